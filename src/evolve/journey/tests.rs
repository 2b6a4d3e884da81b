use std::ops::ControlFlow;
use std::sync::OnceLock;

use glam::Vec3;

use super::*;
use crate::assets::{Budget, read_model_bytes, sample_rooms};
use crate::job::{Job, Outcome, Seed};
use crate::scene::{Frame, GeometryConfig, ImportOptions, room_from_model};

/// The bundled bedroom: bed, desk with chair, armchair.
fn bedroom() -> &'static (Room, RoomGeometry) {
    static ROOM: OnceLock<(Room, RoomGeometry)> = OnceLock::new();
    ROOM.get_or_init(|| bundled("bedroom"))
}

fn bundled(key: &str) -> (Room, RoomGeometry) {
    let sample = sample_rooms().iter().find(|r| r.key == key).expect("bundled room");
    let model = read_model_bytes(key, sample.glb, &Budget::default()).expect("bundled rooms are sound");
    let room = room_from_model(&model, &ImportOptions::default()).room;
    let go_on = |_, _| ControlFlow::Continue(());
    let geometry = RoomGeometry::build(&room, &GeometryConfig::default(), &go_on).expect("not stopped");
    (room, geometry)
}

/// From the door to the desk chair, the armchair, the window, the bed and back.
fn asked() -> Vec<SubGoal> {
    let (room, geometry) = bedroom();
    let goals = tour(room, geometry, 120.0, &Ticker::silent()).expect("not cancelled");
    goals.into_iter().map(|g| SubGoal { stay_s: 1.0, ..g }).collect()
}

fn unfitted(goals: Vec<SubGoal>) -> JourneyRequest {
    JourneyRequest { goals, optimise: false, ..JourneyRequest::default() }
}

fn made(request: &JourneyRequest, seed: u64) -> Journey {
    made_in(bedroom(), request, seed)
}

fn made_in((room, geometry): &(Room, RoomGeometry), request: &JourneyRequest, seed: u64) -> Journey {
    journey(room, geometry, Body::bundled(), request, &JobCtx::headless(Seed::root(seed))).expect("a journey")
}

/// Every bit of some frames.
fn bits(frames: &[Frame]) -> Vec<u32> {
    let numbers = |f: &Frame| {
        let mut all = f.translation.to_array().to_vec();
        all.extend(f.rotation.to_array());
        all.extend(f.pose.iter().flat_map(|p| p.to_array()));
        all.extend(f.hands);
        all
    };
    frames.iter().flat_map(numbers).map(f32::to_bits).collect()
}

#[test]
fn a_tour_of_the_bedroom_sits_and_lies_where_it_was_asked_to_and_comes_back() {
    let goals = asked();
    let poses: Vec<GoalPose> = goals.iter().map(|g| g.pose).collect();
    assert!(poses.iter().filter(|p| **p == GoalPose::Sit).count() >= 2 && poses.contains(&GoalPose::Lie));
    let tour = made(&unfitted(goals.clone()), 1);
    assert!(tour.unreachable.is_empty(), "{:?}", tour.complaints(&bedroom().0));
    assert_eq!(tour.goals.len(), goals.len());
    for report in &tour.goals {
        assert!(report.is_met(), "{report:?}");
    }
    assert!((30.0..90.0).contains(&tour.clip.seconds()), "{} s", tour.clip.seconds());
    assert!(tour.clip.is_finite() && tour.clip.planted.len() == tour.clip.frames.len());
    let apart = tour.clip.legs.windows(2).all(|l| l[0].last == l[1].first && l[0].to == l[1].from);
    assert!(apart, "legs follow one another");
    // Nobody jumps: 12 cm in a thirtieth of a second would be 3.6 m/s.
    for pair in tour.clip.frames.windows(2) {
        assert!(pair[0].translation.distance(pair[1].translation) < 0.12);
    }
}

/// What a tour asks for in a bundled room.
fn asked_in((room, geometry): &(Room, RoomGeometry)) -> Vec<SubGoal> {
    tour(room, geometry, 60.0, &Ticker::silent()).expect("not cancelled")
}

