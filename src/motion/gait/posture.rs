//! Sitting down and lying down between known bodies; getting up is the same backwards in time.
//!
//! The trunk leans over the feet while the pelvis goes back before it goes down, so that it comes over the seat's edge
//! from above; feet stand until no weight is on them. Timings after Kralj, Jaeger and Munih 1990 (getting up 1.5 to 2 s).

use glam::{Quat, Vec3};

use super::curve::{bump, ease, smooth_cover};
use super::feet::{Contact, FootTrack};
use super::figure::{FootPose, Person, Stick, ahead, facing, yaw};
use super::stance;
use super::style::Style;
use crate::body::joints as j;
use crate::job::Seed;
use crate::motion::leg::LegMotion;
use crate::scene::CLIP_FPS;

/// Sitting down and getting up, seconds.
const SIT_S: f32 = 1.9;
/// Drawing the feet to where they rest afterwards.
const SETTLE_S: f32 = 0.7;
/// Lying down from an edge, seconds.
const LIE_S: f32 = 3.0;
/// Lean of the trunk at the moment of contact with the seat, radians: 35 to 40 degrees.
const LEAN: f32 = 0.66;
/// Shares of the lean in the pelvis and each of the spine's joints.
const PELVIS_LEAN: f32 = 0.58;
const SPINE_LEAN: f32 = 0.14;
/// A foot this near to its place needs no step, metres and radians: it shifts by that without anybody seeing it.
const STAYS_M: f32 = 0.008;
const STAYS_RADIANS: f32 = 0.1;
/// A foot is on the floor when the lowest point of its sole is at most this far off and it is at most this much tilted.
const ON_FLOOR_M: f32 = 0.015;
const ON_FLOOR_RADIANS: f32 = 0.3;
/// Legs straighten to this share while the body goes up and down.
const STRAIGHT_SHARE: f32 = 0.995;
/// Frames over which the pelvis gives way to a leg that would be too short.
const LOWER_FRAMES: usize = 5;
/// Pelvis of somebody who sits on an edge, ahead of that the feet stand, metres.
const SEAT_DEPTH_M: f32 = 0.42;

/// Whether a foot stands on the floor at a height.
pub(super) fn on_floor(person: &Person, foot: &FootPose, floor_y: f32) -> bool {
    (person.feet[0].lowest_y(foot) - floor_y).abs() < ON_FLOOR_M && foot.tilt() < ON_FLOOR_RADIANS
}

/// The feet of somebody who stands before where they sit: those they sit with where these stand on the floor.
pub(super) fn feet_before(person: &Person, sits: &Stick, floor_y: f32) -> [FootPose; 2] {
    let facing = facing(sits.rotation);
    let below = sits.pelvis.with_y(floor_y);
    let usable = |foot: &FootPose| {
        let ahead_m = (foot.ankle - sits.pelvis).dot(ahead(facing));
        on_floor(person, foot, floor_y) && (0.2..0.7).contains(&ahead_m)
    };
    let natural = stance::places(person, below + ahead(facing) * SEAT_DEPTH_M, facing);
    let flat = |i: usize| {
        let foot = &sits.feet[i];
        FootPose::flat(&person.feet[i], foot.ankle.with_y(floor_y), foot.heading())
    };
    if sits.feet.iter().all(usable) { [flat(0), flat(1)] } else { stance::feet_at(person, &natural) }
}

/// Somebody standing before where they sit.
pub(super) fn stand_before(person: &Person, sits: &Stick, floor_y: f32, seed: Seed) -> Stick {
    let mut stands = stance::stand(person, feet_before(person, sits, floor_y), seed);
    // Somebody who sits down faces as they will sit, however the toes point.
    stands.rotation = yaw(facing(sits.rotation));
    stands
}

