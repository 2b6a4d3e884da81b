//! Files that are broken, lie or attack. Each must end in an error that names the file and the place in it,
//! or in a model with a note; never in a panic, never slowly, never with much memory.

use std::path::Path;
use std::time::{Duration, Instant};

use inhabit::assets::{Budget, Model, read_model, read_model_bytes};
use serde_json::{Value, json};

/// How long any of these files may take.
const PATIENCE: Duration = Duration::from_secs(2);

/// A file and words that its error (or note) must hold: the place, and what is wrong.
struct Case {
    file: String,
    bytes: Vec<u8>,
    says: Vec<&'static str>,
}

fn case(file: impl Into<String>, bytes: impl Into<Vec<u8>>, says: &[&'static str]) -> Case {
    Case { file: file.into(), bytes: bytes.into(), says: says.to_vec() }
}

/// A document with one triangle: accessor 0 positions, 1 indices (u16).
fn document() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "thing", "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 6 }
        ],
        "buffers": [{ "byteLength": 44 }]
    })
}

fn triangle_bytes() -> Vec<u8> {
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let mut bytes: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2, 0].iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

fn glb(document: &Value, bin: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let word = |bytes: &mut Vec<u8>, n: usize| bytes.extend((n as u32).to_le_bytes());
    word(&mut bytes, 2);
    word(&mut bytes, 12 + 8 + json.len() + 8 + bin.len());
    word(&mut bytes, json.len());
    bytes.extend(b"JSON");
    bytes.extend(&json);
    word(&mut bytes, bin.len());
    bytes.extend(b"BIN\0");
    bytes.extend(bin);
    bytes
}

/// The triangle with one value of its document changed (JSON pointer; a missing key is added).
fn changed(pointer: &str, value: Value) -> Vec<u8> {
    let mut document = document();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Object(map) => drop(map.insert(key.to_string(), value)),
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        other => panic!("{other}"),
    }
    glb(&document, &triangle_bytes())
}

/// Nodes under one another, the last one with the mesh.
fn chain(length: usize) -> Value {
    let mut document = document();
    let nodes = (0..length)
        .map(|i| if i + 1 < length { json!({ "children": [i + 1] }) } else { json!({ "mesh": 0 }) });
    document["nodes"] = nodes.collect();
    document
}

fn broken_containers() -> Vec<Case> {
    let whole = glb(&document(), &triangle_bytes());
    let cuts = [
        1,
        3,
        5,
        9,
        11,
        12,
        15,
        19,
        20,
        40,
        200,
        whole.len() - 50,
        whole.len() - 44,
        whole.len() - 9,
        whole.len() - 1,
    ];
    let mut cases: Vec<Case> =
        cuts.iter().map(|&cut| case(format!("cut_at_{cut}.glb"), &whole[..cut], &[])).collect();
    let patched = |at: usize, word: u32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        bytes
    };
    cases.push(case("nothing.glb", [], &["byte 0", "empty"]));
    cases.push(case("nothing.gltf", [], &["empty"]));
    cases.push(case("nothing.obj", [], &["empty"]));
    cases.push(case("nothing.ply", [], &["empty"]));
    cases.push(case("magic.glb", patched(0, 7), &["JSON line"]));
    cases.push(case("version.glb", patched(4, 1), &["byte 4", "version 1", "Blender"]));
    cases.push(case("length.glb", patched(8, u32::MAX), &["byte 8", "bytes are needed"]));
    cases.push(case("chunk_length.glb", patched(12, u32::MAX - 3), &["byte 12"]));
    cases.push(case("chunk_kind.glb", patched(16, 0), &["no JSON chunk"]));
    cases.push(case("no_json.gltf", "{\"asset\": ", &["JSON line 1"]));
    cases.push(case("nan.gltf", "{\"asset\": {\"version\": NaN}}", &["JSON line 1"]));
    cases.push(case("deep_json.gltf", "[".repeat(1_000_000), &["JSON line 1"]));
    cases.push(case("bytes.gltf", vec![0xff; 1000], &["JSON line 1"]));
    cases.push(case("unknown.fbx", "Kaydara FBX Binary", &[".fbx", "GLB"]));
    cases
}

