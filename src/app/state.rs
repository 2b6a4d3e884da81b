//! Everything the window knows, apart from how it looks: can be driven without a window.

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec3;

use super::engine::{Energies, Engine, ImportSummary};
use super::jobs::Jobs;
use super::learned::LearnedPage;
use super::living::Living;
use super::motion::MotionPanel;
use super::notices::Notices;
use super::orbit::Orbit;
use super::photo::PhotoPanel;
use super::rooms::NewRoom;
use super::samples::{Origin, Seen, Sheet};
use super::selection::{Item, Selection};
use super::study::{StudyRun, StudySetup};
use super::things::Things;
use super::transform::Transform;
use crate::document::Command;
use crate::document::Document;
use crate::document::RoomVersion;
use crate::inspect::BodyReport;
use crate::inspect::Finding;
use crate::inspect::Limits;
use crate::inspect::Site;
use crate::math::Aabb;
use crate::scene::BodyParams;
use crate::scene::Person;
use crate::scene::PersonId;
use crate::scene::PoseFamily;
use crate::scene::RoomGeometry;

/// What a click in the viewport does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Selects.
    #[default]
    Select,
    /// Puts somebody where it is clicked.
    PutHere,
    /// Places a sub-goal where it is pressed; a drag says which way it faces.
    AddGoal,
}

/// What bodies are coloured by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heat {
    /// Their clothes.
    #[default]
    Off,
    /// Distance to the room: contact and penetration.
    Distance,
}

/// What lies over the window; one thing at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Overlay {
    /// Nothing.
    #[default]
    None,
    /// The command palette with what was typed and the marked row.
    Palette {
        /// What was typed.
        query: String,
        /// The marked row.
        row: usize,
    },
    /// Every key.
    Shortcuts,
    /// The first steps.
    Help,
    /// Open by typing a path.
    OpenPath(String),
    /// Save by typing a path.
    SavePath(String),
    /// The import report.
    Import,
    /// The undo history.
    History,
    /// Everything that was said.
    Notifications,
    /// A new name for an item.
    Rename(Item, String),
    /// Export by typing a folder.
    ExportPath(String),
    /// Offers the work of a session that did not end on purpose.
    Recover(PathBuf),
    /// Asks before unsaved changes are lost.
    Unsaved(Leaving),
    /// A room that the program makes.
    NewRoom,
    /// Export of motions: format and path.
    ExportMotion,
    /// What a study with human raters is to show.
    Study,
    /// A file that was dropped: a room or a thing.
    Dropped(PathBuf),
    /// A thing of the user's own, by typing its path.
    ThingPath(String),
    /// Kind, size and front of a thing that is being added.
    AddThing,
    /// What was learned of actions: the graph, or the node with this number.
    Learned(Option<usize>),
    /// The bundled networks: curves and figures of the one with this number.
    Networks(usize),
}

impl Overlay {
    /// Whether keys belong to it: it has a field or asks something.
    pub fn takes_keys(&self) -> bool {
        !matches!(
            self,
            Self::None
                | Self::Shortcuts
                | Self::Help
                | Self::Import
                | Self::History
                | Self::Notifications
                | Self::Networks(_)
                | Self::Learned(_)
        )
    }
}

/// What would lose unsaved changes.
#[derive(Clone, Debug, PartialEq)]
pub enum Leaving {
    /// Closing the window.
    Quit,
    /// Opening a project, which replaces the history.
    Open(super::engine::Source),
}

/// What is generated.
#[derive(Clone, Debug, PartialEq)]
pub struct PopulateOptions {
    /// How many people.
    pub people: usize,
    /// Families that may come.
    pub families: BTreeSet<PoseFamily>,
    /// Root of the seed tree.
    pub seed: u64,
    /// People who were moved by hand are fitted to where they are now.
    pub settle: bool,
}

impl Default for PopulateOptions {
    fn default() -> Self {
        Self { people: 6, families: PoseFamily::ALL.into_iter().collect(), seed: 1, settle: true }
    }
}

