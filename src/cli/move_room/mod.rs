//! `inhabit move`: people walk, sit down, lie and get up, without a window.

mod goals;
mod report;
mod strip;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::{Args, ValueEnum};

use self::report::{ClipRow, MoveReport, MoveSeconds};
use super::clips::read_clips;
use super::load::{self, Loaded};
use super::output::OutputFolder;
use super::progress::run_job;
use super::{Common, Ended, use_threads};
use crate::assets;
use crate::body::{self, Body};
use crate::document::{Project, save_project};
use crate::evolve::journey::{Journey, JourneyPreview, JourneyRequest, MotionMethod, journey, seed_of, tour};
use crate::job::{JobCtx, Seed, Stop, Ticker};
use crate::motion::retrieval::MotionMemory;
use crate::render::{BodySurface, clips_glb};
use crate::scene::{Clip, ClipId, GoalPose, Room, RoomGeometry, Scene, SubGoal};

/// Who sits or lies down stays so long at least, seconds.
const LEAST_STAY_S: f32 = 1.0;

/// Arguments of `move`.
#[derive(Args, Debug)]
pub struct MoveArguments {
    /// A room (GLB, glTF, OBJ, PLY), a project, or `sample:living`, `sample:bedroom`, `sample:office`.
    #[arg(value_name = "ROOM")]
    pub room: Option<PathBuf>,
    /// Where to be: a list of `(at: (x, y, z), facing_deg: Some(0.0), pose: Stand, stay_s: 0.0)`. Once for each
    /// person; who comes later keeps clear of who came before.
    #[arg(long, value_name = "FILE", required_unless_present = "tour")]
    pub goals: Vec<PathBuf>,
    /// Without goals: from the door to a desk chair, a sofa, a window, the bed and back, in about so many seconds.
    #[arg(long, value_name = "SECONDS", conflicts_with = "goals")]
    pub tour: Option<f32>,
    /// Lengthen or cut the stays on seats and beds, else the last one, until the motion lasts so long.
    #[arg(long, value_name = "S")]
    pub seconds: Option<f32>,
    /// Who makes the motion.
    #[arg(long, value_enum, default_value_t = MoveMethod::Gait)]
    pub method: MoveMethod,
    /// Folder of motion clips to look legs up in, for `--method retrieval`.
    #[arg(long, value_name = "DIR", required_if_eq("method", "retrieval"))]
    pub clips: Option<PathBuf>,
    /// Leave the motion as it was made, without fitting it to the room.
    #[arg(long)]
    pub no_optimise: bool,
    /// Folder for everything that is written; must be new or empty.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write over an earlier run in the same folder.
    #[arg(long)]
    pub resume: bool,
    /// No pictures.
    #[arg(long)]
    pub no_pictures: bool,
    /// How the room's file is to be read.
    #[command(flatten)]
    pub import: super::import::ImportArguments,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// Who makes the motion, as the command line names them.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveMethod {
    /// Steps by rule and by statistics of walks.
    Gait,
    /// RouteNet and PoseNet.
    Learned,
    /// Short clips from a memory, blended.
    Retrieval,
    /// RouteNet and a body from the sub-goal network in each frame.
    Cvae,
}

impl From<MoveMethod> for MotionMethod {
    fn from(method: MoveMethod) -> Self {
        match method {
            MoveMethod::Gait => Self::Gait,
            MoveMethod::Learned => Self::Learned,
            MoveMethod::Retrieval => Self::Retrieval,
            MoveMethod::Cvae => Self::RouteCvae,
        }
    }
}

/// All that the job computes, before anything is written.
struct Computed {
    geometry: RoomGeometry,
    journeys: Vec<Journey>,
    field_seconds: f64,
    move_seconds: f64,
}

