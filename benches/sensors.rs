//! Captures of depth and semantics in a furnished room of about 100,000 triangles, with one and two threads.
//!
//! `cargo bench --bench sensors`. With `EMBREE_PYTHON=python` (one that has numpy and open3d) the same room and
//! views are cast by Embree in the same run, by `benches/embree.py`, and the ratio is printed.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::{Affine3A, Mat4, Vec3};
use inhabit::assets::{Material, Mesh, glb_from_model};
use inhabit::generate::sensor::{AgentConfig, Intrinsics, SIDE, Sensor, View, agent_views};
use inhabit::job::Seed;
use inhabit::math::Aabb;
use inhabit::scene::{
    Category, FieldConfig, GeometryConfig, Object, ObjectId, ObjectPart, Resolution, Room, RoomGeometry,
    bake, model_from_room,
};
use rayon::prelude::*;

#[path = "../src/scene/field/test_room.rs"]
#[expect(dead_code, reason = "the field's bench uses the rest")]
mod test_room;

const TRIANGLES: usize = 100_000;
/// Views of one measurement.
const VIEWS: usize = 100;

fn main() {
    summary();
    divan::main();
}

fn room() -> &'static (Room, RoomGeometry) {
    static ROOM: OnceLock<(Room, RoomGeometry)> = OnceLock::new();
    ROOM.get_or_init(|| {
        let objects = vec![object(test_room::triangles(TRIANGLES))];
        let room = Room { objects, materials: vec![Material::default()], ..Room::default() };
        let (owner, triangles): (Vec<_>, Vec<_>) = room.world_triangles().unzip();
        let bounds = Aabb { min: test_room::LOW, max: test_room::HIGH }.grown(0.35);
        let resolution = Resolution::Exactly { dim: [96; 3], bounds };
        let config = GeometryConfig {
            field: FieldConfig { resolution, ..FieldConfig::default() },
            ..Default::default()
        };
        let go_on = |_, _| ControlFlow::Continue(());
        let field = bake(&triangles, &config.field, &go_on).expect("not stopped");
        let geometry =
            RoomGeometry::from_field(triangles, owner, field, &config, &go_on).expect("not stopped");
        (room, geometry)
    })
}

fn object(triangles: Vec<[Vec3; 3]>) -> Object {
    let mesh = Mesh {
        triangles: (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        normals: triangles
            .iter()
            .flat_map(|[a, b, c]| [(b - a).cross(c - a).normalize_or(Vec3::Y); 3])
            .collect(),
        uvs: Vec::new(),
        colors: Vec::new(),
        positions: triangles.into_iter().flatten().collect(),
    };
    Object {
        id: ObjectId(0),
        name: "room".into(),
        category: Category::Misc,
        parts: vec![ObjectPart { mesh: Arc::new(mesh), material: 0, object_from_mesh: Affine3A::IDENTITY }],
        world_from_object: Affine3A::IDENTITY,
        visible: true,
        locked: false,
    }
}

/// The agent's views of the room, each a full 128 x 128 picture.
fn views() -> &'static [View] {
    static VIEWS_OF_ROOM: OnceLock<Vec<View>> = OnceLock::new();
    VIEWS_OF_ROOM.get_or_init(|| {
        let (room, geometry) = room();
        let intrinsics = Intrinsics { width: SIDE as u32, height: SIDE as u32, focal_px: 71.0 };
        let config = AgentConfig { intrinsics, ..AgentConfig::default() };
        agent_views(&Sensor::new(room, geometry), VIEWS, &config, Seed::root(0))
    })
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool")
}

/// Captures every view; gives the number of hits and the sum of depths.
fn capture_all(sensor: &Sensor<'_>, threads: &rayon::ThreadPool) -> (usize, f64) {
    threads.install(|| {
        let one = |view: &View| {
            let capture = sensor.capture(view);
            let hits = capture.depth_m.iter().filter(|d| **d > 0.0);
            (hits.clone().count(), hits.map(|d| f64::from(*d)).sum::<f64>())
        };
        views().par_iter().map(one).reduce(|| (0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
    })
}

/// Prints captures and rays a second, best of five, and what Embree does where it is at hand.
fn summary() {
    let (room, geometry) = room();
    let sensor = Sensor::new(room, geometry);
    println!("{} triangles, {} views of {SIDE} x {SIDE}", geometry.bvh.triangles().len(), views().len());
    let embree = std::env::var_os("EMBREE_PYTHON").map(|python| embree(Path::new(&python)));
    for threads in [1, 2] {
        let pool = pool(threads);
        let seconds = |_| {
            let start = Instant::now();
            black_box(capture_all(&sensor, &pool));
            start.elapsed().as_secs_f64()
        };
        let best = (0..6).map(seconds).fold(f64::INFINITY, f64::min);
        let rays = (views().len() * SIDE * SIDE) as f64 / best;
        let (hits, depth_m) = capture_all(&sensor, &pool);
        println!(
            "{threads} thread(s): {:.0} captures/s, {:.2} M rays/s; {hits} hits, mean depth {:.4} m",
            views().len() as f64 / best,
            rays / 1e6,
            depth_m / hits as f64
        );
        if let Some(line) = embree.as_ref().and_then(|lines| lines.get(threads - 1)) {
            let number = |name: &str| line[name].as_f64().unwrap_or(f64::NAN);
            println!(
                "  Embree: {:.2} M rays/s; {} hits, mean depth {:.4} m; ratio {:.2}",
                number("rays_per_s") / 1e6,
                line["hits"],
                number("mean_depth_m"),
                rays / number("rays_per_s")
            );
        }
    }
}

/// One report a line: for one thread and for two.
fn embree(python: &Path) -> Vec<serde_json::Value> {
    let folder = std::env::temp_dir().join("inhabit-sensors-bench");
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let glb = glb_from_model(&model_from_room(&room().0)).expect("the room is sound");
    let view = |view: &View| {
        let lens = view.intrinsics;
        let world_from_camera = Mat4::from(view.world_from_camera).to_cols_array();
        serde_json::json!({ "world_from_camera": world_from_camera, "width": lens.width, "height": lens.height,
            "focal_px": lens.focal_px })
    };
    let views: Vec<serde_json::Value> = views().iter().map(view).collect();
    let file = |name: &str| -> PathBuf { folder.join(name) };
    std::fs::write(file("room.glb"), glb).expect("writable");
    std::fs::write(file("views.json"), serde_json::Value::from(views).to_string()).expect("writable");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/embree.py");
    let arguments = [script, file("room.glb"), file("views.json"), "1".into(), "2".into()];
    let output = Command::new(python).args(arguments).output().expect("EMBREE_PYTHON names a Python");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    lines.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
}

#[divan::bench(args = [1, 2], sample_count = 5, sample_size = 1)]
fn capture(bencher: Bencher, threads: usize) {
    let (room, geometry) = room();
    let (sensor, pool) = (Sensor::new(room, geometry), pool(threads));
    bencher.counter(ItemsCount::new(views().len())).bench_local(|| capture_all(&sensor, &pool));
}

#[divan::bench(args = [1, 2], sample_count = 5, sample_size = 1)]
fn rays(bencher: Bencher, threads: usize) {
    let (room, geometry) = room();
    let (sensor, pool) = (Sensor::new(room, geometry), pool(threads));
    let rays = views().len() * SIDE * SIDE;
    bencher.counter(ItemsCount::new(rays)).bench_local(|| capture_all(&sensor, &pool));
}
