//! Sets tilted bodies right: a limited turn about the pelvis towards how the family holds itself.

use glam::{Mat3, Quat, Vec3};

use crate::body::joints as j;
use crate::body::joints::JOINTS;
use crate::scene::PoseFamily;

/// Legs of standing people, ankles to hips, stay this near to the vertical, degrees.
const LEGS: f32 = 6.0;
/// Hips of seated people stay this level, degrees.
const HIPS: f32 = 5.0;
/// Thighs of seated people rise or fall by at most this, degrees.
const THIGHS: f32 = 16.0;
/// Straight legs on a bed stay this level, degrees.
const STRAIGHT_LEGS: f32 = 5.0;
/// Lying people are this level from ankles to neck, degrees.
const LEVEL: f32 = 7.0;
/// Fronts of people who lie on back or belly stay this near to straight up or down, degrees.
const FACING: f32 = 25.0;
/// People who lie on a side roll by at most this from it, degrees.
const SIDE: f32 = 35.0;
/// A body is never turned farther than this: what needs more was meant otherwise. Degrees.
const MOST: f32 = 75.0;

/// The turn about the pelvis that sets a body of `family` right; identity for one that holds itself well.
pub fn repair(family: PoseFamily, joints: &[Vec3; JOINTS], world_from_pelvis: &Mat3) -> Mat3 {
    let turn = match family.group() {
        "sit" => seated(family, joints),
        "lie" => lying(family, joints, *world_from_pelvis * Vec3::Z),
        _ => toward(middle(joints, j::LEFT_HIP) - middle(joints, j::LEFT_ANKLE), Vec3::Y, LEGS),
    };
    let (axis, angle) = turn.to_axis_angle();
    Mat3::from_axis_angle(axis, angle.min(MOST.to_radians()))
}

/// Level hips first, then thighs that rest on a seat.
fn seated(family: PoseFamily, joints: &[Vec3; JOINTS]) -> Quat {
    let roll = to_level(joints[j::LEFT_HIP] - joints[j::RIGHT_HIP], HIPS);
    let (end, limit) = match family {
        PoseFamily::SitStraight => (j::LEFT_ANKLE, STRAIGHT_LEGS),
        _ => (j::LEFT_KNEE, THIGHS),
    };
    let legs = roll * (middle(joints, end) - middle(joints, j::LEFT_HIP));
    to_level(legs, limit) * roll
}

/// Level from ankles to neck first, then rolled about that line.
fn lying(family: PoseFamily, joints: &[Vec3; JOINTS], front: Vec3) -> Quat {
    let line = joints[j::NECK] - middle(joints, j::LEFT_ANKLE);
    let level = to_level(line, LEVEL);
    let (axis, front) = ((level * line).normalize_or(Vec3::X), level * front);
    let across = front - axis * front.dot(axis);
    let roll = match family {
        PoseFamily::LieUp => toward(across, Vec3::Y - axis * axis.y, FACING),
        PoseFamily::LieDown => toward(across, axis * axis.y - Vec3::Y, FACING),
        _ => to_level(across, SIDE),
    };
    roll * level
}

/// The middle between a left joint and its right counterpart.
fn middle(joints: &[Vec3; JOINTS], left: usize) -> Vec3 {
    0.5 * (joints[left] + joints[j::mirror(left)])
}

/// Turns `line` towards the horizontal until it is within `limit_deg` of it.
fn to_level(line: Vec3, limit_deg: f32) -> Quat {
    toward(line, line * Vec3::new(1.0, 0.0, 1.0), limit_deg)
}

/// Turns `line` towards `goal` until they are within `limit_deg`.
fn toward(line: Vec3, goal: Vec3, limit_deg: f32) -> Quat {
    let (line, goal) = (line.normalize_or_zero(), goal.normalize_or_zero());
    let beyond = line.dot(goal).clamp(-1.0, 1.0).acos() - limit_deg.to_radians();
    if beyond <= 0.0 || line == Vec3::ZERO || goal == Vec3::ZERO {
        return Quat::IDENTITY;
    }
    Quat::from_axis_angle(line.cross(goal).normalize_or(line.any_orthonormal_vector()), beyond)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Body, FamilyHints, sample_pose};
    use crate::job::Seed;

    #[test]
    fn a_tilted_person_is_set_right_and_an_upright_one_is_left_alone() {
        let body = Body::bundled();
        let mut rng = Seed::root(2).rng();
        for family in [PoseFamily::Stand, PoseFamily::SitChair, PoseFamily::LieUp] {
            let drawn = sample_pose(&body.model.joint_template, family, &mut rng, &FamilyHints::default());
            let turn_needed = |tilt_deg: f32| {
                let tilt = Mat3::from_rotation_z(tilt_deg.to_radians());
                let params = drawn.params(body, [0.0; 10], &tilt);
                let fixed = repair(family, &body.pose(&params).joints, &params.rotation());
                Quat::from_mat3(&fixed).to_axis_angle().1.to_degrees()
            };
            assert!(turn_needed(0.0) < 8.0, "{}: {}", family.label(), turn_needed(0.0));
            let turned = turn_needed(40.0);
            assert!((12.0..42.0).contains(&turned), "{}: {turned}", family.label());
        }
    }
}
