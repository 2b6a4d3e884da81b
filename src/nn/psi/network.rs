//! One type for the three networks.

use burn::tensor::{Device, Tensor};

use super::baseline::Baseline;
use super::config::{BODY, PsiConfig, PsiMethod};
use super::input::{SceneInput, SceneTensors};
use super::s1::S1;
use super::s2::S2;
use crate::assets::{Weights, WeightsError};
use crate::nn::graph::{Graph, Mode, cpu_device, numbers, tensor};
use crate::nn::params::{Declaration, Params};
use crate::nn::vae::Posterior;

/// Note under which a weight file keeps its [`PsiConfig`].
pub const CONFIG_NOTE: &str = "config";

/// What a network makes of the bodies of a batch.
pub struct Reconstruction {
    /// `[batch, 75]`: translation normalised by π, all else as it is, camera frame.
    pub body: Tensor<2>,
    /// One for each stage.
    pub posteriors: Vec<Posterior>,
    /// The baseline's guess of the pose class, `[batch, classes]`, and the truth, one-hot.
    pub class_logits: Option<(Tensor<2>, Tensor<2>)>,
}

/// S1, S2 or the baseline: layers without numbers.
#[derive(Clone, Debug)]
pub struct PsiNetwork {
    config: PsiConfig,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    S1(S1),
    S2(S2),
    Baseline(Baseline),
}

impl PsiNetwork {
    /// A network and its numbers at the start.
    pub fn declare(config: &PsiConfig, seed: u64) -> (Self, Params) {
        let mut d = Declaration::new(seed);
        let kind = match config.method {
            PsiMethod::S1 => Kind::S1(S1::declare(&mut d, config)),
            PsiMethod::S2 => Kind::S2(S2::declare(&mut d, config)),
            PsiMethod::Baseline => Kind::Baseline(Baseline::declare(&mut d, config)),
        };
        (Self { config: config.clone(), kind }, d.finish())
    }

    /// The network that a weight file holds.
    ///
    /// # Errors
    /// [`WeightsError`] when the file holds another network or no configuration.
    pub fn from_weights(weights: &Weights) -> Result<(Self, Params), WeightsError> {
        let damaged = |cause: String| WeightsError::Damaged { file: weights.file.clone(), cause };
        let note = weights.notes.get(CONFIG_NOTE);
        let text = note.ok_or_else(|| damaged("it holds no configuration of a network of PSI".to_owned()))?;
        let config: PsiConfig = serde_json::from_str(text).map_err(|e| damaged(e.to_string()))?;
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

    /// Its sizes.
    pub fn config(&self) -> &PsiConfig {
        &self.config
    }

    /// Sets the middles of the baseline's pose classes, `classes * 32` numbers; others have none.
    pub fn set_pose_centres(&self, params: &mut Params, centres: Vec<f32>) {
        if let Kind::Baseline(baseline) = &self.kind {
            baseline.set_centres(params, centres);
        }
    }

    /// The middles of the baseline's pose classes.
    pub fn pose_centres<'a>(&self, params: &'a Params) -> Option<&'a [f32]> {
        match &self.kind {
            Kind::Baseline(baseline) => Some(baseline.centres(params)),
            _ => None,
        }
    }

    /// One vector `[batch, lift]` for each trunk.
    pub fn encode_scene(&self, g: &Graph, scenes: &SceneTensors) -> Vec<Tensor<2>> {
        match &self.kind {
            Kind::S1(net) => net.encode_scene(g, scenes),
            Kind::S2(net) => net.encode_scene(g, scenes),
            Kind::Baseline(net) => net.encode_scene(g, scenes),
        }
    }

    /// Encodes and decodes bodies `[batch, 75]` (translation normalised) with `noise`
    /// `[batch, config.noise()]`, in scenes encoded by [`PsiNetwork::encode_scene`].
    pub fn reconstruct(
        &self,
        g: &Graph,
        features: &[Tensor<2>],
        bodies: Tensor<2>,
        noise: Tensor<2>,
    ) -> Reconstruction {
        match &self.kind {
            Kind::S1(net) => net.reconstruct(g, features, bodies, noise),
            Kind::S2(net) => net.reconstruct(g, features, bodies, noise),
            Kind::Baseline(net) => net.reconstruct(g, features, bodies, noise),
        }
    }

    /// Bodies `[batch, 75]` (translation normalised) of standard normal codes `[batch, config.noise()]`.
    pub fn decode(&self, g: &Graph, features: &[Tensor<2>], codes: Tensor<2>) -> Tensor<2> {
        match &self.kind {
            Kind::S1(net) => net.decode(g, features, codes),
            Kind::S2(net) => net.decode(g, features, codes),
            Kind::Baseline(net) => net.decode(g, features, codes),
        }
    }
}

