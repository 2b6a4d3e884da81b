//! Distributions of directions in the plane: von Mises, mixtures of it, and how they are fitted and drawn from
//! (Fisher 1993, Statistical Analysis of Circular Data; Best and Fisher 1979 for drawing).
//!
//! Angles are radians of any turn; every function takes them modulo 2π.

use std::f64::consts::{PI, TAU};

use rand::RngExt as _;
use serde::{Deserialize, Serialize};

use super::bessel::{bessel_ratio, ln_bessel_i0_scaled};

/// A von Mises distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VonMises {
    /// Mean direction, -π to π.
    pub mean_rad: f64,
    /// Concentration κ: 0 is uniform; for large κ the standard deviation is 1/√κ radians.
    pub kappa: f64,
}

/// The resultant of weighted directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resultant {
    /// Direction of the weighted sum, -π to π; 0 where the sum vanishes.
    pub mean_rad: f64,
    /// Length of the weighted mean of unit vectors, 0 to 1.
    pub length: f64,
    /// Sum of the weights.
    pub weight: f64,
}

impl Resultant {
    /// Of (angle, weight) pairs; weights are not negative.
    pub fn of(angles: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::of_units(angles.into_iter().map(|(angle, weight)| ([angle.cos(), angle.sin()], weight)))
    }

    /// The same of unit vectors `[cos, sin]`, for angles that are asked often.
    fn of_units(units: impl IntoIterator<Item = ([f64; 2], f64)>) -> Self {
        let sum = |(c, s, w): (f64, f64, f64), ([cos, sin], weight): ([f64; 2], f64)| {
            (c + weight * cos, s + weight * sin, w + weight)
        };
        let (c, s, weight) = units.into_iter().fold((0.0, 0.0, 0.0), sum);
        if weight <= 0.0 {
            return Self::default();
        }
        Self { mean_rad: s.atan2(c), length: (c.hypot(s) / weight).min(1.0), weight }
    }
}

impl VonMises {
    /// Every direction alike.
    pub const UNIFORM: Self = Self { mean_rad: 0.0, kappa: 0.0 };

    /// The most likely distribution of a resultant, with κ at most `most_kappa`.
    pub fn of(resultant: &Resultant, most_kappa: f64) -> Self {
        Self { mean_rad: resultant.mean_rad, kappa: concentration(resultant.length).min(most_kappa) }
    }

    /// The most likely distribution of some angles; few angles (up to [`FEW`]) have κ corrected for its bias, which
    /// would otherwise read certainty out of chance. No angles give the uniform distribution.
    pub fn fit(angles: &[f64], most_kappa: f64) -> Self {
        let resultant = Resultant::of(angles.iter().map(|a| (*a, 1.0)));
        let free = concentration(resultant.length);
        Self { mean_rad: resultant.mean_rad, kappa: unbiased(free, angles.len()).min(most_kappa) }
    }

    /// Natural logarithm of the density per radian.
    pub fn ln_density(&self, angle_rad: f64) -> f64 {
        self.ln_density_with(angle_rad, ln_bessel_i0_scaled(self.kappa))
    }

    /// The same with ln I0(κ), scaled, known.
    fn ln_density_with(&self, angle_rad: f64, ln_i0: f64) -> f64 {
        self.kappa * ((angle_rad - self.mean_rad).cos() - 1.0) - TAU.ln() - ln_i0
    }

    /// Density per radian.
    pub fn density(&self, angle_rad: f64) -> f64 {
        self.ln_density(angle_rad).exp()
    }

