//! `inhabit learn actions`: annotations of photos to an action model, with a report of what it rests on.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context as _;
use clap::{Args, ValueEnum};

use super::super::output::OutputFolder;
use super::super::progress::run_job;
use super::super::{Common, Ended, use_threads};
use super::figures;
use crate::assets::photos::{PhotoSet, Photos};
use crate::evolve::action::ActionModel;
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::actions::pose::{PoseDictionary, PoseSolver, PoseSolverConfig};
use crate::learn::actions::simulate::{Recovery, degradation};
use crate::learn::actions::{
    self as learner, ActionReport, Found, InstanceConfig, LayoutFrame, ModelConfig, Rules, Search,
};
use crate::math::directions::Criterion;

/// How the floor plan lies in photos.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// Facing kept, fixed camera pitch, the origin of people who stand at a worktop's height.
    Pitched,
    /// The same with everybody's origin in the torso.
    Torso,
    /// The paper's: the torso's own right and front as the photo shows them.
    Raw,
}

/// What decides how many components a distribution of directions has.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Components {
    /// Akaike's criterion, as the paper.
    Aic,
    /// The same, corrected for few samples.
    Aicc,
    /// Schwarz's criterion.
    Bic,
}

/// Arguments of `learn actions`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Files or folders with annotations: COCO, V-COCO and LabelMe json, captions as csv, boxes as text, joints as tsv.
    #[arg(value_name = "DATA", required = true)]
    data: Vec<PathBuf>,
    /// File for the model; the report goes to a folder beside it, named after it with `_report`.
    #[arg(long, value_name = "FILE.ron")]
    out: PathBuf,
    /// Write over an earlier report.
    #[arg(long)]
    resume: bool,
    /// Search captions for the paper's words only.
    #[arg(long)]
    strict: bool,
    /// Use captions only, not what people were marked as doing.
    #[arg(long)]
    captions_only: bool,
    /// How the floor plan lies in photos.
    #[arg(long, value_enum, default_value_t = Frame::Pitched)]
    frame: Frame,
    /// What decides how many components a distribution of directions has.
    #[arg(long, value_enum, default_value_t = Components::Aic)]
    components: Components,
    /// Other words, verbs and labels to look for: a copy of the bundled assets/actions/rules.ron, changed.
    #[arg(long, value_name = "FILE.ron")]
    rules: Option<PathBuf>,
    /// Also prove the learner on simulated photos whose truth is known; takes minutes.
    #[arg(long)]
    simulate: bool,
    #[command(flatten)]
    common: Common,
}

/// What the job gives.
struct Learned {
    model: ActionModel,
    found: Found,
    report: ActionReport,
    simulated: Vec<(String, Recovery)>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let started = Instant::now();
    let folder = OutputFolder::claim(&report_folder(&arguments.out), arguments.resume)?;
    let rules = match &arguments.rules {
        Some(file) => {
            let text = fs::read_to_string(file).with_context(|| format!("can't read {}", file.display()))?;
            Rules::from_ron(&text).with_context(|| file.display().to_string())?
        }
        None => Rules::bundled().clone(),
    };
    let photos = read_photos(&arguments.data)?;
    let read_s = started.elapsed().as_secs_f64();
    let (instances, model) = configs(arguments);
    let (simulate, seed) = (arguments.simulate, Seed::root(arguments.common.seed));
    let number = arguments.common.seed;
    let work = move |cx: &JobCtx| learn(&photos, &rules, instances, model, simulate, number, cx);
    let Some(mut learned) = run_job("learn actions", seed, arguments.common.quiet, work)? else {
        return Ok(Ended::Interrupted);
    };
    learned.report.seconds.insert("read".into(), read_s);
    learned.model.provenance.command = command_line(arguments);
    learned.model.provenance.licence = LICENCE.to_owned();
    fs::write(&arguments.out, learned.model.to_ron()?)
        .with_context(|| format!("can't write {}", arguments.out.display()))?;
    let drawing = Instant::now();
    figures::write(&folder, &learned.model, &learned.found, &learned.report, &learned.simulated)?;
    learned.report.seconds.insert("draw".into(), drawing.elapsed().as_secs_f64());
    learned.report.seconds.insert("total".into(), started.elapsed().as_secs_f64());
    let markdown = figures::markdown(&learned.report, &learned.simulated);
    folder.write("report.md", markdown.as_bytes())?;
    let json = serde_json::to_string_pretty(&learned.report)?;
    folder.write("report.json", json.as_bytes())?;
    if arguments.common.json {
        println!("{json}");
    } else if !arguments.common.quiet {
        print!("{markdown}");
    }
    Ok(Ended::Clean)
}

/// What stands in every learned model.
const LICENCE: &str = "Statistics of annotations of photos. Of the bundled model: COCO annotations (c) COCO Consortium, CC BY 4.0; \
     interactions from V-COCO (c) Saurabh Gupta and the Regents of the University of California, MIT. No photograph was used.";

