//! The representative pose (ADSE §4.1, eq. 1), and what else says how somebody is when the legs are hidden.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::pose::{Joints3, Pose3d, coco, middle_of_hips, middle_of_shoulders};
use super::rules::{ActionRule, Caption, PostureHint, Rules};
use super::whereabouts::KeyPlace;
use crate::assets::photos::Photo;
use crate::evolve::action::{KeyObject, KeyRelation, Posture};

/// What says how somebody is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum PostureEvidence {
    /// Somebody marked the person as sitting or lying.
    Verb,
    /// Eq. 1 on the angles of seen hips and knees.
    Angles,
    /// A caption's words.
    Caption,
    /// The key object: on a couch or bed people sit.
    Key,
    /// Nothing: how this type of action is mostly done.
    Assumed,
}

/// Angles of hips (torso to thigh) and knees of the representative poses, radians; straight is π.
fn angles_of(posture: Posture) -> [f32; 2] {
    use std::f32::consts::{FRAC_PI_2, PI};
    match posture {
        // Somebody standing relaxed is nearly, not quite, straight; so is a straight leg on a bed.
        Posture::Stand | Posture::LieDown | Posture::LieUp => [0.94 * PI, 0.94 * PI],
        Posture::Sit => [FRAC_PI_2 * 1.1, FRAC_PI_2],
        Posture::SitStraight => [FRAC_PI_2 * 1.1, 0.9 * PI],
    }
}

/// Torsos that lie by more than this from upright are lying, radians: the angles of hips and knees don't tell lying
/// from standing.
const LYING_FROM: f32 = 1.05;

/// Angles θ of eq. 1 with ω = 0 where a joint is not marked: left and right hip, left and right knee.
pub fn leg_angles(pose: &Pose3d) -> [Option<f32>; 4] {
    use coco::{
        LEFT_ANKLE, LEFT_HIP, LEFT_KNEE, LEFT_SHOULDER, RIGHT_ANKLE, RIGHT_HIP, RIGHT_KNEE, RIGHT_SHOULDER,
    };
    let joints = &pose.joints_px;
    let seen = |needed: &[usize]| needed.iter().all(|j| pose.marked[*j]);
    let angle = |at: Vec3, a: Vec3, b: Vec3| (a - at).angle_between(b - at);
    let torso = middle_of_shoulders(joints) - middle_of_hips(joints);
    let hip = |shoulder: usize, hip: usize, knee: usize| {
        seen(&[shoulder, hip, knee]).then(|| torso.angle_between(joints[knee] - joints[hip]))
    };
    let knee = |hip: usize, knee: usize, ankle: usize| {
        seen(&[hip, knee, ankle]).then(|| angle(joints[knee], joints[hip], joints[ankle]))
    };
    [
        hip(LEFT_SHOULDER, LEFT_HIP, LEFT_KNEE),
        hip(RIGHT_SHOULDER, RIGHT_HIP, RIGHT_KNEE),
        knee(LEFT_HIP, LEFT_KNEE, LEFT_ANKLE),
        knee(RIGHT_HIP, RIGHT_KNEE, RIGHT_ANKLE),
    ]
}

