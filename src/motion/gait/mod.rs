//! Walking, turning, sitting down, lying down and getting up, made from footsteps and a measured gait model.
//!
//! Pure and deterministic for a given seed; knows no room: the planner's way and the two end bodies are all it is
//! told. Planted feet stand still because legs follow from them by inverse kinematics.

mod curve;
mod feet;
mod figure;
mod idle;
mod model;
mod posture;
mod stance;
mod steps;
mod style;
mod walk;
mod way;

#[cfg(test)]
mod tests;

use glam::Vec3;

pub use model::{Curve, GaitModel, GaitModelError, HARMONICS, JointSeries, KNOTS, OfPace, Pace, Series};

use crate::body::Body;
use crate::job::{Cancelled, Seed, Ticker};
use crate::scene::{BETAS, Frame, GoalPose};

use super::leg::{EndState, FootPlace, LegInput, LegMotion, Still, Walking};
use figure::{Person, Stick};
use style::Style;
use walk::End;
use way::Way;

/// Pelvis of two poses this near, metres: one goes over into the other without standing up.
const SHIFT_M: f32 = 0.3;
/// Sitting and lying this near, metres: one lies down from where one sits.
const LIE_FROM_SEAT_M: f32 = 0.95;
/// Standing feet this near to the seat's, metres and radians, need no steps before sitting down; so much farther ahead
/// of it the pelvis still finds the seat.
const FEET_READY_M: f32 = 0.05;
const FEET_READY_RADIANS: f32 = 0.35;
const FEET_AHEAD_M: f32 = 0.14;
/// Pelvis of somebody who stands beside a seat to come in from the side, metres from the seated one's, and what is left
/// of the forward lean.
const BESIDE_M: [f32; 2] = [0.3, 0.75];
const LEAN_FROM_ASIDE: f32 = 0.35;

/// Makes the frames of one leg: walks along the way where there is one, turns, sits down, lies down and gets up. The
/// first and the last frame are exactly the end states' ([`walking_frame`] for a walk that goes on).
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn synthesise_leg(body: &Body, input: &LegInput, ticker: &Ticker) -> Result<LegMotion, Cancelled> {
    ticker.check()?;
    let maker = Maker {
        person: Person::new(body, &input.betas),
        style: Style::of(input.seed),
        input,
        way: Way::new(&input.path),
    };
    let mut motion = maker.motion();
    ticker.check()?;
    if let (Some(first), EndState::Still(still)) = (motion.frames.first_mut(), &input.from) {
        *first = still.frame.clone();
    }
    if let (Some(last), EndState::Still(still)) = (motion.frames.last_mut(), &input.to) {
        *last = still.frame.clone();
    }
    if let (Some(first), EndState::Walking(state)) = (motion.frames.first_mut(), &input.from) {
        *first = walk::walking_stick(&maker.person, state).frame(&maker.person);
    }
    if let (Some(last), EndState::Walking(state)) = (motion.frames.last_mut(), &input.to) {
        *last = walk::walking_stick(&maker.person, state).frame(&maker.person);
    }
    Ok(motion)
}

/// The body in the middle of a walk, its left foot planted and its right foot where it lands.
pub fn walking_frame(body: &Body, betas: &[f32; BETAS], state: &Walking) -> Frame {
    let person = Person::new(body, betas);
    walk::walking_stick(&person, state).frame(&person)
}

/// Somebody who stands relaxed on these feet, left then right; the seed varies arms and head a little.
pub fn standing_frame(body: &Body, betas: &[f32; BETAS], feet: &[FootPlace; 2], seed: Seed) -> Frame {
    let person = Person::new(body, betas);
    stance::stand(&person, stance::feet_at(&person, feet), seed).frame(&person)
}

/// Where the feet of somebody are, left then right, who stands at a point of the floor.
pub fn natural_feet(body: &Body, betas: &[f32; BETAS], at: Vec3, facing: f32) -> [FootPlace; 2] {
    stance::places(&Person::new(body, betas), at, facing)
}

