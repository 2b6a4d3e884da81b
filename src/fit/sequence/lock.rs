//! The hard last pass: planted feet stand exactly where the plan says, by analytic inverse kinematics; in between the
//! corrections fade into each other, so nothing jumps. Pinned frames are never touched.

use glam::{Quat, Vec3};
use rayon::prelude::*;

use super::fitter::SequenceTask;
use super::stance::{FootPlan, TOES_AFTER_ANKLE, foot_of, ground_below_m};
use crate::body::joints::JOINTS;
use crate::body::{Feet, FootPose, FrameJoints, Limb};
use crate::math::Smoother;
use crate::scene::{Frame, SignedDistanceField};

/// A leg is stretched to this share of its length at most.
const LONGEST_SHARE: f32 = 0.9995;
/// A knee bends to this inner angle at least, radians: 145 degrees of flexion.
const LEAST_INNER_ANGLE: f32 = 0.61;
/// Frames over which the pelvis goes down and up again where a leg is too short.
const SINK_FRAMES: usize = 6;
/// Farthest that the pelvis goes down: a foot that is farther off stays short of its place.
const SINK_M: f32 = 0.06;
/// A swinging foot that would scrape the ground is lifted to this height, metres.
const SWING_CLEAR_M: f32 = 0.002;

/// What is added to a foot: a shift, and a turn as a rotation vector about world axes.
#[derive(Clone, Copy, Debug, Default)]
struct Correction {
    shift: Vec3,
    turn: Vec3,
    toes: Vec3,
}

/// The body and the room of a lock.
pub struct Lock<'a> {
    /// Rest joints of the body's shape.
    pub rest: &'a [Vec3; JOINTS],
    /// Its feet.
    pub feet: &'a Feet,
    /// The room.
    pub field: &'a SignedDistanceField,
    /// Where the planted feet stand.
    pub plan: &'a FootPlan,
    /// What is known of the motion.
    pub task: &'a SequenceTask<'a>,
}

