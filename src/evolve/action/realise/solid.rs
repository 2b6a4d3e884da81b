//! What of a thing is surely filled: an upright prism inside of it. Two that overlap run into each other, which is told
//! a hundred times sooner than by triangles; two that don't must still be looked at.

use glam::{Vec2, Vec3};

use super::world::Pose;
use crate::inspect::convex_hull;
use crate::math::Aabb;
use crate::scene::TriangleBvh;

/// The prism's outline is the thing's shrunk by this about its middle: outlines of few corners and dented sides stay
/// inside of what they stand for.
const SHRUNK: f32 = 0.88;
/// Rays along each side of the box in plan.
const STEPS: usize = 9;
/// Thinner prisms say nothing.
const LEAST_M: f32 = 0.006;
/// Prisms overlap when they do so by this much in height: things are tried a few millimetres above their place.
const OVERLAP_M: f32 = 0.002;
/// Corners of an outline.
const CORNERS: usize = 8;

/// An upright prism inside of a thing, in its frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Its outline in plan (x, z), convex, counter-clockwise.
    pub plan: Vec<Vec2>,
    /// From this height.
    pub low_m: f32,
    /// To this height.
    pub high_m: f32,
}

impl Solid {
    /// The prism of a thing: where every ray through the middle of its plan finds something between the same heights.
    /// `None` for what is open, thin or has a hole.
    pub fn of(tree: &TriangleBvh, bounds: &Aabb, plan: &[Vec2], middle: Vec2) -> Option<Self> {
        let stride = (plan.len() / CORNERS).max(1);
        let shrunk = plan.iter().step_by(stride).map(|p| middle + (*p - middle) * SHRUNK);
        let plan = convex_hull(&shrunk.collect::<Vec<_>>());
        let (from, size) = (bounds.min, bounds.size());
        let step = |i: usize| (i as f32 + 0.5) / STEPS as f32;
        let at = |i: usize, j: usize| Vec2::new(from.x + step(i) * size.x, from.z + step(j) * size.z);
        let inside = (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| at(i, j))).filter(|p| holds(&plan, *p));
        let (mut low_m, mut high_m, mut count) = (bounds.min.y, bounds.max.y, 0);
        for p in inside {
            let (below, above) =
                (Vec3::new(p.x, from.y - 0.01, p.y), Vec3::new(p.x, bounds.max.y + 0.01, p.y));
            let up = tree.cast(below, Vec3::Y, size.y + 0.02)?;
            let down = tree.cast(above, Vec3::NEG_Y, size.y + 0.02)?;
            low_m = low_m.max(below.y + up.distance_m);
            high_m = high_m.min(above.y - down.distance_m);
            count += 1;
        }
        let holds_any = count >= STEPS && high_m - low_m > LEAST_M;
        holds_any.then_some(Self { plan, low_m, high_m })
    }

    /// The outline at a place.
    pub fn placed(&self, pose: &Pose) -> Vec<Vec2> {
        self.plan.iter().map(|p| pose.plan(*p)).collect()
    }

    /// Whether two overlap in height at these heights of their things.
    pub fn is_level_with(&self, at_m: f32, other: &Self, other_at_m: f32) -> bool {
        let low_m = (self.low_m + at_m).max(other.low_m + other_at_m);
        let high_m = (self.high_m + at_m).min(other.high_m + other_at_m);
        high_m - low_m > OVERLAP_M
    }
}

fn holds(hull: &[Vec2], point: Vec2) -> bool {
    let inside = |(i, a): (usize, &Vec2)| (hull[(i + 1) % hull.len()] - *a).perp_dot(point - *a) >= 0.0;
    hull.len() > 2 && hull.iter().enumerate().all(inside)
}

/// Whether two convex outlines, counter-clockwise, overlap.
pub fn outlines_meet(a: &[Vec2], b: &[Vec2]) -> bool {
    a.len() > 2 && b.len() > 2 && !separated(a, b) && !separated(b, a)
}

