//! Reads the motion text of physics-based imitation learning (DeepMimic): JSON with 44 numbers a frame.

use glam::{Mat3, Quat, Vec3};
use serde::Deserialize;

use super::bvh::MotionFileError;
use super::rig_motion::{RigJoint, RigMotion};

/// Numbers of one frame: duration, root position, then the rotations of [`JOINTS`].
const NUMBERS: usize = 44;

/// How many numbers give a joint's rotation.
#[derive(Clone, Copy, PartialEq)]
enum Turn {
    /// A quaternion, w first.
    Ball,
    /// One angle about the figure's sideways axis.
    Hinge,
}

/// The figure: name, parent and offset in metres (x forward, y up, z to the right, arms hanging), rotation.
/// Names, order and offsets are the humanoid's of the format's own character file.
const JOINTS: [(&str, Option<usize>, [f32; 3], Turn); 13] = [
    ("root", None, [0.0, 0.0, 0.0], Turn::Ball),
    ("chest", Some(0), [0.0, 0.236_151, 0.0], Turn::Ball),
    ("neck", Some(1), [0.0, 0.223_894, 0.0], Turn::Ball),
    ("right_hip", Some(0), [0.0, 0.0, 0.084_887], Turn::Ball),
    ("right_knee", Some(3), [0.0, -0.421_546, 0.0], Turn::Hinge),
    ("right_ankle", Some(4), [0.0, -0.409_870, 0.0], Turn::Ball),
    ("right_shoulder", Some(1), [-0.024_050, 0.243_110, 0.183_110], Turn::Ball),
    ("right_elbow", Some(6), [0.0, -0.274_788, 0.0], Turn::Hinge),
    ("left_hip", Some(0), [0.0, 0.0, -0.084_887], Turn::Ball),
    ("left_knee", Some(8), [0.0, -0.421_546, 0.0], Turn::Hinge),
    ("left_ankle", Some(9), [0.0, -0.409_870, 0.0], Turn::Ball),
    ("left_shoulder", Some(1), [-0.024_050, 0.243_110, -0.183_110], Turn::Ball),
    ("left_elbow", Some(11), [0.0, -0.274_788, 0.0], Turn::Hinge),
];

/// Below the elbow: where the hand is.
const FOREARM: [f32; 3] = [0.0, -0.258_947, 0.0];
/// From the ankle along the foot.
const FOOT: [f32; 3] = [0.13, -0.045, 0.0];

#[derive(Deserialize)]
struct MotionText {
    #[serde(rename = "Frames")]
    frames: Vec<Vec<f32>>,
}

/// Reads a motion from the JSON text; `file` stands in errors, `name` becomes the motion's.
///
/// The frame time is the first frame's (in the known files all are alike).
///
/// # Errors
/// [`MotionFileError`] with the line of a fault in the JSON; for a frame of another length or with numbers that
/// are not finite, the frame's number.
pub fn read_deepmimic(file: &str, name: &str, text: &str) -> Result<RigMotion, MotionFileError> {
    let fault = |line: usize, what: String| MotionFileError { file: file.to_owned(), line, what };
    let MotionText { frames } = serde_json::from_str(text)
        .map_err(|e| fault(e.line(), format!("{e}; a motion is JSON with a list `Frames`")))?;
    for (i, frame) in frames.iter().enumerate() {
        if frame.len() != NUMBERS || frame.iter().any(|n| !n.is_finite()) {
            let what = format!("frame {i} has {} numbers; {NUMBERS} finite ones are needed", frame.len());
            return Err(fault(0, what));
        }
    }
    let frame_seconds = frames.first().map_or(0.0, |frame| frame[0]);
    if frame_seconds <= 0.0 {
        return Err(fault(0, "no frame with a positive duration; a motion needs at least one".into()));
    }
    let body = body_from_figure();
    let turned = |v: [f32; 3]| body * Vec3::from_array(v);
    let joint = |(name, parent, offset, _): &(&str, Option<usize>, [f32; 3], Turn)| {
        let tip = match name.split_once('_') {
            Some((_, "elbow")) => Some(turned(FOREARM)),
            Some((_, "ankle")) => Some(turned(FOOT)),
            _ => None,
        };
        RigJoint { name: (*name).to_owned(), parent: *parent, offset: turned(*offset), tip }
    };
    let joints = JOINTS.iter().map(joint).collect();
    let root = frames.iter().map(|frame| body * Vec3::from_slice(&frame[1..4])).collect();
    let rotations = frames.iter().map(|frame| rotations(frame, &body)).collect();
    Ok(RigMotion { name: name.to_owned(), joints, frame_seconds, root, rotations })
}

