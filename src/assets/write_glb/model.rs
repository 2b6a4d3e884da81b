use std::collections::HashMap;
use std::sync::Arc;

use glam::Affine3A;

use super::GlbWriteError;
use super::buffer::GlbBuilder;
use super::json;
use crate::assets::{AlphaMode, Material, Mesh, Model, Part, Texture, encode_png};

/// Writes `model` as GLB: one root node per object (parts of one [`Part::node`]), named, with its extras.
///
/// Parts of an object that share a transform become one mesh with several primitives; otherwise the object's
/// node gets a child per transform. Transforms are matrices and read back bit for bit. The names above a node
/// ([`Part::path`]) are not written. Errors name the part.
pub fn glb_from_model(model: &Model) -> Result<Vec<u8>, GlbWriteError> {
    let (mut builder, nodes) = begin_with_model(model)?;
    builder.root.scenes.push(json::Scene { name: model.name.clone(), nodes });
    builder.finish()
}

/// A file that has `model` in it and no scene yet, and the model's root nodes.
pub(super) fn begin_with_model(model: &Model) -> Result<(GlbBuilder, Vec<usize>), GlbWriteError> {
    let mut writer = ModelWriter {
        model,
        builder: GlbBuilder::default(),
        vertices: HashMap::new(),
        meshes: HashMap::new(),
    };
    writer.textures()?;
    writer.materials()?;
    let mut roots = Vec::new();
    for parts in objects(model) {
        roots.push(writer.object(&parts)?);
    }
    Ok((writer.builder, roots))
}

/// Parts by node, in the order in which the nodes first appear.
fn objects(model: &Model) -> Vec<Vec<&Part>> {
    let mut slots = HashMap::new();
    let mut objects: Vec<Vec<&Part>> = Vec::new();
    for part in &model.parts {
        let slot = *slots.entry(part.node).or_insert_with(|| {
            objects.push(Vec::new());
            objects.len() - 1
        });
        objects[slot].push(part);
    }
    objects
}

/// Names a mesh while the model is borrowed: the address of its shared value.
type MeshKey = *const Mesh;

struct ModelWriter<'a> {
    model: &'a Model,
    builder: GlbBuilder,
    vertices: HashMap<MeshKey, (json::Attributes, usize)>,
    meshes: HashMap<Vec<(MeshKey, usize)>, usize>,
}

impl ModelWriter<'_> {
    fn textures(&mut self) -> Result<(), GlbWriteError> {
        for texture in &self.model.textures {
            let image = image(&mut self.builder, texture)?;
            let root = &mut self.builder.root;
            root.textures.push(json::Texture { sampler: 0, source: image });
        }
        if !self.model.textures.is_empty() {
            let sampler = json::Sampler { mag_filter: json::LINEAR, min_filter: json::LINEAR_MIPMAP_LINEAR };
            self.builder.root.samplers.push(sampler);
        }
        Ok(())
    }

    fn materials(&mut self) -> Result<(), GlbWriteError> {
        let count = self.model.textures.len();
        for material in &self.model.materials {
            if let Some(index) = material.base_color_texture.filter(|index| *index >= count) {
                let what = material.name.clone();
                return Err(GlbWriteError::OutOfRange { what, array: "texture", index, count });
            }
            self.builder.root.materials.push(material_json(material));
        }
        Ok(())
    }

    /// Writes one object; returns its root node.
    fn object(&mut self, parts: &[&Part]) -> Result<usize, GlbWriteError> {
        let first = parts[0];
        let extras = first.extras.as_deref().map(serde_json::from_str).transpose();
        let extras = extras.map_err(|source| GlbWriteError::Extras { what: first.name.clone(), source })?;
        let placed = by_transform(parts);
        if let [(file_from_mesh, parts)] = placed.as_slice() {
            return self.placed(&first.name, *file_from_mesh, parts, extras);
        }
        let mut children = Vec::new();
        for (index, (file_from_mesh, parts)) in placed.iter().enumerate() {
            let name = format!("{}.{index}", first.name);
            children.push(self.placed(&name, *file_from_mesh, parts, extras.clone())?);
        }
        Ok(self.node(json::Node { name: first.name.clone(), children, extras, ..json::Node::default() }))
    }

    /// Writes parts that share a transform as one node with one mesh.
    fn placed(
        &mut self,
        name: &str,
        file_from_mesh: Affine3A,
        parts: &[&Part],
        extras: Option<serde_json::Value>,
    ) -> Result<usize, GlbWriteError> {
        if !file_from_mesh.is_finite() {
            return Err(GlbWriteError::NotFinite { what: name.into(), array: "transform" });
        }
        let mesh = self.mesh(parts)?;
        let matrix = (file_from_mesh != Affine3A::IDENTITY).then(|| matrix(&file_from_mesh));
        Ok(self.node(json::Node { name: name.into(), mesh, matrix, extras, ..json::Node::default() }))
    }

    /// The mesh of these parts, written once for all places that share it; `None` if it has no triangle.
    fn mesh(&mut self, parts: &[&Part]) -> Result<Option<usize>, GlbWriteError> {
        let parts: Vec<&Part> = parts.iter().copied().filter(|p| !p.mesh.triangles.is_empty()).collect();
        let key: Vec<(MeshKey, usize)> = parts.iter().map(|p| (Arc::as_ptr(&p.mesh), p.material)).collect();
        if parts.is_empty() || self.meshes.contains_key(&key) {
            return Ok(self.meshes.get(&key).copied());
        }
        let mut primitives = Vec::new();
        for part in parts {
            primitives.push(self.primitive(part)?);
        }
        self.builder.root.meshes.push(json::Mesh { name: String::new(), primitives });
        let mesh = self.builder.root.meshes.len() - 1;
        self.meshes.insert(key, mesh);
        Ok(Some(mesh))
    }

    fn primitive(&mut self, part: &Part) -> Result<json::Primitive, GlbWriteError> {
        let count = self.model.materials.len();
        if part.material >= count {
            let (what, index) = (part.name.clone(), part.material);
            return Err(GlbWriteError::OutOfRange { what, array: "material", index, count });
        }
        let key = Arc::as_ptr(&part.mesh);
        let (attributes, indices) = match self.vertices.get(&key) {
            Some(written) => *written,
            None => self.builder.mesh(&part.name, &part.mesh)?,
        };
        self.vertices.insert(key, (attributes, indices));
        Ok(json::Primitive { attributes, indices, material: part.material })
    }

    fn node(&mut self, node: json::Node) -> usize {
        self.builder.root.nodes.push(node);
        self.builder.root.nodes.len() - 1
    }
}

