//! Files to checked, immutable values and back: glTF, OBJ, PLY, images, npz, BVH, annotations of photos, weights, the
//! disk cache.
//!
//! May name `math` only. No file is trusted: counts are checked against a [`Budget`] and against the bytes
//! that are there before anything is allocated; paths inside a file stay in its folder; nothing is fetched.
//! May not guess what things mean (units, categories): that is `scene`'s.

pub mod cache;
mod clips;
pub mod npz;

mod amass;
mod bvh;
mod bvh_write;
mod deepmimic;
mod rig_motion;
mod weights;

mod budget;
mod bundle;
mod encode;
mod error;
mod furniture;
mod gif;
mod gltf;
mod hash;
mod keypoints;
mod mend;
mod model;
mod motion_folder;
mod npz_write;
mod obj;
mod objects;
pub mod photos;
mod picture;
mod ply;
mod read;
mod samples;
mod triangulate;
mod uri;
mod write_glb;

pub use amass::{AMASS_JOINTS, AmassMotion};
pub use budget::Budget;
pub use bvh::{MotionFileError, read_bvh};
pub use bvh_write::write_bvh;
pub use clips::{CLIP_JOINTS, PoseClip, read_pose_clips};
pub use deepmimic::read_deepmimic;
pub use encode::{encode_jpeg, encode_png};
pub use error::{AssetError, Problem};
pub use furniture::{furniture_model, furniture_names};
pub use gif::{GifError, GifWriter};
pub use hash::{ContentHasher, NumberHasher, NumberMap, content_hash};
pub use keypoints::{
    Keypoint, KeypointSet, PersonKeypoints, PictureKeypoints, read_keypoints, read_keypoints_bytes,
};
pub use model::{AlphaMode, ImageFile, Material, Mesh, Model, Part, Texture};
pub use motion_folder::{MotionContent, MotionFolderError, motion_files, read_motion_file};
pub use objects::{library_text, object_model, object_names};
pub use picture::read_photo;
pub use read::{read_model, read_model_bytes};
pub use rig_motion::{RigJoint, RigMotion};
pub use samples::{SampleRoom, sample_rooms};
pub use weights::{Precision, WeightTensor, Weights, WeightsError};
pub use write_glb::{
    GlbWriteError, ObjectKey, ObjectMotion, SkinJoint, SkinMotion, SkinnedMesh, glb_from_model,
    glb_from_skinned, glb_of_motions, glb_with_people,
};
