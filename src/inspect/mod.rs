//! What is wrong, where, against which limit: metrics of bodies and of motions, and the findings made from them;
//! and PSI's metrics of whole sets of bodies.
//!
//! May name `math`, `scene`, `body`. Only measures: changes nothing, hides nothing. One record feeds the
//! worst-first table, the heat map and the JSON report. NaN is always an error.

mod alignment;
mod body;
mod diversity;
mod finding;
mod hull;
mod motion;
mod representation;
mod surface;

pub use alignment::{EstimateErrors, Similarity, mean_distance_mm};
pub use body::{BodyMetrics, BodyReport, CONTACT_M, inspect_body};
pub use diversity::{DIVERSITY_BODIES, Diversity, FEATURES, diversity, entropy_nats};
pub use finding::{Finding, Limits, Metric, Site};
pub use hull::{convex_hull, distance_to_hull};
pub use motion::{
    DEEP_MM, FrameRecord, GoalError, MotionErrors, MotionLimits, MotionMetrics, MotionReport,
    SKATES_CM_PER_S, inspect_motion, jitter_m_per_s3, pop_ratio, stance_drift_m, tread_speed_m_per_s,
};
pub use representation::Reconstruction;
pub use surface::{BodySolid, each_surface_sample, surface_samples};
