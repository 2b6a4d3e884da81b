//! Spine, neck and head.

use glam::{EulerRot, Mat3, Vec3};

use crate::body::joints::{HEAD, LEFT_COLLAR, NECK, PELVIS, RIGHT_COLLAR, SPINE1, SPINE2, SPINE3};

use super::chance::Chance;
use super::figure::Figure;

/// Angles of a torso, radians.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Torso {
    /// Pelvis tilted back against the upright.
    pub(super) pelvis_back: f32,
    /// Pelvis rolled: its left side up.
    pub(super) pelvis_roll: f32,
    /// The spine's total bend forward.
    pub(super) flexion: f32,
    /// The spine's total bend to the left.
    pub(super) side_bend: f32,
    /// The spine's total turn to the left.
    pub(super) twist: f32,
}

/// Shares of the spine's bend taken by its three joints: the lumbar spine bends most, the chest hardly.
const BEND_SHARES: [f32; 3] = [0.45, 0.35, 0.2];
/// Shares of its turn: the chest turns most, the lumbar spine hardly (White and Panjabi 1990).
const TWIST_SHARES: [f32; 3] = [0.15, 0.35, 0.5];

/// Sets pelvis and spine, with a little of each person's own asymmetry.
pub(super) fn bend(figure: &mut Figure, torso: &Torso, rng: &mut impl Chance) {
    figure.local[PELVIS] =
        Mat3::from_rotation_z(torso.pelvis_roll) * Mat3::from_rotation_x(-torso.pelvis_back);
    for (i, joint) in [SPINE1, SPINE2, SPINE3].into_iter().enumerate() {
        let turn = torso.twist * TWIST_SHARES[i] + rng.degrees(0.0, 1.0);
        let bend = torso.flexion * BEND_SHARES[i] + rng.degrees(0.0, 1.0);
        let side = -torso.side_bend * BEND_SHARES[i] + rng.degrees(0.0, 1.0);
        figure.local[joint] = Mat3::from_euler(EulerRot::YXZ, turn, bend, side);
    }
    for (collar, sign) in [(LEFT_COLLAR, 1.0), (RIGHT_COLLAR, -1.0)] {
        let (drop, forward) = (rng.degrees(-4.0, 2.0), rng.degrees(3.0, 3.0));
        figure.local[collar] = Mat3::from_rotation_z(sign * drop) * Mat3::from_rotation_y(-sign * forward);
    }
}

/// Turns the head in the world: `turn` to the left, `nod` down, `tilt` to the left, radians; neck and head
/// share the way, and neither goes farther than a neck does in comfort.
pub(super) fn look(figure: &mut Figure, turn: f32, nod: f32, tilt: f32) {
    let world = Mat3::from_euler(EulerRot::YXZ, turn, nod, -tilt);
    let relative = figure.rotation(SPINE3).transpose() * world;
    turn_neck(figure, crate::math::rotation::axis_angle_from_matrix(relative));
}

/// Turns neck and head by an axis-angle against the chest.
pub(super) fn turn_neck(figure: &mut Figure, axis_angle: Vec3) {
    let half = axis_angle.clamp_length_max(MAX_HEAD_TURN) * 0.5;
    for joint in [NECK, HEAD] {
        figure.local[joint] = crate::math::rotation::matrix_from_axis_angle(half);
    }
}

/// Radians that neck and head turn together; the norm of rotation is 70 to 80 degrees to a side.
const MAX_HEAD_TURN: f32 = 1.25;
