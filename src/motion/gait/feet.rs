//! A foot over time: planted, rolling over ball and heel without sliding, and swinging to its next place.

use glam::{Quat, Vec3};

use super::curve::{bump, cruise, ease};
use super::figure::{FootPose, FootShape, ahead};
use super::model::{GaitModel, Pace};

/// How a foot comes to its place or leaves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Roll {
    /// Pace of the step.
    pub(super) pace: Pace,
    /// Share of the measured roll: 1 in a walk straight ahead, 0 for a foot put down flat.
    pub(super) share: f32,
    /// How long the stance would last in a steady walk of this pace, seconds.
    pub(super) stance_s: f32,
}

/// A place that a foot stands on, and when.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// The foot while it is flat.
    pub(super) place: FootPose,
    /// When it lands and takes off, seconds.
    pub(super) from_s: f32,
    pub(super) to_s: f32,
    /// How it lands; `None` for a foot that has always stood there.
    pub(super) landing: Option<Roll>,
    /// How it takes off; `None` for a foot that stays.
    pub(super) leaving: Option<Roll>,
}

/// A foot at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct FootMoment {
    pub(super) pose: FootPose,
    /// Whether it stands flat, so that its ankle does not move.
    pub(super) planted: bool,
    /// 1 on the floor, 0 in the air, in between just before landing.
    pub(super) on_floor: f32,
    /// How much its heel may come up for the leg to reach, 0 to 1: late in its stance and just after it.
    pub(super) heel_free: f32,
}

/// Share of a stance at whose beginning the foot may be toes up, and after which its heel may rise.
const FLAT: [f32; 2] = [0.3, 0.38];
/// Between these shares of a stance the heel becomes free to come up for the leg to reach: before the other foot lands.
const HEEL_FREE: [f32; 2] = [0.45, 0.72];
/// A sole that is level to this many radians counts as flat: the ankle moves by less than 4 mm.
const FLAT_RADIANS: f32 = 0.04;
/// Least clearance of the sole in the middle of a swing, metres: people clear the floor by one to two centimetres
/// (Winter 1992).
const CLEARANCE_M: f32 = 0.018;
/// A swinging foot goes round the standing one by at least this much between the ankles, metres.
const PASS_M: f32 = 0.13;

impl Contact {
    /// Pitch of the foot at a time within the contact, toes down positive.
    fn pitch(&self, model: &GaitModel, t: f32) -> f32 {
        let landed = self.landing.map_or(0.0, |roll| roll.landed(model, t - self.from_s));
        let leaves = self.leaving.map_or(0.0, |roll| roll.leaves(model, self.to_s - t));
        landed + leaves
    }

    fn pose(&self, shape: &FootShape, model: &GaitModel, t: f32) -> FootPose {
        rolled(&self.place, shape, self.pitch(model, t))
    }
}

impl Roll {
    /// Pitch so many seconds after landing: toes up, then flat.
    fn landed(&self, model: &GaitModel, seconds: f32) -> f32 {
        let share = seconds / self.stance_s;
        let fade = 1.0 - ease(share, 0.0, FLAT[0]);
        let pitch = model.stance_pitch.at(share.min(1.0), self.pace).min(0.0);
        let first = model.stance_pitch.at(0.0, self.pace).min(0.0);
        // The measured curve, brought to exactly flat: a planted sole does not rock.
        self.share * if fade > 0.0 { pitch.max(first) * fade.sqrt() } else { 0.0 }
    }

    /// How much the heel may come up so many seconds before the foot takes off.
    fn begun(&self, seconds: f32) -> f32 {
        ease(1.0 - seconds / self.stance_s, HEEL_FREE[0], HEEL_FREE[1])
    }

    /// Pitch so many seconds before taking off: flat, then heel up.
    fn leaves(&self, model: &GaitModel, seconds: f32) -> f32 {
        let share = 1.0 - seconds / self.stance_s;
        let grown = ease(share, FLAT[1], FLAT[1] + 0.3);
        self.share * grown * model.stance_pitch.at(share.max(0.0), self.pace).max(0.0)
    }
}

