//! Bodies at sub-goals: a conditional variational auto-encoder (LTM §3.2, fig. 3a).

use burn::tensor::Tensor;
use burn::tensor::activation::relu;

use super::config::{CONDITION, MotionConfig, ROW};
use super::points::PointNet;
use crate::nn::graph::Graph;
use crate::nn::layers::{Linear, ResPair};
use crate::nn::params::Declaration;
use crate::nn::vae::{Posterior, PosteriorHead};

#[derive(Clone, Debug)]
pub(super) struct SubGoalNet {
    scene: Option<PointNet>,
    condition: [Linear; 2],
    body: Linear,
    encoder: ResPair,
    posterior: PosteriorHead,
    code: Linear,
    decoder: ResPair,
    out: Linear,
}

impl SubGoalNet {
    /// The condition takes two matrices: with one the published sizes add up to 8.8 M numbers, with two to the 9.0 M
    /// that they are said to be.
    pub fn declare(d: &mut Declaration, config: &MotionConfig, points: &str) -> Self {
        let MotionConfig { lift, latent, .. } = *config;
        let scene = config.scene.then(|| PointNet::declare(d, points, &config.points));
        let inputs = CONDITION + if scene.is_some() { config.points.channels[2] } else { 0 };
        Self {
            scene,
            condition: [
                Linear::declare(d, "condition.0", inputs, lift),
                Linear::declare(d, "condition.1", lift, lift),
            ],
            body: Linear::declare(d, "body", ROW, lift),
            encoder: ResPair::declare(d, "encoder", 2 * lift),
            posterior: PosteriorHead::declare(d, "posterior", 2 * lift, latent),
            code: Linear::declare(d, "code", latent, lift),
            decoder: ResPair::declare(d, "decoder", 2 * lift),
            out: Linear::declare(d, "out", 2 * lift, ROW),
        }
    }

    /// F^hs: `[batch, lift]` of the room's points and `[batch, CONDITION]`.
    pub fn condition(&self, g: &Graph, cloud: Option<Tensor<3>>, asked: Tensor<2>) -> Tensor<2> {
        let given = match self.scene.as_ref().zip(cloud) {
            Some((net, cloud)) => Tensor::cat(vec![net.forward(g, cloud).whole, asked], 1),
            None => asked,
        };
        self.condition[1].forward(g, relu(self.condition[0].forward(g, given)))
    }

    /// q(z | body, condition).
    pub fn posterior(&self, g: &Graph, condition: &Tensor<2>, bodies: Tensor<2>) -> Posterior {
        let both = Tensor::cat(vec![self.body.forward(g, bodies), condition.clone()], 1);
        self.posterior.forward(g, self.encoder.forward(g, both))
    }

    /// `[batch, ROW]` of codes `[batch, latent]`.
    pub fn decode(&self, g: &Graph, condition: &Tensor<2>, codes: Tensor<2>) -> Tensor<2> {
        let both = Tensor::cat(vec![self.code.forward(g, codes), condition.clone()], 1);
        self.out.forward(g, self.decoder.forward(g, both))
    }
}
