//! The report of `inhabit evolve`: what was done, why, and what is wrong with it.

use serde::Serialize;

use super::Shown;
use crate::cli::load::{self, Loaded};
use crate::cli::report::{BodyRow, RoomRow};
use crate::evolve::action::{Evolution, EvolutionStep, Inserted, Moved, Pose, RoomMeasures};

/// Everything that a report is made of.
pub struct Parts<'a> {
    pub seed: u64,
    pub loaded: &'a Loaded,
    pub states: &'a [(Evolution, RoomMeasures)],
    pub shown: &'a [Shown],
    pub refused: &'a [String],
    pub requested: usize,
    pub stage_seconds: f64,
    pub fit_seconds: f64,
    pub total_seconds: f64,
    pub pictures_by: String,
}

/// The report.
#[derive(Serialize)]
pub struct EvolveReport {
    pub command: &'static str,
    pub version: &'static str,
    pub seed: u64,
    pub room: RoomRow,
    pub actions_requested: usize,
    pub steps: Vec<StepRow>,
    /// Actions that the room does not allow, and why.
    pub off: Vec<OffRow>,
    /// Draws that turned out to be impossible, and why.
    pub refused: Vec<String>,
    pub bodies: Vec<BodyRow>,
    pub summary: SummaryRow,
    pub seconds: SecondsRow,
    pub pictures_by: String,
}

/// One action.
#[derive(Serialize)]
pub struct StepRow {
    pub number: usize,
    pub action: String,
    pub key_object: String,
    pub people: Vec<PersonRow>,
    pub inserted: Vec<ThingRow>,
    pub moved: Vec<MovedRow>,
    pub failed: Vec<FailedRow>,
    pub seconds: f64,
    pub measures: RoomMeasures,
    pub file: String,
}

/// Somebody at an action.
#[derive(Serialize)]
pub struct PersonRow {
    pub family: &'static str,
    pub on: String,
    pub pelvis_m: [f32; 3],
    pub facing_deg: f32,
}

/// Something that was brought.
#[derive(Serialize)]
pub struct ThingRow {
    pub object: String,
    pub kind: String,
    pub on: String,
    pub at_m: [f32; 3],
    pub yaw_deg: f32,
    /// Which person it is for; `null` for what a group shares.
    pub person: Option<usize>,
}

/// Something that was moved.
#[derive(Serialize)]
pub struct MovedRow {
    pub object: String,
    pub from_m: [f32; 3],
    pub to_m: [f32; 3],
    pub distance_m: f32,
    pub turned_deg: f32,
    pub on: String,
    pub why: &'static str,
}

/// Something that the action wanted and did not get.
#[derive(Serialize)]
pub struct FailedRow {
    pub object: String,
    pub why: String,
}

/// An action that the room does not allow.
#[derive(Serialize)]
pub struct OffRow {
    pub action: String,
    pub why: String,
}

/// The last state, and the worst of all states.
#[derive(Serialize)]
pub struct SummaryRow {
    pub interpenetrations: usize,
    pub worst_interpenetration_mm: f32,
    pub unsupported: usize,
    pub out_of_bounds: usize,
    pub objects: usize,
    pub brought: usize,
    pub moved: usize,
    pub failed: usize,
    pub walkable_share: f32,
    pub messiness_bits: f32,
    pub milliseconds_per_action: f64,
    pub slowest_action_ms: f64,
}

/// Where the time went.
#[derive(Serialize)]
pub struct SecondsRow {
    pub understand: f64,
    pub actions: f64,
    pub fit: f64,
    pub total: f64,
}

