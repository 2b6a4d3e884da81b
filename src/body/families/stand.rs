//! Standing and leaning.

use glam::{Mat3, Vec3};

use crate::body::hands::HandShape;
use crate::body::joints::{LEFT_ANKLE, LEFT_FOOT, LEFT_HIP};

use super::arms::ArmGoal;
use super::chance::Chance;
use super::figure::{Figure, Side, leg as leg_of};
use super::torso::{self, Torso};
use super::{FamilyHints, LeanStyle};

/// Ankle joint above the sole.
pub(super) const ANKLE_HEIGHT_M: f32 = 0.077;

/// Where the feet stand, relative to the ground point below the pelvis.
struct Stance {
    /// Each ankle outwards from the middle, left then right.
    outward_m: [f32; 2],
    /// Each ankle forward of the pelvis.
    forward_m: [f32; 2],
    /// Each foot turned outwards, radians.
    toe_out: [f32; 2],
    /// Pelvis joint above the floor, as a share of its height when both legs are straight.
    height_share: f32,
}

/// How somebody stands free.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stand {
    /// On both legs alike.
    Even,
    /// On the left leg (mirrored half of the time), the other knee eased.
    OneLeg,
    /// One foot a short step ahead, as people stop.
    Step,
    /// Feet wide apart.
    Wide,
}

/// Stands free.
pub(super) fn stand(figure: &mut Figure, rng: &mut impl Chance) -> [HandShape; 2] {
    let way = rng.pick(&[(0.25, Stand::Even), (0.4, Stand::OneLeg), (0.25, Stand::Step), (0.1, Stand::Wide)]);
    let eased = match way {
        Stand::OneLeg => rng.between(0.4, 1.1),
        Stand::Step => rng.between(0.1, 0.5),
        Stand::Even | Stand::Wide => 0.0,
    };
    let roll = rng.degrees(4.0, 1.5) * eased;
    let torso = Torso {
        pelvis_back: rng.degrees(1.0, 2.5),
        pelvis_roll: roll,
        flexion: rng.degrees(1.0, 4.0),
        side_bend: roll * 1.1 + rng.degrees(0.0, 1.5),
        twist: rng.degrees(0.0, 7.0),
    };
    torso::bend(figure, &torso, rng);
    plant(figure, &stance_of(way, eased, rng));
    torso::look(figure, rng.degrees(0.0, 26.0), rng.degrees(4.0, 9.0), rng.degrees(0.0, 4.0));
    let below = ArmGoal::Folded { on_top: false };
    let goals = rng.pick(&[
        (0.24, [ArmGoal::Hang, ArmGoal::Hang]),
        (0.1, [ArmGoal::Hang, ArmGoal::Akimbo]),
        (0.06, [ArmGoal::Akimbo, ArmGoal::Akimbo]),
        (0.13, [ArmGoal::Folded { on_top: true }, below]),
        (0.09, [ArmGoal::Pocket, ArmGoal::Pocket]),
        (0.08, [ArmGoal::Pocket, ArmGoal::Hang]),
        (0.07, [ArmGoal::ClaspedFront, ArmGoal::ClaspedFront]),
        (0.05, [ArmGoal::ClaspedBack, ArmGoal::ClaspedBack]),
        (0.07, [ArmGoal::Gesture, ArmGoal::Hang]),
        (0.04, [ArmGoal::Gesture, ArmGoal::Pocket]),
        (0.04, [ArmGoal::Gesture, ArmGoal::Gesture]),
        (0.03, [ArmGoal::Chin, ArmGoal::Akimbo]),
    ]);
    super::place_arms(figure, goals, rng)
}

fn stance_of(way: Stand, eased: f32, rng: &mut impl Chance) -> Stance {
    let (apart, ahead) = match way {
        Stand::Wide => (rng.between(0.04, 0.08), 0.0),
        Stand::Step => (0.0, rng.between(0.1, 0.24)),
        Stand::Even | Stand::OneLeg => (0.0, rng.about(0.03, 0.035)),
    };
    Stance {
        outward_m: [
            rng.between(0.05, 0.1) - 0.03 * eased + apart,
            rng.between(0.08, 0.13) + 0.04 * eased + apart,
        ],
        // A step is shared: the weight stays between the feet.
        forward_m: [-0.02 - 0.4 * ahead, -0.02 + 0.6 * ahead + 0.07 * eased],
        toe_out: [rng.degrees(9.0, 5.0), rng.degrees(12.0, 6.0) + 0.25 * eased],
        height_share: rng.between(0.988, 0.996),
    }
}

/// Leans with the hands on something in front, or with back or hips against something behind.
pub(super) fn lean(figure: &mut Figure, rng: &mut impl Chance, hints: &FamilyHints) -> [HandShape; 2] {
    let style = hints.lean.unwrap_or_else(|| {
        if hints.table_height_m.is_some() {
            return LeanStyle::HandsInFront;
        }
        rng.pick(&[
            (0.5, LeanStyle::HandsInFront),
            (0.25, LeanStyle::BackOnWall),
            (0.25, LeanStyle::HipsOnCounter),
        ])
    });
    match style {
        LeanStyle::HandsInFront => lean_on_hands(figure, rng, hints),
        LeanStyle::BackOnWall => lean_back(figure, rng, [0.14, 0.26], 7.0),
        LeanStyle::HipsOnCounter => lean_back(figure, rng, [0.12, 0.2], -2.0),
    }
}

