//! The convex program: min ½‖W - Σ Mᵢ Bᵢ‖² + λ Σ‖Mᵢ‖₂ over 2 × 3 matrices Mᵢ, by alternating directions (Zhou et
//! al. 2015, §3). The spectral norm is the convex envelope of a scaled rotation and makes few Mᵢ survive.

use glam::Vec3;

use super::Joints3;
use crate::assets::photos::PHOTO_JOINTS;
use crate::math::{Rows, spectral_proximal, symmetric_eigen};

/// Centred points have one direction fewer than points.
const MOST_RANK: usize = PHOTO_JOINTS - 1;

/// A dictionary as a photo shows it: its marked joints, weighted and about their weighted middle.
pub(super) struct Seen {
    /// For each basis, each marked joint times the root of its weight.
    pub bases: Vec<Vec<Vec3>>,
    /// For each basis the weighted middle of its marked joints.
    pub middles: Vec<Vec3>,
    /// `B U`: rows are the coordinates of the bases, columns the principal directions over the joints.
    principal: Vec<[f32; MOST_RANK]>,
    /// Eigenvalues of BᵀB.
    strengths: [f32; MOST_RANK],
}

impl Seen {
    pub fn of(bases: &[Joints3], joints: &[usize], weights: &[f32]) -> Self {
        let total: f32 = weights.iter().sum();
        let middle =
            |basis: &Joints3| joints.iter().zip(weights).map(|(j, w)| basis[*j] * *w).sum::<Vec3>() / total;
        let middles: Vec<Vec3> = bases.iter().map(middle).collect();
        let weighted = |(basis, middle): (&Joints3, &Vec3)| {
            joints.iter().zip(weights).map(|(j, w)| (basis[*j] - *middle) * w.sqrt()).collect()
        };
        let bases: Vec<Vec<Vec3>> = bases.iter().zip(&middles).map(weighted).collect();
        let (principal, strengths) = principal(&bases, joints.len());
        Self { bases, middles, principal, strengths }
    }

    /// `W Bᵀ`: what each basis sees of the points, one row of the points at a time.
    fn seen_by_bases(&self, points: &[[f32; 2]]) -> [Vec<f32>; 2] {
        [0, 1].map(|row| {
            let sum =
                |basis: &Vec<Vec3>| -> Vec3 { basis.iter().zip(points).map(|(b, w)| *b * w[row]).sum() };
            self.bases.iter().flat_map(|basis| sum(basis).to_array()).collect()
        })
    }

    /// `rhs (BBᵀ + μ)⁻¹` by Woodbury's identity on the principal directions.
    fn solve(&self, rhs: &[f32], mu: f32, out: &mut [f32]) {
        let mut told = [0.0_f32; MOST_RANK];
        for (x, row) in rhs.iter().zip(&self.principal) {
            told.iter_mut().zip(row).for_each(|(t, c)| *t += x * c);
        }
        told.iter_mut().zip(&self.strengths).for_each(|(t, s)| *t /= mu + s);
        let over_mu = 1.0 / mu;
        for ((out, x), row) in out.iter_mut().zip(rhs).zip(&self.principal) {
            *out = (x - dot(&told, row)) * over_mu;
        }
    }
}

/// In four sums, so that the processor adds four at a time.
fn dot(a: &[f32; MOST_RANK], b: &[f32; MOST_RANK]) -> f32 {
    let mut lanes = [0.0_f32; 4];
    for k in 0..MOST_RANK / 4 {
        for l in 0..4 {
            lanes[l] += a[4 * k + l] * b[4 * k + l];
        }
    }
    lanes.iter().sum()
}

fn principal(bases: &[Vec<Vec3>], joints: usize) -> (Vec<[f32; MOST_RANK]>, [f32; MOST_RANK]) {
    let gram: Vec<Vec<f64>> = (0..joints)
        .map(|a| (0..joints).map(|b| bases.iter().map(|s| f64::from(s[a].dot(s[b]))).sum()).collect())
        .collect();
    let pairs = symmetric_eigen(&gram);
    let mut strengths = [0.0; MOST_RANK];
    for (strength, (value, _)) in strengths.iter_mut().zip(&pairs) {
        *strength = value.max(0.0) as f32;
    }
    let row = |basis: &Vec<Vec3>, axis: usize| {
        let mut row = [0.0; MOST_RANK];
        for (x, (_, vector)) in row.iter_mut().zip(&pairs) {
            *x = basis.iter().zip(vector).map(|(b, u)| b[axis] * *u as f32).sum();
        }
        row
    };
    (bases.iter().flat_map(|basis| [0, 1, 2].map(|axis| row(basis, axis))).collect(), strengths)
}

