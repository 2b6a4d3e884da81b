//! What a user relies on: gradients are exact, bodies come to rest on seats and floors, nothing sinks in.

use glam::Vec3;

use super::*;
use crate::body::{Body, Region};
use crate::job::{Seed, Ticker};
use crate::scene::{BodyParams, PARAMS, PoseFamily, SignedDistanceField};

/// A floor at 0 and a seat block 45 cm high whose front edge lies at z = 0.
fn field() -> SignedDistanceField {
    let dim = [61, 61, 61];
    let (origin, cell_m) = (Vec3::new(-1.5, -0.5, -1.5), Vec3::splat(0.05));
    let mut field = SignedDistanceField { dim, origin, cell_m, values: vec![0.0; dim.iter().product()] };
    for x in 0..dim[0] {
        for y in 0..dim[1] {
            for z in 0..dim[2] {
                let p = field.position(x, y, z);
                let beyond = (p - Vec3::new(0.0, 0.225, -0.4)).abs() - Vec3::new(0.6, 0.225, 0.4);
                let seat = beyond.max(Vec3::ZERO).length() + beyond.max_element().min(0.0);
                field.values[(x * dim[1] + y) * dim[2] + z] = p.y.min(seat);
            }
        }
    }
    field
}

fn random_body(seed: u64, translation: Vec3) -> BodyParams {
    use rand::RngExt as _;
    let mut rng = Seed::root(seed).rng();
    let mut x = BodyParams { translation, ..BodyParams::default() }.to_vector();
    for value in &mut x[3..] {
        *value += rng.random_range(-0.3..0.3);
    }
    BodyParams::from_vector(&x)
}

fn agrees_with_differences(config: &FitConfig, height_m: f32, tolerance: f32) {
    let (field, body) = (field(), Body::bundled());
    let around = Surroundings::of_field(&field);
    let fitter = Fitter::new(body);
    let start = random_body(1, Vec3::new(0.05, height_m - 0.03, -0.2));
    let at = random_body(2, Vec3::new(0.03, height_m, -0.22));
    let value = |x: &[f32; PARAMS]| -> f64 {
        let params = BodyParams::from_vector(x);
        let (terms, _) = fitter.evaluate(&around, &params, &start, PoseFamily::Stand, &config.objective);
        terms.iter().map(|t| f64::from(*t)).sum()
    };
    let (_, gradient) = fitter.evaluate(&around, &at, &start, PoseFamily::Stand, &config.objective);
    let norm = gradient.iter().map(|g| g * g).sum::<f32>().sqrt();
    let x = at.to_vector();
    let step = 1e-3;
    for i in 0..PARAMS {
        let (mut up, mut down) = (x, x);
        up[i] += step;
        down[i] -= step;
        let numeric = ((value(&up) - value(&down)) / f64::from(2.0 * step)) as f32;
        let error = (numeric - gradient[i]).abs();
        assert!(error < tolerance * norm, "number {i}: {} against {numeric} (norm {norm})", gradient[i]);
    }
}

#[test]
fn the_gradient_of_our_energy_agrees_with_finite_differences() {
    // The field's slope jumps from cell to cell, and some of the skin crosses a border within the step.
    agrees_with_differences(&FitPreset::Rescue.into(), 0.75, 0.03);
}

#[test]
fn the_gradient_of_psis_energy_agrees_with_finite_differences() {
    // Its mean over the penetrating vertices jumps when one leaves, so the body is wholly out or wholly in.
    agrees_with_differences(&FitPreset::PsiMatterport.into(), 1.5, 0.02);
    agrees_with_differences(&FitPreset::PsiMatterport.into(), -1.5, 0.02);
}

