//! How far joints go: limits of the body joints' axis-angle components.
//!
//! The rest pose is a T-pose, so zero is a straight leg and an arm held out sideways, palm down. For a left
//! joint (a right one is its mirror image, y and z turn sign): hips and spine bend forward by -x and +x, knees
//! bend by +x, elbows by -y, an arm is lowered by -z and brought forward by -y, toes point down by +x at the
//! ankle. Flexion limits are the norms of the American Academy of Orthopaedic Surgeons (1965) for active
//! movement plus some ten degrees for a weight that pushes; the spine's three joints and the neck's two share
//! the norms of White and Panjabi (1990). Components of a composed rotation are not clinical angles, so
//! shoulders and forearms have wide boxes: they forbid what no one can do, not what is uncomfortable.

use glam::Vec3;

use super::joints::{self, BODY_JOINTS};
use super::pose_space::BodyPose;

/// Least and greatest axis-angle components of one joint, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimit {
    /// Least components.
    pub min: Vec3,
    /// Greatest components.
    pub max: Vec3,
}

impl JointLimit {
    /// Radians by which each component leaves the limits: negative below, positive above, zero within.
    pub fn excess(&self, axis_angle: Vec3) -> Vec3 {
        (axis_angle - self.max).max(Vec3::ZERO) + (axis_angle - self.min).min(Vec3::ZERO)
    }

    fn degrees(x: [f32; 2], y: [f32; 2], z: [f32; 2]) -> Self {
        let radians = |i: usize| Vec3::new(x[i], y[i], z[i]).map(f32::to_radians);
        Self { min: radians(0), max: radians(1) }
    }

    fn mirrored(self) -> Self {
        let (a, b) = (joints::mirror_axis_angle(self.min), joints::mirror_axis_angle(self.max));
        Self { min: a.min(b), max: a.max(b) }
    }
}

/// Limits of body joints 1 to 21.
pub fn joint_limits() -> [JointLimit; BODY_JOINTS] {
    std::array::from_fn(|i| {
        let joint = i + 1;
        if is_right(joint) { limit_of_left(joints::mirror(joint)).mirrored() } else { limit_of_left(joint) }
    })
}

/// The greatest excess of a pose over the limits, radians, and the joint (1 to 21) that has it.
pub fn worst_excess(pose: &BodyPose) -> (f32, usize) {
    let limits = joint_limits();
    (0..BODY_JOINTS)
        .map(|i| (limits[i].excess(pose[i]).abs().max_element(), i + 1))
        .fold((0.0, 1), |worst, this| if this.0 > worst.0 { this } else { worst })
}

fn is_right(joint: usize) -> bool {
    joints::NAMES[joint].starts_with("right")
}

fn limit_of_left(joint: usize) -> JointLimit {
    match joint {
        joints::LEFT_HIP => JointLimit::degrees([-130.0, 30.0], [-55.0, 65.0], [-40.0, 60.0]),
        joints::LEFT_KNEE => JointLimit::degrees([-12.0, 145.0], [-25.0, 25.0], [-20.0, 20.0]),
        joints::LEFT_ANKLE => JointLimit::degrees([-30.0, 65.0], [-45.0, 45.0], [-45.0, 45.0]),
        joints::LEFT_FOOT => JointLimit::degrees([-60.0, 35.0], [-15.0, 15.0], [-15.0, 15.0]),
        joints::SPINE1 | joints::SPINE2 | joints::SPINE3 => {
            JointLimit::degrees([-20.0, 40.0], [-25.0, 25.0], [-20.0, 20.0])
        }
        joints::NECK | joints::HEAD => JointLimit::degrees([-35.0, 40.0], [-45.0, 45.0], [-30.0, 30.0]),
        joints::LEFT_COLLAR => JointLimit::degrees([-15.0, 15.0], [-25.0, 20.0], [-15.0, 35.0]),
        joints::LEFT_SHOULDER => JointLimit::degrees([-115.0, 100.0], [-130.0, 75.0], [-110.0, 100.0]),
        joints::LEFT_ELBOW => JointLimit::degrees([-90.0, 90.0], [-155.0, 5.0], [-75.0, 75.0]),
        _ => JointLimit::degrees([-60.0, 60.0], [-70.0, 70.0], [-80.0, 80.0]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::joints::{LEFT_ELBOW, LEFT_KNEE, RIGHT_ELBOW};

    #[test]
    fn a_knee_bends_one_way_only() {
        let knee = joint_limits()[LEFT_KNEE - 1];
        assert_eq!(knee.excess(Vec3::new(2.0, 0.0, 0.0)), Vec3::ZERO);
        assert!(knee.excess(Vec3::new(-1.0, 0.0, 0.0)).x < -0.5);
        let mut pose = [Vec3::ZERO; BODY_JOINTS];
        pose[LEFT_KNEE - 1].x = -1.0;
        assert_eq!(worst_excess(&pose).1, LEFT_KNEE);
    }

    #[test]
    fn both_elbows_fold_forward() {
        let limits = joint_limits();
        assert_eq!(limits[LEFT_ELBOW - 1].excess(Vec3::new(0.0, -2.0, 0.0)), Vec3::ZERO);
        assert_eq!(limits[RIGHT_ELBOW - 1].excess(Vec3::new(0.0, 2.0, 0.0)), Vec3::ZERO);
        assert!(limits[RIGHT_ELBOW - 1].excess(Vec3::new(0.0, -2.0, 0.0)).y < -1.0);
    }
}
