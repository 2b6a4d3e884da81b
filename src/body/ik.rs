//! Inverse kinematics of limbs with two bones, and the joints of one frame of a motion that it works on.
//!
//! Analytic (law of cosines), so a planted foot stays where it is to rounding. Middle joints are hinges: both bones
//! turn in one plane and nothing twists.

use glam::{Mat3, Quat, Vec3};

use crate::math::rotation;
use crate::scene::Frame;

use super::joints::{self, JOINTS, PARENTS};
use super::pose_space::BodyPose;
use super::skin_moments::POSE_TREE;

/// A limb of two bones: hip, knee and ankle, or shoulder, elbow and wrist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limb {
    /// The joint at the trunk.
    pub upper: usize,
    /// The hinge between the bones.
    pub lower: usize,
    /// The joint at the end.
    pub end: usize,
    /// Axis at rest about which the lower bone turns when the limb bends: upper × lower direction.
    pub hinge: Vec3,
}

impl Limb {
    /// Left and right leg.
    pub const LEGS: [Self; 2] = [
        Self { upper: joints::LEFT_HIP, lower: joints::LEFT_KNEE, end: joints::LEFT_ANKLE, hinge: Vec3::X },
        Self {
            upper: joints::RIGHT_HIP,
            lower: joints::RIGHT_KNEE,
            end: joints::RIGHT_ANKLE,
            hinge: Vec3::X,
        },
    ];

    /// Left and right arm.
    pub const ARMS: [Self; 2] = [
        Self {
            upper: joints::LEFT_SHOULDER,
            lower: joints::LEFT_ELBOW,
            end: joints::LEFT_WRIST,
            hinge: Vec3::NEG_Y,
        },
        Self {
            upper: joints::RIGHT_SHOULDER,
            lower: joints::RIGHT_ELBOW,
            end: joints::RIGHT_WRIST,
            hinge: Vec3::Y,
        },
    ];

    /// Lengths of the upper and the lower bone, metres.
    pub fn bones_m(&self, rest: &[Vec3]) -> [f32; 2] {
        [rest[self.upper].distance(rest[self.lower]), rest[self.lower].distance(rest[self.end])]
    }

    /// World rotations of the upper and the lower joint whose bones point along `upper` and `lower`; the hinge stays
    /// square to both. `pole` says to which side the middle joint points, for a limb that is almost straight.
    pub fn aim(&self, rest: &[Vec3], [upper, lower]: [Vec3; 2], pole: Vec3) -> [Mat3; 2] {
        let natural = pole.cross(upper);
        let hinge = upper.cross(lower);
        let hinge = if hinge.length() > 0.02 { hinge } else { natural };
        // A limb a little beyond straight is overstretched, not turned round.
        let hinge = if hinge.dot(natural) < 0.0 { -hinge } else { hinge };
        let hinge = hinge.normalize_or(self.hinge);
        let upper_rest = rest[self.lower] - rest[self.upper];
        let lower_rest = rest[self.end] - rest[self.lower];
        [
            axes(upper, hinge) * axes(upper_rest, self.hinge).transpose(),
            axes(lower, hinge) * axes(lower_rest, self.hinge).transpose(),
        ]
    }
}

/// Directions of a limb's two bones, unit vectors, and how far its end misses the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Upper bone, then lower bone.
    pub bones: [Vec3; 2],
    /// Metres by which the target is farther (positive) or nearer (negative) than the limb reaches.
    pub miss_m: f32,
}

/// Radians between the two bones of a limb bent as far as flesh lets it: 145 degrees of flexion.
const LEAST_INNER_ANGLE: f32 = 0.61;

