use burn::tensor::Tensor;

use super::*;
use crate::assets::{Precision, Weights};
use crate::nn::{Graph, Mode, Params, cpu_device, numbers, tensor};

fn wave(count: usize, seed: usize) -> Vec<f32> {
    (0..count).map(|i| ((i * 7919 + seed * 104_729) as f32 * 0.37).sin()).collect()
}

fn cloud(count: usize, seed: usize) -> Cloud {
    wave(3 * count, seed).chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()
}

fn row(seed: usize) -> [f32; ROW] {
    let numbers = wave(ROW, seed);
    std::array::from_fn(|i| numbers[i])
}

fn sampler(config: &MotionConfig) -> MotionSampler {
    let (network, params) = MotionNetwork::declare(config, 5);
    MotionSampler::new(network, &params)
}

#[test]
fn the_published_networks_have_the_published_sizes() {
    let millions = |kind| {
        let count = MotionNetwork::declare(&MotionConfig::paper(kind), 0).1.trained_count();
        (count as f64 / 1e4).round() / 100.0
    };
    assert_eq!(millions(MotionKind::Between(Between::Route)), 0.30);
    assert_eq!(millions(MotionKind::Between(Between::Pose)), 5.32);
    assert_eq!((millions(MotionKind::SubGoal) * 10.0).round() / 10.0, 9.0);
}

#[test]
fn compact_networks_are_small_enough_to_ship() {
    for kind in MotionKind::all() {
        let count = MotionNetwork::declare(&MotionConfig::compact(kind), 0).1.trained_count();
        assert!(count < 2_600_000, "{kind:?}: {count} numbers, two bytes each");
    }
}

#[test]
fn every_network_gives_sixty_frames_of_its_columns_that_depend_on_ends_and_room() {
    for which in Between::ALL {
        let sampler = sampler(&MotionConfig::mini(MotionKind::Between(which)));
        let routes = vec![wave(BETWEEN * PLACE, 3)];
        let fill = |room: usize, end: usize| {
            let made = sampler.between(&[&cloud(32, room)], &[row(1)], &[row(end)], &routes);
            assert_eq!((made.len(), made[0].len()), (1, BETWEEN * which.outputs().len()), "{which:?}");
            made[0].clone()
        };
        let here = fill(0, 2);
        assert!(here.iter().all(|x| x.is_finite()));
        assert_ne!(here, fill(1, 2), "{which:?}: another room, the same frames");
        assert_ne!(here, fill(0, 4), "{which:?}: another end, the same frames");
        assert_eq!(here, fill(0, 2), "{which:?}: not repeatable");
    }
}

#[test]
fn a_blind_network_sees_no_room() {
    let sampler = sampler(&MotionConfig::mini(MotionKind::Between(Between::Route)).blind());
    let fill = |room| sampler.between(&[&cloud(32, room)], &[row(1)], &[row(2)], &[]);
    assert_eq!(fill(0), fill(1));
}

#[test]
fn sub_goals_depend_on_code_request_and_room() {
    let sampler = sampler(&MotionConfig::mini(MotionKind::SubGoal));
    let bodies = |room: usize, asked: usize| {
        let condition: [f32; CONDITION] = std::array::from_fn(|i| row(asked)[i]);
        sampler.bodies(&cloud(32, room), &condition, &wave(2 * 8, 9))
    };
    let here = bodies(0, 0);
    assert_eq!(here.len(), 2);
    assert_ne!(here[0], here[1], "another code");
    assert_ne!(here, bodies(1, 0), "another room");
    assert_ne!(here, bodies(0, 1), "another request");
}

#[test]
fn the_order_of_the_points_means_nothing() {
    let sampler = sampler(&MotionConfig::mini(MotionKind::Between(Between::Base)));
    let (ahead, mut back) = (cloud(32, 1), cloud(32, 1));
    back.reverse();
    let fill = |cloud: &Cloud| sampler.between(&[cloud], &[row(1)], &[row(2)], &[])[0].clone();
    for (a, b) in fill(&ahead).iter().zip(fill(&back)) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
}

