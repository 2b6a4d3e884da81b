//! What decoded rotations cost against the true ones, with its gradient derived by hand.

use glam::{Mat3, Vec3};

use crate::body::BodyModel;
use crate::body::BodyPose;
use crate::body::joints::{BODY_JOINTS, PARENTS};
use crate::math::rotation;

/// The pelvis and the body joints.
const TREE: usize = BODY_JOINTS + 1;
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

/// Positions of skin and joints as the poses move them.
///
/// Skin is taken as moved rigidly by the joint that moves it most. Then the squared displacement of all of it is a
/// quadratic form of each joint's rotation and position with the skin's moments of order 0 to 2, so that every vertex
/// of the body is counted (by its area) at the price of one point a joint.
pub struct PoseLoss {
    rest: [Vec3; TREE],
    mass: [f32; TREE],
    first: [Vec3; TREE],
    second: [Mat3; TREE],
}

/// A pose as rotations and positions, pelvis unturned at its rest position.
struct Figure {
    local: [Mat3; TREE],
    world: [Mat3; TREE],
    position: [Vec3; TREE],
}

impl PoseLoss {
    /// For the mean shape of a body.
    pub fn new(model: &BodyModel) -> Self {
        let rest: [Vec3; TREE] = std::array::from_fn(|joint| model.joint_template[joint]);
        let mut loss =
            Self { rest, mass: [0.0; TREE], first: [Vec3::ZERO; TREE], second: [Mat3::ZERO; TREE] };
        let area = vertex_areas(model);
        let total: f32 = area.iter().sum();
        for (vertex, area) in area.iter().enumerate() {
            let joint = body_joint(model.dominant_joint(vertex));
            // Half for the skin, half for the joints.
            loss.add(joint, model.template[vertex] - rest[joint], 0.5 * area / total);
        }
        (0..TREE).for_each(|joint| loss.add(joint, Vec3::ZERO, 0.5 / TREE as f32));
        loss
    }

    fn add(&mut self, joint: usize, offset: Vec3, mass: f32) {
        self.mass[joint] += mass;
        self.first[joint] += offset * mass;
        self.second[joint] += outer(offset, offset) * mass;
    }

    /// The terms of one pose, and the gradient of their weighted sum with respect to the 126 decoded numbers.
    pub fn evaluate(
        &self,
        six: &[f32],
        target: &BodyPose,
        weights: &PoseLossWeights,
    ) -> (PoseLossTerms, [f32; SIXES]) {
        let own = |joint: usize| -> [f32; 6] { std::array::from_fn(|i| six[6 * (joint - 1) + i]) };
        let decoded = self.figure(&|joint| rotation::matrix_from_6d(&own(joint)));
        let wanted = self.figure(&|joint| rotation::matrix_from_axis_angle(target[joint - 1]));
        let mut terms = PoseLossTerms::default();
        let mut at_world = [Mat3::ZERO; TREE];
        let mut at_position = [Vec3::ZERO; TREE];
        for joint in 0..TREE {
            let turned = decoded.world[joint] - wanted.world[joint];
            let moved = decoded.position[joint] - wanted.position[joint];
            let (by_second, by_first) = (turned * self.second[joint], turned * self.first[joint]);
            terms.position_m2 += inner(&by_second, &turned)
                + 2.0 * moved.dot(by_first)
                + self.mass[joint] * moved.length_squared();
            at_world[joint] = (by_second + outer(moved, self.first[joint])) * (2.0 * weights.position);
            at_position[joint] = (by_first + moved * self.mass[joint]) * (2.0 * weights.position);
        }
        let mut gradient = [0.0; SIXES];
        for joint in (1..TREE).rev() {
            let parent = PARENTS[joint];
            at_position[parent] += at_position[joint];
            at_world[parent] += outer(at_position[joint], self.rest[joint] - self.rest[parent]);
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
    pub fn joints(&self, pose: &dyn Fn(usize) -> Mat3) -> [Vec3; TREE] {
        self.figure(pose).position
    }

    fn figure(&self, local: &dyn Fn(usize) -> Mat3) -> Figure {
        let mut figure =
            Figure { local: [Mat3::IDENTITY; TREE], world: [Mat3::IDENTITY; TREE], position: self.rest };
        for joint in 1..TREE {
            let parent = PARENTS[joint];
            figure.local[joint] = local(joint);
            figure.world[joint] = figure.world[parent] * figure.local[joint];
            figure.position[joint] =
                figure.position[parent] + figure.world[parent] * (self.rest[joint] - self.rest[parent]);
        }
        figure
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

/// The body joint that carries a joint: fingers are the wrist's, the face is the head's.
fn body_joint(mut joint: usize) -> usize {
    while joint >= TREE {
        joint = PARENTS[joint];
    }
    joint
}

fn vertex_areas(model: &BodyModel) -> Vec<f32> {
    let mut areas = vec![0.0; model.template.len()];
    for face in &model.faces {
        let [a, b, c] = face.map(|i| model.template[i as usize]);
        let third = (b - a).cross(c - a).length() / 6.0;
        face.iter().for_each(|i| areas[*i as usize] += third);
    }
    areas
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
    use crate::body::Body;
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
        let in_arm = |v: usize| matches!(body_joint(model.dominant_joint(v)), 16 | 18 | 20);
        let moved = |p: Vec3| (turn * (p - shoulder) - (p - shoulder)).length_squared();
        let skin: f32 =
            (0..areas.len()).filter(|v| in_arm(*v)).map(|v| areas[v] * moved(model.template[v])).sum();
        let joints: f32 = [18, 20].map(|j| moved(model.joint_template[j])).iter().sum();
        let expected = 0.5 * skin / areas.iter().sum::<f32>() + 0.5 * joints / TREE as f32;
        assert!(
            (terms.position_m2 / expected - 1.0).abs() < 1e-2,
            "{} against {expected}",
            terms.position_m2
        );
    }
}
