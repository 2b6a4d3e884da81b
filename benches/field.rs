//! Field baking and ray casts on a furnished room of about 100,000 triangles, with one and two threads.
//!
//! `cargo bench --bench field`. For a comparison with another program on the same room and grid,
//! `FIELD_ROOM_OUT=room.stl cargo bench --bench field` writes the room first.

use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::{Affine3A, Vec3};
use inhabit::assets::{Material, Mesh, Model, Part};
use inhabit::math::Aabb;
use inhabit::scene::{FieldConfig, GeometryConfig, ImportOptions, Resolution, RoomGeometry};
use inhabit::scene::{SignedDistanceField, Step, TriangleBvh, bake, understand};

#[path = "../src/scene/field/test_room.rs"]
mod test_room;

const TRIANGLES: usize = 100_000;
/// Rays of one measurement.
const RAYS: usize = 200_000;
/// Samples of one measurement: the vertices of a body.
const SAMPLES: usize = 10_000;

fn main() {
    if let Some(path) = std::env::var_os("FIELD_ROOM_OUT") {
        std::fs::write(path, stl(&test_room::triangles(TRIANGLES))).expect("the room's file is writable");
    }
    if std::env::var_os("CANCEL").is_some() {
        cancel_latency();
        return;
    }
    accuracy();
    divan::main();
}

/// How long the work on a room of a million triangles goes on after it was told to stop, at 24 moments of
/// each stage: `CANCEL=1 cargo bench --bench field`.
fn cancel_latency() {
    let triangles = test_room::triangles(1_000_000);
    let config = GeometryConfig::default();
    let model = model(&triangles);
    latency("understanding the file", &|step| understand(&model, &ImportOptions::default(), step).is_ok());
    latency("distance field", &|step| bake(&triangles, &config.field, step).is_ok());
    let field = bake(&triangles, &config.field, &go_on).expect("not stopped");
    latency("tree, surfaces, floor", &|step| {
        RoomGeometry::from_field(triangles.clone(), Vec::new(), field.clone(), &config, step).is_ok()
    });
}

fn latency(name: &str, work: &dyn Fn(Step) -> bool) {
    let begun = Instant::now();
    assert!(work(&go_on));
    let whole = begun.elapsed();
    let mut worst = (Duration::ZERO, Duration::ZERO);
    for moment in 1..=24_u32 {
        let (begun, until) = (Instant::now(), whole * moment / 25);
        let stop = |_, _| if begun.elapsed() < until { go_on(0, 0) } else { ControlFlow::Break(()) };
        if work(&stop) {
            continue;
        }
        let late = begun.elapsed().saturating_sub(until);
        worst = worst.max((late, until));
    }
    println!("{name}: {whole:.1?} in all; worst {:.0?} after a cancel at {:.1?}", worst.0, worst.1);
}

/// A model of one mesh without names, as a scan is.
fn model(triangles: &[[Vec3; 3]]) -> Model {
    let positions = triangles.iter().flatten().copied().collect();
    let corners = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let mesh = Mesh { positions, triangles: corners, ..Mesh::default() };
    let part = Part {
        name: String::new(),
        node: 0,
        path: Vec::new(),
        mesh: Arc::new(mesh),
        material: 0,
        file_from_mesh: Affine3A::IDENTITY,
        extras: None,
    };
    let (parts, materials) = (vec![part], vec![Material::default()]);
    Model { name: "room.ply".to_owned(), parts, materials, ..Model::default() }
}

fn go_on(_: usize, _: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The grid of n³ samples over the room's shell and 20 cm around it.
fn config(n: usize) -> FieldConfig {
    let bounds = Aabb { min: test_room::LOW, max: test_room::HIGH }.grown(0.35);
    FieldConfig { resolution: Resolution::Exactly { dim: [n; 3], bounds }, ..FieldConfig::default() }
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool")
}

fn field_128() -> &'static SignedDistanceField {
    static FIELD: OnceLock<SignedDistanceField> = OnceLock::new();
    FIELD.get_or_init(|| bake(&test_room::triangles(TRIANGLES), &config(128), &go_on).expect("not stopped"))
}

