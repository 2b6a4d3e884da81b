use burn::tensor::Tensor;

use super::*;
use crate::assets::{Precision, Weights};
use crate::nn::{Graph, Mode, Params, cpu_device, numbers, tensor};

/// A picture of a floor with a box, different for each `kind`.
fn scene(kind: usize) -> SceneInput {
    let inside = |i: usize| (i / IMAGE) > 60 && (i % IMAGE) / 32 == kind % 4;
    SceneInput {
        depth_m: (0..IMAGE * IMAGE).map(|i| if inside(i) { 2.0 } else { 3.5 }).collect(),
        labels: (0..IMAGE * IMAGE).map(|i| if inside(i) { 3 } else { 2 }).collect(),
        valid: ValidArea { left: 0, top: 0, width: IMAGE, height: 100 },
        max_depth_m: 3.5,
        focal: 1.5,
    }
}

fn sampler(method: PsiMethod) -> PsiSampler {
    let (network, params) = PsiNetwork::declare(&PsiConfig::mini(method), 5);
    PsiSampler::new(network, &params)
}

fn codes(count: usize, noise: usize) -> Vec<f32> {
    (0..count * noise).map(|i| ((i * 7919) as f32 * 0.37).sin() * 1.3).collect()
}

#[test]
fn the_published_networks_have_the_published_sizes() {
    let count = |method| PsiNetwork::declare(&PsiConfig::published(method), 0).1.trained_count();
    assert_eq!(count(PsiMethod::S1), 5_014_699, "5.01 M");
    assert_eq!(count(PsiMethod::S2), 15_705_067, "15.7 M");
}

#[test]
fn compact_networks_are_small_enough_to_ship() {
    for method in PsiMethod::ALL {
        let count = PsiNetwork::declare(&PsiConfig::compact(method), 0).1.trained_count();
        assert!(count < 2_000_000, "{method:?}: {count} numbers, two bytes each");
    }
}

#[test]
fn every_network_samples_bodies_that_depend_on_the_code_and_on_the_scene() {
    for method in PsiMethod::ALL {
        let sampler = sampler(method);
        let codes = codes(3, sampler.config().noise());
        let (here, there) = (sampler.decode(&scene(0), &codes), sampler.decode(&scene(2), &codes));
        assert_eq!(here.len(), 3);
        assert!(here.iter().flatten().all(|x| x.is_finite()), "{method:?}");
        assert_ne!(here[0], here[1], "{method:?}: another code, the same body");
        assert_ne!(here[0], there[0], "{method:?}: another scene, the same body");
        assert_eq!(here, sampler.decode(&scene(0), &codes), "{method:?}: not repeatable");
    }
}

#[test]
fn weights_survive_a_round_trip_and_another_network_is_refused() {
    let (network, params) = PsiNetwork::declare(&PsiConfig::mini(PsiMethod::S2), 5);
    let mut file = Weights::new("s2");
    network.store(&params, &mut file);
    let read = Weights::from_bytes("s2", &file.to_bytes(Precision::Half).expect("bytes")).expect("file");
    let (again, loaded) = PsiNetwork::from_weights(&read).expect("network");
    assert_eq!(again.config(), network.config());
    assert_eq!(loaded, params.rounded(Precision::Half));
    let mut other = PsiNetwork::declare(&PsiConfig::mini(PsiMethod::S1), 5).1;
    assert!(other.load(&read).is_err());
}

#[test]
fn a_network_that_is_given_the_picture_alone_samples_too() {
    let published = PsiConfig::published(PsiMethod::S1);
    let mini = PsiConfig::mini(PsiMethod::S1);
    let config =
        PsiConfig { camera_scale: false, floor_plane: false, semantics: published.semantics, ..mini };
    let (network, params) = PsiNetwork::declare(&config, 3);
    let sampler = PsiSampler::new(network, &params);
    let made = sampler.decode(&scene(0), &vec![0.1; 2 * config.noise()]);
    assert!(made.len() == 2 && made.iter().flatten().all(|x| x.is_finite()));
}

#[test]
fn the_framework_s_gradients_agree_with_finite_differences() {
    for method in PsiMethod::ALL {
        let (network, params) = PsiNetwork::declare(&PsiConfig::mini(method), 9);
        let device = cpu_device();
        let loss = |params: &Params, mode: Mode| {
            let g = Graph::new(params, mode, &device);
            let (a, b) = (scene(0), scene(1));
            let scenes = SceneTensors::new(network.config(), &[&a, &b], g.device());
            let bodies = tensor(codes(2, BODY), [2, BODY], g.device());
            let noise = network.config().noise();
            let features = network.encode_scene(&g, &scenes);
            let made =
                network.reconstruct(&g, &features, bodies, tensor(codes(2, noise), [2, noise], g.device()));
            let divergence = made.posteriors.iter().map(Posterior::divergence).reduce(|a, b| a + b);
            (made.body.square().mean() + divergence.expect("a stage"), g)
        };
        let (value, g) = loss(&params, Mode::Train);
        let gradients = g.gradients(&mut value.backward());
        let name = ["posterior.mean.weight", "local.posterior.mean.weight", "what.posterior.mean.weight"]
            [method as usize];
        let at = params.entries().iter().position(|e| e.name == name).expect("an array");
        for k in [0, 17] {
            let moved = |by: f32| {
                let mut params = params.clone();
                params.entries_mut()[at].values[k] += by;
                let value: Tensor<1> = loss(&params, Mode::Train).0;
                numbers(&value)[0]
            };
            let numeric = (moved(2e-2) - moved(-2e-2)) / 4e-2;
            let analytic = gradients[at][k];
            assert!(
                (analytic - numeric).abs() < 2e-4 + 0.03 * numeric.abs(),
                "{method:?}: {analytic} {numeric}"
            );
        }
    }
}
