//! Sitting: the seat's height sets the knees, the family sets the torso.

use glam::{Mat3, Vec3};

use crate::body::hands::HandShape;
use crate::body::joints::{LEFT_HIP, LEFT_KNEE};
use crate::scene::PoseFamily;

use super::FamilyHints;
use super::arms::{ArmGoal, HIP_ABOVE_SEAT_M};
use super::chance::Chance;
use super::figure::{Figure, Side, leg as leg_of};
use super::stand::{ANKLE_HEIGHT_M, set_foot};
use super::torso::{self, Torso};

/// What the lower legs do.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Legs {
    /// Both feet flat.
    Apart,
    /// Ankles crossed on the floor.
    CrossedAnkles,
    /// Feet pulled under the seat.
    Tucked,
    /// Legs stretched out before the seat, heels on the floor.
    Stretched,
    /// The left thigh over the right one.
    CrossedKnees,
}

/// What the seat does to the legs.
#[derive(Clone, Copy, Debug)]
struct Seat {
    /// Hip joints above the floor.
    hips_m: f32,
    /// Sine of the steepest fall of a thigh: a deep seat holds it up, a stool's edge lets it down.
    least_thigh_rise: f32,
}

/// Sits as the family says.
pub(super) fn sit(
    figure: &mut Figure,
    family: PoseFamily,
    rng: &mut impl Chance,
    hints: &FamilyHints,
) -> [HandShape; 2] {
    if family == PoseFamily::SitStraight {
        return straight_legs(figure, rng);
    }
    let recline = match family {
        PoseFamily::SitSofa => rng.degrees(17.0, 5.0),
        PoseFamily::SitStool => rng.degrees(-3.0, 4.0),
        PoseFamily::SitEdge => rng.degrees(-2.0, 7.0),
        _ => rng.degrees(6.0, 5.0),
    };
    let recline = if hints.table_height_m.is_some() { rng.degrees(-6.0, 4.0) } else { recline };
    lean_torso(figure, recline, rng);
    let seat_m = hints.seat_height_m.unwrap_or(match family {
        PoseFamily::SitStool => 0.62,
        PoseFamily::SitSofa => 0.42,
        _ => 0.45,
    });
    place_legs(figure, family, seat_m, rng);
    let nod = rng.degrees(if recline < -0.05 { 14.0 } else { 6.0 }, 7.0);
    torso::look(figure, rng.degrees(0.0, 20.0), nod, rng.degrees(0.0, 4.0));
    let goals = arm_goals(family, seat_m, recline, hints, rng);
    super::place_arms(figure, goals, rng)
}

/// Sitting turns the pelvis back under a rounded lower back; the head's balance bends the spine forward.
fn lean_torso(figure: &mut Figure, recline: f32, rng: &mut impl Chance) {
    let slouch = rng.degrees(12.0, 4.0);
    let torso = Torso {
        pelvis_back: recline + slouch * 0.7,
        pelvis_roll: rng.degrees(0.0, 1.5),
        flexion: slouch,
        side_bend: rng.degrees(0.0, 3.5),
        twist: rng.degrees(0.0, 6.0),
    };
    torso::bend(figure, &torso, rng);
}

fn place_legs(figure: &mut Figure, family: PoseFamily, seat_m: f32, rng: &mut impl Chance) {
    let legs = rng.pick(&match family {
        PoseFamily::SitSofa => [
            (0.45, Legs::Apart),
            (0.15, Legs::CrossedAnkles),
            (0.0, Legs::Tucked),
            (0.2, Legs::Stretched),
            (0.2, Legs::CrossedKnees),
        ],
        PoseFamily::SitStool => [
            (0.6, Legs::Apart),
            (0.1, Legs::CrossedAnkles),
            (0.3, Legs::Tucked),
            (0.0, Legs::Stretched),
            (0.0, Legs::CrossedKnees),
        ],
        _ => [
            (0.48, Legs::Apart),
            (0.14, Legs::CrossedAnkles),
            (0.16, Legs::Tucked),
            (0.1, Legs::Stretched),
            (0.12, Legs::CrossedKnees),
        ],
    });
    let seat = Seat {
        hips_m: seat_m + HIP_ABOVE_SEAT_M,
        least_thigh_rise: match family {
            PoseFamily::SitStool => -0.42,
            PoseFamily::SitEdge => -0.22,
            _ => -0.14,
        },
    };
    if legs == Legs::CrossedKnees {
        cross_knees(figure, seat, rng);
        return;
    }
    let splay = rng.degrees(7.0, 4.0);
    for side in Side::BOTH {
        let forward = match legs {
            Legs::Apart => rng.degrees(4.0, 6.0),
            Legs::CrossedAnkles => 0.35,
            Legs::Tucked => rng.degrees(-20.0, 4.0),
            _ => rng.degrees(42.0, 5.0),
        };
        let splay = splay + rng.degrees(0.0, 2.5);
        lower_leg(figure, side, seat, splay, forward, rng);
        if legs == Legs::CrossedAnkles {
            cross_ankle(figure, side, seat.hips_m);
        }
    }
}