impl Lock<'_> {
    /// Locks the planted feet of all frames. Returns by how much the worst leg is still too short, metres.
    pub fn apply(&self, frames: &mut [Frame]) -> f32 {
        let total = frames.len();
        let mut figures = self.figures(frames);
        let mut targets = self.targets(&figures);
        self.lift_swings(&figures, &mut targets);
        let sinks = self.sinks(&figures, &targets);
        let work = frames.par_iter_mut().zip(&mut figures).enumerate();
        let short: Vec<f32> = work
            .map(|(i, (frame, figure))| {
                if self.task.is_pinned(i, total) {
                    return 0.0;
                }
                frame.translation.y -= sinks[i];
                figure.positions.iter_mut().for_each(|p| p.y -= sinks[i]);
                let moved: f32 = (0..2)
                    .map(|side| shift_foot(figure, self.rest, side, &targets[i][side]))
                    .fold(0.0, f32::max);
                let pose = figure.pose();
                for side in 0..2 {
                    let leg = &Limb::LEGS[side];
                    for joint in [leg.upper, leg.lower, leg.end, leg.end + TOES_AFTER_ANKLE] {
                        frame.pose[joint - 1] = pose[joint - 1];
                    }
                }
                moved
            })
            .collect();
        short.into_iter().fold(0.0, f32::max)
    }

    fn figures(&self, frames: &[Frame]) -> Vec<FrameJoints> {
        frames.par_iter().map(|frame| FrameJoints::of(self.rest, frame)).collect()
    }

    /// Where both feet of every frame should be.
    fn targets(&self, figures: &[FrameJoints]) -> Vec<[FootPose; 2]> {
        let both: [Vec<FootPose>; 2] = std::array::from_fn(|side| {
            let present: Vec<FootPose> = figures.iter().map(|figure| foot_of(figure, side)).collect();
            let known: Vec<Option<Correction>> = (0..present.len())
                .map(|i| match self.plan.places[i][side] {
                    _ if self.task.is_pinned(i, present.len()) => Some(Correction::default()),
                    Some(place) => Some(Correction::between(&present[i], &place)),
                    None => None,
                })
                .collect();
            present.iter().zip(filled(&known)).map(|(pose, c)| c.applied_to(pose)).collect()
        });
        let [left, right] = both;
        left.into_iter().zip(right).map(|(l, r)| [l, r]).collect()
    }

    /// A correction that fades over a swing may push the foot into the ground: it is lifted there.
    fn lift_swings(&self, figures: &[FrameJoints], targets: &mut [[FootPose; 2]]) {
        let total = figures.len();
        for side in 0..2 {
            let held: Vec<bool> = (0..total)
                .map(|i| self.plan.places[i][side].is_some() || self.task.is_pinned(i, total))
                .collect();
            let mut lifts: Vec<f32> = (0..total)
                .map(|i| {
                    let heights = |pose| {
                        self.feet
                            .sole(side, pose)
                            .filter_map(|p| ground_below_m(self.field, p))
                            .fold(f32::INFINITY, f32::min)
                    };
                    // Only what this pass did: a foot that came in low is the descent's affair.
                    let (was, is) = (heights(&foot_of(&figures[i], side)), heights(&targets[i][side]));
                    if held[i] || is >= SWING_CLEAR_M || !is.is_finite() {
                        0.0
                    } else {
                        (SWING_CLEAR_M.min(was.max(is)) - is).max(0.0)
                    }
                })
                .collect();
            Smoother::new(1.0, &held).smooth(&mut lifts, 1);
            targets.iter_mut().zip(&lifts).for_each(|(t, lift)| t[side].ankle.y += lift.max(0.0));
        }
    }

    /// How far the pelvis of each frame goes down so that both legs reach, smooth in time; 0 at pinned frames.
    fn sinks(&self, figures: &[FrameJoints], targets: &[[FootPose; 2]]) -> Vec<f32> {
        let total = figures.len();
        let needed: Vec<f32> = (0..total)
            .map(|i| {
                let of = |side: usize| {
                    let leg = &Limb::LEGS[side];
                    let longest = leg.bones_m(self.rest).iter().sum::<f32>() * LONGEST_SHARE;
                    let down = figures[i].positions[leg.upper] - targets[i][side].ankle;
                    let across = down.with_y(0.0).length();
                    let reach = (longest * longest - across * across).max(0.0).sqrt();
                    (down.y - reach).clamp(0.0, SINK_M)
                };
                // A seat or a bed does not give way: there a foot rather stays short of its place.
                let stands = self.task.rest(i).is_none() && self.plan.places[i].iter().any(Option::is_some);
                if stands { of(0).max(of(1)) } else { 0.0 }
            })
            .collect();
        let around = |i: usize, by: usize| i.saturating_sub(by)..(i + by + 1).min(total);
        let widened: Vec<f32> =
            (0..total).map(|i| needed[around(i, SINK_FRAMES)].iter().copied().fold(0.0, f32::max)).collect();
        let pinned = self.task.pinned;
        (0..total)
            .map(|i| {
                let near = &widened[around(i, SINK_FRAMES)];
                let mean = near.iter().sum::<f32>() / near.len() as f32;
                let to_pin = i.saturating_sub(pinned[0].saturating_sub(1)) as f32;
                let from_pin = (total - pinned[1].min(total)).saturating_sub(i) as f32;
                let ramp = |frames: f32, pinned: usize| match pinned {
                    0 => 1.0,
                    _ => ease((frames / SINK_FRAMES as f32).min(1.0)),
                };
                mean * ramp(to_pin, pinned[0]) * ramp(from_pin, pinned[1])
            })
            .collect()
    }
}

impl Correction {
    fn between(from: &FootPose, to: &FootPose) -> Self {
        let turn = |from: Quat, to: Quat| {
            let q = to * from.inverse();
            (if q.w < 0.0 { -q } else { q }).to_scaled_axis()
        };
        Self { shift: to.ankle - from.ankle, turn: turn(from.foot, to.foot), toes: turn(from.toes, to.toes) }
    }

