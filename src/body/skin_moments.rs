use glam::{Mat3, Vec3};

use super::joints::{BODY_JOINTS, JOINTS, PARENTS};
use super::model::BodyModel;

/// The pelvis and the body joints.
pub const POSE_TREE: usize = BODY_JOINTS + 1;

/// How a body's skin hangs on its joints, for measuring how far two poses are apart.
///
/// Skin is taken as moved rigidly by the joint that moves it most. Then the mean squared displacement of all of it is a
/// quadratic form of each joint's rotation and position with the skin's moments of order 0 to 2, so that every vertex
/// of the body counts (by its area) at the price of one point a joint. Half of the mass is the skin's, half the joints'.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinMoments {
    /// Joints of the mean shape at rest, metres.
    pub rest: [Vec3; POSE_TREE],
    /// Share of the body that each joint moves; sums to 1.
    pub mass: [f32; POSE_TREE],
    /// Sum of mass times offset from the joint at rest.
    pub first: [Vec3; POSE_TREE],
    /// Sum of mass times the offset's outer product with itself.
    pub second: [Mat3; POSE_TREE],
}

/// A pose as rotations and positions, pelvis unturned at its rest position.
#[derive(Clone, Debug)]
pub struct PoseFigure {
    /// Rotation of each joint in its parent's frame.
    pub local: [Mat3; POSE_TREE],
    /// Rotation of each joint.
    pub world: [Mat3; POSE_TREE],
    /// Position of each joint, metres.
    pub position: [Vec3; POSE_TREE],
}

impl SkinMoments {
    /// Of the mean shape of a body.
    pub fn new(model: &BodyModel) -> Self {
        let rest: [Vec3; POSE_TREE] = std::array::from_fn(|joint| model.joint_template[joint]);
        let mut moments = Self {
            rest,
            mass: [0.0; POSE_TREE],
            first: [Vec3::ZERO; POSE_TREE],
            second: [Mat3::ZERO; POSE_TREE],
        };
        let area = vertex_areas(model);
        let total: f32 = area.iter().sum();
        for (vertex, area) in area.iter().enumerate() {
            let joint = carrier(model.dominant_joint(vertex));
            moments.add(joint, model.template[vertex] - rest[joint], 0.5 * area / total);
        }
        (0..POSE_TREE).for_each(|joint| moments.add(joint, Vec3::ZERO, 0.5 / POSE_TREE as f32));
        moments
    }

    fn add(&mut self, joint: usize, offset: Vec3, mass: f32) {
        self.mass[joint] += mass;
        self.first[joint] += offset * mass;
        self.second[joint] += Mat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z) * mass;
    }

    /// The figure whose joints turn by `local` (of joints 1 to 21; the pelvis is unturned).
    pub fn figure(&self, local: &dyn Fn(usize) -> Mat3) -> PoseFigure {
        let mut figure = PoseFigure {
            local: [Mat3::IDENTITY; POSE_TREE],
            world: [Mat3::IDENTITY; POSE_TREE],
            position: self.rest,
        };
        for joint in 1..POSE_TREE {
            let parent = PARENTS[joint];
            figure.local[joint] = local(joint);
            figure.world[joint] = figure.world[parent] * figure.local[joint];
            figure.position[joint] =
                figure.position[parent] + figure.world[parent] * (self.rest[joint] - self.rest[parent]);
        }
        figure
    }
}

/// The body joint that carries a joint: fingers are the wrist's, the face is the head's.
pub fn carrier(mut joint: usize) -> usize {
    debug_assert!(joint < JOINTS);
    while joint >= POSE_TREE {
        joint = PARENTS[joint];
    }
    joint
}

/// A third of the area of every face at each of its vertices, square metres.
pub fn vertex_areas(model: &BodyModel) -> Vec<f32> {
    let mut areas = vec![0.0; model.template.len()];
    for face in &model.faces {
        let [a, b, c] = face.map(|i| model.template[i as usize]);
        let third = (b - a).cross(c - a).length() / 6.0;
        face.iter().for_each(|i| areas[*i as usize] += third);
    }
    areas
}
