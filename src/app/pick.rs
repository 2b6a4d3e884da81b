//! What lies under the cursor. Pure: rays against the room's triangles and the people's vertices.

use std::sync::Arc;

use glam::Vec3;

use super::motion;
use super::selection::Item;
use super::state::EditorState;
use crate::math::Aabb;
use crate::scene::Camera;
use crate::scene::Category;
use crate::scene::Frame;
use crate::scene::ObjectId;
use crate::scene::Person;
use crate::scene::Room;
use crate::scene::RoomGeometry;

/// Step past a hit that is looked through, in metres.
const PAST_M: f32 = 1e-3;
/// Walls that a ray may look through before it gives up.
const LAYERS: usize = 12;
/// No hand or foot is farther than this from where a body is, metres.
const REACH_M: f32 = 1.6;
/// Farther than any room is wide.
const FAR_M: f32 = 1e4;

/// A ray in the world frame; the direction has length 1.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts, metres.
    pub origin: Vec3,
    /// Where it goes.
    pub direction: Vec3,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// Who or what.
    pub item: Item,
    /// Where, metres, world frame.
    pub point: Vec3,
    /// From the ray's start, metres.
    pub distance_m: f32,
    /// For a person: the vertex nearest to the point.
    pub vertex: Option<usize>,
}

/// Where a ray meets a triangle (Möller and Trumbore 1997), from either side; metres along the ray.
pub fn ray_triangle(ray: &Ray, [a, b, c]: [Vec3; 3]) -> Option<f32> {
    let (edge1, edge2) = (b - a, c - a);
    let p = ray.direction.cross(edge2);
    let determinant = edge1.dot(p);
    if determinant.abs() < 1e-12 {
        return None;
    }
    let from_a = ray.origin - a;
    let u = from_a.dot(p) / determinant;
    let q = from_a.cross(edge1);
    let v = ray.direction.dot(q) / determinant;
    let distance = edge2.dot(q) / determinant;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    (inside && distance > 0.0).then_some(distance)
}

/// Whether the ray meets the box within `max_m`.
pub fn ray_box(ray: &Ray, bounds: &Aabb, max_m: f32) -> bool {
    let inverse = ray.direction.recip();
    let to_min = (bounds.min - ray.origin) * inverse;
    let to_max = (bounds.max - ray.origin) * inverse;
    let near = to_min.min(to_max).max_element().max(0.0);
    let far = to_min.max(to_max).min_element().min(max_m);
    near <= far
}

/// The nearest person, sub-goal's figure or object under the ray, as the viewport shows them.
pub fn pick(state: &EditorState, ray: &Ray) -> Option<Picked> {
    let found =
        [pick_object(state, ray), pick_figure(state, ray), pick_mover(state, ray), pick_person(state, ray)];
    found.into_iter().flatten().min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))
}

fn is_shown(state: &EditorState, item: Item) -> bool {
    state.view.isolated.as_ref().is_none_or(|only| only.contains(&item))
}

fn pick_person(state: &EditorState, ray: &Ray) -> Option<Picked> {
    let clips = state.shown_clips();
    let shown =
        |p: &&Person| p.visible && is_shown(state, Item::Person(p.id)) && !motion::moves(&clips, p.id);
    let people = state.document.scene().people.iter().filter(shown);
    nearest_body(state, ray, people.map(|p| (Item::Person(p.id), state.engine().pose(&p.body))))
}

/// Somebody who moves, as shown now.
fn pick_mover(state: &EditorState, ray: &Ray) -> Option<Picked> {
    let clips = state.shown_clips();
    let bodies = clips.iter().filter_map(|clip| {
        let frame = &clip.frames[state.frame_now(clip)?];
        near(ray, frame).then(|| (Item::Clip(clip.id), state.engine().pose_frame(&clip.betas, frame)))
    });
    nearest_body(state, ray, bodies)
}

/// The figure of a sub-goal.
fn pick_figure(state: &EditorState, ray: &Ray) -> Option<Picked> {
    let figures = state.motion.shown_figures.iter().filter(|figure| near(ray, &figure.frame));
    let bodies = figures.map(|figure| (figure.item, state.engine().pose_frame(&figure.betas, &figure.frame)));
    nearest_body(state, ray, bodies)
}

/// Whether the ray comes so near to a body that it is worth to be posed.
fn near(ray: &Ray, frame: &Frame) -> bool {
    let along_m = (frame.translation - ray.origin).dot(ray.direction).max(0.0);
    (ray.origin + ray.direction * along_m).distance(frame.translation) < REACH_M
}

