//! Rays of one picture: what a point of it sees, how much light gets there, and its colour.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::shade::{Open, lit};
use super::surface::{self, Surface};
use super::world::{Owner, World};
use crate::render::draw::{Look, SceneDraw, Shown};
use crate::render::light::LightRig;
use crate::render::mips::Level;
use crate::scene::{Camera, Hit};

/// How far a ray looks, in metres.
const FAR_M: f32 = 500.0;
/// Rays start this far off the surface they leave.
const LIFT_M: f32 = 2e-3;
/// How far ambient occlusion looks around, in metres.
const REACH_M: f32 = 0.45;
/// Rays for ambient occlusion of each pixel; 25 pixels are averaged.
const AROUND_RAYS: u32 = 3;
/// Half the angle in radians that the key light spans: a shadow a metre away gets 7 cm soft.
const KEY_SPREAD: f32 = 0.035;
/// See-through layers that are drawn over each other.
const MAX_LAYERS: usize = 4;

/// What a point of the picture sees.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The solid surface, if any: position, surface, distance, whose.
    solid: Option<Solid>,
    /// Light of see-through layers in front, already weighted.
    front: Vec3,
    /// Share of what lies behind them that gets through.
    through: f32,
    /// Unit vector towards the eye.
    to_eye: Vec3,
}

#[derive(Clone, Debug)]
struct Solid {
    at: Vec3,
    surface: Surface,
    distance_m: f32,
    owner: usize,
    /// The grid's ground, not a thing: drawn as a veil over the background.
    ground: bool,
}

impl Seen {
    /// 0 for different surfaces to 1 for the same point of one: weight of a neighbour's visibility.
    pub fn likeness(&self, other: &Self) -> f32 {
        let (Some(a), Some(b)) = (&self.solid, &other.solid) else { return 0.0 };
        if a.owner != b.owner {
            return 0.0;
        }
        let bend = a.surface.normal.dot(b.surface.normal).abs();
        let off = (b.at - a.at).dot(a.surface.normal).abs();
        let near = 1.0 - off / (0.01 + 0.01 * a.distance_m);
        if bend < 0.9 || near < 0.0 { 0.0 } else { near }
    }

    /// Whether an edge runs between both.
    pub fn differs(&self, other: &Self) -> bool {
        match (&self.solid, &other.solid) {
            (None, None) => (self.through - other.through).abs() > 0.05,
            (Some(a), Some(b)) => {
                let base = (a.surface.base - b.surface.base).abs().max_element();
                a.owner != b.owner
                    || a.surface.normal.dot(b.surface.normal).abs() < 0.95
                    || (base > 0.08)
                    || (self.through - other.through).abs() > 0.05
                    || (a.distance_m - b.distance_m).abs() > 0.1 * a.distance_m
            }
            _ => true,
        }
    }
}

/// Casts the rays of one picture.
pub struct Caster<'a> {
    world: &'a World<'a>,
    /// Every size of every texture.
    textures: Vec<Vec<Level>>,
    look: Look,
    rig: LightRig,
    camera: &'a Camera,
    size: Vec2,
    /// Point that the room is cut open for, if it is.
    cut_for: Option<Vec3>,
}

impl<'a> Caster<'a> {
    /// For a picture of `size` pixels.
    pub fn new(world: &'a World<'a>, draw: &SceneDraw, camera: &'a Camera, size: [u32; 2]) -> Self {
        let size = Vec2::new(size[0] as f32, size[1] as f32);
        let cut_for = draw.look.cuts(camera, &world.bounds).then(|| Look::cut_eye(camera));
        let textures = draw.room.textures.par_iter().map(|t| Level::full(t).chain()).collect();
        Self { world, textures, look: draw.look, rig: LightRig::default(), camera, size, cut_for }
    }

    /// What the point `pixel` (from the top left) sees.
    pub fn seen(&self, pixel: Vec2) -> Seen {
        let at = pixel / self.size;
        let (origin, direction) = self.camera.ray(at.x, at.y, self.size.x / self.size.y);
        let mut seen = Seen { solid: None, front: Vec3::ZERO, through: 1.0, to_eye: -direction };
        let mut start_m = 0.0;
        let mut passed = None;
        for _ in 0..MAX_LAYERS {
            let from = origin + direction * start_m;
            let stops =
                |hit: &Hit| self.is_shown(hit.triangle) && !self.is_inside_ghost(hit.triangle, passed);
            let Some(hit) = self.world.trace(from, direction, FAR_M, stops) else { break };
            let distance_m = start_m + hit.distance_m;
            let surface = surface::at(self.world, &self.textures, &hit, self.footprint_m(distance_m));
            let owner = self.world.owner_index(hit.triangle);
            if surface.alpha >= 0.99 {
                let at = origin + direction * distance_m;
                seen.solid = Some(Solid { at, surface, distance_m, owner, ground: false });
                return seen;
            }
            let color = lit(&self.rig, &surface, turned(surface.normal, -direction), -direction, Open::FULL);
            seen.front += color * surface.alpha * seen.through;
            seen.through *= 1.0 - surface.alpha;
            start_m = distance_m + LIFT_M;
            passed = Some(owner);
        }
        seen.solid = self.ground(origin, direction);
        seen
    }

    fn is_shown(&self, triangle: usize) -> bool {
        !self.cut_for.is_some_and(|eye| self.world.is_cut_for(triangle, eye))
    }

    /// Of a ghost only the front is drawn.
    fn is_inside_ghost(&self, triangle: usize, passed: Option<usize>) -> bool {
        passed == Some(self.world.owner_index(triangle))
            && matches!(self.world.owner(triangle), Owner::Person(..))
    }

