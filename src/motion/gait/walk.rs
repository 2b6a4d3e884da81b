//! A walk from its footsteps: where the pelvis goes over the feet, what trunk and arms do, and the frames of it.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Quat, Vec3};

use super::curve::{Rising, Spline, ease, smooth_cover};
use super::feet::{FootMoment, FootTrack, rolled, toes_room};
use super::figure::{FootPose, Person, Stick, ahead, facing, tilt, wrap, yaw};
use super::model::Pace;
use super::steps::{Canonical, Fall, Steps, WalkEnd, plan};
use super::style::Style;
use super::way::Way;
use crate::body::joints as j;
use crate::motion::leg::{LegMotion, PathPoint, Walking};
use crate::scene::CLIP_FPS;

/// An end of a walk.
#[derive(Clone, Debug)]
pub(super) enum End {
    /// At rest in a body that stands.
    Still(Box<Stick>),
    /// In the middle of a walk.
    Walking(Walking),
}

impl End {
    fn steps(&self) -> WalkEnd {
        match self {
            Self::Still(stick) => WalkEnd::Still { feet: stick.feet, facing: facing(stick.rotation) },
            Self::Walking(state) => WalkEnd::Walking(*state),
        }
    }

    fn heading(&self) -> f32 {
        match self {
            Self::Still(stick) => facing(stick.rotation),
            Self::Walking(state) => state.heading,
        }
    }

    fn speed(&self) -> f32 {
        match self {
            Self::Still(_) => 0.0,
            Self::Walking(state) => state.speed_m_per_s,
        }
    }
}

/// A pose taken up or left behind takes this long to go over into walking, seconds.
const BLEND_S: f32 = 1.1;
/// Legs are straight to this share at most in the middle of a walk: knees stay soft.
const SOFT_SHARE: f32 = 0.99;
/// Legs at rest may be straighter.
const REST_SHARE: f32 = 0.9995;
/// Hip above ankle over the leg's length, the mean of a walk: knees of 10 to 15 degrees in the middle of the stance
/// (Winter 1990); captured skeletons disagree by centimetres, so only the rise and fall is taken from them.
const WALKING_SHARE: f32 = 0.98;
/// The pelvis is lowest in the middle of the double support (Winter 1990). The measured series is so much later,
/// radians of the gait's phase: uncorrected, the knee of a foot that has just landed bends by 24 degrees instead of 15 to 18.
const HEIGHT_LEADS: f32 = 0.35;
/// Frames over which the pelvis comes down for a leg that would be too short, and a heel comes up.
const LOWER_FRAMES: usize = 2;
const RISE_FRAMES: usize = 2;
/// A heel comes up by at most this much more than measured for a leg to reach, radians.
const EXTRA_RISE: f32 = 0.4;
/// Over this long the pelvis's height goes over into that of an end, seconds.
const LEAD_S: f32 = 0.25;
/// Speed from which trunk and arms swing as measured, metres per second; slower, they swing less.
const LIVELY_M_PER_S: f32 = 0.75;
/// Eyes go ahead of the body by this long in turns, seconds, and by at most this angle.
const GAZE_S: f32 = 0.55;
const GAZE_RADIANS: f32 = 0.7;

/// Walks from one end to the other along the way, in `seconds` if given.
pub(super) fn walk(
    person: &Person,
    ends: [&End; 2],
    way: &Way,
    seconds: Option<f32>,
    style: &Style,
) -> LegMotion {
    let walk = Walk::new(person, ends, way, seconds, style);
    walk.motion()
}

/// A steady walk through the canonical moment of `state`, from so many strides before to so many after it, and its way.
fn steady(person: &Person, state: &Walking, strides: [f32; 2]) -> ([End; 2], Way) {
    let stride = ahead(state.heading) * (2.0 * Canonical::of(person, state).step_s * state.speed_m_per_s);
    let ends = strides.map(|by| Walking { at: state.at + stride * by, ..*state });
    let point = |state: Walking| PathPoint {
        at: state.at,
        heading: state.heading,
        clearance_m: 1.0,
        speed_m_per_s: state.speed_m_per_s,
    };
    let way = Way::new(&ends.map(point));
    (ends.map(End::Walking), way)
}

/// What has to give way at a moment for both legs to reach their feet.
#[derive(Clone, Copy, Debug, Default)]
struct Give {
    /// The pelvis comes down, metres.
    lower_m: f32,
    /// Each heel comes up, radians.
    rise: [f32; 2],
}

