//! PSI's networks on this machine's processor: one training step of 32 bodies, and 100 bodies from one view
//! (demands: a compact step within 60 ms on two idle threads; 100 bodies well under 2 s).

use divan::{Bencher, black_box};
use glam::{Mat3, Vec3};
use inhabit::assets::{Precision, Weights};
use inhabit::generate::learned::LearnedSampler;
use inhabit::generate::sensor::{Intrinsics, SIDE, SceneImage, Valid, View};
use inhabit::job::{JobCtx, Seed, Ticker};
use inhabit::learn::corpus::{CorpusView, ViewKind};
use inhabit::learn::psi::{PsiBody, PsiData, PsiTraining, TrainingInput, TrainingState, train};
use inhabit::nn::psi::{PsiMethod, PsiNetwork};
use inhabit::scene::{BodyParams, POSE};

fn main() {
    divan::main();
}

fn image(person: usize) -> SceneImage {
    let look = View::look_at(Vec3::new(1.5, 2.0, 2.5), Vec3::new(0.0, 0.9, 0.0), Intrinsics::PROX_E);
    let (view, valid) = Valid::of(&look);
    let depth = (0..SIDE * SIDE).map(|p| 2.0 + ((p * 31 + person * 977) % 3000) as f32 * 1e-3).collect();
    SceneImage::new(view, valid, depth, (0..SIDE * SIDE).map(|p| (p / 700 % 40) as u8).collect())
}

/// 32 bodies, so that one epoch is one step.
fn corpus() -> PsiData {
    let mut data = PsiData { id: "bench".to_owned(), ..PsiData::default() };
    for person in 0..32 {
        data.views.push(CorpusView::new(ViewKind::Virtual, person, &image(person)));
        let mut params = BodyParams { translation: Vec3::new(0.0, 0.9, 0.0), ..BodyParams::default() };
        params.set_rotation(&Mat3::from_rotation_y(person as f32));
        data.train.push(PsiBody { room: 0, params, mirrored_pose: [0.0; POSE], views: vec![person] });
    }
    data
}

fn step(bencher: Bencher, training: PsiTraining) {
    let data = corpus();
    let training = PsiTraining { epochs: 1, ..training };
    bencher.with_inputs(|| TrainingState::new(training.clone(), data.id.clone())).bench_refs(|state| {
        let input = TrainingInput { data: &data, fields: &[] };
        let ended = train(state, &input, &JobCtx::headless(Seed::root(0)), &mut |_| Ok(()));
        assert!(ended.is_ok());
    });
}

#[divan::bench(args = PsiMethod::ALL, sample_count = 20)]
fn training_step_compact(bencher: Bencher, method: PsiMethod) {
    step(bencher, PsiTraining::compact(method));
}

#[divan::bench(args = PsiMethod::ALL, sample_count = 3, sample_size = 1)]
fn training_step_paper(bencher: Bencher, method: PsiMethod) {
    step(bencher, PsiTraining::paper(method));
}

#[divan::bench(args = PsiMethod::ALL, sample_count = 20)]
fn hundred_bodies_from_one_view(bencher: Bencher, method: PsiMethod) {
    let (network, params) = PsiNetwork::declare(&PsiTraining::compact(method).network, 1);
    let mut weights = Weights::new("bench");
    network.store(&params, &mut weights);
    let weights =
        Weights::from_bytes("bench", &weights.to_bytes(Precision::Half).expect("bytes")).expect("weights");
    let image = image(0);
    // Reading the weights is part of what a user waits for the first time.
    bencher.bench(|| {
        let sampler = LearnedSampler::from_weights(&weights).expect("a network");
        black_box(sampler.sample(&image, 100, Seed::root(1), &Ticker::silent(), &mut |_| ()).expect("bodies"))
    });
}
