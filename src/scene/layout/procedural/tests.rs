use std::collections::BTreeSet;

use super::*;
use crate::assets::Model;
use crate::math::Aabb;
use crate::scene::layout::{compose, new_room};

use glam::Vec2;

/// Rooms of each kind that are looked at.
const SEEDS: u64 = 30;
/// Boxes may share this much: rounding.
const TOUCH_M: f32 = 0.004;

struct Thing {
    name: String,
    category: String,
    bounds: Aabb,
}

fn things(layout: &Layout, model: &Model) -> Vec<Thing> {
    let category = |name: &str| layout.furniture.iter().find(|p| p.name == name).map(|p| p.category.clone());
    let mut things: Vec<Thing> = Vec::new();
    for part in &model.parts {
        let Some(category) = category(&part.name) else { continue };
        let corners = part.mesh.positions.iter().map(|p| part.file_from_mesh.transform_point3(*p));
        let bounds = Aabb::of(corners);
        match things.iter_mut().find(|t| t.name == part.name) {
            Some(thing) => thing.bounds = thing.bounds.union(bounds),
            None => things.push(Thing { name: part.name.clone(), category, bounds }),
        }
    }
    things
}

fn overlap(a: &Aabb, b: &Aabb) -> bool {
    let (a, b) = (a.grown(-TOUCH_M), b.grown(-TOUCH_M));
    a.intersects(&b)
}

fn check_room(kind: RoomType, seed: u64) {
    let layout = procedural_layout(kind, seed);
    let at = format!("{} {seed}", kind.key());
    // Composing refuses what sticks out of the room, stands on nothing or has a name twice.
    let model =
        compose(&layout, &crate::scene::layout::bundled_furniture).unwrap_or_else(|e| panic!("{at}: {e}"));
    let things = things(&layout, &model);
    let lying = |t: &Thing| t.name.starts_with("Rug");
    let on = |t: &Thing| layout.furniture.iter().find(|p| p.name == t.name).and_then(|p| p.on.clone());
    for (i, a) in things.iter().enumerate() {
        for b in things[i + 1..].iter().filter(|b| !lying(a) && !lying(b)) {
            let held = on(b).as_deref() == Some(a.name.as_str()) || on(a).as_deref() == Some(b.name.as_str());
            assert!(held || !overlap(&a.bounds, &b.bounds), "{at}: {} runs into {}", a.name, b.name);
        }
    }
    let essential: &[&str] = match kind {
        RoomType::Living => &["couch"],
        RoomType::Bedroom | RoomType::Children | RoomType::Guest => &["bed"],
        RoomType::Office => &["office desk", "chair"],
        RoomType::Dining => &["dining table"],
        RoomType::Studio => &["bed", "couch"],
        RoomType::Lounge => &[],
    };
    for category in essential {
        assert!(things.iter().any(|t| t.category == *category), "{at} has no {category}");
    }
    let seats = ["couch", "chair", "bed", "stool", "seating"];
    assert!(things.iter().any(|t| seats.contains(&t.category.as_str())), "{at} has nothing to sit on");
    check_doors(&layout, &things, &at);
}

/// Nothing stands within a step of a door.
fn check_doors(layout: &Layout, things: &[Thing], at: &str) {
    let shell = crate::scene::layout::shell::Shell::new(layout).expect("a shell");
    for door in &layout.doors {
        for out in [0.2, 0.5, 0.75] {
            let before = shell.before_wall(door.wall, door.at_m, out);
            let blocks = |t: &&Thing| {
                let b = t.bounds;
                b.min.y < 1.8
                    && b.max.y > 0.03
                    && (b.min.x..b.max.x).contains(&before.x)
                    && (b.min.z..b.max.z).contains(&before.y)
            };
            let blocking = things.iter().find(blocks);
            assert!(blocking.is_none(), "{at}: {} blocks a door", blocking.map_or("", |t| &t.name));
        }
    }
}

#[test]
fn living_rooms_and_offices_are_whole_and_free_of_overlaps() {
    (0..SEEDS).for_each(|seed| check_room(RoomType::Living, seed));
    (0..SEEDS).for_each(|seed| check_room(RoomType::Office, seed));
}

