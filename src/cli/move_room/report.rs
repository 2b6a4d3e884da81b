//! The report of `move`. Field names are a contract with people's scripts: add, never rename.

use serde::Serialize;

use crate::cli::report::RoomRow;
use crate::evolve::journey::{Journey, JourneySeconds};
use crate::inspect::{Finding, MotionLimits, MotionMetrics};
use crate::scene::{Leg, Room, SubGoal};

/// Findings of one clip that the report lists.
const MOST_FINDINGS: usize = 200;

/// The whole report.
#[derive(Clone, Debug, Serialize)]
pub struct MoveReport {
    /// Always `move`.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// Root of the seed tree.
    pub seed: u64,
    /// What was understood of the room.
    pub room: RoomRow,
    /// Who made the motion.
    pub method: String,
    /// Every person's motion.
    pub clips: Vec<ClipRow>,
    /// Where the time went.
    pub seconds: MoveSeconds,
    /// What drew the pictures.
    pub pictures_by: String,
}

impl MoveReport {
    /// Whether everything was done as asked.
    pub fn is_clean(&self) -> bool {
        self.clips.iter().all(|c| c.complaints.is_empty() && c.findings.is_empty())
    }
}

/// Wall-clock seconds of each stage.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct MoveSeconds {
    /// Reading and understanding the room.
    pub load: f64,
    /// Distance field, surfaces and ray tree.
    pub field: f64,
    /// Sub-goals, routes, poses and their fits.
    pub motion: f64,
    /// Files and pictures.
    pub write: f64,
    /// Everything.
    pub total: f64,
}

/// One motion.
#[derive(Clone, Debug, Serialize)]
pub struct ClipRow {
    /// Name for people.
    pub name: String,
    /// The animated file; beside it stand the same name's `.npz` and `.bvh`.
    pub file: String,
    /// Frames.
    pub frames: usize,
    /// Frames in a second.
    pub fps: f32,
    /// How long it lasts.
    pub seconds: f32,
    /// Every sub-goal, those that were planned too.
    pub goals: Vec<GoalRow>,
    /// From where to where, in the order of time.
    pub legs: Vec<LegRow>,
    /// What was measured of the whole.
    pub metrics: MotionMetrics,
    /// Everything above its limit, worst first; of the frames the worst alone.
    pub findings: Vec<Finding>,
    /// How many there are in all.
    pub findings_total: usize,
    /// What could not be done as asked.
    pub complaints: Vec<String>,
    /// Where somebody squeezes through: `[x, z, free radius]` in metres.
    pub squeezes: Vec<[f32; 3]>,
    /// Where this motion's time went.
    pub stage_seconds: JourneySeconds,
}

/// A sub-goal in a report.
#[derive(Clone, Debug, Serialize)]
pub struct GoalRow {
    /// Stable name.
    pub id: u32,
    /// The point that was asked for.
    pub at: [f32; 3],
    /// The facing that was asked for.
    pub facing_deg: Option<f32>,
    /// What is done there.
    pub pose: String,
    /// How long.
    pub stay_s: f32,
    /// Whether the planner put it in.
    pub planned: bool,
    /// What holds the body; for sub-goals that were asked for.
    pub on: Option<String>,
    /// From the point to the pelvis; for sub-goals that were asked for.
    pub miss_cm: Option<f32>,
    /// From the facing to the body's; for sub-goals that were asked for.
    pub miss_deg: Option<f32>,
}

/// A leg in a report.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LegRow {
    /// Sub-goal where it begins.
    pub from: u32,
    /// Sub-goal where it ends; the same for a stay.
    pub to: u32,
    /// First frame.
    pub first: usize,
    /// Last frame.
    pub last: usize,
}

impl ClipRow {
    /// The row of one motion, written to files of this stem.
    pub fn new(journey: &Journey, room: &Room, stem: &str) -> Self {
        let clip = &journey.clip;
        let mut findings = journey.motion.findings(clip.id.0, &MotionLimits::default());
        let findings_total = findings.len();
        findings.truncate(MOST_FINDINGS);
        Self {
            metrics: journey.motion.metrics,
            findings,
            findings_total,
            name: clip.name.clone(),
            file: format!("{stem}.glb"),
            frames: clip.frames.len(),
            fps: clip.fps,
            seconds: clip.seconds(),
            goals: clip.goals.iter().map(|g| goal_row(g, journey)).collect(),
            legs: clip.legs.iter().map(leg_row).collect(),
            complaints: journey.complaints(room),
            squeezes: journey.squeezes.iter().map(|(_, p, clear_m)| [p.x, p.z, *clear_m]).collect(),
            stage_seconds: journey.seconds,
        }
    }

    /// One line for people.
    pub fn in_words(&self) -> String {
        let asked = self.goals.iter().filter(|g| !g.planned).count();
        format!(
            "{}: {:.1} s in {} legs over {asked} sub-goals and {} planned ones; non-collision {:.2} %, contact {:.1} %, \
             deepest {:.0} mm, skate {:.1} cm/s, drift {:.1} cm, {} findings",
            self.name,
            self.seconds,
            self.legs.len(),
            self.goals.len() - asked,
            self.metrics.non_collision_pct,
            self.metrics.contact_pct,
            self.metrics.penetration_max_mm,
            self.metrics.skate_cm_per_s,
            self.metrics.stance_drift_cm,
            self.findings_total
        )
    }
}

fn goal_row(goal: &SubGoal, journey: &Journey) -> GoalRow {
    let met = journey.goals.iter().find(|g| g.goal == goal.id);
    GoalRow {
        id: goal.id.0,
        at: goal.at.to_array(),
        facing_deg: goal.facing.map(f32::to_degrees),
        pose: format!("{:?}", met.map_or(goal.pose, |m| m.pose)),
        stay_s: goal.stay_s,
        planned: goal.planned,
        on: met.map(|m| m.on.clone()),
        miss_cm: met.map(|m| m.miss_cm),
        miss_deg: met.map(|m| m.miss_deg),
    }
}

fn leg_row(leg: &Leg) -> LegRow {
    LegRow { from: leg.from.0, to: leg.to.0, first: leg.first, last: leg.last }
}
