//! The hand space, fitted on clips and on the program's own hands.
//!
//! Pure: takes clips, returns numbers; the same seed gives the same numbers.

use glam::Vec3;

use crate::assets::PoseClip;
use crate::body::joints::{self, LEFT_HAND, RIGHT_HAND};
use crate::body::{Body, FamilyHints, HAND_CODE, HAND_JOINTS, HandShape, HandSpace, sample_pose};
use crate::job::Seed;
use crate::math::symmetric_eigen;
use crate::scene::PoseFamily;

/// Poses drawn of each family.
const SAMPLES_A_FAMILY: usize = 1500;
/// Weight of all clips together, where each of the ten families weighs 1: clips walk, kneel and crouch, which
/// no family does.
const WEIGHT_OF_CLIPS: f64 = 1.5;
/// Least deviation of a direction, radians: a direction that the data hardly use still takes a code number.
const LEAST_DEVIATION: f64 = 0.01;

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
