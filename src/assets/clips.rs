use glam::Vec3;

use super::npz::{Npz, NpzError};

/// Joints of a clip's frame: SMPL-X's 55.
pub const CLIP_JOINTS: usize = 55;
/// Time from frame to frame of archives that state none.
const USUAL_FRAME_SECONDS: f32 = 1.0 / 24.0;
/// Hip joint to ankle of the mean body, for archives that give the hip's place in leg lengths.
const LEG_M: f32 = 0.81;

/// A motion clip on SMPL-X's joints.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseClip {
    /// Name in the archive, such as `ual/Sitting_Idle_Loop`, or of the file.
    pub name: String,
    /// For each frame the axis-angle of every joint in its parent's frame, radians; the root's (joint 0) in
    /// the clip's upright frame (Y up).
    pub frames: Vec<[Vec3; CLIP_JOINTS]>,
    /// For each frame where the pelvis is in that frame, metres on the mean body; floor at about y = 0.
    pub pelvis_m: Vec<Vec3>,
    /// Time from frame to frame, seconds.
    pub frame_seconds: f32,
}

/// Every clip of an archive: arrays named `NAME/pose` of shape (frames, 55, 3) and, where there is one,
/// `NAME/hip_over_leg` (frames, 3): the pelvis in leg lengths.
///
/// # Errors
/// [`NpzError`] for the first clip of another shape or with numbers that are not finite.
pub fn read_pose_clips(npz: &Npz) -> Result<Vec<PoseClip>, NpzError> {
    let clips = npz.names().filter_map(|name| Some((name, name.strip_suffix("/pose")?)));
    clips
        .map(|(array, name)| {
            let (_, numbers) = npz.floats(array, &[None, Some(CLIP_JOINTS), Some(3)])?;
            let frame = |frame: &[f32]| std::array::from_fn(|j| Vec3::from_slice(&frame[3 * j..]));
            let frames: Vec<_> = numbers.chunks_exact(3 * CLIP_JOINTS).map(frame).collect();
            Ok(PoseClip {
                name: name.to_owned(),
                pelvis_m: read_pelvis(npz, &format!("{name}/hip_over_leg"), frames.len())?,
                frames,
                frame_seconds: USUAL_FRAME_SECONDS,
            })
        })
        .collect()
}

fn read_pelvis(npz: &Npz, array: &str, frames: usize) -> Result<Vec<Vec3>, NpzError> {
    if !npz.has(array) {
        return Ok(vec![Vec3::ZERO; frames]);
    }
    let (_, numbers) = npz.floats(array, &[Some(frames), Some(3)])?;
    Ok(numbers.chunks_exact(3).map(|hip| Vec3::from_slice(hip) * LEG_M).collect())
}
