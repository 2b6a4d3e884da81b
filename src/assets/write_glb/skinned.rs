use glam::{Mat4, Quat, Vec3};

use super::GlbWriteError;
use super::buffer::{GlbBuilder, Layout};
use super::json;
use super::model::begin_with_model;
use super::motion::{self, SkinMotion};
use super::moving::{self, ObjectMotion};
use crate::assets::{Mesh, Model};

/// Joints that move one vertex; what viewers must support at least (glTF 2.0 §3.7.3.1).
const INFLUENCES: usize = 4;

/// A joint of a skeleton whose rest pose has no rotations, as in SMPL-X.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinJoint {
    /// Unique name.
    pub name: String,
    /// Number of the joint above, smaller than its own; `None` for the root only.
    pub parent: Option<usize>,
    /// Where it stands in the bind pose, in metres, body frame.
    pub rest_m: Vec3,
    /// Its rotation against the joint above.
    pub rotation: Quat,
}

/// A posed body as plain values: the mesh in bind pose, and what bends it.
///
/// A vertex at `x` ends up at `Σ w_j G_j (x - rest_j)` where `G_j` chains the joints' rotations and offsets
/// (linear blend skinning), so any viewer shows the pose of the joints.
#[derive(Clone, Debug)]
pub struct SkinnedMesh {
    /// Name of the body in the file.
    pub name: String,
    /// The shaped mesh in bind pose, body frame; vertex colours are its clothes.
    pub mesh: Mesh,
    /// (V, 4) joints that move each vertex.
    pub joints: Vec<[u8; INFLUENCES]>,
    /// (V, 4) how much; only the proportions matter.
    pub weights: Vec<[f32; INFLUENCES]>,
    /// The skeleton, each joint after the one above it.
    pub skeleton: Vec<SkinJoint>,
    /// Added to the root joint: from the body's frame to the room's, in metres.
    pub translation_m: Vec3,
    /// JSON for the body's node (parameters, seed), if any.
    pub extras: Option<String>,
    /// How it moves; the pose above is shown where nothing plays.
    pub motion: Option<SkinMotion>,
}

/// Writes a posed, skinned body as GLB: the mesh node stands untransformed at the scene's root and the
/// skeleton's nodes hold the pose, so that Blender opens it as mesh plus armature. Its motion becomes an animation.
///
/// Weights are renormalised to sum to 1, twice-named joints merged, unused slots set to joint 0.
/// Errors: lengths that differ, joints out of order or range, vertices without weight, numbers not finite.
pub fn glb_from_skinned(body: &SkinnedMesh) -> Result<Vec<u8>, GlbWriteError> {
    glb_with_people(&body.name, None, std::slice::from_ref(body))
}

/// Writes people, and the room around them if there is one, into one GLB, each person as
/// [`glb_from_skinned`] does. All motions begin together, in one animation.
///
/// # Errors
/// As [`super::glb_from_model`] and [`glb_from_skinned`].
pub fn glb_with_people(
    name: &str,
    room: Option<&Model>,
    people: &[SkinnedMesh],
) -> Result<Vec<u8>, GlbWriteError> {
    glb_of_motions(name, room, &[], people)
}

/// As [`glb_with_people`], with objects of the room that move or come while the people do.
///
/// # Errors
/// As [`glb_with_people`]; [`GlbWriteError::OutOfRange`] for an object that the room has not.
pub fn glb_of_motions(
    name: &str,
    room: Option<&Model>,
    objects: &[ObjectMotion],
    people: &[SkinnedMesh],
) -> Result<Vec<u8>, GlbWriteError> {
    let (mut builder, mut nodes) = match room {
        Some(room) => begin_with_model(room)?,
        None => (GlbBuilder::default(), Vec::new()),
    };
    let material = builder.root.materials.len();
    if !people.is_empty() {
        builder.root.materials.push(cloth());
    }
    let mut armatures = Vec::with_capacity(people.len());
    for body in people {
        let first = builder.root.nodes.len();
        add_body(&mut builder, body, material)?;
        nodes.extend([first + BODY_NODE, first + ARMATURE_NODE]);
        armatures.push((body, first + FIRST_JOINT_NODE));
    }
    let mut animation =
        json::Animation { name: name.to_owned(), channels: Vec::new(), samplers: Vec::new(), extras: None };
    motion::add_bodies(&mut builder, &mut animation, &armatures);
    if let Some(room) = room {
        // The room's root nodes come first.
        moving::add_objects(&mut builder, &mut animation, room, &mut nodes, objects)?;
    }
    if !animation.channels.is_empty() {
        builder.root.animations.push(animation);
    }
    builder.root.scenes.push(json::Scene { name: name.to_owned(), nodes });
    builder.finish()
}

