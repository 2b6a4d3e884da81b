//! What every reader of 3-D files returns: named parts with meshes and materials, in the file's own frame.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

use crate::math::Aabb;

/// A triangle mesh in its own frame. `normals`, `uvs` and `colors` are empty or as long as `positions`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, origin top left as in glTF.
    pub uvs: Vec<Vec2>,
    /// sRGB vertex colours with alpha.
    pub colors: Vec<[u8; 4]>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The box around all vertices.
    pub fn bounds(&self) -> Aabb {
        Aabb::of(self.positions.iter().copied())
    }

    /// Corners of triangle `index`.
    pub fn corners(&self, index: usize) -> [Vec3; 3] {
        self.triangles[index].map(|v| self.positions[v as usize])
    }
}

/// How alpha is meant (glTF 2.0 §3.9.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Below the cutoff nothing is drawn.
    Mask(f32),
    /// Blended over what lies behind.
    Blend,
}

/// A surface's look; the subset of glTF's metallic-roughness model that the viewport draws.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file, empty if none.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    /// Index into [`Model::textures`], sRGB.
    pub base_color_texture: Option<usize>,
    /// 0 dielectric to 1 metal.
    pub metallic: f32,
    /// 0 mirror to 1 chalk.
    pub roughness: f32,
    /// Linear RGB light given off.
    pub emissive: [f32; 3],
    /// Whether both sides are meant to be seen.
    pub double_sided: bool,
    /// How alpha is meant.
    pub alpha: AlphaMode,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [0.8, 0.8, 0.8, 1.0],
            base_color_texture: None,
            metallic: 0.0,
            roughness: 0.8,
            emissive: [0.0; 3],
            double_sided: true,
            alpha: AlphaMode::Opaque,
        }
    }
}

/// A picture's file as it was read, kept so that writing it again loses nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageFile {
    /// `image/png` or `image/jpeg`, the two that glTF allows.
    pub mime: &'static str,
    /// The file's bytes.
    pub bytes: Arc<[u8]>,
}

/// A decoded picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texture {
    /// Name in the file, empty if none.
    pub name: String,
    /// Columns.
    pub width: u32,
    /// Rows, the top one first.
    pub height: u32,
    /// sRGB with straight alpha, `width * height * 4` bytes.
    pub rgba: Vec<u8>,
    /// The file it was decoded from, if that was a PNG or JPEG.
    pub file: Option<ImageFile>,
}

/// A mesh with one material, placed. Parts of one node share `node`.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name of the node (or OBJ group) that holds it.
    pub name: String,
    /// Number of the node that holds it: parts with the same number are one object.
    pub node: usize,
    /// Names of the nodes above, the outermost first.
    pub path: Vec<String>,
    /// The mesh, in its own frame; shared between instances.
    pub mesh: Arc<Mesh>,
    /// Index into [`Model::materials`].
    pub material: usize,
    /// From the mesh's frame to the file's frame; may mirror or scale.
    pub file_from_mesh: Affine3A,
    /// The node's `extras` as JSON text, if it has any.
    pub extras: Option<String>,
}

/// A file's content, checked: every index is in range and every number finite.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Name of the file without folder.
    pub name: String,
    /// Placed meshes.
    pub parts: Vec<Part>,
    /// Materials; never empty when there are parts.
    pub materials: Vec<Material>,
    /// Decoded pictures.
    pub textures: Vec<Arc<Texture>>,
    /// What was dropped, mended or ignored while reading, in words for the user.
    pub notes: Vec<String>,
}

impl Model {
    /// Triangles over all parts.
    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|p| p.mesh.triangles.len()).sum()
    }

    /// The box around everything, in the file's frame.
    pub fn bounds(&self) -> Aabb {
        Aabb::of(
            self.parts.iter().flat_map(|part| {
                part.mesh.positions.iter().map(|p| part.file_from_mesh.transform_point3(*p))
            }),
        )
    }
}
