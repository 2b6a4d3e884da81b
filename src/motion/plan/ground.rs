//! The floor as one planner's question sees it: where it is free, what walking there costs, and the cheapest way.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec2;

use super::{APRON_M, Disc, Planner, Spot};
use crate::scene::{WalkableFloor, direction_of};

/// Right before furniture knees and feet need at least this, metres.
const KNEES_M: f32 = 0.05;
/// Spacing at which straight lines are looked at, metres.
const SAMPLE_M: f32 = 0.025;
/// A metre with no room to spare costs this many metres of comfortable way.
const TIGHT: f32 = 4.0;
/// A straight line may cost this much more than the path along the grid that it replaces: grid paths are too long.
const STRAIGHTER: f32 = 1.005;
/// A spot that is walked through is entered and left straight over this length, metres.
const STRAIGHT_M: f32 = 0.3;

/// The floor for people who need `least` of clearance.
pub(super) struct Ground<'a> {
    floor: &'a WalkableFloor,
    body_m: f32,
    comfort_m: f32,
    aprons: [Option<Vec2>; 2],
    others: &'a [Disc],
}

/// A cell in the queue: the least estimate first, then the least number, so that ties break the same way always.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Queued {
    estimate_bits: Reverse<u32>,
    cell: Reverse<usize>,
}

impl<'a> Ground<'a> {
    /// The ground between two spots.
    pub fn new(planner: &Planner<'a>, body_m: f32, ends: [&Spot; 2], others: &'a [Disc]) -> Self {
        let aprons = ends.map(|spot| spot.beside.then_some(spot.at));
        Self { floor: planner.floor(), body_m, comfort_m: planner.config.comfort_m, aprons, others }
    }

    /// The height of the floor below (x, z), metres.
    pub fn height_m(&self, xz: Vec2) -> f32 {
        self.floor.cell_at(xz).map_or(0.0, |cell| self.floor.height_m[cell])
    }

    /// Horizontal distance from (x, z) to what a standing person would touch, metres.
    pub fn clearance_m(&self, xz: Vec2) -> f32 {
        let others = self.others.iter().map(|d| d.at.distance(xz) - d.radius_m);
        others.fold(self.floor.clearance_at(xz), f32::min).max(0.0)
    }

    /// Clearance that is needed at (x, z), metres.
    pub fn least_m(&self, xz: Vec2) -> f32 {
        let near = self.aprons.iter().flatten().map(|at| at.distance(xz)).fold(f32::INFINITY, f32::min);
        // The nearer to the furniture the less of the body's width stands beside it.
        let share = (near / APRON_M).clamp(0.0, 1.0);
        KNEES_M + (self.body_m - KNEES_M) * share
    }

    /// Whether somebody fits at (x, z).
    pub fn is_free(&self, xz: Vec2) -> bool {
        self.clearance_m(xz) >= self.least_m(xz)
    }

    /// What a metre of way costs at (x, z), in metres of comfortable way; `None` where nobody fits.
    fn price(&self, xz: Vec2) -> Option<f32> {
        let (clearance, least) = (self.clearance_m(xz), self.least_m(xz));
        if clearance < least {
            return None;
        }
        let spare = ((clearance - least) / (self.comfort_m - least).max(1e-3)).clamp(0.0, 1.0);
        Some(1.0 + (TIGHT - 1.0) * (1.0 - spare) * (1.0 - spare))
    }

    /// What a straight line costs; `None` where it is not free.
    fn line_cost(&self, from: Vec2, to: Vec2) -> Option<f32> {
        let length = from.distance(to);
        let steps = (length / SAMPLE_M).ceil().max(1.0) as usize;
        let mut sum = 0.0;
        for i in 0..=steps {
            sum += self.price(from.lerp(to, i as f32 / steps as f32))?;
        }
        Some(length * sum / (steps + 1) as f32)
    }

    /// Whether everything on a straight line is free.
    pub fn line_is_free(&self, from: Vec2, to: Vec2) -> bool {
        self.line_cost(from, to).is_some()
    }

    /// Corners of the cheapest way, ends included.
    pub fn path(&self, from: &Spot, to: &Spot) -> Option<Vec<Vec2>> {
        let lead = |spot: &Spot, sign: f32| {
            let out = spot.at + sign * STRAIGHT_M * direction_of(spot.heading?);
            self.line_is_free(spot.at, out).then_some(out)
        };
        let (out, into) = (lead(from, 1.0), lead(to, -1.0));
        let mut corners = self.corners(out.unwrap_or(from.at), into.unwrap_or(to.at))?;
        if out.is_some() {
            corners.insert(0, from.at);
        }
        if into.is_some() {
            corners.push(to.at);
        }
        Some(corners)
    }

