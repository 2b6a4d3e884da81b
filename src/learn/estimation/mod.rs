//! How well people are estimated from pictures (PSI §4.2, table 5): bodies whose truth is known, seen by cameras with
//! noisy, missing and occluded keypoints, estimated by SMPLify-X, PROX and PROX with the scene's prior.
//!
//! Keypoints are made here from the true bodies; no detector is involved, and the figures say nothing about one.
//! May not read or write files. Deterministic for a seed on any number of threads.

mod cases;
mod observe;
mod study;
mod summary;

pub use cases::{SCENE_SAMPLES, cases_of_corpus, cases_of_room, scene_code_by_search};
pub use observe::{ObserveConfig, Observer};
pub use study::{Case, CaseResult, study_room};
pub use summary::{Comparison, GroupRow, MethodRow, Summary, summarise};
