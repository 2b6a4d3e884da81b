//! Every metric against a case worked by hand.

use std::ops::ControlFlow;

use glam::{Quat, Vec3};

use super::*;
use crate::body::{Body, TREADS};
use crate::inspect::Metric;
use crate::scene::{BETAS, CLIP_FPS, Clip, Frame, Leg, SignedDistanceField, SubGoal};

/// A floor at height 0, free space above.
fn floor() -> SignedDistanceField {
    let dim = [9, 17, 9];
    let (origin, cell_m) = (Vec3::new(-4.0, -1.0, -4.0), Vec3::new(1.0, 0.25, 1.0));
    let mut field = SignedDistanceField { dim, origin, cell_m, values: vec![0.0; dim.iter().product()] };
    for i in 0..field.values.len() {
        let y = i / dim[2] % dim[1];
        field.values[i] = origin.y + y as f32 * cell_m.y;
    }
    field
}

/// Somebody who stands on the floor, as still as the T-pose.
fn standing() -> Frame {
    let frame = Frame::default();
    let posed = Body::bundled().pose_axis_angles(&frame.params(&[0.0; BETAS]), &frame.pose);
    let lowest = posed.vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
    Frame { translation: Vec3::Y * (0.001 - lowest), ..frame }
}

fn moved(by: Vec3) -> Frame {
    let frame = standing();
    Frame { translation: frame.translation + by, ..frame }
}

fn clip(frames: Vec<Frame>) -> Clip {
    Clip { planted: vec![[true; 2]; frames.len()], frames, fps: CLIP_FPS, ..Clip::default() }
}

fn measure(clip: &Clip) -> MotionReport {
    inspect_motion(&floor(), Body::bundled(), clip, &|_, _| ControlFlow::Continue(())).expect("not stopped")
}

#[test]
fn somebody_who_stands_still_has_no_fault() {
    let report = measure(&clip(vec![standing(); 8]));
    let m = report.metrics;
    assert_eq!((m.non_collision_pct, m.contact_pct, m.psi_contact_pct), (100.0, 100.0, 0.0));
    assert_eq!((m.skate_cm_per_s, m.stance_drift_cm, m.penetration_max_mm), (0.0, 0.0, 0.0));
    assert_eq!((m.goal_error_cm, m.collision_frame_share), (None, 0.0));
    assert!(m.jitter_m_per_s3 < 0.01, "rounding only: {}", m.jitter_m_per_s3);
    assert!(m.hover_max_mm < 20.0, "{m:?}");
    assert!(report.findings(0, &MotionLimits::default()).is_empty());
}

#[test]
fn a_centimetre_a_frame_is_30_cm_a_second_and_seven_steps_drift_seven() {
    let mut clip = clip((0..8).map(|i| moved(Vec3::X * 0.01 * i as f32)).collect());
    let m = measure(&clip).metrics;
    assert!((m.skate_cm_per_s - 30.0).abs() < 0.01 && (m.stance_drift_cm - 7.0).abs() < 0.01, "{m:?}");
    assert_eq!(m.skate_frame_share, 1.0);
    // A foot in the air may move; of the left one only the last three steps are planted ones.
    clip.planted = (0..8).map(|i| [i >= 4, false]).collect();
    let report = measure(&clip);
    assert!((report.metrics.stance_drift_cm - 3.0).abs() < 0.01, "{:?}", report.metrics);
    assert_eq!(report.frames[4].skate_cm_per_s, [0.0; 2], "it was put down there");
    assert!((report.frames[5].skate_cm_per_s[0] - 30.0).abs() < 0.01);
    let findings = report.findings(7, &MotionLimits::default());
    assert!(findings.iter().any(|f| f.metric == Metric::SkateCmPerS && f.site.frame == Some(5)));
    assert!(findings.iter().any(|f| f.metric == Metric::StanceDriftCm && f.site.frame.is_none()));
}

