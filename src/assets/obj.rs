//! Reads Wavefront OBJ with MTL. Its own reader: errors name the line, materials that no MTL defines keep
//! their names, and polygons need not be convex.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

use super::error::Fault;
use super::hash::NumberMap;
use super::mend::{Dropped, mended};
use super::model::{AlphaMode, Material, Mesh, Model, Part};
use super::picture::{EncodedPicture, decode_all};
use super::triangulate::triangulated;
use super::uri::Surroundings;

/// Numbers of position, texture coordinate and normal of one corner; `u32::MAX` where there is none.
type Corner = [u32; 3];

const NONE: u32 = u32::MAX;

/// The triangles of one group and one material.
#[derive(Default)]
struct Piece {
    object: usize,
    group: usize,
    material: usize,
    vertices: Vec<Corner>,
    numbers: NumberMap<Corner, u32>,
    triangles: Vec<[u32; 3]>,
}

/// What has been read so far.
#[derive(Default)]
struct Reader {
    positions: Vec<Vec3>,
    colors: Vec<[u8; 4]>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    objects: Names,
    groups: Names,
    materials: Names,
    libraries: Vec<String>,
    pieces: Vec<Piece>,
    piece_of: HashMap<[usize; 3], usize>,
    current: [usize; 3],
    triangles: usize,
}

/// Names, numbered in the order they came.
#[derive(Default)]
struct Names {
    names: Vec<String>,
    numbers: HashMap<String, usize>,
}

impl Names {
    fn number(&mut self, name: &str) -> usize {
        if let Some(&number) = self.numbers.get(name) {
            return number;
        }
        self.names.push(name.to_string());
        self.numbers.insert(name.to_string(), self.names.len() - 1);
        self.names.len() - 1
    }
}

/// Reads an OBJ file.
pub(super) fn read(bytes: &[u8], around: Surroundings) -> Result<Model, Fault> {
    let mut reader = Reader::default();
    reader.current = [reader.objects.number(""), reader.groups.number(""), reader.materials.number("")];
    let mut joined = Vec::new();
    for (number, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if let Some(start) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(start);
            joined.push(b' ');
            continue;
        }
        if joined.is_empty() {
            reader.line(line, number + 1, around)?;
        } else {
            joined.extend_from_slice(line);
            reader.line(&joined, number + 1, around)?;
            joined.clear();
        }
    }
    reader.finish(around)
}

impl Reader {
    fn line(&mut self, line: &[u8], number: usize, around: Surroundings) -> Result<(), Fault> {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let place = || format!("line {number}");
        match words.next() {
            Some(b"v") => self.vertex(words, &place)?,
            Some(b"vt") => {
                let [u, v] = numbers(&mut words, &place)?;
                // OBJ counts v from the bottom, ours from the top.
                self.uvs.push(Vec2::new(u, 1.0 - v));
            }
            Some(b"vn") => self.normals.push(Vec3::from_array(numbers(&mut words, &place)?)),
            Some(b"f") => self.face(words, &place, around)?,
            Some(b"o") => self.current[0] = self.objects.number(&rest(line, 1)),
            Some(b"g") => self.current[1] = self.groups.number(&rest(line, 1)),
            Some(b"usemtl") => self.current[2] = self.materials.number(&rest(line, 6)),
            Some(b"mtllib") => self.libraries.push(rest(line, 6)),
            _ => {}
        }
        Ok(())
    }

