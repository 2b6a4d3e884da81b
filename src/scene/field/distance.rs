//! Distances from samples to triangles: exact near the surface, carried outward beyond.
//!
//! Each triangle writes its exact distance into the samples of a narrow band. Beyond the band six sweeps
//! (both ways along each axis) hand on *which* triangle is nearest; each sample then evaluates its exact
//! distance to the candidates of its neighbours. Only the choice of the triangle can be wrong, never the
//! distance to it. (After Strain 1999 and Bridson's closest-triangle sweeping; slices run in parallel.)

use glam::Vec3;
use rayon::prelude::*;

use super::grid::Grid;
use crate::scene::bvh::{Step, Stopped, report};

/// No triangle known yet.
pub(super) const NOBODY: u32 = u32::MAX;

/// A triangle prepared for distances, perhaps thickened (see `thin`).
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    corners: [Vec3; 3],
    /// Unit normal by corner order; zero without area.
    pub normal: Vec3,
    /// Moves the middle of a thickened sheet away from the triangle.
    pub shift: Vec3,
    /// Half the thickness of a thickened sheet, else 0.
    pub radius_m: f32,
}

impl Facet {
    pub fn new(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = *corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        Self { corners: *corners, normal, shift: Vec3::ZERO, radius_m: 0.0 }
    }

    /// Corners.
    pub fn corners(&self) -> &[Vec3; 3] {
        &self.corners
    }

    /// Squared distance from `p` to the bare triangle.
    #[inline]
    pub fn distance2(&self, p: Vec3) -> f32 {
        let [a, b, c] = self.corners;
        let (ap, bp, cp) = (p - a, p - b, p - c);
        let (ab, bc, ca) = (b - a, c - b, a - c);
        let n = self.normal;
        let inside = [n.cross(ab).dot(ap) > 0.0, n.cross(bc).dot(bp) > 0.0, n.cross(ca).dot(cp) > 0.0];
        if inside == [true; 3] {
            let height = n.dot(ap);
            return height * height;
        }
        let mut nearest = f32::INFINITY;
        for (within, from, edge) in [(inside[0], ap, ab), (inside[1], bp, bc), (inside[2], cp, ca)] {
            if !within {
                let along = (from.dot(edge) / edge.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
                nearest = nearest.min((from - edge * along).length_squared());
            }
        }
        nearest
    }

    /// Distance for a sample in free space: to the bare triangle, or signed to its thickened sheet.
    #[inline]
    pub fn air_distance(&self, p: Vec3) -> f32 {
        if self.radius_m == 0.0 {
            self.distance2(p).sqrt()
        } else {
            self.distance2(p - self.shift).sqrt() - self.radius_m
        }
    }
}

/// Nearest distance (metres) and triangle of every sample.
pub(super) struct Nearest {
    pub distance_m: Vec<f32>,
    pub triangle: Vec<u32>,
}

/// Planes of samples that one task fills; small enough for balance, large enough to amortise set-up.
const PLANES_PER_TASK: usize = 4;

/// Exact distances of all samples within `band_m` of a triangle; others stay at infinity.
pub(super) fn narrow_band(
    grid: &Grid,
    facets: &[Facet],
    band_m: f32,
    step: Step,
) -> Result<Nearest, Stopped> {
    let mut nearest =
        Nearest { distance_m: vec![f32::INFINITY; grid.len()], triangle: vec![NOBODY; grid.len()] };
    let all: Vec<u32> = (0..facets.len() as u32).collect();
    splat(grid, facets, &all, band_m, &mut nearest, |_| true, step)?;
    Ok(nearest)
}

/// Writes the distances of the `chosen` triangles into the samples within `band_m` that `open` admits.
pub(super) fn splat(
    grid: &Grid,
    facets: &[Facet],
    chosen: &[u32],
    band_m: f32,
    nearest: &mut Nearest,
    open: impl Fn(usize) -> bool + Sync,
    step: Step,
) -> Result<(), Stopped> {
    let plane = grid.dim[1] * grid.dim[2];
    let task = PLANES_PER_TASK * plane;
    let by_task = triangles_by_task(grid, facets, chosen, band_m);
    nearest
        .distance_m
        .par_chunks_mut(task)
        .zip(nearest.triangle.par_chunks_mut(task))
        .zip(by_task.par_iter())
        .enumerate()
        .try_for_each(|(number, ((distance, triangle), members))| {
            report(step, 0, 1)?;
            let first = number * PLANES_PER_TASK;
            let mut slab = Slab { grid, first_plane: first, distance, triangle };
            for (i, &t) in members.iter().enumerate() {
                if i % 4096 == 4095 {
                    report(step, 0, 1)?;
                }
                slab.write(&facets[t as usize], t, band_m, &open);
            }
            Ok(())
        })
}

fn triangles_by_task(grid: &Grid, facets: &[Facet], chosen: &[u32], band_m: f32) -> Vec<Vec<u32>> {
    let mut by_task = vec![Vec::new(); grid.dim[0].div_ceil(PLANES_PER_TASK)];
    for &t in chosen {
        let facet = &facets[t as usize];
        let reach = band_m + facet.radius_m;
        let xs = facet.corners.map(|p| p.x + facet.shift.x);
        let low = xs[0].min(xs[1]).min(xs[2]) - reach;
        let high = xs[0].max(xs[1]).max(xs[2]) + reach;
        if let Some((first, last)) = grid.span(0, low, high) {
            for list in &mut by_task[first / PLANES_PER_TASK..=last / PLANES_PER_TASK] {
                list.push(t);
            }
        }
    }
    by_task
}

/// A few planes of the grid, filled by one task.
struct Slab<'a> {
    grid: &'a Grid,
    first_plane: usize,
    distance: &'a mut [f32],
    triangle: &'a mut [u32],
}

