//! Motion clips of a folder, whatever format each file has.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context as _;

use crate::assets::npz::Npz;
use crate::assets::{PoseClip, read_bvh, read_deepmimic, read_pose_clips};
use crate::body::{Body, retarget};

/// Every clip of `folder` and the folders below, in the order of their paths; clips of motion files are named
/// after the file and the folder that it is in (`cmu/02_01`).
///
/// # Errors
/// When a file that should be a clip can't be read, or there is none at all.
pub fn read_clips(folder: &Path) -> anyhow::Result<Vec<PoseClip>> {
    let mut files = Vec::new();
    list(folder, &mut files).with_context(|| {
        format!("can't read the corpus {}: name a folder with --corpus", folder.display())
    })?;
    files.sort();
    let mut clips = Vec::new();
    for file in &files {
        clips.extend(read_file(file)?);
    }
    anyhow::ensure!(
        !clips.is_empty(),
        "{} holds no clip: put npz archives with `NAME/pose` arrays, BVH files or DeepMimic's text there",
        folder.display()
    );
    Ok(clips)
}

fn list(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() { list(&path, files)? } else { files.push(path) }
    }
    Ok(())
}

fn read_file(file: &Path) -> anyhow::Result<Vec<PoseClip>> {
    let shown = file.display().to_string();
    let ending = file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let text = || fs::read_to_string(file).with_context(|| format!("can't read {shown}"));
    let rest = &Body::bundled().model.joint_template;
    Ok(match ending.as_str() {
        "npz" => {
            let bytes = fs::read(file).with_context(|| format!("can't read {shown}"))?;
            read_pose_clips(&Npz::from_bytes(&shown, &bytes)?)?
        }
        "bvh" => vec![retarget(&read_bvh(&shown, &name_of(file), &text()?)?, rest)?],
        // Texts that are no JSON are licences and notes.
        "txt" if text()?.trim_start().starts_with('{') => {
            vec![retarget(&read_deepmimic(&shown, &name_of(file), &text()?)?, rest)?]
        }
        _ => Vec::new(),
    })
}

fn name_of(file: &Path) -> String {
    let part = |path: Option<&std::ffi::OsStr>| path.unwrap_or_default().to_string_lossy().into_owned();
    let folder = part(file.parent().and_then(Path::file_name));
    format!("{folder}/{}", part(file.file_stem()))
}
