//! Eq. 1 to 5 of PSI as tensors, and the way into the graph for gradients that were derived by hand.

use burn::tensor::activation::{log_softmax, softplus};
use burn::tensor::{Device, Tensor};

use crate::nn::psi::{BODY, GLOBAL, LOCAL, POSE_CODE, Posterior, Reconstruction, SceneInput};
use crate::nn::{numbers, tensor};

/// Where the pose code starts among the 75 numbers.
const POSE_START: usize = 19;
/// Keeps the division by depth finite, metres (as in π).
const EPSILON_M: f32 = 1e-6;

/// The bodies of a batch as tensors.
pub(super) struct Target {
    /// `[batch, 75]`, translation normalised by π.
    pub normalized: Tensor<2>,
    /// `[batch, 75]`, translation in metres.
    pub metres: Tensor<2>,
    /// `[batch, 1]` each: largest depth and focal length of π.
    max_depth_m: Tensor<2>,
    focal: Tensor<2>,
}

impl Target {
    pub fn new(scenes: &[&SceneInput], bodies: &[[f32; BODY]], device: &Device) -> Self {
        let batch = bodies.len();
        let normalized = scenes.iter().zip(bodies).flat_map(|(s, b)| crate::nn::psi::normalized(s, b));
        let column = |value: &dyn Fn(&SceneInput) -> f32| {
            tensor(scenes.iter().map(|s| value(s)).collect(), [batch, 1], device)
        };
        Self {
            normalized: tensor(normalized.collect(), [batch, BODY], device),
            metres: tensor(bodies.iter().flatten().copied().collect(), [batch, BODY], device),
            max_depth_m: column(&|s| s.max_depth_m),
            focal: column(&|s| s.focal),
        }
    }

    /// π⁻¹ of the network's output: `[batch, 75]` with the translation in metres.
    pub fn in_metres(&self, body: &Tensor<2>) -> Tensor<2> {
        let z = (body.clone().narrow(1, 2, 1) + 1.0) * 0.5 * self.max_depth_m.clone();
        let per_unit = (z.clone() + EPSILON_M) / self.focal.clone();
        let xy = body.clone().narrow(1, 0, 2) * per_unit;
        Tensor::cat(vec![xy, z, body.clone().narrow(1, GLOBAL, LOCAL)], 1)
    }

    /// Eq. 2, means as in the published code.
    pub fn reconstruction(&self, body: &Tensor<2>, in_metres: &Tensor<2>) -> Tensor<1> {
        let off = |a: &Tensor<2>, b: &Tensor<2>, start: usize, count: usize| {
            (a.clone().narrow(1, start, count) - b.clone().narrow(1, start, count)).abs().mean()
        };
        let global = off(body, &self.normalized, 0, GLOBAL) + off(in_metres, &self.metres, 0, GLOBAL);
        global * 0.5 + off(body, &self.normalized, GLOBAL, LOCAL)
    }
}

/// Eq. 3 and 4: the stages' divergences, summed.
pub(super) fn divergence(made: &Reconstruction, device: &Device) -> Tensor<1> {
    let stages = made.posteriors.iter().map(Posterior::divergence);
    stages.reduce(|a, b| a + b).unwrap_or_else(|| Tensor::zeros([1], device))
}

/// Eq. 5 as coded: mean squared pose code.
pub(super) fn pose_prior(body: &Tensor<2>) -> Tensor<1> {
    body.clone().narrow(1, POSE_START, POSE_CODE).square().mean()
}

/// Cross-entropy of the baseline's pose class; zero for networks without classes.
pub(super) fn class(made: &Reconstruction, device: &Device) -> Tensor<1> {
    match &made.class_logits {
        None => Tensor::zeros([1], device),
        Some((logits, truth)) => {
            let batch = truth.dims()[0] as f32;
            (log_softmax(logits.clone(), 1) * truth.clone()).sum() / -batch
        }
    }
}

/// A term whose gradient with respect to `x` is `gradient`, row by row: `Σ x · gradient` with the gradient
/// held fixed. Its value means nothing.
pub(in crate::learn) fn with_gradient(x: &Tensor<2>, gradient: Vec<f32>) -> Tensor<1> {
    let fixed = tensor(gradient, x.dims(), &x.device());
    (x.clone() * fixed).sum()
}

/// Binary cross-entropy of logits `[batch, 1]` that should all be `real`.
pub(super) fn adversarial(logits: Tensor<2>, real: bool) -> Tensor<1> {
    let wrong = if real { -logits } else { logits };
    softplus(wrong, 1.0).mean()
}

/// A tensor's one number.
pub(in crate::learn) fn value(of: &Tensor<1>) -> f32 {
    numbers(of)[0]
}
