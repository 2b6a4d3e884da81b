//! The networks of "Synthesizing Long-Term 3D Human Motion and Interaction in 3D Scenes" (LTM): PointNet, sub-goal
//! bodies, RouteNet, PoseNet, BaseNet and the variants of Table 1.
//!
//! Bodies are rows of [`ROW`] numbers in a frame that belongs to the leg, not to the room: the pelvis in metres 3,
//! rotation 6 (first two columns), pose code 32, hand codes 24. What that frame is, is the caller's affair; the
//! networks only need it to be the same for points and bodies.

mod between;
mod config;
mod lstm;
mod network;
mod points;
mod sampler;
mod subgoal;
#[cfg(test)]
mod tests;

pub use between::BetweenInput;
pub use config::{
    BETWEEN, Between, CONDITION, HAND_COLUMNS, MotionConfig, MotionKind, PLACE, POINT_CLASSES, POSE_COLUMNS,
    PointNetConfig, ROW, TURN_COLUMNS, WHERE_COLUMNS,
};
pub use network::{Cloud, MotionNetwork, POINTS_PREFIX, SubGoalMade};
pub use sampler::MotionSampler;
