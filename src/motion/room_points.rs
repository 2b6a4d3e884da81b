//! The room as the networks of motion see it: points of its surfaces around a leg, a fixed number of them.

use glam::Vec3;
use rand::RngExt as _;

use super::local::LegFrame;
use crate::job::{Rng, Seed};
use crate::nn::motion::Cloud;

/// Points that stand for a room: a leg sees some hundreds of those around it.
pub const ROOM_POINTS: usize = 16_384;
/// How far from the way's straight line points count, metres.
pub const SEEN_M: f32 = 2.0;
/// Nothing above this height over the floor matters to somebody who walks below, metres.
const HIGHEST_M: f32 = 2.0;

/// A point of a surface and what the surface is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoomPoint {
    /// Metres, world frame.
    pub at: Vec3,
    /// Class of its surface, for those who teach the networks; else 0.
    pub class: u8,
}

/// Points spread evenly over the surfaces of a room.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RoomPoints {
    /// In no particular order.
    pub points: Vec<RoomPoint>,
}

impl RoomPoints {
    /// `count` points of triangles (metres, world frame), each triangle with the class of its surface.
    pub fn of(triangles: &[([Vec3; 3], u8)], count: usize, seed: Seed) -> Self {
        let mut total = 0.0;
        let mut reached = Vec::with_capacity(triangles.len());
        for ([a, b, c], _) in triangles {
            let area = f64::from((*b - *a).cross(*c - *a).length());
            total += if area.is_finite() { area } else { 0.0 };
            reached.push(total);
        }
        if total <= 0.0 {
            return Self::default();
        }
        let mut rng = seed.rng();
        // Evenly spaced along the sum of areas: no surface of some size goes without.
        let point = |i: usize, rng: &mut Rng| {
            let along = (i as f64 + rng.random_range(0.0..1.0)) / count as f64 * total;
            let (triangle, class) =
                triangles[reached.partition_point(|r| *r < along).min(triangles.len() - 1)];
            RoomPoint { at: point_of(&triangle, rng), class }
        };
        Self { points: (0..count).map(|i| point(i, &mut rng)).collect() }
    }

    /// `count` points seen from the way between two places, in the leg's frame, with their classes. Where nothing is
    /// near, points of the bare floor stand in.
    pub fn around(&self, leg: &LegFrame, ends: [Vec3; 2], count: usize, seed: Seed) -> (Cloud, Vec<u8>) {
        let floor_m = leg.origin.y;
        let near = |p: &&RoomPoint| {
            p.at.y < floor_m + HIGHEST_M
                && distance_to_segment(p.at.with_y(0.0), ends.map(|e| e.with_y(0.0))) < SEEN_M
        };
        let mut near: Vec<RoomPoint> = self.points.iter().filter(near).copied().collect();
        let mut rng = seed.rng();
        // A partial shuffle: the first `count` are a sample.
        for i in 0..count.min(near.len()) {
            let other = rng.random_range(i..near.len());
            near.swap(i, other);
        }
        near.truncate(count);
        while near.len() < count {
            let at = match near.is_empty() {
                false => near[rng.random_range(0..near.len())],
                true => RoomPoint {
                    at: ends[0].lerp(ends[1], rng.random_range(0.0..1.0)).with_y(floor_m),
                    class: 0,
                },
            };
            near.push(at);
        }
        near.iter().map(|p| (leg.point(p.at).to_array(), p.class)).unzip()
    }
}

/// A point of a triangle, each as likely as any other.
fn point_of([a, b, c]: &[Vec3; 3], rng: &mut Rng) -> Vec3 {
    let (u, v): (f32, f32) = (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0));
    let root = u.sqrt();
    *a * (1.0 - root) + *b * (root * (1.0 - v)) + *c * (root * v)
}

fn distance_to_segment(p: Vec3, [a, b]: [Vec3; 2]) -> f32 {
    let along = b - a;
    let share = (p - a).dot(along) / along.length_squared().max(1e-9);
    p.distance(a + along * share.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    fn square(height_m: f32, side_m: f32, at_x_m: f32, class: u8) -> Vec<([Vec3; 3], u8)> {
        let corner = |x: f32, z: f32| Vec3::new(at_x_m + x * side_m, height_m, z * side_m);
        let (a, b, c, d) = (corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5));
        vec![([a, b, c], class), ([a, c, d], class)]
    }

    #[test]
    fn points_lie_on_the_surfaces_as_dense_as_these_are_large() {
        let triangles = [square(0.0, 4.0, 0.0, 1), square(0.7, 2.0, 0.5, 2)].concat();
        let points = RoomPoints::of(&triangles, 2000, Seed::root(1)).points;
        let table = points.iter().filter(|p| p.class == 2).count();
        assert!((table as f32 / 2000.0 - 0.2).abs() < 0.01, "{table}");
        let height_m = |class: u8| if class == 2 { 0.7 } else { 0.0 };
        assert!(points.iter().all(|p| (p.at.y - height_m(p.class)).abs() < 1e-5));
    }

    #[test]
    fn a_leg_sees_what_is_near_it_in_its_own_frame() {
        let triangles = [square(0.0, 20.0, 0.0, 1), square(0.7, 1.0, 9.0, 2)].concat();
        let points = RoomPoints::of(&triangles, 4000, Seed::root(1));
        let leg = LegFrame { origin: Vec3::new(1.0, 0.0, 0.0), turn: Quat::from_rotation_y(1.0) };
        let ends = [Vec3::new(1.0, 0.9, 0.0), Vec3::new(2.0, 0.9, 0.0)];
        let (cloud, classes) = points.around(&leg, ends, 300, Seed::root(2));
        assert_eq!((cloud.len(), classes.len()), (300, 300));
        assert!(classes.iter().all(|class| *class == 1), "the table is 7 m away");
        assert!(
            cloud.iter().all(|p| Vec3::from_array(*p).length() < 1.0 + SEEN_M + 0.01 && p[1].abs() < 1e-5)
        );
        let (bare, _) = RoomPoints::default().around(&leg, ends, 5, Seed::root(2));
        assert!(bare.len() == 5 && bare.iter().all(|p| p[1].abs() < 1e-6));
    }
}
