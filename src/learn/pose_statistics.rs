//! The Gaussian pose space and the hand space, fitted on clips and on the program's own pose families.
//!
//! Pure: takes clips, returns statistics; the same seed gives the same numbers.

use glam::Vec3;

use super::pose_corpus::random_hints;
use crate::assets::PoseClip;
use crate::body::joints::{self, BODY_JOINTS, LEFT_HAND, RIGHT_HAND};
use crate::body::{
    Body, BodyPose, FamilyHints, HAND_CODE, HAND_JOINTS, HandShape, HandSpace, PoseGaussian, PoseStatistics,
    sample_pose,
};
use crate::job::Seed;
use crate::math::symmetric_eigen;
use crate::scene::{POSE, PoseFamily};


/// Poses drawn of each family.
const SAMPLES_A_FAMILY: usize = 1500;
/// Weight of all clips together, where each of the ten families weighs 1: clips walk, kneel and crouch, which
/// no family does.
const WEIGHT_OF_CLIPS: f64 = 1.5;
/// Least deviation of a direction, radians: a direction that the data hardly use still takes a code number.
const LEAST_DEVIATION: f64 = 0.01;

/// Fits both spaces.
pub fn fit_pose_statistics(clips: &[PoseClip], seed: Seed) -> PoseStatistics {
    PoseStatistics { poses: fit_pose_gaussian(clips, seed), hands: fit_hand_space(clips, seed) }
}

/// Fits the pose space: principal components of every clip frame and of samples of every pose family, each
/// also mirrored, with every family weighing the same.
pub fn fit_pose_gaussian(clips: &[PoseClip], seed: Seed) -> PoseGaussian {
    let mut corpus = Corpus::default();
    for family in PoseFamily::ALL {
        let mut rng = seed.child(family.label(), 0).rng();
        for _ in 0..SAMPLES_A_FAMILY {
            let hints = random_hints(family, &mut rng);
            let pose = sample_pose(&Body::bundled().model.joint_template, family, &mut rng, &hints).pose;
            corpus.add_with_mirror(&pose, 1.0 / SAMPLES_A_FAMILY as f64);
        }
    }
    let frames: usize = clips.iter().map(|clip| clip.frames.len()).sum();
    for frame in clips.iter().flat_map(|clip| &clip.frames) {
        let pose: BodyPose = std::array::from_fn(|j| frame[j + 1]);
        corpus.add_with_mirror(&pose, WEIGHT_OF_CLIPS / frames as f64);
    }
    let (mean, directions) = corpus.principal_directions(POSE);
    PoseGaussian { mean: joints_of(&mean), directions: directions.iter().map(|d| joints_of(d)).collect() }
}

/// Fits the hand space: principal components of the clips' hands (right ones mirrored) and of relaxed, resting,
/// flat, closed and pointing hands.
pub fn fit_hand_space(clips: &[PoseClip], seed: Seed) -> HandSpace {
    let mut corpus = Corpus::default();
    let mut rng = seed.child("hands", 0).rng();
    for family in PoseFamily::ALL {
        for _ in 0..SAMPLES_A_FAMILY {
            let rest = &Body::bundled().model.joint_template;
            for hand in sample_pose(rest, family, &mut rng, &FamilyHints::default()).hands {
                corpus.add(&flat(&hand.left_pose()), 1.0 / SAMPLES_A_FAMILY as f64);
            }
        }
    }
    for shape in [HandShape::fist(), HandShape::pointing()] {
        corpus.add(&flat(&shape.left_pose()), 0.5);
    }
    let frames: usize = clips.iter().map(|clip| clip.frames.len()).sum();
    for frame in clips.iter().flat_map(|clip| &clip.frames) {
        let left: [Vec3; HAND_JOINTS] = std::array::from_fn(|j| frame[LEFT_HAND + j]);
        let right: [Vec3; HAND_JOINTS] =
            std::array::from_fn(|j| joints::mirror_axis_angle(frame[RIGHT_HAND + j]));
        for hand in [left, right] {
            corpus.add(&flat(&hand), WEIGHT_OF_CLIPS / frames as f64);
        }
    }
    let (mean, directions) = corpus.principal_directions(HAND_CODE);
    HandSpace { mean: joints_of(&mean), directions: directions.iter().map(|d| joints_of(d)).collect() }
}

/// Weighted vectors.
#[derive(Default)]
struct Corpus {
    rows: Vec<(f64, Vec<f64>)>,
}

impl Corpus {
    fn add(&mut self, row: &[f64], weight: f64) {
        self.rows.push((weight, row.to_vec()));
    }

    fn add_with_mirror(&mut self, pose: &BodyPose, weight: f64) {
        let mirrored: BodyPose = std::array::from_fn(|j| {
            let other = joints::mirror(j + 1);
            joints::mirror_axis_angle(pose[other - 1])
        });
        self.add(&flat(pose), weight);
        self.add(&flat(&mirrored), weight);
    }

    /// The mean and the leading principal components, each as long as its standard deviation.
    fn principal_directions(&self, count: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
        let total: f64 = self.rows.iter().map(|(weight, _)| weight).sum();
        let width = self.rows.first().map_or(0, |(_, row)| row.len());
        let mut mean = vec![0.0; width];
        for (weight, row) in &self.rows {
            mean.iter_mut().zip(row).for_each(|(m, x)| *m += weight / total * x);
        }
        let mut covariance = vec![vec![0.0; width]; width];
        for (weight, row) in &self.rows {
            for i in 0..width {
                let scaled = weight / total * (row[i] - mean[i]);
                for j in 0..width {
                    covariance[i][j] += scaled * (row[j] - mean[j]);
                }
            }
        }
        let directions = symmetric_eigen(&covariance).into_iter().take(count);
        let directions = directions.map(|(variance, axis)| {
            let deviation = variance.max(0.0).sqrt().max(LEAST_DEVIATION);
            axis.iter().map(|x| x * deviation).collect()
        });
        (mean, directions.collect())
    }
}

fn flat(joints: &[Vec3]) -> Vec<f64> {
    joints.iter().flat_map(|v| v.to_array().map(f64::from)).collect()
}

fn joints_of<const N: usize>(flat: &[f64]) -> [Vec3; N] {
    std::array::from_fn(|j| Vec3::new(flat[3 * j] as f32, flat[3 * j + 1] as f32, flat[3 * j + 2] as f32))
}

/// Mean over joints and samples of the angle in degrees between a family's poses and what the pose space
/// makes of them; the second number is the mean of |code|², which is 32 for draws from the prior.
pub fn family_fit(body: &Body, family: PoseFamily, samples: usize, seed: Seed) -> (f32, f32) {
    let mut rng = seed.child(family.label(), 1).rng();
    let (mut degrees, mut squared) = (0.0, 0.0);
    for _ in 0..samples {
        let hints = random_hints(family, &mut rng);
        let pose = sample_pose(&body.model.joint_template, family, &mut rng, &hints).pose;
        let code = body.pose_space.encode(&pose);
        let back = body.pose_space.decode(&code);
        let angle = |j: usize| {
            let turn = |v| crate::math::rotation::matrix_from_axis_angle(v);
            let between = turn(pose[j]).transpose() * turn(back[j]);
            crate::math::rotation::axis_angle_from_matrix(between).length().to_degrees()
        };
        degrees += (0..BODY_JOINTS).map(angle).sum::<f32>() / BODY_JOINTS as f32;
        squared += code.iter().map(|z| z * z).sum::<f32>();
    }
    (degrees / samples as f32, squared / samples as f32)
}