/// What gives way at the canonical moment of a walk.
fn canonical_give(person: &Person, state: &Walking) -> Give {
    let (ends, way) = steady(person, state, [-1.0, 1.0]);
    let style = Style::plain();
    let walk = Walk::new(person, [&ends[0], &ends[1]], &way, None, &style);
    let middle_s = walk.falls.get(1).map_or(0.0, |fall| fall.land_s);
    let around = 3 * LOWER_FRAMES;
    let times: Vec<f32> =
        (0..=2 * around).map(|i| middle_s + (i as f32 - around as f32) / CLIP_FPS).collect();
    walk.give(&times)[around]
}

/// The pose at the canonical moment of a walk.
pub(super) fn walking_stick(person: &Person, state: &Walking) -> Stick {
    let (ends, way) = steady(person, state, [0.0, 1.0]);
    let style = Style::plain();
    let mut stick = Walk::new(person, [&ends[0], &ends[1]], &way, None, &style).stick(0.0).0;
    canonical_give(person, state).apply(person, &mut stick);
    stick
}

impl Give {
    fn apply(&self, person: &Person, stick: &mut Stick) {
        stick.pelvis.y -= self.lower_m;
        for foot in 0..2 {
            stick.feet[foot] = rolled(&stick.feet[foot], &person.feet[foot], self.rise[foot]);
        }
    }

    fn plus(&self, other: &Self, by: f32, less: &Self) -> Self {
        Self {
            lower_m: self.lower_m + by * (other.lower_m - less.lower_m),
            rise: [0, 1].map(|i| (self.rise[i] + by * (other.rise[i] - less.rise[i])).max(0.0)),
        }
    }
}

struct Walk<'a> {
    person: &'a Person,
    ends: [&'a End; 2],
    style: &'a Style,
    seconds: f32,
    feet: [FootTrack; 2],
    phase: Rising,
    /// Pelvis over the floor; y holds the floor's height.
    path: Spline,
    /// Heading in x; sway's half width in y.
    turn: Spline,
    falls: Vec<Fall>,
    steps: usize,
}

