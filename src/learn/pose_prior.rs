//! Trains the variational pose prior: VPoser's loss (Pavlakos et al. 2019) on the program's corpus.
//!
//! Pure: clips in, weights out, all through memory; the caller keeps the checkpoints. Each step draws from a seed of its
//! own, so a run that was interrupted and resumed ends with the weights of one that was not.

use std::f32::consts::PI;

use glam::Vec3;
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::pose_corpus::{PoseCorpus, PoseGroup};
use super::pose_loss::{PoseLoss, PoseLossTerms, PoseLossWeights};
use crate::assets::{Precision, Weights, WeightsError};
use crate::body::{BodyModel, BodyPose};
use crate::job::{JobCtx, Seed, Stop};
use crate::math::rotation;
use crate::math::{Adam, AdamConfig};
use crate::nn::{PoseVae, VAE_CODE, VAE_POSE, VAE_SIX, VaeBatch};

/// How the prior is trained.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PosePriorConfig {
    /// Width of the hidden layers; VPoser's is 512.
    pub hidden: usize,
    /// Poses a step.
    pub batch: usize,
    /// Steps in all.
    pub steps: usize,
    /// First step size; it falls to a hundredth along a half cosine.
    pub learning_rate: f32,
    /// Share of hidden units dropped (VPoser: 0.1), until [`PosePriorConfig::dropout_until`].
    pub dropout: f32,
    /// Share of the steps after which no more units are dropped: the rest of the training sharpens.
    pub dropout_until: f32,
    /// Share of the steps over which the divergence's weight grows to 1.
    pub warm_up: f32,
    /// Weights of the reconstruction's terms; the divergence from the prior weighs 1.
    pub loss: PoseLossWeights,
    /// A checkpoint and a figure on held-out clips every so many steps.
    pub report_every: usize,
}

impl Default for PosePriorConfig {
    fn default() -> Self {
        Self {
            hidden: 512,
            batch: 256,
            steps: 5_000,
            learning_rate: 1e-3,
            dropout: 0.1,
            dropout_until: 0.4,
            warm_up: 0.15,
            // σ of 2 mm over the whole body; six degrees a joint on top, for turns that move little skin.
            loss: PoseLossWeights { position: 1.0e5, rotation: 20.0, orthogonality: 0.1 },
            report_every: 250,
        }
    }
}

/// A point of the training's curves: means since the point before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PosePriorPoint {
    /// Steps done.
    pub step: usize,
    /// Weighted sum of all terms, nats.
    pub loss: f32,
    /// Divergence of the posterior from the prior, nats, without weight.
    pub divergence: f32,
    /// Root mean square displacement of skin and joints with noise and dropout, millimetres.
    pub training_mm: f32,
    /// Mean distance of joints on held-out clips, millimetres, codes without noise.
    pub held_out_clips_mm: f32,
    /// The same on held-out draws of the pose families.
    pub held_out_families_mm: f32,
}

/// What training gives.
#[derive(Clone, Debug)]
pub struct TrainedPosePrior {
    /// For use: see [`PoseVae::folded`], with notes about the making.
    pub weights: Weights,
    /// The curves.
    pub curve: Vec<PosePriorPoint>,
}

/// Why a checkpoint can't be gone on from.
#[derive(Debug, thiserror::Error)]
pub enum ResumeError {
    /// A tensor is missing or does not fit.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// The notes are missing or say something else than the command.
    #[error("{file}: {what}; resume with the corpus, seed and settings of the first run, or start afresh")]
    Other {
        /// The checkpoint.
        file: String,
        /// What does not fit.
        what: String,
    },
}

/// Everything that changes from step to step.
struct Training {
    vae: PoseVae,
    adam: Adam,
    done: usize,
    curve: Vec<PosePriorPoint>,
}

/// Sums since the last point of the curve.
#[derive(Default)]
struct Sums {
    steps: f32,
    loss: f32,
    divergence: f32,
    position_m2: f32,
}

