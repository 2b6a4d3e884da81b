//! What a ray meets: colours from textures, clothes or heat, and the shading normal.

use glam::{Vec2, Vec3};

use super::world::{Dressed, Owner, Placed, World};
use crate::assets::AlphaMode;
use crate::render::dress::SurfacePart;
use crate::render::heat::heat_color;
use crate::render::light::{linear_from_srgb, linear_rgb};
use crate::render::mips::Level;
use crate::scene::Hit;

/// A surface as light meets it.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Linear RGB.
    pub base: Vec3,
    /// 1 solid.
    pub alpha: f32,
    /// Linear RGB given off.
    pub emissive: Vec3,
    /// 0 dielectric to 1 metal.
    pub metallic: f32,
    /// 0 mirror to 1 chalk.
    pub roughness: f32,
    /// Strength of the rim.
    pub rim: f32,
    /// Unit normal, not yet turned to the viewer.
    pub normal: Vec3,
}

/// The surface at a hit; a pixel is `footprint_m` wide there.
pub fn at(world: &World<'_>, textures: &[Vec<Level>], hit: &Hit, footprint_m: f32) -> Surface {
    let flat = world.flat_normal(hit.triangle);
    match world.owner(hit.triangle) {
        Owner::Person(dressed, t) => of_person(dressed, t, hit.barycentric, footprint_m, flat),
        Owner::Room(placed, t) => {
            let density = texture_density(placed, t, world.corners(hit.triangle));
            of_room(textures, placed, t, hit.barycentric, footprint_m * density, flat)
        }
    }
}

fn of_person(dressed: &Dressed<'_>, t: usize, weights: Vec3, footprint_m: f32, flat: Vec3) -> Surface {
    let corners = dressed.body.triangles()[t].map(|v| v as usize);
    let blend = |of: &dyn Fn(usize) -> Vec3| -> Vec3 {
        corners.iter().zip(weights.to_array()).map(|(v, w)| of(*v) * w).sum()
    };
    let rest = blend(&|v| dressed.body.rest(v));
    let eye = dressed.body.part(corners[0]) == SurfacePart::Eye;
    let (base, roughness, rim) = match &dressed.person.heat {
        Some(heat) => (blend(&|v| linear_rgb(heat_color(heat[v]))), 0.72, 0.4),
        None if eye => (dressed.outfit.eye_at(rest, footprint_m), 0.15, 0.4),
        None => (dressed.outfit.color_at(rest, footprint_m), 0.72, 1.0),
    };
    Surface {
        base,
        alpha: dressed.person.alpha,
        emissive: Vec3::ZERO,
        metallic: 0.0,
        roughness,
        rim,
        normal: blend(&|v| dressed.normals[v]).normalize_or(flat),
    }
}

fn of_room(
    textures: &[Vec<Level>],
    placed: &Placed,
    t: usize,
    weights: Vec3,
    footprint_uv: f32,
    flat: Vec3,
) -> Surface {
    let (mesh, material) = (&placed.mesh, &placed.material);
    let corners = mesh.triangles[t].map(|v| v as usize);
    let weights = weights.to_array();
    let normal: Vec3 = (0..3).map(|c| placed.normals[t * 3 + c] * weights[c]).sum();
    let [r, g, b, mut alpha] = material.base_color;
    let mut base = Vec3::new(r, g, b);
    if let Some(levels) = material.base_color_texture.and_then(|i| textures.get(i)) {
        let uv = |v: usize| mesh.uvs.get(v).copied().unwrap_or_default();
        let at: Vec2 = (0..3).map(|c| uv(corners[c]) * weights[c]).sum();
        let (color, opacity) = sample(levels, at, footprint_uv);
        base *= color;
        alpha *= opacity;
    }
    if !mesh.colors.is_empty() {
        let channel = |i: usize| -> f32 {
            (0..3).map(|c| f32::from(mesh.colors[corners[c]][i]) * weights[c]).sum::<f32>() / 255.0
        };
        base *= Vec3::new(channel(0), channel(1), channel(2)).powf(2.2);
        alpha *= channel(3);
    }
    let alpha = match material.alpha {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask(cutoff) => f32::from(u8::from(alpha >= cutoff)),
        AlphaMode::Blend => alpha,
    };
    Surface {
        base,
        alpha,
        emissive: Vec3::from_array(material.emissive),
        metallic: material.metallic,
        roughness: material.roughness,
        rim: 0.0,
        normal: normal.normalize_or(flat),
    }
}

/// Texture coordinates that a metre on triangle `t` spans.
fn texture_density(placed: &Placed, t: usize, [a, b, c]: [Vec3; 3]) -> f32 {
    let uv = placed.mesh.triangles[t].map(|v| placed.mesh.uvs.get(v as usize).copied().unwrap_or_default());
    let area_uv = (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]).abs();
    let area_m2 = (b - a).cross(c - a).length();
    (area_uv / area_m2.max(1e-12)).sqrt()
}

/// Linear colour and alpha of a texture, blended between texels of the size that suits the footprint.
fn sample(levels: &[Level], uv: Vec2, footprint_uv: f32) -> (Vec3, f32) {
    let Some(full) = levels.first() else { return (Vec3::ONE, 1.0) };
    let texels = footprint_uv * full.width.max(full.height) as f32;
    let level = &levels[(texels.max(1.0).log2().round() as usize).min(levels.len() - 1)];
    let size = Vec2::new(level.width as f32, level.height as f32);
    let at = (uv - uv.floor()) * size - 0.5;
    let (low, part) = (at.floor(), at - at.floor());
    let (mut color, mut alpha) = (Vec3::ZERO, 0.0);
    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        let weight =
            (if dx > 0.0 { part.x } else { 1.0 - part.x }) * (if dy > 0.0 { part.y } else { 1.0 - part.y });
        let x = (low.x + dx).rem_euclid(size.x) as usize % level.width as usize;
        let y = (low.y + dy).rem_euclid(size.y) as usize % level.height as usize;
        let texel = &level.rgba[(y * level.width as usize + x) * 4..][..4];
        color += Vec3::new(lit(texel[0]), lit(texel[1]), lit(texel[2])) * weight;
        alpha += f32::from(texel[3]) / 255.0 * weight;
    }
    (color, alpha)
}

/// sRGB byte to linear light by table.
fn lit(byte: u8) -> f32 {
    use std::sync::LazyLock;
    static TABLE: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|b| linear_from_srgb(b as u8)));
    TABLE[byte as usize]
}
