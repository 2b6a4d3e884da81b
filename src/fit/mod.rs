//! Fits one body to a room by descent on energies: PSI's eq. 8 as published, and ours that can rescue.
//!
//! Pure: no files, no egui. May not name `generate` or `motion`. Deterministic for a given start and
//! configuration; the optimiser's state never leaks from body to body.

mod config;
mod energy;
pub mod estimation;
mod fitter;
mod goals;
mod probe;
mod set_down;
mod surroundings;
mod terms;
#[cfg(test)]
mod tests;

pub use config::{FitConfig, FitPreset, Objective, PsiWeights, Weights};
pub use energy::{Energy, TERMS, Term};
pub use fitter::{Fitted, Fitter, Trace};
pub use goals::{ContactGoal, contact_goals};
pub use probe::{BoneSphere, Limb, bone_spheres};
pub use surroundings::Surroundings;
pub use terms::{Distances, psi_collision, psi_contact};
