//! Estimating people from keypoints: the room helps, the result repeats, and OpenPose's file leads to a body.

use std::ops::ControlFlow;

use inhabit::assets::{Budget, KeypointSet, read_keypoints_bytes, read_model_bytes, sample_rooms};
use inhabit::body::Body;
use inhabit::evolve::{
    EstimateRequest, EstimatorKind, PopulateRequest, estimate_person, mean_code, populate,
};
use inhabit::inspect::{EstimateErrors, Limits};
use inhabit::job::{JobCtx, Seed, Ticker};
use inhabit::learn::estimation::{Case, ObserveConfig, Observer, cases_of_room, study_room, summarise};
use inhabit::scene::{
    BodyParams, GeometryConfig, ImportOptions, PoseFamily, Room, RoomGeometry, room_from_model,
};

fn bedroom() -> (Room, RoomGeometry) {
    let sample = sample_rooms().iter().find(|r| r.key == "bedroom").expect("bundled room");
    let model = read_model_bytes("bedroom", sample.glb, &Budget::default()).expect("bundled rooms are sound");
    let room = room_from_model(&model, &ImportOptions::default()).room;
    let geometry = RoomGeometry::build(&room, &GeometryConfig::default(), &|_, _| ControlFlow::Continue(()));
    (room, geometry.expect("not stopped"))
}

fn cases(room: &Room, geometry: &RoomGeometry) -> Vec<Case> {
    let request = PopulateRequest { people: 3, ..PopulateRequest::default() };
    let found = populate(room, geometry, &request, &JobCtx::headless(Seed::root(1))).expect("people");
    let people: Vec<(BodyParams, PoseFamily)> =
        found.people.into_iter().map(|p| (p.person.body, p.person.family)).collect();
    let mut cases = cases_of_room("bedroom", geometry, &people, 1, 0, Seed::root(1));
    // A prior that knows what people do here.
    let bodies: Vec<BodyParams> = people.into_iter().map(|(body, _)| body).collect();
    cases.iter_mut().for_each(|case| case.scene_code = mean_code(&bodies));
    cases
}

#[test]
fn a_study_repeats_on_any_number_of_threads_and_the_room_helps() {
    let (room, geometry) = bedroom();
    let cases = cases(&room, &geometry);
    let study = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let config = ObserveConfig::default();
        pool.install(|| study_room(&geometry, &cases, &config, Seed::root(1), &Ticker::silent()))
            .expect("study")
    };
    let results = study(2);
    assert!(results.len() >= 2, "cameras see people");
    let errors = |results: &[inhabit::learn::estimation::CaseResult]| {
        results.iter().map(|r| r.errors.clone()).collect::<Vec<_>>()
    };
    assert_eq!(errors(&results), errors(&study(1)));
    let summary = summarise(&results, Seed::root(1));
    let v2v = |m: usize| summary.methods[m].errors.v2v_mm;
    assert!(v2v(1) < v2v(0) + 20.0, "PROX {} against SMPLify-X {}", v2v(1), v2v(0));
    assert!(v2v(2) < 250.0, "{}", v2v(2));
}

#[test]
fn an_open_pose_file_and_a_camera_lead_to_a_body_in_the_room() {
    let (room, geometry) = bedroom();
    let case = cases(&room, &geometry).swap_remove(0);
    let config = ObserveConfig { noise_px: 3.0, dropped: 0.0, ..ObserveConfig::default() };
    let view = Observer::enlarged(&case.view, &config);
    let seen =
        Observer::new(Body::bundled()).observe(&case.truth, &view, &geometry.bvh, &config, Seed::root(4));
    let numbers: Vec<String> =
        seen.points.iter().map(|p| format!("{},{},{}", p.pixel.x, p.pixel.y, p.confidence)).collect();
    let file = format!(r#"{{"people":[{{"pose_keypoints_2d":[{}]}}]}}"#, numbers.join(","));
    let pictures = read_keypoints_bytes("photo_keypoints.json", file.as_bytes()).expect("sound");
    let keypoints = pictures[0].people[0].clone();
    assert_eq!(keypoints.set, KeypointSet::Body25);
    let request = EstimateRequest {
        view,
        keypoints,
        estimator: EstimatorKind::Prox,
        scene_code: [0.0; 32],
        limits: Limits::default(),
    };
    let found = estimate_person(&geometry, &request, &JobCtx::headless(Seed::root(0))).expect("a body");
    let errors = EstimateErrors::of(Body::bundled(), &found.params, &case.truth);
    assert!(errors.pje_mm < 250.0, "{errors:?}");
    assert!(found.reprojection_px < 40.0, "{} px", found.reprojection_px);
    assert!(!found.trace.is_empty());
}
