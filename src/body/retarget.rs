//! Carries captured motion from its own skeleton over to the body's 55 joints.
//!
//! World rotations are kept, corrected for limbs that point elsewhere at rest: with `d` the direction of a limb at
//! rest, ours turns by `R = G C`, `C` the shortest turn from our `d` to the capture's, so both point alike in
//! every frame. Trunk, neck and collar bones are not corrected: their rest curves differ from rig to rig while the
//! people standing in them do not. Lengths are scaled by the legs.

use glam::{Quat, Vec3};

use crate::assets::{CLIP_JOINTS, PoseClip, RigMotion};
use crate::math::rotation;

use super::joints::{self as j, JOINTS, PARENTS};

/// Why a motion can't be carried over.
#[derive(Debug, thiserror::Error)]
pub enum RetargetError {
    /// A skeleton that no table knows.
    #[error(
        "{motion}: no known skeleton has these joints: {found}; rename them as in the CMU database's BVH files"
    )]
    UnknownSkeleton {
        /// The motion.
        motion: String,
        /// Its joints.
        found: String,
    },
    /// A skeleton without legs.
    #[error("{motion}: its legs have no length, so nothing says how large the figure is")]
    NoLegs {
        /// The motion.
        motion: String,
    },
}

/// Which of its joints drives which of ours.
type RigTable = &'static [(usize, &'static str)];

/// The figure of the DAZ-friendly conversion of the CMU database.
const CMU_DAZ: RigTable = &[
    (j::PELVIS, "hip"),
    (j::SPINE2, "abdomen"),
    (j::SPINE3, "chest"),
    (j::NECK, "neck"),
    (j::HEAD, "head"),
    (j::LEFT_COLLAR, "lCollar"),
    (j::LEFT_SHOULDER, "lShldr"),
    (j::LEFT_ELBOW, "lForeArm"),
    (j::LEFT_WRIST, "lHand"),
    (j::LEFT_HIP, "lThigh"),
    (j::LEFT_KNEE, "lShin"),
    (j::LEFT_ANKLE, "lFoot"),
    (j::RIGHT_COLLAR, "rCollar"),
    (j::RIGHT_SHOULDER, "rShldr"),
    (j::RIGHT_ELBOW, "rForeArm"),
    (j::RIGHT_WRIST, "rHand"),
    (j::RIGHT_HIP, "rThigh"),
    (j::RIGHT_KNEE, "rShin"),
    (j::RIGHT_ANKLE, "rFoot"),
];

/// The CMU database's own names.
const CMU_ASF: RigTable = &[
    (j::PELVIS, "hip"),
    (j::SPINE1, "lowerback"),
    (j::SPINE2, "upperback"),
    (j::SPINE3, "thorax"),
    (j::NECK, "lowerneck"),
    (j::HEAD, "head"),
    (j::LEFT_COLLAR, "lclavicle"),
    (j::LEFT_SHOULDER, "lhumerus"),
    (j::LEFT_ELBOW, "lradius"),
    (j::LEFT_WRIST, "lhand"),
    (j::LEFT_HIP, "lfemur"),
    (j::LEFT_KNEE, "ltibia"),
    (j::LEFT_ANKLE, "lfoot"),
    (j::RIGHT_COLLAR, "rclavicle"),
    (j::RIGHT_SHOULDER, "rhumerus"),
    (j::RIGHT_ELBOW, "rradius"),
    (j::RIGHT_WRIST, "rhand"),
    (j::RIGHT_HIP, "rfemur"),
    (j::RIGHT_KNEE, "rtibia"),
    (j::RIGHT_ANKLE, "rfoot"),
];

/// The MotionBuilder-friendly conversion of the CMU database.
const CMU_MB: RigTable = &[
    (j::PELVIS, "Hips"),
    (j::SPINE1, "lowerback"),
    (j::SPINE2, "Chest"),
    (j::SPINE3, "Chest2"),
    (j::NECK, "lowerneck"),
    (j::HEAD, "Head"),
    (j::LEFT_COLLAR, "LeftCollar"),
    (j::LEFT_SHOULDER, "LeftShoulder"),
    (j::LEFT_ELBOW, "LeftElbow"),
    (j::LEFT_WRIST, "lhand"),
    (j::LEFT_HIP, "LeftHip"),
    (j::LEFT_KNEE, "LeftKnee"),
    (j::LEFT_ANKLE, "LeftAnkle"),
    (j::RIGHT_COLLAR, "RightCollar"),
    (j::RIGHT_SHOULDER, "RightShoulder"),
    (j::RIGHT_ELBOW, "RightElbow"),
    (j::RIGHT_WRIST, "rhand"),
    (j::RIGHT_HIP, "RightHip"),
    (j::RIGHT_KNEE, "RightKnee"),
    (j::RIGHT_ANKLE, "RightAnkle"),
];

