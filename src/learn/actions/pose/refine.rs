//! From the relaxation to one rotation: alternates the rotation of the whole pose and the shares of its bases, min
//! ½‖W - R Σ cᵢ Bᵢ‖² + λ Σ|cᵢ| (Zhou et al. 2015, §4).

use glam::{Mat3, Vec3};

use super::convex::Seen;
use crate::math::rotation::matrix_from_axis_angle;
use crate::math::{LassoConfig, Rows, lasso};

/// Settings of [`refine`].
#[derive(Clone, Copy, Debug)]
pub(super) struct RefineConfig {
    /// λ.
    pub penalty: f32,
    /// Whether shares below zero are left out.
    pub non_negative: bool,
    /// Ends when the objective falls by less than this share.
    pub tolerance: f32,
    /// Most rounds.
    pub rounds: usize,
}

/// A rotation (camera from pose) and the share of every basis.
#[derive(Clone, Debug)]
pub(super) struct Refined {
    pub rotation: Mat3,
    pub shares: Vec<f32>,
    /// Value that was minimised.
    pub objective: f32,
}

/// The rotation whose first two rows these are.
pub(super) fn complete(rows: &Rows) -> Mat3 {
    Mat3::from_cols(rows[0], rows[1], rows[0].cross(rows[1])).transpose()
}

pub(super) fn refine(
    seen: &Seen,
    points: &[[f32; 2]],
    rotation: Mat3,
    shares: Vec<f32>,
    config: &RefineConfig,
) -> Refined {
    let mut state = Refined { rotation, shares, objective: f32::INFINITY };
    for _ in 0..config.rounds {
        let shape = shape_of(seen, &state.shares);
        if shape.iter().any(|p| p.length_squared() > 0.0) {
            state.rotation = turn(&shape, points, state.rotation);
        }
        share(seen, points, config, &mut state);
        let objective = objective(seen, points, config.penalty, &state);
        let fell = state.objective - objective;
        state.objective = objective;
        if fell < config.tolerance * objective {
            break;
        }
    }
    state
}

/// Σ cᵢ Bᵢ at the marked joints.
fn shape_of(seen: &Seen, shares: &[f32]) -> Vec<Vec3> {
    let mut shape = vec![Vec3::ZERO; seen.bases.first().map_or(0, Vec::len)];
    for (basis, share) in seen.bases.iter().zip(shares).filter(|(_, s)| **s != 0.0) {
        shape.iter_mut().zip(basis).for_each(|(s, b)| *s += *b * *share);
    }
    shape
}

/// Gauss-Newton steps on the rotation, each taken only if it helps.
fn turn(shape: &[Vec3], points: &[[f32; 2]], start: Mat3) -> Mat3 {
    let cost = |r: &Mat3| -> f32 {
        shape.iter().zip(points).map(|(s, w)| offset(r, s, w).iter().map(|x| x * x).sum::<f32>()).sum()
    };
    let (mut rotation, mut least) = (start, cost(&start));
    for _ in 0..GAUSS_NEWTON_STEPS {
        let (mut normal, mut pull) = (Mat3::ZERO, Vec3::ZERO);
        for (s, w) in shape.iter().zip(points) {
            let turned = rotation * *s;
            let [dx, dy] = offset(&rotation, s, w);
            // Derivatives of x and y of `turned` by a small turn about the camera's axes.
            let jx = Vec3::new(0.0, turned.z, -turned.y);
            let jy = Vec3::new(-turned.z, 0.0, turned.x);
            normal += outer(jx) + outer(jy);
            pull += jx * dx + jy * dy;
        }
        normal +=
            Mat3::from_diagonal(Vec3::splat(1e-4 * (normal.x_axis.x + normal.y_axis.y + normal.z_axis.z)));
        let step = normal.inverse() * pull;
        if !step.is_finite() {
            break;
        }
        let next = matrix_from_axis_angle(step) * rotation;
        let reached = cost(&next);
        if reached >= least {
            break;
        }
        (rotation, least) = (next, reached);
    }
    rotation
}

/// The steps converge quadratically.
const GAUSS_NEWTON_STEPS: usize = 4;

fn offset(rotation: &Mat3, s: &Vec3, w: &[f32; 2]) -> [f32; 2] {
    let turned = *rotation * *s;
    [w[0] - turned.x, w[1] - turned.y]
}

fn outer(v: Vec3) -> Mat3 {
    Mat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// The shares for the present rotation.
fn share(seen: &Seen, points: &[[f32; 2]], config: &RefineConfig, state: &mut Refined) {
    let rows = state.rotation.transpose();
    let (x_axis, y_axis) = (rows.x_axis, rows.y_axis);
    // Every basis as this rotation shows it, x and y of each joint.
    let width = 2 * points.len();
    let shown: Vec<f32> = seen
        .bases
        .iter()
        .flat_map(|basis| basis.iter().flat_map(|b| [x_axis.dot(*b), y_axis.dot(*b)]))
        .collect();
    let count = seen.bases.len();
    let row = |i: usize| &shown[i * width..(i + 1) * width];
    let inner = |a: &[f32], b: &[f32]| -> f32 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut gram = vec![0.0_f32; count * count];
    for i in 0..count {
        for j in 0..=i {
            let value = inner(row(i), row(j));
            (gram[i * count + j], gram[j * count + i]) = (value, value);
        }
    }
    let wanted: Vec<f32> = points.iter().flatten().copied().collect();
    let linear: Vec<f32> = (0..count).map(|i| inner(row(i), &wanted)).collect();
    let config = LassoConfig {
        penalty: config.penalty,
        non_negative: config.non_negative,
        sweeps: 12,
        tolerance: 1e-3,
    };
    lasso(&gram, &linear, &config, &mut state.shares);
}

fn objective(seen: &Seen, points: &[[f32; 2]], penalty: f32, state: &Refined) -> f32 {
    let shape = shape_of(seen, &state.shares);
    let off: f32 = shape
        .iter()
        .zip(points)
        .map(|(s, w)| offset(&state.rotation, s, w).iter().map(|x| x * x).sum::<f32>())
        .sum();
    0.5 * off + penalty * state.shares.iter().map(|c| c.abs()).sum::<f32>()
}
