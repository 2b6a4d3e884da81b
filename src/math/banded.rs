/// A smoother over evenly spaced samples: solves `(I + w DᵀD) y = x` with `D` the second difference (Whittaker 1923),
/// where some samples are held: they stay zero, and their neighbours come to them smoothly.
///
/// A symmetric system with five diagonals, factorised once as `L D Lᵀ` in f64; each solve costs a few operations a
/// sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoother {
    pivot: Vec<f64>,
    /// Entries of L one and two below the diagonal.
    first: Vec<f64>,
    second: Vec<f64>,
    held: Vec<bool>,
}

impl Smoother {
    /// For as many samples as `held` has entries. A wave of `2π w^¼` samples is halved by weight `w`.
    pub fn new(weight: f32, held: &[bool]) -> Self {
        let (mut pivot, mut first, mut second) = bands(f64::from(weight), held);
        for i in 0..held.len() {
            if i >= 2 {
                pivot[i] -= second[i - 2] * second[i - 2] * pivot[i - 2];
            }
            if i >= 1 {
                pivot[i] -= first[i - 1] * first[i - 1] * pivot[i - 1];
                first[i] -= second[i - 1] * pivot[i - 1] * first[i - 1];
            }
            first[i] /= pivot[i];
            second[i] /= pivot[i];
        }
        Self { pivot, first, second, held: held.to_vec() }
    }

    /// Smooths rows of `width` numbers, one row a sample, column by column; held rows become zero.
    pub fn smooth(&self, rows: &mut [f32], width: usize) {
        let n = self.held.len().min(rows.len() / width.max(1));
        let mut column = vec![0.0_f64; n];
        for k in 0..width {
            for i in 0..n {
                let given = if self.held[i] { 0.0 } else { f64::from(rows[i * width + k]) };
                let one = if i >= 1 { self.first[i - 1] * column[i - 1] } else { 0.0 };
                let two = if i >= 2 { self.second[i - 2] * column[i - 2] } else { 0.0 };
                column[i] = given - one - two;
            }
            for i in (0..n).rev() {
                let one = if i + 1 < n { self.first[i] * column[i + 1] } else { 0.0 };
                let two = if i + 2 < n { self.second[i] * column[i + 2] } else { 0.0 };
                column[i] = column[i] / self.pivot[i] - one - two;
                rows[i * width + k] = column[i] as f32;
            }
        }
    }
}

/// The diagonals of the matrix: main, one below, two below. Held samples are cut out.
fn bands(weight: f64, held: &[bool]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let n = held.len();
    let (mut main, mut first, mut second) = (vec![1.0; n], vec![0.0; n], vec![0.0; n]);
    for i in 1..n.saturating_sub(1) {
        for (at, square) in [(i - 1, 1.0), (i, 4.0), (i + 1, 1.0)] {
            main[at] += weight * square;
        }
        first[i - 1] -= 2.0 * weight;
        first[i] -= 2.0 * weight;
        second[i - 1] += weight;
    }
    for i in 0..n {
        if held[i] {
            main[i] = 1.0;
        }
        if held[i] || held.get(i + 1).is_none_or(|h| *h) {
            first[i] = 0.0;
        }
        if held[i] || held.get(i + 2).is_none_or(|h| *h) {
            second[i] = 0.0;
        }
    }
    (main, first, second)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_smoothed_solves_its_equation() {
        let held = [true, true, false, false, false, false, false, false, true];
        let given: Vec<f32> = (0..9).map(|i| (i as f32 * 2.3).sin()).collect();
        let mut y = given.clone();
        Smoother::new(3.0, &held).smooth(&mut y, 1);
        let second = |y: &[f32], i: usize| y[i - 1] - 2.0 * y[i] + y[i + 1];
        for i in 0..9 {
            if held[i] {
                assert_eq!(y[i], 0.0);
                continue;
            }
            let rows = (1..8_usize).filter(|r| r.abs_diff(i) <= 1);
            let pull: f32 = rows.map(|r| second(&y, r) * if r == i { -2.0 } else { 1.0 }).sum();
            assert!((y[i] + 3.0 * pull - given[i]).abs() < 1e-4, "{i}: {y:?}");
        }
    }

    #[test]
    fn a_straight_line_stays_and_a_single_spike_spreads() {
        let free = [false; 40];
        let mut line: Vec<f32> =
            (0..40).flat_map(|i| [i as f32 * 0.5 - 3.0, if i == 20 { 1.0 } else { 0.0 }]).collect();
        let smoother = Smoother::new(50.0, &free);
        smoother.smooth(&mut line, 2);
        for i in 0..40 {
            assert!((line[2 * i] - (i as f32 * 0.5 - 3.0)).abs() < 1e-3);
        }
        let spike: Vec<f32> = line.chunks(2).map(|row| row[1]).collect();
        assert!(spike[20] < 0.25 && spike[20] > spike[22] && (spike.iter().sum::<f32>() - 1.0).abs() < 1e-3);
    }
}