    fn vertex<'a>(
        &mut self,
        mut words: impl Iterator<Item = &'a [u8]>,
        place: &impl Fn() -> String,
    ) -> Result<(), Fault> {
        self.positions.push(Vec3::from_array(numbers(&mut words, place)?));
        let rest: Vec<f32> = words.filter_map(number).collect();
        if let [r, g, b] = rest[..] {
            self.colors.resize(self.positions.len() - 1, [255; 4]);
            let scale = if r.max(g).max(b) > 1.0 { 1.0 } else { 255.0 };
            let [r, g, b] = [r, g, b].map(|c| (c * scale).clamp(0.0, 255.0).round() as u8);
            self.colors.push([r, g, b, 255]);
        }
        Ok(())
    }

    fn face<'a>(
        &mut self,
        words: impl Iterator<Item = &'a [u8]>,
        place: &impl Fn() -> String,
        around: Surroundings,
    ) -> Result<(), Fault> {
        let corners: Vec<Corner> = words.map(|word| self.corner(word, place)).collect::<Result<_, _>>()?;
        if corners.len() < 3 {
            return Err(Fault::malformed(place(), "a face needs at least three corners"));
        }
        let at: Vec<Vec3> = corners.iter().map(|c| self.positions[c[0] as usize]).collect();
        let cut = triangulated(&at);
        self.triangles += cut.len();
        around.budget.check_triangles(&place(), self.triangles)?;
        let piece = self.piece(around, place)?;
        for triangle in cut {
            let triangle = triangle.map(|k| {
                let next = piece.vertices.len() as u32;
                *piece.numbers.entry(corners[k]).or_insert_with(|| {
                    piece.vertices.push(corners[k]);
                    next
                })
            });
            piece.triangles.push(triangle);
        }
        Ok(())
    }

    fn piece(&mut self, around: Surroundings, place: &impl Fn() -> String) -> Result<&mut Piece, Fault> {
        let [object, group, material] = self.current;
        let next = self.pieces.len();
        let index = *self.piece_of.entry(self.current).or_insert(next);
        if index == next {
            around.budget.check_nodes(&place(), "groups", next + 1)?;
            self.pieces.push(Piece { object, group, material, ..Piece::default() });
        }
        Ok(&mut self.pieces[index])
    }

    /// `v`, `v/t`, `v//n` or `v/t/n`; negative numbers count from the end.
    fn corner(&self, word: &[u8], place: &impl Fn() -> String) -> Result<Corner, Fault> {
        let mut fields = word.split(|&b| b == b'/');
        let mut index = |what: &'static str, count: usize| -> Result<u32, Fault> {
            let Some(field) = fields.next().filter(|f| !f.is_empty()) else { return Ok(NONE) };
            let text = std::str::from_utf8(field).ok();
            let index: i64 = text.and_then(|t| t.parse().ok()).ok_or_else(|| {
                let shown = String::from_utf8_lossy(word.get(..40).unwrap_or(word)).into_owned();
                Fault::malformed(place(), format!("\"{shown}\" is not a corner"))
            })?;
            let from_zero = if index < 0 { index.saturating_add(count as i64) } else { index - 1 };
            let there = u32::try_from(from_zero).ok().filter(|i| (*i as usize) < count);
            there.ok_or_else(|| Fault::out_of_range(place(), what, index.unsigned_abs() as usize, count))
        };
        let vertex = index("vertex", self.positions.len())?;
        if vertex == NONE {
            return Err(Fault::malformed(place(), "a corner names no vertex"));
        }
        Ok([vertex, index("texture coordinate", self.uvs.len())?, index("normal", self.normals.len())?])
    }

    fn finish(mut self, around: Surroundings) -> Result<Model, Fault> {
        around.budget.check_vertices("the whole file", self.positions.len())?;
        if !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [255; 4]);
        }
        let mut model = Model::default();
        let library = Library::read(&self.libraries, around, &mut model.notes);
        self.looks(&library, around, &mut model)?;
        let mut dropped = Dropped::default();
        let by_object = self.objects.names.len() > 2;
        let mut nodes = HashMap::new();
        for piece in std::mem::take(&mut self.pieces) {
            let holder = if by_object { (piece.object, 0) } else { (piece.object, piece.group + 1) };
            let next = nodes.len();
            let node = *nodes.entry(holder).or_insert(next);
            let (name, path) = self.names_of(&piece, by_object);
            let material = piece.material;
            let (mesh, lost) = mended(self.mesh(piece));
            dropped.add(lost);
            if !mesh.triangles.is_empty() {
                let file_from_mesh = Affine3A::IDENTITY;
                model.parts.push(Part {
                    name,
                    node,
                    path,
                    mesh: Arc::new(mesh),
                    material,
                    file_from_mesh,
                    extras: None,
                });
            }
        }
        model.notes.extend(dropped.notes());
        Ok(model)
    }

    fn names_of(&self, piece: &Piece, by_object: bool) -> (String, Vec<String>) {
        let (object, group) = (&self.objects.names[piece.object], &self.groups.names[piece.group]);
        if by_object || group.is_empty() {
            return (object.clone(), Vec::new());
        }
        (group.clone(), if object.is_empty() { Vec::new() } else { vec![object.clone()] })
    }

    fn mesh(&self, piece: Piece) -> Mesh {
        fn each<T: Copy>(piece: &Piece, of: &[T], field: usize) -> Vec<T> {
            let picked = piece.vertices.iter().map(|c| of.get(c[field] as usize).copied());
            picked.collect::<Option<_>>().unwrap_or_default()
        }
        Mesh {
            positions: each(&piece, &self.positions, 0),
            normals: each(&piece, &self.normals, 2),
            uvs: each(&piece, &self.uvs, 1),
            colors: each(&piece, &self.colors, 0),
            triangles: piece.triangles,
        }
    }

    /// One material for each name that faces use, defined by the libraries or by name alone.
    fn looks(&self, library: &Library, around: Surroundings, model: &mut Model) -> Result<(), Fault> {
        let mut pictures = Vec::new();
        let mut picture_of: HashMap<String, Option<usize>> = HashMap::new();
        let mut undefined = 0;
        for name in &self.materials.names {
            let Some(found) = library.materials.get(name) else {
                undefined += usize::from(!name.is_empty());
                model.materials.push(Material { name: name.clone(), ..Material::default() });
                continue;
            };
            let mut material = found.look.clone();
            if let Some(file) = &found.picture {
                let known = picture_of.entry(file.clone()).or_insert_with(|| {
                    let bytes = picture_bytes(file, around, &mut model.notes)?;
                    pictures.push(EncodedPicture {
                        name: file.clone(),
                        place: format!("map_Kd {file}"),
                        bytes,
                    });
                    Some(pictures.len() - 1)
                });
                material.base_color_texture = *known;
                if known.is_some() && material.base_color[..3].iter().all(|c| *c == 0.0) {
                    material.base_color = [1.0, 1.0, 1.0, material.base_color[3]];
                }
            }
            model.materials.push(material);
        }
        if undefined > 0 {
            model
                .notes
                .push(format!("{undefined} materials are named but not defined: their look is plain grey"));
        }
        let mut texture_of = Vec::with_capacity(pictures.len());
        for decoded in decode_all(&pictures, around.budget)? {
            texture_of.push(decoded.as_ref().ok().map(|_| model.textures.len()));
            match decoded {
                Ok(texture) => model.textures.push(texture),
                Err(note) => model.notes.push(note),
            }
        }
        for material in &mut model.materials {
            material.base_color_texture = material.base_color_texture.and_then(|p| texture_of[p]);
        }
        Ok(())
    }
}

