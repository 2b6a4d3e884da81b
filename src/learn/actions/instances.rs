//! Action instances: who does what in which photo, found by captions and interactions and filtered (ADSE §4.1).

use glam::Vec2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::layout::{LayoutFrame, PhotoFrame, PolarUnits};
use super::pose::{Pose3d, PoseSolver, coco};
use super::posture::{self, PostureEvidence};
use super::rules::{ActionRule, Caption, Rules, Search};
use super::whereabouts::{self, KeyEvidence, KeyPlace};
use crate::assets::photos::{Photo, PhotoPerson, PixelBox};
use crate::evolve::action::{ActionKind, KeyObject, KeyRelation, Posture};
use crate::job::{Cancelled, Ticker};

/// Settings of [`find_instances`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstanceConfig {
    /// Which phrases.
    pub search: Search,
    /// Whether interactions are used beside captions.
    pub interactions: bool,
    /// Fewest marked joints of a person.
    pub joints_least: usize,
    /// Smallest share of the photo that a person's box takes.
    pub area_least: f32,
    /// Fewest different categories of things indoors, where everything is marked.
    pub categories_least: usize,
    /// Whether a table is taken for granted where only what people use is marked.
    pub key_assumed: bool,
    /// How the floor plan lies in photos.
    pub frame: LayoutFrame,
}

impl Default for InstanceConfig {
    fn default() -> Self {
        Self {
            search: Search::Wide,
            interactions: true,
            joints_least: 8,
            area_least: 0.02,
            categories_least: 2,
            key_assumed: true,
            frame: LayoutFrame::default(),
        }
    }
}

/// A thing beside somebody.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlacedThing {
    /// Category, as the type of action names it.
    pub object: String,
    /// From the middle of the torso.
    pub from_person: PolarUnits,
    /// Its middle in the photo, pixels.
    pub pixel: Vec2,
    /// Whether the person was marked as using it.
    pub used: bool,
}

/// One person who does an action in a photo.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// The photo's key.
    pub photo: String,
    /// What.
    pub kind: ActionKind,
    /// The person in space.
    pub pose: Pose3d,
    /// The floor plan around the person.
    pub frame: PhotoFrame,
    /// How, and how that is known.
    pub posture: Posture,
    /// What says so.
    pub posture_evidence: PostureEvidence,
    /// Where.
    pub key: KeyObject,
    /// On or around it.
    pub relation: KeyRelation,
    /// What says so.
    pub key_evidence: KeyEvidence,
    /// Where the middle of the key object is seen.
    pub key_seen: Option<PolarUnits>,
    /// Whether every thing of the photo was marked.
    pub complete: bool,
    /// Things that actions place: all of a complete photo, what is used of others.
    pub things: Vec<PlacedThing>,
}

/// A group at one table.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// The photo's key.
    pub photo: String,
    /// Its people, as instances of eating in group.
    pub people: Vec<Instance>,
    /// Distances between any two of them, torso lengths.
    pub people_apart: Vec<f64>,
    /// Things with their distance to everybody, torso lengths.
    pub things: Vec<(String, Vec<f64>)>,
    /// Whether every thing was marked.
    pub complete: bool,
}

/// What is left of the photos of one type after each filter.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Funnel {
    /// Photos whose captions say the action.
    pub said: usize,
    /// Photos where somebody was marked as doing it.
    pub done: usize,
    /// Photos found by either.
    pub found: usize,
    /// With boxes of things.
    pub with_things: usize,
    /// With somebody whose joints suffice: enough of them, a shoulder and a hip, large enough.
    pub with_pose: usize,
    /// With a fitting number of such people.
    pub with_people: usize,
    /// With a thing that the action needs.
    pub with_required: usize,
    /// With enough different things, where everything is marked.
    pub with_categories: usize,
    /// With a key object, marked or assumed.
    pub with_key: usize,
    /// People left in these photos.
    pub instances: usize,
    /// Of these, in photos where everything is marked.
    pub complete_instances: usize,
}

/// Everything that was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// Everybody, by type and photo.
    pub instances: Vec<Instance>,
    /// Groups.
    pub groups: Vec<Group>,
    /// For each type, in the order of [`ActionKind::ALL`].
    pub funnels: Vec<(ActionKind, Funnel)>,
    /// Photos with captions that were searched.
    pub photos_with_captions: usize,
    /// Photos with interactions.
    pub photos_with_interactions: usize,
}

/// Somebody in a photo who passed the filters.
struct Candidate<'a> {
    photo: &'a Photo,
    captions: &'a [Caption],
    kind: ActionKind,
    people: Vec<usize>,
}