/// Somebody sitting on the edge of what they will lie on, with the feet as they stand.
pub(super) fn sit_on_edge(lies: &Stick, stands: &Stick) -> Stick {
    let facing = facing(stands.rotation);
    let feet = stands.feet[0].ankle.midpoint(stands.feet[1].ankle);
    let mut sits = stands.clone();
    let over = feet - ahead(facing) * SEAT_DEPTH_M;
    sits.pelvis = Vec3::new(over.x, lies.pelvis.y, over.z);
    sits.rotation = (yaw(facing) * Quat::from_rotation_x(-0.1)).normalize();
    lean_spine(&mut sits, 0.25);
    sits
}

/// Somebody standing with the back to what they will lie on, at about `at`.
pub(super) fn stand_beside(person: &Person, lies: &Stick, at: Vec3, seed: Seed) -> Stick {
    let head = (lies.rotation * Vec3::Y).with_y(0.0).normalize_or(Vec3::X);
    let away = (at - lies.pelvis).with_y(0.0);
    let across = (away - head * away.dot(head)).try_normalize().unwrap_or(ahead(facing(lies.rotation)));
    let heading = crate::scene::facing_of(glam::Vec2::new(across.x, across.z));
    let places = stance::places(person, at, heading);
    stance::stand(person, stance::feet_at(person, &places), seed)
}

/// Sits down.
pub(super) fn sit_down(person: &Person, from: &Stick, to: &Stick, floor_y: f32, style: &Style) -> LegMotion {
    let stays = [0, 1].map(|i| stays(&from.feet[i], &to.feet[i]));
    let down_s = SIT_S / style.tempo;
    let seconds = down_s + if stays == [true; 2] { 0.0 } else { SETTLE_S };
    // Whose feet do not stay where they stood sits down near the edge first and moves back while the feet come after.
    let (feet_from, across_to) =
        if stays == [true; 2] { (0.8, 0.76) } else { (0.7, 0.95 * seconds / down_s) };
    let feet = settling_feet(person, from, to, stays, [down_s * feet_from, seconds]);
    let stick = |t: f32| {
        let x = t / down_s;
        let mut stick = from.lerp(to, ease(x, 0.1, seconds / down_s));
        let across = ease(x, 0.04, across_to);
        let down = ease(x, 0.12, 0.84);
        let level = from.pelvis.lerp(to.pelvis, across);
        stick.pelvis = level.with_y(from.pelvis.y + (to.pelvis.y - from.pelvis.y) * down);
        stick.rotation =
            from.rotation.slerp(super::figure::near(from.rotation, to.rotation), ease(x, 0.2, 0.95));
        let lean = LEAN * style.lean * bump(x, [0.02, 0.5, 0.58, 1.0]);
        lean_forward(&mut stick, lean);
        stick
    };
    let hands = if style.hands_to_knees { 1.0 } else { 0.0 };
    let on_knees = |t: f32| hands * bump(t / down_s, [0.2, 0.55, 0.65, 1.0]);
    frames(person, seconds, floor_y, &|t| {
        let mut stick = stick(t);
        let moments = feet.each_ref().map(|foot| foot.at(person.model, t));
        let shifted = ease(t, 0.0, seconds);
        stick.feet = std::array::from_fn(|i| {
            if stays[i] { from.feet[i].lerp(&to.feet[i], shifted) } else { moments[i].pose }
        });
        (stick, on_knees(t), moments.map(|moment| moment.planted))
    })
}

