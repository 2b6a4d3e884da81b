//! The search itself: all places, a varied choice among them, and for each the best of a few poses.

use glam::Vec3;
use rand::RngExt as _;
use rayon::prelude::*;

use super::cells::Cells;
use super::floor_places::{leaning_places, standing_places, wall_places};
use super::lie_places::lie_places;
use super::place::Place;
use super::pose::{Poser, Settled};
use super::seat_places::{LAST_RESORT, seat_places};
use crate::body::Body;
use crate::job::{Cancelled, Rng, Seed, Ticker};
use crate::scene::{BETAS, BodyParams, PoseFamily, Room, RoomGeometry};

/// Poses tried at each place; the one that settles best is proposed.
const POSES_PER_PLACE: u64 = 5;
/// Places of one family this near to each other are the same seat for most purposes.
const SAME_PLACE_M: f32 = 0.55;
/// With a point asked for, only places this near come into question.
const NEAR_M: f32 = 1.6;
/// Pose groups in the order of a room's life: people sit most, stand, lie and lean.
const GROUPS: [&str; 8] = ["sit", "stand", "sit", "lie", "lean", "sit", "stand", "lie"];

/// What is searched for.
#[derive(Clone, Debug, Default)]
pub struct SearchRequest {
    /// How many proposals.
    pub proposals: usize,
    /// Only near this point.
    pub at: Option<Vec3>,
    /// Only these families.
    pub families: Option<Vec<PoseFamily>>,
}

/// A start for the fitter.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// The body, coarsely settled.
    pub params: BodyParams,
    /// What it does.
    pub family: PoseFamily,
    /// Number of the support surface, `None` for the floor.
    pub support: Option<usize>,
    /// Name of what holds it.
    pub on: String,
    /// Seed of this body.
    pub seed: Seed,
    /// How badly it stands before fitting: 0 is perfect, 1 is doubtful.
    pub cost: f32,
}

/// Proposes people for a room, the most promising and varied first. Fewer than asked for where the room
/// affords no more.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn search(
    room: &Room,
    geometry: &RoomGeometry,
    body: &Body,
    request: &SearchRequest,
    seed: Seed,
    ticker: &Ticker,
) -> Result<Vec<Proposal>, Cancelled> {
    ticker.stage("looking for places", geometry.supports.len())?;
    let mut places = all_places(room, geometry, seed, ticker)?;
    restrict(&mut places, request);
    let chosen = choose(&places, request.proposals, &mut seed.child("choice", 0).rng());
    ticker.stage("posing people", chosen.len())?;
    let poser = Poser::new(body);
    let propose = |(index, place): (usize, &&Place)| {
        let seed = seed.child("proposal", index as u64);
        let settled = best_pose(&poser, geometry, place, seed);
        ticker.advance()?;
        Ok(Proposal {
            params: settled.params,
            family: place.family,
            support: place.support,
            on: place.on.clone(),
            seed,
            cost: settled.cost,
        })
    };
    chosen.par_iter().enumerate().map(propose).collect()
}

/// Everything in the room that affords a pose, in the order of the surfaces: seats, beds and edges to lean
/// on, then places drawn on the floor and along walls.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn all_places(
    room: &Room,
    geometry: &RoomGeometry,
    seed: Seed,
    ticker: &Ticker,
) -> Result<Vec<Place>, Cancelled> {
    let on_surface = |index: usize| {
        let cells = Cells::new(&geometry.supports[index]);
        let mut places = seat_places(room, geometry, index, &cells);
        places.extend(lie_places(room, geometry, index, &cells));
        places.extend(leaning_places(room, geometry, index));
        ticker.advance()?;
        Ok(places)
    };
    let per_surface: Vec<Vec<Place>> =
        (0..geometry.supports.len()).into_par_iter().map(on_surface).collect::<Result<_, Cancelled>>()?;
    let mut places: Vec<Place> = per_surface.into_iter().flatten().collect();
    places.extend(standing_places(geometry, &mut seed.child("floor", 0).rng()));
    places.extend(wall_places(geometry, &mut seed.child("wall", 0).rng()));
    Ok(places)
}

/// Leaves only what was asked for; nearer places weigh more when a point was given.
fn restrict(places: &mut Vec<Place>, request: &SearchRequest) {
    if let Some(families) = &request.families {
        places.retain(|p| families.contains(&p.family));
    }
    if places.iter().any(|p| p.family.group() == "sit" && p.weight > LAST_RESORT) {
        places.retain(|p| p.family.group() != "sit" || p.weight > LAST_RESORT);
    }
    if let Some(at) = request.at {
        places.retain(|p| p.under_pelvis.distance(at) < NEAR_M);
        for place in places.iter_mut() {
            place.weight *= (-place.under_pelvis.distance_squared(at) / (0.35 * 0.35)).exp().max(1e-6);
        }
    }
}

