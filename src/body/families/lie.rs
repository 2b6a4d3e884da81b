//! Lying: head towards -Z, feet towards +Z, the mattress below.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{EulerRot, Mat3, Vec3};

use crate::body::hands::HandShape;
use crate::body::joints::{LEFT_ANKLE, LEFT_HIP, LEFT_KNEE, PELVIS};

use super::FamilyHints;
use super::arms::ArmGoal;
use super::chance::Chance;
use super::figure::{Figure, Side, leg as leg_of};
use super::stand::{ANKLE_HEIGHT_M, set_foot};
use super::torso::{self, Torso};

/// From the pelvis joint to the crown of the mean body, and from an ankle to the tips of the toes.
const CROWN_M: f32 = 0.75;
const TOES_M: f32 = 0.19;
/// From the pelvis to the ankles of somebody face up whose knees are raised: natural, and drawn up as far as one does.
const KNEES_UP_M: [f32; 2] = [0.3, 0.62];
/// Nobody curls up farther than this to fit: hips at 83 degrees.
const TIGHTEST_CURL: f32 = 1.4;
/// A pillow of this height keeps the head of somebody on the side level with the spine.
const LEVEL_PILLOW_M: f32 = 0.11;
/// From the chest to the middle of the head: the arm by which a pillow bends neck and upper spine.
const NECK_ARM_M: f32 = 0.34;

/// By how much neck and upper spine together bend forward for the head to lie on a pillow, radians, beyond what a usual
/// thin one asks for.
fn on_pillow(hints: &FamilyHints) -> f32 {
    hints.pillow_m.map_or(0.0, |pillow| ((pillow - 0.05) / NECK_ARM_M).clamp(0.0, 0.7).asin())
}

/// Face up.
pub(super) fn face_up(figure: &mut Figure, rng: &mut impl Chance, hints: &FamilyHints) -> [HandShape; 2] {
    let raised = on_pillow(hints);
    let torso = Torso {
        flexion: rng.degrees(4.0, 2.5) + 0.4 * raised,
        side_bend: rng.degrees(0.0, 4.0),
        twist: rng.degrees(0.0, 3.0),
        ..Torso::default()
    };
    torso::bend(figure, &torso, rng);
    figure.local[PELVIS] = Mat3::from_rotation_x(-FRAC_PI_2);
    let bent = rng.chance(0.35);
    let crossed = !bent && rng.chance(0.25);
    let stretched_m = CROWN_M + figure.bone(LEFT_KNEE) + figure.bone(LEFT_ANKLE) + TOES_M;
    let short_m = hints.lying_length_m.filter(|length| *length < stretched_m);
    for side in Side::BOTH {
        if let Some(length_m) = short_m {
            let [least, most] = KNEES_UP_M;
            let along = (length_m - CROWN_M - TOES_M).clamp(least, most);
            sole_on_mattress(figure, side, [(along - 0.06).max(least), along + 1e-3], rng);
            continue;
        }
        if bent && side == Side::Left {
            sole_on_mattress(figure, side, [0.6, 0.68], rng);
            continue;
        }
        let apart = if crossed { rng.degrees(-9.0, 1.0) } else { rng.degrees(-1.0, 3.5) };
        let over = if crossed && side == Side::Left { 7.0 } else { 1.5 };
        leg(figure, side, rng.degrees(over, 1.0), apart, rng.degrees(4.0, 2.0));
        slack_foot(figure, side, rng.degrees(26.0, 6.0), rng.degrees(18.0, 7.0));
    }
    // A pillow lifts the head.
    torso::turn_neck(
        figure,
        Vec3::new(rng.degrees(16.0, 6.0) + 0.6 * raised, rng.degrees(0.0, 20.0), rng.degrees(0.0, 3.0)),
    );
    let along = ArmGoal::Along(rng.between(-0.1, -0.08));
    let goals = rng.pick(&[
        (0.25, [along, along]),
        (0.25, [ArmGoal::Belly, along]),
        (0.2, [ArmGoal::Belly, ArmGoal::Belly]),
        (0.12, [ArmGoal::BehindHead, ArmGoal::BehindHead]),
        (0.18, [ArmGoal::BehindHead, ArmGoal::Belly]),
    ]);
    super::place_arms(figure, goals, rng)
}

/// A leg whose knee is up: the sole stands on the mattress, level with the back, the ankle between these distances from
/// the hip towards the feet.
fn sole_on_mattress(figure: &mut Figure, side: Side, along_m: [f32; 2], rng: &mut impl Chance) {
    let hip = figure.position(side.joint(LEFT_HIP));
    let ankle = hip
        + Vec3::new(rng.between(-0.03, 0.06), ANKLE_HEIGHT_M - BACK_M, rng.between(along_m[0], along_m[1]));
    figure.reach(leg_of(side), ankle, side.outward(rng.between(-0.1, 0.25), 1.0, 0.0));
    set_foot(figure, side, Mat3::from_rotation_y(rng.degrees(6.0, 4.0)));
}