fn lean_on_hands(figure: &mut Figure, rng: &mut impl Chance, hints: &FamilyHints) -> [HandShape; 2] {
    let counter_m = hints.table_height_m.unwrap_or_else(|| rng.between(0.85, 0.95));
    // The lower the counter the deeper the bow: level with the elbows (1.0 m) nobody bows at all.
    let bow = ((1.02 - counter_m) * 1.6).clamp(0.05, 0.7);
    let torso = Torso {
        pelvis_back: -(bow * 0.6 + rng.degrees(4.0, 2.0)),
        pelvis_roll: rng.degrees(0.0, 2.0),
        flexion: bow * 0.4 + rng.degrees(6.0, 4.0),
        side_bend: rng.degrees(0.0, 3.0),
        twist: rng.degrees(0.0, 5.0),
    };
    torso::bend(figure, &torso, rng);
    let back = -rng.between(0.02, 0.1) - 0.08 * bow;
    let height = plant(
        figure,
        &Stance {
            outward_m: [rng.between(0.07, 0.13), rng.between(0.07, 0.13)],
            forward_m: [back, back + rng.about(0.0, 0.06)],
            toe_out: [rng.degrees(8.0, 4.0), rng.degrees(8.0, 4.0)],
            height_share: 0.985,
        },
    );
    torso::look(figure, rng.degrees(0.0, 12.0), rng.degrees(20.0, 8.0), rng.degrees(0.0, 3.0));
    let on_counter = ArmGoal::Table {
        height_m: counter_m - height,
        reach_m: hints.table_reach_m.unwrap_or_else(|| rng.between(0.36, 0.44)),
    };
    let goals = rng.pick(&[
        (0.6, [on_counter, on_counter]),
        (0.2, [on_counter, ArmGoal::Hang]),
        (0.1, [on_counter, ArmGoal::Akimbo]),
        (0.1, [on_counter, ArmGoal::Gesture]),
    ]);
    super::place_arms(figure, goals, rng)
}

fn lean_back(
    figure: &mut Figure,
    rng: &mut impl Chance,
    feet_m: [f32; 2],
    back_degrees: f32,
) -> [HandShape; 2] {
    let torso = Torso {
        pelvis_back: rng.degrees(back_degrees + 4.0, 2.0),
        pelvis_roll: rng.degrees(0.0, 2.0),
        flexion: rng.degrees(6.0, 3.0),
        side_bend: rng.degrees(0.0, 2.0),
        twist: rng.degrees(0.0, 4.0),
    };
    torso::bend(figure, &torso, rng);
    let forward = rng.between(feet_m[0], feet_m[1]);
    let crossed = rng.chance(0.3);
    let (outward, second) = if crossed {
        ([0.02, -0.05], 0.13)
    } else {
        ([rng.between(0.06, 0.11), rng.between(0.06, 0.11)], 0.0)
    };
    plant(
        figure,
        &Stance {
            outward_m: outward,
            forward_m: [forward, forward + second + rng.about(0.0, 0.025)],
            toe_out: [rng.degrees(8.0, 4.0), rng.degrees(8.0, 4.0)],
            height_share: rng.between(0.975, 0.99),
        },
    );
    torso::look(figure, rng.degrees(0.0, 20.0), rng.degrees(3.0, 6.0), rng.degrees(0.0, 3.0));
    let goals = rng.pick(&[
        (0.35, [ArmGoal::Folded { on_top: true }, ArmGoal::Folded { on_top: false }]),
        (0.2, [ArmGoal::Pocket, ArmGoal::Pocket]),
        (0.2, [ArmGoal::Hang, ArmGoal::Hang]),
        (0.15, [ArmGoal::ClaspedFront, ArmGoal::ClaspedFront]),
        (0.1, [ArmGoal::Gesture, ArmGoal::Pocket]),
    ]);
    super::place_arms(figure, goals, rng)
}

/// Puts both feet flat on one floor by inverse kinematics of the legs; returns the pelvis joint's height
/// above that floor.
fn plant(figure: &mut Figure, stance: &Stance) -> f32 {
    let reach = |side: Side, i: usize| {
        let hip = figure.position(side.joint(LEFT_HIP));
        let leg = leg_of(side);
        let length = figure.bone(leg.lower) + figure.bone(leg.end);
        let ankle = Vec3::new(side.sign() * stance.outward_m[i], 0.0, stance.forward_m[i]);
        let aside = (ankle - hip).with_y(0.0).length_squared();
        // How far below the pelvis this ankle can be.
        (length * length * stance.height_share * stance.height_share - aside).max(0.0).sqrt() - hip.y
    };
    // The pelvis is as high as the shorter reaching leg lets it.
    let drop = reach(Side::Left, 0).min(reach(Side::Right, 1));
    for (i, side) in Side::BOTH.into_iter().enumerate() {
        let target = Vec3::new(side.sign() * stance.outward_m[i], -drop, stance.forward_m[i]);
        let toe_out = stance.toe_out[i] * side.sign();
        let pole = Mat3::from_rotation_y(toe_out) * Vec3::Z;
        figure.reach(leg_of(side), target, pole);
        set_foot(figure, side, Mat3::from_rotation_y(toe_out));
    }
    drop + ANKLE_HEIGHT_M
}

/// Turns a foot to a world rotation, toes in line.
pub(super) fn set_foot(figure: &mut Figure, side: Side, world: Mat3) {
    figure.set_rotation(side.joint(LEFT_ANKLE), world);
    figure.local[side.joint(LEFT_FOOT)] = Mat3::IDENTITY;
}
