//! Meshes and models while they are built. Faces are flat-shaded unless a shape brings smooth normals.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::Srgb;
use crate::assets::{AlphaMode, Material, Mesh, Model, Part, Texture};
use crate::math::Aabb;

/// A part of an object: a mesh in the object's frame and how it looks.
pub struct Surface {
    pub mesh: Mesh,
    pub material: Material,
    pub texture: Option<Texture>,
}

/// A matt surface of one colour.
pub fn paint(color: Srgb) -> Material {
    let [r, g, b] = linear(color);
    Material { base_color: [r, g, b, 1.0], roughness: 0.85, double_sided: false, ..Material::default() }
}

/// Window glass: nearly clear.
pub fn glass() -> Material {
    Material {
        name: "glass".into(),
        base_color: [0.75, 0.88, 0.95, 0.25],
        roughness: 0.05,
        alpha: AlphaMode::Blend,
        ..Material::default()
    }
}

/// Linear light of an sRGB colour (IEC 61966-2-1), in f64 so that every machine rounds alike.
pub fn linear(color: Srgb) -> [f32; 3] {
    [color.0, color.1, color.2].map(|c| {
        let c = f64::from(c) / 255.0;
        (if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
    })
}

/// Turns by `degrees` about the vertical; in f64 so that every machine rounds alike.
pub fn yaw(degrees: f32) -> Quat {
    let (sin, cos) = (f64::from(degrees).to_radians() * 0.5).sin_cos();
    Quat::from_xyzw(0.0, sin as f32, 0.0, cos as f32)
}

/// Adds to a mesh.
pub trait Build {
    /// A flat quad, counter-clockwise seen from outside.
    fn quad(&mut self, corners: [Vec3; 4]);
    /// A closed box between two corners.
    fn cuboid(&mut self, min: Vec3, max: Vec3);
    /// `other` moved by `self_from_other`, which must not mirror.
    fn append(&mut self, other: &Mesh, self_from_other: Affine3A);
}

impl Build for Mesh {
    fn quad(&mut self, corners: [Vec3; 4]) {
        let [a, b, c, d] = corners;
        let normal = (c - a).cross(d - b).normalize_or(Vec3::Y);
        let base = self.positions.len() as u32;
        self.positions.extend(corners);
        self.normals.extend([normal; 4]);
        self.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
    }

    fn cuboid(&mut self, min: Vec3, max: Vec3) {
        let p = |x: usize, y: usize, z: usize| {
            let pick = |k: usize, high: usize| if high == 1 { max[k] } else { min[k] };
            Vec3::new(pick(0, x), pick(1, y), pick(2, z))
        };
        self.quad([p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)]);
        self.quad([p(1, 0, 0), p(0, 0, 0), p(0, 1, 0), p(1, 1, 0)]);
        self.quad([p(1, 0, 1), p(1, 0, 0), p(1, 1, 0), p(1, 1, 1)]);
        self.quad([p(0, 0, 0), p(0, 0, 1), p(0, 1, 1), p(0, 1, 0)]);
        self.quad([p(0, 1, 1), p(1, 1, 1), p(1, 1, 0), p(0, 1, 0)]);
        self.quad([p(0, 0, 0), p(1, 0, 0), p(1, 0, 1), p(0, 0, 1)]);
    }

    fn append(&mut self, other: &Mesh, self_from_other: Affine3A) {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions.iter().map(|p| self_from_other.transform_point3(*p)));
        let turned =
            other.normals.iter().map(|n| self_from_other.transform_vector3(*n).normalize_or(Vec3::Y));
        self.normals.extend(turned);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + base)));
    }
}

/// A closed box of `size` about the middle of its underside at `foot`.
pub fn block(foot: Vec3, size: Vec3) -> Mesh {
    let half = Vec3::new(size.x * 0.5, 0.0, size.z * 0.5);
    let mut mesh = Mesh::default();
    mesh.cuboid(foot - half, foot + half + Vec3::Y * size.y);
    mesh
}