/// The humanoid of imitation learning: one joint for the whole trunk, no hands.
const DEEPMIMIC: RigTable = &[
    (j::PELVIS, "root"),
    (j::SPINE3, "chest"),
    (j::HEAD, "neck"),
    (j::LEFT_SHOULDER, "left_shoulder"),
    (j::LEFT_ELBOW, "left_elbow"),
    (j::LEFT_HIP, "left_hip"),
    (j::LEFT_KNEE, "left_knee"),
    (j::LEFT_ANKLE, "left_ankle"),
    (j::RIGHT_SHOULDER, "right_shoulder"),
    (j::RIGHT_ELBOW, "right_elbow"),
    (j::RIGHT_HIP, "right_hip"),
    (j::RIGHT_KNEE, "right_knee"),
    (j::RIGHT_ANKLE, "right_ankle"),
];

const RIGS: [RigTable; 4] = [CMU_DAZ, CMU_ASF, CMU_MB, DEEPMIMIC];

/// The trunk from below: joints that a rig lacks turn as evenly between those it has.
const TRUNK: [usize; 6] = [j::PELVIS, j::SPINE1, j::SPINE2, j::SPINE3, j::NECK, j::HEAD];

/// Limbs whose direction is kept: the joint and the one its bone ends at.
const LIMBS: [(usize, usize); 12] = [
    (j::LEFT_HIP, j::LEFT_KNEE),
    (j::LEFT_KNEE, j::LEFT_ANKLE),
    (j::LEFT_ANKLE, j::LEFT_FOOT),
    (j::LEFT_SHOULDER, j::LEFT_ELBOW),
    (j::LEFT_ELBOW, j::LEFT_WRIST),
    (j::LEFT_WRIST, j::LEFT_MIDDLE1),
    (j::RIGHT_HIP, j::RIGHT_KNEE),
    (j::RIGHT_KNEE, j::RIGHT_ANKLE),
    (j::RIGHT_ANKLE, j::RIGHT_FOOT),
    (j::RIGHT_SHOULDER, j::RIGHT_ELBOW),
    (j::RIGHT_ELBOW, j::RIGHT_WRIST),
    (j::RIGHT_WRIST, j::RIGHT_MIDDLE1),
];

/// Which joint of the motion drives each of ours, and the correction of its rest direction.
struct Plan {
    drivers: [Option<(usize, Quat)>; JOINTS],
    scale: f32,
}

/// The motion on a body whose rest joints are `rest` (body frame, metres). Fingers, face and balls of the feet
/// stay at rest; frame rate and path of the pelvis are kept.
///
/// # Errors
/// [`RetargetError::UnknownSkeleton`] when the joints are named as in no known rig, [`RetargetError::NoLegs`] when
/// nothing gives the scale.
pub fn retarget(motion: &RigMotion, rest: &[Vec3; JOINTS]) -> Result<PoseClip, RetargetError> {
    let plan = Plan::new(motion, rest)?;
    let frames = (0..motion.rotations.len()).map(|frame| plan.frame(&motion.world_rotations(frame)));
    Ok(PoseClip {
        name: motion.name.clone(),
        frames: frames.collect(),
        pelvis_m: motion.root.iter().map(|root| *root * plan.scale).collect(),
        frame_seconds: motion.frame_seconds,
    })
}

impl Plan {
    fn new(motion: &RigMotion, rest: &[Vec3; JOINTS]) -> Result<Self, RetargetError> {
        let has_all = |rig: &&RigTable| rig.iter().all(|(_, name)| motion.joint(name).is_some());
        let Some(rig) = RIGS.iter().find(has_all) else {
            let found: Vec<&str> = motion.joints.iter().map(|joint| &*joint.name).collect();
            return Err(RetargetError::UnknownSkeleton {
                motion: motion.name.clone(),
                found: found.join(", "),
            });
        };
        let positions = motion.rest_positions();
        let mut drivers = [None; JOINTS];
        for (ours, name) in *rig {
            drivers[*ours] = motion.joint(name).map(|theirs| (theirs, Quat::IDENTITY));
        }
        for (joint, end) in LIMBS {
            let Some((theirs, _)) = drivers[joint] else { continue };
            let Some(target) = bone_at_rest(motion, &positions, theirs, drivers[end].map(|d| d.0)) else {
                continue;
            };
            let is_foot = matches!(end, j::LEFT_FOOT | j::RIGHT_FOOT);
            drivers[joint] = Some((theirs, turn_between(rest[end] - rest[joint], target, is_foot)));
        }
        let scale = legs_m(rest) / their_legs(motion, &positions, &drivers);
        if !scale.is_finite() {
            return Err(RetargetError::NoLegs { motion: motion.name.clone() });
        }
        Ok(Self { drivers, scale })
    }

