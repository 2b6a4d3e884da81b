//! What somebody who watches a leg would miss.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Mat3, Vec2, Vec3};
use rand::SeedableRng as _;

use super::*;
use crate::body::joints as j;
use crate::body::{FamilyHints, FrameJoints, Limb, Region, sample_pose};
use crate::motion::leg::PathPoint;
use crate::scene::{CLIP_FPS, PoseFamily, facing_of};

const BETAS_OF_MEAN: [f32; BETAS] = [0.0; BETAS];

fn body() -> &'static Body {
    Body::bundled()
}

/// A way through points, 8 cm apart.
fn way(points: &[Vec3]) -> Vec<PathPoint> {
    let mut path = Vec::new();
    for pair in points.windows(2) {
        let steps = (pair[0].distance(pair[1]) / 0.08).ceil();
        let along = pair[1] - pair[0];
        let heading = facing_of(Vec2::new(along.x, along.z));
        let at = |k: f32| pair[0] + along * (k / steps);
        path.extend((0..=steps as usize).map(|k| point(at(k as f32), heading)));
    }
    if path.is_empty() { points.iter().map(|p| point(*p, 0.0)).collect() } else { path }
}

fn point(at: Vec3, heading: f32) -> PathPoint {
    PathPoint { at, heading, clearance_m: 1.0, speed_m_per_s: 1.15 }
}

fn stands(at: Vec3, facing: f32, seed: u64) -> EndState {
    let feet = natural_feet(body(), &BETAS_OF_MEAN, at, facing);
    let frame = standing_frame(body(), &BETAS_OF_MEAN, &feet, Seed::root(seed));
    EndState::Still(Still { frame, pose: GoalPose::Stand })
}

fn walks(at: Vec3, heading: f32, speed_m_per_s: f32) -> EndState {
    EndState::Walking(Walking { at, heading, speed_m_per_s })
}

/// A drawn body whose lowest vertex is `surface_m` above the floor.
fn rests(family: PoseFamily, pose: GoalPose, at: Vec3, facing: f32, surface_m: f32) -> EndState {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
    let hints = FamilyHints { seat_height_m: Some(0.45), ..FamilyHints::default() };
    let sampled = sample_pose(&body().model.joint_template, family, &mut rng, &hints);
    let params = sampled.params(body(), BETAS_OF_MEAN, &Mat3::from_rotation_y(facing));
    let mut frame = Frame::of(&params, &body().pose_space.decode(&params.pose));
    frame.translation = at;
    let posed = body().pose_axis_angles(&frame.params(&BETAS_OF_MEAN), &frame.pose);
    frame.translation.y += surface_m - posed.vertices.iter().map(|v| v.y).fold(f32::MAX, f32::min);
    EndState::Still(Still { frame, pose })
}

/// The same body higher up, its feet hanging with the toes down.
fn hanging(rest: EndState, up_m: f32) -> EndState {
    let EndState::Still(mut still) = rest else { return rest };
    still.frame.translation.y += up_m;
    for ankle in [j::LEFT_ANKLE, j::RIGHT_ANKLE] {
        still.frame.pose[ankle - 1].x += 0.5;
    }
    EndState::Still(still)
}

fn input(from: EndState, to: EndState, points: &[Vec3], seed: u64) -> LegInput {
    LegInput { from, to, path: way(points), betas: BETAS_OF_MEAN, seconds: None, seed: Seed::root(seed) }
}

fn made(input: &LegInput) -> LegMotion {
    synthesise_leg(body(), input, &Ticker::silent()).expect("nobody cancels")
}

fn joints_of(motion: &LegMotion) -> Vec<FrameJoints> {
    let rest = body().model.rest_joints(&BETAS_OF_MEAN);
    motion.frames.iter().map(|frame| FrameJoints::of(&rest, frame)).collect()
}

