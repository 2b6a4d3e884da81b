//! The variational pose prior's network: VPoser's (Pavlakos et al. 2019, SMPLify-X, supplement; version 1's layers).
//!
//! Encoder: 63 axis-angle numbers, batch norm, 512, leaky ReLU, batch norm, dropout, 512, leaky ReLU, then mean and
//! softplus deviation of a 32-number code. Decoder: 32, 512, 512, 126 with leaky ReLUs: 21 rotations as the first two
//! columns of their matrices (Zhou et al. 2019). What the rotations should be is the caller's: a step takes the
//! gradient of the loss with respect to the 126 numbers. All randomness comes in as numbers, so that a step is a pure
//! function, whatever else runs on the device.

use burn::tensor::{Device, Tensor, TensorData, activation};

use crate::assets::{Weights, WeightsError};

/// Numbers of a pose: 21 axis-angles.
pub const VAE_POSE: usize = 63;
/// Numbers of a code.
pub const VAE_CODE: usize = 32;
/// Numbers of a decoded pose: 21 times the first two columns of a rotation, row-major 3x2.
pub const VAE_SIX: usize = 126;
/// Negative slope of the leaky ReLUs (VPoser version 1).
pub const VAE_SLOPE: f64 = 0.2;
/// Added to the variance before its root is divided by (as PyTorch's batch norm).
const NORM_EPSILON: f32 = 1e-5;
/// Share of a batch's statistics that enters the running ones (as PyTorch's batch norm).
const NORM_MOMENTUM: f32 = 0.1;
/// Least deviation of a code number, so that its logarithm stays finite.
const LEAST_DEVIATION: f64 = 1e-4;

/// One block of the parameters: name and shape.
type Block = (&'static str, [usize; 2]);

/// The network as plain numbers: all parameters in one vector, and the running statistics of the two batch norms.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseVae {
    /// Width of the hidden layers.
    pub hidden: usize,
    /// Every parameter, block by block.
    pub parameters: Vec<f32>,
    /// Mean and variance of the inputs, then of the first hidden layer.
    running: [Vec<f32>; 4],
}

/// What one step needs besides the parameters. `B` is the number of poses.
#[derive(Clone, Debug, Default)]
pub struct VaeBatch {
    /// (B, 63) axis-angles, radians.
    pub poses: Vec<f32>,
    /// (B, 32) draws from the standard normal.
    pub noise: Vec<f32>,
    /// (B, hidden) factors on the encoder's and the decoder's first hidden layer: 0 for dropped units,
    /// `1 / (1 - rate)` for kept ones. Empty for no dropout.
    pub keep: [Vec<f32>; 2],
    /// Factor on the divergence from the standard normal.
    pub divergence_weight: f32,
}

/// What a step says.
#[derive(Clone, Debug)]
pub struct VaeGradient {
    /// Divergence of the posterior from the prior, nats a pose, mean over the batch, without its weight.
    pub divergence: f32,
    /// Gradient of weighted divergence plus the caller's loss, as long as the parameters.
    pub parameters: Vec<f32>,
}

/// Mean and deviation of the codes of poses.
#[derive(Clone, Debug)]
pub struct VaeCodes {
    /// (B, 32).
    pub mean: Vec<f32>,
    /// (B, 32).
    pub deviation: Vec<f32>,
}

fn blocks(hidden: usize) -> [Block; 16] {
    [
        ("encoder.norm1.gain", [1, VAE_POSE]),
        ("encoder.norm1.shift", [1, VAE_POSE]),
        ("encoder.fc1.weight", [VAE_POSE, hidden]),
        ("encoder.fc1.bias", [1, hidden]),
        ("encoder.norm2.gain", [1, hidden]),
        ("encoder.norm2.shift", [1, hidden]),
        ("encoder.fc2.weight", [hidden, hidden]),
        ("encoder.fc2.bias", [1, hidden]),
        ("encoder.mean.weight", [hidden, VAE_CODE]),
        ("encoder.mean.bias", [1, VAE_CODE]),
        ("encoder.deviation.weight", [hidden, VAE_CODE]),
        ("encoder.deviation.bias", [1, VAE_CODE]),
        ("decoder.fc1.weight", [VAE_CODE, hidden]),
        ("decoder.fc1.bias", [1, hidden]),
        ("decoder.fc2.weight", [hidden, hidden]),
        ("decoder.fc2.bias", [1, hidden]),
    ]
}