    fn applied_to(&self, pose: &FootPose) -> FootPose {
        FootPose {
            ankle: pose.ankle + self.shift,
            foot: Quat::from_scaled_axis(self.turn) * pose.foot,
            toes: Quat::from_scaled_axis(self.toes) * pose.toes,
        }
    }

    fn lerp(&self, to: &Self, share: f32) -> Self {
        Self {
            shift: self.shift.lerp(to.shift, share),
            turn: self.turn.lerp(to.turn, share),
            toes: self.toes.lerp(to.toes, share),
        }
    }
}

/// Zero slope at both ends.
fn ease(x: f32) -> f32 {
    x * x * (3.0 - 2.0 * x)
}

/// Corrections of all frames: between two known ones they go smoothly from one to the other, before the first and
/// after the last they stay.
fn filled(known: &[Option<Correction>]) -> Vec<Correction> {
    let next: Vec<Option<usize>> = {
        let mut next = vec![None; known.len()];
        let mut ahead = None;
        for i in (0..known.len()).rev() {
            ahead = if known[i].is_some() { Some(i) } else { ahead };
            next[i] = ahead;
        }
        next
    };
    let mut before: Option<usize> = None;
    (0..known.len())
        .map(|i| {
            if let Some(correction) = known[i] {
                before = Some(i);
                return correction;
            }
            let at = |i: Option<usize>| i.and_then(|i| known[i]);
            match (before, next[i]) {
                (Some(a), Some(b)) => {
                    let share = ease((i - a) as f32 / (b - a) as f32);
                    at(before).unwrap_or_default().lerp(&at(next[i]).unwrap_or_default(), share)
                }
                (a, b) => at(a.or(b)).unwrap_or_default(),
            }
        })
        .collect()
}

/// Brings a foot to its target with the least change of its leg: the knee bends as far as the distance asks, then the
/// whole leg swings about the hip. A foot that is there already changes nothing. Returns by how many metres the leg is
/// too short.
fn shift_foot(figure: &mut FrameJoints, rest: &[Vec3; JOINTS], side: usize, target: &FootPose) -> f32 {
    let leg = &Limb::LEGS[side];
    let [a, b] = leg.bones_m(rest);
    let [hip, knee, ankle] = [leg.upper, leg.lower, leg.end].map(|j| figure.positions[j]);
    let wanted = hip.distance(target.ankle);
    let inner = |d: f32| ((a * a + b * b - d * d) / (2.0 * a * b)).clamp(-1.0, 1.0).acos();
    let folded = (a * a + b * b - 2.0 * a * b * LEAST_INNER_ANGLE.cos()).sqrt();
    let reached = wanted.clamp(folded, (a + b) * LONGEST_SHARE);
    let cross = (knee - hip).cross(ankle - knee);
    let natural = figure.rotations[leg.upper] * leg.hinge;
    // A knee that is almost straight does not say about which axis it bends.
    let hinge = if cross.length() > 0.02 * a * b { cross.normalize_or(natural) } else { natural };
    let bend = Quat::from_axis_angle(hinge, inner(hip.distance(ankle)) - inner(reached));
    let bent = knee + bend * (ankle - knee);
    let along = |v: Vec3| v.normalize_or(Vec3::NEG_Y);
    let swing = Quat::from_rotation_arc(along(bent - hip), along(target.ankle - hip));
    figure.rotations[leg.upper] = (swing * figure.rotations[leg.upper]).normalize();
    figure.rotations[leg.lower] = (swing * bend * figure.rotations[leg.lower]).normalize();
    figure.rotations[leg.end] = target.foot.normalize();
    figure.rotations[leg.end + TOES_AFTER_ANKLE] = target.toes.normalize();
    (wanted - reached).max(0.0)
}
