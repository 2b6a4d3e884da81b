//! What arms do: where the wrist goes, where the elbow points, how the hand lies.

use glam::Vec3;

use crate::body::hands::HandShape;
use crate::body::joints::{HEAD, LEFT_HIP, LEFT_KNEE, LEFT_SHOULDER, PELVIS, SPINE3};

use super::chance::Chance;
use super::figure::{Figure, Side, arm as arm_of};

/// From the wrist to the middle of the palm.
pub(super) const PALM_M: f32 = 0.085;
/// Half the thickness of a thigh where hands rest on it, and of a hand.
const THIGH_TOP_M: f32 = 0.078;
/// From the wrist joint down to the skin of a palm.
pub(super) const HAND_HALF_THICKNESS_M: f32 = 0.022;
/// From the hip joints down to the seat.
pub(super) const HIP_ABOVE_SEAT_M: f32 = 0.09;

/// What an arm does. Heights and reaches are metres in the upright frame, pelvis at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ArmGoal {
    /// Hangs by the side.
    Hang,
    /// Palm on the thigh, this share of the way to the knee.
    OnThigh(f32),
    /// Hands together between the thighs.
    InLap,
    /// Palm on the seat beside the hip.
    Beside,
    /// Palm on the seat behind, arm straight: props up the torso.
    Behind,
    /// Forearm on an armrest of this height above the hip joints.
    Armrest(f32),
    /// Hand on a table or counter at this height and reach from the pelvis.
    Table { height_m: f32, reach_m: f32 },
    /// Arms folded before the chest; the arm that lies on top, or the one below.
    Folded { on_top: bool },
    /// Hand on the hip.
    Akimbo,
    /// Hand in the trouser pocket.
    Pocket,
    /// Hands clasped before the belly of somebody who stands.
    ClaspedFront,
    /// Hands together behind the back.
    ClaspedBack,
    /// Speaks with the hand.
    Gesture,
    /// Hand at the chin.
    Chin,
    /// Palm on the belly.
    Belly,
    /// Hand behind the head.
    BehindHead,
    /// Prone: forearm up beside the head.
    ByHead,
    /// Lying: along the body, the wrist this far before the shoulder (body frame, z).
    Along(f32),
    /// On the side: folded forward, hand near the face, as under a pillow.
    BeforeFace,
    /// On the side: the upper arm before the body, hand on the mattress.
    BeforeChest,
    /// On the side: along the upper flank, hand on the thigh.
    OnFlank,
    /// Along a sofa's backrest.
    Spread,
}

struct Reach {
    wrist: Vec3,
    pole: Vec3,
    /// Directions of fingers and palm; none leaves the hand in line with the forearm.
    hand: Option<(Vec3, Vec3)>,
    shape: HandShape,
}

/// Moves one arm of `figure`, and says how its hand is shaped.
pub(super) fn place(figure: &mut Figure, side: Side, goal: ArmGoal, rng: &mut impl Chance) -> HandShape {
    let reach = reach_of(figure, side, goal, rng);
    figure.reach(arm_of(side), reach.wrist, reach.pole);
    if let Some((fingers, palm)) = reach.hand {
        figure.aim_hand(side, fingers, palm);
    }
    reach.shape
}

/// The shape of a hand laid on something.
pub(super) fn resting(rng: &mut impl Chance) -> HandShape {
    HandShape::resting(rng)
}

fn reach_of(figure: &Figure, side: Side, goal: ArmGoal, rng: &mut impl Chance) -> Reach {
    match goal {
        ArmGoal::OnThigh(share) => on_thigh(figure, side, share, rng),
        ArmGoal::InLap
        | ArmGoal::Beside
        | ArmGoal::Behind
        | ArmGoal::Armrest(_)
        | ArmGoal::Table { .. }
        | ArmGoal::Spread => seated(figure, side, goal, rng),
        ArmGoal::Hang
        | ArmGoal::Folded { .. }
        | ArmGoal::Akimbo
        | ArmGoal::Pocket
        | ArmGoal::ClaspedFront
        | ArmGoal::ClaspedBack
        | ArmGoal::Gesture
        | ArmGoal::Chin => upright(figure, side, goal, rng),
        _ => lying(figure, side, goal, rng),
    }
}

