//! `inhabit train hand-space`.

use std::fs;
use std::path::PathBuf;

use anyhow::Context as _;
use clap::Args;

use super::super::clips::read_clips;
use super::super::progress::run_job;
use super::super::{Common, Ended, use_threads};
use crate::job::{JobCtx, Seed};
use crate::learn::fit_hand_space;

/// Arguments of `train hand-space`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Folder with motion clips that have fingers: npz archives with `NAME/pose` arrays of frames x 55 x 3
    /// axis-angles.
    #[arg(long, value_name = "DIR")]
    corpus: PathBuf,
    /// File for what was learned.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let mut clips = read_clips(&arguments.corpus)?;
    clips.retain(|clip| clip.frames.iter().any(|frame| frame[25..].iter().any(|v| v.length() > 0.0)));
    let count = clips.len();
    anyhow::ensure!(count > 0, "{} holds no clip with fingers", arguments.corpus.display());
    let work = move |cx: &JobCtx| Ok(fit_hand_space(&clips, cx.seed));
    let seed = Seed::root(arguments.common.seed);
    let Some(hands) = run_job("train hand-space", seed, arguments.common.quiet, work)? else {
        return Ok(Ended::Interrupted);
    };
    fs::write(&arguments.out, hands.to_ron()?)
        .with_context(|| format!("can't write {}", arguments.out.display()))?;
    if !arguments.common.quiet {
        println!("hands of {count} clips and ten pose families: {}", arguments.out.display());
    }
    Ok(Ended::Clean)
}
