use serde::{Deserialize, Serialize};

/// A lognormal distribution of positive lengths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogNormal {
    /// Mean of ln x; e^μ is the median.
    pub mu: f64,
    /// Standard deviation of ln x.
    pub sigma: f64,
}

/// Smallest length that is told from zero, in whatever unit: keeps ln finite.
const LEAST: f64 = 1e-6;

impl LogNormal {
    /// The most likely distribution (closed form: mean and standard deviation of ln x), with σ at least
    /// `least_sigma`, which keeps few or equal lengths from a spike. `None` without lengths.
    pub fn fit(lengths: &[f64], least_sigma: f64) -> Option<Self> {
        if lengths.is_empty() {
            return None;
        }
        let n = lengths.len() as f64;
        let ln = |x: &f64| x.max(LEAST).ln();
        let mu = lengths.iter().map(ln).sum::<f64>() / n;
        let variance = lengths.iter().map(|x| (ln(x) - mu).powi(2)).sum::<f64>() / n;
        Some(Self { mu, sigma: variance.sqrt().max(least_sigma) })
    }

    /// Natural logarithm of the density per unit of length; minus infinity for lengths that are not positive.
    pub fn ln_density(&self, length: f64) -> f64 {
        if length <= 0.0 {
            return f64::NEG_INFINITY;
        }
        let z = (length.ln() - self.mu) / self.sigma;
        -0.5 * z * z - length.ln() - self.sigma.ln() - 0.5 * std::f64::consts::TAU.ln()
    }

    /// The distribution of the lengths in another unit, of which one of the present is `units`.
    #[must_use]
    pub fn scaled(&self, units: f64) -> Self {
        Self { mu: self.mu + units.ln(), sigma: self.sigma }
    }

    /// Draws a length.
    pub fn sample(&self, rng: &mut impl rand::Rng) -> f64 {
        use rand_distr::Distribution as _;
        let z: f64 = rand_distr::StandardNormal.sample(rng);
        (self.mu + self.sigma * z).exp()
    }

    /// e^μ: half of all lengths are shorter.
    pub fn median(&self) -> f64 {
        self.mu.exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng as _;

    #[test]
    fn draws_give_their_distribution_back_and_units_shift_the_median() {
        let truth = LogNormal { mu: 0.3, sigma: 0.5 };
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let lengths: Vec<f64> = (0..5_000).map(|_| truth.sample(&mut rng)).collect();
        let found = LogNormal::fit(&lengths, 0.0).expect("lengths");
        assert!((found.mu - 0.3).abs() < 0.03 && (found.sigma - 0.5).abs() < 0.02, "{found:?}");
        let metres = truth.scaled(0.5);
        assert!((metres.median() - 0.5 * truth.median()).abs() < 1e-12);
        // A density changes by the inverse of the unit.
        assert!((metres.ln_density(0.6) - truth.ln_density(1.2) - 2.0_f64.ln()).abs() < 1e-12);
    }

    #[test]
    fn equal_lengths_keep_the_least_spread_and_zero_has_no_density() {
        assert_eq!(LogNormal::fit(&[1.0, 1.0], 0.2), Some(LogNormal { mu: 0.0, sigma: 0.2 }));
        assert_eq!(LogNormal::fit(&[], 0.2), None);
        assert_eq!(LogNormal { mu: 0.0, sigma: 1.0 }.ln_density(0.0), f64::NEG_INFINITY);
    }
}
