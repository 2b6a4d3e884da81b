//! `inhabit evaluate psi`: the methods in the corpus' test rooms and in rooms from elsewhere.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::Context as _;
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::charts::charts;
use crate::assets;
use crate::cli::output::OutputFolder;
use crate::cli::progress::run_job;
use crate::cli::{Common, Ended, load, use_threads};
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::evaluate_psi::{
    Evaluation, EvaluationConfig, EvaluationRoom, Evaluator, MethodToEvaluate, RandomPlacement, SearchPlacement,
};
use crate::scene::{ImportOptions, Room};

/// Rooms of `--rooms` in the tables.
const OUTSIDE: &str = "outside rooms";

/// Arguments of `evaluate psi`.
#[derive(Args, Debug)]
pub struct PsiArguments {
    /// Every method: the same as naming all in --methods.
    #[arg(long)]
    pub all: bool,
    /// Methods to evaluate, separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Subject::Random, Subject::Search, Subject::S1])]
    pub methods: Vec<Subject>,
    /// A folder with rooms that nobody trained on (GLB, glTF, OBJ, PLY, also in folders inside), or one room; may
    /// be given more than once.
    #[arg(long, value_name = "DIR")]
    pub rooms: Vec<PathBuf>,
    /// Folder for the tables; must be new or empty.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Write over an earlier run in the same folder.
    #[arg(long)]
    pub resume: bool,
    /// Bodies of each method in each room (the paper: 1200 a scene).
    #[arg(long, value_name = "N", default_value_t = EvaluationConfig::default().samples)]
    pub samples: usize,
    /// Of these, how many are fitted, by each of the two fits.
    #[arg(long, value_name = "N", default_value_t = EvaluationConfig::default().fitted)]
    pub fitted: usize,
    /// The agent's views of each room, among which the samples are shared out.
    #[arg(long, value_name = "N", default_value_t = EvaluationConfig::default().views)]
    pub views: usize,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// The rows of the tables.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// Human poses anywhere in the picture.
    Random,
    /// The affordance search.
    Search,
    /// Li et al.'s where and what modules, modified as in the paper.
    Baseline,
    /// PSI's joint network.
    S1,
    /// The joint network trained with contact and collision losses.
    S1Scene,
    /// PSI's network of two stages.
    S2,
    /// The network of two stages trained with contact and collision losses.
    S2Scene,
}

impl Subject {
    /// Name in the tables.
    fn label(self) -> &'static str {
        match self {
            Self::Random => "random placement",
            Self::Search => "search",
            Self::Baseline => "baseline",
            Self::S1 => "S1",
            Self::S1Scene => "S1 + L_HS",
            Self::S2 => "S2",
            Self::S2Scene => "S2 + L_HS",
        }
    }
}

/// Where a room comes from.
struct Source {
    name: String,
    set: &'static str,
    room: Arc<Room>,
}

/// What `evaluation.json` holds.
#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    version: &'static str,
    seed: u64,
    samples: usize,
    fitted: usize,
    views: usize,
    seconds: f64,
    evaluation: &'a Evaluation,
}

/// Runs the command.
///
/// # Errors
/// When there is no room, or one can't be read, or the output can't be written.
pub fn run(arguments: &PsiArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let started = Instant::now();
    let folder = OutputFolder::claim(&arguments.out, arguments.resume)?;
    let sources = outside_rooms(&arguments.rooms)?;
    anyhow::ensure!(!sources.is_empty(), "no room to evaluate in: name a folder with --rooms");
    let methods = methods(arguments);
    let config = EvaluationConfig {
        samples: arguments.samples,
        fitted: arguments.fitted,
        views: arguments.views,
        ..EvaluationConfig::default()
    };
    let work = move |cx: &JobCtx| evaluate(sources, methods, config, cx);
    let seed = Seed::root(arguments.common.seed);
    let Some(evaluation) = run_job("evaluate psi", seed, arguments.common.quiet, work)? else {
        return Ok(Ended::Interrupted);
    };
    write(&folder, &evaluation, arguments, started.elapsed().as_secs_f64())?;
    Ok(Ended::Clean)
}

