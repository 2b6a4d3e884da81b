//! Real bodies for the people of a step: settled at their place and fitted, so that they sit and stand there.
//!
//! A fit needs a distance field. Baking the room anew takes seconds, so the field of what stays is kept and only
//! chairs, which carry people, are worked into it where they stand now. Small things are not in the field: they are
//! surfaces that the fitter keeps limbs out of, so hands come to rest on a keyboard and not in it.

use std::f32::consts::FRAC_1_SQRT_2;

use glam::Vec3;
use rand_distr::{Distribution as _, StandardNormal};

use super::attend::attention;
use super::evolution::Evolution;
use super::step::{EvolutionStep, StepPerson};
use super::world::Item;
use crate::body::{Attention, Body};
use crate::fit::{FitConfig, Fitter, Surroundings};
use crate::generate::settle_person;
use crate::inspect::{BodyReport, Finding, Limits, Site, inspect_body};
use crate::job::{Cancelled, Seed, Ticker};
use crate::math::Aabb;
use crate::scene::{BETAS, ObjectId, Person, PersonId, RoomGeometry, SignedDistanceField, TriangleBvh};

/// Things this near to somebody matter to their fit.
const NEAR_M: f32 = 1.6;
/// Distances to a chair are exact up to here; beyond, what stays decides.
const CHAIR_BAND_M: f32 = 0.25;
/// Sheets of a chair are taken for this thick: thinner ones fall between the samples.
const HALF_SHEET_M: f32 = 0.006;
/// Fits that are tried for one person.
const TRIES: u64 = 3;
/// People differ in shape by this share of the population's spread.
const SHAPE: f32 = 0.8;

/// Somebody fitted at an action.
#[derive(Clone, Debug)]
pub struct Embodied {
    /// The person.
    pub person: Person,
    /// What was measured.
    pub report: BodyReport,
    /// What is above its limit.
    pub findings: Vec<Finding>,
}

/// Bodies for the people of the last step, numbered from `first_id`.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn embody(evolution: &Evolution, first_id: u32, ticker: &Ticker) -> Result<Vec<Embodied>, Cancelled> {
    embody_as(evolution, None, first_id, ticker)
}

/// As [`embody`], all people with the body shape `betas`: somebody who is known already.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn embody_as(
    evolution: &Evolution,
    betas: Option<&[f32; BETAS]>,
    first_id: u32,
    ticker: &Ticker,
) -> Result<Vec<Embodied>, Cancelled> {
    let Some(step) = evolution.steps().last() else { return Ok(Vec::new()) };
    let one = |(number, person): (usize, &StepPerson)| {
        let geometry = geometry_around(evolution, step, person);
        let id = first_id + number as u32;
        let seed = evolution.seed_of(step.number).child("body", number as u64);
        let attention = attention(evolution, step, number);
        let mut best: Option<(f32, Embodied)> = None;
        for attempt in 0..TRIES {
            let seed = seed.child("try", attempt);
            let betas = betas.copied().unwrap_or_else(|| drawn_shape(seed));
            // Hands that get into something on their way are left to the family at last.
            let attention = attention.filter(|_| attempt + 1 < TRIES);
            let task = Task { geometry: &geometry, person, id, betas, attention };
            let fitted = task.fit(seed, attempt == 0, ticker)?;
            let badness = fitted.findings.iter().map(Finding::severity).sum::<f32>();
            if best.as_ref().is_none_or(|(least, _)| badness < *least) {
                best = Some((badness, fitted));
            }
            if badness == 0.0 {
                break;
            }
        }
        Ok(best.map(|(_, fitted)| fitted))
    };
    let fitted: Result<Vec<_>, Cancelled> = step.people.iter().enumerate().map(one).collect();
    Ok(fitted?.into_iter().flatten().collect())
}

/// A person of the population.
fn drawn_shape(seed: Seed) -> [f32; BETAS] {
    let mut rng = seed.child("shape", 0).rng();
    std::array::from_fn(|_| {
        let z: f32 = StandardNormal.sample(&mut rng);
        z.clamp(-2.0, 2.0) * SHAPE * FRAC_1_SQRT_2
    })
}

