//! The learned pose space: VPoser's decoder (Pavlakos et al. 2019) with its gradient derived by hand, and its encoder.
//!
//! Reads plain numbers from a weight file; names no machine-learning framework and trains nothing. One layer is
//! `y = b + Σ_i x_i w_i` over rows `w_i` that are contiguous over the outputs: forwards sums rows, backwards takes
//! dot products with the same rows, so one copy of the weights serves both.

use glam::{Mat3, Vec3};

use crate::assets::{Weights, WeightsError};
use crate::math::rotation;
use crate::scene::POSE;

use super::joints::{BODY_JOINTS, PARENTS};
use super::model::BodyModel;
use super::pose_space::{BodyPose, PoseSpace, PoseTape};
use super::skin_moments::{POSE_TREE, PoseFigure, SkinMoments};

const BUNDLED: &[u8] = include_bytes!("../../assets/networks/pose_prior.safetensors");

/// Numbers of a pose as axis-angles.
const ANGLES: usize = 3 * BODY_JOINTS;
/// Numbers of a pose as first two columns of rotation matrices.
const SIXES: usize = 6 * BODY_JOINTS;
/// Negative slope of the leaky ReLUs (VPoser version 1).
const SLOPE: f32 = 0.2;
/// Rows summed at a time: their products stay in registers while the sums are loaded once.
const ROWS: usize = 8;
/// Partial sums of a dot product: four registers of four.
const LANES: usize = 16;
/// Times that encoding takes the slope anew at most, and steps with each slope (Gauss and Newton's, then chords).
const SLOPES: usize = 3;
const STEPS_A_SLOPE: usize = 3;
/// Shares of a step that are tried: far from the goal a whole one can lead astray.
const SHARES: [f32; 3] = [1.0, 0.5, 0.25];
/// Encoding ends where a slope improved the cost by less than this share.
const SETTLED: f32 = 0.02;
/// Root mean square displacement of skin and joints that weighs as much as one standard deviation of the prior,
/// metres: a few millimetres, below which nobody sees a difference.
const ENCODING_M: f32 = 0.0022;
/// Turn of a single joint that weighs as much, radians: for turns that move little skin.
const ENCODING_RADIANS: f32 = 0.11;
/// Rows of the misfit of one joint: displacement of its skin's middle, of its skin about that, and its own turn.
const MISFITS: usize = 15;

/// A layer of weights (inputs, outputs), row-major, and its biases.
#[derive(Clone, Debug, PartialEq)]
struct Layer {
    weight: Vec<f32>,
    bias: Vec<f32>,
}

/// Decoder and encoder of the variational pose prior.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseDecoder {
    decoder: [Layer; 3],
    encoder: [Layer; 3],
    skin: SkinMoments,
    /// Middle of each joint's skin, from the joint at rest.
    middle: [Vec3; POSE_TREE],
    /// Lower triangular root of the second moments about that middle.
    root: [Mat3; POSE_TREE],
}

impl PoseDecoder {
    /// The prior of a weight file with tensors `encoder.{0,1,2}` and `decoder.{0,1,2}`, each `.weight` (inputs,
    /// outputs) and `.bias`; the body says how much each joint matters.
    ///
    /// # Errors
    /// [`WeightsError`] for the first tensor that is missing or does not fit.
    pub fn new(weights: &Weights, model: &BodyModel) -> Result<Self, WeightsError> {
        let decoder = layers(weights, "decoder", POSE, SIXES)?;
        let encoder = layers(weights, "encoder", ANGLES, POSE)?;
        let skin = SkinMoments::new(model);
        let middle = std::array::from_fn(|j| skin.first[j] / skin.mass[j]);
        let root = std::array::from_fn(|j| {
            let about = skin.first[j] * (1.0 / skin.mass[j]);
            lower_root(&(skin.second[j] - outer(skin.first[j], about)))
        });
        Ok(Self { decoder, encoder, skin, middle, root })
    }

    /// The weights that ship with the program, with their notes.
    ///
    /// # Errors
    /// Never with the embedded file, which a test reads.
    pub fn bundled_weights() -> Result<Weights, WeightsError> {
        Weights::from_bytes("bundled pose prior", BUNDLED)
    }

