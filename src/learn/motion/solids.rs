//! The distance to a staged room's surfaces, worked out from the boxes that it is made of: for training, where hundreds
//! of rooms are looked at and a centimetre does not matter. Results are measured against fields baked from triangles.

use glam::{Vec2, Vec3};

use super::staging::StagedRoom;
use crate::scene::layout::{Item, Outline, Placement};
use crate::scene::{SignedDistanceField, direction_of};

/// Half of the side of the field around a body, metres: arms' length.
const REACH_M: f32 = 1.3;
/// Height of the field from just below the floor, metres.
const HIGH_M: f32 = 2.1;
/// Spacing of its samples, metres.
const CELL_M: f32 = 0.1;
/// Thickness of table tops and shelves, metres.
const BOARD_M: f32 = 0.04;
/// Depth of a sofa's back, metres.
const BACK_M: f32 = 0.2;

/// A box that stands upright.
struct Solid {
    centre: Vec3,
    half: Vec3,
    facing: f32,
}

impl Solid {
    /// Signed distance of a point, positive outside.
    fn distance_m(&self, p: Vec3) -> f32 {
        let front = direction_of(self.facing);
        let off = p - self.centre;
        let flat = Vec2::new(off.x, off.z);
        let own = Vec3::new(flat.dot(Vec2::new(front.y, -front.x)), off.y, flat.dot(front));
        let beyond = own.abs() - self.half;
        beyond.max(Vec3::ZERO).length() + beyond.max_element().min(0.0)
    }
}

impl StagedRoom {
    /// Signed distances around the point of the floor below a body, metres.
    pub fn field_around(&self, at: Vec3) -> SignedDistanceField {
        let solids: Vec<Solid> = self.layout.furniture.iter().flat_map(solids_of).collect();
        let origin = Vec3::new(at.x - REACH_M, at.y - 2.0 * CELL_M, at.z - REACH_M);
        let count = |length_m: f32| (length_m / CELL_M).ceil() as usize + 1;
        let dim = [count(2.0 * REACH_M), count(HIGH_M), count(2.0 * REACH_M)];
        let walls = self.inside();
        let mut values = Vec::with_capacity(dim.iter().product());
        for x in 0..dim[0] {
            for y in 0..dim[1] {
                for z in 0..dim[2] {
                    let p = origin + Vec3::new(x as f32, y as f32, z as f32) * CELL_M;
                    let shell = walls.map_or(p.y, |[low, high]| {
                        let side = (p.x - low.x).min(high.x - p.x).min(p.z - low.y).min(high.y - p.z);
                        side.min(p.y)
                    });
                    values.push(solids.iter().map(|s| s.distance_m(p)).fold(shell, f32::min));
                }
            }
        }
        SignedDistanceField { dim, origin, cell_m: Vec3::splat(CELL_M), values }
    }

    /// The rectangle inside the walls.
    fn inside(&self) -> Option<[Vec2; 2]> {
        let Outline::Polygon(corners) = &self.layout.outline else { return None };
        let corners = || corners.iter().map(|(x, z)| Vec2::new(*x, *z));
        Some([corners().reduce(Vec2::min)?, corners().reduce(Vec2::max)?])
    }
}

/// What of a piece keeps people out.
fn solids_of(placement: &Placement) -> Vec<Solid> {
    let facing = placement.yaw_deg.to_radians();
    let (x, y, z) = placement.at;
    let front = direction_of(facing);
    let solid = |low_m: f32, high_m: f32, wide_m: f32, along_m: [f32; 2]| {
        let middle = 0.5 * (along_m[0] + along_m[1]);
        Solid {
            centre: Vec3::new(x + front.x * middle, y + 0.5 * (low_m + high_m), z + front.y * middle),
            half: Vec3::new(0.5 * wide_m, 0.5 * (high_m - low_m), 0.5 * (along_m[1] - along_m[0])),
            facing,
        }
    };
    let whole = |size: (f32, f32, f32)| solid(0.0, size.1, size.0, [-0.5 * size.2, 0.5 * size.2]);
    match &placement.item {
        Item::Table { size, .. } => {
            vec![solid(size.1 - BOARD_M, size.1, size.0, [-0.5 * size.2, 0.5 * size.2])]
        }
        Item::Sofa { size, seat_m, .. } => {
            let rear = -0.5 * size.2;
            vec![
                solid(0.0, *seat_m, size.0, [rear, 0.5 * size.2]),
                solid(0.0, size.1, size.0, [rear, rear + BACK_M]),
            ]
        }
        Item::Block { size, .. }
        | Item::Bed { size, .. }
        | Item::Bench { size, .. }
        | Item::Shelf { size, .. } => {
            vec![whole(*size)]
        }
        _ => Vec::new(),
    }
}