fn out_blocks(hidden: usize) -> [Block; 2] {
    [("decoder.out.weight", [hidden, VAE_SIX]), ("decoder.out.bias", [1, VAE_SIX])]
}

fn all_blocks(hidden: usize) -> impl Iterator<Item = Block> {
    blocks(hidden).into_iter().chain(out_blocks(hidden))
}

/// Names of the running statistics in a weight file.
const RUNNING: [&str; 4] =
    ["encoder.norm1.mean", "encoder.norm1.variance", "encoder.norm2.mean", "encoder.norm2.variance"];

impl PoseVae {
    /// A fresh network. `uniform` draws from [-1, 1); weights and biases start within one over the root of their
    /// inputs (as PyTorch's linear layers), and the output's biases at unturned joints.
    pub fn new(hidden: usize, uniform: &mut impl FnMut() -> f32) -> Self {
        let mut parameters = Vec::new();
        let mut inputs = 1;
        for (name, [rows, columns]) in all_blocks(hidden) {
            let count = rows * columns;
            if name.ends_with("gain") {
                parameters.extend(std::iter::repeat_n(1.0, count));
            } else if name.ends_with("shift") {
                parameters.extend(std::iter::repeat_n(0.0, count));
            } else if name == "decoder.out.bias" {
                parameters.extend((0..count).map(|i| if matches!(i % 6, 0 | 3) { 1.0 } else { 0.0 }));
            } else {
                inputs = if rows > 1 { rows } else { inputs };
                let bound = 1.0 / (inputs as f32).sqrt();
                parameters.extend((0..count).map(|_| uniform() * bound));
            }
        }
        let running = [vec![0.0; VAE_POSE], vec![1.0; VAE_POSE], vec![0.0; hidden], vec![1.0; hidden]];
        Self { hidden, parameters, running }
    }

    /// Adds the network to a weight file, block by block.
    pub fn write(&self, weights: &mut Weights) {
        let mut at = 0;
        for (name, [rows, columns]) in all_blocks(self.hidden) {
            let values = self.parameters[at..at + rows * columns].to_vec();
            at += rows * columns;
            match rows {
                1 => weights.insert(name, &[columns], values),
                _ => weights.insert(name, &[rows, columns], values),
            }
        }
        for (name, values) in RUNNING.iter().zip(&self.running) {
            weights.insert(name, &[values.len()], values.clone());
        }
    }

    /// Reads a network as [`PoseVae::write`] wrote it.
    ///
    /// # Errors
    /// [`WeightsError`] for the first tensor that is missing or of another shape.
    pub fn read(weights: &Weights) -> Result<Self, WeightsError> {
        let hidden = weights.tensor("decoder.fc1.bias")?.values.len();
        let mut parameters = Vec::new();
        for (name, [rows, columns]) in all_blocks(hidden) {
            let shape: &[usize] = if rows == 1 { &[columns] } else { &[rows, columns] };
            parameters.extend_from_slice(weights.values(name, shape)?);
        }
        let lengths = [VAE_POSE, VAE_POSE, hidden, hidden];
        let mut running: [Vec<f32>; 4] = Default::default();
        for ((name, length), values) in RUNNING.iter().zip(lengths).zip(&mut running) {
            *values = weights.values(name, &[length])?.to_vec();
        }
        Ok(Self { hidden, parameters, running })
    }

