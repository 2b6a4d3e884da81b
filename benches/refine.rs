//! Refining one body, from the guess of what it does to the measured result, in the bundled bedroom. One thread;
//! a hundred bodies must take less than a minute on two.

use std::ops::ControlFlow;

use divan::{Bencher, black_box};
use inhabit::assets::{Budget, read_model_bytes, sample_rooms};
use inhabit::evolve::{RefineRequest, refine};
use inhabit::fit::FitPreset;
use inhabit::job::{JobCtx, Seed};
use inhabit::learn::random_placements;
use inhabit::scene::{GeometryConfig, ImportOptions, Room, RoomGeometry, room_from_model};

fn main() {
    divan::main();
}

fn bedroom() -> (Room, RoomGeometry) {
    let sample = sample_rooms().iter().find(|r| r.key == "bedroom").expect("bundled room");
    let model = read_model_bytes("bedroom", sample.glb, &Budget::default()).expect("bundled rooms are sound");
    let room = room_from_model(&model, &ImportOptions::default()).room;
    let go_on = |_, _| ControlFlow::Continue(());
    let geometry = RoomGeometry::build(&room, &GeometryConfig::default(), &go_on).expect("not stopped");
    (room, geometry)
}

/// A body at a random place: guess, repair, coarse search, fits and measurements.
#[divan::bench(args = [FitPreset::Rescue, FitPreset::PsiProxe], sample_count = 10)]
fn one_body(bencher: Bencher<'_, '_>, preset: FitPreset) {
    let (room, geometry) = bedroom();
    let samples = random_placements(&geometry, 10, Seed::root(2));
    let request = RefineRequest::of_preset(preset);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut next = 0;
    bencher.bench_local(|| {
        next = (next + 1) % samples.len();
        let sample = std::slice::from_ref(&samples[next]);
        let cx = JobCtx::headless(Seed::root(0));
        pool.install(|| refine(&room, &geometry, black_box(sample), &request, &cx))
    });
}