/// Settings of [`solve`].
#[derive(Clone, Copy, Debug)]
pub(super) struct ConvexConfig {
    /// λ.
    pub penalty: f32,
    /// Ends when both residuals are below this share.
    pub tolerance: f32,
    /// Most rounds.
    pub rounds: usize,
}

/// The matrices Mᵢ that survive, with their basis' number. `points` are W, one column a marked joint.
pub(super) fn solve(seen: &Seen, points: &[[f32; 2]], config: &ConvexConfig) -> Vec<(usize, Rows)> {
    let count = seen.bases.len();
    let size = 3 * count;
    let mean = points.iter().flatten().map(|x| x.abs()).sum::<f32>() / (2 * points.len()).max(1) as f32;
    let mut mu = 1.0 / mean.max(f32::MIN_POSITIVE);
    let told = seen.seen_by_bases(points);
    let zeros = || [vec![0.0_f32; size], vec![0.0_f32; size]];
    let (mut m, mut z, mut y, mut before) = (zeros(), zeros(), zeros(), zeros());
    let mut rhs = vec![0.0_f32; size];
    for _ in 0..config.rounds {
        std::mem::swap(&mut before, &mut z);
        for row in 0..2 {
            for (j, r) in rhs.iter_mut().enumerate() {
                *r = told[row][j] + mu * m[row][j] + y[row][j];
            }
            seen.solve(&rhs, mu, &mut z[row]);
        }
        for i in 0..count {
            let rows = [0, 1].map(|r| at(&z[r], i) - at(&y[r], i) / mu);
            let (next, _) = spectral_proximal(&rows, config.penalty / mu);
            (0..2).for_each(|r| m[r][3 * i..3 * i + 3].copy_from_slice(&next[r].to_array()));
        }
        let (primal, dual) = residuals(&m, &z, &before, &mut y, mu);
        if primal < config.tolerance && dual < config.tolerance {
            break;
        }
        if primal > 10.0 * dual {
            mu *= 2.0;
        } else if dual > 10.0 * primal {
            mu *= 0.5;
        }
    }
    let all = (0..count).map(|i| (i, [0, 1].map(|r| at(&m[r], i))));
    all.filter(|(_, rows)| rows.iter().any(|r| r.length_squared() > 0.0)).collect()
}

fn at(row: &[f32], i: usize) -> Vec3 {
    Vec3::from_slice(&row[3 * i..])
}

/// Moves the dual variable and gives how far Z is from M and from where it was, as shares.
fn residuals(
    m: &[Vec<f32>; 2],
    z: &[Vec<f32>; 2],
    before: &[Vec<f32>; 2],
    y: &mut [Vec<f32>; 2],
    mu: f32,
) -> (f32, f32) {
    let (mut off, mut moved, mut size) = (0.0_f32, 0.0_f32, 0.0_f32);
    for row in 0..2 {
        for (j, y) in y[row].iter_mut().enumerate() {
            let (gap, step, was) = (m[row][j] - z[row][j], z[row][j] - before[row][j], before[row][j]);
            *y += mu * gap;
            off += gap * gap;
            moved += step * step;
            size += was * was;
        }
    }
    // The first round starts from nothing: no share is small then.
    let size = if size > 0.0 { size.sqrt() } else { 1e-6 };
    (off.sqrt() / size, mu * moved.sqrt() / size)
}

/// The one rotation that agrees best with all matrices (max Σ ⟨Mᵢ, R⟩², by the power method on orthonormal rows), and
/// the share of each basis; `None` when nothing survived.
pub(super) fn common_rotation(found: &[(usize, Rows)]) -> Option<(Rows, Vec<(usize, f32)>)> {
    let inner = |a: &Rows, b: &Rows| a[0].dot(b[0]) + a[1].dot(b[1]);
    let strongest = found.iter().max_by(|a, b| inner(&a.1, &a.1).total_cmp(&inner(&b.1, &b.1)))?;
    let mut rotation = crate::math::orthonormal_rows(&strongest.1)?;
    for _ in 0..POWER_STEPS {
        let sum = found.iter().fold([Vec3::ZERO; 2], |sum, (_, m)| {
            let weight = inner(m, &rotation);
            [sum[0] + m[0] * weight, sum[1] + m[1] * weight]
        });
        rotation = crate::math::orthonormal_rows(&sum)?;
    }
    let shares = found.iter().map(|(i, m)| (*i, 0.5 * inner(m, &rotation)));
    Some((rotation, shares.collect()))
}

/// The matrices mostly agree already.
const POWER_STEPS: usize = 10;
