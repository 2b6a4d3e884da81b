//! The networks of PSI ("Generating 3D People in Scenes without People"): S1, S2 and the modified baseline.
//!
//! May not know rooms, cameras or the body model: pictures, 75 numbers and codes are plain numbers here.

mod baseline;
mod config;
mod input;
mod network;
mod s1;
mod s2;
#[cfg(test)]
mod tests;
mod trunk;

pub use super::vae::Posterior;
pub use baseline::{
    DISCRIMINATOR_VERTICES, Discriminator, GAP_M, POSE_CODE, VERTEX_FEATURES, nearest_centre,
};
pub use config::{
    BODY, CLASSES, GLOBAL, IMAGE, LOCAL, PsiConfig, PsiMethod, Semantics, Stem, TrunkConfig, psi_adam,
};
pub use input::{CLIP_M, MPCAT40, SceneInput, SceneTensors, ValidArea};
pub use network::{CONFIG_NOTE, PsiNetwork, PsiSampler, Reconstructed, Reconstruction, normalized};
