//! The training itself: epochs of drawn windows, bodies or clouds, each step one batch.

use burn::tensor::Tensor;
use glam::Affine3A;
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use rayon::prelude::*;

use super::checkpoint::{MotionState, score_of};
use super::config::MotionTraining;
use super::data::{BodyRow, MotionData, StagedBody, Window, WindowRows};
use super::history::MotionRow;
use super::loss;
use super::takes::WINDOW;
use crate::body::joints::PELVIS;
use crate::body::{Body, Workspace};
use crate::job::{JobCtx, Rng, Seed, Stop};
use crate::learn::corpus::Split;
use crate::learn::psi::loss::{value, with_gradient};
use crate::learn::psi::{SceneLoss, TrainError};
use crate::motion::local::LegFrame;
use crate::nn::motion::{
    BETWEEN, Between, BetweenInput, CONDITION, Cloud, HAND_COLUMNS, MotionKind, MotionSampler, PLACE,
    POSE_COLUMNS, ROW, TURN_COLUMNS, WHERE_COLUMNS,
};
use crate::nn::{Graph, Mode, numbers, tensor, training_device};
use crate::scene::{BodyParams, HANDS, POSE};

/// Windows, bodies or clouds of the validation clips looked at after each epoch: enough for a curve.
const VALIDATION: usize = 192;
/// Noise on the ends' places and rotations, against that on their codes.
const PLACE_NOISE: f32 = 0.1;
/// c of the robust distance, metres (1 in the published training).
const ROBUST_C_M: f32 = 1.0;

/// The RouteNet that PoseNet learns behind; its numbers stay as they are (LTM §3.3).
pub type RouteOf<'a> = Option<&'a MotionSampler>;

/// What a training works on.
pub struct TrainInput<'a> {
    /// Takes, bodies, rooms.
    pub data: &'a MotionData,
    /// For PoseNet.
    pub route: RouteOf<'a>,
}

/// What the steps draw from.
struct Pool<'a> {
    data: &'a MotionData,
    route: RouteOf<'a>,
    windows: Vec<Window>,
    bodies: Vec<&'a StagedBody>,
    scene_loss: SceneLoss,
}

/// Goes on with `state` to the last epoch. `after_epoch` gets the state after each epoch, to write a checkpoint or
/// show the curves.
///
/// # Errors
/// [`Stop::Cancelled`] when the user cancelled, else [`TrainError`] or what `after_epoch` says.
pub fn train_motion(
    state: &mut MotionState,
    input: &TrainInput<'_>,
    cx: &JobCtx,
    after_epoch: &mut dyn FnMut(&MotionState) -> Result<(), Stop>,
) -> Result<(), Stop> {
    let weights = state.training.weights;
    let pool = Pool {
        data: input.data,
        route: input.route,
        windows: input.data.training_windows(),
        bodies: input.data.bodies_of(Split::Train),
        scene_loss: SceneLoss::new(Body::bundled(), weights.contact, weights.collision, ROBUST_C_M),
    };
    check(state, &pool)?;
    let steps = state.training.drawn.div_ceil(state.training.batch);
    let left = state.training.epochs.saturating_sub(state.epoch) * steps;
    cx.stage("training", left)?;
    let mut done = 0;
    while state.epoch < state.training.epochs {
        let mut row = MotionRow { epoch: state.epoch + 1, ..MotionRow::default() };
        let seed = Seed::root(state.training.seed).child("epoch", state.epoch as u64);
        for step in 0..steps {
            let progress = state.epoch as f32 + step as f32 / steps as f32;
            let terms = one_step(state, &pool, progress, seed.child("step", step as u64));
            row.training += terms.training / steps as f32;
            row.divergence += terms.divergence / steps as f32;
            row.contact += terms.contact / steps as f32;
            row.collision += terms.collision / steps as f32;
            done += 1;
            cx.step(done, left)?;
        }
        let sampler = MotionSampler::new(state.network.clone(), &state.main.params);
        validate(&sampler, &state.training, input, &mut row);
        if row.curves().iter().any(|(_, value)| !value.is_finite()) {
            return Err(TrainError::Diverged { epoch: row.epoch }.into());
        }
        let score = score_of(&state.training, &row);
        state.finish_epoch(row, score);
        after_epoch(state)?;
    }
    Ok(())
}

