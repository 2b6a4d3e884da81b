//! What is wrong with an evolved room, and how lived in it is: collisions, support, bounds, ways left, messiness.

use std::collections::{BTreeMap, VecDeque};

use glam::{Vec2, Vec3};
use serde::Serialize;

use super::evolution::Evolution;
use super::placing::carries_m;
use super::shape::UnderPoint;
use super::world::{Held, Item, Lifted, Pose, Source, Things, World, flat};
use crate::inspect::distance_to_hull;
use crate::math::Aabb;
use crate::scene::WalkableFloor;

/// Deeper than this is an interpenetration.
pub const PENETRATION_MM: f32 = 2.0;
/// A thing whose nearest point is this near to what is below does not hang in the air.
const HELD_WITHIN_M: f32 = 0.005;
/// Rays for what is below start so far above the underside.
const FROM_ABOVE_M: f32 = 0.004;
/// Weight this far outside of what carries it tips a thing.
const TIPS_M: f32 = 0.008;
/// What sticks out of the room by more than this is out of bounds.
const OUTSIDE_M: f32 = 0.01;
/// Squares of the plan whose filling tells how scattered things are.
const SCATTER_M: f32 = 0.25;
/// Floor things lower than this are stepped over.
const STEP_OVER_M: f32 = 0.08;
/// Somebody works within this distance of where they can walk.
const AT_WORK_M: f32 = 0.75;

/// Two things that run into each other, or a thing and the room.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Interpenetration {
    /// One thing.
    pub object: String,
    /// The other; the room when `None`.
    pub other: Option<String>,
    /// How deep, millimetres.
    pub depth_mm: f32,
}

/// Figures of one state of a room. Only things that an action moved or brought are judged: what was wrong with the
/// room before is not its doing.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RoomMeasures {
    /// Pairs deeper than [`PENETRATION_MM`].
    pub interpenetrations: usize,
    /// The deepest.
    pub worst_interpenetration_mm: f32,
    /// Which.
    pub pairs: Vec<Interpenetration>,
    /// Things that nothing holds, or that would tip.
    pub unsupported: usize,
    /// Which.
    pub unsupported_objects: Vec<String>,
    /// Things that are not inside the room.
    pub out_of_bounds: usize,
    /// Which.
    pub out_of_bounds_objects: Vec<String>,
    /// Things that can be moved.
    pub objects: usize,
    /// Of these, things that actions brought.
    pub brought: usize,
    /// Walkable floor now over walkable floor before, 0 to 1.
    pub walkable_share: f32,
    /// Whether somebody can walk up to the place of the last action.
    pub working_zone_reachable: bool,
    /// How scattered things lie: entropy in bits of their places in squares of 25 cm.
    pub messiness_bits: f32,
}

/// Measures an evolution's present state.
pub fn measure(evolution: &Evolution) -> RoomMeasures {
    let world = evolution.world();
    let touched: Vec<_> = world.items().filter(|i| is_touched(world, i)).cloned().collect();
    let pairs: Vec<Interpenetration> = interpenetrations(world, &touched);
    let deep = |p: &&Interpenetration| p.depth_mm > PENETRATION_MM;
    let unsupported: Vec<String> = touched.iter().filter_map(|i| not_held(world, i)).collect();
    let outside: Vec<String> = touched
        .iter()
        .filter(|i| !world.is_in_the_room(&i.bounds, OUTSIDE_M))
        .map(|i| i.name.clone())
        .collect();
    let (walkable_share, reachable) = ways_left(evolution);
    RoomMeasures {
        interpenetrations: pairs.iter().filter(deep).count(),
        worst_interpenetration_mm: pairs.iter().map(|p| p.depth_mm).fold(0.0, f32::max),
        pairs: pairs.into_iter().filter(|p| p.depth_mm > PENETRATION_MM).collect(),
        unsupported: unsupported.len(),
        unsupported_objects: unsupported,
        out_of_bounds: outside.len(),
        out_of_bounds_objects: outside,
        objects: world.len(),
        brought: world.items().filter(|i| matches!(i.source, Source::Brought { .. })).count(),
        walkable_share,
        working_zone_reachable: reachable,
        messiness_bits: messiness(world),
    }
}

