use glam::Vec3;

use super::npz::{Npz, NpzError};

/// Joints of a clip's frame: SMPL-X's 55.
pub const CLIP_JOINTS: usize = 55;

/// A motion clip on SMPL-X's joints.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseClip {
    /// Name in the archive, such as `ual/Sitting_Idle_Loop`.
    pub name: String,
    /// For each frame the axis-angle of every joint in its parent's frame, radians.
    pub frames: Vec<[Vec3; CLIP_JOINTS]>,
}

/// Every clip of an archive: arrays named `NAME/pose` of shape (frames, 55, 3).
///
/// # Errors
/// [`NpzError`] for the first clip of another shape or with numbers that are not finite.
pub fn read_pose_clips(npz: &Npz) -> Result<Vec<PoseClip>, NpzError> {
    let clips = npz.names().filter_map(|name| Some((name, name.strip_suffix("/pose")?)));
    clips
        .map(|(array, name)| {
            let (_, numbers) = npz.floats(array, &[None, Some(CLIP_JOINTS), Some(3)])?;
            let frame = |frame: &[f32]| std::array::from_fn(|j| Vec3::from_slice(&frame[3 * j..]));
            Ok(PoseClip {
                name: name.to_owned(),
                frames: numbers.chunks_exact(3 * CLIP_JOINTS).map(frame).collect(),
            })
        })
        .collect()
}
