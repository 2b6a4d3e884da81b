use std::collections::HashMap;

use super::*;

const ROOM: &str = r#"(
    name: "Test room",
    outline: Box(4.0, 3.0),
    height_m: 2.5,
    floor: Planks((180, 140, 100)),
    walls: (230, 225, 215),
    ceiling: (250, 250, 250),
    skirting: Some((height_m: 0.08, depth_m: 0.015, color: (255, 255, 255))),
    windows: [(wall: 0, at_m: 2.0, sill_m: 0.9, width_m: 1.6, height_m: 1.2, color: (255, 255, 255))],
    doors: [(wall: 1, at_m: 1.5, width_m: 0.9, height_m: 2.05, color: (240, 240, 240))],
    furniture: [
        (item: Table(size: (1.4, 0.75, 0.8), top: (200, 160, 120), legs: (60, 60, 60)), name: "Desk",
         category: "office desk", at: (0.5, 0.0, -0.9)),
        (item: Laptop, name: "Laptop", category: "objects", at: (0.5, 0.0, -0.9), yaw_deg: 180.0, on: Some("Desk")),
        (item: Lamp(height_m: 1.6, shade: (255, 230, 190), stand: (40, 40, 40)), name: "Lamp",
         category: "lighting", at: (-1.6, 0.0, -1.0)),
    ],
)"#;

fn no_files(file: &str) -> Result<Model, String> {
    Err(format!("no file {file}"))
}

fn build(text: &str) -> Result<Model, LayoutError> {
    compose(&Layout::read(text)?, &no_files)
}

/// The message of the error that `text` gives.
fn problem(text: &str) -> String {
    build(text).expect_err("must be refused").to_string()
}

#[test]
fn a_room_has_the_size_that_its_layout_says() {
    let model = build(ROOM).expect("composes");
    let floor = model.parts.iter().find(|p| p.name == "Floor").expect("a floor");
    assert_eq!(floor.mesh.bounds().max.y, 0.0);
    let bounds = model.bounds();
    assert!((bounds.size().x - 4.2).abs() < 1e-4 && (bounds.size().z - 3.2).abs() < 1e-4, "{bounds:?}");
    let ceiling = model.parts.iter().find(|p| p.name == "Ceiling").expect("a ceiling");
    assert_eq!(ceiling.mesh.bounds().min.y, 2.5);
}

#[test]
fn what_stands_on_a_table_stands_exactly_on_its_top() {
    let model = build(ROOM).expect("composes");
    let lowest = |name: &str| {
        let parts = model.parts.iter().filter(|p| p.name == name);
        let heights = parts.flat_map(|p| {
            p.mesh.positions.iter().map(|v| p.file_from_mesh.transform_point3(*v).y).collect::<Vec<_>>()
        });
        heights.fold(f32::INFINITY, f32::min)
    };
    assert!((lowest("Laptop") - 0.75).abs() < 1e-6, "{}", lowest("Laptop"));
    assert_eq!(lowest("Lamp"), 0.0);
}

/// Edges that are not shared by exactly two triangles of opposite direction, by position.
fn open_edges(mesh: &crate::assets::Mesh) -> usize {
    let key = |v: u32| mesh.positions[v as usize].to_array().map(|c| (c * 1e4).round() as i64);
    let mut edges: HashMap<_, i32> = HashMap::new();
    for t in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (key(t[k]), key(t[(k + 1) % 3]));
            *edges.entry((a, b)).or_default() += 1;
            *edges.entry((b, a)).or_default() -= 1;
        }
    }
    edges.values().filter(|n| **n != 0).count()
}

