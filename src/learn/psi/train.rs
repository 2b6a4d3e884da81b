//! The training itself: epochs over bodies, each step one batch.

use rand::seq::SliceRandom as _;
use rand_distr::{Distribution as _, StandardNormal};
use rayon::prelude::*;

use super::adversary::Projector;
use super::checkpoint::{TrainError, TrainingState};
use super::config::PsiTraining;
use super::data::{Augment, Item, PsiBody, PsiData};
use super::history::HistoryRow;
use super::loss::{self, Target};
use super::scene_loss::SceneLoss;
use crate::body::{Body, Workspace};
use crate::job::{JobCtx, Seed, Stop};
use crate::math::{KMeansConfig, kmeans};
use crate::nn::psi::{BODY, PsiSampler, SceneInput, SceneTensors};
use crate::nn::{Graph, Mode, Params, numbers, tensor, training_device};
use crate::scene::{PARAMS, SignedDistanceField};

/// Validation bodies looked at after each epoch: enough for a curve.
const VALIDATION_BODIES: usize = 128;
/// K-means runs for the baseline's pose classes.
const KMEANS_STARTS: usize = 4;

const _: () = assert!(BODY == PARAMS, "the networks' vector is the body's");

/// What a training works on.
pub struct TrainingInput<'a> {
    /// Bodies and pictures.
    pub data: &'a PsiData,
    /// The distance field of each room, for the scene loss; may be empty without it.
    pub fields: &'a [SignedDistanceField],
}

/// What stays the same over all steps.
struct Tools<'a> {
    input: &'a TrainingInput<'a>,
    body: &'static Body,
    scene_loss: SceneLoss,
    drawn_loss: Option<SceneLoss>,
    projector: Projector,
}

/// Goes on with `state` to the last epoch. `after_epoch` gets the state after each epoch, to write a
/// checkpoint or show the curves.
///
/// # Errors
/// [`Stop::Cancelled`] when the user cancelled, else [`TrainError`] or what `after_epoch` says.
pub fn train(
    state: &mut TrainingState,
    input: &TrainingInput<'_>,
    cx: &JobCtx,
    after_epoch: &mut dyn FnMut(&TrainingState) -> Result<(), Stop>,
) -> Result<(), Stop> {
    check(state, input)?;
    let (body, weights) = (Body::bundled(), state.training.weights);
    let tools = Tools {
        input,
        body,
        scene_loss: SceneLoss::new(body, weights.contact, weights.collision, weights.robust_c_m),
        drawn_loss: state
            .training
            .drawn
            .map(|drawn| SceneLoss::new(body, drawn.contact, drawn.collision, drawn.robust_c_m)),
        projector: Projector::new(body),
    };
    if state.epoch == 0 {
        find_pose_classes(state, input.data);
    }
    let steps = input.data.train.len().div_ceil(state.training.batch);
    let left = state.training.epochs.saturating_sub(state.epoch) * steps;
    cx.stage("training", left)?;
    let mut done = 0;
    while state.epoch < state.training.epochs {
        let row = epoch(state, &tools, cx, &mut done, left)?;
        state.history.rows.push(row);
        state.epoch += 1;
        after_epoch(state)?;
    }
    Ok(())
}

fn check(state: &TrainingState, input: &TrainingInput<'_>) -> Result<(), TrainError> {
    if input.data.train.is_empty() {
        return Err(TrainError::NoBodies);
    }
    let needed = input.data.train.iter().map(|b| b.room + 1).max().unwrap_or(0);
    if state.training.scene_loss && input.fields.len() < needed {
        return Err(TrainError::NoFields { found: input.fields.len(), needed });
    }
    Ok(())
}

/// PSI §4.1.2: pose classes by K-means over the pose codes of the training bodies.
fn find_pose_classes(state: &mut TrainingState, data: &PsiData) {
    if state.network.pose_centres(&state.main.params).is_none() {
        return;
    }
    let codes: Vec<Vec<f32>> =
        data.train.iter().flat_map(|b| [b.params.pose.to_vec(), b.mirrored_pose.to_vec()]).collect();
    let wanted = state.training.network.pose_classes;
    let config = KMeansConfig { clusters: wanted, restarts: KMEANS_STARTS, ..KMeansConfig::default() };
    let seed = Seed::root(state.training.seed).child("pose classes", 0);
    let classes = kmeans(&codes, &config, seed.value());
    // Fewer poses than classes: the last ones stand twice and are never the nearest.
    let centres = classes.centers.iter().cycle().take(wanted).flatten().copied().collect();
    state.network.set_pose_centres(&mut state.main.params, centres);
}

