//! `inhabit evaluate`: how good something is, as tables and pictures, one file a subject.

mod estimation;
mod pose_prior;
mod refine;

use clap::Subcommand;

use super::Ended;

/// What can be evaluated.
#[derive(Subcommand, Debug)]
pub enum Evaluate {
    /// Bodies from keypoints in pictures: SMPLify-X, PROX, and PROX with the scene's prior (PSI table 5).
    Estimation(estimation::EstimationArguments),
    /// Disturbed and randomly placed people before and after fitting, in any rooms (PSI table 3).
    Refine(refine::RefineArguments),
    /// The pose prior: errors on held-out clips, samples and interpolations as pictures.
    PosePrior(pose_prior::Arguments),
}

/// Runs the command.
///
/// # Errors
/// When the data can't be used or a file can't be read or written.
pub fn run(subject: &Evaluate) -> anyhow::Result<Ended> {
    match subject {
        Evaluate::Estimation(arguments) => estimation::run(arguments),
        Evaluate::Refine(arguments) => refine::run(arguments),
        Evaluate::PosePrior(arguments) => pose_prior::run(arguments),
    }
}
