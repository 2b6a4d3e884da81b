//! The main job's promises: people who are held and do not sink in, different ones, the same for the same seed.

use std::ops::ControlFlow;

use inhabit::assets::{Budget, read_model_bytes, sample_rooms};
use inhabit::evolve::{OnCancel, PopulatePreview, PopulateRequest, Populated, populate};
use inhabit::job::{JobCtx, Seed, Stop, Ticker};
use inhabit::scene::{GeometryConfig, ImportOptions, Room, RoomGeometry, room_from_model};

fn sample(key: &str) -> (Room, RoomGeometry) {
    let sample = sample_rooms().iter().find(|r| r.key == key).expect("bundled room");
    let model = read_model_bytes(key, sample.glb, &Budget::default()).expect("bundled rooms are sound");
    let room = room_from_model(&model, &ImportOptions::default()).room;
    let geometry = RoomGeometry::build(&room, &GeometryConfig::default(), &|_, _| ControlFlow::Continue(()));
    (room, geometry.expect("not stopped"))
}

fn people(room: &Room, geometry: &RoomGeometry, seed: u64, threads: usize) -> Populated {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let request = PopulateRequest { people: 5, ..PopulateRequest::default() };
    pool.install(|| populate(room, geometry, &request, &JobCtx::headless(Seed::root(seed)))).expect("people")
}

#[test]
fn people_in_the_bedroom_are_held_do_not_sink_in_and_do_different_things() {
    let (room, geometry) = sample("bedroom");
    let found = people(&room, &geometry, 1, 2);
    assert_eq!((found.people.len(), &found.shortfall), (5, &None));
    for person in &found.people {
        let m = &person.report.metrics;
        assert!(person.findings.is_empty(), "{}: {:?}", person.person.name, person.findings);
        assert!(
            m.supported && m.contact_2cm && m.penetration_max_mm <= 25.0,
            "{}: {m:?}",
            person.person.name
        );
        assert!(m.psi_non_collision >= 0.985, "{}: {}", person.person.name, m.psi_non_collision);
    }
    let mut groups: Vec<&str> = found.people.iter().map(|p| p.person.family.group()).collect();
    groups.sort_unstable();
    groups.dedup();
    assert!(groups.len() >= 3, "{groups:?}");

    let again = people(&room, &geometry, 1, 1);
    let bodies = |p: &Populated| p.people.iter().map(|p| p.person.clone()).collect::<Vec<_>>();
    assert_eq!(bodies(&found), bodies(&again), "the same seed on one thread and on two");
    assert_ne!(bodies(&found), bodies(&people(&room, &geometry, 2, 2)));
}

#[test]
fn a_cancel_keeps_who_is_there_where_that_is_asked_for_and_drops_them_elsewhere() {
    let (room, geometry) = sample("bedroom");
    let cancelled_after_eight_fits = |on_cancel: OnCancel| {
        let ticker = Ticker::silent();
        let watched = ticker.clone();
        let cx = JobCtx::watched(Seed::root(1), ticker).mapped(move |_: PopulatePreview| {
            let progress = watched.progress();
            if progress.stage == "fitting people" && progress.done >= 8 {
                watched.cancel();
            }
        });
        let request = PopulateRequest { people: 5, on_cancel, ..PopulateRequest::default() };
        populate(&room, &geometry, &request, &cx)
    };
    let kept = cancelled_after_eight_fits(OnCancel::KeepBest).expect("people");
    assert!(
        (1..=5).contains(&kept.people.len()) && kept.fitted < 14,
        "{} of {}",
        kept.people.len(),
        kept.fitted
    );
    assert!(kept.people.iter().all(|p| p.findings.is_empty()));
    assert!(matches!(cancelled_after_eight_fits(OnCancel::Drop), Err(Stop::Cancelled)));
}

#[test]
fn nobody_is_put_inside_somebody_who_is_there_and_a_full_room_says_so() {
    let (room, geometry) = sample("bedroom");
    let first = people(&room, &geometry, 1, 2);
    let existing: Vec<_> = first.people.iter().map(|p| p.person.clone()).collect();
    let at = existing[0].body.translation * glam::Vec3::new(1.0, 0.0, 1.0);
    let request = PopulateRequest {
        people: 40,
        at: Some(at),
        next_id: existing.len() as u32,
        existing,
        ..PopulateRequest::default()
    };
    let more = populate(&room, &geometry, &request, &JobCtx::headless(Seed::root(3))).expect("people");
    assert!(more.people.len() < 40);
    assert!(more.shortfall.as_deref().is_some_and(|s| s.contains("of 40 people")), "{:?}", more.shortfall);
    for person in &more.people {
        assert!(person.person.id.0 >= 5, "ids are never used twice");
        for other in &request.existing {
            let apart = person.person.body.translation.distance(other.body.translation);
            assert!(apart > 0.15, "{} stands in {}", person.person.name, other.name);
        }
    }
}

#[test]
fn a_cancelled_job_ends_as_cancelled() {
    let (room, geometry) = sample("bedroom");
    let cx = JobCtx::headless(Seed::root(1));
    cx.cancel();
    let result = populate(&room, &geometry, &PopulateRequest::default(), &cx);
    assert!(matches!(result, Err(Stop::Cancelled)));
}
