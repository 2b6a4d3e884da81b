//! What a user relies on: gradients are exact, feet stop sliding, bodies come out of walls, ends stay, nothing depends
//! on the number of threads, and long motions have no seams.

use glam::{Quat, Vec3};

use super::descent::{MotionEnergy, Subject};
use super::fitter::Run;
use super::variables::{self, NUMBERS};
use super::*;
use crate::body::joints::{LEFT_HIP, LEFT_KNEE, RIGHT_HIP, RIGHT_KNEE};
use crate::body::{Body, FrameJoints};
use crate::fit::Surroundings;
use crate::inspect::{MotionReport, inspect_motion};
use crate::job::{Cancelled, Ticker};
use crate::scene::{BETAS, CLIP_FPS, Clip, Frame, SignedDistanceField};

const BETAS_0: [f32; BETAS] = [0.0; BETAS];

/// A floor at 0 and, from z = `wall_z` on, a wall without end.
fn field(wall_z: f32) -> SignedDistanceField {
    let dim = [61, 61, 131];
    let (origin, cell_m) = (Vec3::new(-1.5, -0.5, -2.0), Vec3::splat(0.05));
    let mut field = SignedDistanceField { dim, origin, cell_m, values: vec![0.0; dim.iter().product()] };
    for x in 0..dim[0] {
        for y in 0..dim[1] {
            for z in 0..dim[2] {
                let p = field.position(x, y, z);
                field.values[(x * dim[1] + y) * dim[2] + z] = p.y.min(wall_z - p.z);
            }
        }
    }
    field
}

fn open() -> SignedDistanceField {
    field(100.0)
}

/// Height of the pelvis joint of the mean body whose soles just stand on the floor, less its rest height.
fn standing_height() -> f32 {
    let frame = Frame::default();
    let posed = Body::bundled().pose_axis_angles(&frame.params(&BETAS_0), &frame.pose);
    -posed.vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min)
}

fn arms_down(frame: &mut Frame) {
    frame.pose[15].z = -1.2;
    frame.pose[16].z = 1.2;
}

/// A walk as a beginner would make it: legs swing like pendulums while the body glides, so planted feet slide. Steps of
/// 15 frames; `speed` in metres a second along z.
fn gliding_walk(frames: usize, speed: f32) -> (Vec<Frame>, Vec<[bool; 2]>) {
    let height = standing_height();
    let walk = (0..frames).map(|i| {
        let time = i as f32 / 30.0;
        let swing = (std::f32::consts::TAU * time).sin();
        let mut frame =
            Frame { translation: Vec3::new(0.0, height - 0.03, speed * time - 1.0), ..Frame::default() };
        arms_down(&mut frame);
        frame.pose[LEFT_HIP - 1].x = -0.3 * swing - 0.15;
        frame.pose[RIGHT_HIP - 1].x = 0.3 * swing - 0.15;
        frame.pose[LEFT_KNEE - 1].x = 0.3 + 0.2 * swing;
        frame.pose[RIGHT_KNEE - 1].x = 0.3 - 0.2 * swing;
        frame
    });
    // A leg that goes back relative to the body is the one on the floor.
    let planted = (0..frames).map(|i| {
        let going = (std::f32::consts::TAU * i as f32 / 30.0).cos();
        [going < 0.0, going >= 0.0]
    });
    (walk.collect(), planted.collect())
}

fn task<'a>(planted: &'a [[bool; 2]], pinned: [usize; 2]) -> SequenceTask<'a> {
    SequenceTask { betas: &BETAS_0, planted, rests: &[], pinned }
}

fn measure(field: &SignedDistanceField, frames: &[Frame], planted: &[[bool; 2]]) -> MotionReport {
    let clip = Clip { frames: frames.to_vec(), planted: planted.to_vec(), fps: CLIP_FPS, ..Clip::default() };
    inspect_motion(field, Body::bundled(), &clip, &|_, _| std::ops::ControlFlow::Continue(()))
        .expect("not stopped")
}

fn optimise(
    field: &SignedDistanceField,
    task: &SequenceTask<'_>,
    frames: &[Frame],
    config: &SequenceConfig,
) -> (Vec<Frame>, Sequenced) {
    let mut frames = frames.to_vec();
    let fitter = SequenceFitter::new(Body::bundled());
    let around = Surroundings::of_field(field);
    let done = fitter
        .optimise(&around, task, &mut frames, config, &Ticker::silent(), &mut |_| ())
        .expect("not cancelled");
    (frames, done)
}

