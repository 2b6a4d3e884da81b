//! The scene encoder: ResNet18's first layers (PSI §3.2.1), a convolution and a matrix.
//!
//! PSI starts from weights trained on ImageNet; none come with this program, so the start is He's.

use burn::tensor::Tensor;
use burn::tensor::activation::relu;
use burn::tensor::module;

use super::config::{CLASSES, IMAGE, PsiConfig, Semantics, Stem};
use super::input::{Pixels, SceneTensors};
use crate::nn::graph::Graph;
use crate::nn::layers::{BasicBlock, BatchNorm, Conv, ConvShape, Linear, max_pool};
use crate::nn::params::{Declaration, Init, ParamId, Role};

/// Deviation of the class vectors at the start: that of the other channels.
const EMBEDDING_DEVIATION: f32 = 0.5;

/// Pictures to one vector each.
#[derive(Clone, Debug)]
pub(super) struct SceneEncoder {
    embedding: Option<(ParamId, usize)>,
    stem: StemLayer,
    norm: BatchNorm,
    pool: bool,
    blocks: Vec<BasicBlock>,
    head: Conv,
    flat: usize,
    lift: Linear,
}

#[derive(Clone, Copy, Debug)]
enum StemLayer {
    Conv(Conv),
    /// One matrix for each square of `side` pixels.
    Patches {
        matrix: Linear,
        side: usize,
    },
}

impl SceneEncoder {
    /// `head` channels between the trunk and the matrix.
    pub fn declare(d: &mut Declaration, name: &str, config: &PsiConfig, head: usize) -> Self {
        let [first, second] = config.trunk.channels;
        let channels = config.pixel_channels();
        let embedding = match config.semantics {
            Semantics::Scalar => None,
            Semantics::Embedding(size) => {
                let init = Init::Normal(EMBEDDING_DEVIATION);
                let table = d.add(&format!("{name}.classes"), &[CLASSES, size], init, Role::Trained);
                Some((table, size))
            }
        };
        let stem = match config.trunk.stem {
            Stem::Conv7 => {
                let shape = ConvShape { channels: [channels, first], kernel: 7, stride: 2 };
                StemLayer::Conv(Conv::declare(d, &format!("{name}.conv1"), shape))
            }
            Stem::Patches(side) => {
                let matrix = Linear::declare(d, &format!("{name}.patches"), side * side * channels, first);
                StemLayer::Patches { matrix, side }
            }
        };
        let norm = BatchNorm::declare(d, &format!("{name}.bn1"), first);
        let mut blocks = Vec::new();
        for (layer, [from, to], stride) in [(1, [first, first], 1), (2, [first, second], 2)] {
            for block in 0..config.trunk.blocks {
                let (channels, stride) = if block == 0 { ([from, to], stride) } else { ([to, to], 1) };
                blocks.push(BasicBlock::declare(
                    d,
                    &format!("{name}.layer{layer}.{block}"),
                    channels,
                    stride,
                ));
            }
        }
        let shape = ConvShape { channels: [second, head], kernel: 3, stride: 1 };
        let side = config.feature_side();
        let flat = head * side * side;
        let inputs = flat + config.view_numbers();
        Self {
            embedding,
            stem,
            norm,
            pool: config.trunk.pool,
            blocks,
            head: Conv::declare_with_bias(d, &format!("{name}.head"), shape),
            flat,
            lift: Linear::declare(d, &format!("{name}.lift"), inputs, config.lift),
        }
    }

    /// `[batch, lift]`.
    pub fn forward(&self, g: &Graph, scenes: &SceneTensors) -> Tensor<2> {
        let x = relu(self.norm.forward(g, self.stem(g, scenes)));
        let x = if self.pool { max_pool(x) } else { x };
        let x = self.blocks.iter().fold(x, |x, block| block.forward(g, x));
        let flat = self.head.forward(g, x).reshape([scenes.batch, self.flat]);
        let flat = match scenes.camera.clone() {
            Some(camera) => Tensor::cat(vec![flat, camera], 1),
            None => flat,
        };
        self.lift.forward(g, flat)
    }

    /// `[batch, channels, h, w]` after the first layer.
    fn stem(&self, g: &Graph, scenes: &SceneTensors) -> Tensor<4> {
        let batch = scenes.batch;
        let embedded = self
            .embedding
            .zip(scenes.labels.clone())
            .map(|((table, size), labels)| (module::embedding(g.param::<2>(table), labels), size));
        match (&self.stem, scenes.pixels.clone()) {
            (StemLayer::Conv(conv), Pixels::Planes(planes)) => {
                let input = match embedded {
                    None => planes,
                    Some((classes, size)) => {
                        let classes = classes.reshape([batch, IMAGE, IMAGE, size]).permute([0, 3, 1, 2]);
                        Tensor::cat(vec![planes, classes], 1)
                    }
                };
                conv.forward(g, input)
            }
            (StemLayer::Patches { matrix, side }, Pixels::Patches(patches)) => {
                let places = IMAGE / side;
                let input = match embedded {
                    None => patches,
                    Some((classes, size)) => {
                        let classes = classes.reshape([batch * places * places, side * side * size]);
                        Tensor::cat(vec![patches, classes], 1)
                    }
                };
                let out = matrix.forward(g, input);
                let channels = out.dims()[1];
                out.reshape([batch, places, places, channels]).permute([0, 3, 1, 2])
            }
            _ => unreachable!("pictures are laid out for the same configuration"),
        }
    }
}
