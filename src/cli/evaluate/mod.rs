//! `inhabit evaluate`: the papers' tables as Markdown, CSV, JSON and charts.

mod charts;
mod psi;

use clap::{Args, Subcommand};

use super::Ended;

/// Arguments of `evaluate`.
#[derive(Args, Debug)]
pub struct EvaluateArguments {
    /// Which tables.
    #[command(subcommand)]
    pub tables: Tables,
}

/// The tables that can be made.
#[derive(Subcommand, Debug)]
pub enum Tables {
    /// PSI's Tables 1, 2 and 3: reconstruction, diversity, physical plausibility.
    Psi(psi::PsiArguments),
}

/// Runs the command.
///
/// # Errors
/// When rooms or weights can't be read or the output can't be written.
pub fn run(arguments: &EvaluateArguments) -> anyhow::Result<Ended> {
    match &arguments.tables {
        Tables::Psi(arguments) => psi::run(arguments),
    }
}