/// Runs the command.
///
/// # Errors
/// When the room or the goals can't be read, no sub-goal can be reached, or the output can't be written.
pub fn run(arguments: &MoveArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let started = Instant::now();
    let loaded = load::load(arguments.room.as_deref(), &arguments.import.options()?)?;
    let asked = arguments.goals.iter().map(|file| goals::read(file)).collect::<anyhow::Result<Vec<_>>>()?;
    let mut seconds = MoveSeconds { load: started.elapsed().as_secs_f64(), ..MoveSeconds::default() };
    let root = arguments.out.clone().unwrap_or_else(load::default_output);
    let folder = OutputFolder::claim(&root, arguments.resume)?;
    let Some(computed) = compute(arguments, &loaded, asked)? else { return Ok(Ended::Interrupted) };
    (seconds.field, seconds.motion) = (computed.field_seconds, computed.move_seconds);
    let writing = Instant::now();
    let clips: Vec<Arc<Clip>> = computed.journeys.iter().map(|j| Arc::new(j.clip.clone())).collect();
    write_scene(&folder, &loaded, &clips)?;
    let pictures_by = match arguments.no_pictures {
        true => "nobody: --no-pictures".to_owned(),
        false => strip::write(&folder, &loaded.room, &clips)?,
    };
    seconds.write = writing.elapsed().as_secs_f64();
    seconds.total = started.elapsed().as_secs_f64();
    let report = report(arguments, &loaded, &computed, seconds, pictures_by);
    let json = serde_json::to_string_pretty(&report)?;
    folder.write("report.json", json.as_bytes())?;
    tell(arguments, &report, &folder, &json);
    Ok(if report.is_clean() { Ended::Clean } else { Ended::WithFindings })
}

fn compute(
    arguments: &MoveArguments,
    loaded: &Loaded,
    asked: Vec<Vec<SubGoal>>,
) -> anyhow::Result<Option<Computed>> {
    let room = loaded.room.clone();
    let (tour_s, wanted_s) = (arguments.tour, arguments.seconds.or(arguments.tour));
    let (before, user_seed) = (loaded.clips.clone(), arguments.common.seed);
    let first_id = before.iter().map(|c| c.id.0 + 1).max().unwrap_or(0);
    let request = JourneyRequest {
        method: arguments.method.into(),
        memory: memory(arguments)?,
        optimise: !arguments.no_optimise,
        ..JourneyRequest::default()
    };
    let work = move |cx: &JobCtx| {
        let started = Instant::now();
        let geometry = load::geometry(&room, cx.ticker())?;
        let field_seconds = started.elapsed().as_secs_f64();
        let moving = Instant::now();
        let asked = match tour_s {
            Some(seconds) => vec![tour(&room, &geometry, seconds, cx.ticker())?],
            None => asked,
        };
        let mut journeys: Vec<Journey> = Vec::new();
        for (number, goals) in asked.into_iter().enumerate() {
            let id = first_id + number as u32;
            let new = journeys.iter().map(|j| Arc::new(j.clip.clone()));
            let request = JourneyRequest {
                id: ClipId(id),
                name: format!("Motion {}", id + 1),
                palette: id,
                goals,
                others: before.iter().cloned().chain(new).collect(),
                ..request.clone()
            };
            let seed = seed_of(cx.seed, request.id);
            let mut made = lasting(&room, &geometry, request, wanted_s, &child(cx, seed))?;
            made.clip.seed = user_seed;
            journeys.push(made);
        }
        let move_seconds = moving.elapsed().as_secs_f64();
        Ok(Computed { geometry, journeys, field_seconds, move_seconds })
    };
    run_job("move", Seed::root(arguments.common.seed), arguments.common.quiet, work)
}

/// The clips that legs are looked up in, where the method does that.
fn memory(arguments: &MoveArguments) -> anyhow::Result<Option<Arc<MotionMemory>>> {
    let (MoveMethod::Retrieval, Some(folder)) = (arguments.method, &arguments.clips) else { return Ok(None) };
    let memory = MotionMemory::new(&read_clips(folder)?, Body::bundled(), &Ticker::silent());
    Ok(memory.ok().map(Arc::new))
}

/// The same job's context for one person, whose previews nobody reads.
fn child<P: 'static>(cx: &JobCtx, seed: Seed) -> JobCtx<P> {
    JobCtx::watched(seed, cx.ticker().clone())
}