    /// Draws an angle, -π to π (Best and Fisher 1979: rejection from a wrapped Cauchy envelope).
    pub fn sample(&self, rng: &mut impl rand::Rng) -> f64 {
        if self.kappa < FLAT_KAPPA {
            return rng.random_range(-PI..PI);
        }
        let tau = 1.0 + (1.0 + 4.0 * self.kappa * self.kappa).sqrt();
        let rho = (tau - (2.0 * tau).sqrt()) / (2.0 * self.kappa);
        let r = (1.0 + rho * rho) / (2.0 * rho);
        loop {
            let z = (PI * rng.random::<f64>()).cos();
            let f = (1.0 + r * z) / (r + z);
            let c = self.kappa * (r - f);
            let u: f64 = rng.random();
            if c * (2.0 - c) > u || (c / u).ln() + 1.0 >= c {
                let side = if rng.random::<bool>() { 1.0 } else { -1.0 };
                return wrap(self.mean_rad + side * f.clamp(-1.0, 1.0).acos());
            }
        }
    }
}

/// Up to so many angles κ is corrected for its bias (Fisher 1993, §4.5.5).
pub const FEW: usize = 15;
/// Below this κ the density varies by less than one in a million: drawn as uniform, since the envelope divides by κ.
const FLAT_KAPPA: f64 = 1e-6;

/// κ of few angles, corrected (Best and Fisher 1981).
fn unbiased(kappa: f64, count: usize) -> f64 {
    let n = count as f64;
    match count {
        0 | 1 => 0.0,
        2..=FEW if kappa < 2.0 => (kappa - 2.0 / (n * kappa)).max(0.0),
        2..=FEW => (n - 1.0).powi(3) * kappa / (n.powi(3) + n),
        _ => kappa,
    }
}

/// κ whose mean resultant length is `length`: Fisher's approximation, then Newton steps on A(κ) = I1/I0.
pub fn concentration(length: f64) -> f64 {
    let r = length.clamp(0.0, 1.0);
    if r >= 1.0 - 1e-12 {
        return f64::INFINITY;
    }
    if r < 1e-12 {
        return 0.0;
    }
    let mut kappa = if r < 0.53 {
        2.0 * r + r.powi(3) + 5.0 * r.powi(5) / 6.0
    } else if r < 0.85 {
        -0.4 + 1.39 * r + 0.43 / (1.0 - r)
    } else {
        1.0 / (r.powi(3) - 4.0 * r * r + 3.0 * r)
    };
    for _ in 0..NEWTON_STEPS {
        let a = bessel_ratio(kappa);
        let slope = 1.0 - a * a - a / kappa;
        if slope <= 0.0 {
            break;
        }
        kappa = (kappa - (a - r) / slope).max(0.5 * kappa);
    }
    kappa
}

/// Fisher's approximation is within 1 %; each step squares the error.
const NEWTON_STEPS: usize = 3;

/// The same angle between -π and π.
pub fn wrap(angle_rad: f64) -> f64 {
    let turned = (angle_rad + PI).rem_euclid(TAU) - PI;
    if turned <= -PI { PI } else { turned }
}

/// A mixture of von Mises distributions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VonMisesMixture {
    /// (weight, distribution); weights are positive and sum to one, heaviest first.
    pub components: Vec<(f64, VonMises)>,
}

/// What decides how many components a mixture has; the smallest value wins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Criterion {
    /// 2p - 2 ln L (Akaike 1973; ADSE §4.2).
    #[default]
    Aic,
    /// AIC with its correction for few samples, 2p(p + 1) / (n - p - 1).
    Aicc,
    /// p ln n - 2 ln L (Schwarz 1978).
    Bic,
}

impl Criterion {
    /// The value for a model of `parameters` fitted to `count` samples.
    pub fn value(self, ln_likelihood: f64, parameters: usize, count: usize) -> f64 {
        let (p, n) = (parameters as f64, count as f64);
        let aic = 2.0 * p - 2.0 * ln_likelihood;
        match self {
            Self::Aic => aic,
            Self::Aicc if n > p + 1.0 => aic + 2.0 * p * (p + 1.0) / (n - p - 1.0),
            Self::Aicc => f64::INFINITY,
            Self::Bic => p * n.ln() - 2.0 * ln_likelihood,
        }
    }
}