/// The bytes of a picture by the name in the MTL; when that leads elsewhere or nowhere, by its last part.
fn picture_bytes(file: &str, around: Surroundings, notes: &mut Vec<String>) -> Option<Vec<u8>> {
    let fault = match around.read_file("map_Kd", file) {
        Ok(bytes) => return Some(bytes),
        Err(fault) => fault,
    };
    let last = file.rsplit(['/', '\\']).next().unwrap_or(file);
    if let Some(bytes) = Some(last).filter(|l| *l != file).and_then(|l| around.read_file("map_Kd", l).ok()) {
        notes.push(format!("the picture \"{last}\" beside the file was taken for \"{file}\""));
        return Some(bytes);
    }
    notes.push(format!("{}: left out, {}", fault.place, fault.problem));
    None
}

/// What the MTL files define.
#[derive(Default)]
struct Library {
    materials: HashMap<String, Defined>,
}

struct Defined {
    look: Material,
    picture: Option<String>,
}

impl Library {
    /// Reads the libraries; one that is missing or elsewhere gives a note, for the room can do without.
    fn read(names: &[String], around: Surroundings, notes: &mut Vec<String>) -> Self {
        let mut library = Self::default();
        for name in names {
            match around.read_file("mtllib", name) {
                Ok(bytes) => library.read_one(&String::from_utf8_lossy(&bytes)),
                Err(fault) => notes.push(format!("{}: materials left out, {}", fault.place, fault.problem)),
            }
        }
        library
    }

