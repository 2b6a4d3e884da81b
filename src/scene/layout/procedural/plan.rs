//! What of a room's floor is taken: furniture, places kept free, and whether one can still walk everywhere.

use std::collections::VecDeque;

use glam::Vec2;

/// Spacing of the grid that walking is checked on.
const GRID_M: f32 = 0.1;
/// Half the width that somebody needs to pass, a little more than the walker of the distance field needs.
const PASS_M: f32 = 0.27;
/// Floor that nobody reaches: more than this share of the free floor is too much.
const LOST_SHARE: f32 = 0.04;
/// Air between things that stand beside each other.
pub const GAP_M: f32 = 0.02;

/// An upright rectangle in plan (x, z).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    pub min: Vec2,
    pub max: Vec2,
}

impl Rect {
    pub fn around(center: Vec2, size: Vec2) -> Self {
        Self { min: center - size * 0.5, max: center + size * 0.5 }
    }

    pub fn of(a: Vec2, b: Vec2) -> Self {
        Self { min: a.min(b), max: a.max(b) }
    }

    pub fn grown(self, by_m: f32) -> Self {
        Self { min: self.min - by_m, max: self.max + by_m }
    }

    pub fn meets(self, other: Self) -> bool {
        self.min.cmplt(other.max).all() && other.min.cmplt(self.max).all()
    }

    pub fn contains(self, p: Vec2) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    pub fn covers(self, other: Self) -> bool {
        self.contains(other.min) && self.contains(other.max)
    }

    pub fn center(self) -> Vec2 {
        (self.min + self.max) * 0.5
    }

    pub fn size(self) -> Vec2 {
        self.max - self.min
    }

    pub fn joined(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
}

/// A wall's inner line.
#[derive(Clone, Copy, Debug)]
pub struct WallLine {
    pub from: Vec2,
    /// Unit vector along it.
    pub along: Vec2,
    /// Unit vector into the room.
    pub inward: Vec2,
    pub length: f32,
}

/// Something at a wall over a stretch of it: from its start, up to a height.
#[derive(Clone, Copy, Debug)]
pub struct AtWall {
    pub wall: usize,
    pub from: f32,
    pub to: f32,
    /// It takes the wall from here ...
    pub bottom: f32,
    /// ... to here.
    pub top: f32,
}

/// The floor of a room with upright walls: a box, less a corner when it is L-shaped.
pub struct Plan {
    pub bounds: Rect,
    /// The missing corner of an L.
    pub cut: Option<Rect>,
    pub walls: Vec<WallLine>,
    pub solids: Vec<Rect>,
    /// Kept free of furniture: doors, the fronts of cupboards, where feet of sitters go.
    pub clear: Vec<Rect>,
    /// Before each door.
    pub doors: Vec<Vec2>,
    /// Where somebody must be able to walk.
    pub reach: Vec<Vec2>,
    pub at_walls: Vec<AtWall>,
}

impl Plan {
    pub fn new(bounds: Rect, cut: Option<Rect>, corners: &[Vec2]) -> Self {
        let n = corners.len();
        let wall = |i: usize| {
            let (a, b) = (corners[i], corners[(i + 1) % n]);
            let along = (b - a).normalize_or(Vec2::X);
            WallLine { from: a, along, inward: along.perp(), length: a.distance(b) }
        };
        Self {
            bounds,
            cut,
            walls: (0..n).map(wall).collect(),
            solids: Vec::new(),
            clear: Vec::new(),
            doors: Vec::new(),
            reach: Vec::new(),
            at_walls: Vec::new(),
        }
    }

    pub fn area_m2(&self) -> f32 {
        let cut = self.cut.map_or(0.0, |c| c.size().element_product());
        self.bounds.size().element_product() - cut
    }

    /// Whether the whole rectangle lies in the room.
    pub fn holds(&self, rect: Rect) -> bool {
        self.bounds.covers(rect) && !self.cut.is_some_and(|c| c.meets(rect))
    }