/// Finds the instances of every type.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn find_instances(
    photos: &[Photo],
    rules: &Rules,
    config: &InstanceConfig,
    solver: &PoseSolver<'_>,
    ticker: &Ticker,
) -> Result<Found, Cancelled> {
    ticker.stage("reading captions", 0)?;
    let captions: Vec<Vec<Caption>> =
        photos.par_iter().map(|p| p.captions.iter().map(|c| Caption::of(c)).collect()).collect();
    let mut found = Found {
        photos_with_captions: photos.iter().filter(|p| !p.captions.is_empty()).count(),
        photos_with_interactions: photos
            .iter()
            .filter(|p| p.people.iter().any(|x| !x.interactions.is_empty()))
            .count(),
        ..Found::default()
    };
    let mut candidates = Vec::new();
    for kind in ActionKind::ALL {
        let mut funnel = Funnel::default();
        if let Some(rule) = rules.action(kind) {
            for (photo, captions) in photos.iter().zip(&captions) {
                candidates.extend(filtered(photo, captions, rule, config, rules, &mut funnel));
            }
        }
        found.funnels.push((kind, funnel));
        ticker.check()?;
    }
    ticker.stage("finding poses in space", candidates.len())?;
    let solved: Vec<Vec<Instance>> = candidates
        .par_iter()
        .map(|candidate| {
            ticker.advance()?;
            Ok(instances_of(candidate, rules, config, solver))
        })
        .collect::<Result<_, Cancelled>>()?;
    for (candidate, people) in candidates.iter().zip(solved) {
        sort_in(&mut found, candidate, people, rules);
    }
    Ok(found)
}

/// Adds what a photo gave: people, or a group.
fn sort_in(found: &mut Found, candidate: &Candidate<'_>, people: Vec<Instance>, rules: &Rules) {
    let Some((_, funnel)) = found.funnels.iter_mut().find(|(kind, _)| *kind == candidate.kind) else {
        return;
    };
    if candidate.kind == ActionKind::EatDinnerInGroup && people.len() < 2 {
        return;
    }
    funnel.with_key += usize::from(!people.is_empty());
    funnel.instances += people.len();
    funnel.complete_instances += people.iter().filter(|p| p.complete).count();
    if candidate.kind == ActionKind::EatDinnerInGroup {
        found.groups.push(group_of(candidate.photo, people, rules));
    } else {
        found.instances.extend(people);
    }
}

/// Whether somebody's joints suffice.
fn has_pose(person: &PhotoPerson, photo: &Photo, config: &InstanceConfig) -> bool {
    let any = |joints: [usize; 2]| joints.iter().any(|j| person.joint(*j).is_some());
    let area = photo.size_px.map_or(f32::INFINITY, |size| size.x * size.y);
    person.marked() >= config.joints_least
        && any([coco::LEFT_SHOULDER, coco::RIGHT_SHOULDER])
        && any([coco::LEFT_HIP, coco::RIGHT_HIP])
        && (area.is_infinite() || person.bounds.area() >= config.area_least * area)
}

fn filtered<'a>(
    photo: &'a Photo,
    captions: &'a [Caption],
    rule: &ActionRule,
    config: &InstanceConfig,
    rules: &Rules,
    funnel: &mut Funnel,
) -> Option<Candidate<'a>> {
    let said = rule.is_said(captions, config.search);
    let doers: Vec<usize> = match config.interactions {
        true => (0..photo.people.len()).filter(|i| does(photo, *i, rule, rules)).collect(),
        false => Vec::new(),
    };
    let is_group = rule.kind == ActionKind::EatDinnerInGroup;
    let done = if is_group { doers.len() >= 2 } else { !doers.is_empty() };
    funnel.said += usize::from(said);
    funnel.done += usize::from(done);
    funnel.found += usize::from(said || done);
    if !(said || done) || (photo.things.is_empty() && !photo.complete) {
        return None;
    }
    funnel.with_things += 1;
    let posed: Vec<usize> =
        (0..photo.people.len()).filter(|i| has_pose(&photo.people[*i], photo, config)).collect();
    if posed.is_empty() {
        return None;
    }
    funnel.with_pose += 1;
    // Marked people are known to do it; of a caption nobody knows whom it means.
    let marked: Vec<usize> = posed.iter().copied().filter(|i| doers.contains(i)).collect();
    let people = if is_group || marked.is_empty() { posed } else { marked };
    if !(rule.people.0..=rule.people.1).contains(&people.len()) {
        return None;
    }
    funnel.with_people += 1;
    if !photo.things.iter().any(|t| rule.requires.contains(&t.category)) {
        return None;
    }
    funnel.with_required += 1;
    if photo.complete && categories(photo, rules) < config.categories_least {
        return None;
    }
    funnel.with_categories += 1;
    Some(Candidate { photo, captions, kind: rule.kind, people })
}

