use glam::{Affine3A, Mat3, Vec3};
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};

use super::adversary::Projector;
use super::data::{Augment, Picture};
use super::loss::{self, Target};
use super::*;
use crate::assets::Weights;
use crate::body::joints::{LEFT_WRIST, PELVIS, RIGHT_WRIST};
use crate::body::{Body, FamilyHints, Workspace, sample_pose};
use crate::generate::sensor::{Intrinsics, SIDE, Valid, View};
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::corpus::{CorpusView, ViewKind};
use crate::nn::psi::{BODY, PsiConfig, PsiMethod, PsiSampler, SceneInput};
use crate::nn::{cpu_device, numbers, tensor};
use crate::scene::{BodyParams, PARAMS, PoseFamily, SignedDistanceField};

/// A floor at y = 0 with all below it solid.
fn floor() -> SignedDistanceField {
    let dim = [9, 9, 9];
    let values = (0..9 * 9 * 9).map(|i| (i / 9 % 9) as f32 * 0.5 - 0.5).collect();
    SignedDistanceField { dim, origin: Vec3::new(-2.0, -0.5, -2.0), cell_m: Vec3::splat(0.5), values }
}

/// People who stand and sit about, each seen by one camera, the pictures made up but different.
fn corpus(people: usize) -> PsiData {
    let mut data = PsiData { id: "made up".to_owned(), ..PsiData::default() };
    for person in 0..people {
        let mut rng = Seed::root(7).child("person", person as u64).rng();
        let family = [PoseFamily::Stand, PoseFamily::SitChair][person % 2];
        let pose =
            sample_pose(&Body::bundled().model.joint_template, family, &mut rng, &FamilyHints::default())
                .pose;
        let at = Vec3::new(rng.random_range(-0.8..0.8), 0.9, rng.random_range(-0.8..0.8));
        let mut params = BodyParams { translation: at, ..BodyParams::default() };
        params.set_rotation(&Mat3::from_rotation_y(rng.random_range(0.0..6.0)));
        let (view, valid) = Valid::of(&View::look_at(Vec3::new(1.5, 2.0, 2.5), at, Intrinsics::PROX_E));
        let stripe = 12 + person % 8 * 14;
        let depth = |p: usize| if (p % SIDE).abs_diff(stripe) < 10 { 2500 } else { 5000 };
        data.views.push(CorpusView {
            kind: ViewKind::Virtual,
            body: person,
            view,
            valid,
            depth_mm: (0..SIDE * SIDE).map(depth).collect(),
            labels: (0..SIDE * SIDE).map(|p| 1 + (p / SIDE / 40) as u8).collect(),
        });
        data.train.push(PsiBody::new(0, params, &pose, vec![person]));
    }
    data.validation = data.train[..2].to_vec();
    assert_eq!(data.drop_unseen(), 0);
    data
}

fn settings(method: PsiMethod, epochs: usize) -> PsiTraining {
    let mut training = PsiTraining {
        network: PsiConfig::mini(method),
        epochs,
        batch: 4,
        learning_rate: 3e-3,
        mirror: false,
        turn_deg: [0.0; 2],
        depth_noise: 0.0,
        ..PsiTraining::paper(method)
    };
    training.weights.kl = 1e-3;
    training
}

fn run(training: &PsiTraining, data: &PsiData, stop_after: usize) -> (TrainingState, Vec<Vec<u8>>) {
    let mut state = TrainingState::new(training.clone(), data.id.clone());
    let checkpoints = go_on(&mut state, data, stop_after);
    (state, checkpoints)
}

fn go_on(state: &mut TrainingState, data: &PsiData, stop_after: usize) -> Vec<Vec<u8>> {
    let fields = [floor()];
    let mut checkpoints = Vec::new();
    let mut keep = |state: &TrainingState| {
        checkpoints.push(state.checkpoint()?);
        if state.epoch >= stop_after { Err(Stop::Cancelled) } else { Ok(()) }
    };
    let input = TrainingInput { data, fields: &fields };
    let ended = train(state, &input, &JobCtx::headless(Seed::root(0)), &mut keep);
    assert!(matches!(ended, Ok(()) | Err(Stop::Cancelled)), "{ended:?}");
    checkpoints
}

