//! Files as other programs write them come in with the same geometry, names, looks and places.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use inhabit::assets::{AlphaMode, Budget, Model, read_model, read_model_bytes};
use serde_json::{Value, json};

fn bytes_of<T: Copy, const N: usize>(values: &[T], to_bytes: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|v| to_bytes(*v)).collect()
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits = |three: &[u8]| {
        let bits = three.iter().fold(0u32, |all, b| (all << 8) | u32::from(*b)) << (8 * (3 - three.len()));
        let text = (0..4).map(|i| char::from(DIGITS[(bits >> (18 - 6 * i)) as usize & 63]));
        text.take(three.len() + 1).collect::<String>()
    };
    bytes.chunks(3).map(digits).collect()
}

/// A glTF document whose one buffer is `bytes`, each view a range of it, each accessor one view.
fn gltf(bytes: &[u8], views: &[(usize, usize)], accessors: Value, rest: Value) -> Value {
    let views: Vec<Value> = views
        .iter()
        .map(|(from, to)| json!({ "buffer": 0, "byteOffset": from, "byteLength": to - from }))
        .collect();
    let uri = format!("data:application/octet-stream;base64,{}", base64(bytes));
    let mut document = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": bytes.len(), "uri": uri }],
        "bufferViews": views,
        "accessors": accessors
    });
    document.as_object_mut().unwrap().extend(rest.as_object().unwrap().clone());
    document
}

fn read(name: &str, bytes: impl AsRef<[u8]>) -> Model {
    read_model_bytes(name, bytes.as_ref(), &Budget::default()).unwrap_or_else(|error| panic!("{error}"))
}

const SQUARE: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, -1.0];

/// Twice the area vector of all triangles, in the file's frame.
fn area_vector(model: &Model) -> Vec3 {
    let of_part = |part: &inhabit::assets::Part| -> Vec3 {
        let corners = |t| part.mesh.corners(t).map(|p| part.file_from_mesh.transform_point3(p));
        (0..part.mesh.triangles.len()).map(corners).map(|[a, b, c]| (b - a).cross(c - a)).sum()
    };
    model.parts.iter().map(of_part).sum()
}

#[test]
fn lists_strips_fans_and_every_width_of_index_give_the_same_square() {
    let widths: [(u32, fn(u32) -> Vec<u8>); 3] = [
        (5121, |i| vec![i as u8]),
        (5123, |i| (i as u16).to_le_bytes().into()),
        (5125, |i| i.to_le_bytes().into()),
    ];
    let modes: [(u32, &[u32]); 3] = [(4, &[0, 1, 2, 0, 2, 3]), (5, &[0, 1, 3, 2]), (6, &[0, 1, 2, 3])];
    for (component, encode) in widths {
        for (mode, corners) in modes {
            let mut bytes = bytes_of(&SQUARE, f32::to_le_bytes);
            let start = bytes.len();
            bytes.extend(corners.iter().flat_map(|i| encode(*i)));
            let document = gltf(
                &bytes,
                &[(0, start), (start, bytes.len())],
                json!([
                    { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
                    { "bufferView": 1, "componentType": component, "count": corners.len(), "type": "SCALAR" }
                ]),
                json!({
                    "nodes": [{ "mesh": 0 }],
                    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "mode": mode }] }]
                }),
            );
            let model = read("square.gltf", document.to_string());
            assert_eq!(model.triangle_count(), 2);
            assert!(area_vector(&model).distance(Vec3::Y * 2.0) < 1e-6, "mode {mode}, component {component}");
            assert!(model.parts[0].mesh.normals.iter().all(|n| n.distance(Vec3::Y) < 1e-6));
        }
    }
}

