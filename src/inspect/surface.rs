//! The room's surfaces inside a body: what anyone who has only the exported meshes can recompute.
//!
//! Vertices in solid matter miss a body that a thin sheet cuts through; samples of the sheet inside the body
//! do not. Both are measured, and the deeper counts.

use glam::Vec3;

use crate::math::Aabb;
use crate::scene::TriangleBvh;

/// Distance between samples on the room's surfaces: finer than any depth limit that is reported.
const SPACING_M: f32 = 0.015;

/// Directions in general position, so that no ray runs along a wall or an edge of a regular mesh.
const PROBES: [Vec3; 3] = [
    Vec3::new(0.540_3, 0.683_1, 0.491_6),
    Vec3::new(-0.712_8, 0.331_7, 0.617_9),
    Vec3::new(0.213_4, -0.804_9, -0.553_7),
];

/// A posed body as a solid: is a point inside, and how deep.
pub struct BodySolid {
    bvh: TriangleBvh,
    bounds: Aabb,
}

impl BodySolid {
    /// The solid with corner positions `vertices` and triangles `faces`, counter-clockwise from outside.
    pub fn new(vertices: &[Vec3], faces: &[[u32; 3]]) -> Self {
        let triangles = faces.iter().map(|f| f.map(|v| vertices[v as usize])).collect();
        let bounds = Aabb::of(vertices.iter().copied());
        Self { bvh: TriangleBvh::new(triangles), bounds }
    }

    /// The box around it.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Metres from `point` to the skin when it is inside; 0 outside.
    pub fn depth(&self, point: Vec3) -> f32 {
        if !self.bounds.contains(point) || !self.is_inside(point) {
            return 0.0;
        }
        self.bvh.closest(point, f32::INFINITY).map_or(0.0, |c| c.distance_m)
    }

    /// Two of three rays leave through the skin's inner side.
    fn is_inside(&self, point: Vec3) -> bool {
        let leaves = |direction: Vec3| {
            self.bvh
                .cast(point, direction, f32::INFINITY)
                .is_some_and(|hit| self.bvh.normal(hit.triangle).dot(direction) > 0.0)
        };
        let direction = |i: usize| PROBES[i].normalize_or(Vec3::Y);
        match (leaves(direction(0)), leaves(direction(1))) {
            (first, second) if first == second => first,
            _ => leaves(direction(2)),
        }
    }

    /// The deepest that any of `triangles` (world frame) reaches into the body, in metres.
    pub fn deepest_surface(&self, triangles: &[[Vec3; 3]]) -> f32 {
        let samples = surface_samples(triangles, &self.bounds, SPACING_M);
        samples.into_iter().map(|p| self.depth(p)).fold(0.0, f32::max)
    }
}

/// Points on those parts of `triangles` that lie in `within`, about `spacing_m` apart or nearer.
pub fn surface_samples(triangles: &[[Vec3; 3]], within: &Aabb, spacing_m: f32) -> Vec<Vec3> {
    let mut samples = Vec::new();
    each_surface_sample(triangles, within, spacing_m, |p| samples.push(p));
    samples
}

/// Calls `take` with each of [`surface_samples`]: where most are not kept, as those of finely tiled things are not, there
/// would be hundreds of millions of them at once.
pub fn each_surface_sample(
    triangles: &[[Vec3; 3]],
    within: &Aabb,
    spacing_m: f32,
    mut take: impl FnMut(Vec3),
) {
    let mut pending: Vec<[Vec3; 3]> = Vec::new();
    for triangle in triangles {
        pending.push(*triangle);
        while let Some(piece) = pending.pop() {
            if !Aabb::of(piece).intersects(within) {
                continue;
            }
            match halves(piece, spacing_m) {
                Some(parts) => pending.extend(parts),
                None => take((piece[0] + piece[1] + piece[2]) / 3.0),
            }
        }
    }
}

/// The two halves of a triangle across its longest edge, or `None` when that edge is short enough to sample.
fn halves([a, b, c]: [Vec3; 3], spacing_m: f32) -> Option<[[Vec3; 3]; 2]> {
    let (ab, bc, ca) = (a.distance_squared(b), b.distance_squared(c), c.distance_squared(a));
    let longest = ab.max(bc).max(ca);
    if longest <= spacing_m * spacing_m {
        return None;
    }
    let split = |a: Vec3, b: Vec3, c: Vec3| {
        let m = (a + b) * 0.5;
        [[a, m, c], [m, b, c]]
    };
    Some(if longest == ab {
        split(a, b, c)
    } else if longest == bc {
        split(b, c, a)
    } else {
        split(c, a, b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box from -1 to 1, outward-facing.
    fn cube() -> BodySolid {
        let vertices: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0)
            .collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces: Vec<[u32; 3]> =
            quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        BodySolid::new(&vertices, &faces)
    }

    #[test]
    fn depth_is_the_distance_to_the_skin_inside_and_zero_outside() {
        let cube = cube();
        assert!((cube.depth(Vec3::new(0.0, 0.0, 0.9)) - 0.1).abs() < 1e-3);
        assert!((cube.depth(Vec3::ZERO) - 1.0).abs() < 1e-3);
        assert_eq!(cube.depth(Vec3::new(0.0, 0.0, 1.1)), 0.0);
    }

    #[test]
    fn a_sheet_that_cuts_through_is_found_though_no_vertex_is_in_solid_matter() {
        let sheet = [[Vec3::new(-9.0, 0.7, -9.0), Vec3::new(9.0, 0.7, -9.0), Vec3::new(0.0, 0.7, 9.0)]];
        assert!((cube().deepest_surface(&sheet) - 0.3).abs() < 5e-3);
        let beside = sheet.map(|t| t.map(|p| p + Vec3::Y));
        assert_eq!(cube().deepest_surface(&beside), 0.0);
    }
}
