//! The geometry of one movable thing in its own frame: triangles in a tree, its underside, its outline in plan.

use std::collections::BTreeSet;

use glam::{Vec2, Vec3};

use super::solid::Solid;
use super::spine::Spine;
use crate::inspect::{convex_hull, distance_to_hull};
use crate::math::Aabb;
use crate::scene::TriangleBvh;

/// Points of the underside along each side of the box in plan: enough to see that half of a plate hangs over.
const UNDER_STEPS: usize = 6;
/// What is this near to the lowest point touches a flat surface.
const CONTACT_M: f32 = 0.003;
/// Corners that are kept of an outline; those of the underside find legs that the grid of points misses.
const MOST_CORNERS: usize = 16;

/// A point of the underside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnderPoint {
    /// In plan (x, z), the thing's frame.
    pub at: Vec2,
    /// Above the thing's lowest point, metres.
    pub lift_m: f32,
    /// Whether it touches a flat surface that the thing stands on.
    pub contact: bool,
    /// One of the even grid of points: counts as area. The rest are corners.
    pub area: bool,
}

/// A thing's geometry.
#[derive(Debug)]
pub struct Shape {
    /// Its triangles.
    pub tree: TriangleBvh,
    /// The box around it.
    pub bounds: Aabb,
    /// Its underside.
    pub under: Vec<UnderPoint>,
    /// The convex hull of its plan, counter-clockwise in (x, z); of round things some corners.
    pub plan: Vec<Vec2>,
    /// The true hull reaches this far beyond those corners, metres.
    pub slack_m: f32,
    /// Where its weight is taken to be: the middle of its area in plan.
    pub middle: Vec2,
    /// Largest distance of its plan from the origin, metres.
    pub reach_m: f32,
    /// Radius of the circle about `middle` that its plan holds, metres.
    pub core_m: f32,
    /// What of it is surely filled.
    pub solid: Option<Solid>,
    /// Lines inside of it.
    pub spine: Spine,
}

impl Shape {
    /// The shape of these triangles.
    pub fn new(triangles: Vec<[Vec3; 3]>) -> Self {
        let corners = || triangles.iter().flatten().copied();
        let bounds = Aabb::of(corners());
        let contacts = lowest_corners(corners(), bounds.min.y);
        let flat: Vec<Vec2> = corners().map(|p| Vec2::new(p.x, p.z)).collect();
        let hull = convex_hull(&flat);
        let plan = outermost(hull.clone());
        let slack_m = hull.iter().map(|p| distance_to_hull(&plan, *p)).fold(0.0, f32::max);
        let reach_m = flat.iter().map(|p| p.length()).fold(0.0, f32::max);
        let tree = TriangleBvh::new(triangles);
        let mut under = under_grid(&tree, &bounds);
        let count = under.len().max(1) as f32;
        let middle = under.iter().map(|p| p.at).sum::<Vec2>() / count;
        let core_m = inner_radius(&plan, middle);
        let solid = Solid::of(&tree, &bounds, &plan, middle);
        let spine = Spine::of(&tree, &bounds, middle);
        under.extend(contacts.into_iter().map(|at| UnderPoint {
            at,
            lift_m: 0.0,
            contact: true,
            area: false,
        }));
        Self { tree, bounds, under, plan, slack_m, middle, reach_m, core_m, solid, spine }
    }

    /// Size of the plan's box in square metres.
    pub fn plan_m2(&self) -> f32 {
        let size = self.bounds.size();
        size.x * size.z
    }

    /// How much room it takes, for placing large things first.
    pub fn volume_m3(&self) -> f32 {
        let size = self.bounds.size();
        size.x * size.y * size.z
    }
}

/// Distance of a point from the nearest edge of a convex outline around it; 0 outside.
fn inner_radius(hull: &[Vec2], point: Vec2) -> f32 {
    let edges = (0..hull.len()).map(|i| (hull[i], hull[(i + 1) % hull.len()]));
    let inside = |(a, b): (Vec2, Vec2)| (b - a).normalize_or_zero().perp_dot(point - a);
    edges.map(inside).fold(f32::INFINITY, f32::min).clamp(0.0, 10.0)
}

