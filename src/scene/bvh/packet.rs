//! Sixteen rays from one point at a time: neighbouring pixels of a camera touch the same boxes and triangles,
//! so each is fetched once for all, and what depends on the origin alone is computed once.

use glam::{Vec3, Vec3A};

use super::{Leaf, TriangleBvh};

/// Rays of one packet: 4 x 4 pixels.
pub const PACKET: usize = 16;

/// A ray that passes this share of a triangle's size beside it still hits: neighbouring triangles then overlap
/// by less than a hair and no ray slips through the seam.
const SEAM: f32 = 1e-5;
/// Smaller components of a direction are taken as this, so that no division gives infinity times zero.
const LEAST_COMPONENT: f32 = 1e-12;

/// First hits of one packet's rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PacketHits {
    /// Along each ray in multiples of its direction; infinite where nothing is hit.
    pub t: [f32; PACKET],
    /// Index into [`TriangleBvh::triangles`] of what is hit, where something is.
    pub triangle: [usize; PACKET],
}

/// Casts packets of rays from one point. Holds the stack that they share.
#[derive(Debug)]
pub struct PacketCaster<'a> {
    bvh: &'a TriangleBvh,
    origin: Vec3A,
    stack: Vec<(f32, u32)>,
}

/// Directions of a packet, their reciprocals, and the nearest hits so far.
struct Rays {
    direction: [[f32; PACKET]; 3],
    inverse: [[f32; PACKET]; 3],
    t: [f32; PACKET],
    slot: [u32; PACKET],
}

impl TriangleBvh {
    /// A caster of packets of rays from `origin`.
    pub fn packets_from(&self, origin: Vec3) -> PacketCaster<'_> {
        PacketCaster { bvh: self, origin: origin.into(), stack: Vec::with_capacity(64) }
    }
}

impl PacketCaster<'_> {
    /// The first triangle that each ray meets within `max_t` times its direction, from either side. Directions
    /// need no unit length; the nearer to each other they are, the faster.
    pub fn cast(&mut self, directions: &[Vec3; PACKET], max_t: f32) -> PacketHits {
        let mut rays = Rays::new(directions, max_t);
        self.stack.clear();
        if !self.bvh.tree.nodes.is_empty() {
            self.stack.push((0.0, 0));
        }
        while let Some((entry, index)) = self.stack.pop() {
            if entry <= rays.farthest() {
                self.visit(index, &mut rays);
            }
        }
        let hit = |i: usize| rays.slot[i] != u32::MAX;
        PacketHits {
            t: std::array::from_fn(|i| if hit(i) { rays.t[i] } else { f32::INFINITY }),
            triangle: std::array::from_fn(|i| match hit(i) {
                true => self.bvh.tree.primitive_indices[rays.slot[i] as usize] as usize,
                false => usize::MAX,
            }),
        }
    }

    fn visit(&mut self, index: u32, rays: &mut Rays) {
        let node = &self.bvh.tree.nodes[index as usize];
        if node.is_leaf() {
            for slot in node.first_index..node.first_index + node.prim_count {
                rays.meet(&self.bvh.leaves[slot as usize], slot, self.origin);
            }
            return;
        }
        let [near, far] = [node.first_index, node.first_index + 1].map(|child| {
            let around = self.bvh.tree.nodes[child as usize].aabb();
            (rays.enter(around.min - self.origin, around.max - self.origin), child)
        });
        let (near, far) = if near.0 <= far.0 { (near, far) } else { (far, near) };
        self.stack.extend([far, near].into_iter().filter(|(entry, _)| entry.is_finite()));
    }
}

impl Rays {
    fn new(directions: &[Vec3; PACKET], max_t: f32) -> Self {
        let component = |axis: usize| std::array::from_fn(|i| away_from_zero(directions[i][axis]));
        let direction: [[f32; PACKET]; 3] = std::array::from_fn(component);
        let inverse = direction.map(|d| d.map(|d| 1.0 / d));
        Self { direction, inverse, t: [max_t; PACKET], slot: [u32::MAX; PACKET] }
    }

    fn farthest(&self) -> f32 {
        self.t.iter().fold(0.0, |far, &t| greater(far, t))
    }

