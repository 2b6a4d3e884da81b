//! The parametric body: 75 numbers to vertices and joints, and gradients back; pose space; contact regions.
//!
//! May name `math`, `assets`, `scene`. Pure: reads no file itself (the bundled model is embedded), optimises
//! nothing, knows no room.
//!
//! Body frame: metres, T-pose at rest, Y up, front +Z, left +X, pelvis joint near the origin; joints in
//! SMPL-X's order ([`joints`]).

mod clip_folder;
mod export;
mod export_clip;
mod families;
mod feet;
mod hand_space;
mod hands;
mod ik;
pub mod joints;
mod limits;
mod model;
mod parts;
mod pose_decoder;
mod pose_space;
mod posed;
mod regions;
mod retarget;
mod skin_form;
mod skin_moments;
mod subset;
mod workspace;

pub use clip_folder::{ClipFolderError, read_clips};
pub use export::skinned_mesh;
pub use export_clip::{amass_motion, rig_motion, skinned_clip};
pub use families::{Attention, FamilyHints, HandOn, LeanStyle, LyingSide, SampledPose, sample_pose};
pub use feet::{Feet, FootPose, TREADS};
pub use hand_space::{HAND_CODE, HAND_JOINTS, HandSpace, HandSpaceError};
pub use hands::HandShape;
pub use ik::{Bend, FrameJoints, Limb, axes, two_bone};
pub use limits::{JointLimit, joint_limits, worst_excess};
pub use model::{BodyModel, BodyModelError};
pub use parts::{BodyPart, BodyParts, Seams, part_at};
pub use pose_decoder::PoseDecoder;
pub use pose_space::{BodyPose, PoseSpace, PoseTape, mirrored};
pub use posed::{Body, Posed};
pub use regions::{ContactRegions, Region};
pub use retarget::{RetargetError, retarget};
pub use skin_form::{SkinForm, SkinMatrices};
pub use skin_moments::{POSE_TREE, PoseFigure, SkinMoments, carrier, vertex_areas};
pub use subset::VertexSubset;
pub use workspace::{Gradients, PosedGradient, Workspace};
