//! The whole state of a training: written, read again, it goes on to the bit.

use super::config::PsiTraining;
use super::history::History;
use crate::assets::{Precision, Weights, WeightsError};
use crate::job::Seed;
use crate::math::AdamConfig;
use crate::nn::psi::{Discriminator, PsiMethod, PsiNetwork};
use crate::nn::{NetworkAdam, Params};

const TRAINING_NOTE: &str = "training";
const HISTORY_NOTE: &str = "history";
const EPOCH_NOTE: &str = "epoch";
const STEPS_NOTE: &str = "steps";
const CORPUS_NOTE: &str = "corpus";

/// Why a training can't begin or go on.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// Nobody to learn from.
    #[error(
        "the corpus has no body of the training split that any of its views shows; stage one with `inhabit stage`"
    )]
    NoBodies,
    /// No motion to learn from.
    #[error(
        "the corpus has no clip to learn {what} from: put motion clips of some seconds there (BVH, npz, text)"
    )]
    NoClips {
        /// What should be learnt.
        what: &'static str,
    },
    /// PoseNet is trained with the route that a trained RouteNet gives.
    #[error(
        "PoseNet learns along the routes of a trained RouteNet; train one and name its weights with --route"
    )]
    NoRoute,
    /// The checkpoint is of another training.
    #[error(
        "{file} is a checkpoint of another training ({differs}); give the same settings as then, or begin anew without --resume"
    )]
    OtherTraining {
        /// The checkpoint.
        file: String,
        /// What differs.
        differs: String,
    },
    /// The checkpoint can't be read.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// The scene loss has no distance fields.
    #[error(
        "the scene loss needs the distance field of each room of the corpus, {found} of {needed} are there"
    )]
    NoFields {
        /// Fields given.
        found: usize,
        /// Rooms.
        needed: usize,
    },
    /// The loss is no number any more.
    #[error("the loss of epoch {epoch} is not finite; begin again with a smaller --rate")]
    Diverged {
        /// The epoch, from 1.
        epoch: usize,
    },
}

/// A network with its optimiser.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::learn) struct Trained {
    pub params: Params,
    pub adam: NetworkAdam,
}

/// Everything that a training carries from epoch to epoch.
#[derive(Clone, Debug)]
pub struct TrainingState {
    /// The settings.
    pub training: PsiTraining,
    /// What the corpus was.
    pub corpus: String,
    /// Epochs done.
    pub epoch: usize,
    /// How it went.
    pub history: History,
    pub(super) network: PsiNetwork,
    pub(super) main: Trained,
    /// The baseline's.
    pub(super) discriminator: Option<(Discriminator, Trained)>,
}

impl TrainingState {
    /// Before the first epoch.
    pub fn new(training: PsiTraining, corpus: String) -> Self {
        let seed = Seed::root(training.seed);
        let (network, params) = PsiNetwork::declare(&training.network, seed.child("weights", 0).value());
        let config = AdamConfig { learning_rate: training.learning_rate, ..AdamConfig::default() };
        let adam = NetworkAdam::new(&params, config);
        let discriminator = (training.network.method == PsiMethod::Baseline).then(|| {
            let (layers, params) = Discriminator::declare(seed.child("discriminator", 0).value());
            let adam = NetworkAdam::new(&params, config);
            (layers, Trained { params, adam })
        });
        let main = Trained { params, adam };
        Self { training, corpus, epoch: 0, history: History::default(), network, main, discriminator }
    }

    /// The network's numbers.
    pub fn params(&self) -> &Params {
        &self.main.params
    }

    /// The network without its numbers.
    pub fn network(&self) -> &PsiNetwork {
        &self.network
    }

    /// The bytes of a checkpoint.
    ///
    /// # Errors
    /// [`WeightsError`] when it can't be put together.
    pub fn checkpoint(&self) -> Result<Vec<u8>, WeightsError> {
        let mut weights = self.described("checkpoint");
        self.main.params.store(&mut weights);
        self.main.adam.store("adam", &self.main.params, &mut weights);
        if let Some((_, trained)) = &self.discriminator {
            trained.params.store(&mut weights);
            trained.adam.store("adam", &trained.params, &mut weights);
        }
        weights.to_bytes(Precision::Full)
    }

    /// The finished network as it ships: numbers of half precision and notes on where they come from.
    ///
    /// # Errors
    /// [`WeightsError`] when it can't be put together.
    pub fn weights(&self) -> Result<Vec<u8>, WeightsError> {
        let mut weights = self.described("weights");
        self.network.store(&self.main.params, &mut weights);
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
            (CORPUS_NOTE, self.corpus.clone()),
        ] {
            weights.notes.insert(note.to_owned(), text);
        }
        weights
    }

    /// The state that [`TrainingState::checkpoint`] wrote, to go on with `training` on `corpus`.
    ///
    /// # Errors
    /// [`TrainError`] when the checkpoint is of another training or damaged.
    pub fn resume(training: PsiTraining, corpus: String, weights: &Weights) -> Result<Self, TrainError> {
        let before: PsiTraining = note(weights, TRAINING_NOTE)?;
        let epoch: usize = note(weights, EPOCH_NOTE)?;
        let steps: u64 = note(weights, STEPS_NOTE)?;
        let other = |differs: &str| TrainError::OtherTraining {
            file: weights.file.clone(),
            differs: differs.to_owned(),
        };
        if !training.continues(&before, epoch) {
            return Err(other("its settings differ"));
        }
        if weights.notes.get(CORPUS_NOTE) != Some(&corpus) {
            return Err(other("its corpus differs"));
        }
        let mut state = Self::new(training, corpus);
        state.epoch = epoch;
        state.history = note(weights, HISTORY_NOTE)?;
        state.main.load(weights, steps)?;
        if let Some((_, trained)) = &mut state.discriminator {
            trained.load(weights, steps)?;
        }
        Ok(state)
    }
}

impl Trained {
    /// Takes numbers and optimiser's state of a checkpoint.
    pub fn load(&mut self, weights: &Weights, steps: u64) -> Result<(), WeightsError> {
        self.params.load(weights)?;
        self.adam.load("adam", &self.params, weights, steps)
    }
}

/// A note of a checkpoint, from JSON.
pub(in crate::learn) fn note<T: serde::de::DeserializeOwned>(
    weights: &Weights,
    name: &str,
) -> Result<T, WeightsError> {
    let damaged = |cause: String| WeightsError::Damaged { file: weights.file.clone(), cause };
    let text = weights.notes.get(name).ok_or_else(|| damaged(format!("it has no note `{name}`")))?;
    serde_json::from_str(text).map_err(|e| damaged(format!("its note `{name}`: {e}")))
}