/// The figure faces +X with its right towards +Z; the body faces +Z with its right towards -X.
fn body_from_figure() -> Mat3 {
    Mat3::from_cols(Vec3::Z, Vec3::Y, Vec3::NEG_X)
}

fn rotations(frame: &[f32], body: &Mat3) -> Vec<Quat> {
    let mut at = 4;
    let turns = JOINTS.iter().map(|(_, _, _, turn)| match turn {
        Turn::Ball => {
            let [w, x, y, z] = [frame[at], frame[at + 1], frame[at + 2], frame[at + 3]];
            at += 4;
            let axis = *body * Vec3::new(x, y, z);
            let length = (w * w + axis.length_squared()).sqrt();
            let turn = Quat::from_xyzw(axis.x / length, axis.y / length, axis.z / length, w / length);
            if length > 1e-3 { turn } else { Quat::IDENTITY }
        }
        Turn::Hinge => {
            let angle = frame[at];
            at += 1;
            Quat::from_axis_angle(*body * Vec3::Z, angle)
        }
    });
    turns.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(change: impl Fn(&mut Vec<f32>)) -> String {
        let mut frame = vec![0.0f32; NUMBERS];
        frame[0] = 0.02;
        frame[1..4].copy_from_slice(&[1.0, 0.9, 2.0]);
        let mut at = 4;
        for (_, _, _, turn) in JOINTS {
            if turn == Turn::Ball {
                frame[at] = 1.0;
            }
            at += if turn == Turn::Ball { 4 } else { 1 };
        }
        assert_eq!(at, NUMBERS);
        change(&mut frame);
        format!("{{\"Loop\": \"none\",\n\"Frames\": [{frame:?}]}}")
    }

    #[test]
    fn knees_bend_back_and_elbows_forward_in_the_bodys_axes() {
        // Knee and elbow of the right side are numbers 20 and 29 of a frame.
        let motion = text(|frame| {
            frame[20] = -1.0;
            frame[29] = 1.0;
        });
        let motion = read_deepmimic("m.txt", "m", &motion).expect("a motion");
        assert_eq!(motion.root[0], Vec3::new(-2.0, 0.9, 1.0));
        let world = motion.world_rotations(0);
        let rest = motion.rest_positions();
        let right = |name: &str| motion.joint(name).expect("a joint");
        assert!(rest[right("right_hip")].x < -0.05 && rest[right("left_shoulder")].x > 0.1);
        let shin = world[right("right_knee")] * Vec3::NEG_Y;
        let forearm = world[right("right_elbow")] * Vec3::NEG_Y;
        assert!(shin.z < -0.8 && forearm.z > 0.8, "{shin} {forearm}");
    }

    #[test]
    fn faults_say_where() {
        let short = text(|frame| frame.truncate(43));
        let error = read_deepmimic("m.txt", "m", &short).expect_err("too short").to_string();
        assert!(error.contains("m.txt") && error.contains("frame 0 has 43"), "{error}");
        let broken = text(|_| ()).replace("[[", "[[x");
        assert_eq!(read_deepmimic("m.txt", "m", &broken).expect_err("no JSON").line, 2);
        let still = text(|frame| frame[0] = 0.0);
        assert!(read_deepmimic("m.txt", "m", &still).is_err());
    }
}
