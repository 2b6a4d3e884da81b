//! Distances beyond the narrow band: sweeps that hand on which triangle is nearest.
//!
//! Each sample measures its exact distance to the triangles that its neighbours know, so only the choice of the
//! triangle can be wrong, never the distance to it. The distance to a triangle is convex: a neighbour's
//! distance and gradient bound it from below, and a triangle that cannot come nearer is not measured.
//! Sweeps along x go plane by plane; those along y and z stay inside a plane, so that planes run in parallel,
//! and come before and after, so that triangles turn corners.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::distance::{Facet, NOBODY, Nearest};
use super::grid::Grid;
use crate::scene::step::{Step, Stopped, fill, report};

/// Gain for which another triangle is measured, in metres: covers the rounding of [`Direction`] over one
/// step of a few centimetres.
const WORTH_M: f32 = 1e-4;
/// Rows of a plane that one task takes in a sweep along x: tens of microseconds of work.
const ROWS_PER_TASK: usize = 32;

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
    let mut gradient = gradients(grid, facets, solid, nearest, step)?;
    let sweep = Sweep { grid, facets, solid, exact_m, slack_m };
    sweep.within_planes(nearest, &mut gradient, step)?;
    for reverse in [false, true] {
        sweep.across_planes(reverse, nearest, &mut gradient, step)?;
    }
    sweep.within_planes(nearest, &mut gradient, step)
}

/// Gradients of the distances that are known already.
fn gradients(
    grid: &Grid,
    facets: &[Facet],
    solid: &[bool],
    nearest: &Nearest,
    step: Step,
) -> Result<Vec<Direction>, Stopped> {
    let mut gradients = vec![Direction::default(); grid.len()];
    fill(&mut gradients, step, |index| {
        let triangle = nearest.triangle[index];
        if triangle == NOBODY {
            return Direction::default();
        }
        let p = grid.position(grid.place(index));
        Direction::pack(facets[triangle as usize].distance(p, solid[index]).1)
    })?;
    Ok(gradients)
}

/// A unit vector in three times ten bits: off by at most 0.001 along each axis.
#[derive(Clone, Copy, Debug, Default)]
struct Direction(u32);

impl Direction {
    const SCALE: f32 = 511.0;

    #[inline]
    fn pack(unit: Vec3) -> Self {
        let part = |x: f32| ((x + 1.0) * Self::SCALE + 0.5) as u32;
        Self(part(unit.x) | part(unit.y) << 10 | part(unit.z) << 20)
    }

    /// Its part along `axis`.
    #[inline]
    fn along(self, axis: usize) -> f32 {
        (self.0 >> (10 * axis) & 1023) as i32 as f32 * (1.0 / Self::SCALE) - 1.0
    }
}

/// What a row of samples hands on: for each a lower bound of its triangle's distance one step ahead, how that
/// bound changes to the sides, and the triangle. One empty entry at either end.
#[derive(Clone)]
struct Row {
    ahead_m: Vec<f32>,
    /// Change of the bound for a step towards larger columns.
    column_m: Vec<f32>,
    /// Change of the bound for a step towards the next row.
    row_m: Vec<f32>,
    triangle: Vec<u32>,
}

impl Row {
    fn new(columns: usize) -> Self {
        // Whole groups of four can be read from any column, and from the one after it.
        let padded = columns + 8;
        let empty = vec![0.0; padded];
        Self {
            ahead_m: vec![f32::INFINITY; padded],
            column_m: empty.clone(),
            row_m: empty,
            triangle: vec![NOBODY; padded],
        }
    }
}

/// One row of samples inside the grid's arrays.
struct Samples<'a> {
    distance_m: &'a mut [f32],
    triangle: &'a mut [u32],
    gradient: &'a mut [Direction],
    /// From sample to sample.
    stride: usize,
    /// Number of samples.
    len: usize,
    /// Grid place of the first sample.
    place: [usize; 3],
    /// Grid index of the first sample.
    index: usize,
}

