use std::f32::consts::FRAC_PI_2;

use glam::{Vec2, Vec3};

use crate::body::joints;
use crate::scene::{direction_of, facing_of};

/// A place on the floor plan seen from a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polar {
    /// Horizontal distance.
    pub distance_m: f32,
    /// 0 is to the person's right, +π/2 in front, ±π to the left, -π/2 behind.
    pub angle_rad: f32,
}

/// Where a person is and faces, on the floor plan: the frame of all learned layouts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PersonFrame {
    /// Middle of the torso, world frame.
    pub centre_m: Vec3,
    /// Radians about +Y, 0 = +Z ([`direction_of`]).
    pub facing_rad: f32,
}

impl PersonFrame {
    /// Of a body's joints in the world frame (SMPL-X's order, [`joints`]): the middle of hips and shoulders, and
    /// front = up × the horizontal line of the shoulders. Somebody whose shoulders stand on top of each other (lying
    /// on the side) faces +Z.
    pub fn of_joints(joints_m: &[Vec3]) -> Self {
        let middle = |a: usize, b: usize| (joints_m[a] + joints_m[b]) * 0.5;
        let shoulders = middle(joints::LEFT_SHOULDER, joints::RIGHT_SHOULDER);
        let hips = middle(joints::LEFT_HIP, joints::RIGHT_HIP);
        let right = joints_m[joints::RIGHT_SHOULDER] - joints_m[joints::LEFT_SHOULDER];
        let front = Vec3::Y.cross(right);
        Self { centre_m: (shoulders + hips) * 0.5, facing_rad: facing_of(Vec2::new(front.x, front.z)) }
    }

    /// The same axes with the origin at another place: the frame of relations between objects.
    #[must_use]
    pub fn at(&self, centre_m: Vec3) -> Self {
        Self { centre_m, ..*self }
    }

    /// The person's front, a horizontal unit vector (x, z).
    pub fn front(&self) -> Vec2 {
        direction_of(self.facing_rad)
    }

    /// The person's right, a horizontal unit vector (x, z).
    pub fn right(&self) -> Vec2 {
        direction_of(self.facing_rad - FRAC_PI_2)
    }

    /// The world place of a polar one, at the frame's own height.
    pub fn place(&self, polar: Polar) -> Vec3 {
        let (sin, cos) = polar.angle_rad.sin_cos();
        let offset = (self.right() * cos + self.front() * sin) * polar.distance_m;
        self.centre_m + Vec3::new(offset.x, 0.0, offset.y)
    }

    /// Where a world point is seen from here; its height does not count.
    pub fn polar_of(&self, point_m: Vec3) -> Polar {
        let offset = point_m - self.centre_m;
        let flat = Vec2::new(offset.x, offset.z);
        Polar { distance_m: flat.length(), angle_rad: flat.dot(self.front()).atan2(flat.dot(self.right())) }
    }

    /// The facing with which somebody at this place sees `point_m` at an angle of the polar frame.
    #[must_use]
    pub fn turned_to_see(&self, point_m: Vec3, angle_rad: f32) -> Self {
        let offset = point_m - self.centre_m;
        let facing_rad = facing_of(Vec2::new(offset.x, offset.z)) + FRAC_PI_2 - angle_rad;
        Self { facing_rad: facing_of(direction_of(facing_rad)), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    fn near(a: Vec3, b: Vec3) -> bool {
        a.distance(b) < 1e-5
    }

    #[test]
    fn front_right_left_and_back_are_where_a_person_has_them() {
        // Facing +Z, the left hand is at +X.
        let person = PersonFrame { centre_m: Vec3::new(1.0, 0.9, 2.0), facing_rad: 0.0 };
        let at = |degrees: f32| person.place(Polar { distance_m: 0.5, angle_rad: degrees.to_radians() });
        assert!(near(at(90.0), Vec3::new(1.0, 0.9, 2.5)));
        assert!(near(at(0.0), Vec3::new(0.5, 0.9, 2.0)));
        assert!(near(at(180.0), Vec3::new(1.5, 0.9, 2.0)));
        assert!(near(at(-90.0), Vec3::new(1.0, 0.9, 1.5)));
    }

    #[test]
    fn places_and_polar_places_are_inverse() {
        for facing_rad in [-2.0, 0.3, 3.0] {
            let person = PersonFrame { centre_m: Vec3::new(-1.0, 1.0, 0.5), facing_rad };
            let polar = Polar { distance_m: 0.8, angle_rad: 2.1 };
            let back = person.polar_of(person.place(polar));
            assert!((back.distance_m - 0.8).abs() < 1e-5 && (back.angle_rad - 2.1).abs() < 1e-5, "{back:?}");
        }
    }

    #[test]
    fn a_person_turned_to_see_a_point_sees_it_at_that_angle() {
        let person = PersonFrame { centre_m: Vec3::ZERO, facing_rad: 0.0 };
        for (point, angle) in [(Vec3::X, PI / 2.0), (Vec3::new(-1.0, 0.0, 2.0), 0.4), (-Vec3::Z, 2.8)] {
            let seen = person.turned_to_see(point, angle).polar_of(point).angle_rad;
            assert!((seen - angle).abs() < 1e-5, "{seen} for {angle}");
        }
    }

    #[test]
    fn a_body_at_rest_faces_plus_z_and_one_on_the_back_has_its_feet_in_front() {
        let body = crate::body::Body::bundled();
        let rest = &body.model.joint_template;
        let upright = PersonFrame::of_joints(rest.as_slice());
        assert!(upright.facing_rad.abs() < 0.05, "{}", upright.facing_rad);
        // Tipped backwards about the left-right axis: the head goes to -Z, the feet stay towards +Z.
        let tipped: Vec<Vec3> = rest.iter().map(|j| Vec3::new(j.x, j.z, -j.y)).collect();
        let lying = PersonFrame::of_joints(&tipped);
        let feet = lying.polar_of(tipped[joints::LEFT_ANKLE]);
        assert!((feet.angle_rad - FRAC_PI_2).abs() < 0.3, "{feet:?}");
    }
}
