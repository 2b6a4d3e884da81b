use glam::{Vec2, Vec3};

use super::staging::{stage, swept};
use super::*;
use crate::assets::{CLIP_JOINTS, PoseClip, Weights};
use crate::body::Body;
use crate::body::joints::{LEFT_HIP, LEFT_KNEE, LEFT_SHOULDER, RIGHT_HIP, RIGHT_KNEE, RIGHT_SHOULDER};
use crate::job::{JobCtx, Seed, Stop, Ticker};
use crate::learn::corpus::Split;
use crate::nn::motion::{Between, MotionConfig, MotionKind, MotionSampler};
use crate::scene::layout::Item;
use crate::scene::{Category, Frame};

/// Somebody who walks a curve at the given speed with swinging arms, for three seconds.
fn walk(name: &str, speed_m_per_s: f32, bend: f32) -> PoseClip {
    let frame = |k: usize| {
        let phase = k as f32 * 0.2;
        let mut joints = [Vec3::ZERO; CLIP_JOINTS];
        joints[0].y = bend * k as f32 / 30.0;
        joints[LEFT_SHOULDER] = Vec3::new(0.3 * phase.sin(), 0.0, -1.2);
        joints[RIGHT_SHOULDER] = Vec3::new(-0.3 * phase.sin(), 0.0, 1.2);
        joints[LEFT_HIP].x = -0.4 * phase.sin();
        joints[RIGHT_HIP].x = 0.4 * phase.sin();
        joints[LEFT_KNEE].x = 0.2 + 0.2 * phase.cos();
        joints[RIGHT_KNEE].x = 0.2 - 0.2 * phase.cos();
        joints
    };
    let mut at = Vec3::new(0.0, 0.9, 0.0);
    let mut pelvis = Vec::new();
    for k in 0..90 {
        let heading = bend * k as f32 / 30.0;
        pelvis.push(at);
        at += Vec3::new(heading.sin(), 0.0, heading.cos()) * speed_m_per_s / 30.0;
    }
    PoseClip {
        name: name.into(),
        frames: (0..90).map(frame).collect(),
        pelvis_m: pelvis,
        frame_seconds: 1.0 / 30.0,
    }
}

/// Somebody who sits down within a second and stays.
fn sit(name: &str, low_m: f32) -> PoseClip {
    let frame = |k: usize| {
        let down = (k as f32 / 30.0).min(1.0);
        let mut joints = [Vec3::ZERO; CLIP_JOINTS];
        joints[LEFT_SHOULDER].z = -1.2;
        joints[RIGHT_SHOULDER].z = 1.2;
        for hip in [LEFT_HIP, RIGHT_HIP] {
            joints[hip].x = -1.5 * down;
        }
        for knee in [LEFT_KNEE, RIGHT_KNEE] {
            joints[knee].x = 1.5 * down;
        }
        joints
    };
    let pelvis = |k: usize| {
        let down = (k as f32 / 30.0).min(1.0);
        Vec3::new(0.0, 0.9 - low_m * down, -0.4 * down)
    };
    PoseClip {
        name: name.into(),
        frames: (0..80).map(frame).collect(),
        pelvis_m: (0..80).map(pelvis).collect(),
        frame_seconds: 1.0 / 30.0,
    }
}

fn corpus() -> MotionData {
    let mut clips: Vec<PoseClip> =
        (0..7).map(|i| walk(&format!("made/walk{i}"), 0.8 + 0.1 * i as f32, 0.1 * i as f32 - 0.3)).collect();
    clips.extend((0..3).map(|i| sit(&format!("made/sit{i}"), 0.42 + 0.02 * i as f32)));
    let config = MotionDataConfig { family_bodies: 20, mirror: false, ..MotionDataConfig::default() };
    MotionData::from_clips(&clips, &config, &Ticker::silent()).expect("a corpus")
}

fn settings(kind: MotionKind, epochs: usize) -> MotionTraining {
    MotionTraining {
        network: MotionConfig::mini(kind),
        epochs,
        drawn: 8,
        batch: 4,
        learning_rate: 3e-3,
        end_noise: 0.0,
        ..MotionTraining::paper(kind)
    }
}

fn go_on(state: &mut MotionState, input: &TrainInput<'_>) -> Vec<Vec<u8>> {
    let mut checkpoints = Vec::new();
    let mut keep = |state: &MotionState| {
        checkpoints.push(state.checkpoint()?);
        Ok(())
    };
    train_motion(state, input, &JobCtx::headless(Seed::root(0)), &mut keep).expect("trained");
    checkpoints
}

#[test]
fn no_clip_is_in_two_parts_and_every_part_has_walks_and_sits() {
    let data = corpus();
    for split in [Split::Train, Split::Validation, Split::Test] {
        let of_part = |t: &&Take| t.split == split;
        let activities: Vec<Activity> = data.takes.iter().filter(of_part).map(|t| t.activity).collect();
        assert!(activities.contains(&Activity::Walk) && activities.contains(&Activity::Sit), "{split:?}");
    }
    for take in &data.takes {
        assert!(
            data.takes.iter().filter(|t| t.clip == take.clip).all(|t| t.split == take.split),
            "{}",
            take.clip
        );
    }
}