/// Settings of [`VonMisesMixture::fit`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MixtureConfig {
    /// Most components; 1 to this many are tried.
    pub most_components: usize,
    /// What decides their number.
    pub criterion: Criterion,
    /// Largest κ: without it components collapse onto equal angles.
    pub most_kappa: f64,
    /// Runs from different starts, of which the most likely is kept.
    pub restarts: usize,
    /// Most iterations of a run.
    pub iterations: usize,
    /// A run ends when ln L grows by less than this share of itself.
    pub least_growth: f64,
}

impl Default for MixtureConfig {
    /// ADSE §4.2: 1 to 4 components by AIC. κ ≤ 50 is a standard deviation of 8°, what a person's facing is known to;
    /// with more, components become needles through chance alignments.
    fn default() -> Self {
        Self {
            most_components: 4,
            criterion: Criterion::Aic,
            most_kappa: 50.0,
            restarts: 4,
            iterations: 200,
            least_growth: 1e-7,
        }
    }
}

impl VonMisesMixture {
    /// Every direction alike.
    pub fn uniform() -> Self {
        Self { components: vec![(1.0, VonMises::UNIFORM)] }
    }

    /// Fits 1 to `most_components` components by expectation-maximisation and keeps the number that the criterion
    /// prefers. A number of components is tried only where the angles are more than its parameters
    /// (n > 3M). The same angles and seed give the same mixture.
    pub fn fit(angles: &[f64], config: &MixtureConfig, seed: u64) -> Self {
        let single = VonMises::fit(angles, config.most_kappa);
        let mut best = Self { components: vec![(1.0, single)] };
        let mut least = config.criterion.value(best.ln_likelihood(angles), 2, angles.len());
        for count in 2..=config.most_components {
            if angles.len() < 3 * count + 1 {
                break;
            }
            let candidate = em::fit(angles, count, config, seed);
            let value =
                config.criterion.value(candidate.ln_likelihood(angles), candidate.parameters(), angles.len());
            if value < least {
                (best, least) = (candidate, value);
            }
        }
        best
    }

    /// This mixture with a `share` of the weight and another with the rest; the heaviest `most` components stay.
    #[must_use]
    pub fn mixed(&self, other: &Self, share: f64, most: usize) -> Self {
        let own = self.components.iter().map(|(w, part)| (w * share, *part));
        let others = other.components.iter().map(|(w, part)| (w * (1.0 - share), *part));
        let mut components: Vec<(f64, VonMises)> = own.chain(others).filter(|(w, _)| *w > 0.0).collect();
        components.sort_by(|a, b| b.0.total_cmp(&a.0));
        components.truncate(most.max(1));
        let total: f64 = components.iter().map(|(w, _)| w).sum();
        components.iter_mut().for_each(|(w, _)| *w /= total);
        Self { components }
    }

    /// Free numbers: mean, κ and weight of each component, less one since weights sum to one.
    pub fn parameters(&self) -> usize {
        (3 * self.components.len()).saturating_sub(1)
    }

    /// Natural logarithm of the density per radian.
    pub fn ln_density(&self, angle_rad: f64) -> f64 {
        ln_sum_exp(self.components.iter().map(|(w, component)| w.ln() + component.ln_density(angle_rad)))
    }

    /// Density per radian.
    pub fn density(&self, angle_rad: f64) -> f64 {
        self.ln_density(angle_rad).exp()
    }

    /// Sum of the logarithms of the densities of some angles.
    pub fn ln_likelihood(&self, angles: &[f64]) -> f64 {
        let prepared = PreparedMixture::of(self);
        angles.iter().map(|a| prepared.ln_density(*a)).sum()
    }

    /// Draws an angle, -π to π.
    pub fn sample(&self, rng: &mut impl rand::Rng) -> f64 {
        let mut left: f64 = rng.random();
        for (weight, component) in &self.components {
            left -= weight;
            if left <= 0.0 {
                return component.sample(rng);
            }
        }
        self.components.last().map_or(0.0, |(_, component)| component.sample(rng))
    }