fn check(state: &MotionState, pool: &Pool<'_>) -> Result<(), TrainError> {
    let missing = match state.training.network.kind {
        MotionKind::Between(Between::Pose) if pool.route.is_none() => return Err(TrainError::NoRoute),
        MotionKind::Between(_) => pool.windows.is_empty(),
        MotionKind::SubGoal => pool.bodies.is_empty(),
        MotionKind::Points => pool.data.takes.is_empty(),
    };
    let what = state.training.network.kind.label();
    if missing { Err(TrainError::NoClips { what }) } else { Ok(()) }
}

/// One step of Adam on one batch; gives the terms.
fn one_step(state: &mut MotionState, pool: &Pool<'_>, progress: f32, seed: Seed) -> MotionRow {
    let training = state.training.clone();
    let device = training_device();
    let g = Graph::new(&state.main.params, Mode::Train, &device);
    let (total, row) = match training.network.kind {
        MotionKind::Points => step_of_points(state, pool, &g, seed),
        MotionKind::SubGoal => step_of_bodies(state, pool, &g, progress, seed),
        MotionKind::Between(which) => step_of_windows(state, pool, &g, which, seed),
    };
    let gradients = g.gradients(&mut total.backward());
    state.main.adam.step(&mut state.main.params, &gradients, training.rate(progress));
    row
}

fn step_of_points(state: &MotionState, pool: &Pool<'_>, g: &Graph, seed: Seed) -> (Tensor<1>, MotionRow) {
    let (count, points) = (state.training.batch, state.training.network.points.count);
    let draw = |i: usize| pool.data.labelled(Split::Train, points, &mut seed.child("cloud", i as u64).rng());
    let (clouds, classes): (Vec<Cloud>, Vec<Vec<u8>>) = (0..count).into_par_iter().filter_map(draw).unzip();
    let clouds: Vec<&Cloud> = clouds.iter().collect();
    let cloud = state.network.cloud_tensor(&clouds, g.device());
    let logits = cloud.and_then(|cloud| state.network.label(g, cloud));
    let total = logits.map_or_else(|| nothing(g), |logits| loss::labels(logits, &classes.concat()));
    let row = MotionRow { training: value(&total), ..MotionRow::default() };
    (total, row)
}

/// A loss of nothing, for what can't happen.
fn nothing(g: &Graph) -> Tensor<1> {
    Tensor::zeros([1], g.device())
}

fn noise(count: usize, deviation: f32, rng: &mut Rng) -> Vec<f32> {
    (0..count)
        .map(|_| {
            let z: f32 = StandardNormal.sample(rng);
            z * deviation
        })
        .collect()
}

/// A batch of windows as tensors.
struct WindowTensors {
    input: BetweenInput,
    truth: Tensor<2>,
}

fn window_tensors(
    which: Between,
    windows: &[WindowRows],
    cloud: Option<Tensor<3>>,
    routes: &[Vec<f32>],
    end_noise: &[f32],
    g: &Graph,
) -> WindowTensors {
    let batch = windows.len();
    let end = |at: usize, noise: &[f32]| {
        let rows = windows.iter().flat_map(|w| w.rows[at]).zip(noise).map(|(x, n)| x + n);
        tensor(rows.collect(), [batch, ROW], g.device())
    };
    let (first, last) = end_noise.split_at(batch * ROW);
    let route = (!routes.is_empty()).then(|| tensor(routes.concat(), [batch, BETWEEN * PLACE], g.device()));
    WindowTensors {
        input: BetweenInput { cloud, start: end(0, first), end: end(WINDOW - 1, last), route },
        truth: tensor(
            windows.iter().flat_map(|w| truth_of(which, w)).collect(),
            [batch, BETWEEN * which.outputs().len()],
            g.device(),
        ),
    }
}

/// What a network should give for a window.
pub(super) fn truth_of(which: Between, window: &WindowRows) -> Vec<f32> {
    window.rows[1..=BETWEEN].iter().flat_map(|row| row[which.outputs()].to_vec()).collect()
}

