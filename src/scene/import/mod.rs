//! Makes a room of a model: finds its unit, its up axis and its floor, what its objects are and which parts
//! belong together. Pure: a [`Model`] in, a [`Room`] and a report in words out. May not drop a triangle.

mod atoms;
mod cluster;
mod measure;
mod names;
mod objects;
mod shape;
mod upright;

use std::collections::BTreeMap;

use serde::Serialize;

use super::Room;
use super::step::{Step, Stopped, report, unwatched};
use crate::assets::Model;
use crate::math::Aabb;

pub use upright::UpAxis;

/// What the user knows better than the file; everything else is found out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// Metres for one unit of the file.
    pub unit_scale: Option<f32>,
    /// The file's axis that points up.
    pub up: Option<UpAxis>,
}

/// A room and how it was understood.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The room: metres, Y up, its floor at y = 0, centred in x and z.
    pub room: Room,
    /// What was found out and why.
    pub report: ImportReport,
}

/// How a file was understood, for people and for `report.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ImportReport {
    /// Name of the file.
    pub source: String,
    /// Triangles of the room.
    pub triangles: usize,
    /// Size of the box around everything as the file has it, in its own units and axes.
    pub extent_in_file: [f32; 3],
    /// Size of the box around everything in metres, Y up.
    pub extent_m: [f32; 3],
    /// Metres for one unit of the file.
    pub unit_scale: f32,
    /// The unit's name, or "free" when no common unit fits.
    pub unit: String,
    /// The file's axis that points up.
    pub up: UpAxis,
    /// Height of the floor in the file, in metres above its origin along `up`; the room was moved down by it.
    pub floor_y: f32,
    /// How far the room was moved in x and z to be centred, in metres.
    pub centred_by_m: [f32; 2],
    /// Why unit, up axis and floor are what they are, in words.
    pub evidence: Vec<String>,
    /// What the reader dropped, mended or ignored.
    pub notes: Vec<String>,
    /// Objects of each category.
    pub categories: BTreeMap<String, usize>,
    /// Objects.
    pub objects: usize,
}

/// Makes a room of `model`. Deterministic; takes about a second for a million triangles.
pub fn room_from_model(model: &Model, options: &ImportOptions) -> Imported {
    match understand(model, options, &unwatched) {
        Ok(imported) => imported,
        Err(Stopped) => unreachable!("nobody stops what nobody watches"),
    }
}

/// As [`room_from_model`], and can be stopped.
///
/// # Errors
/// [`Stopped`] when `step` breaks off.
pub fn understand(model: &Model, options: &ImportOptions, step: Step) -> Result<Imported, Stopped> {
    let stance = upright::stance(model, options, step)?;
    let room = objects::room(model, &stance, step)?;
    report(step, 0, 0)?;
    let bounds = |b: Aabb| if b.is_empty() { [0.0; 3] } else { b.size().to_array() };
    let mut categories = BTreeMap::new();
    for object in &room.objects {
        *categories.entry(object.category.label().to_string()).or_insert(0) += 1;
    }
    let report = ImportReport {
        source: model.name.clone(),
        triangles: room.triangle_count(),
        extent_in_file: bounds(model.bounds()),
        extent_m: bounds(room.bounds()),
        unit_scale: stance.unit_scale,
        unit: stance.unit.to_string(),
        up: stance.up,
        floor_y: stance.floor_m,
        centred_by_m: [-stance.centre_m.x, -stance.centre_m.z],
        evidence: stance.evidence,
        notes: model.notes.clone(),
        categories,
        objects: room.objects.len(),
    };
    Ok(Imported { room, report })
}

#[cfg(test)]
mod tests;