/// Face down, head turned aside.
pub(super) fn face_down(figure: &mut Figure, rng: &mut impl Chance) -> [HandShape; 2] {
    let torso = Torso {
        flexion: rng.degrees(-5.0, 2.0),
        side_bend: rng.degrees(0.0, 4.0),
        twist: rng.degrees(0.0, 3.0),
        ..Torso::default()
    };
    torso::bend(figure, &torso, rng);
    figure.local[PELVIS] = Mat3::from_rotation_y(PI) * Mat3::from_rotation_x(FRAC_PI_2);
    let drawn_up = rng.chance(0.4);
    for side in Side::BOTH {
        if drawn_up && side == Side::Left {
            // The thigh slides out along the mattress.
            draw_up(figure, side, rng.degrees(48.0, 6.0), rng.degrees(66.0, 8.0));
        } else {
            leg(figure, side, rng.degrees(-1.0, 1.5), rng.degrees(0.0, 3.0), rng.degrees(6.0, 3.0));
        }
        slack_foot(figure, side, rng.degrees(48.0, 5.0), rng.degrees(4.0, 8.0));
    }
    torso::turn_neck(
        figure,
        Vec3::new(rng.degrees(-6.0, 3.0), rng.degrees(62.0, 4.0), rng.degrees(0.0, 3.0)),
    );
    let along = ArmGoal::Along(rng.between(0.03, 0.06));
    let goals = rng.pick(&[
        (0.5, [ArmGoal::ByHead, ArmGoal::ByHead]),
        (0.3, [ArmGoal::ByHead, along]),
        (0.2, [along, along]),
    ]);
    super::place_arms(figure, goals, rng)
}

/// On the right side (mirrored half of the time), hips and knees bent.
pub(super) fn on_side(figure: &mut Figure, rng: &mut impl Chance, hints: &FamilyHints) -> [HandShape; 2] {
    let curl = rng.between(0.0, 1.0);
    let curl = match hints.lying_length_m {
        Some(length_m) => {
            let least = least_curl(figure, length_m);
            least + (1.0 - least).max(0.0) * curl
        }
        None => curl,
    };
    let torso = Torso {
        flexion: rng.degrees(8.0, 3.0) + 0.25 * curl,
        side_bend: rng.degrees(-2.0, 3.0),
        twist: rng.degrees(0.0, 4.0),
        ..Torso::default()
    };
    torso::bend(figure, &torso, rng);
    figure.local[PELVIS] =
        Mat3::from_rotation_z(FRAC_PI_2 + rng.degrees(0.0, 4.0)) * Mat3::from_rotation_x(-FRAC_PI_2);
    let [hip, knee] = curled(curl);
    for side in Side::BOTH {
        let upper = side == Side::Left;
        let (more, apart) = if upper { (rng.about(14.0, 6.0), -9.0) } else { (rng.about(0.0, 4.0), -4.0) };
        let bend = [hip, knee].map(|angle: f32| (angle + more).to_radians());
        leg(figure, side, bend[0], rng.degrees(apart, 1.5), bend[1]);
        slack_foot(figure, side, rng.degrees(22.0, 6.0), 0.0);
    }
    // A usual pillow keeps the head level with the spine.
    let up = hints.pillow_m.map_or(0.0, |pillow| ((pillow - LEVEL_PILLOW_M) / NECK_ARM_M).clamp(-0.3, 0.5));
    torso::turn_neck(
        figure,
        Vec3::new(rng.degrees(10.0, 6.0), rng.degrees(0.0, 6.0), rng.degrees(6.0, 3.0) - up),
    );
    let upper = rng.pick(&[(0.6, ArmGoal::BeforeChest), (0.4, ArmGoal::OnFlank)]);
    super::place_arms(figure, [upper, ArmGoal::BeforeFace], rng)
}

/// Flexion of hips and knees of somebody on the side, degrees.
fn curled(curl: f32) -> [f32; 2] {
    [20.0 + 45.0 * curl, 30.0 + 48.0 * curl]
}

/// How much somebody curls up at least to be no longer than `length_m` from the crown to the toes.
fn least_curl(figure: &Figure, length_m: f32) -> f32 {
    let long_m = |curl: f32| {
        let [hip, knee] = curled(curl).map(f32::to_radians);
        let legs_m = figure.bone(LEFT_KNEE) * hip.cos() + figure.bone(LEFT_ANKLE) * (knee - hip).cos();
        CROWN_M - 0.05 * curl + legs_m + TOES_M
    };
    let steps = 28;
    (0..=steps)
        .map(|step| TIGHTEST_CURL * step as f32 / steps as f32)
        .find(|curl| long_m(*curl) <= length_m)
        .unwrap_or(TIGHTEST_CURL)
}

/// A leg in the body's own frame, radians: hip flexed forward, moved `apart` from the middle, knee bent.
fn leg(figure: &mut Figure, side: Side, hip_flexion: f32, apart: f32, knee: f32) {
    let root = figure.rotation(PELVIS);
    let thigh_turn = Mat3::from_euler(EulerRot::ZXY, side.sign() * apart, -hip_flexion, 0.0);
    let thigh = root * thigh_turn * Vec3::NEG_Y;
    let shank = root * thigh_turn * Mat3::from_rotation_x(knee) * Vec3::NEG_Y;
    let knee_cap = root * thigh_turn * Vec3::Z;
    figure.aim_limb(leg_of(side), thigh, shank, knee_cap);
}

/// A leg drawn up along the mattress, face down: thigh out by `apart`, the shank back in by `knee`, radians.
fn draw_up(figure: &mut Figure, side: Side, apart: f32, knee: f32) {
    let root = figure.rotation(PELVIS);
    let in_plane = |angle: f32, lift: f32| root * side.outward(angle.sin(), -angle.cos(), -lift);
    let shank = in_plane(apart - knee, 0.4).normalize_or(Vec3::Z);
    figure.aim_limb(leg_of(side), in_plane(apart, 0.0), shank, root * side.outward(1.0, 0.0, 0.0));
}

/// Skin of back and seat behind the pelvis joint, body at rest.
const BACK_M: f32 = 0.11;

/// A foot without weight on it: toes pointed and fallen outwards, radians.
fn slack_foot(figure: &mut Figure, side: Side, pointed: f32, outward: f32) {
    let shank = figure.rotation(side.joint(LEFT_KNEE));
    set_foot(
        figure,
        side,
        shank * Mat3::from_rotation_y(side.sign() * outward) * Mat3::from_rotation_x(pointed),
    );
}
