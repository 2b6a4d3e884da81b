//! Where the grid's own lines cross the triangles: one list along each axis.
//!
//! Everything that the sign needs is read off these lists: which steps between neighbouring samples a
//! surface blocks, which side of a surface a sample sees, and how thick a plate is. All lines pass through
//! samples moved by one tiny common offset, so that no line runs inside a wall that lies on the grid, and
//! edges are tested in one direction for both of their triangles, so that no line slips through a seam.

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::grid::Grid;
use crate::scene::step::{Pace, Step, Stopped, report};

/// Offset of all lines from the samples in metres: far below any accuracy asked for, far above rounding,
/// and in no simple ratio.
const OFFSET_M: DVec3 = DVec3::new(1.31e-5, 1.73e-5, 1.13e-5);

/// A triangle met by a grid line.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Crossing {
    /// Place along the line in cells from sample 0; the surface stands between `floor` and `floor + 1`.
    pub place: f32,
    /// Which triangle.
    pub triangle: u32,
    /// Whether its normal points along the axis.
    pub along: bool,
}

impl Crossing {
    /// Sample before the crossing; -1 before the grid.
    pub fn before(&self) -> isize {
        self.place.floor() as isize
    }
}

/// All crossings along one axis, in order on each line.
pub(in crate::scene) struct Lines {
    start: Vec<u32>,
    crossings: Vec<Crossing>,
    /// The two other axes, in ascending order.
    across: [usize; 2],
    across_dim: [usize; 2],
}

impl Lines {
    /// Crosses every triangle with the grid lines along `axis`.
    ///
    /// # Errors
    /// [`Stopped`] when `step` breaks off.
    pub fn new(grid: &Grid, triangles: &[[Vec3; 3]], axis: usize, step: Step) -> Result<Self, Stopped> {
        let across = [[1, 2], [0, 2], [0, 1]][axis];
        let across_dim = across.map(|a| grid.dim[a]);
        let chunks = triangles.len().div_ceil(CHUNK);
        let found = triangles.par_chunks(CHUNK).enumerate().map(|(chunk, part)| {
            report(step, chunk, chunks)?;
            let mut out = Vec::with_capacity(part.len() * 2);
            for (i, triangle) in part.iter().enumerate() {
                cross_triangle(grid, triangle, (chunk * CHUNK + i) as u32, axis, across, &mut out);
            }
            Ok(out)
        });
        let found = found.collect::<Result<Vec<_>, Stopped>>()?;
        let mut start = vec![0_u32; across_dim[0] * across_dim[1] + 1];
        for part in &found {
            report(step, 0, 0)?;
            part.iter().for_each(|(line, _)| start[*line as usize + 1] += 1);
        }
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let mut lines = Self { crossings: in_lines(&found, &start, step)?, start, across, across_dim };
        lines.sort(step)?;
        Ok(lines)
    }

    /// Puts the crossings of each line in order.
    fn sort(&mut self, step: Step) -> Result<(), Stopped> {
        let mut pace = Pace::new(step, self.crossings.len());
        for window in self.start.windows(2) {
            let line = &mut self.crossings[window[0] as usize..window[1] as usize];
            pace.items(line.len())?;
            line.sort_unstable_by(|a, b| a.place.total_cmp(&b.place).then(a.triangle.cmp(&b.triangle)));
        }
        Ok(())
    }

    /// The crossings of the line through `(u, v)` of the two other axes, in order.
    #[inline]
    pub fn line(&self, u: usize, v: usize) -> &[Crossing] {
        let line = u * self.across_dim[1] + v;
        &self.crossings[self.start[line] as usize..self.start[line + 1] as usize]
    }

    /// Sample number `along` of the line through `(u, v)`.
    #[inline]
    pub fn sample(&self, u: usize, v: usize, along: usize) -> [usize; 3] {
        let mut sample = [along; 3];
        sample[self.across[0]] = u;
        sample[self.across[1]] = v;
        sample
    }

