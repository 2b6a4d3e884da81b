//! `inhabit train points|subgoal|route|pose|base`: the networks of long-term motion.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::{Args, ValueEnum};

use super::super::clips::read_clips;
use super::super::network::read_weights;
use super::super::progress::run_job;
use super::super::{Common, Ended, use_threads};
use crate::assets::{PoseClip, Weights, encode_png};
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::motion::{
    MotionData, MotionHistory, MotionPreset, MotionState, MotionTraining, TrainInput, train_motion,
};
use crate::nn::motion::{Between, MotionKind, MotionSampler};
use crate::render::plot::{Curve, LineChart, Scale, VerticalMark, line_chart};

/// Pixels of the picture of the curves.
const CHART: [u32; 2] = [1000, 600];

/// How large the network is.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Size {
    /// Minutes on one core.
    Compact,
    /// As published: hours.
    Paper,
}

/// Arguments of every network of motion.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Folder with motion clips: npz archives with `NAME/pose` arrays, BVH files and DeepMimic's text, also in
    /// folders below.
    #[arg(long, value_name = "DIR")]
    corpus: PathBuf,
    /// File for the weights (safetensors); curves (CSV, PNG) and checkpoints are written beside it.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// How large the network is.
    #[arg(long, value_enum, default_value_t = Size::Compact)]
    size: Size,
    /// A network that sees no room (the crosses of the paper's Table 1).
    #[arg(long)]
    no_scene: bool,
    /// Begin with the PointNet of these weights, of `inhabit train points`.
    #[arg(long, value_name = "FILE")]
    points: Option<PathBuf>,
    /// Epochs, each followed by a look at the validation clips.
    #[arg(long, value_name = "N")]
    epochs: Option<usize>,
    /// Windows, bodies or clouds of one epoch.
    #[arg(long, value_name = "N")]
    drawn: Option<usize>,
    /// Of one step.
    #[arg(long, value_name = "N")]
    batch: Option<usize>,
    /// Adam's step size.
    #[arg(long, value_name = "RATE")]
    rate: Option<f32>,
    /// Go on from the checkpoint beside --out.
    #[arg(long)]
    resume: bool,
    /// Write OUT.checkpoint.safetensors every so many epochs.
    #[arg(long, default_value_t = 5, value_name = "N")]
    checkpoint_every: usize,
    #[command(flatten)]
    common: Common,
}

/// Arguments of `train route`.
#[derive(Args, Debug)]
pub struct RouteArguments {
    /// RouteNet(t) of the paper's Table 1: places without rotations.
    #[arg(long)]
    places_only: bool,
    #[command(flatten)]
    shared: Arguments,
}

/// Arguments of `train pose`.
#[derive(Args, Debug)]
pub struct PoseArguments {
    /// The trained RouteNet, along whose routes PoseNet learns.
    #[arg(long, value_name = "FILE", required_unless_present_any = ["alone", "turning"])]
    route: Option<PathBuf>,
    /// PoseNet of the paper's Table 1 that is given no route.
    #[arg(long, conflicts_with = "route")]
    alone: bool,
    /// The same, for RouteNet(t): gives the rotations too.
    #[arg(long, conflicts_with_all = ["route", "alone"])]
    turning: bool,
    #[command(flatten)]
    shared: Arguments,
}

/// Runs `train points`, `train subgoal` or `train base`.
///
/// # Errors
/// When the corpus or a file can't be used or written.
pub fn run(kind: MotionKind, arguments: &Arguments) -> anyhow::Result<Ended> {
    train_kind(kind, arguments, None)
}

/// Runs `train route`.
///
/// # Errors
/// As [`run`].
pub fn run_route(arguments: &RouteArguments) -> anyhow::Result<Ended> {
    let which = if arguments.places_only { Between::RouteWhere } else { Between::Route };
    train_kind(MotionKind::Between(which), &arguments.shared, None)
}

/// Runs `train pose`.
///
/// # Errors
/// As [`run`].
pub fn run_pose(arguments: &PoseArguments) -> anyhow::Result<Ended> {
    let which = match (arguments.alone, arguments.turning) {
        (true, _) => Between::PoseAlone,
        (_, true) => Between::PoseTurning,
        _ => Between::Pose,
    };
    let route = arguments.route.as_deref().map(read_weights).transpose()?;
    train_kind(MotionKind::Between(which), &arguments.shared, route)
}

