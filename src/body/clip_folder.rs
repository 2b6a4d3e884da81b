//! Motion clips of a folder, all carried over to this body.

use std::path::Path;

use super::Body;
use super::retarget::{RetargetError, retarget};
use crate::assets::MotionContent;
use crate::assets::MotionFolderError;
use crate::assets::PoseClip;
use crate::assets::motion_files;
use crate::assets::read_motion_file;

/// Why a folder gives no clips.
#[derive(Debug, thiserror::Error)]
pub enum ClipFolderError {
    /// It can't be read.
    #[error(transparent)]
    Read(#[from] MotionFolderError),
    /// The skeleton of a file is none that is known.
    #[error("{file}: {problem}")]
    Skeleton {
        /// The file.
        file: String,
        /// What is wrong.
        problem: RetargetError,
    },
    /// There is nothing in it.
    #[error(
        "{folder} holds no clip: put npz archives with `NAME/pose` arrays, BVH files or DeepMimic's text there"
    )]
    Empty {
        /// The folder.
        folder: String,
    },
}

/// Every clip of `folder` and the folders below, in the order of their paths.
///
/// # Errors
/// When a file that should be a clip can't be read, or there is none at all.
pub fn read_clips(folder: &Path) -> Result<Vec<PoseClip>, ClipFolderError> {
    let rest = &Body::bundled().model.joint_template;
    let mut clips = Vec::new();
    for file in motion_files(folder).map_err(MotionFolderError::from)? {
        match read_motion_file(&file)? {
            MotionContent::Clips(of_file) => clips.extend(of_file),
            MotionContent::Rig(motion) => clips.push(retarget(&motion, rest).map_err(|problem| {
                ClipFolderError::Skeleton { file: file.display().to_string(), problem }
            })?),
            MotionContent::Nothing => {}
        }
    }
    if clips.is_empty() {
        return Err(ClipFolderError::Empty { folder: folder.display().to_string() });
    }
    Ok(clips)
}
