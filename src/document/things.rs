//! Models of the user's own that actions may bring: one GLB for each in a folder of the user's, named
//! `KIND__NAME.glb`, in metres, upright, its front along +Z.

use std::path::{Path, PathBuf};

use super::files::{ProjectError, replace};
use super::settings::Settings;
use crate::assets::Budget;
use crate::assets::GlbWriteError;
use crate::assets::Model;
use crate::assets::glb_from_model;
use crate::assets::read_model;

/// Most characters of a name: what every file system takes.
const LONGEST_NAME: usize = 60;

/// A model of the user's own.
#[derive(Clone, Debug)]
pub struct OwnThing {
    /// The kind of thing that it is one of.
    pub kind: String,
    /// Its name.
    pub name: String,
    /// Metres, upright, front along +Z.
    pub model: Model,
}

/// Why a thing could not be kept.
#[derive(Debug, thiserror::Error)]
pub enum ThingError {
    /// The model can't be put into a file.
    #[error("{name} was not kept: {problem}")]
    Content {
        /// The thing's name.
        name: String,
        /// What is wrong.
        problem: GlbWriteError,
    },
    /// The disk refuses.
    #[error(transparent)]
    Write(#[from] ProjectError),
}

/// Where this user's things are kept; `None` when the system names no such place.
pub fn things_folder() -> Option<PathBuf> {
    Some(Settings::default_path()?.with_file_name("things"))
}

/// Keeps a thing in `folder`, which is made if it is missing; one of the same kind and name is replaced.
///
/// # Errors
/// [`ThingError`].
pub fn keep_thing(folder: &Path, thing: &OwnThing) -> Result<PathBuf, ThingError> {
    let glb = glb_from_model(&thing.model)
        .map_err(|problem| ThingError::Content { name: thing.name.clone(), problem })?;
    let refused = |source| ProjectError::Write { file: folder.display().to_string(), source };
    std::fs::create_dir_all(folder).map_err(refused)?;
    let path = folder.join(format!("{}__{}.glb", plain(&thing.kind), plain(&thing.name)));
    replace(&path, &glb)?;
    Ok(path)
}

/// Every thing in `folder`, by name of the file, and what could not be read; nothing where there is no folder.
pub fn read_things(folder: &Path) -> (Vec<OwnThing>, Vec<String>) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|e| e == "glb")).collect();
    files.sort();
    let (mut things, mut faults) = (Vec::new(), Vec::new());
    for file in files {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let Some((kind, name)) = stem.split_once("__") else { continue };
        let (kind, name) = (kind.replace('_', " "), name.replace('_', " "));
        match read_model(&file, &Budget::default()) {
            Ok(model) => things.push(OwnThing { kind, name, model }),
            Err(fault) => faults.push(fault.to_string()),
        }
    }
    (things, faults)
}

/// A name without anything that means something in a path, or that parts kind from name.
fn plain(name: &str) -> String {
    let letter = |c: char| if c.is_alphanumeric() || c == '-' { c } else { ' ' };
    let letters: String = name.chars().map(letter).collect();
    let words: Vec<&str> = letters.split_whitespace().collect();
    let joined: String = words.join("_").chars().take(LONGEST_NAME).collect();
    if joined.is_empty() { "thing".to_owned() } else { joined }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine3A, Vec3};

    use super::*;
    use crate::assets::{Material, Mesh, Part};

    fn triangle() -> Model {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let part = Part {
            name: "part".to_owned(),
            node: 0,
            path: Vec::new(),
            mesh: Arc::new(mesh),
            material: 0,
            file_from_mesh: Affine3A::from_scale(Vec3::splat(0.3)),
            extras: None,
        };
        Model { parts: vec![part], materials: vec![Material::default()], ..Model::default() }
    }

    #[test]
    fn a_thing_that_was_kept_is_there_in_the_next_session_in_its_size() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("things");
        assert!(read_things(&place).0.is_empty(), "no folder yet");
        let thing = OwnThing {
            kind: "potted plant".to_owned(),
            name: "../Aunt's __ fern".to_owned(),
            model: triangle(),
        };
        let path = keep_thing(&place, &thing).unwrap();
        assert_eq!(path.parent(), Some(place.as_path()), "names do not leave the folder");
        let (things, faults) = read_things(&place);
        assert_eq!((things.len(), faults.len()), (1, 0));
        assert_eq!((things[0].kind.as_str(), things[0].name.as_str()), ("potted plant", "Aunt s fern"));
        assert!((things[0].model.bounds().size() - Vec3::new(0.3, 0.3, 0.0)).length() < 1e-6);
    }

    #[test]
    fn a_damaged_thing_is_named_and_the_others_come() {
        let folder = tempfile::tempdir().unwrap();
        let thing = OwnThing { kind: "cup".to_owned(), name: "mine".to_owned(), model: triangle() };
        keep_thing(folder.path(), &thing).unwrap();
        std::fs::write(folder.path().join("cup__broken.glb"), b"glTF").unwrap();
        let (things, faults) = read_things(folder.path());
        assert_eq!(things.len(), 1);
        assert!(faults.len() == 1 && faults[0].contains("cup__broken.glb"), "{faults:?}");
    }
}