fn nearest_body(
    state: &EditorState,
    ray: &Ray,
    bodies: impl Iterator<Item = (Item, Arc<[Vec3]>)>,
) -> Option<Picked> {
    let faces = state.engine().faces();
    let mut nearest: Option<Picked> = None;
    for (item, vertices) in bodies {
        let max_m = nearest.map_or(FAR_M, |n| n.distance_m);
        if !ray_box(ray, &Aabb::of(vertices.iter().copied()), max_m) {
            continue;
        }
        for face in faces.iter() {
            let corners = face.map(|v| vertices[v as usize]);
            let Some(distance_m) = ray_triangle(ray, corners) else { continue };
            if nearest.is_none_or(|n| distance_m < n.distance_m) {
                let point = ray.origin + ray.direction * distance_m;
                let near = |v: &u32| vertices[*v as usize].distance_squared(point);
                let vertex = face.iter().min_by(|a, b| near(a).total_cmp(&near(b))).map(|v| *v as usize);
                nearest = Some(Picked { item, point, distance_m, vertex });
            }
        }
    }
    nearest
}

/// The nearest object that is drawn: walls that are cut away are looked through.
pub fn pick_object(state: &EditorState, ray: &Ray) -> Option<Picked> {
    let room = &state.document.scene().room;
    let camera = state.orbit.camera();
    let cut = state.view.cutaway.then(|| Cut::of(&camera, room, state)).flatten();
    let mut start = *ray;
    let mut passed_m = 0.0;
    for _ in 0..LAYERS {
        let (distance_m, id) = match state.geometry() {
            Some(geometry) => cast(geometry, &start)?,
            None => cast_without_tree(room, &start)?,
        };
        let point = start.origin + start.direction * distance_m;
        let item = Item::Object(id);
        let seen_through = cut.as_ref().is_some_and(|cut| cut.hides(room, id, point, ray));
        if is_shown(state, item) && !seen_through {
            return Some(Picked { item, point, distance_m: passed_m + distance_m, vertex: None });
        }
        passed_m += distance_m + PAST_M;
        start.origin = ray.origin + ray.direction * passed_m;
    }
    None
}

fn cast(geometry: &RoomGeometry, ray: &Ray) -> Option<(f32, ObjectId)> {
    let hit = geometry.bvh.cast(ray.origin, ray.direction, FAR_M)?;
    Some((hit.distance_m, geometry.object_of(hit.triangle)?))
}

/// The same while the tree is still being built.
fn cast_without_tree(room: &Room, ray: &Ray) -> Option<(f32, ObjectId)> {
    room.world_triangles()
        .filter_map(|(id, corners)| ray_triangle(ray, corners).map(|distance| (distance, id)))
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The cutaway as the renderer does it: with the camera outside, the near side of the shell is left out.
struct Cut {
    middle: Vec3,
}

impl Cut {
    fn of(camera: &Camera, room: &Room, state: &EditorState) -> Option<Self> {
        let bounds = state.geometry().map_or_else(|| room.bounds(), |g| g.bounds);
        let outside = camera.ortho_height_m.is_some() || !bounds.contains(camera.eye);
        outside.then(|| Self { middle: bounds.center() })
    }

    fn hides(&self, room: &Room, id: ObjectId, point: Vec3, ray: &Ray) -> bool {
        let on_shell = room.object(id).is_some_and(|o| {
            let hung = matches!(o.category, Category::Picture | Category::Curtain | Category::Mirror);
            o.category != Category::Floor && (o.category.is_structure() || hung)
        });
        on_shell && (point - self.middle).dot(ray.direction) < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_a_triangle_where_it_crosses_its_plane() {
        let ray = Ray { origin: Vec3::new(0.2, 5.0, 0.2), direction: Vec3::NEG_Y };
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Z];
        assert_eq!(ray_triangle(&ray, triangle), Some(5.0));
        let beside = Ray { origin: Vec3::new(0.8, 5.0, 0.8), ..ray };
        assert_eq!(ray_triangle(&beside, triangle), None);
        let behind = Ray { origin: Vec3::new(0.2, -5.0, 0.2), ..ray };
        assert_eq!(ray_triangle(&behind, triangle), None);
    }

    #[test]
    fn a_ray_along_an_axis_meets_a_box_and_misses_the_one_beside() {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
        let ray = Ray { origin: Vec3::new(0.5, 0.5, -3.0), direction: Vec3::Z };
        assert!(ray_box(&ray, &bounds, 10.0));
        assert!(!ray_box(&ray, &bounds, 2.0), "too far away");
        assert!(!ray_box(&Ray { origin: Vec3::new(1.5, 0.5, -3.0), ..ray }, &bounds, 10.0));
    }
}
