//! Network building blocks and weight files: the only place that names the machine-learning framework.
//! May not know rooms, bodies or files beyond the weights it is given. Enters with the learned samplers.

mod pose_vae;

pub use pose_vae::{PoseVae, VAE_CODE, VAE_POSE, VAE_SIX, VAE_SLOPE, VaeBatch, VaeCodes, VaeGradient};