/// Rays from below, at even places of the plan.
fn under_grid(tree: &TriangleBvh, bounds: &Aabb) -> Vec<UnderPoint> {
    let (from, size) = (bounds.min, bounds.size());
    let step = |i: usize| (i as f32 + 0.5) / UNDER_STEPS as f32;
    let places = (0..UNDER_STEPS).flat_map(|i| (0..UNDER_STEPS).map(move |j| Vec2::new(step(i), step(j))));
    let below = 0.01;
    let hit = |share: Vec2| {
        let at = Vec2::new(from.x + share.x * size.x, from.z + share.y * size.z);
        let origin = Vec3::new(at.x, from.y - below, at.y);
        let hit = tree.cast(origin, Vec3::Y, size.y + 2.0 * below)?;
        let lift_m = (hit.distance_m - below).max(0.0);
        Some(UnderPoint { at, lift_m, contact: lift_m < CONTACT_M, area: true })
    };
    places.filter_map(hit).collect()
}

/// Corners at the underside, the outermost first, no two of a kind near each other.
fn lowest_corners(corners: impl Iterator<Item = Vec3>, lowest: f32) -> Vec<Vec2> {
    let low: Vec<Vec2> = corners.filter(|p| p.y < lowest + CONTACT_M).map(|p| Vec2::new(p.x, p.z)).collect();
    outermost(convex_hull(&low))
}

/// Of a hull with many corners the farthest in each of a few directions, in the hull's order.
fn outermost(hull: Vec<Vec2>) -> Vec<Vec2> {
    if hull.len() <= MOST_CORNERS {
        return hull;
    }
    let farthest = |k: usize| {
        let way = Vec2::from_angle(std::f32::consts::TAU * k as f32 / MOST_CORNERS as f32);
        (0..hull.len()).max_by(|a, b| hull[*a].dot(way).total_cmp(&hull[*b].dot(way)))
    };
    let kept: BTreeSet<usize> = (0..MOST_CORNERS).filter_map(farthest).collect();
    kept.into_iter().map(|i| hull[i]).collect()
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A closed box of `size` standing on the middle of its underside.
    pub fn block_triangles(size: Vec3) -> Vec<[Vec3; 3]> {
        let corner = |i: usize| {
            let pick = |bit: usize| (i >> bit & 1) as f32;
            Vec3::new((pick(0) - 0.5) * size.x, pick(1) * size.y, (pick(2) - 0.5) * size.z)
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = |q: [usize; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]];
        quads.into_iter().flat_map(halves).map(|t| t.map(corner)).collect()
    }

    #[test]
    fn a_stool_touches_with_its_legs_and_weighs_in_its_middle() {
        let mut triangles: Vec<[Vec3; 3]> = Vec::new();
        let mut add = |size: Vec3, at: Vec3| {
            triangles.extend(block_triangles(size).into_iter().map(|t| t.map(|p| p + at)));
        };
        add(Vec3::new(0.4, 0.04, 0.4), Vec3::Y * 0.42);
        for (x, z) in [(-0.18, -0.18), (0.18, -0.18), (0.18, 0.18), (-0.18, 0.18)] {
            add(Vec3::new(0.02, 0.42, 0.02), Vec3::new(x, 0.0, z));
        }
        let stool = Shape::new(triangles);
        assert!(stool.middle.length() < 1e-3 && (stool.reach_m - 0.2 * 2.0_f32.sqrt()).abs() < 1e-3);
        let corners: Vec<_> = stool.under.iter().filter(|p| p.contact).collect();
        assert!(corners.len() >= 4 && corners.iter().all(|p| p.at.abs().min_element() > 0.1), "{corners:?}");
        let seat = stool.under.iter().filter(|p| p.area && (p.lift_m - 0.42).abs() < 1e-3).count();
        assert!(seat > 25, "{seat} of 36 points lie under the seat");
    }
}
