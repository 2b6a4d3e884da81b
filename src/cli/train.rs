//! `inhabit train`: statistics and, later, networks learned from data.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::{Args, ValueEnum};

use super::progress::run_job;
use super::{Common, Ended, use_threads};
use crate::assets::npz::Npz;
use crate::assets::{PoseClip, read_pose_clips};
use crate::job::{JobCtx, Seed};
use crate::learn::fit_pose_statistics;

/// What can be learned.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The pose and hand spaces: Gaussians over clips and pose families.
    PosePrior,
}

/// Arguments of `train`.
#[derive(Args, Debug)]
pub struct TrainArguments {
    /// What is learned.
    #[arg(value_enum)]
    pub subject: Subject,
    /// Folder with motion clips: npz archives with `NAME/pose` arrays of frames x 55 x 3 axis-angles.
    #[arg(long, value_name = "DIR")]
    pub corpus: PathBuf,
    /// File for what was learned.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// Runs the command.
///
/// # Errors
/// When the corpus holds no clip or a file can't be read or written.
pub fn run(arguments: &TrainArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let clips = read_corpus(&arguments.corpus)?;
    let (count, frames) = (clips.len(), clips.iter().map(|c| c.frames.len()).sum::<usize>());
    let work = move |cx: &JobCtx| Ok(fit_pose_statistics(&clips, cx.seed));
    let seed = Seed::root(arguments.common.seed);
    let Some(statistics) = run_job("train pose-prior", seed, arguments.common.quiet, work)? else {
        return Ok(Ended::Interrupted);
    };
    fs::write(&arguments.out, statistics.to_ron()?)
        .with_context(|| format!("can't write {}", arguments.out.display()))?;
    if !arguments.common.quiet {
        println!("{count} clips with {frames} frames and ten pose families: {}", arguments.out.display());
    }
    Ok(Ended::Clean)
}

/// Every clip of every npz in the folder, in the order of the file names.
fn read_corpus(folder: &Path) -> anyhow::Result<Vec<PoseClip>> {
    let listing = fs::read_dir(folder).with_context(|| {
        format!("can't read the corpus {}: name a folder with --corpus", folder.display())
    })?;
    let mut files: Vec<PathBuf> = listing.filter_map(|e| e.ok().map(|e| e.path())).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "npz"));
    files.sort();
    let mut clips = Vec::new();
    for file in &files {
        let bytes = fs::read(file).with_context(|| format!("can't read {}", file.display()))?;
        clips.extend(read_pose_clips(&Npz::from_bytes(&file.display().to_string(), &bytes)?)?);
    }
    anyhow::ensure!(
        !clips.is_empty(),
        "{} holds no clip: put npz archives with `NAME/pose` arrays there",
        folder.display()
    );
    Ok(clips)
}