/// Appends one body with its skin and its nodes: mesh, armature, joints.
fn add_body(builder: &mut GlbBuilder, body: &SkinnedMesh, material: usize) -> Result<(), GlbWriteError> {
    check(body)?;
    let (mut attributes, indices) = builder.mesh(&body.name, &body.mesh)?;
    let (joints, weights) = clean_weights(body)?;
    let joint_layout = Layout { component_type: json::UNSIGNED_BYTE, ..Layout::floats("VEC4") };
    attributes.joints = Some(builder.array(&joints, joint_layout));
    attributes.weights = Some(builder.array(&weights, Layout::floats("VEC4")));
    let primitive = json::Primitive { attributes, indices, material };
    builder.root.meshes.push(json::Mesh { name: body.name.clone(), primitives: vec![primitive] });
    let first = builder.root.nodes.len();
    let skin = skin(builder, body, first + FIRST_JOINT_NODE);
    builder.root.skins.push(skin);
    let (mesh, skin) = (builder.root.meshes.len() - 1, builder.root.skins.len() - 1);
    let nodes = nodes(body, first, mesh, skin)?;
    builder.root.nodes.extend(nodes);
    Ok(())
}

/// A body's nodes, counted from its first.
const BODY_NODE: usize = 0;
const ARMATURE_NODE: usize = 1;
/// Joints come after the body and the armature.
const FIRST_JOINT_NODE: usize = 2;

/// Bind matrices take the body's frame to each joint's; without rotations in rest they only shift.
fn skin(builder: &mut GlbBuilder, body: &SkinnedMesh, first_joint: usize) -> json::Skin {
    let inverse: Vec<[f32; 16]> =
        body.skeleton.iter().map(|j| Mat4::from_translation(-j.rest_m).to_cols_array()).collect();
    let layout = Layout { target: None, ..Layout::floats("MAT4") };
    json::Skin {
        name: format!("{} skeleton", body.name),
        inverse_bind_matrices: builder.array(&inverse, layout),
        skeleton: first_joint,
        joints: (first_joint..first_joint + body.skeleton.len()).collect(),
    }
}

fn nodes(
    body: &SkinnedMesh,
    first: usize,
    mesh: usize,
    skin: usize,
) -> Result<Vec<json::Node>, GlbWriteError> {
    let extras = body.extras.as_deref().map(serde_json::from_str).transpose();
    let extras = extras.map_err(|source| GlbWriteError::Extras { what: body.name.clone(), source })?;
    let (mesh, skin) = (Some(mesh), Some(skin));
    let mesh_node = json::Node { name: body.name.clone(), mesh, skin, extras, ..json::Node::default() };
    let first_joint = first + FIRST_JOINT_NODE;
    let armature = json::Node {
        name: format!("{} skeleton", body.name),
        children: vec![first_joint],
        ..json::Node::default()
    };
    let joints = body.skeleton.iter().enumerate().map(|(index, joint)| {
        let below = |other: &(usize, &SkinJoint)| other.1.parent == Some(index);
        let offset_m = match joint.parent {
            Some(parent) => joint.rest_m - body.skeleton[parent].rest_m,
            None => joint.rest_m + body.translation_m,
        };
        let children = body.skeleton.iter().enumerate().filter(below).map(|(i, _)| i + first_joint);
        json::Node {
            name: joint.name.clone(),
            translation: Some(offset_m.to_array()),
            rotation: Some(motion::unit(joint.rotation).to_array()),
            children: children.collect(),
            ..json::Node::default()
        }
    });
    Ok([mesh_node, armature].into_iter().chain(joints).collect())
}

