//! Where a distance field is free in whole blocks, so that most points are known to be in no solid without reading it.
//! Only answers that; distances come from the field.

use glam::{UVec3, Vec3};
use rayon::prelude::*;

use super::SignedDistanceField;
use crate::math::Aabb;

/// Cells along each side of a block.
const BLOCK: usize = 8;
/// A block counts as free when every sample of it is at least this far from solids, metres: more than what
/// interpolation rounds.
const SURELY_M: f32 = 1e-4;

/// Blocks of a field's cells in which no point is in a solid.
#[derive(Clone, Debug)]
pub struct OpenBlocks {
    dim: [usize; 3],
    /// Blocks with z fastest, then y.
    open: Vec<bool>,
}

impl OpenBlocks {
    /// Of the blocks that touch `within`, world frame, metres; what lies outside counts as not known to be open.
    pub fn within(field: &SignedDistanceField, within: &Aabb) -> Self {
        let dim = field.dim.map(|samples| (samples - 1).div_ceil(BLOCK));
        let block_m = field.cell_m * BLOCK as f32;
        let place = |p: Vec3| ((p - field.origin) / block_m).max(Vec3::ZERO).as_uvec3().to_array();
        let (low, high) = (place(within.min), place(within.max));
        let asked = |axis: usize, at: usize| (low[axis] as usize..=high[axis] as usize).contains(&at);
        let row = |(x, y): (usize, usize)| {
            let known = asked(0, x) && asked(1, y);
            (0..dim[2]).map(move |z| known && asked(2, z) && is_open(field, [x, y, z]))
        };
        let open = (0..dim[0] * dim[1]).into_par_iter().flat_map_iter(|i| row((i / dim[1], i % dim[1])));
        Self { dim, open: open.collect() }
    }

    /// Whether `p` surely lies in no solid; `field` is the one that these blocks are of.
    #[inline]
    pub fn is_open(&self, field: &SignedDistanceField, p: Vec3) -> bool {
        let in_cells = (p - field.origin) / field.cell_m;
        if !(in_cells.cmpge(Vec3::ZERO).all() && in_cells.cmple(field.last()).all()) {
            return false;
        }
        let cells = UVec3::new(field.dim[0] as u32, field.dim[1] as u32, field.dim[2] as u32) - 2;
        let block = in_cells.as_uvec3().min(cells) / BLOCK as u32;
        self.open[(block.x as usize * self.dim[1] + block.y as usize) * self.dim[2] + block.z as usize]
    }
}

/// Whether no sample of a block, its far sides included, is near to a solid.
fn is_open(field: &SignedDistanceField, block: [usize; 3]) -> bool {
    let range = |axis: usize| {
        let first = block[axis] * BLOCK;
        first..(first + BLOCK + 1).min(field.dim[axis])
    };
    let run = range(2);
    range(0).all(|x| {
        range(1).all(|y| {
            let start = (x * field.dim[1] + y) * field.dim[2];
            let samples = &field.values[start + run.start..start + run.end];
            // NaN is no distance and counts as solid.
            samples.iter().all(|value| *value > SURELY_M)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    /// Three balls in a box whose samples don't fill the last blocks.
    fn balls() -> SignedDistanceField {
        let dim = [45, 37, 50];
        let mut field = SignedDistanceField {
            dim,
            origin: Vec3::new(-1.0, 0.2, 3.0),
            cell_m: Vec3::new(0.05, 0.04, 0.06),
            values: vec![0.0; dim.iter().product()],
        };
        let middle = [Vec3::new(-0.5, 0.6, 3.5), Vec3::new(0.9, 1.5, 5.2), Vec3::new(0.0, 1.0, 4.4)];
        for x in 0..dim[0] {
            for y in 0..dim[1] {
                for z in 0..dim[2] {
                    let p = field.position(x, y, z);
                    let nearest = middle.iter().map(|m| m.distance(p) - 0.17).fold(f32::INFINITY, f32::min);
                    field.values[(x * dim[1] + y) * dim[2] + z] = nearest;
                }
            }
        }
        field
    }

    #[test]
    fn what_is_called_open_is_never_in_a_solid_and_most_of_the_room_is() {
        let field = balls();
        let blocks = OpenBlocks::within(&field, &field.bounds());
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let box_ = field.bounds().grown(0.3);
        let (mut open, mut solid) = (0, 0);
        for _ in 0..20_000 {
            let share = Vec3::new(rng.random(), rng.random(), rng.random());
            let p = box_.min + share * box_.size();
            let distance_m = field.sample(p);
            solid += usize::from(distance_m < 0.0);
            if blocks.is_open(&field, p) {
                assert!(distance_m >= 0.0 && field.contains(p), "{p} is {distance_m} m in a solid");
                open += 1;
            }
        }
        assert!(open > 6_000 && solid > 500, "{open} open, {solid} solid");
    }

    #[test]
    fn nothing_is_known_of_what_was_not_asked_for_nor_of_nan() {
        let field = balls();
        let (asked, beside) = (Vec3::new(1.8, 0.05, 0.05), Vec3::new(1.0, 0.05, 0.05));
        let around = Aabb { min: field.origin + asked, max: field.origin + asked };
        let blocks = OpenBlocks::within(&field, &around);
        assert!(blocks.is_open(&field, field.origin + asked));
        assert!(!blocks.is_open(&field, field.origin + beside));
        let whole = OpenBlocks::within(&field, &field.bounds());
        assert!(whole.is_open(&field, field.origin + beside), "it is open there, and only nobody asked");
        assert!(!blocks.is_open(&field, Vec3::NAN));
    }
}
