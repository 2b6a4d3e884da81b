//! Optimises a motion in a room, all frames at once: LTM §3.4 as published (eq. 5 to 7 and the feet), and ours, which
//! keeps the motion's own manner, locks planted feet and knows what carries the body in each frame.
//!
//! Long motions go in overlapping windows, so time is linear in length and memory is bounded. Frames go over all
//! threads; every sum is made in the order of the frames, so the result is the same for any number of threads.

mod config;
mod descent;
mod fitter;
mod lock;
mod ours;
mod paper;
mod stance;
#[cfg(test)]
mod tests;
mod variables;

pub use config::{MotionObjective, MotionWeights, PaperWeights, SequenceConfig, SequencePreset, Stage};
pub use fitter::{SequenceFitter, SequenceTask, Sequenced};