/// Draws places group by group, by weight, with places near those drawn before suppressed.
fn choose<'a>(places: &'a [Place], count: usize, rng: &mut Rng) -> Vec<&'a Place> {
    let mut weights: Vec<f32> = places.iter().map(|p| p.weight).collect();
    let mut chosen: Vec<&Place> = Vec::new();
    let mut empty_in_a_row = 0;
    for turn in 0.. {
        if chosen.len() >= count || empty_in_a_row > GROUPS.len() {
            break;
        }
        let group = GROUPS[turn % GROUPS.len()];
        let Some(family) = next_family(places, &weights, group, &chosen) else {
            empty_in_a_row += 1;
            continue;
        };
        empty_in_a_row = 0;
        let Some(index) = draw(places, &weights, family, rng) else { continue };
        for (place, weight) in places.iter().zip(&mut weights).filter(|(p, _)| p.family == family) {
            let distance = place.under_pelvis.distance(places[index].under_pelvis) / SAME_PLACE_M;
            *weight *= 1.0 - 0.95 * (-distance * distance).exp();
        }
        weights[index] = 0.0;
        chosen.push(&places[index]);
    }
    chosen
}

/// The family of a group that was drawn least so far, among those with places left.
fn next_family(places: &[Place], weights: &[f32], group: &str, chosen: &[&Place]) -> Option<PoseFamily> {
    let available = |family: &PoseFamily| {
        places.iter().zip(weights).any(|(place, weight)| place.family == *family && *weight > 0.0)
    };
    let drawn = |family: &PoseFamily| chosen.iter().filter(|p| p.family == *family).count();
    PoseFamily::ALL.into_iter().filter(|f| f.group() == group).filter(available).min_by_key(drawn)
}

/// A place of `family`, drawn by weight.
fn draw(places: &[Place], weights: &[f32], family: PoseFamily, rng: &mut Rng) -> Option<usize> {
    let of_family = || places.iter().zip(weights).enumerate().filter(|(_, (p, _))| p.family == family);
    let total: f32 = of_family().map(|(_, (_, w))| w).sum();
    let mut left = rng.random_range(0.0..1.0) * total;
    let mut last = None;
    for (index, (_, weight)) in of_family().filter(|(_, (_, w))| **w > 0.0) {
        last = Some(index);
        left -= weight;
        if left <= 0.0 {
            break;
        }
    }
    last
}

/// The best of a few poses of one person at one place; with `exactly` no place or direction near by will do.
pub fn settle_person(
    body: &Body,
    geometry: &RoomGeometry,
    place: &Place,
    betas: &[f32; BETAS],
    exactly: bool,
    seed: Seed,
) -> Proposal {
    let poser = Poser::new(body);
    let settle =
        |i: u64| poser.settle_person(geometry, place, *betas, exactly, &mut seed.child("pose", i).rng());
    let settled = (1..POSES_PER_PLACE)
        .map(settle)
        .fold(settle(0), |best, next| if next.cost < best.cost { next } else { best });
    Proposal {
        params: settled.params,
        family: place.family,
        support: place.support,
        on: place.on.clone(),
        seed,
        cost: settled.cost,
    }
}

fn best_pose(poser: &Poser<'_>, geometry: &RoomGeometry, place: &Place, seed: Seed) -> Settled {
    let first = poser.settle(geometry, place, &mut seed.child("pose", 0).rng());
    (1..POSES_PER_PLACE)
        .map(|i| poser.settle(geometry, place, &mut seed.child("pose", i).rng()))
        .fold(first, |best, next| if next.cost < best.cost { next } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn place(family: PoseFamily, x: f32, weight: f32) -> Place {
        Place {
            family,
            under_pelvis: Vec3::X * x,
            facing: Vec2::Y,
            support: None,
            hints: crate::body::FamilyHints::default(),
            on: String::new(),
            weight,
        }
    }

    #[test]
    fn every_pose_group_that_the_room_affords_is_proposed_early() {
        let places: Vec<Place> = (0..40)
            .flat_map(|i| {
                let x = i as f32;
                [
                    place(PoseFamily::Stand, x, 9.0),
                    place(PoseFamily::SitChair, x, 1.0),
                    place(PoseFamily::LieUp, x, 0.1),
                ]
            })
            .collect();
        let chosen = choose(&places, 4, &mut Seed::root(1).rng());
        let groups: Vec<&str> = chosen.iter().map(|p| p.family.group()).collect();
        assert_eq!(groups, ["sit", "stand", "sit", "lie"]);
    }

    #[test]
    fn the_same_seat_is_not_proposed_again_while_others_are_free() {
        let places = [
            place(PoseFamily::SitChair, 0.0, 1.0),
            place(PoseFamily::SitChair, 0.05, 1.0),
            place(PoseFamily::SitChair, 3.0, 1.0),
        ];
        let far = (0..50).filter(|seed| {
            let chosen = choose(&places, 2, &mut Seed::root(*seed).rng());
            chosen[0].under_pelvis.distance(chosen[1].under_pelvis) > 1.0
        });
        assert!(far.count() >= 45);
    }

    #[test]
    fn a_point_that_was_clicked_keeps_only_places_near_it() {
        let mut places = vec![place(PoseFamily::Stand, 0.0, 1.0), place(PoseFamily::Stand, 5.0, 1.0)];
        let request = SearchRequest { proposals: 1, at: Some(Vec3::X * 5.2), families: None };
        restrict(&mut places, &request);
        assert_eq!(places.len(), 1);
        assert_eq!(places[0].under_pelvis.x, 5.0);
    }
}
