//! Each file is read again by the `gltf` crate, whose reader and validator share no code with the writer.

use std::sync::Arc;

use glam::{Affine3A, Mat4, Quat, Vec2, Vec3};

use super::*;
use crate::assets::{AlphaMode, ImageFile, Material, Mesh, Model, Part, Texture};

fn open(file: &[u8]) -> (gltf::Document, Vec<u8>) {
    let glb = gltf::Gltf::from_slice(file).expect("a valid GLB");
    (glb.document, glb.blob.expect("a binary chunk"))
}

/// An odd number of odd coordinates, so that alignment and rounding show.
fn mesh() -> Mesh {
    let positions: Vec<Vec3> =
        (0..5).map(|i| Vec3::new(0.1 * i as f32, (i as f32).sqrt() - 1.0, 1.0 / (i as f32 + 3.0))).collect();
    Mesh {
        normals: vec![Vec3::Y; 5],
        uvs: vec![Vec2::new(0.25, 0.3); 5],
        colors: (0..5u8).map(|i| [i, i * 60, 255 - i, 255]).collect(),
        triangles: vec![[0, 1, 2], [2, 3, 4], [4, 0, 1]],
        positions,
    }
}

fn part(name: &str, node: usize, mesh: &Arc<Mesh>, file_from_mesh: Affine3A) -> Part {
    let extras = Some(r#"{"category":"couch"}"#.to_owned());
    let (mesh, name) = (mesh.clone(), name.to_owned());
    Part { name, node, path: Vec::new(), mesh, material: 0, file_from_mesh, extras }
}

fn model(parts: Vec<Part>) -> Model {
    let texture = Texture { width: 3, height: 2, rgba: (0..24).collect(), ..Texture::default() };
    let material = Material {
        name: "oak".into(),
        base_color_texture: Some(0),
        alpha: AlphaMode::Mask(0.25),
        emissive: [0.5, 0.25, 0.125],
        ..Material::default()
    };
    Model {
        name: "room".into(),
        parts,
        materials: vec![material],
        textures: vec![Arc::new(texture)],
        notes: Vec::new(),
    }
}

fn somewhere() -> Affine3A {
    Affine3A::from_scale_rotation_translation(
        Vec3::new(-1.0, 0.7, 1.3),
        Quat::from_rotation_y(0.37),
        Vec3::new(1.1, 0.0, -2.7),
    )
}

#[test]
fn positions_transforms_names_and_extras_read_back_bit_for_bit() {
    let shared = Arc::new(mesh());
    let model = model(vec![
        part("Sofa", 7, &shared, somewhere()),
        part("Table", 3, &shared, Affine3A::IDENTITY),
        part("Sofa", 7, &shared, somewhere()),
    ]);
    let (document, blob) = open(&glb_from_model(&model).expect("writes"));
    let scene = document.default_scene().expect("a scene");
    let nodes: Vec<_> = scene.nodes().collect();
    assert_eq!(nodes.iter().map(|n| n.name().expect("named")).collect::<Vec<_>>(), ["Sofa", "Table"]);
    let matrix = Mat4::from_cols_array_2d(&nodes[0].transform().matrix());
    assert_eq!(Affine3A::from_mat4(matrix), somewhere());
    assert_eq!(nodes[0].extras().as_ref().expect("extras").get(), r#"{"category":"couch"}"#);
    let primitives: Vec<_> = nodes[0].mesh().expect("a mesh").primitives().collect();
    assert_eq!(primitives.len(), 2);
    let reader = primitives[0].reader(|_| Some(&blob));
    let read: Vec<Vec3> = reader.read_positions().expect("positions").map(Vec3::from).collect();
    assert_eq!(read, shared.positions);
    let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
    assert_eq!(indices, shared.triangles.as_flattened());
    let colors: Vec<[f32; 3]> = reader.read_colors(0).expect("colours").into_rgb_f32().collect();
    for (linear, srgb) in colors.iter().zip(&shared.colors) {
        let back =
            linear.map(|c| if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 });
        assert_eq!(back.map(|c| (c * 255.0).round() as u8), [srgb[0], srgb[1], srgb[2]]);
    }
    assert_eq!(document.accessors().count(), 5, "the shared mesh is written once");
}

#[test]
fn an_object_of_two_placed_pieces_keeps_both_under_its_name() {
    let shared = Arc::new(mesh());
    let model =
        model(vec![part("Lamp", 0, &shared, Affine3A::IDENTITY), part("Lamp", 0, &shared, somewhere())]);
    let (document, _) = open(&glb_from_model(&model).expect("writes"));
    let roots: Vec<_> = document.default_scene().expect("a scene").nodes().collect();
    assert_eq!(roots.len(), 1);
    assert_eq!(roots[0].name(), Some("Lamp"));
    assert_eq!(roots[0].children().count(), 2);
    assert_eq!(document.meshes().count(), 1, "the two pieces share their mesh");
}

#[test]
fn materials_and_pictures_read_back() {
    let file = ImageFile { mime: "image/jpeg", bytes: Arc::from([1u8, 2, 3].as_slice()) };
    let mut model = model(vec![part("Sofa", 0, &Arc::new(mesh()), Affine3A::IDENTITY)]);
    model.textures.push(Arc::new(Texture { file: Some(file), ..Texture::default() }));
    let (document, blob) = open(&glb_from_model(&model).expect("writes"));
    let material = document.materials().next().expect("a material");
    assert_eq!(material.alpha_cutoff(), Some(0.25));
    assert_eq!(material.emissive_factor(), [0.5, 0.25, 0.125]);
    let pictures: Vec<_> = document
        .images()
        .map(|image| match image.source() {
            gltf::image::Source::View { view, mime_type } => {
                (mime_type.to_owned(), blob[view.offset()..view.offset() + view.length()].to_vec())
            }
            gltf::image::Source::Uri { .. } => panic!("pictures are embedded"),
        })
        .collect();
    assert_eq!(pictures[1], ("image/jpeg".to_owned(), vec![1, 2, 3]), "a picture's own file is kept");
    let png = image::load_from_memory(&pictures[0].1).expect("a PNG").to_rgba8();
    assert_eq!(png.as_raw(), &model.textures[0].rgba);
}

#[test]
fn what_cannot_be_written_says_which_object_is_to_blame() {
    let mut bad = mesh();
    bad.positions[2].y = f32::NAN;
    let error = glb_from_model(&model(vec![part("Sofa", 0, &Arc::new(bad), Affine3A::IDENTITY)]));
    assert!(error.expect_err("NaN").to_string().contains("'Sofa'"));
    let mut bad = mesh();
    bad.triangles[1][0] = 99;
    let error = glb_from_model(&model(vec![part("Rug", 0, &Arc::new(bad), Affine3A::IDENTITY)]));
    assert!(error.expect_err("index").to_string().contains("'Rug' points to vertex number 99"));
    let mut bad = part("Door", 0, &Arc::new(mesh()), Affine3A::IDENTITY);
    bad.material = 4;
    assert!(matches!(glb_from_model(&model(vec![bad])), Err(GlbWriteError::OutOfRange { index: 4, .. })));
}

/// Three joints up a bent pole; vertices follow one to four slots with flaws that the writer must mend.
fn body() -> SkinnedMesh {
    let joint =
        |name: &str, parent, rest_m, rotation| SkinJoint { name: name.into(), parent, rest_m, rotation };
    SkinnedMesh {
        name: "Ada".into(),
        mesh: mesh(),
        joints: vec![[0, 0, 0, 0], [1, 2, 1, 0], [2, 1, 0, 0], [2, 2, 2, 2], [1, 0, 2, 0]],
        weights: vec![[1.0, 0.0, 0.0, 0.0], [1.0, 3.0, 2.0, 0.0], [0.1; 4], [3.0; 4], [0.2, 0.7, 0.3, 0.0]],
        skeleton: vec![
            joint("pelvis", None, Vec3::new(0.0, 0.1, 0.0), Quat::from_rotation_y(1.0)),
            joint("spine", Some(0), Vec3::new(0.0, 0.4, 0.1), Quat::from_rotation_x(0.5)),
            joint("head", Some(1), Vec3::new(0.1, 0.9, 0.0), Quat::from_rotation_z(-0.8)),
        ],
        translation_m: Vec3::new(1.0, 0.5, -2.0),
        extras: None,
        motion: None,
    }
}

/// The same body: its root walks and turns more than once round, the spine never moves.
fn mover() -> SkinnedMesh {
    let body = body();
    let frames = 90;
    let turn = |i: usize| {
        // As rotations come out of a fit: of either sign.
        let q = Quat::from_rotation_y(0.1 * i as f32);
        if i.is_multiple_of(3) { -q } else { q }
    };
    let motion = SkinMotion {
        fps: 30.0,
        translations_m: (0..frames).map(|i| Vec3::new(0.02 * i as f32, 0.5, -2.0)).collect(),
        rotations: (0..frames)
            .map(|i| vec![turn(i), body.skeleton[1].rotation, Quat::from_rotation_z(0.01 * i as f32)])
            .collect(),
    };
    SkinnedMesh { motion: Some(motion), ..body }
}

#[test]
fn a_motion_is_an_animation_that_interpolates_between_unit_rotations_of_one_sign() {
    let body = mover();
    let (document, blob) = open(&glb_from_skinned(&body).expect("writes"));
    let animation = document.animations().next().expect("an animation");
    assert_eq!(animation.extras().as_ref().expect("extras").get(), r#"{"fps":30.0}"#);
    let motion = body.motion.as_ref().expect("a motion");
    let mut paths = Vec::new();
    for channel in animation.channels() {
        let reader = channel.reader(|_| Some(&blob));
        let times: Vec<f32> = reader.read_inputs().expect("times").collect();
        assert!(times[0] == 0.0 && times.windows(2).all(|t| t[0] < t[1]) && times.len() == 90);
        let input = channel.sampler().input();
        assert_eq!(input.max().expect("a maximum").to_string(), format!("[{}]", times[89]));
        assert_eq!(channel.sampler().interpolation(), gltf::animation::Interpolation::Linear);
        let name = channel.target().node().name().expect("a name").to_owned();
        match reader.read_outputs().expect("outputs") {
            gltf::animation::util::ReadOutputs::Translations(places) => {
                for (place, t) in places.zip(&motion.translations_m) {
                    assert_eq!(Vec3::from(place), body.skeleton[0].rest_m + *t);
                }
                paths.push((name, "translation"));
            }
            gltf::animation::util::ReadOutputs::Rotations(turns) => {
                let turns: Vec<Quat> = turns.into_f32().map(Quat::from_array).collect();
                let joint = body.skeleton.iter().position(|j| j.name == name).expect("a joint");
                assert!(turns.iter().all(|q| q.is_normalized()));
                assert!(turns.windows(2).all(|q| q[0].dot(q[1]) > 0.9), "the short way round");
                let apart = |(q, frame): (&Quat, &Vec<Quat>)| q.angle_between(frame[joint]);
                assert!(turns.iter().zip(&motion.rotations).map(apart).all(|angle| angle < 1e-3));
                paths.push((name, "rotation"));
            }
            _ => panic!("another path"),
        }
    }
    let paths: Vec<(&str, &str)> = paths.iter().map(|(name, path)| (&**name, *path)).collect();
    let expected = [("pelvis", "translation"), ("pelvis", "rotation"), ("head", "rotation")];
    assert_eq!(paths, expected, "the spine, which never turns, has no channel");
}

#[test]
fn several_people_and_their_room_share_a_file_and_begin_together() {
    let room = model(vec![part("Sofa", 0, &Arc::new(mesh()), somewhere())]);
    let people = [mover(), SkinnedMesh { name: "Bo".into(), ..mover() }];
    let (document, _) = open(&glb_with_people("Study", Some(&room), &people).expect("writes"));
    let roots: Vec<_> = document.default_scene().expect("a scene").nodes().collect();
    let names: Vec<&str> = roots.iter().map(|n| n.name().expect("named")).collect();
    assert_eq!(names, ["Sofa", "Ada", "Ada skeleton", "Bo", "Bo skeleton"]);
    assert_eq!((document.skins().count(), document.animations().count()), (2, 1));
    let skin = document.skins().nth(1).expect("Bo's");
    assert_eq!(skin.joints().next().map(|j| j.index()), skin.skeleton().map(|j| j.index()));
    assert_eq!(roots[4].children().next().map(|j| j.index()), skin.skeleton().map(|j| j.index()));
}

#[test]
fn a_motion_of_another_skeleton_or_without_time_is_refused() {
    let with = |edit: &dyn Fn(&mut SkinMotion)| {
        let mut body = mover();
        body.motion.as_mut().into_iter().for_each(edit);
        glb_from_skinned(&body)
    };
    assert!(matches!(with(&|m| m.rotations[7].truncate(2)), Err(GlbWriteError::Length { found: 2, .. })));
    assert!(matches!(with(&|m| m.translations_m.truncate(2)), Err(GlbWriteError::Length { .. })));
    assert!(matches!(with(&|m| m.fps = 0.0), Err(GlbWriteError::NotFinite { .. })));
    assert!(matches!(with(&|m| m.translations_m[3].x = f32::NAN), Err(GlbWriteError::NotFinite { .. })));
}

/// Linear blend skinning by the formula in [`SkinnedMesh`]'s description, in f64 where it counts.
fn posed(body: &SkinnedMesh) -> Vec<Vec3> {
    let mut world: Vec<Mat4> = Vec::new();
    for joint in &body.skeleton {
        let (above, offset) = match joint.parent {
            Some(p) => (world[p], joint.rest_m - body.skeleton[p].rest_m),
            None => (Mat4::IDENTITY, joint.rest_m + body.translation_m),
        };
        world.push(above * Mat4::from_rotation_translation(joint.rotation, offset));
    }
    let blend = |(v, x): (usize, &Vec3)| {
        let sum: f32 = body.weights[v].iter().sum();
        (0..4)
            .map(|k| {
                let j = usize::from(body.joints[v][k]);
                let moved = world[j].transform_point3(*x - body.skeleton[j].rest_m);
                moved * (body.weights[v][k] / sum)
            })
            .sum()
    };
    body.mesh.positions.iter().enumerate().map(blend).collect()
}

#[test]
fn a_viewer_that_skins_the_exported_body_shows_the_same_pose() {
    let body = body();
    let (document, blob) = open(&glb_from_skinned(&body).expect("writes"));
    let skin = document.skins().next().expect("a skin");
    let inverse: Vec<Mat4> = skin
        .reader(|_| Some(&blob))
        .read_inverse_bind_matrices()
        .expect("bind matrices")
        .map(|m| Mat4::from_cols_array_2d(&m))
        .collect();
    let mut world = vec![Mat4::IDENTITY; document.nodes().count()];
    for node in document.nodes() {
        world[node.index()] *= Mat4::from_cols_array_2d(&node.transform().matrix());
        for child in node.children() {
            world[child.index()] = world[node.index()];
        }
    }
    let joints: Vec<usize> = skin.joints().map(|j| j.index()).collect();
    let primitive = document.meshes().next().and_then(|m| m.primitives().next()).expect("a primitive");
    let reader = primitive.reader(|_| Some(&blob));
    let slots: Vec<[u16; 4]> = reader.read_joints(0).expect("joints").into_u16().collect();
    let weights: Vec<[f32; 4]> = reader.read_weights(0).expect("weights").into_f32().collect();
    for (v, (position, expected)) in reader.read_positions().expect("positions").zip(posed(&body)).enumerate()
    {
        let shown: Vec3 = (0..4)
            .map(|k| {
                let j = usize::from(slots[v][k]);
                let matrix = world[joints[j]] * inverse[j];
                matrix.transform_point3(Vec3::from(position)) * weights[v][k]
            })
            .sum();
        assert!(shown.distance(expected) < 1e-5, "vertex {v}: {shown} instead of {expected}");
    }
}

#[test]
fn skin_weights_sum_to_one_and_name_no_joint_twice() {
    let (document, blob) = open(&glb_from_skinned(&body()).expect("writes"));
    let primitive = document.meshes().next().and_then(|m| m.primitives().next()).expect("a primitive");
    let reader = primitive.reader(|_| Some(&blob));
    let slots = reader.read_joints(0).expect("joints").into_u16();
    for (slots, weights) in slots.zip(reader.read_weights(0).expect("weights").into_f32()) {
        assert!((weights.iter().sum::<f32>() - 1.0).abs() <= 2e-7, "{weights:?}");
        let mut used: Vec<u16> = (0..4).filter(|k| weights[*k] > 0.0).map(|k| slots[k]).collect();
        used.sort_unstable();
        assert!(used.windows(2).all(|w| w[0] < w[1]), "{slots:?} {weights:?}");
        assert!((0..4).all(|k| weights[k] > 0.0 || slots[k] == 0), "{slots:?} {weights:?}");
    }
}

#[test]
fn blender_finds_the_body_untransformed_at_the_scenes_root() {
    let (document, _) = open(&glb_from_skinned(&body()).expect("writes"));
    let roots: Vec<_> = document.default_scene().expect("a scene").nodes().collect();
    let holder = roots.iter().find(|n| n.skin().is_some()).expect("the skinned node is a root");
    assert_eq!(holder.transform().matrix(), Mat4::IDENTITY.to_cols_array_2d());
    assert!(document.views().all(|v| v.offset() % 4 == 0));
}

#[test]
fn a_body_that_cannot_be_skinned_is_refused() {
    let mut bad = body();
    bad.weights[3] = [0.0; 4];
    assert!(matches!(glb_from_skinned(&bad), Err(GlbWriteError::Unweighted { vertex: 3, .. })));
    let mut bad = body();
    bad.joints[1][2] = 3;
    assert!(matches!(glb_from_skinned(&bad), Err(GlbWriteError::OutOfRange { index: 3, .. })));
    let mut bad = body();
    bad.skeleton[1].parent = Some(2);
    assert!(matches!(glb_from_skinned(&bad), Err(GlbWriteError::OutOfRange { .. })));
    let mut bad = body();
    bad.joints.pop();
    assert!(matches!(glb_from_skinned(&bad), Err(GlbWriteError::Length { .. })));
}

#[test]
fn an_object_that_moves_ends_where_the_model_has_it_and_comes_when_it_should() {
    let mesh = Arc::new(mesh());
    let model = model(vec![part("rug", 3, &mesh, Affine3A::IDENTITY), part("cup", 7, &mesh, somewhere())]);
    let model_from_object =
        Affine3A::from_rotation_translation(Quat::from_rotation_y(0.5), Vec3::new(0.4, 0.7, 0.0));
    let key = |at_s: f32, translation_m: Vec3, turn: f32| ObjectKey {
        at_s,
        translation_m,
        rotation: Quat::from_rotation_y(turn),
    };
    let keys = vec![key(1.0, Vec3::X, 0.0), key(2.0, Vec3::new(0.4, 0.7, 0.0), 0.5)];
    let motion = ObjectMotion { node: 7, model_from_object, keys, comes_s: Some(1.0) };
    let file = glb_of_motions("day", Some(&model), std::slice::from_ref(&motion), &[]).expect("sound");
    let (document, blob) = open(&file);
    let scene = document.scenes().next().expect("one");
    let above = scene.nodes().find(|n| n.name() == Some("cup moves")).expect("its own node");
    let below = above.children().next().expect("what moves");
    let placed = |node: &gltf::Node<'_>| Mat4::from_cols_array_2d(&node.transform().matrix());
    let found = placed(&above) * placed(&below);
    assert!(found.abs_diff_eq(Mat4::from(somewhere()), 1e-5), "at rest it is where the model has it");
    let animation = document.animations().next().expect("one");
    let mut paths = Vec::new();
    for channel in animation.channels() {
        assert_eq!(channel.target().node().index(), above.index());
        let reader = channel.reader(|_| Some(&blob));
        let times: Vec<f32> = reader.read_inputs().expect("times").collect();
        match reader.read_outputs().expect("values") {
            gltf::animation::util::ReadOutputs::Translations(at) => {
                assert_eq!((times, at.last()), (vec![1.0, 2.0], Some([0.4, 0.7, 0.0])));
                paths.push("translation");
            }
            gltf::animation::util::ReadOutputs::Scales(scales) => {
                assert_eq!((times, scales.collect::<Vec<_>>()), (vec![0.0, 1.0], vec![[0.0; 3], [1.0; 3]]));
                paths.push("scale");
            }
            _ => paths.push("rotation"),
        }
    }
    assert_eq!(paths, ["translation", "rotation", "scale"]);
    let nowhere = ObjectMotion { node: 5, ..motion };
    assert!(glb_of_motions("day", Some(&model), &[nowhere], &[]).is_err(), "the model has no such object");
}
