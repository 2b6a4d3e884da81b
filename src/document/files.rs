//! Projects on disk: a folder (`project.ron`, `room.glb` and `motions.npz` beside it) or one archive (`.inhabit`, all in a
//! ZIP). A save either happens whole or not at all.

use std::fs::File;
use std::io::{Cursor, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::project::{self, Project, ProjectText, WriteProblem, Written};
use crate::assets::AssetError;
use crate::assets::Budget;
use crate::assets::read_model_bytes;

/// Most bytes of a project's text: a hundred thousand people.
const TEXT_LIMIT: u64 = 256 << 20;
/// Most bytes of a room in an archive, unpacked.
const ROOM_LIMIT: u64 = 4 << 30;
/// Most bytes of the motions in a project, packed: days of motion.
const MOTIONS_LIMIT: u64 = 1 << 30;
/// Name of the text in an archive.
const TEXT_NAME: &str = "project.ron";
/// Name of the meshes in an archive and beside `project.ron`.
const ROOM_NAME: &str = "room.glb";
/// Name of the motions' frames in an archive and beside `project.ron`.
const MOTIONS_NAME: &str = "motions.npz";

/// Why a project could not be saved or opened: which file, where in it, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ProjectError {
    /// The operating system refuses to read.
    #[error("{file} can't be read ({source}). Check that it exists and may be read.")]
    Read {
        /// The file.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// The operating system refuses to write.
    #[error(
        "{file} can't be written ({source}). Check that the folder exists, may be written to and has space; the old file is as it was."
    )]
    Write {
        /// The file.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// The scene can't be put into a file.
    #[error("{file} was not written: {problem}")]
    Content {
        /// The file.
        file: String,
        /// What is wrong.
        problem: WriteProblem,
    },
    /// More than is sensible.
    #[error("{file} is larger than {limit_mb} MB, which no project is. Check that it is one.")]
    TooLarge {
        /// The file.
        file: String,
        /// Allowed megabytes.
        limit_mb: u64,
    },
    /// The text does not say what a project says.
    #[error(
        "{file}, line {line}, column {column}: {problem}. Undo the last edit of that place, or open an older copy."
    )]
    Text {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the parser expected.
        problem: String,
    },
    /// Some other RON file.
    #[error("{file} is no Inhabit project: its format is \"{found}\". Open the project.ron of a project.")]
    NotAProject {
        /// The file.
        file: String,
        /// Its format.
        found: String,
    },
    /// Written by a later program.
    #[error(
        "{file} has version {found}, this program knows up to {known}. Open it with Inhabit {program} or later."
    )]
    TooNew {
        /// The file.
        file: String,
        /// Its version.
        found: u32,
        /// The newest version that can be read.
        known: u32,
        /// The program that wrote it.
        program: String,
    },
    /// The archive is damaged.
    #[error("{file}: {place} can't be unpacked ({problem}). The file is damaged: open another copy.")]
    Archive {
        /// The file.
        file: String,
        /// Which part of it.
        place: String,
        /// What is wrong.
        problem: String,
    },
    /// The file of meshes or motions is named by a path.
    #[error(
        "{file} names \"{name}\" as one of its files, which is not a plain file name. Put that file beside the project and name it without a folder."
    )]
    FilePath {
        /// The project.
        file: String,
        /// The name in it.
        name: String,
    },
    /// The meshes can't be read.
    #[error("the room of {file}: {source}")]
    Room {
        /// The project.
        file: String,
        /// What is wrong.
        source: AssetError,
    },
    /// The meshes are not the ones that were saved.
    #[error(
        "{file} describes {expected} meshes, but its room file has {found}. The room file was exchanged: bring the old one back, or open the room file by itself."
    )]
    OtherRoom {
        /// The project.
        file: String,
        /// Meshes in the text.
        expected: usize,
        /// Meshes in the room file.
        found: usize,
    },
    /// The motions can't be read, or are not those that were saved.
    #[error("the motions of {file}: {problem}. Bring the file back that was saved with it.")]
    Motions {
        /// The project.
        file: String,
        /// What is wrong.
        problem: String,
    },
    /// A study without anything to be rated.
    #[error(
        "{folder} has nothing to be rated. Make a folder for each method in it, and in these put projects or rooms, by the same names for the same tasks."
    )]
    NothingToRate {
        /// The folder.
        folder: String,
    },
    /// A person can't be.
    #[error("{file}: the person \"{person}\" {problem}. Remove or mend that entry.")]
    Person {
        /// The project.
        file: String,
        /// Who.
        person: String,
        /// What is wrong.
        problem: &'static str,
    },
}

