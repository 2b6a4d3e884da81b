//! What a user relies on: exact gradients; a person seen with noise is found where they are; the same twice.

use glam::{Affine3A, Mat3, Vec2, Vec3};

use super::*;
use crate::assets::{Keypoint, KeypointSet, PersonKeypoints};
use crate::body::{Body, FamilyHints, Workspace, sample_pose};
use crate::job::{Seed, Ticker};
use crate::scene::{BodyParams, PARAMS, POSE, PoseFamily, SignedDistanceField};

/// From 3.2 m in front of the origin, 1.5 m high, looking slightly down.
fn view() -> Pinhole {
    let forward = Vec3::new(0.05, -0.2, -1.0).normalize_or(Vec3::NEG_Z);
    let right = forward.cross(Vec3::Y).normalize_or(Vec3::X);
    let world_from_camera = Affine3A::from_mat3_translation(
        Mat3::from_cols(right, forward.cross(right), forward),
        Vec3::new(0.1, 1.5, 3.2),
    );
    Pinhole {
        camera_from_world: world_from_camera.inverse(),
        focal_px: 900.0,
        center_px: Vec2::new(640.0, 360.0),
        longest_px: 1280.0,
    }
}

/// A floor at 0.
fn floor() -> SignedDistanceField {
    let dim = [41, 41, 41];
    let (origin, cell_m) = (Vec3::new(-2.0, -1.0, -2.0), Vec3::splat(0.1));
    let mut field = SignedDistanceField { dim, origin, cell_m, values: vec![0.0; dim.iter().product()] };
    for x in 0..dim[0] {
        for y in 0..dim[1] {
            for z in 0..dim[2] {
                field.values[(x * dim[1] + y) * dim[2] + z] = field.position(x, y, z).y;
            }
        }
    }
    field
}

fn person(family: PoseFamily, seed: u64, yaw: f32) -> BodyParams {
    let body = Body::bundled();
    let mut rng = Seed::root(seed).rng();
    let drawn = sample_pose(&body.model.joint_template, family, &mut rng, &FamilyHints::default());
    let mut params = drawn.params(body, [0.0; 10], &Mat3::from_rotation_y(yaw));
    let lowest = body.pose(&params).vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
    params.translation.y -= lowest;
    params
}

fn seen(params: &BodyParams, set: KeypointSet, view: &Pinhole) -> PersonKeypoints {
    let body = Body::bundled();
    let landmarks = Landmarks::of(&body.model);
    let mut workspace = Workspace::default();
    body.forward(params, &landmarks.subset, &mut workspace);
    let points = Landmarks::positions(set, &workspace)
        .into_iter()
        .map(|p| Keypoint { pixel: view.project(p), confidence: 1.0 })
        .collect();
    PersonKeypoints { set, points }
}

fn mean_joint_error_m(a: &BodyParams, b: &BodyParams) -> f32 {
    let body = Body::bundled();
    let (a, b) = (body.pose(a).joints, body.pose(b).joints);
    (0..22).map(|j| a[j].distance(b[j])).sum::<f32>() / 22.0
}

#[test]
fn a_pixel_survives_unprojecting_and_projecting() {
    let view = view();
    let p = Vec3::new(0.3, 0.8, -0.4);
    assert!(view.unproject(view.project(p), view.depth_m(p)).distance(p) < 1e-4);
}

#[test]
fn the_gradient_of_every_estimator_agrees_with_finite_differences() {
    let (body, field, view) = (Body::bundled(), floor(), view());
    let estimator = Estimator::new(body);
    let points = seen(&person(PoseFamily::Stand, 1, 0.3), KeypointSet::Body25, &view);
    let mut at = person(PoseFamily::Stand, 2, 0.4);
    // Soles 3 cm in the air.
    at.translation += Vec3::new(0.05, 0.03, 0.02);
    let x = at.to_vector();
    // A vertex that turns to face the floor during a step makes the mean over facing vertices jump.
    for (config, tolerance) in
        [(EstimateConfig::smplify_x(), 0.01), (EstimateConfig::scene_aware([0.2; POSE]), 0.06)]
    {
        let value = |x: &[f32; PARAMS]| f64::from(estimator.evaluate(&view, &points, &field, &config, x).0);
        let (_, gradient) = estimator.evaluate(&view, &points, &field, &config, &x);
        let norm = gradient.iter().map(|g| g * g).sum::<f32>().sqrt();
        for i in 0..PARAMS {
            let h = 2e-3;
            let side = |step: f32| {
                let mut moved = x;
                moved[i] += step;
                value(&moved)
            };
            let numeric = ((side(h) - side(-h)) / f64::from(2.0 * h)) as f32;
            let error = (numeric - gradient[i]).abs();
            assert!(error < tolerance * norm, "number {i}: {} against {numeric} (norm {norm})", gradient[i]);
        }
    }
}

#[test]
fn people_seen_from_the_front_and_from_behind_are_found_where_they_are() {
    let (field, view) = (floor(), view());
    let estimator = Estimator::new(Body::bundled());
    for (family, set, yaw) in [
        (PoseFamily::Stand, KeypointSet::Body25, 0.3),
        (PoseFamily::Stand, KeypointSet::Coco17, 2.8),
        (PoseFamily::SitChair, KeypointSet::Body25, -1.0),
    ] {
        let truth = person(family, 5, yaw);
        let points = seen(&truth, set, &view);
        let estimate = |config: &EstimateConfig| {
            estimator
                .estimate(&view, &points, &field, config, &Ticker::silent(), &mut |_| ())
                .expect("enough points")
                .expect("not cancelled")
        };
        let found = estimate(&EstimateConfig::smplify_x());
        let error_m = mean_joint_error_m(&found.params, &truth);
        assert!(found.reprojection_px < 6.0, "{}: {} px", family.label(), found.reprojection_px);
        assert!(error_m < 0.2, "{}: {error_m} m", family.label());
        let told = estimate(&EstimateConfig { prior_center: truth.pose, ..EstimateConfig::smplify_x() });
        let told_m = mean_joint_error_m(&told.params, &truth);
        assert!(told_m < 0.06, "{}: {told_m} m with the prior at the truth", family.label());
        assert_eq!(estimate(&EstimateConfig::smplify_x()), found, "the same twice");
    }
}

#[test]
fn too_few_keypoints_and_a_cancel_are_told_apart() {
    let (field, view) = (floor(), view());
    let estimator = Estimator::new(Body::bundled());
    let mut points = seen(&person(PoseFamily::Stand, 1, 0.0), KeypointSet::Coco17, &view);
    let ticker = Ticker::silent();
    ticker.cancel();
    let config = EstimateConfig::smplify_x();
    let cancelled = estimator.estimate(&view, &points, &field, &config, &ticker, &mut |_| ());
    assert!(matches!(cancelled, Ok(Err(crate::job::Cancelled))));
    points.points.iter_mut().skip(3).for_each(|p| p.confidence = 0.0);
    let refused = estimator.estimate(&view, &points, &field, &config, &ticker, &mut |_| ());
    assert_eq!(refused.expect_err("too few"), EstimateError::TooFewPoints { found: 3 });
}