/// Lies down from sitting on the edge: leans to the head's side on an elbow while the legs come up.
pub(super) fn lie_down(person: &Person, from: &Stick, to: &Stick, floor_y: f32, style: &Style) -> LegMotion {
    let seconds = LIE_S / style.tempo;
    let head = (to.rotation * Vec3::Y).with_y(0.0).normalize_or(Vec3::X);
    let side = usize::from((from.rotation * Vec3::X).dot(head) < 0.0);
    let elbow = from.pelvis.with_y(to.pelvis.y) + head * 0.42 - Vec3::Y * 0.03;
    frames(person, seconds, floor_y, &|t| {
        let x = t / seconds;
        let mut stick = from.lerp(to, ease(x, 0.08, 0.92));
        // The arms come to rest last: one carries the trunk before that.
        let late = from.lerp(to, ease(x, 0.4, 0.96));
        for joint in j::LEFT_COLLAR..=j::RIGHT_WRIST {
            if joint != j::HEAD {
                stick.turns[joint - 1] = late.turns[joint - 1];
            }
        }
        let across = from.pelvis.lerp(to.pelvis, ease(x, 0.12, 0.9));
        stick.pelvis = across + Vec3::Y * (0.03 * bump(x, [0.1, 0.4, 0.5, 0.85]));
        stick.feet = swung_up(&from.feet, &to.feet, to.pelvis.y, x);
        let weight = bump(x, [0.08, 0.3, 0.42, 0.75]);
        let out = from.rotation * Vec3::NEG_Z + head * 0.3;
        stick.reach_with_arm(person, side, elbow, out, weight);
        (stick, 0.0, [x < LEGS_UP[0]; 2])
    })
}

/// Shares of the time of lying down between which the legs come up.
const LEGS_UP: [f32; 2] = [0.24, 0.9];

/// Both feet on their way from the floor up over the edge to where they lie: together, or the legs would spread.
fn swung_up(from: &[FootPose; 2], to: &[FootPose; 2], bed_y: f32, x: f32) -> [FootPose; 2] {
    let share = ease(x, LEGS_UP[0], LEGS_UP[1]);
    let [begin, end] = [from, to].map(|feet| feet[0].ankle.midpoint(feet[1].ankle));
    let over_y = (bed_y + 0.12).max(end.y + 0.08) - begin.y;
    // Up first, then across: a cubic whose ends leave and arrive straight up and down.
    let (up, down) = (begin + Vec3::Y * over_y, end + Vec3::Y * 0.12);
    let (s, r) = (share, 1.0 - share);
    let middle = begin * (r * r * r) + up * (3.0 * r * r * s) + down * (3.0 * r * s * s) + end * (s * s * s);
    std::array::from_fn(|i| {
        let mut foot = from[i].lerp(&to[i], share);
        foot.ankle = middle + (from[i].ankle - begin).lerp(to[i].ankle - end, share);
        foot
    })
}

/// From one pose on a seat or bed to another near it.
pub(super) fn shift(person: &Person, from: &Stick, to: &Stick, floor_y: f32, style: &Style) -> LegMotion {
    let seconds = SIT_S / style.tempo;
    let stays = [0, 1].map(|i| stays(&from.feet[i], &to.feet[i]));
    let feet = settling_feet(person, from, to, stays, [0.25 * seconds, 0.8 * seconds]);
    frames(person, seconds, floor_y, &|t| {
        let mut stick = from.lerp(to, ease(t, 0.0, seconds));
        stick.feet = feet.each_ref().map(|foot| foot.at(person.model, t).pose);
        (stick, 0.0, feet.each_ref().map(|foot| foot.at(person.model, t).planted))
    })
}

fn stays(from: &FootPose, to: &FootPose) -> bool {
    from.ankle.distance(to.ankle) < STAYS_M && from.rotation.angle_between(to.rotation) < STAYS_RADIANS
}

/// Feet that stand until `between[0]` and then, one after the other, go to their last places by `between[1]`.
fn settling_feet(
    person: &Person,
    from: &Stick,
    to: &Stick,
    stays: [bool; 2],
    between: [f32; 2],
) -> [FootTrack; 2] {
    let contacts = |i: usize| {
        let still = Contact { place: from.feet[i], from_s: -1e6, to_s: 1e6, landing: None, leaving: None };
        if stays[i] {
            return vec![still];
        }
        let span = between[1] - between[0];
        let late = if stays == [false; 2] { 0.35 * span * i as f32 } else { 0.0 };
        let (lift_s, land_s) = (between[0] + late, between[1] - 0.35 * span + late);
        vec![
            Contact { to_s: lift_s, ..still },
            Contact { place: to.feet[i], from_s: land_s.min(between[1]), ..still },
        ]
    };
    [0, 1].map(|i| FootTrack::new(person.feet[i], contacts(i), &[]))
}

