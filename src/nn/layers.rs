//! Layers: each declares its numbers once and then maps tensors.

use burn::tensor::Tensor;
use burn::tensor::activation::{leaky_relu, relu};
use burn::tensor::module;
use burn::tensor::ops::{ConvOptions, MaxPoolOptions};

use super::graph::{Graph, Mode};
use super::params::{Declaration, Init, ParamId, Role};

/// Slope of the papers' leaky ReLU for negative inputs (PyTorch's default).
pub const LEAKY_SLOPE: f64 = 0.01;
/// Batch normalisation's share of the new batch in its running statistics (PyTorch's default).
const MOMENTUM: f64 = 0.1;
/// Batch normalisation's smallest variance (PyTorch's default).
const EPSILON: f64 = 1e-5;

/// `y = x W + b`.
#[derive(Clone, Copy, Debug)]
pub struct Linear {
    weight: ParamId,
    bias: ParamId,
}

impl Linear {
    /// Even start within 1/sqrt(inputs), PyTorch's default, which the published code keeps.
    pub fn declare(d: &mut Declaration, name: &str, inputs: usize, outputs: usize) -> Self {
        let init = Init::Uniform(1.0 / (inputs as f32).sqrt());
        Self {
            weight: d.add(&format!("{name}.weight"), &[inputs, outputs], init, Role::Trained),
            bias: d.add(&format!("{name}.bias"), &[outputs], init, Role::Trained),
        }
    }

    /// `[batch, inputs]` to `[batch, outputs]`.
    pub fn forward(&self, g: &Graph, x: Tensor<2>) -> Tensor<2> {
        module::linear(x, g.param::<2>(self.weight), Some(g.param::<1>(self.bias)))
    }
}

/// A fully connected residual block of the papers: `x + lrelu(fc2(lrelu(fc1(x))))`.
#[derive(Clone, Copy, Debug)]
pub struct ResBlock {
    first: Linear,
    second: Linear,
}

impl ResBlock {
    /// A block of `width` numbers.
    pub fn declare(d: &mut Declaration, name: &str, width: usize) -> Self {
        Self {
            first: Linear::declare(d, &format!("{name}.fc1"), width, width),
            second: Linear::declare(d, &format!("{name}.fc2"), width, width),
        }
    }

    /// `[batch, width]` to the same.
    pub fn forward(&self, g: &Graph, x: Tensor<2>) -> Tensor<2> {
        let inner = leaky_relu(self.first.forward(g, x.clone()), LEAKY_SLOPE);
        x + leaky_relu(self.second.forward(g, inner), LEAKY_SLOPE)
    }
}

/// Two residual blocks, which the papers always use in pairs.
#[derive(Clone, Copy, Debug)]
pub struct ResPair([ResBlock; 2]);

impl ResPair {
    /// Two blocks of `width` numbers.
    pub fn declare(d: &mut Declaration, name: &str, width: usize) -> Self {
        Self([0, 1].map(|i| ResBlock::declare(d, &format!("{name}.{i}"), width)))
    }

    /// `[batch, width]` to the same.
    pub fn forward(&self, g: &Graph, x: Tensor<2>) -> Tensor<2> {
        self.0.iter().fold(x, |x, block| block.forward(g, x))
    }
}

/// A convolution over pictures.
#[derive(Clone, Copy, Debug)]
pub struct Conv {
    weight: ParamId,
    bias: Option<ParamId>,
    stride: usize,
    padding: usize,
}

/// Sizes of a [`Conv`].
#[derive(Clone, Copy, Debug)]
pub struct ConvShape {
    /// Channels in and out.
    pub channels: [usize; 2],
    /// Side of the square kernel; the picture is padded by half of it.
    pub kernel: usize,
    /// Step between outputs.
    pub stride: usize,
}

impl Conv {
    /// He's normal start by fan-out (He et al. 2015), as torchvision starts ResNet; no bias.
    pub fn declare(d: &mut Declaration, name: &str, shape: ConvShape) -> Self {
        let ConvShape { channels: [inputs, outputs], kernel, stride } = shape;
        let deviation = (2.0 / (outputs * kernel * kernel) as f32).sqrt();
        let dims = [outputs, inputs, kernel, kernel];
        let weight = d.add(&format!("{name}.weight"), &dims, Init::Normal(deviation), Role::Trained);
        Self { weight, bias: None, stride, padding: kernel / 2 }
    }

