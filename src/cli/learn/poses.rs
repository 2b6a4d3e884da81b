//! `inhabit learn poses`: the dictionary of poses, and how well it does on people it has not seen.

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use anyhow::Context as _;
use clap::Args;

use super::super::clips::read_clips;
use super::super::progress::run_job;
use super::super::{Common, Ended, use_threads};
use crate::assets::PoseClip;
use crate::body::Body;
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::actions::pose::{
    DictionaryConfig, JointPlacer, Joints3, PoseDictionary, clip_poses, family_poses, learn_dictionary,
};
use crate::learn::actions::simulate::{PoseAccuracy, pose_accuracy, unseen_families};

/// Frames a second that are taken of clips.
const FRAMES_A_SECOND: f32 = 5.0;
/// Draws of each pose family beside the clips, which hardly show sitting and lying.
const DRAWS_A_FAMILY: usize = 300;
/// Poses of each held-out group that are measured.
const MEASURED: usize = 150;

/// Arguments of `learn poses`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Folder with motion clips.
    #[arg(long, value_name = "DIR")]
    corpus: PathBuf,
    /// File for the dictionary; how well it does is written beside it as Markdown.
    #[arg(long, value_name = "FILE.ron")]
    out: PathBuf,
    /// Bases.
    #[arg(long, value_name = "K", default_value_t = DictionaryConfig::default().bases)]
    bases: usize,
    /// Clips whose names begin so are kept out of learning and measured: whole subjects.
    #[arg(long, value_name = "NAME", value_delimiter = ',', default_value = "cmu/02,cmu/08,cmu/14")]
    held_out: Vec<String>,
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let clips = read_clips(&arguments.corpus)?;
    let config = DictionaryConfig { bases: arguments.bases, ..DictionaryConfig::default() };
    let held_out = arguments.held_out.clone();
    let work = move |cx: &JobCtx| learn(&clips, &held_out, &config, cx);
    let seed = Seed::root(arguments.common.seed);
    let Some((mut dictionary, report)) = run_job("learn poses", seed, arguments.common.quiet, work)? else {
        return Ok(Ended::Interrupted);
    };
    dictionary.note = format!(
        "Statistics of motion clips (CMU motion capture database, mocap.cs.cmu.edu, NSF EIA-0196217; DeepMimic, MIT; \
         Quaternius and KayKit, CC0) and of the program's pose families. Made by `inhabit learn poses --corpus DIR --bases {} \
         --seed {}`.",
        arguments.bases, arguments.common.seed
    );
    for (file, text) in
        [(arguments.out.clone(), dictionary.to_ron()?), (arguments.out.with_extension("md"), report.clone())]
    {
        fs::write(&file, text).with_context(|| format!("can't write {}", file.display()))?;
    }
    if !arguments.common.quiet {
        print!("{report}");
    }
    Ok(Ended::Clean)
}

fn learn(
    clips: &[PoseClip],
    held_out: &[String],
    config: &DictionaryConfig,
    cx: &JobCtx,
) -> Result<(PoseDictionary, String), Stop> {
    let body = Body::bundled();
    let mut placer = JointPlacer::new(body);
    let is_held_out = |name: &str| held_out.iter().any(|h| name.starts_with(h.as_str()));
    let mut poses = clip_poses(clips, FRAMES_A_SECOND, |name| !is_held_out(name));
    let of_clips = poses.len();
    poses.extend(family_poses(body, DRAWS_A_FAMILY, cx.seed.child("families", 0), cx)?);
    let joints: Vec<Joints3> = poses.iter().map(|p| placer.joints(p)).collect();
    let (dictionary, fit) = learn_dictionary(&joints, config, cx.seed, cx)?;
    let mut text = format!(
        "{} bases from {of_clips} poses of clips and {} draws of pose families, and their mirror images: a pose takes \
         {:.1} bases and is off by {:.1} % of its size.\n\n\
         | seen through random cameras | poses | relaxation, mm | refined, mm | facing off, median | 9 of 10 |\n\
         |---|---|---|---|---|---|\n",
        dictionary.bases.len(),
        poses.len() - of_clips,
        fit.active,
        100.0 * fit.relative_error
    );
    cx.stage("measuring people it has not seen", held_out.len() + 3)?;
    let mut groups: Vec<(String, Vec<Joints3>)> = Vec::new();
    for name in held_out {
        let poses = clip_poses(clips, FRAMES_A_SECOND, |clip| clip.starts_with(name.as_str()));
        let step = poses.len().div_ceil(MEASURED).max(1);
        groups.push((name.clone(), poses.iter().step_by(step).map(|p| placer.joints(p)).collect()));
    }
    groups.push(("draws of the pose families".into(), unseen_families(MEASURED / 10, cx.seed, cx)?));
    for (name, joints) in groups.iter().filter(|(_, joints)| !joints.is_empty()) {
        write_row(&mut text, &pose_accuracy(name, joints, &dictionary, 0.0, false, cx.seed));
        cx.advance()?;
    }
    let all: Vec<Joints3> = groups.into_iter().flat_map(|(_, joints)| joints).collect();
    let noisy = "all, joints off by 3 cm";
    write_row(&mut text, &pose_accuracy(noisy, &all, &dictionary, 0.03, false, cx.seed));
    let legless = "all, joints off by 3 cm, legs hidden (the others' error)";
    write_row(&mut text, &pose_accuracy(legless, &all, &dictionary, 0.03, true, cx.seed));
    Ok((dictionary, text))
}

fn write_row(text: &mut String, row: &PoseAccuracy) {
    let _ = writeln!(
        text,
        "| {} | {} | {:.1} | {:.1} | {:.0}° | {:.0}° |",
        row.what, row.poses, row.convex_mm, row.refined_mm, row.facing_median_deg, row.facing_90_percent_deg
    );
}