/// Trains from scratch, or on from a checkpoint. `save` gets a checkpoint at every report.
///
/// # Errors
/// [`Stop::Cancelled`]; [`ResumeError`] for a checkpoint of another run; what `save` says.
pub fn train_pose_prior(
    corpus: &PoseCorpus,
    model: &BodyModel,
    config: &PosePriorConfig,
    resume: Option<&Weights>,
    save: &mut dyn FnMut(&Weights) -> Result<(), Stop>,
    cx: &JobCtx,
) -> Result<TrainedPosePrior, Stop> {
    let loss = PoseLoss::new(model);
    let mut training = match resume {
        Some(checkpoint) => Training::resume(checkpoint, config, cx.seed)?,
        None => Training::new(config, cx.seed),
    };
    cx.stage("training the pose prior", config.steps)?;
    let mut sums = Sums::default();
    while training.done < config.steps {
        cx.step(training.done, config.steps)?;
        training.step(corpus, &loss, config, cx.seed, &mut sums);
        if training.done % config.report_every == 0 || training.done == config.steps {
            let point = training.point(corpus, &loss, &std::mem::take(&mut sums));
            training.curve.push(point);
            save(&training.checkpoint(config, cx.seed)?)?;
        }
    }
    let mut weights = training.vae.folded("pose_prior");
    weights.notes = notes(config, cx.seed, &training)?;
    Ok(TrainedPosePrior { weights, curve: training.curve })
}

impl Training {
    fn new(config: &PosePriorConfig, seed: Seed) -> Self {
        let mut rng = seed.child("weights", 0).rng();
        let vae = PoseVae::new(config.hidden, &mut || rng.random_range(-1.0..1.0));
        let adam = Adam::new(vae.parameters.len(), AdamConfig::default());
        Self { vae, adam, done: 0, curve: Vec::new() }
    }

    fn resume(checkpoint: &Weights, config: &PosePriorConfig, seed: Seed) -> Result<Self, ResumeError> {
        let other = |what: &str| ResumeError::Other { file: checkpoint.file.clone(), what: what.to_owned() };
        let note = |key: &str| {
            checkpoint.notes.get(key).ok_or_else(|| other(&format!("it does not say its `{key}`")))
        };
        let same = note("config")? == &text(config) && note("seed")? == &seed.value().to_string();
        if !same {
            return Err(other("it was made with other settings or another seed"));
        }
        let vae = PoseVae::read(checkpoint)?;
        let count = vae.parameters.len();
        let (first, second) =
            (checkpoint.values("adam.first", &[count])?, checkpoint.values("adam.second", &[count])?);
        let done: usize = note("steps")?.parse().map_err(|_| other("its `steps` are no number"))?;
        let curve = serde_json::from_str(note("curve")?).map_err(|_| other("its `curve` can't be read"))?;
        let steps = i32::try_from(done).map_err(|_| other("its `steps` are too many"))?;
        let adam = Adam::resume(AdamConfig::default(), first.to_vec(), second.to_vec(), steps);
        Ok(Self { vae, adam, done, curve })
    }

    fn checkpoint(&self, config: &PosePriorConfig, seed: Seed) -> Result<Weights, Stop> {
        let mut weights = Weights::new("pose prior checkpoint");
        self.vae.write(&mut weights);
        let (first, second) = self.adam.moments();
        weights.insert("adam.first", &[first.len()], first.to_vec());
        weights.insert("adam.second", &[second.len()], second.to_vec());
        weights.notes = notes(config, seed, self)?;
        Ok(weights)
    }

    fn step(
        &mut self,
        corpus: &PoseCorpus,
        loss: &PoseLoss,
        config: &PosePriorConfig,
        seed: Seed,
        sums: &mut Sums,
    ) {
        let progress = self.done as f32 / config.steps as f32;
        let (poses, batch) = draw_batch(corpus, config, progress, seed.child("step", self.done as u64));
        let mut terms = PoseLossTerms::default();
        let gradient = self.vae.step(&batch, &mut |six| {
            let (mean, gradient) = mean_loss(loss, six, &poses, &config.loss);
            terms = mean;
            gradient
        });
        let rate = config.learning_rate * (0.01 + 0.99 * 0.5 * (1.0 + (PI * progress).cos()));
        self.adam.set_learning_rate(rate);
        let ones = vec![1.0; self.vae.parameters.len()];
        self.adam.step(&mut self.vae.parameters, &gradient.parameters, &ones);
        self.done += 1;
        sums.steps += 1.0;
        sums.loss += terms.total(&config.loss) + batch.divergence_weight * gradient.divergence;
        sums.divergence += gradient.divergence;
        sums.position_m2 += terms.position_m2;
    }