/// Legs of every kind: straight, round a corner, short, turning, sitting down and getting up, lying down.
fn legs() -> Vec<(&'static str, LegInput)> {
    let v = Vec3::new;
    let sits = || rests(PoseFamily::SitChair, GoalPose::Sit, v(0.0, 0.0, -0.42), 0.0, 0.0);
    let lies = || rests(PoseFamily::LieUp, GoalPose::Lie, v(0.1, 0.0, -0.75), FRAC_PI_2, 0.5);
    let o = Vec3::ZERO;
    vec![
        ("straight", input(stands(o, 0.0, 1), stands(v(0.0, 0.0, 4.0), 0.0, 2), &[o, v(0.0, 0.0, 4.0)], 1)),
        (
            "round a corner",
            input(
                stands(o, PI, 1),
                stands(v(2.0, 0.0, 2.0), PI, 2),
                &[o, v(0.1, 0.0, 1.4), v(0.5, 0.0, 1.9), v(2.0, 0.0, 2.0)],
                2,
            ),
        ),
        ("short", input(stands(o, 0.0, 1), stands(v(0.0, 0.0, 0.8), 0.3, 2), &[o, v(0.0, 0.0, 0.8)], 3)),
        ("turning", input(stands(o, 0.0, 1), stands(o, PI, 2), &[o], 4)),
        ("through", input(walks(o, 0.0, 1.1), walks(v(0.0, 0.0, 2.5), 0.0, 1.1), &[o, v(0.0, 0.0, 2.5)], 5)),
        ("sitting down", input(stands(v(0.0, 0.0, 1.5), PI, 1), sits(), &[v(0.0, 0.0, 1.5), o], 6)),
        ("on a high seat", input(stands(o, 0.1, 1), hanging(sits(), 0.15), &[o], 6)),
        ("getting up", input(sits(), stands(v(0.0, 0.0, 0.02), 0.0, 2), &[o], 7)),
        ("lying down", input(stands(o, 0.2, 1), lies(), &[o], 8)),
    ]
}

#[test]
fn the_bundled_model_walks_as_people_do() {
    let model = GaitModel::bundled();
    assert!(model.strides >= 40 && model.to_ron().is_ok());
    let pace = Pace::new(1.2, 0.816, 0.0);
    let step = model.step_length_share(pace) * 0.816;
    assert!((0.55..0.75).contains(&step), "a step of {step} m at 1.2 m/s");
    assert!((0.55..0.68).contains(&model.duty(pace)));
    let [slow, fast] = [0.7, 1.5].map(|v| model.step_length_share(Pace::new(v, 0.816, 0.0)));
    assert!(slow < fast, "faster walks have longer steps");
    assert!(GaitModel::from_ron("(strides: 1)").is_err());
}

#[test]
fn planted_feet_stay_and_stand_on_the_floor() {
    let soles = [Region::LeftLeg, Region::RightLeg].map(|r| body().regions.vertices(r).to_vec());
    for (name, input) in legs() {
        let motion = made(&input);
        let joints = joints_of(&motion);
        for (foot, limb) in Limb::LEGS.iter().enumerate() {
            let mut from: Option<Vec3> = None;
            for (i, frame) in motion.frames.iter().enumerate() {
                if !motion.planted[i][foot] {
                    from = None;
                    continue;
                }
                let ankle = joints[i].positions[limb.end];
                let moved = from.get_or_insert(ankle).distance(ankle);
                assert!(moved < 0.01, "{name}: foot {foot} slides by {moved} m until frame {i}");
                let posed = body().pose_axis_angles(&frame.params(&BETAS_OF_MEAN), &frame.pose);
                let sole = soles[foot].iter().map(|v| posed.vertices[*v as usize].y).fold(f32::MAX, f32::min);
                assert!(sole.abs() < 0.01, "{name}: a planted sole is {sole} m above the floor in frame {i}");
            }
        }
    }
}

#[test]
fn somebody_who_stands_or_walks_has_a_foot_on_the_floor_in_every_frame() {
    for (name, input) in legs().into_iter().take(5) {
        for (i, posed) in joints_of(&made(&input)).iter().enumerate() {
            let lowest = [j::LEFT_FOOT, j::RIGHT_FOOT, j::LEFT_ANKLE, j::RIGHT_ANKLE]
                .map(|joint| posed.positions[joint].y)
                .into_iter()
                .fold(f32::MAX, f32::min);
            assert!(lowest < 0.06, "{name}: the lower foot is {lowest} m high in frame {i}");
        }
    }
}