#[test]
fn weights_survive_a_round_trip_and_pretrained_points_are_taken_over() {
    let (network, params) = MotionNetwork::declare(&MotionConfig::mini(MotionKind::Points), 5);
    let mut file = Weights::new("points");
    network.store(&params, &mut file);
    let read = Weights::from_bytes("points", &file.to_bytes(Precision::Half).expect("bytes")).expect("file");
    let (again, loaded) = MotionNetwork::from_weights(&read).expect("network");
    assert_eq!(again.config(), network.config());
    assert_eq!(loaded, params.rounded(Precision::Half));
    let config = MotionConfig::mini(MotionKind::Between(Between::Route));
    let (_, mut route) = MotionNetwork::declare(&config, 6);
    let before = route.clone();
    MotionNetwork::take_points(&mut route, &read).expect("points of the same sizes");
    for (was, now) in before.entries().iter().zip(route.entries()) {
        assert_eq!(was.values != now.values, now.name.starts_with(POINTS_PREFIX), "{}", now.name);
    }
    let other = MotionConfig::compact(MotionKind::Between(Between::Route));
    assert!(MotionNetwork::take_points(&mut MotionNetwork::declare(&other, 6).1, &read).is_err());
}

/// Sum of squares of what a network makes of a fixed batch.
fn loss(config: &MotionConfig, params: &Params) -> (Tensor<1>, Graph) {
    let g = Graph::new(params, Mode::Train, &cpu_device());
    let (network, _) = MotionNetwork::declare(config, 0);
    let clouds = [cloud(32, 0), cloud(32, 1)];
    let cloud = network.cloud_tensor(&clouds.iter().collect::<Vec<_>>(), g.device());
    let rows = |seed| tensor(wave(2 * ROW, seed), [2, ROW], g.device());
    let made = match config.kind {
        MotionKind::Points => network.label(&g, cloud.expect("a cloud")),
        MotionKind::SubGoal => {
            let asked = tensor(wave(2 * CONDITION, 5), [2, CONDITION], g.device());
            let noise = tensor(wave(2 * config.latent, 6), [2, config.latent], g.device());
            network.reconstruct(&g, cloud, asked, rows(1), noise).map(|made| made.bodies)
        }
        MotionKind::Between(_) => {
            let route = Some(tensor(wave(2 * BETWEEN * PLACE, 4), [2, BETWEEN * PLACE], g.device()));
            network.fill(&g, &BetweenInput { cloud, start: rows(1), end: rows(2), route })
        }
    };
    (made.expect("its own kind").square().mean(), g)
}

#[test]
fn the_framework_s_gradients_agree_with_finite_differences() {
    let cases = [
        (MotionKind::Points, "labels.0.weight"),
        (MotionKind::SubGoal, "condition.0.weight"),
        (MotionKind::Between(Between::Pose), "ends.backward.recurrent"),
        (MotionKind::Between(Between::Base), "ends.forward.input"),
    ];
    for (kind, name) in cases {
        let config = MotionConfig::mini(kind);
        let (_, params) = MotionNetwork::declare(&config, 9);
        let (value, g) = loss(&config, &params);
        let gradients = g.gradients(&mut value.backward());
        let at = params.entries().iter().position(|e| e.name == name).expect("an array");
        for k in [0, 17] {
            let moved = |by: f32| {
                let mut params = params.clone();
                params.entries_mut()[at].values[k] += by;
                numbers(&loss(&config, &params).0)[0]
            };
            let numeric = (moved(2e-2) - moved(-2e-2)) / 4e-2;
            let analytic = gradients[at][k];
            assert!(
                (analytic - numeric).abs() < 2e-4 + 0.03 * numeric.abs(),
                "{kind:?}: {analytic} {numeric}"
            );
        }
    }
}
