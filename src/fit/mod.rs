//! Fits bodies to a room by descent on energies: one body by PSI's eq. 8 as published, and by ours that can rescue; a
//! motion by LTM's eq. 5 to 7, and by ours.
//!
//! Pure: no files, no egui. May not name `generate` or `motion`. Deterministic for a given start and
//! configuration; the optimiser's state never leaks from body to body.

mod config;
mod energy;
pub mod estimation;
mod fitter;
mod goals;
mod probe;
pub mod sequence;
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
