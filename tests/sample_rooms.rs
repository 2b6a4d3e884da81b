//! What every user sees first must be right: the sample rooms are what their layouts say, nothing in them floats
//! or runs into anything else, and people find seats, beds and tables there.

use std::path::{Path, PathBuf};

use glam::{Affine3A, Vec3};
use inhabit::assets::{Budget, Model, glb_from_model, read_model, read_model_bytes, sample_rooms};
use inhabit::math::Aabb;
use inhabit::scene::layout::{Layout, LayoutError, compose};
use inhabit::scene::{ImportOptions, model_from_room, room_from_model};

/// Deeper than this, two things run into each other.
const PENETRATION_LIMIT_M: f32 = 0.005;
/// Nearer than this, something touches what it stands on or hangs from.
const TOUCH_M: f32 = 0.003;

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets")
}

fn composed(text: &str) -> Result<Model, LayoutError> {
    let folder = assets().join("furniture");
    let load = |file: &str| read_model(&folder.join(file), &Budget::default()).map_err(|e| e.to_string());
    compose(&Layout::read(text)?, &load)
}

fn layout_text(key: &str) -> String {
    std::fs::read_to_string(assets().join(format!("rooms/{key}.layout.ron"))).expect("a layout")
}

/// One node of the file with its triangles in the world frame.
struct Thing {
    name: String,
    category: String,
    triangles: Vec<[Vec3; 3]>,
    bounds: Aabb,
}

impl Thing {
    fn is_shell(&self) -> bool {
        ["wall", "floor", "ceiling", "window", "door"].contains(&self.category.as_str())
    }

    /// The thing made `margin_m` smaller on every side.
    fn shrunk(&self, margin_m: f32) -> Vec<[Vec3; 3]> {
        let center = self.bounds.center();
        let size = self.bounds.size().max(Vec3::splat(1e-6));
        let factor = ((size - 2.0 * margin_m) / size).max(Vec3::ZERO);
        let shrink = Affine3A::from_translation(center)
            * Affine3A::from_scale(factor)
            * Affine3A::from_translation(-center);
        self.triangles.iter().map(|t| t.map(|p| shrink.transform_point3(p))).collect()
    }
}

fn things(model: &Model) -> Vec<Thing> {
    let mut things: Vec<(usize, Thing)> = Vec::new();
    for part in &model.parts {
        let corners = (0..part.mesh.triangles.len())
            .map(|t| part.mesh.corners(t).map(|p| part.file_from_mesh.transform_point3(p)));
        let index = things.iter().position(|(node, _)| *node == part.node).unwrap_or_else(|| {
            let extras: serde_json::Value =
                serde_json::from_str(part.extras.as_deref().expect("extras")).expect("JSON");
            let category = extras["category"].as_str().expect("a category").to_owned();
            let name = part.name.clone();
            things.push((part.node, Thing { name, category, triangles: Vec::new(), bounds: Aabb::EMPTY }));
            things.len() - 1
        });
        things[index].1.triangles.extend(corners);
    }
    things
        .into_iter()
        .map(|(_, mut thing)| {
            thing.bounds = Aabb::of(thing.triangles.as_flattened().iter().copied());
            thing
        })
        .collect()
}

/// Whether segment `p`-`q` crosses the triangle (Möller and Trumbore 1997).
fn crosses(p: Vec3, q: Vec3, [a, b, c]: &[Vec3; 3]) -> bool {
    let (direction, e1, e2) = (q - p, b - a, c - a);
    let h = direction.cross(e2);
    let det = e1.dot(h);
    if det.abs() < 1e-12 {
        return false;
    }
    let s = (p - a) / det;
    let u = s.dot(h);
    let k = s.cross(e1);
    let (v, t) = (direction.dot(k), e2.dot(k));
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&t)
}

