//! Rotations as the papers write them, and the gradients of each map.
//!
//! - axis-angle: a `Vec3` whose direction is the axis and whose length is the angle in radians;
//! - 6-D: the first two columns of the matrix, **row-major 3x2** as in PSI's code:
//!   `r00 r01 r10 r11 r20 r21` (interleaved, not stacked).

use glam::{Mat3, Vec3};

/// Below this squared angle the Taylor expansion is exact to f32 precision.
const SMALL_ANGLE_SQUARED: f32 = 1e-8;

/// The cross-product matrix `[v]x`, so that `skew(a) * b == a.cross(b)`.
pub fn skew(v: Vec3) -> Mat3 {
    Mat3::from_cols(Vec3::new(0.0, v.z, -v.y), Vec3::new(-v.z, 0.0, v.x), Vec3::new(v.y, -v.x, 0.0))
}

/// Rotation matrix of an axis-angle vector (Rodrigues' formula).
pub fn matrix_from_axis_angle(axis_angle: Vec3) -> Mat3 {
    let squared = axis_angle.length_squared();
    let k = skew(axis_angle);
    if squared < SMALL_ANGLE_SQUARED {
        return Mat3::IDENTITY + k + k * k * 0.5;
    }
    let angle = squared.sqrt();
    Mat3::IDENTITY + k * (angle.sin() / angle) + k * k * ((1.0 - angle.cos()) / squared)
}

/// Axis-angle vector of a rotation matrix, angle in `[0, pi]`.
pub fn axis_angle_from_matrix(rotation: Mat3) -> Vec3 {
    let q = glam::Quat::from_mat3(&rotation);
    let q = if q.w < 0.0 { -q } else { q };
    q.to_scaled_axis()
}

/// Gradient of `f(matrix_from_axis_angle(v))` with respect to `v`, given `gradient = df/dR`
/// (entry by entry, columns as glam stores them).
///
/// Uses the right Jacobian: `dR = R [Jr dv]x`, hence `df/dv = Jr^T m` with
/// `m_i = <gradient, R [e_i]x>`.
pub fn pull_back_axis_angle(axis_angle: Vec3, rotation: &Mat3, gradient: &Mat3) -> Vec3 {
    let local = rotation.transpose() * *gradient;
    let tangent = Vec3::new(
        local.y_axis.z - local.z_axis.y,
        local.z_axis.x - local.x_axis.z,
        local.x_axis.y - local.y_axis.x,
    );
    right_jacobian_transposed(axis_angle, tangent)
}

fn right_jacobian_transposed(v: Vec3, m: Vec3) -> Vec3 {
    let squared = v.length_squared();
    let (a, b) = if squared < SMALL_ANGLE_SQUARED {
        (0.5, 1.0 / 6.0)
    } else {
        let angle = squared.sqrt();
        ((1.0 - angle.cos()) / squared, (angle - angle.sin()) / (squared * angle))
    };
    // Jr = I - a [v]x + b [v]x^2, so its transpose turns the sign of the odd term.
    let cross = v.cross(m);
    m + cross * a + v.cross(cross) * b
}

/// Gradient of `f(axis_angle_from_matrix(R))` with respect to `R` along rotations (entry by entry; its part that no
/// rotation can move is zero), given `gradient = df/d axis_angle`.
///
/// With `dR = R [δ]x` the axis-angle moves by `Jr⁻¹ δ`, so `df = m·δ` with `m = Jr⁻ᵀ gradient`, which is the gradient
/// `R [m]x / 2`.
pub fn pull_back_logarithm(rotation: &Mat3, gradient: Vec3) -> Mat3 {
    let v = axis_angle_from_matrix(*rotation);
    let squared = v.length_squared();
    // 1/θ² - cot(θ/2)/(2θ); its limit at zero is 1/12.
    let c = if squared < SMALL_LOGARITHM_SQUARED {
        1.0 / 12.0
    } else {
        let angle = squared.sqrt();
        1.0 / squared - 1.0 / (2.0 * angle * (0.5 * angle).tan())
    };
    // Jr⁻¹ = I + [v]x/2 + c [v]x², so its transpose turns the sign of the odd term.
    let cross = v.cross(gradient);
    let tangent = gradient - cross * 0.5 + v.cross(cross) * c;
    *rotation * skew(tangent) * 0.5
}

/// Below this squared angle the two terms of the logarithm's coefficient cancel in f32, and 1/12 is nearer.
const SMALL_LOGARITHM_SQUARED: f32 = 1e-3;

/// Rotation matrix of a 6-D vector by Gram-Schmidt (Zhou et al. 2019; PSI's `R`).
/// Degenerate input (zero or parallel columns) falls back to the nearest axes and is never NaN.
pub fn matrix_from_6d(six: &[f32; 6]) -> Mat3 {
    let (a, b) = columns_of_6d(six);
    let x = a.normalize_or(Vec3::X);
    let y = (b - x * x.dot(b)).normalize_or(x.any_orthonormal_vector());
    Mat3::from_cols(x, y, x.cross(y))
}

/// The 6-D vector of a rotation matrix: its first two columns, row-major 3x2.
pub fn six_d_from_matrix(rotation: &Mat3) -> [f32; 6] {
    let (x, y) = (rotation.x_axis, rotation.y_axis);
    [x.x, y.x, x.y, y.y, x.z, y.z]
}