/// How the viewport looks.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewOptions {
    /// What bodies are coloured by.
    pub heat: Heat,
    /// The metre grid is drawn.
    pub grid: bool,
    /// Walls between camera and room are left out.
    pub cutaway: bool,
    /// Dark theme.
    pub dark: bool,
    /// Only these are drawn, if set.
    pub isolated: Option<BTreeSet<Item>>,
    /// The active person's body before its fit is drawn as a ghost.
    pub before: bool,
}

impl Default for ViewOptions {
    fn default() -> Self {
        Self { heat: Heat::Off, grid: true, cutaway: true, dark: true, isolated: None, before: false }
    }
}

/// Things that only the window can do, asked for by commands and done at the next frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WindowRequests {
    /// Close.
    pub close: bool,
    /// Ask for a file to open.
    pub open_dialog: bool,
    /// Ask for a file to save to.
    pub save_dialog: bool,
    /// Ask for a folder to export to.
    pub export_dialog: bool,
    /// Switch full screen.
    pub full_screen: bool,
    /// Put the panels back.
    pub reset_layout: bool,
    /// Bring the contact sheet to the front.
    pub show_sheet: bool,
    /// Bring *Why like this* to the front.
    pub show_why: bool,
    /// Bring *Sample* to the front.
    pub show_sample: bool,
    /// Bring *Photo* to the front.
    pub show_photo: bool,
    /// Bring *Motion* to the front.
    pub show_motion: bool,
    /// Bring *Actions* to the front.
    pub show_actions: bool,
    /// Bring the timeline to the front.
    pub show_timeline: bool,
    /// Ask for a photo (false) or its keypoints (true).
    pub photo_dialog: Option<bool>,
    /// Ask for a model of the user's own.
    pub thing_dialog: bool,
    /// Ask for a folder of motion clips.
    pub clips_dialog: bool,
}

/// A measured body: valid for exactly this body in exactly this room.
#[derive(Clone, Debug)]
pub struct Measured {
    body: BodyParams,
    version: RoomVersion,
    /// The numbers.
    pub report: Arc<BodyReport>,
    /// Signed distance of every vertex, shared with the renderer.
    pub distances_m: Arc<[f32]>,
    /// How its fit went, if it was made here.
    pub energies: Arc<Energies>,
}

/// The editor apart from its window.
pub struct EditorState {
    /// The scene and its history.
    pub document: Document,
    /// Who and what is selected.
    pub selection: Selection,
    /// The camera.
    pub orbit: Orbit,
    /// What was said.
    pub notices: Notices,
    /// What runs.
    pub jobs: Jobs,
    /// What is generated.
    pub populate: PopulateOptions,
    /// How it looks.
    pub view: ViewOptions,
    /// What a click does.
    pub tool: Tool,
    /// What is being moved by hand.
    pub transform: Option<Transform>,
    /// What lies over the window.
    pub overlay: Overlay,
    /// What was understood of the room's file.
    pub import: Option<ImportSummary>,
    /// The file that *Save* writes.
    pub project: Option<PathBuf>,
    /// Where unsaved work is kept against crashes: never the user's project.
    pub autosave: Option<PathBuf>,
    /// Files opened lately, the newest first.
    pub recent: Vec<PathBuf>,
    /// People as the running job has them so far.
    pub ghosts: Vec<Person>,
    /// Candidates that were sampled from a view.
    pub sheet: Sheet,
    /// What a network would see from here, when it was last asked.
    pub look: Option<Arc<Seen>>,
    /// The photo over the view.
    pub photo: PhotoPanel,
    /// The room that is being made.
    pub new_room: NewRoom,
    /// Motions: what is made, played and shown of them.
    pub motion: MotionPanel,
    /// Who was made last, for re-rolls without a selection.
    pub last_made: Vec<PersonId>,
    /// What people do in the room, and its futures.
    pub living: Living,
    /// The library of things that actions bring.
    pub things: Things,
    /// The page of what was learned of actions.
    pub learned: LearnedPage,
    /// The next study with human raters.
    pub study_setup: StudySetup,
    /// The study that runs.
    pub study: Option<StudyRun>,
    /// What the window is to do.
    pub requests: WindowRequests,
    /// Width over height of the viewport, for framing.
    pub aspect: f32,
    /// Rises with every measurement: the heat map changes with it.
    pub measurements: u64,
    /// Number of the finding looked at last.
    pub finding: Option<usize>,
    pub(super) geometry: Option<(RoomVersion, Arc<RoomGeometry>)>,
    pub(super) measured: BTreeMap<PersonId, Measured>,
    pub(super) origins: BTreeMap<PersonId, Arc<Origin>>,
    pub(super) engine: Arc<dyn Engine>,
    pub(super) wake: Arc<dyn Fn() + Send + Sync>,
}

