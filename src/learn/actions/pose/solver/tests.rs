use super::super::{JointPlacer, coco, family_poses};
use super::*;
use crate::body::Body;
use crate::inspect::{Similarity, mean_distance_mm};
use crate::job::{Seed, Ticker};

/// Poses of the families, as the camera sees them: joints in the camera's frame, metres, and in a photo of 100 pixels
/// a metre.
fn seen_people(each: usize, seed: u64) -> Vec<(Joints3, [Keypoint; PHOTO_JOINTS])> {
    use rand::RngExt as _;
    let body = Body::bundled();
    let poses = family_poses(body, each, Seed::root(seed), &Ticker::silent()).expect("drawn");
    let mut placer = JointPlacer::new(body);
    let mut rng = Seed::root(seed).child("cameras", 0).rng();
    let mut person = |pose| {
        let yaw: f32 = rng.random_range(-3.1..3.1);
        let turn = Mat3::from_rotation_x(rng.random_range(0.0..0.4)) * Mat3::from_rotation_y(yaw);
        let joints = placer.joints(pose).map(|p| turn * p);
        (joints, joints.map(|p| Keypoint { pixel: Vec2::new(p.x, -p.y) * 100.0, confidence: 1.0 }))
    };
    poses.iter().map(&mut person).collect()
}

fn solver() -> PoseSolver<'static> {
    PoseSolver::new(PoseDictionary::bundled(), PoseSolverConfig::default())
}

#[test]
fn people_are_found_in_space_from_all_their_joints() {
    let errors: Vec<f32> = seen_people(12, 5)
        .iter()
        .map(|(truth, marks)| {
            let found = solver().solve(marks).expect("a pose").joints_px;
            mean_distance_mm(&Similarity::between(&found, truth).apply(&found), truth)
        })
        .collect();
    let mean = errors.iter().sum::<f32>() / errors.len() as f32;
    assert!(mean < 70.0, "{mean} mm");
}

#[test]
fn the_facing_is_told_with_and_without_legs() {
    let facing = |joints: &Joints3| {
        let right = joints[coco::RIGHT_SHOULDER] - joints[coco::LEFT_SHOULDER];
        right.z.atan2(-right.x)
    };
    for hidden in [false, true] {
        let people = seen_people(12, 6);
        let off: Vec<f32> = people
            .iter()
            .map(|(truth, marks)| {
                let mut marks = *marks;
                if hidden {
                    (coco::LEFT_KNEE..=coco::RIGHT_ANKLE).for_each(|j| marks[j] = Keypoint::default());
                }
                let found = solver().solve(&marks).expect("a pose").joints_px;
                let turn = facing(&found) - facing(truth);
                turn.sin().atan2(turn.cos()).abs().to_degrees()
            })
            .collect();
        let right = off.iter().filter(|d| **d < 30.0).count() as f32 / off.len() as f32;
        assert!(right > 0.8, "hidden legs {hidden}: {right} within 30 degrees");
    }
}

#[test]
fn a_pose_is_seen_where_its_joints_were_marked() {
    for (_, marks) in seen_people(2, 7) {
        let pose = solver().solve(&marks).expect("a pose");
        assert!(pose.misfit < 0.12 && pose.marked.iter().all(|m| *m), "{}", pose.misfit);
        assert!(pose.torso_px() > 10.0);
    }
}

#[test]
fn too_few_joints_or_all_in_one_place_give_no_pose() {
    let (_, mut marks) = seen_people(1, 8).remove(0);
    assert!(solver().solve(&[Keypoint { pixel: Vec2::ONE, confidence: 1.0 }; PHOTO_JOINTS]).is_none());
    marks[SOLVED_JOINTS_LEAST - 1..].fill(Keypoint::default());
    assert!(solver().solve(&marks).is_none());
}

#[test]
fn the_same_joints_give_the_same_pose() {
    let (_, marks) = seen_people(1, 9).remove(0);
    assert_eq!(solver().solve(&marks), solver().solve(&marks));
}
