//! Eq. 3 and 4 of LTM, and what the sub-goals and the points are taught by, as tensors.

use burn::tensor::activation::log_softmax;
use burn::tensor::{Device, Tensor};

use super::config::MotionTraining;
use crate::nn::motion::{BETWEEN, Between, POINT_CLASSES, ROW};
use crate::nn::tensor;

/// Mean distance, each number by the weight of its column.
pub(super) fn distance(made: &Tensor<2>, truth: &Tensor<2>, weights: &Tensor<2>) -> Tensor<1> {
    ((made.clone() - truth.clone()).abs() * weights.clone()).mean()
}

/// Weights of a network's outputs over all frames, `[1, 60 * outputs]`.
pub(super) fn between_weights(training: &MotionTraining, which: Between, device: &Device) -> Tensor<2> {
    let frame: Vec<f32> = which.outputs().map(|c| training.column_weight(c)).collect();
    let all = frame.repeat(BETWEEN);
    let count = all.len();
    tensor(all, [1, count], device)
}

/// Weights of a body's numbers, `[1, ROW]`.
pub(super) fn body_weights(training: &MotionTraining, device: &Device) -> Tensor<2> {
    tensor((0..ROW).map(|c| training.column_weight(c)).collect(), [1, ROW], device)
}

/// Cross-entropy of logits `[points, POINT_CLASSES]`.
pub(super) fn labels(logits: Tensor<2>, classes: &[u8]) -> Tensor<1> {
    let mut truth = vec![0.0; classes.len() * POINT_CLASSES];
    for (row, class) in truth.chunks_exact_mut(POINT_CLASSES).zip(classes) {
        row[usize::from(*class).min(POINT_CLASSES - 1)] = 1.0;
    }
    let device = logits.device();
    let truth = tensor(truth, [classes.len(), POINT_CLASSES], &device);
    (log_softmax(logits, 1) * truth).sum() / -(classes.len() as f32)
}
