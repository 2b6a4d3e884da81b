//! S1: the whole body from one code (PSI fig. 2, above).

use burn::tensor::Tensor;

use super::config::{BODY, PsiConfig};
use super::input::SceneTensors;
use super::network::Reconstruction;
use super::trunk::SceneEncoder;
use crate::nn::graph::Graph;
use crate::nn::layers::{Linear, ResPair};
use crate::nn::params::Declaration;
use crate::nn::vae::PosteriorHead;

/// The one-stage network.
#[derive(Clone, Debug)]
pub(super) struct S1 {
    scene: SceneEncoder,
    body: Linear,
    encoder: ResPair,
    posterior: PosteriorHead,
    code: Linear,
    decoder: ResPair,
    out: Linear,
}

impl S1 {
    pub fn declare(d: &mut Declaration, config: &PsiConfig) -> Self {
        let (lift, latent) = (config.lift, config.latent);
        Self {
            scene: SceneEncoder::declare(d, "scene", config, config.head_channels),
            body: Linear::declare(d, "body", BODY, lift),
            encoder: ResPair::declare(d, "encoder", 2 * lift),
            posterior: PosteriorHead::declare(d, "posterior", 2 * lift, latent),
            code: Linear::declare(d, "code", latent, lift),
            decoder: ResPair::declare(d, "decoder", 2 * lift),
            out: Linear::declare(d, "out", 2 * lift, BODY),
        }
    }

    pub fn encode_scene(&self, g: &Graph, scenes: &SceneTensors) -> Vec<Tensor<2>> {
        vec![self.scene.forward(g, scenes)]
    }

    pub fn reconstruct(
        &self,
        g: &Graph,
        features: &[Tensor<2>],
        bodies: Tensor<2>,
        noise: Tensor<2>,
    ) -> Reconstruction {
        let lifted = Tensor::cat(vec![features[0].clone(), self.body.forward(g, bodies)], 1);
        let posterior = self.posterior.forward(g, self.encoder.forward(g, lifted));
        let body = self.decode(g, features, posterior.sample(noise));
        Reconstruction { body, posteriors: vec![posterior], class_logits: None }
    }

    pub fn decode(&self, g: &Graph, features: &[Tensor<2>], code: Tensor<2>) -> Tensor<2> {
        let lifted = Tensor::cat(vec![self.code.forward(g, code), features[0].clone()], 1);
        self.out.forward(g, self.decoder.forward(g, lifted))
    }
}
