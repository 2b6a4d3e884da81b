use glam::{Quat, Vec3};

use super::GlbWriteError;
use super::buffer::{GlbBuilder, Layout};
use super::json;
use super::skinned::SkinnedMesh;

/// How a skinned body moves, evenly spaced in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinMotion {
    /// Frames in a second.
    pub fps: f32,
    /// For each frame what is added to the root joint's rest position, metres.
    pub translations_m: Vec<Vec3>,
    /// For each frame the rotation of every joint against the one above it.
    pub rotations: Vec<Vec<Quat>>,
}

impl SkinMotion {
    /// Refuses a motion that is not one of a skeleton of `joints`, or that has no time.
    pub(super) fn check(&self, what: &str, joints: usize) -> Result<(), GlbWriteError> {
        let length = |array, found, expected| {
            let what = what.to_owned();
            if found == expected {
                Ok(())
            } else {
                Err(GlbWriteError::Length { what, array, found, expected })
            }
        };
        length("frames of rotations", self.rotations.len(), self.translations_m.len())?;
        self.rotations.iter().try_for_each(|frame| length("rotations of a frame", frame.len(), joints))?;
        let finite = self.translations_m.iter().all(|t| t.is_finite())
            && self.rotations.iter().flatten().all(|r| r.is_finite());
        if finite && self.fps.is_finite() && self.fps > 0.0 {
            return Ok(());
        }
        Err(GlbWriteError::NotFinite { what: what.to_owned(), array: "motion" })
    }

    /// When each frame is shown, seconds.
    fn times(&self) -> Vec<f32> {
        (0..self.translations_m.len()).map(|i| i as f32 / self.fps).collect()
    }
}

/// A unit quaternion; the identity where there is no direction to keep.
pub(super) fn unit(rotation: Quat) -> Quat {
    let length = rotation.length();
    if length > 0.0 { rotation * length.recip() } else { Quat::IDENTITY }
}

/// Adds the channels of the bodies that move, each with the node of its first joint.
pub(super) fn add_bodies(
    builder: &mut GlbBuilder,
    animation: &mut json::Animation,
    bodies: &[(&SkinnedMesh, usize)],
) {
    for (body, first_joint) in bodies {
        let Some(motion) = body.motion.as_ref().filter(|motion| !motion.translations_m.is_empty()) else {
            continue;
        };
        add_body(builder, animation, body, motion, *first_joint);
        // Blender counts in frames of its scene: without this number nobody knows how many make a second.
        animation.extras = Some(serde_json::json!({ "fps": motion.fps }));
    }
}

/// Joints that never turn get no channel: their node has the rotation already.
fn add_body(
    builder: &mut GlbBuilder,
    animation: &mut json::Animation,
    body: &SkinnedMesh,
    motion: &SkinMotion,
    first_joint: usize,
) {
    let input = builder.times(&motion.times());
    let mut channel = |node, path, output| {
        animation.samplers.push(json::AnimationSampler { input, output, interpolation: "LINEAR" });
        let sampler = animation.samplers.len() - 1;
        animation.channels.push(json::Channel { sampler, target: json::ChannelTarget { node, path } });
    };
    let root_m: Vec<Vec3> = motion.translations_m.iter().map(|t| body.skeleton[0].rest_m + *t).collect();
    let layout = |kind| Layout { target: None, ..Layout::floats(kind) };
    channel(first_joint, "translation", builder.array(&root_m, layout("VEC3")));
    for (number, joint) in body.skeleton.iter().enumerate() {
        let turns = turns_of(motion, number);
        if turns.iter().any(|turn| *turn != unit(joint.rotation)) {
            let turns: Vec<[f32; 4]> = turns.iter().map(glam::Quat::to_array).collect();
            channel(first_joint + number, "rotation", builder.array(&turns, layout("VEC4")));
        }
    }
}

/// Unit rotations of a joint over the frames. Neighbours have the same sign: some programs interpolate the four
/// numbers by themselves, and would turn the long way round.
fn turns_of(motion: &SkinMotion, joint: usize) -> Vec<Quat> {
    let mut turns: Vec<Quat> = Vec::with_capacity(motion.rotations.len());
    for frame in &motion.rotations {
        let turn = unit(frame[joint]);
        let flips = turns.last().is_some_and(|last| last.dot(turn) < 0.0);
        turns.push(if flips { -turn } else { turn });
    }
    turns
}