    /// Where the first of the rays enters a box (corners relative to the origin); infinite when all miss it.
    #[inline]
    fn enter(&self, low: Vec3A, high: Vec3A) -> f32 {
        let [ix, iy, iz] = &self.inverse;
        let mut entry = [0.0_f32; PACKET];
        for i in 0..PACKET {
            let (x0, x1) = (low.x * ix[i], high.x * ix[i]);
            let (y0, y1) = (low.y * iy[i], high.y * iy[i]);
            let (z0, z1) = (low.z * iz[i], high.z * iz[i]);
            let first = greater(greater(lesser(x0, x1), lesser(y0, y1)), greater(lesser(z0, z1), 0.0));
            let last = lesser(lesser(greater(x0, x1), greater(y0, y1)), lesser(greater(z0, z1), self.t[i]));
            entry[i] = if first <= last { first } else { f32::INFINITY };
        }
        entry.iter().fold(f32::INFINITY, |near, &e| lesser(near, e))
    }

    /// Möller and Trumbore's test with everything that the shared origin decides taken out of the loop.
    #[inline]
    fn meet(&mut self, leaf: &Leaf, slot: u32, origin: Vec3A) {
        let s = origin - leaf.corner;
        let q = s.cross(leaf.edge1);
        let (normal, across) = (leaf.edge2.cross(leaf.edge1), leaf.edge2.cross(s));
        let height = leaf.edge2.dot(q);
        let [dx, dy, dz] = &self.direction;
        for i in 0..PACKET {
            let along = |v: Vec3A| dx[i] * v.x + dy[i] * v.y + dz[i] * v.z;
            let inverse = 1.0 / along(normal);
            let (u, v, t) = (along(across) * inverse, along(q) * inverse, height * inverse);
            let inside = (u >= -SEAM) & (v >= -SEAM) & (u + v <= 1.0 + SEAM);
            let nearer = inside & (t >= 0.0) & (t < self.t[i]);
            self.t[i] = if nearer { t } else { self.t[i] };
            self.slot[i] = if nearer { slot } else { self.slot[i] };
        }
    }
}

fn away_from_zero(d: f32) -> f32 {
    if d.abs() < LEAST_COMPONENT { LEAST_COMPONENT.copysign(d) } else { d }
}

// Compiled to one instruction each; `f32::min` and `f32::max` cost more for their care of NaN.
#[inline]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::field::test_room_triangles as test_room;

    #[test]
    fn a_packet_hits_what_its_single_rays_hit() {
        let bvh = TriangleBvh::new(test_room(5_000));
        let mut agree = 0;
        for turn in 0..200 {
            let angle = turn as f32 * 0.731;
            let origin = Vec3::new(2.0 * angle.sin(), 1.0 + 0.6 * (angle * 1.7).cos(), 1.5 * angle.cos());
            let ahead = Vec3::new((angle * 2.3).cos(), 0.6 * (angle * 3.1).sin(), (angle * 2.3).sin());
            let directions = std::array::from_fn(|i| {
                ahead + Vec3::new(0.02 * (i % 4) as f32, 0.02 * (i / 4) as f32, 0.01)
            });
            let hits = bvh.packets_from(origin).cast(&directions, f32::INFINITY);
            for (i, direction) in directions.iter().enumerate() {
                let single = bvh.cast(origin, direction.normalize_or(Vec3::X), 100.0).expect("closed room");
                let distance_m = hits.t[i] * direction.length();
                assert!((distance_m - single.distance_m).abs() < 1e-4, "{distance_m} is {single:?}");
                agree += usize::from(hits.triangle[i] == single.triangle);
            }
        }
        assert!(agree > 200 * PACKET * 99 / 100, "{agree}: only rays through seams may name the neighbour");
    }

    #[test]
    fn a_packet_respects_its_limit_and_an_empty_room() {
        let bvh = TriangleBvh::new(test_room(2_000));
        let hits = bvh.packets_from(Vec3::new(0.0, 1.5, 0.0)).cast(&[Vec3::Y; PACKET], 1.1);
        assert!(hits.t.iter().all(|t| t.is_infinite()), "the ceiling is 1.2 m above");
        let empty = TriangleBvh::new(Vec::new());
        assert!(empty.packets_from(Vec3::ZERO).cast(&[Vec3::X; PACKET], 9.0).t[0].is_infinite());
    }
}
