use std::ops::ControlFlow;

use glam::{Vec2, Vec3};

use super::*;
use crate::job::Ticker;
use crate::motion::leg::FootPlace;
use crate::scene::{GeometryConfig, GoalPose, ObjectId, SubGoal, SubGoalId, bake, facing_of};

/// The six faces of a box, seen from outside, or from inside for a room.
fn cuboid(min: Vec3, max: Vec3, inside: bool) -> Vec<[Vec3; 3]> {
    let p = |i: usize| {
        Vec3::new(
            if i & 1 == 0 { min.x } else { max.x },
            if i & 2 == 0 { min.y } else { max.y },
            if i & 4 == 0 { min.z } else { max.z },
        )
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangle =
        |a: usize, b: usize, c: usize| if inside { [p(a), p(c), p(b)] } else { [p(a), p(b), p(c)] };
    quads.iter().flat_map(|&[a, b, c, d]| [triangle(a, b, c), triangle(a, c, d)]).collect()
}

/// A room of 6 x 5 m with boxes from the floor up in it: (x from, x to, z from, z to, height), objects 1, 2, ...
fn room(boxes: &[(f32, f32, f32, f32, f32)]) -> RoomGeometry {
    let (mut triangles, mut owner) = (Vec::new(), Vec::new());
    let mut add = |new: Vec<[Vec3; 3]>, id: u32| {
        owner.extend(std::iter::repeat_n(ObjectId(id), new.len()));
        triangles.extend(new);
    };
    add(cuboid(Vec3::new(-3.0, 0.0, -2.5), Vec3::new(3.0, 2.7, 2.5), true), 0);
    for (i, &(x0, x1, z0, z1, height)) in boxes.iter().enumerate() {
        add(cuboid(Vec3::new(x0, 0.0, z0), Vec3::new(x1, height, z1), false), 1 + i as u32);
    }
    let go_on = |_, _| ControlFlow::Continue(());
    let config = GeometryConfig::default();
    let field = bake(&triangles, &config.field, &go_on).expect("not stopped");
    RoomGeometry::from_field(triangles, owner, field, &config, &go_on).expect("not stopped")
}

fn spot(x: f32, z: f32) -> Spot {
    Spot { at: Vec2::new(x, z), heading: None, beside: false }
}

fn goal(id: u32, x: f32, z: f32) -> SubGoal {
    SubGoal {
        id: SubGoalId(id),
        at: Vec3::new(x, 0.0, z),
        facing: None,
        pose: GoalPose::Stand,
        stay_s: 0.0,
        planned: false,
        locked: false,
        body: None,
    }
}

fn plan(geometry: &RoomGeometry, goals: &[SubGoal]) -> Route {
    let planner = Planner::new(geometry, PlanConfig::default());
    let stations: Vec<Station> = goals.iter().cloned().map(Station::on_floor).collect();
    route(&planner, &stations, &|_| Vec::new(), &Ticker::silent()).expect("not cancelled")
}

/// A wall from the back to the front with a passage of this width in the middle.
fn divided(passage_m: f32) -> RoomGeometry {
    let half = 0.5 * passage_m;
    room(&[(-0.1, 0.1, -2.5, -half, 2.7), (-0.1, 0.1, half, 2.5, 2.7)])
}

#[test]
fn a_way_goes_around_furniture_with_room_for_the_body_and_without_sharp_turns() {
    let geometry = room(&[(-0.6, 0.6, -2.5, 1.0, 0.9)]);
    let planner = Planner::new(&geometry, PlanConfig::default());
    let way = planner.way(&spot(-2.0, -1.5), &spot(2.0, -1.5), &[]).expect("there is a way");
    assert!(way.squeeze.is_none() && way.points.iter().all(|p| p.clearance_m >= 0.22));
    assert!((5.5..8.0).contains(&way.length_m()), "{} m", way.length_m());
    for p in way.points.windows(5) {
        let turn =
            crate::scene::direction_of(p[0].heading).angle_to(crate::scene::direction_of(p[4].heading));
        assert!(turn.abs() < 1.0, "{:.0} degrees within 20 cm at {}", turn.to_degrees(), p[2].at);
    }
    let around = way.points.iter().find(|p| p.at.z > 1.25).expect("around the front of the box");
    assert!(around.speed_m_per_s <= 1.2);
}

#[test]
fn a_wide_passage_is_walked_through_in_its_middle_and_a_narrow_one_is_reported() {
    let wide = divided(1.0);
    let planner = Planner::new(&wide, PlanConfig::default());
    let way = planner.way(&spot(-2.0, 1.5), &spot(2.0, 1.5), &[]).expect("1 m is wide");
    let inside = way.points.iter().find(|p| p.at.x.abs() < 0.05).expect("through the passage");
    assert!(inside.at.z.abs() < 0.2 && way.squeeze.is_none(), "{inside:?}");
    let narrow = divided(0.46);
    let planner = Planner::new(&narrow, PlanConfig::default());
    let way = planner.way(&spot(-2.0, 1.5), &spot(2.0, 1.5), &[]).expect("46 cm can be squeezed through");
    let (at, clearance_m) = way.squeeze.expect("reported");
    assert!(at.x.abs() < 0.3 && (0.15..0.22).contains(&clearance_m), "{at} {clearance_m}");
}

#[test]
fn what_can_not_be_reached_is_reported_with_what_is_in_the_way() {
    let geometry = room(&[(-0.1, 0.1, -2.5, 2.5, 2.7), (1.5, 2.0, -1.0, -0.5, 0.5)]);
    let route = plan(&geometry, &[goal(0, -2.0, 0.0), goal(1, 1.0, 0.0), goal(2, -1.0, 1.0)]);
    let [unreachable] = route.unreachable.as_slice() else { panic!("{:?}", route.unreachable) };
    assert_eq!(unreachable.goal, SubGoalId(1));
    let Blocked::NoWay { object, .. } = unreachable.why else { panic!("{:?}", unreachable.why) };
    assert_eq!(object, Some(ObjectId(1)), "the wall is in the way");
    assert_eq!(route.stops.first().map(|s| s.goal.id), Some(SubGoalId(0)));
    assert_eq!(route.stops.last().map(|s| s.goal.id), Some(SubGoalId(2)), "the rest is planned");
    let planner = Planner::new(&geometry, PlanConfig::default());
    let inside = planner.way(&spot(1.0, 1.0), &spot(1.75, -0.75), &[]);
    assert!(matches!(inside, Err(Blocked::NobodyFits { object: Some(ObjectId(2)), .. })), "{inside:?}");
    let outside = planner.way(&spot(1.0, 1.0), &spot(9.0, 0.0), &[]);
    assert!(matches!(outside, Err(Blocked::OffFloor { .. })), "{outside:?}");
}

#[test]
fn moving_one_goal_leaves_ways_and_names_between_others_as_they_are() {
    let geometry = room(&[(-0.6, 0.6, -1.0, 1.0, 0.9)]);
    let goals = [goal(0, -2.5, 0.0), goal(1, 2.5, 0.0), goal(2, 0.0, 2.0), goal(3, -2.0, -2.0)];
    let before = plan(&geometry, &goals);
    let mut moved = goals.clone();
    moved[3].at.x = 2.0;
    let after = plan(&geometry, &moved);
    let until = |route: &Route| route.stops.iter().take_while(|s| s.goal.id != SubGoalId(2)).count();
    assert_eq!(before.stops[..until(&before)], after.stops[..until(&after)]);
    assert!(before.stops.iter().any(|s| s.goal.planned), "sub-goals are put in");
    let mut ids: Vec<SubGoalId> = before.stops.iter().map(|s| s.goal.id).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), before.stops.len(), "every sub-goal has its own name");
}