/// How far the toes of a foot may still bend upwards, radians.
pub(super) fn toes_room(foot: &FootPose) -> f32 {
    (TOES_BEND + foot.toes.to_scaled_axis().x).max(0.0)
}

/// A flat foot rolled by a pitch about its ball (heel up) or heel (toes up), which stay where they are. Toes stay on the
/// floor under a raised heel.
pub(super) fn rolled(place: &FootPose, shape: &FootShape, pitch: f32) -> FootPose {
    if pitch == 0.0 {
        return *place;
    }
    let contact = if pitch > 0.0 { shape.ball } else { shape.heel };
    let rotation = (place.rotation * Quat::from_rotation_x(pitch)).normalize();
    let ankle = place.point(contact) - rotation * contact;
    let more = pitch.max(0.0).min(toes_room(place));
    FootPose { ankle, rotation, toes: place.toes * Quat::from_rotation_x(-more) }
}

/// Toes bend upwards by at most this, radians (55 degrees).
const TOES_BEND: f32 = 0.96;

/// One foot's contacts in the order of time, and the swings between them.
#[derive(Clone, Debug)]
pub(super) struct FootTrack {
    pub(super) shape: FootShape,
    pub(super) contacts: Vec<Contact>,
    /// For each swing how far it goes aside in its middle, to pass the other foot.
    asides: Vec<Vec3>,
}

impl FootTrack {
    pub(super) fn new(shape: FootShape, contacts: Vec<Contact>, other: &[Contact]) -> Self {
        let asides = contacts.windows(2).map(|pair| aside(&pair[0], &pair[1], other)).collect();
        Self { shape, contacts, asides }
    }

    /// The foot at a time.
    pub(super) fn at(&self, model: &GaitModel, t: f32) -> FootMoment {
        let last = self.contacts.len() - 1;
        let i = self.contacts.partition_point(|c| c.from_s <= t).clamp(1, last + 1) - 1;
        let contact = &self.contacts[i];
        if t <= contact.to_s || i == last {
            let pitch = contact.pitch(model, t);
            let planted = pitch.abs() < FLAT_RADIANS;
            let heel_free = contact.leaving.map_or(0.0, |roll| roll.begun(contact.to_s - t));
            return FootMoment {
                pose: contact.pose(&self.shape, model, t),
                planted,
                on_floor: 1.0,
                heel_free,
            };
        }
        let next_s = self.contacts[i + 1].from_s;
        let x = (t - contact.to_s) / (next_s - contact.to_s).max(1e-3);
        let (on_floor, heel_free) = (ease(x, LANDS, 1.0), 1.0 - ease(x, 0.0, LEFT_BEHIND));
        FootMoment { pose: self.swing(model, i, t), planted: false, on_floor, heel_free }
    }

    fn swing(&self, model: &GaitModel, i: usize, t: f32) -> FootPose {
        let (a, b) = (&self.contacts[i], &self.contacts[i + 1]);
        let seconds = (b.from_s - a.to_s).max(1e-3);
        let x = (t - a.to_s) / seconds;
        let pitch = swing_pitch(a, b, model, x);
        let turned = ease(x, 0.0, 1.0);
        let level = a.place.rotation.slerp(super::figure::near(a.place.rotation, b.place.rotation), turned);
        let rotation = (level * Quat::from_rotation_x(pitch)).normalize();
        // From the ball, which leaves the floor last, to the heel, which meets it first.
        let first = self.shape.ball;
        let last = if landing_pitch(b, model) < 0.0 { self.shape.heel } else { self.shape.ball };
        let in_foot = first.lerp(last, turned);
        let way = cruise(x / SWING_ARRIVES, SWING_RAMP);
        let over = a.place.point(first).lerp(b.place.point(last), way);
        let mut pose = FootPose {
            ankle: over + self.asides[i] * bump(x, [0.0, 0.5, 0.5, 1.0]) - rotation * in_foot,
            rotation,
            toes: toes(a, b, model, x),
        };
        // What a foot stands on is under its lowest point, not under its heel: feet that hang from a high seat are tilted.
        let [from_y, to_y] = [&a.place, &b.place].map(|place| self.shape.lowest_y(place));
        pose.ankle.y += self.missing_clearance(&pose, from_y + (to_y - from_y) * way, x);
        pose
    }