/// A solid of revolution about the vertical: `profile` runs upwards as (radius, height) and starts and ends
/// on the axis. Smooth around, and along where the profile bends by less than 40 degrees.
pub fn lathe(profile: &[(f32, f32)], segments: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let around: Vec<(f32, f32)> = (0..segments)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / segments as f64).sin_cos();
            (sin as f32, cos as f32)
        })
        .collect();
    let slope = |k: usize| {
        let ((r0, y0), (r1, y1)) = (profile[k], profile[k + 1]);
        Vec2::new(y1 - y0, r0 - r1).normalize_or(Vec2::X)
    };
    let smooth = |k: usize, other: usize| {
        let (a, b) = (slope(k), slope(other));
        if a.dot(b) > 0.766 { (a + b).normalize_or(a) } else { a }
    };
    for k in 0..profile.len() - 1 {
        let below = if k > 0 { smooth(k, k - 1) } else { slope(k) };
        let above = if k + 2 < profile.len() { smooth(k, k + 1) } else { slope(k) };
        let base = mesh.positions.len() as u32;
        for ((radius, y), normal) in [(profile[k], below), (profile[k + 1], above)] {
            for (sin, cos) in &around {
                mesh.positions.push(Vec3::new(radius * sin, y, radius * cos));
                mesh.normals.push(Vec3::new(normal.x * sin, normal.y, normal.x * cos));
            }
        }
        let n = segments as u32;
        for i in 0..n {
            let (a, b, c, d) = (base + i, base + (i + 1) % n, base + n + (i + 1) % n, base + n + i);
            if profile[k].0 > 0.0 {
                mesh.triangles.push([a, b, c]);
            }
            if profile[k + 1].0 > 0.0 {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh
}

/// A model while objects are added; equal materials and pictures are kept once.
pub struct ModelBuilder {
    model: Model,
    nodes: usize,
    placed: HashMap<String, (usize, usize)>,
}

impl ModelBuilder {
    pub fn new(name: &str) -> Self {
        let model = Model { name: name.to_owned(), ..Model::default() };
        Self { model, nodes: 0, placed: HashMap::new() }
    }

    pub fn finish(self) -> Model {
        self.model
    }

    /// The number of an equal material, added if new.
    pub fn material(&mut self, material: &Material) -> usize {
        let known = self.model.materials.iter().position(|m| m == material);
        known.unwrap_or_else(|| {
            self.model.materials.push(material.clone());
            self.model.materials.len() - 1
        })
    }

    /// The number of an equal picture, added if new.
    pub fn texture(&mut self, texture: &Arc<Texture>) -> usize {
        let same = |t: &Arc<Texture>| {
            (t.width, t.height, &t.rgba, &t.file)
                == (texture.width, texture.height, &texture.rgba, &texture.file)
        };
        self.model.textures.iter().position(same).unwrap_or_else(|| {
            self.model.textures.push(texture.clone());
            self.model.textures.len() - 1
        })
    }

    /// Adds an object made of `surfaces`.
    pub fn object(&mut self, name: &str, category: &str, world: Affine3A, surfaces: Vec<Surface>) {
        let mut parts = Vec::new();
        for surface in surfaces.into_iter().filter(|s| !s.mesh.triangles.is_empty()) {
            let texture = surface.texture.map(|t| self.texture(&Arc::new(t)));
            let material = self.material(&Material { base_color_texture: texture, ..surface.material });
            parts.push((Arc::new(surface.mesh), material));
        }
        self.shared_object(name, category, world, &parts);
    }

    /// Adds an object whose meshes may be those of others too.
    pub fn shared_object(
        &mut self,
        name: &str,
        category: &str,
        world: Affine3A,
        parts: &[(Arc<Mesh>, usize)],
    ) {
        let first = self.model.parts.len();
        let extras = serde_json::json!({ "category": category }).to_string();
        self.model.parts.extend(parts.iter().map(|(mesh, material)| Part {
            name: name.to_owned(),
            node: self.nodes,
            path: Vec::new(),
            mesh: mesh.clone(),
            material: *material,
            file_from_mesh: world,
            extras: Some(extras.clone()),
        }));
        self.nodes += 1;
        self.placed.insert(name.to_owned(), (first, self.model.parts.len()));
    }

    /// The parts of the object called `name`.
    pub fn parts(&self, name: &str) -> Option<&[Part]> {
        self.placed.get(name).map(|(first, end)| &self.model.parts[*first..*end])
    }

    /// The box around the object called `name`.
    pub fn bounds(&self, name: &str) -> Aabb {
        let corners = |part: &Part| {
            let world = part.file_from_mesh;
            let positions = part.mesh.positions.clone();
            positions.into_iter().map(move |p| world.transform_point3(p))
        };
        Aabb::of(self.parts(name).unwrap_or_default().iter().flat_map(corners))
    }
}
