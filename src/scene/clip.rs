use glam::{Mat3, Quat, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::person::{BETAS, BodyParams, HANDS, POSE, PersonId};
use crate::math::rotation;

/// Joints that a frame turns: SMPL-X's body joints 1 to 21.
pub const FRAME_JOINTS: usize = 21;
/// Frames in a second of every clip that the program makes (LTM §4.1).
pub const CLIP_FPS: f32 = 30.0;

/// One instant of a motion. Unlike [`BodyParams`] it holds joint rotations, not a pose code, so captured motion
/// goes through it without loss.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Global translation in metres: the pelvis joint stands at `pelvis_rest(betas) + translation`.
    pub translation: Vec3,
    /// World from body.
    pub rotation: Quat,
    /// Axis-angles of joints 1 to 21 in their parents' frames, radians.
    pub pose: [Vec3; FRAME_JOINTS],
    /// Hand pose codes, left then right.
    pub hands: [f32; HANDS],
}

impl Default for Frame {
    fn default() -> Self {
        Self {
            translation: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            pose: [Vec3::ZERO; FRAME_JOINTS],
            hands: [0.0; HANDS],
        }
    }
}

impl Frame {
    /// The body with this frame's place, rotation and hands; its pose code is left zero: pose it with
    /// `Body::pose_axis_angles` and [`Frame::pose`].
    pub fn params(&self, betas: &[f32; BETAS]) -> BodyParams {
        BodyParams {
            translation: self.translation,
            rotation6: rotation::six_d_from_matrix(&Mat3::from_quat(self.rotation)),
            betas: *betas,
            pose: [0.0; POSE],
            hands: self.hands,
        }
    }

    /// The frame of a body whose pose code decodes to `pose`.
    pub fn of(params: &BodyParams, pose: &[Vec3; FRAME_JOINTS]) -> Self {
        Self {
            translation: params.translation,
            rotation: Quat::from_mat3(&params.rotation()).normalize(),
            pose: *pose,
            hands: params.hands,
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.translation.is_finite()
            && self.rotation.is_finite()
            && self.pose.iter().all(|p| p.is_finite())
            && self.hands.iter().all(|h| h.is_finite())
    }
}

/// Names a sub-goal for as long as its clip lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct SubGoalId(pub u32);

/// What somebody does at a sub-goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum GoalPose {
    /// Whatever suits the place: sits on seats, lies on beds, stands on the floor.
    #[default]
    Any,
    /// Walks through without stopping; what the planner puts in between.
    Walk,
    /// Stands.
    Stand,
    /// Sits.
    Sit,
    /// Lies.
    Lie,
}

/// Where somebody should be on the way (LTM §3.1: `{t, r, β}`; β is the clip's).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SubGoal {
    /// Stable name.
    pub id: SubGoalId,
    /// The point of the floor, seat or bed that the person stands, sits or lies on; metres, world frame.
    pub at: Vec3,
    /// Which way the person faces, radians about +Y: 0 faces +Z, π/2 faces +X; for lying the way from the pelvis to the
    /// feet. `None` leaves it to the planner.
    pub facing: Option<f32>,
    /// What is done there.
    pub pose: GoalPose,
    /// How long the person stays, seconds.
    pub stay_s: f32,
    /// Put in by the planner, not asked for; planned again whenever the way changes, unless locked.
    pub planned: bool,
    /// Stays as it is when others are planned or sampled again.
    pub locked: bool,
    /// The body at this sub-goal, once it is known.
    pub body: Option<Frame>,
}

/// The horizontal unit vector (x, z) of a facing angle.
pub fn direction_of(facing: f32) -> Vec2 {
    Vec2::new(facing.sin(), facing.cos())
}

/// The facing angle of a horizontal vector (x, z).
pub fn facing_of(direction: Vec2) -> f32 {
    direction.x.atan2(direction.y)
}

/// The frames from one sub-goal to the next, or the stay at one (`from == to`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Leg {
    /// Where it begins.
    pub from: SubGoalId,
    /// Where it ends.
    pub to: SubGoalId,
    /// Its first frame.
    pub first: usize,
    /// Its last frame, which is the next leg's first.
    pub last: usize,
    /// Digest of everything that it was made from: while this stays, the leg need not be made again.
    pub key: u64,
}

/// Names a clip for as long as the project lives; never used again after a removal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ClipId(pub u32);

/// One person's motion in the room. Without frames it is a plan: sub-goals that nobody has walked yet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Clip {
    /// Stable name.
    pub id: ClipId,
    /// Name for people.
    pub name: String,
    /// Whose motion it is, where the person also stands in the room.
    pub person: Option<PersonId>,
    /// Body shape β, the same in every frame.
    pub betas: [f32; BETAS],
    /// Chooses the clothes' colours.
    pub palette: u32,
    /// Frames in a second.
    pub fps: f32,
    /// The motion, evenly spaced in time.
    pub frames: Vec<Frame>,
    /// Whether the left and the right foot is planted, for each frame.
    pub planted: Vec<[bool; 2]>,
    /// From where to where, in the order of time.
    pub goals: Vec<SubGoal>,
    /// What the frames belong to, in the order of time.
    pub legs: Vec<Leg>,
    /// Seed of the whole clip.
    pub seed: u64,
    /// Shown.
    pub visible: bool,
    /// Protected from being made again, changed and removed.
    pub locked: bool,
}

impl Default for Clip {
    fn default() -> Self {
        Self {
            id: ClipId(0),
            name: String::new(),
            person: None,
            betas: [0.0; BETAS],
            palette: 0,
            fps: CLIP_FPS,
            frames: Vec::new(),
            planted: Vec::new(),
            goals: Vec::new(),
            legs: Vec::new(),
            seed: 0,
            visible: true,
            locked: false,
        }
    }
}

impl Clip {
    /// How long it lasts, seconds.
    pub fn seconds(&self) -> f32 {
        self.frames.len().saturating_sub(1) as f32 / self.fps
    }

    /// The frame that is shown at a time, counted from the clip's start.
    pub fn frame_at(&self, seconds: f32) -> usize {
        ((seconds * self.fps).round().max(0.0) as usize).min(self.frames.len().saturating_sub(1))
    }

    /// Whether every number of every frame is finite.
    pub fn is_finite(&self) -> bool {
        self.fps.is_finite()
            && self.betas.iter().all(|b| b.is_finite())
            && self.frames.iter().all(Frame::is_finite)
    }

    /// The sub-goal named `id`.
    pub fn goal(&self, id: SubGoalId) -> Option<&SubGoal> {
        self.goals.iter().find(|g| g.id == id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facing_angles_and_directions_are_inverse() {
        for facing in [-3.0, -1.0, 0.0, 0.5, 2.0_f32] {
            assert!((facing_of(direction_of(facing)) - facing).abs() < 1e-6);
        }
        assert_eq!(direction_of(0.0), Vec2::new(0.0, 1.0), "0 faces +Z as the body at rest does");
    }

    #[test]
    fn a_frame_and_its_body_stand_at_the_same_place() {
        let turn = Quat::from_rotation_y(0.7);
        let frame = Frame { translation: Vec3::new(1.0, 0.2, -2.0), rotation: turn, ..Frame::default() };
        let back = Frame::of(&frame.params(&[0.0; BETAS]), &frame.pose);
        assert!(back.translation == frame.translation && back.rotation.angle_between(turn) < 1e-3);
    }
}
