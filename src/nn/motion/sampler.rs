//! A trained network of LTM, ready for use: plain numbers in and out.

use burn::tensor::Device;

use super::between::BetweenInput;
use super::config::{BETWEEN, CONDITION, MotionConfig, MotionKind, PLACE, POINT_CLASSES, ROW};
use super::network::{Cloud, MotionNetwork};
use crate::assets::{Weights, WeightsError};
use crate::nn::graph::{Graph, Mode, cpu_device, numbers, tensor};
use crate::nn::params::Params;

/// A network with its numbers on this machine's processor. The same input gives the same bytes.
pub struct MotionSampler {
    network: MotionNetwork,
    graph: Graph,
    device: Device,
}

impl MotionSampler {
    /// A sampler of this network.
    pub fn new(network: MotionNetwork, params: &Params) -> Self {
        let device = cpu_device();
        let graph = Graph::new(params, Mode::Infer, &device);
        Self { network, graph, device }
    }

    /// A sampler of the network in a weight file.
    ///
    /// # Errors
    /// [`WeightsError`] when the file holds another network.
    pub fn from_weights(weights: &Weights) -> Result<Self, WeightsError> {
        let (network, params) = MotionNetwork::from_weights(weights)?;
        Ok(Self::new(network, &params))
    }

    /// Its sizes.
    pub fn config(&self) -> &MotionConfig {
        self.network.config()
    }

    /// Frames between each pair of bodies, all in the frame of their cloud: 60 times the columns of
    /// `Between::outputs` each. `routes` (60 * 9 numbers each) are for PoseNet and else empty. Empty for a network of
    /// another kind.
    pub fn between(
        &self,
        clouds: &[&Cloud],
        starts: &[[f32; ROW]],
        ends: &[[f32; ROW]],
        routes: &[Vec<f32>],
    ) -> Vec<Vec<f32>> {
        let MotionKind::Between(which) = self.config().kind else { return Vec::new() };
        let batch = starts.len();
        if batch == 0 {
            return Vec::new();
        }
        let rows = |rows: &[[f32; ROW]]| {
            tensor(rows.iter().flatten().copied().collect(), [batch, ROW], &self.device)
        };
        let route = which.takes_route().then(|| {
            tensor(routes.iter().flatten().copied().collect(), [batch, BETWEEN * PLACE], &self.device)
        });
        let cloud = self.network.cloud_tensor(clouds, &self.device);
        let input = BetweenInput { cloud, start: rows(starts), end: rows(ends), route };
        let made = self.network.fill(&self.graph, &input).map(|made| numbers(&made)).unwrap_or_default();
        made.chunks(BETWEEN * which.outputs().len()).map(<[f32]>::to_vec).collect()
    }

    /// Bodies under one request, one for each `config().latent` of the standard normal `codes`. Empty for a network of
    /// another kind.
    pub fn bodies(&self, cloud: &Cloud, asked: &[f32; CONDITION], codes: &[f32]) -> Vec<[f32; ROW]> {
        let latent = self.config().latent;
        let count = codes.len() / latent;
        if count == 0 || self.config().kind != MotionKind::SubGoal {
            return Vec::new();
        }
        let cloud = self.network.cloud_tensor(&vec![cloud; count], &self.device);
        let asked = tensor(asked.repeat(count), [count, CONDITION], &self.device);
        let codes = tensor(codes[..count * latent].to_vec(), [count, latent], &self.device);
        let made = self.network.sample(&self.graph, cloud, asked, codes);
        let made = made.map(|bodies| numbers(&bodies)).unwrap_or_default();
        made.chunks_exact(ROW).map(|row| std::array::from_fn(|i| row[i])).collect()
    }

    /// Bodies encoded and decoded with the mean code, each under its own request, and the divergence of each
    /// (mean over the latent numbers). Empty for a network of another kind.
    pub fn reconstruct(
        &self,
        clouds: &[&Cloud],
        asked: &[[f32; CONDITION]],
        bodies: &[[f32; ROW]],
    ) -> Vec<([f32; ROW], f32)> {
        let (count, latent) = (bodies.len(), self.config().latent);
        if count == 0 {
            return Vec::new();
        }
        let cloud = self.network.cloud_tensor(clouds, &self.device);
        let asked = tensor(asked.iter().flatten().copied().collect(), [count, CONDITION], &self.device);
        let rows = tensor(bodies.iter().flatten().copied().collect(), [count, ROW], &self.device);
        let noise = tensor(vec![0.0; count * latent], [count, latent], &self.device);
        let Some(made) = self.network.reconstruct(&self.graph, cloud, asked, rows, noise) else {
            return Vec::new();
        };
        let (bodies, divergence) = (numbers(&made.bodies), made.posterior.divergence_of_each());
        let row = |row: &[f32]| std::array::from_fn(|i| row[i]);
        bodies.chunks_exact(ROW).map(row).zip(divergence).collect()
    }

    /// The likeliest class of every point of a cloud. Empty for a network that labels none.
    pub fn labels(&self, cloud: &Cloud) -> Vec<usize> {
        let Some(points) = self.network.cloud_tensor(&[cloud], &self.device) else { return Vec::new() };
        let logits = self.network.label(&self.graph, points).map(|l| numbers(&l)).unwrap_or_default();
        let best = |row: &[f32]| (0..row.len()).max_by(|a, b| row[*a].total_cmp(&row[*b])).unwrap_or(0);
        logits.chunks_exact(POINT_CLASSES).map(best).collect()
    }
}
