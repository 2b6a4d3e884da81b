//! Network building blocks and weight files: with `learn` the only place that names the machine-learning
//! framework (burn).
//!
//! May name `math` and `assets` only: knows no rooms, no bodies, no files. Samplers take and give plain
//! numbers. Numbers and optimiser state live on the CPU ([`Params`], [`NetworkAdam`]), drawn from our own
//! seeds, so that the same seed gives the same bytes and a resumed training goes on to the bit.

mod adam;
mod graph;
mod layers;
pub mod motion;
mod params;
mod pose_vae;
pub mod psi;
mod vae;

pub use adam::NetworkAdam;
pub use graph::{Graph, Mode, cpu_device, numbers, tensor, training_device};
pub use layers::{BasicBlock, BatchNorm, Conv, ConvShape, LEAKY_SLOPE, Linear, ResBlock, ResPair, max_pool};
pub use params::{Declaration, Entry, Init, ParamId, Params, Role};
pub use pose_vae::{PoseVae, VAE_CODE, VAE_POSE, VAE_SIX, VAE_SLOPE, VaeBatch, VaeCodes, VaeGradient};
