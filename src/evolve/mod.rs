//! The only composer of `generate`, `fit` and `motion`: populating a room; later, actions that evolve it.
//!
//! Works on snapshots; may not name the document, the renderer or a front end.

pub mod action;
pub mod day;
pub mod journey;

mod choose;
mod estimate;
mod populate;
mod populate_learned;
mod refine;

pub use choose::clear_of_others;
pub use estimate::{EstimateRequest, EstimatedPerson, EstimatorKind, estimate_person, mean_code, pinhole};
pub use populate::{OnCancel, PopulatePreview, PopulateRequest, Populated, PopulatedPerson, populate};
pub use populate_learned::{LearnedRequest, populate_learned};
pub use refine::{RefinePreview, RefineRequest, Refined, family_of, refine};