#[test]
fn in_every_sample_room_somebody_sits_and_lies_on_the_way() {
    for key in ["living", "bedroom", "office"] {
        let room = bundled(key);
        let goals = asked_in(&room);
        let of = |pose: GoalPose| goals.iter().filter(|g| g.pose == pose).count();
        assert!(
            of(GoalPose::Sit) >= 2 && of(GoalPose::Lie) == 1,
            "{key}: {:?}",
            goals.iter().map(|g| g.pose)
        );
        let made = made_in(&room, &unfitted(goals.clone()), 0);
        assert!(made.unreachable.is_empty(), "{key}: {:?}", made.complaints(&room.0));
        assert!(made.goals.iter().all(GoalReport::is_met), "{key}: {:?}", made.goals);
        // Whoever rests does not sink in by more than a cushion gives way, calves and heads included.
        let rests = goals.iter().filter(|g| g.pose != GoalPose::Stand);
        for goal in rests {
            let frame = made.motion.goals.iter().find(|g| g.goal == goal.id).expect("measured").frame;
            let deepest = made.motion.frames[frame].penetration_max_mm;
            assert!(deepest < 30.0, "{key}: {:?} at {} sinks in by {deepest} mm", goal.pose, goal.at);
        }
    }
}

#[test]
fn who_lies_in_bed_lies_along_it_with_the_head_on_a_pillow_and_gets_in_from_its_side() {
    let (room, geometry) = bedroom();
    let goals = asked();
    let made = made(&unfitted(goals.clone()), 0);
    let bed = room.objects.iter().find(|o| o.category == crate::scene::Category::Bed).expect("a bed");
    let lies = made.clip.goals.iter().find(|g| g.pose == GoalPose::Lie && !g.planned).expect("lies");
    let joints = |frame: &Frame| {
        let rest = Body::bundled().model.rest_joints(&made.clip.betas);
        crate::body::FrameJoints::of(&rest, frame).positions
    };
    let lying = joints(lies.body.as_ref().expect("a body"));
    let (head, pelvis) = (lying[crate::body::joints::HEAD], lying[0]);
    let pillows = room.objects.iter().filter(|o| o.category == crate::scene::Category::Cushion);
    let under = pillows
        .map(|o| o.world_bounds())
        .find(|b| (b.min.x..b.max.x).contains(&head.x) && (b.min.z - 0.05..b.max.z + 0.05).contains(&head.z));
    let under = under.expect("the head is over a pillow");
    assert!(head.y > under.min.y + 0.05, "not in it");
    // The bed's head is at the back wall, so it is lain on along z.
    assert!((head - pelvis).z < -0.5 && (head - pelvis).x.abs() < 0.1, "{}", head - pelvis);
    let edge = made.clip.goals.iter().find(|g| g.pose == GoalPose::Sit && g.planned).expect("an edge");
    let facing = crate::scene::direction_of(edge.facing.expect("faces"));
    let bounds = bed.world_bounds();
    assert!(facing.x.abs() > 0.9, "from the side, not from the foot: {facing}");
    assert!(edge.at.z < bounds.max.z - 0.3, "{} of a bed until {}", edge.at, bounds.max);
    assert!(geometry.floor.is_walkable(glam::Vec2::new(edge.at.x, edge.at.z) + facing * 0.7));
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_one_thread_and_on_two() {
    let goals: Vec<SubGoal> = asked().into_iter().take(2).map(|g| SubGoal { stay_s: 0.5, ..g }).collect();
    let request = JourneyRequest { goals, ..JourneyRequest::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        bits(&pool.install(|| made(&request, 3)).clip.frames)
    };
    let one = on(1);
    assert!(one == on(2));
    let other = bits(&made(&JourneyRequest { optimise: false, ..request.clone() }, 4).clip.frames);
    assert!(one != other, "another seed gives another motion");
}

#[test]
fn changing_one_sub_goal_leaves_all_legs_but_its_own_byte_for_byte() {
    let goals = asked();
    let before = made(&unfitted(goals.clone()), 1).clip;
    let changed = goals.len() - 3;
    let mut moved = goals.clone();
    assert_eq!(moved[changed].pose, GoalPose::Stand, "the window");
    moved[changed].facing = moved[changed].facing.map(|f| f + 0.6);
    let request = JourneyRequest { kept: Some(Arc::new(before.clone())), ..unfitted(moved) };
    let after = made(&request, 1);
    let own = |clip: &Clip, leg: &crate::scene::Leg| {
        let given = |id: SubGoalId| clip.goals.iter().position(|g| g.id == id).unwrap_or(0);
        let at = |k: usize| given(goals[k].id);
        given(leg.to) > at(changed - 1) && given(leg.from) < at(changed + 1)
    };
    let (mut kept, mut remade) = (0, 0);
    for leg in &after.clip.legs {
        let same = before.legs.iter().find(|l| (l.from, l.to) == (leg.from, leg.to));
        let frames = |clip: &Clip, l: &crate::scene::Leg| bits(&clip.frames[l.first..=l.last]);
        let identical = same.is_some_and(|l| frames(&before, l) == frames(&after.clip, leg));
        if own(&after.clip, leg) {
            remade += usize::from(!identical);
        } else {
            assert!(identical, "the leg from {:?} to {:?} changed", leg.from, leg.to);
            kept += 1;
        }
    }
    assert!(remade >= 2 && after.legs_kept >= kept, "{remade} made again, {kept} kept");
    let alone = made(&JourneyRequest { kept: None, ..request }, 1);
    assert!(bits(&alone.clip.frames) == bits(&after.clip.frames), "kept legs are what would be made");
}

#[test]
fn a_route_is_seen_first_then_poses_and_a_cancelled_journey_is_cancelled() {
    let (stages, seen) = std::sync::mpsc::channel();
    let goals = asked();
    let work = move |cx: &JobCtx<(Stage, usize)>| {
        let (room, geometry) = bedroom();
        let inner = cx.mapped(move |p: JourneyPreview| {
            let _ = stages.send((p.stage, p.clip.frames.len()));
            (p.stage, p.clip.frames.len())
        });
        let request = JourneyRequest { goals, ..JourneyRequest::default() };
        journey(room, geometry, Body::bundled(), &request, &inner)
    };
    let mut job = Job::spawn("tour", Seed::root(1), || (), work);
    let next = || seen.recv_timeout(std::time::Duration::from_secs(300)).expect("a preview");
    let (first, frames) = next();
    assert!(first == Stage::Route && frames > 100, "{first:?} with {frames} frames");
    assert_eq!(next().0, Stage::Poses);
    assert_eq!(next().0, Stage::Optimised);
    job.cancel();
    let outcome = loop {
        if let Some(outcome) = job.poll() {
            break outcome;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    };
    assert!(matches!(outcome, Outcome::Cancelled));
}

#[test]
fn somebody_who_stands_in_the_way_is_walked_around() {
    let living = bundled("living");
    let left =
        SubGoal { at: Vec3::new(-1.6, 0.0, 1.3), facing: None, pose: GoalPose::Stand, ..asked()[0].clone() };
    let right = SubGoal { id: SubGoalId(1), at: Vec3::new(1.6, 0.0, 1.3), ..left.clone() };
    let request = unfitted(vec![left, right]);
    let alone = made_in(&living, &request, 2).clip;
    let middle = alone.frames[alone.frames.len() / 2].clone();
    let other = Clip { name: "Somebody".to_owned(), frames: vec![middle.clone()], ..Clip::default() };
    let both = made_in(&living, &JourneyRequest { others: vec![Arc::new(other)], ..request }, 2);
    let away = |f: &Frame| f.translation.with_y(0.0).distance(middle.translation.with_y(0.0));
    let nearest = |clip: &Clip| clip.frames.iter().map(away).fold(f32::INFINITY, f32::min);
    assert!(nearest(&alone) < 0.05, "the test is about people who would collide");
    assert!(both.meetings.is_empty(), "{:?}", both.meetings);
    assert!(nearest(&both.clip) > 0.5, "{} m apart", nearest(&both.clip));
    assert_eq!(both.goals.len(), 2, "and comes to where it was asked to");
}

#[test]
fn goals_that_can_not_be_reached_are_told_and_the_rest_is_done() {
    let (room, geometry) = bedroom();
    let mut goals: Vec<SubGoal> = asked().into_iter().filter(|g| g.pose == GoalPose::Stand).collect();
    let mut lost = goals[1].clone();
    (lost.id, lost.at) = (SubGoalId(77), Vec3::new(40.0, 0.0, 0.0));
    goals.insert(1, lost.clone());
    let made = made(&unfitted(goals), 1);
    assert_eq!(made.unreachable.iter().map(|u| u.goal).collect::<Vec<_>>(), [SubGoalId(77)]);
    assert!(made.complaints(room)[0].contains("outside"), "{:?}", made.complaints(room));
    assert!(made.clip.goal(SubGoalId(77)).is_none() && made.goals.len() >= 2);
    let nowhere =
        journey(room, geometry, Body::bundled(), &unfitted(vec![lost]), &JobCtx::headless(Seed::root(1)));
    assert!(matches!(nowhere, Err(Stop::Failed(reason)) if reason.contains("outside")));
}
