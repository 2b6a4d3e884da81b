//! Reads PLY (Turk 1994): ascii and binary of both byte orders, polygons of any size, triangle strips,
//! vertex normals, colours and texture coordinates. Unknown elements and properties are skipped.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

use super::error::{Fault, Problem};
use super::mend::mended;
use super::model::{Material, Mesh, Model, Part};
use super::picture::{EncodedPicture, decode_all};
use super::triangulate::triangulated;
use super::uri::Surroundings;

/// Longer headers are no headers.
const MAX_HEADER_BYTES: usize = 1 << 16;

/// Corners of one face; a longer list is damage.
const MAX_CORNERS: usize = 1 << 16;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// The number in the first bytes of `bytes`, which hold at least [`Number::size`].
    fn decode(self, bytes: &[u8], big: bool) -> f64 {
        let mut raw = [0u8; 8];
        let size = self.size();
        for (i, byte) in bytes.iter().take(size).enumerate() {
            raw[if big { size - 1 - i } else { i }] = *byte;
        }
        let bits = u64::from_le_bytes(raw);
        match self {
            Self::I8 => f64::from(bits as i8),
            Self::U8 | Self::U16 | Self::U32 => bits as f64,
            Self::I16 => f64::from(bits as i16),
            Self::I32 => f64::from(bits as i32),
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}

#[derive(Clone, Debug)]
struct Property {
    name: String,
    value: Number,
    /// The type of the length when it is a list.
    length: Option<Number>,
}

#[derive(Clone, Debug)]
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

#[derive(Debug)]
struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    texture: Option<String>,
    /// Bytes of the header.
    length: usize,
}

/// Reads a PLY file.
pub(super) fn read(bytes: &[u8], around: Surroundings) -> Result<Model, Fault> {
    let header = header(bytes)?;
    let mut body = Body { bytes, at: header.length, encoding: header.encoding };
    let mut raw = Raw::default();
    for element in &header.elements {
        let place = format!("element {}", element.name);
        body.check_count(element, &place)?;
        match element.name.as_str() {
            "vertex" => {
                around.budget.check_vertices(&place, element.count as usize)?;
                raw.read_vertices(&mut body, element)?;
            }
            "face" | "tristrips" | "triangle" => raw.read_faces(&mut body, element, around)?,
            _ => body.skip(element)?,
        }
    }
    raw.into_model(header.texture, around)
}

fn header(bytes: &[u8]) -> Result<Header, Fault> {
    if !bytes.starts_with(b"ply") {
        return Err(Fault::malformed("line 1", "a PLY file starts with \"ply\""));
    }
    let mut header = Header { encoding: Encoding::Ascii, elements: Vec::new(), texture: None, length: 0 };
    let mut has_format = false;
    for (number, line) in
        bytes[..bytes.len().min(MAX_HEADER_BYTES)].split_inclusive(|&b| b == b'\n').enumerate()
    {
        header.length += line.len();
        let line = String::from_utf8_lossy(line);
        let words: Vec<&str> = line.split_whitespace().collect();
        let place = || format!("line {}", number + 1);
        match words[..] {
            ["format", encoding, ..] => {
                has_format = true;
                header.encoding = match encoding {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => {
                        return Err(Fault::malformed(
                            place(),
                            format!("\"{encoding}\" is not one of PLY's formats"),
                        ));
                    }
                };
            }
            ["comment", "TextureFile", ..] => {
                header.texture = line.split_once("TextureFile").map(|(_, name)| name.trim().to_string());
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| {
                    Fault::malformed(place(), format!("\"{count}\" is not a number of {name} elements"))
                })?;
                header.elements.push(Element { name: name.to_string(), count, properties: Vec::new() });
            }
            ["property", ref rest @ ..] => {
                let property =
                    property(rest).ok_or_else(|| Fault::malformed(place(), "not a PLY property"))?;
                let element = header.elements.last_mut();
                element
                    .ok_or_else(|| Fault::malformed(place(), "a property before any element"))?
                    .properties
                    .push(property);
            }
            ["end_header"] if has_format => return Ok(header),
            ["end_header"] => return Err(Fault::malformed(place(), "the header names no format")),
            _ => {}
        }
    }
    Err(Fault::malformed("the header", "there is no end_header"))
}