/// Gradient of `f(matrix_from_6d(six))` with respect to `six`, given `gradient = df/dR`.
pub fn pull_back_6d(six: &[f32; 6], gradient: &Mat3) -> [f32; 6] {
    let (a, b) = columns_of_6d(six);
    let a_len = a.length().max(1e-12);
    let x = a.normalize_or(Vec3::X);
    let u = b - x * x.dot(b);
    let u_len = u.length().max(1e-12);
    let y = u.normalize_or(x.any_orthonormal_vector());
    // z = x × y
    let mut grad_x = gradient.x_axis + y.cross(gradient.z_axis);
    let grad_y = gradient.y_axis + gradient.z_axis.cross(x);
    let grad_u = (grad_y - y * y.dot(grad_y)) / u_len;
    let grad_b = grad_u - x * x.dot(grad_u);
    grad_x -= b * x.dot(grad_u) + grad_u * x.dot(b);
    let grad_a = (grad_x - x * x.dot(grad_x)) / a_len;
    [grad_a.x, grad_b.x, grad_a.y, grad_b.y, grad_a.z, grad_b.z]
}

fn columns_of_6d(six: &[f32; 6]) -> (Vec3, Vec3) {
    (Vec3::new(six[0], six[2], six[4]), Vec3::new(six[1], six[3], six[5]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(a: &Mat3, b: &Mat3) -> f32 {
        a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis) + a.z_axis.dot(b.z_axis)
    }

    const WEIGHTS: Mat3 =
        Mat3::from_cols(Vec3::new(0.3, -1.2, 0.7), Vec3::new(0.9, 0.1, -0.4), Vec3::new(-0.6, 0.5, 1.1));

    #[test]
    fn axis_angle_survives_a_round_trip() {
        for v in [Vec3::ZERO, Vec3::new(1e-5, 0.0, 0.0), Vec3::new(0.4, -1.1, 0.6), Vec3::new(0.0, 3.0, 0.0)]
        {
            let back = axis_angle_from_matrix(matrix_from_axis_angle(v));
            assert!((back - v).length() < 1e-4, "{v} came back as {back}");
        }
    }

    #[test]
    fn six_d_survives_a_round_trip_and_is_row_major() {
        let r = matrix_from_axis_angle(Vec3::new(0.4, -1.1, 0.6));
        let six = six_d_from_matrix(&r);
        assert_eq!([six[0], six[2], six[4]], r.x_axis.to_array());
        assert!((matrix_from_6d(&six) - r).abs_diff_eq(Mat3::ZERO, 1e-5));
    }

    #[test]
    fn axis_angle_gradient_agrees_with_finite_differences() {
        for v in [Vec3::new(0.4, -1.1, 0.6), Vec3::new(1e-6, 0.0, 2e-6), Vec3::new(2.0, 1.5, -0.3)] {
            let analytic = pull_back_axis_angle(v, &matrix_from_axis_angle(v), &WEIGHTS);
            for i in 0..3 {
                let mut e = Vec3::ZERO;
                e[i] = 1e-2;
                let f = |v| dot(&matrix_from_axis_angle(v), &WEIGHTS);
                let numeric = (f(v + e) - f(v - e)) / 2e-2;
                assert!((analytic[i] - numeric).abs() < 2e-3, "at {v}: {analytic}[{i}] against {numeric}");
            }
        }
    }

    #[test]
    fn logarithm_gradient_agrees_with_finite_differences() {
        let gradient = Vec3::new(0.7, -1.3, 0.4);
        for v in
            [Vec3::ZERO, Vec3::new(1e-4, 0.0, -2e-4), Vec3::new(0.03, 0.01, 0.0), Vec3::new(0.4, -1.9, 1.6)]
        {
            let rotation = matrix_from_axis_angle(v);
            let analytic = pull_back_logarithm(&rotation, gradient);
            for axis in Vec3::AXES {
                let turned = |by: f32| {
                    axis_angle_from_matrix(rotation * matrix_from_axis_angle(axis * by)).dot(gradient)
                };
                let numeric = (turned(1e-2) - turned(-1e-2)) / 2e-2;
                let along = dot(&analytic, &(rotation * skew(axis)));
                assert!((along - numeric).abs() < 2e-3, "at {v} about {axis}: {along} against {numeric}");
            }
        }
    }

    #[test]
    fn six_d_gradient_agrees_with_finite_differences() {
        let six = [0.8, -0.3, 0.5, 1.4, -0.2, 0.9];
        let analytic = pull_back_6d(&six, &WEIGHTS);
        for i in 0..6 {
            let at = |d: f32| {
                let mut moved = six;
                moved[i] += d;
                dot(&matrix_from_6d(&moved), &WEIGHTS)
            };
            let numeric = (at(1e-2) - at(-1e-2)) / 2e-2;
            assert!((analytic[i] - numeric).abs() < 2e-3, "[{i}]: {} against {numeric}", analytic[i]);
        }
    }

    #[test]
    fn degenerate_six_d_is_still_a_rotation() {
        for six in [[0.0; 6], [1.0, 2.0, 0.0, 0.0, 0.0, 0.0]] {
            let r = matrix_from_6d(&six);
            assert!((r.determinant() - 1.0).abs() < 1e-4, "{r:?}");
        }
    }
}
