//! The whole state of a training: written, read again, it goes on to the bit.

use super::config::MotionTraining;
use super::history::{MotionHistory, MotionRow};
use crate::assets::{Precision, Weights, WeightsError};
use crate::job::Seed;
use crate::learn::psi::TrainError;
use crate::learn::psi::checkpoint::{Trained, note};
use crate::math::AdamConfig;
use crate::nn::motion::{MotionNetwork, MotionSampler};
use crate::nn::{NetworkAdam, Params};

const TRAINING_NOTE: &str = "training";
const HISTORY_NOTE: &str = "history";
const EPOCH_NOTE: &str = "epoch";
const STEPS_NOTE: &str = "steps";
const CORPUS_NOTE: &str = "corpus";
/// Names of the kept epoch's arrays in a checkpoint begin with this.
const BEST: &str = "best";

/// Everything that a training carries from epoch to epoch.
#[derive(Clone, Debug)]
pub struct MotionState {
    /// The settings.
    pub training: MotionTraining,
    /// What was learnt from.
    pub corpus: String,
    /// Epochs done.
    pub epoch: usize,
    /// How it went.
    pub history: MotionHistory,
    pub(super) network: MotionNetwork,
    pub(super) main: Trained,
    best: Params,
}

impl MotionState {
    /// Before the first epoch; PointNet as `points` has it, if given.
    ///
    /// # Errors
    /// [`WeightsError`] when `points` holds a PointNet of other sizes.
    pub fn new(
        training: MotionTraining,
        corpus: String,
        points: Option<&Weights>,
    ) -> Result<Self, WeightsError> {
        let seed = Seed::root(training.seed).child("weights", 0);
        let (network, mut params) = MotionNetwork::declare(&training.network, seed.value());
        if let (Some(points), true) = (points, training.network.scene) {
            MotionNetwork::take_points(&mut params, points)?;
        }
        let config = AdamConfig { learning_rate: training.learning_rate, ..AdamConfig::default() };
        let main = Trained { adam: NetworkAdam::new(&params, config), params };
        let best = main.params.clone();
        Ok(Self { training, corpus, epoch: 0, history: MotionHistory::default(), network, main, best })
    }

    /// The numbers of the epoch with the least validation loss.
    pub fn best(&self) -> &Params {
        &self.best
    }

    /// The network without its numbers.
    pub fn network(&self) -> &MotionNetwork {
        &self.network
    }

    /// A sampler of the kept epoch.
    pub fn sampler(&self) -> MotionSampler {
        MotionSampler::new(self.network.clone(), &self.best)
    }

    /// Notes an epoch; its numbers are kept when none before did better on the validation clips.
    pub(super) fn finish_epoch(&mut self, row: MotionRow, score: f32) {
        let least = self.history.best_row().map_or(f32::INFINITY, |r| score_of(&self.training, r));
        self.history.rows.push(row);
        self.epoch += 1;
        if score <= least {
            self.history.best = self.epoch;
            self.best.clone_from(&self.main.params);
        }
    }

    /// The bytes of a checkpoint.
    ///
    /// # Errors
    /// [`WeightsError`] when it can't be put together.
    pub fn checkpoint(&self) -> Result<Vec<u8>, WeightsError> {
        let mut weights = self.described("checkpoint");
        self.main.params.store(&mut weights);
        self.main.adam.store("adam", &self.main.params, &mut weights);
        for entry in self.best.entries() {
            weights.insert(&format!("{BEST}.{}", entry.name), &entry.shape, entry.values.clone());
        }
        weights.to_bytes(Precision::Full)
    }

    /// The finished network as it ships: the kept epoch in half precision, with notes on where it comes from.
    ///
    /// # Errors
    /// [`WeightsError`] when it can't be put together.
    pub fn weights(&self) -> Result<Vec<u8>, WeightsError> {
        let mut weights = self.described("weights");
        self.network.store(&self.best, &mut weights);
        weights.to_bytes(Precision::Half)
    }

    fn described(&self, file: &str) -> Weights {
        let mut weights = Weights::new(file);
        let training = serde_json::to_string(&self.training).unwrap_or_default();
        let history = serde_json::to_string(&self.history).unwrap_or_default();
        for (note, text) in [
            (TRAINING_NOTE, training),
            (HISTORY_NOTE, history),
            (EPOCH_NOTE, self.epoch.to_string()),
            (STEPS_NOTE, self.main.adam.steps().to_string()),
            (CORPUS_NOTE, serde_json::to_string(&self.corpus).unwrap_or_default()),
        ] {
            weights.notes.insert(note.to_owned(), text);
        }
        weights
    }

    /// The state that [`MotionState::checkpoint`] wrote, to go on with `training` on `corpus`.
    ///
    /// # Errors
    /// [`TrainError`] when the checkpoint is of another training or damaged.
    pub fn resume(training: MotionTraining, corpus: String, weights: &Weights) -> Result<Self, TrainError> {
        let other = |differs: &str| TrainError::OtherTraining {
            file: weights.file.clone(),
            differs: differs.to_owned(),
        };
        if note::<MotionTraining>(weights, TRAINING_NOTE)? != training {
            return Err(other("its settings differ"));
        }
        if note::<String>(weights, CORPUS_NOTE)? != corpus {
            return Err(other("its corpus differs"));
        }
        let mut state = Self::new(training, corpus, None)?;
        state.epoch = note(weights, EPOCH_NOTE)?;
        state.history = note(weights, HISTORY_NOTE)?;
        state.main.load(weights, note(weights, STEPS_NOTE)?)?;
        for entry in state.best.entries_mut() {
            entry.values = weights.values(&format!("{BEST}.{}", entry.name), &entry.shape)?.to_vec();
        }
        Ok(state)
    }
}

/// What the kept epoch has least of: the validation loss, and for sub-goals what their codes cost beside it.
pub(super) fn score_of(training: &MotionTraining, row: &MotionRow) -> f32 {
    row.validation + training.weights.kl * row.divergence
}
