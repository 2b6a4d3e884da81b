//! S2: first the translation, then all the rest given the translation (PSI fig. 2, below).

use burn::tensor::Tensor;

use super::config::{BODY, GLOBAL, LOCAL, PsiConfig};
use super::input::SceneTensors;
use super::network::Reconstruction;
use super::trunk::SceneEncoder;
use crate::nn::graph::Graph;
use crate::nn::layers::{Linear, ResPair};
use crate::nn::params::Declaration;
use crate::nn::vae::{Posterior, PosteriorHead};

/// The two-stage network.
#[derive(Clone, Debug)]
pub(super) struct S2 {
    global: Global,
    local: Local,
    latent: usize,
}

#[derive(Clone, Debug)]
struct Global {
    scene: SceneEncoder,
    lift: Linear,
    encoder: ResPair,
    posterior: PosteriorHead,
    code: Linear,
    decoder: ResPair,
    out: Linear,
}

#[derive(Clone, Debug)]
struct Local {
    scene: SceneEncoder,
    global: Linear,
    lift: Linear,
    encoder: ResPair,
    posterior: PosteriorHead,
    code: Linear,
    decoder: ResPair,
    out: Linear,
}

impl S2 {
    pub fn declare(d: &mut Declaration, config: &PsiConfig) -> Self {
        let (lift, latent) = (config.lift, config.latent);
        let (where_to, how) = (config.global_decoder, config.local_decoder);
        let global = Global {
            scene: SceneEncoder::declare(d, "global.scene", config, config.head_channels),
            lift: Linear::declare(d, "global.translation", GLOBAL, lift),
            encoder: ResPair::declare(d, "global.encoder", 2 * lift),
            posterior: PosteriorHead::declare(d, "global.posterior", 2 * lift, latent),
            code: Linear::declare(d, "global.code", lift + latent, where_to),
            decoder: ResPair::declare(d, "global.decoder", where_to),
            out: Linear::declare(d, "global.out", where_to, GLOBAL),
        };
        let local = Local {
            scene: SceneEncoder::declare(d, "local.scene", config, config.local_head_channels),
            global: Linear::declare(d, "local.translation", GLOBAL, lift),
            lift: Linear::declare(d, "local.body", LOCAL, lift),
            encoder: ResPair::declare(d, "local.encoder", 3 * lift),
            posterior: PosteriorHead::declare(d, "local.posterior", 3 * lift, latent),
            code: Linear::declare(d, "local.code", 2 * lift + latent, how),
            decoder: ResPair::declare(d, "local.decoder", how),
            out: Linear::declare(d, "local.out", how, LOCAL),
        };
        Self { global, local, latent }
    }

    pub fn encode_scene(&self, g: &Graph, scenes: &SceneTensors) -> Vec<Tensor<2>> {
        vec![self.global.scene.forward(g, scenes), self.local.scene.forward(g, scenes)]
    }

    pub fn reconstruct(
        &self,
        g: &Graph,
        features: &[Tensor<2>],
        bodies: Tensor<2>,
        noise: Tensor<2>,
    ) -> Reconstruction {
        let (for_global, for_local) = self.split_noise(noise);
        let given = bodies.clone().narrow(1, 0, GLOBAL);
        let where_to = self.global.posterior(g, &features[0], given);
        let global = self.global.decode(g, &features[0], where_to.sample(for_global));
        let how = self.local.posterior(g, &features[1], &global, bodies.narrow(1, GLOBAL, LOCAL));
        let local = self.local.decode(g, &features[1], &global, how.sample(for_local));
        let body = Tensor::cat(vec![global, local], 1);
        debug_assert_eq!(body.dims()[1], BODY);
        Reconstruction { body, posteriors: vec![where_to, how], class_logits: None }
    }

    pub fn decode(&self, g: &Graph, features: &[Tensor<2>], codes: Tensor<2>) -> Tensor<2> {
        let (for_global, for_local) = self.split_noise(codes);
        let global = self.global.decode(g, &features[0], for_global);
        let local = self.local.decode(g, &features[1], &global, for_local);
        Tensor::cat(vec![global, local], 1)
    }

    fn split_noise(&self, noise: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        (noise.clone().narrow(1, 0, self.latent), noise.narrow(1, self.latent, self.latent))
    }
}

impl Global {
    fn posterior(&self, g: &Graph, scene: &Tensor<2>, global: Tensor<2>) -> Posterior {
        let lifted = Tensor::cat(vec![scene.clone(), self.lift.forward(g, global)], 1);
        self.posterior.forward(g, self.encoder.forward(g, lifted))
    }

    fn decode(&self, g: &Graph, scene: &Tensor<2>, code: Tensor<2>) -> Tensor<2> {
        let lifted = self.code.forward(g, Tensor::cat(vec![code, scene.clone()], 1));
        self.out.forward(g, self.decoder.forward(g, lifted))
    }
}

impl Local {
    fn posterior(&self, g: &Graph, scene: &Tensor<2>, global: &Tensor<2>, local: Tensor<2>) -> Posterior {
        let place = self.global.forward(g, global.clone());
        let lifted = Tensor::cat(vec![scene.clone(), place, self.lift.forward(g, local)], 1);
        self.posterior.forward(g, self.encoder.forward(g, lifted))
    }

    fn decode(&self, g: &Graph, scene: &Tensor<2>, global: &Tensor<2>, code: Tensor<2>) -> Tensor<2> {
        let place = self.global.forward(g, global.clone());
        let lifted = self.code.forward(g, Tensor::cat(vec![code, scene.clone(), place], 1));
        self.out.forward(g, self.decoder.forward(g, lifted))
    }
}
