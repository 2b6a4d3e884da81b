//! Reads accessors: every offset is checked against the bytes that are there before anything is read.

use std::borrow::Cow;

use super::json::{Accessor, Document};
use crate::assets::budget::Budget;
use crate::assets::error::{Fault, Problem};
use crate::assets::uri::Surroundings;

/// The document with the bytes of its buffers.
pub struct Buffers<'a> {
    pub document: &'a Document,
    /// One for each buffer; empty for those that are only a fallback of compressed data.
    bytes: Vec<Cow<'a, [u8]>>,
}

/// A checked run of elements of one accessor.
pub struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: Component,
    normalized: bool,
    pub count: usize,
    /// Index and element bytes, by rising index.
    replaced: Vec<(u32, &'a [u8])>,
}

/// glTF 2.0 §3.6.2.2.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(number: u32, place: &str) -> Result<Self, Fault> {
        Ok(match number {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            other => {
                return Err(Fault::malformed(place, format!("component type {other} is not one of glTF's")));
            }
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number that `bytes` start with; integers are brought to 0..1 or -1..1 when `normalized` (§3.11).
    fn read(self, bytes: &[u8], normalized: bool) -> f32 {
        let byte = |i: usize| bytes.get(i).copied().unwrap_or(0);
        let scaled = |value: f32, most: f32| if normalized { (value / most).max(-1.0) } else { value };
        match self {
            Self::I8 => scaled(f32::from(byte(0) as i8), 127.0),
            Self::U8 => scaled(f32::from(byte(0)), 255.0),
            Self::I16 => scaled(f32::from(i16::from_le_bytes([byte(0), byte(1)])), 32767.0),
            Self::U16 => scaled(f32::from(u16::from_le_bytes([byte(0), byte(1)])), 65535.0),
            Self::U32 => scaled(self.read_index(bytes) as f32, u32::MAX as f32),
            Self::F32 => f32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)]),
        }
    }

    fn read_index(self, bytes: &[u8]) -> u32 {
        let byte = |i: usize| u32::from(bytes.get(i).copied().unwrap_or(0));
        (0..self.size()).map(|i| byte(i) << (8 * i)).sum()
    }
}

impl Elements<'_> {
    fn element(&self, index: usize) -> &[u8] {
        if let Ok(at) = self.replaced.binary_search_by_key(&(index as u32), |(i, _)| *i) {
            return self.replaced[at].1;
        }
        self.bytes.get(index * self.stride..).unwrap_or(&[])
    }

    /// Element `index` as numbers; an accessor without bytes is all zeros (§3.6.2.3).
    pub fn floats<const N: usize>(&self, index: usize) -> [f32; N] {
        let bytes = self.element(index);
        let size = self.component.size();
        std::array::from_fn(|k| self.component.read(bytes.get(k * size..).unwrap_or(&[]), self.normalized))
    }

    /// Every element as an index; `None` when they are not whole numbers.
    pub fn indices(&self) -> Option<Vec<u32>> {
        let whole = matches!(self.component, Component::U8 | Component::U16 | Component::U32);
        whole.then(|| (0..self.count).map(|i| self.component.read_index(self.element(i))).collect())
    }
}

impl<'a> Buffers<'a> {
    /// Fetches every buffer: the GLB's own chunk, data URIs and files beside the document.
    pub fn load(document: &'a Document, bin: Option<&'a [u8]>, around: Surroundings) -> Result<Self, Fault> {
        around.budget.check_nodes("buffers", "buffers", document.buffers.len())?;
        let mut total = 0;
        let mut bytes = Vec::with_capacity(document.buffers.len());
        for (i, buffer) in document.buffers.iter().enumerate() {
            let place = format!("buffers[{i}]");
            let found = match (&buffer.uri, bin) {
                (Some(uri), _) => Cow::Owned(around.read_uri(&place, uri)?),
                (None, Some(bin)) if i == 0 => Cow::Borrowed(bin),
                (None, _) => Cow::Borrowed(&[][..]),
            };
            let there = found.len() as u64;
            let is_fallback = buffer.uri.is_none() && there == 0;
            if there < buffer.byte_length && !is_fallback {
                return Err(Fault::new(place, Problem::Truncated { needed: buffer.byte_length, there }));
            }
            total += there;
            around.budget.check_bytes(&place, total)?;
            bytes.push(found);
        }
        Ok(Self { document, bytes })
    }