    fn point(&self, corpus: &PoseCorpus, loss: &PoseLoss, sums: &Sums) -> PosePriorPoint {
        let mean = |sum: f32| sum / sums.steps.max(1.0);
        PosePriorPoint {
            step: self.done,
            loss: mean(sums.loss),
            divergence: mean(sums.divergence),
            training_mm: mean(sums.position_m2).sqrt() * 1000.0,
            held_out_clips_mm: held_out_mm(&self.vae, loss, &corpus.held_out_clips),
            held_out_families_mm: held_out_mm(&self.vae, loss, &corpus.held_out_families),
        }
    }
}

fn text(config: &PosePriorConfig) -> String {
    serde_json::to_string(config).unwrap_or_default()
}

fn notes(
    config: &PosePriorConfig,
    seed: Seed,
    training: &Training,
) -> Result<std::collections::BTreeMap<String, String>, Stop> {
    let pairs = [
        ("network", "variational pose prior, VPoser v1's layers".to_owned()),
        ("config", text(config)),
        ("seed", seed.value().to_string()),
        ("steps", training.done.to_string()),
        ("curve", serde_json::to_string(&training.curve)?),
    ];
    Ok(pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
}

fn draw_batch(
    corpus: &PoseCorpus,
    config: &PosePriorConfig,
    progress: f32,
    seed: Seed,
) -> (Vec<BodyPose>, VaeBatch) {
    let mut rng = seed.rng();
    let poses: Vec<BodyPose> = (0..config.batch).map(|_| corpus.draw(&mut rng)).collect();
    let rate = if progress < config.dropout_until { config.dropout } else { 0.0 };
    let keep = [(); 2].map(|()| match rate > 0.0 {
        true => dropout(config.batch * config.hidden, rate, &mut rng),
        false => Vec::new(),
    });
    let batch = VaeBatch {
        poses: flat(&poses),
        noise: (0..config.batch * VAE_CODE).map(|_| StandardNormal.sample(&mut rng)).collect(),
        keep,
        divergence_weight: (progress / config.warm_up.max(1e-6)).min(1.0),
    };
    (poses, batch)
}

fn dropout(count: usize, rate: f32, rng: &mut crate::job::Rng) -> Vec<f32> {
    let kept = 1.0 / (1.0 - rate);
    (0..count).map(|_| if rng.random_range(0.0..1.0f32) < rate { 0.0 } else { kept }).collect()
}

fn flat(poses: &[BodyPose]) -> Vec<f32> {
    poses.iter().flatten().flat_map(|v: &Vec3| v.to_array()).collect()
}

/// Mean terms over the batch and the gradient of their weighted sum with respect to the decoded numbers.
fn mean_loss(
    loss: &PoseLoss,
    six: &[f32],
    poses: &[BodyPose],
    weights: &PoseLossWeights,
) -> (PoseLossTerms, Vec<f32>) {
    let pairs: Vec<_> =
        six.par_chunks(VAE_SIX).zip(poses).map(|(six, pose)| loss.evaluate(six, pose, weights)).collect();
    let share = 1.0 / poses.len().max(1) as f32;
    let mut mean = PoseLossTerms::default();
    let mut gradient = Vec::with_capacity(six.len());
    for (terms, pull) in &pairs {
        mean.position_m2 += share * terms.position_m2;
        mean.rotation += share * terms.rotation;
        mean.orthogonality += share * terms.orthogonality;
        gradient.extend(pull.iter().map(|g| g * share));
    }
    (mean, gradient)
}

/// Held-out poses that a figure of the curve looks at, at most.
const LOOKED_AT: usize = 512;

/// Mean distance of the joints, encoded and decoded without noise, millimetres; 0 when nothing is held out.
fn held_out_mm(vae: &PoseVae, loss: &PoseLoss, groups: &[PoseGroup]) -> f32 {
    let count: usize = groups.iter().map(|group| group.poses.len()).sum();
    let stride = count.div_ceil(LOOKED_AT).max(1);
    let poses: Vec<BodyPose> =
        groups.iter().flat_map(|group| &group.poses).copied().step_by(stride).collect();
    if poses.is_empty() {
        return 0.0;
    }
    let six = vae.decode(&vae.encode(&flat(&poses)).mean);
    let distance = |(six, pose): (&[f32], &BodyPose)| {
        let own = |joint: usize| std::array::from_fn(|i| six[6 * (joint - 1) + i]);
        let decoded = loss.joints(&|joint| rotation::matrix_from_6d(&own(joint)));
        let wanted = loss.joints(&|joint| rotation::matrix_from_axis_angle(pose[joint - 1]));
        let apart: f32 = decoded.iter().zip(&wanted).map(|(a, b)| a.distance(*b)).sum();
        apart / decoded.len() as f32
    };
    1000.0 * six.chunks_exact(VAE_SIX).zip(&poses).map(distance).sum::<f32>() / poses.len() as f32
}

/// How the trained weights are stored: two bytes a number lose a thousandth of each.
pub const SHIPPED_PRECISION: Precision = Precision::Half;

const _: () = assert!(VAE_POSE == 3 * crate::body::joints::BODY_JOINTS && VAE_CODE == crate::scene::POSE);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;
    use crate::job::Ticker;
    use crate::learn::PoseCorpusConfig;

    fn small() -> (PoseCorpus, PosePriorConfig) {
        let config = PoseCorpusConfig { samples_a_family: 10, ..PoseCorpusConfig::default() };
        let corpus = PoseCorpus::new(&[], &Body::bundled().model, config, Seed::root(1), &Ticker::silent());
        let config = PosePriorConfig {
            hidden: 32,
            batch: 32,
            steps: 60,
            learning_rate: 3e-3,
            report_every: 20,
            ..PosePriorConfig::default()
        };
        (corpus.expect("a corpus"), config)
    }

    fn train(resume: Option<&Weights>) -> (TrainedPosePrior, Vec<Weights>) {
        let (corpus, config) = small();
        let mut saved = Vec::new();
        let mut save = |checkpoint: &Weights| {
            saved.push(checkpoint.clone());
            Ok(())
        };
        let cx = JobCtx::headless(Seed::root(4));
        let trained = train_pose_prior(&corpus, &Body::bundled().model, &config, resume, &mut save, &cx);
        (trained.expect("trained"), saved)
    }

    #[test]
    fn a_small_prior_learns_and_resumes_to_the_same_weights() {
        let (whole, saved) = train(None);
        let [first, .., last] = whole.curve.as_slice() else { panic!("no curve") };
        assert!(last.held_out_families_mm < 0.8 * first.held_out_families_mm, "{:?}", whole.curve);
        // Through bytes, as a file would.
        let bytes = saved[0].to_bytes(Precision::Full).expect("bytes");
        let read = Weights::from_bytes("pose prior checkpoint", &bytes).expect("checkpoint");
        let (resumed, _) = train(Some(&read));
        assert_eq!(resumed.weights, whole.weights);
        assert_eq!(resumed.curve.len(), whole.curve.len());
    }

    #[test]
    fn a_checkpoint_of_another_run_is_refused() {
        let (corpus, config) = small();
        let (_, saved) = train(None);
        let other = PosePriorConfig { batch: 16, ..config };
        let cx = JobCtx::headless(Seed::root(4));
        let model = &Body::bundled().model;
        let stop = train_pose_prior(&corpus, model, &other, Some(&saved[0]), &mut |_| Ok(()), &cx);
        assert!(matches!(stop, Err(Stop::Failed(why)) if why.contains("other settings")));
    }
}
