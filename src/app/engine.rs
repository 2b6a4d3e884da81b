//! The work that the window asks others for, behind one trait, so that tests can put slow, failing and
//! panicking work in its place.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;

use super::lived::{ActionChoice, LivedRoom};
use crate::assets::Model;
use crate::assets::PersonKeypoints;
use crate::document::NextIds;
use crate::document::Project;
use crate::evolve::PopulatePreview;
use crate::evolve::day::Track;
use crate::generate::sensor::SceneImage;
use crate::inspect::BodyReport;
use crate::inspect::MotionReport;
use crate::job::{JobCtx, Seed, Stop, Ticker};
use crate::render::BodySurface;
use crate::render::Picture;
use crate::scene::BETAS;
use crate::scene::BodyParams;
use crate::scene::Camera;
use crate::scene::Clip;
use crate::scene::Frame;
use crate::scene::Person;
use crate::scene::PoseFamily;
use crate::scene::Room;
use crate::scene::RoomGeometry;
use crate::scene::Scene;
use crate::scene::SubGoal;
use crate::scene::SubGoalId;
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
    /// A room that the program makes.
    Made(RoomRequest),
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
    /// The ids that are free.
    pub next: NextIds,
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

/// Where samples of people come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SampleMethod {
    /// Looks for places that hold a body; uses no network.
    #[default]
    Search,
    /// PSI's one-stage network.
    S1,
    /// PSI's two-stage network.
    S2,
    /// The modified network of Li et al. that PSI compares with.
    Baseline,
    /// Found in a photo; not on the menu of samplers.
    Photo,
}

impl SampleMethod {
    /// Every method, in the order of the menu.
    pub const ALL: [Self; 4] = [Self::Search, Self::S1, Self::S2, Self::Baseline];

    /// Name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Search => "Search",
            Self::S1 => "Network S1",
            Self::S2 => "Network S2",
            Self::Baseline => "Baseline network",
            Self::Photo => "Photo",
        }
    }

    /// Name on the command line.
    pub fn key(self) -> &'static str {
        match self {
            Self::Search => "search",
            Self::S1 => "s1",
            Self::S2 => "s2",
            Self::Baseline => "baseline",
            Self::Photo => "photo",
        }
    }

    /// What it is good at, for somebody who has never heard of it.
    pub fn strength(self) -> &'static str {
        match self {
            Self::Search => {
                "Goes over the room's geometry for seats, beds, free floor and things to lean on. Knows the whole \
                 room, hardly ever floats or sinks; poses come from a fixed repertoire. Take this when in doubt."
            }
            Self::S1 => {
                "Learned where and how people are from what a camera sees: depth and kinds of things. Draws place \
                 and pose together, so both suit each other. The most natural variety within one view."
            }
            Self::S2 => {
                "Learned like S1, but first decides where somebody is and then how. More places over the whole \
                 view, now and then a pose that suits its place less."
            }
            Self::Baseline => {
                "An older network to compare with: picks a place, then one of a few learned pose classes. Coarser; \
                 its bodies need the most fitting."
            }
            Self::Photo => "Found in a photo by its keypoints.",
        }
    }
}

/// From where a room is looked at for samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleView {
    /// The editor's camera, with a picture so many times as wide as high.
    Camera(Camera, f32),
    /// Somebody 1.8 m tall who stands somewhere in the room and looks a little down (PSI §4.1.1); where, follows
    /// from the seed.
    Agent,
}

/// People to sample from what one view shows; an owned snapshot.
#[derive(Clone)]
pub struct SampleTask {
    /// The room.
    pub room: Arc<Room>,
    /// What its geometry says.
    pub geometry: Arc<RoomGeometry>,
    /// From where.
    pub view: SampleView,
    /// By what.
    pub method: SampleMethod,
    /// How many.
    pub count: usize,
}

/// Somebody who might be put into the room, as sampled: nothing is fitted yet.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Who; the id means nothing.
    pub person: Person,
    /// What was measured.
    pub report: BodyReport,
}

/// What came of a [`SampleTask`].
#[derive(Clone, Debug)]
pub struct Sampled {
    /// Depth and semantics as the networks take them.
    pub seen: Arc<SceneImage>,
    /// Who, in the order they were drawn.
    pub candidates: Vec<Candidate>,
    /// Why there are fewer than asked for.
    pub shortfall: Option<String>,
}

/// People to be fitted to the room from where they are.
#[derive(Clone)]
pub struct FitTask {
    /// The room.
    pub room: Arc<Room>,
    /// What its geometry says.
    pub geometry: Arc<RoomGeometry>,
    /// Who.
    pub people: Vec<Person>,
    /// Whoever would end in one of these, or in somebody before them, is left out; nobody is when `None`.
    pub clear_of: Option<Vec<Person>>,
    /// Whether it is known what they do ([`Person::family`] and [`Person::on`]); else it is found out.
    pub knows_family: bool,
}

