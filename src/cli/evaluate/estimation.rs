//! `inhabit evaluate estimation`: PSI table 5 on bodies whose truth is known.

mod tables;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use crate::body::Body;
use crate::cli::corpus::{read_manifest, read_room, read_room_model};
use crate::cli::load;
use crate::cli::output::OutputFolder;
use crate::cli::progress::run_job;
use crate::cli::scene_prior::{PriorSource, ScenePrior};
use crate::cli::{Common, Ended, use_threads};
use crate::evolve::{PopulateRequest, populate};
use crate::generate::sensor::Sensor;
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::corpus::{CorpusRoom, RoomEntry, Split, ViewKind, corpus_geometry};
use crate::learn::estimation::{
    CaseResult, ObserveConfig, cases_of_corpus, cases_of_room, study_room, summarise,
};
use crate::scene::{BodyParams, GeometryConfig, PoseFamily, Room};

/// People that are put into each room that is not of a corpus.
const PEOPLE: usize = 10;

/// Arguments of `evaluate estimation`.
#[derive(Args, Debug)]
pub struct EstimationArguments {
    /// Rooms: files, projects or `sample:NAME`; people are put into them by search and fit.
    #[arg(value_name = "ROOM", required_unless_present = "corpus")]
    pub rooms: Vec<PathBuf>,
    /// A corpus: people and cameras of its test rooms.
    #[arg(long, value_name = "DIR", conflicts_with = "rooms")]
    pub corpus: Option<PathBuf>,
    /// Views over all rooms.
    #[arg(long, default_value_t = 200, value_name = "N")]
    pub views: usize,
    /// Who says what people do in a scene: the centre of the scene-aware estimator's prior.
    #[arg(long, value_enum, default_value_t = PriorSource::S1)]
    pub prior: PriorSource,
    /// Weights of `inhabit train psi --method s1` instead of those that come with the program.
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Noise of well-seen keypoints in pixels of a picture 1920 wide.
    #[arg(long, default_value_t = 8.0, value_name = "PX")]
    pub noise_px: f32,
    /// Folder for `estimation.md`, `.csv` and `.json`; must be new or empty.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// A room that cases come from.
enum Place {
    /// Any room.
    Room(PathBuf),
    /// A room of a corpus.
    Corpus(PathBuf, RoomEntry),
}

/// What one room's job needs, owned.
struct Work {
    room: Room,
    staged: Option<CorpusRoom>,
    name: String,
    views: usize,
    first: u64,
    prior: Arc<ScenePrior>,
    observe: ObserveConfig,
}

/// Runs the command.
///
/// # Errors
/// When a room or the corpus can't be read or the output can't be written.
pub fn run(arguments: &EstimationArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let folder = OutputFolder::claim(&arguments.out, false)?;
    let observe = ObserveConfig { noise_px: arguments.noise_px.max(0.0), ..ObserveConfig::default() };
    let seed = Seed::root(arguments.common.seed);
    let prior = Arc::new(ScenePrior::of(arguments.prior, arguments.weights.as_deref())?);
    let places = places(arguments)?;
    let views = arguments.views.div_ceil(places.len().max(1));
    let mut results: Vec<CaseResult> = Vec::new();
    for (index, place) in places.iter().enumerate() {
        let work = work(place, views, (index * views) as u64, prior.clone(), observe)?;
        let seed = seed.child("room", index as u64);
        let job = move |cx: &JobCtx| of_room(&work, cx);
        let Some(of_room) = run_job("evaluate estimation", seed, arguments.common.quiet, job)? else {
            return Ok(Ended::Interrupted);
        };
        results.extend(of_room);
    }
    anyhow::ensure!(
        !results.is_empty(),
        "no body is seen by any camera: name rooms that people fit into, or a corpus with test rooms"
    );
    let summary = summarise(&results, seed);
    let report = tables::Report {
        command: "evaluate estimation",
        version: env!("CARGO_PKG_VERSION"),
        seed: arguments.common.seed,
        scene_prior: arguments.prior.label(),
        keypoints: observe,
        summary: &summary,
        cases: &results,
    };
    let (json, table) = (serde_json::to_string_pretty(&report)?, tables::markdown(&summary));
    folder.write("estimation.json", json.as_bytes())?;
    folder.write("estimation.md", table.as_bytes())?;
    folder.write("estimation.csv", tables::csv(&results).as_bytes())?;
    println!("{}", if arguments.common.json { json } else { table });
    Ok(Ended::Clean)
}

/// Rooms by name, or the test rooms of the corpus.
fn places(arguments: &EstimationArguments) -> anyhow::Result<Vec<Place>> {
    let Some(corpus) = &arguments.corpus else {
        return Ok(arguments.rooms.iter().cloned().map(Place::Room).collect());
    };
    let entries = read_manifest(corpus)?.rooms.into_iter().filter(|r| r.split == Split::Test);
    Ok(entries.map(|entry| Place::Corpus(corpus.clone(), entry)).collect())
}

fn work(
    place: &Place,
    views: usize,
    first: u64,
    prior: Arc<ScenePrior>,
    observe: ObserveConfig,
) -> anyhow::Result<Work> {
    let (room, staged, name) = match place {
        Place::Room(path) => {
            let loaded = load::load(Some(path), &crate::scene::ImportOptions::default())?;
            let room = Arc::unwrap_or_clone(loaded.room);
            (room, None, stem(path).unwrap_or(loaded.path))
        }
        Place::Corpus(folder, entry) => {
            (read_room_model(folder, entry)?, Some(read_room(folder, entry)?), entry.name.clone())
        }
    };
    Ok(Work { room, staged, name, views, first, prior, observe })
}

fn stem(path: &Path) -> Option<String> {
    path.file_stem().map(|name| name.to_string_lossy().into_owned())
}

fn of_room(work: &Work, cx: &JobCtx) -> Result<Vec<CaseResult>, Stop> {
    let config = if work.staged.is_some() { corpus_geometry() } else { GeometryConfig::default() };
    let geometry = load::geometry_of(&work.room, &config, cx.ticker())?;
    let mut cases = match &work.staged {
        Some(staged) => cases_of_corpus(staged, ViewKind::Virtual, work.views, work.first, Body::bundled()),
        None => {
            let people = people(work, &geometry, cx)?;
            let each = work.views.div_ceil(people.len().max(1));
            let mut cases = cases_of_room(&work.name, &geometry, &people, each, work.first, cx.seed);
            cases.truncate(work.views);
            cases
        }
    };
    let sensor = Sensor::new(&work.room, &geometry);
    // Other people than those who are estimated: another branch of the seeds.
    let prior = work.prior.in_room(&work.room, &sensor, cx.seed.child("scene prior", 0), cx.ticker())?;
    cx.stage("asking the scene", cases.len())?;
    for case in &mut cases {
        let image = case.image.take().unwrap_or_else(|| sensor.scene_image(&case.view));
        case.scene_code = prior.code(&image, case.number);
        cx.advance()?;
    }
    cx.stage("estimating people", cases.len())?;
    Ok(study_room(&geometry, &cases, &work.observe, cx.seed, cx.ticker())?)
}

fn people(
    work: &Work,
    geometry: &crate::scene::RoomGeometry,
    cx: &JobCtx,
) -> Result<Vec<(BodyParams, PoseFamily)>, Stop> {
    let request = PopulateRequest { people: PEOPLE, ..PopulateRequest::default() };
    let found = populate(&work.room, geometry, &request, &JobCtx::watched(cx.seed, cx.ticker().clone()))?;
    Ok(found.people.into_iter().map(|p| (p.person.body, p.person.family)).collect())
}