fn train_kind(kind: MotionKind, arguments: &Arguments, route: Option<Weights>) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let clips = read_clips(&arguments.corpus)?;
    let files = Files::new(arguments);
    let work = Work {
        training: arguments.training(kind),
        resume: arguments.resume.then(|| super::read_checkpoint(&files.checkpoint)).transpose()?,
        points: arguments.points.as_deref().map(read_weights).transpose()?,
        route,
        files,
    };
    let checkpoint = work.files.checkpoint.clone();
    let seed = Seed::root(arguments.common.seed);
    let run = move |cx: &JobCtx| work.run(&clips, cx);
    let name = format!("train {}", kind.label());
    let Some(state) = run_job(&name, seed, arguments.common.quiet, run)? else {
        eprintln!("interrupted; go on with --resume from {}", checkpoint.display());
        return Ok(Ended::Interrupted);
    };
    if arguments.common.json {
        println!("{}", serde_json::to_string_pretty(&state.history)?);
    } else if let (Some(row), false) = (state.history.best_row(), arguments.common.quiet) {
        println!(
            "{} numbers, {} epochs; kept epoch {}: {:.4} on the validation clips, {:.4} in training. Written to {}",
            state.best().trained_count(),
            state.epoch,
            row.epoch,
            row.validation,
            row.training,
            arguments.out.display()
        );
    }
    Ok(Ended::Clean)
}

impl Arguments {
    fn training(&self, kind: MotionKind) -> MotionTraining {
        let preset = match self.size {
            Size::Compact => MotionPreset::Compact,
            Size::Paper => MotionPreset::Paper,
        };
        let base = MotionTraining::of(preset, kind);
        let network = if self.no_scene { base.network.clone().blind() } else { base.network.clone() };
        MotionTraining {
            network,
            seed: self.common.seed,
            epochs: self.epochs.unwrap_or(base.epochs),
            drawn: self.drawn.unwrap_or(base.drawn).max(1),
            batch: self.batch.unwrap_or(base.batch).max(1),
            learning_rate: self.rate.unwrap_or(base.learning_rate),
            ..base
        }
    }
}

/// What is written on the way.
struct Files {
    out: PathBuf,
    checkpoint: PathBuf,
    every: usize,
}

impl Files {
    fn new(arguments: &Arguments) -> Self {
        Self {
            out: arguments.out.clone(),
            checkpoint: arguments.out.with_extension("checkpoint.safetensors"),
            every: arguments.checkpoint_every.max(1),
        }
    }

    /// The weights stand there after every epoch: a training that is stopped leaves what it has learnt.
    fn after_epoch(&self, state: &MotionState) -> Result<(), Stop> {
        let failed = |error: anyhow::Error| Stop::Failed(format!("{error:#}"));
        if state.epoch.is_multiple_of(self.every) || state.epoch == state.training.epochs {
            write(&self.checkpoint, &state.checkpoint()?).map_err(failed)?;
        }
        write(&self.out, &state.weights()?).map_err(failed)?;
        write_curves(&self.out, state).map_err(failed)
    }
}

struct Work {
    training: MotionTraining,
    resume: Option<Weights>,
    points: Option<Weights>,
    route: Option<Weights>,
    files: Files,
}

impl Work {
    fn run(&self, clips: &[PoseClip], cx: &JobCtx) -> Result<MotionState, Stop> {
        let data = MotionData::from_clips(clips, &self.training.data, cx.ticker())?;
        let route = self.route.as_ref().map(MotionSampler::from_weights).transpose()?;
        let mut state = match &self.resume {
            None => MotionState::new(self.training.clone(), data.id.clone(), self.points.as_ref())?,
            Some(weights) => MotionState::resume(self.training.clone(), data.id.clone(), weights)?,
        };
        let input = TrainInput { data: &data, route: route.as_ref() };
        train_motion(&mut state, &input, cx, &mut |state| self.files.after_epoch(state))?;
        Ok(state)
    }
}

fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    fs::write(path, bytes).with_context(|| format!("can't write {}: is the disk full?", path.display()))
}

/// The curves beside the weights: `OUT.csv` and `OUT.png`.
fn write_curves(out: &Path, state: &MotionState) -> anyhow::Result<()> {
    write(&out.with_extension("csv"), state.history.to_csv().as_bytes())?;
    if state.history.rows.len() < 2 {
        return Ok(());
    }
    let picture = line_chart(&chart(&state.history, &state.training), CHART)?;
    write(&out.with_extension("png"), &encode_png(picture.width, picture.height, &picture.rgba)?)
}

fn chart(history: &MotionHistory, training: &MotionTraining) -> LineChart {
    // The first four terms share their unit; the others are in the CSV.
    let names: Vec<&str> = history.rows[0].curves()[..4].iter().map(|(name, _)| *name).collect();
    let points =
        |c: usize| history.rows.iter().map(|r| [r.epoch as f64, f64::from(r.curves()[c].1)]).collect();
    let curves =
        names.iter().enumerate().map(|(c, name)| Curve { name: (*name).to_owned(), points: points(c) });
    let counts = |curve: &Curve| curve.points.iter().any(|[_, y]| *y > 0.0);
    LineChart {
        title: format!("train {}", training.network.kind.label()),
        x_label: "epoch".to_owned(),
        y_label: "loss (terms as in LTM eq. 3 and 4, means; logarithmic)".to_owned(),
        curves: curves.filter(counts).collect(),
        marks: vec![VerticalMark { x: history.best as f64, label: "kept".to_owned() }],
        y_scale: Scale::Log,
        ..LineChart::default()
    }
}
