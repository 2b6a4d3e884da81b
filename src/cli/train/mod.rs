//! `inhabit train`: statistics and networks learned from data, one file a subject.

pub mod curve;
mod gait;
mod hand_space;
mod motion;
mod pose_prior;
mod psi;

use std::fs;
use std::path::Path;

use anyhow::Context as _;
use clap::Subcommand;

use super::Ended;
use crate::assets::Weights;
use crate::nn::motion::{Between, MotionKind};

/// What can be learned.
#[derive(Subcommand, Debug)]
pub enum Train {
    /// The variational prior over body poses, from motion clips and the program's own pose families.
    PosePrior(pose_prior::Arguments),
    /// The Gaussian over hand poses, from motion clips and the program's own hands.
    HandSpace(hand_space::Arguments),
    /// How people walk, from captured walks.
    Gait(gait::Arguments),
    /// The networks that put people into what a camera sees: S1, S2 and the baseline.
    Psi(psi::Arguments),
    /// PointNet, by labelling the points of staged rooms: where the networks of motion begin.
    Points(motion::Arguments),
    /// Bodies at the sub-goals of a motion.
    Subgoal(motion::Arguments),
    /// RouteNet: places and rotations between two bodies.
    Route(motion::RouteArguments),
    /// PoseNet: poses along a route.
    Pose(motion::PoseArguments),
    /// BaseNet: route and poses at once.
    Base(motion::Arguments),
}

/// Runs the command.
///
/// # Errors
/// When the data can't be used or a file can't be read or written.
pub fn run(subject: &Train) -> anyhow::Result<Ended> {
    match subject {
        Train::PosePrior(arguments) => pose_prior::run(arguments),
        Train::HandSpace(arguments) => hand_space::run(arguments),
        Train::Gait(arguments) => gait::run(arguments),
        Train::Psi(arguments) => psi::run(arguments),
        Train::Points(arguments) => motion::run(MotionKind::Points, arguments),
        Train::Subgoal(arguments) => motion::run(MotionKind::SubGoal, arguments),
        Train::Route(arguments) => motion::run_route(arguments),
        Train::Pose(arguments) => motion::run_pose(arguments),
        Train::Base(arguments) => motion::run(MotionKind::Between(Between::Base), arguments),
    }
}

/// The state of an earlier run.
fn read_checkpoint(file: &Path) -> anyhow::Result<Weights> {
    let bytes = fs::read(file).with_context(|| format!("can't read the checkpoint {}", file.display()))?;
    Ok(Weights::from_bytes(&file.display().to_string(), &bytes)?)
}
