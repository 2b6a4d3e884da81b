//! Which foot stands when, and where: LTM's sub-sequences of the nearer foot, and our places of planted feet.

use std::ops::Range;

use glam::Vec3;

use super::fitter::SequenceTask;
use crate::body::{Feet, FootPose, FrameJoints, Limb};
use crate::math::Smoother;
use crate::scene::SignedDistanceField;

/// Frames in which one foot is stable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// Which frames.
    pub frames: Range<usize>,
    /// 0 left, 1 right.
    pub side: usize,
}

/// LTM §3.4: in each step the foot that moves less is the stable one; sub-sequences of the same foot. `ankles` are the
/// left and the right ankle of each frame, metres.
pub fn nearer_foot_runs(ankles: &[[Vec3; 2]]) -> Vec<Run> {
    let step = |i: usize, side: usize| ankles[i + 1][side].distance_squared(ankles[i][side]);
    let steps = ankles.len().saturating_sub(1);
    let stable = |i: usize| match i.min(steps.saturating_sub(1)) {
        _ if steps == 0 => 0,
        i => usize::from(step(i, 1) < step(i, 0)),
    };
    let mut runs: Vec<Run> = Vec::new();
    for i in 0..ankles.len() {
        match runs.last_mut() {
            Some(run) if run.side == stable(i) => run.frames.end = i + 1,
            _ => runs.push(Run { frames: i..i + 1, side: stable(i) }),
        }
    }
    runs
}

/// Where each foot stands in each frame in which it is planted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FootPlan {
    /// Left and right of each frame.
    pub places: Vec<[Option<FootPose>; 2]>,
}

/// A planted foot is put on what is under it if that is this near, metres: farther off it is not planted but wrong.
const SETTLE_M: f32 = 0.12;
/// Feet keep this from furniture and walls, metres.
const CLEAR_M: f32 = 0.015;
/// This high over its sole a foot is wide; what is lower is floor or threshold, metres.
const OVER_SOLE_M: f32 = 0.04;
/// Farthest that a planted foot is moved out of furniture, metres.
const PUSH_M: f32 = 0.3;
/// Steps of pushing a foot out.
const PUSHES: usize = 24;
/// Ground is what rises no steeper than this: cosine of 45 degrees.
const GROUND_NORMAL: f32 = 0.7;
/// Heights settle smoothly over some four frames, and over some fifteen where a pinned frame has another height.
const SETTLE_SMOOTHING: [f32; 2] = [2.0, 30.0];

impl FootPlan {
    /// Places the planted feet of a motion so that none slides: each stance keeps the motion's own turns of the foot
    /// and rolls over whichever of heel, ball and toes moves least, at the height of the ground, out of furniture. A
    /// stance that begins or ends pinned keeps the pinned place.
    pub fn of(
        feet: &Feet,
        field: &SignedDistanceField,
        task: &SequenceTask<'_>,
        figures: &[FrameJoints],
    ) -> Self {
        let mut plan = Self { places: vec![[None; 2]; figures.len()] };
        for side in 0..2 {
            for stance in stances(task, side, figures.len()) {
                let poses: Vec<FootPose> = stance.clone().map(|i| foot_of(&figures[i], side)).collect();
                let pinned: Vec<bool> = stance.clone().map(|i| task.is_pinned(i, figures.len())).collect();
                let placed = Stance { feet, field, side, pinned: &pinned }.place(poses);
                for (i, pose) in stance.zip(placed) {
                    plan.places[i][side] = Some(pose);
                }
            }
        }
        plan
    }
}

/// The foot of a posed frame.
pub fn foot_of(figure: &FrameJoints, side: usize) -> FootPose {
    let ankle = Limb::LEGS[side].end;
    FootPose {
        ankle: figure.positions[ankle],
        foot: figure.rotations[ankle],
        toes: figure.rotations[ankle + TOES_AFTER_ANKLE],
    }
}

/// The ball joint stands three after its ankle in the order of joints.
pub const TOES_AFTER_ANKLE: usize = 3;

fn stances(task: &SequenceTask<'_>, side: usize, frames: usize) -> Vec<Range<usize>> {
    let planted = |i: usize| task.planted.get(i).is_some_and(|p| p[side]);
    let mut found: Vec<Range<usize>> = Vec::new();
    for i in (0..frames).filter(|i| planted(*i)) {
        match found.last_mut() {
            Some(stance) if stance.end == i => stance.end = i + 1,
            _ => found.push(i..i + 1),
        }
    }
    found
}

/// One foot from when it is put down to when it is lifted.
struct Stance<'a> {
    feet: &'a Feet,
    field: &'a SignedDistanceField,
    side: usize,
    pinned: &'a [bool],
}

