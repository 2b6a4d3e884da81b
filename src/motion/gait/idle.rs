//! Staying: breathing, small shifts of the weight, glances.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};
use rand::RngExt as _;

use super::curve::{ease, smooth_cover};
use super::figure::{Person, Stick};
use super::posture::on_floor;
use crate::body::joints as j;
use crate::job::Seed;
use crate::motion::leg::{LegMotion, Still};
use crate::scene::{CLIP_FPS, GoalPose};

/// Breaths a second at rest: 12 to 18 a minute.
const BREATHS_HZ: [f32; 2] = [0.2, 0.29];
/// How far a breath straightens the chest and lifts the collar bones, radians.
const CHEST: f32 = 0.016;
const COLLAR: f32 = 0.02;
/// Excursions of the pelvis in quiet standing, metres to the side and ahead: a visible shift of the weight now and then
/// on top of the millimetres of balance.
const SHIFT_M: [f32; 2] = [0.014, 0.006];
/// Time to come into the stay and out of it, seconds.
const EASE_S: f32 = 1.2;
/// Time between glances, how long one is held and how far it goes.
const GLANCE_EVERY_S: [f32; 2] = [2.5, 6.0];
const GLANCE_HELD_S: [f32; 2] = [0.8, 2.6];
const GLANCE_RADIANS: [f32; 2] = [0.42, 0.14];
/// Turning the head takes this long, seconds.
const GLANCE_S: f32 = 0.7;

struct Manner {
    breath_hz: f32,
    breath_phase: f32,
    shifts: [[f32; 2]; 4],
    glances: Vec<Glance>,
    /// How much of the shifts and glances the posture has.
    freedom: f32,
}

/// Looking somewhere for a while.
struct Glance {
    from_s: f32,
    to_s: f32,
    yaw: f32,
    pitch: f32,
}

/// Stays in a known body above a floor of this height for about `seconds`.
pub(super) fn stay(person: &Person, still: &Still, floor_y: f32, seconds: f32, seed: Seed) -> LegMotion {
    let count = (seconds * CLIP_FPS).round().max(1.0) as usize;
    let seconds = count as f32 / CLIP_FPS;
    let stick = Stick::of(person, &still.frame);
    let manner = Manner::new(still.pose, seconds, seed);
    let mut sticks: Vec<Stick> =
        (0..=count).map(|i| manner.at(&stick, i as f32 / CLIP_FPS, seconds)).collect();
    let at_rest = stick.overreach_m(person, REST_SHARE).into_iter().fold(0.0, f32::max);
    let needed: Vec<f32> = sticks
        .iter()
        .map(|s| s.overreach_m(person, REST_SHARE).into_iter().fold(0.0, f32::max) - at_rest)
        .collect();
    for (stick, by) in sticks.iter_mut().zip(smooth_cover(&needed, 4)) {
        stick.pelvis.y -= by;
    }
    let stands = still.pose != GoalPose::Lie;
    let planted = std::array::from_fn(|i| stands && on_floor(person, &stick.feet[i], floor_y));
    let mut frames: Vec<_> = sticks.iter().map(|s| s.frame(person)).collect();
    frames[0] = still.frame.clone();
    frames[count] = still.frame.clone();
    LegMotion { planted: vec![planted; frames.len()], frames }
}

/// Legs at rest may be this straight.
const REST_SHARE: f32 = 0.9995;