/// A hierarchy: "house" (scaled by two, mirrored in x) holds "room", which holds two nodes with one mesh.
fn house() -> Value {
    let bytes = bytes_of(&SQUARE[..9], f32::to_le_bytes);
    gltf(
        &bytes,
        &[(0, bytes.len())],
        json!([{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }]),
        json!({
            "scene": 1,
            "scenes": [{ "nodes": [] }, { "nodes": [3], "name": "shown" }],
            "nodes": [
                { "name": "chair", "mesh": 0, "translation": [1, 0, 0], "extras": { "category": "stool", "price": 7 } },
                { "name": "chair.001", "mesh": 0, "rotation": [0, 1, 0, 0] },
                { "name": "room", "children": [0, 1], "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1] },
                { "name": "house", "children": [2], "scale": [-2, 2, 2] }
            ],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
            "materials": [{
                "name": "oak", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.3,
                "emissiveFactor": [0, 0.5, 0],
                "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 0.125, 1], "metallicFactor": 0, "roughnessFactor": 0.4 }
            }]
        }),
    )
}

#[test]
fn nodes_stand_where_their_ancestors_put_them_and_share_one_mesh() {
    let model = read("house.gltf", house().to_string());
    let names: Vec<_> = model.parts.iter().map(|p| (p.name.as_str(), p.path.join("/"))).collect();
    assert_eq!(names, [("chair", "house/room".to_string()), ("chair.001", "house/room".to_string())]);
    assert!(Arc::ptr_eq(&model.parts[0].mesh, &model.parts[1].mesh));
    let at = |part: usize, p: Vec3| model.parts[part].file_from_mesh.transform_point3(p);
    assert!(at(0, Vec3::ZERO).distance(Vec3::new(-2.0, 0.0, 10.0)) < 1e-5);
    assert!(at(0, Vec3::X).distance(Vec3::new(-4.0, 0.0, 10.0)) < 1e-5);
    assert!(at(1, Vec3::X).distance(Vec3::new(2.0, 0.0, 10.0)) < 1e-5);
    assert!(model.notes.iter().any(|n| n.contains("shown")), "{:?}", model.notes);
    let extras: Value = serde_json::from_str(model.parts[0].extras.as_ref().unwrap()).unwrap();
    assert_eq!(extras, json!({ "category": "stool", "price": 7 }));
}

#[test]
fn looks_are_kept() {
    let model = read("house.gltf", house().to_string());
    let oak = &model.materials[model.parts[0].material];
    assert_eq!((oak.name.as_str(), oak.base_color, oak.double_sided), ("oak", [0.5, 0.25, 0.125, 1.0], true));
    assert_eq!((oak.alpha, oak.emissive, oak.roughness), (AlphaMode::Mask(0.3), [0.0, 0.5, 0.0], 0.4));
}

#[test]
fn quantised_sparse_and_strided_vertices_are_decoded() {
    // Two 16-bit positions, normalised, 8 bytes apart; the third comes from the sparse part.
    let mut bytes = bytes_of(&[0i16, 0, 0, 99, 32767, 0, 0, 99, 0, 0, 0, 99], i16::to_le_bytes);
    bytes.extend(bytes_of(&[2u16, 0], u16::to_le_bytes));
    bytes.extend(bytes_of(&[0i16, 0, -32767, 0], i16::to_le_bytes));
    let mut document = gltf(
        &bytes,
        &[(0, 24), (24, 28), (28, 36)],
        json!([{
            "bufferView": 0, "componentType": 5122, "normalized": true, "count": 3, "type": "VEC3",
            "sparse": { "count": 1, "indices": { "bufferView": 1, "componentType": 5123 }, "values": { "bufferView": 2 } }
        }]),
        json!({
            "extensionsRequired": ["KHR_mesh_quantization"],
            "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }]
        }),
    );
    document["bufferViews"][0]["byteStride"] = json!(8);
    let model = read("small.gltf", document.to_string());
    assert_eq!(model.parts[0].mesh.corners(0), [Vec3::ZERO, Vec3::X, Vec3::NEG_Z]);
}

#[test]
fn buffers_and_pictures_beside_the_file_are_found_under_escaped_names() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("my parts")).unwrap();
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    put("my parts/a.bin", &bytes_of(&SQUARE[..9], f32::to_le_bytes));
    let mut png = std::io::Cursor::new(Vec::new());
    let red = image::RgbImage::from_pixel(2, 3, image::Rgb([255, 0, 0]));
    red.write_to(&mut png, image::ImageFormat::Png).unwrap();
    put("red.png", png.get_ref());
    let mut document = house();
    document["buffers"][0]["uri"] = json!("my%20parts/a.bin");
    document["images"] = json!([{ "uri": "./red.png", "name": "red" }]);
    document["textures"] = json!([{ "source": 0 }]);
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    put("room.gltf", document.to_string().as_bytes());
    let model = read_model(&folder.path().join("room.gltf"), &Budget::default()).unwrap();
    assert_eq!((model.textures[0].width, model.textures[0].height), (2, 3));
    assert_eq!(model.textures[0].rgba[..4], [255, 0, 0, 255]);
    assert_eq!(model.materials[0].base_color_texture, Some(0));
    assert_eq!(model.name, "room.gltf");
}