/// Parts of one object by their transform, in order of appearance.
fn by_transform<'a>(parts: &[&'a Part]) -> Vec<(Affine3A, Vec<&'a Part>)> {
    let mut placed: Vec<(Affine3A, Vec<&Part>)> = Vec::new();
    for part in parts {
        match placed.iter_mut().find(|(transform, _)| *transform == part.file_from_mesh) {
            Some((_, same)) => same.push(part),
            None => placed.push((part.file_from_mesh, vec![part])),
        }
    }
    placed
}

/// Column-major 4x4 as glTF wants it.
fn matrix(file_from_mesh: &Affine3A) -> [f32; 16] {
    glam::Mat4::from(*file_from_mesh).to_cols_array()
}

/// Writes a picture: its own file where it has one, else a PNG. Returns the image's number.
fn image(builder: &mut GlbBuilder, texture: &Texture) -> Result<usize, GlbWriteError> {
    let expected = texture.width as usize * texture.height as usize * 4;
    let (what, found) = (texture.name.clone(), texture.rgba.len());
    if texture.file.is_none() && found != expected {
        return Err(GlbWriteError::Length { what, array: "bytes of colour", found, expected });
    }
    let (mime_type, buffer_view) = match &texture.file {
        Some(file) => (file.mime, builder.view(&file.bytes, None)),
        None => {
            let png = encode_png(texture.width, texture.height, &texture.rgba)
                .map_err(|source| GlbWriteError::Picture { what, source })?;
            ("image/png", builder.view(&png, None))
        }
    };
    builder.root.images.push(json::Image { name: texture.name.clone(), mime_type, buffer_view });
    Ok(builder.root.images.len() - 1)
}

fn material_json(material: &Material) -> json::Material {
    let (alpha_mode, alpha_cutoff) = match material.alpha {
        AlphaMode::Opaque => (None, None),
        AlphaMode::Mask(cutoff) => (Some("MASK"), Some(cutoff)),
        AlphaMode::Blend => (Some("BLEND"), None),
    };
    let unit = |c: f32| c.clamp(0.0, 1.0);
    json::Material {
        name: material.name.clone(),
        pbr_metallic_roughness: json::Pbr {
            base_color_factor: material.base_color.map(unit),
            base_color_texture: material.base_color_texture.map(|index| json::TextureRef { index }),
            metallic_factor: unit(material.metallic),
            roughness_factor: unit(material.roughness),
        },
        emissive_factor: (material.emissive != [0.0; 3]).then(|| material.emissive.map(unit)),
        alpha_mode,
        alpha_cutoff,
        double_sided: material.double_sided,
    }
}
