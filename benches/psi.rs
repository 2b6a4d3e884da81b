//! PSI's networks on this machine's processor: one training step of 32 bodies, 100 bodies from one view, and the same
//! fitted in a real room (demands: a compact step within 60 ms on two idle threads; 100 bodies under 2 s, under 60 s
//! when fitted; the first preview within 300 ms).

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use divan::{Bencher, black_box};
use glam::{Mat3, Vec3};
use inhabit::assets::{Budget, Precision, Weights, read_model_bytes, sample_rooms};
use inhabit::evolve::{RefineRequest, refine};
use inhabit::generate::learned::{LearnedMethod, LearnedSampler};
use inhabit::generate::sensor::{
    AgentConfig, Intrinsics, SIDE, SceneImage, Sensor, Valid, View, agent_views,
};
use inhabit::job::{Job, JobCtx, Outcome, Seed, Ticker};
use inhabit::learn::corpus::{CorpusView, ViewKind};
use inhabit::learn::psi::{PsiBody, PsiData, PsiTraining, TrainingInput, TrainingState, train};
use inhabit::nn::psi::{PsiMethod, PsiNetwork};
use inhabit::scene::{BodyParams, GeometryConfig, ImportOptions, POSE, RoomGeometry, room_from_model};

fn main() {
    if std::env::args().any(|argument| argument == "--bench") {
        sampled_and_fitted();
    }
    divan::main();
}

/// A hundred bodies from one view of the living room, by the networks that ship with the program, each fitted by ours:
/// prints what a user waits for. Geometry and weights are there already, as in the window.
fn sampled_and_fitted() {
    let sample = sample_rooms().iter().find(|r| r.key == "living").expect("bundled");
    let model = read_model_bytes("living", sample.glb, &Budget::default()).expect("bundled rooms are sound");
    let room = room_from_model(&model, &ImportOptions::default()).room;
    let geometry = RoomGeometry::build(&room, &GeometryConfig::default(), &|_, _| ControlFlow::Continue(()));
    let (room, geometry) = (Arc::new(room), Arc::new(geometry.expect("not stopped")));
    let sensor = Sensor::new(&room, &geometry);
    let view = agent_views(&sensor, 1, &AgentConfig::default(), Seed::root(1))[0];
    for network in PsiMethod::ALL {
        let method = LearnedMethod { network, scene_loss: false };
        let sampler = LearnedSampler::bundled(method).expect("bundled weights");
        let start = Instant::now();
        let image = sensor.scene_image(&view);
        let bodies =
            sampler.sample(&image, 100, Seed::root(1), &Ticker::silent(), &mut |_| ()).expect("bodies");
        let sampled = start.elapsed();
        let (of, around, wanted) = (room.clone(), geometry.clone(), bodies);
        let work = move |cx: &JobCtx<_>| refine(&of, &around, &wanted, &RefineRequest::default(), cx);
        let mut job = Job::spawn("fit", Seed::root(1), || (), work);
        let mut first = None;
        let fitted = loop {
            if first.is_none() && job.take_preview().is_some() {
                first = Some(start.elapsed());
            }
            match job.poll() {
                Some(outcome) => break outcome,
                None => std::thread::sleep(Duration::from_millis(1)),
            }
        };
        let Outcome::Done(fitted) = fitted else { panic!("not fitted") };
        let sound = fitted.iter().filter(|r| r.findings.is_empty()).count();
        println!(
            "{}: captured and sampled 100 in {:.0} ms; first preview after {:.0} ms; fitted after {:.1} s, {sound} without findings",
            network.label(),
            sampled.as_secs_f64() * 1e3,
            first.map_or(f64::NAN, |d: Duration| d.as_secs_f64() * 1e3),
            start.elapsed().as_secs_f64()
        );
    }
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