/// One leg: thigh splayed by `splay`, shank leaning `forward` from the vertical (radians), foot on a floor
/// that is `hips_m` below the hips, or hanging where the seat is too high for it.
fn lower_leg(figure: &mut Figure, side: Side, seat: Seat, splay: f32, forward: f32, rng: &mut impl Chance) {
    let hips_m = seat.hips_m;
    let leg = leg_of(side);
    let (thigh_m, shank_m) = (figure.bone(leg.lower), figure.bone(leg.end));
    let wanted = (ANKLE_HEIGHT_M + shank_m * forward.cos() - hips_m) / thigh_m;
    let rise = wanted.clamp(seat.least_thigh_rise, 0.5);
    // Where the seat holds the thigh up, the shank stands as steeply as the foot needs to reach the floor.
    let reach = (hips_m + thigh_m * rise - ANKLE_HEIGHT_M) / shank_m;
    let forward =
        if (-1.0..1.0).contains(&reach) && rise > wanted { reach.acos().copysign(forward) } else { forward };
    let level = (1.0 - rise * rise).sqrt();
    let out = Mat3::from_rotation_y(splay * side.sign());
    let thigh = out * Vec3::new(0.0, rise, level);
    let shank =
        out * Mat3::from_rotation_x(rng.degrees(0.0, 1.0)) * Vec3::new(0.0, -forward.cos(), forward.sin());
    figure.aim_limb(leg, thigh, shank, Vec3::new(0.0, 1.0, 1.0));
    let sole_m =
        figure.position(leg.end).y - figure.position(side.joint(LEFT_HIP)).y + hips_m - ANKLE_HEIGHT_M;
    let toe_out = (splay + rng.degrees(4.0, 4.0)) * side.sign();
    // A foot that does not reach the floor hangs with its toes down; one before the knee rests on its heel.
    let pitch = if sole_m > 0.04 { 0.35 } else { -(forward - 0.45).max(0.0) * 0.9 };
    set_foot(figure, side, Mat3::from_rotation_y(toe_out) * Mat3::from_rotation_x(pitch));
}

/// Brings an ankle to the middle line, the left one before the right.
fn cross_ankle(figure: &mut Figure, side: Side, hips_m: f32) {
    let leg = leg_of(side);
    let knee = figure.position(side.joint(LEFT_KNEE));
    let hip = figure.position(side.joint(LEFT_HIP));
    let before = if side == Side::Left { 0.115 } else { 0.0 };
    let target = Vec3::new(
        -side.sign() * 0.05,
        hip.y - hips_m + ANKLE_HEIGHT_M + 0.1 * before,
        knee.z + 0.08 + before,
    );
    figure.reach(leg, target, knee - hip);
    set_foot(figure, side, Mat3::from_rotation_y(-0.1 * side.sign()) * Mat3::from_rotation_x(0.1));
}

/// The left thigh lies over the right one, its foot in the air.
fn cross_knees(figure: &mut Figure, seat: Seat, rng: &mut impl Chance) {
    lower_leg(figure, Side::Right, seat, rng.degrees(-3.0, 2.0), rng.degrees(8.0, 4.0), rng);
    let below = figure.position(Side::Right.joint(LEFT_KNEE));
    let leg = leg_of(Side::Left);
    let hip = figure.position(LEFT_HIP);
    let knee = Vec3::new(below.x + 0.05, below.y + 0.135, below.z + 0.01);
    let thigh = (knee - hip).normalize_or(Vec3::Z);
    let shank = Vec3::new(rng.about(-0.42, 0.05), -1.0, rng.about(0.5, 0.08)).normalize_or(Vec3::NEG_Y);
    figure.aim_limb(leg, thigh, shank, Vec3::Y);
    let foot = figure.rotation(LEFT_KNEE) * Mat3::from_rotation_x(rng.degrees(18.0, 6.0));
    set_foot(figure, Side::Left, foot);
}

/// Backs farther behind the pelvis than this are out of an arm's reach for somebody at ease.
const BACK_IN_REACH_M: f32 = 0.22;

