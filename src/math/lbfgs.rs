/// Settings of [`minimise`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LbfgsConfig {
    /// Most steps.
    pub iterations: usize,
    /// Steps that the curvature is remembered of (Nocedal and Wright 2006, §7.2: 3 to 20).
    pub memory: usize,
    /// Stops when a step lowers the value by less than this share of it.
    pub least_gain: f32,
}

impl Default for LbfgsConfig {
    fn default() -> Self {
        Self { iterations: 100, memory: 12, least_gain: 1e-6 }
    }
}

/// Sufficient decrease (Nocedal and Wright 2006, §3.1).
const DECREASE: f64 = 1e-4;
/// Sufficient flattening of the slope for quasi-Newton steps (the same, §3.1).
const FLATTENING: f64 = 0.9;
/// Tries of one line search.
const TRIES: usize = 18;

/// One remembered step: change of place, change of gradient, and `1 / (y · s)`.
struct Pair {
    s: Vec<f64>,
    y: Vec<f64>,
    rho: f64,
}

/// A value with its gradient, written into the second slice.
pub type ValueAndGradient<'a> = dyn FnMut(&[f32], &mut [f32]) -> f32 + 'a;

/// What sees each accepted point and value, and may break off.
pub type EachPoint<'a, E> = dyn FnMut(&[f32], f32) -> Result<(), E> + 'a;

/// Minimises `value_and_gradient` from `x` by L-BFGS (Nocedal and Wright 2006, algorithm 7.4) with bisection to a
/// weak Wolfe point (Lewis and Overton 2013), which kinks don't upset. `x` ends at the lowest point found, whose
/// value is returned. `each` sees every accepted point and value and may break off with an error.
///
/// `value_and_gradient(x, gradient)` fills the gradient and gives the value. Nothing is kept between calls.
///
/// # Errors
/// What `each` returns.
pub fn minimise<E>(
    x: &mut [f32],
    config: &LbfgsConfig,
    value_and_gradient: &mut ValueAndGradient<'_>,
    each: &mut EachPoint<'_, E>,
) -> Result<f32, E> {
    let mut gradient = vec![0.0; x.len()];
    let mut value = value_and_gradient(x, &mut gradient);
    let mut pairs: Vec<Pair> = Vec::new();
    for _ in 0..config.iterations {
        each(x, value)?;
        let mut direction = descent(&gradient, &pairs);
        let mut slope = dot(&direction, &gradient);
        if slope >= 0.0 {
            pairs.clear();
            direction = gradient.iter().map(|g| -f64::from(*g)).collect();
            slope = dot(&direction, &gradient);
        }
        // Without curvature a step as long as the gradient means nothing.
        let first = if pairs.is_empty() { 0.1 / (-slope).sqrt().max(1e-12) } else { 1.0 };
        let found = search(x, value, &direction, slope, first, value_and_gradient);
        let Some(found) = found else { break };
        remember(&mut pairs, config.memory, x, &gradient, &found);
        let gain = value - found.value;
        x.copy_from_slice(&found.x);
        gradient = found.gradient;
        value = found.value;
        if gain <= config.least_gain * value.abs() {
            break;
        }
    }
    each(x, value)?;
    Ok(value)
}

/// A point that the line search accepts.
struct Found {
    x: Vec<f32>,
    gradient: Vec<f32>,
    value: f32,
}

/// Bisects and doubles the step until the value falls enough and the slope is flat enough; `None` when no step
/// lowers the value.
fn search(
    x: &[f32],
    value: f32,
    direction: &[f64],
    slope: f64,
    first: f64,
    value_and_gradient: &mut dyn FnMut(&[f32], &mut [f32]) -> f32,
) -> Option<Found> {
    let (mut low, mut high, mut step) = (0.0, f64::INFINITY, first);
    let mut best: Option<Found> = None;
    for _ in 0..TRIES {
        let at: Vec<f32> = x.iter().zip(direction).map(|(x, d)| (f64::from(*x) + step * d) as f32).collect();
        let mut gradient = vec![0.0; x.len()];
        let there = value_and_gradient(&at, &mut gradient);
        let falls = f64::from(there) <= f64::from(value) + DECREASE * step * slope;
        if !there.is_finite() || !falls {
            high = step;
        } else {
            let steep = dot(direction, &gradient) < FLATTENING * slope;
            if best.as_ref().is_none_or(|b| there < b.value) {
                best = Some(Found { x: at, gradient, value: there });
            }
            if !steep {
                break;
            }
            low = step;
        }
        step = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * low };
    }
    best.filter(|b| b.value < value)
}