    fn frame(&self, theirs: &[Quat]) -> [Vec3; CLIP_JOINTS] {
        let given = |joint: usize| self.drivers[joint].map(|(driver, turn)| theirs[driver] * turn);
        let mut world = [Quat::IDENTITY; JOINTS];
        let mut driven: [Option<Quat>; JOINTS] = std::array::from_fn(given);
        fill_trunk(&mut driven);
        let mut frame = [Vec3::ZERO; CLIP_JOINTS];
        for joint in 0..JOINTS {
            let parent = if joint == 0 { Quat::IDENTITY } else { world[PARENTS[joint]] };
            world[joint] = driven[joint].unwrap_or(parent);
            let local = glam::Mat3::from_quat((parent.inverse() * world[joint]).normalize());
            frame[joint] = rotation::axis_angle_from_matrix(local);
        }
        frame
    }
}

/// Trunk joints that no joint drives turn evenly between the driven ones; above the last one they follow it.
fn fill_trunk(driven: &mut [Option<Quat>; JOINTS]) {
    let mut below = 0;
    for above in 1..TRUNK.len() {
        let (Some(from), Some(to)) = (driven[TRUNK[below]], driven[TRUNK[above]]) else { continue };
        for between in below + 1..above {
            let share = (between - below) as f32 / (above - below) as f32;
            driven[TRUNK[between]] = Some(from.slerp(to, share));
        }
        below = above;
    }
}

/// Direction of a bone at rest: to the joint that drives its end, else to the tip, else to the farthest child.
fn bone_at_rest(motion: &RigMotion, positions: &[Vec3], joint: usize, end: Option<usize>) -> Option<Vec3> {
    let children = motion.joints.iter().enumerate().filter(|(_, child)| child.parent == Some(joint));
    let farthest = children
        .map(|(child, _)| positions[child] - positions[joint])
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let bone = end.map(|end| positions[end] - positions[joint]).or(motion.joints[joint].tip).or(farthest)?;
    (bone.length() > 0.0).then_some(bone)
}

/// Shortest turn from our direction to theirs. Feet are only pitched: the ball of the foot lies inside of the toes'
/// middle in some rigs and outside in others, while the feet point alike.
fn turn_between(ours: Vec3, theirs: Vec3, is_foot: bool) -> Quat {
    let flat = |v: Vec3| if is_foot { v.with_x(0.0) } else { v };
    Quat::from_rotation_arc(flat(ours).normalize_or(Vec3::Z), flat(theirs).normalize_or(Vec3::Z))
}

fn legs_m(rest: &[Vec3; JOINTS]) -> f32 {
    rest[j::LEFT_HIP].distance(rest[j::LEFT_KNEE]) + rest[j::LEFT_KNEE].distance(rest[j::LEFT_ANKLE])
}

