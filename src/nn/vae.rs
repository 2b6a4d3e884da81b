//! The variational part that the networks of PSI and of LTM share.

use burn::tensor::Tensor;

use super::graph::{Graph, numbers};
use super::layers::Linear;
use super::params::Declaration;

/// The distribution q(z | body, scene) of each body of a batch: `[batch, latent]` each.
#[derive(Clone)]
pub struct Posterior {
    /// Mean.
    pub mean: Tensor<2>,
    /// Logarithm of the variance.
    pub log_variance: Tensor<2>,
}

impl Posterior {
    /// A code: mean + deviation * noise (the re-parameterisation of Kingma and Welling 2014).
    pub fn sample(&self, noise: Tensor<2>) -> Tensor<2> {
        self.mean.clone() + (self.log_variance.clone() * 0.5).exp() * noise
    }

    /// KL divergence from the standard normal, mean over bodies and latent numbers, as the published code:
    /// one number.
    pub fn divergence(&self) -> Tensor<1> {
        let lv = self.log_variance.clone();
        ((lv.clone().exp() + self.mean.clone().square() - lv - 1.0) * 0.5).mean()
    }

    /// The same of each body, mean over its latent numbers.
    pub fn divergence_of_each(&self) -> Vec<f32> {
        let lv = self.log_variance.clone();
        let each = (lv.clone().exp() + self.mean.clone().square() - lv - 1.0) * 0.5;
        numbers(&each.mean_dim(1))
    }
}

/// Two matrices that give a [`Posterior`].
#[derive(Clone, Copy, Debug)]
pub(super) struct PosteriorHead {
    mean: Linear,
    log_variance: Linear,
}

impl PosteriorHead {
    pub fn declare(d: &mut Declaration, name: &str, width: usize, latent: usize) -> Self {
        Self {
            mean: Linear::declare(d, &format!("{name}.mean"), width, latent),
            log_variance: Linear::declare(d, &format!("{name}.log_variance"), width, latent),
        }
    }

    pub fn forward(&self, g: &Graph, x: Tensor<2>) -> Posterior {
        Posterior { mean: self.mean.forward(g, x.clone()), log_variance: self.log_variance.forward(g, x) }
    }
}