    /// Width of a pixel at a distance, in metres.
    fn footprint_m(&self, distance_m: f32) -> f32 {
        match self.camera.ortho_height_m {
            Some(height_m) => height_m / self.size.y,
            None => 2.0 * distance_m * (self.camera.fov_y * 0.5).tan() / self.size.y,
        }
    }

    /// The ground grid, where nothing else is.
    fn ground(&self, origin: Vec3, direction: Vec3) -> Option<Solid> {
        let height = if self.world.bounds.is_empty() { 0.0 } else { self.world.bounds.min.y.min(0.0) };
        let distance_m = (height - origin.y) / direction.y;
        if self.look.grid == Shown::No || !(0.0..FAR_M).contains(&distance_m) {
            return None;
        }
        let at = origin + direction * distance_m;
        let surface = Surface {
            base: Vec3::ONE,
            alpha: self.grid_strength(at, direction, distance_m),
            emissive: Vec3::ZERO,
            metallic: 0.0,
            roughness: 1.0,
            rim: 0.0,
            normal: Vec3::Y,
        };
        Some(Solid { at, surface, distance_m, owner: usize::MAX, ground: true })
    }

    fn grid_strength(&self, at: Vec3, direction: Vec3, distance_m: f32) -> f32 {
        let bounds = &self.world.bounds;
        let (middle, reach) = match bounds.is_empty() {
            true => (Vec3::ZERO, 30.0),
            false => (bounds.center(), (bounds.size().length() * 2.0).max(30.0)),
        };
        let off = Vec2::new(at.x - middle.x, at.z - middle.z).length() / reach;
        let pixel = self.footprint_m(distance_m) / direction.y.abs().max(0.05);
        let line = |v: f32, period: f32| {
            let away = ((v / period - 0.5).rem_euclid(1.0) - 0.5).abs() * period;
            (1.0 - away / pixel).clamp(0.0, 1.0) * (1.5 - 3.0 * pixel / period).clamp(0.0, 1.0)
        };
        let strength = |period: f32| line(at.x, period).max(line(at.z, period));
        let steep = (direction.y.abs() * 6.0).clamp(0.0, 1.0);
        (strength(1.0) * 0.20).max(strength(5.0) * 0.34) * (1.0 - off).clamp(0.0, 1.0).powf(1.5) * steep
    }

    /// How much light reaches what is seen, by a few rays that differ from pixel to pixel.
    pub fn open(&self, seen: &Seen, x: u32, y: u32) -> Open {
        let Some(solid) = &seen.solid else { return Open::FULL };
        let normal = turned(solid.surface.normal, seen.to_eye);
        let from = solid.at + normal * LIFT_M;
        // What is cut away for the camera must not darken what it then shows.
        let casts = |t: usize| self.is_shown(t) && self.world.casts_shadow(t, self.rig.to_key);
        let blocked =
            |direction: Vec3, max_m: f32| self.world.trace(from, direction, max_m, |h| casts(h.triangle));
        let [a, b] = noise(x, y, 0);
        let key = if normal.dot(self.rig.to_key) <= 0.0 {
            0.0
        } else {
            let spread = disk(a, b) * KEY_SPREAD;
            let (u, v) = self.rig.to_key.any_orthonormal_pair();
            let direction = (self.rig.to_key + u * spread.x + v * spread.y).normalize_or(self.rig.to_key);
            f32::from(u8::from(blocked(direction, FAR_M).is_none()))
        };
        let mut around = 0.0;
        let (u, v) = normal.any_orthonormal_pair();
        for ray in 1..=AROUND_RAYS {
            let [a, b] = noise(x, y, ray);
            let flat = disk(a, b);
            let up = (1.0 - flat.length_squared()).max(0.0).sqrt();
            let direction = (u * flat.x + v * flat.y + normal * up).normalize_or(normal);
            let hit = blocked(direction, REACH_M);
            around += hit.map_or(1.0, |h| 0.85 * h.distance_m / REACH_M);
        }
        Open { key, around: around / AROUND_RAYS as f32 }
    }

    /// Linear RGB of what is seen.
    pub fn color(&self, seen: &Seen, open: Open, background: Vec3) -> Vec3 {
        let behind = match &seen.solid {
            None => background,
            Some(ground) if ground.ground => {
                let fade = (1.0 - ground.distance_m / 60.0).max(0.0);
                let veiled = background * (1.0 - (1.0 - open.key) * 0.35 * fade);
                veiled.lerp(Vec3::splat(0.75), ground.surface.alpha)
            }
            Some(solid) => {
                let normal = turned(solid.surface.normal, seen.to_eye);
                lit(&self.rig, &solid.surface, normal, seen.to_eye, open)
            }
        };
        seen.front + behind * seen.through
    }
}

fn turned(normal: Vec3, to_eye: Vec3) -> Vec3 {
    if normal.dot(to_eye) < 0.0 { -normal } else { normal }
}

/// A point of the unit disk from two numbers in 0 to 1 (uniform by area).
fn disk(a: f32, b: f32) -> Vec2 {
    Vec2::from_angle(b * std::f32::consts::TAU) * a.sqrt()
}

/// Two numbers in 0 to 1 for a pixel's ray: within any 5 x 5 pixels, which are averaged, they are spread
/// out (golden-ratio lattice of Roberts' R2 sequence).
fn noise(x: u32, y: u32, ray: u32) -> [f32; 2] {
    let index = f64::from((x % 5) + 5 * (y % 5) + 25 * ray) + 1.0;
    [(index * 0.754_877_666_246_692_8).fract() as f32, (index * 0.569_840_290_998_053_2).fract() as f32]
}
