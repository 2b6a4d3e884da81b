use serde::{Deserialize, Serialize};

use super::BodyMetrics;

/// Where a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Site {
    /// Number of the person.
    pub body: u32,
    /// Frame of a clip; `None` for a still body.
    pub frame: Option<u32>,
}

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// PSI §4.1.4: share of vertices in free space.
    PsiNonCollision,
    /// Whether some contact vertex is within 2 cm of the surface.
    #[serde(rename = "contact_2cm")]
    Contact2cm,
    /// Deepest penetration in millimetres.
    PenetrationMaxMm,
    /// Whether the body is held by what is under it.
    Supported,
    /// Largest excess over a joint's limit in degrees.
    JointLimitDeg,
    /// Vertices outside the distance field.
    OutsideField,
    /// A number that is not finite.
    NotFinite,
    /// LTM §4.3: share of vertices in free space, mean over a clip's frames, per cent.
    NonCollisionPct,
    /// Share of a clip's frames that touch the room, per cent.
    ContactPct,
    /// Speed of planted feet along the floor, cm/s.
    SkateCmPerS,
    /// Wandering of a planted foot in one stance, centimetres.
    StanceDriftCm,
    /// Height of a planted foot above what is under it, millimetres.
    HoverMm,
    /// Distance from a sub-goal, centimetres.
    GoalErrorCm,
    /// Turn from a sub-goal's facing, degrees.
    GoalErrorDeg,
    /// LTM §4.3: distance of a leg's ends from its sub-goals' bodies, centimetres.
    #[serde(rename = "neighbour_v2v")]
    NeighbourV2v,
    /// Speed at a boundary of legs over that beside it.
    BoundarySpeedRatio,
}

impl Metric {
    /// Name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::PsiNonCollision => "non-collision (PSI)",
            Self::Contact2cm => "contact within 2 cm",
            Self::PenetrationMaxMm => "penetration, deepest (mm)",
            Self::Supported => "supported",
            Self::JointLimitDeg => "beyond joint limit (degrees)",
            Self::OutsideField => "vertices outside the room",
            Self::NotFinite => "numbers that are not finite",
            Self::NonCollisionPct => "non-collision over the clip (%)",
            Self::ContactPct => "frames in contact (%)",
            Self::SkateCmPerS => "planted foot slides (cm/s)",
            Self::StanceDriftCm => "planted foot wanders (cm)",
            Self::HoverMm => "planted foot hovers (mm)",
            Self::GoalErrorCm => "off its sub-goal (cm)",
            Self::GoalErrorDeg => "turned from its sub-goal (degrees)",
            Self::NeighbourV2v => "leg's end off its sub-goal's body (cm)",
            Self::BoundarySpeedRatio => "jump between legs (times its neighbourhood)",
        }
    }
}

/// Something above (or below) its limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Where.
    pub site: Site,
    /// What.
    pub metric: Metric,
    /// How much.
    pub value: f32,
    /// What would have been acceptable.
    pub limit: f32,
}

impl Finding {
    /// How bad it is: the ratio by which the limit is missed, at least 1; for worst-first tables.
    pub fn severity(&self) -> f32 {
        match self.metric {
            Metric::PsiNonCollision => (1.0 - self.value) / (1.0 - self.limit).max(1e-6),
            Metric::Contact2cm | Metric::Supported => 2.0,
            Metric::NonCollisionPct | Metric::ContactPct => {
                (100.0 - self.value) / (100.0 - self.limit).max(1e-6)
            }
            Metric::PenetrationMaxMm
            | Metric::JointLimitDeg
            | Metric::SkateCmPerS
            | Metric::StanceDriftCm
            | Metric::HoverMm
            | Metric::GoalErrorCm
            | Metric::GoalErrorDeg
            | Metric::NeighbourV2v
            | Metric::BoundarySpeedRatio => self.value / self.limit.max(1e-6),
            Metric::OutsideField => 3.0,
            Metric::NotFinite => f32::INFINITY,
        }
    }
}

/// What is acceptable.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Least share of vertices in free space.
    pub psi_non_collision: f32,
    /// Deepest acceptable penetration in millimetres: what a cushion or a mattress gives way.
    pub penetration_max_mm: f32,
    /// Acceptable excess over a joint's limit in degrees.
    pub joint_limit_deg: f32,
}

impl Default for Limits {
    fn default() -> Self {
        Self { psi_non_collision: 0.98, penetration_max_mm: 25.0, joint_limit_deg: 10.0 }
    }
}

impl Limits {
    /// The findings of one body's metrics, worst first.
    pub fn findings(&self, site: Site, metrics: &BodyMetrics) -> Vec<Finding> {
        let flag = |b: bool| if b { 1.0 } else { 0.0 };
        let checks = [
            (Metric::NotFinite, metrics.not_finite as f32, 0.0, metrics.not_finite > 0),
            (Metric::OutsideField, metrics.outside_field as f32, 0.0, metrics.outside_field > 0),
            (
                Metric::PsiNonCollision,
                metrics.psi_non_collision,
                self.psi_non_collision,
                metrics.psi_non_collision < self.psi_non_collision,
            ),
            (Metric::Contact2cm, flag(metrics.contact_2cm), 1.0, !metrics.contact_2cm),
            (
                Metric::PenetrationMaxMm,
                metrics.penetration_max_mm,
                self.penetration_max_mm,
                metrics.penetration_max_mm > self.penetration_max_mm,
            ),
            (Metric::Supported, flag(metrics.supported), 1.0, !metrics.supported),
            (
                Metric::JointLimitDeg,
                metrics.joint_limit_deg,
                self.joint_limit_deg,
                metrics.joint_limit_deg > self.joint_limit_deg,
            ),
        ];
        let failed = checks.into_iter().filter(|(.., fails)| *fails);
        let mut findings: Vec<Finding> =
            failed.map(|(metric, value, limit, _)| Finding { site, metric, value, limit }).collect();
        findings.sort_by(|a, b| b.severity().total_cmp(&a.severity()));
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good() -> BodyMetrics {
        BodyMetrics {
            psi_non_collision: 1.0,
            psi_contact: true,
            contact_2cm: true,
            supported: true,
            ..BodyMetrics::default()
        }
    }

    #[test]
    fn a_good_body_has_no_findings_and_a_bad_one_is_listed_worst_first() {
        let site = Site { body: 3, frame: None };
        assert!(Limits::default().findings(site, &good()).is_empty());
        let bad = BodyMetrics { penetration_max_mm: 100.0, supported: false, ..good() };
        let findings = Limits::default().findings(site, &bad);
        assert_eq!(
            findings.iter().map(|f| f.metric).collect::<Vec<_>>(),
            [Metric::PenetrationMaxMm, Metric::Supported]
        );
        assert_eq!(findings[0].limit, 25.0);
    }

    #[test]
    fn a_number_that_is_not_finite_is_always_a_finding() {
        let bad = BodyMetrics { not_finite: 1, ..good() };
        let findings = Limits::default().findings(Site { body: 0, frame: None }, &bad);
        assert_eq!(findings[0].metric, Metric::NotFinite);
    }
}
