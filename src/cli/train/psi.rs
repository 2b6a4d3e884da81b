//! `inhabit train psi`: the networks that put people into what a camera sees.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::{Args, ValueEnum};
use glam::Vec3;
use rayon::prelude::*;

use super::super::corpus::{read_corpus, read_manifest, read_room_model};
use super::super::progress::run_job;
use super::super::{Common, Ended, use_threads};
use crate::assets::{Weights, encode_png};
use crate::job::{JobCtx, Seed, Stop, Ticker};
use crate::learn::corpus::{RoomEntry, Split, corpus_geometry};
use crate::learn::psi::{
    DrawnWeights, History, LossPreset, PsiData, PsiTraining, TrainingInput, TrainingState, train,
};
use crate::nn::psi::{PsiConfig, PsiMethod};
use crate::render::plot::{Curve, LineChart, Scale, VerticalMark, line_chart};
use crate::scene::{SignedDistanceField, bake_cached};

/// Pixels of the picture of the curves.
const CHART: [u32; 2] = [1000, 600];

/// Which network.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Method {
    /// The whole body from one code.
    S1,
    /// First where, then how.
    S2,
    /// The modified network of Li et al. 2019.
    Baseline,
}

/// How large the network is.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Size {
    /// Minutes on two cores.
    Compact,
    /// As published: hours on two cores; use `--features gpu`.
    Paper,
}

/// How classes reach the network.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum SemanticsInput {
    /// A learnt vector for each class.
    Embedding,
    /// The paper's: the label over the picture's largest label, one channel, no mask.
    Scalar,
}

/// Whose weights the loss has.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Loss {
    /// PSI §3.4.
    Paper,
    /// The published scripts'.
    Code,
}

/// Arguments of `train psi`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Which network.
    #[arg(long, value_enum)]
    method: Method,
    /// Folder of a corpus of `inhabit stage`.
    #[arg(long, value_name = "DIR")]
    corpus: PathBuf,
    /// File for the weights (safetensors); curves (CSV, PNG) and checkpoints are written beside it.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Contact and collision with the room join the loss in the last quarter (L_HS).
    #[arg(long)]
    scene_loss: bool,
    /// L_HS also on bodies of codes drawn from N(0, I), which is how bodies are sampled later (ours; the paper's sees
    /// reconstructions only): weights of their contact and collision, and c of the contact in metres.
    #[arg(long, requires = "scene_loss", value_name = "CONTACT,COLLISION,C", value_parser = drawn_weights,
        num_args = 0..=1, default_missing_value = "1,1,0.1")]
    drawn: Option<DrawnWeights>,
    /// How large the network is.
    #[arg(long, value_enum, default_value_t = Size::Compact)]
    size: Size,
    /// How classes reach the network.
    #[arg(long, value_enum, default_value_t = SemanticsInput::Embedding)]
    semantics: SemanticsInput,
    /// Whose weights the loss has.
    #[arg(long, value_enum, default_value_t = Loss::Paper)]
    loss: Loss,
    /// Weight of the KL divergence instead of that of --loss.
    #[arg(long, value_name = "W")]
    kl: Option<f32>,
    /// Times that everybody is seen, each time in one picture.
    #[arg(long, default_value_t = 30, value_name = "N")]
    epochs: usize,
    /// People of one step.
    #[arg(long, default_value_t = 32, value_name = "N")]
    batch: usize,
    /// Adam's step size; 3e-4 for the paper's size, 1e-3 falling along a cosine for the compact one.
    #[arg(long, value_name = "RATE")]
    rate: Option<f32>,
    /// Go on from this checkpoint; with --scene-loss, from one of the same run without it before its last
    /// quarter (OUT.late.safetensors).
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Write OUT.checkpoint.safetensors every so many epochs.
    #[arg(long, default_value_t = 5, value_name = "N")]
    checkpoint_every: usize,
    #[command(flatten)]
    common: Common,
}