/// Whether an edge of one of two convex outlines, counter-clockwise, has the other this far outside, metres.
pub fn outlines_part(a: &[Vec2], b: &[Vec2], by_m: f32) -> bool {
    a.len() > 2 && b.len() > 2 && (parted(a, b, by_m) || parted(b, a, by_m))
}

fn parted(a: &[Vec2], b: &[Vec2], by_m: f32) -> bool {
    (0..a.len()).any(|i| {
        let (from, edge) = (a[i], a[(i + 1) % a.len()] - a[i]);
        let least = -by_m * edge.length();
        b.iter().all(|p| edge.perp_dot(*p - from) < least)
    })
}

/// Whether an edge of the convex outline `a` has all of `b` outside.
fn separated(a: &[Vec2], b: &[Vec2]) -> bool {
    (0..a.len()).any(|i| {
        let (from, to) = (a[i], a[(i + 1) % a.len()]);
        b.iter().all(|p| (to - from).perp_dot(*p - from) < 0.0)
    })
}

#[cfg(test)]
mod tests {
    use super::super::shape::Shape;
    use super::super::shape::tests::block_triangles;
    use super::*;

    fn shape(blocks: &[(Vec3, Vec3)]) -> Shape {
        let placed = |(size, at): &(Vec3, Vec3)| {
            let at = *at;
            block_triangles(*size).into_iter().map(move |t| t.map(|p| p + at))
        };
        Shape::new(blocks.iter().flat_map(placed).collect())
    }

    #[test]
    fn a_box_is_filled_from_foot_to_top_and_a_table_at_its_top_only() {
        let whole = shape(&[(Vec3::new(0.2, 0.1, 0.3), Vec3::ZERO)]).solid.expect("filled");
        assert!(whole.low_m < 1e-4 && (whole.high_m - 0.1).abs() < 1e-4, "{whole:?}");
        assert!(whole.plan.iter().all(|p| p.x.abs() < 0.1 && p.y.abs() < 0.15), "inside of the box");
        let leg = Vec3::new(0.02, 0.7, 0.02);
        let legs =
            [(-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4)].map(|(x, z)| (leg, Vec3::new(x, 0.0, z)));
        let top = (Vec3::new(0.9, 0.04, 0.9), Vec3::Y * 0.7);
        let table = shape(&[&legs[..], &[top]].concat()).solid.expect("its top is filled");
        assert!((table.low_m - 0.7).abs() < 1e-3 && (table.high_m - 0.74).abs() < 1e-3, "{table:?}");
    }

    #[test]
    fn what_has_a_hole_or_is_thin_is_not_surely_filled() {
        let bar = |x: f32, z: f32, size: Vec3| (size, Vec3::new(x, 0.0, z));
        let (long, wide) = (Vec3::new(0.02, 0.1, 0.4), Vec3::new(0.4, 0.1, 0.02));
        let frame = [bar(-0.2, 0.0, long), bar(0.2, 0.0, long), bar(0.0, -0.2, wide), bar(0.0, 0.2, wide)];
        assert_eq!(shape(&frame).solid, None, "a frame is open in the middle");
        assert_eq!(shape(&[(Vec3::new(0.2, 0.002, 0.3), Vec3::ZERO)]).solid, None, "paper");
    }

    #[test]
    fn outlines_meet_only_where_no_edge_parts_them() {
        let square =
            |x: f32| [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(a, b)| Vec2::new(a + x, b));
        assert!(outlines_meet(&square(0.0), &square(0.9)));
        assert!(!outlines_meet(&square(0.0), &square(1.1)));
        let diamond = [(1.0, -0.2), (2.0, -1.2), (3.0, -0.2), (2.0, 0.8)].map(|(a, b)| Vec2::new(a, b - 0.9));
        assert!(!outlines_meet(&square(0.0), &diamond), "boxes touch, edges part them");
        assert!(
            outlines_part(&square(0.0), &square(1.1), 0.09)
                && !outlines_part(&square(0.0), &square(1.1), 0.11)
        );
        assert!(
            outlines_part(&square(0.0), &diamond, 0.01) && !outlines_part(&square(0.0), &square(0.9), 0.0)
        );
    }
}