    /// The resultant of the whole mixture, from each component's own (its length is A(κ)).
    pub fn resultant(&self) -> Resultant {
        let (c, s) = self.components.iter().fold((0.0, 0.0), |(c, s), (weight, component)| {
            let length = weight * bessel_ratio(component.kappa);
            (c + length * component.mean_rad.cos(), s + length * component.mean_rad.sin())
        });
        Resultant { mean_rad: s.atan2(c), length: c.hypot(s).min(1.0), weight: 1.0 }
    }
}

/// A mixture with all that does not depend on the angle, for asking it about many.
#[derive(Clone, Debug)]
pub struct PreparedMixture {
    /// ln of the weight, the distribution, and ln I0 of its κ.
    components: Vec<(f64, VonMises, f64)>,
}

impl PreparedMixture {
    /// Of a mixture.
    pub fn of(mixture: &VonMisesMixture) -> Self {
        let prepared = |(w, part): &(f64, VonMises)| (w.ln(), *part, ln_bessel_i0_scaled(part.kappa));
        Self { components: mixture.components.iter().map(prepared).collect() }
    }

    /// Bit by bit what [`VonMisesMixture::ln_density`] says.
    pub fn ln_density(&self, angle_rad: f64) -> f64 {
        let of = |(ln_w, part, ln_i0): &(f64, VonMises, f64)| ln_w + part.ln_density_with(angle_rad, *ln_i0);
        ln_sum_exp(self.components.iter().map(of))
    }
}

/// ln Σ exp, safe where every term is very small.
pub fn ln_sum_exp(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY { most } else { most + terms.map(|t| (t - most).exp()).sum::<f64>().ln() }
}

mod em {
    //! Expectation-maximisation of a mixture with a known number of components.

    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::{MixtureConfig, Resultant, VonMises, VonMisesMixture, ln_sum_exp};

    /// κ of a fresh start: a standard deviation of about half a radian.
    const START_KAPPA: f64 = 4.0;
    /// A component with less than this share of one angle is dropped for good.
    const LEAST_SHARE: f64 = 1e-3;

    pub(super) fn fit(angles: &[f64], count: usize, config: &MixtureConfig, seed: u64) -> VonMisesMixture {
        let mut best: Option<(f64, VonMisesMixture)> = None;
        let units: Vec<[f64; 2]> = angles.iter().map(|a| [a.cos(), a.sin()]).collect();
        for restart in 0..config.restarts.max(1) {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream((count * 1000 + restart) as u64);
            let run = one_run(angles, &units, start(angles, count, &mut rng), config);
            if best.as_ref().is_none_or(|(most, _)| run.0 > *most) {
                best = Some(run);
            }
        }
        let mut mixture = best.map_or_else(VonMisesMixture::uniform, |(_, mixture)| mixture);
        mixture.components.sort_by(|a, b| b.0.total_cmp(&a.0));
        mixture
    }

    /// Means at angles far from one another: each next one drawn by its squared distance to the nearest before
    /// (Arthur and Vassilvitskii 2007).
    fn start(angles: &[f64], count: usize, rng: &mut ChaCha8Rng) -> VonMisesMixture {
        let mut means = vec![angles[rng.random_range(0..angles.len())]];
        while means.len() < count {
            let far = |a: &f64| means.iter().map(|m| 1.0 - (a - m).cos()).fold(f64::INFINITY, f64::min);
            let total: f64 = angles.iter().map(far).sum();
            let mut left = rng.random::<f64>() * total;
            let next = angles.iter().find(|a| {
                left -= far(a);
                left <= 0.0
            });
            let next = next.copied().unwrap_or(angles[0]);
            means.push(next);
        }
        let weight = 1.0 / count as f64;
        let component = |mean_rad| (weight, VonMises { mean_rad, kappa: START_KAPPA });
        VonMisesMixture { components: means.into_iter().map(component).collect() }
    }

