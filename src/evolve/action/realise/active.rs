//! Placing what an action uses (ADSE §5.2, eq. 9 and 10; §5.3, eq. 12): places are drawn uniformly over what the
//! thing may stand on, valued, and taken best first: the first that is free is the best that is free.

use std::cmp::Ordering;

use glam::{Vec2, Vec3};
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};

use super::library::{Faces, Ground, Kind};
use super::placing::{Avoid, Onto, Rest};
use super::shape::Shape;
use super::stage::Surface;
use super::step::{Candidates, Sample, Verdict};
use super::world::{Ball, Lifted, World, flat};
use crate::evolve::action::PersonFrame;
use crate::job::Rng;
use crate::scene::{ObjectId, facing_of};

/// ADSE §5.2: places drawn for one thing.
pub const ACTIVE_SAMPLES: usize = 2000;
/// Things are placed this near to the person's centre at most; what is watched, farther.
const REACH_M: f32 = 1.25;
/// What stays put is watched from across the room.
const WATCH_M: f32 = 5.0;
/// People want this much of a thing on the table; eq. 9's half is taken where there is no such place.
const WANTED_SHARE: f32 = 0.85;
/// How much a place off the key object is worth.
const ELSEWHERE: f32 = 0.3;
/// How much a place on the floor is worth.
const ON_FLOOR: f32 = 0.01;
/// Samples kept for the overlay beside those that were tried.
const KEPT_UNTRIED: usize = 48;
/// Most tried samples that are kept for the overlay.
const KEPT_TRIED: usize = 96;
/// What people use keeps this far from their body.
const OFF_BODY_M: f32 = 0.02;
/// Heads and chests are this far above a lap.
const FACE_BLEND: f32 = 0.5;

/// One thing to be placed.
pub struct Task<'a> {
    /// What it is.
    pub kind: &'a Kind,
    /// Its geometry.
    pub shape: &'a Shape,
    /// The key object.
    pub key: ObjectId,
    /// Whom it is for: it faces them. For what a group shares, the nearest of them.
    pub person: PersonFrame,
    /// Things that it would rather lie on: a plate for a sandwich.
    pub servers: Vec<ObjectId>,
    /// How much a place is worth; 0 where it must not be.
    pub value: &'a dyn Fn(Vec3) -> f32,
}

/// A thing's chosen place, and the places that were drawn.
pub struct Chosen {
    /// The place, if there is one.
    pub rest: Option<Rest>,
    /// For the overlay.
    pub candidates: Candidates,
}

/// Chooses the best free place. `balls` are the people that it must keep clear of.
pub fn choose(world: &World, task: &Task<'_>, lifted: &Lifted, balls: &[Ball], rng: &mut Rng) -> Chosen {
    let grown: Vec<Ball> = balls.iter().map(|(at, r)| (*at, r + OFF_BODY_M)).collect();
    let avoid = Avoid::new(lifted, &grown);
    let served = task.servers.iter().find_map(|server| on_server(world, task, *server, &avoid, rng));
    if let Some(rest) = served {
        let sample = Sample { at: rest.pose.at, score: (task.value)(rest.pose.at), verdict: Verdict::Taken };
        let candidates = Candidates { object: task.kind.kind.clone(), samples: vec![sample], drawn: 1 };
        return Chosen { rest: Some(rest), candidates };
    }
    let mut drawn = draw(world, task, rng);
    drawn.sort_by(|a, b| b.score.total_cmp(&a.score).then(order(a.at, b.at)));
    let rest = try_in_order(world, task, &mut drawn, &avoid);
    Chosen { rest, candidates: kept(task, &drawn) }
}

/// A place that was drawn.
struct Drawn {
    at: Vec3,
    yaw_rad: f32,
    surface: usize,
    score: f32,
    verdict: Verdict,
}

fn order(a: Vec3, b: Vec3) -> Ordering {
    a.x.total_cmp(&b.x).then(a.z.total_cmp(&b.z)).then(a.y.total_cmp(&b.y))
}

/// How much a surface is worth to a thing; `None` where it may not stand.
fn worth(task: &Task<'_>, surface: &Surface) -> Option<f32> {
    let allowed = task.kind.on.contains(&surface.ground);
    let is_key = surface.owner == Some(task.key);
    // What stays is put where it suits best, wherever people are: a television on its stand.
    let suits = if task.kind.on.first() == Some(&surface.ground) { 1.0 } else { ELSEWHERE };
    match (allowed, surface.ground, is_key) {
        (false, ..) => None,
        (true, Ground::Floor, _) if task.kind.on.len() > 1 => Some(ON_FLOOR),
        (true, ..) if task.kind.stays => Some(suits),
        (true, Ground::Floor, _) | (true, _, true) => Some(1.0),
        (true, _, false) => Some(ELSEWHERE),
    }
}