    /// Whether furniture may stand on the rectangle.
    pub fn is_free(&self, rect: Rect) -> bool {
        let near = rect.grown(GAP_M * 0.5);
        self.holds(rect)
            && !self.solids.iter().any(|s| s.meets(near))
            && !self.clear.iter().any(|c| c.meets(rect))
    }

    /// Whether the rectangle is floor without furniture, so that it can be kept free.
    pub fn can_stay_clear(&self, rect: Rect) -> bool {
        self.holds(rect) && !self.solids.iter().any(|s| s.meets(rect))
    }

    /// Whether from the first door nearly all free floor and every place that must be reached is reached.
    pub fn can_walk(&self) -> bool {
        let size = (self.bounds.size() / GRID_M).ceil();
        let (width, depth) = (size.x as usize, size.y as usize);
        let at = |i: usize| {
            let cell = Vec2::new((i / depth) as f32 + 0.5, (i % depth) as f32 + 0.5);
            self.bounds.min + cell * GRID_M
        };
        let inner = self.bounds.grown(-PASS_M);
        let cut = self.cut.map(|c| c.grown(PASS_M));
        let grown: Vec<Rect> = self.solids.iter().map(|s| s.grown(PASS_M)).collect();
        let free: Vec<bool> = (0..width * depth)
            .map(at)
            .map(|p| {
                inner.contains(p)
                    && !cut.is_some_and(|c| c.contains(p))
                    && !grown.iter().any(|s| s.contains(p))
            })
            .collect();
        let Some(start) = self.doors.first().and_then(|door| nearest(&free, at, *door, 0.6)) else {
            return false;
        };
        let reached = flood(&free, start, width, depth);
        let count = |cells: &[bool]| cells.iter().filter(|c| **c).count() as f32;
        let lost = 1.0 - count(&reached) / count(&free);
        let all = self.reach.iter().chain(&self.doors);
        lost < LOST_SHARE && all.into_iter().all(|p| nearest(&reached, at, *p, 0.4).is_some())
    }
}

/// The cell of `set` nearest to `p`, within a distance.
fn nearest(set: &[bool], at: impl Fn(usize) -> Vec2, p: Vec2, within_m: f32) -> Option<usize> {
    let away = |i: &usize| at(*i).distance_squared(p);
    let cells = (0..set.len()).filter(|i| set[*i] && away(i) < within_m * within_m);
    cells.min_by(|a, b| away(a).total_cmp(&away(b)))
}

fn flood(free: &[bool], start: usize, width: usize, depth: usize) -> Vec<bool> {
    let mut reached = vec![false; free.len()];
    let mut open = VecDeque::from([start]);
    reached[start] = true;
    while let Some(i) = open.pop_front() {
        let (x, z) = (i / depth, i % depth);
        let beside = [
            (x > 0).then(|| i - depth),
            (x + 1 < width).then(|| i + depth),
            (z > 0).then(|| i - 1),
            (z + 1 < depth).then(|| i + 1),
        ];
        for j in beside.into_iter().flatten() {
            if free[j] && !reached[j] {
                reached[j] = true;
                open.push_back(j);
            }
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room() -> Plan {
        let bounds = Rect::around(Vec2::ZERO, Vec2::new(4.0, 3.0));
        let corners = [(-2.0, -1.5), (2.0, -1.5), (2.0, 1.5), (-2.0, 1.5)].map(|(x, z)| Vec2::new(x, z));
        let mut plan = Plan::new(bounds, None, &corners);
        plan.doors.push(Vec2::new(-1.5, 1.0));
        plan
    }

    #[test]
    fn a_barrier_across_the_room_is_noticed_and_a_passage_through_it_too() {
        let mut plan = room();
        plan.solids.push(Rect::around(Vec2::ZERO, Vec2::new(0.6, 3.0)));
        assert!(!plan.can_walk());
        plan.solids[0] = Rect::around(Vec2::new(0.0, -0.4), Vec2::new(0.6, 2.2));
        assert!(plan.can_walk());
    }

    #[test]
    fn every_wall_looks_into_the_room() {
        for wall in room().walls {
            assert!(wall.inward.dot(-(wall.from + wall.along * wall.length * 0.5)) > 0.0);
        }
    }
}