/// Which way a row looks: the axis of the sweep, of the columns and of the rows, and the step ahead.
#[derive(Clone, Copy)]
struct Way {
    ahead: usize,
    column: usize,
    row: usize,
    reverse: bool,
}

struct Sweep<'a> {
    grid: &'a Grid,
    facets: &'a [Facet],
    solid: &'a [bool],
    exact_m: f32,
    slack_m: f32,
}

impl Sweep<'_> {
    /// Both ways along y and z in every plane.
    fn within_planes(
        &self,
        nearest: &mut Nearest,
        gradient: &mut [Direction],
        step: Step,
    ) -> Result<(), Stopped> {
        let [nx, ny, nz] = self.grid.dim;
        let plane = ny * nz;
        let distances = nearest.distance_m.par_chunks_mut(plane);
        let triangles = nearest.triangle.par_chunks_mut(plane);
        let gradients = gradient.par_chunks_mut(plane);
        distances.zip(triangles).zip(gradients).enumerate().try_for_each(
            |(x, ((distance_m, triangle), gradient))| {
                report(step, x, nx)?;
                for (ahead, column) in [(1, 2), (2, 1)] {
                    let (slices, columns) = (self.grid.dim[ahead], self.grid.dim[column]);
                    let strides = self.grid.strides();
                    for reverse in [false, true] {
                        let way = Way { ahead, column, row: 0, reverse };
                        let (mut front, mut next) = (Row::new(columns), Row::new(columns));
                        for turn in 0..slices {
                            let slice = if reverse { slices - 1 - turn } else { turn };
                            let offset = slice * strides[ahead];
                            let mut place = [x, 0, 0];
                            place[ahead] = slice;
                            let samples = Samples {
                                distance_m: &mut distance_m[offset..],
                                triangle: &mut triangle[offset..],
                                gradient: &mut gradient[offset..],
                                stride: strides[column],
                                len: columns,
                                place,
                                index: x * plane + offset,
                            };
                            self.row(way, samples, [None, Some(&front), None], &mut next);
                            std::mem::swap(&mut front, &mut next);
                        }
                    }
                }
                Ok(())
            },
        )
    }

    /// One way along x, plane by plane.
    fn across_planes(
        &self,
        reverse: bool,
        nearest: &mut Nearest,
        gradient: &mut [Direction],
        step: Step,
    ) -> Result<(), Stopped> {
        let [nx, ny, nz] = self.grid.dim;
        let plane = ny * nz;
        let way = Way { ahead: 0, column: 2, row: 1, reverse };
        let mut front = vec![Row::new(nz); ny];
        let mut next = front.clone();
        for turn in 0..nx {
            report(step, turn, nx)?;
            let x = if reverse { nx - 1 - turn } else { turn };
            let range = x * plane..(x + 1) * plane;
            let distances = nearest.distance_m[range.clone()].par_chunks_mut(nz);
            let triangles = nearest.triangle[range.clone()].par_chunks_mut(nz);
            let rows = distances.zip(triangles).zip(gradient[range].par_chunks_mut(nz));
            rows.zip(next.par_iter_mut()).enumerate().with_min_len(ROWS_PER_TASK).for_each(
                |(y, (((distance_m, triangle), gradient), next))| {
                    let index = x * plane + y * nz;
                    let samples = Samples {
                        distance_m,
                        triangle,
                        gradient,
                        stride: 1,
                        len: nz,
                        place: [x, y, 0],
                        index,
                    };
                    let before = y.checked_sub(1).and_then(|y| front.get(y));
                    self.row(way, samples, [before, front.get(y), front.get(y + 1)], next);
                },
            );
            std::mem::swap(&mut front, &mut next);
        }
        Ok(())
    }

    /// Updates one row from the row behind it and that row's neighbours, and writes what it hands on.
    fn row(&self, way: Way, mut samples: Samples, front: [Option<&Row>; 3], next: &mut Row) {
        for first in (0..samples.len).step_by(4) {
            let lanes = (samples.len - first).min(4);
            let mut limit = Vec4::splat(f32::NEG_INFINITY);
            for lane in 0..lanes {
                let distance_m = samples.distance_m[(first + lane) * samples.stride];
                // What is exact can't be improved.
                limit[lane] =
                    if distance_m <= self.exact_m { f32::NEG_INFINITY } else { distance_m - WORTH_M };
            }
            for (row, side) in front.into_iter().zip([-1.0_f32, 0.0, 1.0]) {
                let Some(row) = row else { continue };
                // A neighbour in the row before looks at us one step towards larger rows.
                self.consider(way, &mut samples, (first, lanes), row, (1, -side, 0.0), &mut limit);
                if side == 0.0 {
                    self.consider(way, &mut samples, (first, lanes), row, (0, 0.0, 1.0), &mut limit);
                    self.consider(way, &mut samples, (first, lanes), row, (2, 0.0, -1.0), &mut limit);
                }
            }
        }
        self.hand_on(way, &samples, next);
    }

    /// Lets four samples try the triangles of four samples of `row`, which lie `shift - 1` columns on.
    #[inline]
    fn consider(
        &self,
        way: Way,
        samples: &mut Samples,
        (first, lanes): (usize, usize),
        row: &Row,
        (shift, to_row, to_column): (usize, f32, f32),
        limit: &mut Vec4,
    ) {
        let at = first + shift;
        let four = |values: &[f32]| Vec4::from_slice(&values[at..at + 4]);
        let bound = four(&row.ahead_m) + four(&row.row_m) * to_row + four(&row.column_m) * to_column;
        let worth = bound.cmplt(*limit);
        if !worth.any() {
            return;
        }
        for lane in (0..lanes).filter(|&lane| worth.test(lane)) {
            let candidate = row.triangle[at + lane];
            let here = (first + lane) * samples.stride;
            if candidate == samples.triangle[here] || candidate == NOBODY {
                continue;
            }
            let mut place = samples.place;
            place[way.column] = first + lane;
            let solid = self.solid[samples.index + here];
            let (distance_m, gradient) =
                self.facets[candidate as usize].distance(self.grid.position(place), solid);
            if distance_m < samples.distance_m[here] {
                samples.distance_m[here] = distance_m;
                samples.triangle[here] = candidate;
                samples.gradient[here] = Direction::pack(gradient);
                limit[lane] = distance_m - WORTH_M;
            }
        }
    }

    fn hand_on(&self, way: Way, samples: &Samples, next: &mut Row) {
        // The same loop, once for the compiler to see that the samples are adjacent.
        if samples.stride == 1 {
            self.hand_on_by(1, way, samples, next);
        } else {
            self.hand_on_by(samples.stride, way, samples, next);
        }
    }

    #[inline(always)]
    fn hand_on_by(&self, stride: usize, way: Way, samples: &Samples, next: &mut Row) {
        let cell = self.grid.cell_m;
        let ahead = if way.reverse { -cell[way.ahead] } else { cell[way.ahead] };
        let (column_m, row_m) = (cell[way.column], cell[way.row]);
        let span = (samples.len - 1) * stride + 1;
        let (distance_m, triangle) = (&samples.distance_m[..span], &samples.triangle[..span]);
        let (gradient, solid) = (&samples.gradient[..span], &self.solid[samples.index..samples.index + span]);
        let inside = 1..samples.len + 1;
        let bounds = next.ahead_m[inside.clone()].iter_mut().zip(&mut next.triangle[inside.clone()]);
        let slopes = next.column_m[inside.clone()].iter_mut().zip(&mut next.row_m[inside]);
        for (column, ((bound, number), (along_column, along_row))) in bounds.zip(slopes).enumerate() {
            let here = column * stride;
            let direction = gradient[here];
            // Solid samples measure to bare triangles, which says less about thickened ones.
            let slack_m = if solid[here] { self.slack_m } else { 0.0 };
            *bound = distance_m[here] + direction.along(way.ahead) * ahead - slack_m;
            *along_column = direction.along(way.column) * column_m;
            *along_row = direction.along(way.row) * row_m;
            *number = triangle[here];
        }
    }
}
