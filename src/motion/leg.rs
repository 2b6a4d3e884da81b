//! What a leg of motion is made from and what comes out; shared by the planner and by everything that makes legs.
//! Plain data: plans nothing, poses nothing.

use glam::Vec3;

use crate::job::Seed;
use crate::scene::{BETAS, Frame, GoalPose};

/// One leg to be made: from one known state to another, along a way.
///
/// A leg depends on nothing else, neither on its neighbours nor on the clock: changing one sub-goal changes the two
/// legs that touch it, and no other.
#[derive(Clone, Debug, PartialEq)]
pub struct LegInput {
    /// The state at its first frame.
    pub from: EndState,
    /// The state at its last frame.
    pub to: EndState,
    /// Points of the floor that the body goes over, from below its start to below its end, at most 10 cm apart; the
    /// curve is smooth enough to be walked. A single point where the person stays on the spot: sits down from
    /// standing before the seat, lies down from its edge, gets up again, turns.
    pub path: Vec<PathPoint>,
    /// Body shape β.
    pub betas: [f32; BETAS],
    /// How long it should take, seconds; `None` leaves it to the maker (natural walking).
    pub seconds: Option<f32>,
    /// Chooses among ways of doing it.
    pub seed: Seed,
}

/// A point of the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// On the floor, metres, world frame.
    pub at: Vec3,
    /// Which way the path goes on here, radians about +Y (see `scene::direction_of`).
    pub heading: f32,
    /// Horizontal distance to what a standing person would touch, metres: arms and steps stay small in narrow places.
    pub clearance_m: f32,
    /// How fast the planner would walk here, metres per second: slower in turns and in narrow places. Speeding up
    /// from and slowing down to a still end is the leg maker's own affair.
    pub speed_m_per_s: f32,
}

/// How a leg begins or ends.
#[derive(Clone, Debug, PartialEq)]
pub enum EndState {
    /// At rest in a known body. The leg's first or last frame is exactly this body, with no velocity.
    Still(Still),
    /// In the middle of a walk. The leg's first or last frame and its velocity follow from these numbers alone, so that
    /// the legs before and after meet without either knowing the other.
    Walking(Walking),
}

/// A body at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Still {
    /// The body.
    pub frame: Frame,
    /// Stands, sits or lies; never [`GoalPose::Any`] or [`GoalPose::Walk`].
    pub pose: GoalPose,
}

/// A moment of a walk, always at the same phase: the right foot is about to land in front, the left foot is planted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walking {
    /// The point of the floor below the pelvis, metres, world frame.
    pub at: Vec3,
    /// Which way the person walks and faces, radians about +Y.
    pub heading: f32,
    /// Speed of the pelvis along the heading, metres per second.
    pub speed_m_per_s: f32,
}

/// Where a planted foot stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootPlace {
    /// The point of the floor below the ankle, metres, world frame.
    pub at: Vec3,
    /// Which way the toes point, radians about +Y.
    pub heading: f32,
}

/// The frames of a leg, `scene::CLIP_FPS` a second.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LegMotion {
    /// The motion, both ends included: the last frame is the next leg's first.
    pub frames: Vec<Frame>,
    /// Whether the left and the right foot is planted, for each frame.
    pub planted: Vec<[bool; 2]>,
}
