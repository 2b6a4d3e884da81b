use glam::Vec3;

/// The two rows of a 2 × 3 matrix.
pub type Rows = [Vec3; 2];

/// Singular values (largest first) of a 2 × 3 matrix, and the angle of the left singular vector of the first.
pub fn singular_values(rows: &Rows) -> ([f32; 2], f32) {
    let (a, b, c) = (rows[0].length_squared(), rows[0].dot(rows[1]), rows[1].length_squared());
    // Eigenvalues of the Gram matrix [a b; b c].
    let (mean, half) = (0.5 * (a + c), 0.5 * (a - c));
    let spread = half.hypot(b);
    let values = [(mean + spread).max(0.0).sqrt(), (mean - spread).max(0.0).sqrt()];
    (values, 0.5 * b.atan2(half))
}

/// The matrix of the same singular vectors with `values` in place of its singular values `were`.
fn with_singular_values(rows: &Rows, angle: f32, were: [f32; 2], values: [f32; 2]) -> Rows {
    let factor = |i: usize| if were[i] > 0.0 { values[i] / were[i] } else { 0.0 };
    let (sin, cos) = angle.sin_cos();
    let (f, g) = (factor(0), factor(1));
    let (xx, xy, yy) = (f * cos * cos + g * sin * sin, (f - g) * sin * cos, f * sin * sin + g * cos * cos);
    [rows[0] * xx + rows[1] * xy, rows[0] * xy + rows[1] * yy]
}

/// Proximal step of the spectral norm of a 2 × 3 matrix, argmin ½‖M - Q‖² + t‖M‖₂, and the norm of the result: the
/// singular values less their projection onto the ℓ1 ball of radius t (Zhou et al. 2015, proposition 1).
pub fn spectral_proximal(rows: &Rows, t: f32) -> (Rows, f32) {
    let (were, angle) = singular_values(rows);
    let [first, second] = were;
    if first + second <= t {
        return ([Vec3::ZERO; 2], 0.0);
    }
    let values = if first - second <= t { [0.5 * (first + second - t); 2] } else { [first - t, second] };
    (with_singular_values(rows, angle, were, values), values[0])
}

/// The nearest matrix with orthonormal rows (the polar factor); `None` where the rows are parallel or zero.
pub fn orthonormal_rows(rows: &Rows) -> Option<Rows> {
    let (were, angle) = singular_values(rows);
    (were[1] > 1e-6 * were[0].max(f32::MIN_POSITIVE))
        .then(|| with_singular_values(rows, angle, were, [1.0, 1.0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MATRIX: Rows = [Vec3::new(1.0, 2.0, -0.5), Vec3::new(0.3, -1.0, 0.8)];

    fn distance2(a: &Rows, b: &Rows) -> f32 {
        (a[0] - b[0]).length_squared() + (a[1] - b[1]).length_squared()
    }

    #[test]
    fn singular_values_have_the_matrix_norm_and_volume() {
        let ([s, t], _) = singular_values(&MATRIX);
        let norm = MATRIX[0].length_squared() + MATRIX[1].length_squared();
        assert!((s * s + t * t - norm).abs() < 1e-5);
        assert!((s * t - MATRIX[0].cross(MATRIX[1]).length()).abs() < 1e-5);
    }

    #[test]
    fn the_proximal_step_beats_every_matrix_near_it() {
        for t in [0.1, 0.9, 1.8, 5.0] {
            let objective = |m: &Rows| 0.5 * distance2(m, &MATRIX) + t * singular_values(m).0[0];
            let (best, norm) = spectral_proximal(&MATRIX, t);
            assert!((singular_values(&best).0[0] - norm).abs() < 1e-4);
            for i in 0..6 {
                for step in [-0.02, 0.02] {
                    let mut other = best;
                    other[i / 3][i % 3] += step;
                    assert!(objective(&other) > objective(&best) - 1e-6, "t = {t}, entry {i}");
                }
            }
        }
    }

    #[test]
    fn the_polar_factor_is_orthonormal_and_parallel_rows_have_none() {
        let rows = orthonormal_rows(&MATRIX).expect("full rank");
        assert!((rows[0].length() - 1.0).abs() < 1e-5 && rows[0].dot(rows[1]).abs() < 1e-5);
        assert!(distance2(&orthonormal_rows(&rows).expect("full rank"), &rows) < 1e-9);
        assert!(orthonormal_rows(&[Vec3::X, Vec3::X * 2.0]).is_none());
    }
}
