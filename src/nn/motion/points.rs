//! PointNet (Qi et al. 2017) as LTM §3.2 changes it: no learnt transformations, so that points stay in the leg's frame.

use burn::tensor::Tensor;
use burn::tensor::activation::relu;

use super::config::{POINT_CLASSES, PointNetConfig};
use crate::nn::graph::Graph;
use crate::nn::layers::Linear;
use crate::nn::params::Declaration;

/// Instance normalisation's smallest variance (PyTorch's default).
const EPSILON: f64 = 1e-5;
/// Width of the labelling head.
const HEAD: usize = 64;

/// Points to one feature: three layers shared by all points, each normalised over the cloud, then the largest of each
/// number.
#[derive(Clone, Debug)]
pub(super) struct PointNet {
    layers: [Linear; 3],
    channels: [usize; 3],
}

/// A cloud's features.
pub(super) struct PointFeatures {
    /// Of each point after the first layer, `[batch, points, channels 0]`.
    pub each: Tensor<3>,
    /// Of the whole, `[batch, channels 2]`.
    pub whole: Tensor<2>,
}

impl PointNet {
    pub fn declare(d: &mut Declaration, name: &str, config: &PointNetConfig) -> Self {
        let [a, b, c] = config.channels;
        let sizes = [(3, a), (a, b), (b, c)];
        let layer = |i: usize| (format!("{name}.{i}"), sizes[i]);
        let layers = [0, 1, 2].map(layer).map(|(name, (from, to))| Linear::declare(d, &name, from, to));
        Self { layers, channels: config.channels }
    }

    /// `[batch, points, 3]` metres to features.
    pub fn forward(&self, g: &Graph, cloud: Tensor<3>) -> PointFeatures {
        let each = relu(self.layer(g, 0, cloud));
        let second = relu(self.layer(g, 1, each.clone()));
        let third = self.layer(g, 2, second);
        let [batch, _, channels] = third.dims();
        PointFeatures { each, whole: third.max_dim(1).reshape([batch, channels]) }
    }

    fn layer(&self, g: &Graph, layer: usize, x: Tensor<3>) -> Tensor<3> {
        let [batch, points, inputs] = x.dims();
        let flat = self.layers[layer].forward(g, x.reshape([batch * points, inputs]));
        normalised(flat.reshape([batch, points, self.channels[layer]]))
    }
}

/// Every channel of every cloud with mean 0 and variance 1.
fn normalised(x: Tensor<3>) -> Tensor<3> {
    let centred = x.clone() - x.mean_dim(1);
    let variance = centred.clone().square().mean_dim(1);
    centred / (variance + EPSILON).sqrt()
}

/// Labels of points, for pre-training.
#[derive(Clone, Debug)]
pub(super) struct Labels {
    first: Linear,
    out: Linear,
}

impl Labels {
    pub fn declare(d: &mut Declaration, name: &str, config: &PointNetConfig) -> Self {
        let inputs = config.channels[0] + config.channels[2];
        Self {
            first: Linear::declare(d, &format!("{name}.0"), inputs, HEAD),
            out: Linear::declare(d, &format!("{name}.1"), HEAD, POINT_CLASSES),
        }
    }

    /// `[batch * points, POINT_CLASSES]` logits.
    pub fn forward(&self, g: &Graph, features: PointFeatures) -> Tensor<2> {
        let [batch, points, own] = features.each.dims();
        let shared = features.whole.dims()[1];
        let whole = features.whole.reshape([batch, 1, shared]).repeat_dim(1, points);
        let both = Tensor::cat(vec![features.each, whole], 2).reshape([batch * points, own + shared]);
        self.out.forward(g, relu(self.first.forward(g, both)))
    }
}