impl Slab<'_> {
    fn write(&mut self, facet: &Facet, number: u32, band_m: f32, open: &impl Fn(usize) -> bool) {
        let reach = band_m + facet.radius_m;
        let [a, b, c] = facet.corners.map(|p| p + facet.shift);
        let low = a.min(b).min(c) - reach;
        let high = a.max(b).max(c) + reach;
        let Some((x0, x1)) = self.grid.span(0, low.x, high.x) else { return };
        let Some((y0, y1)) = self.grid.span(1, low.y, high.y) else { return };
        let Some((z0, z1)) = self.grid.span(2, low.z, high.z) else { return };
        let last_plane = self.first_plane + self.distance.len() / (self.grid.dim[1] * self.grid.dim[2]) - 1;
        for x in x0.max(self.first_plane)..=x1.min(last_plane) {
            for y in y0..=y1 {
                let row = self.grid.index([x - self.first_plane, y, 0]);
                let global = self.grid.index([x, y, 0]);
                let from = self.grid.position([x, y, 0]);
                for z in z0..=z1 {
                    if !open(global + z) {
                        continue;
                    }
                    let p = from + Vec3::Z * (z as f32 * self.grid.cell_m.z);
                    let best = self.distance[row + z].min(band_m);
                    let height = facet.normal.dot(p - facet.shift - facet.corners[0]).abs();
                    if height - facet.radius_m > best {
                        continue;
                    }
                    let distance = facet.air_distance(p);
                    if distance < best {
                        self.distance[row + z] = distance;
                        self.triangle[row + z] = number;
                    }
                }
            }
        }
    }
}

/// Carries nearest triangles into all samples beyond `exact_m`. `solid` samples measure to bare triangles,
/// the others to thickened ones.
pub(super) fn sweep_outward(
    grid: &Grid,
    facets: &[Facet],
    solid: &[bool],
    exact_m: f32,
    nearest: &mut Nearest,
    step: Step,
) -> Result<(), Stopped> {
    let slack_m = 2.0 * facets.par_iter().map(|f| f.radius_m).reduce(|| 0.0, f32::max);
    let total: usize = 2 * grid.dim.iter().sum::<usize>();
    let mut done = 0;
    for (axis, reverse) in [(1, false), (1, true), (0, false), (0, true), (2, false), (2, true)] {
        let sweep = Sweep { grid, facets, solid, exact_m, slack_m, axis };
        let order: Vec<usize> =
            if reverse { (0..grid.dim[axis]).rev().collect() } else { (0..grid.dim[axis]).collect() };
        let mut front = Front::new(grid);
        let mut next = Front::new(grid);
        for (turn, &slice) in order.iter().enumerate() {
            sweep.slice(slice, turn > 0, &front, &mut next, nearest);
            std::mem::swap(&mut front, &mut next);
            done += 1;
            report(step, done, total)?;
        }
    }
    Ok(())
}

/// Distances and triangles of the slice before; rows by x (or by y for sweeps along x).
struct Front {
    distance_m: Vec<f32>,
    triangle: Vec<u32>,
}

