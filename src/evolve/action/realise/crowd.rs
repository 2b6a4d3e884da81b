//! Where on a surface a thing surely has no place because others stand there, told for whole squares at once. Says
//! nothing that [`World::is_plainly_taken`] would not say of every place of the square, only sooner; what it does not
//! call taken must still be looked at.

use std::collections::BTreeMap;

use glam::{Quat, Vec2, Vec3};

use super::placing::{CORES, TRIED_ABOVE_M};
use super::world::{Item, Lifted, Pose, World, flat};
use crate::math::Aabb;

/// Side of a square, metres: a fraction of the smallest things that fill a table.
const SQUARE_M: f32 = 0.02;
/// What rounding may do to a distance, metres.
const ROUNDING_M: f32 = 1e-4;
/// More squares than this along a side are not told apart: nothing is called taken on surfaces that large.
const MOST: usize = 1024;

/// The places that one thing, turned as it is, surely can't have. The world must not change meanwhile.
pub struct Crowd<'a> {
    world: &'a World,
    item: &'a Item,
    lifted: &'a Lifted,
    surfaces: BTreeMap<usize, Asked>,
}

/// How often a surface was asked for before its squares are gone over: that costs as much as some places.
const ASKED_FIRST: usize = 24;

/// What is known of one surface.
enum Asked {
    Times(usize),
    Known(Squares),
}

/// Squares of one surface.
struct Squares {
    origin: Vec2,
    dim: [usize; 2],
    taken: Vec<bool>,
}

impl<'a> Crowd<'a> {
    /// Of a thing among all but the lifted ones.
    pub fn around(world: &'a World, item: &'a Item, lifted: &'a Lifted) -> Self {
        Self { world, item, lifted, surfaces: BTreeMap::new() }
    }

    /// Whether the place is surely taken. A surface is gone over once it was asked for some times.
    pub fn has_taken(&mut self, surface: usize, at: Vec2) -> bool {
        match self.surfaces.entry(surface).or_insert(Asked::Times(0)) {
            Asked::Known(squares) => squares.is_taken(at),
            Asked::Times(times) if *times < ASKED_FIRST => {
                *times += 1;
                false
            }
            unknown @ Asked::Times(_) => {
                let squares = taken(self.world, self.item, self.lifted, surface);
                let is_taken = squares.is_taken(at);
                *unknown = Asked::Known(squares);
                is_taken
            }
        }
    }
}

impl Squares {
    fn is_taken(&self, at: Vec2) -> bool {
        let square = ((at - self.origin) / SQUARE_M).floor();
        let inside = square.cmpge(Vec2::ZERO).all();
        let [x, z] = [square.x as usize, square.y as usize];
        inside && x < self.dim[0] && z < self.dim[1] && self.taken[x * self.dim[1] + z]
    }

    /// Marks the squares that lie wholly within a circle.
    fn mark(&mut self, middle: Vec2, radius_m: f32) {
        let within_m = radius_m - ROUNDING_M - SQUARE_M * std::f32::consts::FRAC_1_SQRT_2;
        if within_m <= 0.0 {
            return;
        }
        let square = |at: f32, from: f32| ((at - from) / SQUARE_M).floor();
        let range = |axis: usize| {
            let (low, high) = (middle[axis] - within_m, middle[axis] + within_m);
            let from = square(low, self.origin[axis]).max(0.0) as usize;
            let to = square(high, self.origin[axis]).min(self.dim[axis] as f32 - 1.0);
            from..(to + 1.0).max(0.0) as usize
        };
        let (across, along) = (range(0), range(1));
        for x in across {
            for z in along.clone() {
                let centre = self.origin + (Vec2::new(x as f32, z as f32) + 0.5) * SQUARE_M;
                if centre.distance_squared(middle) < within_m * within_m {
                    self.taken[x * self.dim[1] + z] = true;
                }
            }
        }
    }
}

