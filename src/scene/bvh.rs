//! A tree over world triangles: rays, closest points, vertical look-ups. Plain data; knows no objects.
//!
//! obvhs builds the tree. On rooms made of regular, axis-aligned tiles every merge costs the same and its
//! builder ends with a poor tree, so every box is grown by a seeded random amount below
//! [`MAX_JITTER_M`] first. Boxes only ever grow: no hit is lost and none moves.

mod overlap;
mod packet;

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb as TreeBox;
use obvhs::bvh2::Bvh2;
use obvhs::ray::{Ray, RayHit};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::step::{Pace, Step, Stopped, unwatched};
use super::tree::tree_of;

pub use packet::{PACKET, PacketCaster, PacketHits};

/// Largest growth of a triangle's box before building: breaks the ties of axis-aligned tilings, and is
/// small against any triangle that matters.
const MAX_JITTER_M: f32 = 1e-3;

/// Where a ray first meets the room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Along the ray, in metres.
    pub distance_m: f32,
    /// Index into [`TriangleBvh::triangles`].
    pub triangle: usize,
    /// Weights of the triangle's three corners at the hit; they sum to 1.
    pub barycentric: Vec3,
}

/// The point of the room nearest to a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Distance in metres.
    pub distance_m: f32,
    /// The nearest point, world frame.
    pub point: Vec3,
    /// Index into [`TriangleBvh::triangles`].
    pub triangle: usize,
}

/// A bounding volume hierarchy over triangles in the world frame (metres).
pub struct TriangleBvh {
    triangles: Vec<[Vec3; 3]>,
    tree: Bvh2,
    /// Corner and two edges of each triangle, in the tree's leaf order.
    leaves: Vec<Leaf>,
}

#[derive(Clone, Copy)]
struct Leaf {
    corner: Vec3A,
    edge1: Vec3A,
    edge2: Vec3A,
}

impl Leaf {
    /// Distance along the ray and the weights of the second and third corner (Möller and Trumbore 1997).
    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<(f32, f32, f32)> {
        let p = ray.direction.cross(self.edge2);
        let determinant = self.edge1.dot(p);
        let inverse = 1.0 / determinant;
        let s = ray.origin - self.corner;
        let u = s.dot(p) * inverse;
        let q = s.cross(self.edge1);
        let v = ray.direction.dot(q) * inverse;
        let t = self.edge2.dot(q) * inverse;
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        (inside && t >= ray.tmin && t <= ray.tmax).then_some((t, u, v))
    }
}

impl std::fmt::Debug for TriangleBvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "TriangleBvh({} triangles)", self.triangles.len())
    }
}

impl TriangleBvh {
    /// Builds the tree; about a second for a million triangles. Triangles must be finite.
    pub fn new(triangles: Vec<[Vec3; 3]>) -> Self {
        match Self::build(triangles, &unwatched) {
            Ok(tree) => tree,
            Err(Stopped) => unreachable!("nobody stops what nobody watches"),
        }
    }

    /// As [`TriangleBvh::new`], and can be stopped.
    ///
    /// # Errors
    /// [`Stopped`] when `step` breaks off.
    pub fn build(triangles: Vec<[Vec3; 3]>, step: Step) -> Result<Self, Stopped> {
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let mut pace = Pace::new(step, triangles.len());
        let boxes = triangles.iter().map(|corners| {
            pace.item()?;
            let grow = Vec3A::splat(random.random_range(0.0..MAX_JITTER_M));
            let around = TreeBox::from_points(&corners.map(Vec3A::from));
            Ok(TreeBox::new(around.min - grow, around.max + grow))
        });
        let boxes = boxes.collect::<Result<Vec<_>, Stopped>>()?;
        let tree = tree_of(&boxes, step)?;
        let mut pace = Pace::new(step, triangles.len());
        let leaves = tree.primitive_indices.iter().map(|&index| {
            pace.item()?;
            let [a, b, c] = triangles[index as usize].map(Vec3A::from);
            Ok(Leaf { corner: a, edge1: b - a, edge2: c - a })
        });
        let leaves = leaves.collect::<Result<Vec<_>, Stopped>>()?;
        Ok(Self { triangles, tree, leaves })
    }