fn wrong_numbers() -> Vec<Case> {
    let accessor = |key: &str, value: Value| changed(&format!("/accessors/0/{key}"), value);
    let view = |key: &str, value: Value| changed(&format!("/bufferViews/0/{key}"), value);
    let primitive = |key: &str, value: Value| changed(&format!("/meshes/0/primitives/0/{key}"), value);
    vec![
        case("version_3.glb", changed("/asset/version", json!("3.0")), &["asset.version"]),
        case("version_1.glb", changed("/asset/version", json!("1.0")), &["asset.version", "glTF 1.0"]),
        case("count_absurd.glb", accessor("count", json!(4_000_000_000_u64)), &["accessors[0]", "limit"]),
        case("count_long.glb", accessor("count", json!(1_000_000)), &["accessors[0]", "bytes are needed"]),
        case("count_max.glb", accessor("count", json!(u64::MAX)), &["accessors[0]"]),
        case("count_negative.glb", accessor("count", json!(-1)), &["JSON line"]),
        case(
            "offset_max.glb",
            accessor("byteOffset", json!(u64::MAX)),
            &["accessors[0]", "bytes are needed"],
        ),
        case("component.glb", accessor("componentType", json!(5130)), &["accessors[0]", "5130"]),
        case("kind.glb", accessor("type", json!("MAT4")), &["accessors[0]", "MAT4", "VEC3"]),
        case("view_of_accessor.glb", accessor("bufferView", json!(9)), &["bufferViews", "buffer view 9"]),
        case("no_bytes.glb", accessor("bufferView", json!(null)), &["accessors[0]", "no bytes"]),
        case(
            "view_length.glb",
            view("byteLength", json!(4_000_000_000_u64)),
            &["bufferViews[0]", "bytes are needed"],
        ),
        case("view_overflow.glb", view("byteOffset", json!(u64::MAX - 3)), &["bufferViews[0]"]),
        case("view_buffer.glb", view("buffer", json!(5)), &["bufferViews[0]", "buffer 5"]),
        case("view_stride.glb", view("byteStride", json!(1_000_000)), &["bufferViews[0]", "stride"]),
        case("buffer_length.glb", changed("/buffers/0/byteLength", json!(1_000_000)), &["buffers[0]"]),
        case("index_float.glb", changed("/accessors/1/componentType", json!(5126)), &["accessors[1]"]),
        case("index_vec3.glb", changed("/accessors/1/type", json!("VEC3")), &["accessors[1]", "SCALAR"]),
        case("index_accessor.glb", primitive("indices", json!(77)), &["primitives[0]", "accessor 77"]),
        case("no_position.glb", primitive("attributes", json!({})), &["primitives[0]", "POSITION"]),
        case("mode.glb", primitive("mode", json!(12)), &["primitives[0]", "mode 12"]),
        case("material.glb", primitive("material", json!(0)), &["primitives[0]", "material 0"]),
        case("mesh.glb", changed("/nodes/0/mesh", json!(3)), &["nodes[0]", "mesh 3"]),
        case("scene.glb", changed("/scene", json!(4)), &["scene 4"]),
        case("scene_node.glb", changed("/scenes/0/nodes", json!([8])), &["scenes[0]", "node 8"]),
        case("child.glb", changed("/nodes/0/children", json!([8])), &["nodes[0].children", "node 8"]),
        case("no_meshes.glb", changed("/nodes", json!([{}])), &["no triangles"]),
        case("only_points.glb", primitive("mode", json!(0)), &["no triangles"]),
        case(
            "place_infinite.glb",
            changed("/nodes/0/translation", json!([1e300, 0.0, 0.0])),
            &["nodes[0]", "finite"],
        ),
        case(
            "colour_count.glb",
            primitive("attributes", json!({ "POSITION": 0, "COLOR_0": 1 })),
            &["accessors[1]"],
        ),
    ]
}