/// Painted by vertex colours alone.
fn cloth() -> json::Material {
    json::Material {
        name: "body".into(),
        pbr_metallic_roughness: json::Pbr {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 0.0,
            roughness_factor: 0.8,
        },
        emissive_factor: None,
        alpha_mode: None,
        alpha_cutoff: None,
        double_sided: false,
    }
}

type Influences = (Vec<[u8; INFLUENCES]>, Vec<[f32; INFLUENCES]>);

fn clean_weights(body: &SkinnedMesh) -> Result<Influences, GlbWriteError> {
    let mut cleaned = (Vec::with_capacity(body.joints.len()), Vec::with_capacity(body.joints.len()));
    for (vertex, (joints, weights)) in body.joints.iter().zip(&body.weights).enumerate() {
        let (joints, weights) = clean_vertex(joints, weights)
            .ok_or_else(|| GlbWriteError::Unweighted { what: body.name.clone(), vertex })?;
        cleaned.0.push(joints);
        cleaned.1.push(weights);
    }
    Ok(cleaned)
}

/// Merges twice-named joints, drops what does not pull and makes the sum 1; `None` if nothing pulls.
fn clean_vertex(
    joints: &[u8; INFLUENCES],
    weights: &[f32; INFLUENCES],
) -> Option<([u8; INFLUENCES], [f32; INFLUENCES])> {
    let mut merged: Vec<(u8, f32)> = Vec::with_capacity(INFLUENCES);
    for (joint, weight) in joints.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
        match merged.iter_mut().find(|(j, _)| j == joint) {
            Some((_, sum)) => *sum += weight,
            None => merged.push((*joint, *weight)),
        }
    }
    merged.sort_by(|a, b| b.1.total_cmp(&a.1));
    let sum: f32 = merged.iter().map(|(_, w)| w).sum();
    let mut out = ([0; INFLUENCES], [0.0; INFLUENCES]);
    for (slot, (joint, weight)) in merged.into_iter().enumerate() {
        out.0[slot] = joint;
        out.1[slot] = weight / sum;
    }
    // The largest takes up the rounding of the others.
    out.1[0] = 1.0 - out.1[1..].iter().sum::<f32>();
    (sum > 0.0).then_some(out)
}

fn check(body: &SkinnedMesh) -> Result<(), GlbWriteError> {
    let expected = body.mesh.positions.len();
    for (array, found) in [("vertex joints", body.joints.len()), ("vertex weights", body.weights.len())] {
        if found != expected {
            return Err(GlbWriteError::Length { what: body.name.clone(), array, found, expected });
        }
    }
    let count = body.skeleton.len();
    if let Some(bad) = body.joints.as_flattened().iter().find(|j| usize::from(**j) >= count) {
        let (what, index) = (body.name.clone(), usize::from(*bad));
        return Err(GlbWriteError::OutOfRange { what, array: "joint", index, count });
    }
    for (index, joint) in body.skeleton.iter().enumerate() {
        let in_order = joint.parent.map_or(index == 0, |parent| parent < index);
        if !in_order {
            let (what, parent) = (joint.name.clone(), joint.parent.unwrap_or(index));
            return Err(GlbWriteError::OutOfRange { what, array: "parent", index: parent, count: index });
        }
        if !(joint.rest_m.is_finite() && joint.rotation.is_finite()) {
            return Err(GlbWriteError::NotFinite { what: joint.name.clone(), array: "pose" });
        }
    }
    if !body.translation_m.is_finite() || body.weights.as_flattened().iter().any(|w| !w.is_finite()) {
        let array = "translation or weights";
        return Err(GlbWriteError::NotFinite { what: body.name.clone(), array });
    }
    body.motion.as_ref().map_or(Ok(()), |motion| motion.check(&body.name, count))
}