#[test]
fn a_foot_that_rolls_from_heel_to_toes_does_not_slide() {
    // The ball comes down while the heel stands, then the heel leaves while the ball stands.
    let foot = |heel: f32, ball: f32| [Vec3::X * heel, Vec3::X * ball, Vec3::X * (ball + 0.05)];
    let roll = [foot(0.0, 0.14), foot(0.0, 0.17), foot(0.0, 0.18), foot(0.03, 0.18), foot(0.07, 0.18)];
    assert_eq!(stance_drift_m(&roll), 0.0);
    assert_eq!(tread_speed_m_per_s(&roll[0], &roll[1], 30.0), 0.0);
    let slides: Vec<[Vec3; TREADS]> = (0..4).map(|i| foot(0.01 * i as f32, 0.15 + 0.01 * i as f32)).collect();
    assert!((stance_drift_m(&slides) - 0.03).abs() < 1e-6);
    // To and fro: the farthest point counts, not the end.
    assert!((stance_drift_m(&[slides[0], slides[2], slides[0]]) - 0.02).abs() < 1e-6);
}

#[test]
fn a_body_sunk_by_five_centimetres_is_measured_so() {
    let frames = vec![standing(), moved(Vec3::Y * -0.05)];
    let report = measure(&clip(frames));
    let m = report.metrics;
    assert!((m.penetration_max_mm - 49.0).abs() < 0.1 && m.collision_frame_share == 0.5, "{m:?}");
    assert_eq!((m.psi_contact_pct, m.contact_pct), (50.0, 100.0));
    assert!(m.penetration_mean_mm > 10.0 && m.penetration_mean_mm < 49.0);
    let share = report.frames[1].non_collision;
    assert!((m.non_collision_pct - 50.0 * (1.0 + share)).abs() < 1e-3 && share < 1.0);
}

#[test]
fn a_foot_in_the_air_hovers_only_while_it_is_called_planted() {
    let mut hovering = clip(vec![moved(Vec3::Y * 0.06)]);
    let m = measure(&hovering).metrics;
    assert!((60.0..75.0).contains(&m.hover_max_mm) && m.contact_pct == 0.0, "{m:?}");
    hovering.planted = vec![[false; 2]];
    assert_eq!(measure(&hovering).metrics.hover_max_mm, 0.0);
}

#[test]
fn jitter_is_the_third_derivative() {
    // x = t³ has the third derivative 6 everywhere, and its third difference is exact.
    let cubic = |i: usize| moved(Vec3::X * (i as f32 / CLIP_FPS).powi(3));
    let m = measure(&clip((0..10).map(cubic).collect())).metrics;
    assert!((m.jitter_m_per_s3 - 6.0).abs() < 0.1, "{}", m.jitter_m_per_s3);
}

#[test]
fn a_jump_between_two_legs_stands_out() {
    let walk = |jump: f32| {
        let frames = (0..12).map(|i| moved(Vec3::X * (0.02 * i as f32 + if i > 6 { jump } else { 0.0 })));
        let (a, b) = (SubGoalId(0), SubGoalId(1));
        let leg = |from, to, first, last| Leg { from, to, first, last, key: 1 };
        Clip { legs: vec![leg(a, b, 0, 6), leg(b, a, 6, 11)], ..clip(frames.collect()) }
    };
    let ratio = |jump| measure(&walk(jump)).metrics.boundary_speed_ratio.expect("two legs");
    assert!((ratio(0.0) - 1.0).abs() < 1e-3, "{}", ratio(0.0));
    // 2 cm a step everywhere, 5 cm at the boundary.
    assert!((ratio(0.03) - 2.5).abs() < 1e-3, "{}", ratio(0.03));
}

