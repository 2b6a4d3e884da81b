//! Whether the surfaces of two trees run into each other: exact triangle against triangle, both trees descended
//! together. What lies wholly inside the other touches no surface; ask [`TriangleBvh::is_inside`] for that.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use obvhs::aabb::Aabb as TreeBox;

use super::TriangleBvh;

/// Overlap along every axis by less than this is touching, not running into each other.
const TOUCH_M: f32 = 1e-6;

impl TriangleBvh {
    /// Whether a triangle of this tree meets one of `other`, whose frame is placed by `self_from_other`, which turns and
    /// shifts only.
    pub fn meets(&self, other: &Self, self_from_other: &Affine3A) -> bool {
        self.first_meeting(other, self_from_other).is_some()
    }

    /// Indices of two triangles that meet, of this tree and of `other`.
    pub fn first_meeting(&self, other: &Self, self_from_other: &Affine3A) -> Option<(usize, usize)> {
        if self.tree.nodes.is_empty() || other.tree.nodes.is_empty() {
            return None;
        }
        let turn = Turn::new(self_from_other);
        let mut stack = Vec::with_capacity(64);
        stack.push((0_u32, 0_u32));
        while let Some((a, b)) = stack.pop() {
            let (mine, theirs) = (&self.tree.nodes[a as usize], &other.tree.nodes[b as usize]);
            let (box_a, box_b) = (mine.aabb(), theirs.aabb());
            if turn.parts(box_a, box_b) {
                continue;
            }
            match (mine.is_leaf(), theirs.is_leaf()) {
                (true, true) => {
                    let mine = mine.first_index..mine.first_index + mine.prim_count;
                    let theirs = theirs.first_index..theirs.first_index + theirs.prim_count;
                    if let Some(pair) = self.leaves_meet(mine, other, theirs, self_from_other) {
                        return Some(pair);
                    }
                }
                // The larger box is split first; of its halves the nearer one is looked at first, where a meeting is
                // more likely.
                (false, leaf) if leaf || box_a.half_area() > box_b.half_area() => {
                    let middle = turn.place.transform_point3a(middle_of(box_b));
                    let (near, far) = self.nearer_half(mine.first_index, middle);
                    stack.extend([(far, b), (near, b)]);
                }
                _ => {
                    let middle = turn.back * (middle_of(box_a) - turn.place.translation);
                    let (near, far) = other.nearer_half(theirs.first_index, middle);
                    stack.extend([(a, far), (a, near)]);
                }
            }
        }
        None
    }

    /// Two halves of a node, `first` and the one after it, that whose middle is nearer to a point first.
    fn nearer_half(&self, first: u32, point: Vec3A) -> (u32, u32) {
        let off = |node: u32| middle_of(self.tree.nodes[node as usize].aabb()).distance_squared(point);
        if off(first) <= off(first + 1) { (first, first + 1) } else { (first + 1, first) }
    }

    fn leaves_meet(
        &self,
        mine: std::ops::Range<u32>,
        other: &Self,
        theirs: std::ops::Range<u32>,
        self_from_other: &Affine3A,
    ) -> Option<(usize, usize)> {
        for slot_b in theirs {
            let b = other.tree.primitive_indices[slot_b as usize] as usize;
            let [p, q, r] = &other.triangles[b];
            let placed = [
                self_from_other.transform_point3a(Vec3A::from(*p)),
                self_from_other.transform_point3a(Vec3A::from(*q)),
                self_from_other.transform_point3a(Vec3A::from(*r)),
            ];
            for slot_a in mine.clone() {
                let a = self.tree.primitive_indices[slot_a as usize] as usize;
                let [p, q, r] = &self.triangles[a];
                if triangles_meet(&[Vec3A::from(*p), Vec3A::from(*q), Vec3A::from(*r)], &placed) {
                    return Some((a, b));
                }
            }
        }
        None
    }

    /// Whether `point` lies inside the closed surfaces of this tree: a ray upwards and one aside leave through an odd
    /// number of triangles. Open and doubled surfaces are not inside anything.
    pub fn is_inside(&self, point: Vec3) -> bool {
        // Directions that miss the edges of things made of boxes.
        let ways = [Vec3::new(0.012_3, 1.0, 0.007_1), Vec3::new(1.0, 0.013_7, 0.009_3)];
        ways.iter().all(|way| self.crossings(point, way.normalize_or(Vec3::Y)) % 2 == 1)
    }

    fn crossings(&self, mut from: Vec3, direction: Vec3) -> usize {
        /// More crossings than any thing has: a ray along a surface.
        const MOST: usize = 64;
        /// Past the surface that was met.
        const PAST_M: f32 = 1e-5;
        for count in 0..MOST {
            let Some(hit) = self.cast(from, direction, 100.0) else { return count };
            from += direction * (hit.distance_m + PAST_M);
        }
        0
    }
}

#[inline]
fn middle_of(around: &TreeBox) -> Vec3A {
    (around.min + around.max) * 0.5
}

/// How the frame of one tree lies in that of another, to tell boxes of the two apart.
struct Turn {
    place: Affine3A,
    /// The turn without signs: how far a box of the other frame reaches in this one.
    reach: Mat3A,
    back: Mat3A,
    back_reach: Mat3A,
}

impl Turn {
    fn new(place: &Affine3A) -> Self {
        let unsigned = |m: Mat3A| Mat3A::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
        let back = place.matrix3.transpose();
        Self { place: *place, reach: unsigned(place.matrix3), back, back_reach: unsigned(back) }
    }

