//! Training and measuring the networks of LTM (§3, §4) on captured clips put into staged rooms.
//!
//! What comes out is **staged, not captured**: nobody recorded the rooms. A seat stands where the clip sits, furniture
//! stands where it does not go; so a network can learn what a room has to do with a motion, not how people choose.

mod checkpoint;
mod config;
mod data;
pub mod evaluate;
mod history;
mod loss;
mod solids;
pub mod staging;
mod takes;
#[cfg(test)]
mod tests;
mod train;

pub use checkpoint::MotionState;
pub use config::{MotionPreset, MotionTraining};
pub use data::{MotionData, MotionDataConfig, StagedBody, Window};
pub use history::{MotionHistory, MotionRow};
pub use takes::{Activity, Take, takes_of};
pub use train::{RouteOf, TrainInput, train_motion, validation_loss};
