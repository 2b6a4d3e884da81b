//! The networks as makers of legs: what a planned journey asks for, in the terms of its plan.

use glam::Vec3;
use rand_distr::{Distribution as _, StandardNormal};

use super::gait::walking_frame;
use super::learned::{LearnedMotion, LegEnds, LegScene, stretched};
use super::leg::{EndState, LegInput, LegMotion};
use super::local::{LegFrame, code_of};
use super::planted::planted_feet;
use super::room_points::{ROOM_POINTS, RoomPoints};
use super::subgoal::SubGoalBodies;
use crate::body::Body;
use crate::body::joints::PELVIS;
use crate::job::{Cancelled, Seed, Ticker};
use crate::nn::motion::{CONDITION, PLACE, ROW};
use crate::scene::{BETAS, Frame, RoomGeometry};

/// The body at an end of a leg.
fn frame_of(body: &Body, betas: &[f32; BETAS], state: &EndState) -> Frame {
    match state {
        EndState::Still(still) => still.frame.clone(),
        EndState::Walking(walking) => walking_frame(body, betas, walking),
    }
}

/// The points of a room that legs are made in; some milliseconds.
pub fn points_of(geometry: &RoomGeometry) -> RoomPoints {
    let triangles: Vec<([Vec3; 3], u8)> = geometry.bvh.triangles().iter().map(|t| (*t, 0)).collect();
    // The same room has the same points, whoever walks in it.
    RoomPoints::of(&triangles, ROOM_POINTS, Seed::root(0).child("room points", 0))
}

/// A planned leg by RouteNet and PoseNet (LTM §3.3).
///
/// # Errors
/// [`Cancelled`].
pub fn learned_leg(
    nets: &LearnedMotion,
    body: &Body,
    points: &RoomPoints,
    input: &LegInput,
    ticker: &Ticker,
) -> Result<LegMotion, Cancelled> {
    let [from, to] = [&input.from, &input.to].map(|state| frame_of(body, &input.betas, state));
    nets.leg(body, points, &ends_of(input, &from, &to), &input.path, input.seed, ticker)
}

/// A planned leg by RouteNet and a body of the sub-goal network at every place of the route, all from one code
/// (LTM §4.4, Route+CVAE). For comparison: nothing holds the bodies together in time.
///
/// # Errors
/// [`Cancelled`].
pub fn route_cvae_leg(
    nets: &LearnedMotion,
    bodies: &SubGoalBodies,
    body: &Body,
    points: &RoomPoints,
    input: &LegInput,
    ticker: &Ticker,
) -> Result<LegMotion, Cancelled> {
    let [from, to] = [&input.from, &input.to].map(|state| frame_of(body, &input.betas, state));
    let ends = ends_of(input, &from, &to);
    let net = bodies.sampler();
    let count = net.config().points.count;
    let scene = LegScene::new(body, points, &ends, [nets.route_points(), count], input.seed);
    let mut rng = input.seed.child("codes", 0).rng();
    let code: Vec<f32> = (0..net.config().latent).map(|_| StandardNormal.sample(&mut rng)).collect();
    let rest = body.model.rest_joints(&input.betas)[PELVIS];
    let mut rows = nets.route_rows(&scene);
    for (k, row) in rows.iter_mut().enumerate() {
        ticker.check()?;
        let placed = scene.leg.placed(row, rest);
        let own = LegFrame::of(&placed, rest, ends.floor_m);
        let here = own.row(&placed, &code_of(row), rest);
        let mut asked = [0.0; CONDITION];
        asked[..PLACE].copy_from_slice(&here[..PLACE]);
        asked[PLACE..].copy_from_slice(&input.betas);
        let at = [placed.translation + rest; 2];
        let cloud = points.around(&own, at, count, input.seed.child("cloud", k as u64)).0;
        if let Some(made) = net.bodies(&cloud, &asked, &code).first() {
            row[PLACE..ROW].copy_from_slice(&made[PLACE..]);
        }
    }
    let frames = stretched(&scene.frames(body, &ends, &rows), ends.frame_count(&input.path));
    let planted = planted_feet(body, ends.betas, &frames, ends.floor_m);
    Ok(LegMotion { frames, planted })
}

fn ends_of<'a>(input: &'a LegInput, from: &'a Frame, to: &'a Frame) -> LegEnds<'a> {
    let floor_m = input.path.first().map_or(0.0, |p| p.at.y);
    LegEnds { betas: &input.betas, from, to, floor_m, seconds: input.seconds }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::leg::{PathPoint, Walking};

    #[test]
    fn a_planned_leg_between_two_moments_of_a_walk_joins_its_neighbours() {
        let body = Body::bundled();
        let walking = |z: f32| Walking { at: Vec3::new(0.0, 0.0, z), heading: 0.0, speed_m_per_s: 1.0 };
        let point = |z: f32| PathPoint {
            at: Vec3::new(0.0, 0.0, z),
            heading: 0.0,
            clearance_m: 1.0,
            speed_m_per_s: 1.0,
        };
        let input = LegInput {
            from: EndState::Walking(walking(0.0)),
            to: EndState::Walking(walking(1.4)),
            path: (0..=14).map(|i| point(0.1 * i as f32)).collect(),
            betas: [0.0; BETAS],
            seconds: None,
            seed: Seed::root(3),
        };
        let nets = LearnedMotion::bundled().expect("bundled");
        let bodies = SubGoalBodies::bundled().expect("bundled");
        let (points, ticker) = (RoomPoints::default(), Ticker::silent());
        let ends = [0.0, 1.4].map(|z| walking_frame(body, &input.betas, &walking(z)));
        for leg in [
            learned_leg(nets, body, &points, &input, &ticker).expect("a leg"),
            route_cvae_leg(nets, &bodies, body, &points, &input, &ticker).expect("a leg"),
        ] {
            let last = leg.frames.len() - 1;
            assert!(leg.frames[0] == ends[0] && leg.frames[last] == ends[1] && leg.planted.len() == last + 1);
            assert!((30..60).contains(&last), "{last}");
        }
        ticker.cancel();
        assert!(learned_leg(nets, body, &points, &input, &ticker).is_err());
    }
}
