use std::ops::ControlFlow;

use super::test_room::{HIGH, LOW, exact_distance, triangles};
use super::*;
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
