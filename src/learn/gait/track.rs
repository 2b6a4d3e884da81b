//! A clip as the paths of what walking is measured on.

use glam::{Quat, Vec3};

use crate::assets::PoseClip;
use crate::body::joints::{self, JOINTS};
use crate::body::{FrameJoints, POSE_TREE};
use crate::scene::Frame;

/// Seconds to either side over which the way's direction is taken: about a step.
const DIRECTION_S: f32 = 0.3;

/// One clip, each frame posed on the body.
pub(super) struct Track {
    /// Rotations of pelvis (world) and body joints (in their parents' frames).
    pub(super) local: Vec<[Quat; POSE_TREE]>,
    /// Positions of the same joints, metres.
    pub(super) positions: Vec<[Vec3; POSE_TREE]>,
    /// World rotation of the left and the right foot.
    pub(super) feet: Vec<[Quat; 2]>,
    /// Horizontal direction of the way, unit length; the facing where somebody stands.
    pub(super) ahead: Vec<Vec3>,
    pub(super) frame_seconds: f32,
    pub(super) leg_m: f32,
}

impl Track {
    pub(super) fn of(clip: &PoseClip, rest: &[Vec3; JOINTS]) -> Self {
        let mut track = Self {
            local: Vec::new(),
            positions: Vec::new(),
            feet: Vec::new(),
            ahead: Vec::new(),
            frame_seconds: clip.frame_seconds,
            leg_m: rest[joints::LEFT_HIP].distance(rest[joints::LEFT_KNEE])
                + rest[joints::LEFT_KNEE].distance(rest[joints::LEFT_ANKLE]),
        };
        for (angles, pelvis) in clip.frames.iter().zip(&clip.pelvis_m) {
            let frame = Frame {
                translation: *pelvis - rest[joints::PELVIS],
                rotation: Quat::from_scaled_axis(angles[joints::PELVIS]),
                pose: std::array::from_fn(|i| angles[i + 1]),
                ..Frame::default()
            };
            let posed = FrameJoints::of(rest, &frame);
            track.local.push(std::array::from_fn(|i| Quat::from_scaled_axis(angles[i])));
            track.positions.push(posed.positions);
            track.feet.push([joints::LEFT_ANKLE, joints::RIGHT_ANKLE].map(|foot| posed.rotations[foot]));
        }
        track.find_directions();
        track
    }

    /// The same walk in a mirror.
    pub(super) fn mirrored(&self) -> Self {
        let flip = |q: Quat| Quat::from_xyzw(q.x, -q.y, -q.z, q.w);
        let across = Vec3::new(-1.0, 1.0, 1.0);
        Self {
            local: self.local.iter().map(|l| std::array::from_fn(|i| flip(l[joints::mirror(i)]))).collect(),
            positions: self
                .positions
                .iter()
                .map(|p| std::array::from_fn(|i| p[joints::mirror(i)] * across))
                .collect(),
            feet: self.feet.iter().map(|[left, right]| [flip(*right), flip(*left)]).collect(),
            ahead: self.ahead.iter().map(|a| *a * across).collect(),
            ..*self
        }
    }

    pub(super) fn len(&self) -> usize {
        self.positions.len()
    }

    /// The frames to either side that `seconds` reach.
    pub(super) fn frames(&self, seconds: f32) -> usize {
        ((seconds / self.frame_seconds).round() as usize).max(1)
    }

    fn find_directions(&mut self) {
        let reach = self.frames(DIRECTION_S);
        let last = self.len().saturating_sub(1);
        self.ahead = (0..self.len())
            .map(|i| {
                let (from, to) = (i.saturating_sub(reach), (i + reach).min(last));
                let way = (self.positions[to][0] - self.positions[from][0]).with_y(0.0);
                let facing = (self.local[i][0] * Vec3::Z).with_y(0.0).normalize_or(Vec3::Z);
                if way.length() > 0.05 { way.normalize_or(facing) } else { facing }
            })
            .collect();
    }
}