/// A palm laid on something: the wrist behind the palm and above the surface.
fn palm_at(palm_point: Vec3, fingers: Vec3, palm: Vec3, pole: Vec3, shape: HandShape) -> Reach {
    let (f, p) = (fingers.normalize_or(Vec3::Z), palm.normalize_or(Vec3::NEG_Y));
    let wrist = palm_point - f * PALM_M - p * HAND_HALF_THICKNESS_M;
    Reach { wrist, pole, hand: Some((f, p)), shape }
}

fn on_thigh(figure: &Figure, side: Side, share: f32, rng: &mut impl Chance) -> Reach {
    let hip = figure.position(side.joint(LEFT_HIP));
    let knee = figure.position(side.joint(LEFT_KNEE));
    let along = (knee - hip).normalize_or(Vec3::Z);
    let up = (Vec3::Y - along * along.y).normalize_or(Vec3::Y);
    let inward = side.outward(-rng.between(0.1, 0.6), 0.0, 0.0);
    let fingers = along + inward;
    let point =
        hip + (knee - hip) * share + up * THIGH_TOP_M + side.outward(rng.between(-0.01, 0.02), 0.0, 0.0);
    let pole = side.outward(1.0, -0.5, -0.5);
    palm_at(point, fingers, -up + inward * 0.2, pole, HandShape::resting(rng))
}

fn seated(figure: &Figure, side: Side, goal: ArmGoal, rng: &mut impl Chance) -> Reach {
    let hip = figure.position(side.joint(LEFT_HIP));
    let seat_y = hip.y - HIP_ABOVE_SEAT_M;
    let elbow_out = side.outward(1.0, -0.3, -0.6);
    match goal {
        ArmGoal::InLap => {
            let knee = figure.position(side.joint(LEFT_KNEE));
            let above = hip.lerp(knee, rng.between(0.42, 0.5)).y + rng.between(0.09, 0.105);
            let over = if side == Side::Left { 0.022 } else { -0.012 };
            let point = Vec3::new(side.sign() * 0.035, above + over, hip.z + rng.between(0.17, 0.2));
            palm_at(
                point,
                side.outward(-0.8, -0.15, 0.6),
                side.outward(-0.4, -0.9, -0.2),
                elbow_out,
                HandShape::relaxed(rng),
            )
        }
        ArmGoal::Beside => {
            let point = Vec3::new(
                hip.x + side.sign() * rng.between(0.15, 0.2),
                seat_y,
                hip.z + rng.between(-0.04, 0.12),
            );
            palm_at(
                point,
                side.outward(rng.between(0.0, 0.6), -0.1, 1.0),
                Vec3::NEG_Y,
                elbow_out,
                HandShape::flat(rng),
            )
        }
        ArmGoal::Behind => {
            let point = Vec3::new(
                hip.x + side.sign() * rng.between(0.1, 0.2),
                seat_y,
                hip.z - rng.between(0.24, 0.34),
            );
            palm_at(
                point,
                side.outward(0.7, -0.1, -0.6),
                Vec3::NEG_Y,
                side.outward(0.2, 0.0, -1.0),
                HandShape::flat(rng),
            )
        }
        ArmGoal::Armrest(above_hip_m) => {
            let wrist = Vec3::new(
                hip.x + side.sign() * rng.between(0.17, 0.22),
                hip.y + above_hip_m + 0.035,
                hip.z + rng.between(0.16, 0.26),
            );
            let shape = HandShape::resting(rng);
            Reach {
                wrist,
                pole: side.outward(0.35, -0.8, -1.0),
                hand: Some((Vec3::new(0.0, -0.15, 1.0), Vec3::NEG_Y)),
                shape,
            }
        }
        ArmGoal::Table { height_m, reach_m } => {
            let point =
                Vec3::new(side.sign() * rng.between(0.08, 0.2), height_m, reach_m + rng.between(-0.05, 0.04));
            palm_at(
                point,
                side.outward(-rng.between(0.0, 0.7), -0.1, 1.0),
                Vec3::NEG_Y,
                elbow_out,
                HandShape::resting(rng),
            )
        }
        _ => {
            let shoulder = figure.position(side.joint(LEFT_SHOULDER));
            let wrist = shoulder
                + side.outward(rng.between(0.36, 0.42), rng.between(-0.1, 0.0), rng.between(-0.14, -0.02));
            let hand = Some((side.outward(0.8, -0.2, 0.3), Vec3::new(0.0, -1.0, 0.2)));
            Reach { wrist, pole: side.outward(0.1, -1.0, -0.3), hand, shape: HandShape::relaxed(rng) }
        }
    }
}