#[test]
fn an_obj_keeps_its_groups_materials_and_polygons() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    put("my room.mtl", "newmtl oak\nKd 0.5 0.25 0.125\nd 0.5\nmap_Kd -s 1 1 1 gone.png\n");
    put(
        "room.obj",
        "mtllib my room.mtl\r\nv 0 0 0\r\nv 2 0 0\r\nv 2 0 -2\r\nv 1 0 -1\r\nv 0 0 -2\r\nvt 0.25 1\r\n\
         g table top\r\nusemtl oak\r\nf 1/1 2/1 3/1 4/1 5/1\r\n\
         g chair\r\nusemtl not defined\r\nf -5 -4 \\\r\n-3\r\nusemtl oak\r\nf 1 2 4\r\n",
    );
    let model = read_model(&folder.path().join("room.obj"), &Budget::default()).unwrap();
    let parts: Vec<_> =
        model.parts.iter().map(|p| (p.name.as_str(), p.node, p.mesh.triangles.len())).collect();
    assert_eq!(parts, [("table top", 0, 3), ("chair", 1, 1), ("chair", 1, 1)]);
    let material = |part: usize| &model.materials[model.parts[part].material];
    assert_eq!((material(0).base_color, material(0).alpha), ([0.5, 0.25, 0.125, 0.5], AlphaMode::Blend));
    assert_eq!((material(1).name.as_str(), material(2).name.as_str()), ("not defined", "oak"));
    assert_eq!(model.parts[0].mesh.uvs[0], Vec2::new(0.25, 0.0));
    // The five-cornered table top has a notch: 3 of the 4 square metres.
    let table = Model { parts: model.parts[..1].to_vec(), ..Model::default() };
    assert!(area_vector(&table).distance(Vec3::Y * 6.0) < 1e-5, "{}", area_vector(&table));
    let notes = model.notes.join("\n");
    assert!(notes.contains("gone.png") && notes.contains("1 materials"), "{notes}");
}

/// A coloured square as PLY: an unknown property, an unknown element, one face of four corners.
fn ply(format: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nelement vertex 4\nproperty double x\nproperty float y\n\
         property float z\nproperty short quality\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
         element camera 1\nproperty list uchar float view\nelement face 1\nproperty uchar flags\n\
         property list uchar uint vertex_indices\nend_header\n"
    );
    let mut body = Vec::new();
    let big = format == "binary_big_endian";
    let mut put = |text: String, little: &[u8]| match format {
        "ascii" => body.extend(format!("{text} ").bytes()),
        _ if big => body.extend(little.iter().rev()),
        _ => body.extend(little),
    };
    for corner in SQUARE.chunks(3) {
        put(corner[0].to_string(), &f64::from(corner[0]).to_le_bytes());
        put(corner[1].to_string(), &corner[1].to_le_bytes());
        put(corner[2].to_string(), &corner[2].to_le_bytes());
        put("-7".into(), &(-7i16).to_le_bytes());
        for channel in [200u8, 100, 50] {
            put(channel.to_string(), &[channel]);
        }
    }
    put("2".into(), &[2]);
    put("0.5".into(), &0.5f32.to_le_bytes());
    put("1.5".into(), &1.5f32.to_le_bytes());
    put("9".into(), &[9]);
    put("4".into(), &[4]);
    for corner in 0..4u32 {
        put(corner.to_string(), &corner.to_le_bytes());
    }
    [header.into_bytes(), body].concat()
}

#[test]
fn the_three_kinds_of_ply_give_the_same_mesh() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let model = read("square.ply", ply(format));
        assert_eq!(model.triangle_count(), 2, "{format}");
        assert!(area_vector(&model).distance(Vec3::Y * 2.0) < 1e-6, "{format}");
        assert!(model.parts[0].mesh.colors.iter().all(|c| *c == [200, 100, 50, 255]), "{format}");
    }
}

#[test]
fn a_file_with_an_unknown_name_is_known_by_its_first_bytes() {
    for (bytes, parts) in [
        (ply("ascii"), 1),
        (house().to_string().into(), 2),
        (b"v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n".to_vec(), 1),
    ] {
        assert_eq!(read("download", bytes).parts.len(), parts);
    }
}

#[test]
fn a_budget_is_kept() {
    let small = |change: fn(&mut Budget)| {
        let mut budget = Budget::default();
        change(&mut budget);
        read_model_bytes("square.ply", &ply("ascii"), &budget).unwrap_err().to_string()
    };
    assert!(small(|b| b.max_file_bytes = 100).contains("bytes"));
    assert!(small(|b| b.max_vertices = 3).contains("4 vertices"));
    assert!(small(|b| b.max_triangles = 1).contains("2 triangles"));
}
