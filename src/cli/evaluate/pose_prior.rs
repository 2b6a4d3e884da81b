//! `inhabit evaluate pose-prior`: reconstruction of held-out poses, samples of the prior, interpolations.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use glam::Vec3;
use rand_distr::{Distribution as _, StandardNormal};
use rayon::prelude::*;

use super::super::clips::read_clips;
use super::super::figures::figure_sheet;
use super::super::network::read_weights;
use super::super::output::OutputFolder;
use super::super::train::curve::curve_png;
use super::super::{Common, Ended, use_threads};
use crate::assets::{PoseClip, encode_png};
use crate::body::{Body, BodyPose, PoseDecoder, PoseSpace, worst_excess};
use crate::job::{Seed, Ticker};
use crate::learn::{PoseCorpus, PoseCorpusConfig, PoseGroup, PosePriorPoint};
use crate::scene::{BodyParams, POSE};

/// Poses of each group that are looked at.
const POSES_A_GROUP: usize = 400;
/// Samples of the prior that are measured.
const SAMPLES: usize = 2000;
/// Samples of the prior that are drawn.
const DRAWN: usize = 40;

/// Arguments of `evaluate pose-prior`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Folder with the motion clips that the prior was trained on; what training held out is evaluated.
    #[arg(long, value_name = "DIR")]
    corpus: PathBuf,
    /// Weights; those of the program when left out.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Folder for the report and the pictures.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Draw frames of every clip too, as they look on the body.
    #[arg(long)]
    clips: bool,
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let folder = OutputFolder::claim(&arguments.out, false)?;
    let clips = read_clips(&arguments.corpus)?;
    if arguments.clips {
        draw_clips(&folder, &clips)?;
    }
    let body = Body::bundled();
    let weights = match &arguments.weights {
        Some(file) => read_weights(file)?,
        None => PoseDecoder::bundled_weights()?,
    };
    if let Some(curve) = weights.notes.get("curve") {
        folder.write("curves.png", &curve_png(&serde_json::from_str::<Vec<PosePriorPoint>>(curve)?)?)?;
    }
    let prior = &PoseDecoder::new(&weights, &body.model)?;
    let seed = Seed::root(arguments.common.seed);
    let config = PoseCorpusConfig { samples_a_family: 2000, ..PoseCorpusConfig::default() };
    let Ok(corpus) = PoseCorpus::new(&clips, &body.model, config, seed.child("corpus", 0), &Ticker::silent())
    else {
        return Ok(Ended::Interrupted);
    };
    let report = report(body, prior, &corpus, seed);
    folder.write("pose_prior.md", report.as_bytes())?;
    print!("{report}");
    let samples = draws(prior, seed, DRAWN);
    save(&folder, "samples", &samples, 5)?;
    save(&folder, "interpolations", &interpolations(prior, &corpus, seed), 7)?;
    Ok(Ended::Clean)
}

/// Errors in millimetres and codes' lengths of one group.
struct Row {
    joints_mm: f32,
    vertices_mm: f32,
    degrees: f32,
    squared_code: f32,
}

fn report(body: &Body, prior: &dyn PoseSpace, corpus: &PoseCorpus, seed: Seed) -> String {
    let mut text = String::from(
        "| held out | poses | joints, mm | vertices, mm | angle a joint, degrees | mean of code squared |\n|---|---|---|---|---|---|\n",
    );
    for groups in [&corpus.held_out_clips, &corpus.held_out_families] {
        for group in groups {
            let row = measure(body, prior, group);
            let _ = writeln!(
                text,
                "| {} | {} | {:.1} | {:.1} | {:.1} | {:.1} |",
                group.label,
                group.poses.len(),
                row.joints_mm,
                row.vertices_mm,
                row.degrees,
                row.squared_code
            );
        }
    }
    let samples = draws(prior, seed, SAMPLES);
    let excess: Vec<f32> = samples.iter().map(|pose| worst_excess(pose).0.to_degrees()).collect();
    let beyond = excess.iter().filter(|e| **e > 10.0).count();
    let mean = excess.iter().sum::<f32>() / excess.len() as f32;
    let _ = writeln!(
        text,
        "\nOf {SAMPLES} samples of the prior {:.1} % leave a joint limit by more than 10 degrees; the worst joint's \
         mean excess is {mean:.1} degrees.",
        100.0 * beyond as f32 / SAMPLES as f32
    );
    text
}

