//! Distances from samples to triangles, exact in a narrow band: each triangle writes into the samples near it.

use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::grid::Grid;
use crate::scene::step::{Pace, Step, Stopped, report};

/// No triangle known yet.
pub(super) const NOBODY: u32 = u32::MAX;

/// A triangle prepared for distances, perhaps thickened (see `thin`): flat coordinates with corner `a` at the
/// origin, the longest edge `ab` along x and corner `c` above it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    a: Vec3,
    x_axis: Vec3,
    y_axis: Vec3,
    /// Unit normal by corner order; any direction across for a triangle without area.
    pub normal: Vec3,
    b: f32,
    c: Vec2,
    /// One over the squared lengths of `ac` and `bc`.
    inverse2: Vec2,
    /// Moves the middle of a thickened sheet away from the triangle.
    pub shift: Vec3,
    /// Half the thickness of a thickened sheet, else 0.
    pub radius_m: f32,
}

impl Facet {
    pub fn new(corners: &[Vec3; 3]) -> Self {
        let length2 = |i: usize| corners[i].distance_squared(corners[(i + 1) % 3]);
        let first = (0..3).max_by(|&i, &j| length2(i).total_cmp(&length2(j))).unwrap_or(0);
        let [a, b, c] = [0, 1, 2].map(|i| corners[(first + i) % 3]);
        let x_axis = (b - a).normalize_or(Vec3::X);
        let normal = x_axis.cross(c - a).try_normalize().unwrap_or_else(|| x_axis.any_orthonormal_vector());
        let y_axis = normal.cross(x_axis);
        let (b, c) = ((b - a).dot(x_axis), Vec2::new((c - a).dot(x_axis), (c - a).dot(y_axis)));
        let inverse = |length2: f32| 1.0 / length2.max(f32::MIN_POSITIVE);
        let inverse2 = Vec2::new(inverse(c.length_squared()), inverse(c.distance_squared(Vec2::new(b, 0.0))));
        Self { a, x_axis, y_axis, normal, b, c, inverse2, shift: Vec3::ZERO, radius_m: 0.0 }
    }

    /// The corners, from the one that starts the longest edge.
    pub fn corners(&self) -> [Vec3; 3] {
        let flat = |x: f32, y: f32| self.a + self.x_axis * x + self.y_axis * y;
        [self.a, flat(self.b, 0.0), flat(self.c.x, self.c.y)]
    }

    /// Flat coordinates and height over the plane of the (shifted) triangle.
    #[inline]
    fn local(&self, p: Vec3) -> Vec3 {
        let d = p - self.a;
        Vec3::new(self.x_axis.dot(d), self.y_axis.dot(d), self.normal.dot(d))
    }

    /// From the triangle's nearest points to four points at `(x, y)` in its plane.
    #[inline]
    fn offsets(&self, x: Vec4, y: Vec4) -> (Vec4, Vec4) {
        let (b, c) = (self.b, self.c);
        let edge = Vec2::new(c.x - b, c.y);
        let from_b = x - b;
        let inside = y.cmpge(Vec4::ZERO)
            & (y * edge.x - from_b * edge.y).cmpge(Vec4::ZERO)
            & (x * c.y - y * c.x).cmpge(Vec4::ZERO);
        let ab = (x - x.clamp(Vec4::ZERO, Vec4::splat(b)), y);
        let t = ((x * c.x + y * c.y) * self.inverse2.x).clamp(Vec4::ZERO, Vec4::ONE);
        let ac = (x - t * c.x, y - t * c.y);
        let t = ((from_b * edge.x + y * edge.y) * self.inverse2.y).clamp(Vec4::ZERO, Vec4::ONE);
        let bc = (from_b - t * edge.x, y - t * edge.y);
        let length2 = |v: (Vec4, Vec4)| v.0 * v.0 + v.1 * v.1;
        let nearer = |v: (Vec4, Vec4), w: (Vec4, Vec4)| {
            let first = length2(v).cmple(length2(w));
            (Vec4::select(first, v.0, w.0), Vec4::select(first, v.1, w.1))
        };
        let (dx, dy) = nearer(ab, nearer(ac, bc));
        (Vec4::select(inside, Vec4::ZERO, dx), Vec4::select(inside, Vec4::ZERO, dy))
    }

