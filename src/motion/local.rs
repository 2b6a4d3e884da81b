//! The frame that belongs to a leg: below its first body, turned as that faces. What the networks and the memory of
//! clips see is in it, so that they do as well at any place and in any direction of a room.

use glam::{Mat3, Quat, Vec2, Vec3};

use crate::math::rotation;
use crate::nn::motion::{HAND_COLUMNS, POSE_COLUMNS, ROW, TURN_COLUMNS, WHERE_COLUMNS};
use crate::scene::{Frame, HANDS, POSE, facing_of};

/// A horizontal axis of the body shorter than this says little about where it faces.
const CLEAR: f32 = 0.6;

/// Which way a body faces, radians about +Y. Of somebody who lies on the back: towards the feet.
pub fn heading_of(world_from_body: Quat) -> f32 {
    let left = world_from_body * Vec3::X;
    let front = world_from_body * Vec3::Z;
    let across = left.cross(Vec3::Y);
    let chosen = if across.length() > CLEAR { across } else { front };
    facing_of(Vec2::new(chosen.x, chosen.z))
}

/// Where a leg is in the world. Turns about the vertical only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegFrame {
    /// On the floor, metres, world frame.
    pub origin: Vec3,
    /// World from leg.
    pub turn: Quat,
}

impl LegFrame {
    /// The frame of a leg that begins with `start` on a body whose pelvis rests at `rest_pelvis`, on a floor at
    /// `floor_m`.
    pub fn of(start: &Frame, rest_pelvis: Vec3, floor_m: f32) -> Self {
        Self {
            origin: (start.translation + rest_pelvis).with_y(floor_m),
            turn: Quat::from_rotation_y(heading_of(start.rotation)),
        }
    }

    /// A point of the world in the leg's frame, metres.
    pub fn point(&self, world: Vec3) -> Vec3 {
        self.turn.inverse() * (world - self.origin)
    }

    /// A point of the leg's frame in the world, metres.
    pub fn world_point(&self, local: Vec3) -> Vec3 {
        self.origin + self.turn * local
    }

    /// A body as the networks take it, with its pose's code.
    pub fn row(&self, frame: &Frame, code: &[f32; POSE], rest_pelvis: Vec3) -> [f32; ROW] {
        let at = self.point(frame.translation + rest_pelvis);
        let turn = Mat3::from_quat(self.turn.inverse() * frame.rotation);
        let mut row = [0.0; ROW];
        row[WHERE_COLUMNS].copy_from_slice(&at.to_array());
        row[TURN_COLUMNS].copy_from_slice(&rotation::six_d_from_matrix(&turn));
        row[POSE_COLUMNS].copy_from_slice(code);
        row[HAND_COLUMNS].copy_from_slice(&frame.hands);
        row
    }

    /// Place, rotation and hands of a body as the networks give it; the joints stay at rest.
    pub fn placed(&self, row: &[f32; ROW], rest_pelvis: Vec3) -> Frame {
        let six: [f32; 6] = std::array::from_fn(|i| row[TURN_COLUMNS.start + i]);
        let turn = Quat::from_mat3(&rotation::matrix_from_6d(&six));
        let hands: [f32; HANDS] = std::array::from_fn(|i| row[HAND_COLUMNS.start + i]);
        Frame {
            translation: self.world_point(Vec3::from_slice(&row[WHERE_COLUMNS])) - rest_pelvis,
            rotation: (self.turn * turn).normalize(),
            hands,
            ..Frame::default()
        }
    }
}

/// The pose code in a row.
pub fn code_of(row: &[f32; ROW]) -> [f32; POSE] {
    std::array::from_fn(|i| row[POSE_COLUMNS.start + i])
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn the_same_leg_elsewhere_in_the_room_gives_the_same_numbers() {
        let rest = Vec3::new(0.001, -0.002, 0.003);
        let start = Frame {
            translation: Vec3::new(0.3, 0.9, -1.0),
            rotation: Quat::from_rotation_y(0.4) * Quat::from_rotation_x(0.1),
            ..Frame::default()
        };
        let body = Frame { translation: Vec3::new(1.0, 0.7, -0.5), ..start.clone() };
        let numbers = |turn: f32, by: Vec3| {
            let turn = Quat::from_rotation_y(turn);
            let moved = |f: &Frame| Frame {
                translation: turn * (f.translation + rest) + by - rest,
                rotation: turn * f.rotation,
                ..f.clone()
            };
            LegFrame::of(&moved(&start), rest, 0.0).row(&moved(&body), &[0.5; POSE], rest)
        };
        for (a, b) in numbers(0.0, Vec3::ZERO).iter().zip(numbers(2.1, Vec3::new(4.0, 0.0, -3.0))) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
    }

    #[test]
    fn a_body_comes_back_from_its_row_and_lying_people_face_their_feet() {
        let rest = Vec3::new(0.0, 0.01, 0.0);
        let frame = Frame {
            translation: Vec3::new(0.3, 0.9, -1.0),
            rotation: Quat::from_rotation_y(2.4),
            hands: [0.25; HANDS],
            ..Frame::default()
        };
        let leg = LegFrame { origin: Vec3::new(1.0, 0.0, 2.0), turn: Quat::from_rotation_y(-0.7) };
        let back = leg.placed(&leg.row(&frame, &[0.0; POSE], rest), rest);
        assert!(back.translation.distance(frame.translation) < 1e-5 && back.hands == frame.hands);
        assert!(back.rotation.angle_between(frame.rotation) < 1e-3);
        assert!((heading_of(frame.rotation) - 2.4).abs() < 1e-5);
        // On the back with the head towards -Z, the feet towards +Z.
        assert!(heading_of(Quat::from_rotation_x(-FRAC_PI_2)).abs() < 1e-5);
    }
}
