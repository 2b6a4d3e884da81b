//! Metrics of a motion in a room, per frame for a timeline and per clip for tables and findings: LTM §4.3's, whose
//! "modified" contact score nobody defined (ours is [`MotionMetrics::contact_pct`]), and today's, which see feet
//! slide and bodies jerk.

mod errors;
mod feet;
mod flow;
mod frame;
mod limits;

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use serde::Serialize;

pub use errors::MotionErrors;
pub use feet::{stance_drift_m, tread_speed_m_per_s};
pub use flow::{jitter_m_per_s3, pop_ratio};
pub use frame::{DEEP_MM, FrameRecord};
pub use limits::MotionLimits;

use self::feet::Skate;
use self::frame::{FrameMeter, Measured};
use super::Finding;
use crate::body::Body;
use crate::body::joints::{NECK, PELVIS};
use crate::scene::{
    Clip, Frame, GoalPose, SignedDistanceField, Step, Stopped, SubGoal, SubGoalId, facing_of,
};

/// A foot that moves faster than this while planted is seen to slide, centimetres per second.
pub const SKATES_CM_PER_S: f32 = 2.0;

/// What was measured of one clip. Names are those of the reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MotionMetrics {
    /// LTM §4.3, PSI §4.1.4: share of vertices in free space, mean over the frames, per cent.
    pub non_collision_pct: f32,
    /// Share of frames in which some vertex of PROX's contact segments is within [`super::CONTACT_M`] of a surface or in
    /// something solid, per cent. Ours for LTM's undefined "modified contact score": PSI's own counts penetration only,
    /// so a body that rests exactly on the floor would score nothing.
    pub contact_pct: f32,
    /// Share of frames in which some vertex has a signed distance of zero or less (PSI §4.1.4), per cent.
    pub psi_contact_pct: f32,
    /// Deepest vertex in solid matter in any frame, millimetres.
    pub penetration_max_mm: f32,
    /// Mean depth of the penetrating vertices of all frames, millimetres.
    pub penetration_mean_mm: f32,
    /// Share of frames with a vertex deeper than [`DEEP_MM`], 0 to 1.
    pub collision_frame_share: f32,
    /// Mean speed along the floor of planted feet, each by the slowest of heel, ball and toe tip, cm/s.
    pub skate_cm_per_s: f32,
    /// Share of the planted feet's frames with more than [`SKATES_CM_PER_S`], 0 to 1.
    pub skate_frame_share: f32,
    /// How far the worst planted foot wandered from where it was put down, centimetres.
    pub stance_drift_cm: f32,
    /// Greatest height of a planted foot above what is under it, millimetres.
    pub hover_max_mm: f32,
    /// Greatest distance along the floor between the pelvis and where it was asked to be, centimetres.
    pub goal_error_cm: Option<f32>,
    /// Greatest difference between where the body faces at a sub-goal and where it was asked to, degrees.
    pub goal_error_deg: Option<f32>,
    /// LTM §4.3: mean distance of the vertices of each leg's two ends from those of the sub-goals' bodies, centimetres
    /// (the paper's ×100), mean over the ends.
    pub neighbour_v2v: Option<f32>,
    /// Worst ratio of the speed at a boundary of legs to that beside it ([`pop_ratio`]).
    pub boundary_speed_ratio: Option<f32>,
    /// Mean size of the third derivative of the body joints' places, m/s³.
    pub jitter_m_per_s3: f32,
}

/// How well one sub-goal was met.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GoalError {
    /// Which.
    pub goal: SubGoalId,
    /// The frame at which the clip is there.
    pub frame: usize,
    /// Along the floor from the point asked for to the pelvis, centimetres.
    pub distance_cm: f32,
    /// Between where the body faces and where it was asked to, degrees; `None` where nothing was asked.
    pub facing_deg: Option<f32>,
}

/// Everything that is known about one clip in one room.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MotionReport {
    /// The numbers.
    pub metrics: MotionMetrics,
    /// One for each frame, for a timeline.
    pub frames: Vec<FrameRecord>,
    /// Of the sub-goals that somebody asked for, in their order.
    pub goals: Vec<GoalError>,
}

impl MotionReport {
    /// What is beyond its limit, worst first; `body` names the clip's person in the record.
    pub fn findings(&self, body: u32, limits: &MotionLimits) -> Vec<Finding> {
        limits.findings(body, self)
    }
}