impl<'a> Walk<'a> {
    fn new(
        person: &'a Person,
        ends: [&'a End; 2],
        way: &'a Way,
        seconds: Option<f32>,
        style: &'a Style,
    ) -> Self {
        let walk_ends = ends.map(End::steps);
        let walk_ends = [&walk_ends[0], &walk_ends[1]];
        let steps = plan(person, walk_ends, way, style);
        let wanted = seconds.unwrap_or(steps.seconds).clamp(0.6 * steps.seconds, 2.5 * steps.seconds);
        let frames = (wanted * CLIP_FPS).round().max(1.0);
        let steps = steps.stretched(frames / CLIP_FPS);
        Self {
            person,
            ends,
            style,
            seconds: steps.seconds,
            feet: steps.tracks(person, walk_ends),
            phase: phase(person, ends, &steps),
            path: path(person, ends, &steps),
            turn: turn(person, ends, &steps),
            steps: steps.falls.len(),
            falls: steps.falls,
        }
    }

    fn motion(&self) -> LegMotion {
        let count = (self.seconds * CLIP_FPS).round() as usize;
        let time = |i: usize| self.seconds * i as f32 / count as f32;
        let times: Vec<f32> = (0..=count).map(time).collect();
        let given = self.give(&times);
        let ends = [0, 1].map(|end| match self.ends[end] {
            End::Still(_) => Give::default(),
            End::Walking(state) => canonical_give(self.person, state),
        });
        let mut moments = Vec::with_capacity(count + 1);
        for (t, give) in times.iter().zip(&given) {
            // What the leg before and the leg after do at the ends is what this one does there.
            let give = give.plus(&ends[0], 1.0 - ease(*t, 0.0, LEAD_S), &given[0]).plus(
                &ends[1],
                ease(*t, self.seconds - LEAD_S, self.seconds),
                &given[count],
            );
            let (mut stick, moments_of_feet) = self.stick(*t);
            give.apply(self.person, &mut stick);
            for foot in 0..2 {
                stick.soften(self.person, foot, 1.0 - moments_of_feet[foot].on_floor);
            }
            let planted = [0, 1].map(|i| moments_of_feet[i].planted && give.rise[i] < 0.02);
            moments.push((stick, planted));
        }
        LegMotion {
            frames: moments.iter().map(|(stick, _)| stick.frame(self.person)).collect(),
            planted: moments.iter().map(|(_, planted)| *planted).collect(),
        }
    }

    /// For each time how far heels come up and then the pelvis down, smoothly, so that no standing leg is overstretched.
    fn give(&self, times: &[f32]) -> Vec<Give> {
        let share = |t: f32| SOFT_SHARE + (REST_SHARE - SOFT_SHARE) * self.rest(t);
        let moments: Vec<(Stick, [FootMoment; 2])> = times.iter().map(|t| self.stick(*t)).collect();
        let rise = [0, 1].map(|foot| {
            let needed: Vec<f32> = moments
                .iter()
                .zip(times)
                .map(|((stick, feet), t)| feet[foot].heel_free * self.rise(stick, foot, share(*t)))
                .collect();
            smooth_cover(&needed, RISE_FRAMES)
        });
        let lower: Vec<f32> = (0..times.len())
            .map(|i| {
                let (mut stick, feet) = moments[i].clone();
                Give { lower_m: 0.0, rise: [rise[0][i], rise[1][i]] }.apply(self.person, &mut stick);
                let over = stick.overreach_m(self.person, share(times[i]));
                (0..2).map(|foot| over[foot] * feet[foot].on_floor).fold(0.0, f32::max)
            })
            .collect();
        let lower = smooth_cover(&lower, LOWER_FRAMES);
        (0..times.len()).map(|i| Give { lower_m: lower[i], rise: [rise[0][i], rise[1][i]] }).collect()
    }

    /// How far a heel has to come up for its leg to reach.
    fn rise(&self, stick: &Stick, foot: usize, share: f32) -> f32 {
        let mut rise = 0.0;
        let most = EXTRA_RISE.min(toes_room(&stick.feet[foot]));
        let mut raised = stick.clone();
        // The ankle comes up by the length of the foot's lever times the angle: a few steps of Newton's method.
        for _ in 0..4 {
            raised.feet[foot] = rolled(&stick.feet[foot], &self.person.feet[foot], rise);
            let over = raised.overreach_m(self.person, share)[foot];
            rise = (rise + over / self.person.feet[foot].ball.z).min(most);
        }
        rise
    }

    fn velocity(&self, t: f32) -> Vec3 {
        let h = 0.02;
        let (a, b) = ((t - h).max(0.0), (t + h).min(self.seconds));
        (self.path.at(b) - self.path.at(a)).with_y(0.0) / (b - a).max(1e-4)
    }

    fn turning(&self, t: f32) -> f32 {
        let h = 0.1;
        let (a, b) = ((t - h).max(0.0), (t + h).min(self.seconds));
        (self.turn.at(b).x - self.turn.at(a).x) / (b - a).max(1e-4)
    }

    /// 1 in a still end, 0 in the middle of the walk.
    fn rest(&self, t: f32) -> f32 {
        let [from, to] = self.shares(t);
        from.max(to)
    }

    /// How much of each still end's pose there is.
    fn shares(&self, t: f32) -> [f32; 2] {
        let over = BLEND_S.min(0.5 * self.seconds);
        let over = if self.steps < 2 { self.seconds } else { over };
        let still = |end: usize| f32::from(u8::from(matches!(self.ends[end], End::Still(_))));
        if self.steps < 2 {
            let x = ease(t, 0.0, self.seconds);
            return [(1.0 - x) * still(0), x * still(1)];
        }
        let from = (1.0 - ease(t, 0.0, over)) * still(0);
        let to = ease(t, self.seconds - over, self.seconds) * still(1);
        [from, to]
    }

    /// The pose at a time, before anything gives way, and its feet.
    fn stick(&self, t: f32) -> (Stick, [FootMoment; 2]) {
        let (person, model) = (self.person, self.person.model);
        let phase = self.phase.at(t);
        let speed = self.velocity(t).length();
        let heading = self.turn.at(t).x;
        let lively = ease(speed, 0.0, LIVELY_M_PER_S);
        let pace = model.measured(Pace::new(speed, person.leg_m, self.turning(t) * lively));
        let feet = [0, 1].map(|foot| self.feet[foot].at(model, t));
        let mut stick = self.gait_pose(t, phase, pace, lively);
        stick.feet = feet.map(|foot| foot.pose);
        let floor = self.path.at(t);
        stick.pelvis = Vec3::new(floor.x, floor.y + self.height_m(t, phase, pace, lively), floor.z);
        stick.pelvis += self.sway(heading, phase, self.turn.at(t).y);
        (stick, feet)
    }

    fn sway(&self, heading: f32, phase: f32, half_m: f32) -> Vec3 {
        // To the right while the right foot stands: between its landing (0) and the other's (π).
        ahead(heading + FRAC_PI_2) * (-half_m * phase.sin())
    }

    fn height_m(&self, t: f32, phase: f32, pace: Pace, lively: f32) -> f32 {
        let person = self.person;
        let height = &person.model.height;
        let phase = phase + HEIGHT_LEADS;
        let swing = height.at(phase, pace, lively) - height.at(phase, pace, 0.0);
        let hips = person.leg_m * (WALKING_SHARE + swing);
        let walking = person.ankle_m() + hips + person.pelvis_above_hips_m();
        let standing = |end: usize| match self.ends[end] {
            End::Still(stick) => Some(stick.pelvis.y - self.floor_y(end)),
            End::Walking(_) => None,
        };
        let share = ease(t, 0.0, self.seconds);
        let rest = match (standing(0), standing(1)) {
            (Some(a), Some(b)) => a + (b - a) * share,
            (Some(a), None) => a,
            (None, Some(b)) => b,
            (None, None) => walking,
        };
        let rest_share = self.rest(t).max(1.0 - lively);
        walking + (rest - walking) * rest_share
    }

    fn floor_y(&self, end: usize) -> f32 {
        self.path.at(if end == 0 { 0.0 } else { self.seconds }).y
    }

    /// Trunk, head and arms: the gait model's, led over from and into the poses of still ends.
    fn gait_pose(&self, t: f32, phase: f32, pace: Pace, lively: f32) -> Stick {
        let model = self.person.model;
        let heading = self.turn.at(t).x;
        let away = self.away_from_walking_ends(t);
        let liveliness = lively * (1.0 + (self.style.liveliness - 1.0) * away);
        let turn = |joint: usize| {
            model.joint(joint).map_or(Quat::IDENTITY, |series| series.at(phase, pace, liveliness))
        };
        let mut stick = Stick {
            pelvis: Vec3::ZERO,
            rotation: turn(j::PELVIS),
            turns: std::array::from_fn(|i| turn(i + 1)),
            feet: [self.feet[0].contacts[0].place, self.feet[1].contacts[0].place],
            poles: [Vec3::Z; 2],
            twists: [[Quat::IDENTITY; 2]; 2],
            hands: [0.0; crate::scene::HANDS],
        };
        stick.poles = [1.0, -1.0].map(|out| Vec3::new(0.08 * out, 0.0, 1.0).normalize_or(Vec3::Z));
        let shares = self.shares(t);
        for (end, share) in self.ends.iter().zip(shares) {
            if let End::Still(pose) = end {
                let mut pose = (**pose).clone();
                pose.rotation = tilt(pose.rotation);
                stick = stick.lerp(&pose, share);
            }
        }
        stick.rotation = (yaw(heading) * stick.rotation).normalize();
        self.look_ahead(&mut stick, t);
        stick
    }

    /// 0 at a walking end, 1 a step away from it.
    fn away_from_walking_ends(&self, t: f32) -> f32 {
        let from = if matches!(self.ends[0], End::Walking(_)) { ease(t, 0.0, 0.6) } else { 1.0 };
        let to = if matches!(self.ends[1], End::Walking(_)) {
            1.0 - ease(t, self.seconds - 0.6, self.seconds)
        } else {
            1.0
        };
        from * to
    }

    /// Head, neck and chest turn to where the body will go.
    fn look_ahead(&self, stick: &mut Stick, t: f32) {
        let ahead_by = wrap(self.turn.at(t + GAZE_S).x - self.turn.at(t).x);
        let ahead_by = GAZE_RADIANS * (ahead_by / GAZE_RADIANS).tanh();
        let awake = self.away_from_walking_ends(t) * (1.0 - self.shares(t)[1]) * ease(t, 0.0, 0.4);
        for (joint, share) in [(j::SPINE3, 0.2), (j::NECK, 0.35), (j::HEAD, 0.35)] {
            let turn = &mut stick.turns[joint - 1];
            *turn = Quat::from_rotation_y(ahead_by * awake * share) * *turn;
        }
    }
}

/// The gait's phase: π for every landing, 0 where the right foot lands.
fn phase(person: &Person, ends: [&End; 2], steps: &Steps) -> Rising {
    let first = match (ends[0], steps.falls.first()) {
        (End::Still(_), Some(fall)) if fall.foot == 1 => PI,
        _ => 0.0,
    };
    let mut keys = vec![(0.0, first)];
    for fall in &steps.falls {
        let last = keys[keys.len() - 1].1;
        keys.push((fall.land_s, last + PI));
    }
    let rate = |end: &End| match end {
        End::Still(_) => 0.0,
        End::Walking(state) => PI / Canonical::of(person, state).step_s,
    };
    let last = keys[keys.len() - 1];
    if last.0 < steps.seconds - 1e-3 {
        keys.push((steps.seconds, last.1));
    }
    Rising::new(&keys, ends.map(rate))
}

/// Where the pelvis is over the floor: between the feet whenever one lands.
fn path(person: &Person, ends: [&End; 2], steps: &Steps) -> Spline {
    let at = |end: &End, feet: &[FootPose; 2]| match end {
        End::Still(stick) => {
            let floor = feet[0].ankle.y.min(feet[1].ankle.y) - person.ankle_m();
            stick.pelvis.with_y(floor)
        }
        End::Walking(state) => state.at,
    };
    let mut feet = steps.start;
    let mut keys = vec![(0.0, at(ends[0], &feet))];
    let count = steps.falls.len();
    let mut last_feet = steps.start;
    steps.falls.iter().for_each(|fall| last_feet[fall.foot] = fall.place);
    let goal = at(ends[1], &last_feet);
    let still_end = matches!(ends[1], End::Still(_));
    for (k, fall) in steps.falls.iter().enumerate() {
        feet[fall.foot] = fall.place;
        let middle = feet[0].ankle.midpoint(feet[1].ankle) - Vec3::Y * person.ankle_m();
        if k + 1 < count {
            keys.push((fall.land_s, middle + ahead(fall.heading) * (person.lead_m() * fall.roll)));
        } else if still_end {
            // The body arrives a little after its last foot.
            let before = keys[keys.len() - 1].1;
            keys.push((fall.land_s, goal + (before - goal) * 0.16));
        }
    }
    keys.push((steps.seconds, goal));
    let velocity = |end: &End| ahead(end.heading()) * end.speed();
    Spline::new(&keys, ends.map(velocity))
}

/// Heading (x) and half width of the sway (y).
fn turn(person: &Person, ends: [&End; 2], steps: &Steps) -> Spline {
    let sway = |end: &End| match end {
        End::Still(_) => 0.0,
        End::Walking(state) => sway_m(person, Canonical::of(person, state).pace, 0.0),
    };
    let mut feet = steps.start;
    let mut heading = ends[0].heading();
    let mut keys = vec![(0.0, Vec3::new(heading, sway(ends[0]), 0.0))];
    let count = steps.falls.len();
    for (k, fall) in steps.falls.iter().enumerate() {
        feet[fall.foot] = fall.place;
        let last = k + 1 == count;
        // The pelvis is turned half way between its two feet's steps.
        let towards = if last { ends[1].heading() } else { fall.heading };
        let before = if k == 0 { ends[0].heading() } else { steps.falls[k - 1].heading };
        let half = before + 0.5 * wrap(fall.heading - before);
        let wanted = if last { towards } else { half };
        heading += wrap(wanted - heading);
        let apart = (feet[0].ankle - feet[1].ankle).with_y(0.0);
        let aside = apart.dot(ahead(heading + FRAC_PI_2)).abs();
        let half_m = if last { sway(ends[1]) } else { sway_m(person, fall.pace, aside) };
        keys.push((fall.land_s, Vec3::new(heading, half_m, 0.0)));
    }
    heading += wrap(ends[1].heading() - heading);
    if keys[keys.len() - 1].0 < steps.seconds - 1e-3 {
        keys.push((steps.seconds, Vec3::new(heading, sway(ends[1]), 0.0)));
    }
    Spline::new(&keys, [Vec3::ZERO; 2])
}

/// How far the pelvis goes to the side of the standing foot: as measured in walking, more the slower the steps, for
/// then the weight has to be over that foot.
fn sway_m(person: &Person, pace: Pace, aside_m: f32) -> f32 {
    let measured = person.model.sway.at(-FRAC_PI_2, pace, 1.0).abs() * person.leg_m;
    let slow = 1.0 - ease(pace.speed, 0.0, person.model.speeds[0] + 0.1);
    measured + slow * (0.3 * aside_m - measured).max(0.0)
}
