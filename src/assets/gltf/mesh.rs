//! Turns one primitive into a mesh: decodes its attributes, unrolls strips and fans.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::accessor::{Buffers, Elements};
use super::json::{Primitive, TextureInfo, TextureTransform};
use crate::assets::budget::Budget;
use crate::assets::error::{Fault, Problem};
use crate::assets::mend::{Dropped, mended};
use crate::assets::model::Mesh;

const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// The mesh of `primitive`, or `None` for points and lines. `base_texture` chooses the texture coordinates.
pub fn read(
    buffers: &Buffers,
    primitive: &Primitive,
    base_texture: Option<&TextureInfo>,
    place: &str,
    budget: &Budget,
) -> Result<Option<(Mesh, Dropped)>, Fault> {
    let mode = primitive.mode.unwrap_or(TRIANGLES);
    if mode < TRIANGLES {
        return Ok(None);
    }
    if mode > FAN {
        return Err(Fault::malformed(place, format!("mode {mode} is not one of glTF's")));
    }
    let Some(&position) = primitive.attributes.get("POSITION") else {
        return Err(Fault::malformed(place, "it has no POSITION"));
    };
    refuse_draco(buffers, primitive, position, place)?;
    let positions = buffers.elements(position, &["VEC3"], &format!("{place} POSITION"), budget)?;
    let triangles = unrolled(&corners(buffers, primitive, positions.count, place, budget)?, mode);
    budget.check_triangles(place, triangles.len())?;
    let (used, triangles) = compacted(triangles, positions.count);
    let mut mesh = Mesh {
        positions: used.iter().map(|&v| Vec3::from_array(positions.floats(v as usize))).collect(),
        triangles,
        ..Mesh::default()
    };
    let optional = Optional { buffers, primitive, place, budget, vertices: positions.count, used: &used };
    mesh.normals = optional.normals()?;
    mesh.uvs = optional.uvs(base_texture)?;
    mesh.colors = optional.colors()?;
    Ok(Some(mended(mesh)))
}

fn refuse_draco(buffers: &Buffers, primitive: &Primitive, position: usize, place: &str) -> Result<(), Fault> {
    let compressed = primitive.extensions.get("KHR_draco_mesh_compression").is_some();
    let has_fallback = buffers.document.accessors.get(position).is_some_and(|a| a.buffer_view.is_some());
    if !compressed || has_fallback {
        return Ok(());
    }
    Err(Fault::new(
        place,
        Problem::Unsupported {
            feature: "Draco compression (KHR_draco_mesh_compression)".to_string(),
            remedy: "Export it without compression, e.g. by importing it into Blender and exporting it again with \
                 \"Compression\" off, or with `gltf-transform copy IN.glb OUT.glb`.",
        },
    ))
}

/// The vertex of every corner, each checked to exist.
fn corners(
    buffers: &Buffers,
    primitive: &Primitive,
    vertices: usize,
    place: &str,
    budget: &Budget,
) -> Result<Vec<u32>, Fault> {
    let Some(accessor) = primitive.indices else { return Ok((0..vertices as u32).collect()) };
    let elements = buffers.elements(accessor, &["SCALAR"], &format!("{place} indices"), budget)?;
    let corners = elements.indices().ok_or_else(|| {
        Fault::malformed(
            format!("accessors[{accessor}] ({place} indices)"),
            "indices must be unsigned integers",
        )
    })?;
    match corners.iter().position(|&v| v as usize >= vertices) {
        Some(at) => {
            let place = format!("accessors[{accessor}] ({place} indices) element {at}");
            Err(Fault::out_of_range(place, "vertex", corners[at] as usize, vertices))
        }
        None => Ok(corners),
    }
}

/// Triangles of a list, strip or fan (glTF 2.0 §3.7.2.1); an unfinished last triangle is left out.
fn unrolled(corners: &[u32], mode: u32) -> Vec<[u32; 3]> {
    match mode {
        STRIP => corners
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect(),
        FAN => {
            let first = corners.first().copied().unwrap_or(0);
            corners.get(1..).unwrap_or(&[]).windows(2).map(|w| [first, w[0], w[1]]).collect()
        }
        _ => corners.as_chunks::<3>().0.to_vec(),
    }
}