    fn one_run(
        angles: &[f64],
        units: &[[f64; 2]],
        mut mixture: VonMisesMixture,
        config: &MixtureConfig,
    ) -> (f64, VonMisesMixture) {
        let mut before = f64::NEG_INFINITY;
        for _ in 0..config.iterations {
            let (ln_likelihood, shares) = expect(angles, &mixture);
            if ln_likelihood - before < config.least_growth * ln_likelihood.abs() {
                break;
            }
            before = ln_likelihood;
            mixture = maximise(units, &shares, config.most_kappa);
        }
        (mixture.ln_likelihood(angles), mixture)
    }

    /// ln L and for each component its share of each angle. What does not depend on the angle is computed once.
    fn expect(angles: &[f64], mixture: &VonMisesMixture) -> (f64, Vec<Vec<f64>>) {
        let mut shares: Vec<Vec<f64>> = mixture
            .components
            .iter()
            .map(|(weight, part)| {
                let at_mean = weight.ln() + part.ln_density(part.mean_rad);
                angles.iter().map(|a| at_mean + part.kappa * ((a - part.mean_rad).cos() - 1.0)).collect()
            })
            .collect();
        let mut total = 0.0;
        for index in 0..angles.len() {
            let sum = ln_sum_exp(shares.iter().map(|share| share[index]));
            total += sum;
            shares.iter_mut().for_each(|share| share[index] = (share[index] - sum).exp());
        }
        (total, shares)
    }

