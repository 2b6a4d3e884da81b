//! Speed of the body: forward, forward and gradient; all vertices and an optimiser's subset; one body on one
//! thread and a batch of 60 over all.

use divan::{Bencher, black_box};
use glam::Vec3;
use inhabit::body::{Body, Gradients, VertexSubset, Workspace};
use inhabit::scene::BodyParams;
use rayon::prelude::*;

fn main() {
    divan::main();
}

fn params() -> BodyParams {
    let mut params = BodyParams::default();
    for (i, z) in params.pose.iter_mut().enumerate() {
        *z = (i as f32).sin();
    }
    for (i, z) in params.betas.iter_mut().enumerate() {
        *z = (i as f32).cos();
    }
    params
}

/// About the size that a fit works on: every contact vertex and an even sample of the rest.
fn subset_of_2500(body: &Body) -> VertexSubset {
    let count = body.model.template.len();
    VertexSubset::new(&body.model, (0..2500).map(|i| (i * count / 2500) as u32).collect())
}

fn forward_and_gradient(body: &Body, subset: &VertexSubset, gradient: &[Vec3], ws: &mut Workspace) {
    body.forward(&params(), subset, ws);
    black_box(body.backward(subset, &Gradients::of_vertices(gradient), ws));
}

#[divan::bench]
fn forward_full(bencher: Bencher) {
    let body = Body::bundled();
    let mut ws = Workspace::default();
    bencher.bench_local(|| body.forward(&params(), body.all_vertices(), &mut ws));
}

#[divan::bench]
fn forward_gradient_full(bencher: Bencher) {
    let body = Body::bundled();
    let gradient = vec![Vec3::new(0.1, 0.2, 0.3); body.all_vertices().len()];
    let mut ws = Workspace::default();
    bencher.bench_local(|| forward_and_gradient(body, body.all_vertices(), &gradient, &mut ws));
}

#[divan::bench]
fn forward_subset(bencher: Bencher) {
    let body = Body::bundled();
    let subset = subset_of_2500(body);
    let mut ws = Workspace::default();
    bencher.bench_local(|| body.forward(&params(), &subset, &mut ws));
}

#[divan::bench]
fn forward_gradient_subset(bencher: Bencher) {
    let body = Body::bundled();
    let subset = subset_of_2500(body);
    let gradient = vec![Vec3::new(0.1, 0.2, 0.3); subset.len()];
    let mut ws = Workspace::default();
    bencher.bench_local(|| forward_and_gradient(body, &subset, &gradient, &mut ws));
}

#[divan::bench]
fn joints_alone(bencher: Bencher) {
    let body = Body::bundled();
    let mut ws = Workspace::default();
    bencher.bench_local(|| body.forward_joints(&params(), &mut ws));
}

#[divan::bench]
fn forward_gradient_full_60_over_threads(bencher: Bencher) {
    let body = Body::bundled();
    let gradient = vec![Vec3::new(0.1, 0.2, 0.3); body.all_vertices().len()];
    let mut workspaces = vec![Workspace::default(); 60];
    bencher.bench_local(|| {
        workspaces
            .par_iter_mut()
            .for_each(|ws| forward_and_gradient(body, body.all_vertices(), &gradient, ws));
    });
}
