//! Finds strides of walking in a clip and measures each.
//!
//! A foot lands where it is farthest ahead of the pelvis along the way (Zeni, Richards and Higginson 2008: kinematic
//! events without force plates), which needs no guess at contact heights.

use glam::{Quat, Vec3};

use crate::body::joints::{LEFT_ANKLE, RIGHT_ANKLE, RIGHT_FOOT};
use crate::motion::gait::{KNOTS, Pace};

use super::track::Track;
use super::{INSTANTS, TURNING};

/// Seconds within which a foot lands once.
const LANDING_S: f32 = 0.35;
/// A landing foot is at least this far ahead of the pelvis, metres.
const LEAST_AHEAD_M: f32 = 0.12;
/// Strides of walking, seconds: slower ones are interrupted, faster ones are runs.
const STRIDE_S: [f32; 2] = [0.8, 1.7];
/// Speeds of walking, metres per second on the mean body.
const SPEED_M_PER_S: [f32; 2] = [0.35, 1.95];
/// The other foot lands in the middle of a stride; farther off somebody turns, limps or stops.
const OTHER_SHARE: [f32; 2] = [0.42, 0.58];
/// Shares of the stride on the floor: below a half there is a flight phase.
const DUTY: [f32; 2] = [0.53, 0.75];
/// Step width over the leg's length in a walk ahead.
const WIDTH: [f32; 2] = [0.02, 0.3];
/// Fastest change of speed between the halves of a stride, as a share.
const STEADY: f32 = 0.2;

/// One stride, from one landing of the right foot to the next.
pub(super) struct Stride {
    pub(super) pace: Pace,
    /// For each instant the rotation of the [`TURNING`] joints; the pelvis's in the frame of the way.
    pub(super) turns: Vec<[Quat; TURNING.len()]>,
    /// Pelvis above the flat ankle over the leg's length.
    pub(super) height: Vec<f32>,
    /// Pelvis to the left of its mean way over the leg's length.
    pub(super) sway: Vec<f32>,
    pub(super) step_length: f32,
    pub(super) step_width: f32,
    pub(super) duty: f32,
    pub(super) stance_pitch: [f32; KNOTS],
    pub(super) swing_pitch: [f32; KNOTS],
    pub(super) swing_way: [f32; KNOTS],
    pub(super) swing_lift: [f32; KNOTS],
}

/// Every steady stride of a track.
pub(super) fn strides(track: &Track) -> Vec<Stride> {
    let right = landings(track, RIGHT_ANKLE);
    let left = landings(track, LEFT_ANKLE);
    right.windows(2).filter_map(|pair| stride(track, [pair[0], pair[1]], &left)).collect()
}

/// Frames in which a foot is farthest ahead of the pelvis.
fn landings(track: &Track, ankle: usize) -> Vec<usize> {
    let ahead = |i: usize| (track.positions[i][ankle] - track.positions[i][0]).dot(track.ahead[i]);
    let reach = track.frames(LANDING_S);
    (reach..track.len().saturating_sub(reach))
        .filter(|&i| {
            let here = ahead(i);
            here > LEAST_AHEAD_M
                && (i - reach..i).all(|k| ahead(k) < here)
                && (i + 1..=i + reach).all(|k| ahead(k) <= here)
        })
        .collect()
}

/// The frame in which a foot takes off: its ball leaves the place where it was while the foot was flat.
fn takes_off(track: &Track, ball: usize, [from, to]: [usize; 2]) -> usize {
    let at = |share: f32| from + (share * (to - from) as f32) as usize;
    let (a, b) = (at(FLAT[0]), at(FLAT[1]));
    let placed = (a..=b).map(|i| track.positions[i][ball]).sum::<Vec3>() / (b - a + 1) as f32;
    (b..to).find(|i| track.positions[*i][ball].distance(placed) > LIFTED_M).unwrap_or(to)
}

/// A ball of the foot that has moved by this much has left the floor, metres.
const LIFTED_M: f32 = 0.05;
/// Shares of the stride between which a foot is flat.
const FLAT: [f32; 2] = [0.16, 0.28];

fn within(x: f32, [low, high]: [f32; 2]) -> bool {
    (low..=high).contains(&x)
}