/// Where the feet of somebody stand, left then right, who is about to sit down into a body or just got up from it: from
/// there no foot has to be moved.
pub fn feet_before(body: &Body, betas: &[f32; BETAS], sits: &Frame, floor_y: f32) -> [FootPlace; 2] {
    let person = Person::new(body, betas);
    let feet = posture::feet_before(&person, &Stick::of(&person, sits), floor_y);
    feet.map(|foot| FootPlace { at: foot.ankle.with_y(floor_y), heading: foot.heading() })
}

/// Length of a natural stride (two steps) of a body at a speed in metres per second: a walk between two canonical
/// moments takes a whole number of them.
pub fn stride_m(body: &Body, betas: &[f32; BETAS], speed_m_per_s: f32) -> f32 {
    let person = Person::new(body, betas);
    let pace = Pace::new(speed_m_per_s, person.leg_m, 0.0);
    2.0 * person.model.step_length_share(pace) * person.leg_m
}

/// Stays in a known body above a floor of this height for about `seconds`: breathes, shifts its weight, looks about. First and last frame are
/// exactly the body's; planted feet do not move.
pub fn idle(
    body: &Body,
    betas: &[f32; BETAS],
    still: &Still,
    floor_y: f32,
    seconds: f32,
    seed: Seed,
) -> LegMotion {
    idle::stay(&Person::new(body, betas), still, floor_y, seconds, seed)
}

/// A pose that somebody rests in.
struct Rest {
    stick: Stick,
    pose: GoalPose,
    floor_y: f32,
}

struct Maker<'a> {
    person: Person,
    style: Style,
    input: &'a LegInput,
    way: Way,
}

