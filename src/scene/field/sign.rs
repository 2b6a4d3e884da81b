//! What is free space and what is solid: the sign rule. See `bake` for the reasoning.

use std::collections::HashMap;
use std::collections::VecDeque;

use glam::Vec3;
use rayon::prelude::*;

use super::grid::Grid;
use super::lines::{Crossing, Lines};
use crate::math::Aabb;
use crate::scene::bvh::{Step, Stopped, report};

/// Air that cannot be reached through openings at least twice as wide is doubtful: holes of scans and gaps
/// between parts of furniture are smaller, passages for people larger.
const BALL_M: f32 = 0.05;
/// Edge of the blocks that are searched for standing room.
const BLOCK_M: f32 = 0.1;
/// Blocks that must be empty on every side of standing room: 0.2 m, half a person's width.
const BLOCK_CLEARANCE: usize = 2;
/// Standing room that is smaller than this share of the largest one is the inside of a piece of furniture.
const SMALLEST_ROOM: f32 = 0.02;
/// Share of a room's floor that must exist for a second room to count: outdoors and cavities have none.
const FLOORED: f32 = 0.3;
/// A surface has a front if standing air sees one side in at least this share of the views.
const ONE_SIDED: f32 = 0.8;

const BLOCKED: [u8; 3] = [1, 2, 4];
const OUTSIDE: u8 = 8;

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
}

/// Whether each sample is solid.
pub(super) fn classify(room: &Surroundings, step: Step) -> Result<Vec<bool>, Stopped> {
    let marks = mark_blocked(room);
    report(step, 1, 6)?;
    let standing = standing_room(room, &marks);
    report(step, 2, 6)?;
    let fronts = fronts_seen(room, &standing);
    report(step, 3, 6)?;
    let mut reach = flood_by_ball(room, &marks, &standing);
    report(step, 4, 6)?;
    flood_narrow(room, &marks, &mut reach);
    report(step, 5, 6)?;
    let votes = facing_votes(room, &fronts);
    let solid = reach.par_iter().zip(&votes).map(|(&how, &votes)| is_solid(how, votes));
    Ok(solid.collect())
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

/// Of the surfaces seen along ±x, ±z and up: how many show their fronts, how many their backs.
#[derive(Clone, Copy, Debug, Default)]
struct Votes {
    front: u8,
    back: u8,
}

/// The rule: unreached is solid; what a ball reaches is air unless everything in sight shows its back;
/// what lies behind narrow gaps is air if it sees more fronts than backs.
fn is_solid(how: Reach, votes: Votes) -> bool {
    match how {
        Reach::Never => true,
        Reach::Wide => votes.front == 0 && votes.back >= 2,
        Reach::Narrow => votes.back >= votes.front,
    }
}

fn mark_blocked(room: &Surroundings) -> Vec<u8> {
    let grid = room.grid;
    let mut marks = vec![0_u8; grid.len()];
    let plane = grid.dim[1] * grid.dim[2];
    marks.par_chunks_mut(plane).enumerate().for_each(|(x, plane)| {
        for (i, mark) in plane.iter_mut().enumerate() {
            if !room.enclosure.contains(grid.position([x, i / grid.dim[2], i % grid.dim[2]])) {
                *mark = OUTSIDE;
            }
        }
    });
    for (axis, lines) in room.lines.iter().enumerate() {
        lines.for_each(|u, v, crossings| {
            for crossing in crossings {
                let before = crossing.before();
                if before >= 0 && (before as usize) < grid.dim[axis] {
                    let place = on_line(lines, u, v, before as usize);
                    marks[grid.index(place)] |= BLOCKED[axis];
                }
            }
        });
    }
    marks
}

fn on_line(lines: &Lines, u: usize, v: usize, along: usize) -> [usize; 3] {
    let mut place = [along; 3];
    place[lines.across[0]] = u;
    place[lines.across[1]] = v;
    place
}

/// Coarse blocks of samples.
struct Blocks {
    size: [usize; 3],
    dim: [usize; 3],
}

impl Blocks {
    fn new(grid: &Grid) -> Self {
        let size: [usize; 3] = std::array::from_fn(|a| ((BLOCK_M / grid.cell_m[a]).round() as usize).max(1));
        Self { size, dim: std::array::from_fn(|a| grid.dim[a].div_ceil(size[a])) }
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.dim[1] + y) * self.dim[2] + z
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let rest = index / self.dim[2];
        [rest / self.dim[1], rest % self.dim[1], index % self.dim[2]]
    }

    fn of_sample(&self, place: [usize; 3]) -> usize {
        self.index(std::array::from_fn(|a| place[a] / self.size[a]))
    }

    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        let place = self.place(index);
        (0..6).filter_map(move |side| {
            let mut next = place;
            let axis = side / 2;
            next[axis] = if side % 2 == 0 { place[axis].checked_sub(1)? } else { place[axis] + 1 };
            (next[axis] < self.dim[axis]).then(|| self.index(next))
        })
    }
}

