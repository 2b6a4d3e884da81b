//! Long-term motion: sub-goals, route, pose, stitching. May not name `generate` or `fit`: bodies on seats and beds
//! come in from `evolve`, which also fits what comes out.

pub mod gait;
pub mod leg;
pub mod plan;

pub use leg::{EndState, FootPlace, LegInput, LegMotion, PathPoint, Still, Walking};
