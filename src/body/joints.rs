//! SMPL-X's 55 joints: their order, names and tree, and which mirrors which.

/// Joints of the body model.
pub const JOINTS: usize = 55;
/// Joints that the body pose turns: joints 1 to 21, everything but the root, face and hands.
pub const BODY_JOINTS: usize = 21;

/// Root of the tree.
pub const PELVIS: usize = 0;
/// Left hip.
pub const LEFT_HIP: usize = 1;
/// Right hip.
pub const RIGHT_HIP: usize = 2;
/// Lumbar spine.
pub const SPINE1: usize = 3;
/// Left knee.
pub const LEFT_KNEE: usize = 4;
/// Right knee.
pub const RIGHT_KNEE: usize = 5;
/// Lower thoracic spine.
pub const SPINE2: usize = 6;
/// Left ankle.
pub const LEFT_ANKLE: usize = 7;
/// Right ankle.
pub const RIGHT_ANKLE: usize = 8;
/// Upper thoracic spine.
pub const SPINE3: usize = 9;
/// Ball of the left foot.
pub const LEFT_FOOT: usize = 10;
/// Ball of the right foot.
pub const RIGHT_FOOT: usize = 11;
/// Neck.
pub const NECK: usize = 12;
/// Left collar bone.
pub const LEFT_COLLAR: usize = 13;
/// Right collar bone.
pub const RIGHT_COLLAR: usize = 14;
/// Head.
pub const HEAD: usize = 15;
/// Left shoulder.
pub const LEFT_SHOULDER: usize = 16;
/// Right shoulder.
pub const RIGHT_SHOULDER: usize = 17;
/// Left elbow.
pub const LEFT_ELBOW: usize = 18;
/// Right elbow.
pub const RIGHT_ELBOW: usize = 19;
/// Left wrist.
pub const LEFT_WRIST: usize = 20;
/// Right wrist.
pub const RIGHT_WRIST: usize = 21;
/// Jaw.
pub const JAW: usize = 22;
/// Left eye.
pub const LEFT_EYE: usize = 23;
/// Right eye.
pub const RIGHT_EYE: usize = 24;
/// First of the 15 joints of the left hand: index, middle, pinky, ring, thumb, three each.
pub const LEFT_HAND: usize = 25;
/// First of the 15 joints of the right hand.
pub const RIGHT_HAND: usize = 40;
/// First joint of the left middle finger: with the wrist it gives the middle of the palm.
pub const LEFT_MIDDLE1: usize = 28;
/// First joint of the right middle finger.
pub const RIGHT_MIDDLE1: usize = 43;

/// Parent of each joint; the root is its own.
pub const PARENTS: [usize; JOINTS] = [
    0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 15, 15, 15, 20, 25, 26, 20, 28,
    29, 20, 31, 32, 20, 34, 35, 20, 37, 38, 21, 40, 41, 21, 43, 44, 21, 46, 47, 21, 49, 50, 21, 52, 53,
];

/// SMPL-X's name of each joint.
pub const NAMES: [&str; JOINTS] = [
    "pelvis",
    "left_hip",
    "right_hip",
    "spine1",
    "left_knee",
    "right_knee",
    "spine2",
    "left_ankle",
    "right_ankle",
    "spine3",
    "left_foot",
    "right_foot",
    "neck",
    "left_collar",
    "right_collar",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "jaw",
    "left_eye_smplhf",
    "right_eye_smplhf",
    "left_index1",
    "left_index2",
    "left_index3",
    "left_middle1",
    "left_middle2",
    "left_middle3",
    "left_pinky1",
    "left_pinky2",
    "left_pinky3",
    "left_ring1",
    "left_ring2",
    "left_ring3",
    "left_thumb1",
    "left_thumb2",
    "left_thumb3",
    "right_index1",
    "right_index2",
    "right_index3",
    "right_middle1",
    "right_middle2",
    "right_middle3",
    "right_pinky1",
    "right_pinky2",
    "right_pinky3",
    "right_ring1",
    "right_ring2",
    "right_ring3",
    "right_thumb1",
    "right_thumb2",
    "right_thumb3",
];

/// The joint on the other side of the body; joints of the middle are their own.
pub fn mirror(joint: usize) -> usize {
    match joint {
        LEFT_HIP | LEFT_KNEE | LEFT_ANKLE | LEFT_FOOT | LEFT_COLLAR | LEFT_SHOULDER | LEFT_ELBOW
        | LEFT_WRIST | LEFT_EYE => joint + 1,
        RIGHT_HIP | RIGHT_KNEE | RIGHT_ANKLE | RIGHT_FOOT | RIGHT_COLLAR | RIGHT_SHOULDER | RIGHT_ELBOW
        | RIGHT_WRIST | RIGHT_EYE => joint - 1,
        LEFT_HAND..RIGHT_HAND => joint + 15,
        RIGHT_HAND..JOINTS => joint - 15,
        _ => joint,
    }
}

/// An axis-angle vector of a joint as the joint on the other side turns in the mirror image (x turns sign,
/// so a rotation keeps its x part and turns the others).
pub fn mirror_axis_angle(axis_angle: glam::Vec3) -> glam::Vec3 {
    glam::Vec3::new(axis_angle.x, -axis_angle.y, -axis_angle.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_left_joint_mirrors_to_the_right_joint_of_the_same_name() {
        for joint in 0..JOINTS {
            let expected = match NAMES[joint].split_once('_') {
                Some(("left", rest)) => format!("right_{rest}"),
                Some(("right", rest)) => format!("left_{rest}"),
                _ => NAMES[joint].to_owned(),
            };
            assert_eq!(NAMES[mirror(joint)], expected);
            assert_eq!(mirror(PARENTS[joint]), PARENTS[mirror(joint)], "{expected}");
        }
    }
}
