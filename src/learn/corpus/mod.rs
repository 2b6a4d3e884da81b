//! The corpus of people in rooms: what the networks of PSI learn from.
//!
//! A folder with `corpus.ron` (the [`Manifest`]) and one folder a room: `layout.ron` (procedural rooms), `room.glb` and
//! `samples.npz` ([`CorpusRoom::to_npz`]). People are kept as translation, rotation, shape, **21 axis-angles of the body
//! pose** and hand codes, so that a corpus outlives every pose space; views as cameras with depth in millimetres and
//! labels, 128 x 128. Captures of real people would fit the same format: `family` and `source` say what is known.
//!
//! Pure: turns values into bytes and back; files are the caller's.

mod samples;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use crate::assets::npz::NpzError;
use crate::body::{Body, BodyPose};
use crate::generate::sensor::{SceneImage, Valid, View};
use crate::scene::layout::RoomType;
use crate::scene::{BETAS, BodyParams, GeometryConfig, HANDS, PoseFamily, Resolution};

use glam::Vec3;

/// Number of the format; another one is refused.
pub const FORMAT: u32 = 1;
/// File name of the manifest.
pub const MANIFEST: &str = "corpus.ron";
/// File name of a room's people and views, in the room's folder.
pub const SAMPLES: &str = "samples.npz";
/// File name of a room, in its folder.
pub const ROOM: &str = "room.glb";
/// File name of a procedural room's layout, in its folder.
pub const LAYOUT: &str = "layout.ron";

/// Which part of the work a room serves. Split by room: nobody is tested where they learned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Split {
    /// To learn from.
    Train,
    /// To see how learning goes on.
    Validation,
    /// For the tables; never seen while learning.
    Test,
}

/// Where a room comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RoomSource {
    /// Made by rule.
    Procedural {
        /// Kind of room.
        kind: RoomType,
        /// Its seed.
        seed: u64,
    },
    /// A sample room of the program, by key.
    Sample(String),
    /// A file of somebody else's, by name: for captures.
    File(String),
}

/// One line of the manifest.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RoomEntry {
    /// Folder of the room, such as `room_0007`.
    pub name: String,
    /// What it is for.
    pub split: Split,
    /// Where it comes from.
    pub source: RoomSource,
    /// Number of people in it.
    pub people: usize,
    /// Number of views of them.
    pub views: usize,
}

/// What a corpus is, and its rooms.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`FORMAT`].
    pub format: u32,
    /// What it is, for people: that it is staged, by which command.
    pub about: String,
    /// Root of the seed tree.
    pub seed: u64,
    /// Every room.
    pub rooms: Vec<RoomEntry>,
}

/// Somebody in a room of the corpus.
#[derive(Clone, Debug, PartialEq)]
pub struct CorpusPerson {
    /// Global translation in metres, world frame, as in [`BodyParams`].
    pub translation: Vec3,
    /// Global rotation, 6-D row-major 3x2, as in [`BodyParams`].
    pub rotation6: [f32; 6],
    /// Body shape.
    pub betas: [f32; BETAS],
    /// Axis-angles of SMPL-X's body joints 1 to 21 in radians, each in its parent's frame.
    pub body_pose: BodyPose,
    /// Hand pose codes, left then right.
    pub hands: [f32; HANDS],
    /// What they do.
    pub family: PoseFamily,
}

/// How a view came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ViewKind {
    /// A virtual camera of PROX-E, aimed at the body.
    Virtual,
    /// The agent of MP3D-R: eye height, looking down.
    Agent,
}

/// What a camera sees of the room, empty as it is, at the place of one of its people.
#[derive(Clone, Debug, PartialEq)]
pub struct CorpusView {
    /// How it came about.
    pub kind: ViewKind,
    /// Index of the person in its picture.
    pub body: usize,
    /// The camera of the 128 x 128 square.
    pub view: View,
    /// The part of the square that is not padding.
    pub valid: Valid,
    /// Depth along the axis in millimetres, row by row; 0 where nothing is.
    pub depth_mm: Vec<u16>,
    /// Labels ([`crate::generate::sensor::label_of`]), row by row; 0 where nothing is.
    pub labels: Vec<u8>,
}

/// A room with its people and views.
#[derive(Clone, Debug, PartialEq)]
pub struct CorpusRoom {
    /// Folder of the room.
    pub name: String,
    /// What it is for.
    pub split: Split,
    /// Where it comes from.
    pub source: RoomSource,
    /// Its people; each is alone in the room, so they may overlap each other.
    pub people: Vec<CorpusPerson>,
    /// Views of them.
    pub views: Vec<CorpusView>,
}

