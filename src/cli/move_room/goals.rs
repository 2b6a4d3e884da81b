//! Sub-goals from a file: `[(at: (x, y, z), facing_deg: Some(0.0), pose: Stand, stay_s: 0.0), ...]`.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, ensure};
use glam::Vec3;
use serde::Deserialize;

use crate::scene::{GoalPose, SubGoal, SubGoalId};

/// Goals of one person that a file may hold: an hour of them.
const MOST_GOALS: usize = 10_000;
/// Nobody stays longer than this at one place, seconds.
const LONGEST_STAY_S: f32 = 3600.0;

/// One sub-goal as people write it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GoalText {
    at: (f32, f32, f32),
    #[serde(default)]
    facing_deg: Option<f32>,
    #[serde(default)]
    pose: GoalPose,
    #[serde(default)]
    stay_s: f32,
}

/// Reads a list of sub-goals; their ids count from 0.
///
/// # Errors
/// When the file can't be read, is no such list, or a number makes no sense; the message names the place.
pub fn read(file: &Path) -> anyhow::Result<Vec<SubGoal>> {
    let text =
        fs::read_to_string(file).with_context(|| format!("can't read the goals {}", file.display()))?;
    parse(&text).with_context(|| format!("the goals {} can't be used", file.display()))
}

fn parse(text: &str) -> anyhow::Result<Vec<SubGoal>> {
    let goals: Vec<GoalText> = ron::from_str(text).map_err(|error| {
        anyhow::anyhow!(
            "line {}, column {}: {}; write a list like [(at: (1.0, 0.0, 2.0), facing_deg: Some(90.0), pose: Sit, stay_s: \
             5.0)]",
            error.span.start.line,
            error.span.start.col,
            error.code
        )
    })?;
    ensure!(!goals.is_empty(), "the list is empty: write at least one sub-goal");
    ensure!(goals.len() <= MOST_GOALS, "{} sub-goals are more than {MOST_GOALS}", goals.len());
    goals.iter().enumerate().map(|(index, goal)| sub_goal(index, goal)).collect()
}

fn sub_goal(index: usize, goal: &GoalText) -> anyhow::Result<SubGoal> {
    let at = Vec3::from(goal.at);
    let number = index + 1;
    ensure!(at.is_finite(), "sub-goal {number}: {at} is no point");
    ensure!(goal.facing_deg.is_none_or(f32::is_finite), "sub-goal {number}: facing_deg must be a number");
    ensure!(
        (0.0..=LONGEST_STAY_S).contains(&goal.stay_s),
        "sub-goal {number}: stay_s is {}, write 0 to {LONGEST_STAY_S} seconds",
        goal.stay_s
    );
    Ok(SubGoal {
        id: SubGoalId(index as u32),
        at,
        facing: goal.facing_deg.map(f32::to_radians),
        pose: goal.pose,
        stay_s: goal.stay_s,
        planned: false,
        locked: false,
        body: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_read_as_people_write_them_and_what_is_left_out_is_left_to_the_planner() {
        let goals = parse(
            "[(at: (1, 0.0, -2.5), facing_deg: Some(90.0), pose: Sit, stay_s: 4.0), (at: (0.0, 0.0, 0.0))]",
        )
        .expect("a list of goals");
        assert_eq!(goals[0].at, Vec3::new(1.0, 0.0, -2.5));
        assert_eq!((goals[0].pose, goals[0].stay_s), (GoalPose::Sit, 4.0));
        assert!((goals[0].facing.expect("said") - std::f32::consts::FRAC_PI_2).abs() < 1e-4);
        assert_eq!((goals[1].id, goals[1].pose, goals[1].facing), (SubGoalId(1), GoalPose::Any, None));
    }

    #[test]
    fn what_makes_no_sense_is_refused_with_its_place() {
        for (text, said) in [
            ("[(at: (1.0, 0.0))]", "line 1"),
            ("[]", "empty"),
            ("[(at: (0.0, 0.0, 0.0), stay_s: -1.0)]", "stay_s"),
            ("[(at: (0.0, 0.0, 0.0), pose: Fly)]", "Fly"),
            ("[(at: (NaN, 0.0, 0.0))]", "no point"),
        ] {
            let error = format!("{:#}", parse(text).expect_err(text));
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