impl Stance<'_> {
    fn place(&self, mut poses: Vec<FootPose>) -> Vec<FootPose> {
        let mut offsets = self.standing_offsets(&poses);
        self.keep_pins(&mut offsets);
        poses.iter_mut().zip(&offsets).for_each(|(pose, offset)| pose.ankle += *offset);
        if !self.pinned.contains(&true) {
            let push = self.push_out(&poses);
            poses.iter_mut().for_each(|pose| pose.ankle += push);
        }
        let mut lifts: Vec<f32> = poses.iter().map(|pose| -self.height_m(pose)).collect();
        let smoothing = SETTLE_SMOOTHING[usize::from(self.pinned.contains(&true))];
        Smoother::new(smoothing, self.pinned).smooth(&mut lifts, 1);
        poses.iter_mut().zip(&lifts).for_each(|(pose, lift)| pose.ankle.y += *lift);
        poses
    }

    /// What to add to each place so that the tread that moves least from frame to frame does not move at all.
    fn standing_offsets(&self, poses: &[FootPose]) -> Vec<Vec3> {
        let treads: Vec<_> = poses.iter().map(|pose| self.feet.treads(self.side, pose)).collect();
        let mut offsets = vec![Vec3::ZERO; poses.len()];
        for i in 1..poses.len() {
            let steps = (0..treads[i].len()).map(|t| (treads[i][t] - treads[i - 1][t]).with_y(0.0));
            let least = steps.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
            offsets[i] = offsets[i - 1] - least.unwrap_or(Vec3::ZERO);
        }
        offsets
    }

    /// Shifts the offsets so that they are zero at pinned frames, or in the mean where none is pinned. Two pinned ends
    /// that disagree share their difference out over the frames between.
    fn keep_pins(&self, offsets: &mut [Vec3]) {
        let n = offsets.len();
        let leading = self.pinned.iter().take_while(|p| **p).count();
        let trailing = self.pinned.iter().rev().take_while(|p| **p).count();
        match (leading, trailing) {
            (0, 0) => {
                let mean = offsets.iter().sum::<Vec3>() / n.max(1) as f32;
                offsets.iter_mut().for_each(|o| *o -= mean);
            }
            (0, _) => {
                let at = offsets[n - trailing];
                offsets.iter_mut().for_each(|o| *o -= at);
            }
            (leading, _) => {
                let at = offsets[leading - 1];
                offsets.iter_mut().for_each(|o| *o -= at);
                if trailing > 0 && leading < n {
                    let (from, to) = (leading - 1, n - trailing);
                    let rest = offsets[to];
                    for i in from..to {
                        offsets[i] -= rest * ((i - from) as f32 / (to - from) as f32);
                    }
                }
            }
        }
        offsets.iter_mut().zip(self.pinned).filter(|(_, p)| **p).for_each(|(o, _)| *o = Vec3::ZERO);
    }

    /// The horizontal shift that brings the whole stance out of what stands on the floor.
    fn push_out(&self, poses: &[FootPose]) -> Vec3 {
        let every = poses.len().div_ceil(4).max(1);
        let points: Vec<Vec3> = poses
            .iter()
            .step_by(every)
            .flat_map(|pose| self.feet.sole(self.side, pose))
            .map(|p| p + Vec3::Y * OVER_SOLE_M)
            .collect();
        let mut shift = Vec3::ZERO;
        for _ in 0..PUSHES {
            let depth = |p: &Vec3| {
                let (d, gradient) = self.field.sample_gradient(*p + shift);
                (CLEAR_M.min(OVER_SOLE_M * 0.5) - d, gradient.with_y(0.0))
            };
            let aside = points.iter().map(depth).filter(|(lack, aside)| *lack > 0.0 && aside.length() > 0.3);
            let Some((lack, aside)) = aside.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            shift += aside.normalize_or_zero() * lack.min(0.05);
            shift = shift.clamp_length_max(PUSH_M);
        }
        shift
    }

    /// Height of the lowest point of the sole over the ground, metres; 0 where there is none within reach.
    fn height_m(&self, pose: &FootPose) -> f32 {
        let heights = self.feet.sole(self.side, pose).filter_map(|p| ground_below_m(self.field, p));
        let lowest = heights.fold(f32::INFINITY, f32::min);
        if lowest.abs() < SETTLE_M { lowest } else { 0.0 }
    }
}

/// Height of a point over the ground, negative under it; `None` where the nearest surface is no ground.
pub fn ground_below_m(field: &SignedDistanceField, point: Vec3) -> Option<f32> {
    let (d, gradient) = field.sample_gradient(point);
    (gradient.y > GROUND_NORMAL).then(|| d / gradient.y)
}