#[test]
fn knees_bend_forward_only_and_legs_keep_their_length() {
    for (name, input) in legs() {
        let motion = made(&input);
        for (i, frame) in motion.frames.iter().enumerate() {
            for knee in [j::LEFT_KNEE, j::RIGHT_KNEE] {
                let bend = frame.pose[knee - 1].x.to_degrees();
                assert!((-8.0..150.0).contains(&bend), "{name}: a knee bends by {bend} degrees in frame {i}");
            }
            assert!(frame.is_finite());
        }
    }
}

#[test]
fn knees_give_a_little_when_a_foot_has_landed_and_do_not_snap_straight_before() {
    let knees = [j::LEFT_KNEE, j::RIGHT_KNEE];
    for (name, input) in legs().into_iter().filter(|(name, _)| ["straight", "through"].contains(name)) {
        let motion = made(&input);
        let bend = |i: usize, foot: usize| motion.frames[i].pose[knees[foot] - 1].x.to_degrees();
        for i in 1..motion.frames.len() {
            for foot in 0..2 {
                let stretched = bend(i - 1, foot) - bend(i, foot);
                assert!(stretched < 27.0, "{name}: a knee straightens by {stretched} degrees in frame {i}");
                let landed = motion.planted[i][foot] && !motion.planted[i - 1][foot];
                let after = i..(i + 6).min(motion.frames.len());
                let most = after.map(|k| bend(k, foot)).fold(0.0, f32::max);
                assert!(!landed || most < 25.0, "{name}: a knee gives by {most} degrees after frame {i}");
            }
        }
    }
}

#[test]
fn a_leg_begins_and_ends_exactly_at_its_ends_and_at_rest() {
    for (name, input) in legs() {
        let motion = made(&input);
        let joints = joints_of(&motion);
        let last = motion.frames.len() - 1;
        for (end, at, next) in [(&input.from, 0, 1), (&input.to, last, last - 1)] {
            match end {
                EndState::Still(still) => {
                    assert_eq!(motion.frames[at], still.frame, "{name}");
                    let speed = speed(&joints[at], &joints[next]);
                    assert!(speed < 0.12, "{name}: {speed} m/s beside a rest");
                }
                EndState::Walking(state) => {
                    assert_eq!(motion.frames[at], walking_frame(body(), &BETAS_OF_MEAN, state), "{name}");
                }
            }
        }
        assert_eq!(motion.frames.len(), motion.planted.len());
    }
}

/// The fastest joint between two frames, metres per second.
fn speed(a: &FrameJoints, b: &FrameJoints) -> f32 {
    let apart = a.positions.iter().zip(&b.positions).map(|(a, b)| a.distance(*b));
    apart.fold(0.0, f32::max) * CLIP_FPS
}

#[test]
fn two_legs_of_a_walk_meet_without_a_pop() {
    let v = Vec3::new;
    let middle = walks(v(0.0, 0.0, 2.5), 0.0, 1.1);
    let first = input(stands(Vec3::ZERO, 0.0, 1), middle.clone(), &[Vec3::ZERO, v(0.0, 0.0, 2.5)], 1);
    let second = input(middle, walks(v(0.0, 0.0, 5.2), 0.0, 1.1), &[v(0.0, 0.0, 2.5), v(0.0, 0.0, 5.2)], 2);
    let (a, b) = (joints_of(&made(&first)), joints_of(&made(&second)));
    let n = a.len();
    for joint in [j::PELVIS, j::HEAD, j::LEFT_WRIST, j::RIGHT_WRIST] {
        let before = (a[n - 1].positions[joint] - a[n - 2].positions[joint]) * CLIP_FPS;
        let after = (b[1].positions[joint] - b[0].positions[joint]) * CLIP_FPS;
        let jump = before.distance(after);
        assert!(
            jump < 0.35,
            "{}: the velocity jumps by {jump} m/s from {before} to {after}",
            j::NAMES[joint]
        );
    }
}

#[test]
fn nothing_pops_on_the_way() {
    for (name, input) in legs() {
        let joints = joints_of(&made(&input));
        for (i, window) in joints.windows(3).enumerate() {
            for joint in [j::PELVIS, j::HEAD, j::LEFT_WRIST, j::RIGHT_ANKLE] {
                let [a, b, c] = [0, 1, 2].map(|k| window[k].positions[joint]);
                let acceleration = (a - 2.0 * b + c).length() * CLIP_FPS * CLIP_FPS;
                assert!(
                    acceleration < 90.0,
                    "{name}: {} at {acceleration} m/s² in frame {i}",
                    j::NAMES[joint]
                );
            }
        }
    }
}

