//! Where the feet come down between two ends, and when.

use glam::Vec3;

use super::feet::{Contact, FootTrack, Roll};
use super::figure::{FootPose, Person, ahead, wrap};
use super::model::Pace;
use super::style::Style;
use super::way::Way;
use crate::motion::leg::Walking;

/// How a walk begins or ends.
#[derive(Clone, Debug)]
pub(super) enum WalkEnd {
    /// On both feet, facing this way.
    Still { feet: [FootPose; 2], facing: f32 },
    /// In the middle of a walk, the right foot landing.
    Walking(Walking),
}

/// One landing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fall {
    /// 0 left, 1 right.
    pub(super) foot: usize,
    pub(super) place: FootPose,
    /// Which way the body faces with this step.
    pub(super) heading: f32,
    /// When the foot takes off and lands, seconds.
    pub(super) lift_s: f32,
    pub(super) land_s: f32,
    pub(super) pace: Pace,
    /// Share of the measured roll of the foot.
    pub(super) roll: f32,
}

/// A walk as footsteps.
#[derive(Clone, Debug)]
pub(super) struct Steps {
    /// The feet at its beginning, flat.
    pub(super) start: [FootPose; 2],
    pub(super) falls: Vec<Fall>,
    /// How long it takes.
    pub(super) seconds: f32,
}

/// The most that a step of the foot on the side of a turn turns it, radians, setting off, and arriving or on the spot:
/// hips turn outwards by some 75 degrees at most.
const TURN_SETTING_OFF: f32 = 0.95;
const TURN_ON_THE_SPOT: f32 = 1.31;
/// The other foot follows by less, or the toes would meet.
const FOLLOWING_SHARE: f32 = 0.45;
/// A turn of less than this is made by any foot, radians.
const SMALL_TURN: f32 = 0.4;
/// Way below which feet are set without walking, metres.
const ON_THE_SPOT_M: f32 = 0.2;
/// A foot this near to its place stays, metres and radians.
const IN_PLACE_M: f32 = 0.012;
const IN_PLACE_RADIANS: f32 = 0.06;
/// The weight is shifted for this long before the first foot takes off, seconds (anticipatory adjustments take 0.3 to
/// 0.5 s).
const SHIFT_S: f32 = 0.32;
/// After the last foot has landed the body comes to rest within this time, seconds.
const SETTLE_S: f32 = 0.45;
/// One small step of turning or placing, seconds: people turn half round within 1.2 to 2 s in three or four steps.
const SMALL_STEP_S: f32 = 0.44;
/// First and last step of a walk as shares of the steps between.
const FIRST_SHARE: f32 = 0.78;
const LAST_SHARE: f32 = 0.86;
/// Steps longer than this times the natural length are leaps.
const LONGEST_STEP: f32 = 1.2;
/// Share of a step's time for which the foot may be in the air.
const LONGEST_SWING: f32 = 0.86;

/// The feet of a walk at its canonical moment: left planted flat, right where it lands.
pub(super) fn walking_feet(person: &Person, state: &Walking) -> [FootPose; 2] {
    let pace = Pace::new(state.speed_m_per_s, person.leg_m, 0.0);
    let half = 0.5 * person.model.step_length_share(pace) * person.leg_m;
    let middle = state.at - ahead(state.heading) * person.lead_m();
    [(0, -half), (1, half)].map(|(foot, along)| {
        foot_at(person, foot, middle + ahead(state.heading) * along, state.heading, pace)
    })
}

/// A flat foot beside a point of the way.
fn foot_at(person: &Person, foot: usize, on_way: Vec3, heading: f32, pace: Pace) -> FootPose {
    let out = if foot == 0 { 1.0 } else { -1.0 };
    let width = person.model.step_width_share(pace).max(LEAST_WIDTH) * person.leg_m;
    let left = ahead(heading + std::f32::consts::FRAC_PI_2);
    let toes = heading + out * TOE_OUT;
    FootPose::flat(&person.feet[foot], on_way + left * (0.5 * width * out), toes)
}

