//! Writes Biovision hierarchies (BVH): Y up, lengths in the motion's own unit, angles in degrees.

use std::f32::consts::{PI, TAU};
use std::fmt::Write;

use glam::{EulerRot, Quat, Vec3};

use super::rig_motion::RigMotion;

/// The turns that the root's three channels mean, from the outermost: facing is free to go round, and the middle
/// one, whose quarter turn is the singular one, is the tilt to the side.
const ROOT: (EulerRot, [char; 3]) = (EulerRot::YZX, ['Y', 'Z', 'X']);
/// The same of the other joints: knees and hips bend about X, shoulders about Z, so Y is in the middle.
const JOINT: (EulerRot, [char; 3]) = (EulerRot::ZYX, ['Z', 'Y', 'X']);

/// The text of a BVH file. The root has six channels, every other joint three rotations; the root's offset is zero,
/// for programs don't agree whether it counts. Angles go on where those of the frame before ended, so that curves
/// have no jumps of a full turn.
pub fn write_bvh(motion: &RigMotion) -> String {
    let mut text = "HIERARCHY\n".to_owned();
    let mut order = Vec::with_capacity(motion.joints.len());
    if !motion.joints.is_empty() {
        write_joint(&mut text, motion, 0, 0, &mut order);
    }
    let frames = motion.rotations.len().min(motion.root.len());
    line(&mut text, 0, &format!("MOTION\nFrames: {frames}\nFrame Time: {}", motion.frame_seconds));
    let mut last = vec![Vec3::ZERO; motion.joints.len()];
    for frame in 0..frames {
        let mut numbers: Vec<f32> = motion.root[frame].to_array().to_vec();
        for joint in &order {
            let angles = angles_near(motion.rotations[frame][*joint], channels(*joint).0, last[*joint]);
            last[*joint] = angles;
            numbers.extend(angles.to_array().map(f32::to_degrees));
        }
        let words: Vec<String> = numbers.iter().map(|number| format!("{number:.6}")).collect();
        line(&mut text, 0, &words.join(" "));
    }
    text
}

fn channels(joint: usize) -> (EulerRot, [char; 3]) {
    if joint == 0 { ROOT } else { JOINT }
}

fn line(text: &mut String, depth: usize, words: &str) {
    // Writing to a string can't fail.
    let _ = writeln!(text, "{}{words}", "  ".repeat(depth));
}

/// A joint and those below it; `order` gets them in the order of the file, which is that of the numbers.
fn write_joint(text: &mut String, motion: &RigMotion, joint: usize, depth: usize, order: &mut Vec<usize>) {
    order.push(joint);
    let of = &motion.joints[joint];
    let (kind, offset) = if depth == 0 { ("ROOT", Vec3::ZERO) } else { ("JOINT", of.offset) };
    let at = |p: Vec3| format!("OFFSET {:.6} {:.6} {:.6}", p.x, p.y, p.z);
    let turns = channels(joint).1.map(|axis| format!("{axis}rotation")).join(" ");
    line(text, depth, &format!("{kind} {}", of.name));
    line(text, depth, "{");
    line(text, depth + 1, &at(offset));
    let places = if depth == 0 { "6 Xposition Yposition Zposition" } else { "3" };
    line(text, depth + 1, &format!("CHANNELS {places} {turns}"));
    let mut is_last = true;
    for below in (0..motion.joints.len()).filter(|below| motion.joints[*below].parent == Some(joint)) {
        write_joint(text, motion, below, depth + 1, order);
        is_last = false;
    }
    if is_last {
        line(text, depth + 1, "End Site");
        line(text, depth + 1, "{");
        line(text, depth + 2, &at(of.tip.unwrap_or(of.offset)));
        line(text, depth + 1, "}");
    }
    line(text, depth, "}");
}

/// The three angles of a rotation that are nearest to `last`: of the two triples that mean the same, each angle
/// taken modulo a full turn.
fn angles_near(rotation: Quat, order: EulerRot, last: Vec3) -> Vec3 {
    let (a, b, c) = rotation.to_euler(order);
    let near = |angle: f32, last: f32| angle + ((last - angle) / TAU).round() * TAU;
    let unwound =
        |angles: Vec3| Vec3::new(near(angles.x, last.x), near(angles.y, last.y), near(angles.z, last.z));
    let one = unwound(Vec3::new(a, b, c));
    let other = unwound(Vec3::new(a + PI, PI - b, c + PI));
    if one.distance_squared(last) <= other.distance_squared(last) { one } else { other }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::read_bvh;
    use crate::assets::rig_motion::RigJoint;

    fn joint(name: &str, parent: Option<usize>, offset: Vec3) -> RigJoint {
        RigJoint { name: name.into(), parent, offset, tip: None }
    }

    /// Turns through everything, gimbal locks too.
    fn motion() -> RigMotion {
        let turn = |i: usize, j: usize| {
            let t = i as f32 * 0.11 + j as f32;
            Quat::from_rotation_y(t) * Quat::from_rotation_x(1.7 * t) * Quat::from_rotation_z(0.3 * t)
        };
        RigMotion {
            name: "turns".into(),
            joints: vec![
                joint("hips", None, Vec3::ZERO),
                joint("spine", Some(0), Vec3::new(0.0, 0.1, -0.02)),
                joint("leg", Some(0), Vec3::new(0.1, -0.05, 0.0)),
                RigJoint { tip: Some(Vec3::Y * 0.2), ..joint("head", Some(1), Vec3::Y * 0.4) },
            ],
            frame_seconds: 1.0 / 30.0,
            root: (0..200).map(|i| Vec3::new(i as f32 * 0.01, 0.93, -1.0)).collect(),
            rotations: (0..200).map(|i| (0..4).map(|j| turn(i, j)).collect()).collect(),
        }
    }

    #[test]
    fn what_is_written_reads_back_as_the_same_motion() {
        let written = motion();
        let read = read_bvh("turns.bvh", "turns", &write_bvh(&written)).expect("a BVH file");
        let names: Vec<&str> = read.joints.iter().map(|j| &*j.name).collect();
        assert_eq!(names, ["hips", "spine", "head", "leg"], "depth first");
        assert!((read.frame_seconds - written.frame_seconds).abs() < 1e-7);
        assert_eq!(read.joints[2].tip, Some(Vec3::new(0.0, 0.2, 0.0)));
        for frame in 0..200 {
            assert!(read.root[frame].distance(written.root[frame]) < 1e-5);
            for (joint, turn) in read.joints.iter().zip(&read.rotations[frame]) {
                let ours = written.joints.iter().position(|j| j.name == joint.name).expect("the joint");
                let apart = turn.angle_between(written.rotations[frame][ours]);
                assert!(apart < 2e-3, "frame {frame}, {}: {apart} rad apart", joint.name);
            }
        }
    }

    #[test]
    fn angles_go_on_from_frame_to_frame_instead_of_jumping_by_a_turn() {
        let mut turning = motion();
        turning.rotations = (0..200).map(|i| vec![Quat::from_rotation_y(i as f32 * 0.1); 4]).collect();
        let text = write_bvh(&turning);
        let facing: Vec<f32> = text
            .lines()
            .skip_while(|line| !line.starts_with("Frame Time"))
            .skip(1)
            .map(|line| line.split(' ').nth(3).and_then(|word| word.parse().ok()).expect("a number"))
            .collect();
        assert_eq!(facing.len(), 200);
        assert!(facing.windows(2).all(|pair| (pair[1] - pair[0] - 0.1f32.to_degrees()).abs() < 0.01));
    }
}
