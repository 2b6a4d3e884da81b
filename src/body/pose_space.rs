use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::scene::POSE;

use super::hand_space::{HAND_CODE, HandSpace};
use super::joints::BODY_JOINTS;

/// Axis-angle vectors of SMPL-X's body joints 1 to 21, radians, each in its parent's frame.
pub type BodyPose = [Vec3; BODY_JOINTS];

/// What a pose space remembers of a decoding for its gradient; scratch memory that is reused.
#[derive(Clone, Debug, Default)]
pub struct PoseTape(pub(super) Vec<f32>);

/// A map from a 32-number code of unit variance to a body pose, and its gradient. The fitter knows nothing
/// else about poses, so the Gaussian of today and a learned prior are exchangeable.
pub trait PoseSpace: Send + Sync {
    /// The pose of a code; `tape` keeps what [`PoseSpace::pull_back_taped`] needs.
    fn decode_taped(&self, code: &[f32; POSE], tape: &mut PoseTape) -> BodyPose;

    /// Gradient of `f(decode(code))` with respect to the code, given `gradient = df/dpose` and the tape of the
    /// decoding of the same code.
    fn pull_back_taped(&self, code: &[f32; POSE], tape: &PoseTape, gradient: &BodyPose) -> [f32; POSE];

    /// The pose of a code.
    fn decode(&self, code: &[f32; POSE]) -> BodyPose {
        self.decode_taped(code, &mut PoseTape::default())
    }

    /// Gradient of `f(decode(code))` with respect to the code, given `gradient = df/dpose`.
    fn pull_back(&self, code: &[f32; POSE], gradient: &BodyPose) -> [f32; POSE] {
        let mut tape = PoseTape::default();
        self.decode_taped(code, &mut tape);
        self.pull_back_taped(code, &tape, gradient)
    }

    /// The code whose pose is nearest to `pose`.
    fn encode(&self, pose: &BodyPose) -> [f32; POSE];

    /// Negative log likelihood of a code under the standard normal prior, less its constant: `|z|²/2`.
    /// Its gradient is the code itself.
    fn prior_energy(&self, code: &[f32; POSE]) -> f32 {
        0.5 * code.iter().map(|z| z * z).sum::<f32>()
    }
}

/// Poses as a Gaussian: `pose = mean + directions · code`, over the 63 axis-angle numbers. The directions
/// are the leading principal components of a corpus times their standard deviations, so codes of the
/// corpus are whitened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseGaussian {
    /// Mean pose.
    pub mean: BodyPose,
    /// For each code number the change of the pose per standard deviation; mutually orthogonal.
    pub directions: Vec<BodyPose>,
}

impl PoseGaussian {
    /// Whether there is one direction of positive length for every code number.
    pub fn is_complete(&self) -> bool {
        self.directions.len() == POSE && self.directions.iter().all(|d| squared(d) > 0.0)
    }
}

impl PoseSpace for PoseGaussian {
    fn decode_taped(&self, code: &[f32; POSE], _tape: &mut PoseTape) -> BodyPose {
        let mut pose = self.mean;
        for (direction, z) in self.directions.iter().zip(code) {
            for (angle, step) in pose.iter_mut().zip(direction) {
                *angle += *step * *z;
            }
        }
        pose
    }

    fn pull_back_taped(&self, _code: &[f32; POSE], _tape: &PoseTape, gradient: &BodyPose) -> [f32; POSE] {
        std::array::from_fn(|i| dot(&self.directions[i], gradient))
    }

    fn encode(&self, pose: &BodyPose) -> [f32; POSE] {
        let offset: BodyPose = std::array::from_fn(|j| pose[j] - self.mean[j]);
        std::array::from_fn(|i| dot(&self.directions[i], &offset) / squared(&self.directions[i]))
    }
}

/// Both spaces as one file: what `inhabit train pose-prior` writes and the program embeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseStatistics {
    /// Body poses.
    pub poses: PoseGaussian,
    /// Hand poses.
    pub hands: HandSpace,
}

/// Why a pose statistics file can't be used.
#[derive(Debug, thiserror::Error)]
pub enum PoseStatisticsError {
    /// Not the text it should be.
    #[error("pose statistics: {0}; make the file again with `inhabit train pose-prior`")]
    Syntax(#[from] ron::error::SpannedError),
    /// Too few directions.
    #[error(
        "pose statistics: {POSE} body and {HAND_CODE} hand directions are needed; make the file again with `inhabit train pose-prior`"
    )]
    Incomplete,
}

impl PoseStatistics {
    /// Reads the RON text of a statistics file.
    ///
    /// # Errors
    /// [`PoseStatisticsError`].
    pub fn from_ron(text: &str) -> Result<Self, PoseStatisticsError> {
        let statistics: Self = ron::from_str(text)?;
        let complete = statistics.poses.is_complete() && statistics.hands.is_complete();
        if complete { Ok(statistics) } else { Err(PoseStatisticsError::Incomplete) }
    }

    /// The RON text of a statistics file.
    ///
    /// # Errors
    /// What the serialiser says; it never fails on numbers.
    pub fn to_ron(&self) -> Result<String, ron::Error> {
        ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new().depth_limit(3))
    }
}

fn dot(a: &BodyPose, b: &BodyPose) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

fn squared(a: &BodyPose) -> f32 {
    dot(a, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;

    #[test]
    fn a_code_survives_decoding_and_encoding() {
        let body = Body::bundled();
        let code: [f32; POSE] = std::array::from_fn(|i| (i as f32 * 1.7).sin());
        let back = body.pose_space.encode(&body.pose_space.decode(&code));
        for (a, b) in code.iter().zip(back) {
            assert!((a - b).abs() < 1e-3, "{a} came back as {b}");
        }
    }

    #[test]
    fn statistics_survive_a_round_trip_and_a_short_file_is_refused() {
        let text = include_str!("../../assets/body/pose_statistics.ron");
        let mut statistics = PoseStatistics::from_ron(text).expect("bundled");
        let again = PoseStatistics::from_ron(&statistics.to_ron().expect("text")).expect("round trip");
        assert_eq!(again, statistics);
        statistics.poses.directions.pop();
        let short = PoseStatistics::from_ron(&statistics.to_ron().expect("text"));
        assert!(matches!(short, Err(PoseStatisticsError::Incomplete)));
        assert!(matches!(PoseStatistics::from_ron("(poses:"), Err(PoseStatisticsError::Syntax(_))));
    }
}
