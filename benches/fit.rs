//! One iteration and a whole fit of one body, in the room of the distance-field benchmark. One thread.

#[path = "../src/scene/field/test_room.rs"]
#[allow(dead_code, missing_docs)]
mod test_room;

use divan::{Bencher, black_box};
use glam::Vec3;
use inhabit::body::Body;
use inhabit::fit::{FitConfig, FitPreset, Fitter, Surroundings};
use inhabit::job::Ticker;
use inhabit::scene::{BodyParams, PoseFamily, SignedDistanceField};

fn main() {
    // One thread, whatever the machine: a fit is the unit that threads are given.
    divan::main();
}

/// The exact distances of the synthetic room on 256³ samples, as the Python baseline has them.
fn field() -> SignedDistanceField {
    let pad = Vec3::splat(0.2);
    let (origin, far) = (test_room::LOW - pad, test_room::HIGH + pad);
    let dim = [256; 3];
    let cell_m = (far - origin) / 255.0;
    let mut field = SignedDistanceField { dim, origin, cell_m, values: Vec::new() };
    let samples = (0..256).flat_map(|x| (0..256).flat_map(move |y| (0..256).map(move |z| (x, y, z))));
    field.values = samples
        .map(|(x, y, z)| test_room::exact_distance(origin + Vec3::new(x as f32, y as f32, z as f32) * cell_m))
        .collect();
    field
}

/// Near the sofa and a little inside it, as the Python baseline starts.
fn start() -> BodyParams {
    BodyParams { translation: Vec3::new(-1.2, 0.72, -1.9), ..BodyParams::default() }
}

const PRESETS: [FitPreset; 4] =
    [FitPreset::PsiProxe, FitPreset::PsiMatterport, FitPreset::PsiNotebook, FitPreset::Rescue];

/// Forward, energies and gradient: against 29 ms of PyTorch with a KD-tree on a quiet machine.
#[divan::bench(args = [FitPreset::PsiProxe, FitPreset::Rescue])]
fn one_iteration(bencher: Bencher<'_, '_>, preset: FitPreset) {
    let (field, fitter) = (field(), Fitter::new(Body::bundled()));
    let around = Surroundings::of_field(&field);
    let config = FitConfig { iterations: 1, ..preset.into() };
    let start = start();
    bencher.bench_local(|| {
        fitter.fit(&around, black_box(&start), PoseFamily::SitSofa, &config, &Ticker::silent(), &mut |_| ())
    });
}

/// A whole body from proposal to rest.
#[divan::bench(args = PRESETS, sample_count = 20)]
fn whole_fit(bencher: Bencher<'_, '_>, preset: FitPreset) {
    let (field, fitter) = (field(), Fitter::new(Body::bundled()));
    let around = Surroundings::of_field(&field);
    let (config, start) = (FitConfig::from(preset), start());
    bencher.bench_local(|| {
        fitter.fit(&around, black_box(&start), PoseFamily::SitSofa, &config, &Ticker::silent(), &mut |_| ())
    });
}