fn hostile_structures() -> Vec<Case> {
    let node = |value: Value| changed("/nodes", value);
    let sparse = |count: u64, index_view: u64, offset: u64| {
        let indices = json!({ "bufferView": index_view, "componentType": 5123, "byteOffset": offset });
        let sparse = json!({ "count": count, "indices": indices, "values": { "bufferView": 0 } });
        changed("/accessors/0/sparse", sparse)
    };
    let mut bad_index = triangle_bytes();
    bad_index[38] = 200;
    let mut all_nan = triangle_bytes();
    all_nan[..36].copy_from_slice(&f32::NAN.to_le_bytes().repeat(9));
    let mut draco = document();
    draco["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_draco_mesh_compression": { "bufferView": 0 } });
    draco["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let meshopt = json!({ "EXT_meshopt_compression": { "buffer": 0, "count": 3 } });
    vec![
        case("itself.glb", node(json!([{ "mesh": 0, "children": [0] }])), &["nodes[0]", "cycle"]),
        case(
            "cycle.glb",
            node(json!([{ "children": [1] }, { "children": [2] }, { "children": [0] }])),
            &["cycle"],
        ),
        case(
            "hidden_cycle.glb",
            node(json!([{ "mesh": 0 }, { "children": [2] }, { "children": [1] }])),
            &["cycle"],
        ),
        case("deep.glb", glb(&chain(5_000), &triangle_bytes()), &["nodes[", "above one another"]),
        case("very_deep.glb", glb(&chain(150_000), &triangle_bytes()), &["nodes[", "above one another"]),
        case("many_nodes.glb", node(vec![json!({}); 300_000].into()), &["nodes", "300000"]),
        case("index_range.glb", glb(&document(), &bad_index), &["accessors[1]", "element 1", "vertex 200"]),
        case("all_nan.glb", glb(&document(), &all_nan), &["no triangles"]),
        case("sparse_count.glb", sparse(1_000, 1, 0), &["accessors[0]", "sparse"]),
        case("sparse_view.glb", sparse(1, 7, 0), &["buffer view 7"]),
        case("sparse_offset.glb", sparse(1, 1, 1_000), &["accessors[0]", "sparse"]),
        case("sparse_falling.glb", sparse(2, 0, 0), &["accessors[0]", "sparse"]),
        case("draco.glb", glb(&draco, &triangle_bytes()), &["primitives[0]", "Draco", "Blender"]),
        case("meshopt.glb", changed("/bufferViews/0/extensions", meshopt), &["bufferViews[0]", "meshopt"]),
        case(
            "required.glb",
            changed("/extensionsRequired", json!(["X_new"])),
            &["extensionsRequired", "X_new"],
        ),
    ]
}

fn references_that_lead_away() -> Vec<Case> {
    let buffer = |uri: &str| changed("/buffers/0/uri", json!(uri));
    let image = |uri: &str| {
        let mut document = document();
        document["images"] = json!([{ "uri": uri }]);
        document["textures"] = json!([{ "source": 0 }]);
        document["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        glb(&document, &triangle_bytes())
    };
    let outside: &[&str] = &["buffers[0]", "outside"];
    vec![
        case("up.glb", buffer("../secret.bin"), outside),
        case("up_inside.glb", buffer("a/../../secret.bin"), outside),
        case("up_escaped.glb", buffer("%2e%2e/secret.bin"), outside),
        case("up_backslash.glb", buffer("..\\secret.bin"), outside),
        case("absolute.glb", buffer("/etc/passwd"), outside),
        case("drive.glb", buffer("C:\\secret.bin"), outside),
        case("share.glb", buffer("\\\\server\\secret.bin"), outside),
        case("file_uri.glb", buffer("file:///etc/passwd"), outside),
        case("http.glb", buffer("http://example.org/a.bin"), outside),
        case("https_image.glb", image("https://example.org/a.png"), &["images[0]", "outside"]),
        case("up_image.glb", image("../a.png"), &["images[0]", "outside"]),
        case("missing.glb", buffer("missing.bin"), &["buffers[0] (missing.bin)", "can't be read"]),
        case("folder.glb", buffer("."), &["buffers[0]"]),
        case(
            "data_garbage.glb",
            buffer("data:application/octet-stream;base64,!!!!"),
            &["buffers[0]", "base64"],
        ),
        case("data_plain.glb", buffer("data:text/plain,hello"), &["buffers[0]", "base64"]),
        case("data_no_comma.glb", buffer("data:application/octet-stream;base64"), &["buffers[0]", "base64"]),
        case(
            "data_short.glb",
            buffer("data:application/octet-stream;base64,AAAA"),
            &["buffers[0]", "bytes are needed"],
        ),
        case(
            "texture_index.glb",
            {
                changed(
                    "/materials",
                    json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 4 } } }]),
                )
            },
            &["materials[0]", "texture 4"],
        ),
    ]
}