/// Whether somebody was marked as doing it; a group eats what anybody eats.
fn does(photo: &Photo, person: usize, rule: &ActionRule, rules: &Rules) -> bool {
    let eats = [ActionKind::EatDinner, ActionKind::EatSnacks];
    match rule.kind {
        ActionKind::EatDinnerInGroup => {
            eats.iter().filter_map(|kind| rules.action(*kind)).any(|rule| rule.is_done(photo, person))
        }
        _ => rule.is_done(photo, person),
    }
}

/// Different categories of things indoors.
fn categories(photo: &Photo, rules: &Rules) -> usize {
    let indoors = |name: &str| {
        rules.objects.iter().any(|o| o == name) || rules.key_of_label(name).is_some() || name == "chair"
    };
    let mut names: Vec<&str> =
        photo.things.iter().map(|t| t.category.as_str()).filter(|n| indoors(n)).collect();
    names.sort_unstable();
    names.dedup();
    names.len()
}

fn instances_of(
    candidate: &Candidate<'_>,
    rules: &Rules,
    config: &InstanceConfig,
    solver: &PoseSolver<'_>,
) -> Vec<Instance> {
    candidate.people.iter().filter_map(|p| instance_of(candidate, *p, rules, config, solver)).collect()
}

fn instance_of(
    candidate: &Candidate<'_>,
    person: usize,
    rules: &Rules,
    config: &InstanceConfig,
    solver: &PoseSolver<'_>,
) -> Option<Instance> {
    let (photo, kind) = (candidate.photo, candidate.kind);
    let rule = rules.action(kind)?;
    let pose = solver.solve(&photo.people[person].joints)?;
    let place = whereabouts::key_place(photo, person, candidate.captions, rule, rules, &pose);
    // COCO marks no desks and no kitchen counters: photos without them say nothing.
    let unmarked = matches!(rule.key, KeyObject::OfficeDesk | KeyObject::KitchenIsland) || !photo.complete;
    let place = place.or_else(|| {
        (config.key_assumed && unmarked).then(|| whereabouts::assumed(candidate.captions, rule, rules))
    })?;
    let (posture, posture_evidence) =
        posture::posture(photo, person, candidate.captions, &place, rule, rules, &pose);
    let place = whereabouts::fitting(place, posture);
    let frame = PhotoFrame::of(&pose, posture, config.frame)?;
    let KeyPlace { key, relation, evidence, bounds } = place;
    let key_seen =
        bounds.filter(|_| relation == KeyRelation::Around).map(|b: PixelBox| frame.polar(b.center()));
    Some(Instance {
        photo: photo.key.clone(),
        kind,
        frame,
        posture,
        posture_evidence,
        key,
        relation,
        key_evidence: evidence,
        key_seen,
        complete: photo.complete,
        things: things_of(photo, person, kind, rules, &frame),
        pose,
    })
}

fn things_of(
    photo: &Photo,
    person: usize,
    kind: ActionKind,
    rules: &Rules,
    frame: &PhotoFrame,
) -> Vec<PlacedThing> {
    let used = |index: usize| photo.people[person].interactions.iter().any(|i| i.thing == index);
    let placed = photo.things.iter().enumerate().filter_map(|(index, thing)| {
        let object = rules.object_name(kind, &thing.category)?.to_owned();
        let (pixel, used) = (thing.center(), used(index));
        (photo.complete || used).then(|| PlacedThing { object, from_person: frame.polar(pixel), pixel, used })
    });
    placed.collect()
}

/// Distances among people and things of one photo, each as the people's own floor plans measure them.
fn group_of(photo: &Photo, people: Vec<Instance>, rules: &Rules) -> Group {
    let middle = |i: &Instance| i.frame.origin();
    let mut people_apart = Vec::new();
    for (index, a) in people.iter().enumerate() {
        for b in &people[..index] {
            // People are seen at different sizes: either measures the other.
            let there = a.frame.polar(middle(b)).distance;
            let back = b.frame.polar(middle(a)).distance;
            people_apart.push(0.5 * (there + back));
        }
    }
    let things = photo.things.iter().filter_map(|thing| {
        let object = rules.object_name(ActionKind::EatDinnerInGroup, &thing.category)?.to_owned();
        let from = |p: &Instance| p.frame.polar(thing.center()).distance;
        Some((object, people.iter().map(from).collect()))
    });
    Group {
        photo: photo.key.clone(),
        things: things.collect(),
        people_apart,
        complete: photo.complete,
        people,
    }
}