impl EditorState {
    /// An editor without a room. `wake` asks for another frame and may be called from any thread.
    pub fn new(engine: Arc<dyn Engine>, wake: Arc<dyn Fn() + Send + Sync>) -> Self {
        Self {
            document: Document::default(),
            selection: Selection::default(),
            orbit: Orbit::default(),
            notices: Notices::default(),
            jobs: Jobs::default(),
            populate: PopulateOptions::default(),
            view: ViewOptions::default(),
            tool: Tool::default(),
            transform: None,
            overlay: Overlay::default(),
            import: None,
            project: None,
            autosave: None,
            recent: Vec::new(),
            ghosts: Vec::new(),
            sheet: Sheet::default(),
            look: None,
            photo: PhotoPanel::default(),
            new_room: NewRoom::default(),
            motion: MotionPanel::default(),
            last_made: Vec::new(),
            living: Living::new(),
            things: Things::default(),
            learned: LearnedPage::default(),
            study_setup: StudySetup::default(),
            study: None,
            requests: WindowRequests::default(),
            aspect: 1.5,
            measurements: 0,
            finding: None,
            geometry: None,
            measured: BTreeMap::new(),
            origins: BTreeMap::new(),
            engine,
            wake,
        }
    }

    /// Whether a room is open.
    pub fn has_room(&self) -> bool {
        !self.document.scene().room.objects.is_empty()
    }

    /// The work behind the window.
    pub fn engine(&self) -> &Arc<dyn Engine> {
        &self.engine
    }

    /// The geometry of the room as it is now, once it is built.
    pub fn geometry(&self) -> Option<&Arc<RoomGeometry>> {
        let (version, geometry) = self.geometry.as_ref()?;
        (*version == self.document.room_version()).then_some(geometry)
    }

    /// Where a person came from, if that is known: who was made in this session.
    pub fn origin(&self, id: PersonId) -> Option<&Arc<Origin>> {
        self.origins.get(&id)
    }

    /// Everybody who is drawn but not there: people being fitted, the chosen candidate, the active person
    /// before the fit.
    pub fn shown_ghosts(&self) -> Vec<Person> {
        let mut ghosts = self.ghosts.clone();
        ghosts.extend(self.sheet.chosen_card().map(|card| card.person.clone()));
        let active = self.selection.active_person().filter(|_| self.view.before);
        let person = active.and_then(|id| self.document.scene().person(id));
        if let Some((person, origin)) = person.and_then(|person| Some((person, self.origin(person.id)?))) {
            ghosts.push(Person { body: origin.before.clone(), ..person.clone() });
        }
        ghosts
    }

    /// Does `command` and says so when it is refused. Whether anything changed.
    pub fn apply(&mut self, command: Command) -> bool {
        let label = command.label();
        let changed = match self.document.apply(command) {
            Ok(change) => change.is_some(),
            Err(refused) => {
                self.notices.error(format!("{label}: not done"), refused.to_string());
                false
            }
        };
        if changed {
            self.prune();
        }
        changed
    }

