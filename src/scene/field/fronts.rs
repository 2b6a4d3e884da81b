//! Which side of each surface is its front, and what each sample sees: fronts or backs.

use glam::Vec3;
use rayon::prelude::*;

use super::grid::Grid;
use super::lines::{Crossing, Lines};
use crate::scene::step::{Pace, Step, Stopped, fill, group, report};

/// A surface has a front if standing air sees one side in at least this share of the views.
const ONE_SIDED: f32 = 0.8;
/// Planes of samples that one task counts.
const PLANES_PER_TASK: usize = 16;

/// For every triangle which side is its front: +1 the side of its normal, -1 the other, 0 unknown or both.
/// The front is what standing air sees; all triangles of a connected surface share it.
pub(super) fn fronts_seen(
    grid: &Grid,
    lines: &[Lines; 3],
    triangles: &[[Vec3; 3]],
    is_standing: impl Fn(usize) -> bool,
    step: Step,
) -> Result<Vec<i8>, Stopped> {
    let (surface_of, surfaces) = connected_surfaces(triangles, step)?;
    let mut seen = vec![(0_u32, 0_u32); surfaces];
    for (axis, lines) in lines.iter().enumerate() {
        let stride = grid.strides()[axis];
        lines.for_each(step, |u, v, crossings| {
            let start = grid.index(lines.sample(u, v, 0));
            let mut look = |crossing: &Crossing, from_above: bool| {
                let views = &mut seen[surface_of[crossing.triangle as usize] as usize];
                if crossing.along == from_above { views.0 += 1 } else { views.1 += 1 }
            };
            for_each_gap(crossings, grid.dim[axis], |first, last, below, above| {
                if (first..=last).any(|i| is_standing(start + i * stride)) {
                    below.iter().for_each(|c| look(c, true));
                    above.iter().for_each(|c| look(c, false));
                }
            });
        })?;
    }
    let front = |&(front, back): &(u32, u32)| {
        let share = front as f32 / (front + back).max(1) as f32;
        match (front + back, share) {
            (0, _) => 0,
            (_, s) if s >= ONE_SIDED => 1,
            (_, s) if s <= 1.0 - ONE_SIDED => -1,
            _ => 0,
        }
    };
    let fronts: Vec<i8> = seen.iter().map(front).collect();
    Ok(surface_of.iter().map(|&s| fronts[s as usize]).collect())
}

/// Calls `visit(first, last, below, above)` for every run of samples between neighbouring crossings.
#[inline]
fn for_each_gap(
    crossings: &[Crossing],
    samples: usize,
    mut visit: impl FnMut(usize, usize, Option<&Crossing>, Option<&Crossing>),
) {
    let mut first = 0_isize;
    let mut below = None;
    for above in crossings.iter().map(Some).chain([None]) {
        let last = above.map_or(samples as isize - 1, |c| c.before().min(samples as isize - 1));
        if last >= first {
            visit(first as usize, last as usize, below, above);
            first = last + 1;
        }
        below = above;
    }
}

/// Which connected surface each triangle belongs to (corners at the same place are joined), and how many.
fn connected_surfaces(triangles: &[[Vec3; 3]], step: Step) -> Result<(Vec<u32>, usize), Stopped> {
    let mut corners = vec![([0_u32; 3], 0_u32); 3 * triangles.len()];
    fill(&mut corners, step, |i| {
        // Adding 0.0 makes -0.0 and 0.0 the same place.
        let place = (triangles[i / 3][i % 3] + Vec3::ZERO).to_array().map(f32::to_bits);
        (place, (i / 3) as u32)
    })?;
    let places = group(corners, step, |([x, y, z], _)| {
        u64::from(*x) ^ u64::from(*y).rotate_left(21) ^ u64::from(*z).rotate_left(42)
    })?;
    let mut parent: Vec<u32> = (0..triangles.len() as u32).collect();
    for corners in &places {
        report(step, 0, 0)?;
        for pair in corners.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            let (a, b) = (root(&mut parent, pair[0].1), root(&mut parent, pair[1].1));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut number = vec![u32::MAX; triangles.len()];
    let mut count = 0;
    let mut pace = Pace::new(step, triangles.len());
    let surface_of = (0..triangles.len() as u32).map(|t| {
        pace.item()?;
        let r = root(&mut parent, t) as usize;
        if number[r] == u32::MAX {
            number[r] = count;
            count += 1;
        }
        Ok(number[r])
    });
    let surface_of = surface_of.collect::<Result<Vec<u32>, Stopped>>()?;
    Ok((surface_of, count as usize))
}

fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}

/// Of the surfaces seen along ±x, ±z and up: how many show their fronts, how many their backs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Votes(u8);

impl Votes {
    /// How many fronts are seen.
    pub fn fronts(self) -> u8 {
        self.0 & 15
    }

    /// How many backs are seen.
    pub fn backs(self) -> u8 {
        self.0 >> 4
    }
}

/// What every sample sees.
pub(super) fn votes(
    grid: &Grid,
    lines: &[Lines; 3],
    fronts: &[i8],
    step: Step,
) -> Result<Vec<Votes>, Stopped> {
    let mut votes = vec![Votes::default(); grid.len()];
    let plane = grid.dim[1] * grid.dim[2];
    let vote = |crossing: Option<&Crossing>, from_above: bool| -> u8 {
        let front = crossing.map_or(0, |c| fronts[c.triangle as usize]);
        let seen = if crossing.is_some_and(|c| c.along == from_above) { front } else { -front };
        [16, 0, 1][(seen + 1) as usize]
    };
    votes.par_chunks_mut(PLANES_PER_TASK * plane).enumerate().try_for_each(|(task, votes)| {
        let first_plane = task * PLANES_PER_TASK;
        let planes = votes.len() / plane;
        for x in 0..planes {
            report(step, first_plane + x, grid.dim[0])?;
            let votes = &mut votes[x * plane..(x + 1) * plane];
            for y in 0..grid.dim[1] {
                for_each_gap(lines[2].line(first_plane + x, y), grid.dim[2], |first, last, below, above| {
                    let seen = vote(below, true) + vote(above, false);
                    let row = y * grid.dim[2];
                    votes[row + first..=row + last].iter_mut().for_each(|v| v.0 += seen);
                });
            }
            for z in 0..grid.dim[2] {
                for_each_gap(lines[1].line(first_plane + x, z), grid.dim[1], |first, last, _, above| {
                    let seen = vote(above, false);
                    (first..=last).for_each(|y| votes[y * grid.dim[2] + z].0 += seen);
                });
            }
        }
        for column in 0..plane {
            let line = lines[0].line(column / grid.dim[2], column % grid.dim[2]);
            let last_plane = first_plane + planes - 1;
            for_each_gap(line, grid.dim[0], |first, last, below, above| {
                let seen = vote(below, true) + vote(above, false);
                for x in first.max(first_plane)..=last.min(last_plane) {
                    votes[(x - first_plane) * plane + column].0 += seen;
                }
            });
        }
        Ok(())
    })?;
    Ok(votes)
}