#[test]
fn a_staged_room_is_free_where_its_motion_goes_and_has_a_seat_where_it_sits() {
    let data = corpus();
    let body = Body::bundled();
    let mut seated = 0;
    for take in &data.takes {
        let pieces = &take.room.layout.furniture;
        let way = swept(body, &take.frames);
        assert!(pieces.len() > 1, "{}: {} pieces", take.clip, pieces.len());
        let seats = |c: &str| Category::from_label(c).is_some_and(Category::is_seat);
        let bears = |p: &&crate::scene::layout::Placement| match &p.item {
            Item::Block { size, .. } => seats(&p.category) && (size.1 - 0.45).abs() < 0.25,
            _ => false,
        };
        seated += usize::from(take.activity == Activity::Sit && pieces.iter().any(|p| bears(&p)));
        for point in way.points().iter().step_by(37) {
            let field = take.room.field_around(point.with_y(0.0));
            let depth_m = -field.sample(*point);
            assert!(depth_m < 0.09, "{}: {depth_m} m inside something at {point}", take.clip);
        }
    }
    // A seat that calves leave too little room for is left out.
    assert!(seated > 0, "nobody who sits has a seat");
}

#[test]
fn the_same_clips_are_staged_the_same_way() {
    let (a, b) = (corpus(), corpus());
    assert_eq!(a.id, b.id);
    for (a, b) in a.takes.iter().zip(&b.takes) {
        assert!(a.frames == b.frames && a.codes == b.codes && a.room.points == b.room.points);
    }
}

#[test]
fn windows_hold_two_seconds_in_which_something_happens() {
    let data = corpus();
    let windows = data.training_windows();
    assert!(windows.len() > 10, "{}", windows.len());
    let rows = data.rows(windows[0], 64, Seed::root(1));
    assert_eq!((rows.rows.len(), rows.cloud.len()), (62, 64));
    let start = Vec2::new(rows.rows[0][0], rows.rows[0][2]);
    assert!(start.length() < 1e-5, "the frame is below the first body: {start}");
}

#[test]
fn a_tiny_corpus_is_learnt() {
    let data = corpus();
    let route = {
        let mut state =
            MotionState::new(settings(MotionKind::Between(Between::Route), 60), data.id.clone(), None)
                .expect("a network");
        go_on(&mut state, &TrainInput { data: &data, route: None });
        let rows = &state.history.rows;
        let (first, last) = (rows[0].training, rows[rows.len() - 1].training);
        assert!(last < 0.5 * first, "route: {first} to {last}");
        state.sampler()
    };
    for kind in [
        MotionKind::Points,
        MotionKind::SubGoal,
        MotionKind::Between(Between::Pose),
        MotionKind::Between(Between::Base),
    ] {
        let mut state = MotionState::new(settings(kind, 60), data.id.clone(), None).expect("a network");
        go_on(&mut state, &TrainInput { data: &data, route: Some(&route) });
        let rows = &state.history.rows;
        let mean = |rows: &[MotionRow]| rows.iter().map(|r| r.training).sum::<f32>() / rows.len() as f32;
        let (first, last) = (mean(&rows[..2]), mean(&rows[rows.len() - 5..]));
        // Made-up walks hardly change their codes along the way: there is little for poses to learn beyond the line.
        let share = if matches!(kind, MotionKind::Between(_)) { 0.99 } else { 0.75 };
        assert!(last < share * first, "{}: {first} to {last}", kind.label());
    }
}

#[test]
fn a_resumed_training_ends_with_the_same_bytes() {
    let data = corpus();
    for kind in [MotionKind::Points, MotionKind::SubGoal, MotionKind::Between(Between::Route)] {
        let training = settings(kind, 4);
        let input = TrainInput { data: &data, route: None };
        let mut whole = MotionState::new(training.clone(), data.id.clone(), None).expect("a network");
        let checkpoints = go_on(&mut whole, &input);
        let read = Weights::from_bytes("checkpoint", &checkpoints[1]).expect("checkpoint");
        let mut again = MotionState::resume(training.clone(), data.id.clone(), &read).expect("resumed");
        assert_eq!(again.epoch, 2);
        assert_eq!(go_on(&mut again, &input), checkpoints[2..], "{}", kind.label());
        assert_eq!(again.weights().expect("bytes"), whole.weights().expect("bytes"));
        assert!(MotionState::resume(training.clone(), "another".into(), &read).is_err());
        let other = MotionTraining { seed: 9, ..training };
        assert!(MotionState::resume(other, data.id.clone(), &read).is_err());
    }
}

#[test]
fn pose_net_wants_a_route_net() {
    let data = corpus();
    let training = settings(MotionKind::Between(Between::Pose), 1);
    let mut state = MotionState::new(training, data.id.clone(), None).expect("a network");
    let input = TrainInput { data: &data, route: None };
    let ended = train_motion(&mut state, &input, &JobCtx::headless(Seed::root(0)), &mut |_| Ok(()));
    assert!(matches!(ended, Err(Stop::Failed(why)) if why.contains("--route")));
}

#[test]
fn the_kept_epoch_is_the_one_with_the_least_validation_loss() {
    let data = corpus();
    let mut state = MotionState::new(settings(MotionKind::Between(Between::Route), 8), data.id.clone(), None)
        .expect("a network");
    go_on(&mut state, &TrainInput { data: &data, route: None });
    let least = state.history.rows.iter().map(|r| r.validation).fold(f32::INFINITY, f32::min);
    let kept = state.history.best_row().expect("an epoch").validation;
    assert_eq!(kept, least);
    let again = MotionSampler::new(state.network().clone(), state.best());
    let input = TrainInput { data: &data, route: None };
    let sums = validation_loss(&again, Between::Route, &input, Split::Validation, 192);
    assert!((sums[..9].iter().sum::<f32>() / 9.0 - least).abs() < 1e-5);
}

#[test]
fn one_body_can_be_staged_by_itself() {
    let frame = Frame { translation: Vec3::new(0.0, 0.9, 0.0), ..Frame::default() };
    let room = stage(Body::bundled(), &[frame], Seed::root(4)).expect("a room");
    assert!(room.points.points.len() > 1000);
}
