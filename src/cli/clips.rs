//! Motion clips of a folder, whatever format each file has.

pub use crate::body::read_clips;