fn property(words: &[&str]) -> Option<Property> {
    match words {
        ["list", length, value, name] => {
            let length = Number::of(length).filter(|l| l.is_whole())?;
            Some(Property { name: name.to_string(), value: Number::of(value)?, length: Some(length) })
        }
        [value, name] => Some(Property { name: name.to_string(), value: Number::of(value)?, length: None }),
        _ => None,
    }
}

/// The bytes behind the header and how far they have been read.
struct Body<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl Body<'_> {
    /// Refuses a count that the bytes left can't hold.
    fn check_count(&self, element: &Element, place: &str) -> Result<(), Fault> {
        let smallest = |p: &Property| match self.encoding {
            // A digit and a space each.
            Encoding::Ascii => 2,
            _ => p.length.unwrap_or(p.value).size() as u64,
        };
        let each: u64 = element.properties.iter().map(smallest).sum();
        // The last number of an ascii file needs no space behind it.
        let needed =
            element.count.saturating_mul(each).saturating_sub(u64::from(self.encoding == Encoding::Ascii));
        let there = self.bytes.len().saturating_sub(self.at) as u64;
        if each == 0 && element.count > 0 {
            return Err(Fault::malformed(place, "it has elements but no properties"));
        }
        if needed > there {
            return Err(Fault::new(place, Problem::Truncated { needed, there }));
        }
        Ok(())
    }

    fn number(&mut self, kind: Number) -> Result<f64, Fault> {
        let value = match self.encoding {
            Encoding::Ascii => self.word()?,
            Encoding::Little | Encoding::Big => {
                let bytes = self
                    .bytes
                    .get(self.at..self.at + kind.size())
                    .ok_or_else(|| self.cut_off(kind.size()))?;
                self.at += kind.size();
                kind.decode(bytes, self.encoding == Encoding::Big)
            }
        };
        Ok(value)
    }

    fn word(&mut self) -> Result<f64, Fault> {
        let left = self.bytes.get(self.at..).unwrap_or(&[]);
        let start = left.iter().position(|b| !b.is_ascii_whitespace()).ok_or_else(|| self.cut_off(1))?;
        let length = left[start..].iter().position(u8::is_ascii_whitespace).unwrap_or(left.len() - start);
        let word = &left[start..start + length];
        let place = self.at + start;
        self.at = place + length;
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        number.ok_or_else(|| {
            let shown = String::from_utf8_lossy(word.get(..40).unwrap_or(word)).into_owned();
            Fault::malformed(format!("byte {place}"), format!("\"{shown}\" is not a number"))
        })
    }

    fn cut_off(&self, more: usize) -> Fault {
        let there = self.bytes.len() as u64;
        Fault::new(format!("byte {}", self.at), Problem::Truncated { needed: (self.at + more) as u64, there })
    }

    /// Reads a list into `values`.
    fn list(&mut self, length: Number, value: Number, values: &mut Vec<f64>) -> Result<(), Fault> {
        let place = self.at;
        let count = self.number(length)?;
        if !(0.0..=MAX_CORNERS as f64).contains(&count) && !self.holds(count, value) {
            return Err(Fault::malformed(format!("byte {place}"), format!("a list of {count} numbers")));
        }
        values.clear();
        for _ in 0..count as usize {
            values.push(self.number(value)?);
        }
        Ok(())
    }

    /// Whether the bytes left hold `count` numbers: a triangle strip may be longer than any face.
    fn holds(&self, count: f64, value: Number) -> bool {
        let each = if self.encoding == Encoding::Ascii { 2 } else { value.size() };
        count >= 0.0 && count * each as f64 <= self.bytes.len().saturating_sub(self.at) as f64 + 1.0
    }

    fn skip(&mut self, element: &Element) -> Result<(), Fault> {
        let mut values = Vec::new();
        for _ in 0..element.count {
            for p in &element.properties {
                match p.length {
                    Some(length) => self.list(length, p.value, &mut values)?,
                    None => drop(self.number(p.value)?),
                }
            }
        }
        Ok(())
    }
}

/// What a property of a vertex is for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Role {
    Position(usize),
    Normal(usize),
    Color(usize),
    Uv(usize),
}