    /// Forward and backward of one batch; moves the running statistics. `loss` gets the decoded (B, 126) numbers and
    /// returns the gradient of its own mean over the batch with respect to them.
    ///
    /// # Panics
    /// When a vector of the batch has another length than its shape: a bug of the caller.
    pub fn step(&mut self, batch: &VaeBatch, loss: &mut dyn FnMut(&[f32]) -> Vec<f32>) -> VaeGradient {
        let device = Device::flex().autodiff();
        let count = batch.poses.len() / VAE_POSE;
        let leaves = self.leaves(&device);
        let keep = |i: usize| {
            let factors: &[f32] = &batch.keep[i];
            (!factors.is_empty()).then(|| matrix(factors, [count, self.hidden], &device))
        };
        let poses = matrix(&batch.poses, [count, VAE_POSE], &device);
        let (input, statistics1) = normalised(poses);
        let hidden = leaky(layer(input * leaves[0].clone() + leaves[1].clone(), &leaves[2..4]));
        let (hidden, statistics2) = normalised(hidden);
        let hidden = dropped(hidden * leaves[4].clone() + leaves[5].clone(), keep(0));
        let hidden = leaky(layer(hidden, &leaves[6..8]));
        let mean = layer(hidden.clone(), &leaves[8..10]);
        let deviation = deviation(layer(hidden, &leaves[10..12]));
        let noise = matrix(&batch.noise, [count, VAE_CODE], &device);
        let code = mean.clone() + deviation.clone() * noise;
        let hidden = dropped(leaky(layer(code, &leaves[12..14])), keep(1));
        let six = layer(leaky(layer(hidden, &leaves[14..16])), &leaves[16..18]);
        let spread =
            mean.clone() * mean + deviation.clone() * deviation.clone() - deviation.log() * 2.0 - 1.0;
        let divergence = spread.sum() * (0.5 / count as f64);
        let decoded = plain(six.clone());
        let pull = matrix(&loss(&decoded), [count, VAE_SIX], &device);
        let total = (six * pull).sum() + divergence.clone() * f64::from(batch.divergence_weight);
        let gradients = total.backward();
        let mut parameters = Vec::with_capacity(self.parameters.len());
        for leaf in &leaves {
            match leaf.grad(&gradients) {
                Some(gradient) => parameters.extend(plain(gradient)),
                None => parameters.extend(std::iter::repeat_n(0.0, leaf.shape().num_elements())),
            }
        }
        self.track(count, statistics1, statistics2);
        VaeGradient { divergence: plain(divergence.reshape([1, 1]))[0], parameters }
    }

    /// Codes of (B, 63) poses, with the running statistics and without dropout.
    pub fn encode(&self, poses: &[f32]) -> VaeCodes {
        let device = Device::flex();
        let count = poses.len() / VAE_POSE;
        let leaves = self.leaves(&device);
        let fixed = |x: Tensor<2>, which: usize| {
            let mean = matrix(&self.running[which], [1, self.running[which].len()], &device);
            let factor: Vec<f32> =
                self.running[which + 1].iter().map(|v| 1.0 / (v + NORM_EPSILON).sqrt()).collect();
            (x - mean) * matrix(&factor, [1, factor.len()], &device)
        };
        let input = fixed(matrix(poses, [count, VAE_POSE], &device), 0);
        let hidden = leaky(layer(input * leaves[0].clone() + leaves[1].clone(), &leaves[2..4]));
        let hidden = fixed(hidden, 2) * leaves[4].clone() + leaves[5].clone();
        let hidden = leaky(layer(hidden, &leaves[6..8]));
        VaeCodes {
            mean: plain(layer(hidden.clone(), &leaves[8..10])),
            deviation: plain(deviation(layer(hidden, &leaves[10..12]))),
        }
    }

    /// (B, 126) decoded numbers of (B, 32) codes.
    pub fn decode(&self, codes: &[f32]) -> Vec<f32> {
        let device = Device::flex();
        let leaves = self.leaves(&device);
        let code = matrix(codes, [codes.len() / VAE_CODE, VAE_CODE], &device);
        let hidden = leaky(layer(leaky(layer(code, &leaves[12..14])), &leaves[14..16]));
        plain(layer(hidden, &leaves[16..18]))
    }

    /// The network for use, not for training: the batch norms folded into the layers behind them, the deviation left
    /// out. Tensors `encoder.{0,1,2}` and `decoder.{0,1,2}`, each `.weight` (inputs, outputs) and `.bias`.
    pub fn folded(&self, file: &str) -> Weights {
        let mut weights = Weights::new(file);
        let blocks = self.split();
        let encoder = [
            self.fold_norm(0, [blocks[0], blocks[1]], blocks[2], blocks[3]),
            self.fold_norm(2, [blocks[4], blocks[5]], blocks[6], blocks[7]),
            (blocks[8].to_vec(), blocks[9].to_vec()),
        ];
        let decoder = [12, 14, 16].map(|i| (blocks[i].to_vec(), blocks[i + 1].to_vec()));
        for (part, layers) in [("encoder", encoder), ("decoder", decoder)] {
            for (i, (weight, bias)) in layers.into_iter().enumerate() {
                let shape = [weight.len() / bias.len(), bias.len()];
                weights.insert(&format!("{part}.{i}.weight"), &shape, weight);
                weights.insert(&format!("{part}.{i}.bias"), &shape[1..], bias);
            }
        }
        weights
    }