/// Brings the end of two bones of lengths `bones_m` by `root_to_target` from their root, as far as they reach, the
/// middle joint towards `pole`. `longest_share` is the share of the full length that the limb may stretch to.
pub fn two_bone(root_to_target: Vec3, [a, b]: [f32; 2], pole: Vec3, longest_share: f32) -> Bend {
    let along = root_to_target.normalize_or(Vec3::NEG_Y);
    let folded = (a * a + b * b - 2.0 * a * b * LEAST_INNER_ANGLE.cos()).sqrt();
    let wanted = root_to_target.length();
    let distance = wanted.clamp(folded, (a + b) * longest_share);
    let pole = (pole - along * pole.dot(along)).normalize_or(along.any_orthonormal_vector());
    let cos = ((a * a + distance * distance - b * b) / (2.0 * a * distance)).clamp(-1.0, 1.0);
    let upper = along * cos + pole * (1.0 - cos * cos).sqrt();
    let lower = (along * distance - upper * a).normalize_or(along);
    Bend { bones: [upper, lower], miss_m: wanted - distance }
}

/// Right-handed axes, the first along `first` and the second as near to `second` as it can be.
pub fn axes(first: Vec3, second: Vec3) -> Mat3 {
    let x = first.normalize_or(Vec3::X);
    let y = (second - x * x.dot(second)).normalize_or(x.any_orthonormal_vector());
    Mat3::from_cols(x, y, x.cross(y))
}

/// World positions and rotations of the pelvis and the body joints in one frame.
#[derive(Clone, Debug)]
pub struct FrameJoints {
    /// Position of each joint, metres, world frame.
    pub positions: [Vec3; POSE_TREE],
    /// Rotation of each joint: world from the joint's rest frame.
    pub rotations: [Quat; POSE_TREE],
}

impl FrameJoints {
    /// The joints of a frame on a body whose rest joints are `rest` ([`super::BodyModel::rest_joints`]).
    pub fn of(rest: &[Vec3; JOINTS], frame: &Frame) -> Self {
        let mut figure = Self { positions: [Vec3::ZERO; POSE_TREE], rotations: [frame.rotation; POSE_TREE] };
        figure.positions[0] = rest[0] + frame.translation;
        for joint in 1..POSE_TREE {
            let local = Quat::from_scaled_axis(frame.pose[joint - 1]);
            figure.rotations[joint] = (figure.rotations[PARENTS[joint]] * local).normalize();
            figure.place(rest, joint);
        }
        figure
    }

    /// Rotations of joints 1 to 21 in their parents' frames, as axis-angles.
    pub fn pose(&self) -> BodyPose {
        std::array::from_fn(|i| self.local(i + 1))
    }

    /// Rotation of one joint in its parent's frame, as an axis-angle.
    pub fn local(&self, joint: usize) -> Vec3 {
        let local = self.rotations[PARENTS[joint]].inverse() * self.rotations[joint];
        rotation::axis_angle_from_matrix(Mat3::from_quat(local.normalize()))
    }

    fn place(&mut self, rest: &[Vec3; JOINTS], joint: usize) {
        let parent = PARENTS[joint];
        self.positions[joint] =
            self.positions[parent] + self.rotations[parent] * (rest[joint] - rest[parent]);
    }

    /// Brings a limb's end to `target` and turns it to the world rotation `end`, the middle joint towards `pole`. The
    /// joint after the end (the ball of a foot) keeps its rotation in the end's frame. Returns by how many metres the
    /// limb is too short (0 when it reaches).
    pub fn reach(&mut self, rest: &[Vec3; JOINTS], limb: &Limb, target: Vec3, end: Quat, pole: Vec3) -> f32 {
        let toes = (limb.end + 3 < POSE_TREE && PARENTS[limb.end + 3] == limb.end).then_some(limb.end + 3);
        let toes = toes.map(|t| (t, self.rotations[limb.end].inverse() * self.rotations[t]));
        let to_target = target - self.positions[limb.upper];
        let bend = two_bone(to_target, limb.bones_m(rest), pole, STRAIGHT_SHARE);
        // A limb folded so far that its upper bone points away from the target still bends towards the pole.
        let pole = bend.bones[0].cross(pole.cross(to_target));
        let [upper, lower] = limb.aim(rest, bend.bones, pole);
        self.rotations[limb.upper] = Quat::from_mat3(&upper).normalize();
        self.rotations[limb.lower] = Quat::from_mat3(&lower).normalize();
        self.rotations[limb.end] = end;
        self.place(rest, limb.lower);
        self.place(rest, limb.end);
        if let Some((joint, local)) = toes {
            self.rotations[joint] = (end * local).normalize();
            self.place(rest, joint);
        }
        bend.miss_m.max(0.0)
    }