/// Prints how well the 128³ field agrees with the exact one: sign where |d| > 2 cm, distance within 5 cm.
fn accuracy() {
    let field = field_128();
    let inside = Aabb { min: test_room::LOW, max: test_room::HIGH };
    let (mut counted, mut agree, mut worst_m) = (0_usize, 0_usize, 0.0_f32);
    for x in 0..field.dim[0] {
        for (y, z) in (0..field.dim[1]).flat_map(|y| (0..field.dim[2]).map(move |z| (y, z))) {
            let p = field.position(x, y, z);
            if !inside.contains(p) {
                continue;
            }
            let (exact, found) = (test_room::exact_distance(p), field.at(x, y, z));
            if exact.abs() > 0.02 {
                counted += 1;
                agree += usize::from((exact > 0.0) == (found > 0.0));
            }
            if (0.0..=0.05).contains(&exact) {
                worst_m = worst_m.max((exact - found).abs());
            }
        }
    }
    let share = 100.0 * agree as f64 / counted as f64;
    println!("128³: {share:.4} % of signs agree; worst error within 5 cm {:.4} mm", worst_m * 1e3);
}

#[divan::bench(args = [(128, 1), (128, 2), (256, 1), (256, 2)], sample_count = 3, sample_size = 1)]
fn bake_field(bencher: Bencher, (n, threads): (usize, usize)) {
    let (triangles, pool, config) = (test_room::triangles(TRIANGLES), pool(threads), config(n));
    bencher.bench_local(|| pool.install(|| bake(black_box(&triangles), &config, &go_on)));
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn build_tree(bencher: Bencher) {
    let triangles = test_room::triangles(TRIANGLES);
    bencher.with_inputs(|| triangles.clone()).bench_local_values(TriangleBvh::new);
}

fn rays() -> Vec<(Vec3, Vec3)> {
    // A low-discrepancy walk through the room's air and directions (golden ratio sequences).
    let unit = |i: usize, step: f64| ((i as f64 * step) % 1.0) as f32;
    (0..RAYS)
        .map(|i| {
            let at = Vec3::new(unit(i, 0.819_172_5), unit(i, 0.671_043_6), unit(i, 0.549_700_4));
            let origin = test_room::LOW + at * (test_room::HIGH - test_room::LOW);
            let (up, turn) = (2.0 * unit(i, 0.754_877_6) - 1.0, std::f32::consts::TAU * unit(i, 0.569_840_3));
            let flat = (1.0 - up * up).max(0.0).sqrt();
            (origin, Vec3::new(flat * turn.cos(), up, flat * turn.sin()))
        })
        .collect()
}

#[divan::bench(args = [1, 2], sample_count = 5, sample_size = 1)]
fn cast_rays(bencher: Bencher, threads: usize) {
    use rayon::prelude::*;
    let (bvh, rays, pool) = (TriangleBvh::new(test_room::triangles(TRIANGLES)), rays(), pool(threads));
    bencher.counter(ItemsCount::new(RAYS)).bench_local(|| {
        pool.install(|| {
            rays.par_iter().filter(|(from, along)| bvh.cast(*from, *along, 100.0).is_some()).count()
        })
    });
}

#[divan::bench(sample_count = 20)]
fn sample_gradient(bencher: Bencher) {
    let (field, points) = (field_128(), rays());
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        points[..SAMPLES].iter().map(|(p, _)| field.sample_gradient(black_box(*p)).1).sum::<Vec3>()
    });
}

/// A binary STL file of the triangles.
fn stl(triangles: &[[Vec3; 3]]) -> Vec<u8> {
    let mut bytes = vec![0_u8; 80];
    bytes.extend_from_slice(&(triangles.len() as u32).to_le_bytes());
    for [a, b, c] in triangles {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for number in [normal, *a, *b, *c].iter().flat_map(|p| p.to_array()) {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        bytes.extend_from_slice(&[0, 0]);
    }
    bytes
}