/// How a person of a photo is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PhotoMethod {
    /// By keypoints, the room, and what people do in this view (PSI §4.2).
    #[default]
    Scene,
    /// By keypoints and the room (PROX).
    Room,
    /// By keypoints alone (SMPLify-X).
    Keypoints,
}

/// A photo with keypoints.
#[derive(Clone, Debug)]
pub struct Photo {
    /// Its pixels, perhaps fewer than the file's.
    pub picture: Picture,
    /// Columns and rows of the file, which the keypoints are in.
    pub size_px: [u32; 2],
    /// Everybody who has keypoints.
    pub people: Vec<PersonKeypoints>,
}

/// A person of a photo to be found in the room; an owned snapshot.
#[derive(Clone)]
pub struct PhotoTask {
    /// The room.
    pub room: Arc<Room>,
    /// What its geometry says.
    pub geometry: Arc<RoomGeometry>,
    /// The camera that took the photo.
    pub camera: Camera,
    /// Columns and rows.
    pub size_px: [u32; 2],
    /// The person in it.
    pub keypoints: PersonKeypoints,
    /// How it is found.
    pub method: PhotoMethod,
    /// Number of the new person.
    pub id: u32,
}

/// What is wanted of a room that the program makes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RoomRequest {
    /// Number of its kind in [`Engine::room_kinds`].
    pub kind: usize,
    /// The same seed gives the same room.
    pub seed: u64,
}

/// A kind of thing that actions bring.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ThingKind {
    /// Its name.
    pub kind: String,
    /// How many a room takes.
    pub most: usize,
    /// How many models of it are bundled.
    pub models: usize,
}

/// What a thing looks like.
#[derive(Clone, Debug)]
pub struct ThingPicture {
    /// A small picture of it.
    pub picture: Picture,
    /// Width, height and depth in metres.
    pub size_m: Vec3,
}

/// One curve of a training.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What went down.
    pub name: String,
    /// (epoch, value).
    pub points: Vec<[f64; 2]>,
}

/// A bundled network and how it came about, or what was measured of several (then without curves).
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkCard {
    /// Name for people.
    pub name: String,
    /// What it was trained on, by which command, its figures: Markdown.
    pub text: String,
    /// Losses over the epochs.
    pub curves: Vec<Curve>,
    /// What else was measured on the validation data after each epoch.
    pub measures: Vec<Curve>,
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
    /// The bodies before they were fitted, in the order of `people`; may be shorter.
    pub before: Vec<BodyParams>,
    /// Why fewer people came than were asked for.
    pub shortfall: Option<String>,
}

/// How a motion is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MotionMethod {
    /// Steps and postures by rules learned from captured walks.
    #[default]
    Gait,
    /// RouteNet and PoseNet (LTM §3.3).
    Learned,
    /// Pieces of captured motion, blended (HSNMS-like).
    Retrieval,
    /// RouteNet, and a body for each frame by the sub-goal network (LTM §4.2).
    RouteCvae,
}

impl MotionMethod {
    /// Every method, in the order of the menu.
    pub const ALL: [Self; 4] = [Self::Gait, Self::Learned, Self::Retrieval, Self::RouteCvae];

    /// Name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Gait => "Steps by rule",
            Self::Learned => "Networks (RouteNet, PoseNet)",
            Self::Retrieval => "Captured pieces",
            Self::RouteCvae => "Route + CVAE",
        }
    }

    /// Name on the command line.
    pub fn key(self) -> &'static str {
        match self {
            Self::Gait => "gait",
            Self::Learned => "learned",
            Self::Retrieval => "retrieval",
            Self::RouteCvae => "cvae",
        }
    }

    /// What it is good at, for somebody who has never heard of it.
    pub fn strength(self) -> &'static str {
        match self {
            Self::Gait => {
                "Plans every footstep along the way and swings the body over it with the rhythm of captured walks. Feet \
                 stay where they tread, turns and stops are exact. Take this when in doubt."
            }
            Self::Learned => {
                "Two networks: the first draws the way, the second the poses along it, both with an eye on the room. \
                 More variety with every seed, feet less exact."
            }
            Self::Retrieval => {
                "Looks for captured pieces that begin and end nearly right and blends them together. The most natural \
                 details, where a fitting piece exists."
            }
            Self::RouteCvae => {
                "To compare with: the same network's way, but a body for each frame by itself. Every frame is \
                 plausible, the motion is not smooth."
            }
        }
    }
}

