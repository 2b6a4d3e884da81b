//! Light on a surface: `shaders/light.wgsl` in Rust, with rays in place of shadow map and depth.

use glam::Vec3;

use super::surface::Surface;
use crate::render::light::LightRig;

/// How much light reaches a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Open {
    /// Of the key light: 0 in shadow to 1.
    pub key: f32,
    /// Of the surroundings: 0 closed to 1.
    pub around: f32,
}

impl Open {
    /// Nothing summed up yet.
    pub const NONE: Self = Self { key: 0.0, around: 0.0 };
    /// Nothing in the way.
    pub const FULL: Self = Self { key: 1.0, around: 1.0 };

    /// The sum with `other` times `weight`.
    pub fn plus(self, other: Self, weight: f32) -> Self {
        Self { key: self.key + other.key * weight, around: self.around + other.around * weight }
    }

    /// Both times `factor`.
    pub fn scaled(self, factor: f32) -> Self {
        Self { key: self.key * factor, around: self.around * factor }
    }
}

fn hemisphere(rig: &LightRig, normal: Vec3) -> Vec3 {
    rig.ground.lerp(rig.sky, 0.5 + 0.5 * normal.y)
}

/// Linear RGB that `surface` sends along the unit vector `to_eye`; `normal` is turned to the viewer.
pub fn lit(rig: &LightRig, surface: &Surface, normal: Vec3, to_eye: Vec3, open: Open) -> Vec3 {
    let n_dot_l = normal.dot(rig.to_key).max(0.0);
    let n_dot_v = normal.dot(to_eye).max(1e-3);
    let key = n_dot_l * open.key;
    let diffuse = surface.base * (1.0 - surface.metallic);
    let f0 = Vec3::splat(0.04).lerp(surface.base, surface.metallic);
    let ambient = diffuse * (hemisphere(rig, normal) + rig.camera * n_dot_v);
    // Trowbridge-Reitz lobe of the key light; the hemisphere stands in for a mirrored room.
    let half = (to_eye + rig.to_key).normalize_or(normal);
    let a = (surface.roughness * surface.roughness).max(0.03);
    let n_dot_h = normal.dot(half).max(0.0);
    let d = n_dot_h * n_dot_h * (a * a - 1.0) + 1.0;
    let lobe = (a * a / (4.0 * d * d * n_dot_v.max(0.2))).min(4.0);
    let gloss = 1.0 - surface.roughness;
    let fresnel = f0 + (f0.max(Vec3::splat(gloss)) - f0) * (1.0 - n_dot_v).powi(5);
    let mirrored = hemisphere(rig, (-to_eye).reflect(normal)) * fresnel * (0.35 + 0.65 * gloss);
    let edge = (1.0 - n_dot_v).powi(3) * (0.4 + 0.6 * normal.y.max(0.0));
    let direct = (diffuse + f0 * lobe) * key * rig.key + surface.emissive;
    let indirect = ambient + mirrored + Vec3::splat(surface.rim * rig.rim * edge);
    let color = direct + indirect;
    let share = (indirect.element_sum() / color.element_sum().max(1e-4)).clamp(0.0, 1.0);
    let dimmed = 1.0 + (open.around - 1.0) * (0.35 + 0.65 * share);
    shoulder(color) * dimmed
}

/// Bends what is brighter than 0.75 towards 1, so that white walls keep their edges and colours their hue.
fn shoulder(color: Vec3) -> Vec3 {
    const START: f32 = 0.75;
    let peak = color.max_element();
    if peak <= START {
        return color;
    }
    let over = peak - START;
    color * ((START + (1.0 - START) * over / (over + (1.0 - START))) / peak)
}
