//! `inhabit train pose-prior`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;

use super::super::clips::read_clips;
use super::super::progress::run_job;
use super::super::{Common, Ended, use_threads};
use super::curve::{csv, curve_png};
use crate::assets::{PoseClip, Precision, Weights};
use crate::body::Body;
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::{
    PoseCorpus, PoseCorpusConfig, PosePriorConfig, SHIPPED_PRECISION, TrainedPosePrior, train_pose_prior,
};

/// Arguments of `train pose-prior`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Folder with motion clips: npz archives with `NAME/pose` arrays, BVH files and DeepMimic's text, also in
    /// folders below.
    #[arg(long, value_name = "DIR")]
    corpus: PathBuf,
    /// File for the weights (safetensors); the curves are written beside it as CSV and PNG.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Steps in all.
    #[arg(long, value_name = "N")]
    steps: Option<usize>,
    /// Weight of the reconstruction: nats per square metre of mean squared displacement.
    #[arg(long, value_name = "W")]
    position_weight: Option<f32>,
    /// Go on from the checkpoint beside --out.
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let clips = read_clips(&arguments.corpus)?;
    let (count, frames) = (clips.len(), clips.iter().map(|c| c.frames.len()).sum::<usize>());
    let checkpoint = arguments.out.with_extension("checkpoint.safetensors");
    let resume = arguments.resume.then(|| super::read_checkpoint(&checkpoint)).transpose()?;
    let mut config = PosePriorConfig::default();
    config.steps = arguments.steps.unwrap_or(config.steps);
    config.loss.position = arguments.position_weight.unwrap_or(config.loss.position);
    let file = checkpoint.clone();
    let work = move |cx: &JobCtx| train(&clips, &config, resume.as_ref(), &file, cx);
    let seed = Seed::root(arguments.common.seed);
    let Some(trained) = run_job("train pose-prior", seed, arguments.common.quiet, work)? else {
        eprintln!("interrupted; go on with --resume from {}", checkpoint.display());
        return Ok(Ended::Interrupted);
    };
    let bytes = trained.weights.to_bytes(SHIPPED_PRECISION)?;
    fs::write(&arguments.out, bytes).with_context(|| format!("can't write {}", arguments.out.display()))?;
    fs::write(arguments.out.with_extension("csv"), csv(&trained.curve))?;
    fs::write(arguments.out.with_extension("png"), curve_png(&trained.curve)?)?;
    if !arguments.common.quiet {
        println!("{count} clips with {frames} frames and ten pose families: {}", arguments.out.display());
        print!("{}", csv(&trained.curve[trained.curve.len().saturating_sub(1)..]));
    }
    Ok(Ended::Clean)
}

fn train(
    clips: &[PoseClip],
    config: &PosePriorConfig,
    resume: Option<&Weights>,
    checkpoint: &Path,
    cx: &JobCtx,
) -> Result<TrainedPosePrior, Stop> {
    let model = &Body::bundled().model;
    let corpus =
        PoseCorpus::new(clips, model, PoseCorpusConfig::default(), cx.seed.child("corpus", 0), cx.ticker())?;
    let mut save = |weights: &Weights| Ok(fs::write(checkpoint, weights.to_bytes(Precision::Full)?)?);
    train_pose_prior(&corpus, model, config, resume, &mut save, cx)
}
