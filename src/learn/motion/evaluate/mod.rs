//! LTM's Tables 1, 2 and 4 on held-out clips in staged rooms, and what today's viewers look at: feet that slide, skin in
//! furniture, jumps at sub-goals.
//!
//! Pure: clips and networks come in, rows go out as they are found.

mod makers;
mod rows;
mod run;
mod tables;

pub use makers::{Maker, MotionNets};
pub use rows::{MotionRowKind, MotionStudyRow, Optimised};
pub use run::{MotionStudyConfig, run_motion_study};
pub use tables::{motion_csv, motion_markdown};