/// Three numbers, as in `1,1,0.1`.
fn drawn_weights(text: &str) -> Result<DrawnWeights, String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[contact, collision, robust_c_m]) if contact >= 0.0 && collision >= 0.0 && robust_c_m > 0.0 => {
            Ok(DrawnWeights { contact, collision, robust_c_m })
        }
        _ => Err("give three numbers: contact, collision and c in metres, as in 1,1,0.1".to_owned()),
    }
}

/// Runs the command.
///
/// # Errors
/// When the corpus or the checkpoint can't be used, or a file can't be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let training = arguments.training();
    let resume = arguments.resume.as_deref().map(super::read_checkpoint).transpose()?;
    let (corpus, files) = (arguments.corpus.clone(), Files::new(arguments));
    let seed = Seed::root(arguments.common.seed);
    let work = move |cx: &JobCtx| train_network(&training, &corpus, resume.as_ref(), &files, cx);
    let Some(state) = run_job("train psi", seed, arguments.common.quiet, work)? else {
        eprintln!("interrupted; go on with --resume {}", Files::new(arguments).checkpoint.display());
        return Ok(Ended::Interrupted);
    };
    write(&arguments.out, &state.weights()?)?;
    write_curves(&arguments.out, &state.training, &state.history)?;
    if arguments.common.json {
        println!("{}", serde_json::to_string_pretty(&state.history)?);
    } else if let (Some(row), false) = (state.history.rows.last(), arguments.common.quiet) {
        println!(
            "{} numbers, {} epochs: reconstruction {:.3}, on other rooms {:.3}; divergence {:.3}, {:.3}. Written to {}",
            state.params().trained_count(),
            state.epoch,
            row.reconstruction,
            row.validation_reconstruction,
            row.divergence,
            row.validation_divergence,
            arguments.out.display()
        );
    }
    Ok(Ended::Clean)
}

impl Arguments {
    fn training(&self) -> PsiTraining {
        let method = match self.method {
            Method::S1 => PsiMethod::S1,
            Method::S2 => PsiMethod::S2,
            Method::Baseline => PsiMethod::Baseline,
        };
        let base = match self.size {
            Size::Compact => PsiTraining::compact(method),
            Size::Paper => PsiTraining::paper(method),
        };
        let network = match self.semantics {
            SemanticsInput::Embedding => base.network.clone(),
            SemanticsInput::Scalar => {
                let published = PsiConfig::published(method);
                PsiConfig {
                    semantics: published.semantics,
                    valid_mask: false,
                    camera_scale: false,
                    floor_plane: false,
                    ..base.network.clone()
                }
            }
        };
        let preset = match self.loss {
            Loss::Paper => LossPreset::Paper,
            Loss::Code => LossPreset::Code,
        };
        let mut training = PsiTraining {
            network,
            seed: self.common.seed,
            epochs: self.epochs,
            batch: self.batch.max(2),
            learning_rate: self.rate.unwrap_or(base.learning_rate),
            weights: preset.into(),
            scene_loss: self.scene_loss,
            drawn: self.drawn,
            ..base
        };
        training.weights.kl = self.kl.unwrap_or(training.weights.kl);
        training
    }
}

/// What is written on the way.
struct Files {
    out: PathBuf,
    checkpoint: PathBuf,
    late: PathBuf,
    every: usize,
}

impl Files {
    fn new(arguments: &Arguments) -> Self {
        Self {
            out: arguments.out.clone(),
            checkpoint: arguments.out.with_extension("checkpoint.safetensors"),
            late: arguments.out.with_extension("late.safetensors"),
            every: arguments.checkpoint_every.max(1),
        }
    }

    fn after_epoch(&self, state: &TrainingState) -> Result<(), Stop> {
        let failed = |error: anyhow::Error| Stop::Failed(format!("{error:#}"));
        if state.epoch.is_multiple_of(self.every) || state.epoch == state.training.epochs {
            write(&self.checkpoint, &state.checkpoint()?).map_err(failed)?;
        }
        if state.epoch == state.training.late_epoch() && !state.training.scene_loss {
            write(&self.late, &state.checkpoint()?).map_err(failed)?;
        }
        write_curves(&self.out, &state.training, &state.history).map_err(failed)
    }
}

