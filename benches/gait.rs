//! How long motion takes to make. One thread; each case names the length of what it makes, so that the time over it is
//! the time a second of motion costs.

use divan::{Bencher, black_box};
use glam::Vec3;
use inhabit::body::Body;
use inhabit::job::{Seed, Ticker};
use inhabit::motion::{EndState, LegInput, PathPoint, Still, Walking, gait};
use inhabit::scene::{BETAS, GoalPose};

fn main() {
    divan::main();
}

fn stands(at: Vec3, facing: f32) -> EndState {
    let feet = gait::natural_feet(Body::bundled(), &[0.0; BETAS], at, facing);
    let frame = gait::standing_frame(Body::bundled(), &[0.0; BETAS], &feet, Seed::root(1));
    EndState::Still(Still { frame, pose: GoalPose::Stand })
}

fn leg(from: EndState, to: EndState, length_m: f32) -> LegInput {
    let points = (length_m / 0.1) as usize;
    let point = |i: usize| PathPoint {
        at: Vec3::Z * (0.1 * i as f32),
        heading: 0.0,
        clearance_m: 1.0,
        speed_m_per_s: 1.15,
    };
    LegInput {
        from,
        to,
        path: (0..=points).map(point).collect(),
        betas: [0.0; BETAS],
        seconds: None,
        seed: Seed::root(1),
    }
}

fn make(bencher: Bencher, input: &LegInput) {
    let body = Body::bundled();
    bencher.bench_local(|| gait::synthesise_leg(body, black_box(input), &Ticker::silent()));
}

#[divan::bench]
fn walk_of_10_m_11_s(bencher: Bencher) {
    make(bencher, &leg(stands(Vec3::ZERO, 0.0), stands(Vec3::Z * 10.0, 0.0), 10.0));
}

#[divan::bench]
fn walk_of_100_m_90_s(bencher: Bencher) {
    make(bencher, &leg(stands(Vec3::ZERO, 0.0), stands(Vec3::Z * 100.0, 0.0), 100.0));
}

#[divan::bench]
fn two_strides_between_two_walks_2_s(bencher: Bencher) {
    let walks = |at: Vec3| EndState::Walking(Walking { at, heading: 0.0, speed_m_per_s: 1.15 });
    make(bencher, &leg(walks(Vec3::ZERO), walks(Vec3::Z * 2.5), 2.5));
}

#[divan::bench]
fn turn_about_3_s(bencher: Bencher) {
    make(bencher, &leg(stands(Vec3::ZERO, 0.0), stands(Vec3::ZERO, 3.0), 0.0));
}
