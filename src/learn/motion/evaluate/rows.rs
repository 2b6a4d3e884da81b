use serde::Serialize;

use crate::inspect::{MotionErrors, MotionMetrics};

/// Which table a row belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum MotionRowKind {
    /// Two seconds between two captured bodies against what was captured: Tables 1, 2 and 4.
    Short,
    /// Two, four and six seconds through captured sub-goals.
    Long,
}

/// Whether and how the motion was optimised afterwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Optimised {
    /// As it came out.
    No,
    /// LTM §3.4 with the published weights.
    Paper,
    /// Ours.
    Ours,
}

impl Optimised {
    /// Name in the tables.
    pub fn label(self) -> &'static str {
        match self {
            Self::No => "-",
            Self::Paper => "paper",
            Self::Ours => "ours",
        }
    }
}

/// Means over the cases of one maker.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotionStudyRow {
    /// Which table.
    pub kind: MotionRowKind,
    /// Who made the motions.
    pub method: String,
    /// Whether it saw the room.
    pub scene: bool,
    /// What was done afterwards.
    pub optimised: Optimised,
    /// How long the motions are, seconds.
    pub seconds: u32,
    /// How many there are.
    pub cases: usize,
    /// Against the captured frames; of the long motions too.
    pub errors: MotionErrors,
    /// Mean distance of the vertices of the given first and last body from those of the frames beside them,
    /// centimetres (Table 4).
    pub neighbour_v2v_cm: f32,
    /// In the room; means over the cases, maxima where the name says so are means of the cases' maxima.
    pub metrics: MotionMetrics,
    /// The deepest penetration of any case, millimetres.
    pub penetration_worst_mm: f32,
}

/// What was measured of one case.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Measured {
    pub errors: MotionErrors,
    pub neighbour_v2v_cm: f32,
    pub metrics: MotionMetrics,
}

impl MotionStudyRow {
    /// The means of one maker's cases.
    pub(super) fn mean(
        kind: MotionRowKind,
        (method, scene): (&str, bool),
        optimised: Optimised,
        seconds: u32,
        cases: &[Measured],
    ) -> Self {
        let mean =
            |of: &dyn Fn(&Measured) -> f32| cases.iter().map(of).sum::<f32>() / cases.len().max(1) as f32;
        let some = |of: &dyn Fn(&MotionMetrics) -> Option<f32>| {
            let values: Vec<f32> = cases.iter().filter_map(|c| of(&c.metrics)).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f32>() / values.len() as f32)
        };
        Self {
            kind,
            method: method.to_owned(),
            scene,
            optimised,
            seconds,
            cases: cases.len(),
            errors: MotionErrors {
                translation_l1_x100: mean(&|c| c.errors.translation_l1_x100),
                orientation_l1_x100: mean(&|c| c.errors.orientation_l1_x100),
                pose_l1_x100: mean(&|c| c.errors.pose_l1_x100),
                mpjpe_mm: mean(&|c| c.errors.mpjpe_mm),
                mpvpe_mm: mean(&|c| c.errors.mpvpe_mm),
            },
            neighbour_v2v_cm: mean(&|c| c.neighbour_v2v_cm),
            metrics: MotionMetrics {
                non_collision_pct: mean(&|c| c.metrics.non_collision_pct),
                contact_pct: mean(&|c| c.metrics.contact_pct),
                psi_contact_pct: mean(&|c| c.metrics.psi_contact_pct),
                penetration_max_mm: mean(&|c| c.metrics.penetration_max_mm),
                penetration_mean_mm: mean(&|c| c.metrics.penetration_mean_mm),
                collision_frame_share: mean(&|c| c.metrics.collision_frame_share),
                skate_cm_per_s: mean(&|c| c.metrics.skate_cm_per_s),
                skate_frame_share: mean(&|c| c.metrics.skate_frame_share),
                stance_drift_cm: mean(&|c| c.metrics.stance_drift_cm),
                hover_max_mm: mean(&|c| c.metrics.hover_max_mm),
                goal_error_cm: some(&|m| m.goal_error_cm),
                goal_error_deg: some(&|m| m.goal_error_deg),
                neighbour_v2v: some(&|m| m.neighbour_v2v),
                boundary_speed_ratio: some(&|m| m.boundary_speed_ratio),
                jitter_m_per_s3: mean(&|c| c.metrics.jitter_m_per_s3),
            },
            penetration_worst_mm: cases.iter().map(|c| c.metrics.penetration_max_mm).fold(0.0, f32::max),
        }
    }
}