fn their_legs(motion: &RigMotion, positions: &[Vec3], drivers: &[Option<(usize, Quat)>; JOINTS]) -> f32 {
    let at = |joint: usize| drivers[joint].map_or(positions[0], |(driver, _)| positions[driver]);
    debug_assert_eq!(positions.len(), motion.joints.len());
    at(j::LEFT_HIP).distance(at(j::LEFT_KNEE)) + at(j::LEFT_KNEE).distance(at(j::LEFT_ANKLE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::RigJoint;
    use crate::body::Body;

    /// A rig of `DEEPMIMIC`'s names with hanging arms, in centimetres, in one frame.
    fn hanging(turns: &[(&str, Quat)]) -> RigMotion {
        let parts: [(&str, Option<usize>, [f32; 3]); 13] = [
            ("root", None, [0.0, 0.0, 0.0]),
            ("chest", Some(0), [0.0, 24.0, 0.0]),
            ("neck", Some(1), [0.0, 22.0, 0.0]),
            ("right_hip", Some(0), [-9.0, 0.0, 0.0]),
            ("right_knee", Some(3), [0.0, -40.0, 0.0]),
            ("right_ankle", Some(4), [0.0, -40.0, 0.0]),
            ("right_shoulder", Some(1), [-18.0, 24.0, 0.0]),
            ("right_elbow", Some(6), [0.0, -27.0, 0.0]),
            ("left_hip", Some(0), [9.0, 0.0, 0.0]),
            ("left_knee", Some(8), [0.0, -40.0, 0.0]),
            ("left_ankle", Some(9), [0.0, -40.0, 0.0]),
            ("left_shoulder", Some(1), [18.0, 24.0, 0.0]),
            ("left_elbow", Some(11), [0.0, -27.0, 0.0]),
        ];
        let tip = |name: &str| match name.split_once('_') {
            Some((_, "elbow")) => Some(Vec3::new(0.0, -25.0, 0.0)),
            Some((_, "ankle")) => Some(Vec3::new(0.0, -5.0, 14.0)),
            _ => None,
        };
        let joint = |(name, parent, offset): (&str, Option<usize>, [f32; 3])| RigJoint {
            name: name.into(),
            parent,
            offset: offset.into(),
            tip: tip(name),
        };
        let joints: Vec<RigJoint> = parts.into_iter().map(joint).collect();
        let turn = |joint: &RigJoint| {
            turns.iter().find(|(name, _)| *name == joint.name).map_or(Quat::IDENTITY, |(_, turn)| *turn)
        };
        let rotations = vec![joints.iter().map(turn).collect()];
        RigMotion { name: "m".into(), rotations, root: vec![Vec3::Y * 83.0], joints, frame_seconds: 0.01 }
    }

    fn posed(clip: &PoseClip) -> [Vec3; JOINTS] {
        let rest = &Body::bundled().model.joint_template;
        let mut world = [glam::Mat3::IDENTITY; JOINTS];
        let mut positions = *rest;
        for joint in 0..JOINTS {
            let local = rotation::matrix_from_axis_angle(clip.frames[0][joint]);
            let parent = PARENTS[joint];
            world[joint] = if joint == 0 { local } else { world[parent] * local };
            if joint > 0 {
                positions[joint] = positions[parent] + world[parent] * (rest[joint] - rest[parent]);
            }
        }
        positions
    }

    #[test]
    fn limbs_point_as_captured_whatever_the_rest_pose() {
        let rest = &Body::bundled().model.joint_template;
        let bent = Quat::from_rotation_x(-80f32.to_radians());
        let clip = retarget(&hanging(&[("left_elbow", bent)]), rest).expect("a clip");
        let p = posed(&clip);
        let along = |a: usize, b: usize| (p[b] - p[a]).normalize_or_zero();
        assert!(along(j::RIGHT_SHOULDER, j::RIGHT_ELBOW).distance(Vec3::NEG_Y) < 1e-3);
        assert!(along(j::LEFT_SHOULDER, j::LEFT_ELBOW).distance(Vec3::NEG_Y) < 1e-3);
        assert!(along(j::LEFT_ELBOW, j::LEFT_WRIST).z > 0.95, "{}", along(j::LEFT_ELBOW, j::LEFT_WRIST));
        assert!(along(j::LEFT_HIP, j::LEFT_KNEE).distance(Vec3::NEG_Y) < 1e-3);
        assert!((clip.pelvis_m[0].y - 0.83 * legs_m(rest) / 0.8).abs() < 1e-4);
        assert_eq!(clip.frame_seconds, 0.01);
    }

    #[test]
    fn one_trunk_joint_is_shared_by_three() {
        let rest = &Body::bundled().model.joint_template;
        let bow = Quat::from_rotation_x(60f32.to_radians());
        let frame = retarget(&hanging(&[("chest", bow)]), rest).expect("a clip").frames[0];
        for joint in [j::SPINE1, j::SPINE2, j::SPINE3] {
            assert!((frame[joint].x.to_degrees() - 20.0).abs() < 0.1, "{}", frame[joint]);
        }
        assert!(frame[j::HEAD].length() < 1e-3);
    }

    #[test]
    fn unknown_skeletons_are_named() {
        let mut motion = hanging(&[]);
        motion.joints[3].name = "tentacle".into();
        let error =
            retarget(&motion, &Body::bundled().model.joint_template).expect_err("unknown").to_string();
        assert!(error.contains("tentacle"), "{error}");
        let mut legless = hanging(&[]);
        for joint in &mut legless.joints {
            joint.offset = Vec3::ZERO;
        }
        let legless = retarget(&legless, &Body::bundled().model.joint_template);
        assert!(matches!(legless, Err(RetargetError::NoLegs { .. })));
    }
}