/// Whether an action moved or brought a thing.
fn is_touched(world: &World, item: &Item) -> bool {
    let found = world.stage.movable.iter().find(|f| f.id == item.id);
    found.is_none_or(|f| item.pose != Pose::upright(f.at, 0.0))
}

fn interpenetrations(world: &World, touched: &[std::sync::Arc<Item>]) -> Vec<Interpenetration> {
    let mut found = Vec::new();
    for item in touched {
        for other in world.near(&item.bounds) {
            let counted_before = touched.iter().any(|t| t.id == other.id) && other.id < item.id;
            if other.id == item.id || counted_before {
                continue;
            }
            let depth_mm = depth_mm(item, other);
            if depth_mm > 0.0 {
                found.push(Interpenetration {
                    object: item.name.clone(),
                    other: Some(other.name.clone()),
                    depth_mm,
                });
            }
        }
        let room_mm = depth_in_room_mm(world, item);
        if room_mm > 0.0 {
            found.push(Interpenetration { object: item.name.clone(), other: None, depth_mm: room_mm });
        }
    }
    found
}

/// How far two things must move apart along the vertical or sideways to run into each other no more, millimetres.
fn depth_mm(item: &Item, other: &Item) -> f32 {
    let meets = |shift: Vec3| {
        let place = other.world_from_item().inverse()
            * glam::Affine3A::from_translation(shift)
            * item.world_from_item();
        other.shape.tree.meets(&item.shape.tree, &place)
    };
    least_shift_mm(&meets)
}

fn depth_in_room_mm(world: &World, item: &Item) -> f32 {
    let meets = |shift: Vec3| {
        let place = glam::Affine3A::from_translation(shift) * item.world_from_item();
        world.stage.geometry.bvh.meets(&item.shape.tree, &place)
    };
    least_shift_mm(&meets)
}

/// The least of a few lengths by which a shift in one of five directions frees; 0 when nothing meets.
fn least_shift_mm(meets: &dyn Fn(Vec3) -> bool) -> f32 {
    const WAYS: [Vec3; 5] = [Vec3::Y, Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z];
    if !meets(Vec3::ZERO) {
        return 0.0;
    }
    for millimetres in [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0_f32] {
        if WAYS.iter().any(|way| !meets(*way * millimetres * 1e-3)) {
            return millimetres;
        }
    }
    128.0
}

/// Why a thing would fall, for people; `None` when something is right under it and it does not tip. Looks at the thing
/// as it lies, whatever was known when it was put there.
fn not_held(world: &World, item: &Item) -> Option<String> {
    if item.held == Held::AsFound {
        return None;
    }
    // What stands on it is not under it.
    let mut above = Lifted::from([item.id]);
    above.extend(world.carried_by(item.id));
    let soft = match item.held {
        Held::Surface(number) => world.stage.surfaces.get(number).is_some_and(|s| s.soft),
        _ => false,
    };
    let place = item.world_from_item();
    let gap_m = |p: &UnderPoint| {
        let point = place.transform_point3(Vec3::new(p.at.x, item.shape.bounds.min.y + p.lift_m, p.at.y));
        let top = world.top_below(flat(point), point.y + FROM_ABOVE_M, &Things::AllBut(&above)).0;
        (p.at, point.y - top)
    };
    let gaps: Vec<(Vec2, f32)> = item.shape.under.iter().map(gap_m).collect();
    let least_m = gaps.iter().map(|g| g.1).fold(f32::INFINITY, f32::min);
    if least_m > HELD_WITHIN_M {
        return Some(format!("{} hangs {:.0} mm in the air", item.name, least_m * 1e3));
    }
    let carried: Vec<Vec2> = gaps.iter().filter(|g| g.1 < carries_m(soft)).map(|g| g.0).collect();
    let off_m = distance_to_hull(&carried, item.shape.middle);
    (off_m > TIPS_M)
        .then(|| format!("{} tips: its weight is {:.0} mm off what carries it", item.name, off_m * 1e3))
}