/// Toes outwards in walking, radians: 6.7 degrees (Murray, Drought and Kory 1964); captured skeletons do not agree on
/// where toes point at rest.
const TOE_OUT: f32 = 0.117;
/// Ankles apart over the leg's length; narrower feet would touch.
const LEAST_WIDTH: f32 = 0.13;

/// Plans the landings from one end to the other along the way.
pub(super) fn plan(person: &Person, ends: [&WalkEnd; 2], way: &Way, style: &Style) -> Steps {
    let planner = Planner::new(person, ends, way, style);
    let falls = planner.falls();
    planner.timed(falls)
}

struct Planner<'a> {
    person: &'a Person,
    ends: [&'a WalkEnd; 2],
    way: &'a Way,
    style: &'a Style,
    start: [FootPose; 2],
    goal: [FootPose; 2],
    facing: [f32; 2],
    on_the_spot: bool,
    /// Share of the time that coming to rest takes: less where something follows.
    rest_after: f32,
}

/// Where a step leads: along the way, and facing where.
#[derive(Clone, Copy, Debug)]
struct Station {
    along_m: f32,
    heading: f32,
}

impl<'a> Planner<'a> {
    fn new(person: &'a Person, ends: [&'a WalkEnd; 2], way: &'a Way, style: &'a Style) -> Self {
        let feet = |end: &WalkEnd| match end {
            WalkEnd::Still { feet, .. } => *feet,
            WalkEnd::Walking(state) => walking_feet(person, state),
        };
        let facing = |end: &WalkEnd| match end {
            WalkEnd::Still { facing, .. } => *facing,
            WalkEnd::Walking(state) => state.heading,
        };
        let still = ends.iter().all(|end| matches!(end, WalkEnd::Still { .. }));
        Self {
            person,
            ends,
            way,
            style,
            start: feet(ends[0]),
            goal: feet(ends[1]),
            facing: ends.map(facing),
            on_the_spot: still && way.length() < ON_THE_SPOT_M,
            rest_after: if style.goes_on { 0.5 } else { 1.0 },
        }
    }

    fn walks(&self, end: usize) -> bool {
        matches!(self.ends[end], WalkEnd::Walking(_))
    }

    /// Natural speed, metres per second: the planner's, less on short ways between two rests.
    fn speed(&self) -> f32 {
        let hinted = self.way.mean_speed() * self.style.tempo;
        let rests = (0..2).filter(|end| !self.walks(*end)).count() as f32;
        let short = ((self.way.length() + 0.2) / (1.1 * rests).max(0.1)).sqrt().clamp(0.5, 1.0);
        hinted * short
    }

    fn falls(&self) -> Vec<(usize, FootPose, Station)> {
        if self.on_the_spot {
            return self.falls_on_the_spot();
        }
        let turn_in = if self.walks(0) { 0.0 } else { wrap(self.way.heading(0.0) - self.facing[0]) };
        let turn_out =
            if self.walks(1) { 0.0 } else { wrap(self.facing[1] - self.way.heading(self.way.length())) };
        let (turns_in, turns_out) = (turns(turn_in, TURN_SETTING_OFF), turns(turn_out, TURN_ON_THE_SPOT));
        let (before, after) = (turns_in.len() - 1, turns_out.len() - 1);
        let increments = self.increments(before, [turn_in, turn_out]);
        let mut stations = Vec::new();
        stations.extend(
            turns_in[..before].iter().map(|turn| Station { along_m: 0.0, heading: self.facing[0] + turn }),
        );
        let mut along_m = self.along(0, 1);
        for (k, by) in increments.iter().enumerate() {
            along_m += by;
            if k + 1 < increments.len() {
                stations.push(Station { along_m, heading: self.way.heading(along_m) });
            }
        }
        let length = self.way.length();
        let arriving = self.way.heading(length);
        stations.extend(
            turns_out[..after].iter().map(|turn| Station { along_m: length, heading: arriving + turn }),
        );
        self.on_feet(&stations)
    }

    /// Where along the way a foot of an end stands: `which` 0 the one that landed before, 1 the one that landed last.
    fn along(&self, end: usize, which: usize) -> f32 {
        let at = if end == 0 { 0.0 } else { self.way.length() };
        let WalkEnd::Walking(state) = self.ends[end] else { return at };
        let pace = Pace::new(state.speed_m_per_s, self.person.leg_m, 0.0);
        let half = 0.5 * self.person.model.step_length_share(pace) * self.person.leg_m;
        at - self.person.lead_m() + if which == 0 { -half } else { half }
    }

    /// Lengths of the steps along the way, from the foot that landed last to the one that lands last but one.
    fn increments(&self, before: usize, turns: [f32; 2]) -> Vec<f32> {
        let speed = self.speed();
        let pace = Pace::new(speed, self.person.leg_m, 0.0);
        let natural = self.person.model.step_length_share(pace) * self.person.leg_m * self.style.stride;
        let to_go = (self.along(1, 0) - self.along(0, 1)).max(0.0);
        let lost = if self.walks(0) { 0.0 } else { 1.0 - FIRST_SHARE }
            + if self.walks(1) { 0.0 } else { 1.0 - LAST_SHARE };
        let wanted = to_go / natural + lost;
        let count = self.fitting_count(wanted, before, turns);
        let mut weights = vec![1.0; count];
        if !self.walks(0) {
            weights[0] *= FIRST_SHARE;
        }
        if !self.walks(1) {
            weights[count - 1] *= LAST_SHARE;
        }
        let total: f32 = weights.iter().sum();
        weights.iter().map(|w| to_go * w / total).collect()
    }

    /// The number of steps next to what is wanted that ends on the right foot: a walk's canonical end has it landing, and
    /// a turn at the end is begun by the foot on its side.
    fn fitting_count(&self, wanted: f32, before: usize, [turn_in, turn_out]: [f32; 2]) -> usize {
        let rounded = (wanted.round() as usize).max(1);
        // The landing (counted from 0) that a foot is asked for: the end's own last, or the first one of the turn.
        let asked = |count: usize| {
            if self.walks(1) {
                Some((before + count, 1))
            } else if turn_out.abs() > SMALL_TURN {
                Some((before + count - 1, usize::from(turn_out < 0.0)))
            } else {
                None
            }
        };
        let fits = |count: usize| match (self.first_foot(turn_in), asked(count)) {
            (Some(first), Some((landing, foot))) => (first + landing) % 2 == foot,
            _ => true,
        };
        let candidates = [rounded, rounded + 1, rounded.saturating_sub(1).max(1)];
        // By the step's length over the natural one: twice too long is as bad as half as long, and legs end before that.
        let off = |count: &usize| {
            let length = wanted.max(0.3) / *count as f32;
            length.ln().abs() + 4.0 * (length - LONGEST_STEP).max(0.0)
        };
        candidates
            .into_iter()
            .filter(|count| fits(*count))
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .unwrap_or(rounded)
    }

    /// The foot that takes the first step, where something says so.
    fn first_foot(&self, turn: f32) -> Option<usize> {
        if self.walks(0) {
            return Some(0);
        }
        if turn.abs() > SMALL_TURN {
            // The foot on the side of the turn opens it.
            return Some(usize::from(turn < 0.0));
        }
        let heading = ahead(self.way.heading(0.0));
        let lag = (self.start[1].ankle - self.start[0].ankle).dot(heading);
        // The foot that stands behind goes first.
        (lag.abs() > 0.07).then_some(usize::from(lag < 0.0))
    }

    fn on_feet(&self, stations: &[Station]) -> Vec<(usize, FootPose, Station)> {
        let turn_in = wrap(stations.first().map_or(self.facing[1], |s| s.heading) - self.facing[0]);
        let count = stations.len() + 2;
        let first = if self.walks(1) {
            // So that the last landing is the right foot's.
            usize::from(count % 2 == 1)
        } else {
            self.first_foot(turn_in).unwrap_or(self.style.first_foot)
        };
        let pace = Pace::new(self.speed(), self.person.leg_m, 0.0);
        let mut falls = Vec::with_capacity(count);
        for (k, station) in stations.iter().enumerate() {
            let foot = (first + k) % 2;
            let place = foot_at(self.person, foot, self.centre(station), station.heading, pace);
            falls.push((foot, place, *station));
        }
        for which in 0..2 {
            let foot = (first + stations.len() + which) % 2;
            let station = Station { along_m: self.along(1, which), heading: self.facing[1] };
            falls.push((foot, self.goal[foot], station));
        }
        falls
    }

    /// The middle between the feet at a station: on the way, led from where the feet stand at a still end to where
    /// they stand at the other.
    fn centre(&self, station: &Station) -> Vec3 {
        let off = |end: usize| {
            let feet = if end == 0 { &self.start } else { &self.goal };
            let on_way = self.way.at(if end == 0 { 0.0 } else { self.way.length() });
            let middle = feet[0].ankle.midpoint(feet[1].ankle) - Vec3::Y * self.person.ankle_m();
            if self.walks(end) { Vec3::ZERO } else { middle - on_way }
        };
        let length = self.way.length();
        let near = |distance: f32| (1.0 - distance / 0.5).clamp(0.0, 1.0);
        let near_start = near(station.along_m);
        let near_end = near(length - station.along_m);
        let both = (near_start + near_end).max(1.0);
        self.way.at(station.along_m) + (off(0) * near_start + off(1) * near_end) / both
    }

    /// Turning or shifting the feet with hardly any way.
    fn falls_on_the_spot(&self) -> Vec<(usize, FootPose, Station)> {
        let in_place = |foot: usize| {
            self.start[foot].ankle.distance(self.goal[foot].ankle) < IN_PLACE_M
                && self.start[foot].rotation.angle_between(self.goal[foot].rotation) < IN_PLACE_RADIANS
        };
        let turn = wrap(self.facing[1] - self.facing[0]);
        let moving: Vec<usize> = (0..2).filter(|foot| !in_place(*foot)).collect();
        let station = |heading: f32| Station { along_m: 0.0, heading };
        if moving.len() < 2 && turn.abs() < TURN_ON_THE_SPOT {
            let put = |foot: &usize| (*foot, self.goal[*foot], station(self.facing[1]));
            return moving.iter().map(put).collect();
        }
        let turned = turns(turn, TURN_ON_THE_SPOT);
        let count = turned.len();
        let stations: Vec<Station> =
            turned[..count - 1].iter().map(|turn| station(self.facing[0] + turn)).collect();
        let side = usize::from(if turn.abs() > 0.1 { turn < 0.0 } else { self.first_to_move() == 1 });
        let pace = Pace::default();
        let mut falls: Vec<_> = stations
            .iter()
            .enumerate()
            .map(|(k, station)| {
                let foot = (side + k) % 2;
                (
                    foot,
                    foot_at(self.person, foot, self.centre_between(k, count), station.heading, pace),
                    *station,
                )
            })
            .collect();
        for which in 0..2 {
            let foot = (side + stations.len() + which) % 2;
            falls.push((foot, self.goal[foot], station(self.facing[1])));
        }
        falls
    }

    /// The foot whose place lies farther on the side it is on, which has to make way for the other.
    fn first_to_move(&self) -> usize {
        let by = |foot: usize| self.goal[foot].ankle - self.start[foot].ankle;
        let apart = (self.start[0].ankle - self.start[1].ankle).with_y(0.0);
        if (by(0) + by(1)).dot(apart) > 0.0 { 0 } else { 1 }
    }

    fn centre_between(&self, k: usize, count: usize) -> Vec3 {
        let middle = |feet: &[FootPose; 2]| feet[0].ankle.midpoint(feet[1].ankle);
        let at = middle(&self.start).lerp(middle(&self.goal), (k + 1) as f32 / count as f32);
        at - Vec3::Y * self.person.ankle_m()
    }

    fn timed(&self, falls: Vec<(usize, FootPose, Station)>) -> Steps {
        let (person, model) = (self.person, self.person.model);
        let cruise = self.speed().max(0.2);
        let usual = model.step_seconds(Pace::new(cruise, person.leg_m, 0.0), person.leg_m);
        let mut feet = self.start;
        let mut timed = Vec::with_capacity(falls.len());
        let (mut now, count) = (0.0, falls.len());
        let mut before = [self.along(0, 0), self.along(0, 1)];
        for (k, (foot, place, station)) in falls.into_iter().enumerate() {
            let by = (place.ankle - feet[foot].ankle).dot(ahead(station.heading));
            let step_m = station.along_m - before[1];
            let body_m = if k == 0 && !self.walks(0) { step_m } else { 0.5 * (station.along_m - before[0]) };
            before = [before[1], station.along_m];
            let last = k + 1 == count;
            let step_s = if step_m < 0.15 && !(last && by > 0.3) {
                SMALL_STEP_S / self.style.tempo
            } else if last && !self.walks(1) {
                usual.clamp(0.5, 0.65)
            } else if let Some(speed) = self.speed_of_end([k == 0, last]) {
                body_m / speed
            } else {
                let speed = self.way.speed(station.along_m).min(cruise).max(0.2);
                (body_m / speed).clamp(0.86 * usual, 1.2 * usual)
            };
            let pace = model.measured(model.pace_of_step(0.5 * by.max(0.0), person.leg_m));
            let shift_s = if k == 0 && !self.walks(0) { SHIFT_S } else { 0.0 };
            let swing_s = (2.0 * (1.0 - model.duty(pace)) * step_s).min(LONGEST_SWING * step_s);
            now += shift_s + step_s;
            let roll = super::curve::ease(by, 0.1, 0.85);
            let heading = station.heading;
            timed.push(Fall { foot, place, heading, lift_s: now - swing_s, land_s: now, pace, roll });
            feet[foot] = place;
        }
        let settle_s = if self.walks(1) { 0.0 } else { SETTLE_S * self.rest_after };
        let mut steps = Steps { start: self.start, falls: timed, seconds: now + settle_s };
        self.keep_canonical(&mut steps);
        steps
    }

    /// The speed of the walk that the first or the last step belongs to.
    fn speed_of_end(&self, at: [bool; 2]) -> Option<f32> {
        (0..2).find_map(|end| match self.ends[end] {
            WalkEnd::Walking(state) if at[end] => Some(state.speed_m_per_s.max(0.2)),
            _ => None,
        })
    }

    /// The first and last steps of a walk that goes on before and after are the walk's own.
    fn keep_canonical(&self, steps: &mut Steps) {
        if let (WalkEnd::Walking(state), Some(first)) = (self.ends[0], steps.falls.first_mut()) {
            let canonical = Canonical::of(self.person, state);
            first.lift_s = canonical.double_support_s.min(first.land_s - 0.15);
        }
        if let (WalkEnd::Walking(state), Some(last)) = (self.ends[1], steps.falls.last_mut()) {
            last.pace = Canonical::of(self.person, state).pace;
            last.roll = 1.0;
        }
    }
}

