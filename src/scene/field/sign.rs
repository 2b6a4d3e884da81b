//! What is free space and what is solid: the sign rule. See `bake` for the reasoning.

use rayon::prelude::*;

use glam::Vec3;

use super::fronts::{Votes, fronts_seen, votes};
use super::grid::Grid;
use super::lines::Lines;
use super::standing::for_each_standing;
use crate::math::Aabb;
use crate::scene::step::{Pace, Step, Stopped, fill, report};

/// Air that cannot be reached through openings at least twice as wide is doubtful: holes of scans and gaps
/// between parts of furniture are smaller, passages for people larger.
const BALL_M: f32 = 0.05;

/// Steps to the next sample along x, y and z that are closed.
const CLOSED: [u8; 3] = [1, 2, 4];
/// Outside the room.
const OUTSIDE: u8 = 8;
/// Somebody could stand there.
const STANDING: u8 = 16;

/// The room as the sign rule sees it.
pub(super) struct Surroundings<'a> {
    pub grid: &'a Grid,
    /// Crossings of the grid lines along x, y and z.
    pub lines: &'a [Lines; 3],
    pub triangles: &'a [[Vec3; 3]],
    /// Exact distances near surfaces, infinite elsewhere.
    pub distance_m: &'a [f32],
    /// Outside this box all is solid: virtual walls, floor and ceiling.
    pub enclosure: Aabb,
    /// Columns (x, z) that belong to the room; outside them all is solid.
    pub indoors: &'a [bool],
}

/// Whether each sample is solid.
pub(super) fn classify(room: &Surroundings, step: Step) -> Result<Vec<bool>, Stopped> {
    let grid = room.grid;
    let mut marks = closed_steps(room, step)?;
    let mut standing = Vec::new();
    for_each_standing(grid, &marks, &room.lines[1], step, |index| standing.push(index as u32))?;
    let mut pace = Pace::new(step, standing.len());
    for &index in &standing {
        pace.item()?;
        marks[index as usize] |= STANDING;
    }
    let fronts = fronts_seen(grid, room.lines, room.triangles, |index| marks[index] & STANDING != 0, step)?;
    let (mut reach, shore) = flood_by_ball(room, &marks, standing, step)?;
    flood_narrow(grid, &marks, &mut reach, shore, step)?;
    let votes = votes(grid, room.lines, &fronts, step)?;
    let mut solid = vec![false; grid.len()];
    fill(&mut solid, step, |index| is_solid(reach[index], votes[index]))?;
    Ok(solid)
}

/// How air comes to a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    /// Not at all.
    Never,
    /// A ball of [`BALL_M`] comes through.
    Wide,
    /// Only through narrower gaps.
    Narrow,
}

/// The rule: unreached is solid; what a ball reaches is air unless everything in sight shows its back;
/// what lies behind narrow gaps is air if it sees more fronts than backs.
fn is_solid(how: Reach, votes: Votes) -> bool {
    match how {
        Reach::Never => true,
        Reach::Wide => votes.fronts() == 0 && votes.backs() >= 2,
        Reach::Narrow => votes.backs() >= votes.fronts(),
    }
}

/// Marks which steps between samples cross a surface or leave the grid, and which samples lie outside.
fn closed_steps(room: &Surroundings, step: Step) -> Result<Vec<u8>, Stopped> {
    let grid = room.grid;
    let mut marks = vec![0_u8; grid.len()];
    let spans = [0, 1, 2].map(|a| grid.span(a, room.enclosure.min[a], room.enclosure.max[a]));
    let within =
        |axis: usize, at: usize| spans[axis].is_some_and(|(first, last)| (first..=last).contains(&at));
    let [nx, ny, nz] = grid.dim;
    marks.par_chunks_mut(nz).enumerate().try_for_each(|(row, marks)| {
        if row % ny == 0 {
            report(step, row / ny, nx)?;
        }
        let (x, y) = (row / ny, row % ny);
        let border = if x + 1 == nx { CLOSED[0] } else { 0 } | if y + 1 == ny { CLOSED[1] } else { 0 };
        let row_inside = within(0, x) && within(1, y);
        for (z, mark) in marks.iter_mut().enumerate() {
            let inside = row_inside && within(2, z) && room.indoors[x * nz + z];
            *mark = border | if inside { 0 } else { OUTSIDE };
        }
        marks[nz - 1] |= CLOSED[2];
        Ok(())
    })?;
    for (axis, lines) in room.lines.iter().enumerate() {
        lines.for_each(step, |u, v, crossings| {
            for crossing in crossings {
                let before = crossing.before();
                if before >= 0 && (before as usize) < grid.dim[axis] {
                    marks[grid.index(lines.sample(u, v, before as usize))] |= CLOSED[axis];
                }
            }
        })?;
    }
    Ok(marks)
}

