//! `inhabit evaluate`: how good something is, as tables and pictures, one file a subject.

mod charts;
mod pose_prior;
mod psi;

use clap::Subcommand;

use super::Ended;

/// What can be evaluated.
#[derive(Subcommand, Debug)]
pub enum Evaluate {
    /// The pose prior: errors on held-out clips, samples and interpolations as pictures.
    PosePrior(pose_prior::Arguments),
    /// The paper's Tables 1, 2 and 3: reconstruction, diversity and physical plausibility of the networks, the search
    /// and chance, before and after fitting.
    Psi(psi::PsiArguments),
}

/// Runs the command.
///
/// # Errors
/// When the data can't be used or a file can't be read or written.
pub fn run(subject: &Evaluate) -> anyhow::Result<Ended> {
    match subject {
        Evaluate::PosePrior(arguments) => pose_prior::run(arguments),
        Evaluate::Psi(arguments) => psi::run(arguments),
    }
}
