//! A network's numbers put into the framework for one forward pass, and their gradients read back.

use std::sync::{Mutex, PoisonError};

use burn::tensor::{Device, Gradients, Tensor, TensorData};

use super::params::{ParamId, Params, Role};

/// Whether gradients and batch statistics are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Records gradients; batch normalisation uses and updates the batch's statistics.
    Train,
    /// No gradients; batch normalisation uses the running statistics.
    Infer,
}

/// The numbers of a [`Params`] as tensors of one device, for one step.
///
/// The CPU keeps the numbers and the optimiser's state, so that a checkpoint is exact and a resumed run
/// identical; a step sends them to the device and brings the gradients back.
pub struct Graph {
    device: Device,
    mode: Mode,
    leaves: Vec<Tensor<1>>,
    shapes: Vec<Vec<usize>>,
    statistics: Mutex<Vec<(ParamId, Tensor<1>)>>,
}

/// A device that computes on this machine's processor.
pub fn cpu_device() -> Device {
    Device::flex()
}

/// The device that trains: the GPU when the program was built with the feature `gpu`, else the processor.
pub fn training_device() -> Device {
    #[cfg(feature = "gpu")]
    return Device::wgpu(burn::tensor::DeviceKind::DefaultDevice);
    #[cfg(not(feature = "gpu"))]
    cpu_device()
}

/// A tensor of numbers in C order.
///
/// # Panics
/// When `values` does not fill `shape`: a bug of the caller.
pub fn tensor<const D: usize>(values: Vec<f32>, shape: [usize; D], device: &Device) -> Tensor<D> {
    Tensor::from_data(TensorData::new(values, shape), device)
}

/// The numbers of a tensor, C order.
///
/// # Panics
/// When the device fails, which the processor never does.
pub fn numbers<const D: usize>(tensor: &Tensor<D>) -> Vec<f32> {
    tensor.try_to_vec_as::<f32>().expect("the device gives its numbers back")
}

impl Graph {
    /// Puts `params` on `device`.
    pub fn new(params: &Params, mode: Mode, device: &Device) -> Self {
        let device = match mode {
            Mode::Train => device.clone().autodiff(),
            Mode::Infer => device.clone(),
        };
        let leaf = |entry: &super::params::Entry| {
            let leaf = tensor(entry.values.clone(), [entry.values.len()], &device);
            if mode == Mode::Train && entry.role == Role::Trained { leaf.require_grad() } else { leaf }
        };
        Self {
            leaves: params.entries().iter().map(leaf).collect(),
            shapes: params.entries().iter().map(|e| e.shape.clone()).collect(),
            statistics: Mutex::default(),
            device,
            mode,
        }
    }

    /// The device of all tensors of this step.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Whether this step trains.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The array `id` with its declared shape, which has `D` axes.
    pub fn param<const D: usize>(&self, id: ParamId) -> Tensor<D> {
        let shape: [usize; D] = std::array::from_fn(|axis| self.shapes[id.index()][axis]);
        self.leaves[id.index()].clone().reshape(shape)
    }

    /// Notes the new value of a running statistic.
    pub fn note_statistic(&self, id: ParamId, value: Tensor<1>) {
        self.statistics.lock().unwrap_or_else(PoisonError::into_inner).push((id, value));
    }

    /// The gradient of every array; zero for what the loss does not depend on.
    pub fn gradients(&self, gradients: &mut Gradients) -> Vec<Vec<f32>> {
        let read = |leaf: &Tensor<1>| match leaf.grad_remove(gradients) {
            Some(gradient) => numbers(&gradient),
            None => Vec::new(),
        };
        self.leaves.iter().map(read).collect()
    }

    /// The running statistics that the forward pass changed.
    pub fn statistics(&self) -> Vec<(ParamId, Vec<f32>)> {
        self.statistics
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .iter()
            .map(|(id, value)| (*id, numbers(value)))
            .collect()
    }
}
