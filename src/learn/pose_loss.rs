//! What decoded rotations cost against the true ones, with its gradient derived by hand.

use glam::{Mat3, Vec3};

use crate::body::joints::{BODY_JOINTS, PARENTS};
use crate::body::{BodyModel, BodyPose, POSE_TREE, SkinMoments};
use crate::math::rotation;

/// Numbers of a decoded pose.
const SIXES: usize = 6 * BODY_JOINTS;

/// Weights of the terms, nats per unit.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PoseLossWeights {
    /// Per squared metre of displacement, mean of skin and joints: `1 / (2 σ²)` of the misfit that is tolerated.
    pub position: f32,
    /// Per squared difference of the joints' own rotation matrices, summed over joints.
    pub rotation: f32,
    /// Per squared departure of the two decoded columns from orthonormal ones, summed over joints.
    pub orthogonality: f32,
}

/// The terms of one pose, without weights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseLossTerms {
    /// Mean squared displacement of skin and joints, square metres.
    pub position_m2: f32,
    /// Summed squared difference of rotation matrices.
    pub rotation: f32,
    /// Summed squared departure from orthonormal columns.
    pub orthogonality: f32,
}

impl PoseLossTerms {
    /// The weighted sum, nats.
    pub fn total(&self, weights: &PoseLossWeights) -> f32 {
        weights.position * self.position_m2
            + weights.rotation * self.rotation
            + weights.orthogonality * self.orthogonality
    }
}

/// Positions of skin and joints as the poses move them: see [`SkinMoments`].
pub struct PoseLoss {
    skin: SkinMoments,
}

impl PoseLoss {
    /// For the mean shape of a body.
    pub fn new(model: &BodyModel) -> Self {
        Self { skin: SkinMoments::new(model) }
    }

    /// The terms of one pose, and the gradient of their weighted sum with respect to the 126 decoded numbers.
    pub fn evaluate(
        &self,
        six: &[f32],
        target: &BodyPose,
        weights: &PoseLossWeights,
    ) -> (PoseLossTerms, [f32; SIXES]) {
        let own = |joint: usize| -> [f32; 6] { std::array::from_fn(|i| six[6 * (joint - 1) + i]) };
        let decoded = self.skin.figure(&|joint| rotation::matrix_from_6d(&own(joint)));
        let wanted = self.skin.figure(&|joint| rotation::matrix_from_axis_angle(target[joint - 1]));
        let mut terms = PoseLossTerms::default();
        let mut at_world = [Mat3::ZERO; POSE_TREE];
        let mut at_position = [Vec3::ZERO; POSE_TREE];
        for joint in 0..POSE_TREE {
            let turned = decoded.world[joint] - wanted.world[joint];
            let moved = decoded.position[joint] - wanted.position[joint];
            let (by_second, by_first) = (turned * self.skin.second[joint], turned * self.skin.first[joint]);
            terms.position_m2 += inner(&by_second, &turned)
                + 2.0 * moved.dot(by_first)
                + self.skin.mass[joint] * moved.length_squared();
            at_world[joint] = (by_second + outer(moved, self.skin.first[joint])) * (2.0 * weights.position);
            at_position[joint] = (by_first + moved * self.skin.mass[joint]) * (2.0 * weights.position);
        }
        let mut gradient = [0.0; SIXES];
        for joint in (1..POSE_TREE).rev() {
            let parent = PARENTS[joint];
            at_position[parent] += at_position[joint];
            at_world[parent] += outer(at_position[joint], self.skin.rest[joint] - self.skin.rest[parent]);
            at_world[parent] += at_world[joint] * decoded.local[joint].transpose();
            let turned = decoded.local[joint] - wanted.local[joint];
            terms.rotation += inner(&turned, &turned);
            let at_local =
                decoded.world[parent].transpose() * at_world[joint] + turned * (2.0 * weights.rotation);
            let six = own(joint);
            let (departure, straighten) = orthogonality(&six);
            terms.orthogonality += departure;
            let pull = rotation::pull_back_6d(&six, &at_local);
            for i in 0..6 {
                gradient[6 * (joint - 1) + i] = pull[i] + weights.orthogonality * straighten[i];
            }
        }
        (terms, gradient)
    }

    /// Positions of the pelvis and the 21 body joints, metres, pelvis unturned at its rest position.
    pub fn joints(&self, pose: &dyn Fn(usize) -> Mat3) -> [Vec3; POSE_TREE] {
        self.skin.figure(pose).position
    }
}