/// The squares of a surface in which the thing's middle is in the middle of another, whatever the height of the
/// surface there.
fn taken(world: &World, item: &Item, lifted: &Lifted, surface: usize) -> Squares {
    let surface = &world.stage.surfaces[surface];
    let extent = Aabb::of(surface.cells.iter().map(|c| c.0)).grown(surface.cell_m);
    let size = flat(extent.max - extent.min) / SQUARE_M;
    if surface.cells.is_empty() || size.max_element() > MOST as f32 {
        return Squares { origin: Vec2::ZERO, dim: [0; 2], taken: Vec::new() };
    }
    let dim = [size.x as usize + 1, size.y as usize + 1];
    let mut squares = Squares { origin: flat(extent.min), dim, taken: vec![false; dim[0] * dim[1]] };
    let shape = &item.shape;
    let (lowest_m, highest_m) = (extent.min.y + surface.cell_m, extent.max.y - surface.cell_m);
    let foot_m = highest_m + TRIED_ABOVE_M + shape.bounds.min.y + ROUNDING_M;
    let head_m = lowest_m + TRIED_ABOVE_M + shape.bounds.max.y - ROUNDING_M;
    let offset = Pose::upright(Vec3::ZERO, item.pose.yaw_rad).plan(shape.middle);
    let around = Aabb { min: extent.min - Vec3::splat(10.0), max: extent.max + Vec3::splat(10.0) };
    for other in world.any_near(&around).filter(|other| !lifted.contains(&other.id)) {
        let level = other.bounds.min.y <= head_m && other.bounds.max.y >= foot_m;
        if level && other.pose.lean == Quat::IDENTITY {
            let middle = other.pose.plan(other.shape.middle) - offset;
            squares.mark(middle, CORES * (other.shape.core_m + shape.core_m));
        }
    }
    squares
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::super::placing::{Avoid, Onto};
    use super::super::world::tests::world;
    use super::*;
    use crate::scene::ObjectId;

    #[test]
    fn what_a_crowd_has_taken_is_plainly_taken_and_what_is_lifted_takes_nothing() {
        let mut world = world();
        let table = world.stage.work_surface(ObjectId(1)).expect("the table has a top");
        let first = world.item(ObjectId(2)).expect("the box").clone();
        // A dozen boxes on the table, turned.
        for i in 0..12_u32 {
            let id = ObjectId(10 + i);
            let at = Vec3::new(-0.5 + 0.09 * i as f32, 0.75, if i % 2 == 0 { 0.2 } else { -0.25 });
            let mut another = (*first).clone();
            another.id = id;
            world.restore(Arc::new(another));
            let pose = Pose::upright(at, 0.3 * i as f32);
            world.put(id, &super::super::placing::Rest { pose, share: 1.0, held: first.held });
        }
        let moving = world.item(ObjectId(2)).expect("the box").clone();
        let lifted = Lifted::from([ObjectId(2), ObjectId(13)]);
        let avoid = Avoid::new(&lifted, &[]);
        let onto = Onto::Surface { number: table, height_m: 0.75, soft: false };
        let mut crowd = Crowd::around(&world, &moving, &lifted);
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut taken = 0;
        for _ in 0..4_000 {
            let at = Vec2::new(rng.random_range(-0.7..0.7), rng.random_range(-0.5..0.5));
            if crowd.has_taken(table, at) {
                assert!(world.is_plainly_taken(&moving.shape, at, moving.pose.yaw_rad, onto, &avoid), "{at}");
                taken += 1;
            }
        }
        assert!(taken > 200, "{taken} of 4000 places known to be taken");
        assert!(!crowd.has_taken(table, flat(first.pose.at)), "the lifted box's own place");
        let all = Lifted::from_iter(world.items().map(|i| i.id));
        let mut nobody = Crowd::around(&world, &moving, &all);
        assert!((0..50).all(|i| !nobody.has_taken(table, Vec2::new(-0.5 + 0.02 * i as f32, 0.2))));
    }
}
