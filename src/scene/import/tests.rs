use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec3};

use super::*;
use crate::assets::{Material, Mesh, Part};
use crate::math::Aabb;
use crate::scene::Category;

/// A closed box as a mesh, wound outwards.
fn solid(low: Vec3, high: Vec3) -> Mesh {
    let positions = (0..8).map(|i| {
        let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { low[axis] } else { high[axis] };
        Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions: positions.collect(), triangles, ..Mesh::default() }
}

fn joined(meshes: &[Mesh]) -> Mesh {
    let mut all = Mesh::default();
    for mesh in meshes {
        let first = all.positions.len() as u32;
        all.positions.extend(&mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

fn block(x: f32, y: f32, z: f32, width: f32, height: f32, depth: f32) -> Mesh {
    let half = Vec3::new(width, 0.0, depth) * 0.5;
    solid(Vec3::new(x, y, z) - half, Vec3::new(x, y + height, z) + half)
}

/// A top on four legs.
fn table(x: f32, z: f32) -> Vec<Mesh> {
    let leg = |dx: f32, dz: f32| block(x + dx, 0.0, z + dz, 0.06, 0.71, 0.06);
    let top = block(x, 0.71, z, 1.6, 0.04, 0.9);
    vec![top, leg(-0.75, -0.4), leg(0.75, -0.4), leg(-0.75, 0.4), leg(0.75, 0.4)]
}

/// A seat with legs and a back.
fn chair(x: f32, z: f32) -> Vec<Mesh> {
    let leg = |dx: f32, dz: f32| block(x + dx, 0.0, z + dz, 0.04, 0.42, 0.04);
    let seat = block(x, 0.42, z, 0.45, 0.04, 0.45);
    let back = block(x, 0.43, z + 0.2, 0.45, 0.45, 0.04);
    vec![seat, back, leg(-0.2, -0.2), leg(0.2, -0.2), leg(-0.2, 0.18), leg(0.2, 0.18)]
}

/// Floor and walls of 5 x 4 m, `ceiling` or not, as thin slabs.
fn shell(ceiling: bool) -> Vec<(&'static str, Mesh)> {
    let mut parts = vec![
        ("Cube", block(0.0, -0.1, 0.0, 5.2, 0.1, 4.2)),
        ("Cube.001", block(-2.55, 0.0, 0.0, 0.1, 2.6, 4.0)),
        ("Cube.002", block(2.55, 0.0, 0.0, 0.1, 2.6, 4.0)),
        ("Cube.003", block(0.0, 0.0, -2.05, 5.2, 2.6, 0.1)),
        ("Cube.004", block(0.0, 0.0, 2.05, 5.2, 2.6, 0.1)),
    ];
    if ceiling {
        parts.push(("Cube.005", block(0.0, 2.6, 0.0, 5.2, 0.1, 4.2)));
    }
    parts
}

/// A model of one node for each named mesh.
fn model(name: &str, parts: Vec<(&str, Mesh)>) -> Model {
    let part = |(node, (name, mesh)): (usize, (&str, Mesh))| Part {
        name: name.to_string(),
        node,
        path: Vec::new(),
        mesh: Arc::new(mesh),
        material: 0,
        file_from_mesh: Affine3A::IDENTITY,
        extras: None,
    };
    let parts = parts.into_iter().enumerate().map(part).collect();
    Model { name: name.to_string(), parts, materials: vec![Material::default()], ..Model::default() }
}

/// A furnished room without telling names, metres, Y up.
fn furnished(file: &str, ceiling: bool) -> Model {
    let mut parts = shell(ceiling);
    parts.push(("Mesh1", joined(&table(-1.0, 0.5))));
    parts.push(("Mesh2", joined(&chair(-1.0, 1.4))));
    parts.push(("Mesh3", block(1.6, 0.0, -1.4, 1.8, 0.45, 0.9)));
    parts.push(("Mesh4", block(1.6, 0.1, -1.9, 1.8, 0.75, 0.1)));
    model(file, parts)
}

/// `model` as another program would have written it.
fn written_as(mut model: Model, up: UpAxis, unit_m: f32, moved: Vec3) -> Model {
    let file_from_upright = up.upright_from_file().transpose() * (1.0 / unit_m);
    let change = Affine3A::from_mat3_translation(file_from_upright, file_from_upright * moved);
    for part in &mut model.parts {
        part.file_from_mesh = change * part.file_from_mesh;
    }
    model
}

fn found(model: &Model) -> Imported {
    room_from_model(model, &ImportOptions::default())
}

fn object(imported: &Imported, category: Category) -> Vec<&super::super::Object> {
    imported.room.objects.iter().filter(|o| o.category == category).collect()
}

#[test]
fn a_room_comes_in_upright_in_metres_with_its_floor_at_zero_whatever_program_wrote_it() {
    let ways = [
        ("room.glb", UpAxis::Y, 1.0),
        ("room.obj", UpAxis::Y, 0.01),
        ("room.obj", UpAxis::Z, 1.0),
        ("room.ply", UpAxis::Z, 0.001),
        ("room.obj", UpAxis::Z, 0.0254),
        ("room.obj", UpAxis::Y, 0.0254),
        ("room.glb", UpAxis::Y, 0.01),
        ("scan.ply", UpAxis::NegY, 1.0),
    ];
    for ceiling in [true, false] {
        for (file, up, unit_m) in ways {
            let model = written_as(furnished(file, ceiling), up, unit_m, Vec3::new(7.0, -1.42, 3.0));
            let imported = found(&model);
            let report = &imported.report;
            let what = format!("{file} {up:?} {unit_m} {ceiling}: {report:#?}");
            assert_eq!(report.up, up, "{what}");
            assert!((report.unit_scale / unit_m - 1.0).abs() < 1e-3, "{what}");
            let bounds = imported.room.bounds();
            assert!((bounds.min.y + 0.1).abs() < 0.01, "floor at {}: {what}", bounds.min.y + 0.1);
            assert!((bounds.center() * Vec3::new(1.0, 0.0, 1.0)).length() < 0.01, "{what}");
            assert!((bounds.size().x - 5.2).abs() < 0.01 && !report.evidence.is_empty(), "{what}");
        }
    }
}

#[test]
fn names_of_floor_and_ceiling_outweigh_what_gltf_says_about_up() {
    let mut room = furnished("room.glb", true);
    room.parts[0].name = "Floor".to_string();
    room.parts[5].name = "Ceiling".to_string();
    let report = found(&written_as(room, UpAxis::Z, 1.0, Vec3::ZERO)).report;
    assert_eq!(report.up, UpAxis::Z, "{:#?}", report.evidence);
}

#[test]
fn a_room_in_no_unit_at_all_is_brought_to_a_plausible_height() {
    for factor in [3.1, 0.05, 40.0] {
        let imported = found(&written_as(furnished("room.obj", true), UpAxis::Y, 1.0 / factor, Vec3::ZERO));
        let height = imported.report.extent_m[1];
        assert!((2.1..3.4).contains(&height), "factor {factor}: {height} m, {:#?}", imported.report.evidence);
    }
}

#[test]
fn what_is_plausible_in_metres_is_left_alone() {
    let stretched = |factor: f32| {
        let mut model = furnished("room.glb", true);
        for part in &mut model.parts {
            part.file_from_mesh = Affine3A::from_mat3(Mat3::from_diagonal(Vec3::new(1.0, factor, 1.0)));
        }
        model
    };
    for factor in [0.85, 1.0, 1.2, 1.6] {
        assert_eq!(found(&stretched(factor)).report.unit_scale, 1.0, "{} m high", factor * 2.6);
    }
    let sofa = model("sofa.glb", vec![("sofa", block(0.0, 0.0, 0.0, 2.0, 0.8, 0.9))]);
    assert_eq!(found(&sofa).report.unit_scale, 1.0);
}

#[test]
fn the_user_knows_better_than_the_file() {
    let options = ImportOptions { unit_scale: Some(0.5), up: Some(UpAxis::Z) };
    let report = room_from_model(&furnished("room.glb", true), &options).report;
    assert_eq!((report.unit_scale, report.up), (0.5, UpAxis::Z));
    assert!(report.evidence.iter().filter(|e| e.contains("you said so")).count() == 2);
}

#[test]
fn a_nameless_room_is_understood_by_its_shapes() {
    let imported = found(&furnished("room.glb", true));
    assert_eq!(object(&imported, Category::Floor).len(), 1);
    assert_eq!(object(&imported, Category::Ceiling).len(), 1);
    assert_eq!(object(&imported, Category::Wall).len(), 4);
    assert_eq!(object(&imported, Category::Chair).len(), 1);
    assert_eq!(object(&imported, Category::DiningTable).len(), 1);
    let sofas = object(&imported, Category::Sofa);
    assert_eq!(sofas.len(), 1, "{:?}", imported.report.categories);
    assert_eq!(sofas[0].parts.len(), 2, "the back belongs to the seat");
    assert!(imported.room.objects.iter().zip(0..).all(|(o, i)| o.id.0 == i));
}

#[test]
fn a_merged_room_is_taken_apart_into_its_furniture_and_no_triangle_is_lost() {
    // One mesh for each of two materials: everything of wood, everything of the building.
    let wood: Vec<Mesh> = [table(-1.0, 0.5), chair(-1.0, 1.3), chair(-1.0, -0.3), chair(1.5, 1.0)]
        .into_iter()
        .flatten()
        .collect();
    let building: Vec<Mesh> = shell(true).into_iter().map(|(_, mesh)| mesh).collect();
    let merged = model("merged.glb", vec![("Wood", joined(&wood)), ("Plaster", joined(&building))]);
    let imported = found(&merged);
    assert_eq!(object(&imported, Category::Chair).len(), 3, "{:#?}", imported.report.categories);
    assert_eq!(object(&imported, Category::DiningTable).len(), 1, "{:#?}", imported.report.categories);
    assert_eq!(imported.room.triangle_count(), merged.triangle_count());
}

#[test]
fn what_stands_on_a_table_or_under_it_is_no_part_of_it() {
    let mut parts = shell(true);
    parts.push(("A", joined(&table(0.0, 0.0))));
    // Pushed under the table up to its back.
    parts.push(("B", joined(&chair(0.0, 0.4))));
    parts.push(("C", block(0.3, 0.75, 0.0, 0.2, 0.02, 0.2)));
    let imported = found(&model("room.glb", parts));
    assert_eq!(object(&imported, Category::Chair).len(), 1);
    assert_eq!(object(&imported, Category::DiningTable)[0].parts.len(), 1);
    assert_eq!(object(&imported, Category::Objects).len(), 1);
}

#[test]
fn extras_say_what_a_thing_is_before_its_name_does() {
    let mut room = furnished("room.glb", true);
    let last = room.parts.len() - 3;
    room.parts[last].name = "table".to_string();
    room.parts[last].extras = Some("{\"category\": \"stool\"}".to_string());
    assert_eq!(object(&found(&room), Category::Stool).len(), 1);
}

#[test]
fn parts_below_a_node_that_names_furniture_are_one_object() {
    let mut room = model("room.glb", shell(true));
    for (node, (name, mesh)) in [
        ("frame", block(0.0, 0.0, 0.0, 2.0, 0.3, 0.9)),
        ("pillow_a", block(-0.5, 0.5, 0.0, 0.5, 0.1, 0.5)),
        ("pillow_b", block(0.5, 0.5, 0.0, 0.5, 0.1, 0.5)),
    ]
    .into_iter()
    .enumerate()
    {
        let path = vec!["Living Room".to_string(), "Sofa".to_string()];
        let part = model("", vec![(name, mesh)]).parts.remove(0);
        room.parts.push(Part { node: 100 + node, path, ..part });
    }
    let imported = found(&room);
    let sofas = object(&imported, Category::Sofa);
    assert_eq!(sofas.len(), 1, "{:?}", imported.report.categories);
    assert_eq!(sofas[0].parts.len(), 3);
}

#[test]
fn an_object_stands_where_it_stood_in_the_file() {
    let imported = found(&written_as(furnished("room.obj", true), UpAxis::Z, 0.01, Vec3::new(3.0, 1.0, 2.0)));
    let chair = object(&imported, Category::Chair)[0].world_bounds();
    let expected = Aabb { min: Vec3::new(-1.225, 0.0, 1.175), max: Vec3::new(-0.775, 0.88, 1.625) };
    assert!(chair.min.distance(expected.min) < 0.01 && chair.max.distance(expected.max) < 0.01, "{chair:?}");
}
