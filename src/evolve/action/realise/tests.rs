//! Promises to a user, kept in the sample rooms.

use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use super::evolution::{Evolution, EvolutionConfig, GroupMode};
use super::library::Library;
use super::measure::{PENETRATION_MM, measure};
use super::stage::Stage;
use super::step::{MoveReason, Verdict};
use crate::assets::{Budget, read_model_bytes, sample_rooms};
use crate::body::Body;
use crate::evolve::action::{
    ActionKind, ActionModel, ActionNode, Evidence, GroupModel, KeyObject, KeyRelation, Occurrence,
    PEOPLE_APART_M, PairPlacement, Placement, PolarDensity, Posture,
};
use crate::job::{Seed, Ticker};
use crate::math::LogNormal;
use crate::math::directions::{VonMises, VonMisesMixture};
use crate::scene::{ImportOptions, Room, room_from_model};

fn sample(key: &str) -> Room {
    let sample = sample_rooms().iter().find(|r| r.key == key).expect("bundled");
    let model = read_model_bytes(key, sample.glb, &Budget::default()).expect("reads");
    room_from_model(&model, &ImportOptions::default()).room
}

/// The stages of the three sample rooms, each made once.
fn stage(key: &'static str) -> Arc<Stage> {
    static MADE: LazyLock<Mutex<Vec<(&'static str, Arc<Stage>)>>> = LazyLock::new(Mutex::default);
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, stage)) = made.iter().find(|(known, _)| *known == key) {
        return stage.clone();
    }
    let stage =
        Stage::new(Arc::new(sample(key)), Library::bundled(), &Ticker::silent()).expect("not cancelled");
    let stage = Arc::new(stage);
    made.push((key, stage.clone()));
    stage
}

fn density(distance_m: f64, spread: f64, degrees: f64, kappa: f64) -> PolarDensity {
    let direction = VonMises { mean_rad: degrees.to_radians(), kappa };
    PolarDensity {
        distance_m: LogNormal { mu: distance_m.ln(), sigma: spread },
        direction: VonMisesMixture { components: vec![(1.0, direction)] },
        samples: 50,
        evidence: Evidence::Node,
    }
}

/// Things as (label, probabilities of 0, 1 …, metres away, spread, degrees, kappa).
type Thing<'a> = (&'a str, &'a [f64], f64, f64, f64, f64);