/// Samples where somebody could be: blocks with clearance all round, in regions of a room's size.
struct Standing {
    blocks: Blocks,
    /// Per block.
    is_standing: Vec<bool>,
}

impl Standing {
    fn at(&self, place: [usize; 3]) -> bool {
        self.is_standing[self.blocks.of_sample(place)]
    }
}

fn standing_room(room: &Surroundings, marks: &[u8]) -> Standing {
    let blocks = Blocks::new(room.grid);
    let mut occupied = vec![false; blocks.dim.iter().product()];
    for (index, &mark) in marks.iter().enumerate() {
        if mark != 0 {
            occupied[blocks.of_sample(room.grid.place(index))] = true;
        }
    }
    for clearance in (0..=BLOCK_CLEARANCE).rev() {
        let tight = grown(&blocks, &occupied, clearance);
        let is_standing = room_sized_regions(room, &blocks, &tight);
        if is_standing.contains(&true) {
            return Standing { blocks, is_standing };
        }
    }
    let nowhere = vec![false; occupied.len()];
    Standing { blocks, is_standing: nowhere }
}

/// `occupied` grown by `by` blocks along each axis in turn.
fn grown(blocks: &Blocks, occupied: &[bool], by: usize) -> Vec<bool> {
    let mut now = occupied.to_vec();
    for axis in 0..3 {
        let before = now.clone();
        let stride = [blocks.dim[1] * blocks.dim[2], blocks.dim[2], 1][axis];
        for (index, cell) in now.iter_mut().enumerate() {
            let at = blocks.place(index)[axis];
            let (low, high) = (at.saturating_sub(by), (at + by).min(blocks.dim[axis] - 1));
            *cell = (low..=high).any(|i| before[index + i * stride - at * stride]);
        }
    }
    now
}

/// Connected regions of free blocks that are as large as a room: the largest, and every other that is not
/// tiny and has a floor.
fn room_sized_regions(room: &Surroundings, blocks: &Blocks, tight: &[bool]) -> Vec<bool> {
    let mut seen = tight.to_vec();
    let mut regions: Vec<Vec<usize>> = Vec::new();
    for start in 0..seen.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let mut region = vec![start];
        let mut next = 0;
        while next < region.len() {
            for n in blocks.neighbours(region[next]) {
                if !std::mem::replace(&mut seen[n], true) {
                    region.push(n);
                }
            }
            next += 1;
        }
        regions.push(region);
    }
    regions.sort_by_key(|r| (std::cmp::Reverse(r.len()), r[0]));
    let largest = regions.first().map_or(0, Vec::len) as f32;
    let mut standing = vec![false; tight.len()];
    for (rank, region) in regions.iter().enumerate() {
        let large = region.len() as f32 >= SMALLEST_ROOM * largest;
        if rank == 0 || (large && floored_share(room, blocks, region) >= FLOORED) {
            region.iter().for_each(|&b| standing[b] = true);
        }
    }
    standing
}

