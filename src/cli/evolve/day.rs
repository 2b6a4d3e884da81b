//! `inhabit evolve --day`: one timeline of somebody who goes from action to action.

use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;

use super::EvolveArguments;
use super::report::{FailedRow, MovedRow, ThingRow, moved, thing};
use crate::assets::{ObjectMotion, encode_png};
use crate::body::Body;
use crate::cli::Ended;
use crate::cli::output::OutputFolder;
use crate::cli::progress::run_job;
use crate::document::{Project, save_project};
use crate::evolve::action::{ActionModel, RoomMeasures};
use crate::evolve::action::{Evolution, EvolutionConfig, Library, Stage, measure};
use crate::evolve::day::{Day, DayRequest, Moment, day};
use crate::job::{JobCtx, Seed};
use crate::math::Aabb;
use crate::render::{
    Backend, BodySurface, Cutaway, Film, Painter, Picture, Quality, SceneDraw, frame_bounds, moving_room_glb,
};
use crate::scene::{Camera, ObjectId, Room, Scene};

/// Pictures a second in the strip.
const PER_SECOND: f32 = 1.0;
/// Most pictures of a strip.
const MOST: usize = 240;
/// Size of one picture.
const TILE: [u32; 2] = [320, 280];
/// Pictures side by side.
const COLUMNS: usize = 8;
/// Half of what a picture shows around the person, metres, and up to which height.
const AROUND_M: (f32, f32) = (1.1, 1.7);
/// Where the camera stands, from what it looks at, for each strip.
const FROM: [(&str, glam::Vec3); 2] = [
    ("strip.png", glam::Vec3::new(0.66, 0.6, 0.75)),
    ("strip_behind.png", glam::Vec3::new(-0.66, 0.6, -0.75)),
];
/// A 35 mm lens.
const FOV_Y: f32 = 0.66;

/// `evolution.json`: what was done when, and what is wrong with the room in the end.
#[derive(Serialize)]
struct DayReport {
    command: &'static str,
    version: &'static str,
    seed: u64,
    seconds: f32,
    computed_in_s: f64,
    moments: Vec<MomentRow>,
    refused: Vec<String>,
    last: RoomMeasures,
}

/// One action on the timeline.
#[derive(Serialize)]
struct MomentRow {
    step: usize,
    action: String,
    key_object: String,
    changes_s: f32,
    arrives_s: f32,
    leaves_s: f32,
    walked: bool,
    inserted: Vec<ThingRow>,
    moved: Vec<MovedRow>,
    failed: Vec<FailedRow>,
}

/// Makes and writes the day.
///
/// # Errors
/// When nothing can be done or walked to, or the output can't be written.
pub fn run(
    arguments: &EvolveArguments,
    room: Arc<Room>,
    model: Arc<ActionModel>,
    config: EvolutionConfig,
    locked: &[ObjectId],
    folder: &OutputFolder,
) -> anyhow::Result<Ended> {
    let started = Instant::now();
    let request = DayRequest { actions: arguments.actions, ..DayRequest::default() };
    let locked = locked.to_vec();
    let work = move |cx: &JobCtx| {
        let stage = Arc::new(Stage::new(room, Library::bundled(), cx.ticker())?);
        let mut start = Evolution::new(stage, model, config, cx.seed);
        locked.iter().for_each(|id| start.lock(*id, true));
        day(&start, &request, &JobCtx::watched(cx.seed, cx.ticker().clone()))
    };
    let root = Seed::root(arguments.common.seed);
    let Some(made) = run_job("day", root, arguments.common.quiet, work)? else {
        return Ok(Ended::Interrupted);
    };
    let computed_in_s = started.elapsed().as_secs_f64();
    write_scene(folder, &made)?;
    if !arguments.no_pictures {
        strips(folder, &made)?;
    }
    let report = report(arguments, &made, computed_in_s);
    let json = serde_json::to_string_pretty(&report)?;
    folder.write("evolution.json", json.as_bytes())?;
    tell(arguments, &report, folder, &json);
    let whole = report.moments.len() == arguments.actions;
    Ok(if whole { Ended::Clean } else { Ended::WithFindings })
}

/// The animated scene, and the room in the end with the motion as a project.
fn write_scene(folder: &OutputFolder, made: &Day) -> anyhow::Result<()> {
    let Some(last) = made.states.last() else { return Ok(()) };
    let room = last.room();
    let motions: Vec<ObjectMotion> =
        made.tracks().iter().filter_map(|track| track.motion_in(&room)).collect();
    let surface = BodySurface::of(Body::bundled());
    let glb = moving_room_glb("a day", Some(&room), &motions, [&made.clip], &surface)?;
    folder.write("day.glb", &glb)?;
    let clips = vec![Arc::new(made.clip.clone())];
    let scene = Scene { room: Arc::new(room), people: Vec::new(), clips };
    save_project(&folder.root().join("project.ron"), &Project::of_scene(scene))?;
    Ok(())
}