/// Shannon entropy of where small things lie.
fn messiness(world: &World) -> f32 {
    let mut squares: BTreeMap<[i32; 2], usize> = BTreeMap::new();
    for item in world.items() {
        let square = (flat(item.pose.at) / SCATTER_M).floor().as_ivec2();
        *squares.entry(square.to_array()).or_default() += 1;
    }
    let total = world.len().max(1) as f32;
    squares.values().map(|n| *n as f32 / total).map(|p| -p * p.log2()).sum()
}

/// The share of the walkable floor that is left, and whether the last action's place can be walked up to.
fn ways_left(evolution: &Evolution) -> (f32, bool) {
    let world = evolution.world();
    let floor = &world.stage.geometry.floor;
    let then = found_positions(world);
    let before = largest_area(floor, &then);
    let now_boxes: Vec<Aabb> = world.items().map(|i| i.bounds).collect();
    let now = largest_area(floor, &now_boxes);
    let share =
        now.iter().filter(|c| **c).count() as f32 / before.iter().filter(|c| **c).count().max(1) as f32;
    let Some(step) = evolution.steps().last() else { return (share.min(1.0), true) };
    let reached = |at: Vec3| {
        (0..now.len()).any(|cell| now[cell] && flat(floor.position(cell)).distance(flat(at)) < AT_WORK_M)
    };
    (share.min(1.0), step.people.iter().all(|p| reached(p.spot.pelvis)))
}

fn found_positions(world: &World) -> Vec<Aabb> {
    let at = |f: &super::stage::Found| super::world::placed_bounds(&f.shape, &Pose::upright(f.at, 0.0));
    world.stage.movable.iter().map(at).collect()
}

/// Cells of the largest connected walkable area when boxes stand on the floor.
fn largest_area(floor: &WalkableFloor, boxes: &[Aabb]) -> Vec<bool> {
    let [nx, nz] = floor.dim;
    let radius = floor.walker.radius_m;
    let mut free: Vec<bool> = floor.area.iter().map(Option::is_some).collect();
    let stands = |b: &&Aabb| b.min.y < 0.3 && b.max.y > STEP_OVER_M;
    for b in boxes.iter().filter(stands) {
        let (low, high) = (Vec2::new(b.min.x, b.min.z) - radius, Vec2::new(b.max.x, b.max.z) + radius);
        let from = ((low - floor.origin) / floor.cell_m).ceil().max(Vec2::ZERO);
        let to = ((high - floor.origin) / floor.cell_m).floor();
        for x in from.x as usize..=(to.x.max(-1.0) as i64).clamp(-1, nx as i64 - 1).max(0) as usize {
            for z in from.y as usize..=(to.y.max(-1.0) as i64).clamp(-1, nz as i64 - 1).max(0) as usize {
                if x < nx && z < nz {
                    free[x * nz + z] = false;
                }
            }
        }
    }
    flood(&free, nx, nz)
}

fn flood(free: &[bool], nx: usize, nz: usize) -> Vec<bool> {
    let mut seen = vec![false; free.len()];
    let mut best: Vec<usize> = Vec::new();
    for start in 0..free.len() {
        if !free[start] || seen[start] {
            continue;
        }
        let (mut area, mut queue) = (vec![start], VecDeque::from([start]));
        seen[start] = true;
        while let Some(cell) = queue.pop_front() {
            let (x, z) = (cell / nz, cell % nz);
            let around = [(x > 0, cell.wrapping_sub(nz)), (x + 1 < nx, cell + nz)];
            let beside = [(z > 0, cell.wrapping_sub(1)), (z + 1 < nz, cell + 1)];
            for next in around.into_iter().chain(beside).filter(|n| n.0).map(|n| n.1) {
                if free[next] && !seen[next] {
                    seen[next] = true;
                    area.push(next);
                    queue.push_back(next);
                }
            }
        }
        if area.len() > best.len() {
            best = area;
        }
    }
    let mut largest = vec![false; free.len()];
    best.into_iter().for_each(|cell| largest[cell] = true);
    largest
}