fn stride(track: &Track, [from, to]: [usize; 2], left: &[usize]) -> Option<Stride> {
    let mut others = left.iter().copied().filter(|l| (from..to).contains(l));
    let (other, None) = (others.next()?, others.next()) else { return None };
    let seconds = (to - from) as f32 * track.frame_seconds;
    let pelvis = |i: usize| track.positions[i][0];
    let level = |a: usize, b: usize| (pelvis(b) - pelvis(a)).with_y(0.0).length();
    let speed = level(from, to) / seconds;
    let halves =
        [(from, other), (other, to)].map(|(a, b)| level(a, b) / ((b - a) as f32 * track.frame_seconds));
    let off = takes_off(track, RIGHT_FOOT, [from, to]);
    let duty = (off - from) as f32 / (to - from) as f32;
    let share = (other - from) as f32 / (to - from) as f32;
    let steady = (halves[0] - halves[1]).abs() < STEADY * speed;
    let walks = within(seconds, STRIDE_S) && within(speed, SPEED_M_PER_S) && within(duty, DUTY);
    if !(walks && steady && within(share, OTHER_SHARE)) {
        return None;
    }
    let turned = signed_angle(track.ahead[from], track.ahead[to.min(track.len() - 1)]);
    let pace = Pace::new(speed, track.leg_m, turned / seconds);
    let stride = Measure { track, from, other, off, to }.stride(pace, duty);
    // Feet that cross or are far apart step aside.
    within(stride.step_width, WIDTH).then_some(stride)
}

/// Turn to the left from one horizontal direction to another.
fn signed_angle(a: Vec3, b: Vec3) -> f32 {
    a.cross(b).y.atan2(a.dot(b))
}

/// One stride's frames.
struct Measure<'a> {
    track: &'a Track,
    from: usize,
    other: usize,
    off: usize,
    to: usize,
}