/// The routes that RouteNet gives for windows; empty for networks that take none.
fn routes_of(route: RouteOf<'_>, which: Between, windows: &[WindowRows]) -> Vec<Vec<f32>> {
    let Some(net) = route.filter(|_| which.takes_route()) else { return Vec::new() };
    let starts: Vec<[f32; ROW]> = windows.iter().map(|w| w.rows[0]).collect();
    let ends: Vec<[f32; ROW]> = windows.iter().map(|w| w.rows[WINDOW - 1]).collect();
    let clouds: Vec<Cloud> = windows.iter().map(|w| fitted(&w.cloud, net.config().points.count)).collect();
    net.between(&clouds.iter().collect::<Vec<_>>(), &starts, &ends, &[])
}

/// As many points as another network takes: the first of them, again from the start where there are too few.
fn fitted(cloud: &Cloud, count: usize) -> Cloud {
    cloud.iter().cycle().take(if cloud.is_empty() { 0 } else { count }).copied().collect()
}

fn step_of_windows(
    state: &MotionState,
    pool: &Pool<'_>,
    g: &Graph,
    which: Between,
    seed: Seed,
) -> (Tensor<1>, MotionRow) {
    let training = &state.training;
    let mut rng = seed.child("draw", 0).rng();
    let chosen = pool.data.draw(&pool.windows, training.batch, &mut rng);
    let points = training.network.points.count;
    let windows: Vec<WindowRows> = chosen
        .par_iter()
        .enumerate()
        .map(|(i, window)| pool.data.rows(*window, points, seed.child("cloud", i as u64)))
        .collect();
    let routes = routes_of(pool.route, which, &windows);
    let clouds: Vec<&Cloud> = windows.iter().map(|w| &w.cloud).collect();
    let cloud = state.network.cloud_tensor(&clouds, g.device());
    let mut end_noise = noise(2 * windows.len() * ROW, training.end_noise, &mut rng);
    for row in end_noise.chunks_exact_mut(ROW) {
        row[..PLACE].iter_mut().for_each(|n| *n *= PLACE_NOISE);
    }
    let batch = window_tensors(which, &windows, cloud, &routes, &end_noise, g);
    let weights = loss::between_weights(training, which, g.device());
    let made = state.network.fill(g, &batch.input);
    let total = made.map_or_else(|| nothing(g), |made| loss::distance(&made, &batch.truth, &weights));
    let row = MotionRow { training: value(&total), ..MotionRow::default() };
    (total, row)
}

fn step_of_bodies(
    state: &MotionState,
    pool: &Pool<'_>,
    g: &Graph,
    progress: f32,
    seed: Seed,
) -> (Tensor<1>, MotionRow) {
    let training = &state.training;
    let mut rng = seed.child("draw", 0).rng();
    let chosen: Vec<&StagedBody> =
        (0..training.batch).map(|_| pool.bodies[rng.random_range(0..pool.bodies.len())]).collect();
    let points = training.network.points.count;
    let bodies: Vec<BodyRow> = chosen
        .par_iter()
        .enumerate()
        .map(|(i, body)| pool.data.body_row(body, points, seed.child("cloud", i as u64)))
        .collect();
    let batch = bodies.len();
    let clouds: Vec<&Cloud> = bodies.iter().map(|b| &b.cloud).collect();
    let cloud = state.network.cloud_tensor(&clouds, g.device());
    let asked = tensor(bodies.iter().flat_map(|b| b.asked).collect(), [batch, CONDITION], g.device());
    let truth = tensor(bodies.iter().flat_map(|b| b.row).collect(), [batch, ROW], g.device());
    let latent = training.network.latent;
    let normal = tensor(noise(batch * latent, 1.0, &mut rng), [batch, latent], g.device());
    let Some(made) = state.network.reconstruct(g, cloud, asked, truth.clone(), normal) else {
        return (nothing(g), MotionRow::default());
    };
    let reconstruction = loss::distance(&made.bodies, &truth, &loss::body_weights(training, g.device()));
    let divergence = made.posterior.divergence();
    let mut row = MotionRow {
        training: value(&reconstruction),
        divergence: value(&divergence),
        ..MotionRow::default()
    };
    let mut total = reconstruction + divergence * training.kl_weight(progress);
    if state.epoch >= training.late_epoch() {
        let gradient = scene_gradient(pool, &chosen, &numbers(&made.bodies), &mut row);
        total = total + with_gradient(&made.bodies, gradient);
    }
    (total, row)
}

