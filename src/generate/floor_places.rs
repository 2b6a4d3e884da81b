//! Where people stand: free on the floor, leaning on tables and counters, with their back to a wall.

use glam::{Vec2, Vec3};
use rand::RngExt as _;

use super::place::{Place, category, flat, name_of};
use crate::body::{FamilyHints, LeanStyle};
use crate::job::Rng;
use crate::scene::{EdgePoint, PoseFamily, Room, RoomGeometry};

/// Heights over the floor of things to lean on with hands or hips.
const LEAN_HEIGHT_M: std::ops::RangeInclusive<f32> = 0.68..=1.15;
/// From the edge of a table to the pelvis of somebody who leans on it with their hands.
const HANDS_DISTANCE_M: f32 = 0.3;
/// How far behind the edge the hands rest.
const HANDS_ON_TOP_M: f32 = 0.06;
/// From the edge of a counter to the pelvis of somebody who leans their hips against it.
const HIPS_DISTANCE_M: f32 = 0.14;
/// From a wall to the pelvis of somebody who leans their back against it.
const WALL_DISTANCE_M: f32 = 0.16;
/// From where one leans to the floor that one walks on.
const STEP_M: f32 = 0.35;
/// Height at which a wall is looked for behind a back.
const BACK_HEIGHT_M: f32 = 1.1;
/// Places drawn on the floor: enough that every corner of a room is among them.
const FLOOR_DRAWS: usize = 400;

/// Places to stand, drawn evenly over the floor that can be reached.
pub fn standing_places(geometry: &RoomGeometry, rng: &mut Rng) -> Vec<Place> {
    let cells: Vec<usize> = geometry.floor.largest_area().collect();
    if cells.is_empty() {
        return Vec::new();
    }
    let draw = |rng: &mut Rng| {
        let cell = geometry.floor.position(cells[rng.random_range(0..cells.len())]);
        let facing = Vec2::from_angle(rng.random_range(0.0..std::f32::consts::TAU));
        let view_m = open_view(geometry, cell, facing);
        floor_place(PoseFamily::Stand, cell, facing, "floor".to_owned(), 0.2 + view_m.min(2.5) / 2.5)
    };
    (0..FLOOR_DRAWS).map(|_| draw(rng)).collect()
}

/// Places to lean with the back against a wall.
pub fn wall_places(geometry: &RoomGeometry, rng: &mut Rng) -> Vec<Place> {
    let cells: Vec<usize> = geometry.floor.largest_area().collect();
    if cells.is_empty() {
        return Vec::new();
    }
    let draw = |rng: &mut Rng| {
        let cell = geometry.floor.position(cells[rng.random_range(0..cells.len())]);
        let (distance, gradient) = geometry.field.sample_gradient(cell + Vec3::Y * BACK_HEIGHT_M);
        let away = flat(gradient).normalize_or_zero();
        let upright = gradient.y.abs() < 0.2 && distance < 0.45 && away != Vec2::ZERO;
        let stand = cell - Vec3::new(away.x, 0.0, away.y) * (distance - WALL_DISTANCE_M);
        let whole = [0.5, 0.9, 1.3]
            .iter()
            .all(|h| (geometry.field.sample(stand + Vec3::Y * *h) - WALL_DISTANCE_M).abs() < 0.05);
        (upright && whole).then(|| {
            let mut place = floor_place(PoseFamily::Lean, stand, away, "wall".to_owned(), 0.6);
            place.hints.lean = Some(LeanStyle::BackOnWall);
            place
        })
    };
    (0..FLOOR_DRAWS).filter_map(|_| draw(rng)).collect()
}

/// Places to lean on the edges of one surface, with the hands in front or the hips behind.
pub fn leaning_places(room: &Room, geometry: &RoomGeometry, index: usize) -> Vec<Place> {
    let surface = &geometry.supports[index];
    let category = category(room, surface);
    if category.is_structure() || surface.area_m2 < 0.1 {
        return Vec::new();
    }
    let weight = if category.is_table() { 1.0 } else { 0.25 };
    let at = |edge: &EdgePoint, distance_m: f32, sign: f32| {
        let outward = flat(edge.outward).normalize_or_zero();
        let p = flat(edge.position) + outward * distance_m;
        // Somebody can walk up to it: the walkable floor begins no farther than a step away.
        let floor = geometry.floor.position(geometry.floor.nearest_walkable(p)?);
        if flat(floor).distance(p) > STEP_M {
            return None;
        }
        let mut place = floor_place(
            PoseFamily::Lean,
            Vec3::new(p.x, floor.y, p.y),
            outward * sign,
            name_of(category, "edge"),
            weight,
        );
        place.support = Some(index);
        place.hints.table_height_m = Some(edge.drop_m);
        place.hints.table_reach_m = Some(distance_m + HANDS_ON_TOP_M);
        place.hints.lean = Some(if sign < 0.0 { LeanStyle::HandsInFront } else { LeanStyle::HipsOnCounter });
        Some(place)
    };
    let edges = surface.edges.iter().filter(|e| LEAN_HEIGHT_M.contains(&e.drop_m) && e.body_free_m > 0.3);
    edges.flat_map(|e| [at(e, HANDS_DISTANCE_M, -1.0), at(e, HIPS_DISTANCE_M, 1.0)]).flatten().collect()
}

fn floor_place(family: PoseFamily, at: Vec3, facing: Vec2, on: String, weight: f32) -> Place {
    Place { family, under_pelvis: at, facing, support: None, hints: FamilyHints::default(), on, weight }
}

/// How far somebody standing at `cell` sees along `facing`: nobody stares at a wall from near by.
fn open_view(geometry: &RoomGeometry, cell: Vec3, facing: Vec2) -> f32 {
    let eye = cell + Vec3::Y * 1.5;
    let direction = Vec3::new(facing.x, 0.0, facing.y);
    geometry.bvh.cast(eye, direction, 3.0).map_or(3.0, |hit| hit.distance_m)
}