impl Measure<'_> {
    fn stride(&self, pace: Pace, duty: f32) -> Stride {
        let leg = self.track.leg_m;
        let instants: Vec<f32> = (0..INSTANTS).map(|i| self.frame_at(i as f32 / INSTANTS as f32)).collect();
        let floor = self.flat_ankle_m();
        let height = instants.iter().map(|t| (self.point(*t, 0).y - floor) / leg).collect();
        let both = self.landing();
        Stride {
            pace,
            turns: instants.iter().map(|t| self.turns(*t)).collect(),
            height,
            sway: instants.iter().map(|t| self.sway(*t) / leg).collect(),
            step_length: both.length / leg,
            step_width: both.width / leg,
            duty,
            stance_pitch: self.pitches(self.from, self.off),
            swing_pitch: self.pitches(self.off, self.to),
            swing_way: self.swing_way(),
            swing_lift: self.knots(self.off, self.to, &|t| (self.point(t, RIGHT_ANKLE).y - floor) / leg),
        }
    }

    /// Frame number at a share of the stride; the left landing is the middle.
    fn frame_at(&self, share: f32) -> f32 {
        let [from, other, to] = [self.from, self.other, self.to].map(|i| i as f32);
        if share < 0.5 {
            from + (other - from) * 2.0 * share
        } else {
            other + (to - other) * (2.0 * share - 1.0)
        }
    }

    fn neighbours(&self, at: f32) -> (usize, usize, f32) {
        let i = (at as usize).min(self.track.len() - 1);
        (i, (i + 1).min(self.track.len() - 1), at - i as f32)
    }

    fn point(&self, at: f32, joint: usize) -> Vec3 {
        let (a, b, share) = self.neighbours(at);
        self.track.positions[a][joint].lerp(self.track.positions[b][joint], share)
    }

    fn turns(&self, at: f32) -> [Quat; TURNING.len()] {
        let (a, b, share) = self.neighbours(at);
        let way = self.way_direction();
        std::array::from_fn(|i| {
            let joint = TURNING[i];
            let turn = self.track.local[a][joint].slerp(self.track.local[b][joint], share);
            if joint == 0 { way(at).inverse() * turn } else { turn }
        })
    }

    /// Turn about Y of the way at each instant: from the direction at the stride's beginning to that at its end, so
    /// that the pelvis's own turning is not taken for the way's.
    fn way_direction(&self) -> impl Fn(f32) -> Quat {
        let chord =
            |a: usize, b: usize| (self.track.positions[b][0] - self.track.positions[a][0]).with_y(0.0);
        let (first, second) = (chord(self.from, self.other), chord(self.other, self.to));
        let mean = (first + second).normalize_or(Vec3::Z);
        let turn = signed_angle(first, second);
        let (middle, span) = (0.5 * (self.from + self.to) as f32, 0.5 * (self.to - self.from) as f32);
        move |at: f32| {
            // The halves' directions hold in their middles, half a stride apart.
            let off = (at - middle) / span * turn;
            Quat::from_rotation_y(mean.x.atan2(mean.z) + off)
        }
    }

    fn sway(&self, at: f32) -> f32 {
        // The mean way: a parabola through the landings' pelvis positions would follow the sway, a chord over one
        // whole stride around the instant does not.
        let half = 0.5 * (self.to - self.from) as f32;
        let last = (self.track.len() - 1) as f32;
        let steps = 16;
        let around = (0..steps).map(|k| at - half + (k as f32 + 0.5) * 2.0 * half / steps as f32);
        let mean: Vec3 = around.map(|t| self.point(t.clamp(0.0, last), 0)).sum::<Vec3>() / steps as f32;
        let left = self.way_direction()(at) * Vec3::X;
        (self.point(at, 0) - mean).dot(left)
    }

    /// Height of the right ankle while its foot is flat.
    fn flat_ankle_m(&self) -> f32 {
        let (a, b) = self.flat();
        let heights = (a..=b).map(|i| self.track.positions[i][RIGHT_ANKLE].y);
        heights.sum::<f32>() / (b - a + 1) as f32
    }

    /// Frames in which the right foot is flat.
    fn flat(&self) -> (usize, usize) {
        let stride = (self.to - self.from) as f32;
        (self.from + (FLAT[0] * stride) as usize, self.from + (FLAT[1] * stride) as usize)
    }

    fn pitch_of(&self, at: f32) -> f32 {
        let (a, b, share) = self.neighbours(at);
        let toes = self.track.feet[a][1].slerp(self.track.feet[b][1], share) * Vec3::Z;
        -toes.y.atan2(toes.with_y(0.0).length())
    }

    fn flat_pitch(&self) -> f32 {
        let (a, b) = self.flat();
        (a..=b).map(|i| self.pitch_of(i as f32)).sum::<f32>() / (b - a + 1) as f32
    }

    fn pitches(&self, from: usize, to: usize) -> [f32; KNOTS] {
        let flat = self.flat_pitch();
        self.knots(from, to, &|t| self.pitch_of(t) - flat)
    }

    fn swing_way(&self) -> [f32; KNOTS] {
        let [a, b] = [self.off, self.to].map(|i| self.point(i as f32, RIGHT_ANKLE));
        let way = (b - a).with_y(0.0);
        let squared = way.length_squared().max(1e-6);
        self.knots(self.off, self.to, &|t| (self.point(t, RIGHT_ANKLE) - a).dot(way) / squared)
    }

    fn knots(&self, from: usize, to: usize, of: &dyn Fn(f32) -> f32) -> [f32; KNOTS] {
        let (from, to) = (from as f32, to as f32);
        std::array::from_fn(|k| of(from + (to - from) * k as f32 / (KNOTS - 1) as f32))
    }

    /// Where the flat feet stand around the right foot's landing.
    fn landing(&self) -> Landing {
        let middle = 0.5 * (FLAT[0] + FLAT[1]) * (self.to - self.from) as f32;
        let flat = |from: usize, ankle: usize| self.point(from as f32 + middle, ankle);
        let advance =
            self.track.positions[self.to][RIGHT_ANKLE] - self.track.positions[self.from][RIGHT_ANKLE];
        let right = flat(self.from, RIGHT_ANKLE);
        // Where the left foot stood before is where it stands now less one stride.
        let left = flat(self.other, LEFT_ANKLE);
        let way = self.way_direction()(self.from as f32).inverse();
        Landing {
            length: 0.5 * advance.with_y(0.0).length(),
            width: (way * (left - 0.5 * advance - right)).x,
        }
    }
}

struct Landing {
    length: f32,
    width: f32,
}
