//! Guesses what a nameless thing is from its size and its level surfaces. Modest: better "furniture" than wrong.

use glam::Vec3;

use crate::math::Aabb;
use crate::scene::Category;

/// Height of one slice of a thing's level area.
const SLICE_M: f32 = 0.02;

/// What a thing looks like, in metres, Y up.
#[derive(Clone, Debug)]
pub struct Shape {
    pub bounds: Aabb,
    /// Level area by slice of height above the floor.
    level: Vec<f32>,
    /// Area of upright surfaces.
    upright: f32,
}

/// The room around a thing.
#[derive(Clone, Copy, Debug)]
pub struct Surrounding {
    pub bounds: Aabb,
    /// Height of the ceiling, or of the top of the walls.
    pub ceiling_m: f32,
}

impl Shape {
    /// The shape of triangles in the world frame.
    pub fn of(triangles: impl Iterator<Item = [Vec3; 3]>) -> Self {
        let mut shape = Self { bounds: Aabb::EMPTY, level: Vec::new(), upright: 0.0 };
        for [a, b, c] in triangles {
            shape.bounds = [a, b, c].into_iter().fold(shape.bounds, Aabb::include);
            let cross = (b - a).cross(c - a) * 0.5;
            let area = cross.length();
            if cross.y.abs() < 0.2 * area {
                shape.upright += area;
            } else if cross.y.abs() > 0.9 * area {
                let height = (a.y + b.y + c.y) / 3.0;
                // A room is lower than 20 m; what lies higher or under the floor is no furniture's surface.
                let slice = (height / SLICE_M).clamp(0.0, 1000.0) as usize;
                if shape.level.len() <= slice {
                    shape.level.resize(slice + 1, 0.0);
                }
                // A box's top counts whichever way it faces.
                shape.level[slice] += area;
            }
        }
        shape
    }

    /// Longer and shorter side of the ground plan.
    fn sides(&self) -> (f32, f32) {
        let size = self.bounds.size();
        (size.x.max(size.z), size.x.min(size.z))
    }

    fn footprint(&self) -> f32 {
        let (long, short) = self.sides();
        (long * short).max(1e-6)
    }

    /// Share of the ground plan that level surfaces between two heights cover.
    fn level_share(&self, from_m: f32, to_m: f32) -> f32 {
        let slice = |m: f32| ((m / SLICE_M) as usize).min(self.level.len());
        self.level[slice(from_m)..slice(to_m)].iter().sum::<f32>() / self.footprint()
    }

    /// Whether upright surfaces close it all around: a cabinet, not a table.
    fn is_closed(&self) -> bool {
        let (long, short) = self.sides();
        let around = 2.0 * (long + short) * self.bounds.size().y;
        self.upright > 0.6 * around
    }

    /// Slices with a surface over most of the ground plan.
    fn boards(&self) -> usize {
        let big = |w: &[f32]| w.iter().sum::<f32>() > 0.5 * self.footprint();
        self.level.windows(2).step_by(2).filter(|w| big(w)).count()
    }
}

/// What a thing of this shape most likely is.
pub fn category(shape: &Shape, around: &Surrounding) -> Category {
    structure(shape, around).or_else(|| on_wall_or_ceiling(shape, around)).unwrap_or_else(|| furniture(shape))
}

/// Floors, ceilings, walls, and the whole room in one.
fn structure(shape: &Shape, around: &Surrounding) -> Option<Category> {
    let (size, room) = (shape.bounds.size(), around.bounds.size());
    let (long, short) = shape.sides();
    let covers = shape.footprint() / (room.x * room.z).max(1e-6);
    let (bottom, top) = (shape.bounds.min.y, shape.bounds.max.y);
    if size.y < 0.06 && top < 0.12 && shape.footprint() > 0.4 || (covers > 0.3 && top < 0.25) {
        return Some(Category::Floor);
    }
    if covers > 0.3 && bottom > 0.75 * around.ceiling_m {
        return Some(Category::Ceiling);
    }
    // Skirting boards.
    if short < 0.06 && size.y < 0.3 && bottom.abs() < 0.1 && long > 0.15 {
        return Some(Category::Wall);
    }
    let high = size.y > 0.7 * around.ceiling_m.min(3.0);
    if high && short < 0.4 && long > 0.8 {
        return Some(Category::Wall);
    }
    if high && short > 2.5 && covers > 0.25 {
        // Walls around the room; with floor and furniture in it, it can't be said what it is.
        let level = shape.level_share(-1.0, around.ceiling_m + 1.0);
        return Some(if level < 0.2 { Category::Wall } else { Category::Unlabeled });
    }
    None
}

/// Pictures, windows and lamps.
fn on_wall_or_ceiling(shape: &Shape, around: &Surrounding) -> Option<Category> {
    let size = shape.bounds.size();
    let (long, short) = shape.sides();
    let (bottom, top) = (shape.bounds.min.y, shape.bounds.max.y);
    if top > around.ceiling_m - 0.15 && bottom > 1.4 && long < 1.6 {
        return Some(Category::Lighting);
    }
    let flat_on_wall = short < 0.12 && bottom > 0.5 && size.y > 0.15 && long > 0.15;
    flat_on_wall.then_some(Category::Picture)
}

/// What stands on the floor, by its level surfaces.
fn furniture(shape: &Shape) -> Category {
    let height = shape.bounds.size().y;
    let (top, bottom) = (shape.bounds.max.y, shape.bounds.min.y);
    let (long, short) = shape.sides();
    if bottom > 0.25 || long.max(height) < 0.35 {
        return Category::Objects;
    }
    let seat = shape.level_share(0.34, 0.56);
    let back_above = top > 0.62;
    if seat > 0.35 && (1.75..2.6).contains(&long) && short > 0.75 && top < 1.4 && short > 0.4 * long {
        if short > 1.15 || !back_above {
            return Category::Bed;
        }
        return Category::Sofa;
    }
    if seat > 0.3 && back_above && top < 1.35 {
        match (long, short) {
            (l, s) if l < 1.15 && s > 0.3 => return Category::Chair,
            (l, s) if l < 3.6 && s > 0.5 && s < 1.9 => return Category::Sofa,
            _ => {}
        }
    }
    surface_or_box(shape, long, short, height, top)
}

fn surface_or_box(shape: &Shape, long: f32, short: f32, height: f32, top: f32) -> Category {
    let top_share = shape.level_share(top - 0.06, top + 0.04);
    let closed = shape.is_closed();
    if top < 0.62 && top_share > 0.5 {
        return match (closed, long) {
            (_, l) if l < 0.6 && top > 0.38 => Category::Stool,
            (false, l) if l > 0.6 => Category::CoffeeTable,
            _ => Category::Furniture,
        };
    }
    let table_top = shape.level_share(0.68, 0.82);
    if table_top > 0.5 && !closed && top < 1.3 {
        return if long >= 1.1 && short >= 0.65 { Category::DiningTable } else { Category::Table };
    }
    if closed && shape.level_share(0.84, 0.98) > 0.5 && long > 0.9 && top < 1.4 {
        return Category::Counter;
    }
    if height > 0.6 && short > 0.15 && (closed || shape.boards() >= 4) {
        return if shape.boards() >= 5 { Category::Shelving } else { Category::Cabinet };
    }
    if top_share > 0.5 && top < 1.2 && !closed {
        return Category::Table;
    }
    if long.max(height) < 0.6 { Category::Objects } else { Category::Furniture }
}