    /// The encoder's mean: fast, a few degrees off.
    pub fn encode_roughly(&self, pose: &BodyPose) -> [f32; POSE] {
        let angles: Vec<f32> = pose.iter().flat_map(glam::Vec3::to_array).collect();
        let first = self.encoder[0].forward(&angles, true);
        let second = self.encoder[1].forward(&first, true);
        let code = self.encoder[2].forward(&second, false);
        std::array::from_fn(|i| code[i])
    }

    /// What encoding minimises the square of, besides the code's: displacement of skin and joints and turns of single
    /// joints, in units of [`ENCODING_M`] and [`ENCODING_RADIANS`]; [`MISFITS`] numbers a joint.
    fn misfit(&self, figure: &PoseFigure, target: &PoseFigure) -> Vec<f32> {
        let mut misfit = Vec::with_capacity(MISFITS * POSE_TREE);
        for joint in 0..POSE_TREE {
            let turned = figure.world[joint] - target.world[joint];
            let moved = figure.position[joint] - target.position[joint] + turned * self.middle[joint];
            let between = target.local[joint].transpose() * figure.local[joint];
            self.push_misfit(joint, moved, turned, rotation::axis_angle_from_matrix(between), &mut misfit);
        }
        misfit
    }

    fn push_misfit(&self, joint: usize, moved: Vec3, turned: Mat3, by: Vec3, misfit: &mut Vec<f32>) {
        misfit.extend((moved * (self.skin.mass[joint].sqrt() / ENCODING_M)).to_array());
        misfit.extend((turned * self.root[joint] * (1.0 / ENCODING_M)).to_cols_array());
        misfit.extend((by / ENCODING_RADIANS).to_array());
    }

    fn figure(&self, tape: &PoseTape) -> PoseFigure {
        let six = &tape.0[tape.0.len() - SIXES..];
        self.skin.figure(&|joint| rotation::matrix_from_6d(&six_of(six, joint - 1)))
    }

    /// Change of the misfit per change of each code number: 32 rows as long as the misfit.
    fn slope(&self, tape: &PoseTape, figure: &PoseFigure) -> Vec<Vec<f32>> {
        let [first, second, out] = &self.decoder;
        let (hidden, six) = (first.bias.len(), &tape.0[tape.0.len() - SIXES..]);
        let (at_first, at_second) = (&tape.0[..hidden], &tape.0[hidden..2 * hidden]);
        // Forwards, one row a code number: 32 is less than the misfit has.
        let mut rows = first.weight.clone();
        rows.chunks_exact_mut(hidden).for_each(|row| slope_of_leaky(row, at_first));
        let mut rows = second.forward_many(&rows);
        rows.chunks_exact_mut(hidden).for_each(|row| slope_of_leaky(row, at_second));
        let rows = out.forward_many(&rows);
        let turns: Vec<[[f32; 6]; 3]> =
            (0..BODY_JOINTS).map(|joint| turns_of_six(&six_of(six, joint))).collect();
        rows.chunks_exact(SIXES).map(|row| self.slope_row(row, &turns, figure)).collect()
    }

    /// The misfit's change when the decoded numbers change by `row`.
    fn slope_row(&self, row: &[f32], turns: &[[[f32; 6]; 3]], figure: &PoseFigure) -> Vec<f32> {
        // Turn of each joint about world axes, and its displacement, from the pelvis outwards.
        let mut spin = [Vec3::ZERO; POSE_TREE];
        let mut moved = [Vec3::ZERO; POSE_TREE];
        let mut slope = Vec::with_capacity(MISFITS * POSE_TREE);
        for joint in 0..POSE_TREE {
            let mut by = Vec3::ZERO;
            if joint > 0 {
                let parent = PARENTS[joint];
                let own = six_of(row, joint - 1);
                by = Vec3::from_array(
                    turns[joint - 1].map(|turn| turn.iter().zip(&own).map(|(t, r)| t * r).sum()),
                );
                spin[joint] = spin[parent] + figure.world[joint] * by;
                moved[joint] =
                    moved[parent] + spin[parent].cross(figure.position[joint] - figure.position[parent]);
            }
            let turned = rotation::skew(spin[joint]) * figure.world[joint];
            self.push_misfit(joint, moved[joint] + turned * self.middle[joint], turned, by, &mut slope);
        }
        slope
    }
}

