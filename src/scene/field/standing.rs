//! Where somebody could stand: coarse blocks with clearance all round, in regions of a room's size, over a floor.

use super::grid::Grid;
use super::lines::Lines;
use crate::scene::step::{Pace, Step, Stopped, report};

/// Edge of the blocks that are searched for standing room.
const BLOCK_M: f32 = 0.1;
/// Blocks that must be empty on every side of standing room: 0.2 m, half a person's width.
const CLEARANCE: usize = 2;
/// Standing room that is smaller than this share of the largest one is the inside of a piece of furniture.
const SMALLEST_ROOM: f32 = 0.02;
/// Share of a region's columns that must have a floor: outdoors has none.
const FLOORED: f32 = 0.3;

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

    fn len(&self) -> usize {
        self.dim.iter().product()
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.dim[1] + y) * self.dim[2] + z
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let rest = index / self.dim[2];
        [rest / self.dim[1], rest % self.dim[1], index % self.dim[2]]
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

    /// Calls `visit(block, first sample, samples)` for each row of samples in each block.
    fn for_each_row(
        &self,
        grid: &Grid,
        step: Step,
        mut visit: impl FnMut(usize, usize, usize),
    ) -> Result<(), Stopped> {
        for x in 0..grid.dim[0] {
            report(step, x, grid.dim[0])?;
            for y in 0..grid.dim[1] {
                let blocks = self.index([x / self.size[0], y / self.size[1], 0]);
                let row = grid.index([x, y, 0]);
                for z in 0..self.dim[2] {
                    let first = z * self.size[2];
                    visit(blocks + z, row + first, self.size[2].min(grid.dim[2] - first));
                }
            }
        }
        Ok(())
    }
}

/// Calls `mark` for every sample that lies in standing room. `marks` is 0 where a sample is inside the room
/// and none of its steps crosses a surface.
pub(super) fn for_each_standing(
    grid: &Grid,
    marks: &[u8],
    heights: &Lines,
    step: Step,
    mut mark: impl FnMut(usize),
) -> Result<(), Stopped> {
    let blocks = Blocks::new(grid);
    let mut occupied = vec![false; blocks.len()];
    blocks.for_each_row(grid, step, |block, first, count| {
        occupied[block] |= marks[first..first + count].iter().any(|&m| m != 0);
    })?;
    // A room crammed so full that nobody has 0.2 m around still has some air.
    let mut standing = Vec::new();
    for clearance in (0..=CLEARANCE).rev() {
        standing = room_sized_regions(&blocks, &grown(&blocks, &occupied, clearance, step)?, heights, step)?;
        if standing.contains(&true) {
            break;
        }
    }
    blocks.for_each_row(grid, step, |block, first, count| {
        if standing[block] {
            (first..first + count).for_each(&mut mark);
        }
    })
}

/// `occupied` grown by `by` blocks along each axis in turn.
fn grown(blocks: &Blocks, occupied: &[bool], by: usize, step: Step) -> Result<Vec<bool>, Stopped> {
    let mut now = occupied.to_vec();
    let mut pace = Pace::new(step, 3 * now.len());
    for axis in 0..3 {
        let before = now.clone();
        let stride = [blocks.dim[1] * blocks.dim[2], blocks.dim[2], 1][axis];
        for (index, cell) in now.iter_mut().enumerate() {
            pace.item()?;
            let at = blocks.place(index)[axis];
            let (low, high) = (at.saturating_sub(by), (at + by).min(blocks.dim[axis] - 1));
            *cell = (low..=high).any(|i| before[index + i * stride - at * stride]);
        }
    }
    Ok(now)
}

/// Connected regions of free blocks that are not tiny and have a floor; if none has one, the largest.
fn room_sized_regions(
    blocks: &Blocks,
    tight: &[bool],
    heights: &Lines,
    step: Step,
) -> Result<Vec<bool>, Stopped> {
    let mut regions = connected(blocks, tight, step)?;
    regions.sort_by_key(|region| (std::cmp::Reverse(region.len()), region[0]));
    let floored: Vec<&Vec<usize>> =
        regions.iter().filter(|region| floored_share(blocks, region, heights) >= FLOORED).collect();
    let rooms = if floored.is_empty() { regions.iter().take(1).collect() } else { floored };
    let largest = rooms.first().map_or(0, |region| region.len()) as f32;
    let mut standing = vec![false; tight.len()];
    for region in rooms.iter().filter(|region| region.len() as f32 >= SMALLEST_ROOM * largest) {
        region.iter().for_each(|&block| standing[block] = true);
    }
    Ok(standing)
}

fn connected(blocks: &Blocks, tight: &[bool], step: Step) -> Result<Vec<Vec<usize>>, Stopped> {
    let mut seen = tight.to_vec();
    let mut pace = Pace::new(step, seen.len());
    let mut regions = Vec::new();
    for start in 0..seen.len() {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let mut region = vec![start];
        let mut next = 0;
        while next < region.len() {
            pace.item()?;
            for n in blocks.neighbours(region[next]) {
                if !std::mem::replace(&mut seen[n], true) {
                    region.push(n);
                }
            }
            next += 1;
        }
        regions.push(region);
    }
    Ok(regions)
}

/// Share of the region's columns that have a surface beneath.
fn floored_share(blocks: &Blocks, region: &[usize], heights: &Lines) -> f32 {
    let mut lowest = vec![usize::MAX; blocks.dim[0] * blocks.dim[2]];
    for &block in region {
        let [x, y, z] = blocks.place(block);
        let column = &mut lowest[x * blocks.dim[2] + z];
        *column = y.min(*column);
    }
    let columns = lowest.iter().enumerate().filter(|&(_, &y)| y != usize::MAX);
    let (mut all, mut floored) = (0_usize, 0_usize);
    for (column, y) in columns {
        let line =
            heights.line(column / blocks.dim[2] * blocks.size[0], column % blocks.dim[2] * blocks.size[2]);
        all += 1;
        floored += usize::from(line.first().is_some_and(|c| c.before() < (y * blocks.size[1]) as isize));
    }
    floored as f32 / all.max(1) as f32
}
