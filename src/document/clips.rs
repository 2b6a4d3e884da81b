//! The motions of a project: what they are stands in the project's text, their frames, which are many, in a NumPy
//! archive beside it, to the last bit of every number.

use std::sync::Arc;

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use super::files::ProjectError;
use crate::assets::npz::{Npz, NpzError, NpzWriter};
use crate::scene::Clip;
use crate::scene::FRAME_JOINTS;
use crate::scene::Frame;
use crate::scene::HANDS;

/// The motions as the text has them.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct MotionsText {
    /// Where the frames are: beside the text; never a path.
    pub file: String,
    /// Everything but frames and feet.
    clips: Vec<Clip>,
}

impl MotionsText {
    pub fn of(clips: &[Arc<Clip>], file: &str) -> Self {
        let bare = |clip: &Arc<Clip>| Clip {
            name: clip.name.clone(),
            goals: clip.goals.clone(),
            legs: clip.legs.clone(),
            frames: Vec::new(),
            planted: Vec::new(),
            ..*clip.as_ref()
        };
        Self { file: file.to_owned(), clips: clips.iter().map(bare).collect() }
    }
}

/// The frames of all motions as an archive; arrays are named `ID/what`.
pub(super) fn write(clips: &[Arc<Clip>]) -> std::io::Result<Vec<u8>> {
    let mut archive = NpzWriter::default();
    for clip in clips {
        let (id, frames) = (clip.id.0, clip.frames.len());
        let all = |numbers: &dyn Fn(&Frame) -> Vec<f32>| -> Vec<f32> {
            clip.frames.iter().flat_map(numbers).collect()
        };
        let pose = |frame: &Frame| frame.pose.iter().flat_map(glam::Vec3::to_array).collect();
        archive.add(
            &format!("{id}/translation"),
            &[frames, 3],
            &all(&|f| f.translation.to_array().into()),
        )?;
        archive.add(&format!("{id}/rotation"), &[frames, 4], &all(&|f| f.rotation.to_array().into()))?;
        archive.add(&format!("{id}/pose"), &[frames, FRAME_JOINTS, 3], &all(&pose))?;
        archive.add(&format!("{id}/hands"), &[frames, HANDS], &all(&|f| f.hands.into()))?;
        let feet: Vec<u8> = clip.planted.iter().flat_map(|feet| feet.map(u8::from)).collect();
        archive.add(&format!("{id}/planted"), &[clip.planted.len(), 2], &feet)?;
    }
    archive.finish()
}

/// Puts motions and their frames together again.
///
/// # Errors
/// [`ProjectError::Motions`] for frames that are missing, of another shape or not finite, for legs beyond the frames
/// and for motions with the same id.
pub(super) fn read(text: MotionsText, bytes: &[u8], file: &str) -> Result<Vec<Arc<Clip>>, ProjectError> {
    let bad = |problem: String| ProjectError::Motions { file: file.to_owned(), problem };
    let npz = Npz::from_bytes(&text.file, bytes).map_err(|e| bad(e.to_string()))?;
    let mut clips: Vec<Arc<Clip>> = Vec::with_capacity(text.clips.len());
    for mut clip in text.clips {
        (clip.frames, clip.planted) = frames_of(&npz, clip.id.0).map_err(|e| bad(e.to_string()))?;
        if clips.iter().any(|other| other.id == clip.id) {
            return Err(bad(format!("\"{}\" has the id of another motion", clip.name)));
        }
        let frames = clip.frames.len();
        let beyond = clip.legs.iter().any(|leg| leg.first > leg.last || leg.last >= frames);
        if beyond || (clip.planted.len() != frames && !clip.planted.is_empty()) || !clip.is_finite() {
            return Err(bad(format!("\"{}\" has other frames than it says", clip.name)));
        }
        clips.push(Arc::new(clip));
    }
    Ok(clips)
}

type Frames = (Vec<Frame>, Vec<[bool; 2]>);

fn frames_of(npz: &Npz, id: u32) -> Result<Frames, NpzError> {
    let (shape, translation) = npz.floats(&format!("{id}/translation"), &[None, Some(3)])?;
    let frames = Some(shape[0]);
    let (_, rotation) = npz.floats(&format!("{id}/rotation"), &[frames, Some(4)])?;
    let (_, pose) = npz.floats(&format!("{id}/pose"), &[frames, Some(FRAME_JOINTS), Some(3)])?;
    let (_, hands) = npz.floats(&format!("{id}/hands"), &[frames, Some(HANDS)])?;
    let (_, planted) = npz.ints(&format!("{id}/planted"), &[None, Some(2)])?;
    let frame = |i: usize| Frame {
        translation: Vec3::from_slice(&translation[3 * i..]),
        rotation: Quat::from_slice(&rotation[4 * i..]),
        pose: std::array::from_fn(|j| Vec3::from_slice(&pose[3 * (FRAME_JOINTS * i + j)..])),
        hands: std::array::from_fn(|j| hands[HANDS * i + j]),
    };
    let planted = planted.chunks_exact(2).map(|feet| [feet[0] != 0, feet[1] != 0]);
    Ok(((0..shape[0]).map(frame).collect(), planted.collect()))
}
