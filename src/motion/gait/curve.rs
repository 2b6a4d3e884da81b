//! Smooth curves through keys in time, and eases.

use glam::Vec3;

/// A curve through keys with continuous velocity and acceleration (clamped cubic spline); constant outside its keys.
#[derive(Clone, Debug)]
pub(super) struct Spline {
    times: Vec<f32>,
    values: Vec<Vec3>,
    slopes: Vec<Vec3>,
}

impl Spline {
    /// Through `keys` (seconds, value) in the order of time, with these velocities at its ends.
    pub(super) fn new(keys: &[(f32, Vec3)], [first, last]: [Vec3; 2]) -> Self {
        let times: Vec<f32> = keys.iter().map(|k| k.0).collect();
        let values: Vec<Vec3> = keys.iter().map(|k| k.1).collect();
        let n = keys.len();
        let mut slopes = vec![Vec3::ZERO; n];
        if n > 1 {
            (slopes[0], slopes[n - 1]) = (first, last);
            solve_interior(&times, &values, &mut slopes);
        }
        Self { times, values, slopes }
    }

    fn piece(&self, t: f32) -> Option<usize> {
        let last = self.times.len().checked_sub(1).filter(|last| *last > 0)?;
        (t > self.times[0] && t < self.times[last])
            .then(|| self.times.partition_point(|key| *key <= t).clamp(1, last) - 1)
    }

    /// The value at a time.
    pub(super) fn at(&self, t: f32) -> Vec3 {
        let Some(i) = self.piece(t) else {
            let before = self.times.first().is_none_or(|first| t <= *first);
            let end = if before { self.values.first() } else { self.values.last() };
            return end.copied().unwrap_or(Vec3::ZERO);
        };
        let h = self.times[i + 1] - self.times[i];
        let x = (t - self.times[i]) / h;
        let (x2, x3) = (x * x, x * x * x);
        self.values[i] * (2.0 * x3 - 3.0 * x2 + 1.0)
            + self.slopes[i] * (h * (x3 - 2.0 * x2 + x))
            + self.values[i + 1] * (3.0 * x2 - 2.0 * x3)
            + self.slopes[i + 1] * (h * (x3 - x2))
    }
}

/// Slopes between the given ends that make the second derivative continuous (Thomas' algorithm).
fn solve_interior(times: &[f32], values: &[Vec3], slopes: &mut [Vec3]) {
    let n = times.len();
    let step = |i: usize| (times[i + 1] - times[i]).max(1e-4);
    let rise = |i: usize| (values[i + 1] - values[i]) / step(i);
    let (mut above, mut right) = (vec![0.0; n], slopes.to_vec());
    for i in 1..n - 1 {
        let (before, after) = (step(i - 1), step(i));
        let pivot = 2.0 * (before + after) - after * above[i - 1];
        above[i] = before / pivot;
        right[i] = ((rise(i - 1) * after + rise(i) * before) * 3.0 - right[i - 1] * after) / pivot;
    }
    for i in (1..n - 1).rev() {
        slopes[i] = right[i] - slopes[i + 1] * above[i];
    }
}

/// A curve through rising keys that never turns back (Fritsch and Carlson 1980), with continuous velocity.
#[derive(Clone, Debug)]
pub(super) struct Rising {
    keys: Vec<(f32, f32)>,
    slopes: Vec<f32>,
}

impl Rising {
    /// Through `keys` (seconds, value), with these velocities at its ends.
    pub(super) fn new(keys: &[(f32, f32)], [first, last]: [f32; 2]) -> Self {
        let rise = |i: usize| (keys[i + 1].1 - keys[i].1) / (keys[i + 1].0 - keys[i].0).max(1e-4);
        let slope = |i: usize| {
            if i == 0 {
                return first;
            }
            if i + 1 == keys.len() {
                return last;
            }
            let (a, b) = (rise(i - 1), rise(i));
            if a * b <= 0.0 { 0.0 } else { 2.0 * a * b / (a + b) }
        };
        Self { keys: keys.to_vec(), slopes: (0..keys.len()).map(slope).collect() }
    }

    /// The value at a time.
    pub(super) fn at(&self, t: f32) -> f32 {
        let (Some(first), Some(last)) = (self.keys.first(), self.keys.last()) else { return 0.0 };
        if t <= first.0 {
            return first.1;
        }
        if t >= last.0 {
            return last.1;
        }
        let i = self.keys.partition_point(|key| key.0 <= t).clamp(1, self.keys.len() - 1) - 1;
        let ((t0, a), (t1, b)) = (self.keys[i], self.keys[i + 1]);
        let h = t1 - t0;
        let x = (t - t0) / h;
        let (x2, x3) = (x * x, x * x * x);
        a * (2.0 * x3 - 3.0 * x2 + 1.0)
            + self.slopes[i] * (h * (x3 - 2.0 * x2 + x))
            + b * (3.0 * x2 - 2.0 * x3)
            + self.slopes[i + 1] * (h * (x3 - x2))
    }
}