/// The journey; where it should last a given time, its stays are lengthened or cut to that.
fn lasting(
    room: &Room,
    geometry: &RoomGeometry,
    mut request: JourneyRequest,
    wanted_s: Option<f32>,
    cx: &JobCtx<JourneyPreview>,
) -> Result<Journey, Stop> {
    let body = Body::bundled();
    if let Some(wanted_s) = wanted_s {
        let rough = JourneyRequest { optimise: false, ..request.clone() };
        let rough = journey(room, geometry, body, &rough, cx)?.clip;
        spend(&mut request.goals, &rough, wanted_s - rough.seconds());
    }
    journey(room, geometry, body, &request, cx)
}

/// Spreads the time that is missing, or too much, over the stays on seats and beds, else over the last stay; bodies
/// that are known need not be made again.
fn spend(goals: &mut [SubGoal], made: &Clip, missing_s: f32) {
    for goal in goals.iter_mut() {
        goal.body = made.goal(goal.id).and_then(|g| g.body.clone());
    }
    let rests = |g: &SubGoal| g.stay_s > 0.0 && matches!(g.pose, GoalPose::Sit | GoalPose::Lie);
    let count = goals.iter().filter(|g| rests(g)).count();
    if count == 0 {
        goals.iter_mut().next_back().into_iter().for_each(|g| g.stay_s = (g.stay_s + missing_s).max(0.0));
    }
    for goal in goals.iter_mut().filter(|g| rests(g)) {
        goal.stay_s = (goal.stay_s + missing_s / count as f32).max(LEAST_STAY_S);
    }
}

/// Writes the project with its room, and every motion for other programs.
fn write_scene(folder: &OutputFolder, loaded: &Loaded, clips: &[Arc<Clip>]) -> anyhow::Result<()> {
    let scene = Scene {
        room: loaded.room.clone(),
        people: loaded.people.clone(),
        clips: loaded.clips.iter().chain(clips).cloned().collect(),
    };
    save_project(&folder.root().join("project.ron"), &Project::of_scene(scene))?;
    let (body, surface) = (Body::bundled(), BodySurface::of(Body::bundled()));
    for (number, clip) in clips.iter().enumerate() {
        let name = file_stem(number);
        folder.write(
            &format!("{name}.glb"),
            &clips_glb(&clip.name, None, std::iter::once(clip.as_ref()), &surface)?,
        )?;
        folder.write(&format!("{name}.npz"), &body::amass_motion(body, clip).to_npz()?)?;
        let bvh = assets::write_bvh(&body::rig_motion(body, clip));
        folder.write(&format!("{name}.bvh"), bvh.as_bytes())?;
    }
    Ok(())
}

/// `clip` for the first motion, `clip_1` for the second.
fn file_stem(number: usize) -> String {
    if number == 0 { "clip".to_owned() } else { format!("clip_{number}") }
}

fn report(
    arguments: &MoveArguments,
    loaded: &Loaded,
    computed: &Computed,
    seconds: MoveSeconds,
    pictures_by: String,
) -> MoveReport {
    let rows = computed.journeys.iter().enumerate();
    MoveReport {
        command: "move".to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed: arguments.common.seed,
        room: load::room_row(loaded, &computed.geometry, computed.field_seconds),
        method: MotionMethod::from(arguments.method).label().to_owned(),
        clips: rows.map(|(n, j)| ClipRow::new(j, &loaded.room, &file_stem(n))).collect(),
        seconds,
        pictures_by,
    }
}

fn tell(arguments: &MoveArguments, report: &MoveReport, folder: &OutputFolder, json: &str) {
    if arguments.common.json {
        println!("{json}");
    } else if !arguments.common.quiet {
        for clip in &report.clips {
            println!("{}", clip.in_words());
        }
        println!(
            "Made in {:.1} s. Written to {}: clip.glb, clip.npz, clip.bvh, strip.png, project.ron, report.json",
            report.seconds.motion,
            folder.root().display()
        );
    }
    for complaint in report.clips.iter().flat_map(|c| &c.complaints) {
        eprintln!("inhabit: {complaint}.");
    }
}
