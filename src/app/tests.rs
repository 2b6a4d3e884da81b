//! The window in the user's words, driven without a screen; work behind it is replaced by work that is quick,
//! endless or breaks, as a test needs it.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable as _};
use glam::{Affine3A, Vec3};

use super::autosave::Autosave;
use super::engine::{
    Candidate, Curve, Engine, FitTask, ImportSummary, Made, NetworkCard, Opened, Photo, PhotoTask,
    PopulateTask, RoomRequest, SampleMethod, SampleTask, SampleView, Sampled, Source,
};
use super::samples::Fate;
use super::selection::Item;
use super::state::{EditorState, Leaving, Overlay, Tool};
use super::window::Window;
use crate::assets::{Keypoint, KeypointSet, Material, Mesh, PersonKeypoints};
use crate::body::Body;
use crate::document::{Command, Project};
use crate::evolve::PopulatePreview;
use crate::generate::sensor::{Intrinsics, SIDE, SceneImage, Valid, View};
use crate::inspect::BodyReport;
use crate::job::{JobCtx, Seed, Stop, Ticker};
use crate::render::{BodySurface, Picture};
use crate::scene::{
    BodyParams, Category, FieldConfig, GeometryConfig, Object, ObjectId, ObjectPart, Person, PersonId,
    PoseFamily, Resolution, Room, RoomGeometry, Scene, UpAxis, bake,
};

/// How making people goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Making {
    /// At once.
    #[default]
    Quick,
    /// On and on, until cancelled.
    Endless,
    /// On and on; when cancelled, the first one is there.
    FirstThenEndless,
    /// With a fault of the program.
    Breaks,
}

#[derive(Default)]
struct FakeEngine {
    making: Mutex<Making>,
    /// Files that were saved, with the number of people in each.
    saved: Mutex<Vec<(PathBuf, usize)>>,
}

fn somebody(id: u32) -> Person {
    Person {
        id: PersonId(id),
        name: format!("Person {}", id + 1),
        body: BodyParams { translation: Vec3::new(0.0, 1.0, 0.0), ..BodyParams::default() },
        family: PoseFamily::Stand,
        on: "floor".to_owned(),
        seed: 1,
        palette: 0,
        visible: true,
        locked: false,
    }
}

/// A good body but for this penetration.
fn measured_mm(penetration_max_mm: f32) -> BodyReport {
    let mut report = BodyReport::default();
    report.metrics.psi_non_collision = 1.0;
    report.metrics.contact_2cm = true;
    report.metrics.supported = true;
    report.metrics.penetration_max_mm = penetration_max_mm;
    report
}

fn thing(id: u32, name: &str, category: Category, height_m: f32) -> Object {
    let corner = |x: f32, z: f32| Vec3::new(x, height_m, z);
    let mesh = Mesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        ..Mesh::default()
    };
    let part = ObjectPart { mesh: Arc::new(mesh), material: 0, object_from_mesh: Affine3A::IDENTITY };
    Object {
        id: ObjectId(id),
        name: name.to_owned(),
        category,
        parts: vec![part],
        world_from_object: Affine3A::IDENTITY,
        visible: true,
        locked: false,
    }
}

/// What a camera in a wide room without furniture sees.
fn seen() -> SceneImage {
    let intrinsics = Intrinsics { width: 128, height: 72, focal_px: 100.0 };
    let view = View::look_at(Vec3::new(0.0, 1.6, 0.0), Vec3::new(0.0, 1.0, 2.0), intrinsics);
    let valid = Valid { left: 0, top: 28, width: 128, height: 72 };
    let place = |i: usize| (i % SIDE, i / SIDE);
    let inside = |i: usize| (28..100).contains(&place(i).1);
    let depth_m = (0..SIDE * SIDE).map(|i| if inside(i) { 1.0 + place(i).1 as f32 * 0.03 } else { 0.0 });
    let labels = (0..SIDE * SIDE).map(|i| if inside(i) { 1 + (place(i).0 / 32) as u8 } else { 0 });
    SceneImage::new(view, valid, depth_m.collect(), labels.collect())
}

fn grey_picture() -> Picture {
    Picture { width: 8, height: 8, rgba: vec![128; 8 * 8 * 4], backend: "nobody".to_owned() }
}

impl Engine for FakeEngine {
    fn samples(&self) -> Vec<String> {
        vec!["Study".to_owned()]
    }

