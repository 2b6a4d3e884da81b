use std::sync::OnceLock;

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use crate::assets::npz::Npz;
use crate::scene::{BETAS, BodyParams, Frame};

use super::hand_space::HandSpace;
use super::joints::JOINTS;
use super::model::BodyModel;
use super::parts::BodyParts;
use super::pose_decoder::PoseDecoder;
use super::pose_space::{BodyPose, PoseSpace};
use super::regions::ContactRegions;
use super::subset::VertexSubset;
use super::workspace::Workspace;

const BODY_NPZ: &[u8] = include_bytes!("../../assets/body/body.npz");
const HAND_SPACE: &str = include_str!("../../assets/body/hand_space.ron");

/// A body model with the spaces its pose codes live in: all that turns 75 numbers into a person.
pub struct Body {
    /// Template, shape, joints, skin.
    pub model: BodyModel,
    /// What the 32 pose numbers mean.
    pub pose_space: Box<dyn PoseSpace>,
    /// What the 24 hand numbers mean.
    pub hand_space: HandSpace,
    /// Which vertices may touch the room.
    pub regions: ContactRegions,
    /// How the body is dressed.
    pub parts: BodyParts,
    all: VertexSubset,
}

/// A posed body, world frame, metres.
#[derive(Clone, Debug)]
pub struct Posed {
    /// Every vertex of the model, in its order.
    pub vertices: Vec<Vec3>,
    /// The 55 joints.
    pub joints: [Vec3; JOINTS],
    /// World rotation of each joint: world from the joint's rest frame.
    pub rotations: [Mat3; JOINTS],
}

impl Body {
    /// A body of these parts.
    pub fn new(model: BodyModel, pose_space: Box<dyn PoseSpace>, hand_space: HandSpace) -> Self {
        let all = VertexSubset::all(&model);
        let regions = ContactRegions::of(&model);
        let parts = BodyParts::of(&model);
        Self { model, pose_space, hand_space, regions, parts, all }
    }

    /// The free body that ships with the program. Built once; the first call takes some 30 ms.
    ///
    /// # Panics
    /// Never with the embedded data, which a test reads.
    pub fn bundled() -> &'static Self {
        static BODY: OnceLock<Body> = OnceLock::new();
        BODY.get_or_init(|| {
            let model = Npz::from_bytes("bundled body", BODY_NPZ)
                .map_err(Into::into)
                .and_then(|npz| BodyModel::from_npz(&npz))
                .expect("the bundled body is sound");
            let poses = PoseDecoder::bundled_weights()
                .and_then(|weights| PoseDecoder::new(&weights, &model))
                .expect("the bundled pose prior is sound");
            let hands = HandSpace::from_ron(HAND_SPACE).expect("the bundled hand space is sound");
            Self::new(model, Box::new(poses), hands)
        })
    }

    /// Every vertex, as a subset for [`Body::forward`] and [`Body::backward`].
    pub fn all_vertices(&self) -> &VertexSubset {
        &self.all
    }

    /// Poses the whole body.
    pub fn pose(&self, params: &BodyParams) -> Posed {
        let mut workspace = Workspace::default();
        self.forward(params, &self.all, &mut workspace);
        let (vertices, joints, rotations) = workspace.into_parts();
        Posed { vertices, joints, rotations }
    }

    /// Poses the whole body with these axis-angles of the body joints in place of the pose code.
    pub fn pose_axis_angles(&self, params: &BodyParams, pose: &BodyPose) -> Posed {
        let mut workspace = Workspace::default();
        self.forward_posed(params, pose, &self.all, &mut workspace);
        let (vertices, joints, rotations) = workspace.into_parts();
        Posed { vertices, joints, rotations }
    }

    /// Poses a body of shape `betas` as `frame` has it.
    pub fn pose_frame(&self, betas: &[f32; BETAS], frame: &Frame) -> Posed {
        self.pose_axis_angles(&frame.params(betas), &frame.pose)
    }

    /// Poses many bodies or frames over all threads; results in the order given.
    pub fn pose_many(&self, params: &[BodyParams]) -> Vec<Posed> {
        params.par_iter().map(|p| self.pose(p)).collect()
    }

    /// Area-weighted unit normals of the whole body's vertices.
    pub fn vertex_normals(&self, vertices: &[Vec3]) -> Vec<Vec3> {
        self.model.vertex_normals(vertices)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::joints::{LEFT_ANKLE, LEFT_KNEE, LEFT_WRIST, NAMES, PELVIS, mirror};
    use crate::math::Aabb;
    use crate::scene::HANDS;

    #[test]
    fn the_mean_person_stands_1_7_m_tall_facing_z_with_the_left_hand_at_plus_x() {
        let body = Body::bundled();
        let bounds = Aabb::of(body.model.template.iter().copied());
        assert!((1.6..1.8).contains(&bounds.size().y), "{bounds:?}");
        assert!(body.model.joint_template[PELVIS].length() < 0.02);
        assert!(body.model.joint_template[LEFT_WRIST].x > 0.5);
        let toes = body.model.template.iter().copied().min_by(|a, b| a.y.total_cmp(&b.y)).expect("vertices");
        assert!(toes.y < -0.85 && bounds.max.z > 0.1, "{bounds:?}");
    }

    #[test]
    fn the_second_body_shape_number_still_gives_a_person() {
        let body = Body::bundled();
        for b in 0..BETAS {
            let mut params = BodyParams::default();
            params.betas[b] = 2.0;
            let joints = body.model.rest_joints(&params.betas);
            let leg = joints[LEFT_KNEE].distance(joints[LEFT_ANKLE]);
            assert!((0.33..0.55).contains(&leg), "betas[{b}] = 2: lower leg of {leg} m");
        }
    }

    #[test]
    fn translation_and_rotation_move_the_body_as_smplx_says() {
        let body = Body::bundled();
        let mut params = BodyParams { translation: Vec3::new(1.0, 2.0, 3.0), ..BodyParams::default() };
        let turn = Mat3::from_rotation_y(std::f32::consts::FRAC_PI_2);
        let still = body.pose(&params);
        params.set_rotation(&turn);
        let turned = body.pose(&params);
        let pelvis = body.model.joint_template[PELVIS] + params.translation;
        assert!(turned.joints[PELVIS].distance(pelvis) < 1e-5);
        let expected = pelvis + turn * (still.vertices[4000] - pelvis);
        assert!(turned.vertices[4000].distance(expected) < 1e-5);
    }

    #[test]
    fn the_same_code_in_both_hands_gives_mirrored_hands() {
        let body = Body::bundled();
        let mut params = BodyParams::default();
        for i in 0..HANDS {
            params.hands[i] = [0.7, -0.4, 1.2][i % 12 % 3];
        }
        let [left, right] = body.hand_space.decode(&params.hands);
        for (l, r) in left.iter().zip(right) {
            assert_eq!(*l, crate::body::joints::mirror_axis_angle(r));
        }
        let rest = &body.model.joint_template;
        for j in 0..NAMES.len() {
            let across = rest[mirror(j)] * Vec3::new(-1.0, 1.0, 1.0);
            assert!(rest[j].distance(across) < 5e-3, "{} is not the mirror of its other side", NAMES[j]);
        }
    }

    #[test]
    fn normals_point_out_of_the_body() {
        let body = Body::bundled();
        let normals = body.vertex_normals(&body.model.template);
        let crown = (0..normals.len())
            .max_by(|a, b| body.model.template[*a].y.total_cmp(&body.model.template[*b].y))
            .expect("vertices");
        assert!(normals[crown].y > 0.9, "{}", normals[crown]);
    }
}