#[test]
fn a_body_that_hovers_or_is_sunk_comes_to_rest_on_the_floor() {
    let (field, body) = (field(), Body::bundled());
    let around = Surroundings::of_field(&field);
    let fitter = Fitter::new(body);
    let soles = body.model.template.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
    for wrong_m in [-0.08, 0.08] {
        let start = BodyParams { translation: Vec3::new(0.0, wrong_m - soles, 0.8), ..BodyParams::default() };
        let fitted = fitter
            .fit(&around, &start, PoseFamily::Stand, &FitConfig::default(), &Ticker::silent(), &mut |_| ())
            .expect("not cancelled");
        let lowest = body.pose(&fitted.params).vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
        assert!(lowest.abs() < 0.01, "{wrong_m} m off: soles at {lowest}");
        let (first, last) = (fitted.trace[0], fitted.trace[fitted.trace.len() - 1]);
        assert!(last.iter().sum::<f32>() < first.iter().sum::<f32>());
    }
}

#[test]
fn a_fit_repeats_bit_for_bit_and_leaks_nothing_from_the_body_before() {
    let (field, body) = (field(), Body::bundled());
    let around = Surroundings::of_field(&field);
    let config = FitConfig { iterations: 15, ..FitConfig::default() };
    let fit = |fitter: &Fitter<'_>, seed| {
        let start = random_body(seed, Vec3::new(0.0, 0.8, 0.3));
        fitter
            .fit(&around, &start, PoseFamily::SitEdge, &config, &Ticker::silent(), &mut |_| ())
            .expect("fit")
    };
    let (used, fresh) = (Fitter::new(body), Fitter::new(body));
    fit(&used, 7);
    assert_eq!(fit(&used, 8), fit(&fresh, 8));
}

#[test]
fn a_cancelled_fit_stops_and_previews_show_the_body_on_its_way() {
    let (field, ticker) = (field(), Ticker::silent());
    let around = Surroundings::of_field(&field);
    let fitter = Fitter::new(Body::bundled());
    let config = FitConfig { preview_every: 2, ..FitConfig::default() };
    let start = random_body(3, Vec3::new(0.0, 0.9, 0.3));
    let mut previews = Vec::new();
    let result = fitter.fit(&around, &start, PoseFamily::Stand, &config, &ticker, &mut |body| {
        previews.push(body.clone());
        if previews.len() == 3 {
            ticker.cancel();
        }
    });
    assert!(result.is_err());
    assert_eq!(previews.len(), 3);
    assert_ne!(previews[0], previews[2]);
}

#[test]
fn a_sheet_too_thin_for_the_field_is_pushed_out_of_the_body() {
    let (field, body) = (field(), Body::bundled());
    let fitter = Fitter::new(body);
    let mut start = BodyParams { translation: Vec3::new(0.0, 1.0, 0.8), ..BodyParams::default() };
    let lowest = body.pose(&start).vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
    start.translation.y -= lowest;
    // A small vertical sheet 3 cm inside the foremost point of chest and belly.
    let posed = body.pose(&start).vertices;
    let torso = body.regions.vertices(Region::Front).iter().map(|v| posed[*v as usize]);
    let foremost = torso.max_by(|a, b| a.z.total_cmp(&b.z)).expect("a body has a front");
    let steps = || (-4i8..=4).map(|i| 0.02 * f32::from(i));
    let patch = steps().flat_map(|x| steps().map(move |y| Vec3::new(x, y, -0.03)));
    let surface: Vec<Vec3> = patch.map(|offset| foremost + offset).collect();
    let deepest = |params: &BodyParams| {
        let solid = crate::inspect::BodySolid::new(&body.pose(params).vertices, &body.model.faces);
        surface.iter().map(|p| solid.depth(*p)).fold(0.0, f32::max)
    };
    let around = Surroundings { field: &field, surface: surface.clone() };
    let fitted = fitter
        .fit(&around, &start, PoseFamily::Stand, &FitConfig::default(), &Ticker::silent(), &mut |_| ())
        .expect("not cancelled");
    assert!(deepest(&start) > 0.02);
    assert!(deepest(&fitted.params) < 0.01, "{} m deep", deepest(&fitted.params));
}
