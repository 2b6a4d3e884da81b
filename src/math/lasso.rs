/// Settings of [`lasso`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LassoConfig {
    /// Weight of the sum of absolute values.
    pub penalty: f32,
    /// Whether negative numbers are left out.
    pub non_negative: bool,
    /// Most rounds over all numbers.
    pub sweeps: usize,
    /// Ends when no number moves by more than this share of the largest.
    pub tolerance: f32,
}

/// Minimises `½ cᵀ G c - bᵀ c + penalty Σ|cᵢ|` from where `c` is, by coordinate descent (Friedman, Hastie, Höfling and
/// Tibshirani 2007). `gram` is G, n × n and positive semi-definite, row by row; `linear` is b.
pub fn lasso(gram: &[f32], linear: &[f32], config: &LassoConfig, c: &mut [f32]) {
    let n = c.len();
    // b - G c
    let mut left = linear.to_vec();
    for i in 0..n {
        if c[i] != 0.0 {
            subtract(&mut left, &gram[i * n..(i + 1) * n], c[i]);
        }
    }
    for _ in 0..config.sweeps {
        let (mut moved, mut largest) = (0.0_f32, 0.0_f32);
        for i in 0..n {
            let own = gram[i * n + i];
            if own <= 0.0 {
                continue;
            }
            let pull = left[i] + own * c[i];
            let next = shrunk(pull, config) / own;
            let step = next - c[i];
            if step != 0.0 {
                c[i] = next;
                subtract(&mut left, &gram[i * n..(i + 1) * n], step);
            }
            moved = moved.max(step.abs());
            largest = largest.max(next.abs());
        }
        if moved <= config.tolerance * largest {
            break;
        }
    }
}

fn shrunk(pull: f32, config: &LassoConfig) -> f32 {
    let size = (pull.abs() - config.penalty).max(0.0);
    if pull < 0.0 && config.non_negative { 0.0 } else { size.copysign(pull) }
}

/// `left -= row * factor`
fn subtract(left: &mut [f32], row: &[f32], factor: f32) {
    left.iter_mut().zip(row).for_each(|(l, r)| *l -= r * factor);
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXACT: LassoConfig =
        LassoConfig { penalty: 0.0, non_negative: false, sweeps: 200, tolerance: 1e-7 };
    const GRAM: [f32; 4] = [2.0, 1.0, 1.0, 3.0];

    #[test]
    fn without_a_penalty_it_solves_the_equations() {
        let mut c = [5.0, -5.0];
        lasso(&GRAM, &[1.0, -2.0], &EXACT, &mut c);
        assert!((c[0] - 1.0).abs() < 1e-5 && (c[1] + 1.0).abs() < 1e-5, "{c:?}");
    }

    #[test]
    fn a_penalty_sets_small_numbers_to_zero_and_shrinks_the_others() {
        let mut c = [0.0; 2];
        lasso(&GRAM, &[2.0, 0.4], &LassoConfig { penalty: 0.5, ..EXACT }, &mut c);
        // The second stays at zero since |0.4 - 0.75| < 0.5; the first solves 2 c = 2 - 0.5.
        assert_eq!(c, [0.75, 0.0]);
    }

    #[test]
    fn negative_numbers_can_be_left_out() {
        let mut c = [1.0, 1.0];
        lasso(&GRAM, &[1.0, -2.0], &LassoConfig { non_negative: true, ..EXACT }, &mut c);
        assert_eq!(c, [0.5, 0.0]);
    }
}
