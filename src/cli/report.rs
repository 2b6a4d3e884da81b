//! The JSON report of `generate`. Field names are a contract with people's scripts: add, never rename.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::inspect::{BodyMetrics, Finding};
use crate::scene::Person;

/// The whole report.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct GenerateReport {
    /// Always `generate`.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// Root of the seed tree.
    pub seed: u64,
    /// What was understood of the room.
    pub room: RoomRow,
    /// Every body.
    pub bodies: Vec<BodyRow>,
    /// Means and shares over the bodies.
    pub summary: Summary,
    /// Everything above its limit, worst first.
    pub findings: Vec<Finding>,
    /// Where the time went.
    pub seconds: Seconds,
    /// How many people were asked for.
    pub people_requested: usize,
    /// Why fewer came, if so.
    pub shortfall: Option<String>,
    /// What drew the pictures: the adapter's name, or the ray caster on the processor.
    pub pictures_by: String,
}

/// The room in a report.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RoomRow {
    /// File that was read, or the sample's name.
    pub path: String,
    /// Triangles.
    pub triangles: usize,
    /// Size in metres.
    pub extent_m: [f32; 3],
    /// Factor from the file's unit to metres.
    pub unit_scale: f32,
    /// The file's up axis.
    pub up: String,
    /// Objects.
    pub objects: usize,
    /// Its distance field.
    pub field: FieldRow,
    /// What the import dropped, mended or guessed.
    pub notes: Vec<String>,
}

/// The distance field in a report.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FieldRow {
    /// Samples along x, y and z.
    pub dim: [usize; 3],
    /// Largest distance between samples in metres.
    pub cell_m: f32,
    /// Time to make or load it.
    pub seconds: f64,
}

/// A body in a report.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BodyRow {
    /// Number of the person.
    pub id: u32,
    /// `sit`, `stand`, `lie` or `lean`.
    pub family: String,
    /// The finer pose family.
    pub pose: String,
    /// What holds it.
    pub on: String,
    /// Global translation.
    pub translation_m: [f32; 3],
    /// Seed of this body.
    pub seed: u64,
    /// Time to propose and fit it.
    pub seconds: f64,
    /// Every metric.
    pub metrics: MetricsRow,
    /// The body's file.
    pub file: String,
}

/// Metrics in a report: flags as 0 and 1, as the contract has them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MetricsRow {
    /// PSI §4.1.4: share of vertices with positive distance.
    pub psi_non_collision: f32,
    /// PSI §4.1.4: 1 when some vertex has a distance of zero or less.
    pub psi_contact: u8,
    /// 1 when some contact vertex is within 2 cm of a surface.
    pub contact_2cm: u8,
    /// Mean over penetrating vertices.
    pub penetration_mean_mm: f32,
    /// Deepest penetration, of the body's vertices in the room and of the room's surfaces in the body.
    pub penetration_max_mm: f32,
    /// The first of these two alone.
    pub penetration_vertices_max_mm: f32,
    /// The second of these two alone.
    pub penetration_surface_max_mm: f32,
    /// Skin within contact distance.
    pub contact_area_cm2: f32,
    /// The same by region.
    pub contact_area_by_region_cm2: BTreeMap<String, f32>,
    /// Whether what is under the body holds it.
    pub supported: bool,
    /// Largest excess over a joint limit.
    pub joint_limit_deg: f32,
    /// Vertices outside the distance field.
    pub outside_field: usize,
}

impl From<&BodyMetrics> for MetricsRow {
    fn from(m: &BodyMetrics) -> Self {
        Self {
            psi_non_collision: m.psi_non_collision,
            psi_contact: m.psi_contact.into(),
            contact_2cm: m.contact_2cm.into(),
            penetration_mean_mm: m.penetration_mean_mm,
            penetration_max_mm: m.penetration_max_mm,
            penetration_vertices_max_mm: m.penetration_vertices_max_mm,
            penetration_surface_max_mm: m.penetration_surface_max_mm,
            contact_area_cm2: m.contact_area_cm2,
            contact_area_by_region_cm2: m
                .contact_area_by_region_cm2
                .iter()
                .map(|(region, area)| ((*region).to_owned(), *area))
                .collect(),
            supported: m.supported,
            joint_limit_deg: m.joint_limit_deg,
            outside_field: m.outside_field,
        }
    }
}

impl BodyRow {
    /// The row of one person.
    pub fn new(person: &Person, metrics: &BodyMetrics, seconds: f64, file: String) -> Self {
        Self {
            id: person.id.0,
            family: person.family.group().to_owned(),
            pose: person.family.label().to_owned(),
            on: person.on.clone(),
            translation_m: person.body.translation.to_array(),
            seed: person.seed,
            seconds,
            metrics: metrics.into(),
            file,
        }
    }
}

/// Means and shares over all bodies.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Summary {
    /// Mean of the bodies' scores.
    pub psi_non_collision_mean: f32,
    /// Share of bodies with contact as PSI defines it.
    pub psi_contact_mean: f32,
    /// Share of bodies with contact within 2 cm.
    pub contact_2cm_mean: f32,
    /// Deepest penetration of any body.
    pub penetration_max_mm: f32,
    /// Share of supported bodies.
    pub supported_share: f32,
    /// Bodies per family group.
    pub families: BTreeMap<String, usize>,
}

impl Summary {
    /// The summary of `bodies`; all zero without any.
    pub fn of(bodies: &[BodyRow]) -> Self {
        let mean = |value: &dyn Fn(&MetricsRow) -> f32| {
            bodies.iter().map(|b| value(&b.metrics)).sum::<f32>() / bodies.len().max(1) as f32
        };
        let mut families = BTreeMap::new();
        for body in bodies {
            *families.entry(body.family.clone()).or_insert(0) += 1;
        }
        Self {
            psi_non_collision_mean: mean(&|m| m.psi_non_collision),
            psi_contact_mean: mean(&|m| m.psi_contact.into()),
            contact_2cm_mean: mean(&|m| m.contact_2cm.into()),
            penetration_max_mm: bodies.iter().map(|b| b.metrics.penetration_max_mm).fold(0.0, f32::max),
            supported_share: mean(&|m| f32::from(u8::from(m.supported))),
            families,
        }
    }
}

/// Wall-clock seconds of each stage.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Seconds {
    /// Reading and understanding the room.
    pub load: f64,
    /// Distance field, surfaces and ray tree.
    pub field: f64,
    /// Proposing people.
    pub generate: f64,
    /// Fitting and choosing among them.
    pub fit: f64,
    /// Files and pictures.
    pub write: f64,
    /// Everything.
    pub total: f64,
}
