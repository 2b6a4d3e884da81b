//! `inhabit train gait`.

use std::fs;
use std::path::PathBuf;

use anyhow::Context as _;
use clap::Args;

use super::super::clips::read_clips;
use super::super::progress::run_job;
use super::super::{Common, Ended, use_threads};
use crate::body::Body;
use crate::job::{JobCtx, Seed};
use crate::learn::gait::measure_gait;

/// Arguments of `train gait`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Folder with captured walks that travel: BVH files of the CMU database, DeepMimic's texts, npz archives.
    #[arg(long, value_name = "DIR")]
    corpus: PathBuf,
    /// Only clips whose name (folder/file) begins so, such as `cmu/07`; several with commas.
    #[arg(long, value_name = "PREFIX", value_delimiter = ',')]
    only: Vec<String>,
    /// File for what was measured.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let mut clips = read_clips(&arguments.corpus)?;
    let only = &arguments.only;
    clips.retain(|clip| only.is_empty() || only.iter().any(|prefix| clip.name.starts_with(prefix)));
    let work = move |cx: &JobCtx| measure_gait(&clips, &Body::bundled().model.joint_template, cx);
    let seed = Seed::root(arguments.common.seed);
    let Some(model) = run_job("train gait", seed, arguments.common.quiet, work)? else {
        return Ok(Ended::Interrupted);
    };
    fs::write(&arguments.out, model.to_ron()?)
        .with_context(|| format!("can't write {}", arguments.out.display()))?;
    if !arguments.common.quiet {
        println!("walking of {} strides: {}", model.strides, arguments.out.display());
    }
    Ok(Ended::Clean)
}