/// A motion to be made; an owned snapshot.
#[derive(Clone)]
pub struct MoveTask {
    /// The room.
    pub room: Arc<Room>,
    /// What its geometry says.
    pub geometry: Arc<RoomGeometry>,
    /// Sub-goals, body shape and seed; and, where it was made before, the frames, whose legs are kept where
    /// nothing has changed.
    pub clip: Clip,
    /// By what.
    pub method: MotionMethod,
    /// Sub-goals whose bodies are to be others than they are.
    pub anew: Vec<SubGoalId>,
    /// Who else moves, and must not be walked into.
    pub others: Vec<Arc<Clip>>,
    /// Who stays where they are, and must not be walked into.
    pub people: Vec<Person>,
    /// Folder of clips to look pieces up in, for [`MotionMethod::Retrieval`].
    pub clips: Option<PathBuf>,
}

/// A motion while it is being made: whole, but not as good as it will be.
#[derive(Clone, Debug)]
pub struct MovePreview {
    /// The motion.
    pub clip: Arc<Clip>,
}

/// What came of a [`MoveTask`].
#[derive(Clone, Debug, Default)]
pub struct Moved {
    /// The motion.
    pub clip: Clip,
    /// What was measured.
    pub report: Option<MotionReport>,
    /// What the user should know: sub-goals that were not met, narrow places.
    pub remarks: Vec<String>,
}

/// A file format of motions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionFormat {
    /// Animated, skinned GLB of the people.
    #[default]
    Glb,
    /// The same with the room.
    GlbWithRoom,
    /// Biovision hierarchy.
    Bvh,
    /// AMASS-like NumPy archive.
    Amass,
    /// Animated GIF.
    Gif,
    /// A folder of PNG pictures.
    Pictures,
}

impl MotionFormat {
    /// Every format, in the order of the menu.
    pub const ALL: [Self; 6] =
        [Self::Glb, Self::GlbWithRoom, Self::Bvh, Self::Amass, Self::Gif, Self::Pictures];

    /// Name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Glb => "Animated GLB",
            Self::GlbWithRoom => "Animated GLB with room",
            Self::Bvh => "BVH",
            Self::Amass => "AMASS npz",
            Self::Gif => "GIF",
            Self::Pictures => "PNG sequence",
        }
    }

    /// Ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Glb | Self::GlbWithRoom => "glb",
            Self::Bvh => "bvh",
            Self::Amass => "npz",
            Self::Gif => "gif",
            Self::Pictures => "png",
        }
    }

    /// What it is for.
    pub fn purpose(self) -> &'static str {
        match self {
            Self::Glb => {
                "Skinned, dressed people that play in Blender and in game engines. In Blender, set the scene to the clip's frames a second first."
            }
            Self::GlbWithRoom => "The same with the room around them, in one file.",
            Self::Bvh => "The skeleton alone, for motion tools: metres, Y up, one file for each motion.",
            Self::Amass => {
                "Pose parameters as researchers exchange them (SMPL+H, Z up), one file for each motion."
            }
            Self::Gif => "What the view shows, 15 pictures a second, for a page or a message.",
            Self::Pictures => "What the view shows, a picture for each frame, for a film.",
        }
    }
}

/// What happens to the room while motions play: nothing, or what a day brings and moves.
#[derive(Clone, Debug, Default)]
pub struct RoomChanges {
    /// How things come and move, in the last room.
    pub tracks: Vec<Track>,
    /// The rooms one after the other, and from when on each is there, seconds; the first from the beginning.
    pub rooms: Vec<(f32, Arc<Room>)>,
}

/// Motions to be written; an owned snapshot.
#[derive(Clone)]
pub struct MotionExport {
    /// As what.
    pub format: MotionFormat,
    /// Room and people.
    pub scene: Scene,
    /// The motions.
    pub clips: Vec<Arc<Clip>>,
    /// What the room does meanwhile; it ends as the scene's room.
    pub changes: RoomChanges,
    /// From where pictures are taken.
    pub camera: Camera,
    /// Columns and rows of pictures.
    pub size: [u32; 2],
}