impl Role {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "x" => Self::Position(0),
            "y" => Self::Position(1),
            "z" => Self::Position(2),
            "nx" => Self::Normal(0),
            "ny" => Self::Normal(1),
            "nz" => Self::Normal(2),
            "red" | "r" | "diffuse_red" => Self::Color(0),
            "green" | "g" | "diffuse_green" => Self::Color(1),
            "blue" | "b" | "diffuse_blue" => Self::Color(2),
            "alpha" | "a" | "diffuse_alpha" => Self::Color(3),
            "u" | "s" | "texture_u" => Self::Uv(0),
            "v" | "t" | "texture_v" => Self::Uv(1),
            _ => return None,
        })
    }
}

/// The content as the file has it.
#[derive(Default)]
struct Raw {
    mesh: Mesh,
    /// Texture coordinates of every corner of every triangle, where faces have their own.
    corner_uvs: Vec<[Vec2; 3]>,
}

impl Raw {
    fn read_vertices(&mut self, body: &mut Body, element: &Element) -> Result<(), Fault> {
        let roles: Vec<Option<Role>> = element.properties.iter().map(|p| Role::of(&p.name)).collect();
        let has = |role: Role| roles.contains(&Some(role));
        if !(0..3).all(|axis| has(Role::Position(axis))) {
            return Err(Fault::malformed("element vertex", "it lacks x, y or z"));
        }
        let (normals, colors, uvs) = (has(Role::Normal(2)), has(Role::Color(0)), has(Role::Uv(0)));
        let mut unused = Vec::new();
        for _ in 0..element.count {
            let (mut position, mut normal, mut uv) = ([0.0; 3], [0.0; 3], [0.0; 2]);
            let mut color = [255; 4];
            for (p, role) in element.properties.iter().zip(&roles) {
                if let Some(length) = p.length {
                    body.list(length, p.value, &mut unused)?;
                    continue;
                }
                let value = body.number(p.value)?;
                match role {
                    Some(Role::Position(axis)) => position[*axis] = value as f32,
                    Some(Role::Normal(axis)) => normal[*axis] = value as f32,
                    Some(Role::Uv(axis)) => uv[*axis] = value as f32,
                    Some(Role::Color(channel)) => color[*channel] = color_byte(value, p.value),
                    None => {}
                }
            }
            self.mesh.positions.push(Vec3::from_array(position));
            if normals {
                self.mesh.normals.push(Vec3::from_array(normal));
            }
            if colors {
                self.mesh.colors.push(color);
            }
            if uvs {
                self.mesh.uvs.push(Vec2::new(uv[0], 1.0 - uv[1]));
            }
        }
        Ok(())
    }

    fn read_faces(&mut self, body: &mut Body, element: &Element, around: Surroundings) -> Result<(), Fault> {
        let (mut corners, mut uvs, mut unused) = (Vec::new(), Vec::new(), Vec::new());
        for face in 0..element.count {
            let place = || format!("{} {face}", element.name);
            for p in &element.properties {
                match (p.length, p.name.as_str()) {
                    (Some(length), "vertex_indices" | "vertex_index") => {
                        body.list(length, p.value, &mut corners)?;
                    }
                    (Some(length), "texcoord") => body.list(length, p.value, &mut uvs)?,
                    (Some(length), _) => body.list(length, p.value, &mut unused)?,
                    (None, _) => drop(body.number(p.value)?),
                }
            }
            match element.name.as_str() {
                "tristrips" => self.strips(&corners, &place)?,
                _ => self.face(&corners, &uvs, &place)?,
            }
            around.budget.check_triangles(&place(), self.mesh.triangles.len())?;
        }
        Ok(())
    }

    fn vertex(&self, number: f64, place: &impl Fn() -> String) -> Result<u32, Fault> {
        let count = self.mesh.positions.len();
        if number >= 0.0 && number < count as f64 {
            return Ok(number as u32);
        }
        Err(Fault::out_of_range(place(), "vertex", number.abs() as usize, count))
    }

