use glam::Vec3;

use crate::scene::{BodyParams, PARAMS};

/// How well a network's reconstruction keeps a body (PSI §4.1.3, Table 1; eq. 2), all in the camera frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reconstruction {
    /// Mean absolute difference of the translation in metres.
    pub translation_m: f32,
    /// The same of the normalised translation π(t).
    pub translation_normalized: f32,
    /// Mean absolute difference of the other 72 numbers.
    pub rest: f32,
}

impl Reconstruction {
    /// Of `truth` by `reconstruction`, given their translations projected by π of the image.
    pub fn of(truth: (&BodyParams, Vec3), reconstruction: (&BodyParams, Vec3)) -> Self {
        let mean = |a: &[f32], b: &[f32]| {
            a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>() / a.len().max(1) as f32
        };
        let (x, y): ([f32; PARAMS], [f32; PARAMS]) = (truth.0.to_vector(), reconstruction.0.to_vector());
        Self {
            translation_m: mean(&x[..3], &y[..3]),
            translation_normalized: mean(&truth.1.to_array(), &reconstruction.1.to_array()),
            rest: mean(&x[3..], &y[3..]),
        }
    }

    /// Eq. 2: half of both translation errors and the rest; each a mean over its numbers, as the published code
    /// takes |·| (algorithms 1.3).
    pub fn error(&self) -> f32 {
        0.5 * (self.translation_m + self.translation_normalized) + self.rest
    }

    /// Negative evidence lower bound as Table 1 gives it: eq. 2 and the Kullback-Leibler divergence (eq. 3, 4) as a
    /// mean over the latent numbers, summed over the stages.
    pub fn negative_elbo(&self, divergence: f32) -> f32 {
        self.error() + divergence
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_weighs_both_translations_half_and_the_rest_whole() {
        let truth = BodyParams::default();
        let mut other = BodyParams { translation: Vec3::new(0.3, 0.0, 0.6), ..BodyParams::default() };
        other.betas[0] = 7.2;
        let found = Reconstruction::of((&truth, Vec3::ZERO), (&other, Vec3::new(0.0, 0.3, 0.0)));
        assert!((found.translation_m - 0.3).abs() < 1e-6);
        assert!((found.translation_normalized - 0.1).abs() < 1e-6);
        assert!((found.rest - 0.1).abs() < 1e-6, "7.2 over 72 numbers");
        assert!((found.error() - 0.3).abs() < 1e-6);
    }

    #[test]
    fn the_lower_bound_adds_the_divergence_to_the_error() {
        let found = Reconstruction { translation_m: 0.2, translation_normalized: 0.4, rest: 0.1 };
        assert!((found.negative_elbo(0.05) - (0.3 + 0.1 + 0.05)).abs() < 1e-6);
    }
}
