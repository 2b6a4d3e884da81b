//! Seats and beds of any size, made on the spot: sofas, armchairs, poufs, beds.

use glam::{Affine3A, Vec3};

use super::Srgb;
use super::mesh::{Build, Surface, block, paint};
use super::soft::soft_block;
use crate::assets::Mesh;

/// Thickness of a seat's cushion.
const CUSHION_M: f32 = 0.15;
/// Depth of a sofa's back, its cushion with it.
const BACK_M: f32 = 0.22;
/// Armrests over the seat, as most sofas have them.
const ARM_OVER_SEAT_M: f32 = 0.19;
/// Height of legs under sofas and beds.
const LEG_M: f32 = 0.09;
/// Side of a square leg.
const LEG_WIDE_M: f32 = 0.05;
/// Rounding of cushions: fabric over foam.
const SOFT_M: f32 = 0.035;
/// Thickness of a mattress.
const MATTRESS_M: f32 = 0.2;
/// Thickness of a headboard.
const HEADBOARD_M: f32 = 0.05;

fn part(mesh: Mesh, color: Srgb) -> Surface {
    Surface { mesh, material: paint(color), texture: None }
}

fn moved(mesh: &mut Mesh, other: &Mesh, at: Vec3) {
    mesh.append(other, Affine3A::from_translation(at));
}

fn legs(size: Vec3, height: f32) -> Mesh {
    let mut mesh = Mesh::default();
    let inset = LEG_WIDE_M * 0.5 + 0.03;
    for (sx, sz) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        let foot = Vec3::new(sx * (size.x * 0.5 - inset), 0.0, sz * (size.z * 0.5 - inset));
        moved(&mut mesh, &block(Vec3::ZERO, Vec3::new(LEG_WIDE_M, height, LEG_WIDE_M)), foot);
    }
    mesh
}

/// A sofa of `seats` cushions with its back at -z; an armchair when it has one. Armrests `arm_m` wide, none at 0.
pub fn sofa(size: Vec3, seat_m: f32, seats: u8, arm_m: f32, fabric: Srgb, wood: Srgb) -> Vec<Surface> {
    let inner = size.x - 2.0 * arm_m;
    let (base_top, front) = (seat_m - CUSHION_M, size.z * 0.5);
    let mut cover = Mesh::default();
    let base = soft_block(Vec3::new(size.x, base_top - LEG_M, size.z), 0.012);
    moved(&mut cover, &base, Vec3::Y * LEG_M);
    let back = soft_block(Vec3::new(size.x, size.y - base_top + 0.02, BACK_M * 0.6), SOFT_M);
    moved(&mut cover, &back, Vec3::new(0.0, base_top - 0.02, BACK_M * 0.3 - front));
    let count = seats.max(1);
    let wide = inner / f32::from(count);
    let deep = size.z - BACK_M;
    for k in 0..count {
        let x = (f32::from(k) + 0.5) * wide - inner * 0.5;
        let seat = soft_block(Vec3::new(wide - 0.006, CUSHION_M + 0.01, deep), SOFT_M);
        moved(&mut cover, &seat, Vec3::new(x, base_top - 0.01, front - deep * 0.5));
        let rest = soft_block(Vec3::new(wide - 0.006, size.y - seat_m - 0.03, BACK_M * 0.55), SOFT_M);
        moved(&mut cover, &rest, Vec3::new(x, seat_m - 0.01, BACK_M * 0.75 - front));
    }
    if arm_m > 0.0 {
        for side in [-1.0, 1.0] {
            let arm = soft_block(Vec3::new(arm_m, seat_m + ARM_OVER_SEAT_M - LEG_M, size.z), SOFT_M);
            moved(&mut cover, &arm, Vec3::new(side * (size.x - arm_m) * 0.5, LEG_M, 0.0));
        }
    }
    vec![part(cover, fabric), part(legs(size, LEG_M + 0.01), wood)]
}

/// A bed, its head at -z: `size.1` is the height of the mattress's top, the headboard rises to `headboard_m`.
pub fn bed(size: Vec3, headboard_m: f32, cover: Srgb, wood: Srgb) -> Vec<Surface> {
    let deep = size.z - HEADBOARD_M;
    let middle = HEADBOARD_M * 0.5;
    let under = (size.y - MATTRESS_M).max(LEG_M + 0.04);
    let mut frame = Mesh::default();
    let rail = block(Vec3::new(0.0, LEG_M, middle), Vec3::new(size.x, under - LEG_M, deep));
    frame.append(&rail, Affine3A::IDENTITY);
    frame.append(&legs(Vec3::new(size.x, 0.0, size.z), LEG_M + 0.005), Affine3A::IDENTITY);
    let board = Vec3::new(size.x, headboard_m.max(size.y), HEADBOARD_M);
    moved(&mut frame, &soft_block(board, 0.015), Vec3::Z * (HEADBOARD_M - size.z) * 0.5);
    let mut mattress = Mesh::default();
    let soft = soft_block(Vec3::new(size.x - 0.02, size.y - under + 0.01, deep - 0.02), 0.05);
    moved(&mut mattress, &soft, Vec3::new(0.0, under - 0.01, middle));
    vec![part(mattress, cover), part(frame, wood)]
}

/// A pouf or footstool without legs.
pub fn pouf(size: Vec3, fabric: Srgb) -> Vec<Surface> {
    vec![part(soft_block(size, 0.06), fabric)]
}

/// A bench: a padded board on four legs.
pub fn bench(size: Vec3, fabric: Srgb, wood: Srgb) -> Vec<Surface> {
    const PAD_M: f32 = 0.07;
    let mut pad = Mesh::default();
    moved(&mut pad, &soft_block(Vec3::new(size.x, PAD_M, size.z), 0.025), Vec3::Y * (size.y - PAD_M));
    vec![part(pad, fabric), part(legs(size, size.y - PAD_M + 0.01), wood)]
}

/// An open shelf of `boards` boards, the top one with it, with a back.
pub fn shelf(size: Vec3, boards: u8, color: Srgb) -> Vec<Surface> {
    const BOARD_M: f32 = 0.022;
    let mut mesh = Mesh::default();
    let (half, back) = (size.x * 0.5, size.z * 0.5);
    for side in [-1.0, 1.0] {
        let x = side * (half - BOARD_M * 0.5);
        mesh.append(&block(Vec3::X * x, Vec3::new(BOARD_M, size.y, size.z)), Affine3A::IDENTITY);
    }
    let inner = size.x - 2.0 * BOARD_M;
    mesh.cuboid(Vec3::new(BOARD_M - half, 0.0, -back), Vec3::new(half - BOARD_M, size.y, 0.012 - back));
    let count = boards.max(2);
    for k in 0..count {
        let y = (size.y - BOARD_M) * f32::from(k) / f32::from(count - 1);
        let at = Vec3::new(0.0, y, 0.006);
        mesh.append(&block(at, Vec3::new(inner, BOARD_M, size.z - 0.012)), Affine3A::IDENTITY);
    }
    vec![part(mesh, color)]
}
