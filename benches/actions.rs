//! Poses in space from the joints of a photo, and what layouts cost. One thread; a photo's person must take less than
//! 20 ms, or learning from two thousand takes longer than a coffee.

use divan::{Bencher, black_box};
use inhabit::assets::Keypoint;
use inhabit::assets::photos::PHOTO_JOINTS;
use inhabit::job::{Seed, Ticker};
use inhabit::learn::actions::pose::{PoseDictionary, PoseSolver, PoseSolverConfig};
use inhabit::learn::actions::simulate::{Conditions, Truth, simulated_photos, unseen_families};
use inhabit::math::directions::{MixtureConfig, VonMisesMixture};

fn main() {
    divan::main();
}

/// Joints of people as simulated photos mark them, half of them without legs.
fn people() -> Vec<[Keypoint; PHOTO_JOINTS]> {
    let conditions = Conditions { photos: 40, ..Conditions::default() };
    let photos = simulated_photos(&Truth::example(), &conditions, Seed::root(1)).expect("sound");
    photos.iter().flat_map(|p| &p.people).map(|p| p.joints).collect()
}

/// One person, by the relaxation alone and with the refinement.
#[divan::bench(args = [false, true], sample_count = 200)]
fn pose_in_space(bencher: Bencher<'_, '_>, refine: bool) {
    let people = people();
    let config = PoseSolverConfig { refine, ..PoseSolverConfig::default() };
    let solver = PoseSolver::new(PoseDictionary::bundled(), config);
    let mut next = 0;
    bencher.bench_local(|| {
        next = (next + 1) % people.len();
        solver.solve(black_box(&people[next]))
    });
}

/// 1 to 4 components by AIC.
#[divan::bench(args = [30, 300])]
fn mixture_of_directions(bencher: Bencher<'_, '_>, angles: usize) {
    let poses = unseen_families(angles.div_ceil(10), Seed::root(1), &Ticker::silent());
    let angles: Vec<f64> =
        poses.unwrap_or_default().iter().map(|p| f64::from(p[9].x.atan2(p[9].z))).take(angles).collect();
    bencher.bench_local(|| VonMisesMixture::fit(black_box(&angles), &MixtureConfig::default(), 1));
}