#[test]
fn nothing_pops_on_any_way_between_any_stances() {
    for case in 0..60u8 {
        let (x, turn) = (f32::from(case), f32::from(case % 7) - 3.0);
        let to = Vec3::new((0.7 * x).sin(), 0.0, 1.0 + 0.05 * x);
        let from = if case % 3 == 0 { walks(Vec3::ZERO, 0.0, 0.8) } else { stands(Vec3::ZERO, turn, 1) };
        let leg = input(from, stands(to, 0.4 * x, 2), &[Vec3::ZERO, to], u64::from(case));
        for (i, window) in joints_of(&made(&leg)).windows(3).enumerate() {
            let [a, b, c] = [0, 1, 2].map(|k| window[k].positions[j::LEFT_FOOT]);
            let acceleration = (a - 2.0 * b + c).length() * CLIP_FPS * CLIP_FPS;
            assert!(acceleration < 180.0, "way {case}: a foot at {acceleration} m/s² in frame {i}");
        }
    }
}

#[test]
fn the_body_stays_upright_in_walking_and_arms_swing_against_the_legs() {
    let (_, input) = legs().swap_remove(0);
    let joints = joints_of(&made(&input));
    let mut against = 0.0;
    for posed in &joints {
        let trunk = posed.positions[j::NECK] - posed.positions[j::PELVIS];
        assert!(trunk.angle_between(Vec3::Y) < 0.3, "{trunk}");
        let apart = |left: usize, right: usize| posed.positions[left].z - posed.positions[right].z;
        against += apart(j::LEFT_ANKLE, j::RIGHT_ANKLE) * apart(j::LEFT_WRIST, j::RIGHT_WRIST);
    }
    assert!(against < 0.0, "arms swing with the legs: {against}");
}

#[test]
fn turning_on_the_spot_faces_where_it_should_without_travelling() {
    for turn in [PI, -FRAC_PI_2, 0.7] {
        let input = input(stands(Vec3::ZERO, 0.0, 1), stands(Vec3::ZERO, turn, 2), &[Vec3::ZERO], 9);
        let motion = made(&input);
        let last = &motion.frames[motion.frames.len() - 1];
        let front = last.rotation * Vec3::Z;
        assert!(figure::wrap(facing_of(Vec2::new(front.x, front.z)) - turn).abs() < 0.05);
        let seconds = (motion.frames.len() - 1) as f32 / CLIP_FPS;
        assert!((0.8..2.6).contains(&seconds), "a turn of {turn} takes {seconds} s");
        for posed in joints_of(&motion) {
            assert!(posed.positions[0].with_y(0.0).length() < 0.15, "wanders to {}", posed.positions[0]);
        }
    }
}

#[test]
fn who_stands_before_a_seat_sits_down_without_another_step() {
    for up_m in [0.0, 0.15] {
        let sits = rests(PoseFamily::SitChair, GoalPose::Sit, Vec3::new(0.0, 0.0, -0.42), 0.0, 0.0);
        let sits = if up_m > 0.0 { hanging(sits, up_m) } else { sits };
        let EndState::Still(seat) = &sits else { panic!("a rest") };
        let feet = feet_before(body(), &BETAS_OF_MEAN, &seat.frame, 0.0);
        let frame = standing_frame(body(), &BETAS_OF_MEAN, &feet, Seed::root(1));
        let stands = EndState::Still(Still { frame, pose: GoalPose::Stand });
        let at = 0.5 * (feet[0].at + feet[1].at);
        let motion = made(&input(stands, sits, &[at], 6));
        let seconds = (motion.frames.len() - 1) as f32 / CLIP_FPS;
        assert!(seconds < 3.2, "{seconds} s to sit down on a seat {up_m} m too high");
        let lifted = motion.planted.iter().position(|p| *p != [true; 2]).unwrap_or(motion.planted.len());
        assert!(lifted as f32 > CLIP_FPS, "a foot leaves the floor in frame {lifted}");
    }
}

