//! People's joints in space from their joints in a photo: shapes as sparse sums of bases, each turned by itself, by the
//! convex relaxation of Zhou et al. 2015 (3D shape estimation from 2D landmarks), then refined to one rotation.
//!
//! Joints are COCO's 17. A pose's own frame has the left to +X, up +Y, the front +Z, as the body at rest; the camera's
//! frame has right +X, up +Y and the viewer at +Z. Both are right-handed; lengths have no unit before a torso gives
//! them one.

mod convex;
mod dictionary;
mod examples;
mod refine;
mod solver;

pub use dictionary::{DictionaryConfig, PoseDictionary, PoseDictionaryError, learn_dictionary};
pub use examples::{JointPlacer, clip_poses, family_poses};
pub use solver::{Pose3d, PoseSolver, PoseSolverConfig, SOLVED_JOINTS_LEAST};

use glam::Vec3;

use crate::assets::photos::PHOTO_JOINTS;

/// Joints of a pose in space, COCO's 17.
pub type Joints3 = [Vec3; PHOTO_JOINTS];

/// Numbers of joints among COCO's 17.
pub mod coco {
    /// Nose.
    pub const NOSE: usize = 0;
    /// Left shoulder.
    pub const LEFT_SHOULDER: usize = 5;
    /// Right shoulder.
    pub const RIGHT_SHOULDER: usize = 6;
    /// Left elbow.
    pub const LEFT_ELBOW: usize = 7;
    /// Right elbow.
    pub const RIGHT_ELBOW: usize = 8;
    /// Left wrist.
    pub const LEFT_WRIST: usize = 9;
    /// Right wrist.
    pub const RIGHT_WRIST: usize = 10;
    /// Left hip.
    pub const LEFT_HIP: usize = 11;
    /// Right hip.
    pub const RIGHT_HIP: usize = 12;
    /// Left knee.
    pub const LEFT_KNEE: usize = 13;
    /// Right knee.
    pub const RIGHT_KNEE: usize = 14;
    /// Left ankle.
    pub const LEFT_ANKLE: usize = 15;
    /// Right ankle.
    pub const RIGHT_ANKLE: usize = 16;
}

/// Middle of the shoulders.
pub fn middle_of_shoulders(joints: &Joints3) -> Vec3 {
    (joints[coco::LEFT_SHOULDER] + joints[coco::RIGHT_SHOULDER]) * 0.5
}

/// Middle of the hips.
pub fn middle_of_hips(joints: &Joints3) -> Vec3 {
    (joints[coco::LEFT_HIP] + joints[coco::RIGHT_HIP]) * 0.5
}
