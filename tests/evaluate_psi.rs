//! The tables' promises: rows for every method and room, the same for the same seed; a better method shows as one.

use std::ops::ControlFlow;
use std::sync::Arc;

use inhabit::assets::{Budget, read_model_bytes, sample_rooms};
use inhabit::job::{JobCtx, Seed};
use inhabit::learn::evaluate_psi::{
    Evaluation, EvaluationConfig, EvaluationRoom, Evaluator, MethodToEvaluate, RandomPlacement,
    SearchPlacement, Stage,
};
use inhabit::scene::{GeometryConfig, ImportOptions, RoomGeometry, room_from_model};

fn bedroom() -> EvaluationRoom {
    let sample = sample_rooms().iter().find(|r| r.key == "bedroom").expect("bundled room");
    let model = read_model_bytes("bedroom", sample.glb, &Budget::default()).expect("bundled rooms are sound");
    let room = Arc::new(room_from_model(&model, &ImportOptions::default()).room);
    let geometry = RoomGeometry::build(&room, &GeometryConfig::default(), &|_, _| ControlFlow::Continue(()));
    EvaluationRoom {
        name: "bedroom".into(),
        set: "sample rooms".into(),
        room,
        geometry: geometry.expect("not stopped"),
        images: Vec::new(),
    }
}

fn methods() -> Vec<MethodToEvaluate> {
    let method = |name: &str, placer| MethodToEvaluate { name: name.into(), placer, representer: None };
    vec![
        method("random", Ok(Box::new(RandomPlacement))),
        method("search", Ok(Box::new(SearchPlacement))),
        method("S1", Err("no weights".into())),
    ]
}

fn evaluation(room: &EvaluationRoom, threads: usize) -> Evaluation {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let config = EvaluationConfig { samples: 24, fitted: 2, views: 2, ..EvaluationConfig::default() };
    pool.install(|| {
        let cx = JobCtx::headless(Seed::root(1));
        let mut evaluator = Evaluator::new(methods(), config);
        evaluator.room(room, &cx).expect("not stopped");
        evaluator.finish(cx.seed)
    })
}

#[test]
fn search_beats_chance_fitting_helps_and_the_same_seed_gives_the_same_tables() {
    let room = bedroom();
    let found = evaluation(&room, 2);
    let row = |method: &str, stage| found.of_set(method, "sample rooms", stage).expect("a row");
    let (random, search) = (row("random", Stage::Before), row("search", Stage::Before));
    assert_eq!((random.bodies, search.bodies), (24, 24));
    assert!(search.psi_non_collision > random.psi_non_collision + 0.05, "{search:?} {random:?}");
    let fitted = row("search", Stage::OurFit);
    assert_eq!(fitted.bodies, 2);
    assert!(fitted.psi_non_collision > 0.97 && fitted.contact_2cm == 1.0, "{fitted:?}");
    assert_eq!(random.entropy_world_nats, None, "24 bodies are too few for 20 clusters");
    assert!(found.of_set("S1", "sample rooms", Stage::Before).is_none());
    assert_eq!(found.missing[0].why, "no weights");
    assert_eq!(found.rows.iter().filter(|r| r.room.as_deref() == Some("bedroom")).count(), 9);
    assert_eq!(found, evaluation(&room, 1), "one thread gives what two give");
}
