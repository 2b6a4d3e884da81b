//! The key object: where somebody does an action, and whether on or around it (ADSE §4.1).

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::pose::{Pose3d, coco, middle_of_hips, middle_of_shoulders};
use super::rules::{ActionRule, Caption, Rules};
use crate::assets::photos::{Photo, PhotoThing, PixelBox};
use crate::evolve::action::{KeyObject, KeyRelation, Posture};

/// What says where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum KeyEvidence {
    /// A marked thing near the person.
    Thing,
    /// Somebody marked the person as sitting or lying on it.
    Verb,
    /// A caption's words.
    Caption,
    /// Nothing: where this type of action mostly happens.
    Assumed,
}

/// Where an action happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyPlace {
    /// Which key object.
    pub key: KeyObject,
    /// On or around.
    pub relation: KeyRelation,
    /// What says so.
    pub evidence: KeyEvidence,
    /// Where it is in the photo, where it is marked.
    pub bounds: Option<PixelBox>,
}

/// A key object farther from the person's box than this share of the box's height is not theirs.
const NEAR: f32 = 0.5;

/// The key object that something marked in the photo says; `None` when nothing does.
pub fn key_place(
    photo: &Photo,
    person: usize,
    captions: &[Caption],
    rule: &ActionRule,
    rules: &Rules,
    pose: &Pose3d,
) -> Option<KeyPlace> {
    if let Some(place) = by_verb(photo, person, rules) {
        return Some(place);
    }
    let body = &photo.people[person].bounds;
    let near = NEAR * (body.max.y - body.min.y);
    let keys = photo.things.iter().filter_map(|t| Some((t, rules.key_of_label(&t.category)?)));
    let nearest = keys.filter(|(thing, _)| thing.bounds.gap(body) <= near);
    let (thing, label) = nearest.max_by(|a, b| a.0.bounds.area().total_cmp(&b.0.bounds.area()))?;
    let relation = if is_on(thing, pose) { KeyRelation::On } else { KeyRelation::Around };
    // Nobody uses a table by being on it.
    let relation =
        if matches!(label, KeyObject::Bed | KeyObject::Couch) { relation } else { KeyRelation::Around };
    let key = if thing.category == "dining table" { table(captions, rule, rules).0 } else { label };
    Some(KeyPlace { key, relation, evidence: KeyEvidence::Thing, bounds: Some(thing.bounds) })
}

/// What somebody marked the person as sitting or lying on.
fn by_verb(photo: &Photo, person: usize, rules: &Rules) -> Option<KeyPlace> {
    photo.people[person].interactions.iter().find_map(|i| {
        let thing = photo.things.get(i.thing)?;
        let rule = rules.seat_verbs.iter().find(|(verb, on, _)| *verb == i.verb && *on == thing.category)?;
        Some(KeyPlace {
            key: rule.2,
            relation: KeyRelation::On,
            evidence: KeyEvidence::Verb,
            bounds: Some(thing.bounds),
        })
    })
}

/// The key object where none is marked: what a caption says, or where this type of action mostly happens.
pub fn assumed(captions: &[Caption], rule: &ActionRule, rules: &Rules) -> KeyPlace {
    for (word, key) in [("bed", KeyObject::Bed), ("couch", KeyObject::Couch), ("sofa", KeyObject::Couch)] {
        if captions.iter().any(|c| c.has(&format!("on_a_{word}")) || c.has(&format!("on_the_{word}"))) {
            let evidence = KeyEvidence::Caption;
            return KeyPlace { key, relation: KeyRelation::On, evidence, bounds: None };
        }
    }
    let (key, said) = table(captions, rule, rules);
    let relation = if key == KeyObject::Couch { KeyRelation::On } else { KeyRelation::Around };
    let evidence = if said { KeyEvidence::Caption } else { KeyEvidence::Assumed };
    KeyPlace { key, relation, evidence, bounds: None }
}

/// The place as the posture has it: nobody stands on furniture or lies at a table, and who sits at a couch or bed sits
/// on it, though the knees stand out of its box.
pub fn fitting(place: KeyPlace, posture: Posture) -> KeyPlace {
    let soft = matches!(place.key, KeyObject::Bed | KeyObject::Couch);
    match posture {
        Posture::Stand => KeyPlace { relation: KeyRelation::Around, ..place },
        Posture::LieDown | Posture::LieUp if !soft => KeyPlace {
            key: KeyObject::Bed,
            relation: KeyRelation::On,
            evidence: KeyEvidence::Assumed,
            bounds: None,
        },
        _ if soft => KeyPlace { relation: KeyRelation::On, ..place },
        _ => KeyPlace { relation: KeyRelation::Around, ..place },
    }
}