fn volume(mesh: &crate::assets::Mesh) -> f32 {
    (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

#[test]
fn walls_and_pieces_are_watertight_and_face_outwards() {
    let extra = r#"(item: Rug(size: (1.0, 0.8), color: (9, 9, 9), border: (99, 9, 9)), name: "Rug", category: "objects", at: (0.0, 0.0, 0.4)),
        (item: Curtain(size: (0.8, 2.0), color: (9, 9, 9)), name: "Curtain", category: "curtain", at: (1.0, 0.1, -1.45)),
        (item: Rod(length_m: 1.0, color: (9, 9, 9)), name: "Rod", category: "curtain", at: (1.0, 2.2, -1.5)),
        (item: Cushion(size: (0.5, 0.12, 0.4), color: (9, 9, 9)), name: "Pillow", category: "cushion", at: (0.0, 0.0, 1.0)),
        (item: Pendant(drop_m: 0.8, shade: (9, 9, 9)), name: "Pendant", category: "lighting", at: (0.0, 1.7, 0.0)),
        (item: Picture(size: (0.6, 0.4), art: Hills, colors: ((1, 2, 3), (1, 2, 3), (1, 2, 3), (1, 2, 3)), frame: (9, 9, 9)), name: "Picture", category: "picture", at: (-1.0, 1.4, -1.5)),
        (item: Wardrobe(size: (1.0, 2.0, 0.6), doors: 3, case: (9, 9, 9), front: (9, 9, 9)), name: "Wardrobe", category: "cabinet", at: (-1.4, 0.0, 0.9), yaw_deg: 90.0),
        (item: Monitor(width_m: 0.55), name: "Monitor", category: "tv monitor", at: (0.2, 0.0, -0.9), on: Some("Desk")),
        (item: Keyboard, name: "Keyboard", category: "objects", at: (0.2, 0.0, -0.7), on: Some("Desk")),
        (item: Sofa(size: (1.4, 0.8, 0.85), seat_m: 0.42, seats: 2, arm_m: 0.15, fabric: (9, 9, 9), wood: (9, 9, 9)), name: "Sofa", category: "couch", at: (1.1, 0.0, 1.0), yaw_deg: 180.0),
        (item: Bed(size: (0.9, 0.5, 1.9), headboard_m: 1.0, cover: (9, 9, 9), wood: (9, 9, 9)), name: "Bed", category: "bed", at: (-0.6, 0.0, 0.3)),
        (item: Pouf(size: (0.5, 0.4, 0.5), fabric: (9, 9, 9)), name: "Pouf", category: "stool", at: (0.3, 0.0, 0.4)),
        (item: Bench(size: (1.0, 0.45, 0.4), fabric: (9, 9, 9), wood: (9, 9, 9)), name: "Bench", category: "seating", at: (1.3, 0.0, 0.2)),
        (item: Shelf(size: (0.8, 1.4, 0.3), boards: 4, color: (9, 9, 9)), name: "Shelf", category: "shelving", at: (1.5, 0.0, -1.2)),
        (item: Books([(9, 9, 9), (99, 9, 9)]), name: "Books", category: "objects", at: (0.9, 0.0, -0.8), on: Some("Desk")),
    ],
)"#;
    let text = format!("{}{extra}", ROOM.strip_suffix("    ],\n)").expect("ends so"));
    let model = build(&text).expect("composes");
    for part in &model.parts {
        assert_eq!(open_edges(&part.mesh), 0, "{} has open edges", part.name);
        assert!(volume(&part.mesh) > 0.0, "{} is inside out", part.name);
    }
    let names: Vec<&str> = model.parts.iter().map(|p| p.name.as_str()).collect();
    for name in ["Wall 3", "Window 0", "Door 0", "Skirting", "Pendant", "Books"] {
        assert!(names.contains(&name), "{name} is missing");
    }
}

#[test]
fn a_wall_is_as_big_as_its_face_less_its_openings() {
    let model = build(ROOM).expect("composes");
    let wall = model.parts.iter().find(|p| p.name == "Wall 0").expect("a wall");
    // Mitred: 4 m inside, 4.2 m outside, 0.1 m thick; the window takes 1.6 by 1.2.
    let expected = (4.1 * 2.5 - 1.6 * 1.2) * 0.1;
    assert!((volume(&wall.mesh) - expected).abs() < 1e-4, "{} instead of {expected}", volume(&wall.mesh));
}

#[test]
fn a_room_with_a_corner_cut_out_has_floor_only_where_the_room_is() {
    let text = ROOM.replace(
        "Box(4.0, 3.0)",
        "Polygon([(-2, -1.5), (2, -1.5), (2, 1.5), (0, 1.5), (0, 0.5), (-2, 0.5)])",
    );
    let model = build(&text).expect("composes");
    let floor = model.parts.iter().find(|p| p.name == "Floor").expect("a floor");
    let expected = (4.2 * 2.2 + 2.2 * 1.0) * 0.1;
    assert!((volume(&floor.mesh) - expected).abs() < 1e-3, "{} not {expected}", volume(&floor.mesh));
    assert_eq!(open_edges(&floor.mesh), 0);
    assert!(problem(&text.replace("(-1.6, 0.0, -1.0)", "(-1.6, 0.0, 1.0)")).contains("'Lamp' sticks"));
}

#[test]
fn the_same_layout_gives_the_same_bytes() {
    let bytes = || crate::assets::glb_from_model(&build(ROOM).expect("composes")).expect("writes");
    assert_eq!(bytes(), bytes());
}

#[test]
fn mistakes_in_a_layout_are_named_with_their_remedy() {
    assert!(problem("(name: \"x\",\n outlin: 3)").starts_with("line 2, column"));
    assert!(problem(&ROOM.replace("\"lighting\"", "\"lantern\"")).contains("'lantern'"));
    assert!(
        problem(&ROOM.replace("Some(\"Desk\")", "Some(\"Shelf\")")).contains("'Shelf', which isn't placed")
    );
    assert!(
        problem(&ROOM.replace("name: \"Lamp\"", "name: \"Desk\"")).contains("two objects are called 'Desk'")
    );
    assert!(problem(&ROOM.replace("(-1.6, 0.0, -1.0)", "(-1.9, 0.0, -1.0)")).contains("out of the room"));
    assert!(problem(&ROOM.replace("wall: 0", "wall: 4")).contains("numbered 0 to 3"));
    assert!(problem(&ROOM.replace("width_m: 1.6", "width_m: 4.6")).contains("doesn't fit into wall 0"));
    assert!(problem(&ROOM.replace("height_m: 2.5", "height_m: -1.0")).contains("the room's height is -1 m"));
    assert!(
        problem(&ROOM.replace("Box(4.0, 3.0)", "Polygon([(0, 0), (0, 3), (4, 3)])")).contains("clockwise")
    );
    assert!(
        problem(&ROOM.replace("Laptop,", "Model(\"sofa.glb\"),")).contains("'sofa.glb' of 'Laptop': no file")
    );
}
