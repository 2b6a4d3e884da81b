//! The few draws that pose families are made of.

use rand::RngExt as _;

/// Draws for any random stream.
pub(in crate::body) trait Chance {
    /// Uniform in a range.
    fn between(&mut self, low: f32, high: f32) -> f32;

    /// True with this probability.
    fn chance(&mut self, probability: f32) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// Bell-shaped around `mean` with this standard deviation, never farther off than 2.45 of them (the mean
    /// of three uniforms has no tails, so no draw is inhuman).
    fn about(&mut self, mean: f32, deviation: f32) -> f32 {
        let sum = self.between(-1.0, 1.0) + self.between(-1.0, 1.0) + self.between(-1.0, 1.0);
        // Each term has variance 1/3, so the sum has variance 1 and never leaves ±3.
        mean + deviation * sum.clamp(-2.45, 2.45)
    }

    /// [`Chance::about`] of degrees, in radians.
    fn degrees(&mut self, mean: f32, deviation: f32) -> f32 {
        self.about(mean, deviation).to_radians()
    }

    /// One of the choices, by weight.
    fn pick<T: Copy>(&mut self, choices: &[(f32, T)]) -> T {
        let total: f32 = choices.iter().map(|(weight, _)| weight).sum();
        let mut left = self.between(0.0, total);
        for (weight, choice) in choices {
            left -= weight;
            if left <= 0.0 {
                return *choice;
            }
        }
        choices[choices.len() - 1].1
    }
}

impl<R: rand::Rng> Chance for R {
    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.random::<f32>()
    }
}
