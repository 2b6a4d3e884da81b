//! A body from a person's keypoints in one picture of a known room: SMPLify-X's energy, PROX's scene terms, and
//! PSI §4.2's prior centred at what people do in this scene.
//!
//! Gradients are those of the hand-derived body. May not read pictures, detect keypoints or sample bodies: the
//! centre of the prior is given. Deterministic.

mod energy;
mod estimator;
mod initial;
mod landmarks;
mod pinhole;
#[cfg(test)]
mod tests;

pub use energy::{ESTIMATE_TERMS, EstimateTerm};
pub use estimator::{Estimate, EstimateConfig, EstimateError, EstimateTrace, Estimator, SceneWeights, Stage};
pub use landmarks::Landmarks;
pub use pinhole::Pinhole;