fn train_network(
    training: &PsiTraining,
    folder: &Path,
    resume: Option<&Weights>,
    files: &Files,
    cx: &JobCtx,
) -> Result<TrainingState, Stop> {
    let corpus = read_corpus(folder, cx.ticker())?;
    let mut data = PsiData::from_corpus(corpus, cx.ticker())?;
    data.drop_unseen();
    let fields = if training.scene_loss { read_fields(folder, cx.ticker())? } else { Vec::new() };
    let mut state = match resume {
        None => TrainingState::new(training.clone(), data.id.clone()),
        Some(weights) => TrainingState::resume(training.clone(), data.id.clone(), weights)?,
    };
    let input = TrainingInput { data: &data, fields: &fields };
    train(&mut state, &input, cx, &mut |state| files.after_epoch(state))?;
    Ok(state)
}

/// The distance field of each room in the manifest's order; rooms not learnt from get an empty one.
fn read_fields(folder: &Path, ticker: &Ticker) -> Result<Vec<SignedDistanceField>, Stop> {
    let manifest = read_manifest(folder).map_err(|error| Stop::Failed(format!("{error:#}")))?;
    ticker.stage("distance fields", manifest.rooms.len())?;
    let field = |entry: &RoomEntry| {
        let field = match entry.split {
            Split::Train => read_field(folder, entry, ticker)?,
            _ => SignedDistanceField {
                dim: [2; 3],
                origin: Vec3::ZERO,
                cell_m: Vec3::ONE,
                values: vec![1.0; 8],
            },
        };
        ticker.advance()?;
        Ok(field)
    };
    manifest.rooms.par_iter().map(field).collect()
}

fn read_field(folder: &Path, entry: &RoomEntry, ticker: &Ticker) -> Result<SignedDistanceField, Stop> {
    let room = read_room_model(folder, entry).map_err(|error| Stop::Failed(format!("{error:#}")))?;
    let triangles: Vec<[Vec3; 3]> = room.world_triangles().map(|(_, triangle)| triangle).collect();
    let step = |_: usize, _: usize| match ticker.check() {
        Ok(()) => ControlFlow::Continue(()),
        Err(_) => ControlFlow::Break(()),
    };
    bake_cached(&triangles, &corpus_geometry().field, &step).map_err(|_| Stop::Cancelled)
}

fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    fs::write(path, bytes).with_context(|| format!("can't write {}: is the disk full?", path.display()))
}

/// The curves beside the weights: `OUT.csv` and `OUT.png`.
fn write_curves(out: &Path, training: &PsiTraining, history: &History) -> anyhow::Result<()> {
    write(&out.with_extension("csv"), history.to_csv().as_bytes())?;
    if history.rows.len() < 2 {
        return Ok(());
    }
    let names = history.rows[0].curves().map(|(name, _)| name);
    let points =
        |c: usize| history.rows.iter().map(|r| [r.epoch as f64, f64::from(r.curves()[c].1)]).collect();
    let curve = |(c, name): (usize, &str)| Curve { name: name.replace('_', " "), points: points(c) };
    let counts = |curve: &Curve| curve.points.iter().any(|[_, y]| *y > 0.0);
    let late = training.late_epoch() as f64;
    let label = if training.scene_loss { "KL full, scene loss on" } else { "KL full" };
    let chart = LineChart {
        title: format!("train psi --method {}", training.network.method.label()),
        x_label: "epoch".to_owned(),
        y_label: "mean per body (terms as in PSI eq. 1, logarithmic)".to_owned(),
        curves: names.into_iter().enumerate().map(curve).filter(counts).collect(),
        marks: vec![VerticalMark { x: late, label: label.to_owned() }],
        y_scale: Scale::Log,
        y_range: None,
    };
    let picture = line_chart(&chart, CHART)?;
    let png = encode_png(picture.width, picture.height, &picture.rgba)?;
    write(&out.with_extension("png"), &png)
}
