//! What is acceptable in a motion.

use super::{FrameRecord, MotionReport};
use crate::inspect::{Finding, Metric, Site};

/// What is acceptable in a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits {
    /// Least mean share of vertices in free space, per cent.
    pub non_collision_pct: f32,
    /// Least share of frames in contact, per cent.
    pub contact_pct: f32,
    /// Deepest vertex in any frame, millimetres.
    pub penetration_max_mm: f32,
    /// Mean speed of planted feet, cm/s; a single frame may be [`Self::SINGLE_FRAME`] times as bad.
    pub skate_cm_per_s: f32,
    /// Wandering of a planted foot in one stance, centimetres.
    pub stance_drift_cm: f32,
    /// Height of a planted foot above what is under it, millimetres.
    pub hover_mm: f32,
    /// Distance from a sub-goal, centimetres.
    pub goal_error_cm: f32,
    /// Turn from a sub-goal's facing, degrees.
    pub goal_error_deg: f32,
    /// Distance of a leg's ends from its sub-goals' bodies (LTM table 4), centimetres.
    pub neighbour_v2v: f32,
    /// Speed at a boundary of legs over that beside it.
    pub boundary_speed_ratio: f32,
}

impl Default for MotionLimits {
    fn default() -> Self {
        Self {
            non_collision_pct: 99.5,
            contact_pct: 99.0,
            penetration_max_mm: 43.0,
            skate_cm_per_s: 2.0,
            stance_drift_cm: 1.0,
            hover_mm: 20.0,
            goal_error_cm: 3.0,
            goal_error_deg: 5.0,
            neighbour_v2v: 8.25,
            boundary_speed_ratio: 1.5,
        }
    }
}

impl MotionLimits {
    /// A mean limit is broken in a single frame only by this many times: one frame lasts a thirtieth of a second.
    pub const SINGLE_FRAME: f32 = 3.0;

    /// What breaks a limit, worst first: of the clip (`frame` is `None`) and of its frames.
    pub(super) fn findings(&self, body: u32, report: &MotionReport) -> Vec<Finding> {
        let mut findings = self.of_clip(body, report);
        for (i, frame) in report.frames.iter().enumerate() {
            findings.extend(self.of_frame(Site { body, frame: Some(i as u32) }, frame));
        }
        let at = |frame: usize| Site { body, frame: Some(frame as u32) };
        for goal in &report.goals {
            findings.extend(above(at(goal.frame), Metric::GoalErrorCm, goal.distance_cm, self.goal_error_cm));
            let turn = goal.facing_deg.unwrap_or(0.0);
            findings.extend(above(at(goal.frame), Metric::GoalErrorDeg, turn, self.goal_error_deg));
        }
        findings.sort_by(|a, b| b.severity().total_cmp(&a.severity()));
        findings
    }

    fn of_clip(&self, body: u32, report: &MotionReport) -> Vec<Finding> {
        let site = Site { body, frame: None };
        let m = &report.metrics;
        let below = |metric, value: f32, limit: f32| {
            (value < limit || value.is_nan()).then_some(Finding { site, metric, value, limit })
        };
        [
            below(Metric::NonCollisionPct, m.non_collision_pct, self.non_collision_pct),
            below(Metric::ContactPct, m.contact_pct, self.contact_pct),
            above(site, Metric::SkateCmPerS, m.skate_cm_per_s, self.skate_cm_per_s),
            above(site, Metric::StanceDriftCm, m.stance_drift_cm, self.stance_drift_cm),
            above(site, Metric::NeighbourV2v, m.neighbour_v2v.unwrap_or(0.0), self.neighbour_v2v),
            above(
                site,
                Metric::BoundarySpeedRatio,
                m.boundary_speed_ratio.unwrap_or(1.0),
                self.boundary_speed_ratio,
            ),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn of_frame(&self, site: Site, frame: &FrameRecord) -> impl Iterator<Item = Finding> {
        let skate = frame.skate_cm_per_s[0].max(frame.skate_cm_per_s[1]);
        [
            above(site, Metric::NotFinite, frame.not_finite as f32, 0.0),
            above(site, Metric::OutsideField, frame.outside_field as f32, 0.0),
            above(site, Metric::PenetrationMaxMm, frame.penetration_max_mm, self.penetration_max_mm),
            above(site, Metric::SkateCmPerS, skate, self.skate_cm_per_s * Self::SINGLE_FRAME),
            above(site, Metric::HoverMm, frame.hover_mm, self.hover_mm),
        ]
        .into_iter()
        .flatten()
    }
}

fn above(site: Site, metric: Metric, value: f32, limit: f32) -> Option<Finding> {
    (value > limit || value.is_nan()).then_some(Finding { site, metric, value, limit })
}