/// From 0 to 1 between two instants, without velocity or acceleration at either (quintic).
pub(super) fn ease(t: f32, from: f32, to: f32) -> f32 {
    let x = ((t - from) / (to - from).max(1e-4)).clamp(0.0, 1.0);
    // Rounding must not lead beyond 1: roots are taken of what is left.
    (x * x * x * (x * (6.0 * x - 15.0) + 10.0)).clamp(0.0, 1.0)
}

/// From 0 up to 1 and down to 0 again.
pub(super) fn bump(t: f32, [rise, full, fall, gone]: [f32; 4]) -> f32 {
    ease(t, rise, full) * (1.0 - ease(t, fall, gone))
}

/// Share of a way after a share of its time when it is begun and ended from rest by speeding up and slowing down over
/// `ramp` of the time each, at an even speed between.
pub(super) fn cruise(t: f32, ramp: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    if t > 0.5 {
        return 1.0 - cruise(1.0 - t, ramp);
    }
    // The ramp's velocity is a smoothstep, whose integral is x³ - x⁴/2.
    let top = 1.0 / (1.0 - ramp);
    let x = (t / ramp).min(1.0);
    top * (ramp * (x * x * x - 0.5 * x * x * x * x) + (t - ramp).max(0.0))
}

/// The least smooth curve that is nowhere below `needed`: a running maximum, smoothed. Values per frame.
pub(super) fn smooth_cover(needed: &[f32], reach: usize) -> Vec<f32> {
    if needed.iter().all(|n| *n <= 0.0) {
        return vec![0.0; needed.len()];
    }
    let n = needed.len();
    let highest: Vec<f32> = (0..n)
        .map(|i| needed[i.saturating_sub(reach)..(i + reach + 1).min(n)].iter().copied().fold(0.0, f32::max))
        .collect();
    // A raised cosine as wide as the maximum's reach averages only values that are at least the one needed.
    let window = |k: usize| {
        let x = (k as f32 - reach as f32) / (reach as f32 + 1.0);
        0.5 * (1.0 + (std::f32::consts::PI * x).cos())
    };
    let total: f32 = (0..=2 * reach).map(window).sum();
    (0..n)
        .map(|i| {
            let value = |k: usize| highest[(i + k).saturating_sub(reach).min(n - 1)];
            (0..=2 * reach).map(|k| window(k) * value(k)).sum::<f32>() / total
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_goes_through_its_keys_without_a_jolt() {
        let keys: Vec<(f32, Vec3)> = [0.0, 0.4, 1.1, 1.5, 2.3]
            .iter()
            .enumerate()
            .map(|(i, t)| (*t, Vec3::new((i * i) as f32, (i as f32).sin(), 0.0)))
            .collect();
        let spline = Spline::new(&keys, [Vec3::X, Vec3::ZERO]);
        for (t, value) in &keys {
            assert!(spline.at(*t).distance(*value) < 1e-4);
        }
        let velocity = |t: f32| (spline.at(t + 1e-2) - spline.at(t - 1e-2)) / 2e-2;
        let acceleration = |t: f32| (velocity(t + 1e-2) - velocity(t - 1e-2)) / 2e-2;
        assert!((velocity(0.011) - Vec3::X).length() < 0.3);
        for (t, _) in &keys[1..4] {
            assert!(acceleration(t - 0.02).distance(acceleration(t + 0.02)) < 2.5);
        }
    }

    #[test]
    fn rising_keys_never_turn_back() {
        let curve = Rising::new(&[(0.0, 0.0), (0.5, 0.1), (0.6, 3.0), (2.0, 3.1)], [0.0, 0.0]);
        let values: Vec<f32> = (0..=200).map(|i| curve.at(i as f32 * 0.01)).collect();
        assert!(values.windows(2).all(|w| w[1] >= w[0] - 1e-6));
        assert_eq!((values[0], values[200]), (0.0, 3.1));
    }

    #[test]
    fn a_cover_is_smooth_and_nowhere_too_low() {
        let needed: Vec<f32> = (0..60).map(|i| if i == 30 { 0.05 } else { 0.0 }).collect();
        let cover = smooth_cover(&needed, 5);
        assert!(cover.iter().zip(&needed).all(|(c, n)| *c > n - 1e-5), "{cover:?}");
        assert!(cover.windows(2).all(|w| (w[1] - w[0]).abs() < 0.012), "{cover:?}");
        assert_eq!(smooth_cover(&[0.0; 9], 4), [0.0; 9]);
    }

    #[test]
    fn a_cruise_covers_the_way() {
        assert_eq!((cruise(0.0, 0.3), cruise(1.0, 0.3)), (0.0, 1.0));
        assert!((cruise(0.5, 0.3) - 0.5).abs() < 1e-6);
        assert!((0..100).all(|i| cruise(i as f32 * 0.01 + 0.01, 0.3) >= cruise(i as f32 * 0.01, 0.3)));
    }
}