fn remember(pairs: &mut Vec<Pair>, memory: usize, x: &[f32], gradient: &[f32], found: &Found) {
    let change = |new: &[f32], old: &[f32]| -> Vec<f64> {
        new.iter().zip(old).map(|(n, o)| f64::from(*n) - f64::from(*o)).collect()
    };
    let (s, y) = (change(&found.x, x), change(&found.gradient, gradient));
    let curvature: f64 = s.iter().zip(&y).map(|(s, y)| s * y).sum();
    if curvature > 1e-12 {
        if pairs.len() == memory {
            pairs.remove(0);
        }
        pairs.push(Pair { s, y, rho: 1.0 / curvature });
    }
}

/// Two-loop recursion: minus the inverse Hessian's estimate times the gradient.
fn descent(gradient: &[f32], pairs: &[Pair]) -> Vec<f64> {
    let mut q: Vec<f64> = gradient.iter().map(|g| f64::from(*g)).collect();
    let inner = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut shares = vec![0.0; pairs.len()];
    for (pair, share) in pairs.iter().zip(&mut shares).rev() {
        *share = pair.rho * inner(&pair.s, &q);
        q.iter_mut().zip(&pair.y).for_each(|(q, y)| *q -= *share * y);
    }
    if let Some(last) = pairs.last() {
        let scale = 1.0 / (last.rho * inner(&last.y, &last.y));
        q.iter_mut().for_each(|q| *q *= scale);
    }
    for (pair, share) in pairs.iter().zip(&shares) {
        let back = pair.rho * inner(&pair.y, &q);
        q.iter_mut().zip(&pair.s).for_each(|(q, s)| *q += (share - back) * s);
    }
    q.iter_mut().for_each(|q| *q = -*q);
    q
}

fn dot(direction: &[f64], gradient: &[f32]) -> f64 {
    direction.iter().zip(gradient).map(|(d, g)| d * f64::from(*g)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's curved valley, lowest at (1, 1).
    fn valley(x: &[f32], gradient: &mut [f32]) -> f32 {
        let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
        gradient[0] = -2.0 * a - 400.0 * x[0] * b;
        gradient[1] = 200.0 * b;
        a * a + 100.0 * b * b
    }

    #[test]
    fn a_curved_valley_is_followed_to_its_bottom() {
        let mut x = [-1.2, 1.0];
        let value = minimise::<()>(&mut x, &LbfgsConfig::default(), &mut valley, &mut |_, _| Ok(()));
        assert!(value.expect("not broken off") < 1e-8, "{x:?}");
        assert!((x[0] - 1.0).abs() < 1e-3 && (x[1] - 1.0).abs() < 1e-3, "{x:?}");
    }

    #[test]
    fn a_kink_is_reached_and_values_never_rise() {
        let mut x = [3.0f32, -2.0];
        let mut kink = |x: &[f32], gradient: &mut [f32]| {
            gradient[0] = 4.0 * x[0].signum();
            gradient[1] = 2.0 * (x[1] - 1.0);
            4.0 * x[0].abs() + (x[1] - 1.0) * (x[1] - 1.0)
        };
        let mut values = Vec::new();
        let mut see = |_: &[f32], value: f32| {
            values.push(value);
            Ok::<(), ()>(())
        };
        minimise(&mut x, &LbfgsConfig::default(), &mut kink, &mut see).expect("not broken off");
        assert!(x[0].abs() < 1e-2 && (x[1] - 1.0).abs() < 2e-2, "{x:?}");
        assert!(values.windows(2).all(|w| w[1] <= w[0]), "{values:?}");
    }

    #[test]
    fn a_watcher_can_break_off() {
        let mut x = [-1.2, 1.0];
        let mut left = 3;
        let mut watch = |_: &[f32], _: f32| {
            left -= 1;
            if left == 0 { Err("enough") } else { Ok(()) }
        };
        assert_eq!(minimise(&mut x, &LbfgsConfig::default(), &mut valley, &mut watch), Err("enough"));
    }
}