    /// Whether a side of one of the boxes, `mine` of this frame and `theirs` of the other, has the other box before it.
    #[inline]
    fn parts(&self, mine: &TreeBox, theirs: &TreeBox) -> bool {
        let (half, their_half) = ((mine.max - mine.min) * 0.5, (theirs.max - theirs.min) * 0.5);
        let between =
            self.place.transform_point3a((theirs.min + theirs.max) * 0.5) - (mine.min + mine.max) * 0.5;
        between.abs().cmpgt(half + self.reach * their_half).any()
            || (self.back * between).abs().cmpgt(their_half + self.back_reach * half).any()
    }
}

/// Separating axes: both planes, all pairs of edges, and within the plane for flat on flat. Spelt out, for closures
/// over arrays are not folded away here and this is where the time of placing things goes.
fn triangles_meet(a: &[Vec3A; 3], b: &[Vec3A; 3]) -> bool {
    let (low_a, high_a) = (a[0].min(a[1]).min(a[2]), a[0].max(a[1]).max(a[2]));
    let (low_b, high_b) = (b[0].min(b[1]).min(b[2]), b[0].max(b[1]).max(b[2]));
    if low_a.cmpgt(high_b).any() || low_b.cmpgt(high_a).any() {
        return false;
    }
    let ea = [a[1] - a[0], a[2] - a[1], a[0] - a[2]];
    let na = ea[0].cross(ea[1]);
    if apart(a, b, na) {
        return false;
    }
    let eb = [b[1] - b[0], b[2] - b[1], b[0] - b[2]];
    let nb = eb[0].cross(eb[1]);
    if apart(a, b, nb) {
        return false;
    }
    for x in &ea {
        for y in &eb {
            if apart(a, b, x.cross(*y)) {
                return false;
            }
        }
    }
    for (x, y) in ea.iter().zip(&eb) {
        if apart(a, b, na.cross(*x)) || apart(a, b, nb.cross(*y)) {
            return false;
        }
    }
    true
}

#[inline(always)]
fn apart(a: &[Vec3A; 3], b: &[Vec3A; 3], axis: Vec3A) -> bool {
    let length2 = axis.length_squared();
    // Parallel edges have no axis of their own.
    if length2 < 1e-18 {
        return false;
    }
    let (a0, a1, a2) = (a[0].dot(axis), a[1].dot(axis), a[2].dot(axis));
    let (b0, b1, b2) = (b[0].dot(axis), b[1].dot(axis), b[2].dot(axis));
    let slack = TOUCH_M * length2.sqrt();
    a0.max(a1).max(a2) <= b0.min(b1).min(b2) + slack || b0.max(b1).max(b2) <= a0.min(a1).min(a2) + slack
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    fn cube(size: f32) -> TriangleBvh {
        let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32) * size;
        let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let halves = |q: [usize; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]];
        TriangleBvh::new(quads.into_iter().flat_map(halves).map(|t| t.map(corner)).collect())
    }

    #[test]
    fn boxes_side_by_side_are_free_and_overlapping_ones_meet() {
        let (a, b) = (cube(1.0), cube(0.5));
        let at = |x: f32, y: f32| Affine3A::from_translation(Vec3::new(x, y, 0.2));
        assert!(a.meets(&b, &at(0.8, 0.3)));
        assert!(!a.meets(&b, &at(1.0005, 0.3)), "half a millimetre apart");
        assert!(!a.meets(&b, &at(0.3, 1.0005)), "standing on it with half a millimetre to spare");
        assert!(a.meets(&b, &at(0.3, 0.999)), "sunk in by a millimetre");
        // Wholly inside, no surface is touched.
        assert!(!a.meets(&b, &at(0.2, 0.2)) && a.is_inside(Vec3::new(0.4, 0.4, 0.4)));
        assert!(!a.is_inside(Vec3::new(1.4, 0.4, 0.4)));
    }

    #[test]
    fn trees_agree_with_looking_at_every_pair() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut soup = |count: usize| -> Vec<[Vec3; 3]> {
            let mut point = |around: Vec3, reach: f32| {
                around
                    + Vec3::new(rng.random_range(-reach..reach), rng.random_range(-reach..reach), 0.0)
                    + Vec3::Z * rng.random_range(-reach..reach)
            };
            (0..count)
                .map(|_| {
                    let middle = point(Vec3::ZERO, 1.0);
                    [point(middle, 0.1), point(middle, 0.1), point(middle, 0.1)]
                })
                .collect()
        };
        let pairs: Vec<_> = (0..40).map(|_| (soup(120), soup(120))).collect();
        let place = Affine3A::from_rotation_y(0.7) * Affine3A::from_translation(Vec3::new(0.1, 0.0, -0.05));
        let mut met = 0;
        for (a, b) in pairs {
            let placed: Vec<[Vec3; 3]> = b.iter().map(|t| t.map(|p| place.transform_point3(p))).collect();
            let every = a
                .iter()
                .any(|x| placed.iter().any(|y| triangles_meet(&x.map(Vec3A::from), &y.map(Vec3A::from))));
            assert_eq!(TriangleBvh::new(a).meets(&TriangleBvh::new(b), &place), every);
            met += usize::from(every);
        }
        assert!((5..=35).contains(&met), "{met} of 40 met: the test says little");
    }
}
