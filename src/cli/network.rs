//! Networks of PSI for the commands: those that come with the program, or weights from a file.

use std::fs;
use std::ops::Deref;
use std::path::Path;

use anyhow::Context as _;

use crate::assets::Weights;
use crate::generate::learned::{LearnedMethod, LearnedSampler};
use crate::nn::psi::PsiMethod;

/// A network to sample from.
pub enum Network {
    /// Came with the program.
    Bundled(&'static LearnedSampler),
    /// From a file.
    Own(Box<LearnedSampler>),
}

impl Network {
    /// The network of `method` that came with the program, or that of the file `weights` in its stead.
    ///
    /// # Errors
    /// When no weights are there or the file can't be used.
    pub fn of(method: PsiMethod, weights: Option<&Path>) -> anyhow::Result<Self> {
        let Some(file) = weights else {
            return Ok(Self::Bundled(LearnedSampler::bundled(LearnedMethod::best_of(method))?));
        };
        Ok(Self::Own(Box::new(LearnedSampler::from_weights(&read_weights(file)?)?)))
    }
}

impl Deref for Network {
    type Target = LearnedSampler;

    fn deref(&self) -> &LearnedSampler {
        match self {
            Self::Bundled(network) => network,
            Self::Own(network) => network,
        }
    }
}

/// The weights in a file.
///
/// # Errors
/// When it can't be read or holds none.
pub fn read_weights(file: &Path) -> anyhow::Result<Weights> {
    let bytes = fs::read(file).with_context(|| format!("can't read {}", file.display()))?;
    Ok(Weights::from_bytes(&file.display().to_string(), &bytes)?)
}
