//! The binary chunk while it grows, and the file around both chunks (glTF 2.0 §4.4).

use bytemuck::NoUninit;
use glam::{Vec2, Vec3};

use super::GlbWriteError;
use super::json::{
    ARRAY_BUFFER, Accessor, Attributes, Buffer, BufferView, ELEMENT_ARRAY_BUFFER, FLOAT, Root, UNSIGNED_INT,
    UNSIGNED_SHORT,
};
use crate::assets::Mesh;
use crate::math::Aabb;

/// How the numbers of an accessor are stored.
#[derive(Clone, Copy)]
pub struct Layout {
    pub component_type: u32,
    pub kind: &'static str,
    pub normalized: bool,
    pub target: Option<u32>,
}

impl Layout {
    /// Vertex data of 32-bit floats.
    pub const fn floats(kind: &'static str) -> Self {
        Self { component_type: FLOAT, kind, normalized: false, target: Some(ARRAY_BUFFER) }
    }
}

/// A file under construction: the JSON and the bytes that it points into.
#[derive(Default)]
pub struct GlbBuilder {
    pub root: Root,
    bytes: Vec<u8>,
}

impl GlbBuilder {
    /// Appends `bytes` at the next multiple of four; returns the buffer view's number.
    pub fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = BufferView { buffer: 0, byte_offset: self.bytes.len(), byte_length: bytes.len(), target };
        self.bytes.extend_from_slice(bytes);
        self.root.buffer_views.push(view);
        self.root.buffer_views.len() - 1
    }

    /// Appends an array of elements of `layout`; returns the accessor's number.
    pub fn array<T: NoUninit>(&mut self, elements: &[T], layout: Layout) -> usize {
        let buffer_view = self.view(bytemuck::cast_slice(elements), layout.target);
        self.root.accessors.push(Accessor {
            buffer_view,
            component_type: layout.component_type,
            normalized: layout.normalized,
            count: elements.len(),
            kind: layout.kind,
            min: None,
            max: None,
        });
        self.root.accessors.len() - 1
    }

    /// Appends positions with the bounds that glTF demands of them.
    fn positions(&mut self, positions: &[Vec3]) -> usize {
        let accessor = self.array(positions, Layout::floats("VEC3"));
        let bounds = Aabb::of(positions.iter().copied());
        self.root.accessors[accessor].min = Some(bounds.min.to_array().to_vec());
        self.root.accessors[accessor].max = Some(bounds.max.to_array().to_vec());
        accessor
    }

    /// Appends the times of key frames in ascending order, with the bounds that glTF demands of them.
    pub fn times(&mut self, seconds: &[f32]) -> usize {
        let accessor = self.array(seconds, Layout { target: None, ..Layout::floats("SCALAR") });
        self.root.accessors[accessor].min = seconds.first().map(|first| vec![*first]);
        self.root.accessors[accessor].max = seconds.last().map(|last| vec![*last]);
        accessor
    }

    /// Appends triangles with the narrowest indices that reach every one of `vertices`.
    fn triangles(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        let layout = |component_type| Layout {
            component_type,
            kind: "SCALAR",
            normalized: false,
            target: Some(ELEMENT_ARRAY_BUFFER),
        };
        // 65535 itself is the primitive restart value, which glTF forbids as an index.
        if vertices <= usize::from(u16::MAX) {
            let narrow: Vec<u16> = triangles.as_flattened().iter().map(|v| *v as u16).collect();
            self.array(&narrow, layout(UNSIGNED_SHORT))
        } else {
            self.array(triangles.as_flattened(), layout(UNSIGNED_INT))
        }
    }

    /// Appends a checked mesh: the accessors of its vertices and of its triangles.
    pub fn mesh(&mut self, name: &str, mesh: &Mesh) -> Result<(Attributes, usize), GlbWriteError> {
        check_mesh(name, mesh)?;
        let attributes = Attributes {
            position: self.positions(&mesh.positions),
            normal: (!mesh.normals.is_empty()).then(|| self.array(&mesh.normals, Layout::floats("VEC3"))),
            texcoord: (!mesh.uvs.is_empty()).then(|| self.array(&mesh.uvs, Layout::floats("VEC2"))),
            color: (!mesh.colors.is_empty()).then(|| self.colors(&mesh.colors)),
            ..Attributes::default()
        };
        Ok((attributes, self.triangles(&mesh.triangles, mesh.positions.len())))
    }

    /// Appends vertex colours. glTF means linear light, so 16 bits keep every 8-bit sRGB value apart.
    fn colors(&mut self, srgb: &[[u8; 4]]) -> usize {
        let wide: Vec<[u16; 4]> = srgb
            .iter()
            .map(|c| std::array::from_fn(|k| if k < 3 { linear_u16(c[k]) } else { u16::from(c[k]) * 257 }))
            .collect();
        let layout = Layout {
            component_type: UNSIGNED_SHORT,
            kind: "VEC4",
            normalized: true,
            target: Some(ARRAY_BUFFER),
        };
        self.array(&wide, layout)
    }

    /// The finished file: header, JSON chunk padded by spaces, binary chunk padded by zeros.
    pub fn finish(mut self) -> Result<Vec<u8>, GlbWriteError> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        if !self.bytes.is_empty() {
            self.root.buffers = vec![Buffer { byte_length: self.bytes.len() }];
        }
        let mut json = serde_json::to_vec(&self.root)?;
        json.resize(json.len().next_multiple_of(4), b' ');
        let binary_chunk = if self.bytes.is_empty() { 0 } else { 8 + self.bytes.len() };
        let total = 20 + json.len() + binary_chunk;
        let length = u32::try_from(total).map_err(|_| GlbWriteError::TooLarge { bytes: total })?;
        let mut file = Vec::with_capacity(total);
        for word in [u32::from_le_bytes(*b"glTF"), 2, length] {
            file.extend_from_slice(&word.to_le_bytes());
        }
        chunk(&mut file, *b"JSON", &json);
        if binary_chunk > 0 {
            chunk(&mut file, *b"BIN\0", &self.bytes);
        }
        Ok(file)
    }
}