fn epoch(
    state: &mut TrainingState,
    tools: &Tools<'_>,
    cx: &JobCtx,
    done: &mut usize,
    left: usize,
) -> Result<HistoryRow, Stop> {
    let data = tools.input.data;
    let seed = Seed::root(state.training.seed).child("epoch", state.epoch as u64);
    let mut order: Vec<usize> = (0..data.train.len()).collect();
    order.shuffle(&mut seed.child("order", 0).rng());
    let PsiTraining { mirror, turn_deg, depth_noise, .. } = state.training;
    let augment = Augment { mirror, turn_deg, depth_noise };
    let mut row = HistoryRow { epoch: state.epoch + 1, ..HistoryRow::default() };
    let steps = order.len().div_ceil(state.training.batch);
    for (step, chosen) in order.chunks(state.training.batch).enumerate() {
        let seed = seed.child("step", step as u64);
        let draw =
            |(i, body): (usize, &usize)| data.draw(&data.train[*body], augment, seed.child("item", i as u64));
        let items: Vec<Item> = chosen.par_iter().enumerate().map(draw).collect();
        let progress = state.epoch as f32 + step as f32 / steps as f32;
        row.add(&one_step(state, tools, &items, progress, seed.child("noise", 0)));
        *done += 1;
        cx.step(*done, left)?;
    }
    row.mean_over(steps);
    let sampler = PsiSampler::new(state.network.clone(), &state.main.params);
    (row.validation_reconstruction, row.validation_divergence) =
        evaluate_reconstruction(&sampler, data, &data.validation, VALIDATION_BODIES, Seed::root(0));
    match row.curves().iter().all(|(_, value)| value.is_finite()) {
        true => Ok(row),
        false => Err(TrainError::Diverged { epoch: row.epoch }.into()),
    }
}

/// One step of Adam on one batch; gives the terms.
fn one_step(
    state: &mut TrainingState,
    tools: &Tools<'_>,
    items: &[Item],
    progress: f32,
    seed: Seed,
) -> HistoryRow {
    let training = state.training.clone();
    let device = training_device();
    let g = Graph::new(&state.main.params, Mode::Train, &device);
    let scenes: Vec<&SceneInput> = items.iter().map(|i| &i.scene).collect();
    let bodies: Vec<[f32; BODY]> = items.iter().map(|i| i.body).collect();
    let target = Target::new(&scenes, &bodies, g.device());
    let noise = standard_normal(items.len(), training.network.noise(), seed, &g);
    let pictures = SceneTensors::new(&training.network, &scenes, g.device());
    let features = state.network.encode_scene(&g, &pictures);
    let made = state.network.reconstruct(&g, &features, target.normalized.clone(), noise);
    let in_metres = target.in_metres(&made.body);
    let reconstruction = target.reconstruction(&made.body, &in_metres);
    let divergence = loss::divergence(&made, g.device());
    let pose_prior = loss::pose_prior(&made.body);
    let class = loss::class(&made, g.device());
    let mut row = HistoryRow {
        reconstruction: loss::value(&reconstruction),
        divergence: loss::value(&divergence),
        pose_prior: loss::value(&pose_prior),
        class: loss::value(&class),
        ..HistoryRow::default()
    };
    let weights = training.weights;
    let mut total = reconstruction
        + divergence * training.kl_weight(progress)
        + pose_prior * weights.pose_prior
        + class * weights.class;
    let with_scene = training.scene_loss && state.epoch >= training.late_epoch();
    if with_scene || state.discriminator.is_some() {
        let given = rows_of(&numbers(&in_metres));
        let mut gradient = vec![0.0; items.len() * BODY];
        if with_scene {
            add_scene_loss(tools, &tools.scene_loss, items, &given, &mut gradient, &mut row);
        }
        if state.discriminator.is_some() {
            add_adversary(state, tools, items, &given, &mut gradient, &mut row, progress);
        }
        total = total + loss::with_gradient(&in_metres, gradient);
    }
    if let (true, Some(drawn_loss)) = (with_scene, &tools.drawn_loss) {
        let codes = standard_normal(items.len(), training.network.noise(), seed.child("drawn", 0), &g);
        let drawn = target.in_metres(&state.network.decode(&g, &features, codes));
        let mut gradient = vec![0.0; items.len() * BODY];
        add_scene_loss(tools, drawn_loss, items, &rows_of(&numbers(&drawn)), &mut gradient, &mut row);
        total = total + loss::with_gradient(&drawn, gradient);
    }
    let gradients = g.gradients(&mut total.backward());
    let statistics = g.statistics();
    state.main.adam.step(&mut state.main.params, &gradients, training.rate(progress));
    statistics.into_iter().for_each(|(id, values)| state.main.params.replace(id, values));
    row
}

fn rows_of(values: &[f32]) -> Vec<[f32; BODY]> {
    values.chunks_exact(BODY).map(|row| std::array::from_fn(|i| row[i])).collect()
}

fn standard_normal(rows: usize, columns: usize, seed: Seed, g: &Graph) -> burn::tensor::Tensor<2> {
    let mut rng = seed.rng();
    let values = (0..rows * columns).map(|_| StandardNormal.sample(&mut rng)).collect();
    tensor(values, [rows, columns], g.device())
}

