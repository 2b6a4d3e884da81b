//! What lies under the pointer: the same things that are drawn, walls that are cut away left out. On the
//! processor, in well under a frame.

use std::sync::Arc;

use glam::Vec3;

use super::cpu::{Owner, World};
use super::draw::{Look, PersonDraw, SceneDraw};
use crate::math::Aabb;
use crate::scene::{Camera, ObjectId, PersonId, Room};

/// What was hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picked {
    /// An object of the room.
    Object(ObjectId),
    /// A person.
    Person(PersonId),
}

/// Where a ray first meets something that is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// What.
    pub what: Picked,
    /// Where, metres, world frame.
    pub at: Vec3,
    /// Unit normal there, towards the viewer.
    pub normal: Vec3,
    /// From the ray's origin, in metres.
    pub distance_m: f32,
    /// Of a person: the nearest vertex, for reading its signed distance.
    pub vertex: Option<u32>,
}

/// Answers for one room; make a new one when the room changes.
pub struct Picker {
    room: Arc<Room>,
    world: World<'static>,
}

impl Picker {
    /// Builds the tree over the visible objects of `room` (long for big rooms: call it in a job).
    pub fn new(room: &Arc<Room>) -> Self {
        Self { room: Arc::clone(room), world: World::of_room(room) }
    }

    /// Whether this answers for `room`.
    pub fn is_for(&self, room: &Arc<Room>) -> bool {
        Arc::ptr_eq(&self.room, room)
    }

    /// What is at `(x, y)` of the picture, each 0 to 1 from the top left.
    pub fn pick(&self, draw: &SceneDraw, camera: &Camera, [x, y]: [f32; 2], aspect: f32) -> Option<Pick> {
        /// Farther than any room is large.
        const FAR_M: f32 = 1000.0;
        let (origin, direction) = camera.ray(x, y, aspect);
        let cut_for = draw.look.cuts(camera, &self.world.bounds).then(|| Look::cut_eye(camera));
        let is_shown = |t: usize| !cut_for.is_some_and(|eye| self.world.is_cut_for(t, eye));
        let room = self.world.trace(origin, direction, FAR_M, |h| is_shown(h.triangle));
        let of_room = room.and_then(|hit| match self.world.owner(hit.triangle) {
            Owner::Person(..) => None,
            Owner::Room(placed, _) => Some(Pick {
                what: Picked::Object(placed.object),
                at: origin + direction * hit.distance_m,
                normal: towards(self.world.flat_normal(hit.triangle), -direction),
                distance_m: hit.distance_m,
                vertex: None,
            }),
        });
        let people = draw.people.iter().filter_map(|p| pick_person(draw, p, origin, direction));
        people.chain(of_room).min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))
    }
}

fn pick_person(draw: &SceneDraw, person: &PersonDraw, origin: Vec3, direction: Vec3) -> Option<Pick> {
    let body = draw.body.as_ref()?;
    if person.alpha <= 0.0 || !crosses(&Aabb::of(person.vertices.iter().copied()), origin, direction) {
        return None;
    }
    let hits = body.triangles().iter().filter_map(|triangle| {
        let corners = triangle.map(|v| person.vertices.get(v as usize).copied().unwrap_or(Vec3::INFINITY));
        distance_to(corners, origin, direction).map(|distance_m| (distance_m, triangle, corners))
    });
    let (distance_m, triangle, corners) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let at = origin + direction * distance_m;
    let [a, b, c] = corners;
    let nearest = (0..3)
        .min_by(|i, j| corners[*i].distance_squared(at).total_cmp(&corners[*j].distance_squared(at)))?;
    Some(Pick {
        what: Picked::Person(person.id),
        at,
        normal: towards((b - a).cross(c - a).normalize_or(-direction), -direction),
        distance_m,
        vertex: Some(triangle[nearest]),
    })
}

fn towards(normal: Vec3, viewer: Vec3) -> Vec3 {
    if normal.dot(viewer) < 0.0 { -normal } else { normal }
}

/// Whether a ray passes through a box (slab test).
fn crosses(bounds: &Aabb, origin: Vec3, direction: Vec3) -> bool {
    let inverse = direction.recip();
    let (a, b) = ((bounds.min - origin) * inverse, (bounds.max - origin) * inverse);
    let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
    near <= far && far >= 0.0
}

/// Distance along a ray to a triangle (Möller and Trumbore 1997).
fn distance_to([a, b, c]: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<f32> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let inverse = 1.0 / ab.dot(p);
    let s = origin - a;
    let u = s.dot(p) * inverse;
    let q = s.cross(ab);
    let v = direction.dot(q) * inverse;
    let t = ac.dot(q) * inverse;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}
