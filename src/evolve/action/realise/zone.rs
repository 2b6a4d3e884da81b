//! The working zone of an action (ADSE §5.2): the convex hull of its people and of the things that matter to it, from
//! what they work on upwards. What is not used keeps out of it.

use glam::Vec2;

use super::shape::Shape;
use super::solid::outlines_meet;
use super::world::{Ball, Pose, flat};
use crate::inspect::convex_hull;

/// The zone reaches down to this far below what people work on, so that thin things count.
const BELOW_M: f32 = 0.02;

/// A convex prism.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Zone {
    /// Its plan (x, z), counter-clockwise.
    pub hull: Vec<Vec2>,
    /// From this height.
    pub low_m: f32,
    /// To this height.
    pub high_m: f32,
}

impl Zone {
    /// Around people and things; `work_m` is the height of what they work on.
    pub fn around(people: &[Ball], things: &[(&Shape, Pose)], work_m: f32) -> Self {
        let rim = |(at, r): &Ball| {
            let (at, r) = (flat(*at), *r);
            [Vec2::X, Vec2::Y, Vec2::NEG_X, Vec2::NEG_Y].map(|way| at + way * r)
        };
        let above = people.iter().filter(|(at, r)| at.y + r > work_m - 0.3);
        let mut points: Vec<Vec2> = above.flat_map(rim).collect();
        points.extend(things.iter().flat_map(|(shape, pose)| shape.plan.iter().map(|p| pose.plan(*p))));
        let top = |(shape, pose): &(&Shape, Pose)| pose.at.y + shape.bounds.max.y;
        let high_m =
            people.iter().map(|(at, r)| at.y + r).chain(things.iter().map(top)).fold(work_m, f32::max);
        Self { hull: convex_hull(&points), low_m: work_m - BELOW_M, high_m }
    }

    /// Whether a point of the plan at a height is in it.
    pub fn holds_point(&self, at: Vec2, height_m: f32) -> bool {
        let edges = (0..self.hull.len()).map(|i| (self.hull[i], self.hull[(i + 1) % self.hull.len()]));
        self.hull.len() > 2
            && (self.low_m..=self.high_m).contains(&height_m)
            && edges.into_iter().all(|(a, b)| (b - a).perp_dot(at - a) >= 0.0)
    }

    /// Whether a thing at a place reaches into it.
    pub fn holds(&self, shape: &Shape, pose: &Pose) -> bool {
        let (low, high) = (pose.at.y + shape.bounds.min.y, pose.at.y + shape.bounds.max.y);
        if high < self.low_m || low > self.high_m || self.hull.len() < 3 {
            return false;
        }
        let plan: Vec<Vec2> = shape.plan.iter().map(|p| pose.plan(*p)).collect();
        outlines_meet(&self.hull, &plan)
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::tests::block_triangles;
    use super::*;
    use glam::Vec3;

    #[test]
    fn what_reaches_in_is_held_and_what_lies_beside_or_below_is_not() {
        let block = Shape::new(block_triangles(Vec3::new(0.2, 0.1, 0.2)));
        let at = |x: f32, y: f32| Pose::upright(Vec3::new(x, y, 0.0), 0.0);
        let zone = Zone::around(&[(Vec3::new(0.0, 1.0, 0.0), 0.3)], &[(&block, at(0.5, 0.75))], 0.75);
        assert!(zone.holds(&block, &at(0.25, 0.75)) && zone.holds(&block, &at(0.68, 0.75)));
        assert!(!zone.holds(&block, &at(0.72, 0.75)), "beside");
        assert!(!zone.holds(&block, &at(0.3, 0.0)), "under the table");
        let turned = Pose { yaw_rad: 0.785, ..at(0.72, 0.75) };
        assert!(zone.holds(&block, &turned), "a corner reaches in");
    }
}