    /// Forgets what is no longer in the scene.
    pub(super) fn prune(&mut self) {
        self.selection.prune(self.document.scene());
        self.prune_motion();
    }

    /// Whether there is work that no file holds: people or motions.
    pub fn has_unsaved_work(&self) -> bool {
        let scene = self.document.scene();
        self.document.is_dirty() && !(scene.people.is_empty() && scene.clips.is_empty())
    }

    /// What was measured of a person, if it still holds.
    pub fn measured(&self, id: PersonId) -> Option<&Measured> {
        let measured = self.measured.get(&id)?;
        let person = self.document.scene().person(id)?;
        let holds = measured.version == self.document.room_version() && measured.body == person.body;
        holds.then_some(measured)
    }

    /// Signed distance of every vertex of a person to paint them by. While they are being moved those measured last
    /// will do: the next ones are under way.
    pub fn shown_distances_m(&self, id: PersonId) -> Option<Arc<[f32]>> {
        let moved = self.transform.as_ref().is_some_and(|t| t.holds(id));
        let measured = if moved { self.measured.get(&id) } else { self.measured(id) };
        let wanted = moved || self.view.heat == Heat::Distance;
        measured.filter(|_| wanted).map(|m| m.distances_m.clone())
    }

    /// Keeps what was measured of `person` in the room of `version`.
    pub(super) fn keep_measured(
        &mut self,
        person: &Person,
        version: RoomVersion,
        report: BodyReport,
        energies: Energies,
    ) {
        let distances_m = report.signed_distances_m.as_slice().into();
        let energies = Arc::new(energies);
        let measured =
            Measured { body: person.body.clone(), version, report: Arc::new(report), distances_m, energies };
        self.measured.insert(person.id, measured);
        self.measurements += 1;
    }

    /// Forgets a measurement, so that it is made again.
    pub(super) fn forget_measured(&mut self, id: PersonId) {
        self.measured.remove(&id);
    }

    /// People that have not been measured as they are.
    pub fn unmeasured(&self) -> Vec<Person> {
        let people = &self.document.scene().people;
        people.iter().filter(|p| self.measured(p.id).is_none()).cloned().collect()
    }

    /// Everything above its limit, the worst first.
    pub fn findings(&self) -> Vec<Finding> {
        let limits = Limits::default();
        let people = &self.document.scene().people;
        let mut findings: Vec<Finding> = people
            .iter()
            .filter_map(|p| self.measured(p.id).map(|m| (p.id, m)))
            .flat_map(|(id, m)| limits.findings(Site { body: id.0, frame: None }, &m.report.metrics))
            .collect();
        findings.sort_by(|a, b| b.severity().total_cmp(&a.severity()));
        findings
    }

    /// Whether anything is above its limit.
    pub fn has_findings(&self) -> bool {
        !self.findings().is_empty() || !self.worst_clip_findings().is_empty()
    }

    /// The box around an item in the world frame; empty if it is gone.
    pub fn bounds_of(&self, item: Item) -> Aabb {
        let scene = self.document.scene();
        match item {
            Item::Person(id) => scene
                .person(id)
                .map_or(Aabb::EMPTY, |person| Aabb::of(self.engine.pose(&person.body).iter().copied())),
            Item::Object(id) => scene.room.object(id).map_or(Aabb::EMPTY, crate::scene::Object::world_bounds),
            Item::Clip(id) => self.clip_bounds(id),
            Item::Goal(clip, goal) => self.goal(clip, goal).map_or(Aabb::EMPTY, goal_bounds),
        }
    }
}

/// Room for somebody at a sub-goal.
fn goal_bounds(goal: &crate::scene::SubGoal) -> Aabb {
    Aabb { min: goal.at - Vec3::new(0.4, 0.0, 0.4), max: goal.at + Vec3::new(0.4, 1.7, 0.4) }
}
