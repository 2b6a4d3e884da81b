use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::Vec3;

use super::bake::{bake_kept, cache_key};
use super::test_room::{HIGH, LOW, box_triangles, exact_distance, triangles};
use super::*;
use crate::assets::cache::Cache;
use crate::scene::bvh::TriangleBvh;

fn quietly(_: usize, _: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn bake_room(cells: usize) -> SignedDistanceField {
    let bounds = Aabb { min: LOW, max: HIGH }.grown(0.35);
    let config =
        FieldConfig { resolution: Resolution::Exactly { dim: [cells; 3], bounds }, ..FieldConfig::default() };
    bake(&triangles(20_000), &config, &quietly).expect("not stopped")
}

#[test]
fn a_furnished_room_keeps_its_signs_and_distances() {
    let field = bake_room(96);
    let bvh = TriangleBvh::new(triangles(20_000));
    let (mut counted, mut wrong_sign) = (0, 0);
    for index in 0..field.values.len() {
        let grid = grid::Grid { dim: field.dim, origin: field.origin, cell_m: field.cell_m };
        let p = grid.position(grid.place(index));
        if !(Aabb { min: LOW, max: HIGH }).contains(p) {
            continue;
        }
        let exact = exact_distance(p);
        if exact.abs() > 0.02 {
            counted += 1;
            wrong_sign += usize::from((exact > 0.0) != (field.values[index] > 0.0));
        }
        if exact > 0.0 && index % 7 == 0 {
            let closest = bvh.closest(p, 10.0).expect("room").distance_m;
            let allowed = if closest <= 0.05 { 0.001 } else { 0.005 };
            assert!(
                (field.values[index] - closest).abs() <= allowed,
                "{p}: {} instead of {closest}",
                field.values[index]
            );
        }
    }
    assert!(wrong_sign as f32 <= 0.0005 * counted as f32, "{wrong_sign} of {counted} signs are wrong");
}

/// Bakes with cells of 2.5 cm, the way rooms are.
fn bake_quietly(triangles: &[[Vec3; 3]]) -> SignedDistanceField {
    bake(triangles, &FieldConfig::default(), &quietly).expect("not stopped")
}

fn quad(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> [[Vec3; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

fn flipped(triangles: &[[Vec3; 3]]) -> Vec<[Vec3; 3]> {
    triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
}

/// A room of 3 x 2.5 x 3 m whose walls are single sheets, around the origin.
fn shell() -> Vec<[Vec3; 3]> {
    box_triangles(Vec3::new(-1.5, 0.0, -1.5), Vec3::new(1.5, 2.5, 1.5), true, 0.5)
}

fn solid_box(low: [f32; 3], high: [f32; 3]) -> Vec<[Vec3; 3]> {
    box_triangles(low.into(), high.into(), false, 0.2)
}

/// A sofa body of 1 x 0.4 x 0.8 m from `bottom_m` up, without its underside.
fn bottomless_sofa(bottom_m: f32) -> Vec<[Vec3; 3]> {
    let mut sofa = solid_box([-0.5, bottom_m, -0.4], [0.5, bottom_m + 0.4, 0.4]);
    sofa.retain(|t| t.iter().any(|p| p.y > bottom_m + 1e-4));
    sofa
}

#[test]
fn normals_may_point_either_way() {
    let sofa = solid_box([-0.5, 0.0, -0.4], [0.5, 0.4, 0.4]);
    for (walls, sofa) in [
        (shell(), sofa.clone()),
        (flipped(&shell()), sofa.clone()),
        (shell(), flipped(&sofa)),
        (flipped(&shell()), flipped(&sofa)),
    ] {
        let field = bake_quietly(&[walls, sofa].concat());
        assert!((field.sample(Vec3::new(0.0, 1.4, 0.0)) - 1.0).abs() < 0.01);
        assert!((field.sample(Vec3::new(0.0, 0.2, 0.0)) + 0.2).abs() < 0.03);
        assert!(field.sample(Vec3::new(0.0, -0.1, 1.0)) < -0.05, "below the floor");
        assert!(field.sample(Vec3::new(1.7, 1.0, 0.0)) < -0.15, "outside the room");
    }
}

#[test]
fn a_sofa_without_underside_is_solid_on_the_floor_and_on_legs() {
    for bottom_m in [0.0, 0.04, 0.12] {
        let field = bake_quietly(&[shell(), bottomless_sofa(bottom_m)].concat());
        let inside = field.sample(Vec3::new(0.0, bottom_m + 0.3, 0.0));
        assert!(inside < -0.05, "{bottom_m}: {inside}");
        assert!(field.sample(Vec3::new(0.0, bottom_m + 0.5, 0.0)) > 0.09, "air above the seat");
    }
}

#[test]
fn a_small_hole_does_not_let_air_into_furniture() {
    // Half a tile of 15 cm: a ball of at most 9 cm across fits through.
    let mut sofa = box_triangles(Vec3::new(-0.5, 0.0, -0.4), Vec3::new(0.5, 0.4, 0.4), false, 0.15);
    let hole = sofa.iter().position(|t| t.iter().all(|p| p.y > 0.39 && p.x.abs() < 0.3 && p.z.abs() < 0.3));
    sofa.remove(hole.expect("a tile in the middle of the top"));
    let field = bake_quietly(&[shell(), sofa].concat());
    assert!(field.sample(Vec3::new(-0.3, 0.2, 0.2)) < -0.05, "inside stays solid");
}

#[test]
fn a_table_top_of_one_sheet_holds_and_its_top_stays_where_it_is() {
    let top = |y: f32| {
        let at = |x: f32, z: f32| Vec3::new(x, y, z);
        quad(at(-0.6, -0.4), at(-0.6, 0.4), at(0.6, 0.4), at(0.6, -0.4)).to_vec()
    };
    // At every place between two samples.
    for y in [0.70, 0.706, 0.7125, 0.719] {
        let field = bake_quietly(&[shell(), top(y)].concat());
        let deepest = (0..30).map(|i| field.sample(Vec3::new(0.1, y - i as f32 * 0.001, 0.1)));
        assert!(deepest.fold(0.0, f32::min) < -0.002, "{y}: the sheet is lost");
        assert!((field.sample(Vec3::new(0.1, y + 0.05, 0.1)) - 0.05).abs() < 0.003, "{y}");
        assert!(field.sample(Vec3::new(0.0, 0.4, 0.0)) > 0.2, "room for legs under the table");
    }
}

#[test]
fn a_cushion_that_overlaps_its_seat_leaves_no_surface_inside() {
    let seat = solid_box([-0.5, 0.0, -0.4], [0.5, 0.4, 0.4]);
    let cushion = solid_box([-0.45, 0.25, -0.35], [0.45, 0.5, 0.35]);
    let field = bake_quietly(&[shell(), seat, cushion].concat());
    let inside = field.sample(Vec3::new(0.0, 0.3, 0.0));
    assert!(inside < -0.15, "20 cm below the cushion's top, not {inside}");
}

#[test]
fn an_open_scan_without_ceiling_and_one_wall_is_closed_by_virtual_ones() {
    let mut scan = shell();
    scan.retain(|t| t.iter().any(|p| p.y < 2.49) && t.iter().any(|p| p.x < 1.49));
    let field = bake_quietly(&scan);
    assert!((field.sample(Vec3::new(0.0, 1.2, 0.0)) - 1.2).abs() < 0.1, "the middle stays free");
    assert!(field.sample(Vec3::new(1.8, 1.0, 0.0)) < -0.2, "a virtual wall where one is missing");
    let negative = (0..field.values.len()).filter(|&i| {
        let grid = grid::Grid { dim: field.dim, origin: field.origin, cell_m: field.cell_m };
        let p = grid.position(grid.place(i));
        let inside = Aabb { min: Vec3::new(-1.45, 0.05, -1.45), max: Vec3::new(1.45, 2.3, 1.45) };
        inside.contains(p) && field.values[i] <= 0.0
    });
    assert_eq!(negative.count(), 0, "no holes in the air");
}

#[test]
fn the_gradient_is_the_derivative_of_the_interpolation_inside_and_outside_the_grid() {
    let field = bake_room(32);
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    for _ in 0..300 {
        let span = field.bounds().grown(0.5);
        let p = span.min + Vec3::new(random(), random(), random()) * span.size();
        let (value, gradient) = field.sample_gradient(p);
        assert_eq!(value, field.sample(p));
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let h = 1e-3;
            let (above, below) = (field.sample(p + axis * h), field.sample(p - axis * h));
            let kink = (above - value) / h - (value - below) / h;
            if kink.abs() < 0.02 {
                assert!(((above - below) / (2.0 * h) - gradient.dot(axis)).abs() < 0.02, "{p} {axis}");
            }
        }
    }
    assert!(field.sample(Vec3::splat(50.0)) < -40.0, "far away is never free");
}

#[test]
fn the_same_room_gives_the_same_bytes_on_any_number_of_threads() {
    let bake_with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| bake_room(48))
    };
    assert!(bake_with(1) == bake_with(3));
}

#[test]
fn baking_stops_at_once_when_asked() {
    let calls = std::sync::atomic::AtomicUsize::new(0);
    let stop_late = |_, _| match calls.fetch_add(1, std::sync::atomic::Ordering::Relaxed) {
        0..20 => ControlFlow::Continue(()),
        _ => ControlFlow::Break(()),
    };
    assert!(bake(&triangles(2_000), &FieldConfig::default(), &stop_late).is_err());
}

#[test]
fn a_field_that_was_baked_before_comes_back_bit_by_bit_and_only_for_the_same_room() {
    let folder = tempfile::tempdir().expect("a folder");
    let cache = Cache::at(folder.path().join("cache"), 1 << 24);
    let room = shell();
    let coarse = Resolution::Cells { cell_m: 0.1, max_bytes: 1 << 24 };
    let config = FieldConfig { resolution: coarse, ..FieldConfig::default() };
    let asked = AtomicUsize::new(0);
    let count = |_, _| {
        asked.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    let kept = |room: &[[Vec3; 3]], config: &FieldConfig| {
        asked.store(0, Ordering::Relaxed);
        let field = bake_kept(Some(&cache), room, config, &count).expect("not stopped");
        (field, asked.load(Ordering::Relaxed))
    };
    let (first, baking) = kept(&room, &config);
    assert_eq!(first, bake(&room, &config, &quietly).expect("not stopped"));
    let (again, reading) = kept(&room, &config);
    let bits = |field: &SignedDistanceField| field.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!((bits(&again), again.dim, again.origin), (bits(&first), first.dim, first.origin));
    assert!(reading < baking / 4, "it was baked again: {reading} steps, {baking} the first time");
    assert_ne!(kept(&room[1..], &config).1, reading, "another room is another field");
    let wider = FieldConfig { band_m: 0.08, ..config };
    assert_ne!(kept(&room, &wider).1, reading, "other settings give another field");

    let key = cache_key(&room, &config, &quietly).expect("not stopped");
    cache.put(&key, b"half a field");
    let (mended, steps) = kept(&room, &config);
    assert!(steps > reading && bits(&mended) == bits(&first), "a damaged entry was taken");
}