fn report_folder(out: &Path) -> PathBuf {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    out.with_file_name(format!("{stem}_report"))
}

/// The command without the user's own paths.
fn command_line(arguments: &Arguments) -> String {
    let mut text = "inhabit learn actions DATA --out actions.ron".to_owned();
    let mut add = |on: bool, option: &str| {
        if on {
            text.push(' ');
            text.push_str(option);
        }
    };
    add(arguments.strict, "--strict");
    add(arguments.captions_only, "--captions-only");
    add(arguments.frame == Frame::Raw, "--frame raw");
    add(arguments.frame == Frame::Torso, "--frame torso");
    add(arguments.components == Components::Aicc, "--components aicc");
    add(arguments.components == Components::Bic, "--components bic");
    add(arguments.rules.is_some(), "--rules RULES");
    format!("{text} --seed {}", arguments.common.seed)
}

fn configs(arguments: &Arguments) -> (InstanceConfig, ModelConfig) {
    let frame = match arguments.frame {
        Frame::Pitched => LayoutFrame::default(),
        Frame::Torso => LayoutFrame::Pitched { pitch_deg: 20.0, lowered: false },
        Frame::Raw => LayoutFrame::Raw,
    };
    let instances = InstanceConfig {
        search: if arguments.strict { Search::Strict } else { Search::Wide },
        interactions: !arguments.captions_only,
        frame,
        ..InstanceConfig::default()
    };
    let mut model = ModelConfig::default();
    model.mixture.criterion = match arguments.components {
        Components::Aic => Criterion::Aic,
        Components::Aicc => Criterion::Aicc,
        Components::Bic => Criterion::Bic,
    };
    (instances, model)
}

/// Everything in the named files and folders, folders by the order of their paths.
fn read_photos(data: &[PathBuf]) -> anyhow::Result<Photos> {
    let mut files = Vec::new();
    for path in data {
        list(path, path.is_file(), &mut files).with_context(|| {
            format!("can't read {}: name files or folders with annotations", path.display())
        })?;
    }
    anyhow::ensure!(
        !files.is_empty(),
        "no annotations in {}: files ending in {} are read",
        data.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", "),
        PhotoSet::ENDINGS.join(", ")
    );
    let mut set = PhotoSet::default();
    for file in &files {
        set.add_file(file)?;
    }
    Ok(set.finish())
}

fn list(path: &Path, named: bool, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if path.is_dir() {
        let mut inside: Vec<PathBuf> =
            fs::read_dir(path)?.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>()?;
        inside.sort();
        return inside.iter().try_for_each(|path| list(path, false, files));
    }
    fs::metadata(path)?;
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if named || PhotoSet::ENDINGS.contains(&ending.as_str()) {
        files.push(path.to_owned());
    }
    Ok(())
}

fn learn(
    photos: &Photos,
    rules: &Rules,
    instances: InstanceConfig,
    config: ModelConfig,
    simulate: bool,
    number: u64,
    cx: &JobCtx,
) -> Result<Learned, Stop> {
    let mut seconds = BTreeMap::new();
    let mut clock = Instant::now();
    let mut lap = |name: &str| {
        seconds.insert(name.to_owned(), clock.elapsed().as_secs_f64());
        clock = Instant::now();
    };
    let unit = instances.frame.metres_per_unit();
    let solver = PoseSolver::new(PoseDictionary::bundled(), PoseSolverConfig::default());
    let found = learner::find_instances(&photos.photos, rules, &instances, &solver, cx)?;
    lap("find instances and poses");
    cx.stage("learning distributions", 0)?;
    let model = learner::build_model(&found, rules, &config, unit, cx.seed);
    lap("distributions");
    let likelihood = learner::held_out_likelihood(&found, rules, &config, unit, cx.seed, cx)?;
    let reference = learner::reference_rows(&found, &config, cx.seed);
    lap("held-out likelihood");
    let simulated = if simulate {
        cx.stage("simulating photos", 0)?;
        degradation(cx.seed, cx)?
    } else {
        Vec::new()
    };
    let (seated_asked, seated_told_by_angles) = learner::seated_told_by_angles(&found);
    let report = ActionReport {
        command: "learn actions".to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed: number,
        instances,
        model: config,
        photos_with_captions: found.photos_with_captions,
        photos_with_interactions: found.photos_with_interactions,
        photos_used: model.provenance.images,
        people_without_size: photos.people_without_size,
        funnels: found.funnels.iter().map(|(kind, f)| (kind.label().to_owned(), f.clone())).collect(),
        nodes: learner::node_rows(&model),
        warnings: learner::warnings(&model),
        posture_evidence: learner::posture_evidence(&found),
        seated_told_by_angles,
        seated_asked,
        reference,
        likelihood,
        graph: model.graph(),
        seconds,
    };
    Ok(Learned { model, found, report, simulated })
}
