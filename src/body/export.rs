//! A posed body as the plain skinned mesh that the writers of 3-D files take.

use glam::{Quat, Vec3};

use super::Body;
use super::joints::{NAMES, PARENTS};
use super::workspace::Workspace;
use crate::assets::{Mesh, SkinJoint, SkinnedMesh};
use crate::scene::BodyParams;

/// The body of `params` as bind mesh, skin and posed skeleton in the world frame: what skins it shows the
/// vertices of [`Body::pose`].
///
/// `colors` are sRGB with alpha, one per vertex, or empty. The 75 numbers go along as the node's extras,
/// `{"body": {…}}`.
pub fn skinned_mesh(body: &Body, name: &str, params: &BodyParams, colors: Vec<[u8; 4]>) -> SkinnedMesh {
    let model = &body.model;
    let mut pose = Workspace::default();
    body.forward_joints(params, &mut pose);
    let rest_joints = model.rest_joints(&params.betas);
    let positions = shaped(body, params);
    let joint = |j: usize| SkinJoint {
        name: NAMES[j].to_owned(),
        parent: (j > 0).then(|| PARENTS[j]),
        rest_m: rest_joints[j],
        rotation: match j {
            0 => Quat::from_mat3(&params.rotation()),
            _ => Quat::from_scaled_axis(pose.local_pose()[j]),
        },
    };
    SkinnedMesh {
        name: name.to_owned(),
        mesh: Mesh {
            normals: model.vertex_normals(&positions),
            positions,
            uvs: Vec::new(),
            colors,
            triangles: model.faces.clone(),
        },
        joints: model.skin.iter().map(|pull| pull.map(|(joint, _)| joint)).collect(),
        weights: model.skin.iter().map(|pull| pull.map(|(_, weight)| weight)).collect(),
        skeleton: (0..NAMES.len()).map(joint).collect(),
        translation_m: params.translation,
        extras: Some(serde_json::json!({ "body": params }).to_string()),
        motion: None,
    }
}

/// The template with its shape, in bind pose.
fn shaped(body: &Body, params: &BodyParams) -> Vec<Vec3> {
    let shape = |(rest, directions): (&Vec3, &[Vec3; crate::scene::BETAS])| {
        directions.iter().zip(&params.betas).fold(*rest, |sum, (direction, beta)| sum + *direction * *beta)
    };
    body.model.template.iter().zip(&body.model.shape_dirs).map(shape).collect()
}

#[cfg(test)]
mod tests {
    use glam::{Mat3, Mat4};

    use super::*;
    use crate::assets::glb_from_skinned;

    fn somebody() -> BodyParams {
        let wave = |i: usize, swing: f32| swing * (i as f32 * 1.7).sin();
        let mut params = BodyParams {
            translation: Vec3::new(1.2, 0.9, -2.5),
            betas: std::array::from_fn(|i| wave(i, 1.5)),
            pose: std::array::from_fn(|i| wave(i + 3, 1.0)),
            hands: std::array::from_fn(|i| wave(i + 5, 0.8)),
            ..BodyParams::default()
        };
        params.set_rotation(&(Mat3::from_rotation_y(2.0) * Mat3::from_rotation_x(0.4)));
        params
    }

    /// Vertices as a viewer would show them: skinned by the file's own nodes, bind matrices and weights.
    fn shown(glb: &[u8]) -> Vec<Vec3> {
        let glb = gltf::Gltf::from_slice(glb).expect("a valid GLB");
        let blob = glb.blob.as_deref().expect("a binary chunk");
        let mut world = vec![Mat4::IDENTITY; glb.nodes().count()];
        for node in glb.nodes() {
            world[node.index()] *= Mat4::from_cols_array_2d(&node.transform().matrix());
            node.children().for_each(|child| world[child.index()] = world[node.index()]);
        }
        let skin = glb.skins().next().expect("a skin");
        let inverse = skin.reader(|_| Some(blob)).read_inverse_bind_matrices().expect("bind matrices");
        let bones: Vec<Mat4> = skin
            .joints()
            .zip(inverse)
            .map(|(joint, inverse)| world[joint.index()] * Mat4::from_cols_array_2d(&inverse))
            .collect();
        let primitive = glb.meshes().next().and_then(|m| m.primitives().next()).expect("a primitive");
        let reader = primitive.reader(|_| Some(blob));
        let joints = reader.read_joints(0).expect("joints").into_u16();
        let weights = reader.read_weights(0).expect("weights").into_f32();
        let positions = reader.read_positions().expect("positions").map(Vec3::from);
        let blend = |((p, j), w): ((Vec3, [u16; 4]), [f32; 4])| {
            (0..4).map(|k| bones[usize::from(j[k])].transform_point3(p) * w[k]).sum()
        };
        positions.zip(joints).zip(weights).map(blend).collect()
    }

    #[test]
    fn blender_shows_an_exported_person_where_the_program_does_to_a_tenth_of_a_millimetre() {
        let (body, params) = (Body::bundled(), somebody());
        let colors = vec![[200, 100, 50, 255]; body.model.template.len()];
        let glb = glb_from_skinned(&skinned_mesh(body, "Ada", &params, colors)).expect("writes");
        let posed = body.pose(&params).vertices;
        let shown = shown(&glb);
        assert_eq!(shown.len(), posed.len());
        let worst = shown.iter().zip(&posed).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(worst < 1e-4, "{worst} m apart");
    }

    #[test]
    fn an_exported_person_carries_its_numbers() {
        let params = somebody();
        let mesh = skinned_mesh(Body::bundled(), "Ada", &params, Vec::new());
        let extras: serde_json::Value = serde_json::from_str(&mesh.extras.expect("extras")).expect("JSON");
        let back: BodyParams = serde_json::from_value(extras["body"].clone()).expect("a body");
        assert_eq!(back, params);
    }
}
