//! Sheets of figures: many posed bodies in one picture, each from two sides, without a room.

use std::sync::Arc;

use glam::{Mat3, Vec3};

use crate::body::Body;
use crate::render::{Backend, BodySurface, Painter, PersonDraw, Picture, SceneDraw, Shown};
use crate::scene::{Camera, PersonId};

/// Room of one figure, metres: arms and a lying body fit.
const CELL_M: [f32; 2] = [1.7, 2.1];
/// The second view of a figure overlaps the gap between two cells.
const PAIR_M: f32 = 1.15;

/// Draws figures in rows of `columns`, each from the front and from its left side. Vertices are in the body's frame.
///
/// # Errors
/// When the picture can't be drawn.
pub fn figure_sheet(figures: &[Vec<Vec3>], columns: usize, pixels_a_metre: f32) -> anyhow::Result<Picture> {
    let columns = columns.clamp(1, figures.len().max(1));
    let rows = figures.len().div_ceil(columns).max(1);
    let width_m = (CELL_M[0] + PAIR_M) * columns as f32;
    let height_m = CELL_M[1] * rows as f32;
    let people = figures.iter().enumerate().flat_map(|(i, vertices)| {
        let corner =
            Vec3::new((i % columns) as f32 * (CELL_M[0] + PAIR_M), -((i / columns) as f32) * CELL_M[1], 0.0);
        let front = corner + Vec3::new(0.5 * CELL_M[0], -0.48 * CELL_M[1], 0.0);
        let side = front + Vec3::X * (0.5 * CELL_M[0] + 0.5 * PAIR_M);
        let from_side = Mat3::from_rotation_y(-std::f32::consts::FRAC_PI_2);
        [(front, Mat3::IDENTITY), (side, from_side)].into_iter().enumerate().map(move |(view, (at, turn))| {
            let moved: Arc<[Vec3]> = vertices.iter().map(|v| at + turn * *v).collect();
            PersonDraw::new(PersonId((2 * i + view) as u32), moved, i as u32)
        })
    });
    let mut draw = SceneDraw { people: people.collect(), ..SceneDraw::default() };
    draw.body = Some(Arc::new(BodySurface::of(Body::bundled())));
    (draw.look.grid, draw.look.background) = (Shown::No, [214, 217, 222]);
    let middle = Vec3::new(0.5 * width_m, -0.5 * height_m, 0.0);
    let camera =
        Camera { eye: middle + Vec3::Z * 20.0, target: middle, fov_y: 0.5, ortho_height_m: Some(height_m) };
    let size = [width_m, height_m].map(|m| (m * pixels_a_metre) as u32);
    Ok(Painter::new(Backend::Cpu)?.picture(&draw, &camera, size)?)
}
