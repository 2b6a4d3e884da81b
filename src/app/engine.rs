//! The work that the window asks others for, behind one trait, so that tests can put slow, failing and
//! panicking work in its place.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;

use crate::document::Project;
use crate::evolve::PopulatePreview;
use crate::inspect::BodyReport;
use crate::job::{JobCtx, Stop, Ticker};
use crate::render::BodySurface;
use crate::scene::BodyParams;
use crate::scene::Person;
use crate::scene::PoseFamily;
use crate::scene::Room;
use crate::scene::RoomGeometry;
use crate::scene::Scene;
use crate::scene::UpAxis;

/// What a user says about a file's unit and up axis; `None` is left to detection.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportChoice {
    /// Metres per unit of the file.
    pub unit_m: Option<f32>,
    /// The file's up axis.
    pub up: Option<UpAxis>,
}

/// Where a room comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A file of the user's: room or project.
    File(PathBuf, ImportChoice),
    /// A bundled sample room, by number.
    Sample(usize),
}

/// What was understood of a file, for the import report.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportSummary {
    /// Where it came from.
    pub source: Source,
    /// Name for people.
    pub name: String,
    /// Metres per unit of the file that were taken.
    pub unit_m: f32,
    /// The up axis that was taken.
    pub up: UpAxis,
    /// Triangles.
    pub triangles: usize,
    /// Objects.
    pub objects: usize,
    /// Size in metres.
    pub extent_m: Vec3,
    /// Why unit, up axis and floor are what they are.
    pub evidence: Vec<String>,
    /// What was dropped, mended or ignored.
    pub notes: Vec<String>,
}

/// A file that was read.
#[derive(Clone, Debug)]
pub struct Opened {
    /// The room and, for a project, its people.
    pub scene: Scene,
    /// For the import report.
    pub summary: ImportSummary,
    /// Set for a project: its file and the numbers below which ids are taken.
    pub project: Option<OpenedProject>,
}

/// What a project knows beyond its scene.
#[derive(Clone, Debug)]
pub struct OpenedProject {
    /// The file that *Save* writes.
    pub path: PathBuf,
    /// First free person id.
    pub next_person: u32,
    /// First free object id.
    pub next_object: u32,
}

/// People to make; an owned snapshot, a job never sees the document.
#[derive(Clone)]
pub struct PopulateTask {
    /// The room.
    pub room: Arc<Room>,
    /// What its geometry says.
    pub geometry: Arc<RoomGeometry>,
    /// How many people.
    pub people: usize,
    /// Near this point of a surface, metres, world frame.
    pub at: Option<Vec3>,
    /// Only these families; `None` is all.
    pub families: Option<Vec<PoseFamily>>,
    /// Who is there already and must not be walked into.
    pub existing: Vec<Person>,
    /// Number of the first new person.
    pub next_id: u32,
}

/// Energies of one fit: name of the term and its value after each iteration.
pub type Energies = Vec<(String, Vec<f32>)>;

/// People that were made.
#[derive(Clone, Debug, Default)]
pub struct Made {
    /// Who.
    pub people: Vec<Person>,
    /// What was measured, in the order of `people`; may be shorter.
    pub reports: Vec<BodyReport>,
    /// How the fits went, in the order of `people`; may be shorter.
    pub energies: Vec<Energies>,
    /// Why fewer people came than were asked for.
    pub shortfall: Option<String>,
}

/// The work of the window. Everything but [`Engine::pose`] runs in a job.
pub trait Engine: Send + Sync + 'static {
    /// Names of the bundled sample rooms.
    fn samples(&self) -> Vec<String>;
    /// Reads a room or a project.
    ///
    /// # Errors
    /// What, which file and place, what to do; or cancelled.
    fn open(&self, source: &Source, ticker: &Ticker) -> Result<Opened, Stop>;
    /// Writes a project.
    ///
    /// # Errors
    /// What, which file, what to do; or cancelled.
    fn save(&self, path: &Path, project: &Project, ticker: &Ticker) -> Result<(), Stop>;
    /// Ray tree, distance field, support surfaces and floor of a room.
    ///
    /// # Errors
    /// Why there is none; or cancelled.
    fn geometry(&self, room: &Room, ticker: &Ticker) -> Result<RoomGeometry, Stop>;
    /// Makes people; previews are the people as they are so far.
    ///
    /// # Errors
    /// Why nobody could be made; or cancelled.
    fn populate(&self, task: &PopulateTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop>;
    /// Measures one body.
    ///
    /// # Errors
    /// Cancelled.
    fn measure(
        &self,
        geometry: &RoomGeometry,
        body: &BodyParams,
        ticker: &Ticker,
    ) -> Result<BodyReport, Stop>;
    /// Vertices of a body in metres, world frame. Below a millisecond, so the window calls it itself.
    fn pose(&self, body: &BodyParams) -> Arc<[Vec3]>;
    /// How the vertices of [`Engine::pose`] join to triangles.
    fn faces(&self) -> Arc<[[u32; 3]]>;
    /// The surface for the renderer.
    fn surface(&self) -> Arc<BodySurface>;
}