fn agrees_with_differences(
    energy: &dyn MotionEnergy,
    subject: &Subject<'_>,
    input: &[Frame],
    tolerance: f32,
) {
    let mut x: Vec<f32> = input.iter().flat_map(|f| variables::numbers_of(f, f.rotation)).collect();
    // Away from the input, where the terms that hold to it have no slope.
    for (i, value) in x.iter_mut().enumerate() {
        *value += 0.02 * (i as f32 * 1.7).sin();
    }
    let (_, gradient) = subject.evaluate(&x, input, energy);
    let norm = (gradient.iter().map(|g| g * g).sum::<f32>() / input.len() as f32).sqrt();
    for i in (0..x.len()).filter(|i| i / NUMBERS != 1 || i % NUMBERS < 40).step_by(7) {
        let step = 1e-3;
        let side = |by: f32| {
            let mut moved = x.clone();
            moved[i] += by;
            subject.evaluate(&moved, input, energy).0
        };
        let numeric = ((side(step) - side(-step)) / f64::from(2.0 * step)) as f32;
        let error = (numeric - gradient[i]).abs();
        let (frame, k) = (i / NUMBERS, i % NUMBERS);
        assert!(
            error < tolerance * norm,
            "frame {frame} number {k}: {} against {numeric} of {norm}",
            gradient[i]
        );
    }
}

/// Checks the gradient of each stage of a preset on a few frames.
fn gradient_of_preset(preset: SequencePreset, height_m: f32, tolerance: f32) {
    let (mut frames, planted) = gliding_walk(6, 1.2);
    frames.iter_mut().for_each(|f| f.translation.y += height_m);
    let (field, config) = (field(1.1), SequenceConfig::from(preset));
    let (fitter, around) = (SequenceFitter::new(Body::bundled()), Surroundings::of_field(&field));
    let task = task(&planted, [0, 0]);
    let run = Run::new(&fitter, &around, &task, &frames, &config, &Ticker::silent()).expect("not cancelled");
    let stage = config.stages.last().expect("a stage");
    run.with_energy(stage, &mut |subject, energy| {
        agrees_with_differences(energy, subject, &frames, tolerance)
    });
}

#[test]
fn the_gradient_of_our_energy_agrees_with_finite_differences() {
    // The field's slope jumps from cell to cell, and some of the skin crosses a border within the step.
    gradient_of_preset(SequencePreset::Ours, -0.02, 0.03);
}

#[test]
fn the_gradient_of_the_papers_energy_agrees_with_finite_differences() {
    // Its mean over the penetrating vertices jumps when one leaves, so the body is wholly out.
    gradient_of_preset(SequencePreset::Paper, 0.3, 0.02);
}

#[test]
fn a_walk_whose_feet_slide_is_mended() {
    let (frames, planted) = gliding_walk(90, 0.8);
    let before = measure(&open(), &frames, &planted).metrics;
    assert!(before.skate_cm_per_s > 10.0, "{before:?}");
    let (mended, done) = optimise(&open(), &task(&planted, [0, 0]), &frames, &SequenceConfig::default());
    let after = measure(&open(), &mended, &planted).metrics;
    assert!(after.skate_cm_per_s < 2.0 && after.stance_drift_cm < 1.0, "{after:?}, short {}", done.short_m);
    assert!(after.hover_max_mm < 15.0 && after.penetration_max_mm < 25.0, "{after:?}");
    // It is still the same walk.
    let changed = crate::inspect::MotionErrors::of(Body::bundled(), &BETAS_0, &mended, &frames);
    assert!(changed.mpjpe_mm < 60.0, "{changed:?}");
}

#[test]
fn a_body_pushed_into_a_wall_comes_out() {
    // Somebody stands upright with a quarter of the body's depth in the wall for a second and a half.
    let mut still = Frame { translation: Vec3::new(0.0, standing_height(), 1.0), ..Frame::default() };
    arms_down(&mut still);
    let (frames, planted) = (vec![still; 45], vec![[true; 2]; 45]);
    let field = field(1.08);
    let before = measure(&field, &frames, &planted).metrics;
    assert!(before.penetration_max_mm > 60.0, "{before:?}");
    let (out, _) = optimise(&field, &task(&planted, [0, 0]), &frames, &SequenceConfig::default());
    let after = measure(&field, &out, &planted).metrics;
    assert!(after.penetration_max_mm < 15.0, "{after:?}");
    assert!(after.skate_cm_per_s < 2.0 && after.stance_drift_cm < 1.0, "{after:?}");
}

