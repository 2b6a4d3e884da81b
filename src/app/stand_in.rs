//! temp: only until inspect and geometry land
use std::collections::BTreeMap;
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyMetrics {
    pub psi_non_collision: f32,
    pub psi_contact: bool,
    pub contact_2cm: bool,
    pub penetration_mean_mm: f32,
    pub penetration_max_mm: f32,
    pub penetration_vertices_max_mm: f32,
    pub penetration_surface_max_mm: f32,
    pub contact_area_cm2: f32,
    pub contact_area_by_region_cm2: BTreeMap<&'static str, f32>,
    pub supported: bool,
    pub joint_limit_deg: f32,
    pub outside_field: usize,
    pub not_finite: usize,
}
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyReport {
    pub metrics: BodyMetrics,
    pub signed_distances_m: Vec<f32>,
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Site {
    pub body: u32,
    pub frame: Option<u32>,
}
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Metric {
    PenetrationMaxMm,
}
impl Metric {
    pub fn label(self) -> &'static str {
        "penetration, deepest (mm)"
    }
}
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    pub site: Site,
    pub metric: Metric,
    pub value: f32,
    pub limit: f32,
}
impl Finding {
    pub fn severity(&self) -> f32 {
        self.value / self.limit
    }
}
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Limits {
    pub psi_non_collision: f32,
    pub penetration_max_mm: f32,
    pub joint_limit_deg: f32,
}
impl Limits {
    pub fn findings(&self, site: Site, m: &BodyMetrics) -> Vec<Finding> {
        if m.penetration_max_mm > 25.0 {
            vec![Finding { site, metric: Metric::PenetrationMaxMm, value: m.penetration_max_mm, limit: 25.0 }]
        } else {
            vec![]
        }
    }
}