    fn read_one(&mut self, text: &str) {
        let mut current: Option<(String, Defined)> = None;
        for line in text.lines() {
            let (key, value) = line.trim().split_once(char::is_whitespace).unwrap_or((line.trim(), ""));
            if key == "newmtl" {
                self.materials.extend(current.take());
                let name = value.trim().to_string();
                let look = Material { name: name.clone(), ..Material::default() };
                current = Some((name, Defined { look, picture: None }));
            } else if let Some((_, material)) = &mut current {
                material.set(key, value.trim());
            }
        }
        self.materials.extend(current);
    }
}

impl Defined {
    /// Takes in one statement; unknown ones are skipped.
    fn set(&mut self, key: &str, value: &str) {
        let numbers: Vec<f32> = value.split_whitespace().map_while(|w| w.parse().ok()).collect();
        let unit = |n: f32| if n.is_finite() { n.clamp(0.0, 1.0) } else { 1.0 };
        match (key, &numbers[..]) {
            ("Kd", &[r, g, b, ..]) => self.look.base_color[..3].copy_from_slice(&[r, g, b].map(unit)),
            ("Ke", &[r, g, b, ..]) => self.look.emissive = [r, g, b].map(unit),
            ("d", &[d, ..]) => self.set_opacity(unit(d)),
            ("Tr", &[t, ..]) => self.set_opacity(1.0 - unit(t)),
            ("Pr", &[r, ..]) => self.look.roughness = unit(r),
            ("Pm", &[m, ..]) => self.look.metallic = unit(m),
            // Beckmann roughness of a Blinn-Phong exponent (Walter et al. 2007).
            ("Ns", &[n, ..]) => self.look.roughness = unit((2.0 / (n.max(0.0) + 2.0)).sqrt()),
            ("map_Kd", _) => self.picture = picture_name(value),
            _ => {}
        }
    }

    fn set_opacity(&mut self, opacity: f32) {
        self.look.base_color[3] = opacity;
        self.look.alpha = if opacity < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
    }
}

/// The file of a `map_` statement behind its options (`-s 1 1 1 wood.png`).
fn picture_name(value: &str) -> Option<String> {
    let mut left = value;
    while let Some(option) = left.strip_prefix('-') {
        left = option.split_once(char::is_whitespace)?.1.trim_start();
        while let Some((word, behind)) = left.split_once(char::is_whitespace) {
            if word.parse::<f32>().is_err() && !matches!(word, "on" | "off") {
                break;
            }
            left = behind.trim_start();
        }
    }
    (!left.is_empty()).then(|| left.to_string())
}

/// What follows a statement's key, as text.
fn rest(line: &[u8], key_length: usize) -> String {
    let line = line.trim_ascii();
    String::from_utf8_lossy(line.get(key_length..).unwrap_or(&[])).trim().to_string()
}

fn number(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

fn numbers<'a, const N: usize>(
    words: &mut impl Iterator<Item = &'a [u8]>,
    place: &impl Fn() -> String,
) -> Result<[f32; N], Fault> {
    let mut values = [0.0; N];
    for (k, value) in values.iter_mut().enumerate() {
        *value = match words.next() {
            Some(word) => number(word).ok_or_else(|| {
                let shown = String::from_utf8_lossy(word.get(..40).unwrap_or(word)).into_owned();
                Fault::malformed(place(), format!("\"{shown}\" is not a number"))
            })?,
            // The second texture coordinate may be missing.
            None if N == 2 && k == 1 => 0.0,
            None => return Err(Fault::malformed(place(), format!("{N} numbers are due, {k} are there"))),
        };
    }
    Ok(values)
}
