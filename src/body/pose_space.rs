use glam::Vec3;

use crate::scene::POSE;

use super::joints::{self, BODY_JOINTS};

/// Axis-angle vectors of SMPL-X's body joints 1 to 21, radians, each in its parent's frame.
pub type BodyPose = [Vec3; BODY_JOINTS];

/// The pose as its mirror image.
pub fn mirrored(pose: &BodyPose) -> BodyPose {
    std::array::from_fn(|j| joints::mirror_axis_angle(pose[joints::mirror(j + 1) - 1]))
}

/// What a pose space remembers of a decoding for its gradient; scratch memory that is reused.
#[derive(Clone, Debug, Default)]
pub struct PoseTape(pub(super) Vec<f32>);

/// A map from a 32-number code of unit variance to a body pose, and its gradient. The fitter knows nothing
/// else about poses, so one prior can take another's place.
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

#[cfg(test)]
mod tests {
    use crate::body::Body;
    use crate::scene::{BodyParams, POSE};

    #[test]
    fn a_pose_survives_encoding_and_decoding() {
        let body = Body::bundled();
        for number in 0..8 {
            let code: [f32; POSE] = std::array::from_fn(|i| ((i * 7 + number * 3) as f32 * 1.7).sin());
            let pose = body.pose_space.decode(&code);
            let back = body.pose_space.decode(&body.pose_space.encode(&pose));
            let joints = |pose| body.pose_axis_angles(&BodyParams::default(), pose).joints;
            let (a, b) = (joints(&pose), joints(&back));
            let mean_m = (0..22).map(|j| a[j].distance(b[j])).sum::<f32>() / 22.0;
            assert!(mean_m < 0.008, "code {number} came back {mean_m} m off");
        }
    }
}