/// Share of the region's columns that have a surface beneath.
fn floored_share(room: &Surroundings, blocks: &Blocks, region: &[usize]) -> f32 {
    let mut columns: HashMap<[usize; 2], usize> = HashMap::new();
    for &block in region {
        let [x, y, z] = blocks.place(block);
        let lowest = columns.entry([x, z]).or_insert(y);
        *lowest = y.min(*lowest);
    }
    let floored = columns.iter().filter(|&(&[x, z], &y)| {
        let line = room.lines[1].line(x * blocks.size[0], z * blocks.size[2]);
        line.first().is_some_and(|c| c.before() < (y * blocks.size[1]) as isize)
    });
    floored.count() as f32 / columns.len().max(1) as f32
}

/// For every triangle which side is its front: +1 the side of its normal, -1 the other, 0 unknown or both.
/// The front is what standing air sees; all triangles of a connected surface share it.
fn fronts_seen(room: &Surroundings, standing: &Standing) -> Vec<i8> {
    let (surface_of, surfaces) = connected_surfaces(room.triangles);
    let mut seen = vec![(0_u32, 0_u32); surfaces];
    for (axis, lines) in room.lines.iter().enumerate() {
        lines.for_each(|u, v, crossings| {
            let mut look = |crossing: &Crossing, from_above: bool| {
                let views = &mut seen[surface_of[crossing.triangle as usize] as usize];
                if crossing.along == from_above { views.0 += 1 } else { views.1 += 1 }
            };
            for_each_gap(crossings, room.grid.dim[axis], |first, last, below, above| {
                if (first..=last).any(|i| standing.at(on_line(lines, u, v, i))) {
                    below.iter().for_each(|c| look(c, true));
                    above.iter().for_each(|c| look(c, false));
                }
            });
        });
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
    surface_of.iter().map(|&s| fronts[s as usize]).collect()
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
fn connected_surfaces(triangles: &[[Vec3; 3]]) -> (Vec<u32>, usize) {
    let mut parent: Vec<u32> = (0..triangles.len() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut corners: Vec<([u32; 3], u32)> = triangles
        .iter()
        .enumerate()
        // Adding 0.0 makes -0.0 and 0.0 the same place.
        .flat_map(|(t, c)| c.map(|p| ((p + Vec3::ZERO).to_array().map(f32::to_bits), t as u32)))
        .collect();
    corners.par_sort_unstable();
    for pair in corners.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (a, b) = (root(&mut parent, pair[0].1), root(&mut parent, pair[1].1));
        parent[a.max(b) as usize] = a.min(b);
    }
    let mut number = vec![u32::MAX; triangles.len()];
    let mut count = 0;
    let surface_of = (0..triangles.len() as u32)
        .map(|t| {
            let r = root(&mut parent, t) as usize;
            if number[r] == u32::MAX {
                number[r] = count;
                count += 1;
            }
            number[r]
        })
        .collect();
    (surface_of, count as usize)
}

/// Whether the step from sample `index` to its neighbour on `side` (-x +x -y +y -z +z) is free, and to where.
#[inline]
fn stepped(grid: &Grid, marks: &[u8], index: usize, place: [usize; 3], side: usize) -> Option<usize> {
    let axis = side / 2;
    let stride = grid.strides()[axis];
    let (next, gate) = if side % 2 == 0 {
        (place[axis] > 0).then(|| (index - stride, index - stride))?
    } else {
        (place[axis] + 1 < grid.dim[axis]).then_some((index + stride, index))?
    };
    (marks[gate] & BLOCKED[axis] == 0 && marks[next] & OUTSIDE == 0).then_some(next)
}

/// Floods from standing room with a ball of [`BALL_M`], then lets the ball cover what it touches.
fn flood_by_ball(room: &Surroundings, marks: &[u8], standing: &Standing) -> Vec<Reach> {
    let grid = room.grid;
    let mut reach = vec![Reach::Never; grid.len()];
    let clear = |index: usize| room.distance_m[index] > BALL_M && marks[index] & OUTSIDE == 0;
    let mut queue: Vec<u32> = Vec::new();
    for index in 0..grid.len() {
        if clear(index) && standing.at(grid.place(index)) {
            reach[index] = Reach::Wide;
            queue.push(index as u32);
        }
    }
    let mut shore = VecDeque::new();
    while let Some(index) = queue.pop() {
        let index = index as usize;
        let place = grid.place(index);
        let mut at_shore = false;
        for next in (0..6).filter_map(|side| stepped(grid, marks, index, place, side)) {
            if reach[next] != Reach::Never {
                continue;
            }
            if clear(next) {
                reach[next] = Reach::Wide;
                queue.push(next as u32);
            } else {
                at_shore = true;
            }
        }
        if at_shore {
            shore.push_back((index as u32, index as u32));
        }
    }
    let ball_m = BALL_M + grid.cell_m.max_element();
    while let Some((index, source)) = shore.pop_front() {
        let index = index as usize;
        let center = grid.position(grid.place(source as usize));
        for next in (0..6).filter_map(|side| stepped(grid, marks, index, grid.place(index), side)) {
            let covered = grid.position(grid.place(next)).distance(center) <= ball_m;
            if reach[next] == Reach::Never && covered {
                reach[next] = Reach::Wide;
                shore.push_back((next as u32, source));
            }
        }
    }
    reach
}

/// Marks what air reaches only through narrow gaps.
fn flood_narrow(room: &Surroundings, marks: &[u8], reach: &mut [Reach]) {
    let grid = room.grid;
    let mut queue: Vec<u32> = Vec::new();
    for index in 0..grid.len() {
        if reach[index] == Reach::Wide {
            queue.push(index as u32);
        }
    }
    while let Some(index) = queue.pop() {
        let index = index as usize;
        let place = grid.place(index);
        for next in (0..6).filter_map(|side| stepped(grid, marks, index, place, side)) {
            if reach[next] == Reach::Never {
                reach[next] = Reach::Narrow;
                queue.push(next as u32);
            }
        }
    }
}

/// What every sample sees along ±x, ±z and up.
fn facing_votes(room: &Surroundings, fronts: &[i8]) -> Vec<Votes> {
    let grid = room.grid;
    let mut votes = vec![Votes::default(); grid.len()];
    let plane = grid.dim[1] * grid.dim[2];
    let side = |crossing: Option<&Crossing>, from_above: bool| -> i8 {
        crossing.map_or(0, |c| {
            let front = fronts[c.triangle as usize];
            if c.along == from_above { front } else { -front }
        })
    };
    votes.par_chunks_mut(plane).enumerate().for_each(|(x, votes)| {
        let mut cast = |index: usize, vote: i8| match vote {
            1 => votes[index].front += 1,
            -1 => votes[index].back += 1,
            _ => (),
        };
        for y in 0..grid.dim[1] {
            for_each_gap(room.lines[2].line(x, y), grid.dim[2], |first, last, below, above| {
                for z in first..=last {
                    cast(y * grid.dim[2] + z, side(below, true));
                    cast(y * grid.dim[2] + z, side(above, false));
                }
            });
        }
        for z in 0..grid.dim[2] {
            for_each_gap(room.lines[1].line(x, z), grid.dim[1], |first, last, _, above| {
                for y in first..=last {
                    cast(y * grid.dim[2] + z, side(above, false));
                }
            });
        }
        for y in 0..grid.dim[1] {
            for z in 0..grid.dim[2] {
                let line = room.lines[0].line(y, z);
                let after = line.partition_point(|c| c.before() < x as isize);
                let below = after.checked_sub(1).map(|i| &line[i]);
                cast(y * grid.dim[2] + z, side(below, true));
                cast(y * grid.dim[2] + z, side(line.get(after), false));
            }
        }
    });
    votes
}