/// Measures one clip in the room of `field` with every vertex of every frame, about a millisecond a frame, on all threads.
///
/// # Errors
/// [`Stopped`] when `step` breaks off; it is asked at every frame.
pub fn inspect_motion(
    field: &SignedDistanceField,
    body: &Body,
    clip: &Clip,
    step: Step,
) -> Result<MotionReport, Stopped> {
    let meter = FrameMeter::new(body, field, &clip.betas);
    let total = clip.frames.len();
    let measured = (0..total).into_par_iter().map_init(Default::default, |workspace, i| {
        if step(i, total).is_break() {
            return Err(Stopped);
        }
        Ok(meter.measure(&clip.frames[i], clip.planted.get(i).copied().unwrap_or_default(), workspace))
    });
    let mut measured = measured.collect::<Result<Vec<Measured>, Stopped>>()?;
    let skate = Skate::of(&measured, clip.fps);
    skate.mark(&mut measured);
    let goals = goal_errors(clip, &measured);
    let mut metrics = MotionMetrics::of_frames(&measured);
    metrics.skate_cm_per_s = skate.mean_cm_per_s;
    metrics.skate_frame_share = skate.frame_share;
    metrics.stance_drift_cm = skate.drift_cm;
    metrics.goal_error_cm = goals.iter().map(|g| g.distance_cm).reduce(f32::max);
    metrics.goal_error_deg = goals.iter().filter_map(|g| g.facing_deg).reduce(f32::max);
    metrics.neighbour_v2v = neighbour_v2v(&meter, clip);
    let joints: Vec<_> = measured.iter().map(|m| m.joints).collect();
    metrics.jitter_m_per_s3 = jitter_m_per_s3(&joints, clip.fps);
    let inner = clip.legs.iter().map(|leg| leg.last).filter(|last| *last > 0 && *last + 1 < total);
    metrics.boundary_speed_ratio = inner.map(|last| pop_ratio(&joints, last, clip.fps)).reduce(f32::max);
    Ok(MotionReport { metrics, frames: measured.into_iter().map(|m| m.record).collect(), goals })
}

impl MotionMetrics {
    /// What follows from each frame by itself.
    fn of_frames(measured: &[Measured]) -> Self {
        let count = measured.len().max(1) as f32;
        let mean =
            |of: &dyn Fn(&FrameRecord) -> f32| measured.iter().map(|m| of(&m.record)).sum::<f32>() / count;
        let most =
            |of: &dyn Fn(&FrameRecord) -> f32| measured.iter().map(|m| of(&m.record)).fold(0.0, f32::max);
        let share = |of: &dyn Fn(&FrameRecord) -> bool| mean(&|r| f32::from(u8::from(of(r))));
        let depth: f64 = measured.iter().map(|m| m.depth_sum_mm).sum();
        let deep: usize = measured.iter().map(|m| m.penetrating).sum();
        Self {
            non_collision_pct: 100.0 * mean(&|r| r.non_collision),
            contact_pct: 100.0 * share(&|r| r.contact),
            psi_contact_pct: 100.0 * share(&|r| r.psi_contact),
            penetration_max_mm: most(&|r| r.penetration_max_mm),
            penetration_mean_mm: (depth / deep.max(1) as f64) as f32,
            collision_frame_share: share(&|r| r.penetration_max_mm > DEEP_MM),
            hover_max_mm: most(&|r| r.hover_mm),
            ..Self::default()
        }
    }
}

/// The frame at which a clip is at a sub-goal: where the leg to it ends, or the first leg begins.
fn frame_of(clip: &Clip, goal: SubGoalId) -> Option<usize> {
    let arrives = clip.legs.iter().find(|leg| leg.to == goal && leg.from != goal).map(|leg| leg.last);
    arrives.or_else(|| clip.legs.iter().find(|leg| leg.from == goal).map(|leg| leg.first))
}

fn goal_errors(clip: &Clip, measured: &[Measured]) -> Vec<GoalError> {
    let error = |goal: &SubGoal| {
        let frame = frame_of(clip, goal.id)?;
        let at = measured.get(frame)?;
        let off = at.joints[PELVIS] - goal.at;
        let facing_deg = goal.facing.map(|asked| turn_deg(asked, facing(&clip.frames[frame], at, goal)));
        Some(GoalError { goal: goal.id, frame, distance_cm: off.with_y(0.0).length() * 100.0, facing_deg })
    };
    clip.goals.iter().filter(|goal| !goal.planned).filter_map(error).collect()
}

/// Where a body faces: its front, or, where it lies, where its trunk points from the head to the feet, however the legs
/// are drawn up.
fn facing(frame: &Frame, at: &Measured, goal: &SubGoal) -> f32 {
    let pose = goal.pose;
    let front = frame.rotation * Vec3::Z;
    let direction = match pose {
        GoalPose::Lie => to_feet(at),
        // Somebody who lies, though nobody asked for lying: the spine is nearer to level than to upright.
        GoalPose::Any if (frame.rotation * Vec3::Y).y < std::f32::consts::FRAC_1_SQRT_2 => to_feet(at),
        _ => front,
    };
    facing_of(Vec2::new(direction.x, direction.z))
}

fn to_feet(at: &Measured) -> Vec3 {
    at.joints[PELVIS] - at.joints[NECK]
}

fn turn_deg(a: f32, b: f32) -> f32 {
    let turn = (a - b).rem_euclid(std::f32::consts::TAU);
    turn.min(std::f32::consts::TAU - turn).to_degrees()
}

/// Both ends of every leg against the bodies of its sub-goals, where they are known.
fn neighbour_v2v(meter: &FrameMeter<'_>, clip: &Clip) -> Option<f32> {
    let body_of = |goal: SubGoalId| clip.goal(goal)?.body.as_ref();
    let ends = clip.legs.iter().flat_map(|leg| [(leg.from, leg.first), (leg.to, leg.last)]);
    let distances: Vec<f32> = ends
        .filter_map(|(goal, frame)| Some(meter.distance_m(clip.frames.get(frame)?, body_of(goal)?) * 100.0))
        .collect();
    (!distances.is_empty()).then(|| distances.iter().sum::<f32>() / distances.len() as f32)
}

#[cfg(test)]
mod tests;