fn arm_goals(
    family: PoseFamily,
    seat_m: f32,
    recline: f32,
    hints: &FamilyHints,
    rng: &mut impl Chance,
) -> [ArmGoal; 2] {
    use ArmGoal::{Armrest, Behind, Beside, Chin, Folded, Gesture, InLap, OnThigh, Spread, Table};
    let thigh = [OnThigh(rng.between(0.4, 0.75)), OnThigh(rng.between(0.4, 0.75))];
    let knees = [OnThigh(rng.between(0.8, 0.98)), OnThigh(rng.between(0.8, 0.98))];
    let folded = [Folded { on_top: true }, Folded { on_top: false }];
    if let Some(height_m) = hints.table_height_m {
        let reach_m = hints.table_reach_m.unwrap_or(0.4);
        let on_table = Table { height_m: height_m - seat_m - HIP_ABOVE_SEAT_M + 0.03, reach_m };
        return rng.pick(&[
            (0.6, [on_table, on_table]),
            (0.25, [on_table, thigh[1]]),
            (0.15, [on_table, Chin]),
        ]);
    }
    if let Some(height_m) = hints.armrest_above_seat_m
        && rng.chance(0.6)
    {
        let rest = Armrest(height_m - HIP_ABOVE_SEAT_M);
        return rng.pick(&[(0.5, [rest, rest]), (0.3, [rest, thigh[1]]), (0.2, [rest, Chin])]);
    }
    // An arm lies along a backrest only where one is within its reach.
    let spread = match hints.seat_behind_m {
        Some(behind_m) if behind_m > BACK_IN_REACH_M => thigh[0],
        _ => Spread,
    };
    match family {
        PoseFamily::SitSofa => rng.pick(&[
            (0.32, thigh),
            (0.18, [InLap, InLap]),
            (0.14, folded),
            (0.12, [Beside, thigh[1]]),
            (0.12, [spread, thigh[1]]),
            (0.12, [Gesture, thigh[1]]),
        ]),
        PoseFamily::SitEdge if recline > 0.0 => {
            rng.pick(&[(0.35, [Beside, Beside]), (0.25, [Behind, thigh[1]]), (0.4, thigh)])
        }
        PoseFamily::SitEdge => rng.pick(&[(0.35, [Beside, Beside]), (0.35, knees), (0.3, [InLap, InLap])]),
        PoseFamily::SitStool => rng.pick(&[
            (0.4, thigh),
            (0.25, [InLap, InLap]),
            (0.15, knees),
            (0.1, folded),
            (0.1, [Gesture, thigh[1]]),
        ]),
        _ => rng.pick(&[
            (0.42, thigh),
            (0.2, [InLap, InLap]),
            (0.12, folded),
            (0.1, knees),
            (0.1, [Gesture, thigh[1]]),
            (0.06, [Chin, thigh[1]]),
        ]),
    }
}

/// Sits with the legs on the seat.
fn straight_legs(figure: &mut Figure, rng: &mut impl Chance) -> [HandShape; 2] {
    let propped = rng.chance(0.4);
    let recline = if propped { rng.degrees(27.0, 3.0) } else { rng.degrees(14.0, 6.0) };
    lean_torso(figure, recline, rng);
    let one_up = rng.chance(0.25);
    let crossed = !one_up && rng.chance(0.25);
    for side in Side::BOTH {
        let leg = leg_of(side);
        let splay = if crossed { -0.035 } else { rng.degrees(5.0, 3.0) };
        let rise: f32 = if one_up && side == Side::Left {
            rng.degrees(52.0, 5.0)
        } else if crossed && side == Side::Left {
            0.14
        } else {
            rng.degrees(4.0, 2.0)
        };
        let out = Mat3::from_rotation_y(splay * side.sign());
        let thigh = out * Vec3::new(0.0, rise.sin(), rise.cos());
        // The heel lies as low as the seat, an ankle's half thickness below the hip's height above it.
        let shank_drop = (figure.bone(leg.lower) * rise.sin() + HEEL_BELOW_HIP_M) / figure.bone(leg.end);
        let heel_lift = if crossed && side == Side::Left { 0.17 } else { 0.0 };
        let drop = (shank_drop - heel_lift).clamp(-0.2, 0.98);
        let shank = out * Vec3::new(0.0, -drop, (1.0 - drop * drop).sqrt());
        figure.aim_limb(leg, thigh, shank, Vec3::Y);
        let roll = Mat3::from_rotation_y(side.sign() * rng.degrees(14.0, 6.0));
        let pointed = rng.degrees(22.0, 7.0);
        let foot = if one_up && side == Side::Left {
            Mat3::from_rotation_y(splay)
        } else {
            figure.rotation(side.joint(LEFT_KNEE)) * roll * Mat3::from_rotation_x(pointed)
        };
        set_foot(figure, side, foot);
    }
    torso::look(figure, rng.degrees(0.0, 15.0), rng.degrees(10.0, 8.0), rng.degrees(0.0, 3.0));
    let goals = if propped {
        [ArmGoal::Behind, ArmGoal::Behind]
    } else {
        let thigh = [ArmGoal::OnThigh(rng.between(0.4, 0.7)), ArmGoal::OnThigh(rng.between(0.4, 0.7))];
        rng.pick(&[
            (0.45, thigh),
            (0.3, [ArmGoal::InLap, ArmGoal::InLap]),
            (0.15, [ArmGoal::Beside, thigh[1]]),
            (0.1, [ArmGoal::Folded { on_top: true }, ArmGoal::Folded { on_top: false }]),
        ])
    };
    super::place_arms(figure, goals, rng)
}

/// A heel lies on the seat with its ankle joint this much lower than the hip joint.
const HEEL_BELOW_HIP_M: f32 = 0.03;