/// How far a turn has gone with each of the landings that make it, the last one all of it: the foot on its side takes
/// large steps, the other follows by smaller ones.
fn turns(turn: f32, most: f32) -> Vec<f32> {
    let share = |k: usize| if k.is_multiple_of(2) { 1.0 } else { FOLLOWING_SHARE };
    let mut total = 1.0;
    let mut count = 1;
    while turn.abs() > most * total {
        total += share(count);
        count += 1;
    }
    let mut gone = 0.0;
    (0..count)
        .map(|k| {
            gone += share(k);
            turn * gone / total
        })
        .collect()
}

/// Times of a steady walk.
pub(super) struct Canonical {
    pub(super) pace: Pace,
    pub(super) step_s: f32,
    pub(super) double_support_s: f32,
    pub(super) stance_s: f32,
}

impl Canonical {
    pub(super) fn of(person: &Person, state: &Walking) -> Self {
        let pace = Pace::new(state.speed_m_per_s, person.leg_m, 0.0);
        let step_s = person.model.step_seconds(pace, person.leg_m);
        let duty = person.model.duty(pace);
        let pace = person.model.measured(pace);
        Self { pace, step_s, double_support_s: (2.0 * duty - 1.0) * step_s, stance_s: 2.0 * duty * step_s }
    }