fn measure(body: &Body, prior: &dyn PoseSpace, group: &PoseGroup) -> Row {
    let stride = group.poses.len().div_ceil(POSES_A_GROUP).max(1);
    let poses: Vec<&BodyPose> = group.poses.iter().step_by(stride).collect();
    let rows: Vec<[f32; 4]> = poses
        .par_iter()
        .map(|pose| {
            let code = prior.encode(pose);
            let back = prior.decode(&code);
            let params = BodyParams::default();
            let (a, b) = (body.pose_axis_angles(&params, pose), body.pose_axis_angles(&params, &back));
            let degrees =
                pose.iter().zip(&back).map(|(a, b)| angle_between(*a, *b).to_degrees()).sum::<f32>();
            [
                mean_distance_mm(&a.joints[..22], &b.joints[..22]),
                mean_distance_mm(&a.vertices, &b.vertices),
                degrees / pose.len() as f32,
                code.iter().map(|z| z * z).sum(),
            ]
        })
        .collect();
    let mean = |i: usize| rows.iter().map(|row| row[i]).sum::<f32>() / rows.len().max(1) as f32;
    Row { joints_mm: mean(0), vertices_mm: mean(1), degrees: mean(2), squared_code: mean(3) }
}

fn angle_between(a: Vec3, b: Vec3) -> f32 {
    let turn = |v: Vec3| crate::math::rotation::matrix_from_axis_angle(v);
    crate::math::rotation::axis_angle_from_matrix(turn(a).transpose() * turn(b)).length()
}

fn mean_distance_mm(a: &[Vec3], b: &[Vec3]) -> f32 {
    1000.0 * a.iter().zip(b).map(|(a, b)| a.distance(*b)).sum::<f32>() / a.len().max(1) as f32
}

fn draws(prior: &dyn PoseSpace, seed: Seed, count: usize) -> Vec<BodyPose> {
    let mut rng = seed.child("samples", 0).rng();
    let mut code = || -> [f32; POSE] { std::array::from_fn(|_| StandardNormal.sample(&mut rng)) };
    (0..count).map(|_| prior.decode(&code())).collect()
}

/// Four straight lines of codes between held-out poses of different groups, seven poses each.
fn interpolations(prior: &dyn PoseSpace, corpus: &PoseCorpus, seed: Seed) -> Vec<BodyPose> {
    let groups: Vec<&PoseGroup> = corpus.held_out_families.iter().chain(&corpus.held_out_clips).collect();
    let pick = |i: usize| {
        let group = groups[(i * 3) % groups.len()];
        let at = seed.child("interpolations", i as u64).value() as usize % group.poses.len();
        prior.encode(&group.poses[at])
    };
    let line = |i: usize| {
        let (from, to) = (pick(i), pick(i + 1));
        (0..7).map(move |step| {
            let share = step as f32 / 6.0;
            std::array::from_fn(|k| from[k] + share * (to[k] - from[k]))
        })
    };
    (0..4).flat_map(line).map(|code| prior.decode(&code)).collect()
}

fn save(folder: &OutputFolder, name: &str, poses: &[BodyPose], columns: usize) -> anyhow::Result<()> {
    let body = Body::bundled();
    let figure = |pose: &BodyPose| body.pose_axis_angles(&BodyParams::default(), pose).vertices;
    let figures: Vec<Vec<Vec3>> = poses.par_iter().map(figure).collect();
    let picture = figure_sheet(&figures, columns, 85.0)?;
    folder.write(&format!("{name}.png"), &encode_png(picture.width, picture.height, &picture.rgba)?)?;
    Ok(())
}

/// Every clip's frames at six times, with the root's turn, to see whether it was carried over rightly.
fn draw_clips(folder: &OutputFolder, clips: &[PoseClip]) -> anyhow::Result<()> {
    let body = Body::bundled();
    for (sheet, some) in clips.chunks(8).enumerate() {
        let figures =
            some.iter().flat_map(|clip| (1..=4).map(move |i| &clip.frames[clip.frames.len() * i / 5]));
        let figures: Vec<Vec<Vec3>> = figures
            .map(|frame| {
                let mut params = BodyParams::default();
                params.set_rotation(&crate::math::rotation::matrix_from_axis_angle(frame[0]));
                let pose: BodyPose = std::array::from_fn(|j| frame[j + 1]);
                body.pose_axis_angles(&params, &pose).vertices
            })
            .collect();
        let picture = figure_sheet(&figures, 4, 85.0)?;
        let png = encode_png(picture.width, picture.height, &picture.rgba)?;
        folder.write(&format!("clips_{sheet:02}.png"), &png)?;
        println!("clips_{sheet:02}: {}", some.iter().map(|clip| &*clip.name).collect::<Vec<_>>().join(", "));
    }
    Ok(())
}