    /// Weight and bias of a layer that takes unnormalised inputs.
    fn fold_norm(
        &self,
        which: usize,
        [gain, shift]: [&[f32]; 2],
        weight: &[f32],
        bias: &[f32],
    ) -> (Vec<f32>, Vec<f32>) {
        let (mut folded, mut constant) = (weight.to_vec(), bias.to_vec());
        let outputs = bias.len();
        for (i, row) in folded.chunks_exact_mut(outputs).enumerate() {
            let factor = gain[i] / (self.running[which + 1][i] + NORM_EPSILON).sqrt();
            let offset = shift[i] - self.running[which][i] * factor;
            for (w, b) in row.iter_mut().zip(&mut constant) {
                *b += offset * *w;
                *w *= factor;
            }
        }
        (folded, constant)
    }

    /// The parameters, block by block.
    fn split(&self) -> Vec<&[f32]> {
        let mut rest = self.parameters.as_slice();
        all_blocks(self.hidden)
            .map(|(_, [rows, columns])| {
                let (block, behind) = rest.split_at(rows * columns);
                rest = behind;
                block
            })
            .collect()
    }

    fn leaves(&self, device: &Device) -> Vec<Tensor<2>> {
        let shapes = all_blocks(self.hidden).map(|(_, shape)| shape);
        let leaf = |(block, shape): (&[f32], [usize; 2])| {
            let tensor = matrix(block, shape, device);
            if device.is_autodiff() { tensor.require_grad() } else { tensor }
        };
        self.split().into_iter().zip(shapes).map(leaf).collect()
    }

    fn track(&mut self, count: usize, first: [Vec<f32>; 2], second: [Vec<f32>; 2]) {
        // The running variance is the unbiased one, as in PyTorch.
        let unbiased = count as f32 / count.saturating_sub(1).max(1) as f32;
        let news = first.into_iter().chain(second);
        for (i, (running, new)) in self.running.iter_mut().zip(news).enumerate() {
            let scale = if i % 2 == 1 { unbiased } else { 1.0 };
            for (r, n) in running.iter_mut().zip(new) {
                *r += NORM_MOMENTUM * (scale * n - *r);
            }
        }
    }
}

fn matrix(values: &[f32], shape: [usize; 2], device: &Device) -> Tensor<2> {
    Tensor::from_data(TensorData::new(values.to_vec(), shape), device)
}

fn plain(tensor: Tensor<2>) -> Vec<f32> {
    tensor.into_data().iter::<f32>().collect()
}

fn layer(input: Tensor<2>, weight_and_bias: &[Tensor<2>]) -> Tensor<2> {
    input.matmul(weight_and_bias[0].clone()) + weight_and_bias[1].clone()
}

fn leaky(tensor: Tensor<2>) -> Tensor<2> {
    activation::leaky_relu(tensor, VAE_SLOPE)
}

fn deviation(tensor: Tensor<2>) -> Tensor<2> {
    activation::softplus(tensor, 1.0) + LEAST_DEVIATION
}

fn dropped(tensor: Tensor<2>, keep: Option<Tensor<2>>) -> Tensor<2> {
    match keep {
        Some(factors) => tensor * factors,
        None => tensor,
    }
}