/// Eq. 6 and 7 of every body, means over the batch.
fn add_scene_loss(
    tools: &Tools<'_>,
    scene_loss: &SceneLoss,
    items: &[Item],
    given: &[[f32; BODY]],
    gradient: &mut [f32],
    row: &mut HistoryRow,
) {
    let share = 1.0 / items.len() as f32;
    let evaluate = |workspace: &mut Workspace, (item, body): (&Item, &[f32; BODY])| {
        let field = &tools.input.fields[item.room];
        scene_loss.evaluate(tools.body, field, &item.world_from_camera, body, workspace)
    };
    let pairs = items.par_iter().zip(given);
    let found: Vec<_> = pairs.map_init(Workspace::default, evaluate).collect();
    for (found, row_gradient) in found.iter().zip(gradient.chunks_mut(BODY)) {
        row.contact += found.contact * share;
        row.collision += found.collision * share;
        row_gradient.iter_mut().zip(found.gradient).for_each(|(g, by)| *g += by * share);
    }
}

/// One step of the discriminator on real and given bodies, then its pull on the given ones.
fn add_adversary(
    state: &mut TrainingState,
    tools: &Tools<'_>,
    items: &[Item],
    given: &[[f32; BODY]],
    gradient: &mut [f32],
    row: &mut HistoryRow,
    progress: f32,
) {
    let rate = state.training.rate(progress);
    let weight = state.training.weights.adversarial;
    let Some((layers, trained)) = &mut state.discriminator else { return };
    let features =
        |(item, body): (&Item, &[f32; BODY])| tools.projector.features(tools.body, &item.scene, body);
    let real: Vec<f32> = items.par_iter().map(|i| features((i, &i.body))).flatten_iter().collect();
    let fake: Vec<f32> = items.par_iter().zip(given).map(features).flatten_iter().collect();
    let shape = [items.len(), real.len() / items.len()];
    let device = training_device();
    let logits = |params: &Params, of: &[f32]| {
        let g = Graph::new(params, Mode::Train, &device);
        let x = tensor(of.to_vec(), shape, g.device()).require_grad();
        (layers.forward(&g, x.clone()), x, g)
    };
    let g = Graph::new(&trained.params, Mode::Train, &device);
    let of = |x: &[f32]| layers.forward(&g, tensor(x.to_vec(), shape, g.device()));
    let own = (loss::adversarial(of(&real), true) + loss::adversarial(of(&fake), false)) * 0.5;
    row.discriminator += loss::value(&own);
    let gradients = g.gradients(&mut own.backward());
    trained.adam.step(&mut trained.params, &gradients, rate);
    let (judged, x, _graph) = logits(&trained.params, &fake);
    let mut by_features = (loss::adversarial(judged, true) * weight).backward();
    let by_features = x.grad_remove(&mut by_features).map(|g| numbers(&g)).unwrap_or_default();
    let pulled: Vec<[f32; PARAMS]> = items
        .par_iter()
        .zip(given)
        .zip(by_features.par_chunks(shape[1]))
        .map(|((item, body), by)| tools.projector.pull_back(tools.body, &item.scene, body, by))
        .collect();
    for (row, by) in gradient.chunks_mut(BODY).zip(pulled) {
        row.iter_mut().zip(by).for_each(|(g, by)| *g += by);
    }
}

/// Eq. 2 and the divergence (mean over latent numbers, stages summed) over at most `most` of these bodies of
/// `data`, each in one view, with the mean code: PSI Table 1. Zero for nobody.
pub fn evaluate_reconstruction(
    sampler: &PsiSampler,
    data: &PsiData,
    bodies: &[PsiBody],
    most: usize,
    seed: Seed,
) -> (f32, f32) {
    // Evenly over the whole, for rooms stand one after another.
    let bodies: Vec<&PsiBody> = bodies.iter().step_by(bodies.len().div_ceil(most.max(1)).max(1)).collect();
    let (mut error, mut divergence) = (0.0, 0.0);
    for (b, batch) in bodies.chunks(64).enumerate() {
        let draw = |(i, body): (usize, &&PsiBody)| {
            data.draw(body, Augment::NONE, seed.child("view", (b * 64 + i) as u64))
        };
        let items: Vec<Item> = batch.par_iter().enumerate().map(draw).collect();
        let scenes: Vec<&SceneInput> = items.iter().map(|i| &i.scene).collect();
        let given: Vec<[f32; BODY]> = items.iter().map(|i| i.body).collect();
        for (item, made) in items.iter().zip(sampler.reconstruct(&scenes, &given)) {
            error += reconstruction_error(&item.scene, &item.body, &made.body);
            divergence += made.divergence;
        }
    }
    let share = 1.0 / bodies.len().max(1) as f32;
    (error * share, divergence * share)
}

/// Eq. 2 of one body, camera frame, metres.
pub fn reconstruction_error(scene: &SceneInput, truth: &[f32; BODY], made: &[f32; BODY]) -> f32 {
    let off =
        |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>() / a.len() as f32;
    let place = |x: &[f32; BODY]| scene.normalize([x[0], x[1], x[2]]);
    0.5 * (off(&truth[..3], &made[..3]) + off(&place(truth), &place(made))) + off(&truth[3..], &made[3..])
}
