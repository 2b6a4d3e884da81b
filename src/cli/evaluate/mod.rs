//! `inhabit evaluate`: how good something is, as tables and pictures, one file a subject.

mod charts;
mod estimation;
mod groups;
mod motion;
mod pose_prior;
mod psi;
mod refine;

use clap::Subcommand;

use super::Ended;

/// What can be evaluated.
#[derive(Subcommand, Debug)]
pub enum Evaluate {
    /// Bodies from keypoints in pictures: SMPLify-X, PROX, and PROX with the scene's prior (PSI table 5).
    Estimation(estimation::EstimationArguments),
    /// Groups at a table: what they share within everybody's reach, beside ADSE's baseline.
    Groups(groups::GroupsArguments),
    /// Disturbed and randomly placed people before and after fitting, in any rooms (PSI table 3).
    Refine(refine::RefineArguments),
    /// The pose prior: errors on held-out clips, samples and interpolations as pictures.
    PosePrior(pose_prior::Arguments),
    /// The paper's Tables 1, 2 and 3: reconstruction, diversity and physical plausibility of the networks, the search
    /// and chance, before and after fitting.
    Psi(psi::PsiArguments),
    /// Long-term motion: LTM's Tables 1, 2 and 4 on held-out clips in staged rooms, and feet, depth and joins.
    Motion(motion::MotionArguments),
}

/// Runs the command.
///
/// # Errors
/// When the data can't be used or a file can't be read or written.
pub fn run(subject: &Evaluate) -> anyhow::Result<Ended> {
    match subject {
        Evaluate::Estimation(arguments) => estimation::run(arguments),
        Evaluate::Groups(arguments) => groups::run(arguments),
        Evaluate::Refine(arguments) => refine::run(arguments),
        Evaluate::PosePrior(arguments) => pose_prior::run(arguments),
        Evaluate::Psi(arguments) => psi::run(arguments),
        Evaluate::Motion(arguments) => motion::run(arguments),
    }
}