fn intersect(a: &[Vec3; 3], b: &[Vec3; 3]) -> bool {
    let edges = |t: &[Vec3; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    edges(a).iter().any(|(p, q)| crosses(*p, *q, b)) || edges(b).iter().any(|(p, q)| crosses(*p, *q, a))
}

/// Where two things run into each other, if they do.
fn collision(a: &Thing, b: &Thing) -> Option<Vec3> {
    let near = |triangles: Vec<[Vec3; 3]>, other: &Aabb| -> Vec<([Vec3; 3], Aabb)> {
        let boxed = triangles.into_iter().map(|t| (t, Aabb::of(t)));
        boxed.filter(|(_, bounds)| bounds.intersects(other)).collect()
    };
    let inside_b = near(a.shrunk(PENETRATION_LIMIT_M), &b.bounds);
    let inside_a = near(b.shrunk(PENETRATION_LIMIT_M), &a.bounds);
    inside_b.iter().find_map(|(t, bounds)| {
        let hit = inside_a.iter().any(|(other, around)| around.intersects(bounds) && intersect(t, other));
        hit.then(|| bounds.center())
    })
}

#[test]
fn the_shipped_rooms_are_what_their_layouts_say_byte_for_byte() {
    for room in sample_rooms() {
        let glb = glb_from_model(&composed(&layout_text(room.key)).expect("composes")).expect("writes");
        assert!(glb == room.glb, "{}: run `cargo run --release --example bake_rooms`", room.key);
        assert!(room.glb.len() < 1_500_000, "{} has {} bytes", room.key, room.glb.len());
    }
}

#[test]
fn a_room_reads_back_to_the_same_triangles_in_the_same_objects() {
    for room in sample_rooms() {
        let written = composed(&layout_text(room.key)).expect("composes");
        let read = read_model_bytes(room.key, room.glb, &Budget::default()).expect("reads");
        assert_eq!(read.notes, Vec::<String>::new(), "{}", room.key);
        let (written, read) = (things(&written), things(&read));
        assert_eq!(written.len(), read.len());
        for (w, r) in written.iter().zip(&read) {
            assert_eq!((&w.name, &w.category, w.triangles.len()), (&r.name, &r.category, r.triangles.len()));
            assert!(w.triangles == r.triangles, "{} of {} moved", w.name, room.key);
        }
    }
}

#[test]
fn a_room_that_is_exported_opens_again_with_the_same_objects_in_the_same_place() {
    for sample in sample_rooms() {
        let open = |glb: &[u8]| {
            let model = read_model_bytes(sample.key, glb, &Budget::default()).expect("reads");
            room_from_model(&model, &ImportOptions::default()).room
        };
        let room = open(sample.glb);
        let again = open(&glb_from_model(&model_from_room(&room)).expect("writes"));
        assert_eq!(room.objects.len(), again.objects.len(), "{}", sample.key);
        for (a, b) in room.objects.iter().zip(&again.objects) {
            assert_eq!((&a.name, a.category), (&b.name, b.category), "{}", sample.key);
            let apart = a.world_triangles().flatten().zip(b.world_triangles().flatten());
            let worst = apart.map(|(p, q)| p.distance(q)).fold(0.0, f32::max);
            assert!(a.triangle_count() == b.triangle_count() && worst < 2e-6, "{}: {worst} m", a.name);
        }
    }
}

#[test]
fn nothing_in_a_sample_room_runs_into_anything_else() {
    for room in sample_rooms() {
        let model = read_model_bytes(room.key, room.glb, &Budget::default()).expect("reads");
        let things = things(&model);
        for (i, a) in things.iter().enumerate() {
            for b in things[i + 1..].iter().filter(|b| !(a.is_shell() && b.is_shell())) {
                let at = collision(a, b);
                assert!(at.is_none(), "{}: {} runs into {} at {at:?}", room.key, a.name, b.name);
            }
        }
    }
}

/// Whether some point of `thing` is within [`TOUCH_M`] of some surface of `other`.
fn touches(thing: &Thing, other: &Thing) -> bool {
    if !thing.bounds.grown(TOUCH_M).intersects(&other.bounds) {
        return false;
    }
    let reach = thing.bounds.grown(TOUCH_M);
    let near: Vec<&[Vec3; 3]> = other.triangles.iter().filter(|t| Aabb::of(**t).intersects(&reach)).collect();
    let close =
        |p: &Vec3| near.iter().any(|t| inhabit::scene::closest_on_triangle(t, *p).distance(*p) < TOUCH_M);
    thing.triangles.as_flattened().iter().any(close)
}

#[test]
fn everything_in_a_sample_room_stands_lies_or_hangs_on_something() {
    for room in sample_rooms() {
        let model = read_model_bytes(room.key, room.glb, &Budget::default()).expect("reads");
        let things = things(&model);
        for thing in things.iter().filter(|t| !t.is_shell()) {
            let standing = things.iter().any(|other| {
                let below = other.bounds.min.y < thing.bounds.min.y - 0.002;
                other.name != thing.name && below && touches_from_above(thing, other)
            });
            let hanging = ["picture", "curtain", "lighting", "tv monitor", "board panel"]
                .contains(&thing.category.as_str())
                && things.iter().any(|other| other.name != thing.name && touches(thing, other));
            assert!(standing || hanging, "{}: {} floats", room.key, thing.name);
        }
    }
}

/// Whether the lowest points of `thing` rest on `other`.
fn touches_from_above(thing: &Thing, other: &Thing) -> bool {
    let foot = thing.bounds.min.y + TOUCH_M;
    let lowest = thing.triangles.iter().filter(|t| t.iter().any(|p| p.y < foot)).copied().collect();
    let soles =
        Thing { triangles: lowest, name: String::new(), category: String::new(), bounds: thing.bounds };
    touches(&soles, other)
}

#[test]
fn the_key_objects_are_there_for_people_to_use() {
    let expected: [(&str, &[(&str, usize)]); 3] = [
        (
            "living",
            &[("couch", 1), ("chair", 5), ("coffee table", 1), ("dining table", 1), ("tv monitor", 1)],
        ),
        ("bedroom", &[("bed", 1), ("chair", 2), ("office desk", 1), ("cabinet", 3), ("lighting", 2)]),
        ("office", &[("office desk", 2), ("chair", 2), ("couch", 1), ("stool", 3), ("counter", 3)]),
    ];
    for (key, counts) in expected {
        let room = sample_rooms().iter().find(|r| r.key == key).expect("the room");
        let things = things(&read_model_bytes(key, room.glb, &Budget::default()).expect("reads"));
        for (category, least) in counts {
            let found = things.iter().filter(|t| t.category == *category).count();
            assert!(found >= *least, "{key} has {found} of {category}, needs {least}");
        }
        for structure in ["wall", "floor", "ceiling", "window", "door"] {
            assert!(things.iter().any(|t| t.category == structure), "{key} has no {structure}");
        }
    }
}

/// The rooms' chairs stand at tables; someone who sits there needs room for the thighs under the top (62 cm
/// above the floor for a tall man) and between backrest and table edge for the trunk (30 cm).
#[test]
fn people_can_sit_at_the_tables() {
    for (key, chairs, table) in [
        ("living", ["Chair 1", "Chair 2", "Chair 3", "Chair 4"].as_slice(), "Dining table"),
        ("bedroom", &["Desk chair"], "Desk"),
        ("office", &["Office chair 1"], "Desk 1"),
    ] {
        let room = sample_rooms().iter().find(|r| r.key == key).expect("the room");
        let things = things(&read_model_bytes(key, room.glb, &Budget::default()).expect("reads"));
        let thing = |name: &str| things.iter().find(|t| t.name == name).expect("the thing");
        let table = thing(table);
        let top = table.bounds.max.y;
        assert!((0.70..0.78).contains(&top), "{key}: the table is {top} m high");
        for chair in chairs.iter().map(|name| thing(name)) {
            let to_table = table.bounds.center() - chair.bounds.center();
            let axis = if chair.bounds.max.z < table.bounds.min.z || chair.bounds.min.z > table.bounds.max.z {
                2
            } else {
                0
            };
            let gap = if to_table[axis] > 0.0 {
                table.bounds.min[axis] - chair.bounds.max[axis]
            } else {
                chair.bounds.min[axis] - table.bounds.max[axis]
            };
            assert!((0.0..0.2).contains(&gap), "{key}: {} is {gap} m from the table", chair.name);
            let behind = chair.triangles.as_flattened().iter().filter(|p| p.y > 0.7);
            let back = Aabb::of(behind.copied()).center()[axis] - chair.bounds.center()[axis];
            assert!(back * to_table[axis] < 0.0, "{key}: {} turns its back to the table", chair.name);
        }
    }
}
