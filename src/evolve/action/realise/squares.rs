//! Things by where they stand in plan: what is near a place is found without looking at the rest.

use std::sync::Arc;

use glam::Vec2;

use super::world::Item;
use crate::math::Aabb;

/// Side of a square. A table holds a few dozen, a chair stands in four to nine.
const SQUARE_M: f32 = 0.25;
/// Most squares along a side; larger rooms get larger squares.
const MOST: usize = 128;

/// A grid over the plan of a room. What stands outside belongs to the squares at the border.
#[derive(Clone, Debug)]
pub struct Squares {
    origin: Vec2,
    square_m: f32,
    dim: [usize; 2],
    items: Vec<Vec<Entry>>,
}

/// A thing in a square, with what is asked of all of them, so that most are passed over without a look at the thing.
#[derive(Clone, Debug)]
struct Entry {
    bounds: Aabb,
    /// The first of the squares that it is in, along x and z.
    first: [usize; 2],
    item: Arc<Item>,
}

/// Squares from the first to the last, both along x and along z.
type Range = [[usize; 2]; 2];

impl Squares {
    /// Without things.
    pub fn over(bounds: &Aabb) -> Self {
        let (low, size) = (bounds.min, bounds.size().max(glam::Vec3::ZERO));
        let square_m = SQUARE_M.max(size.x.max(size.z) / MOST as f32);
        let count = |length_m: f32| ((length_m / square_m).ceil() as usize).clamp(1, MOST);
        let dim = [count(size.x), count(size.z)];
        Self { origin: Vec2::new(low.x, low.z), square_m, dim, items: vec![Vec::new(); dim[0] * dim[1]] }
    }

    /// A thing is there now.
    pub fn enter(&mut self, item: &Arc<Item>) {
        let [[x, _], [z, _]] = self.range(&item.bounds);
        for square in self.covered(&item.bounds) {
            self.items[square].push(Entry { bounds: item.bounds, first: [x, z], item: item.clone() });
        }
    }

    /// A thing is there no longer.
    pub fn leave(&mut self, item: &Item) {
        for square in self.covered(&item.bounds) {
            self.items[square].retain(|other| other.item.id != item.id);
        }
    }

    /// Things whose boxes touch `bounds`, each once.
    pub fn near<'a>(&'a self, bounds: &Aabb) -> impl Iterator<Item = &'a Arc<Item>> + use<'a> {
        let (asked, bounds) = (self.range(bounds), *bounds);
        // A thing in several squares counts in the first that it shares with what is asked.
        let is_first = move |x: usize, z: usize, first: [usize; 2]| {
            x == first[0].max(asked[0][0]) && z == first[1].max(asked[1][0])
        };
        let at = move |x: usize, z: usize| {
            let entries = self.items[x * self.dim[1] + z].iter();
            let near = entries.filter(move |e| e.bounds.intersects(&bounds) && is_first(x, z, e.first));
            near.map(|entry| &entry.item)
        };
        (asked[0][0]..=asked[0][1]).flat_map(move |x| (asked[1][0]..=asked[1][1]).flat_map(move |z| at(x, z)))
    }

    fn covered(&self, bounds: &Aabb) -> impl Iterator<Item = usize> + use<> {
        let ([[x0, x1], [z0, z1]], width) = (self.range(bounds), self.dim[1]);
        (x0..=x1).flat_map(move |x| (z0..=z1).map(move |z| x * width + z))
    }

    fn range(&self, bounds: &Aabb) -> Range {
        let square = |at: f32, from: f32, count: usize| {
            (((at - from) / self.square_m).max(0.0) as usize).min(count - 1)
        };
        let x = |at: f32| square(at, self.origin.x, self.dim[0]);
        let z = |at: f32| square(at, self.origin.y, self.dim[1]);
        [[x(bounds.min.x), x(bounds.max.x)], [z(bounds.min.z), z(bounds.max.z)]]
    }
}