    fn open(&self, source: &Source, _: &Ticker) -> Result<Opened, Stop> {
        if let Source::File(path, _) = source {
            return Err(Stop::Failed(format!("{}, byte 0: the file is empty", path.display())));
        }
        let objects =
            vec![thing(0, "Oak floor", Category::Floor, 0.0), thing(1, "Red sofa", Category::Sofa, 0.4)];
        let materials = vec![Material::default()];
        let room = Room { name: "Study".to_owned(), objects, materials, textures: Vec::new() };
        let summary = ImportSummary {
            source: source.clone(),
            name: "Study".to_owned(),
            unit_m: 1.0,
            up: UpAxis::Y,
            triangles: 4,
            objects: 2,
            extent_m: room.bounds().size(),
            evidence: vec!["The unit is the metre.".to_owned()],
            notes: vec!["One empty mesh was left out.".to_owned()],
        };
        Ok(Opened { scene: Scene { room: Arc::new(room), ..Scene::default() }, summary, project: None })
    }

    fn save(&self, path: &Path, project: &Project, _: &Ticker) -> Result<(), Stop> {
        self.saved.lock().unwrap().push((path.to_owned(), project.scene.people.len()));
        Ok(())
    }

    fn export(&self, _: &Path, scene: &Scene, _: &Ticker) -> Result<usize, Stop> {
        Ok(1 + scene.people.len())
    }

    fn geometry(&self, room: &Room, _: &Ticker) -> Result<RoomGeometry, Stop> {
        let (owner, triangles): (Vec<_>, Vec<_>) = room.world_triangles().unzip();
        let config = GeometryConfig::default();
        let go_on = |_, _| ControlFlow::Continue(());
        let stopped = |_| Stop::Cancelled;
        let coarse = FieldConfig {
            resolution: Resolution::Cells { cell_m: 0.1, max_bytes: 64 << 20 },
            ..config.field
        };
        let field = bake(&triangles, &coarse, &go_on).map_err(stopped)?;
        RoomGeometry::from_field(triangles, owner, field, &config, &go_on).map_err(stopped)
    }

    fn populate(&self, task: &PopulateTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
        let people: Vec<Person> = (0..task.people as u32).map(|i| somebody(task.next_id + i)).collect();
        let making = *self.making.lock().unwrap();
        match making {
            Making::Quick => {
                let reports = people.iter().map(|_| measured_mm(12.0)).collect();
                Ok(Made { people, reports, ..Made::default() })
            }
            Making::FirstThenEndless => {
                while cx.step(0, 0).is_ok() {
                    cx.preview(PopulatePreview { people: people.clone() });
                    std::thread::sleep(Duration::from_millis(2));
                }
                let shortfall = Some("1 of 3 people: stopped".to_owned());
                Ok(Made { people: people[..1].to_vec(), shortfall, ..Made::default() })
            }
            Making::Breaks => panic!("index 7 is out of range"),
            Making::Endless => loop {
                cx.step(0, 0)?;
                cx.preview(PopulatePreview { people: people.clone() });
                std::thread::sleep(Duration::from_millis(2));
            },
        }
    }

    fn missing_methods(&self) -> Vec<(SampleMethod, String)> {
        vec![(SampleMethod::Baseline, "It was left at home".to_owned())]
    }

    fn see(
        &self,
        _: &Room,
        _: &RoomGeometry,
        _: &SampleView,
        _: Seed,
        _: &Ticker,
    ) -> Result<SceneImage, Stop> {
        Ok(seen())
    }

    /// The first candidate floats a little, the second not at all, and so on.
    fn sample(&self, task: &SampleTask, cx: &JobCtx<PopulatePreview>) -> Result<Sampled, Stop> {
        let candidate = |i: usize| {
            let mut person = somebody(i as u32);
            person.seed = cx.seed.child("body", i as u64).value();
            person.on = task.method.label().to_owned();
            let report = measured_mm(if i.is_multiple_of(2) { 40.0 + i as f32 } else { 3.0 });
            Candidate { person, report }
        };
        let candidates = (0..task.count).map(candidate).collect();
        Ok(Sampled { seen: Arc::new(seen()), candidates, shortfall: None })
    }