    /// The triangles, in the order they were given.
    pub fn triangles(&self) -> &[[Vec3; 3]] {
        &self.triangles
    }

    /// Unit normal of triangle `index` by its corner order; +Y for a triangle without area.
    pub fn normal(&self, index: usize) -> Vec3 {
        let [a, b, c] = self.triangles[index];
        (b - a).cross(c - a).normalize_or(Vec3::Y)
    }

    /// The first triangle that the ray meets within `max_m`, from either side.
    pub fn cast(&self, origin: Vec3, unit_direction: Vec3, max_m: f32) -> Option<Hit> {
        let ray = Ray::new(origin.into(), unit_direction.into(), 0.0, max_m);
        let mut best: Option<(f32, f32, f32, usize)> = None;
        self.tree.ray_traverse(ray, &mut RayHit::none(), |ray, slot| {
            match self.leaves[slot].intersect(ray) {
                Some((t, u, v)) if best.is_none_or(|b| t < b.0) => {
                    best = Some((t, u, v, slot));
                    t
                }
                _ => f32::INFINITY,
            }
        });
        best.map(|(t, u, v, slot)| Hit {
            distance_m: t,
            triangle: self.tree.primitive_indices[slot] as usize,
            barycentric: Vec3::new(1.0 - u - v, u, v),
        })
    }

    /// Whether anything lies on the ray within `max_m`.
    pub fn any_hit(&self, origin: Vec3, unit_direction: Vec3, max_m: f32) -> bool {
        let ray = Ray::new(origin.into(), unit_direction.into(), 0.0, max_m);
        // A little less than the limit, as the tree asks for `t < tmax`.
        !self.tree.ray_traverse_miss(ray, |ray, slot| match self.leaves[slot].intersect(ray) {
            Some((t, ..)) => t.min(max_m.next_down()),
            None => f32::INFINITY,
        })
    }

    /// The nearest point of any triangle within `max_m`; branch and bound, nearest box first.
    pub fn closest(&self, point: Vec3, max_m: f32) -> Option<Closest> {
        let root = self.tree.nodes.first()?;
        let query = Vec3A::from(point);
        let mut best = (max_m * max_m, None);
        let mut stack = Vec::with_capacity(64);
        stack.push((box_distance2(root.aabb(), query), 0_u32));
        while let Some((bound, index)) = stack.pop() {
            if bound > best.0 {
                continue;
            }
            let node = &self.tree.nodes[index as usize];
            if node.is_leaf() {
                self.closest_in_leaf(node.first_index..node.first_index + node.prim_count, point, &mut best);
                continue;
            }
            let children = [node.first_index, node.first_index + 1]
                .map(|child| (box_distance2(self.tree.nodes[child as usize].aabb(), query), child));
            let near_first = children[0].0 <= children[1].0;
            stack.push(children[usize::from(near_first)]);
            stack.push(children[usize::from(!near_first)]);
        }
        let (distance2, found) = best;
        found.map(|(point, triangle)| Closest { distance_m: distance2.sqrt(), point, triangle })
    }

    fn closest_in_leaf(
        &self,
        slots: std::ops::Range<u32>,
        point: Vec3,
        best: &mut (f32, Option<(Vec3, usize)>),
    ) {
        for slot in slots {
            let triangle = self.tree.primitive_indices[slot as usize] as usize;
            let on_triangle = closest_on_triangle(&self.triangles[triangle], point);
            let distance2 = on_triangle.distance_squared(point);
            if distance2 <= best.0 {
                *best = (distance2, Some((on_triangle, triangle)));
            }
        }
    }