fn draw(world: &World, task: &Task<'_>, rng: &mut Rng) -> Vec<Drawn> {
    let reach_m = if task.kind.stays { WATCH_M } else { REACH_M };
    let centre = flat(task.person.centre_m);
    let height_m = task.shape.bounds.size().y;
    let mut cells: Vec<(usize, Vec3, f32)> = Vec::new();
    for (number, surface) in world.stage.surfaces.iter().enumerate() {
        let Some(worth) = worth(task, surface) else { continue };
        let near = surface.cells.iter().filter(|(at, clear_m)| {
            *clear_m > height_m && flat(*at).distance_squared(centre) < reach_m * reach_m
        });
        cells.extend(near.map(|(at, _)| (number, *at, worth)));
    }
    if cells.is_empty() {
        return Vec::new();
    }
    let one = |_| {
        let (surface, cell, worth) = cells[rng.random_range(0..cells.len())];
        let half = 0.5 * world.stage.surfaces[surface].cell_m;
        let at = cell + Vec3::new(rng.random_range(-half..half), 0.0, rng.random_range(-half..half));
        let yaw_rad = yaw_of(task, flat(at), rng);
        Drawn { at, yaw_rad, surface, score: worth * (task.value)(at), verdict: Verdict::NotTried }
    };
    (0..ACTIVE_SAMPLES).map(one).filter(|d| d.score > 0.0).collect()
}

/// The turn with which a thing's front looks where its kind says.
fn yaw_of(task: &Task<'_>, at: Vec2, rng: &mut Rng) -> f32 {
    let noise: f32 = StandardNormal.sample(rng);
    let spread = task.kind.spread_deg.to_radians() * noise.clamp(-2.5, 2.5);
    let towards = facing_of(flat(task.person.centre_m) - at);
    // Square to the person's own front as much as to the line of sight: what lies aside is not turned all the way.
    let square = task.person.facing_rad + std::f32::consts::PI;
    let between = square + FACE_BLEND * super::spot::wrapped(towards - square);
    match task.kind.faces {
        Faces::Person => between + spread,
        Faces::Away => between + std::f32::consts::PI + spread,
        Faces::Seat => towards + spread,
        Faces::Free => rng.random_range(-std::f32::consts::PI..std::f32::consts::PI),
    }
}

/// The best place with as much of the thing on it as people want; else the best where at least half of it is.
fn try_in_order(world: &World, task: &Task<'_>, drawn: &mut [Drawn], avoid: &Avoid<'_>) -> Option<Rest> {
    let mut second: Option<(usize, Rest)> = None;
    for (number, place) in drawn.iter_mut().enumerate() {
        let surface = &world.stage.surfaces[place.surface];
        let onto = Onto::Surface { number: place.surface, height_m: place.at.y, soft: surface.soft };
        match world.place(task.shape, flat(place.at), place.yaw_rad, onto, avoid) {
            Ok(rest) if rest.share >= WANTED_SHARE => {
                place.verdict = Verdict::Taken;
                return Some(rest);
            }
            Ok(rest) => {
                place.verdict = Verdict::Overhangs;
                second.get_or_insert((number, rest));
            }
            Err(refused) => place.verdict = refused.into(),
        }
    }
    let (number, rest) = second?;
    drawn[number].verdict = Verdict::Taken;
    Some(rest)
}

/// On a plate or a board, near its middle.
fn on_server(
    world: &World,
    task: &Task<'_>,
    server: ObjectId,
    avoid: &Avoid<'_>,
    rng: &mut Rng,
) -> Option<Rest> {
    let item = world.item(server)?;
    let onto = Onto::Item { id: server, top_m: item.bounds.max.y };
    let room = (item.shape.reach_m - task.shape.reach_m).max(0.0);
    (0..8).find_map(|k| {
        let off =
            Vec2::from_angle(rng.random_range(0.0..std::f32::consts::TAU)) * room * 0.4 * (k as f32 / 8.0);
        let yaw_rad = yaw_of(task, flat(item.pose.at), rng);
        world.place(task.shape, flat(item.pose.at) + off, yaw_rad, onto, avoid).ok()
    })
}

fn kept(task: &Task<'_>, drawn: &[Drawn]) -> Candidates {
    let sample = |d: &Drawn| Sample { at: d.at, score: d.score, verdict: d.verdict };
    let tried = drawn.iter().filter(|d| d.verdict != Verdict::NotTried);
    let taken = tried.clone().filter(|d| d.verdict == Verdict::Taken).map(sample);
    let refused = tried.filter(|d| d.verdict != Verdict::Taken).take(KEPT_TRIED).map(sample);
    let untried: Vec<&Drawn> = drawn.iter().filter(|d| d.verdict == Verdict::NotTried).collect();
    let stride = (untried.len() / KEPT_UNTRIED).max(1);
    let rest = untried.iter().step_by(stride).take(KEPT_UNTRIED).map(|d| sample(d));
    let samples = taken.chain(refused).chain(rest).collect();
    Candidates { object: task.kind.kind.clone(), samples, drawn: drawn.len() }
}