/// Which table, and whether a caption says so: COCO has one class for all.
fn table(captions: &[Caption], rule: &ActionRule, rules: &Rules) -> (KeyObject, bool) {
    let said =
        rules.table_words.iter().find(|(_, words)| captions.iter().any(|c| words.iter().any(|w| c.has(w))));
    said.map_or((rule.key, false), |(key, _)| (*key, true))
}

/// ADSE §4.1: on, when torso and thighs lie in the convex hull of the thing; hidden knees are passed over.
fn is_on(thing: &PhotoThing, pose: &Pose3d) -> bool {
    let joints = &pose.joints_px;
    let flat = |p: glam::Vec3| Vec2::new(p.x, -p.y);
    let mut points = vec![flat(middle_of_hips(joints)), flat(middle_of_shoulders(joints))];
    points.extend(
        [coco::LEFT_KNEE, coco::RIGHT_KNEE].into_iter().filter(|k| pose.marked[*k]).map(|k| flat(joints[k])),
    );
    let slack = SLACK * pose.torso_px();
    let hull = if thing.outline.is_empty() { corners(&thing.bounds) } else { convex_hull(&thing.outline) };
    points.iter().all(|p| is_inside(&hull, *p, slack))
}

/// Shoulders stand out over a couch's back by this share of the torso.
const SLACK: f32 = 0.35;

fn corners(bounds: &PixelBox) -> Vec<Vec2> {
    let (a, b) = (bounds.min, bounds.max);
    vec![a, Vec2::new(b.x, a.y), b, Vec2::new(a.x, b.y)]
}

/// The convex hull, in one sense of rotation (Andrew 1979).
fn convex_hull(points: &[Vec2]) -> Vec<Vec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut chain: Vec<Vec2> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(p - a) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut sorted.iter().copied());
    hull.extend(half(&mut sorted.iter().rev().copied()));
    hull
}

/// Whether a point is in a convex polygon, or outside by at most `slack`.
fn is_inside(hull: &[Vec2], point: Vec2, slack: f32) -> bool {
    (0..hull.len()).all(|i| {
        let (a, b) = (hull[i], hull[(i + 1) % hull.len()]);
        let edge = b - a;
        edge.perp_dot(point - a) >= -slack * edge.length()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolve::action::ActionKind;

    #[test]
    fn hulls_hold_what_is_inside_and_a_little_more() {
        let outline =
            [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 1.0), (0.0, 4.0)].map(|(x, y)| Vec2::new(x, y));
        let hull = convex_hull(&outline);
        assert_eq!(hull.len(), 4, "the notch is filled");
        assert!(is_inside(&hull, Vec2::new(2.0, 3.0), 0.0));
        assert!(!is_inside(&hull, Vec2::new(2.0, 4.5), 0.0) && is_inside(&hull, Vec2::new(2.0, 4.5), 1.0));
        let square = corners(&PixelBox { min: Vec2::ZERO, max: Vec2::splat(2.0) });
        assert!(is_inside(&square, Vec2::ONE, 0.0) && !is_inside(&square, Vec2::new(3.0, 1.0), 0.5));
    }

    #[test]
    fn places_fit_postures() {
        use KeyRelation::{Around, On};
        let at = |key, relation, posture| {
            let place = KeyPlace { key, relation, evidence: KeyEvidence::Thing, bounds: None };
            let fitted = fitting(place, posture);
            (fitted.key, fitted.relation)
        };
        assert_eq!(at(KeyObject::Couch, On, Posture::Stand), (KeyObject::Couch, Around));
        assert_eq!(at(KeyObject::Couch, Around, Posture::Sit), (KeyObject::Couch, On));
        assert_eq!(at(KeyObject::OfficeDesk, Around, Posture::LieUp), (KeyObject::Bed, On));
        assert_eq!(at(KeyObject::OfficeDesk, Around, Posture::Sit), (KeyObject::OfficeDesk, Around));
    }

    #[test]
    fn captions_say_which_table_and_whether_on_a_bed() {
        let rules = Rules::bundled();
        let rule = rules.action(ActionKind::UseLaptop).expect("a rule");
        let at = |text: &str| assumed(&[Caption::of(text)], rule, rules);
        assert_eq!(
            (at("a laptop on a bed").key, at("a laptop on a bed").relation),
            (KeyObject::Bed, KeyRelation::On)
        );
        assert_eq!(at("a laptop on the coffee table").key, KeyObject::CoffeeTable);
        assert_eq!(
            (at("a laptop").key, at("a laptop").evidence),
            (KeyObject::OfficeDesk, KeyEvidence::Assumed)
        );
    }
}