#[test]
fn every_network_learns_four_bodies_by_heart() {
    let data = corpus(4);
    for (method, epochs) in [(PsiMethod::S1, 120), (PsiMethod::S2, 160), (PsiMethod::Baseline, 160)] {
        let (state, _) = run(&settings(method, epochs), &data, usize::MAX);
        let rows = &state.history.rows;
        let (first, last) = (rows[0].reconstruction, rows[rows.len() - 1].reconstruction);
        assert!(last < 0.25 * first && last < 0.2, "{method:?}: {first} to {last}");
        assert_eq!(rows.len(), epochs);
    }
}

#[test]
fn a_resumed_training_ends_with_the_same_bytes() {
    let data = corpus(6);
    for method in PsiMethod::ALL {
        let training = settings(method, 4);
        let (whole, checkpoints) = run(&training, &data, usize::MAX);
        let read = Weights::from_bytes("checkpoint", &checkpoints[1]).expect("checkpoint");
        let mut again = TrainingState::resume(training.clone(), data.id.clone(), &read).expect("resumed");
        assert_eq!(again.epoch, 2);
        let rest = go_on(&mut again, &data, usize::MAX);
        assert_eq!(rest, checkpoints[2..], "{method:?}");
        assert_eq!(again.weights().expect("bytes"), whole.weights().expect("bytes"), "{method:?}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let data = corpus(6);
    let training = PsiTraining {
        scene_loss: true,
        drawn: Some(DrawnWeights::default()),
        mirror: true,
        turn_deg: [15.0, 8.0],
        depth_noise: 0.01,
        ..settings(PsiMethod::S1, 3)
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| run(&training, &data, usize::MAX).0.weights().expect("bytes"))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn the_scene_loss_branches_off_late_and_a_foreign_checkpoint_is_refused() {
    let data = corpus(4);
    let plain = settings(PsiMethod::S1, 4);
    let with = PsiTraining { scene_loss: true, ..plain.clone() };
    let (_, checkpoints) = run(&plain, &data, usize::MAX);
    let read = |at: usize| Weights::from_bytes("c", &checkpoints[at]).expect("checkpoint");
    let mut branch = TrainingState::resume(with.clone(), data.id.clone(), &read(2)).expect("branches");
    go_on(&mut branch, &data, usize::MAX);
    let last = branch.history.rows[3];
    assert!(last.contact > 0.0 && branch.history.rows[2].contact == 0.0, "{last:?}");
    let (whole, _) = run(&with, &data, usize::MAX);
    assert_eq!(whole.weights().expect("bytes"), branch.weights().expect("bytes"));
    let refused = |training: &PsiTraining, corpus: &str, at: usize| {
        TrainingState::resume(training.clone(), corpus.to_owned(), &read(at)).is_err()
    };
    assert!(refused(&with, &data.id, 3) && refused(&plain, "another", 1));
    assert!(refused(&PsiTraining { seed: 9, ..plain }, &data.id, 1));
}

/// How deep bodies of drawn codes are in the room on average, weighted.
fn drawn_collision(state: &TrainingState, data: &PsiData) -> f32 {
    let body = Body::bundled();
    let sampler = PsiSampler::new(state.network.clone(), &state.main.params);
    let loss = SceneLoss::new(body, 0.0, 1.0, 1.0);
    let mut rng = Seed::root(11).rng();
    let mut total = 0.0;
    for one in &data.train {
        let item = data.draw(one, Augment::NONE, Seed::root(1));
        let codes: Vec<f32> =
            (0..8 * sampler.config().noise()).map(|_| StandardNormal.sample(&mut rng)).collect();
        for made in sampler.decode(&item.scene, &codes) {
            let mut workspace = Workspace::default();
            total += loss.evaluate(body, &floor(), &item.world_from_camera, &made, &mut workspace).collision;
        }
    }
    total
}

#[test]
fn bodies_of_drawn_codes_are_kept_out_of_the_floor_when_that_is_asked_for() {
    let data = corpus(4);
    let with = PsiTraining { scene_loss: true, late: 0.25, ..settings(PsiMethod::S1, 60) };
    let drawn = PsiTraining {
        drawn: Some(DrawnWeights { contact: 0.0, collision: 3.0, ..DrawnWeights::default() }),
        ..with.clone()
    };
    let [without, kept] = [with, drawn].map(|t| drawn_collision(&run(&t, &data, usize::MAX).0, &data));
    assert!(kept < 0.5 * without, "{kept} against {without}");
}

/// A body in its picture, and a vector near it.
fn item(mirrored: bool) -> (Item, [f32; PARAMS]) {
    let data = corpus(3);
    let draws =
        (0..64).map(|s| data.draw(&data.train[1], Augment { mirror: true, ..Augment::NONE }, Seed::root(s)));
    let reflects = |i: &Item| i.world_from_camera.matrix3.determinant() < 0.0;
    let item = draws.into_iter().find(|i| reflects(i) == mirrored).expect("both kinds");
    let mut x = item.body;
    let mut rng = Seed::root(3).rng();
    x.iter_mut().for_each(|v| *v += rng.random_range(-0.15..0.15));
    (item, x)
}

#[test]
fn the_scene_loss_and_its_gradient_agree_with_finite_differences() {
    let body = Body::bundled();
    let field = floor();
    for mirrored in [false, true] {
        let (item, x) = item(mirrored);
        let scene_loss = SceneLoss::new(body, 1.0, 1.0, 1.0);
        let mut workspace = Workspace::default();
        let mut at = |x: &[f32; PARAMS]| {
            // Wholly in the ground: the published mean over the vertices in solid matter jumps when one leaves.
            let sunk = Affine3A::from_translation(Vec3::NEG_Y * 2.6) * item.world_from_camera;
            scene_loss.evaluate(body, &field, &sunk, x, &mut workspace)
        };
        let found = at(&x);
        assert!(found.contact > 0.0 && found.collision > 0.0, "{found:?}");
        for k in [0, 1, 2, 3, 6, 8, 10, 19, 25, 40, 51] {
            let mut moved = |by: f32| {
                let mut x = x;
                x[k] += by;
                let v = at(&x);
                v.contact + v.collision
            };
            let numeric = (moved(2e-3) - moved(-2e-3)) / 4e-3;
            let analytic = found.gradient[k];
            assert!((analytic - numeric).abs() < 0.01 + 0.03 * numeric.abs(), "x[{k}]: {analytic} {numeric}");
        }
    }
}

#[test]
fn a_gradient_put_into_the_graph_comes_out_at_the_network_s_output() {
    let body = Body::bundled();
    let field = floor();
    let (item, x) = item(false);
    let device = cpu_device().autodiff();
    let scenes: [&SceneInput; 1] = [&item.scene];
    let target = Target::new(&scenes, &[item.body], &device);
    let normal = crate::nn::psi::normalized(&item.scene, &x);
    let scene_loss = SceneLoss::new(body, 1.0, 0.0, 1.0);
    let mut workspace = Workspace::default();
    let mut of_metres = |metres: &[f32; BODY]| {
        scene_loss.evaluate(body, &field, &item.world_from_camera, metres, &mut workspace)
    };
    let leaf = tensor(normal.to_vec(), [1, BODY], &device).require_grad();
    let in_metres = target.in_metres(&leaf);
    let metres: [f32; BODY] = numbers(&in_metres).try_into().expect("one body");
    assert!(metres.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-4), "π⁻¹ undoes π");
    let gradient = of_metres(&metres).gradient;
    let grads = loss::with_gradient(&in_metres, gradient.to_vec()).backward();
    let analytic = numbers(&leaf.grad(&grads).expect("a gradient"));
    for k in [0, 1, 2, 5, 20] {
        let mut moved = |by: f32| {
            let mut n = normal;
            n[k] += by;
            let there = item.scene.denormalize([n[0], n[1], n[2]]);
            let mut m = n;
            m[..3].copy_from_slice(&there);
            of_metres(&m).contact
        };
        let numeric = (moved(5e-3) - moved(-5e-3)) / 1e-2;
        assert!(
            (analytic[k] - numeric).abs() < 5e-3 + 0.03 * numeric.abs(),
            "{k}: {} {numeric}",
            analytic[k]
        );
    }
}

#[test]
fn what_the_discriminator_sees_and_its_gradient_agree_with_finite_differences() {
    let body = Body::bundled();
    let projector = Projector::new(body);
    let (item, x) = item(false);
    let weights: Vec<f32> =
        (0..projector.features(body, &item.scene, &x).len()).map(|i| (i as f32 * 0.7).sin()).collect();
    let value = |x: &[f32; PARAMS]| -> f32 {
        projector.features(body, &item.scene, x).iter().zip(&weights).map(|(f, w)| f * w).sum()
    };
    let gradient = projector.pull_back(body, &item.scene, &x, &weights);
    for k in [0, 1, 4, 10, 20, 30] {
        let moved = |by: f32| {
            let mut x = x;
            x[k] += by;
            value(&x)
        };
        let numeric = (moved(1e-4) - moved(-1e-4)) / 2e-4;
        assert!(
            (gradient[k] - numeric).abs() < 0.15 + 0.05 * numeric.abs(),
            "x[{k}]: {} {numeric}",
            gradient[k]
        );
    }
}

#[test]
fn a_mirrored_picture_shows_the_same_person_from_the_mirrored_side() {
    let body = Body::bundled();
    let data = corpus(3);
    let world = body.pose(&data.train[1].params);
    let (item, _) = item(true);
    let posed = body.pose(&BodyParams::from_vector(&item.body));
    let back = |joint: usize| item.world_from_camera.transform_point3(posed.joints[joint]);
    assert!(back(PELVIS).distance(world.joints[PELVIS]) < 1e-3);
    assert!(back(LEFT_WRIST).distance(world.joints[RIGHT_WRIST]) < 0.06, "the body is nearly symmetric");
    assert!(back(RIGHT_WRIST).distance(world.joints[LEFT_WRIST]) < 0.06);
    let view = &data.views[data.train[1].views[0]];
    let (straight, mirrored) = (Picture::of(view).scene_input(false), Picture::of(view).scene_input(true));
    assert_eq!(straight.depth_m[5 * SIDE + 3], mirrored.depth_m[5 * SIDE + SIDE - 4]);
    assert_eq!(mirrored, item.scene);
}

#[test]
fn a_turned_camera_sees_a_wall_where_it_is() {
    let data = corpus(2);
    let mut view = data.views[0].clone();
    // A wall three metres ahead, straight across.
    view.depth_mm = vec![3000; SIDE * SIDE];
    let straight = Picture::of(&view);
    let turned = straight.turned(0.2, -0.1);
    for (x, y) in [(64, 64), (60, 70), (75, 58)] {
        let middle = glam::Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let there = turned.view.unproject(middle, turned.depth_m[y * SIDE + x]);
        let depth_before = straight.view.point_in_camera(there).z;
        assert!((depth_before - 3.0).abs() < 1e-3, "({x}, {y}): {depth_before} m");
    }
    let level = |v: &View| v.world_from_camera.matrix3.x_axis.y;
    assert!(level(&turned.view).abs() < 1e-5 && turned.view.eye() == straight.view.eye());
    let item = turned.item(&data.train[0], false);
    let posed = Body::bundled().pose(&BodyParams::from_vector(&item.body));
    let world = Body::bundled().pose(&data.train[0].params);
    let back = item.world_from_camera.transform_point3(posed.joints[LEFT_WRIST]);
    assert!(back.distance(world.joints[LEFT_WRIST]) < 1e-3, "the body stays where it is");
}

#[test]
fn bodies_that_no_picture_shows_are_left_out() {
    let mut data = corpus(3);
    data.views[0].depth_mm = vec![600; SIDE * SIDE];
    data.train[1].params.translation += Vec3::new(3.0, 0.0, 6.0);
    assert!(data.drop_unseen() >= 2, "behind the wall, and behind the camera");
    assert_eq!(data.train.len(), 1);
}