    /// Which way a limb's middle joint points, square to the line from its root to its end; `None` when it is
    /// straight.
    pub fn pole(&self, limb: &Limb) -> Option<Vec3> {
        let along = (self.positions[limb.end] - self.positions[limb.upper]).normalize_or(Vec3::NEG_Y);
        let out = self.positions[limb.lower] - self.positions[limb.upper];
        (out - along * along.dot(out)).try_normalize().filter(|_| out.cross(along).length() > STRAIGHT_M)
    }
}

/// Share of a limb's length that it stretches to: a hair less than all of it keeps the middle joint's direction known.
const STRAIGHT_SHARE: f32 = 0.9998;
/// A middle joint that is nearer to the line from root to end says nothing about its direction.
const STRAIGHT_M: f32 = 0.004;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;
    use crate::body::joints::{LEFT_ANKLE, LEFT_FOOT, LEFT_HIP, LEFT_KNEE};
    use crate::scene::BETAS;

    fn rest() -> [Vec3; JOINTS] {
        Body::bundled().model.rest_joints(&[0.5; BETAS])
    }

    #[test]
    fn joints_of_a_frame_are_the_posed_bodys() {
        let body = Body::bundled();
        let mut frame = Frame { translation: Vec3::new(1.0, 0.2, -2.0), ..Frame::default() };
        frame.rotation = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(0.2);
        frame.pose = std::array::from_fn(|i| Vec3::new(0.3, -0.2, 0.1) * (i as f32).sin());
        let posed = body.pose_axis_angles(&frame.params(&[0.5; BETAS]), &frame.pose);
        let joints = FrameJoints::of(&rest(), &frame);
        for j in 0..POSE_TREE {
            assert!(joints.positions[j].distance(posed.joints[j]) < 1e-4, "{}", joints::NAMES[j]);
        }
        for (a, b) in joints.pose().iter().zip(&frame.pose) {
            assert!(a.distance(*b) < 1e-4);
        }
    }

    #[test]
    fn a_leg_reaches_its_target_with_the_knee_forward_and_the_foot_as_asked() {
        let rest = rest();
        let mut figure = FrameJoints::of(&rest, &Frame::default());
        let target = rest[LEFT_ANKLE] + Vec3::new(0.05, 0.2, 0.25);
        let foot = Quat::from_rotation_y(0.2);
        let missing = figure.reach(&rest, &Limb::LEGS[0], target, foot, Vec3::Z);
        assert_eq!(missing, 0.0);
        let frame = Frame { pose: figure.pose(), ..Frame::default() };
        let again = FrameJoints::of(&rest, &frame);
        assert!(again.positions[LEFT_ANKLE].distance(target) < 1e-4);
        assert!(again.rotations[LEFT_ANKLE].angle_between(foot) < 2e-3);
        let knee = figure.local(LEFT_KNEE);
        // The bones at rest are not quite in one line, so that a hinge's bend shows a little on the other axes.
        let off = knee.y.abs().max(knee.z.abs());
        assert!(knee.x > 0.5 && off < 0.15 * knee.x, "{knee} is not a hinge's bend");
        let forward = again.pole(&Limb::LEGS[0]).expect("a bent knee");
        assert!(forward.z > 0.5, "{forward}");
        assert!(again.positions[LEFT_FOOT].distance(target) < 0.2);
    }

    #[test]
    fn a_target_out_of_reach_is_missed_by_what_is_said() {
        let rest = rest();
        let mut figure = FrameJoints::of(&rest, &Frame::default());
        let target = rest[LEFT_HIP] + Vec3::NEG_Y * 2.0;
        let missing = figure.reach(&rest, &Limb::LEGS[0], target, Quat::IDENTITY, Vec3::Z);
        assert!((figure.positions[LEFT_ANKLE].distance(target) - missing).abs() < 1e-3);
        // The rest pose has its knees bent by 6.6 degrees: less than that is straight.
        assert!(figure.local(LEFT_KNEE).x.abs() < 0.13, "a straight knee does not bend back");
    }
}
