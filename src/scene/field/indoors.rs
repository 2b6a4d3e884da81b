//! Which columns of the grid belong to the room: those over its floor, holes and notches closed. The rest (the
//! notch of an L-shaped flat, the garden beyond a terrace without ground) lies outside, where all is solid.

use rayon::prelude::*;

use super::grid::Grid;
use super::lines::Lines;
use crate::scene::step::{Step, Stopped, report};

/// Holes and notches in a floor (scans see none behind furniture) are closed up to twice this width.
const CLOSE_M: f32 = 0.6;
/// The room reaches this far beyond its last floor.
const BEYOND_FLOOR_M: f32 = 0.05;
/// A surface is a floor up to this height: what hangs higher (a roof's overhang) shelters no room.
const FLOOR_BELOW_M: f32 = 1.0;
/// With less floor than this share of the box the file has no floor at all, and the box is the room.
const LEAST_FLOOR: f32 = 0.2;

/// Horizontal distance in metres of every column (x, z) from the edge of the room: positive inside, at most 0
/// outside, infinite where the box is the room.
pub(super) fn distance_indoors(grid: &Grid, heights: &Lines, step: Step) -> Result<Vec<f32>, Stopped> {
    let [nx, _, nz] = grid.dim;
    let floor_m = FLOOR_BELOW_M - grid.origin.y;
    let floored: Vec<bool> = (0..nx * nz)
        .map(|column| {
            let lowest = heights.line(column / nz, column % nz).first();
            lowest.is_some_and(|c| c.place * grid.cell_m.y <= floor_m)
        })
        .collect();
    let count = floored.iter().filter(|&&f| f).count();
    if (count as f32) < LEAST_FLOOR * floored.len() as f32 || count == floored.len() {
        return Ok(vec![f32::INFINITY; nx * nz]);
    }
    let from_floor = plane_distances([nx, nz], [grid.cell_m.x, grid.cell_m.z], &floored, step)?;
    let outside: Vec<bool> = from_floor.iter().map(|&d| d > CLOSE_M).collect();
    if !outside.contains(&true) {
        return Ok(vec![f32::INFINITY; nx * nz]);
    }
    let to_outside = plane_distances([nx, nz], [grid.cell_m.x, grid.cell_m.z], &outside, step)?;
    let signed = |(&to_outside, &from_floor): (&f32, &f32)| {
        let inside = to_outside - CLOSE_M + BEYOND_FLOOR_M;
        if inside > 0.0 { inside } else { inside.min(BEYOND_FLOOR_M - from_floor).min(0.0) }
    };
    Ok(to_outside.iter().zip(&from_floor).map(signed).collect())
}

/// Distance in metres from each cell of a plane to the nearest one that is `set`, exact; infinite if none is.
pub(in crate::scene) fn plane_distances(
    [nx, nz]: [usize; 2],
    cell_m: [f32; 2],
    set: &[bool],
    step: Step,
) -> Result<Vec<f32>, Stopped> {
    let mut along_z = vec![f32::INFINITY; nx * nz];
    for x in 0..nx {
        let row = &mut along_z[x * nz..(x + 1) * nz];
        let mut since = f32::INFINITY;
        for z in 0..nz {
            since = if set[x * nz + z] { 0.0 } else { since + cell_m[1] };
            row[z] = since;
        }
        since = f32::INFINITY;
        for z in (0..nz).rev() {
            since = if set[x * nz + z] { 0.0 } else { since + cell_m[1] };
            row[z] = row[z].min(since);
        }
    }
    let mut distance = vec![f32::INFINITY; nx * nz];
    distance.par_chunks_mut(nz.max(1)).enumerate().try_for_each(|(x, row)| {
        report(step, x, nx)?;
        for i in 0..nx {
            let across2 = ((i as f32 - x as f32) * cell_m[0]).powi(2);
            for (z, distance) in row.iter_mut().enumerate() {
                *distance = distance.min(along_z[i * nz + z].powi(2) + across2);
            }
        }
        row.iter_mut().for_each(|distance| *distance = distance.sqrt());
        Ok(())
    })?;
    Ok(distance)
}