/// Contact and collision of the bodies that came out (PSI eq. 6, 7), means over the batch; their gradient.
fn scene_gradient(pool: &Pool<'_>, chosen: &[&StagedBody], made: &[f32], row: &mut MotionRow) -> Vec<f32> {
    let body = Body::bundled();
    let rest = body.model.joint_template[PELVIS];
    let share = 1.0 / chosen.len() as f32;
    let evaluate = |workspace: &mut Workspace, (staged, made): (&&StagedBody, &[f32])| {
        let leg = LegFrame::of(&staged.frame, rest, 0.0);
        let world_from_leg = Affine3A::from_rotation_translation(leg.turn, leg.origin);
        let field = pool.data.room_of(staged).field_around(leg.origin);
        let in_leg = params_of(made, rest).to_vector();
        pool.scene_loss.evaluate(body, &field, &world_from_leg, &in_leg, workspace)
    };
    let found: Vec<_> =
        chosen.par_iter().zip(made.par_chunks_exact(ROW)).map_init(Workspace::default, evaluate).collect();
    let mut gradient = vec![0.0; made.len()];
    for (found, own) in found.iter().zip(gradient.chunks_exact_mut(ROW)) {
        row.contact += found.contact * share;
        row.collision += found.collision * share;
        // The body's 75 numbers are t, R, betas, pose, hands; a row has no betas.
        let (place, rest_of_it) = found.gradient.split_at(PLACE);
        own[..PLACE].copy_from_slice(place);
        own[PLACE..].copy_from_slice(&rest_of_it[crate::scene::BETAS..]);
        own.iter_mut().for_each(|g| *g *= share);
    }
    gradient
}

/// A row as a body in the row's own frame.
fn params_of(row: &[f32], rest: glam::Vec3) -> BodyParams {
    let pose: [f32; POSE] = std::array::from_fn(|i| row[POSE_COLUMNS.start + i]);
    let hands: [f32; HANDS] = std::array::from_fn(|i| row[HAND_COLUMNS.start + i]);
    BodyParams {
        translation: glam::Vec3::from_slice(&row[WHERE_COLUMNS]) - rest,
        rotation6: std::array::from_fn(|i| row[TURN_COLUMNS.start + i]),
        pose,
        hands,
        ..BodyParams::default()
    }
}

/// The loss on the validation clips, without noise, into `row`.
fn validate(sampler: &MotionSampler, training: &MotionTraining, input: &TrainInput<'_>, row: &mut MotionRow) {
    match training.network.kind {
        MotionKind::Points => {
            row.labelled_rightly = labelled_rightly(sampler, input.data);
            row.validation = 1.0 - row.labelled_rightly;
        }
        MotionKind::SubGoal => validate_bodies(sampler, training, input.data, row),
        MotionKind::Between(which) => {
            let sums = validation_loss(sampler, which, input, Split::Validation, VALIDATION);
            let weight: f32 = which.outputs().map(|c| training.column_weight(c) * sums[c]).sum();
            row.validation = weight / which.outputs().len() as f32;
            note_columns(&sums, row);
        }
    }
}

fn note_columns(mean: &[f32; ROW], row: &mut MotionRow) {
    let of = |columns: std::ops::Range<usize>| {
        let count = columns.len() as f32;
        100.0 * mean[columns].iter().sum::<f32>() / count
    };
    row.place_cm = of(WHERE_COLUMNS);
    row.turn_x100 = of(TURN_COLUMNS);
    row.pose_x100 = of(POSE_COLUMNS);
}

