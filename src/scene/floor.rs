//! Where somebody can stand and walk: the floor at about `y = 0`, in cells of 5 cm.

use glam::{Vec2, Vec3};

use super::bvh::TriangleBvh;
use super::columns::Columns;
use super::field::SignedDistanceField;
use super::field::indoors::plane_distances;
use super::step::{Step, Stopped, fill, report};

/// Spacing of the cells in metres.
const CELL_M: f32 = 0.05;
/// A floor may lie this far from `y = 0`: rugs, thresholds, noise of scans.
const FLOOR_RANGE_M: f32 = 0.12;
/// Things that rise less than this above the floor don't stop a foot.
const STEP_OVER_M: f32 = 0.08;
/// Free space that every height of a standing person must have before clearance is counted.
const TOUCH_M: f32 = 0.04;
/// Spacing of the heights that are looked at.
const SCAN_M: f32 = 0.1;

/// Who walks: sizes of a standing person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walker {
    /// Half the width of a standing person with arms, in metres.
    pub radius_m: f32,
    /// Height in metres.
    pub height_m: f32,
}

impl Default for Walker {
    fn default() -> Self {
        Self { radius_m: 0.22, height_m: 1.8 }
    }
}

/// The floor as a grid of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct WalkableFloor {
    /// Cells along x and z.
    pub dim: [usize; 2],
    /// Centre (x, z) of cell (0, 0), world frame.
    pub origin: Vec2,
    /// Spacing in metres.
    pub cell_m: f32,
    /// Who was measured for.
    pub walker: Walker,
    /// Height of the floor in each cell in metres; cell (x, z) at `x * dim[1] + z`.
    pub height_m: Vec<f32>,
    /// Horizontal distance from each cell to what a standing person would touch, in metres; 0 where nobody
    /// can be.
    pub clearance_m: Vec<f32>,
    /// Number of the connected area that each walkable cell belongs to, the largest 0; `None` where nobody
    /// can stand.
    pub area: Vec<Option<u32>>,
}

impl WalkableFloor {
    /// Measures the floor of a room.
    ///
    /// # Errors
    /// [`Stopped`] when `step` breaks off.
    pub fn new(
        bvh: &TriangleBvh,
        field: &SignedDistanceField,
        walker: Walker,
        step: Step,
    ) -> Result<Self, Stopped> {
        let columns = Columns::new(bvh, field, CELL_M, step)?;
        let dim = columns.dim;
        let place = |cell: usize| [cell / dim[1], cell % dim[1]];
        let mut height_m = vec![0.0; dim[0] * dim[1]];
        fill(&mut height_m, step, |cell| {
            let floors = columns.tops(place(cell)).iter().map(|t| t.height_m);
            floors.filter(|y| y.abs() <= FLOOR_RANGE_M).reduce(f32::max).unwrap_or(0.0)
        })?;
        let mut blocked = vec![false; dim[0] * dim[1]];
        fill(&mut blocked, step, |cell| {
            is_blocked(field, columns.position(place(cell), height_m[cell]), &walker)
        })?;
        let clearance_m = plane_distances(dim, [CELL_M; 2], &blocked, step)?;
        report(step, 0, 1)?;
        let area = areas(dim, &clearance_m, walker.radius_m);
        Ok(Self { dim, origin: columns.origin, cell_m: CELL_M, walker, height_m, clearance_m, area })
    }

    /// Centre of a cell on the floor, world frame.
    pub fn position(&self, cell: usize) -> Vec3 {
        let (x, z) = (cell / self.dim[1], cell % self.dim[1]);
        let x = self.origin.x + x as f32 * self.cell_m;
        Vec3::new(x, self.height_m[cell], self.origin.y + z as f32 * self.cell_m)
    }

    /// The cell that holds (x, z), if the grid does.
    pub fn cell_at(&self, xz: Vec2) -> Option<usize> {
        let place = ((xz - self.origin) / self.cell_m).round();
        let inside =
            place.cmpge(Vec2::ZERO).all() && place.x < self.dim[0] as f32 && place.y < self.dim[1] as f32;
        inside.then(|| place.x as usize * self.dim[1] + place.y as usize)
    }

    /// Horizontal distance from (x, z) to what a standing person would touch, in metres; 0 where nobody can be.
    pub fn clearance_at(&self, xz: Vec2) -> f32 {
        self.cell_at(xz).map_or(0.0, |cell| self.clearance_m[cell])
    }

    /// Whether somebody can stand at (x, z).
    pub fn is_walkable(&self, xz: Vec2) -> bool {
        self.cell_at(xz).is_some_and(|cell| self.area[cell].is_some())
    }

    /// Every cell where somebody can stand.
    pub fn walkable_cells(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.area.len()).filter(|&cell| self.area[cell].is_some())
    }

    /// The cells of the largest connected area.
    pub fn largest_area(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.area.len()).filter(|&cell| self.area[cell] == Some(0))
    }

    /// The walkable cell nearest to (x, z).
    pub fn nearest_walkable(&self, xz: Vec2) -> Option<usize> {
        let away = |cell: usize| {
            let p = self.position(cell);
            Vec2::new(p.x, p.z).distance_squared(xz)
        };
        self.walkable_cells().min_by(|&a, &b| away(a).total_cmp(&away(b)))
    }
}

/// Whether a thin pole of a person's height would touch anything at `foot`.
fn is_blocked(field: &SignedDistanceField, foot: Vec3, walker: &Walker) -> bool {
    let lowest = STEP_OVER_M + TOUCH_M;
    let scans = ((walker.height_m - TOUCH_M - lowest) / SCAN_M).ceil() as usize;
    (0..=scans).any(|i| {
        let height_m = (lowest + i as f32 * SCAN_M).min(walker.height_m - TOUCH_M);
        field.sample(foot + Vec3::Y * height_m) < TOUCH_M
    })
}

/// Numbers the connected areas with at least `radius_m` of clearance, the largest first.
fn areas([nx, nz]: [usize; 2], clearance_m: &[f32], radius_m: f32) -> Vec<Option<u32>> {
    let mut area: Vec<Option<u32>> = vec![None; nx * nz];
    let mut found: Vec<Vec<usize>> = Vec::new();
    let free = |cell: usize| clearance_m[cell] >= radius_m;
    for start in 0..nx * nz {
        if area[start].is_some() || !free(start) {
            continue;
        }
        area[start] = Some(u32::MAX);
        let mut members = vec![start];
        let mut next = 0;
        while next < members.len() {
            let (x, z) = (members[next] / nz, members[next] % nz);
            next += 1;
            let sides = [
                (x > 0).then(|| (x - 1) * nz + z),
                (x + 1 < nx).then_some((x + 1) * nz + z),
                (z > 0).then(|| x * nz + z - 1),
                (z + 1 < nz).then_some(x * nz + z + 1),
            ];
            for cell in sides.into_iter().flatten() {
                if area[cell].is_none() && free(cell) {
                    area[cell] = Some(u32::MAX);
                    members.push(cell);
                }
            }
        }
        found.push(members);
    }
    found.sort_by_key(|members| (std::cmp::Reverse(members.len()), members[0]));
    for (number, members) in found.iter().enumerate() {
        members.iter().for_each(|&cell| area[cell] = Some(number as u32));
    }
    area
}