/// A whole corpus in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Corpus {
    /// What it is.
    pub manifest: Manifest,
    /// Its rooms, in the manifest's order.
    pub rooms: Vec<CorpusRoom>,
}

/// Why a corpus can't be used. The file's name is in the message.
#[derive(Debug, thiserror::Error)]
pub enum CorpusError {
    /// The manifest isn't one.
    #[error("{MANIFEST}, line {line}, column {column}: {problem}; stage the corpus again")]
    Manifest {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the parser expected.
        problem: String,
    },
    /// A format of another program version.
    #[error("{MANIFEST} says format {found}, this program reads {FORMAT}; stage the corpus again with it")]
    Format {
        /// The number in the file.
        found: u32,
    },
    /// An array of a room is missing or damaged.
    #[error(transparent)]
    Npz(#[from] NpzError),
    /// A number in an array makes no sense.
    #[error(
        "{file}: `{array}` at {index}: {problem}; stage the room again: remove its folder and run with --resume"
    )]
    Value {
        /// The file.
        file: String,
        /// The array.
        array: String,
        /// First index of the entry.
        index: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// The room's file holds another number of people or views than the manifest says.
    #[error("{room}: {found} {what}, the manifest says {expected}; stage the corpus again")]
    Count {
        /// The room.
        room: String,
        /// People or views.
        what: &'static str,
        /// In the file.
        found: usize,
        /// In the manifest.
        expected: usize,
    },
}

impl Manifest {
    /// Reads the RON text.
    ///
    /// # Errors
    /// [`CorpusError::Manifest`] and [`CorpusError::Format`].
    pub fn from_ron(text: &str) -> Result<Self, CorpusError> {
        let manifest: Self = ron::from_str(text).map_err(|error: ron::error::SpannedError| {
            let (line, column) = (error.span.start.line, error.span.start.col);
            CorpusError::Manifest { line, column, problem: error.code.to_string() }
        })?;
        let found = manifest.format;
        if found == FORMAT { Ok(manifest) } else { Err(CorpusError::Format { found }) }
    }

    /// The RON text.
    ///
    /// # Errors
    /// What the serialiser says; it never fails on these values.
    pub fn to_ron(&self) -> Result<String, ron::Error> {
        ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new().depth_limit(2))
    }

    /// Checks a room against its line.
    ///
    /// # Errors
    /// [`CorpusError::Count`].
    pub fn check(entry: &RoomEntry, room: &CorpusRoom) -> Result<(), CorpusError> {
        for (what, found, expected) in
            [("people", room.people.len(), entry.people), ("views", room.views.len(), entry.views)]
        {
            if found != expected {
                return Err(CorpusError::Count { room: entry.name.clone(), what, found, expected });
            }
        }
        Ok(())
    }
}

impl CorpusPerson {
    /// From a body of today's pose space.
    pub fn new(params: &BodyParams, family: PoseFamily, body: &Body) -> Self {
        Self {
            translation: params.translation,
            rotation6: params.rotation6,
            betas: params.betas,
            body_pose: body.pose_space.decode(&params.pose),
            hands: params.hands,
            family,
        }
    }

    /// In today's pose space: the code whose pose is nearest.
    pub fn params(&self, body: &Body) -> BodyParams {
        BodyParams {
            translation: self.translation,
            rotation6: self.rotation6,
            betas: self.betas,
            pose: body.pose_space.encode(&self.body_pose),
            hands: self.hands,
        }
    }
}

impl CorpusView {
    /// From a captured image.
    pub fn new(kind: ViewKind, body: usize, image: &SceneImage) -> Self {
        let millimetres = |m: &f32| (m * 1000.0).round().clamp(0.0, 65_535.0) as u16;
        Self {
            kind,
            body,
            view: image.view,
            valid: image.valid,
            depth_mm: image.depth_m.iter().map(millimetres).collect(),
            labels: image.labels.clone(),
        }
    }

    /// What the networks see.
    pub fn scene_image(&self) -> SceneImage {
        let depth_m = self.depth_mm.iter().map(|mm| f32::from(*mm) * 1e-3).collect();
        SceneImage::new(self.view, self.valid, depth_m, self.labels.clone())
    }
}

/// How the geometry of a corpus's rooms is derived: 3 cm between samples, about 3 million in a living room, which
/// bakes in a second or two and fits hundreds of rooms on a disk.
pub fn corpus_geometry() -> GeometryConfig {
    let mut config = GeometryConfig::default();
    config.field.resolution = Resolution::Cells { cell_m: 0.03, max_bytes: 256 << 20 };
    config
}