    /// Distance from `p` in metres and its gradient. For a sample in free space (`!solid`) signed to the
    /// thickened sheet, else to the bare triangle.
    #[inline]
    pub fn distance(&self, p: Vec3, solid: bool) -> (f32, Vec3) {
        let (shift, radius_m) = if solid { (Vec3::ZERO, 0.0) } else { (self.shift, self.radius_m) };
        let at = self.local(p - shift);
        let edge = Vec2::new(self.c.x - self.b, self.c.y);
        let left_of_bc = at.y * edge.x - (at.x - self.b) * edge.y >= 0.0;
        if at.y >= 0.0 && left_of_bc && at.x * self.c.y - at.y * self.c.x >= 0.0 {
            // Right over the triangle: what most samples far from edges are.
            return (at.z.abs() - radius_m, self.normal * 1.0_f32.copysign(at.z));
        }
        let (dx, dy) = self.offsets(Vec4::splat(at.x), Vec4::splat(at.y));
        let away = Vec3::new(dx.x, dy.x, at.z);
        let distance = away.length();
        let unit = away / distance.max(f32::MIN_POSITIVE);
        let gradient = self.x_axis * unit.x + self.y_axis * unit.y + self.normal * unit.z;
        (distance - radius_m, gradient)
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
    let by_task = triangles_by_task(grid, facets, chosen, band_m, step)?;
    nearest
        .distance_m
        .par_chunks_mut(task)
        .zip(nearest.triangle.par_chunks_mut(task))
        .zip(by_task.par_iter())
        .enumerate()
        .try_for_each(|(number, ((distance, triangle), members))| {
            report(step, number, by_task.len())?;
            let first = number * PLANES_PER_TASK;
            let mut slab = Slab { grid, first_plane: first, distance, triangle };
            for (i, &t) in members.iter().enumerate() {
                if i % ASKED == ASKED - 1 {
                    report(step, number, by_task.len())?;
                }
                slab.write(&facets[t as usize], t, band_m, &open);
            }
            Ok(())
        })
}

/// Triangles between two calls of the caller's step; each fills at most a few thousand samples of a task.
const ASKED: usize = 256;

fn triangles_by_task(
    grid: &Grid,
    facets: &[Facet],
    chosen: &[u32],
    band_m: f32,
    step: Step,
) -> Result<Vec<Vec<u32>>, Stopped> {
    let mut by_task = vec![Vec::new(); grid.dim[0].div_ceil(PLANES_PER_TASK)];
    let mut pace = Pace::new(step, chosen.len());
    for &t in chosen {
        pace.item()?;
        let facet = &facets[t as usize];
        let reach = band_m + facet.radius_m;
        let xs = facet.corners().map(|p| p.x + facet.shift.x);
        let low = xs[0].min(xs[1]).min(xs[2]) - reach;
        let high = xs[0].max(xs[1]).max(xs[2]) + reach;
        if let Some((first, last)) = grid.span(0, low, high) {
            for list in &mut by_task[first / PLANES_PER_TASK..=last / PLANES_PER_TASK] {
                list.push(t);
            }
        }
    }
    Ok(by_task)
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
        let [a, b, c] = facet.corners().map(|p| p + facet.shift);
        let low = a.min(b).min(c) - reach;
        let high = a.max(b).max(c) + reach;
        let Some((x0, x1)) = self.grid.span(0, low.x, high.x) else { return };
        let Some((y0, y1)) = self.grid.span(1, low.y, high.y) else { return };
        let Some((z0, z1)) = self.grid.span(2, low.z, high.z) else { return };
        let last_plane = self.first_plane + self.distance.len() / (self.grid.dim[1] * self.grid.dim[2]) - 1;
        for x in x0.max(self.first_plane)..=x1.min(last_plane) {
            for y in y0..=y1 {
                self.write_row(facet, number, band_m, [x, y], (z0, z1), open);
            }
        }
    }

    /// Four samples at a time; flat coordinates and height are linear along the row.
    fn write_row(
        &mut self,
        facet: &Facet,
        number: u32,
        band_m: f32,
        [x, y]: [usize; 2],
        (z0, z1): (usize, usize),
        open: &impl Fn(usize) -> bool,
    ) {
        let row = self.grid.index([x - self.first_plane, y, 0]);
        let global = self.grid.index([x, y, 0]);
        let start = facet.local(self.grid.position([x, y, 0]) - facet.shift);
        let step_z = self.grid.cell_m.z;
        let per_step = Vec3::new(facet.x_axis.z, facet.y_axis.z, facet.normal.z) * step_z;
        let radius = Vec4::splat(facet.radius_m);
        for z in (z0..=z1).step_by(4) {
            let lanes = (z1 + 1 - z).min(4);
            let along = Vec4::splat(z as f32) + Vec4::new(0.0, 1.0, 2.0, 3.0);
            let height = along * per_step.z + start.z;
            let mut best = Vec4::splat(f32::NEG_INFINITY);
            for lane in 0..lanes {
                best[lane] = self.distance[row + z + lane];
            }
            let bound = best.min(Vec4::splat(band_m)) + radius - GAIN_M;
            let bound2 = Vec4::select(bound.cmpgt(Vec4::ZERO), bound * bound, Vec4::splat(-1.0));
            let height2 = height * height;
            if !height2.cmplt(bound2).any() {
                continue;
            }
            let (dx, dy) = facet.offsets(along * per_step.x + start.x, along * per_step.y + start.y);
            let distance2 = dx * dx + dy * dy + height2;
            let nearer = distance2.cmplt(bound2);
            if !nearer.any() {
                continue;
            }
            for lane in 0..lanes {
                if nearer.test(lane) && open(global + z + lane) {
                    self.distance[row + z + lane] = distance2[lane].sqrt() - facet.radius_m;
                    self.triangle[row + z + lane] = number;
                }
            }
        }
    }
}

/// A triangle must be nearer by this to replace another: neighbouring tiles of a flat wall would otherwise
/// take each other's samples by rounding, over and over.
const GAIN_M: f32 = 1e-6;