fn node(kind: ActionKind, key: KeyObject, how: (KeyRelation, Posture), things: &[Thing<'_>]) -> ActionNode {
    let occurrence =
        things.iter().map(|t| Occurrence { object: t.0.to_owned(), probability: t.1.to_vec() }).collect();
    let placement =
        |t: &Thing<'_>| Placement { object: t.0.to_owned(), density: density(t.2, t.3, t.4, t.5) };
    let around = how.0 == KeyRelation::Around;
    ActionNode {
        kind,
        key,
        relation: how.0,
        posture: how.1,
        instances: 50,
        complete_instances: 30,
        key_angle: around.then_some(VonMises { mean_rad: std::f64::consts::FRAC_PI_2, kappa: 8.0 }),
        occurrence,
        around_person: things.iter().map(placement).collect(),
        between: Vec::new(),
        group: None,
    }
}

/// Actions by hand: every type of action, about as they were learned.
fn model() -> Arc<ActionModel> {
    use ActionKind as A;
    use KeyObject as K;
    use KeyRelation::{Around, On};
    use Posture::{LieDown, LieUp, Sit, Stand};
    const SURE: &[f64] = &[0.0, 1.0];
    const HALF: &[f64] = &[0.5, 0.5];
    let laptop: Thing<'_> = ("laptop", SURE, 0.45, 0.25, 90.0, 8.0);
    let cup: Thing<'_> = ("cup", &[0.4, 0.5, 0.1], 0.6, 0.3, 40.0, 3.0);
    let book: Thing<'_> = ("book", &[0.0, 0.8, 0.2], 0.45, 0.3, 90.0, 5.0);
    let computer: &[Thing<'_>] = &[
        ("monitor", SURE, 0.75, 0.2, 90.0, 10.0),
        ("keyboard", SURE, 0.4, 0.2, 92.0, 10.0),
        ("mouse", &[0.2, 0.8], 0.45, 0.2, 50.0, 10.0),
        cup,
    ];
    let dinner: &[Thing<'_>] = &[
        ("fork", &[0.2, 0.8], 0.42, 0.2, 125.0, 8.0),
        ("knife", &[0.4, 0.6], 0.42, 0.2, 60.0, 8.0),
        ("cup", &[0.3, 0.7], 0.6, 0.2, 60.0, 5.0),
        ("bowl", HALF, 0.55, 0.2, 110.0, 4.0),
        ("pizza", &[0.6, 0.4], 0.6, 0.2, 90.0, 6.0),
    ];
    let cooking: &[Thing<'_>] = &[
        ("knife", SURE, 0.45, 0.2, 70.0, 8.0),
        ("bowl", HALF, 0.6, 0.2, 110.0, 4.0),
        ("carrot", &[0.3, 0.4, 0.3], 0.5, 0.2, 100.0, 4.0),
        ("bottle", HALF, 0.7, 0.2, 90.0, 3.0),
    ];
    let television: &[Thing<'_>] =
        &[("tv", SURE, 2.4, 0.4, 90.0, 6.0), ("remote", &[0.2, 0.8], 0.5, 0.3, 60.0, 2.0), cup];
    let snacks: &[Thing<'_>] = &[
        ("donut", HALF, 0.5, 0.3, 90.0, 4.0),
        ("cup", SURE, 0.55, 0.3, 60.0, 3.0),
        ("apple", HALF, 0.6, 0.3, 110.0, 3.0),
    ];
    let mut nodes = vec![
        node(A::UseComputer, K::OfficeDesk, (Around, Sit), computer),
        node(A::UseLaptop, K::OfficeDesk, (Around, Sit), &[laptop, cup]),
        node(A::UseLaptop, K::CoffeeTable, (Around, Sit), &[laptop, cup]),
        node(A::UseLaptop, K::Bed, (On, LieDown), &[laptop]),
        node(A::ReadBook, K::Bed, (On, LieUp), &[book]),
        node(A::ReadBook, K::Couch, (On, Sit), &[book, cup]),
        node(A::PrepareFood, K::KitchenIsland, (Around, Stand), cooking),
        node(A::WatchTv, K::Couch, (On, Sit), television),
        node(A::EatSnacks, K::CoffeeTable, (Around, Sit), snacks),
        node(A::EatDinner, K::DiningTable, (Around, Sit), dinner),
        node(A::EatDinnerInGroup, K::DiningTable, (Around, Sit), dinner),
    ];
    let with_mouse = PairPlacement {
        object: "mouse".into(),
        reference: "keyboard".into(),
        together: 0.8,
        density: density(0.28, 0.1, 0.0, 20.0),
    };
    nodes[0].between.push(with_mouse);
    nodes[10].group = Some(GroupModel {
        sizes: vec![(2, 0.4), (3, 0.3), (4, 0.3)],
        shared: vec![
            Occurrence { object: "bottle".into(), probability: vec![0.2, 0.8] },
            Occurrence { object: "pizza".into(), probability: vec![0.3, 0.7] },
        ],
        people_apart_m: PEOPLE_APART_M,
        groups: 20,
    });
    Arc::new(ActionModel { metres_per_unit: 0.5, nodes, ..ActionModel::default() })
}

fn start(key: &'static str, seed: u64) -> Evolution {
    Evolution::new(stage(key), model(), EvolutionConfig::usual(), Seed::root(seed))
}

/// Draws and does actions until `count` are done or none is possible any more.
fn run(mut evolution: Evolution, count: usize) -> Evolution {
    let mut refused = 0;
    while evolution.steps().len() < count && refused < 30 {
        let Some(node) = evolution.draw_next_after(refused) else { break };
        match evolution.apply(node, 0) {
            Ok(next) => (evolution, refused) = (next, 0),
            Err(_) => refused += 1,
        }
    }
    evolution
}

fn node_of(evolution: &Evolution, kind: ActionKind, key: KeyObject) -> usize {
    let nodes = &evolution.model().nodes;
    nodes.iter().position(|n| n.kind == kind && n.key == key).expect("in the model")
}

#[test]
fn after_thirty_actions_nothing_runs_into_anything_and_everything_is_held() {
    for (key, seed) in
        [("living", 1), ("living", 2), ("bedroom", 1), ("bedroom", 2), ("office", 1), ("office", 2)]
    {
        let evolution = run(start(key, seed), 30);
        assert_eq!(evolution.steps().len(), 30, "{key} {seed}");
        let measures = measure(&evolution);
        assert_eq!(measures.interpenetrations, 0, "{key} {seed}: {:?}", measures.pairs);
        assert!(measures.worst_interpenetration_mm <= PENETRATION_MM);
        assert_eq!(measures.unsupported, 0, "{key} {seed}: {:?}", measures.unsupported_objects);
        assert_eq!(measures.out_of_bounds, 0, "{key} {seed}");
        assert!(measures.brought > 8, "{key} {seed}: only {} things came", measures.brought);
    }
}

#[test]
fn no_room_gets_more_of_a_kind_than_it_takes() {
    let evolution = run(start("living", 3), 40);
    let library = evolution.library();
    for (id, kind) in library.kinds() {
        let there = evolution.world().of_kind(id).count();
        let before = evolution.stage().movable.iter().filter(|f| f.kind == Some(id)).count();
        assert!(there <= kind.most.max(before).max(4), "{} of kind {}", there, kind.kind);
    }
}

#[test]
fn what_is_locked_stays_where_it_is() {
    let mut first = start("office", 1);
    let locked: Vec<_> = first.world().items().step_by(2).map(|i| (i.id, i.pose)).collect();
    locked.iter().for_each(|(id, _)| first.lock(*id, true));
    let evolution = run(first, 15);
    for (id, pose) in locked {
        assert_eq!(evolution.world().item(id).map(|i| i.pose), Some(pose));
        assert!(evolution.steps().iter().all(|s| s.moved.iter().all(|m| m.id != id)));
    }
}

#[test]
fn banned_kinds_never_come() {
    let mut config = EvolutionConfig::usual();
    config.banned.insert("cup".into());
    let evolution = run(start("living", 1).with_config(config), 12);
    let steps = evolution.steps();
    assert!(steps.iter().all(|s| s.inserted.iter().all(|i| i.kind != "cup")));
    assert!(steps.iter().any(|s| s.failed.iter().any(|f| f.object == "cup" && f.why.contains("banned"))));
}

#[test]
fn the_same_seed_gives_the_same_room_and_a_branch_leaves_its_origin_alone() {
    let poses = |e: &Evolution| -> Vec<_> {
        e.world()
            .items()
            .map(|i| (i.id, i.name.clone(), i.pose.at.to_array(), i.pose.yaw_rad, i.pose.lean.to_array()))
            .collect()
    };
    let (a, b) = (run(start("living", 7), 6), run(start("living", 7), 6));
    assert_eq!(poses(&a), poses(&b));
    assert_ne!(poses(&a), poses(&run(start("living", 8), 6)));
    let before = poses(&a);
    let node = a.suggestions()[0].node;
    let (left, right) = (a.apply(node, 0), a.apply(node, 1));
    assert_eq!(poses(&a), before, "applying leaves the value alone: keeping it is undo");
    if let (Ok(left), Ok(right)) = (left, right) {
        assert_ne!(poses(&left), poses(&right), "another roll is another outcome");
    }
}

#[test]
fn suggestions_follow_the_graph_and_what_is_off_says_why() {
    let evolution = run(start("bedroom", 1), 1);
    let suggestions = evolution.suggestions();
    assert!(suggestions.windows(2).all(|w| w[0].probability >= w[1].probability));
    assert!((suggestions.iter().map(|s| s.probability).sum::<f64>() - 1.0).abs() < 1e-9);
    assert!(suggestions.iter().all(|s| !s.keys.is_empty()));
    let dinner = evolution.off().iter().find(|o| o.action.contains("dinner")).expect("no dining table");
    assert!(dinner.why.contains("there is no dining table"), "{}", dinner.why);
    let node = node_of(&evolution, ActionKind::EatDinner, KeyObject::DiningTable);
    let refused = evolution.apply(node, 0).err().expect("not possible").to_string();
    assert!(refused.contains("dining table"), "{refused}");
}

#[test]
fn nobody_stands_at_a_couch_to_watch_television() {
    use KeyRelation::Around;
    let watch = node(ActionKind::WatchTv, KeyObject::Couch, (Around, Posture::Stand), &[]);
    let model = Arc::new(ActionModel { nodes: vec![watch], ..(*model()).clone() });
    let evolution = Evolution::new(stage("living"), model, EvolutionConfig::usual(), Seed::root(0));
    assert!(evolution.suggestions().is_empty());
    assert!(evolution.off()[0].why.contains("nothing to stand at"), "{}", evolution.off()[0].why);
}

#[test]
fn things_go_far_when_all_is_taken_near_by() {
    // A table full of plates: what is in the way there goes to another surface, not nowhere.
    let evolution = run(start("living", 9), 40);
    let refused = (0..40).filter(|roll| {
        let node = evolution.draw_next_after(*roll).expect("something is on");
        let why = evolution.apply(node, *roll).err().map(|e| e.why).unwrap_or_default();
        why.contains("no room left")
    });
    assert!(refused.count() <= 4, "there is floor enough in the living room");
}

#[test]
fn a_room_without_key_objects_says_that_nothing_can_be_done() {
    let mut room = sample("bedroom");
    room.objects.retain(|o| o.category.is_structure());
    let stage = Stage::new(Arc::new(room), Library::bundled(), &Ticker::silent()).expect("not cancelled");
    let evolution = Evolution::new(Arc::new(stage), model(), EvolutionConfig::usual(), Seed::root(0));
    assert!(evolution.suggestions().is_empty() && evolution.draw_next().is_none());
    assert_eq!(evolution.off().len(), evolution.model().nodes.len());
}

#[test]
fn a_group_of_two_to_four_sits_apart_with_plates_of_their_own() {
    for size in 2..=4 {
        let config = EvolutionConfig { group_size: Some(size), ..EvolutionConfig::usual() };
        let evolution = start("living", 5).with_config(config);
        let node = node_of(&evolution, ActionKind::EatDinnerInGroup, KeyObject::DiningTable);
        let done = (0..8).find_map(|roll| evolution.apply(node, roll).ok()).expect("some roll works");
        let step = &done.steps()[0];
        assert!((2..=size).contains(&step.people.len()));
        for (i, a) in step.people.iter().enumerate() {
            for b in &step.people[..i] {
                let apart = a.frame.centre_m.with_y(0.0).distance(b.frame.centre_m.with_y(0.0));
                assert!((PEOPLE_APART_M[0]..=PEOPLE_APART_M[1]).contains(&apart), "{apart}");
                assert_ne!(a.chair, b.chair, "everybody has a chair of their own");
            }
        }
        let plates: Vec<_> = step.inserted.iter().filter(|i| i.kind == "plate").map(|i| i.person).collect();
        let owners: std::collections::BTreeSet<_> = plates.iter().collect();
        assert!(plates.iter().all(Option::is_some) && owners.len() == plates.len(), "{plates:?}");
        let shared: Vec<_> = step.inserted.iter().filter(|i| i.person.is_none()).collect();
        for thing in shared {
            let to = |p: &super::StepPerson| p.frame.centre_m.with_y(0.0).distance(thing.pose.at.with_y(0.0));
            let (near, far) =
                step.people.iter().map(to).fold((f32::MAX, 0.0_f32), |(n, f), d| (n.min(d), f.max(d)));
            assert!(far < 2.0 * near, "{} is shared, yet {near} and {far} m away", thing.name);
        }
    }
}

#[test]
fn the_baseline_deals_shared_things_out_to_single_people() {
    let config =
        EvolutionConfig { group_size: Some(3), group: GroupMode::Baseline, ..EvolutionConfig::usual() };
    let evolution = start("living", 5).with_config(config);
    let node = node_of(&evolution, ActionKind::EatDinnerInGroup, KeyObject::DiningTable);
    let done = (0..8).find_map(|roll| evolution.apply(node, roll).ok()).expect("some roll works");
    assert!(done.steps()[0].inserted.iter().all(|i| i.person.is_some()));
}

#[test]
fn a_laptop_is_used_at_the_desk_in_front_of_somebody_on_a_chair() {
    let evolution = start("office", 2);
    let node = node_of(&evolution, ActionKind::UseLaptop, KeyObject::OfficeDesk);
    let done = evolution.apply(node, 0).expect("possible");
    let step = &done.steps()[0];
    let person = &step.people[0];
    assert!(person.chair.is_some() && step.action == "use laptop on desk while sitting");
    let chair = step.moved.iter().find(|m| Some(m.id) == person.chair).expect("one of the office's");
    assert_eq!(chair.why, MoveReason::SatOn);
    let laptop = done.library().named("laptop").expect("known");
    let near = done
        .world()
        .of_kind(laptop)
        .map(|i| i.pose.at)
        .min_by(|a, b| a.distance(person.frame.centre_m).total_cmp(&b.distance(person.frame.centre_m)));
    let seen = person.frame.polar_of(near.expect("there is one"));
    assert!((0.2..0.9).contains(&seen.distance_m), "{} m away", seen.distance_m);
    assert!(
        (30.0..150.0).contains(&seen.angle_rad.to_degrees()),
        "at {} degrees",
        seen.angle_rad.to_degrees()
    );
    // The overlay can say why: the taken place is the best of those that are free.
    let candidates = step.candidates.iter().find(|c| c.object == "laptop").expect("told");
    let taken = candidates.samples.iter().find(|s| s.verdict == Verdict::Taken).expect("one was taken");
    let mut untried = candidates.samples.iter().filter(|s| s.verdict == Verdict::NotTried);
    assert!(untried.all(|s| s.score <= taken.score), "a better place was not tried");
    assert!(candidates.drawn > 1000, "{} places were drawn", candidates.drawn);
}

#[test]
fn people_at_an_action_really_sit_there() {
    let evolution = start("office", 2);
    let node = node_of(&evolution, ActionKind::UseLaptop, KeyObject::OfficeDesk);
    let done = evolution.apply(node, 0).expect("possible");
    let people = super::embody(&done, 0, &Ticker::silent()).expect("not cancelled");
    assert_eq!(people.len(), 1);
    let metrics = &people[0].report.metrics;
    assert!(metrics.supported && metrics.penetration_max_mm < 25.0, "{metrics:?}");
    let joints = Body::bundled().joints(&people[0].person.body);
    let planned = done.steps()[0].people[0].spot.pelvis;
    assert!(
        joints[0].distance(planned) < 0.2,
        "the pelvis is {} m off its place",
        joints[0].distance(planned)
    );
}

#[test]
fn the_evolved_room_holds_everything_once_and_reads_back() {
    let evolution = run(start("living", 4), 5);
    let room = evolution.room();
    let mut ids: Vec<_> = room.objects.iter().map(|o| o.id).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), room.objects.len());
    for object in room.objects.iter() {
        assert!(object.parts.iter().all(|p| p.material < room.materials.len()), "{}", object.name);
    }
    for item in evolution.world().items() {
        let object = room.object(item.id).expect("in the room");
        let apart = object.world_bounds().center().distance(item.bounds.center());
        assert!(
            apart < 0.15 && object.world_bounds().min.y - item.bounds.min.y < 1e-3,
            "{}: {apart}",
            item.name
        );
    }
    let state = super::scene_state(&evolution, "test");
    let objects = state["scene"]["object"].as_array().expect("a list");
    assert!(
        objects.len() > 20
            && objects.iter().all(|o| o["transform"]["data"].as_array().is_some_and(|d| d.len() == 16))
    );
}