fn ply(header: &str, body: &[u8]) -> Vec<u8> {
    [b"ply\n", header.as_bytes(), b"end_header\n", body].concat()
}

fn broken_ply() -> Vec<Case> {
    const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";
    const FACES: &str = "property list uchar int vertex_indices\n";
    let mesh = |format: &str, vertices: &str, faces: &str| {
        format!("format {format} 1.0\nelement vertex {vertices}\n{XYZ}element face {faces}\n{FACES}")
    };
    let ascii =
        |vertices: &str, faces: &str, body: &str| ply(&mesh("ascii", vertices, faces), body.as_bytes());
    let binary =
        |vertices: &str, faces: &str, body: &[u8]| ply(&mesh("binary_little_endian", vertices, faces), body);
    let corners = [0u8; 36];
    vec![
        case("no_header.ply", "plywood", &["header", "end_header"]),
        case("not_ply.ply", "hello", &["line 1"]),
        case("no_format.ply", ply("", b""), &["no format"]),
        case("format.ply", ply("format morse 1.0\n", b""), &["line 2", "morse"]),
        case("count_word.ply", ascii("many", "1", ""), &["line 3", "many"]),
        case("count_negative.ply", ascii("-3", "1", ""), &["line 3"]),
        case("vertices_lie.ply", ascii("1000000000000", "1", "0 0 0"), &["element vertex"]),
        case(
            "vertices_overflow.ply",
            binary("18446744073709551615", "1", &corners),
            &["element vertex", "needed"],
        ),
        case("cut.ply", binary("3", "1", &corners[..20]), &["element vertex", "needed"]),
        case("faces_lie.ply", binary("3", "4000000000", &corners), &["element face", "needed"]),
        case(
            "list_lies.ply",
            binary("3", "1", &[&corners[..], &[250, 0, 0, 0, 0]].concat()),
            &["byte", "needed"],
        ),
        case(
            "no_properties.ply",
            ply("format ascii 1.0\nelement vertex 9\n", b"0 0"),
            &["element vertex", "no properties"],
        ),
        case(
            "no_z.ply",
            ply("format ascii 1.0\nelement vertex 1\nproperty float x\n", b"0"),
            &["element vertex", "lacks"],
        ),
        case("kind.ply", ply("format ascii 1.0\nelement vertex 1\nproperty quark x\n", b"0"), &["line 4"]),
        case(
            "orphan.ply",
            ply("format ascii 1.0\nproperty float x\n", b""),
            &["line 3", "before any element"],
        ),
        case("word.ply", ascii("3", "1", "0 0 0 1 zero 0 0 0 1 3 0 1 2"), &["byte", "zero"]),
        case("index.ply", ascii("3", "1", "0 0 0 1 0 0 0 0 1 3 0 1 9"), &["face 0", "vertex 9"]),
        case("index_negative.ply", ascii("3", "1", "0 0 0 1 0 0 0 0 1 3 0 1 -1"), &["face 0"]),
        case("length_negative.ply", ascii("3", "1", "0 0 0 1 0 0 0 0 1 -3 0 1 2"), &["byte", "list"]),
        case("points.ply", ascii("3", "0", "0 0 0 1 0 0 0 0 1"), &["element face", "points"]),
        case("all_nan.ply", ascii("3", "1", "nan 0 0 1 nan 0 0 0 inf 3 0 1 2"), &["no triangles"]),
    ]
}