impl Maker<'_> {
    fn rest(&self, still: &Still, along_m: f32) -> Rest {
        let stick = Stick::of(&self.person, &still.frame);
        let floor_y = if self.input.path.is_empty() {
            stick.feet[0].ankle.y.min(stick.feet[1].ankle.y) - self.person.ankle_m()
        } else {
            self.way.at(along_m).y
        };
        Rest { stick, pose: still.pose, floor_y }
    }

    fn motion(&self) -> LegMotion {
        let (from, to) = (&self.input.from, &self.input.to);
        if let (EndState::Still(a), EndState::Still(b)) = (from, to) {
            let (a, b) = (self.rest(a, 0.0), self.rest(b, self.way.length()));
            if let Some(motion) = self.without_standing(&a, &b).or_else(|| self.on_ready_feet(&a, &b)) {
                return motion;
            }
        }
        let (rise, start) = match from {
            EndState::Walking(state) => (None, End::Walking(*state)),
            EndState::Still(still) => self.risen(&self.rest(still, 0.0)),
        };
        let (descend, goal) = match to {
            EndState::Walking(state) => (None, End::Walking(*state)),
            EndState::Still(still) => self.risen(&self.rest(still, self.way.length())),
        };
        let seconds = if rise.is_none() && descend.is_none() { self.input.seconds } else { None };
        let style = Style { goes_on: descend.is_some(), ..self.style };
        let walk = walk::walk(&self.person, [&start, &goal], &self.way, seconds, &style);
        let mut motion = rise.map(backwards).unwrap_or_default();
        append(&mut motion, walk);
        if let Some(down) = descend {
            append(&mut motion, down);
        }
        motion
    }

    /// Between two rests that are so near that nobody would get up for it.
    fn without_standing(&self, a: &Rest, b: &Rest) -> Option<LegMotion> {
        use GoalPose::{Lie, Sit};
        let apart = a.stick.pelvis.distance(b.stick.pelvis);
        match (a.pose, b.pose) {
            (Sit, Sit) | (Lie, Lie) if apart < SHIFT_M => {
                Some(posture::shift(&self.person, &a.stick, &b.stick, a.floor_y, &self.style))
            }
            (Sit, Lie) if apart < LIE_FROM_SEAT_M => {
                Some(posture::lie_down(&self.person, &a.stick, &b.stick, a.floor_y, &self.style))
            }
            (Lie, Sit) if apart < LIE_FROM_SEAT_M => {
                Some(backwards(posture::lie_down(&self.person, &b.stick, &a.stick, b.floor_y, &self.style)))
            }
            _ => None,
        }
    }

    /// Sitting down from, or getting up into, a stance whose feet are the seat's, or beside a seat that has no room in
    /// front: at a table one comes in from the side, upright.
    fn on_ready_feet(&self, a: &Rest, b: &Rest) -> Option<LegMotion> {
        let (stands, sits, down) = match (a.pose, b.pose) {
            (GoalPose::Stand, GoalPose::Sit) => (a, b, true),
            (GoalPose::Sit, GoalPose::Stand) => (b, a, false),
            _ => return None,
        };
        let before = posture::feet_before(&self.person, &sits.stick, sits.floor_y);
        let ahead = figure::ahead(figure::facing(sits.stick.rotation));
        let feet = || (0..2).map(|i| (&stands.stick.feet[i], &before[i]));
        let turned = feet()
            .any(|(have, need)| figure::wrap(have.heading() - need.heading()).abs() > FEET_READY_RADIANS);
        let ready = feet().all(|(have, need)| {
            let off = have.ankle - need.ankle;
            let farther_m = off.dot(ahead).clamp(0.0, FEET_AHEAD_M);
            (off - ahead * farther_m).length() < FEET_READY_M
        });
        let off = (stands.stick.pelvis - sits.stick.pelvis).with_y(0.0);
        let (forward_m, aside_m) = (off.dot(ahead), off.reject_from(ahead).length());
        let beside = (BESIDE_M[0]..BESIDE_M[1]).contains(&aside_m) && forward_m.abs() < aside_m;
        if turned || !(ready || beside) {
            return None;
        }
        let lean = self.style.lean * if ready { 1.0 } else { LEAN_FROM_ASIDE };
        let style = Style { lean, ..self.style };
        let motion = posture::sit_down(&self.person, &stands.stick, &sits.stick, sits.floor_y, &style);
        Some(if down { motion } else { backwards(motion) })
    }

    /// A rest as somebody stands before it, and how they go down into it from there.
    fn risen(&self, rest: &Rest) -> (Option<LegMotion>, End) {
        let (person, seed) = (&self.person, self.input.seed);
        match rest.pose {
            GoalPose::Sit => {
                let stands = posture::stand_before(person, &rest.stick, rest.floor_y, seed);
                let down = posture::sit_down(person, &stands, &rest.stick, rest.floor_y, &self.style);
                (Some(down), End::Still(Box::new(stands)))
            }
            GoalPose::Lie => {
                let end = if (self.way.at(0.0) - rest.stick.pelvis).length()
                    < (self.way.at(self.way.length()) - rest.stick.pelvis).length()
                {
                    self.way.at(0.0)
                } else {
                    self.way.at(self.way.length())
                };
                let stands = posture::stand_beside(person, &rest.stick, end, seed);
                let sits = posture::sit_on_edge(&rest.stick, &stands);
                let mut down = posture::sit_down(person, &stands, &sits, rest.floor_y, &self.style);
                append(&mut down, posture::lie_down(person, &sits, &rest.stick, rest.floor_y, &self.style));
                (Some(down), End::Still(Box::new(stands)))
            }
            _ => (None, End::Still(Box::new(rest.stick.clone()))),
        }
    }
}

/// The motion backwards in time.
fn backwards(mut motion: LegMotion) -> LegMotion {
    motion.frames.reverse();
    motion.planted.reverse();
    motion
}

/// Adds a motion whose first frame is the last one's.
fn append(motion: &mut LegMotion, next: LegMotion) {
    let skip = usize::from(!motion.frames.is_empty());
    motion.frames.extend(next.frames.into_iter().skip(skip));
    motion.planted.extend(next.planted.into_iter().skip(skip));
}