    fn roll(&self) -> Roll {
        Roll { pace: self.pace, share: 1.0, stance_s: self.stance_s }
    }
}

/// Time that stands for ever.
const ALWAYS_S: f32 = 1e6;

impl Steps {
    /// Stretches the times so that all takes `seconds`.
    pub(super) fn stretched(mut self, seconds: f32) -> Self {
        let by = seconds / self.seconds.max(1e-3);
        for fall in &mut self.falls {
            fall.lift_s *= by;
            fall.land_s *= by;
        }
        self.seconds = seconds;
        self
    }

    /// Both feet over time.
    pub(super) fn tracks(&self, person: &Person, ends: [&WalkEnd; 2]) -> [FootTrack; 2] {
        let contacts = [0, 1].map(|foot| self.contacts(person, ends, foot));
        let [left, right] = contacts;
        [FootTrack::new(person.feet[0], left.clone(), &right), FootTrack::new(person.feet[1], right, &left)]
    }

    fn contacts(&self, person: &Person, ends: [&WalkEnd; 2], foot: usize) -> Vec<Contact> {
        let mut contacts = vec![first_contact(person, ends[0], foot, self.start[foot])];
        for fall in self.falls.iter().filter(|fall| fall.foot == foot) {
            let swing_s = fall.land_s - fall.lift_s;
            let duty = person.model.duty(fall.pace);
            let stance_s = swing_s * duty / (1.0 - duty);
            let before = contacts.len() - 1;
            let leaves_walk = before == 0 && foot == 0 && matches!(ends[0], WalkEnd::Walking(_));
            contacts[before].to_s = fall.lift_s;
            if !leaves_walk {
                let share = 0.2 + 0.8 * fall.roll;
                contacts[before].leaving = Some(Roll { pace: fall.pace, share, stance_s });
            }
            contacts.push(Contact {
                place: fall.place,
                from_s: fall.land_s,
                to_s: ALWAYS_S,
                landing: Some(Roll { pace: fall.pace, share: fall.roll, stance_s }),
                leaving: None,
            });
        }
        if let (WalkEnd::Walking(state), 0) = (ends[1], foot) {
            let canonical = Canonical::of(person, state);
            let last = contacts.len() - 1;
            contacts[last].to_s = self.seconds + canonical.double_support_s;
            contacts[last].leaving = Some(canonical.roll());
        }
        if let (WalkEnd::Walking(state), 1) = (ends[1], foot) {
            let last = contacts.len() - 1;
            contacts[last].landing = Some(Canonical::of(person, state).roll());
        }
        contacts
    }
}

fn first_contact(person: &Person, end: &WalkEnd, foot: usize, place: FootPose) -> Contact {
    let always = Contact { place, from_s: -ALWAYS_S, to_s: ALWAYS_S, landing: None, leaving: None };
    let WalkEnd::Walking(state) = end else { return always };
    let canonical = Canonical::of(person, state);
    if foot == 1 {
        return Contact { from_s: 0.0, landing: Some(canonical.roll()), ..always };
    }
    let from_s = -canonical.step_s;
    let to_s = canonical.double_support_s;
    Contact { from_s, to_s, landing: Some(canonical.roll()), leaving: Some(canonical.roll()), ..always }
}