    /// Calls `visit(u, v, crossings)` for every line that meets anything.
    ///
    /// # Errors
    /// [`Stopped`] when `step` breaks off.
    pub fn for_each(
        &self,
        step: Step,
        mut visit: impl FnMut(usize, usize, &[Crossing]),
    ) -> Result<(), Stopped> {
        let mut pace = Pace::new(step, self.crossings.len());
        for u in 0..self.across_dim[0] {
            for v in 0..self.across_dim[1] {
                let line = self.line(u, v);
                if !line.is_empty() {
                    pace.items(line.len() + LINE)?;
                    visit(u, v, line);
                }
            }
        }
        Ok(())
    }
}

/// Triangles that one task crosses.
const CHUNK: usize = 8192;
/// A line of samples is about as much work as so many crossings.
const LINE: usize = 16;

/// The crossings of all chunks, those of each line together, beginning at its `start`.
fn in_lines(found: &[Vec<(u32, Crossing)>], start: &[u32], step: Step) -> Result<Vec<Crossing>, Stopped> {
    let mut next = start.to_vec();
    let nothing = Crossing { place: 0.0, triangle: 0, along: false };
    let mut crossings = vec![nothing; start[start.len() - 1] as usize];
    for part in found {
        report(step, 0, 0)?;
        for (line, crossing) in part {
            let slot = &mut next[*line as usize];
            crossings[*slot as usize] = *crossing;
            *slot += 1;
        }
    }
    Ok(crossings)
}

fn cross_triangle(
    grid: &Grid,
    triangle: &[Vec3; 3],
    number: u32,
    axis: usize,
    across: [usize; 2],
    out: &mut Vec<(u32, Crossing)>,
) {
    let origin = grid.origin.as_dvec3() + OFFSET_M;
    let cell = grid.cell_m.as_dvec3();
    let corners = triangle.map(|p| (p.as_dvec3() - origin) / cell);
    let flat = corners.map(|p| DVec2::new(p[across[0]], p[across[1]]));
    let twice_area = (flat[1] - flat[0]).perp_dot(flat[2] - flat[0]);
    if twice_area == 0.0 {
        return;
    }
    let low = flat[0].min(flat[1]).min(flat[2]).ceil().max(DVec2::ZERO);
    let high = flat[0].max(flat[1]).max(flat[2]).floor();
    let high = high.min(DVec2::new((grid.dim[across[0]] - 1) as f64, (grid.dim[across[1]] - 1) as f64));
    if low.x > high.x || low.y > high.y {
        return;
    }
    // Axes (y,z), (x,z), (x,y): the middle pair is the one of odd order.
    let along = (twice_area > 0.0) != (axis == 1);
    for u in low.x as usize..=high.x as usize {
        for v in low.y as usize..=high.y as usize {
            let p = DVec2::new(u as f64, v as f64);
            if let Some(place) = height_at(&flat, &corners, axis, p, twice_area) {
                let line = (u * grid.dim[across[1]] + v) as u32;
                out.push((line, Crossing { place: place as f32, triangle: number, along }));
            }
        }
    }
}

/// The triangle's place along `axis` over `p`, if it lies over `p`.
fn height_at(flat: &[DVec2; 3], corners: &[DVec3; 3], axis: usize, p: DVec2, twice_area: f64) -> Option<f64> {
    let left = twice_area > 0.0;
    let mut weights = [0.0; 3];
    for i in 0..3 {
        let (from, to) = (flat[(i + 1) % 3], flat[(i + 2) % 3]);
        // Both triangles of an edge test it in the same direction, so that they agree to the last bit.
        let swapped = (from.x, from.y) > (to.x, to.y);
        let (a, b) = if swapped { (to, from) } else { (from, to) };
        let side = (b - a).perp_dot(p - a);
        if ((side >= 0.0) != swapped) != left {
            return None;
        }
        weights[i] = if swapped { -side } else { side };
    }
    Some((0..3).map(|i| weights[i] * corners[i][axis]).sum::<f64>() / twice_area)
}