/// Leans the whole trunk forward by an angle; the face stays up and the arms hang.
fn lean_forward(stick: &mut Stick, lean: f32) {
    let pitch = Quat::from_rotation_x;
    stick.rotation = (stick.rotation * pitch(lean * PELVIS_LEAN)).normalize();
    lean_spine(stick, lean * 3.0 * SPINE_LEAN);
    for joint in [j::NECK, j::HEAD] {
        stick.turns[joint - 1] = pitch(-0.3 * lean) * stick.turns[joint - 1];
    }
    for shoulder in [j::LEFT_SHOULDER, j::RIGHT_SHOULDER] {
        stick.turns[shoulder - 1] = pitch(-1.15 * lean) * stick.turns[shoulder - 1];
    }
}

fn lean_spine(stick: &mut Stick, lean: f32) {
    for joint in [j::SPINE1, j::SPINE2, j::SPINE3] {
        stick.turns[joint - 1] = Quat::from_rotation_x(lean / 3.0) * stick.turns[joint - 1];
    }
}

/// Above the knee's middle where a palm lies, metres.
const PALM_ABOVE_KNEE_M: f32 = 0.085;

/// Wrists over the knees.
fn hands_to_knees(person: &Person, stick: &mut Stick, weight: f32) {
    if weight <= 0.0 {
        return;
    }
    let knees = stick.knees(person);
    for side in 0..2 {
        let out = if side == 0 { 1.0 } else { -1.0 };
        let hip = stick.hip(person, side);
        let back = (hip - knees[side]).normalize_or(Vec3::NEG_Z);
        let target = knees[side] + back * 0.12 + Vec3::Y * PALM_ABOVE_KNEE_M;
        let pole = stick.rotation * Vec3::new(0.8 * out, 0.0, -0.6);
        stick.reach_with_arm(person, side, target, pole, weight);
    }
}

/// A moment: the pose, how much the hands are on the knees, and which feet are planted.
type Moment = (Stick, f32, [bool; 2]);

fn frames(person: &Person, seconds: f32, floor_y: f32, at: &dyn Fn(f32) -> Moment) -> LegMotion {
    let count = (seconds * CLIP_FPS).round().max(1.0) as usize;
    let mut moments: Vec<Moment> = (0..=count).map(|i| at(seconds * i as f32 / count as f32)).collect();
    let needed: Vec<f32> = moments
        .iter()
        .map(|(stick, _, planted)| {
            let over = stick.overreach_m(person, STRAIGHT_SHARE);
            (0..2).filter(|i| planted[*i]).map(|i| over[i]).fold(0.0, f32::max)
        })
        .collect();
    let mut lowered = smooth_cover(&needed, LOWER_FRAMES);
    let off = [lowered[0], lowered[count]];
    for (i, by) in lowered.iter_mut().enumerate() {
        let x = i as f32 / count as f32;
        *by -= off[0] * (1.0 - ease(x, 0.0, 0.15)) + off[1] * ease(x, 0.85, 1.0);
    }
    for ((stick, knees, _), by) in moments.iter_mut().zip(lowered) {
        stick.pelvis.y -= by;
        hands_to_knees(person, stick, *knees);
    }
    LegMotion {
        frames: moments.iter().map(|(stick, ..)| stick.frame(person)).collect(),
        planted: moments
            .iter()
            .map(|(stick, _, planted)| {
                std::array::from_fn(|i| planted[i] && on_floor(person, &stick.feet[i], floor_y))
            })
            .collect(),
    }
}
