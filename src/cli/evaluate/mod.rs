//! `inhabit evaluate`: the papers' tables as Markdown, CSV and JSON.

mod estimation;
mod refine;

use clap::{Args, Subcommand};

use super::Ended;

/// Arguments of `evaluate`.
#[derive(Args, Debug)]
pub struct EvaluateArguments {
    /// What is evaluated.
    #[command(subcommand)]
    pub subject: Subject,
}

/// What can be evaluated.
#[derive(Subcommand, Debug)]
pub enum Subject {
    /// Bodies from keypoints in pictures: SMPLify-X, PROX and PROX with the scene's prior (PSI table 5).
    Estimation(estimation::EstimationArguments),
    /// Disturbed and randomly placed people before and after fitting, in any rooms (PSI table 3).
    Refine(refine::RefineArguments),
}

/// Runs the command.
///
/// # Errors
/// When a room or corpus can't be read or the output can't be written.
pub fn run(arguments: &EvaluateArguments) -> anyhow::Result<Ended> {
    match &arguments.subject {
        Subject::Estimation(arguments) => estimation::run(arguments),
        Subject::Refine(arguments) => refine::run(arguments),
    }
}