    fn maximise(units: &[[f64; 2]], shares: &[Vec<f64>], most_kappa: f64) -> VonMisesMixture {
        let resultants =
            shares.iter().map(|share| Resultant::of_units(units.iter().copied().zip(share.iter().copied())));
        let kept: Vec<Resultant> = resultants.filter(|r| r.weight > LEAST_SHARE).collect();
        let total: f64 = kept.iter().map(|r| r.weight).sum();
        let component = |r: &Resultant| (r.weight / total, VonMises::of(r, most_kappa));
        VonMisesMixture { components: kept.iter().map(component).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    fn draws(mixture: &VonMisesMixture, count: usize, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count).map(|_| mixture.sample(&mut rng)).collect()
    }

    fn of(components: &[(f64, f64, f64)]) -> VonMisesMixture {
        let one = |(weight, mean_rad, kappa): &(f64, f64, f64)| {
            (*weight, VonMises { mean_rad: *mean_rad, kappa: *kappa })
        };
        VonMisesMixture { components: components.iter().map(one).collect() }
    }

    /// Half the integral of the densities' difference: 0 alike, 1 disjoint.
    fn apart(a: &VonMisesMixture, b: &VonMisesMixture) -> f64 {
        let steps = 720;
        let at = |i: usize| f64::from(i as u32) * TAU / f64::from(steps as u32);
        let sum: f64 = (0..steps).map(|i| (a.density(at(i)) - b.density(at(i))).abs()).sum();
        0.5 * sum * TAU / f64::from(steps as u32)
    }

    #[test]
    fn concentration_inverts_the_mean_resultant_length() {
        for kappa in [1e-4, 0.1, 0.53, 1.26, 4.3, 20.0, 200.0, 5_000.0] {
            let found = concentration(bessel_ratio(kappa));
            assert!((found / kappa - 1.0).abs() < 1e-5, "{found} for {kappa}");
        }
        assert_eq!((concentration(0.0), concentration(1.0)), (0.0, f64::INFINITY));
    }

    #[test]
    fn densities_integrate_to_one_and_draws_follow_them() {
        for kappa in [0.0, 0.5, 3.0, 60.0] {
            let truth = of(&[(1.0, 2.5, kappa)]);
            let sum: f64 = (0..3600).map(|i| truth.density(f64::from(i) * TAU / 3600.0)).sum();
            assert!((sum * TAU / 3600.0 - 1.0).abs() < 1e-6, "{sum}");
            let drawn = Resultant::of(draws(&truth, 20_000, 3).into_iter().map(|a| (a, 1.0)));
            assert!((drawn.length - bessel_ratio(kappa)).abs() < 0.012, "{drawn:?} for {kappa}");
            assert!(kappa < 0.1 || wrap(drawn.mean_rad - 2.5).abs() < 0.06, "{drawn:?}");
        }
    }

    #[test]
    fn a_prepared_mixture_says_the_same_bit_by_bit() {
        let truth = of(&[(0.5, 2.5, 3.0), (0.3, -1.0, 45.0), (0.2, 0.0, 0.0)]);
        let prepared = PreparedMixture::of(&truth);
        let angles = draws(&truth, 500, 8);
        assert!(angles.iter().all(|a| prepared.ln_density(*a) == truth.ln_density(*a)));
    }

    #[test]
    fn few_angles_do_not_pretend_to_be_certain() {
        let fit = VonMises::fit(&[0.1, 0.12], 200.0);
        assert!(fit.kappa <= 200.0 && (fit.mean_rad - 0.11).abs() < 1e-9);
        assert_eq!(VonMises::fit(&[1.0], 200.0).kappa, 0.0);
        assert_eq!(VonMises::fit(&[], 200.0), VonMises::UNIFORM);
    }

    #[test]
    fn a_mixture_is_recovered_from_its_draws() {
        let truth = of(&[(0.6, 1.5, 20.0), (0.4, -1.0, 3.0)]);
        for (count, farthest) in [(60, 0.25), (300, 0.12), (3_000, 0.05)] {
            let found = VonMisesMixture::fit(&draws(&truth, count, 9), &MixtureConfig::default(), 1);
            assert!(apart(&found, &truth) < farthest, "n = {count}: {} {found:?}", apart(&found, &truth));
            let weights: f64 = found.components.iter().map(|c| c.0).sum();
            assert!((weights - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn one_heap_of_angles_is_told_as_one_by_the_strict_criterion_and_ties_stay_finite() {
        let truth = of(&[(1.0, 1.5, 8.0)]);
        let strict = MixtureConfig { criterion: Criterion::Bic, ..MixtureConfig::default() };
        let ones = (0..20).filter(|seed| {
            VonMisesMixture::fit(&draws(&truth, 100, *seed), &strict, 1).components.len() == 1
        });
        assert!(ones.count() >= 18);
        let ties = VonMisesMixture::fit(&[vec![0.5; 20], vec![2.5; 20]].concat(), &strict, 1);
        assert!(ties.components.len() == 2 && ties.components.iter().all(|c| c.1.kappa <= 50.0), "{ties:?}");
    }

    #[test]
    fn two_mixtures_mix_by_their_shares_and_the_lightest_part_goes() {
        let (a, b) = (of(&[(1.0, 1.0, 4.0)]), of(&[(0.9, 2.0, 2.0), (0.1, -1.0, 2.0)]));
        let mixed = a.mixed(&b, 0.4, 2);
        let weights: Vec<f64> = mixed.components.iter().map(|c| c.0).collect();
        assert!((weights[0] - 0.54 / 0.94).abs() < 1e-12 && (weights[1] - 0.4 / 0.94).abs() < 1e-12);
        assert_eq!(a.mixed(&b, 1.0, 4), a);
    }

    #[test]
    fn the_criteria_are_their_formulae() {
        assert_eq!(Criterion::Aic.value(-10.0, 2, 8), 24.0);
        assert_eq!(Criterion::Aicc.value(-10.0, 2, 8), 24.0 + 12.0 / 5.0);
        assert!((Criterion::Bic.value(-10.0, 2, 8) - (2.0 * 8.0_f64.ln() + 20.0)).abs() < 1e-12);
        assert_eq!(Criterion::Aicc.value(-10.0, 2, 3), f64::INFINITY);
    }

    #[test]
    fn angles_are_taken_modulo_a_turn() {
        for (angle, wrapped) in [(3.0 * PI, PI), (-PI, PI), (TAU + 0.5, 0.5), (-4.0, TAU - 4.0)] {
            assert!((wrap(angle) - wrapped).abs() < 1e-12, "{angle}");
        }
    }
}
