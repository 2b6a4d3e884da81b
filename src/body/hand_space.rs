use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::scene::HANDS;

use super::joints;

/// Joints of one hand: index, middle, pinky, ring, thumb, three each.
pub const HAND_JOINTS: usize = 15;
/// Code numbers of one hand (PSI §3.1: the 24 hand numbers are 12 a hand).
pub const HAND_CODE: usize = HANDS / 2;

/// Hand poses as a Gaussian: `pose = mean + directions · code`; given for the left hand, the right hand is
/// its mirror image. Code zero is a relaxed hand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandSpace {
    /// Mean axis-angles of the left hand.
    pub mean: [Vec3; HAND_JOINTS],
    /// For each code number the change of the left hand per standard deviation; mutually orthogonal.
    pub directions: Vec<[Vec3; HAND_JOINTS]>,
}

impl HandSpace {
    /// Whether there is one direction for every code number.
    pub fn is_complete(&self) -> bool {
        self.directions.len() == HAND_CODE
    }

    /// Axis-angles of both hands, left then right.
    pub fn decode(&self, code: &[f32; HANDS]) -> [[Vec3; HAND_JOINTS]; 2] {
        let (left, right) = code.split_at(HAND_CODE);
        [self.decode_left(left), self.decode_left(right).map(joints::mirror_axis_angle)]
    }

    fn decode_left(&self, code: &[f32]) -> [Vec3; HAND_JOINTS] {
        let mut pose = self.mean;
        for (direction, z) in self.directions.iter().zip(code) {
            for (angle, step) in pose.iter_mut().zip(direction) {
                *angle += *step * *z;
            }
        }
        pose
    }

    /// Gradient of `f(decode(code))` with respect to the code, given the gradient of both hands.
    pub fn pull_back(&self, gradient: &[[Vec3; HAND_JOINTS]; 2]) -> [f32; HANDS] {
        let right = gradient[1].map(joints::mirror_axis_angle);
        std::array::from_fn(|i| match i.checked_sub(HAND_CODE) {
            None => dot(&self.directions[i], &gradient[0]),
            Some(i) => dot(&self.directions[i], &right),
        })
    }

    /// The code nearest to a pose of one hand; a right hand is given mirrored
    /// ([`joints::mirror_axis_angle`]).
    pub fn encode_left(&self, pose: &[Vec3; HAND_JOINTS]) -> [f32; HAND_CODE] {
        let offset: [Vec3; HAND_JOINTS] = std::array::from_fn(|j| pose[j] - self.mean[j]);
        std::array::from_fn(|i| {
            let direction = &self.directions[i];
            let squared = dot(direction, direction);
            if squared > 0.0 { dot(direction, &offset) / squared } else { 0.0 }
        })
    }
}

fn dot(a: &[Vec3; HAND_JOINTS], b: &[Vec3; HAND_JOINTS]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}
