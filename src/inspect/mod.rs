//! What is wrong, where, against which limit: metrics of bodies and the findings made from them.
//!
//! May name `math`, `scene`, `body`. Only measures: changes nothing, hides nothing. One record feeds the
//! worst-first table, the heat map and the JSON report. NaN is always an error.

mod alignment;
mod body;
mod finding;
mod hull;
mod surface;

pub use alignment::{EstimateErrors, Similarity, mean_distance_mm};
pub use body::{BodyMetrics, BodyReport, CONTACT_M, inspect_body};
pub use finding::{Finding, Limits, Metric, Site};
pub use surface::{BodySolid, surface_samples};