impl Manner {
    fn new(pose: GoalPose, seconds: f32, seed: Seed) -> Self {
        let mut rng = seed.child("idle", 0).rng();
        let freedom = match pose {
            GoalPose::Lie => 0.3,
            GoalPose::Sit => 0.8,
            _ => 1.0,
        };
        let mut glances = Vec::new();
        let mut now = rng.random_range(0.6..GLANCE_EVERY_S[0]);
        loop {
            let held = rng.random_range(GLANCE_HELD_S[0]..GLANCE_HELD_S[1]);
            let to_s = now + held + 2.0 * GLANCE_S;
            if to_s > seconds {
                break;
            }
            let yaw = rng.random_range(-GLANCE_RADIANS[0]..GLANCE_RADIANS[0]);
            let pitch = rng.random_range(-0.6 * GLANCE_RADIANS[1]..GLANCE_RADIANS[1]);
            glances.push(Glance { from_s: now, to_s, yaw, pitch });
            now = to_s + rng.random_range(GLANCE_EVERY_S[0]..GLANCE_EVERY_S[1]);
        }
        Self {
            breath_hz: rng.random_range(BREATHS_HZ[0]..BREATHS_HZ[1]),
            breath_phase: rng.random_range(0.0..TAU),
            shifts: std::array::from_fn(|i| {
                let slow = [0.07, 0.16, 0.11, 0.23][i];
                [slow * rng.random_range(0.8..1.25), rng.random_range(0.0..TAU)]
            }),
            glances,
            freedom,
        }
    }

    fn at(&self, still: &Stick, t: f32, seconds: f32) -> Stick {
        let over = EASE_S.min(0.5 * seconds);
        let awake = ease(t, 0.0, over) * (1.0 - ease(t, seconds - over, seconds));
        let mut stick = still.clone();
        let breath = awake * (TAU * self.breath_hz * t + self.breath_phase).sin();
        self.breathe(&mut stick, breath);
        self.shift(&mut stick, t, awake * self.freedom);
        for glance in &self.glances {
            let up = ease(t, glance.from_s, glance.from_s + GLANCE_S);
            let looks = up * (1.0 - ease(t, glance.to_s - GLANCE_S, glance.to_s)) * self.freedom;
            for (joint, share) in [(j::SPINE3, 0.12), (j::NECK, 0.4), (j::HEAD, 0.48)] {
                let turn = Quat::from_rotation_y(glance.yaw * looks * share)
                    * Quat::from_rotation_x(glance.pitch * looks * share);
                stick.turns[joint - 1] = turn * stick.turns[joint - 1];
            }
        }
        stick
    }

    fn breathe(&self, stick: &mut Stick, breath: f32) {
        let pitch = |by: f32| Quat::from_rotation_x(by);
        stick.turns[j::SPINE2 - 1] = pitch(-CHEST * breath) * stick.turns[j::SPINE2 - 1];
        stick.turns[j::SPINE3 - 1] = pitch(-0.6 * CHEST * breath) * stick.turns[j::SPINE3 - 1];
        stick.turns[j::NECK - 1] = pitch(1.1 * CHEST * breath) * stick.turns[j::NECK - 1];
        for (collar, out) in [(j::LEFT_COLLAR, 1.0), (j::RIGHT_COLLAR, -1.0)] {
            let lift = Quat::from_rotation_z(COLLAR * breath * out);
            stick.turns[collar - 1] = lift * stick.turns[collar - 1];
        }
    }

    /// The pelvis wanders over the feet and the trunk keeps the head where it was.
    fn shift(&self, stick: &mut Stick, t: f32, by: f32) {
        let wave = |i: usize| (TAU * self.shifts[i][0] * t + self.shifts[i][1]).sin();
        let (side, front) = (0.7 * wave(0) + 0.3 * wave(1), 0.7 * wave(2) + 0.3 * wave(3));
        let off = Vec3::new(SHIFT_M[0] * side, 0.0, SHIFT_M[1] * front) * by;
        // Seated and lying bodies rest on their pelvis: only the trunk moves.
        if self.freedom >= 1.0 {
            stick.pelvis += super::figure::yaw(super::figure::facing(stick.rotation)) * off;
        }
        let lean = Quat::from_rotation_z(1.1 * off.x) * Quat::from_rotation_x(-1.1 * off.z);
        stick.turns[j::SPINE1 - 1] = lean * stick.turns[j::SPINE1 - 1];
        stick.turns[j::HEAD - 1] = lean.inverse() * stick.turns[j::HEAD - 1];
    }
}
