//! Motion clips of a folder, whatever format each file has.

use std::fs;
use std::path::{Path, PathBuf};

use super::budget::Budget;
use super::bvh::{MotionFileError, read_bvh};
use super::clips::{PoseClip, read_pose_clips};
use super::deepmimic::read_deepmimic;
use super::error::{AssetError, Fault};
use super::npz::{Npz, NpzError};
use super::rig_motion::RigMotion;
use super::uri::read_plain_file;

/// What a file of a folder of motions holds.
#[derive(Clone, Debug)]
pub enum MotionContent {
    /// Clips of bodies like ours.
    Clips(Vec<PoseClip>),
    /// A motion of another skeleton.
    Rig(RigMotion),
    /// A licence, a note, something else.
    Nothing,
}

/// Why a folder of motions can't be read.
#[derive(Debug, thiserror::Error)]
pub enum MotionFolderError {
    /// The folder or a file can't be read.
    #[error(transparent)]
    File(#[from] AssetError),
    /// An archive is not what it should be.
    #[error(transparent)]
    Archive(#[from] NpzError),
    /// A BVH or DeepMimic file is not what it should be.
    #[error(transparent)]
    Motion(#[from] MotionFileError),
}

/// Every file of `folder` and the folders below, by path.
///
/// # Errors
/// When a folder can't be listed.
pub fn motion_files(folder: &Path) -> Result<Vec<PathBuf>, AssetError> {
    let mut files = Vec::new();
    list(folder, &mut files)?;
    files.sort();
    Ok(files)
}

fn list(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), AssetError> {
    let refused = |error| Fault::new("the folder itself", error).in_file(&folder.display().to_string());
    for entry in fs::read_dir(folder).map_err(refused)? {
        let path = entry.map_err(refused)?.path();
        if path.is_dir() { list(&path, files)? } else { files.push(path) }
    }
    Ok(())
}

/// Reads a file of motions: npz archives with `NAME/pose` arrays, BVH, DeepMimic's text. Motions are named after the
/// file and the folder that it is in (`cmu/02_01`).
///
/// # Errors
/// When a file that should hold motions can't be read.
pub fn read_motion_file(file: &Path) -> Result<MotionContent, MotionFolderError> {
    let shown = file.display().to_string();
    let ending = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let bytes = || read_plain_file(file, &Budget::default()).map_err(|fault| fault.in_file(&shown));
    let text = || Ok::<_, AssetError>(String::from_utf8_lossy(&bytes()?).into_owned());
    Ok(match ending.as_str() {
        "npz" => MotionContent::Clips(read_pose_clips(&Npz::from_bytes(&shown, &bytes()?)?)?),
        "bvh" => MotionContent::Rig(read_bvh(&shown, &name_of(file), &text()?)?),
        // Texts that are no JSON are licences and notes.
        "txt" => {
            let text = text()?;
            match text.trim_start().starts_with('{') {
                true => MotionContent::Rig(read_deepmimic(&shown, &name_of(file), &text)?),
                false => MotionContent::Nothing,
            }
        }
        _ => MotionContent::Nothing,
    })
}

fn name_of(file: &Path) -> String {
    let part = |path: Option<&std::ffi::OsStr>| path.unwrap_or_default().to_string_lossy().into_owned();
    let folder = part(file.parent().and_then(Path::file_name));
    format!("{folder}/{}", part(file.file_stem()))
}
