//! Refining promises: whatever a network or chance proposes ends held and free of penetration, near where it was.

use std::ops::ControlFlow;

use glam::Vec3;
use inhabit::assets::{Budget, read_model_bytes, sample_rooms};
use inhabit::body::Body;
use inhabit::evolve::{PopulateRequest, RefineRequest, Refined, populate, refine};
use inhabit::fit::{FitConfig, FitPreset, Fitter, Surroundings};
use inhabit::inspect::Metric;
use inhabit::job::{JobCtx, Seed, Stop, Ticker};
use inhabit::learn::{Disturbance, random_placements};
use inhabit::scene::{
    BodyParams, GeometryConfig, ImportOptions, PoseFamily, Room, RoomGeometry, room_from_model,
};

fn sample(key: &str) -> (Room, RoomGeometry) {
    let sample = sample_rooms().iter().find(|r| r.key == key).expect("bundled room");
    let model = read_model_bytes(key, sample.glb, &Budget::default()).expect("bundled rooms are sound");
    let room = room_from_model(&model, &ImportOptions::default()).room;
    let geometry = RoomGeometry::build(&room, &GeometryConfig::default(), &|_, _| ControlFlow::Continue(()));
    (room, geometry.expect("not stopped"))
}

/// People of the search, disturbed as a poor network errs.
fn disturbed(room: &Room, geometry: &RoomGeometry, count: usize, seed: u64) -> Vec<BodyParams> {
    let request = PopulateRequest { people: count, ..PopulateRequest::default() };
    let people = populate(room, geometry, &request, &JobCtx::headless(Seed::root(seed))).expect("people");
    let bodies: Vec<BodyParams> = people.people.into_iter().map(|p| p.person.body).collect();
    Disturbance::default().apply(&bodies, Seed::root(seed))
}

fn anywhere(geometry: &RoomGeometry, count: usize, seed: u64) -> Vec<BodyParams> {
    random_placements(geometry, count, Seed::root(seed))
}

fn refined(
    room: &Room,
    geometry: &RoomGeometry,
    samples: &[BodyParams],
    request: &RefineRequest,
) -> Vec<Refined> {
    refine(room, geometry, samples, request, &JobCtx::headless(Seed::root(0))).expect("not cancelled")
}

fn mean(of: impl Iterator<Item = f32>) -> f32 {
    let all: Vec<f32> = of.collect();
    all.iter().sum::<f32>() / all.len().max(1) as f32
}

#[test]
fn disturbed_and_random_people_end_held_and_free_of_penetration() {
    let (room, geometry) = sample("bedroom");
    let mut samples = disturbed(&room, &geometry, 8, 1);
    samples.extend(anywhere(&geometry, 10, 2));
    let people = refined(&room, &geometry, &samples, &RefineRequest::default());
    for (i, person) in people.iter().enumerate() {
        let m = &person.report.metrics;
        assert!(m.psi_non_collision > 0.97 && m.contact_2cm, "{i}, {}: {m:?}", person.family.label());
        assert!(person.params.to_vector().iter().all(|v| v.is_finite()));
    }
    let non_collision = mean(people.iter().map(|p| p.report.metrics.psi_non_collision));
    assert!(non_collision >= 0.98, "{non_collision}");
    let held = people.iter().filter(|p| p.report.metrics.supported).count();
    assert!(held * 10 >= people.len() * 9, "{held} of {}", people.len());
    let far = mean(people.iter().take(8).map(|p| p.moved_m));
    assert!(far < 0.6, "disturbed by half a metre at most, moved by {far} m in the mean");
}

#[test]
fn a_body_comes_out_the_same_alone_and_among_others_on_any_number_of_threads() {
    let (room, geometry) = sample("bedroom");
    let samples = anywhere(&geometry, 3, 5);
    let request = RefineRequest { starts_near: 1, starts_anywhere: 0, ..RefineRequest::default() };
    let on = |threads: usize, samples: &[BodyParams]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let people = pool.install(|| refined(&room, &geometry, samples, &request));
        people.into_iter().map(|p| (p.params, p.trace)).collect::<Vec<_>>()
    };
    let together = on(2, &samples);
    assert_eq!(together, on(1, &samples));
    for (sample, expected) in samples.iter().zip(&together) {
        assert_eq!(&on(1, std::slice::from_ref(sample))[0], expected, "Adam's state must not leak");
    }
}

#[test]
fn the_published_fit_starts_at_the_sample_and_does_nothing_else() {
    let (room, geometry) = sample("bedroom");
    let samples = anywhere(&geometry, 2, 7);
    let people = refined(&room, &geometry, &samples, &RefineRequest::of_preset(FitPreset::PsiProxe));
    let fitter = Fitter::new(Body::bundled());
    let around = Surroundings::of_field(&geometry.field);
    for (person, sample) in people.iter().zip(&samples) {
        let config = FitConfig::from(FitPreset::PsiProxe);
        let fitted = fitter
            .fit(&around, sample, PoseFamily::Stand, &config, &Ticker::silent(), &mut |_| ())
            .expect("fit");
        assert_eq!((&person.params, person.trace.len()), (&fitted.params, 20));
    }
}

#[test]
fn numbers_that_are_not_finite_are_a_finding_and_a_cancel_ends_the_job() {
    let (room, geometry) = sample("bedroom");
    let broken = BodyParams { translation: Vec3::new(f32::NAN, 0.0, 0.0), ..BodyParams::default() };
    let people = refined(&room, &geometry, &[broken], &RefineRequest::default());
    assert_eq!(people[0].findings[0].metric, Metric::NotFinite);
    let cx = JobCtx::headless(Seed::root(1));
    cx.cancel();
    let stopped = refine(&room, &geometry, &[BodyParams::default()], &RefineRequest::default(), &cx);
    assert!(matches!(stopped, Err(Stop::Cancelled)));
}