#[test]
fn the_papers_optimiser_lowers_its_energy_and_takes_a_body_out_of_the_floor() {
    let (mut frames, planted) = gliding_walk(20, 0.8);
    frames.iter_mut().for_each(|f| f.translation.y -= 0.08);
    let before = measure(&open(), &frames, &planted).metrics;
    let (after, done) = optimise(&open(), &task(&planted, [0, 0]), &frames, &SequencePreset::Paper.into());
    let after = measure(&open(), &after, &planted).metrics;
    assert!(after.non_collision_pct > before.non_collision_pct, "{before:?} to {after:?}");
    let sum = |at: usize| done.trace[at].iter().sum::<f32>();
    assert_eq!(done.trace.len(), 70);
    assert!(sum(19) < sum(0) && sum(69) < sum(20), "{} {} {} {}", sum(0), sum(19), sum(20), sum(69));
}

#[test]
fn pinned_ends_stay_byte_for_byte_and_are_joined_smoothly() {
    let (mut frames, planted) = gliding_walk(90, 0.8);
    frames.iter_mut().for_each(|f| f.translation.y += 0.04);
    let (after, _) = optimise(&open(), &task(&planted, [3, 2]), &frames, &SequenceConfig::default());
    assert_eq!(after[..3], frames[..3]);
    assert_eq!(after[88..], frames[88..]);
    assert_ne!(after[40], frames[40]);
    let rest = Body::bundled().model.rest_joints(&BETAS_0);
    let change = |i: usize| {
        let (a, b) = (FrameJoints::of(&rest, &after[i]), FrameJoints::of(&rest, &frames[i]));
        (0..22).map(|j| a.positions[j].distance(b.positions[j])).sum::<f32>() / 22.0
    };
    let steps: Vec<f32> = (1..90).map(|i| (change(i) - change(i - 1)).abs()).collect();
    assert!(steps[2] < 0.006 && steps[87] < 0.006, "{steps:?}");
}

#[test]
fn a_motion_without_fault_is_left_alone() {
    let mut still = Frame { translation: Vec3::new(0.0, standing_height(), 0.0), ..Frame::default() };
    arms_down(&mut still);
    still.pose[LEFT_KNEE - 1].x = 0.1;
    still.pose[RIGHT_KNEE - 1].x = 0.1;
    still.pose[LEFT_HIP - 1].x = -0.05;
    still.pose[RIGHT_HIP - 1].x = -0.05;
    let (frames, planted) = (vec![still; 30], vec![[true; 2]; 30]);
    let (after, _) = optimise(&open(), &task(&planted, [0, 0]), &frames, &SequenceConfig::default());
    let changed = crate::inspect::MotionErrors::of(Body::bundled(), &BETAS_0, &after, &frames);
    assert!(changed.mpjpe_mm < 10.0, "{changed:?}");
}

#[test]
fn far_from_a_fault_a_motion_stays_byte_for_byte() {
    // Somebody stands for five seconds and leans into the wall in the middle of it.
    let leans = |i: usize| (-((i as f32 - 75.0) / 8.0).powi(2)).exp();
    let frames: Vec<Frame> = (0..150)
        .map(|i| {
            let at = Vec3::new(0.0, standing_height(), 0.5 + 0.45 * leans(i));
            let mut frame = Frame { translation: at, ..Frame::default() };
            arms_down(&mut frame);
            frame
        })
        .collect();
    let planted = vec![[false; 2]; frames.len()];
    let (mended, _) = optimise(&field(1.0), &task(&planted, [0, 0]), &frames, &SequenceConfig::default());
    assert!(mended[..20] == frames[..20] && mended[130..] == frames[130..]);
    assert!(mended[75] != frames[75]);
    let deepest = measure(&field(1.0), &mended, &planted).metrics.penetration_max_mm;
    assert!(deepest < 43.0, "{deepest} mm in the wall");
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let (frames, planted) = gliding_walk(40, 0.8);
    let config = SequenceConfig { window: 30, overlap: 10, ..SequenceConfig::default() };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| optimise(&open(), &task(&planted, [2, 2]), &frames, &config))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn windows_leave_no_seams() {
    let (frames, planted) = gliding_walk(160, 0.8);
    let whole = SequenceConfig { window: 1000, ..SequenceConfig::default() };
    let parts = SequenceConfig { window: 60, overlap: 24, ..SequenceConfig::default() };
    let jitter = |config: &SequenceConfig| {
        let (after, _) = optimise(&open(), &task(&planted, [0, 0]), &frames, config);
        let report = measure(&open(), &after, &planted);
        let rest = Body::bundled().model.rest_joints(&BETAS_0);
        let joints: Vec<[Vec3; 22]> = after.iter().map(|f| FrameJoints::of(&rest, f).positions).collect();
        let bend = |i: usize| {
            let [a, b, c] = [i - 1, i, i + 1].map(|i| &joints[i]);
            (0..22).map(|j| (a[j] - 2.0 * b[j] + c[j]).length()).sum::<f32>() / 22.0
        };
        (report.metrics.jitter_m_per_s3, (1..159).map(bend).fold(0.0, f32::max))
    };
    let ((whole_jitter, whole_bend), (parts_jitter, parts_bend)) = (jitter(&whole), jitter(&parts));
    assert!(parts_jitter < 1.15 * whole_jitter, "{parts_jitter} against {whole_jitter}");
    assert!(parts_bend < 1.25 * whole_bend, "{parts_bend} against {whole_bend}");
}