    /// PyTorch's default start and a bias, for convolutions that no normalisation follows.
    pub fn declare_with_bias(d: &mut Declaration, name: &str, shape: ConvShape) -> Self {
        let ConvShape { channels: [inputs, outputs], kernel, stride } = shape;
        let init = Init::Uniform(1.0 / ((inputs * kernel * kernel) as f32).sqrt());
        let dims = [outputs, inputs, kernel, kernel];
        let weight = d.add(&format!("{name}.weight"), &dims, init, Role::Trained);
        let bias = d.add(&format!("{name}.bias"), &[outputs], init, Role::Trained);
        Self { weight, bias: Some(bias), stride, padding: kernel / 2 }
    }

    /// `[batch, inputs, h, w]` to `[batch, outputs, h / stride, w / stride]`.
    pub fn forward(&self, g: &Graph, x: Tensor<4>) -> Tensor<4> {
        let options = ConvOptions::new([self.stride; 2], [self.padding; 2], [1; 2], 1);
        module::conv2d(x, g.param::<4>(self.weight), self.bias.map(|b| g.param::<1>(b)), options)
    }
}

/// Normalisation of each channel over the batch.
#[derive(Clone, Copy, Debug)]
pub struct BatchNorm {
    gamma: ParamId,
    beta: ParamId,
    mean: ParamId,
    variance: ParamId,
}

impl BatchNorm {
    /// Starts as the identity.
    pub fn declare(d: &mut Declaration, name: &str, channels: usize) -> Self {
        let mut add = |part: &str, value: f32, role: Role| {
            d.add(&format!("{name}.{part}"), &[channels], Init::Constant(value), role)
        };
        Self {
            gamma: add("weight", 1.0, Role::Trained),
            beta: add("bias", 0.0, Role::Trained),
            mean: add("running_mean", 0.0, Role::Running),
            variance: add("running_var", 1.0, Role::Running),
        }
    }

    /// Keeps the shape `[batch, channels, h, w]`.
    pub fn forward(&self, g: &Graph, x: Tensor<4>) -> Tensor<4> {
        let (gamma, beta) = (g.param::<1>(self.gamma), g.param::<1>(self.beta));
        let (mean, variance) = (g.param::<1>(self.mean), g.param::<1>(self.variance));
        if g.mode() == Mode::Infer {
            return module::batch_norm(x, gamma, beta, mean, variance, EPSILON);
        }
        let batch = module::batch_norm_train(x, gamma, beta, EPSILON);
        let blend = |old: Tensor<1>, new: Tensor<1>| old * (1.0 - MOMENTUM) + new.detach() * MOMENTUM;
        g.note_statistic(self.mean, blend(mean, batch.mean));
        g.note_statistic(self.variance, blend(variance, batch.variance));
        batch.output
    }
}

/// A residual block of ResNet18 (He et al. 2016).
#[derive(Clone, Copy, Debug)]
pub struct BasicBlock {
    first: (Conv, BatchNorm),
    second: (Conv, BatchNorm),
    shortcut: Option<(Conv, BatchNorm)>,
}

impl BasicBlock {
    /// A block that changes the channels and halves the picture when `stride` is 2.
    pub fn declare(d: &mut Declaration, name: &str, channels: [usize; 2], stride: usize) -> Self {
        let outputs = channels[1];
        let mut part = |name: String, bn: String, shape: ConvShape| {
            (Conv::declare(d, &name, shape), BatchNorm::declare(d, &bn, outputs))
        };
        let first = ConvShape { channels, kernel: 3, stride };
        let second = ConvShape { channels: [outputs; 2], kernel: 3, stride: 1 };
        let across = ConvShape { channels, kernel: 1, stride };
        let changes = stride != 1 || channels[0] != outputs;
        Self {
            first: part(format!("{name}.conv1"), format!("{name}.bn1"), first),
            second: part(format!("{name}.conv2"), format!("{name}.bn2"), second),
            shortcut: changes
                .then(|| part(format!("{name}.downsample.0"), format!("{name}.downsample.1"), across)),
        }
    }

    /// `[batch, in, h, w]` to `[batch, out, h / stride, w / stride]`.
    pub fn forward(&self, g: &Graph, x: Tensor<4>) -> Tensor<4> {
        let through = |(conv, norm): &(Conv, BatchNorm), x: Tensor<4>| norm.forward(g, conv.forward(g, x));
        let inner = through(&self.second, relu(through(&self.first, x.clone())));
        let across = match &self.shortcut {
            Some(shortcut) => through(shortcut, x),
            None => x,
        };
        relu(inner + across)
    }
}

/// ResNet's pooling: the largest of 3x3, every second pixel.
pub fn max_pool(x: Tensor<4>) -> Tensor<4> {
    module::max_pool2d(x, MaxPoolOptions::new([3, 3]).with_stride([2, 2]).with_padding([1, 1]))
}