/// Somebody to be fitted.
struct Task<'a> {
    geometry: &'a RoomGeometry,
    person: &'a StepPerson,
    id: u32,
    betas: [f32; BETAS],
    attention: Option<Attention>,
}

impl Task<'_> {
    fn fit(&self, seed: Seed, exactly: bool, ticker: &Ticker) -> Result<Embodied, Cancelled> {
        let (body, geometry, person, id) = (Body::bundled(), self.geometry, self.person, self.id);
        let mut place = person.place.clone();
        place.hints.attention = self.attention;
        let start = settle_person(body, geometry, &place, &self.betas, exactly, seed.child("pose", 0)).params;
        let around = Surroundings::new(geometry, Aabb::of(body.pose(&start).vertices));
        let fitter = Fitter::new(body);
        let fitted =
            fitter.fit(&around, &start, person.family, &FitConfig::default(), ticker, &mut |_| ())?;
        let report = inspect_body(geometry, body, &fitted.params);
        let findings = Limits::default().findings(Site { body: id, frame: None }, &report.metrics);
        let person = Person {
            id: PersonId(id),
            name: format!("Person {}", id + 1),
            body: fitted.params,
            family: person.family,
            on: person.on.clone(),
            seed: seed.value(),
            palette: id,
            visible: true,
            locked: false,
        };
        Ok(Embodied { person, report, findings })
    }
}

/// The room around one person as it is now.
fn geometry_around(evolution: &Evolution, step: &EvolutionStep, person: &StepPerson) -> RoomGeometry {
    let (world, stage) = (evolution.world(), evolution.stage());
    let near = Aabb::of([person.spot.pelvis]).grown(NEAR_M);
    let touches = |t: &[Vec3; 3]| Aabb::of(*t).intersects(&near);
    let fixed = stage.geometry.bvh.triangles().iter().enumerate().filter(|(_, t)| touches(t));
    let (mut owner, mut triangles): (Vec<ObjectId>, Vec<[Vec3; 3]>) =
        fixed.map(|(i, t)| (stage.geometry.object_of(i).unwrap_or(ObjectId(u32::MAX)), *t)).unzip();
    let mut field = stage.geometry.field.clone();
    let chairs: Vec<ObjectId> = step.people.iter().filter_map(|p| p.chair).collect();
    let is_chair = |item: &Item| {
        let kind = item.kind.map(|k| evolution.library().kind(k).kind.as_str());
        chairs.contains(&item.id) || matches!(kind, Some("chair" | "stool"))
    };
    for item in world.near(&near) {
        let place = item.world_from_item();
        for triangle in item.shape.tree.triangles() {
            owner.push(item.id);
            triangles.push(triangle.map(|p| place.transform_point3(p)));
        }
        if is_chair(item) {
            work_in(&mut field, item);
        }
    }
    RoomGeometry {
        bvh: TriangleBvh::new(triangles),
        field,
        supports: Vec::new(),
        floor: stage.geometry.floor.clone(),
        bounds: stage.geometry.bounds,
        owner,
    }
}

/// Lowers the field's values around a chair to the distance from it.
fn work_in(field: &mut SignedDistanceField, item: &Item) {
    let around = item.bounds.grown(CHAIR_BAND_M);
    let inverse = item.world_from_item().inverse();
    let cell = |p: Vec3| ((p - field.origin) / field.cell_m).max(Vec3::ZERO);
    let (low, high) = (cell(around.min).floor().as_uvec3(), cell(around.max).ceil().as_uvec3());
    for x in low.x as usize..=(high.x as usize).min(field.dim[0] - 1) {
        for y in low.y as usize..=(high.y as usize).min(field.dim[1] - 1) {
            for z in low.z as usize..=(high.z as usize).min(field.dim[2] - 1) {
                let local = inverse.transform_point3(field.position(x, y, z));
                let Some(nearest) = item.shape.tree.closest(local, CHAIR_BAND_M) else { continue };
                let at = (x * field.dim[1] + y) * field.dim[2] + z;
                field.values[at] = field.values[at].min(nearest.distance_m - HALF_SHEET_M);
            }
        }
    }
}
