//! From annotated photos to action models (ADSE §4.1 to 4.4): who does what where with what, and how things lie.
//!
//! Knows annotations, never photos; reads no file. Deterministic for a seed on any number of threads. What follows
//! follows the paper but for what its data had and ours has not: joints that nobody marked stay unknown (ω = 0), legs
//! that are hidden are told by other evidence ([`posture`]), the floor plan keeps a person's facing only
//! ([`LayoutFrame`]), photos without all their things marked count for places, not for occurrence.

mod instances;
mod layout;
mod likelihood;
mod nodes;
pub mod pose;
mod posture;
mod report;
mod rules;
pub mod simulate;
mod whereabouts;

pub use instances::{Found, Funnel, Group, Instance, InstanceConfig, PlacedThing, find_instances};
pub use layout::{LayoutFrame, PhotoFrame, PolarUnits, TORSO_M};
pub use likelihood::{Likelihood, LikelihoodRow, held_out_likelihood};
pub use nodes::{MOST_PIECES, ModelConfig, NodeKey, build_model, node_key};
pub use posture::PostureEvidence;
pub use report::{
    ActionReport, NodeRow, ObjectRow, ReferenceRow, THIN, node_rows, places_of, posture_evidence,
    reference_rows, seated_told_by_angles, warnings,
};
pub use rules::{ActionRule, Caption, Rules, RulesError, Search};
pub use whereabouts::KeyEvidence;