/// What evaluation needs of one body: reconstruction with the mean code, and the divergence.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstructed {
    /// The body, camera frame, translation in metres.
    pub body: [f32; BODY],
    /// KL divergence of all stages, mean over the latent numbers of each, as in training.
    pub divergence: f32,
}

/// A trained network, ready to sample on this machine's processor: plain numbers in and out.
pub struct PsiSampler {
    network: PsiNetwork,
    graph: Graph,
    device: Device,
}

impl PsiSampler {
    /// A sampler of this network.
    pub fn new(network: PsiNetwork, params: &Params) -> Self {
        let device = cpu_device();
        let graph = Graph::new(params, Mode::Infer, &device);
        Self { network, graph, device }
    }

    /// A sampler of the network in a weight file.
    ///
    /// # Errors
    /// [`WeightsError`] when the file holds another network.
    pub fn from_weights(weights: &Weights) -> Result<Self, WeightsError> {
        let (network, params) = PsiNetwork::from_weights(weights)?;
        Ok(Self::new(network, &params))
    }

    /// Its sizes.
    pub fn config(&self) -> &PsiConfig {
        self.network.config()
    }

    /// Bodies for one scene from standard normal `codes`, `config().noise()` numbers each: camera frame,
    /// translation in metres. The same codes give the same bytes.
    pub fn decode(&self, scene: &SceneInput, codes: &[f32]) -> Vec<[f32; BODY]> {
        let noise = self.config().noise();
        let count = codes.len() / noise;
        if count == 0 {
            return Vec::new();
        }
        let scenes = SceneTensors::new(self.config(), &[scene], &self.device);
        let features: Vec<Tensor<2>> = self
            .network
            .encode_scene(&self.graph, &scenes)
            .into_iter()
            .map(|f| f.repeat_dim(0, count))
            .collect();
        let codes = tensor(codes[..count * noise].to_vec(), [count, noise], &self.device);
        let bodies = numbers(&self.network.decode(&self.graph, &features, codes));
        bodies.chunks(BODY).map(|body| in_metres(scene, body)).collect()
    }

    /// Encodes bodies (camera frame, metres), each in its scene, and decodes the mean of each posterior.
    pub fn reconstruct(&self, scenes: &[&SceneInput], bodies: &[[f32; BODY]]) -> Vec<Reconstructed> {
        let count = bodies.len().min(scenes.len());
        if count == 0 {
            return Vec::new();
        }
        let scene_tensors = SceneTensors::new(self.config(), &scenes[..count], &self.device);
        let given: Vec<f32> = scenes.iter().zip(bodies).flat_map(|(s, b)| normalized(s, b)).collect();
        let given = tensor(given, [count, BODY], &self.device);
        let noise =
            tensor(vec![0.0; count * self.config().noise()], [count, self.config().noise()], &self.device);
        let features = self.network.encode_scene(&self.graph, &scene_tensors);
        let made = self.network.reconstruct(&self.graph, &features, given, noise);
        let divergences: Vec<Vec<f32>> = made.posteriors.iter().map(Posterior::divergence_of_each).collect();
        let bodies = numbers(&made.body);
        let body = |i: usize| in_metres(scenes[i], &bodies[i * BODY..(i + 1) * BODY]);
        let divergence = |i: usize| divergences.iter().map(|stage| stage[i]).sum();
        (0..count).map(|i| Reconstructed { body: body(i), divergence: divergence(i) }).collect()
    }
}

/// A body with its translation normalised by the scene's π.
pub fn normalized(scene: &SceneInput, body: &[f32; BODY]) -> [f32; BODY] {
    let mut x = *body;
    x[..3].copy_from_slice(&scene.normalize([body[0], body[1], body[2]]));
    x
}

fn in_metres(scene: &SceneInput, body: &[f32]) -> [f32; BODY] {
    let mut x: [f32; BODY] = std::array::from_fn(|i| body[i]);
    x[..3].copy_from_slice(&scene.denormalize([body[0], body[1], body[2]]));
    x
}
