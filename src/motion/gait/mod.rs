//! Walking, turning, sitting down, lying down and getting up, made from footsteps and a measured gait model.
//!
//! Pure and deterministic for a given seed; knows no room: the planner's way and the two end bodies are all it is
//! told. Planted feet stand still because legs follow from them by inverse kinematics.

mod curve;
mod feet;
mod figure;
mod model;
mod steps;
mod style;
mod way;

pub use model::{Curve, GaitModel, GaitModelError, HARMONICS, JointSeries, KNOTS, OfPace, Pace, Series};
