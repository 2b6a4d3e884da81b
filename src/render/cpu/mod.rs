//! Pictures without any graphics driver: a small ray caster over the room's triangle tree.
//!
//! Sees what the card draws, in the same light: textures, clothes, heat colours, ghosts and glass, the key
//! light's shadow, ambient occlusion, the ground grid, the cut-open room. May not need an adapter, may
//! not be random: the same scene gives the same bytes on any number of threads. Draws no selection
//! outlines, lines and markers: those belong to windows.

mod cast;
mod shade;
mod surface;
mod world;

pub(super) use world::{Owner, World};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::RenderError;
use super::draw::{SceneDraw, check_camera};
use super::light::{linear_rgb, srgb_from_linear};
use super::picture::{MAX_SIDE, Picture};
use crate::scene::Camera;
use cast::{Caster, Seen};
use shade::Open;

/// What [`Picture::backend`] says of pictures drawn here.
pub const BACKEND: &str = "processor (ray caster)";

/// Sub-samples of a pixel that an edge runs through, along each side.
const EDGE_GRID: u32 = 3;

/// Draws `draw` as `camera` sees it, on the processor, with all threads of the pool.
///
/// # Errors
/// [`RenderError::Size`], [`RenderError::Camera`] and what [`SceneDraw::check`] says.
pub fn render_on_processor(
    draw: &SceneDraw,
    camera: &Camera,
    [width, height]: [u32; 2],
) -> Result<Picture, RenderError> {
    draw.check()?;
    check_camera(camera)?;
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(RenderError::Size { width, height, limit: MAX_SIDE });
    }
    let world = World::new(draw);
    let caster = Caster::new(&world, draw, camera, [width, height]);
    let film = Film { width, height };
    let seen = film.map(|x, y| caster.seen(Vec2::new(x as f32 + 0.5, y as f32 + 0.5)));
    let raw = film.map(|x, y| caster.open(&seen[film.at(x, y)], x, y));
    let open = film.map(|x, y| film.smoothed(&seen, &raw, x, y));
    let background = linear_rgb(draw.look.background);
    let rgba = film.map(|x, y| {
        let color = match film.is_edge(&seen, x, y) {
            true => film.refined(&caster, &seen, &open, x, y, background),
            false => caster.color(&seen[film.at(x, y)], open[film.at(x, y)], background),
        };
        let [r, g, b] = color.to_array().map(srgb_from_linear);
        [r, g, b, 255]
    });
    Ok(Picture { width, height, rgba: rgba.concat(), backend: BACKEND.to_owned() })
}

/// The pixels of a picture, row by row.
#[derive(Clone, Copy)]
struct Film {
    width: u32,
    height: u32,
}

impl Film {
    fn at(self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    fn map<T: Send>(self, f: impl Fn(u32, u32) -> T + Sync) -> Vec<T> {
        let count = self.width as usize * self.height as usize;
        let at = |i: usize| ((i % self.width as usize) as u32, (i / self.width as usize) as u32);
        (0..count).into_par_iter().with_min_len(256).map(|i| f(at(i).0, at(i).1)).collect()
    }

    fn around(self, x: u32, y: u32, reach: i64) -> impl Iterator<Item = usize> {
        let inside = move |dx: i64, dy: i64| {
            let (x, y) = (i64::from(x) + dx, i64::from(y) + dy);
            let fits = x >= 0 && y >= 0 && x < i64::from(self.width) && y < i64::from(self.height);
            fits.then(|| self.at(x as u32, y as u32))
        };
        (-reach..=reach).flat_map(move |dy| (-reach..=reach).filter_map(move |dx| inside(dx, dy)))
    }

    /// Mean visibility over the pixels around that see the same surface: a few rays each make a smooth
    /// shadow.
    fn smoothed(self, seen: &[Seen], raw: &[Open], x: u32, y: u32) -> Open {
        let own = self.at(x, y);
        let (mut sum, mut weight) = (Open::NONE, 0.0);
        for i in self.around(x, y, 2) {
            let w = seen[own].likeness(&seen[i]);
            sum = sum.plus(raw[i], w);
            weight += w;
        }
        if weight > 0.0 { sum.scaled(1.0 / weight) } else { raw[own] }
    }

    fn is_edge(self, seen: &[Seen], x: u32, y: u32) -> bool {
        let own = &seen[self.at(x, y)];
        self.around(x, y, 1).any(|i| own.differs(&seen[i]))
    }

    /// The mean colour of several points of a pixel; visibility comes from the likest pixel around.
    fn refined(
        self,
        caster: &Caster<'_>,
        seen: &[Seen],
        open: &[Open],
        x: u32,
        y: u32,
        background: Vec3,
    ) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for sub in 0..EDGE_GRID * EDGE_GRID {
            let offset = Vec2::new((sub % EDGE_GRID) as f32, (sub / EDGE_GRID) as f32) + 0.5;
            let at = Vec2::new(x as f32, y as f32) + offset / EDGE_GRID as f32;
            let point = caster.seen(at);
            let likest = self
                .around(x, y, 1)
                .map(|i| (point.likeness(&seen[i]), i))
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let visible = match likest {
                Some((likeness, i)) if likeness > 0.0 => open[i],
                _ => caster.open(&point, x, y),
            };
            sum += caster.color(&point, visible, background);
        }
        sum / (EDGE_GRID * EDGE_GRID) as f32
    }
}