/// Squared departure of two columns from orthonormal ones, `|CᵀC - 1|²`, and its gradient.
fn orthogonality(six: &[f32; 6]) -> (f32, [f32; 6]) {
    let (a, b) = (Vec3::new(six[0], six[2], six[4]), Vec3::new(six[1], six[3], six[5]));
    let (long_a, long_b, across) = (a.length_squared() - 1.0, b.length_squared() - 1.0, a.dot(b));
    let at_a = (a * long_a + b * across) * 4.0;
    let at_b = (b * long_b + a * across) * 4.0;
    let departure = long_a * long_a + long_b * long_b + 2.0 * across * across;
    (departure, [at_a.x, at_b.x, at_a.y, at_b.y, at_a.z, at_b.z])
}

fn outer(column: Vec3, row: Vec3) -> Mat3 {
    Mat3::from_cols(column * row.x, column * row.y, column * row.z)
}

fn inner(a: &Mat3, b: &Mat3) -> f32 {
    a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis) + a.z_axis.dot(b.z_axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Body, carrier, vertex_areas};
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    const WEIGHTS: PoseLossWeights = PoseLossWeights { position: 50.0, rotation: 0.5, orthogonality: 0.3 };

    fn random_pose(rng: &mut ChaCha8Rng) -> BodyPose {
        std::array::from_fn(|_| Vec3::from_array(std::array::from_fn(|_| rng.random_range(-0.6..0.6))))
    }

    fn six_of(pose: &BodyPose) -> Vec<f32> {
        let six = |v: &Vec3| rotation::six_d_from_matrix(&rotation::matrix_from_axis_angle(*v));
        pose.iter().flat_map(six).collect()
    }

    #[test]
    fn the_gradient_agrees_with_finite_differences() {
        let loss = PoseLoss::new(&Body::bundled().model);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let target = random_pose(&mut rng);
        let six: Vec<f32> =
            six_of(&random_pose(&mut rng)).into_iter().map(|s| s + rng.random_range(-0.1..0.1)).collect();
        let (_, analytic) = loss.evaluate(&six, &target, &WEIGHTS);
        for i in 0..SIXES {
            let side = |step: f32| {
                let mut moved = six.clone();
                moved[i] += step;
                f64::from(loss.evaluate(&moved, &target, &WEIGHTS).0.total(&WEIGHTS))
            };
            let numeric = (side(1e-2) - side(-1e-2)) / 2e-2;
            let error = (f64::from(analytic[i]) - numeric).abs();
            assert!(error < 1e-2 + 1e-2 * numeric.abs(), "[{i}]: {} against {numeric}", analytic[i]);
        }
    }

    #[test]
    fn the_true_pose_costs_nothing_and_a_raised_arm_what_its_skin_moves() {
        let loss = PoseLoss::new(&Body::bundled().model);
        let mut pose = [Vec3::ZERO; BODY_JOINTS];
        let (terms, gradient) = loss.evaluate(&six_of(&pose), &pose, &WEIGHTS);
        assert!(terms.total(&WEIGHTS) < 1e-9 && gradient.iter().all(|g| g.abs() < 1e-4));
        pose[crate::body::joints::LEFT_SHOULDER - 1].z = 0.5;
        let (terms, _) = loss.evaluate(&six_of(&pose), &[Vec3::ZERO; BODY_JOINTS], &WEIGHTS);
        // By rigid skin: every vertex of the arm turns about the shoulder.
        let model = &Body::bundled().model;
        let areas = vertex_areas(model);
        let turn = Mat3::from_rotation_z(0.5);
        let shoulder = model.joint_template[16];
        let in_arm = |v: usize| matches!(carrier(model.dominant_joint(v)), 16 | 18 | 20);
        let moved = |p: Vec3| (turn * (p - shoulder) - (p - shoulder)).length_squared();
        let skin: f32 =
            (0..areas.len()).filter(|v| in_arm(*v)).map(|v| areas[v] * moved(model.template[v])).sum();
        let joints: f32 = [18, 20].map(|j| moved(model.joint_template[j])).iter().sum();
        let expected = 0.5 * skin / areas.iter().sum::<f32>() + 0.5 * joints / POSE_TREE as f32;
        assert!(
            (terms.position_m2 / expected - 1.0).abs() < 1e-2,
            "{} against {expected}",
            terms.position_m2
        );
    }
}