/// Appends one chunk; its length fits because the whole file's does.
fn chunk(file: &mut Vec<u8>, kind: [u8; 4], content: &[u8]) {
    file.extend_from_slice(&(content.len() as u32).to_le_bytes());
    file.extend_from_slice(&kind);
    file.extend_from_slice(content);
}

/// An sRGB byte as linear light in 16 bits (IEC 61966-2-1).
fn linear_u16(srgb: u8) -> u16 {
    let c = f64::from(srgb) / 255.0;
    let linear = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    (linear * 65535.0).round() as u16
}

fn check_mesh(name: &str, mesh: &Mesh) -> Result<(), GlbWriteError> {
    let count = mesh.positions.len();
    for (array, found) in
        [("normals", mesh.normals.len()), ("uvs", mesh.uvs.len()), ("colors", mesh.colors.len())]
    {
        if found != 0 && found != count {
            return Err(GlbWriteError::Length { what: name.into(), array, found, expected: count });
        }
    }
    if let Some(bad) = mesh.triangles.as_flattened().iter().find(|v| **v as usize >= count) {
        let index = *bad as usize;
        return Err(GlbWriteError::OutOfRange { what: name.into(), array: "vertex", index, count });
    }
    let not_finite = |array| Err(GlbWriteError::NotFinite { what: name.into(), array });
    match mesh {
        _ if !mesh.positions.iter().all(|v| v.is_finite()) => not_finite("positions"),
        _ if !mesh.normals.iter().all(|v| v.is_finite()) => not_finite("normals"),
        _ if !mesh.uvs.iter().copied().all(Vec2::is_finite) => not_finite("uvs"),
        _ => Ok(()),
    }
}