/// Turn about the joint's own three axes per change of the six numbers: with `dR = R [e]x` it is `<R [e]x / 2, dR>`.
fn turns_of_six(six: &[f32; 6]) -> [[f32; 6]; 3] {
    let matrix = rotation::matrix_from_6d(six);
    Vec3::AXES.map(|axis| rotation::pull_back_6d(six, &(matrix * rotation::skew(axis) * 0.5)))
}

impl PoseSpace for PoseDecoder {
    fn decode_taped(&self, code: &[f32; POSE], tape: &mut PoseTape) -> BodyPose {
        let [first, second, out] = &self.decoder;
        let hidden = first.bias.len();
        tape.0.resize(2 * hidden + SIXES, 0.0);
        let (at_first, rest) = tape.0.split_at_mut(hidden);
        let (at_second, six) = rest.split_at_mut(hidden);
        first.forward_into(code, at_first, true);
        second.forward_into(at_first, at_second, true);
        out.forward_into(at_second, six, false);
        std::array::from_fn(|joint| {
            rotation::axis_angle_from_matrix(rotation::matrix_from_6d(&six_of(six, joint)))
        })
    }

    fn pull_back_taped(&self, _code: &[f32; POSE], tape: &PoseTape, gradient: &BodyPose) -> [f32; POSE] {
        let [first, second, out] = &self.decoder;
        let hidden = first.bias.len();
        let (at_first, rest) = tape.0.split_at(hidden);
        let (at_second, six) = rest.split_at(hidden);
        let mut at_six = [0.0; SIXES];
        for (joint, pull) in gradient.iter().enumerate() {
            let own = six_of(six, joint);
            let turn = rotation::pull_back_logarithm(&rotation::matrix_from_6d(&own), *pull);
            at_six[6 * joint..6 * joint + 6].copy_from_slice(&rotation::pull_back_6d(&own, &turn));
        }
        let mut upper = vec![0.0; hidden];
        let mut lower = vec![0.0; hidden];
        let mut code = [0.0; POSE];
        out.backward_into(&at_six, &mut upper);
        slope_of_leaky(&mut upper, at_second);
        second.backward_into(&upper, &mut lower);
        slope_of_leaky(&mut lower, at_first);
        first.backward_into(&lower, &mut code);
        code
    }

    /// The encoder's mean, then a few steps of Gauss and Newton on the decoder: what is kept is a compromise
    /// between the pose (within some millimetres) and a likely code.
    fn encode(&self, pose: &BodyPose) -> [f32; POSE] {
        let target = self.skin.figure(&|joint| rotation::matrix_from_axis_angle(pose[joint - 1]));
        let mut tape = PoseTape::default();
        let mut best = self.attempt(self.encode_roughly(pose), &target, &mut tape);
        for _ in 0..SLOPES {
            self.decode_taped(&best.code, &mut tape);
            let slope = self.slope(&tape, &best.figure);
            let Some(factor) = normal_factor(&slope) else { break };
            let before = best.cost;
            for _ in 0..STEPS_A_SLOPE {
                let step = solve(&factor, &downhill(&slope, &best.misfit, &best.code));
                let tried = SHARES.iter().find_map(|share| {
                    let moved = std::array::from_fn(|i| best.code[i] + share * step[i]);
                    let attempt = self.attempt(moved, &target, &mut tape);
                    (attempt.cost < best.cost).then_some(attempt)
                });
                match tried {
                    Some(better) => best = better,
                    None => break,
                }
            }
            // Written so that a cost that is no number ends it too.
            let improved = best.cost < before * (1.0 - SETTLED);
            if !improved {
                break;
            }
        }
        best.code
    }
}

/// A code that encoding tries, and how far it is from the goal.
struct Attempt {
    code: [f32; POSE],
    figure: PoseFigure,
    misfit: Vec<f32>,
    cost: f32,
}