/// The work of the window. Everything but [`Engine::pose`] and what says so runs in a job.
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
    /// Writes room and people for other programs into a folder; how many files.
    ///
    /// # Errors
    /// What, which file, what to do; or cancelled.
    fn export(&self, folder: &Path, scene: &Scene, ticker: &Ticker) -> Result<usize, Stop>;
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
    /// Which methods can't be used, and why.
    fn missing_methods(&self) -> Vec<(SampleMethod, String)>;
    /// What a view shows, as the networks take it.
    ///
    /// # Errors
    /// Why it can't be seen; or cancelled.
    fn see(
        &self,
        room: &Room,
        geometry: &RoomGeometry,
        view: &SampleView,
        seed: Seed,
        ticker: &Ticker,
    ) -> Result<SceneImage, Stop>;
    /// Samples people and measures them; previews are those that are there so far.
    ///
    /// # Errors
    /// Why there are none; or cancelled.
    fn sample(&self, task: &SampleTask, cx: &JobCtx<PopulatePreview>) -> Result<Sampled, Stop>;
    /// Fits people to the room; previews are the people as they are so far.
    ///
    /// # Errors
    /// Why they can't be fitted; or cancelled.
    fn fit(&self, task: &FitTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop>;
    /// Reads a photo and its keypoints.
    ///
    /// # Errors
    /// What, which file and place, what to do; or cancelled.
    fn open_photo(&self, picture: &Path, keypoints: &Path, ticker: &Ticker) -> Result<Photo, Stop>;
    /// Finds a person of a photo; previews are the person as it is so far.
    ///
    /// # Errors
    /// Why it can't be found; or cancelled.
    fn fit_photo(&self, task: &PhotoTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop>;
    /// A small picture of somebody in the room.
    ///
    /// # Errors
    /// Why it can't be drawn; or cancelled.
    fn portrait(
        &self,
        room: &Room,
        geometry: &RoomGeometry,
        person: &Person,
        ticker: &Ticker,
    ) -> Result<Picture, Stop>;
    /// Names of the kinds of rooms that can be made.
    fn room_kinds(&self) -> Vec<String>;
    /// Makes a room.
    ///
    /// # Errors
    /// Why it can't be made; or cancelled.
    fn make_room(&self, request: &RoomRequest, ticker: &Ticker) -> Result<Opened, Stop>;
    /// A picture of a whole room.
    ///
    /// # Errors
    /// Why it can't be drawn; or cancelled.
    fn overview(&self, room: &Arc<Room>, ticker: &Ticker) -> Result<Picture, Stop>;
    /// The bundled networks.
    fn networks(&self) -> Arc<[NetworkCard]>;
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
    /// The same of a motion's frame.
    fn pose_frame(&self, betas: &[f32; BETAS], frame: &Frame) -> Arc<[Vec3]>;
    /// Makes a motion; previews are the motion as it is so far.
    ///
    /// # Errors
    /// Why it can't be made; or cancelled.
    fn synthesise(&self, task: &MoveTask, cx: &JobCtx<MovePreview>) -> Result<Moved, Stop>;
    /// Measures every frame of a motion.
    ///
    /// # Errors
    /// Cancelled.
    fn measure_clip(
        &self,
        geometry: &RoomGeometry,
        clip: &Clip,
        ticker: &Ticker,
    ) -> Result<MotionReport, Stop>;
    /// Whether one gets to a sub-goal from the one before it; called by the window itself while the sub-goal is
    /// dragged, so it takes a few milliseconds.
    ///
    /// # Errors
    /// What is in the way, in words.
    fn reach(&self, room: &Room, geometry: &RoomGeometry, clip: &Clip, goal: SubGoalId)
    -> Result<(), String>;
    /// Somebody at a sub-goal whose body is not made yet, to look at. Called by the window itself: milliseconds.
    fn stand_in(&self, goal: &SubGoal, betas: &[f32; BETAS]) -> Frame;
    /// Writes motions for other programs; how many files.
    ///
    /// # Errors
    /// What, which file, what to do; or cancelled.
    fn export_motion(&self, path: &Path, export: &MotionExport, ticker: &Ticker) -> Result<usize, Stop>;
    /// Looks at a room: what can be done in it.
    ///
    /// # Errors
    /// Why it can't be said; or cancelled.
    fn look_for_actions(
        &self,
        room: &Arc<Room>,
        choice: &ActionChoice,
        seed: u64,
        ticker: &Ticker,
    ) -> Result<Arc<dyn LivedRoom>, Stop>;
    /// The kinds of things that actions bring.
    fn thing_kinds(&self) -> Vec<ThingKind>;
    /// Draws the first model of a kind.
    ///
    /// # Errors
    /// Why it can't be drawn; or cancelled.
    fn thing_picture(&self, kind: &str, ticker: &Ticker) -> Result<ThingPicture, Stop>;
    /// Reads a model of the user's own, in the file's frame.
    ///
    /// # Errors
    /// What, which file and place, what to do; or cancelled.
    fn read_thing(&self, path: &Path, ticker: &Ticker) -> Result<Model, Stop>;
    /// Draws a model in metres, upright, as somebody sees it who stands before it.
    ///
    /// # Errors
    /// Why it can't be drawn; or cancelled.
    fn model_picture(&self, model: &Model, ticker: &Ticker) -> Result<ThingPicture, Stop>;
    /// How the vertices of [`Engine::pose`] join to triangles.
    fn faces(&self) -> Arc<[[u32; 3]]>;
    /// The surface for the renderer.
    fn surface(&self) -> Arc<BodySurface>;
}