#[test]
fn a_later_round_over_some_windows_leaves_no_seams_either() {
    // One stretch of the way runs along a wall, so only its windows are gone through again.
    let (mut frames, planted) = gliding_walk(200, 0.75);
    let field = field(100.0);
    for (i, frame) in frames.iter_mut().enumerate() {
        let aside = (-((i as f32 - 60.0) / 40.0).powi(2)).exp();
        frame.translation += Vec3::new(1.0 - 0.4 * (1.0 - aside), 0.02, -0.5);
    }
    let walled = SignedDistanceField {
        values: (0..field.values.len())
            .map(|i| {
                let x = i / (field.dim[1] * field.dim[2]);
                field.values[i].min(1.1 - field.position(x, 0, 0).x)
            })
            .collect(),
        ..field
    };
    let config = SequenceConfig { window: 60, overlap: 24, ..SequenceConfig::default() };
    let (after, _) = optimise(&walled, &task(&planted, [0, 0]), &frames, &config);
    let rest = Body::bundled().model.rest_joints(&BETAS_0);
    let pelvis = |i: usize| FrameJoints::of(&rest, &after[i]).positions[0];
    // Along the floor: the height also follows legs that are too short for this walk.
    let bend = |i: usize| (pelvis(i - 1) - 2.0 * pelvis(i) + pelvis(i + 1)).with_y(0.0).length();
    let worst = (1..199).max_by(|a, b| bend(*a).total_cmp(&bend(*b))).unwrap_or(1);
    assert!(
        bend(worst) < 0.012,
        "the pelvis jerks by {} m at {worst}, {:?}",
        bend(worst),
        [worst - 1, worst, worst + 1].map(|i| (pelvis(i), frames[i].translation)),
    );
}

#[test]
fn a_cancel_keeps_the_best_so_far() {
    let (frames, planted) = gliding_walk(100, 0.8);
    let (field, ticker) = (open(), Ticker::silent());
    let (fitter, around) = (SequenceFitter::new(Body::bundled()), Surroundings::of_field(&field));
    let mut kept = frames.clone();
    let config = SequenceConfig { window: 40, overlap: 10, ..SequenceConfig::default() };
    let task = task(&planted, [0, 0]);
    let result = fitter.optimise(&around, &task, &mut kept, &config, &ticker, &mut |_| ticker.cancel());
    assert_eq!(result, Err(Cancelled));
    assert_ne!(kept[10], frames[10], "the first window was done");
    let after = measure(&field, &kept, &planted).metrics;
    assert!(after.skate_cm_per_s < 2.0, "feet are locked all the same: {after:?}");
}

#[test]
fn the_stable_foot_is_the_one_that_moves_less() {
    let ankles: Vec<[Vec3; 2]> =
        [(0.0, 0.0), (0.0, 0.2), (0.01, 0.4), (0.2, 0.41)].map(|(l, r)| [Vec3::Z * l, Vec3::Z * r]).to_vec();
    let runs = super::stance::nearer_foot_runs(&ankles);
    let found: Vec<_> = runs.iter().map(|run| (run.frames.clone(), run.side)).collect();
    assert_eq!(found, [(0..2, 0), (2..4, 1)]);
    assert!(super::stance::nearer_foot_runs(&[]).is_empty());
}

#[test]
fn a_turned_frame_survives_its_numbers() {
    let (walk, _) = gliding_walk(3, 1.0);
    let from = Quat::from_rotation_y(2.0);
    let frame =
        Frame { rotation: Quat::from_rotation_y(2.9) * Quat::from_rotation_x(0.4), ..walk[2].clone() };
    let back = variables::frame_of(&variables::numbers_of(&frame, from), from);
    assert!(back.rotation.angle_between(frame.rotation) < 1e-3 && back.pose == frame.pose);
}