    /// How much a swinging foot has to be raised for its sole to clear the floor.
    fn missing_clearance(&self, pose: &FootPose, floor_y: f32, x: f32) -> f32 {
        let wanted = CLEARANCE_M * bump(x, [0.0, 0.4, 0.6, 1.0]);
        let lowest = self.shape.lowest_y(pose) - floor_y;
        // A smooth maximum: no kink where the clearance begins to rule.
        let short = wanted - lowest;
        0.5 * (short + (short * short + 1e-4 * bump(x, [0.0, 0.2, 0.8, 1.0])).sqrt())
    }
}

/// Until this share of a swing the foot trails and its heel may be higher than measured.
const LEFT_BEHIND: f32 = 0.4;
/// From this share of a swing on the leg gets ready for the floor.
const LANDS: f32 = 0.78;
/// Share of a swing over which a foot speeds up, and slows down again.
const SWING_RAMP: f32 = 0.42;
/// After this share of a swing the foot is over its place: earlier, the pelvis would not yet be near enough, and the knee
/// would snap straight.
const SWING_ARRIVES: f32 = 1.0;

fn landing_pitch(contact: &Contact, model: &GaitModel) -> f32 {
    contact.landing.map_or(0.0, |roll| roll.landed(model, 0.0))
}

fn leaving_pitch(contact: &Contact, model: &GaitModel) -> f32 {
    contact.leaving.map_or(0.0, |roll| roll.leaves(model, 0.0))
}

/// The measured pitch of a swing, scaled to the step and led from the one contact's pitch to the other's.
fn swing_pitch(a: &Contact, b: &Contact, model: &GaitModel, x: f32) -> f32 {
    let (from, to) = (leaving_pitch(a, model), landing_pitch(b, model));
    let Some(roll) = a.leaving else { return from + (to - from) * ease(x, 0.0, 1.0) };
    let share = roll.share + (b.landing.map_or(0.0, |r| r.share) - roll.share) * ease(x, 0.0, 1.0);
    let measured = |x: f32| share * model.swing_pitch.at(x, roll.pace);
    let off = (from - measured(0.0)) * (1.0 - ease(x, 0.0, 0.5)) + (to - measured(1.0)) * ease(x, 0.5, 1.0);
    measured(x) + off
}

/// Toes unbend in the first third of a swing.
fn toes(a: &Contact, b: &Contact, model: &GaitModel, x: f32) -> Quat {
    let bent =
        Quat::from_rotation_x(-leaving_pitch(a, model).clamp(0.0, TOES_BEND) * (1.0 - ease(x, 0.0, 0.35)));
    a.place.toes.slerp(super::figure::near(a.place.toes, b.place.toes), ease(x, 0.0, 1.0)) * bent
}

/// How far a swing has to bow out to pass the standing foot.
fn aside(a: &Contact, b: &Contact, other: &[Contact]) -> Vec3 {
    let middle_s = 0.5 * (a.to_s + b.from_s);
    let Some(standing) = other.iter().find(|c| c.from_s <= middle_s && middle_s <= c.to_s) else {
        return Vec3::ZERO;
    };
    let (from, to) = (a.place.ankle.with_y(0.0), b.place.ankle.with_y(0.0));
    let at = standing.place.ankle.with_y(0.0);
    let way = to - from;
    let share = ((at - from).dot(way) / way.length_squared().max(1e-6)).clamp(0.0, 1.0);
    let nearest = from + way * share;
    let off = nearest - at;
    let short = PASS_M - off.length();
    if short <= 0.0 || way.length() < 0.05 {
        return Vec3::ZERO;
    }
    // Out of the way of the standing foot, on the side where the swinging foot comes from and goes to.
    let outward = (from.midpoint(to) - at).normalize_or(ahead(a.place.heading()).cross(Vec3::Y));
    off.try_normalize().filter(|_| off.length() > 0.03).unwrap_or(outward) * short
}