/// Mean distance of each column over all frames of at most `most` windows of one part; 0 for columns that the network
/// doesn't give.
pub fn validation_loss(
    sampler: &MotionSampler,
    which: Between,
    input: &TrainInput<'_>,
    split: Split,
    most: usize,
) -> [f32; ROW] {
    let chosen = input.data.measured(split, most);
    let seed = Seed::root(0).child("validation", 0);
    let mut mean = [0.0; ROW];
    let columns = which.outputs();
    let share = 1.0 / (chosen.len().max(1) * BETWEEN) as f32;
    for (b, batch) in chosen.chunks(64).enumerate() {
        let points = sampler.config().points.count;
        let rows: Vec<WindowRows> = batch
            .par_iter()
            .enumerate()
            .map(|(i, w)| input.data.rows(*w, points, seed.child("cloud", (b * 64 + i) as u64)))
            .collect();
        for (window, made) in rows.iter().zip(fill_windows(sampler, which, input.route, &rows)) {
            let truth = truth_of(which, window);
            for (made, truth) in made.chunks_exact(columns.len()).zip(truth.chunks_exact(columns.len())) {
                for (c, (a, b)) in columns.clone().zip(made.iter().zip(truth)) {
                    mean[c] += (a - b).abs() * share;
                }
            }
        }
    }
    mean
}

/// What a network gives for windows, behind the route of RouteNet where it takes one.
pub(super) fn fill_windows(
    sampler: &MotionSampler,
    which: Between,
    route: RouteOf<'_>,
    windows: &[WindowRows],
) -> Vec<Vec<f32>> {
    let routes = routes_of(route, which, windows);
    let clouds: Vec<Cloud> =
        windows.iter().map(|w| fitted(&w.cloud, sampler.config().points.count)).collect();
    let starts: Vec<[f32; ROW]> = windows.iter().map(|w| w.rows[0]).collect();
    let ends: Vec<[f32; ROW]> = windows.iter().map(|w| w.rows[WINDOW - 1]).collect();
    sampler.between(&clouds.iter().collect::<Vec<_>>(), &starts, &ends, &routes)
}

fn validate_bodies(
    sampler: &MotionSampler,
    training: &MotionTraining,
    data: &MotionData,
    row: &mut MotionRow,
) {
    let bodies = data.bodies_of(Split::Validation);
    let chosen: Vec<&StagedBody> =
        bodies.iter().step_by(bodies.len().div_ceil(VALIDATION).max(1)).copied().collect();
    let seed = Seed::root(0).child("validation", 0);
    let points = sampler.config().points.count;
    let rows: Vec<BodyRow> = chosen
        .par_iter()
        .enumerate()
        .map(|(i, body)| data.body_row(body, points, seed.child("cloud", i as u64)))
        .collect();
    let clouds: Vec<&Cloud> = rows.iter().map(|r| &r.cloud).collect();
    let asked: Vec<[f32; CONDITION]> = rows.iter().map(|r| r.asked).collect();
    let truth: Vec<[f32; ROW]> = rows.iter().map(|r| r.row).collect();
    let mut mean = [0.0; ROW];
    let share = 1.0 / rows.len().max(1) as f32;
    for ((made, _), truth) in sampler.reconstruct(&clouds, &asked, &truth).iter().zip(&truth) {
        for (c, sum) in mean.iter_mut().enumerate() {
            *sum += (made[c] - truth[c]).abs() * share;
        }
    }
    row.validation = (0..ROW).map(|c| training.column_weight(c) * mean[c]).sum::<f32>() / ROW as f32;
    note_columns(&mean, row);
}

fn labelled_rightly(sampler: &MotionSampler, data: &MotionData) -> f32 {
    let seed = Seed::root(0).child("validation", 0);
    let points = sampler.config().points.count;
    let (mut right, mut all) = (0, 0);
    for i in 0..VALIDATION / 4 {
        let mut rng = seed.child("cloud", i as u64).rng();
        let Some((cloud, classes)) = data.labelled(Split::Validation, points, &mut rng) else { break };
        let found = sampler.labels(&cloud);
        right += found.iter().zip(&classes).filter(|(f, c)| **f == usize::from(**c)).count();
        all += classes.len();
    }
    right as f32 / all.max(1) as f32
}