    /// Expected boxes and triangles that a random ray through the room touches (surface area heuristic).
    pub fn sah_cost(&self) -> f32 {
        let Some(root) = self.tree.nodes.first() else { return 0.0 };
        let total = root.aabb().half_area().max(f32::MIN_POSITIVE);
        let cost = |n: &obvhs::bvh2::node::Bvh2Node| n.aabb().half_area() * (n.prim_count.max(1)) as f32;
        self.tree.nodes.iter().map(cost).sum::<f32>() / total
    }
}

fn box_distance2(around: &TreeBox, point: Vec3A) -> f32 {
    (around.min - point).max(point - around.max).max(Vec3A::ZERO).length_squared()
}

/// The point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
pub fn closest_on_triangle(&[a, b, c]: &[Vec3; 3], p: Vec3) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3).max(f32::MIN_POSITIVE));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6).max(f32::MIN_POSITIVE));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let along = (d4 - d3) / ((d4 - d3) + (d5 - d6)).max(f32::MIN_POSITIVE);
        return b + (c - b) * along;
    }
    let sum = (va + vb + vc).max(f32::MIN_POSITIVE);
    a + ab * (vb / sum) + ac * (vc / sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::field::test_room_triangles as test_room;

    fn random_point(random: &mut ChaCha8Rng) -> Vec3 {
        Vec3::new(
            random.random_range(-3.0..3.0),
            random.random_range(0.0..2.7),
            random.random_range(-2.5..2.5),
        )
    }

    #[test]
    fn rays_and_closest_points_agree_with_looking_at_every_triangle() {
        let triangles = test_room(2_000);
        let bvh = TriangleBvh::new(triangles.clone());
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..200 {
            let (p, q) = (random_point(&mut random), random_point(&mut random));
            let direction = (q - p).normalize_or(Vec3::X);
            let exhaustive = triangles
                .iter()
                .filter_map(|&[a, b, c]| {
                    let leaf = Leaf { corner: a.into(), edge1: (b - a).into(), edge2: (c - a).into() };
                    leaf.intersect(&Ray::new(p.into(), direction.into(), 0.0, 50.0)).map(|h| h.0)
                })
                .fold(f32::INFINITY, f32::min);
            let hit = bvh.cast(p, direction, 50.0).expect("the room is closed");
            assert!((hit.distance_m - exhaustive).abs() < 1e-5);
            let [a, b, c] = triangles[hit.triangle];
            let w = hit.barycentric;
            let at = a * w.x + b * w.y + c * w.z;
            assert!(at.distance(p + direction * hit.distance_m) < 1e-4);
            assert!(bvh.any_hit(p, direction, hit.distance_m + 1e-3));
            assert!(!bvh.any_hit(p, direction, hit.distance_m - 1e-3));

            let nearest =
                triangles.iter().map(|t| closest_on_triangle(t, p).distance(p)).fold(f32::INFINITY, f32::min);
            let closest = bvh.closest(p, 10.0).expect("within ten metres");
            assert!((closest.distance_m - nearest).abs() < 1e-5);
            assert!((closest.point.distance(p) - nearest).abs() < 1e-5);
            assert!(bvh.closest(p, nearest * 0.99 - 1e-4).is_none());
        }
    }

    #[test]
    fn an_axis_aligned_room_still_gets_a_good_tree() {
        let bvh = TriangleBvh::new(test_room(20_000));
        assert!(bvh.sah_cost() < 120.0, "{}", bvh.sah_cost());
    }

    #[test]
    fn an_empty_room_is_met_by_nothing() {
        let bvh = TriangleBvh::new(Vec::new());
        assert!(bvh.cast(Vec3::ZERO, Vec3::X, 10.0).is_none());
        assert!(bvh.closest(Vec3::ZERO, 10.0).is_none());
        assert!(!bvh.any_hit(Vec3::ZERO, Vec3::X, 10.0));
    }
}
