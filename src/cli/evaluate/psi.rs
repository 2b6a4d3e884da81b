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
use crate::body::Body;
use crate::cli::corpus::{read_manifest, read_room, read_room_model};
use crate::cli::network::read_weights;
use crate::cli::output::OutputFolder;
use crate::cli::progress::run_job;
use crate::cli::{Common, Ended, load, use_threads};
use crate::generate::learned::{LearnedMethod, LearnedSampler};
use crate::generate::sensor::SceneImage;
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::corpus::{Manifest, RoomEntry, Split, ViewKind};
use crate::learn::evaluate_psi::{
    Evaluation, EvaluationConfig, EvaluationRoom, Evaluator, Example, LearnedPlacement, MethodToEvaluate,
    Placer, RandomPlacement, Representer, SearchPlacement,
};
use crate::nn::psi::PsiMethod;
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
    /// A corpus of `inhabit stage`: its test rooms are evaluated through its virtual cameras, and its people give
    /// Table 1.
    #[arg(long, value_name = "DIR")]
    pub corpus: Option<PathBuf>,
    /// Which of the corpus' rooms: `validation` to choose between networks, `test` to report.
    #[arg(long, value_enum, default_value_t = EvaluatedSplit::Test)]
    pub split: EvaluatedSplit,
    /// Take the networks' weights from this folder (`s1.safetensors`, `s1_hs.safetensors`, `s2.safetensors`,
    /// `s2_hs.safetensors`, `baseline.safetensors`) instead of the program.
    #[arg(long, value_name = "DIR")]
    pub weights: Option<PathBuf>,
    /// At most this many of the corpus' rooms.
    #[arg(long, value_name = "N")]
    pub test_rooms: Option<usize>,
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
    /// Views of each room, among which the samples are shared out: virtual cameras' in the corpus, an agent's elsewhere.
    #[arg(long, value_name = "N", default_value_t = EvaluationConfig::default().views)]
    pub views: usize,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// Rooms of a corpus that nobody learns from.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum EvaluatedSplit {
    /// Rooms by which networks are compared while they are made.
    Validation,
    /// Rooms for the tables.
    Test,
}