fn upright(figure: &Figure, side: Side, goal: ArmGoal, rng: &mut impl Chance) -> Reach {
    let shoulder = figure.position(side.joint(LEFT_SHOULDER));
    let chest = |x: f32, y: f32, z: f32| figure.point(SPINE3, side.outward(x, y, z));
    let chest_turn = figure.rotation(SPINE3);
    let pelvis = |x: f32, y: f32, z: f32| figure.point(PELVIS, side.outward(x, y, z));
    match goal {
        ArmGoal::Hang => {
            let wrist = shoulder
                + side.outward(
                    rng.between(0.05, 0.11),
                    rng.between(-0.475, -0.455),
                    rng.between(-0.02, 0.08),
                );
            Reach { wrist, pole: side.outward(0.35, 0.0, -1.0), hand: None, shape: HandShape::relaxed(rng) }
        }
        ArmGoal::Folded { on_top } => {
            let (wrist, tip) =
                if on_top { (chest(-0.05, 0.02, 0.235), 0.12) } else { (chest(-0.02, 0.0, 0.185), 0.05) };
            let fingers = chest_turn * side.outward(-1.0, tip, -0.15);
            let palm = chest_turn * Vec3::new(0.0, -0.2, -1.0);
            Reach {
                wrist,
                pole: chest_turn * side.outward(1.0, -1.2, 0.1),
                hand: Some((fingers, palm)),
                shape: HandShape::resting(rng),
            }
        }
        ArmGoal::Akimbo => {
            let point = pelvis(rng.between(0.155, 0.17), rng.between(0.05, 0.08), 0.05);
            palm_at(
                point,
                side.outward(-0.35, -0.45, 1.0),
                side.outward(-1.0, -0.1, -0.2),
                side.outward(1.0, 0.0, -0.6),
                HandShape::resting(rng),
            )
        }
        ArmGoal::Pocket => {
            let wrist = pelvis(rng.between(0.2, 0.22), rng.between(-0.01, 0.02), rng.between(0.02, 0.06));
            let hand = Some((side.outward(-0.25, -1.0, 0.35), side.outward(-1.0, -0.1, -0.1)));
            Reach { wrist, pole: side.outward(0.5, 0.0, -1.0), hand, shape: HandShape::relaxed(rng) }
        }
        ArmGoal::ClaspedFront => {
            let over = if side == Side::Left { 0.03 } else { 0.0 };
            let point = pelvis(0.015, rng.between(-0.1, -0.07), 0.155 + over);
            palm_at(
                point,
                side.outward(-0.75, -0.65, 0.1),
                side.outward(-0.2, 0.0, -1.0),
                side.outward(1.0, 0.0, -0.5),
                HandShape::relaxed(rng),
            )
        }
        ArmGoal::ClaspedBack => {
            let over = if side == Side::Left { 0.03 } else { 0.0 };
            let point = pelvis(0.0, rng.between(0.0, 0.05), -0.155 - over);
            palm_at(
                point,
                side.outward(-0.8, -0.55, 0.0),
                Vec3::new(0.0, 0.0, -1.0),
                side.outward(1.0, 0.0, -1.0),
                HandShape::relaxed(rng),
            )
        }
        ArmGoal::Chin => {
            let wrist = figure.point(HEAD, side.outward(0.035, -0.145, 0.155));
            let hand = Some((side.outward(-0.15, 0.9, -0.35), side.outward(-0.5, 0.2, -1.0)));
            Reach { wrist, pole: side.outward(0.4, -1.0, 0.2), hand, shape: HandShape::relaxed(rng) }
        }
        _ => {
            let wrist = shoulder
                + side.outward(rng.between(-0.02, 0.12), rng.between(-0.26, -0.12), rng.between(0.22, 0.33));
            let hand =
                Some((side.outward(-0.3, 0.35, 1.0), side.outward(-0.8, rng.between(-0.3, 0.5), -0.2)));
            Reach { wrist, pole: side.outward(0.6, -1.0, -0.4), hand, shape: HandShape::relaxed(rng) }
        }
    }
}