    fn face(&mut self, corners: &[f64], uvs: &[f64], place: &impl Fn() -> String) -> Result<(), Fault> {
        let vertices: Vec<u32> = corners.iter().map(|n| self.vertex(*n, place)).collect::<Result<_, _>>()?;
        let own_uvs = uvs.len() == 2 * vertices.len() && !uvs.is_empty();
        let uv = |k: usize| {
            if own_uvs { Vec2::new(uvs[2 * k] as f32, 1.0 - uvs[2 * k + 1] as f32) } else { Vec2::ZERO }
        };
        let triangles = if vertices.len() == 3 {
            vec![[0, 1, 2]]
        } else {
            let at: Vec<Vec3> = vertices.iter().map(|&v| self.mesh.positions[v as usize]).collect();
            triangulated(&at)
        };
        for triangle in triangles {
            self.mesh.triangles.push(triangle.map(|k| vertices[k]));
            if own_uvs || !self.corner_uvs.is_empty() {
                self.corner_uvs.resize(self.mesh.triangles.len() - 1, [Vec2::ZERO; 3]);
                self.corner_uvs.push(triangle.map(uv));
            }
        }
        Ok(())
    }

    /// Strips, each ended by -1 (Stanford's scans).
    fn strips(&mut self, corners: &[f64], place: &impl Fn() -> String) -> Result<(), Fault> {
        for strip in corners.split(|&n| n < 0.0) {
            let vertices: Vec<u32> =
                strip.iter().map(|n| self.vertex(*n, place)).collect::<Result<_, _>>()?;
            for (i, w) in vertices.windows(3).enumerate() {
                self.mesh.triangles.push(if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] });
            }
        }
        Ok(())
    }

    fn into_model(mut self, texture: Option<String>, around: Surroundings) -> Result<Model, Fault> {
        if self.mesh.triangles.is_empty() && !self.mesh.positions.is_empty() {
            let remedy = "It is a cloud of points: make a mesh of it first, for example with MeshLab's screened \
                          Poisson reconstruction.";
            return Err(Fault::new("element face", Problem::Empty(remedy)));
        }
        if !self.corner_uvs.is_empty() {
            self.corner_uvs.resize(self.mesh.triangles.len(), [Vec2::ZERO; 3]);
            self.mesh = with_corner_uvs(&self.mesh, &self.corner_uvs);
        }
        let mut model = Model { materials: vec![Material::default()], ..Model::default() };
        if !self.mesh.colors.is_empty() || texture.is_some() {
            model.materials[0].base_color = [1.0; 4];
        }
        if let Some(name) = texture.filter(|_| !self.mesh.uvs.is_empty()) {
            add_texture(&name, around, &mut model)?;
        }
        let (mesh, dropped) = mended(self.mesh);
        model.notes.extend(dropped.notes());
        model.parts.push(Part {
            name: String::new(),
            node: 0,
            path: Vec::new(),
            mesh: Arc::new(mesh),
            material: 0,
            file_from_mesh: Affine3A::IDENTITY,
            extras: None,
        });
        Ok(model)
    }
}

fn color_byte(value: f64, kind: Number) -> u8 {
    let full = match kind {
        Number::F32 | Number::F64 => 1.0,
        Number::U16 => 65535.0,
        _ => 255.0,
    };
    (value / full * 255.0).round().clamp(0.0, 255.0) as u8
}

/// One vertex for each corner, with its own texture coordinate.
fn with_corner_uvs(mesh: &Mesh, corner_uvs: &[[Vec2; 3]]) -> Mesh {
    fn each<T: Copy>(mesh: &Mesh, of: &[T]) -> Vec<T> {
        if of.is_empty() {
            Vec::new()
        } else {
            mesh.triangles.iter().flatten().map(|&v| of[v as usize]).collect()
        }
    }
    Mesh {
        positions: each(mesh, &mesh.positions),
        normals: each(mesh, &mesh.normals),
        uvs: corner_uvs.iter().flatten().copied().collect(),
        colors: each(mesh, &mesh.colors),
        triangles: (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    }
}

fn add_texture(name: &str, around: Surroundings, model: &mut Model) -> Result<(), Fault> {
    let place = format!("comment TextureFile {name}");
    let bytes = match around.read_file(&place, name) {
        Ok(bytes) => bytes,
        Err(fault) => {
            model.notes.push(format!("{}: left out, {}", fault.place, fault.problem));
            return Ok(());
        }
    };
    match decode_all(&[EncodedPicture { name: name.to_string(), place, bytes }], around.budget)?.pop() {
        Some(Ok(texture)) => {
            model.textures.push(texture);
            model.materials[0].base_color_texture = Some(0);
        }
        Some(Err(note)) => model.notes.push(note),
        None => {}
    }
    Ok(())
}
