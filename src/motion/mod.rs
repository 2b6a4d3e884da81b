//! Long-term motion: sub-goals, route, pose, stitching. May not name `generate` or `fit`: bodies on seats and beds
//! come in from `evolve`, which also fits what comes out.

pub mod bundled;
pub mod capture;
pub mod gait;
pub mod learned;
pub mod leg;
pub mod local;
pub mod networks;
pub mod plan;
pub mod planted;
pub mod retrieval;
pub mod room_points;
pub mod stitch;
pub mod subgoal;

pub use leg::{EndState, FootPlace, LegInput, LegMotion, PathPoint, Still, Walking};