impl PoseDecoder {
    fn attempt(&self, code: [f32; POSE], target: &PoseFigure, tape: &mut PoseTape) -> Attempt {
        self.decode_taped(&code, tape);
        let figure = self.figure(tape);
        let misfit = self.misfit(&figure, target);
        let cost = misfit.iter().chain(&code).map(|x| x * x).sum();
        Attempt { code, figure, misfit, cost }
    }
}

impl Layer {
    fn forward(&self, input: &[f32], active: bool) -> Vec<f32> {
        let mut output = vec![0.0; self.bias.len()];
        self.forward_into(input, &mut output, active);
        output
    }

    fn forward_into(&self, input: &[f32], output: &mut [f32], active: bool) {
        output.copy_from_slice(&self.bias);
        self.add_rows(input, output);
        if active {
            output.iter_mut().for_each(|y| *y = if *y < 0.0 { SLOPE * *y } else { *y });
        }
    }

    /// Adds `Σ_i input_i weight_i`.
    fn add_rows(&self, input: &[f32], output: &mut [f32]) {
        let width = output.len();
        let blocks = self.weight.chunks(ROWS * width).zip(input.chunks(ROWS));
        for (rows, x) in blocks {
            add_block(rows, x, output);
        }
    }

    /// Rows of inputs through the weights, without biases. Goes through the weights once, a block of them at a time.
    fn forward_many(&self, inputs: &[f32]) -> Vec<f32> {
        let width = self.bias.len();
        let depth = self.weight.len() / width;
        let mut outputs = vec![0.0; inputs.len() / depth * width];
        for (block, rows) in self.weight.chunks(ROWS * width).enumerate() {
            for (input, output) in inputs.chunks_exact(depth).zip(outputs.chunks_exact_mut(width)) {
                add_block(rows, &input[block * ROWS..(block * ROWS + rows.len() / width)], output);
            }
        }
        outputs
    }

    /// Gradient with respect to the inputs, given that with respect to the outputs.
    fn backward_into(&self, at_output: &[f32], at_input: &mut [f32]) {
        for (row, x) in self.weight.chunks_exact(at_output.len()).zip(at_input) {
            *x = dot(row, at_output);
        }
    }
}

/// Adds up to [`ROWS`] rows, each times its factor.
fn add_block(rows: &[f32], factors: &[f32], output: &mut [f32]) {
    let width = output.len();
    if let (Ok(x), true) = (<[f32; ROWS]>::try_from(factors), rows.len() == ROWS * width) {
        let mut row = rows.chunks_exact(width);
        let mut next = || row.next().unwrap_or(&[]);
        let [a, b, c, d] = [next(), next(), next(), next()];
        let [e, f, g, h] = [next(), next(), next(), next()];
        let eight = a.iter().zip(b).zip(c).zip(d).zip(e).zip(f).zip(g).zip(h);
        for (y, (((((((a, b), c), d), e), f), g), h)) in output.iter_mut().zip(eight) {
            let low = x[0] * a + x[1] * b + (x[2] * c + x[3] * d);
            let high = x[4] * e + x[5] * f + (x[6] * g + x[7] * h);
            *y += low + high;
        }
        return;
    }
    for (row, x) in rows.chunks_exact(width).zip(factors) {
        output.iter_mut().zip(row).for_each(|(y, w)| *y += x * w);
    }
}

fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0f32; LANES];
    let (whole_a, whole_b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f32 = whole_a.remainder().iter().zip(whole_b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in whole_a.zip(whole_b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f32>() + rest
}

/// Turns a gradient after a leaky ReLU into one before it; the output's sign is the input's.
fn slope_of_leaky(gradient: &mut [f32], output: &[f32]) {
    gradient.iter_mut().zip(output).for_each(|(g, y)| *g = if *y < 0.0 { SLOPE * *g } else { *g });
}

fn six_of(six: &[f32], joint: usize) -> [f32; 6] {
    std::array::from_fn(|i| six[6 * joint + i])
}

fn layers(weights: &Weights, part: &str, inputs: usize, outputs: usize) -> Result<[Layer; 3], WeightsError> {
    let hidden = weights.tensor(&format!("{part}.0.bias"))?.values.len();
    let layer = |i: usize, shape: [usize; 2]| {
        Ok(Layer {
            weight: weights.values(&format!("{part}.{i}.weight"), &shape)?.to_vec(),
            bias: weights.values(&format!("{part}.{i}.bias"), &shape[1..])?.to_vec(),
        })
    };
    Ok([layer(0, [inputs, hidden])?, layer(1, [hidden, hidden])?, layer(2, [hidden, outputs])?])
}

fn outer(column: Vec3, row: Vec3) -> Mat3 {
    Mat3::from_cols(column * row.x, column * row.y, column * row.z)
}

/// Lower triangular `L` with `L Lᵀ` the matrix, which is positive semi-definite; what rounding makes negative is zero.
fn lower_root(matrix: &Mat3) -> Mat3 {
    let mut root = Mat3::ZERO;
    for column in 0..3 {
        for row in column..3 {
            let sum: f32 = (0..column).map(|k| root.col(k)[row] * root.col(k)[column]).sum();
            let left = matrix.col(column)[row] - sum;
            let above = root.col(column)[column];
            root.col_mut(column)[row] = match row == column {
                true => left.max(0.0).sqrt(),
                false if above > 0.0 => left / above,
                false => 0.0,
            };
        }
    }
    root
}

/// Cholesky factor of `slope slopeᵀ + 1`, lower triangle; `None` when numbers are not finite.
fn normal_factor(slope: &[Vec<f32>]) -> Option<Vec<f32>> {
    let mut normal = vec![0.0f32; POSE * POSE];
    for a in 0..POSE {
        for b in 0..=a {
            normal[a * POSE + b] = dot(&slope[a], &slope[b]) + if a == b { 1.0 } else { 0.0 };
        }
    }
    for a in 0..POSE {
        for b in 0..=a {
            let sum: f32 = (0..b).map(|k| normal[a * POSE + k] * normal[b * POSE + k]).sum();
            let left = normal[a * POSE + b] - sum;
            if a == b {
                if !(left > 0.0 && left.is_finite()) {
                    return None;
                }
                normal[a * POSE + a] = left.sqrt();
            } else {
                normal[a * POSE + b] = left / normal[b * POSE + b];
            }
        }
    }
    Some(normal)
}

/// Minus half the gradient of the encoding's cost.
fn downhill(slope: &[Vec<f32>], misfit: &[f32], code: &[f32; POSE]) -> [f32; POSE] {
    std::array::from_fn(|i| -code[i] - dot(&slope[i], misfit))
}

/// Solves with the Cholesky factor of [`normal_factor`].
fn solve(factor: &[f32], right: &[f32; POSE]) -> [f32; POSE] {
    let mut x = *right;
    for a in 0..POSE {
        let sum: f32 = (0..a).map(|k| factor[a * POSE + k] * x[k]).sum();
        x[a] = (x[a] - sum) / factor[a * POSE + a];
    }
    for a in (0..POSE).rev() {
        let sum: f32 = (a + 1..POSE).map(|k| factor[k * POSE + a] * x[k]).sum();
        x[a] = (x[a] - sum) / factor[a * POSE + a];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    /// A small decoder of random weights; `turn` scales how far it turns joints.
    fn random_decoder(turn: f32, seed: u64) -> PoseDecoder {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut weights = Weights::new("random");
        let mut layer = |part: &str, i: usize, inputs: usize, outputs: usize, scale: f32| {
            let scale = scale / (inputs as f32).sqrt();
            let weight = (0..inputs * outputs).map(|_| scale * rng.random_range(-1.0..1.0f32)).collect();
            weights.insert(&format!("{part}.{i}.weight"), &[inputs, outputs], weight);
            let six = outputs == SIXES;
            let bias = (0..outputs).map(|o| if six && matches!(o % 6, 0 | 3) { 1.0 } else { 0.0 }).collect();
            weights.insert(&format!("{part}.{i}.bias"), &[outputs], bias);
        };
        for (part, inputs, outputs, scale) in [("decoder", POSE, SIXES, turn), ("encoder", ANGLES, POSE, 1.0)]
        {
            layer(part, 0, inputs, 37, 2.0);
            layer(part, 1, 37, 37, 2.0);
            layer(part, 2, 37, outputs, scale);
        }
        PoseDecoder::new(&weights, &Body::bundled().model).expect("weights that fit")
    }

    fn random_code(rng: &mut ChaCha8Rng) -> [f32; POSE] {
        std::array::from_fn(|_| rng.random_range(-1.5..1.5))
    }

    fn check_gradient(decoder: &PoseDecoder, code: &[f32; POSE], gradient: &BodyPose) {
        let value = |code: &[f32; POSE]| -> f64 {
            decoder.decode(code).iter().zip(gradient).map(|(a, g)| f64::from(a.dot(*g))).sum()
        };
        let analytic = decoder.pull_back(code, gradient);
        for i in 0..POSE {
            let side = |step: f32| {
                let mut moved = *code;
                moved[i] += step;
                value(&moved)
            };
            let numeric = (side(1e-3) - side(-1e-3)) / 2e-3;
            let error = (f64::from(analytic[i]) - numeric).abs();
            assert!(error < 2e-2 + 1e-2 * numeric.abs(), "[{i}]: {} against {numeric}", analytic[i]);
        }
    }

    #[test]
    fn gradients_agree_with_finite_differences() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for turn in [0.3, 1.5] {
            let decoder = random_decoder(turn, 2);
            for _ in 0..3 {
                let code = random_code(&mut rng);
                let gradient = std::array::from_fn(|_| Vec3::from_array(rng.random()));
                check_gradient(&decoder, &code, &gradient);
            }
        }
    }

    #[test]
    fn gradients_hold_where_joints_hardly_turn() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let code = random_code(&mut rng);
        let mut decoder = random_decoder(0.8, 3);
        let mut tape = PoseTape::default();
        decoder.decode_taped(&code, &mut tape);
        // Biases that leave every joint unturned at this code.
        let six = &tape.0[tape.0.len() - SIXES..];
        for (i, bias) in decoder.decoder[2].bias.iter_mut().enumerate() {
            *bias += if matches!(i % 6, 0 | 3) { 1.0 - six[i] } else { -six[i] };
        }
        assert!(decoder.decode(&code).iter().all(|v| v.length() < 1e-5));
        let gradient: BodyPose = std::array::from_fn(|_| Vec3::from_array(rng.random()));
        check_gradient(&decoder, &code, &gradient);
        let still = random_decoder(0.0, 3);
        assert!(still.pull_back(&code, &gradient).iter().all(|g| g.is_finite()));
    }

    #[test]
    fn the_slope_that_encoding_uses_is_that_of_the_decoder() {
        let decoder = random_decoder(0.8, 5);
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let code = random_code(&mut rng);
        let mut tape = PoseTape::default();
        decoder.decode_taped(&code, &mut tape);
        let here = decoder.figure(&tape);
        let slope = decoder.slope(&tape, &here);
        for (i, row) in slope.iter().enumerate() {
            let mut side = |step: f32| {
                let mut moved = code;
                moved[i] += step;
                decoder.decode_taped(&moved, &mut tape);
                decoder.misfit(&decoder.figure(&tape), &here)
            };
            let (after, before) = (side(2e-3), side(-2e-3));
            for ((a, b), analytic) in after.iter().zip(&before).zip(row) {
                let numeric = (a - b) / 4e-3;
                assert!((numeric - analytic).abs() < 0.1 + 0.03 * analytic.abs(), "{numeric} {analytic}");
            }
        }
    }

    #[test]
    fn encoding_solves_its_normal_equations() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let slope: Vec<Vec<f32>> =
            (0..POSE).map(|_| (0..50).map(|_| rng.random_range(-1.0..1.0)).collect()).collect();
        let right: [f32; POSE] = std::array::from_fn(|i| (i as f32).sin());
        let x = solve(&normal_factor(&slope).expect("positive"), &right);
        let along: Vec<f32> = (0..50).map(|m| (0..POSE).map(|a| slope[a][m] * x[a]).sum()).collect();
        for a in 0..POSE {
            let back = x[a] + dot(&slope[a], &along);
            assert!((back - right[a]).abs() < 1e-4, "{back} against {}", right[a]);
        }
    }
}