    fn corners(&self, from: Vec2, to: Vec2) -> Option<Vec<Vec2>> {
        if let Some(cost) = self.line_cost(from, to)
            && cost <= 1.02 * from.distance(to)
        {
            return Some(vec![from, to]);
        }
        let cells = self.cheapest_cells(from, to)?;
        let inner = cells.len().saturating_sub(2);
        let mut points = vec![from];
        points.extend(cells.into_iter().skip(1).take(inner).map(|cell| self.middle(cell)));
        points.push(to);
        Some(self.pulled(&points))
    }

    fn middle(&self, cell: usize) -> Vec2 {
        super::flat(self.floor.position(cell))
    }

    /// A* over the cells (Hart, Nilsson and Raphael 1968).
    fn cheapest_cells(&self, from: Vec2, to: Vec2) -> Option<Vec<usize>> {
        let (start, goal) = (self.floor.cell_at(from)?, self.floor.cell_at(to)?);
        let count = self.floor.area.len();
        let mut cost = vec![f32::INFINITY; count];
        let mut before = vec![usize::MAX; count];
        let mut done = vec![false; count];
        let estimate = |cell: usize, cost: f32| cost + self.middle(cell).distance(self.middle(goal));
        let queued = |cell: usize, cost: f32| Queued {
            // Costs are not negative, so their bits sort as they do.
            estimate_bits: Reverse(estimate(cell, cost).to_bits()),
            cell: Reverse(cell),
        };
        let mut queue = BinaryHeap::from([queued(start, 0.0)]);
        cost[start] = 0.0;
        while let Some(Queued { cell: Reverse(cell), .. }) = queue.pop() {
            if cell == goal {
                return Some(chain(&before, start, goal));
            }
            if std::mem::replace(&mut done[cell], true) {
                continue;
            }
            for (next, step_m) in self.neighbours(cell) {
                let end = next == goal || next == start;
                let Some(price) = self.price(self.middle(next)).or(end.then_some(TIGHT)) else { continue };
                let through = cost[cell] + step_m * price;
                if through < cost[next] {
                    (cost[next], before[next]) = (through, cell);
                    queue.push(queued(next, through));
                }
            }
        }
        None
    }

    /// The eight cells around one, with their distances in metres.
    fn neighbours(&self, cell: usize) -> impl Iterator<Item = (usize, f32)> + use<> {
        let [nx, nz] = self.floor.dim;
        let (x, z) = ((cell / nz) as isize, (cell % nz) as isize);
        let cell_m = self.floor.cell_m;
        (-1..=1).flat_map(move |dx: isize| {
            (-1..=1).filter_map(move |dz: isize| {
                let (x, z) = (x + dx, z + dz);
                let inside = x >= 0 && z >= 0 && x < nx as isize && z < nz as isize;
                let step_m = cell_m * ((dx * dx + dz * dz) as f32).sqrt();
                (inside && (dx, dz) != (0, 0)).then_some((x as usize * nz + z as usize, step_m))
            })
        })
    }

    /// The path pulled straight wherever that costs no more than the path itself.
    fn pulled(&self, points: &[Vec2]) -> Vec<Vec2> {
        let mut cost = vec![0.0; points.len()];
        for i in 1..points.len() {
            let step = self.line_cost(points[i - 1], points[i]);
            cost[i] = cost[i - 1] + step.unwrap_or(TIGHT * points[i - 1].distance(points[i]));
        }
        let mut corners = vec![points[0]];
        let mut at = 0;
        while at + 1 < points.len() {
            let along = |to: usize| STRAIGHTER * (cost[to] - cost[at]);
            let straight =
                |to: &usize| self.line_cost(points[at], points[*to]).is_some_and(|c| c <= along(*to));
            at = (at + 2..points.len()).rev().find(straight).unwrap_or(at + 1);
            corners.push(points[at]);
        }
        corners
    }
}

fn chain(before: &[usize], start: usize, goal: usize) -> Vec<usize> {
    let mut cells = vec![goal];
    let mut at = goal;
    while at != start {
        at = before[at];
        cells.push(at);
    }
    cells.reverse();
    cells
}