/// The columns brought to mean 0 and variance 1 over the batch; and that mean and variance.
fn normalised(tensor: Tensor<2>) -> (Tensor<2>, [Vec<f32>; 2]) {
    let mean = tensor.clone().mean_dim(0);
    let centred = tensor - mean.clone();
    let variance = (centred.clone() * centred.clone()).mean_dim(0);
    let statistics = [plain(mean), plain(variance.clone())];
    (centred / (variance + NORM_EPSILON).sqrt(), statistics)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small stream of numbers in [-1, 1).
    fn stream(mut state: u32) -> impl FnMut() -> f32 {
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1u32 << 23) as f32 - 1.0
        }
    }

    fn batch(count: usize) -> VaeBatch {
        let mut draw = stream(5);
        VaeBatch {
            poses: (0..count * VAE_POSE).map(|_| draw()).collect(),
            noise: (0..count * VAE_CODE).map(|_| draw()).collect(),
            keep: std::array::from_fn(|_| {
                (0..count * 16).map(|i| if i % 5 == 0 { 0.0 } else { 1.25 }).collect()
            }),
            divergence_weight: 0.7,
        }
    }

    /// Half the squared distance of the decoded numbers to a target, mean over poses.
    fn bowl(six: &[f32]) -> (f64, Vec<f32>) {
        let count = (six.len() / VAE_SIX) as f32;
        let target = |i: usize| (i as f32 * 0.37).sin();
        let energy = six.iter().enumerate().map(|(i, s)| f64::from(s - target(i)).powi(2)).sum::<f64>();
        let gradient = six.iter().enumerate().map(|(i, s)| (s - target(i)) / count).collect();
        (0.5 * energy / f64::from(count), gradient)
    }

    fn energy(vae: &PoseVae, batch: &VaeBatch) -> f64 {
        let mut value = 0.0;
        let said = vae.clone().step(batch, &mut |six| {
            let (energy, gradient) = bowl(six);
            value = energy;
            gradient
        });
        value + 0.7 * f64::from(said.divergence)
    }

    #[test]
    fn gradients_of_every_block_agree_with_finite_differences() {
        let vae = PoseVae::new(16, &mut stream(1));
        let batch = batch(6);
        let analytic = vae.clone().step(&batch, &mut |six| bowl(six).1).parameters;
        let mut at = 0;
        for (name, [rows, columns]) in all_blocks(16) {
            // Along the gradient's own direction within the block: one figure for all its numbers.
            let range = at..at + rows * columns;
            at = range.end;
            let length = analytic[range.clone()].iter().map(|g| g * g).sum::<f32>().sqrt();
            let moved = |step: f32| {
                let mut moved = vae.clone();
                for i in range.clone() {
                    moved.parameters[i] += step * analytic[i] / length.max(1e-9);
                }
                energy(&moved, &batch)
            };
            // A short step: the leaky ReLUs have kinks.
            let numeric = (moved(0.003) - moved(-0.003)) / 0.006;
            let error = (numeric - f64::from(length)).abs();
            // A bias in front of a batch norm moves nothing but rounding.
            assert!(error < 4e-3 + 0.03 * f64::from(length), "{name}: {length} against {numeric}");
        }
    }

    #[test]
    fn the_folded_network_is_the_trained_one() {
        let mut vae = PoseVae::new(16, &mut stream(3));
        let batch = batch(8);
        for _ in 0..3 {
            vae.step(&batch, &mut |six| bowl(six).1);
        }
        let folded = vae.folded("f");
        let layer = |x: &[f32], name: &str, active: bool| -> Vec<f32> {
            let bias = &folded.tensor(&format!("{name}.bias")).expect("bias").values;
            let weight = &folded.tensor(&format!("{name}.weight")).expect("weight").values;
            let sum =
                |o: usize| x.iter().enumerate().map(|(i, x)| x * weight[i * bias.len() + o]).sum::<f32>();
            let y = (0..bias.len()).map(|o| bias[o] + sum(o));
            y.map(|y| if active && y < 0.0 { 0.2 * y } else { y }).collect()
        };
        let hidden = layer(&layer(&batch.poses[..VAE_POSE], "encoder.0", true), "encoder.1", true);
        let code = layer(&hidden, "encoder.2", false);
        let expected = vae.encode(&batch.poses);
        assert!(expected.deviation.iter().all(|d| *d > 0.0));
        for (a, b) in code.iter().zip(&expected.mean) {
            assert!((a - b).abs() < 1e-4, "{a} against {b}");
        }
        let six = layer(&layer(&layer(&code, "decoder.0", true), "decoder.1", true), "decoder.2", false);
        for (a, b) in six.iter().zip(vae.decode(&code)) {
            assert!((a - b).abs() < 1e-4, "{a} against {b}");
        }
    }

    #[test]
    fn a_network_survives_its_weight_file() {
        let vae = PoseVae::new(16, &mut stream(3));
        let mut weights = Weights::new("w");
        vae.write(&mut weights);
        assert_eq!(PoseVae::read(&weights).expect("read"), vae);
        weights.insert("encoder.fc1.bias", &[4], vec![0.0; 4]);
        assert!(PoseVae::read(&weights).is_err());
    }
}
