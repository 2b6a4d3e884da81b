//! A jointed figure that poses are built on: world rotations set joint by joint, limbs by directions or by
//! two-bone inverse kinematics.

use glam::{Mat3, Vec3};

use crate::body::ik::{Limb, axes, two_bone};
use crate::body::joints::{self, JOINTS, PARENTS};
use crate::body::pose_space::BodyPose;
use crate::math::rotation;

/// Joints of the figure: root and body joints.
pub(super) const FIGURE_JOINTS: usize = 22;

/// One side of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
}

impl Side {
    pub(super) const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// +1 for the left, where x grows outwards.
    pub(super) fn sign(self) -> f32 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }

    /// The joint of this side, given the left one.
    pub(super) fn joint(self, left: usize) -> usize {
        match self {
            Self::Left => left,
            Self::Right => joints::mirror(left),
        }
    }

    /// A vector whose x is given as "outwards".
    pub(super) fn outward(self, x: f32, y: f32, z: f32) -> Vec3 {
        Vec3::new(self.sign() * x, y, z)
    }
}

/// The arm of a side.
pub(super) fn arm(side: Side) -> Limb {
    Limb::ARMS[side as usize]
}

/// The leg of a side.
pub(super) fn leg(side: Side) -> Limb {
    Limb::LEGS[side as usize]
}

/// Rest joints and the rotation of each joint in its parent's frame; the root's is upright-from-body.
#[derive(Clone, Debug)]
pub(super) struct Figure {
    rest: [Vec3; FIGURE_JOINTS],
    pub(super) local: [Mat3; FIGURE_JOINTS],
}

impl Figure {
    pub(super) fn new(rest: &[Vec3; JOINTS]) -> Self {
        Self { rest: std::array::from_fn(|j| rest[j]), local: [Mat3::IDENTITY; FIGURE_JOINTS] }
    }

    /// World rotation of a joint.
    pub(super) fn rotation(&self, joint: usize) -> Mat3 {
        if joint == 0 { self.local[0] } else { self.rotation(PARENTS[joint]) * self.local[joint] }
    }

    /// World position of a joint; the pelvis stands at the origin.
    pub(super) fn position(&self, joint: usize) -> Vec3 {
        if joint == 0 {
            return Vec3::ZERO;
        }
        let parent = PARENTS[joint];
        self.position(parent) + self.rotation(parent) * (self.rest[joint] - self.rest[parent])
    }

    /// A point given in a joint's own frame, relative to the joint.
    pub(super) fn point(&self, joint: usize, offset: Vec3) -> Vec3 {
        self.position(joint) + self.rotation(joint) * offset
    }

    /// Turns a joint to a world rotation.
    pub(super) fn set_rotation(&mut self, joint: usize, world: Mat3) {
        self.local[joint] = self.rotation(PARENTS[joint]).transpose() * world;
    }

    /// Length of the bone that ends at a joint.
    pub(super) fn bone(&self, joint: usize) -> f32 {
        self.rest[joint].distance(self.rest[PARENTS[joint]])
    }

    /// Points a limb's two bones along world directions; the hinge stays square to both, so nothing twists.
    /// `pole` says to which side the middle joint points.
    pub(super) fn aim_limb(&mut self, limb: Limb, upper: Vec3, lower: Vec3, pole: Vec3) {
        let [upper, lower] = limb.aim(&self.rest, [upper, lower], pole);
        self.set_rotation(limb.upper, upper);
        self.set_rotation(limb.lower, lower);
    }

    /// Brings the limb's end to `target` as far as it reaches, the middle joint towards `pole`.
    pub(super) fn reach(&mut self, limb: Limb, target: Vec3, pole: Vec3) {
        let bend =
            two_bone(target - self.position(limb.upper), limb.bones_m(&self.rest), pole, LONGEST_SHARE);
        self.aim_limb(limb, bend.bones[0], bend.bones[1], pole);
    }

    /// Turns a hand so that its fingers and palm point where asked, as far as forearm and wrist allow; most
    /// of the turn about the forearm is taken by the forearm.
    pub(super) fn aim_hand(&mut self, side: Side, fingers: Vec3, palm: Vec3) {
        let arm = arm(side);
        let rest_axis = Vec3::X * side.sign();
        let hand = axes(fingers, palm) * axes(rest_axis, Vec3::NEG_Y).transpose();
        let relative = self.rotation(arm.lower).transpose() * hand;
        let (swing, twist) = swing_twist(relative, rest_axis);
        let twist = twist.clamp(-MAX_FOREARM_TWIST, MAX_FOREARM_TWIST);
        let in_forearm = twist * FOREARM_SHARE;
        self.local[arm.lower] *= Mat3::from_axis_angle(rest_axis, in_forearm);
        let swing = swing.clamp_length_max(MAX_WRIST_SWING);
        // The swing was measured before the forearm turned: turn it back into the new frame.
        let swing = Mat3::from_axis_angle(rest_axis, -in_forearm) * swing;
        self.local[arm.end] =
            rotation::matrix_from_axis_angle(swing) * Mat3::from_axis_angle(rest_axis, twist - in_forearm);
    }

    /// Axis-angles of the body joints.
    pub(super) fn pose(&self) -> BodyPose {
        std::array::from_fn(|j| rotation::axis_angle_from_matrix(self.local[j + 1]))
    }

    /// The figure seen in a mirror: left and right change places.
    pub(super) fn mirrored(&self) -> Self {
        let flip = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
        let mut mirrored = self.clone();
        for j in 0..FIGURE_JOINTS {
            mirrored.local[joints::mirror(j)] = flip * self.local[j] * flip;
        }
        mirrored
    }
}

/// Nobody reaches with limbs as straight as a ruler.
const LONGEST_SHARE: f32 = 0.995;
/// Radians; pronation and supination reach 75 to 85 degrees each (AAOS norms).
const MAX_FOREARM_TWIST: f32 = 1.5;
/// Radians; wrist flexion and extension reach 70 to 80 degrees (AAOS norms), less in comfort.
const MAX_WRIST_SWING: f32 = 1.1;
/// Share of a hand's twist that the forearm's skin takes; all of it at the wrist would pinch the mesh.
const FOREARM_SHARE: f32 = 0.6;

/// Splits `rotation = swing · twist`, the twist about `axis` in radians, the swing as axis-angle.
fn swing_twist(rotation: Mat3, axis: Vec3) -> (Vec3, f32) {
    let q = glam::Quat::from_mat3(&rotation);
    let along = Vec3::new(q.x, q.y, q.z).dot(axis);
    let twist = 2.0 * along.atan2(q.w);
    let twist = (twist + std::f32::consts::PI).rem_euclid(std::f32::consts::TAU) - std::f32::consts::PI;
    let swing = rotation * Mat3::from_axis_angle(axis, -twist);
    (rotation::axis_angle_from_matrix(swing), twist)
}
