//! Offline learning: clips and annotations in, statistics and weights out. May not be called from the
//! document, the renderer or the editor's frame; the command line and jobs run it.

mod pose_statistics;
pub mod psi;

pub use pose_statistics::{family_fit, fit_hand_space, fit_pose_gaussian, fit_pose_statistics};
