//! Where to look from to see what people do: their faces, and what they use, past whatever stands about. Draws nothing.

use glam::{Vec2, Vec3};

use crate::body::{Body, Posed, joints};
use crate::cli::screens::Screens;
use crate::evolve::action::{Embodied, Evolution, EvolutionStep, MoveReason};
use crate::math::Aabb;
use crate::render::frame_bounds;
use crate::scene::{Camera, ObjectId, Room};

/// Points of a body that should be seen.
const SAMPLES: usize = 64;
/// Things farther than this from everybody are no part of the picture, metres.
const AT_HAND_M: f32 = 0.9;
/// Two views differ by at least this angle, a little less than a right one (radians).
const APART: f32 = 1.3;
/// Elevations that are tried, radians: a table top is not seen from a seated person's eyes.
const ELEVATIONS: [f32; 4] = [0.2, 0.42, 0.64, 0.86];
/// Vertical fields of view: of a 35 mm lens, and of the wide one that narrow rooms need.
const FIELDS_OF_VIEW: [f32; 2] = [0.66, 0.95];
/// What a view is worth: people, heads and things that are seen, fronts, and against it steepness and width.
const WORTH: Worth = Worth { people: 0.35, heads: 0.3, things: 0.35, fronts: 0.2, steep: 0.1, wide: 0.15 };
/// Points of a head are so far from its joint, metres.
const HEAD_M: f32 = 0.13;

struct Worth {
    people: f32,
    heads: f32,
    things: f32,
    fronts: f32,
    steep: f32,
    wide: f32,
}

/// What a picture of an action has to show.
struct Subject {
    people: Vec<Vec3>,
    heads: Vec<Vec3>,
    things: Vec<Vec3>,
    fronts: Vec<Vec2>,
}

/// Up to `count` views of the last action, the clearest first; none before the first action.
pub fn action_views(
    evolution: &Evolution,
    room: &Room,
    people: &[Embodied],
    aspect: f32,
    count: usize,
) -> Vec<Camera> {
    let Some(step) = evolution.steps().last() else { return Vec::new() };
    let subject = Subject::of(evolution, step, people);
    let screens = Screens::of(room);
    let bounds = Aabb::of(subject.people.iter().chain(&subject.things).copied()).grown(0.08);
    let mut found: Vec<(f32, f32, Camera)> = directions()
        .flat_map(|(azimuth, elevation)| FIELDS_OF_VIEW.map(|fov_y| (azimuth, elevation, fov_y)))
        .map(|(azimuth, elevation, fov_y)| {
            let (flat, up) = (elevation.cos(), elevation.sin());
            let direction = Vec3::new(azimuth.sin() * flat, up, azimuth.cos() * flat);
            let camera = frame_bounds(&bounds, direction, fov_y, aspect);
            let strain = WORTH.steep * elevation + WORTH.wide * (fov_y - FIELDS_OF_VIEW[0]);
            (subject.worth(&camera, &screens) - strain, azimuth, camera)
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<(f32, Camera)> = Vec::new();
    for (_, azimuth, camera) in found {
        if chosen.len() < count && chosen.iter().all(|(other, _)| turn(azimuth, *other) >= APART) {
            chosen.push((azimuth, camera));
        }
    }
    chosen.into_iter().map(|(_, camera)| camera).collect()
}

fn directions() -> impl Iterator<Item = (f32, f32)> {
    let azimuths = (0..24).map(|i| i as f32 / 24.0 * std::f32::consts::TAU);
    azimuths.flat_map(|azimuth| ELEVATIONS.map(|elevation| (azimuth, elevation)))
}

/// Angle between two azimuths, 0 to pi.
fn turn(a: f32, b: f32) -> f32 {
    let d = (a - b).rem_euclid(std::f32::consts::TAU);
    d.min(std::f32::consts::TAU - d)
}

impl Subject {
    /// The step's people, as they were fitted or else as they were meant, and what they touch.
    fn of(evolution: &Evolution, step: &EvolutionStep, people: &[Embodied]) -> Self {
        let body = Body::bundled();
        let pose = |params| body.pose(params);
        let bodies: Vec<Posed> = match people {
            [] => step.people.iter().map(|p| pose(&p.body)).collect(),
            fitted => fitted.iter().map(|p| pose(&p.person.body)).collect(),
        };
        let sampled = |posed: &Posed| {
            let every = (posed.vertices.len() / SAMPLES).max(1);
            posed.vertices.iter().copied().step_by(every).collect::<Vec<_>>()
        };
        let around = [Vec3::ZERO, Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::Z, Vec3::NEG_Z];
        let head = |posed: &Posed| around.map(|way| posed.joints[joints::HEAD] + way * HEAD_M);
        let near = |bounds: &Aabb| {
            let at = bounds.center();
            step.people.iter().any(|p| p.frame.centre_m.distance(at) < AT_HAND_M)
        };
        let boxes = touched(step).filter_map(|id| evolution.world().item(id)).map(|item| item.bounds);
        Self {
            people: bodies.iter().flat_map(sampled).collect(),
            heads: bodies.iter().flat_map(head).collect(),
            things: boxes.filter(near).flat_map(|bounds| top(&bounds)).collect(),
            fronts: step.people.iter().map(|p| p.frame.front()).collect(),
        }
    }

    fn worth(&self, camera: &Camera, screens: &Screens) -> f32 {
        let people = screens.seen(camera, &self.people);
        let things = if self.things.is_empty() { people } else { screens.seen(camera, &self.things) };
        let to_eye = camera.eye - camera.target;
        let to_eye = Vec2::new(to_eye.x, to_eye.z).normalize_or_zero();
        let fronts = self.fronts.iter().map(|front| front.dot(to_eye)).sum::<f32>();
        let fronts = fronts / self.fronts.len().max(1) as f32;
        let heads = screens.seen(camera, &self.heads);
        WORTH.people * people + WORTH.heads * heads + WORTH.things * things + WORTH.fronts * fronts
    }
}

/// Everything that an action brought or moved in order to use it.
fn touched(step: &EvolutionStep) -> impl Iterator<Item = ObjectId> + '_ {
    let used = step.moved.iter().filter(|thing| thing.why == MoveReason::Used);
    step.inserted.iter().map(|thing| thing.id).chain(used.map(|thing| thing.id))
}

/// Points of a thing's upper side.
fn top(bounds: &Aabb) -> [Vec3; 5] {
    let (middle, half) = (bounds.center(), 0.35 * bounds.size());
    let at = |x: f32, z: f32| Vec3::new(middle.x + x * half.x, bounds.max.y, middle.z + z * half.z);
    [at(0.0, 0.0), at(-1.0, -1.0), at(-1.0, 1.0), at(1.0, -1.0), at(1.0, 1.0)]
}
