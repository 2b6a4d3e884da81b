//! Speed of the learned pose space: a decoding, its gradient, an encoding. One thread.

use divan::{Bencher, black_box};
use glam::Vec3;
use inhabit::body::joints::BODY_JOINTS;
use inhabit::body::{Body, PoseTape};
use inhabit::scene::POSE;

fn main() {
    divan::main();
}

fn code() -> [f32; POSE] {
    std::array::from_fn(|i| (i as f32).sin())
}

#[divan::bench]
fn decode(bencher: Bencher) {
    let space = &Body::bundled().pose_space;
    let mut tape = PoseTape::default();
    bencher.bench_local(|| space.decode_taped(black_box(&code()), &mut tape));
}

#[divan::bench]
fn decode_and_pull_back(bencher: Bencher) {
    let space = &Body::bundled().pose_space;
    let mut tape = PoseTape::default();
    let gradient = [Vec3::new(0.1, 0.2, 0.3); BODY_JOINTS];
    bencher.bench_local(|| {
        black_box(space.decode_taped(black_box(&code()), &mut tape));
        space.pull_back_taped(&code(), &tape, black_box(&gradient))
    });
}

#[divan::bench]
fn encode(bencher: Bencher) {
    let space = &Body::bundled().pose_space;
    let pose = space.decode(&code());
    bencher.bench_local(|| space.encode(black_box(&pose)));
}