#[test]
fn bedrooms_of_all_kinds_are_whole_and_free_of_overlaps() {
    (0..SEEDS).for_each(|seed| check_room(RoomType::Bedroom, seed));
    (0..SEEDS).for_each(|seed| check_room(RoomType::Children, seed));
    (0..SEEDS).for_each(|seed| check_room(RoomType::Guest, seed));
}

#[test]
fn dining_rooms_studios_and_lounges_are_whole_and_free_of_overlaps() {
    (0..SEEDS).for_each(|seed| check_room(RoomType::Dining, seed));
    (0..SEEDS).for_each(|seed| check_room(RoomType::Studio, seed));
    (0..SEEDS).for_each(|seed| check_room(RoomType::Lounge, seed));
}

/// Whether one can walk between any two free places of the floor: judged by the finished room's own boxes on a
/// grid of its own, for a walker 44 cm wide.
#[test]
fn one_can_walk_everywhere() {
    const CELL_M: f32 = 0.08;
    const HALF_M: f32 = 0.22;
    for (kind, seed) in RoomType::ALL.into_iter().flat_map(|kind| (0..6).map(move |seed| (kind, seed))) {
        let layout = procedural_layout(kind, seed);
        let model = new_room(kind, seed).expect("composes");
        let shell = crate::scene::layout::shell::Shell::new(&layout).expect("a shell");
        let boxes: Vec<Aabb> = things(&layout, &model)
            .into_iter()
            .filter(|t| t.bounds.max.y > 0.03 && t.bounds.min.y < 1.8)
            .map(|t| t.bounds.grown(HALF_M))
            .collect();
        let free = |p: Vec2| {
            let inside = [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y]
                .iter()
                .all(|d| shell.outside_m(p + *d * HALF_M) == 0.0);
            inside
                && !boxes
                    .iter()
                    .any(|b| (b.min.x..b.max.x).contains(&p.x) && (b.min.z..b.max.z).contains(&p.y))
        };
        let at = |x: i32, z: i32| Vec2::new(x as f32, z as f32) * CELL_M;
        let cells: BTreeSet<(i32, i32)> = (-60..=60)
            .flat_map(|x| (-60..=60).map(move |z| (x, z)))
            .filter(|(x, z)| free(at(*x, *z)))
            .collect();
        let largest = largest_part(&cells);
        let share = largest as f32 / cells.len() as f32;
        assert!(share > 0.9, "{} {seed}: only {share} of the free floor hangs together", kind.key());
    }
}

fn largest_part(cells: &BTreeSet<(i32, i32)>) -> usize {
    let mut left = cells.clone();
    let mut largest = 0;
    while let Some(start) = left.pop_first() {
        let (mut open, mut size) = (vec![start], 0);
        while let Some((x, z)) = open.pop() {
            size += 1;
            for beside in [(x - 1, z), (x + 1, z), (x, z - 1), (x, z + 1)] {
                if left.remove(&beside) {
                    open.push(beside);
                }
            }
        }
        largest = largest.max(size);
    }
    largest
}

#[test]
fn the_same_seed_gives_the_same_room_and_another_seed_another() {
    let text = |seed| ron::to_string(&procedural_layout(RoomType::Studio, seed)).expect("text");
    assert_eq!(text(3), text(3));
    assert_ne!(text(3), text(4));
    let read = Layout::read(&text(5)).expect("reads back");
    assert_eq!(ron::to_string(&read).expect("text"), text(5));
}

#[test]
fn the_catalogue_agrees_with_the_models() {
    for stock in stock::ALL.iter().flat_map(|list| list.iter()) {
        let model = crate::assets::furniture_model(stock.file).expect(stock.file).expect("reads");
        let size = model.bounds().size();
        let listed = glam::Vec3::from(stock.size);
        assert!((size - listed).abs().max_element() < 0.003, "{} is {size}, not {listed}", stock.file);
    }
}

#[test]
fn kinds_are_found_by_their_keys() {
    for kind in RoomType::ALL {
        assert_eq!(RoomType::from_key(kind.key()), Some(kind));
    }
    assert_eq!(RoomType::from_key("castle"), None);
}
