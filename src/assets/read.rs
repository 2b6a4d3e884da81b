//! The way in: chooses the reader by the file's name, or by its first bytes when the name says nothing.

use std::path::Path;

use super::budget::Budget;
use super::error::{AssetError, Fault, Problem};
use super::model::Model;
use super::uri::{Surroundings, read_plain_file};
use super::{gltf, obj, ply};

/// Formats that are read.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    Gltf,
    Obj,
    Ply,
}

/// Reads a model from a file: `.glb`, `.gltf`, `.obj` or `.ply`, told by its first bytes under any other
/// name. Files that it refers to are read from its own folder only.
///
/// # Errors
/// Names the file, the place in it, what is wrong and what to do.
pub fn read_model(path: &Path, budget: &Budget) -> Result<Model, AssetError> {
    let shown = path.display().to_string();
    let name = path.file_name().map_or_else(|| shown.clone(), |n| n.to_string_lossy().into_owned());
    let folder = path.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
    let around = Surroundings { folder, budget };
    read_plain_file(path, budget).and_then(|bytes| read(&name, &bytes, around)).map_err(|f| f.in_file(&shown))
}

/// Reads a model from memory, as [`read_model`] does; files that it refers to are refused.
///
/// # Errors
/// As [`read_model`]; `name` stands for the file.
pub fn read_model_bytes(name: &str, bytes: &[u8], budget: &Budget) -> Result<Model, AssetError> {
    read(name, bytes, Surroundings { folder: None, budget }).map_err(|fault| fault.in_file(name))
}

fn read(name: &str, bytes: &[u8], around: Surroundings) -> Result<Model, Fault> {
    around.budget.check_bytes("the file itself", bytes.len() as u64)?;
    if bytes.is_empty() {
        return Err(Fault::malformed("byte 0", "the file is empty"));
    }
    let mut model = match format_of(name, bytes)? {
        Format::Gltf => gltf::read(bytes, around)?,
        Format::Obj => obj::read(bytes, around)?,
        Format::Ply => ply::read(bytes, around)?,
    };
    if model.triangle_count() == 0 {
        let remedy = match model.notes.is_empty() {
            true => "Check that the export had something selected and that it exports meshes.",
            false => "Everything in it had to be dropped: export it again.",
        };
        return Err(Fault::new("the whole file", Problem::Empty(remedy)));
    }
    model.name = name.to_string();
    Ok(model)
}

fn format_of(name: &str, bytes: &[u8]) -> Result<Format, Fault> {
    let extension =
        Path::new(name).extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "glb" | "gltf" | "vrm" => return Ok(Format::Gltf),
        "obj" => return Ok(Format::Obj),
        "ply" => return Ok(Format::Ply),
        _ => {}
    }
    let text = bytes.trim_ascii_start();
    let is_text = !bytes.iter().take(512).any(|&b| b == 0);
    let has_vertex_line = || text.split(|&b| b == b'\n').take(1000).any(|line| line.starts_with(b"v "));
    if bytes.starts_with(b"glTF") || (text.starts_with(b"{") && is_text) {
        Ok(Format::Gltf)
    } else if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        Ok(Format::Ply)
    } else if is_text && has_vertex_line() {
        Ok(Format::Obj)
    } else {
        let kind = if extension.is_empty() {
            "an unknown format".to_string()
        } else {
            format!("the format .{extension}")
        };
        let remedy = "GLB, glTF, OBJ and PLY are read: export it as GLB, for example from Blender.";
        Err(Fault::new("the first bytes", Problem::Unsupported { feature: kind, remedy }))
    }
}