impl EvaluatedSplit {
    /// The split and its name in the tables.
    fn named(self) -> (Split, &'static str) {
        match self {
            Self::Validation => (Split::Validation, "validation rooms"),
            Self::Test => (Split::Test, "test rooms"),
        }
    }
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

impl Subject {
    /// The network; `None` for what was not learned.
    fn network(self) -> Option<LearnedMethod> {
        let (network, scene_loss) = match self {
            Self::Random | Self::Search => return None,
            Self::Baseline => (PsiMethod::Baseline, false),
            Self::S1 => (PsiMethod::S1, false),
            Self::S1Scene => (PsiMethod::S1, true),
            Self::S2 => (PsiMethod::S2, false),
            Self::S2Scene => (PsiMethod::S2, true),
        };
        Some(LearnedMethod { network, scene_loss })
    }
}

/// Where a room comes from.
enum Source {
    /// A file that is none of the corpus'.
    File(PathBuf),
    /// A room of the corpus in this folder.
    Corpus(PathBuf, RoomEntry),
}

/// What the job works on.
struct Work {
    sources: Vec<Source>,
    methods: Vec<MethodToEvaluate>,
    config: EvaluationConfig,
    corpus: Option<(PathBuf, Manifest)>,
    split: EvaluatedSplit,
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
    let work = prepared(arguments)?;
    let seed = Seed::root(arguments.common.seed);
    let work = move |cx: &JobCtx| evaluate(work, cx);
    let Some(evaluation) = run_job("evaluate psi", seed, arguments.common.quiet, work)? else {
        return Ok(Ended::Interrupted);
    };
    write(&folder, &evaluation, arguments, started.elapsed().as_secs_f64())?;
    Ok(Ended::Clean)
}

/// Everything that can be wrong with the arguments, found before the long work begins.
fn prepared(arguments: &PsiArguments) -> anyhow::Result<Work> {
    let mut sources = Vec::new();
    let mut corpus = None;
    if let Some(folder) = &arguments.corpus {
        let manifest = read_manifest(folder)?;
        let tests = manifest.rooms.iter().filter(|r| r.split == arguments.split.named().0);
        let tests = tests.take(arguments.test_rooms.unwrap_or(usize::MAX));
        sources.extend(tests.map(|entry| Source::Corpus(folder.clone(), entry.clone())));
        corpus = Some((folder.clone(), manifest));
    }
    let mut files = Vec::new();
    for path in &arguments.rooms {
        room_files(path, &mut files)?;
    }
    sources.extend(files.into_iter().map(Source::File));
    anyhow::ensure!(
        !sources.is_empty(),
        "no room to evaluate in: name a corpus with --corpus or rooms with --rooms"
    );
    let config = EvaluationConfig {
        samples: arguments.samples,
        fitted: arguments.fitted,
        views: arguments.views,
        ..EvaluationConfig::default()
    };
    Ok(Work { sources, methods: methods(arguments)?, config, corpus, split: arguments.split })
}

fn evaluate(work: Work, cx: &JobCtx) -> Result<Evaluation, Stop> {
    let mut evaluator = Evaluator::new(work.methods, work.config);
    if let Some((folder, manifest)) = &work.corpus {
        for (split, is_test) in [(Split::Train, false), (Split::Test, true)] {
            let examples = examples(folder, manifest, split, work.config.reconstructed, cx)?;
            evaluator.represent(&examples, is_test, cx)?;
        }
    }
    for source in &work.sources {
        let (name, room, images) =
            opened(source, work.config.views).map_err(|error| Stop::Failed(format!("{error:#}")))?;
        let set = match source {
            Source::Corpus(..) => work.split.named().1,
            Source::File(_) => OUTSIDE,
        };
        let room = Arc::new(room);
        let geometry = load::geometry(&room, cx.ticker())?;
        evaluator.room(&EvaluationRoom { name, set: set.to_owned(), room, geometry, images }, cx)?;
    }
    Ok(evaluator.finish(cx.seed))
}

/// A room with its name and, in a corpus, what `views` of its virtual cameras see, evenly from all.
fn opened(source: &Source, views: usize) -> anyhow::Result<(String, Room, Vec<SceneImage>)> {
    match source {
        Source::Corpus(folder, entry) => {
            let seen = read_room(folder, entry)?.views;
            let aimed: Vec<_> = seen.iter().filter(|v| v.kind == ViewKind::Virtual).collect();
            anyhow::ensure!(
                !aimed.is_empty(),
                "{} has no virtual cameras: stage it with --views",
                entry.name
            );
            let count = views.min(aimed.len());
            let images = (0..count).map(|i| aimed[i * aimed.len() / count].scene_image()).collect();
            Ok((entry.name.clone(), read_room_model(folder, entry)?, images))
        }
        Source::File(file) => {
            let room = load::load(Some(file), &ImportOptions::default())?.room;
            let name = file.file_stem().map_or_else(|| "room".into(), |n| n.to_string_lossy().into_owned());
            Ok((name, Room::clone(&room), Vec::new()))
        }
    }
}

/// People of a split as the agent sees them, evenly from its rooms, at most `most`.
fn examples(
    folder: &Path,
    manifest: &Manifest,
    split: Split,
    most: usize,
    cx: &JobCtx,
) -> Result<Vec<Example>, Stop> {
    let rooms: Vec<&RoomEntry> = manifest.rooms.iter().filter(|r| r.split == split).collect();
    cx.stage("reading people of the corpus", rooms.len())?;
    let a_room = most.div_ceil(rooms.len().max(1));
    let model = &Body::bundled().model;
    let mut examples = Vec::new();
    for entry in rooms {
        let room = read_room(folder, entry).map_err(|error| Stop::Failed(format!("{error:#}")))?;
        let seen: Vec<_> = room.views.iter().filter(|v| v.kind == ViewKind::Agent).collect();
        let stride = seen.len().div_ceil(a_room).max(1);
        examples.extend(seen.iter().step_by(stride).map(|view| {
            let in_world = room.people[view.body].params(Body::bundled());
            Example { in_camera: view.view.body_in_camera(&in_world, model), image: view.scene_image() }
        }));
        cx.advance()?;
    }
    examples.truncate(most);
    Ok(examples)
}

fn methods(arguments: &PsiArguments) -> anyhow::Result<Vec<MethodToEvaluate>> {
    let subjects = Subject::value_variants().iter().copied();
    let wanted = subjects.filter(|s| arguments.all || arguments.methods.contains(s));
    wanted.map(|s| method(s, arguments.weights.as_deref())).collect()
}

fn method(subject: Subject, weights: Option<&Path>) -> anyhow::Result<MethodToEvaluate> {
    let name = subject.label().to_owned();
    let Some(network) = subject.network() else {
        let placer: Box<dyn Placer> = match subject {
            Subject::Random => Box::new(RandomPlacement),
            _ => Box::new(SearchPlacement),
        };
        return Ok(MethodToEvaluate { name, placer: Ok(placer), representer: None });
    };
    let learned = |placer: Box<dyn Placer>, representer: Box<dyn Representer>| MethodToEvaluate {
        name: name.clone(),
        placer: Ok(placer),
        representer: Some(representer),
    };
    let missing = |why: String| MethodToEvaluate { name: name.clone(), placer: Err(why), representer: None };
    let Some(folder) = weights else {
        return Ok(match LearnedSampler::bundled(network) {
            Ok(sampler) => learned(Box::new(LearnedPlacement(sampler)), Box::new(LearnedPlacement(sampler))),
            Err(why) => missing(why.to_string()),
        });
    };
    let file = folder.join(format!("{}.safetensors", network.label()));
    if !file.is_file() {
        return Ok(missing(format!("there is no {}", file.display())));
    }
    let sampler = Arc::new(LearnedSampler::from_weights(&read_weights(&file)?)?);
    Ok(learned(Box::new(LearnedPlacement(sampler.clone())), Box::new(LearnedPlacement(sampler))))
}

/// Every room in a folder and the folders inside, in the order of their names; a file is taken as it is.
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
