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

/// Why a hand space can't be used.
#[derive(Debug, thiserror::Error)]
pub enum HandSpaceError {
    /// Not the text it should be.
    #[error("hand space: {0}; make the file again with `inhabit train hand-space`")]
    Syntax(#[from] ron::error::SpannedError),
    /// Too few directions.
    #[error(
        "hand space: {HAND_CODE} directions are needed; make the file again with `inhabit train hand-space`"
    )]
    Incomplete,
}

impl HandSpace {
    /// Reads the RON text of a hand space.
    ///
    /// # Errors
    /// [`HandSpaceError`].
    pub fn from_ron(text: &str) -> Result<Self, HandSpaceError> {
        let hands: Self = ron::from_str(text)?;
        if hands.is_complete() { Ok(hands) } else { Err(HandSpaceError::Incomplete) }
    }

    /// The RON text of a hand space.
    ///
    /// # Errors
    /// What the serialiser says; it never fails on numbers.
    pub fn to_ron(&self) -> Result<String, ron::Error> {
        ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new().depth_limit(2))
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_space_survives_a_round_trip_and_a_short_file_is_refused() {
        let text = include_str!("../../assets/body/hand_space.ron");
        let mut hands = HandSpace::from_ron(text).expect("bundled");
        assert_eq!(HandSpace::from_ron(&hands.to_ron().expect("text")).expect("round trip"), hands);
        hands.directions.pop();
        let short = HandSpace::from_ron(&hands.to_ron().expect("text"));
        assert!(matches!(short, Err(HandSpaceError::Incomplete)));
        assert!(matches!(HandSpace::from_ron("(mean:"), Err(HandSpaceError::Syntax(_))));
    }
}