fn broken_obj() -> Vec<Case> {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 0 1\n";
    let obj = |rest: &str| format!("{vertices}{rest}\n");
    vec![
        case("index.obj", obj("f 1 2 9"), &["line 4", "vertex 9"]),
        case("index_zero.obj", obj("f 0 1 2"), &["line 4", "vertex"]),
        case("index_back.obj", obj("f -1 -2 -9"), &["line 4", "vertex 9"]),
        case("index_huge.obj", obj("f 1 2 99999999999999999999"), &["line 4", "not a corner"]),
        case("index_least.obj", obj("f 1 2 -9223372036854775808"), &["line 4"]),
        case("index_texture.obj", obj("f 1/7 2/7 3/7"), &["line 4", "texture coordinate 7"]),
        case("index_normal.obj", obj("f 1//7 2//7 3//7"), &["line 4", "normal 7"]),
        case("word.obj", obj("f one two three"), &["line 4", "\"one\""]),
        case("two_corners.obj", obj("f 1 2"), &["line 4", "three corners"]),
        case("no_vertex.obj", obj("f /1 /2 /3"), &["line 4", "no vertex"]),
        case("coordinate.obj", "v 0 zero 0\n", &["line 1", "zero"]),
        case("few_coordinates.obj", "v 0 0\n", &["line 1", "3 numbers"]),
        case("no_faces.obj", vertices, &["no triangles"]),
        case("bytes.obj", vec![0u8; 5000], &["no triangles"]),
        case("all_nan.obj", "v nan 0 0\nv 1 inf 0\nv 0 0 nan\nf 1 2 3\n", &["no triangles"]),
        case("long_word.obj", format!("f {}", "x".repeat(3_000_000)), &["line 1", "not a corner"]),
    ]
}

/// The reader's answer to a file in a folder of its own, within [`PATIENCE`].
fn answer(folder: &Path, case: &Case) -> Result<Model, String> {
    let path = folder.join(&case.file);
    std::fs::write(&path, &case.bytes).unwrap();
    let start = Instant::now();
    let answer = read_model(&path, &Budget::default());
    assert!(start.elapsed() < PATIENCE, "{} took {:?}", case.file, start.elapsed());
    let in_memory = read_model_bytes(&case.file, &case.bytes, &Budget::default());
    assert!(in_memory.is_err() || answer.is_ok(), "{}: memory and disk disagree", case.file);
    answer.map_err(|error| {
        assert!(!error.place.is_empty(), "{} names no place", case.file);
        error.to_string()
    })
}

#[test]
fn every_broken_file_is_refused_with_its_name_the_place_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("secret.bin"), triangle_bytes()).unwrap();
    let inner = folder.path().join("rooms");
    std::fs::create_dir(&inner).unwrap();
    let cases: Vec<Case> = [
        broken_containers(),
        wrong_numbers(),
        hostile_structures(),
        references_that_lead_away(),
        broken_ply(),
        broken_obj(),
    ]
    .into_iter()
    .flatten()
    .collect();
    assert!(cases.len() >= 100, "only {} files", cases.len());
    let mut wrong = Vec::new();
    for case in &cases {
        match answer(&inner, case) {
            Ok(model) => wrong.push(format!("{} was read: {:?}", case.file, model.notes)),
            Err(text) => {
                let missing =
                    case.says.iter().copied().chain([case.file.as_str()]).find(|words| !text.contains(words));
                wrong
                    .extend(missing.map(|words| format!("{}: \"{words}\" is missing in: {text}", case.file)));
                if text.len() > 1000 {
                    wrong.push(format!("{}: more than a paragraph", case.file));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), cases.len(), wrong.join("\n"));
}

/// A PNG that says it is `side` x `side` and holds nothing.
fn absurd_png(side: u32) -> Vec<u8> {
    let mut head = side.to_be_bytes().repeat(2);
    head.extend([8, 6, 0, 0, 0]);
    [
        b"\x89PNG\r\n\x1a\n".to_vec(),
        png_chunk(b"IHDR", &head),
        png_chunk(b"IDAT", &[]),
        png_chunk(b"IEND", &[]),
    ]
    .concat()
}

fn png_chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [kind, data].concat();
    let crc = body.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 })
    });
    [&(data.len() as u32).to_be_bytes()[..], &body, &(!crc).to_be_bytes()].concat()
}