impl EvolveReport {
    /// The report of a run.
    pub fn new(parts: &Parts<'_>) -> Self {
        let last = &parts.states[parts.states.len() - 1].0;
        let steps: Vec<StepRow> = last
            .steps()
            .iter()
            .zip(parts.states.iter().skip(1))
            .map(|(s, (_, m))| StepRow::new(s, m))
            .collect();
        let body = |shown: &Shown| -> Vec<BodyRow> {
            let number = shown.evolution.steps().len();
            let row = |(i, p): (usize, &crate::evolve::action::Embodied)| {
                BodyRow::new(&p.person, &p.report.metrics, 0.0, format!("people/{number:03}_{i}.glb"))
            };
            shown.people.iter().enumerate().map(row).collect()
        };
        Self {
            command: "evolve",
            version: env!("CARGO_PKG_VERSION"),
            seed: parts.seed,
            room: load::room_row(parts.loaded, &last.stage().geometry, parts.stage_seconds),
            actions_requested: parts.requested,
            off: last.off().iter().map(|o| OffRow { action: o.action.clone(), why: o.why.clone() }).collect(),
            refused: parts.refused.to_vec(),
            bodies: parts.shown.iter().flat_map(body).collect(),
            summary: SummaryRow::new(parts, &steps),
            seconds: SecondsRow {
                understand: parts.stage_seconds,
                actions: steps.iter().map(|s| s.seconds).sum(),
                fit: parts.fit_seconds,
                total: parts.total_seconds,
            },
            steps,
            pictures_by: parts.pictures_by.clone(),
        }
    }

    /// Whether there is nothing to complain of.
    pub fn is_clean(&self) -> bool {
        let s = &self.summary;
        let whole = self.steps.len() == self.actions_requested;
        whole && s.interpenetrations == 0 && s.unsupported == 0 && s.out_of_bounds == 0
    }
}

impl SummaryRow {
    fn new(parts: &Parts<'_>, steps: &[StepRow]) -> Self {
        let measures = || parts.states.iter().map(|(_, m)| m);
        let last = measures().last().cloned().unwrap_or_default();
        let times = || steps.iter().map(|s| s.seconds * 1e3);
        Self {
            interpenetrations: measures().map(|m| m.interpenetrations).max().unwrap_or(0),
            worst_interpenetration_mm: measures().map(|m| m.worst_interpenetration_mm).fold(0.0, f32::max),
            unsupported: measures().map(|m| m.unsupported).max().unwrap_or(0),
            out_of_bounds: measures().map(|m| m.out_of_bounds).max().unwrap_or(0),
            objects: last.objects,
            brought: last.brought,
            moved: steps.iter().map(|s| s.moved.len()).sum(),
            failed: steps.iter().map(|s| s.failed.len()).sum(),
            walkable_share: last.walkable_share,
            messiness_bits: last.messiness_bits,
            milliseconds_per_action: times().sum::<f64>() / steps.len().max(1) as f64,
            slowest_action_ms: times().fold(0.0, f64::max),
        }
    }
}

impl StepRow {
    fn new(step: &EvolutionStep, measures: &RoomMeasures) -> Self {
        Self {
            number: step.number,
            action: step.action.clone(),
            key_object: step.key_name.clone(),
            people: step
                .people
                .iter()
                .map(|p| PersonRow {
                    family: p.family.label(),
                    on: p.on.clone(),
                    pelvis_m: p.spot.pelvis.to_array(),
                    facing_deg: p.spot.facing_rad.to_degrees(),
                })
                .collect(),
            inserted: step.inserted.iter().map(thing).collect(),
            moved: step.moved.iter().map(moved).collect(),
            failed: step
                .failed
                .iter()
                .map(|f| FailedRow { object: f.object.clone(), why: f.why.clone() })
                .collect(),
            seconds: step.seconds,
            measures: measures.clone(),
            file: format!("steps/{:03}.glb", step.number),
        }
    }
}

/// A row of something that was brought.
pub fn thing(thing: &Inserted) -> ThingRow {
    ThingRow {
        object: thing.name.clone(),
        kind: thing.kind.clone(),
        on: thing.on.clone(),
        at_m: thing.pose.at.to_array(),
        yaw_deg: thing.pose.yaw_rad.to_degrees(),
        person: thing.person,
    }
}

/// A row of something that was moved.
pub fn moved(thing: &Moved) -> MovedRow {
    let turned = |a: &Pose, b: &Pose| (b.yaw_rad - a.yaw_rad).to_degrees();
    MovedRow {
        object: thing.name.clone(),
        from_m: thing.from.at.to_array(),
        to_m: thing.to.at.to_array(),
        distance_m: thing.distance_m(),
        turned_deg: (turned(&thing.from, &thing.to) + 180.0).rem_euclid(360.0) - 180.0,
        on: thing.on.clone(),
        why: thing.why.label(),
    }
}
