//! Poses that dictionaries are learned from and judged by: frames of clips and draws of the pose families.

use glam::Vec3;
use rand::RngExt as _;

use super::Joints3;
use crate::assets::{KeypointSet, PoseClip};
use crate::body::{Body, BodyPose, FamilyHints, Workspace, sample_pose};
use crate::fit::estimation::Landmarks;
use crate::job::{Cancelled, Seed, Ticker};
use crate::scene::{BodyParams, PoseFamily};

/// Places COCO's joints of posed mean bodies.
pub struct JointPlacer<'a> {
    body: &'a Body,
    landmarks: Landmarks,
    workspace: Workspace,
}

impl<'a> JointPlacer<'a> {
    /// For `body`.
    pub fn new(body: &'a Body) -> Self {
        Self { body, landmarks: Landmarks::of(&body.model), workspace: Workspace::default() }
    }

    /// COCO's joints of the mean body in a pose, body frame, metres.
    pub fn joints(&mut self, pose: &BodyPose) -> Joints3 {
        self.joints_of(&BodyParams::default(), pose)
    }

    /// COCO's joints of a body with these axis-angles, world frame, metres.
    pub fn joints_of(&mut self, params: &BodyParams, pose: &BodyPose) -> Joints3 {
        self.body.forward_posed(params, pose, &self.landmarks.subset, &mut self.workspace);
        let places = Landmarks::positions(KeypointSet::Coco17, &self.workspace);
        std::array::from_fn(|j| places[j])
    }
}

/// Poses of clips at so many frames a second, of the clips that `wanted` names.
pub fn clip_poses(clips: &[PoseClip], frames_a_second: f32, wanted: impl Fn(&str) -> bool) -> Vec<BodyPose> {
    let chosen = clips.iter().filter(|clip| wanted(&clip.name));
    chosen
        .flat_map(|clip| {
            let stride = (1.0 / (frames_a_second * clip.frame_seconds)).round().max(1.0) as usize;
            clip.frames.iter().step_by(stride).map(|frame| std::array::from_fn(|j| frame[j + 1]))
        })
        .filter(|pose: &BodyPose| !is_calibration(pose))
        .collect()
}

/// Both arms straight out, as files begin.
fn is_calibration(pose: &BodyPose) -> bool {
    use crate::body::joints as j;
    let arms = [j::LEFT_SHOULDER, j::RIGHT_SHOULDER, j::LEFT_ELBOW, j::RIGHT_ELBOW];
    arms.iter().all(|joint| pose[joint - 1].length() < 0.35)
}

/// Draws of every pose family, half of the seated ones with their hands at a table.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn family_poses(
    body: &Body,
    each: usize,
    seed: Seed,
    ticker: &Ticker,
) -> Result<Vec<BodyPose>, Cancelled> {
    let mut poses = Vec::with_capacity(each * PoseFamily::ALL.len());
    for family in PoseFamily::ALL {
        let mut rng = seed.child(family.label(), 0).rng();
        for index in 0..each {
            if index % 64 == 0 {
                ticker.check()?;
            }
            let table = rng.random::<bool>().then(|| rng.random_range(0.66..0.95));
            let hints = FamilyHints { table_height_m: table, ..FamilyHints::default() };
            poses.push(sample_pose(&body.model.joint_template, family, &mut rng, &hints).pose);
        }
    }
    Ok(poses)
}

/// The joints as their mirror image: left and right exchanged.
pub(super) fn mirrored(joints: &Joints3) -> Joints3 {
    // COCO lists the nose, then left and right in turn.
    let other = |j: usize| if j == 0 { 0 } else { ((j - 1) ^ 1) + 1 };
    std::array::from_fn(|j| joints[other(j)] * Vec3::new(-1.0, 1.0, 1.0))
}