    fn fit(&self, task: &FitTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
        if *self.making.lock().unwrap() == Making::Endless {
            loop {
                cx.step(0, 0)?;
                cx.preview(PopulatePreview { people: task.people.clone() });
                std::thread::sleep(Duration::from_millis(2));
            }
        }
        let before = task.people.iter().map(|p| p.body.clone()).collect();
        let settle = |p: &Person| {
            let mut settled = p.clone();
            settled.body.translation.y = 0.9;
            settled
        };
        let people: Vec<Person> = task.people.iter().map(settle).collect();
        let reports = people.iter().map(|_| measured_mm(1.0)).collect();
        let energies = people.iter().map(|_| vec![("contact".to_owned(), vec![3.0, 2.0, 1.0])]).collect();
        Ok(Made { people, reports, energies, before, shortfall: None })
    }

    fn open_photo(&self, _: &Path, _: &Path, _: &Ticker) -> Result<Photo, Stop> {
        let point = Keypoint { pixel: glam::Vec2::new(20.0, 30.0), confidence: 0.9 };
        let person = PersonKeypoints { set: KeypointSet::Coco17, points: vec![point; 17] };
        Ok(Photo { picture: grey_picture(), size_px: [80, 80], people: vec![person] })
    }

    fn fit_photo(&self, task: &PhotoTask, _: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
        let person = somebody(task.id);
        let before = vec![person.body.clone()];
        Ok(Made { people: vec![person], reports: vec![measured_mm(2.0)], before, ..Made::default() })
    }

    fn portrait(&self, _: &Room, _: &RoomGeometry, _: &Person, _: &Ticker) -> Result<Picture, Stop> {
        Ok(grey_picture())
    }

    fn room_kinds(&self) -> Vec<String> {
        vec!["Hut".to_owned(), "Hall".to_owned()]
    }

    fn make_room(&self, request: &RoomRequest, ticker: &Ticker) -> Result<Opened, Stop> {
        let mut opened = self.open(&Source::Sample(0), ticker)?;
        let name = format!("{} {}", self.room_kinds()[request.kind], request.seed);
        opened.summary.name.clone_from(&name);
        let room = Arc::make_mut(&mut opened.scene.room);
        room.name = name;
        Ok(opened)
    }

    fn overview(&self, _: &Arc<Room>, _: &Ticker) -> Result<Picture, Stop> {
        Ok(grey_picture())
    }

    fn networks(&self) -> Arc<[NetworkCard]> {
        let curves =
            vec![Curve { name: "total".to_owned(), points: vec![[0.0, 4.0], [1.0, 2.0], [2.0, 1.0]] }];
        let text = "# Data\n- a hut\n\n| figure | value |\n|---|---|\n| error | 3 |\nTrained in no time.";
        vec![NetworkCard { name: "S1".to_owned(), text: text.to_owned(), curves }].into()
    }

    fn measure(&self, _: &RoomGeometry, _: &BodyParams, _: &Ticker) -> Result<BodyReport, Stop> {
        Ok(measured_mm(31.0))
    }

    fn pose(&self, body: &BodyParams) -> Arc<[Vec3]> {
        Body::bundled().pose(body).vertices.into()
    }

    fn faces(&self) -> Arc<[[u32; 3]]> {
        Body::bundled().model.faces.as_slice().into()
    }

    fn surface(&self) -> Arc<BodySurface> {
        Arc::new(BodySurface::of(Body::bundled()))
    }
}

/// Somebody in front of the window.
struct User {
    harness: Harness<'static, Window>,
    engine: Arc<FakeEngine>,
}

impl User {
    fn starts() -> Self {
        let engine = Arc::new(FakeEngine::default());
        let given = engine.clone();
        let harness = Harness::builder()
            .with_size(egui::vec2(1200.0, 760.0))
            .with_max_steps(60)
            .build_eframe(move |cc| Window::new(cc, given));
        Self { harness, engine }
    }

    fn opens_the_study() -> Self {
        let mut user = Self::starts();
        user.state().open(Source::Sample(0));
        user.waits(|state| state.geometry().is_some());
        user
    }

    fn state(&mut self) -> &mut EditorState {
        &mut self.harness.state_mut().state
    }

    fn sees(&mut self) {
        self.harness.run_ok();
    }

