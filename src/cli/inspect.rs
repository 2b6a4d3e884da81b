//! `inhabit inspect`: what was understood of a room, before anybody is put in.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::load;
use super::progress::run_job;
use super::report::RoomRow;
use super::{Common, Ended, use_threads};
use crate::job::{JobCtx, Seed};
use crate::scene::{ImportReport, Room, RoomGeometry};

/// Arguments of `inspect`.
#[derive(Args, Debug)]
pub struct InspectArguments {
    /// A room, a project, or `sample:living` and the like.
    #[arg(value_name = "ROOM|PROJECT")]
    pub room: PathBuf,
    /// How the room's file is to be read.
    #[command(flatten)]
    pub import: super::import::ImportArguments,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// The report of `inspect`.
#[derive(Debug, Serialize)]
struct InspectReport {
    command: &'static str,
    version: &'static str,
    room: RoomRow,
    import: Option<ImportReport>,
    categories: BTreeMap<&'static str, Vec<String>>,
    surfaces: Vec<SurfaceRow>,
    walkable_m2: f32,
    people: usize,
}

/// A support surface in the report.
#[derive(Debug, Serialize)]
struct SurfaceRow {
    object: Option<String>,
    height_m: f32,
    area_m2: f32,
    clearance_m: f32,
    edges: usize,
    has_back: bool,
}

/// Runs the command.
///
/// # Errors
/// When the room can't be read.
pub fn run(arguments: &InspectArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let loaded = load::load(Some(&arguments.room), &arguments.import.options()?)?;
    let started = Instant::now();
    let room = loaded.room.clone();
    let work = move |cx: &JobCtx| load::geometry(&room, cx.ticker());
    let Some(geometry) = run_job("inspect", Seed::root(arguments.common.seed), arguments.common.quiet, work)?
    else {
        return Ok(Ended::Interrupted);
    };
    let report = InspectReport {
        command: "inspect",
        version: env!("CARGO_PKG_VERSION"),
        room: load::room_row(&loaded, &geometry, started.elapsed().as_secs_f64()),
        categories: categories(&loaded.room),
        surfaces: surfaces(&loaded.room, &geometry),
        walkable_m2: geometry.floor.walkable_cells().count() as f32 * geometry.floor.cell_m.powi(2),
        people: loaded.people.len(),
        import: loaded.import,
    };
    if arguments.common.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        tell(&report);
    }
    Ok(Ended::Clean)
}

fn categories(room: &Room) -> BTreeMap<&'static str, Vec<String>> {
    let mut categories: BTreeMap<&'static str, Vec<String>> = BTreeMap::new();
    for object in &room.objects {
        categories.entry(object.category.label()).or_default().push(object.name.clone());
    }
    categories
}

fn surfaces(room: &Room, geometry: &RoomGeometry) -> Vec<SurfaceRow> {
    let row = |surface: &crate::scene::SupportSurface| SurfaceRow {
        object: surface.object.and_then(|id| room.object(id)).map(|o| o.name.clone()),
        height_m: surface.height_m,
        area_m2: surface.area_m2,
        clearance_m: surface.clearance_m,
        edges: surface.edges.len(),
        has_back: !surface.backs.is_empty(),
    };
    geometry.supports.iter().map(row).collect()
}

fn tell(report: &InspectReport) {
    let room = &report.room;
    let [x, y, z] = room.extent_m;
    println!(
        "{}: {x:.2} x {y:.2} x {z:.2} m, {} triangles, {} objects",
        room.path, room.triangles, room.objects
    );
    println!("Unit: {} m, up: {}", room.unit_scale, room.up);
    if let Some(import) = &report.import {
        import.evidence.iter().chain(&import.notes).for_each(|line| println!("  {line}"));
    }
    for (category, names) in &report.categories {
        println!("{category} ({}): {}", names.len(), names.join(", "));
    }
    let [nx, ny, nz] = room.field.dim;
    println!(
        "Distance field: {nx} x {ny} x {nz}, cells of {:.1} cm, {:.2} s with surfaces and ray tree",
        room.field.cell_m * 100.0,
        room.field.seconds
    );
    println!("Walkable floor: {:.1} m²", report.walkable_m2);
    for s in &report.surfaces {
        let object = s.object.as_deref().unwrap_or("(no object)");
        let back = if s.has_back { ", with a back" } else { "" };
        println!("Surface at {:.2} m: {:.2} m² on {object}{back}", s.height_m, s.area_m2);
    }
}