/// Pictures at even times from two opposite sides, each with the things where they are by then.
fn strips(folder: &OutputFolder, made: &Day) -> anyhow::Result<()> {
    let painter = Painter::new(Backend::Auto)?;
    let surface = Arc::new(BodySurface::of(Body::bundled()));
    let films: Vec<Film> = made
        .states
        .iter()
        .map(|state| {
            let mut scene = SceneDraw::of_room(&Scene { room: Arc::new(state.room()), ..Scene::default() });
            scene.body = Some(surface.clone());
            scene.look.quality = Quality::Low;
            scene.look.cutaway = Cutaway::Outside;
            let fps = PER_SECOND.min(MOST as f32 / made.clip.seconds().max(1.0));
            let clips = vec![Arc::new(made.clip.clone())];
            Film { scene, clips, camera: Camera::default(), size: TILE, fps }
        })
        .collect();
    let Some(first) = films.first() else { return Ok(()) };
    let (count, fps) = (first.pictures(), first.fps);
    for (file, direction) in FROM {
        let [width, height] = TILE.map(|side| side as usize);
        let mut sheet = Picture::blank([COLUMNS.min(count) * width, count.div_ceil(COLUMNS) * height]);
        for number in 0..count {
            let seconds = number as f32 / fps;
            let begun = made.state_at(seconds).steps().len();
            let mut film = films[begun.min(films.len() - 1)].clone();
            film.camera = camera(made, seconds, direction);
            let picture = film.draw(&painter, number)?;
            sheet.paste([number % COLUMNS * width, number / COLUMNS * height], &picture);
        }
        folder.write(file, &encode_png(sheet.width, sheet.height, &sheet.rgba)?)?;
    }
    Ok(())
}

fn camera(made: &Day, seconds: f32, direction: glam::Vec3) -> Camera {
    let frame = made.clip.frames.get(made.clip.frame_at(seconds));
    let at = frame.map_or(glam::Vec3::ZERO, |f| f.translation);
    let (half, high) = AROUND_M;
    let around = Aabb {
        min: glam::Vec3::new(at.x - half, 0.0, at.z - half),
        max: glam::Vec3::new(at.x + half, high, at.z + half),
    };
    frame_bounds(&around, direction, FOV_Y, TILE[0] as f32 / TILE[1] as f32)
}

fn report(arguments: &EvolveArguments, made: &Day, computed_in_s: f64) -> DayReport {
    let row = |(moment, state): (&Moment, &Evolution)| {
        let step = state.steps().last();
        let failed = step.iter().flat_map(|s| &s.failed);
        MomentRow {
            step: moment.step,
            action: moment.action.clone(),
            key_object: moment.key.clone(),
            changes_s: moment.changes_s,
            arrives_s: moment.arrives_s,
            leaves_s: moment.leaves_s,
            walked: moment.walked,
            inserted: step.iter().flat_map(|s| &s.inserted).map(thing).collect(),
            moved: step.iter().flat_map(|s| &s.moved).map(moved).collect(),
            failed: failed.map(|f| FailedRow { object: f.object.clone(), why: f.why.clone() }).collect(),
        }
    };
    DayReport {
        command: "evolve --day",
        version: env!("CARGO_PKG_VERSION"),
        seed: arguments.common.seed,
        seconds: made.clip.seconds(),
        computed_in_s,
        moments: made.moments.iter().zip(made.states.iter().skip(1)).map(row).collect(),
        refused: made.refused.clone(),
        last: made.states.last().map(measure).unwrap_or_default(),
    }
}

fn tell(arguments: &EvolveArguments, report: &DayReport, folder: &OutputFolder, json: &str) {
    if arguments.common.json {
        println!("{json}");
    } else if !arguments.common.quiet {
        for moment in &report.moments {
            let how = if moment.walked { "walks to" } else { "turns to" };
            println!("{:6.1} s  {how} \"{}\" at {}", moment.arrives_s, moment.action, moment.key_object);
        }
        println!(
            "{:.0} s of a day in {:.0} s. Written to {}: day.glb, strip.png, strip_behind.png, project.ron, \
             evolution.json",
            report.seconds,
            report.computed_in_s,
            folder.root().display()
        );
    }
    if report.moments.len() < arguments.actions {
        let why = report.refused.last().map_or("nothing more can be done here", String::as_str);
        eprintln!("inhabit: {} of {} actions: {why}", report.moments.len(), arguments.actions);
    }
}