/// A project that was opened.
#[derive(Clone, Debug)]
pub struct LoadedProject {
    /// The project.
    pub project: Project,
    /// What its reader should know, in words.
    pub notes: Vec<String>,
}

/// Saves `project`: as one archive under a name that ends in `.inhabit`, otherwise as RON with the room's
/// meshes in a GLB and the motions' frames, if there are motions, in an archive beside it (`room.glb` and
/// `motions.npz` for `project.ron`, `NAME.room.glb` and so on for `NAME.ron`). Files are replaced whole or not at all.
///
/// # Errors
/// [`ProjectError`] names the file and the remedy; what was there before is still there.
pub fn save_project(path: &Path, project: &Project) -> Result<(), ProjectError> {
    let (room_name, motions_name) = if is_archive(path) {
        (ROOM_NAME.to_owned(), MOTIONS_NAME.to_owned())
    } else {
        (name_beside(path, ROOM_NAME), name_beside(path, MOTIONS_NAME))
    };
    let written = project::write(project, &room_name, &motions_name)
        .map_err(|problem| ProjectError::Content { file: shown(path), problem })?;
    if is_archive(path) {
        let bytes = pack(&written).map_err(|source| ProjectError::Write { file: shown(path), source })?;
        return replace(path, &bytes);
    }
    replace_if_other(&path.with_file_name(&room_name), &written.glb)?;
    if let Some(motions) = &written.motions {
        replace_if_other(&path.with_file_name(&motions_name), motions)?;
    }
    replace(path, written.text.as_bytes())
}

/// Leaves a file alone that holds these bytes already.
fn replace_if_other(path: &Path, bytes: &[u8]) -> Result<(), ProjectError> {
    let unchanged = std::fs::read(path).is_ok_and(|old| old == bytes);
    if unchanged { Ok(()) } else { replace(path, bytes) }
}

/// Opens what [`save_project`] wrote; every number comes back bit by bit.
///
/// # Errors
/// [`ProjectError`] names the file, the place in it and the remedy.
pub fn load_project(path: &Path) -> Result<LoadedProject, ProjectError> {
    let file = shown(path);
    let Parts { text, glb, motions } = if is_archive(path) { unpack(path)? } else { read_folder(path)? };
    let mut notes = Vec::new();
    if project::hash_text(&glb) != text.room.content_hash {
        notes.push(format!("The room file {} was changed after the project was saved.", text.room.file));
    }
    let model = read_model_bytes(&text.room.file, &glb, &Budget::default())
        .map_err(|source| ProjectError::Room { file: file.clone(), source })?;
    let project = project::assemble(text, model, motions.as_deref(), &file)?;
    Ok(LoadedProject { project, notes })
}

/// Whether the name is that of an archive.
fn is_archive(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("inhabit"))
}

/// The name of a file of the project beside the text.
fn name_beside(path: &Path, name: &str) -> String {
    match path.file_stem().map(|s| s.to_string_lossy().into_owned()) {
        Some(stem) if stem != "project" => format!("{stem}.{name}"),
        _ => name.to_owned(),
    }
}

/// What a project is made of, read but not understood.
struct Parts {
    text: ProjectText,
    glb: Vec<u8>,
    motions: Option<Vec<u8>>,
}

fn read_folder(path: &Path) -> Result<Parts, ProjectError> {
    let file = shown(path);
    let bytes = read_limited(path, TEXT_LIMIT)?;
    let text = project::parse(&utf8(bytes, &file)?, &file)?;
    let beside = |name: &String, limit: u64| {
        if Path::new(name).file_name().is_none_or(|plain| plain.to_string_lossy() != *name) {
            return Err(ProjectError::FilePath { file: file.clone(), name: name.clone() });
        }
        read_limited(&path.with_file_name(name), limit)
    };
    let glb = beside(&text.room.file, ROOM_LIMIT)?;
    let motions = text.motions.as_ref().map(|m| beside(&m.file, MOTIONS_LIMIT)).transpose()?;
    Ok(Parts { text, glb, motions })
}