fn with_image(image: &[u8], textures: Value) -> Vec<u8> {
    let mut document = document();
    let mut bytes = triangle_bytes();
    document["bufferViews"].as_array_mut().unwrap().push(json!({
        "buffer": 0, "byteOffset": bytes.len(), "byteLength": image.len()
    }));
    bytes.extend(image);
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    document["buffers"][0]["byteLength"] = json!(bytes.len());
    document["images"] = json!([{ "bufferView": 2 }]);
    document["textures"] = textures;
    document["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
    glb(&document, &bytes)
}

fn mendable() -> Vec<Case> {
    let mut one_nan = document();
    one_nan["accessors"][0]["count"] = json!(4);
    one_nan["accessors"][1]["count"] = json!(6);
    one_nan["bufferViews"] = json!([
        { "buffer": 0, "byteOffset": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 12 }
    ]);
    one_nan["buffers"][0]["byteLength"] = json!(60);
    let mut bytes = triangle_bytes()[..36].to_vec();
    bytes.extend(f32::NAN.to_le_bytes().repeat(3));
    bytes.extend([0u16, 1, 2, 0, 1, 3].iter().flat_map(|i| i.to_le_bytes()));
    let mut two_parents = document();
    two_parents["nodes"] = json!([{ "children": [2] }, { "children": [2] }, { "mesh": 0 }]);
    two_parents["scenes"][0]["nodes"] = json!([0, 1]);
    let plain = json!([{ "source": 0 }]);
    let ktx = json!([{ "extensions": { "KHR_texture_basisu": { "source": 0 } } }]);
    let obj = "mtllib ../other/room.mtl\nusemtl oak\nv 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n";
    vec![
        case("one_nan.glb", glb(&one_nan, &bytes), &["1 triangles dropped", "finite"]),
        case("two_parents.glb", glb(&two_parents, &triangle_bytes()), &["two parents"]),
        case("two_scenes.glb", changed("/scenes", json!([{ "nodes": [0] }, { "nodes": [] }])), &["scene 0"]),
        case(
            "huge_image.glb",
            with_image(&absurd_png(60_000), plain.clone()),
            &["images[0]", "60000 x 60000"],
        ),
        case("absurd_image.glb", with_image(&absurd_png(u32::MAX), plain.clone()), &["images[0]"]),
        case("empty_image.glb", with_image(&absurd_png(4), plain.clone()), &["images[0]"]),
        case("no_image.glb", with_image(b"GIF89a....", plain), &["images[0]", "PNG or JPEG"]),
        case("ktx.glb", with_image(b"KTX 20", ktx), &["textures[0]", "KTX2"]),
        case("library_away.obj", obj, &["mtllib", "outside", "1 materials"]),
        case(
            "image_missing.glb",
            {
                let mut document = document();
                document["images"] = json!([{ "uri": "missing.png" }]);
                document["textures"] = json!([{ "source": 0 }]);
                document["materials"] =
                    json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
                glb(&document, &triangle_bytes())
            },
            &["images[0] (missing.png)"],
        ),
    ]
}

#[test]
fn what_can_be_mended_is_read_and_the_report_says_what_was_left_out() {
    let folder = tempfile::tempdir().unwrap();
    for case in mendable() {
        let model = answer(folder.path(), &case).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(model.triangle_count(), 1, "{}", case.file);
        let notes = model.notes.join("\n");
        for words in case.says {
            assert!(notes.contains(words), "{}: \"{words}\" is missing in: {notes}", case.file);
        }
        let finite = model.parts.iter().flat_map(|p| &p.mesh.positions).all(|p| p.is_finite());
        assert!(finite && model.parts.iter().all(|p| p.material < model.materials.len()), "{}", case.file);
    }
}

#[test]
fn no_cut_and_no_flipped_byte_makes_a_reader_panic_or_index_wrongly() {
    let budget = Budget::default();
    let ascii = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                 element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 0 1\n3 0 1 2\n";
    let obj = "o a\nv 0 0 0\nv 1 0 0 1 0 0\nv 0 0 1\nvt 0 0\nvn 0 1 0\nf 1/1/1 2/1/1 3/1/1\n";
    let files =
        [("a.glb", glb(&document(), &triangle_bytes())), ("a.ply", ascii.into()), ("a.obj", obj.into())];
    for (name, whole) in files {
        assert_eq!(read_model_bytes(name, &whole, &budget).unwrap().triangle_count(), 1);
        for at in 0..whole.len() {
            let mut flipped = whole.clone();
            flipped[at] ^= 1 << (at % 8);
            for bytes in [&whole[..at], &flipped] {
                let Ok(model) = read_model_bytes(name, bytes, &budget) else { continue };
                for part in &model.parts {
                    let vertices = part.mesh.positions.len();
                    assert!(
                        part.mesh.triangles.iter().flatten().all(|v| (*v as usize) < vertices),
                        "{name} {at}"
                    );
                    assert!(
                        part.mesh.normals.len() == vertices && part.mesh.bounds().size().is_finite(),
                        "{name} {at}"
                    );
                }
            }
        }
    }
}
