//! Sheets and thin plates: surfaces with free space on both sides within one cell of each other.
//!
//! Sampled as they are they would fall between the samples and vanish: a body could pass through a table
//! top. Each is thickened to just over one cell. Horizontal ones grow downward only, so that what stands on
//! them stands where the file says; upright ones grow to both sides.

use super::distance::Facet;
use super::grid::Grid;
use super::lines::{Crossing, Lines};
use crate::scene::step::{Pace, Step, Stopped, fill};

/// Half thickness of a sheet in cells. At least 0.5, or a sheet in the middle between two samples touches
/// neither; the rest covers the rounding.
const HALF_THICKNESS: f32 = 0.55;
/// Share of a triangle's crossings that must be thin before all of it is thickened.
const MOSTLY: f32 = 0.25;
/// A surface counts as horizontal from this upward component of its normal (45 degrees).
const HORIZONTAL: f32 = 0.7;

/// Thickens the sheets among `facets` and returns which ones they are.
pub(super) fn thicken(
    grid: &Grid,
    lines: &[Lines; 3],
    solid: &[bool],
    facets: &mut [Facet],
    step: Step,
) -> Result<Vec<u32>, Stopped> {
    let mut crossed = vec![(0_u32, 0_u32); facets.len()];
    for_each_step(grid, lines, step, |axis, here, ends| {
        let thin = ends.iter().all(|&end| !solid[end]);
        for crossing in here {
            let (all, thin_ones) = &mut crossed[crossing.triangle as usize];
            *all += 1;
            *thin_ones += u32::from(thin);
        }
        if thin {
            widen(grid, axis, here, facets);
        }
    })?;
    let mut thickened = Vec::new();
    let mut pace = Pace::new(step, facets.len());
    for (t, facet) in facets.iter_mut().enumerate() {
        pace.item()?;
        let (all, thin) = crossed[t];
        if facet.radius_m > 0.0 && thin as f32 >= MOSTLY * all as f32 {
            thickened.push(t as u32);
        } else {
            facet.radius_m = 0.0;
            facet.shift = glam::Vec3::ZERO;
        }
    }
    Ok(thickened)
}

/// Calls `visit(axis, crossings, [sample before, sample after])` for every step between samples that is crossed.
fn for_each_step(
    grid: &Grid,
    lines: &[Lines; 3],
    step: Step,
    mut visit: impl FnMut(usize, &[Crossing], [usize; 2]),
) -> Result<(), Stopped> {
    for (axis, lines) in lines.iter().enumerate() {
        let stride = grid.strides()[axis];
        lines.for_each(step, |u, v, crossings| {
            for step in crossings.chunk_by(|a, b| a.before() == b.before()) {
                let before = step[0].before();
                if before >= 0 && (before as usize) + 1 < grid.dim[axis] {
                    let index = grid.index(lines.sample(u, v, before as usize));
                    visit(axis, step, [index, index + stride]);
                }
            }
        })?;
    }
    Ok(())
}

/// Gives the triangles of one crossed step at least the thickness of a cell.
fn widen(grid: &Grid, axis: usize, step: &[Crossing], facets: &mut [Facet]) {
    let (first, last) = (step[0].place, step[step.len() - 1].place);
    for crossing in step {
        let facet = &mut facets[crossing.triangle as usize];
        let across = facet.normal[axis].abs();
        let radius_m = HALF_THICKNESS * grid.cell_m[axis] * across;
        if radius_m <= facet.radius_m {
            continue;
        }
        let horizontal = axis == 1 && across >= HORIZONTAL;
        let middle = if horizontal { last - HALF_THICKNESS } else { 0.5 * (first + last) };
        facet.radius_m = radius_m;
        facet.shift = glam::Vec3::ZERO;
        facet.shift[axis] = (middle - crossing.place) * grid.cell_m[axis];
    }
}

/// Triangles with solid on both sides: no boundary of free space, so no distance is measured to them.
pub(super) fn buried(
    grid: &Grid,
    lines: &[Lines; 3],
    solid: &[bool],
    facets: &[Facet],
    step: Step,
) -> Result<Vec<bool>, Stopped> {
    let mut exposed = vec![false; facets.len()];
    for_each_step(grid, lines, step, |_, here, ends| {
        if ends.iter().any(|&end| !solid[end]) {
            here.iter().for_each(|c| exposed[c.triangle as usize] = true);
        }
    })?;
    let near_air = |facet: &Facet| {
        let [a, b, c] = facet.corners();
        [(a + b + c) / 3.0, a, b, c].into_iter().any(|p| {
            let low = ((p - grid.origin) / grid.cell_m).floor();
            (0..8).any(|corner| {
                let place: [usize; 3] = std::array::from_fn(|axis| {
                    (low[axis] as isize + (corner >> axis & 1)).clamp(0, grid.dim[axis] as isize - 1) as usize
                });
                !solid[grid.index(place)]
            })
        })
    };
    let mut buried = vec![false; facets.len()];
    fill(&mut buried, step, |t| !exposed[t] && !near_air(&facets[t]))?;
    Ok(buried)
}