#[test]
fn somebody_who_stands_in_the_way_is_gone_around() {
    let geometry = room(&[]);
    let planner = Planner::new(&geometry, PlanConfig::default());
    let other = Disc { at: Vec2::new(0.0, 0.0), radius_m: 0.3 };
    let way = planner.way(&spot(-2.0, 0.0), &spot(2.0, 0.0), &[other]).expect("around");
    let nearest = way.points.iter().map(|p| Vec2::new(p.at.x, p.at.z).length()).fold(f32::INFINITY, f32::min);
    assert!(nearest > 0.5, "{nearest} m from the other's middle");
    assert!(way.length_m() < 4.6);
}

#[test]
fn one_sits_down_from_the_front_and_from_the_side_where_a_table_leaves_no_room() {
    let seat = (-0.25, 0.25, -0.25, 0.25, 0.45);
    let table = (-0.6, 0.6, 0.35, 1.2, 0.75);
    let foot = |x: f32| FootPlace { at: Vec3::new(x, 0.0, 0.42), heading: 0.0 };
    let seated = Seated { pelvis: Vec3::new(0.0, 0.55, 0.0), facing: 0.0, feet: [foot(0.1), foot(-0.1)] };
    let free = room(&[seat]);
    let planner = Planner::new(&free, PlanConfig::default());
    let first = stances(&planner, &seated)[0];
    assert_eq!(first.side, Side::Front);
    assert!(first.at.z > 0.4 && first.feet.is_some());
    assert!(planner.way(&spot(2.0, 2.0), &first.spot(), &[]).is_ok());
    let set = room(&[seat, table]);
    let planner = Planner::new(&set, PlanConfig::default());
    let first = stances(&planner, &seated)[0];
    assert!(matches!(first.side, Side::Left | Side::Right), "{first:?}");
    assert!(planner.way(&spot(2.0, 2.0), &first.spot(), &[]).is_ok());
}

#[test]
fn a_sub_goal_put_by_hand_is_walked_through_the_way_it_faces() {
    let geometry = room(&[]);
    let mut through = goal(1, 0.0, 0.5);
    (through.pose, through.facing) = (GoalPose::Walk, Some(facing_of(Vec2::X)));
    let route = plan(&geometry, &[goal(0, -2.0, -1.0), through, goal(2, 2.0, -1.0)]);
    let stop = route.stops.iter().find(|s| s.goal.id == SubGoalId(1)).expect("on the route");
    assert!(matches!(&stop.role, Role::Through(w) if w.heading == facing_of(Vec2::X)));
    let first = stop.way.first().expect("it goes on");
    assert!((first.heading - facing_of(Vec2::X)).abs() < 0.35, "leaves with {} rad", first.heading);
}