fn read_limited(path: &Path, limit: u64) -> Result<Vec<u8>, ProjectError> {
    let fail = |source| ProjectError::Read { file: shown(path), source };
    let file = File::open(path).map_err(fail)?;
    take_limited(file, limit)
        .map_err(fail)?
        .ok_or_else(|| ProjectError::TooLarge { file: shown(path), limit_mb: limit >> 20 })
}

/// All bytes, or `None` if there are more than `limit`.
fn take_limited(from: impl Read, limit: u64) -> std::io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    from.take(limit + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= limit).then_some(bytes))
}

fn utf8(bytes: Vec<u8>, file: &str) -> Result<String, ProjectError> {
    String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|b| **b == b'\n').count();
        let problem = "this is not text (UTF-8)".to_owned();
        ProjectError::Text { file: file.to_owned(), line, column: 1, problem }
    })
}

fn unpack(path: &Path) -> Result<Parts, ProjectError> {
    let file = shown(path);
    let opened = File::open(path).map_err(|source| ProjectError::Read { file: file.clone(), source })?;
    let damaged = |place: &str, problem: String| ProjectError::Archive {
        file: shown(path),
        place: place.to_owned(),
        problem,
    };
    let mut archive = ZipArchive::new(opened).map_err(|e| damaged("the archive", e.to_string()))?;
    let text = entry(&mut archive, TEXT_NAME, TEXT_LIMIT).map_err(|e| damaged(TEXT_NAME, e))?;
    let text = project::parse(&utf8(text, &file)?, &file)?;
    let mut packed = |name: &str, limit| entry(&mut archive, name, limit).map_err(|e| damaged(name, e));
    let glb = packed(&text.room.file, ROOM_LIMIT)?;
    let motions = text.motions.as_ref().map(|m| packed(&m.file, MOTIONS_LIMIT)).transpose()?;
    Ok(Parts { text, glb, motions })
}

/// One file of the archive, unpacked no further than `limit`.
fn entry(archive: &mut ZipArchive<impl Read + Seek>, name: &str, limit: u64) -> Result<Vec<u8>, String> {
    let entry = archive.by_name(name).map_err(|e| e.to_string())?;
    let bytes = take_limited(entry, limit).map_err(|e| e.to_string())?;
    bytes.ok_or_else(|| format!("it is larger than {} MB", limit >> 20))
}

fn pack(written: &Written) -> std::io::Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .large_file(written.glb.len() as u64 >= u64::from(u32::MAX));
    let motions = written.motions.as_ref().map(|bytes| (MOTIONS_NAME, bytes.as_slice()));
    let files = [(TEXT_NAME, written.text.as_bytes()), (ROOM_NAME, &written.glb)];
    for (name, bytes) in files.into_iter().chain(motions) {
        zip.start_file(name, options)?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

/// Writes files into `folder`, by their paths in it; folders are made where they are missing, each file is
/// replaced as a whole or not at all.
///
/// # Errors
/// [`ProjectError::Write`] when the disk refuses.
pub fn write_folder(folder: &Path, files: &[(String, Vec<u8>)]) -> Result<(), ProjectError> {
    for (name, bytes) in files {
        let path = folder.join(name);
        if let Some(around) = path.parent() {
            let refused = |source| ProjectError::Write { file: shown(around), source };
            std::fs::create_dir_all(around).map_err(refused)?;
        }
        replace(&path, bytes)?;
    }
    Ok(())
}

/// Puts `bytes` in place of the file at `path`: written beside it, forced to the disk, then renamed.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<(), ProjectError> {
    let beside = temporary(path);
    let write = || -> std::io::Result<()> {
        let mut file = File::create(&beside)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        std::fs::rename(&beside, path)
    };
    write().map_err(|source| {
        // The half-written file is of no use to anybody; that it may be gone already is fine.
        let _ = std::fs::remove_file(&beside);
        ProjectError::Write { file: shown(path), source }
    })?;
    if let Some(folder) = path.parent().and_then(|folder| File::open(folder).ok()) {
        // Makes the rename itself last; file systems that can't do this need not.
        let _ = folder.sync_all();
    }
    Ok(())
}

/// A name beside `path` that no other writing has, neither of this process nor of another.
fn temporary(path: &Path) -> PathBuf {
    static WRITINGS: AtomicUsize = AtomicUsize::new(0);
    let number = WRITINGS.fetch_add(1, Ordering::Relaxed);
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    path.with_file_name(format!(".{name}.{}.{number}.part", std::process::id()))
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}