#[test]
fn a_goal_is_missed_by_its_distance_along_the_floor_and_by_its_angle() {
    let goal = |id, at: Vec3, facing: f32, body| SubGoal {
        id: SubGoalId(id),
        at,
        facing: Some(facing),
        pose: GoalPose::Stand,
        stay_s: 0.0,
        planned: false,
        locked: false,
        body,
    };
    let pelvis = |frame: &Frame| Body::bundled().model.joint_template[PELVIS] + frame.translation;
    let mut end = moved(Vec3::X * 0.5);
    end.rotation = Quat::from_rotation_y(0.3);
    let start = standing();
    let off_body = Frame { translation: end.translation + Vec3::Z * 0.07, ..end.clone() };
    let goals = vec![
        goal(0, pelvis(&start).with_y(0.0), 0.0, Some(start.clone())),
        goal(
            1,
            pelvis(&end).with_y(0.0) + Vec3::new(0.03, 0.0, 0.04),
            0.3 + 10.0_f32.to_radians(),
            Some(off_body),
        ),
    ];
    let legs = vec![Leg { from: SubGoalId(0), to: SubGoalId(1), first: 0, last: 1, key: 1 }];
    let clip = Clip { goals, legs, ..clip(vec![start, end]) };
    let report = measure(&clip);
    assert!((report.metrics.goal_error_cm.expect("goals") - 5.0).abs() < 0.01);
    assert!((report.metrics.goal_error_deg.expect("facings") - 10.0).abs() < 0.1);
    assert_eq!((report.goals[0].frame, report.goals[1].frame), (0, 1));
    // One end is on its body, the other 7 cm off.
    assert!((report.metrics.neighbour_v2v.expect("bodies") - 3.5).abs() < 0.01);
}

#[test]
fn a_motion_three_centimetres_beside_the_truth_is_30_mm_off() {
    let truth = vec![standing(), moved(Vec3::X)];
    let mut motion: Vec<Frame> =
        truth.iter().map(|f| Frame { translation: f.translation + Vec3::Z * 0.03, ..f.clone() }).collect();
    let errors = MotionErrors::of(Body::bundled(), &[0.0; BETAS], &motion, &truth);
    assert!((errors.mpjpe_mm - 30.0).abs() < 0.01 && (errors.mpvpe_mm - 30.0).abs() < 0.01, "{errors:?}");
    assert!((errors.translation_l1_x100 - 1.0).abs() < 1e-3 && errors.orientation_l1_x100 == 0.0);
    // Turned by 0.3 about Y: of the six numbers cos - 1, sin, 0 differ in the first column, none in the second.
    motion[0].rotation = Quat::from_rotation_y(0.3);
    motion[0].pose[4].x += 0.63;
    let errors = MotionErrors::of(Body::bundled(), &[0.0; BETAS], &motion, &truth);
    let by_hand = 0.5 * 100.0 * ((1.0 - 0.3_f32.cos()) + 0.3_f32.sin()) / 6.0;
    assert!((errors.orientation_l1_x100 - by_hand).abs() < 1e-3, "{errors:?} against {by_hand}");
    assert!((errors.pose_l1_x100 - 0.5 * 100.0 * 0.63 / 63.0).abs() < 1e-3, "{errors:?}");
}

#[test]
fn a_measurement_that_is_told_to_stop_stops() {
    let stop = |_, _| ControlFlow::Break(());
    assert!(inspect_motion(&floor(), Body::bundled(), &clip(vec![standing()]), &stop).is_err());
}

#[test]
fn a_frame_that_is_not_a_number_is_a_finding_and_the_others_are_still_measured() {
    let broken = Frame { translation: Vec3::splat(f32::NAN), ..standing() };
    let report = measure(&clip(vec![standing(), broken, moved(Vec3::Y * -0.05)]));
    assert!(report.frames[1].not_finite > 0 && report.frames[2].penetration_max_mm > 40.0);
    let findings = report.findings(0, &MotionLimits::default());
    assert_eq!((findings[0].metric, findings[0].site.frame), (Metric::NotFinite, Some(1)));
}