    /// The bytes of a buffer view and its stride.
    pub fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), Fault> {
        let place = format!("bufferViews[{index}]");
        let views = &self.document.buffer_views;
        let view = views
            .get(index)
            .ok_or_else(|| Fault::out_of_range("bufferViews", "buffer view", index, views.len()))?;
        if let Some(name) = view.extensions.keys().find(|name| name.contains("meshopt")) {
            return Err(Fault::new(
                place,
                Problem::Unsupported {
                    feature: format!("meshopt compression ({name})"),
                    remedy: "Decompress it first, e.g. by importing it into Blender and exporting it again, or with \
                         `gltf-transform copy IN.glb OUT.glb`.",
                },
            ));
        }
        let buffer = self
            .bytes
            .get(view.buffer)
            .ok_or_else(|| Fault::out_of_range(&place, "buffer", view.buffer, self.bytes.len()))?;
        let end = view.byte_offset.saturating_add(view.byte_length);
        let there = buffer.len() as u64;
        if end > there {
            return Err(Fault::new(place, Problem::Truncated { needed: end, there }));
        }
        let stride = match view.byte_stride {
            Some(stride) if stride > 252 => {
                return Err(Fault::malformed(
                    place,
                    format!("a stride of {stride} bytes is above glTF's 252"),
                ));
            }
            stride => stride.map(|s| s as usize).filter(|s| *s > 0),
        };
        Ok((&buffer[view.byte_offset as usize..end as usize], stride))
    }

    /// Accessor `index`, checked to be one of `kinds` (`SCALAR`, `VEC2`, ...). `user` says who asks for it.
    pub fn elements(
        &self,
        index: usize,
        kinds: &[&str],
        user: &str,
        budget: &Budget,
    ) -> Result<Elements<'_>, Fault> {
        let accessors = &self.document.accessors;
        let accessor = accessors
            .get(index)
            .ok_or_else(|| Fault::out_of_range(user, "accessor", index, accessors.len()))?;
        let place = format!("accessors[{index}] ({user})");
        if !kinds.contains(&accessor.kind.as_str()) {
            let found = &accessor.kind;
            return Err(Fault::malformed(
                place,
                format!("its type is \"{found}\" where {} is due", kinds.join(" or ")),
            ));
        }
        let component = Component::of(accessor.component_type, &place)?;
        let components = match accessor.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let size = component.size() * components;
        let limit = if kinds.contains(&"SCALAR") {
            budget.max_triangles.saturating_mul(3)
        } else {
            budget.max_vertices
        };
        Budget::check(&place, "elements", accessor.count, limit as u64)?;
        let (bytes, stride) = self.run(accessor, size, &place)?;
        let replaced = self.replaced(accessor, size, &place)?;
        if bytes.is_empty() && replaced.is_empty() && accessor.count > 0 {
            return Err(Fault::malformed(
                place,
                format!("it promises {} elements but refers to no bytes", accessor.count),
            ));
        }
        Ok(Elements {
            bytes,
            stride,
            component,
            normalized: accessor.normalized,
            count: accessor.count as usize,
            replaced,
        })
    }

    /// The bytes from the accessor's first element on, and the step from one element to the next.
    fn run(&self, accessor: &Accessor, size: usize, place: &str) -> Result<(&[u8], usize), Fault> {
        let Some(view) = accessor.buffer_view else { return Ok((&[], size)) };
        let (bytes, stride) = self.view(view)?;
        let stride = stride.unwrap_or(size);
        Ok((slice(bytes, accessor.byte_offset, accessor.count, stride, size, place)?, stride))
    }

    fn replaced(&self, accessor: &Accessor, size: usize, place: &str) -> Result<Vec<(u32, &[u8])>, Fault> {
        let Some(sparse) = &accessor.sparse else { return Ok(Vec::new()) };
        let place = format!("{place}.sparse");
        Budget::check(&place, "replaced elements", sparse.count, accessor.count)?;
        let component = Component::of(sparse.indices.component_type, &place)?;
        let step = component.size();
        let (indices, _) = self.view(sparse.indices.buffer_view)?;
        let indices = slice(indices, sparse.indices.byte_offset, sparse.count, step, step, &place)?;
        let (values, _) = self.view(sparse.values.buffer_view)?;
        let values = slice(values, sparse.values.byte_offset, sparse.count, size, size, &place)?;
        let replaced: Vec<(u32, &[u8])> =
            indices.chunks(step).map(|i| component.read_index(i)).zip(values.chunks(size)).collect();
        if let Some((index, _)) = replaced.iter().find(|(i, _)| u64::from(*i) >= accessor.count) {
            return Err(Fault::out_of_range(place, "element", *index as usize, accessor.count as usize));
        }
        if !replaced.is_sorted_by(|a, b| a.0 < b.0) {
            return Err(Fault::malformed(place, "its indices do not rise"));
        }
        Ok(replaced)
    }
}

/// `count` elements of `size` bytes, `stride` apart, from `offset` on; refused when they don't fit `bytes`.
fn slice<'b>(
    bytes: &'b [u8],
    offset: u64,
    count: u64,
    stride: usize,
    size: usize,
    place: &str,
) -> Result<&'b [u8], Fault> {
    if count == 0 {
        return Ok(&[]);
    }
    let length = (count - 1).saturating_mul(stride as u64).saturating_add(size as u64);
    let needed = offset.saturating_add(length);
    let there = bytes.len() as u64;
    if needed > there {
        return Err(Fault::new(place, Problem::Truncated { needed, there }));
    }
    Ok(&bytes[offset as usize..needed as usize])
}
