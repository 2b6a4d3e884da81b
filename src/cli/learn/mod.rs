//! `inhabit learn`: statistics of people, from annotated photos and from motion clips.

mod actions;
mod figures;
mod poses;

use clap::Subcommand;

use super::Ended;

/// What can be learned.
#[derive(Subcommand, Debug)]
pub enum Learn {
    /// What people do where, with which objects and how these lie, from annotations of photos.
    Actions(actions::Arguments),
    /// The dictionary that tells people's poses in space from their joints in a photo, from motion clips.
    Poses(poses::Arguments),
}

/// Runs the command.
///
/// # Errors
/// When the data can't be used or a file can't be read or written.
pub fn run(subject: &Learn) -> anyhow::Result<Ended> {
    match subject {
        Learn::Actions(arguments) => actions::run(arguments),
        Learn::Poses(arguments) => poses::run(arguments),
    }
}