/// Eq. 1 over `among`: the representative pose nearest to the seen angles; `None` when none is seen.
pub fn nearest(angles: &[Option<f32>; 4], among: &[Posture]) -> Option<Posture> {
    if angles.iter().all(Option::is_none) {
        return None;
    }
    let distance = |posture: &Posture| -> f32 {
        let [hip, knee] = angles_of(*posture);
        angles.iter().zip([hip, hip, knee, knee]).map(|(a, b)| a.map_or(0.0, |a| (a - b).abs())).sum()
    };
    among.iter().copied().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// How somebody is, and what says so: a marked verb, the angles that are seen, a caption, the key object, or what is
/// usual.
pub fn posture(
    photo: &Photo,
    person: usize,
    captions: &[Caption],
    place: &KeyPlace,
    rule: &ActionRule,
    rules: &Rules,
    pose: &Pose3d,
) -> (Posture, PostureEvidence) {
    use PostureEvidence::{Angles, Assumed, Caption as Said, Key, Verb};
    let person = &photo.people[person];
    let angles = leg_angles(pose);
    let seated = || sitting(&angles, place);
    if rules.lie_verbs.iter().any(|v| person.does(v)) {
        return (lying(&pose.joints_px), Verb);
    }
    if rules.sit_verbs.iter().any(|v| person.does(v)) {
        return (seated(), Verb);
    }
    if is_lying(&pose.joints_px) && can_lie(place) {
        return (lying(&pose.joints_px), Angles);
    }
    // Two angles at least: one alone is often a thigh that points at the camera.
    if angles.iter().flatten().count() >= 2
        && let Some(nearest) = nearest(&angles, &[Posture::Stand, Posture::Sit, Posture::SitStraight])
    {
        let straight_seat = matches!(place.key, KeyObject::Bed | KeyObject::Couch);
        let nearest = if nearest == Posture::SitStraight && !straight_seat { Posture::Sit } else { nearest };
        return (nearest, Angles);
    }
    match said(captions, rules) {
        Some(PostureHint::Lie) if can_lie(place) => return (lying(&pose.joints_px), Said),
        Some(PostureHint::Sit) => return (seated(), Said),
        Some(PostureHint::Stand) if place.relation == KeyRelation::Around => return (Posture::Stand, Said),
        _ => {}
    }
    match place.relation {
        KeyRelation::On => (Posture::Sit, Key),
        KeyRelation::Around if place.key == KeyObject::KitchenIsland => (Posture::Stand, Assumed),
        KeyRelation::Around => (rule.posture, Assumed),
    }
}

/// What the captions agree on: the first kind of word that one has, unless another has another.
fn said(captions: &[Caption], rules: &Rules) -> Option<PostureHint> {
    let has = |words: &[String]| captions.iter().any(|c| words.iter().any(|w| c.has(w)));
    let mut hints = rules.posture_words.iter().filter(|(_, words)| has(words)).map(|(hint, _)| *hint);
    let first = hints.next();
    if hints.next().is_some() { None } else { first }
}

fn can_lie(place: &KeyPlace) -> bool {
    place.relation == KeyRelation::On
}

/// With straight legs on beds and couches, where the angles say so.
fn sitting(angles: &[Option<f32>; 4], place: &KeyPlace) -> Posture {
    match place.key {
        KeyObject::Bed | KeyObject::Couch if angles[2..].iter().any(Option::is_some) => {
            nearest(angles, &[Posture::Sit, Posture::SitStraight]).unwrap_or(Posture::Sit)
        }
        _ => Posture::Sit,
    }
}

fn is_lying(joints: &Joints3) -> bool {
    let torso = middle_of_shoulders(joints) - middle_of_hips(joints);
    torso.angle_between(Vec3::Y) > LYING_FROM
}

/// Face up or down: where the chest points, from a camera that looks down a little.
fn lying(joints: &Joints3) -> Posture {
    let torso = middle_of_shoulders(joints) - middle_of_hips(joints);
    let front = torso.cross(joints[coco::RIGHT_SHOULDER] - joints[coco::LEFT_SHOULDER]);
    let up = Vec3::new(0.0, 0.94, 0.34);
    if front.dot(up) >= 0.0 { Posture::LieUp } else { Posture::LieDown }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{FRAC_PI_2, PI};

    #[test]
    fn the_nearest_pose_goes_by_the_seen_angles_alone() {
        let all = [Posture::Stand, Posture::Sit, Posture::SitStraight];
        assert_eq!(nearest(&[Some(PI), Some(PI), None, None], &all), Some(Posture::Stand));
        assert_eq!(nearest(&[Some(1.6), None, Some(FRAC_PI_2), None], &all), Some(Posture::Sit));
        assert_eq!(nearest(&[Some(1.6), None, Some(PI), None], &all), Some(Posture::SitStraight));
        assert_eq!(nearest(&[None; 4], &all), None);
    }

    #[test]
    fn captions_that_disagree_say_nothing() {
        let rules = Rules::bundled();
        let hint = |texts: &[&str]| said(&texts.iter().map(|t| Caption::of(t)).collect::<Vec<_>>(), rules);
        assert_eq!(hint(&["A man sitting.", "A man at a table."]), Some(PostureHint::Sit));
        assert_eq!(hint(&["A man sitting.", "A man stands."]), None);
        assert_eq!(hint(&["A man."]), None);
    }
}