    fn waits(&mut self, until: impl Fn(&EditorState) -> bool) {
        let begun = Instant::now();
        loop {
            self.harness.step();
            if until(&self.harness.state().state) {
                return self.sees();
            }
            assert!(begun.elapsed() < Duration::from_secs(30), "waited in vain");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn presses(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.sees();
    }

    fn populates(&mut self, people: usize) {
        self.state().populate.people = people;
        self.presses(Modifiers::COMMAND, Key::Enter);
        self.waits(|state| !state.jobs.populating());
    }

    /// Samples `count` candidates from the present view.
    fn samples(&mut self, count: usize) {
        self.state().sheet.options.count = count;
        self.presses(Modifiers::SHIFT, Key::S);
        self.waits(|state| !state.jobs.any_running() && !state.sheet.cards.is_empty());
    }

    /// Seeds of the candidates, which tell them apart.
    fn candidates(&self) -> Vec<u64> {
        self.harness.state().state.sheet.cards.iter().map(|card| card.person.seed).collect()
    }

    fn people(&self) -> usize {
        self.harness.state().state.document.scene().people.len()
    }

    fn errors(&self) -> Vec<String> {
        let notices = &self.harness.state().state.notices;
        let errors = notices.all().filter(|(_, n)| n.level == super::notices::Level::Error);
        errors.map(|(_, n)| n.for_clipboard()).collect()
    }
}

#[test]
fn a_room_that_is_opened_shows_its_objects_by_category() {
    let mut user = User::starts();
    user.sees();
    user.harness.get_by_label("Study").click();
    user.waits(EditorState::has_room);
    user.harness.get_by_label("Couch (1)");
    user.harness.get_by_label("Red sofa").click();
    user.sees();
    assert_eq!(user.state().selection.objects(), [ObjectId(1)]);
}

#[test]
fn populating_is_one_step_that_one_undo_takes_back() {
    let mut user = User::opens_the_study();
    user.populates(3);
    assert_eq!(user.people(), 3);
    assert_eq!(user.state().document.past_labels().collect::<Vec<_>>(), ["Add 3 people"]);
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!(user.people(), 0);
    user.presses(Modifiers { shift: true, ..Modifiers::COMMAND }, Key::Z);
    assert_eq!(user.people(), 3);
}

#[test]
fn cancel_takes_effect_within_200_ms_and_changes_nothing() {
    let mut user = User::opens_the_study();
    *user.engine.making.lock().unwrap() = Making::Endless;
    user.presses(Modifiers::COMMAND, Key::Enter);
    user.waits(|state| !state.ghosts.is_empty());
    let begun = Instant::now();
    user.harness.get_by_label("Cancel").click();
    while user.harness.state().state.jobs.populating() {
        user.harness.step();
        assert!(begun.elapsed() < Duration::from_secs(10), "Cancel does nothing");
    }
    assert!(begun.elapsed() < Duration::from_millis(200), "{:?}", begun.elapsed());
    assert!(user.state().ghosts.is_empty() && user.people() == 0 && !user.state().document.can_undo());
}

#[test]
fn cancel_keeps_who_is_there_as_a_step_that_can_be_undone() {
    let mut user = User::opens_the_study();
    *user.engine.making.lock().unwrap() = Making::FirstThenEndless;
    user.presses(Modifiers::COMMAND, Key::Enter);
    user.waits(|state| !state.ghosts.is_empty());
    user.harness.get_by_label("Cancel").click();
    user.waits(|state| !state.jobs.populating());
    assert_eq!(user.people(), 1);
    assert!(user.state().ghosts.is_empty());
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!(user.people(), 0);
}

#[test]
fn the_window_answers_while_people_are_being_made() {
    let mut user = User::opens_the_study();
    *user.engine.making.lock().unwrap() = Making::Endless;
    user.presses(Modifiers::COMMAND, Key::Enter);
    user.waits(|state| !state.ghosts.is_empty());
    let revision = user.state().document.revision();
    user.state().selection.only(Item::Object(ObjectId(1)));
    user.harness.key_press(Key::L);
    user.harness.step();
    user.harness.step();
    assert!(user.state().document.revision() > revision, "a lock is set beside the running job");
    assert!(user.state().jobs.populating());
}

#[test]
fn a_fault_in_a_worker_leaves_the_document_whole_and_is_said() {
    let mut user = User::opens_the_study();
    user.populates(2);
    *user.engine.making.lock().unwrap() = Making::Breaks;
    user.populates(2);
    assert_eq!(user.people(), 2);
    let errors = user.errors();
    assert!(errors[0].contains("fault of the program") && errors[0].contains("index 7"), "{errors:?}");
    *user.engine.making.lock().unwrap() = Making::Quick;
    user.populates(1);
    assert_eq!(user.people(), 3, "the next job works");
}

#[test]
fn people_made_for_furniture_that_was_moved_meanwhile_are_refused() {
    let mut user = User::opens_the_study();
    *user.engine.making.lock().unwrap() = Making::Quick;
    user.state().start_populating(None);
    user.state().apply(Command::MoveObject(ObjectId(1), Affine3A::from_translation(Vec3::X)));
    user.waits(|state| !state.jobs.populating());
    assert_eq!(user.people(), 0);
    assert!(user.errors()[0].contains("changed while this was being computed"), "{:?}", user.errors());
}

#[test]
fn re_rolled_people_keep_their_name_and_number() {
    let mut user = User::opens_the_study();
    user.populates(2);
    user.state().apply(Command::RenamePerson(PersonId(0), "Ada".to_owned()));
    user.state().selection.only(Item::Person(PersonId(0)));
    let mut moved = somebody(0);
    moved.body.translation.x = 0.4;
    user.state().apply(Command::SetBody(PersonId(0), moved.body));
    user.presses(Modifiers::NONE, Key::F9);
    user.waits(|state| !state.jobs.populating());
    let ada = user.state().document.scene().person(PersonId(0)).cloned().unwrap();
    assert_eq!((ada.name.as_str(), ada.body.translation.x, user.people()), ("Ada", 0.0, 2));
}

#[test]
fn the_palette_runs_a_command_by_a_few_letters() {
    let mut user = User::opens_the_study();
    let grid = user.state().view.grid;
    user.presses(Modifiers::COMMAND, Key::K);
    user.harness.get_by_role(egui::Role::TextInput).type_text("grid");
    user.sees();
    user.presses(Modifiers::NONE, Key::Enter);
    assert_ne!(user.state().view.grid, grid);
    assert_eq!(user.state().overlay, Overlay::None);
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("not read by the window".to_owned())
    }
}

#[test]
fn dropping_a_bad_file_names_it_and_keeps_what_was_there() {
    let mut user = User::opens_the_study();
    user.populates(1);
    let file: egui::DroppedFileHandle = Arc::new(Dropped(PathBuf::from("broken.glb")));
    user.harness.input_mut().dropped_files.push(file);
    user.waits(|state| !state.jobs.opening() && state.notices.all().any(|(_, n)| n.text.contains("broken")));
    assert!(user.errors()[0].contains("broken.glb, byte 0"), "{:?}", user.errors());
    assert_eq!(user.people(), 1);
    assert_eq!(user.state().document.scene().room.name, "Study");
}

#[test]
fn letters_typed_into_a_field_are_no_commands() {
    let mut user = User::opens_the_study();
    user.populates(1);
    user.state().selection.only(Item::Person(PersonId(0)));
    user.presses(Modifiers { shift: true, ..Modifiers::COMMAND }, Key::O);
    user.presses(Modifiers::NONE, Key::X);
    assert_eq!(user.people(), 1, "X in the path field does not delete");
    user.presses(Modifiers::NONE, Key::Escape);
    assert_eq!(user.state().overlay, Overlay::None);
    user.presses(Modifiers::NONE, Key::X);
    assert_eq!(user.people(), 0, "X in the view does");
}

#[test]
fn escape_leaves_one_thing_at_a_time_and_never_the_program() {
    let mut user = User::opens_the_study();
    user.populates(1);
    user.state().selection.only(Item::Person(PersonId(0)));
    user.presses(Modifiers::SHIFT, Key::A);
    user.presses(Modifiers::NONE, Key::Questionmark);
    user.presses(Modifiers::NONE, Key::Escape);
    assert!(user.state().overlay == Overlay::None && user.state().tool == Tool::PutHere);
    user.presses(Modifiers::NONE, Key::Escape);
    assert!(user.state().tool == Tool::Select && !user.state().selection.is_empty());
    user.presses(Modifiers::NONE, Key::Escape);
    assert!(user.state().selection.is_empty());
    user.presses(Modifiers::NONE, Key::Escape);
    assert!(!user.state().requests.close);
}

#[test]
fn locked_people_survive_delete_and_the_rest_goes_in_one_step() {
    let mut user = User::opens_the_study();
    user.populates(3);
    user.state().apply(Command::SetPeopleLocked(vec![PersonId(1)], true));
    user.presses(Modifiers::COMMAND, Key::A);
    user.presses(Modifiers::NONE, Key::Delete);
    assert_eq!(user.people(), 1);
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!(user.people(), 3);
}

#[test]
fn the_worst_finding_is_one_key_away() {
    let mut user = User::opens_the_study();
    user.populates(2);
    user.presses(Modifiers::COMMAND, Key::A);
    super::actions::measure_again(user.state());
    user.waits(|state| state.findings().len() == 2);
    user.state().selection.clear();
    user.presses(Modifiers::NONE, Key::N);
    assert_eq!(user.state().selection.active_person(), Some(PersonId(0)));
    user.presses(Modifiers::NONE, Key::N);
    assert_eq!(user.state().selection.active_person(), Some(PersonId(1)));
}

#[test]
fn looking_at_a_person_changes_nothing_and_measures_nothing_again() {
    let mut user = User::opens_the_study();
    user.populates(1);
    let mut body = somebody(0).body;
    body.betas[0] = 0.123_456;
    body.betas[1] = -3.7;
    user.state().apply(Command::SetBody(PersonId(0), body.clone()));
    user.state().selection.only(Item::Person(PersonId(0)));
    user.waits(|state| state.measured(PersonId(0)).is_some());
    let revision = user.state().document.revision();
    user.harness.run_steps(6);
    assert_eq!(user.state().document.revision(), revision);
    assert_eq!(user.state().document.scene().people[0].body, body);
}

#[test]
fn what_was_measured_while_people_were_made_is_kept() {
    let mut user = User::opens_the_study();
    user.populates(2);
    let measured = user.state().measured(PersonId(1)).expect("measured by the job itself");
    assert_eq!(measured.report.metrics.penetration_max_mm, 12.0);
}

#[test]
fn unsaved_people_are_kept_against_a_crash_once_for_each_change() {
    let mut user = User::opens_the_study();
    let mut autosave = Autosave::new(PathBuf::from("kept.inhabit")).with_interval(Duration::ZERO);
    let mut keeps = |user: &mut User| {
        for _ in 0..20 {
            autosave.keep(user.state());
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    keeps(&mut user);
    assert!(user.engine.saved.lock().unwrap().is_empty(), "there is nobody to lose");
    user.populates(2);
    keeps(&mut user);
    user.populates(1);
    keeps(&mut user);
    let kept = PathBuf::from("kept.inhabit");
    assert_eq!(*user.engine.saved.lock().unwrap(), [(kept.clone(), 2), (kept, 3)]);
    assert!(
        user.state().project.is_none() && user.state().document.is_dirty(),
        "it is no save of the user's"
    );
}

#[test]
fn closing_with_unsaved_people_asks_first() {
    let mut user = User::opens_the_study();
    user.populates(1);
    user.presses(Modifiers::COMMAND, Key::Q);
    assert_eq!(user.state().overlay, Overlay::Unsaved(Leaving::Quit));
    user.harness.get_by_label("Stay").click();
    user.sees();
    assert!(user.state().overlay == Overlay::None && user.people() == 1);
}

#[test]
fn candidates_come_ranked_and_nobody_is_in_the_room_before_one_is_accepted() {
    let mut user = User::opens_the_study();
    user.samples(4);
    assert_eq!((user.people(), user.state().document.can_undo()), (0, false));
    let findings: Vec<usize> = user.state().sheet.cards.iter().map(|card| card.findings.len()).collect();
    assert_eq!(findings, [0, 0, 1, 1], "those without findings first");
    assert_eq!(user.state().shown_ghosts().len(), 1, "the best one is shown in the view");
    user.harness.get_by_label("Candidates 4");
    user.harness.get_by_label("Candidate 3: stand");
}

#[test]
fn an_accepted_candidate_is_fitted_selected_and_taken_back_by_one_undo() {
    let mut user = User::opens_the_study();
    user.samples(3);
    user.harness.get_by_label("Accept candidate 2").click_accesskit();
    user.sees();
    user.waits(|state| !state.jobs.any_running());
    assert_eq!(user.people(), 1);
    let person = user.state().document.scene().people[0].clone();
    assert_eq!(person.body.translation.y, 0.9, "fitted");
    assert_eq!(user.state().selection.active_person(), Some(person.id));
    assert_eq!(user.state().sheet.cards[1].fate, Fate::Accepted);
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!(user.people(), 0);
}

#[test]
fn accept_all_is_one_step() {
    let mut user = User::opens_the_study();
    user.samples(5);
    user.presses(Modifiers::SHIFT, Key::Enter);
    user.waits(|state| !state.jobs.any_running());
    assert_eq!(user.people(), 5);
    assert_eq!(user.state().document.past_labels().collect::<Vec<_>>(), ["Add 5 people"]);
}

#[test]
fn a_re_roll_leaves_locked_and_accepted_candidates_alone() {
    let mut user = User::opens_the_study();
    user.samples(4);
    let before = user.candidates();
    user.harness.get_by_label("Lock candidate 1").click_accesskit();
    user.sees();
    user.harness.get_by_label("Accept candidate 2").click_accesskit();
    user.sees();
    user.waits(|state| !state.jobs.any_running());
    user.presses(Modifiers::SHIFT, Key::F9);
    user.waits(|state| !state.jobs.any_running());
    let after = user.candidates();
    assert_eq!(after[..2], before[..2]);
    assert!(after[2] != before[2] && after[3] != before[3], "{before:?} {after:?}");
    user.harness.get_by_label("Re-roll candidate 3").click_accesskit();
    user.sees();
    user.waits(|state| !state.jobs.any_running());
    let last = user.candidates();
    assert!(last[2] != after[2] && last[3] == after[3]);
}

#[test]
fn a_cancelled_fit_leaves_the_candidate_to_be_accepted_later() {
    let mut user = User::opens_the_study();
    user.samples(2);
    *user.engine.making.lock().unwrap() = Making::Endless;
    user.presses(Modifiers::NONE, Key::Enter);
    user.waits(|state| !state.ghosts.is_empty());
    user.state().cancel_all();
    user.sees();
    assert!(user.people() == 0 && user.state().sheet.cards[0].fate == Fate::Open);
}

#[test]
fn candidates_of_a_room_that_has_changed_are_not_fitted() {
    let mut user = User::opens_the_study();
    user.samples(2);
    user.state().apply(Command::MoveObject(ObjectId(1), Affine3A::from_translation(Vec3::X)));
    user.waits(|state| state.geometry().is_some());
    user.presses(Modifiers::SHIFT, Key::Enter);
    user.waits(|state| !state.jobs.any_running());
    assert_eq!(user.people(), 0);
}

#[test]
fn why_like_this_shows_what_was_seen_and_the_body_before_the_fit() {
    let mut user = User::opens_the_study();
    user.samples(1);
    user.presses(Modifiers::NONE, Key::Enter);
    user.waits(|state| !state.jobs.any_running());
    let person = user.state().document.scene().people[0].clone();
    user.presses(Modifiers::SHIFT, Key::W);
    for shown in ["Depth: how far away things are", "Kinds of things"] {
        let panels = user.harness.query_all_by_label(shown).count();
        assert_eq!(panels, 2, "{shown}: beside the sampler's settings and in the answer");
    }
    user.presses(Modifiers::NONE, Key::B);
    let ghosts = user.state().shown_ghosts();
    assert_eq!(ghosts[0].body.translation.y, 1.0, "as it was sampled");
    assert_eq!(person.body.translation.y, 0.9);
}

#[test]
fn somebody_who_is_moved_along_an_axis_by_a_number_settles_there_and_two_undos_take_it_back() {
    let mut user = User::opens_the_study();
    user.populates(1);
    let id = user.state().document.scene().people[0].id;
    user.state().selection.only(Item::Person(id));
    for key in [Key::G, Key::X, Key::Num1, Key::Period, Key::Num5] {
        user.presses(Modifiers::NONE, key);
    }
    let body = |user: &User| user.harness.state().state.document.scene().people[0].body.clone();
    assert!((body(&user).translation - Vec3::new(1.5, 1.0, 0.0)).length() < 1e-5, "{:?}", body(&user));
    user.presses(Modifiers::NONE, Key::Enter);
    user.waits(|state| !state.jobs.any_running());
    assert_eq!((body(&user).translation.x, body(&user).translation.y), (1.5, 0.9), "moved, then settled");
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!(body(&user).translation.y, 1.0);
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!((body(&user).translation.x, user.people()), (0.0, 1));
}

#[test]
fn escape_while_something_is_turned_puts_it_back_and_x_deletes_nothing() {
    let mut user = User::opens_the_study();
    user.state().selection.only(Item::Object(ObjectId(1)));
    for key in [Key::R, Key::Num9, Key::Num0] {
        user.presses(Modifiers::NONE, key);
    }
    let sofa = |user: &User| user.harness.state().state.document.scene().room.objects[1].world_from_object;
    let turned = sofa(&user).transform_vector3(Vec3::X);
    assert!(turned.distance(Vec3::NEG_Z) < 1e-5, "{turned}");
    user.presses(Modifiers::NONE, Key::X);
    user.presses(Modifiers::NONE, Key::Escape);
    assert_eq!(sofa(&user), Affine3A::IDENTITY);
    assert!(!user.state().document.can_undo() && user.state().document.scene().room.objects.len() == 2);
}

#[test]
fn a_person_of_a_photo_is_found_in_the_room_and_can_be_taken_back() {
    let mut user = User::opens_the_study();
    user.state().photo.picture_path = "me.jpg".to_owned();
    user.state().photo.keypoints_path = "me.json".to_owned();
    user.state().open_photo();
    user.waits(|state| state.photo.photo.is_some());
    user.state().fit_photo();
    user.waits(|state| !state.jobs.any_running());
    assert_eq!(user.people(), 1);
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!(user.people(), 0);
}

#[test]
fn a_new_room_is_looked_at_before_it_is_opened_and_undo_brings_the_old_one_back() {
    let mut user = User::opens_the_study();
    user.presses(Modifiers::COMMAND, Key::N);
    user.waits(|state| state.new_room.made.is_some());
    assert_eq!(user.state().document.scene().room.name, "Study");
    user.harness.get_by_label("Hall").click();
    user.waits(|state| state.new_room.made.as_ref().is_some_and(|made| made.request.kind == 1));
    user.harness.get_by_label("Open this room").click();
    user.waits(|state| state.geometry().is_some());
    assert_eq!(user.state().document.scene().room.name, "Hall 0");
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!(user.state().document.scene().room.name, "Study");
}

#[test]
fn a_method_that_is_not_there_says_so_and_cannot_be_chosen() {
    let mut user = User::opens_the_study();
    super::actions::sample_view(user.state());
    user.waits(|state| !state.jobs.any_running());
    user.harness.get_by_role(egui::Role::ComboBox).click();
    user.sees();
    let baseline = user.harness.get_by_label("Baseline network");
    assert!(NodeT::accesskit_node(&baseline).is_disabled());
    user.harness.get_by_label("Network S2").click();
    user.sees();
    assert_eq!(user.state().sheet.options.method, SampleMethod::S2);
}

/// The harness fails for a widget without a name and for a letter that no font has.
#[test]
fn every_page_has_names_for_its_widgets_and_letters_that_can_be_read() {
    let mut user = User::opens_the_study();
    user.populates(2);
    user.samples(3);
    user.presses(Modifiers::SHIFT, Key::Enter);
    user.waits(|state| !state.jobs.any_running());
    user.presses(Modifiers::SHIFT, Key::W);
    super::actions::measure_again(user.state());
    user.waits(EditorState::has_findings);
    user.state().notices.error("Something failed", "room.glb: why");
    user.state().notices.warning("Something was left out");
    let pages = [
        Overlay::None,
        Overlay::Palette { query: String::new(), row: 0 },
        Overlay::Shortcuts,
        Overlay::Help,
        Overlay::OpenPath(String::new()),
        Overlay::SavePath(String::new()),
        Overlay::Import,
        Overlay::History,
        Overlay::Notifications,
        Overlay::Rename(Item::Person(PersonId(0)), "Ada".to_owned()),
        Overlay::Unsaved(Leaving::Quit),
        Overlay::NewRoom,
        Overlay::ExportPath(String::new()),
        Overlay::Recover(PathBuf::from("kept.inhabit")),
        Overlay::Networks(0),
    ];
    for dark in [true, false] {
        user.state().view.dark = dark;
        for page in pages.clone() {
            for item in [None, Some(Item::Person(PersonId(0))), Some(Item::Object(ObjectId(1)))] {
                user.state().selection.set(item);
                user.state().overlay = page.clone();
                user.harness.run_steps(2);
            }
        }
    }
}
