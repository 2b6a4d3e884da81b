//! One type for all networks of LTM.

use burn::tensor::{Device, Tensor};

use super::between::{BetweenInput, BetweenNet};
use super::config::{MotionConfig, MotionKind};
use super::points::{Labels, PointNet};
use super::subgoal::SubGoalNet;
use crate::assets::{Weights, WeightsError};
use crate::nn::graph::{Graph, tensor};
use crate::nn::params::{Declaration, Params, Role};
use crate::nn::vae::Posterior;

/// Note under which a weight file keeps its [`MotionConfig`].
const CONFIG_NOTE: &str = "motion_config";
/// PointNet's arrays have names that begin with this, in every network.
pub const POINTS_PREFIX: &str = "points";

/// Points of the room around a leg, in the leg's frame, metres.
pub type Cloud = Vec<[f32; 3]>;

/// What the sub-goal network makes of a batch.
pub struct SubGoalMade {
    /// `[batch, ROW]`.
    pub bodies: Tensor<2>,
    /// q(z | body, condition).
    pub posterior: Posterior,
}

/// Layers without numbers.
#[derive(Clone, Debug)]
pub struct MotionNetwork {
    config: MotionConfig,
    layers: Layers,
}

#[derive(Clone, Debug)]
enum Layers {
    Points(PointNet, Labels),
    SubGoal(SubGoalNet),
    Between(BetweenNet),
}

impl MotionNetwork {
    /// A network and its numbers at the start.
    pub fn declare(config: &MotionConfig, seed: u64) -> (Self, Params) {
        let mut d = Declaration::new(seed);
        let layers = match config.kind {
            MotionKind::Points => Layers::Points(
                PointNet::declare(&mut d, POINTS_PREFIX, &config.points),
                Labels::declare(&mut d, "labels", &config.points),
            ),
            MotionKind::SubGoal => Layers::SubGoal(SubGoalNet::declare(&mut d, config, POINTS_PREFIX)),
            MotionKind::Between(which) => {
                Layers::Between(BetweenNet::declare(&mut d, which, config, POINTS_PREFIX))
            }
        };
        (Self { config: config.clone(), layers }, d.finish())
    }

    /// The network that a weight file holds.
    ///
    /// # Errors
    /// [`WeightsError`] when the file holds another network or no configuration.
    pub fn from_weights(weights: &Weights) -> Result<(Self, Params), WeightsError> {
        let damaged = |cause: String| WeightsError::Damaged { file: weights.file.clone(), cause };
        let note = weights.notes.get(CONFIG_NOTE);
        let text =
            note.ok_or_else(|| damaged("it holds no configuration of a network of motion".to_owned()))?;
        let config: MotionConfig = serde_json::from_str(text).map_err(|e| damaged(e.to_string()))?;
        let (network, mut params) = Self::declare(&config, 0);
        params.load(weights)?;
        Ok((network, params))
    }

    /// Puts the network and its numbers into a weight file.
    pub fn store(&self, params: &Params, weights: &mut Weights) {
        let config = serde_json::to_string(&self.config).unwrap_or_default();
        weights.notes.insert(CONFIG_NOTE.to_owned(), config);
        params.store(weights);
    }

    /// Takes PointNet from a pre-trained network of [`MotionKind::Points`]; nothing changes for a network that sees no
    /// room.
    ///
    /// # Errors
    /// [`WeightsError`] when the file holds none or one of other sizes; then nothing is changed.
    pub fn take_points(params: &mut Params, weights: &Weights) -> Result<(), WeightsError> {
        let mut taken = params.clone();
        for entry in taken.entries_mut() {
            if entry.role == Role::Trained && entry.name.starts_with(&format!("{POINTS_PREFIX}.")) {
                entry.values = weights.values(&entry.name, &entry.shape)?.to_vec();
            }
        }
        *params = taken;
        Ok(())
    }

    /// Its sizes.
    pub fn config(&self) -> &MotionConfig {
        &self.config
    }

    /// Logits of every point, `[batch * points, POINT_CLASSES]`; `None` for a network that labels none.
    pub fn label(&self, g: &Graph, cloud: Tensor<3>) -> Option<Tensor<2>> {
        match &self.layers {
            Layers::Points(net, labels) => Some(labels.forward(g, net.forward(g, cloud))),
            _ => None,
        }
    }

    /// Frames between two bodies, `[batch, 60 * outputs]`; `None` for another network.
    pub fn fill(&self, g: &Graph, input: &BetweenInput) -> Option<Tensor<2>> {
        match &self.layers {
            Layers::Between(net) => Some(net.forward(g, input)),
            _ => None,
        }
    }

    /// Encodes and decodes bodies `[batch, ROW]` under `[batch, CONDITION]` with `noise` `[batch, latent]`; `None` for
    /// another network.
    pub fn reconstruct(
        &self,
        g: &Graph,
        cloud: Option<Tensor<3>>,
        asked: Tensor<2>,
        bodies: Tensor<2>,
        noise: Tensor<2>,
    ) -> Option<SubGoalMade> {
        let Layers::SubGoal(net) = &self.layers else { return None };
        let condition = net.condition(g, cloud, asked);
        let posterior = net.posterior(g, &condition, bodies);
        let bodies = net.decode(g, &condition, posterior.sample(noise));
        Some(SubGoalMade { bodies, posterior })
    }

    /// Bodies `[batch, ROW]` of standard normal `codes` `[batch, latent]`; `None` for another network.
    pub fn sample(
        &self,
        g: &Graph,
        cloud: Option<Tensor<3>>,
        asked: Tensor<2>,
        codes: Tensor<2>,
    ) -> Option<Tensor<2>> {
        let Layers::SubGoal(net) = &self.layers else { return None };
        let condition = net.condition(g, cloud, asked);
        Some(net.decode(g, &condition, codes))
    }

    /// Clouds of one size as a tensor; `None` for a network that sees no room.
    pub fn cloud_tensor(&self, clouds: &[&Cloud], device: &Device) -> Option<Tensor<3>> {
        let count = clouds.first().map_or(0, |cloud| cloud.len());
        let sees = self.config.scene || self.config.kind == MotionKind::Points;
        let numbers = || clouds.iter().flat_map(|cloud| cloud.iter().flatten().copied()).collect();
        (sees && count > 0).then(|| tensor(numbers(), [clouds.len(), count, 3], device))
    }
}
