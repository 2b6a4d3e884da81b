//! Standing bodies made from where their feet are.

use std::f32::consts::FRAC_PI_2;

use glam::{Quat, Vec3};
use rand::RngExt as _;

use super::figure::{FootPose, Person, Stick, ahead, near, wrap, yaw};
use super::model::Pace;
use crate::body::joints as j;
use crate::job::Seed;
use crate::motion::leg::FootPlace;
use crate::scene::HANDS;

/// Ankles of somebody who stands at ease, apart over the hips' width: a little less than the hips.
const STANCE_SHARE: f32 = 0.85;
/// Toes outwards in standing, radians (10 degrees).
const TOE_OUT: f32 = 0.17;
/// The pelvis stands this far before the ankles, metres: the weight is over the arches of the feet.
const PELVIS_AHEAD_M: f32 = 0.035;
/// Legs in standing over their full length.
const STANDING_SHARE: f32 = 0.993;
/// Arms hang straighter in standing than their mean in walking.
const ELBOW_SHARE: f32 = 0.55;

/// Places of the feet of somebody who stands at a point of the floor, left then right.
pub(super) fn places(person: &Person, at: Vec3, facing: f32) -> [FootPlace; 2] {
    let half = 0.5 * STANCE_SHARE * person.hips_m();
    let left = ahead(facing + FRAC_PI_2);
    [1.0, -1.0].map(|out| FootPlace {
        at: at - ahead(facing) * PELVIS_AHEAD_M + left * (half * out),
        heading: facing + TOE_OUT * out,
    })
}

/// Flat feet at two places.
pub(super) fn feet_at(person: &Person, places: &[FootPlace; 2]) -> [FootPose; 2] {
    std::array::from_fn(|i| FootPose::flat(&person.feet[i], places[i].at, places[i].heading))
}

/// Somebody who stands relaxed on these feet.
pub(super) fn stand(person: &Person, feet: [FootPose; 2], seed: Seed) -> Stick {
    let mut rng = seed.child("stance", 0).rng();
    let mut about = |degrees: f32| rng.random_range(-degrees..degrees).to_radians();
    let (left, right) = (feet[0].heading(), feet[1].heading());
    let facing = right + 0.5 * wrap(left - right);
    let model = person.model;
    let rest = |joint: usize| {
        model
            .joint(joint)
            .map_or(Quat::IDENTITY, |s| s.at(0.0, Pace { speed: model.speeds[0], turn: 0.0 }, 0.0))
    };
    let mut turns: [Quat; 21] = std::array::from_fn(|i| rest(i + 1));
    for elbow in [j::LEFT_ELBOW, j::RIGHT_ELBOW] {
        turns[elbow - 1] = Quat::IDENTITY.slerp(near(Quat::IDENTITY, turns[elbow - 1]), ELBOW_SHARE);
    }
    for (joint, degrees) in
        [(j::HEAD, 6.0), (j::LEFT_SHOULDER, 4.0), (j::RIGHT_SHOULDER, 4.0), (j::SPINE2, 1.5)]
    {
        let varied = Quat::from_scaled_axis(Vec3::new(about(degrees), about(degrees), about(degrees)));
        turns[joint - 1] = (varied * turns[joint - 1]).normalize();
    }
    let middle = feet[0].ankle.midpoint(feet[1].ankle) + ahead(facing) * PELVIS_AHEAD_M;
    let mut stick = Stick {
        pelvis: middle + Vec3::Y * (person.leg_m + person.pelvis_above_hips_m() + 0.05),
        rotation: yaw(facing),
        turns,
        feet,
        poles: [1.0, -1.0].map(|out| Vec3::new(0.12 * out, 0.0, 1.0).normalize_or(Vec3::Z)),
        twists: [[Quat::IDENTITY; 2]; 2],
        hands: [0.0; HANDS],
    };
    let high = stick.overreach_m(person, STANDING_SHARE).into_iter().fold(0.0, f32::max);
    stick.pelvis.y -= high;
    stick
}