#[test]
fn who_stands_beside_a_seat_at_a_table_comes_in_from_the_side_upright() {
    let sits = rests(PoseFamily::SitChair, GoalPose::Sit, Vec3::ZERO, 0.0, 0.0);
    let motion = made(&input(stands(Vec3::new(0.5, 0.0, 0.2), 0.0, 1), sits, &[Vec3::new(0.5, 0.0, 0.2)], 6));
    let joints = joints_of(&motion);
    let furthest = joints.iter().map(|p| p.positions[j::PELVIS].z).fold(f32::MIN, f32::max);
    assert!(furthest < 0.3, "goes {furthest} m ahead of the seat, where the table is");
    let lean = |p: &FrameJoints| (p.rotations[j::SPINE3] * Vec3::Y).z.asin().to_degrees();
    let most = joints.iter().map(lean).fold(0.0, f32::max);
    assert!(most < 30.0, "the trunk leans by {most} degrees over the table");
}

#[test]
fn sitting_down_leans_forward_and_comes_from_above_the_edge() {
    let sits = rests(PoseFamily::SitChair, GoalPose::Sit, Vec3::new(0.0, 0.0, -0.42), 0.0, 0.0);
    let EndState::Still(seat) = &sits else { panic!("a rest") };
    let seat_pelvis = FrameJoints::of(&body().model.joint_template, &seat.frame).positions[0];
    let motion = made(&input(stands(Vec3::ZERO, 0.0, 1), sits.clone(), &[Vec3::ZERO], 6));
    let joints = joints_of(&motion);
    let lean = |p: &FrameJoints| (p.rotations[j::SPINE3] * Vec3::Y).z.asin().to_degrees();
    let most = joints.iter().map(lean).fold(0.0, f32::max);
    assert!((25.0..65.0).contains(&most), "the trunk leans by {most} degrees");
    for posed in &joints {
        let above = posed.positions[0].y - seat_pelvis.y;
        let before = posed.positions[0].z - seat_pelvis.z;
        assert!(above > 0.5 * before.min(0.3) - 0.05, "{before} m before the seat only {above} m above it");
    }
}

#[test]
fn a_seed_gives_the_same_frames_and_another_seed_another_way() {
    let (_, first) = legs().swap_remove(1);
    assert_eq!(made(&first), made(&first));
    let other = LegInput { seed: Seed::root(77), ..first.clone() };
    assert_ne!(made(&first).frames, made(&other).frames);
}

#[test]
fn asked_time_is_kept() {
    let (_, mut leg) = legs().swap_remove(0);
    leg.seconds = Some(6.0);
    assert_eq!(made(&leg).frames.len(), 181);
}

#[test]
fn staying_breathes_and_returns_to_the_very_pose() {
    for still in [
        stands(Vec3::ZERO, 0.4, 3),
        rests(PoseFamily::SitSofa, GoalPose::Sit, Vec3::ZERO, 0.0, 0.0),
        rests(PoseFamily::LieUp, GoalPose::Lie, Vec3::ZERO, 0.0, 0.4),
    ] {
        let EndState::Still(still) = still else { continue };
        let motion = idle(body(), &BETAS_OF_MEAN, &still, 0.0, 8.0, Seed::root(3));
        let last = motion.frames.len() - 1;
        assert_eq!(last, 240);
        assert!(motion.frames[0] == still.frame && motion.frames[last] == still.frame);
        let joints = joints_of(&motion);
        let moved = |joint: usize| {
            joints.iter().map(|p| p.positions[joint].distance(joints[0].positions[joint])).fold(0.0, f32::max)
        };
        assert!(moved(j::HEAD) > 0.003, "a statue");
        assert!(moved(j::LEFT_ANKLE) < 0.005 && moved(j::HEAD) < 0.15);
        for pair in joints.windows(2) {
            assert!(speed(&pair[0], &pair[1]) < 0.5);
        }
    }
}

#[test]
fn a_leg_on_an_upper_floor_is_the_same_leg_higher_up() {
    let up = Vec3::Y * 2.8;
    let leg = |at: Vec3| {
        let to = at + Vec3::new(0.0, 0.0, 2.0);
        made(&input(stands(at, 0.0, 1), stands(to, 0.0, 2), &[at, to], 1))
    };
    let (low, high) = (joints_of(&leg(Vec3::ZERO)), joints_of(&leg(up)));
    assert_eq!(low.len(), high.len());
    for (a, b) in low.iter().zip(&high) {
        assert!(a.positions[0].distance(b.positions[0] - up) < 2e-3);
    }
}
