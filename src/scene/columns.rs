//! The room seen from above: every surface that a grid of vertical lines meets, with the room above it.

use glam::{Vec2, Vec3};

use super::bvh::TriangleBvh;
use super::field::SignedDistanceField;
use super::field::grid::Grid;
use super::field::lines::Lines;
use super::step::{Pace, Step, Stopped};

/// Steepest surface that counts as something to be on: 60 degrees, so that noisy scans keep their seats
/// (smoothness between neighbouring columns is asked for separately).
const STEEPEST_NORMAL_Y: f32 = 0.5;
/// Free space that must be above a surface for it to be a top: above the thickness that sheets are given.
const AIR_PROBE_M: f32 = 0.05;
/// Surfaces closer above each other than this are layers of one thing (rug on floor, cover on mattress).
const LAYER_M: f32 = 0.03;

/// A surface that something can be on, in one column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Top {
    /// Height in metres, world frame.
    pub height_m: f32,
    /// Free height above it in metres, at most [`OPEN_M`].
    pub clearance_m: f32,
    /// The triangle.
    pub triangle: usize,
}

/// Clearance where nothing is above.
pub(super) const OPEN_M: f32 = 10.0;

/// Vertical lines on a regular grid.
pub(super) struct Columns {
    /// Lines along x and z.
    pub dim: [usize; 2],
    /// Place (x, z) of line (0, 0).
    pub origin: Vec2,
    /// Spacing in metres.
    pub cell_m: f32,
    tops: Vec<Vec<Top>>,
}

impl Columns {
    /// Columns `cell_m` apart over the whole field.
    ///
    /// # Errors
    /// [`Stopped`] when `step` breaks off.
    pub fn new(
        bvh: &TriangleBvh,
        field: &SignedDistanceField,
        cell_m: f32,
        step: Step,
    ) -> Result<Self, Stopped> {
        let bounds = field.bounds();
        let size = bounds.size();
        let dim = [(size.x / cell_m) as usize + 1, (size.z / cell_m) as usize + 1];
        let origin = Vec3::new(bounds.min.x, 0.0, bounds.min.z);
        let grid = Grid { dim: [dim[0], 2, dim[1]], origin, cell_m: Vec3::new(cell_m, 1.0, cell_m) };
        let lines = Lines::new(&grid, bvh.triangles(), 1, step)?;
        let mut pace = Pace::new(step, dim[0] * dim[1]);
        let tops = (0..dim[0] * dim[1]).map(|i| {
            let (x, z) = (i / dim[1], i % dim[1]);
            let at = grid.position([x, 0, z]);
            let crossings = lines.line(x, z);
            pace.items(1 + crossings.len())?;
            let top = |(rank, crossing): (usize, &super::field::lines::Crossing)| {
                let triangle = crossing.triangle as usize;
                let height_m = crossing.place;
                let above =
                    crossings[rank + 1..].iter().map(|c| c.place - height_m).find(|&gap| gap > LAYER_M);
                let covered = crossings.get(rank + 1).is_some_and(|c| c.place - height_m <= LAYER_M);
                let free = field.sample(at.with_y(height_m + AIR_PROBE_M)) > 0.0;
                let flat = bvh.normal(triangle).y.abs() >= STEEPEST_NORMAL_Y;
                (free && flat && !covered).then_some(Top {
                    height_m,
                    clearance_m: above.unwrap_or(OPEN_M).min(OPEN_M),
                    triangle,
                })
            };
            Ok(crossings.iter().enumerate().filter_map(top).collect())
        });
        let tops = tops.collect::<Result<_, Stopped>>()?;
        Ok(Self { dim, origin: Vec2::new(origin.x, origin.z), cell_m, tops })
    }

    /// The tops of column (x, z), the lowest first.
    pub fn tops(&self, [x, z]: [usize; 2]) -> &[Top] {
        &self.tops[x * self.dim[1] + z]
    }

    /// World position of column (x, z) at a height.
    pub fn position(&self, [x, z]: [usize; 2], height_m: f32) -> Vec3 {
        Vec3::new(self.origin.x + x as f32 * self.cell_m, height_m, self.origin.y + z as f32 * self.cell_m)
    }

    /// The column nearest to (x, z), if it lies in the grid.
    pub fn nearest(&self, p: Vec3) -> Option<[usize; 2]> {
        let x = ((p.x - self.origin.x) / self.cell_m).round();
        let z = ((p.z - self.origin.y) / self.cell_m).round();
        let inside = x >= 0.0 && z >= 0.0 && x < self.dim[0] as f32 && z < self.dim[1] as f32;
        inside.then_some([x as usize, z as usize])
    }

    /// The column `by` steps away, if it lies in the grid.
    pub fn neighbour(&self, [x, z]: [usize; 2], by: [isize; 2]) -> Option<[usize; 2]> {
        let x = x.checked_add_signed(by[0]).filter(|&x| x < self.dim[0])?;
        let z = z.checked_add_signed(by[1]).filter(|&z| z < self.dim[1])?;
        Some([x, z])
    }
}
