//! Repeatable choices. Every number that ends up in a layout is rounded, so that all machines agree.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// A stream of choices of one seed.
pub struct Dice(ChaCha8Rng);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// A length between two, in whole centimetres.
    pub fn between(&mut self, least_m: f32, most_m: f32) -> f32 {
        let (least, most) = ((least_m * 100.0).round() as i32, (most_m * 100.0).round() as i32);
        self.0.random_range(least..=most.max(least)) as f32 / 100.0
    }

    /// A whole number between two, both possible.
    pub fn count(&mut self, least: usize, most: usize) -> usize {
        self.0.random_range(least..=most.max(least))
    }

    pub fn chance(&mut self, percent: u32) -> bool {
        self.0.random_range(0..100u32) < percent
    }

    /// One of some; the slices given are never empty.
    pub fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.0.random_range(0..of.len())]
    }
}

/// `v` in whole millimetres.
pub fn millimetres(v: f32) -> f32 {
    (v * 1000.0).round() / 1000.0
}