/// The used vertices and the triangles that number them. Many primitives may share one long accessor, so
/// the work is in proportion to the triangles, not to the accessor.
fn compacted(mut triangles: Vec<[u32; 3]>, vertices: usize) -> (Vec<u32>, Vec<[u32; 3]>) {
    let few = triangles.len().saturating_mul(12) < vertices;
    let mut used = Vec::new();
    let mut number = |old: u32, slot: &mut u32| {
        if *slot == u32::MAX {
            *slot = used.len() as u32;
            used.push(old);
        }
        *slot
    };
    if few {
        let mut slots: HashMap<u32, u32> = HashMap::new();
        for v in triangles.iter_mut().flatten() {
            *v = number(*v, slots.entry(*v).or_insert(u32::MAX));
        }
    } else {
        let mut slots = vec![u32::MAX; vertices];
        for v in triangles.iter_mut().flatten() {
            *v = number(*v, &mut slots[*v as usize]);
        }
    }
    (used, triangles)
}

/// Reads what a primitive may have beside positions.
struct Optional<'a> {
    buffers: &'a Buffers<'a>,
    primitive: &'a Primitive,
    place: &'a str,
    budget: &'a Budget,
    vertices: usize,
    used: &'a [u32],
}

impl Optional<'_> {
    fn elements(&self, name: &str, kinds: &[&str]) -> Result<Option<Elements<'_>>, Fault> {
        let Some(&accessor) = self.primitive.attributes.get(name) else { return Ok(None) };
        let place = format!("{} {name}", self.place);
        let elements = self.buffers.elements(accessor, kinds, &place, self.budget)?;
        if elements.count < self.vertices {
            let what = format!("{} values for {} vertices", elements.count, self.vertices);
            return Err(Fault::malformed(format!("accessors[{accessor}] ({place})"), what));
        }
        Ok(Some(elements))
    }

    fn each<T>(&self, of: impl Fn(usize) -> T) -> Vec<T> {
        self.used.iter().map(|&v| of(v as usize)).collect()
    }

    fn normals(&self) -> Result<Vec<Vec3>, Fault> {
        let elements = self.elements("NORMAL", &["VEC3"])?;
        Ok(elements.map_or_else(Vec::new, |e| self.each(|v| Vec3::from_array(e.floats(v)))))
    }

    fn uvs(&self, texture: Option<&TextureInfo>) -> Result<Vec<Vec2>, Fault> {
        let transform = texture.and_then(|t| t.extensions.transform.as_ref());
        let set = transform.and_then(|t| t.tex_coord).or(texture.map(|t| t.tex_coord)).unwrap_or(0);
        let elements = self.elements(&format!("TEXCOORD_{set}"), &["VEC2"])?;
        Ok(elements.map_or_else(Vec::new, |e| {
            self.each(|v| {
                let uv = Vec2::from_array(e.floats(v));
                transform.map_or(uv, |t| transformed(t, uv))
            })
        }))
    }

    fn colors(&self) -> Result<Vec<[u8; 4]>, Fault> {
        let alpha =
            |accessor: &usize| self.buffers.document.accessors.get(*accessor).map(|a| a.kind == "VEC4");
        let has_alpha = self.primitive.attributes.get("COLOR_0").and_then(alpha).unwrap_or(false);
        let elements = self.elements("COLOR_0", &["VEC3", "VEC4"])?;
        Ok(elements.map_or_else(Vec::new, |e| {
            self.each(|v| {
                let [r, g, b] = e.floats::<3>(v).map(srgb_byte);
                let a = if has_alpha { e.floats::<4>(v)[3] } else { 1.0 };
                [r, g, b, (a.clamp(0.0, 1.0) * 255.0).round() as u8]
            })
        }))
    }
}

/// KHR_texture_transform: scale, then rotate, then offset.
fn transformed(t: &TextureTransform, uv: Vec2) -> Vec2 {
    let scaled = uv * Vec2::from_array(t.scale.unwrap_or([1.0, 1.0]));
    let (sin, cos) = t.rotation.sin_cos();
    Vec2::new(cos * scaled.x + sin * scaled.y, -sin * scaled.x + cos * scaled.y) + Vec2::from_array(t.offset)
}

/// glTF's vertex colours are linear (§3.7.2.1), ours sRGB: IEC 61966-2-1.
fn srgb_byte(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}