impl Front {
    fn new(grid: &Grid) -> Self {
        let widest = grid.dim[0].max(grid.dim[1]) * grid.dim[1].max(grid.dim[2]);
        Self { distance_m: vec![f32::INFINITY; widest], triangle: vec![NOBODY; widest] }
    }
}

struct Sweep<'a> {
    grid: &'a Grid,
    facets: &'a [Facet],
    solid: &'a [bool],
    exact_m: f32,
    slack_m: f32,
    axis: usize,
}

impl Sweep<'_> {
    /// Updates one slice from the front before it and makes it the next front.
    fn slice(&self, at: usize, has_front: bool, front: &Front, next: &mut Front, nearest: &mut Nearest) {
        let [nx, ny, nz] = self.grid.dim;
        let plane = ny * nz;
        let columns = if self.axis == 2 { ny } else { nz };
        let rows = if self.axis == 0 { ny } else { nx };
        let task = |row: usize, distance: &mut [f32], triangle: &mut [u32], d: &mut [f32], t: &mut [u32]| {
            let step = if self.axis == 2 { nz } else { 1 };
            for column in 0..columns {
                let local = column * step;
                let place = match self.axis {
                    0 => [at, row, column],
                    1 => [row, at, column],
                    _ => [row, column, at],
                };
                if has_front && !(distance[local] <= self.exact_m) {
                    let own = (distance[local], triangle[local]);
                    let best = self.best(place, own, front, (row, column), (rows, columns));
                    (distance[local], triangle[local]) = best;
                }
                d[column] = distance[local];
                t[column] = triangle[local];
            }
        };
        let fronts = next.distance_m.par_chunks_mut(columns).zip(next.triangle.par_chunks_mut(columns));
        if self.axis == 0 {
            let plane_range = at * plane..(at + 1) * plane;
            let distance = nearest.distance_m[plane_range.clone()].par_chunks_mut(nz);
            let triangle = nearest.triangle[plane_range].par_chunks_mut(nz);
            distance.zip(triangle).zip(fronts).enumerate().with_min_len(8).for_each(
                |(row, ((distance, triangle), (d, t)))| {
                    task(row, distance, triangle, d, t);
                },
            );
        } else {
            let offset = if self.axis == 1 { at * nz } else { at };
            let distance = nearest.distance_m.par_chunks_mut(plane);
            let triangle = nearest.triangle.par_chunks_mut(plane);
            distance.zip(triangle).zip(fronts).enumerate().with_min_len(8).for_each(
                |(row, ((distance, triangle), (d, t)))| {
                    task(row, &mut distance[offset..], &mut triangle[offset..], d, t);
                },
            );
        }
    }

    /// The nearest of the sample's own triangle and those of five samples in the slice before.
    #[inline]
    fn best(
        &self,
        place: [usize; 3],
        own: (f32, u32),
        front: &Front,
        (row, column): (usize, usize),
        (rows, columns): (usize, usize),
    ) -> (f32, u32) {
        let p = self.grid.position(place);
        let solid = self.solid[self.grid.index(place)];
        let here = row * columns + column;
        let cell = self.grid.cell_m;
        let across = match self.axis {
            0 => [cell.y, cell.z],
            1 => [cell.x, cell.z],
            _ => [cell.x, cell.y],
        };
        let straight = cell[self.axis];
        let mut best = own;
        let mut tried = NOBODY;
        let mut consider = |at: usize, away_m: f32| {
            let candidate = front.triangle[at];
            if candidate == NOBODY || candidate == best.1 || candidate == tried {
                return;
            }
            if front.distance_m[at] - away_m - self.slack_m >= best.0 {
                return;
            }
            tried = candidate;
            let facet = &self.facets[candidate as usize];
            let distance = if solid { facet.distance2(p).sqrt() } else { facet.air_distance(p) };
            if distance < best.0 {
                best = (distance, candidate);
            }
        };
        consider(here, straight);
        let rowwise = straight.hypot(across[0]);
        let columnwise = straight.hypot(across[1]);
        if row > 0 {
            consider(here - columns, rowwise);
        }
        if row + 1 < rows {
            consider(here + columns, rowwise);
        }
        if column > 0 {
            consider(here - 1, columnwise);
        }
        if column + 1 < columns {
            consider(here + 1, columnwise);
        }
        best
    }
}