fn evaluate(
    sources: Vec<Source>,
    methods: Vec<MethodToEvaluate>,
    config: EvaluationConfig,
    cx: &JobCtx,
) -> Result<Evaluation, Stop> {
    let mut evaluator = Evaluator::new(methods, config);
    for Source { name, set, room } in sources {
        let geometry = load::geometry(&room, cx.ticker())?;
        let room = EvaluationRoom { name, set: set.to_owned(), room, geometry };
        evaluator.room(&room, cx)?;
    }
    Ok(evaluator.finish(cx.seed))
}

fn methods(arguments: &PsiArguments) -> Vec<MethodToEvaluate> {
    let subjects = Subject::value_variants().iter().copied();
    let wanted = subjects.filter(|s| arguments.all || arguments.methods.contains(s));
    wanted.map(method).collect()
}

fn method(subject: Subject) -> MethodToEvaluate {
    MethodToEvaluate {
        name: subject.label().to_owned(),
        placer: match subject {
            Subject::Random => Ok(Box::new(RandomPlacement)),
            Subject::Search => Ok(Box::new(SearchPlacement)),
            _ => Err("this program holds no weights of it".to_owned()),
        },
        representer: None,
    }
}

/// Every room in the folders and files named, in the order of their names.
fn outside_rooms(paths: &[PathBuf]) -> anyhow::Result<Vec<Source>> {
    let mut files = Vec::new();
    for path in paths {
        room_files(path, &mut files)?;
    }
    let read = |file: &PathBuf| {
        let loaded = load::load(Some(file), &ImportOptions::default())?;
        let name = file.file_stem().map_or_else(|| "room".into(), |n| n.to_string_lossy().into_owned());
        Ok(Source { name, set: OUTSIDE, room: loaded.room })
    };
    files.iter().map(read).collect()
}

fn room_files(path: &Path, files: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    if !path.is_dir() {
        files.push(path.to_owned());
        return Ok(());
    }
    let listing = fs::read_dir(path).with_context(|| format!("can't read the folder {}", path.display()))?;
    let mut inside: Vec<PathBuf> = listing.filter_map(|e| e.ok().map(|e| e.path())).collect();
    inside.sort();
    for path in inside {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let is_room = ending.is_some_and(|e| ["glb", "gltf", "obj", "ply"].contains(&e.as_str()));
        if path.is_dir() || is_room {
            room_files(&path, files)?;
        }
    }
    Ok(())
}

fn write(
    folder: &OutputFolder,
    evaluation: &Evaluation,
    arguments: &PsiArguments,
    seconds: f64,
) -> anyhow::Result<()> {
    let report = Report {
        command: "evaluate psi",
        version: env!("CARGO_PKG_VERSION"),
        seed: arguments.common.seed,
        samples: arguments.samples,
        fitted: arguments.fitted,
        views: arguments.views,
        seconds,
        evaluation,
    };
    let json = serde_json::to_string_pretty(&report)?;
    folder.write("evaluation.json", json.as_bytes())?;
    let markdown = evaluation.markdown();
    folder.write("tables.md", markdown.as_bytes())?;
    folder.write("tables_2_and_3.csv", evaluation.csv().as_bytes())?;
    folder.write("table_1.csv", evaluation.representation_csv().as_bytes())?;
    for (name, picture) in charts(evaluation)? {
        let png = assets::encode_png(picture.width, picture.height, &picture.rgba)?;
        folder.write(&name, &png)?;
    }
    if arguments.common.json {
        println!("{json}");
    } else if !arguments.common.quiet {
        println!("{markdown}\nWritten to {} in {seconds:.0} s", folder.root().display());
    }
    Ok(())
}
