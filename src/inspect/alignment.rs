//! How far an estimated body is from the true one, as pose estimation is judged (PSI table 5).

use glam::{DMat3, DQuat, DVec3, Vec3};

use crate::body::Body;
use crate::body::joints::BODY_JOINTS;
use crate::math::symmetric_eigen;
use crate::scene::BodyParams;

/// The four errors of PSI table 5, millimetres.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct EstimateErrors {
    /// Mean distance of the body's 22 joints.
    pub pje_mm: f32,
    /// Mean distance of all vertices.
    pub v2v_mm: f32,
    /// [`Self::pje_mm`] after the similarity that brings the joints nearest.
    pub aligned_pje_mm: f32,
    /// [`Self::v2v_mm`] after the similarity that brings the vertices nearest.
    pub aligned_v2v_mm: f32,
}

impl EstimateErrors {
    /// Of an estimate against the truth: pelvis and the 21 body joints, and every vertex.
    pub fn of(body: &Body, estimate: &BodyParams, truth: &BodyParams) -> Self {
        let (estimate, truth) = (body.pose(estimate), body.pose(truth));
        let joints = (&estimate.joints[..=BODY_JOINTS], &truth.joints[..=BODY_JOINTS]);
        let vertices = (&estimate.vertices[..], &truth.vertices[..]);
        Self {
            pje_mm: mean_distance_mm(joints.0, joints.1),
            v2v_mm: mean_distance_mm(vertices.0, vertices.1),
            aligned_pje_mm: mean_distance_mm(
                &Similarity::between(joints.0, joints.1).apply(joints.0),
                joints.1,
            ),
            aligned_v2v_mm: mean_distance_mm(
                &Similarity::between(vertices.0, vertices.1).apply(vertices.0),
                vertices.1,
            ),
        }
    }
}

/// Mean distance of points to their counterparts, millimetres; 0 without points.
pub fn mean_distance_mm(a: &[Vec3], b: &[Vec3]) -> f32 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a.distance(*b))).sum();
    (sum / a.len().min(b.len()).max(1) as f64 * 1e3) as f32
}

/// Scale, rotation and translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Uniform scale.
    pub scale: f64,
    /// Rotation, never a reflection.
    pub rotation: DQuat,
    /// Added last, in the points' unit.
    pub translation: DVec3,
}

impl Similarity {
    /// The similarity that brings `from` nearest to their counterparts in `to` in the sum of squared distances
    /// (Procrustes with scale; rotation by Horn 1987, scale by Umeyama 1991).
    pub fn between(from: &[Vec3], to: &[Vec3]) -> Self {
        let count = from.len().min(to.len()).max(1) as f64;
        let mean = |points: &[Vec3]| points.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / count;
        let (from_mean, to_mean) = (mean(from), mean(to));
        let (mut correlation, mut spread) = (DMat3::ZERO, 0.0);
        for (a, b) in from.iter().zip(to) {
            let (a, b) = (a.as_dvec3() - from_mean, b.as_dvec3() - to_mean);
            // Entry (row of a, row of b), column by column.
            correlation += DMat3::from_cols(a * b.x, a * b.y, a * b.z);
            spread += a.length_squared();
        }
        let rotation = horn(&correlation);
        let turned: f64 = {
            let r = DMat3::from_quat(rotation);
            // Σ b · R a is the trace of R times the correlation.
            (r * correlation).to_cols_array().iter().step_by(4).sum()
        };
        let scale = if spread > 0.0 { turned / spread } else { 1.0 };
        Self { scale, rotation, translation: to_mean - rotation * (from_mean * scale) }
    }

    /// The points, moved.
    pub fn apply(&self, points: &[Vec3]) -> Vec<Vec3> {
        let moved = |p: &Vec3| self.rotation * (p.as_dvec3() * self.scale) + self.translation;
        points.iter().map(|p| moved(p).as_vec3()).collect()
    }
}

/// The rotation that maximises `Σ b · R a`, from `Σ a bᵀ`: the eigenvector of Horn's symmetric 4 x 4 matrix.
fn horn(correlation: &DMat3) -> DQuat {
    let s = |row: usize, column: usize| correlation.col(column)[row];
    let matrix = vec![
        vec![s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0)],
        vec![s(1, 2) - s(2, 1), s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2)],
        vec![s(2, 0) - s(0, 2), s(0, 1) + s(1, 0), s(1, 1) - s(0, 0) - s(2, 2), s(1, 2) + s(2, 1)],
        vec![s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1), s(2, 2) - s(0, 0) - s(1, 1)],
    ];
    let best = &symmetric_eigen(&matrix)[0].1;
    let q = DQuat::from_xyzw(best[1], best[2], best[3], best[0]);
    if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron without symmetry.
    const POINTS: [Vec3; 4] =
        [Vec3::ZERO, Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 0.0, 3.0)];

    #[test]
    fn a_shifted_body_is_off_by_the_shift_and_aligned_not_at_all() {
        let body = Body::bundled();
        let truth = BodyParams::default();
        let shifted = BodyParams { translation: Vec3::new(0.3, 0.0, -0.4), ..truth.clone() };
        let errors = EstimateErrors::of(body, &shifted, &truth);
        assert!((errors.pje_mm - 500.0).abs() < 0.1 && (errors.v2v_mm - 500.0).abs() < 0.1, "{errors:?}");
        assert!(errors.aligned_pje_mm < 0.05 && errors.aligned_v2v_mm < 0.05, "{errors:?}");
    }

    #[test]
    fn size_and_turn_are_taken_out_by_alignment_but_a_mirror_is_not() {
        let turn = DQuat::from_euler(glam::EulerRot::YXZ, 1.2, -0.5, 0.3);
        let moved = Similarity { scale: 1.7, rotation: turn, translation: DVec3::new(4.0, -2.0, 1.0) };
        let to = moved.apply(&POINTS);
        let found = Similarity::between(&POINTS, &to);
        assert!((found.scale - 1.7).abs() < 1e-6, "{found:?}");
        assert!(mean_distance_mm(&found.apply(&POINTS), &to) < 1e-3);
        let mirrored = POINTS.map(|p| p * Vec3::new(-1.0, 1.0, 1.0));
        assert!(mean_distance_mm(&Similarity::between(&POINTS, &mirrored).apply(&POINTS), &mirrored) > 100.0);
    }

    #[test]
    fn the_errors_of_a_pair_of_points_worked_by_hand() {
        // One of two points is off by 6 mm across the line between them, so the mean is 3 mm; a similarity can
        // always bring two points onto two.
        let from = [Vec3::ZERO, Vec3::X];
        let to = [Vec3::ZERO, Vec3::new(1.0, 0.006, 0.0)];
        assert!((mean_distance_mm(&from, &to) - 3.0).abs() < 1e-4);
        assert!(mean_distance_mm(&Similarity::between(&from, &to).apply(&from), &to) < 1e-3);
        // Three points of which the last moved away from the others by 3 along their line: means 1 and 2, the best
        // scale is Σab/Σaa = (-1·-2 + 0·-1 + 1·3)/2 = 2.5, and the misses are 0.5, 1 and 0.5.
        let from = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
        let to = [Vec3::ZERO, Vec3::X, Vec3::X * 5.0];
        let found = Similarity::between(&from, &to);
        assert!((found.scale - 2.5).abs() < 1e-9, "{found:?}");
        let miss_mm = mean_distance_mm(&found.apply(&from), &to);
        assert!((miss_mm - 2000.0 / 3.0).abs() < 0.01, "{miss_mm}");
    }
}