/// Calls `visit` with every neighbour that an open step leads to. The last sample of every row is marked
/// closed, so a step can't wrap into the next row.
#[inline]
fn for_each_open(strides: [usize; 3], marks: &[u8], index: usize, mut visit: impl FnMut(usize)) {
    for axis in 0..3 {
        if marks[index] & CLOSED[axis] == 0 && marks[index + strides[axis]] & OUTSIDE == 0 {
            visit(index + strides[axis]);
        }
        if let Some(before) = index.checked_sub(strides[axis])
            && marks[before] & (CLOSED[axis] | OUTSIDE) == 0
        {
            visit(before);
        }
    }
}

/// Floods from standing room with a ball of [`BALL_M`], then lets the ball cover what it touches. Returns how
/// each sample is reached and the samples at which narrower gaps may begin.
fn flood_by_ball(
    room: &Surroundings,
    marks: &[u8],
    standing: Vec<u32>,
    step: Step,
) -> Result<(Vec<Reach>, Vec<u32>), Stopped> {
    let grid = room.grid;
    let strides = grid.strides();
    let mut reach = vec![Reach::Never; grid.len()];
    let mut queue = standing;
    queue.iter().for_each(|&index| reach[index as usize] = Reach::Wide);
    let mut shore: Vec<u32> = Vec::new();
    let mut pace = Pace::new(step, grid.len());
    while let Some(index) = queue.pop() {
        pace.item()?;
        let mut at_shore = false;
        for_each_open(strides, marks, index as usize, |next| {
            if reach[next] == Reach::Never {
                if room.distance_m[next] > BALL_M {
                    reach[next] = Reach::Wide;
                    queue.push(next as u32);
                } else {
                    at_shore = true;
                }
            }
        });
        if at_shore {
            shore.push(index);
        }
    }
    cover(grid, marks, &mut reach, &mut shore, step)?;
    Ok((reach, shore))
}

/// Lets balls at the `shore` cover the samples that they touch; those are added to the shore.
fn cover(
    grid: &Grid,
    marks: &[u8],
    reach: &mut [Reach],
    shore: &mut Vec<u32>,
    step: Step,
) -> Result<(), Stopped> {
    let mut pace = Pace::new(step, 0);
    let ball_m = BALL_M + grid.cell_m.max_element();
    let mut center: Vec<u32> = shore.clone();
    let mut next = 0;
    while next < shore.len() {
        pace.item()?;
        let from = grid.position(grid.place(center[next] as usize));
        for_each_open(grid.strides(), marks, shore[next] as usize, |neighbour| {
            if reach[neighbour] == Reach::Never
                && grid.position(grid.place(neighbour)).distance(from) <= ball_m
            {
                reach[neighbour] = Reach::Wide;
                shore.push(neighbour as u32);
                center.push(center[next]);
            }
        });
        next += 1;
    }
    Ok(())
}

/// Marks what air reaches from the shore only through narrow gaps.
fn flood_narrow(
    grid: &Grid,
    marks: &[u8],
    reach: &mut [Reach],
    shore: Vec<u32>,
    step: Step,
) -> Result<(), Stopped> {
    let mut queue = shore;
    let mut pace = Pace::new(step, 0);
    while let Some(index) = queue.pop() {
        pace.item()?;
        for_each_open(grid.strides(), marks, index as usize, |next| {
            if reach[next] == Reach::Never {
                reach[next] = Reach::Narrow;
                queue.push(next as u32);
            }
        });
    }
    Ok(())
}