/// Goals of lying bodies, in the body's own frame: x outwards, y to the head, z out of the belly.
fn lying(figure: &Figure, side: Side, goal: ArmGoal, rng: &mut impl Chance) -> Reach {
    let root = figure.rotation(PELVIS);
    let from_root = |x: f32, y: f32, z: f32| root * side.outward(x, y, z);
    let at = |joint: usize, x: f32, y: f32, z: f32| figure.position(joint) + from_root(x, y, z);
    let shoulder = side.joint(LEFT_SHOULDER);
    let shape = HandShape::relaxed(rng);
    let palm = |point, fingers, palm, pole| palm_at(point, fingers, palm, pole, shape);
    match goal {
        ArmGoal::Belly => {
            let point = at(SPINE3, rng.between(-0.03, 0.06), rng.between(-0.13, -0.04), 0.15);
            palm(
                point,
                from_root(-1.0, rng.between(-0.3, 0.2), 0.0),
                from_root(0.0, 0.0, -1.0),
                from_root(1.0, -0.3, -0.6),
            )
        }
        ArmGoal::BehindHead => {
            let wrist = at(HEAD, 0.1, 0.06, -0.1);
            let hand = Some((from_root(-1.0, 0.15, -0.1), from_root(0.0, 0.0, 1.0)));
            Reach { wrist, pole: from_root(1.0, 0.35, 0.05), hand, shape }
        }
        ArmGoal::ByHead => {
            let wrist = at(shoulder, rng.between(0.06, 0.2), rng.between(0.2, 0.27), rng.between(0.02, 0.05));
            let hand = Some((from_root(-0.35, 1.0, 0.05), from_root(0.0, 0.0, 1.0)));
            Reach { wrist, pole: from_root(1.0, -0.35, -0.05), hand, shape }
        }
        ArmGoal::BeforeFace => {
            let wrist = at(HEAD, rng.between(-0.02, 0.02), rng.between(-0.1, -0.04), rng.between(0.2, 0.26));
            let hand = Some((from_root(-0.2, 1.0, -0.3), from_root(-1.0, 0.0, -0.1)));
            Reach { wrist, pole: from_root(0.1, -1.0, 0.5), hand, shape }
        }
        ArmGoal::BeforeChest => {
            let wrist =
                at(shoulder, rng.between(-0.3, -0.24), rng.between(-0.22, -0.08), rng.between(0.26, 0.32));
            let hand = Some((from_root(-0.6, 0.1, 0.7), from_root(-0.8, 0.0, -0.5)));
            Reach { wrist, pole: from_root(1.0, -0.7, 0.0), hand, shape }
        }
        ArmGoal::OnFlank => {
            let wrist = at(shoulder, rng.between(0.02, 0.05), -0.45, rng.between(0.03, 0.1));
            Reach { wrist, pole: from_root(0.4, 0.0, -1.0), hand: None, shape }
        }
        _ => {
            let before = if let ArmGoal::Along(before) = goal { before } else { 0.0 };
            let wrist = at(shoulder, rng.between(0.08, 0.16), rng.between(-0.47, -0.45), before);
            let hand = Some((from_root(0.1, -1.0, 0.0), from_root(-0.6, 0.0, rng.between(-1.0, 0.2))));
            Reach { wrist, pole: from_root(1.0, 0.0, -0.3), hand, shape }
        }
    }
}
