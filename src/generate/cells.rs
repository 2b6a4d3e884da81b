//! Coverage questions about one support surface: what is under a point, how far it goes in a direction.

use std::collections::HashMap;

use glam::{IVec2, Vec2, Vec3};

use super::place::flat;
use crate::scene::SupportSurface;

/// Side of the squares that cells are sorted into: wider than the support map's own columns.
const BIN_M: f32 = 0.05;
/// Step of walks over a surface.
const STEP_M: f32 = 0.025;

/// A support surface's cells, findable by place.
pub struct Cells {
    bins: HashMap<IVec2, f32>,
}

impl Cells {
    /// Sorts the cells of `surface`.
    pub fn new(surface: &SupportSurface) -> Self {
        Self::of_points(surface.cells.iter().map(|c| c.position))
    }

    /// Sorts any points, world frame; of points above each other the highest counts.
    pub fn of_points(points: impl Iterator<Item = Vec3>) -> Self {
        let mut bins = HashMap::new();
        for top in points {
            let height: &mut f32 = bins.entry(bin(flat(top))).or_insert(top.y);
            *height = height.max(top.y);
        }
        Self { bins }
    }

    /// Height of the surface at (x, z), if it is there.
    pub fn height_at(&self, p: Vec2) -> Option<f32> {
        self.bins.get(&bin(p)).copied()
    }

    /// The surface's point at (x, z), if it is there.
    pub fn point_at(&self, p: Vec2) -> Option<Vec3> {
        self.height_at(p).map(|y| Vec3::new(p.x, y, p.y))
    }

    /// How far the surface goes from `from` along `direction`, up to `most_m`; gaps of one step are bridged.
    pub fn extent(&self, from: Vec2, direction: Vec2, most_m: f32) -> f32 {
        let steps = (most_m / STEP_M) as usize;
        let mut last = 0;
        for i in 0..=steps {
            if self.height_at(from + direction * (i as f32 * STEP_M)).is_some() {
                last = i;
            } else if i > last + 2 {
                break;
            }
        }
        last as f32 * STEP_M
    }

    /// Share of a rectangle that the surface covers: `half` along `axis` and across it.
    pub fn coverage(&self, center: Vec2, axis: Vec2, half: Vec2) -> f32 {
        let across = axis.perp();
        let counts = (half / BIN_M).ceil().as_ivec2();
        let (mut covered, mut all) = (0, 0);
        for i in -counts.x..=counts.x {
            for j in -counts.y..=counts.y {
                let along = axis * (half.x * i as f32 / counts.x as f32);
                let aside = across * (half.y * j as f32 / counts.y as f32);
                all += 1;
                covered += usize::from(self.height_at(center + along + aside).is_some());
            }
        }
        covered as f32 / all.max(1) as f32
    }
}

fn bin(p: Vec2) -> IVec2 {
    (p / BIN_M).floor().as_ivec2()
}
