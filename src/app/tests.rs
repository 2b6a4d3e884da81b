//! The window in the user's words, driven without a screen; work behind it is replaced by work that is quick,
//! endless or breaks, as a test needs it.

use std::collections::BTreeMap;
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
    Candidate, Curve, Engine, FitTask, ImportSummary, Made, MotionExport, MotionFormat, MotionMethod,
    MovePreview, MoveTask, Moved, NetworkCard, Opened, Photo, PhotoTask, PopulateTask, RoomRequest,
    SampleMethod, SampleTask, SampleView, Sampled, Source, ThingKind, ThingPicture,
};
use super::lived::{ActionChoice, ActionStep, LivedDay, LivedRoom, Mark, Touched};
use super::motion::{GoalFigures, Placing, Trail};
use super::samples::Fate;
use super::selection::Item;
use super::state::{EditorState, Leaving, Overlay, Tool};
use super::window::Window;
use crate::assets::{Keypoint, KeypointSet, Material, Mesh, Model, PersonKeypoints};
use crate::body::Body;
use crate::document::{Command, Project};
use crate::evolve::PopulatePreview;
use crate::evolve::action::{Off, Suggestion, Verdict};
use crate::evolve::day::{Moment, Place, Track};
use crate::generate::sensor::{Intrinsics, SIDE, SceneImage, Valid, View};
use crate::inspect::{BodyReport, FrameRecord, MotionReport};
use crate::job::{Cancelled, JobCtx, Seed, Stop, Ticker};
use crate::render::{BodySurface, Picture};
use crate::scene::{
    BETAS, BodyParams, Category, Clip, ClipId, FieldConfig, Frame, GeometryConfig, GoalPose, Leg, Object,
    ObjectId, ObjectPart, Person, PersonId, PoseFamily, Resolution, Room, RoomGeometry, Scene, SubGoal,
    SubGoalId, UpAxis, bake,
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
    /// Motions that were asked for.
    moves: Mutex<Vec<MoveTask>>,
    /// Motions that were written: format, file, how many.
    written: Mutex<Vec<(MotionFormat, PathBuf, usize)>>,
    /// What moved beside those who were written last, and how many states of the room there were.
    changes: Mutex<(usize, usize)>,
}

/// A cup as a file has it: nine centimetres high, in centimetres, lying along Z.
const CUP_IN_CM: &str = "v 0 0 0\nv 6 0 0\nv 0 6 0\nv 0 0 9\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n";

/// A room where one can read (60 %), eat (30 %) or nap (10 %, not possible); each action brings one thing.
#[derive(Clone)]
struct FakeLife {
    room: Room,
    steps: Vec<ActionStep>,
    banned: Vec<String>,
    most: BTreeMap<String, usize>,
    slow: bool,
}

impl LivedRoom for FakeLife {
    fn suggestions(&self) -> Vec<Suggestion> {
        let of = |node, action: &str, probability| Suggestion {
            node,
            action: action.to_owned(),
            probability,
            keys: vec![ObjectId(1)],
        };
        vec![of(0, "read on sofa", 0.6), of(1, "eat on sofa", 0.3), of(2, "nap on sofa", 0.1)]
    }

    fn off(&self) -> Vec<Off> {
        vec![Off { node: 3, action: "cook".to_owned(), why: "there is no kitchen here".to_owned() }]
    }

    fn draw_next(&self, refused: u64) -> Option<usize> {
        Some(if refused == 0 { 2 } else { self.steps.len() % 2 })
    }

    fn apply(&self, node: usize, roll: u64) -> Result<Arc<dyn LivedRoom>, Stop> {
        if node == 2 {
            return Err(Stop::Failed("\"nap on sofa\" is not possible here: it is too short".to_owned()));
        }
        let mut next = self.clone();
        let kind = if self.banned.iter().any(|kind| kind == "book") { "cup" } else { "book" };
        let there = next.room.objects.iter().filter(|object| object.name == kind).count();
        if there >= self.most.get(kind).copied().unwrap_or(usize::MAX) {
            return Err(Stop::Failed(format!("there is no room for another {kind}")));
        }
        let id = next.room.objects.len() as u32;
        let mut brought = thing(id, kind, Category::Chair, 0.5);
        brought.world_from_object = Affine3A::from_translation(Vec3::X * roll as f32 * 0.1);
        next.room.objects.push(brought);
        let touched = vec![Touched {
            id: ObjectId(id),
            line: format!("{kind} came, on Red sofa"),
            kind: kind.to_owned(),
        }];
        let (at, score) = (Vec3::Y * 0.4, 1.0);
        let marks = vec![Mark { object: kind.to_owned(), at, verdict: Verdict::Taken, score }];
        let action = self.suggestions()[node].action.clone();
        next.steps.push(ActionStep { node, action, touched, marks, ..ActionStep::default() });
        Ok(Arc::new(next))
    }

    fn decided(&self, choice: &ActionChoice, _: &[ObjectId]) -> Arc<dyn LivedRoom> {
        Arc::new(Self { banned: choice.banned.clone(), most: choice.most.clone(), ..self.clone() })
    }

    fn last_step(&self) -> Option<ActionStep> {
        self.steps.last().cloned()
    }

    fn step_count(&self) -> usize {
        self.steps.len()
    }

    fn room(&self) -> Room {
        self.room.clone()
    }

    fn people(&self, first_id: u32) -> Vec<Person> {
        vec![somebody(first_id)]
    }

    fn day(&self, actions: usize, cx: &JobCtx<LivedDay>) -> Result<LivedDay, Stop> {
        if self.slow && actions > 1 {
            let first = self.day(1, cx)?;
            loop {
                cx.preview(first.clone());
                cx.step(0, 0)?;
                std::thread::sleep(Duration::from_millis(2));
            }
        }
        let mut states: Vec<Arc<dyn LivedRoom>> = Vec::new();
        for action in 0..actions {
            let last: &dyn LivedRoom = states.last().map_or(self, |state| state.as_ref());
            states.push(last.apply(action % 2, 0)?);
        }
        let frames = vec![Frame::default(); 30 * actions + 1];
        let planted = vec![[true, true]; frames.len()];
        let clip = Clip { frames, planted, ..Clip::default() };
        let moment = |action: usize| Moment {
            step: action + 1,
            action: self.suggestions()[action % 2].action.clone(),
            key: "Red sofa".to_owned(),
            changes_s: action as f32 + 0.5,
            arrives_s: action as f32 + 0.6,
            leaves_s: action as f32 + 0.9,
            walked: true,
        };
        let moments = (0..actions).map(moment).collect();
        let came = |id: usize| Track {
            object: ObjectId(id as u32),
            places: vec![Place { at_s: 0.5, at_m: Vec3::ZERO, rotation: glam::Quat::IDENTITY }],
            comes_s: Some(0.5),
        };
        let there = self.room.objects.len();
        let tracks = (there..there + actions).map(came).collect();
        Ok(LivedDay { clip, states, moments, tracks, refused: Vec::new() })
    }

    fn fitted_people(&self, first: u32, ticker: &Ticker) -> Result<Vec<(Person, BodyReport)>, Cancelled> {
        while self.slow {
            ticker.check()?;
            std::thread::sleep(Duration::from_millis(2));
        }
        let mut fitted = somebody(first);
        fitted.body.translation.y = 0.9;
        Ok(vec![(fitted, measured_mm(2.0))])
    }
}

/// Frames of a leg of the fake.
const LEG: usize = 10;

/// Slides in a straight line from sub-goal to sub-goal, a third of a second each.
fn slid(plan: &Clip) -> Clip {
    let mut clip = Clip { frames: Vec::new(), legs: Vec::new(), ..plan.clone() };
    let frame = |at: Vec3| Frame { translation: at + Vec3::Y, ..Frame::default() };
    clip.frames.extend(clip.goals.first().map(|goal| frame(goal.at)));
    for pair in plan.goals.windows(2) {
        let first = clip.frames.len() - 1;
        let along = (1..=LEG).map(|i| frame(pair[0].at.lerp(pair[1].at, i as f32 / LEG as f32)));
        clip.frames.extend(along);
        clip.legs.push(Leg { from: pair[0].id, to: pair[1].id, first, last: first + LEG, key: 5 });
    }
    clip.planted = clip.frames.iter().enumerate().map(|(i, _)| [i % 8 < 4, i % 8 >= 4]).collect();
    clip
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
        let is_result = |path: &Path| path.extension().is_some_and(|e| e == "inhabit");
        if let Source::File(path, _) = source
            && !is_result(path)
        {
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
        vec![NetworkCard { name: "S1".to_owned(), text: text.to_owned(), curves, measures: Vec::new() }]
            .into()
    }

    fn measure(&self, _: &RoomGeometry, _: &BodyParams, _: &Ticker) -> Result<BodyReport, Stop> {
        Ok(measured_mm(31.0))
    }

    fn pose(&self, body: &BodyParams) -> Arc<[Vec3]> {
        Body::bundled().pose(body).vertices.into()
    }

    fn pose_frame(&self, betas: &[f32; BETAS], frame: &Frame) -> Arc<[Vec3]> {
        Body::bundled().pose_frame(betas, frame).vertices.into()
    }

    fn synthesise(&self, task: &MoveTask, cx: &JobCtx<MovePreview>) -> Result<Moved, Stop> {
        self.moves.lock().unwrap().push(task.clone());
        let clip = slid(&task.clip);
        while *self.making.lock().unwrap() == Making::FirstThenEndless {
            cx.step(0, 0)?;
            std::thread::sleep(Duration::from_millis(2));
        }
        if *self.making.lock().unwrap() == Making::Endless {
            loop {
                cx.preview(MovePreview { clip: Arc::new(clip.clone()) });
                cx.step(0, 0)?;
                std::thread::sleep(Duration::from_millis(2));
            }
        }
        Ok(Moved { clip, report: None, remarks: Vec::new() })
    }

    /// The eighth frame sinks in.
    fn measure_clip(&self, _: &RoomGeometry, clip: &Clip, _: &Ticker) -> Result<MotionReport, Stop> {
        let record = |i: usize| FrameRecord {
            non_collision: 1.0,
            contact: true,
            penetration_max_mm: if i == 7 { 90.0 } else { 2.0 },
            ..FrameRecord::default()
        };
        let frames = (0..clip.frames.len()).map(record).collect();
        let mut report = MotionReport { frames, ..MotionReport::default() };
        (report.metrics.non_collision_pct, report.metrics.contact_pct) = (100.0, 100.0);
        Ok(report)
    }

    fn reach(&self, _: &Room, _: &RoomGeometry, clip: &Clip, goal: SubGoalId) -> Result<(), String> {
        let at = clip.goal(goal).map_or(Vec3::ZERO, |goal| goal.at);
        if at.x > 0.9 { Err("the red sofa is in the way".to_owned()) } else { Ok(()) }
    }

    fn stand_in(&self, goal: &SubGoal, _: &[f32; BETAS]) -> Frame {
        Frame { translation: goal.at + Vec3::Y, ..Frame::default() }
    }

    fn look_for_actions(
        &self,
        room: &Arc<Room>,
        _: &ActionChoice,
        _: u64,
        _: &Ticker,
    ) -> Result<Arc<dyn LivedRoom>, Stop> {
        let slow = *self.making.lock().unwrap() == Making::Endless;
        let room = room.as_ref().clone();
        let (steps, banned, most) = (Vec::new(), Vec::new(), BTreeMap::new());
        Ok(Arc::new(FakeLife { room, steps, banned, most, slow }))
    }

    fn export_motion(&self, path: &Path, export: &MotionExport, _: &Ticker) -> Result<usize, Stop> {
        self.written.lock().unwrap().push((export.format, path.to_owned(), export.clips.len()));
        *self.changes.lock().unwrap() = (export.changes.tracks.len(), export.changes.rooms.len());
        Ok(1)
    }

    fn thing_kinds(&self) -> Vec<ThingKind> {
        [("book", 12), ("cup", 6)]
            .map(|(kind, most)| ThingKind { kind: kind.to_owned(), most, models: 2 })
            .to_vec()
    }

    fn thing_picture(&self, _: &str, _: &Ticker) -> Result<ThingPicture, Stop> {
        Ok(ThingPicture { picture: grey_picture(), size_m: Vec3::splat(0.1) })
    }

    fn read_thing(&self, path: &Path, _: &Ticker) -> Result<Model, Stop> {
        let budget = crate::assets::Budget::default();
        Ok(crate::assets::read_model_bytes(&path.display().to_string(), CUP_IN_CM.as_bytes(), &budget)?)
    }

    fn model_picture(&self, _: &Model, _: &Ticker) -> Result<ThingPicture, Stop> {
        Ok(ThingPicture { picture: grey_picture(), size_m: Vec3::splat(0.1) })
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

    /// Places sub-goals at these points of the floor, one after the other.
    fn places(&mut self, points: &[(f32, f32)]) {
        for (x, z) in points {
            let at = Vec3::new(*x, 0.0, *z);
            self.state().place_goal(Placing { at, towards: at + Vec3::X });
        }
        self.sees();
    }

    /// Makes the active motion and waits until it is measured.
    fn synthesises(&mut self) {
        self.presses(Modifiers { shift: true, ..Modifiers::COMMAND }, Key::Enter);
        self.waits(|state| !state.jobs.any_running() && state.can_play());
    }

    fn clip(&self) -> Clip {
        self.harness.state().state.active_clip().expect("a motion").as_ref().clone()
    }

    fn history(&self) -> Vec<String> {
        self.harness.state().state.document.past_labels().map(str::to_owned).collect()
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
    user.sees();
    user.harness.get_by_label("Open as a room").click();
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
        Overlay::ExportMotion,
        Overlay::Study,
        Overlay::Dropped(PathBuf::from("cup.obj")),
        Overlay::ThingPath(String::new()),
        Overlay::Learned(None),
        Overlay::Learned(Some(2)),
    ];
    user.places(&[(-0.5, 0.0), (0.5, 0.5), (0.5, -0.5)]);
    user.synthesises();
    let clip = user.clip();
    user.state().motion.trail = Trail::Figures;
    user.state().motion.figures = GoalFigures::All;
    user.state().requests.show_motion = true;
    for dark in [true, false] {
        user.state().view.dark = dark;
        for page in pages.clone() {
            let items = [
                Item::Person(PersonId(0)),
                Item::Object(ObjectId(1)),
                Item::Clip(clip.id),
                Item::Goal(clip.id, clip.goals[1].id),
            ];
            for item in std::iter::once(None).chain(items.map(Some)) {
                user.state().selection.set(item);
                user.state().overlay = page.clone();
                user.harness.run_steps(2);
            }
        }
    }
}

#[test]
fn sub_goals_are_placed_one_step_each_and_undo_takes_them_back() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.5, 0.0), (0.5, 0.5)]);
    let clip = user.clip();
    assert_eq!(clip.goals.iter().map(|goal| goal.at.x).collect::<Vec<_>>(), [-0.5, 0.5]);
    assert_eq!(clip.goals[1].facing, Some(std::f32::consts::FRAC_PI_2), "the drag went along +X");
    assert_eq!(user.history(), ["Add sub-goal", "Add sub-goal"]);
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!(user.clip().goals.len(), 1);
    user.presses(Modifiers::COMMAND, Key::Z);
    assert!(user.state().document.scene().clips.is_empty());
}

#[test]
fn a_click_into_the_view_places_a_sub_goal_and_a_drag_gives_it_a_facing() {
    let mut user = User::opens_the_study();
    user.presses(Modifiers::SHIFT, Key::I);
    let middle = user.harness.get_by_label("3-D view").rect().center();
    user.harness.drag_at(middle);
    user.harness.hover_at(middle + egui::vec2(40.0, 10.0));
    user.sees();
    user.harness.hover_at(middle + egui::vec2(90.0, 20.0));
    user.sees();
    assert!(user.state().motion.placing.is_some(), "shown while the button is down");
    user.harness.drop_at(middle + egui::vec2(90.0, 20.0));
    user.sees();
    let goal = user.clip().goals[0].clone();
    assert!(goal.facing.is_some() && goal.at.x.abs() < 1.0 && goal.at.z.abs() < 1.0, "{goal:?}");
    assert_eq!(user.state().tool, Tool::AddGoal, "ready for the next one");
}

#[test]
fn with_somebody_selected_the_motion_is_theirs_and_begins_where_they_are() {
    let mut user = User::opens_the_study();
    user.populates(1);
    user.state().selection.only(Item::Person(PersonId(0)));
    user.places(&[(0.5, 0.5)]);
    let clip = user.clip();
    assert_eq!((clip.person, clip.name.as_str()), (Some(PersonId(0)), "Person 1"));
    assert!(clip.goals.len() == 2 && clip.goals[0].locked && clip.goals[0].body.is_some());
}

#[test]
fn synthesising_is_one_step_that_plays_and_is_measured_frame_by_frame() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.5, 0.0), (0.5, 0.5), (0.5, -0.5)]);
    user.synthesises();
    assert_eq!(user.clip().frames.len(), 2 * LEG + 1);
    assert_eq!(user.history().last().map(String::as_str), Some("Synthesise motion"));
    let name = format!("Timeline of {}", user.clip().name);
    user.harness.get_by_label(&name);
    let clip = user.state().active_clip().unwrap().clone();
    let findings = user.state().clip_findings();
    assert_eq!(findings.len(), 1);
    assert_eq!((findings[0].0.id, findings[0].1.site.frame), (clip.id, Some(7)));
    user.presses(Modifiers::COMMAND, Key::Z);
    assert!(user.clip().frames.is_empty() && user.clip().goals.len() == 3, "the plan is there again");
}

#[test]
fn cancel_keeps_the_motion_as_it_is_so_far_within_200_ms_as_one_step() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.5, 0.0), (0.5, 0.5)]);
    *user.engine.making.lock().unwrap() = Making::Endless;
    user.presses(Modifiers { shift: true, ..Modifiers::COMMAND }, Key::Enter);
    user.waits(|state| state.motion.preview.is_some());
    assert!(user.state().can_play(), "plays as it goes");
    user.harness.get_by_label("Stop and keep").click();
    let begun = Instant::now();
    user.harness.step();
    assert!(begun.elapsed() < Duration::from_millis(200) && !user.state().jobs.moving());
    assert_eq!(user.clip().frames.len(), LEG + 1);
    user.waits(|state| !state.jobs.any_running());
    assert_eq!(
        user.history(),
        ["Add sub-goal", "Add sub-goal", "Synthesise motion"],
        "one step, and no more comes"
    );
    user.presses(Modifiers::COMMAND, Key::Z);
    assert!(user.clip().frames.is_empty() && user.clip().goals.len() == 2, "the plan is there again");
    user.presses(Modifiers { shift: true, ..Modifiers::COMMAND }, Key::Z);
    assert_eq!(user.clip().frames.len(), LEG + 1);
}

#[test]
fn moving_one_sub_goal_says_what_is_in_the_way_and_makes_only_its_legs_again() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.8, 0.0), (-0.3, 0.5), (0.2, -0.5), (0.6, 0.5)]);
    user.synthesises();
    let clip = user.clip();
    user.state().selection.only(Item::Goal(clip.id, clip.goals[1].id));
    for key in [Key::G, Key::X, Key::Num1, Key::Period, Key::Num4] {
        user.presses(Modifiers::NONE, key);
    }
    let reach = user.state().motion.reach.clone().expect("asked while it is moved");
    assert_eq!(reach.1, Err("the red sofa is in the way".to_owned()));
    assert_eq!(user.clip().legs.iter().map(|leg| leg.key).collect::<Vec<_>>(), [0, 0, 5]);
    user.presses(Modifiers::NONE, Key::Enter);
    user.waits(|state| !state.jobs.any_running());
    let asked = user.engine.moves.lock().unwrap().last().unwrap().clip.clone();
    assert_eq!(asked.legs.iter().map(|leg| leg.key).collect::<Vec<_>>(), [0, 0, 5], "the last leg is kept");
    assert!((user.clip().goals[1].at.x - 1.1).abs() < 1e-5 && user.clip().legs[0].key == 5);
    assert!(user.state().motion.reach.is_none());
}

#[test]
fn a_sub_goal_is_turned_locked_and_removed_like_everything_else() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.8, 0.0), (-0.3, 0.5), (0.2, -0.5)]);
    let clip = user.clip();
    let item = Item::Goal(clip.id, clip.goals[1].id);
    user.state().selection.only(item);
    for key in [Key::R, Key::Num9, Key::Num0, Key::Enter] {
        user.presses(Modifiers::NONE, key);
    }
    assert!((user.clip().goals[1].facing.unwrap() - std::f32::consts::PI).abs() < 1e-5);
    user.presses(Modifiers::NONE, Key::L);
    user.presses(Modifiers::NONE, Key::X);
    assert_eq!(user.clip().goals.len(), 3, "locked");
    user.presses(Modifiers::NONE, Key::L);
    user.presses(Modifiers::NONE, Key::X);
    assert_eq!(
        user.clip().goals.iter().map(|goal| goal.id).collect::<Vec<_>>(),
        [SubGoalId(0), SubGoalId(2)]
    );
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!(user.clip().goals.len(), 3);
}

#[test]
fn another_body_is_made_at_a_sub_goal_by_f9() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.8, 0.0), (-0.3, 0.5)]);
    let clip = user.clip();
    user.state().selection.only(Item::Goal(clip.id, clip.goals[1].id));
    user.presses(Modifiers::NONE, Key::F9);
    user.waits(|state| !state.jobs.any_running());
    assert_eq!(user.engine.moves.lock().unwrap()[0].anew, [clip.goals[1].id]);
}

#[test]
fn space_plays_arrows_step_and_the_red_frame_is_one_click_away() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.5, 0.0), (0.5, 0.5), (0.5, -0.5)]);
    user.synthesises();
    user.presses(Modifiers::SHIFT, Key::ArrowLeft);
    assert_eq!(user.state().motion.player.seconds, 0.0);
    user.presses(Modifiers::NONE, Key::ArrowRight);
    user.presses(Modifiers::NONE, Key::ArrowRight);
    let clip = user.state().active_clip().unwrap().clone();
    assert_eq!(user.state().frame_now(&clip), Some(2));
    user.presses(Modifiers::NONE, Key::ArrowUp);
    assert_eq!(user.state().frame_now(&clip), Some(LEG), "the next sub-goal");
    assert_eq!(user.state().selection.goals(), [(clip.id, clip.goals[1].id)]);
    user.presses(Modifiers::SHIFT, Key::ArrowRight);
    assert_eq!(user.state().frame_now(&clip), Some(2 * LEG));
    super::actions::go_to_clip_finding(user.state(), 0);
    assert_eq!(user.state().frame_now(&clip), Some(7), "the one that sinks in");
    user.harness.key_press(Key::Space);
    user.harness.step();
    assert!(user.state().motion.player.playing);
    user.harness.step();
    user.harness.key_press(Key::Space);
    user.sees();
    assert!(!user.state().motion.player.playing);
}

#[test]
fn two_motions_play_at_once_and_each_knows_of_the_other() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.5, 0.0), (0.5, 0.5)]);
    user.synthesises();
    user.state().selection.clear();
    super::actions::new_motion(user.state());
    user.places(&[(-0.5, -0.5), (0.5, -0.5)]);
    user.synthesises();
    assert_eq!(user.state().document.scene().clips.len(), 2);
    let others = user.engine.moves.lock().unwrap().last().unwrap().others.clone();
    assert_eq!(others.iter().map(|clip| clip.id).collect::<Vec<_>>(), [ClipId(0)]);
    assert_eq!(super::actors::actors(user.state(), None).iter().filter(|a| a.alpha == 1.0).count(), 2);
}

#[test]
fn motions_are_exported_in_every_format() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.5, 0.0), (0.5, 0.5)]);
    user.synthesises();
    for format in MotionFormat::ALL {
        user.state().ask_motion_export(format);
        user.sees();
        user.harness.get_by_label("Export").click();
        user.sees();
        user.waits(|state| !state.jobs.any_running());
    }
    let written = user.engine.written.lock().unwrap().clone();
    assert_eq!(written.iter().map(|(format, ..)| *format).collect::<Vec<_>>(), MotionFormat::ALL);
    assert!(written.iter().all(|(.., clips)| *clips == 1));
    assert!(written[2].1.to_string_lossy().ends_with(".bvh"));
}

#[test]
fn a_seat_is_a_place_to_sit_for_a_sub_goal_that_takes_whatever_suits() {
    let mut user = User::opens_the_study();
    user.state().motion.options.pose = GoalPose::Sit;
    user.places(&[(0.1, 0.2)]);
    assert_eq!((user.clip().goals[0].pose, user.clip().goals[0].stay_s), (GoalPose::Sit, 2.0));
    user.state().motion.options.pose = GoalPose::Walk;
    user.places(&[(0.4, 0.2)]);
    assert_eq!((user.clip().goals[1].pose, user.clip().goals[1].stay_s), (GoalPose::Walk, 0.0));
}

#[test]
fn a_study_is_blind_scored_by_key_and_leaves_the_users_room_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let results = ["ours/door", "ours/sofa", "theirs/door", "theirs/sofa"];
    let files = results.map(|name| (format!("{name}.inhabit"), Vec::new()));
    crate::document::write_folder(folder.path(), &files).unwrap();
    let mut user = User::opens_the_study();
    user.populates(2);
    user.state().study_setup.folder = folder.path().display().to_string();
    user.state().study_setup.rater = "Ada".to_owned();
    super::commands::find("study").map(|c| (c.run)(user.state()));
    user.sees();
    user.harness.get_by_label("Begin").click();
    user.sees();
    for (number, key) in [Key::Num4, Key::Num2, Key::Num5, Key::Num1].into_iter().enumerate() {
        user.waits(|state| state.study.as_ref().is_some_and(super::study::StudyRun::is_shown));
        let text = format!("{} of 4", number + 1);
        user.harness.get_by_label(&text);
        for giveaway in ["ours", "theirs", "door", "sofa"] {
            assert_eq!(user.harness.query_all_by_label_contains(giveaway).count(), 0, "{giveaway} is shown");
        }
        user.presses(Modifiers::NONE, key);
    }
    let written = |run: &super::study::StudyRun| run.summary.iter().map(|m| m.count).sum::<usize>();
    user.waits(|state| state.study.as_ref().is_some_and(|run| written(run) == 4));
    user.harness.get_by_label("Thank you: everything is scored.");
    let summary = &user.state().study.as_ref().unwrap().summary;
    let counts: Vec<_> = summary.iter().map(|m| (m.method.as_str(), m.count)).collect();
    assert_eq!(counts, [("ours", 2), ("theirs", 2)]);
    assert_eq!(summary.iter().map(|m| m.mean).sum::<f64>(), 6.0);
    user.presses(Modifiers::NONE, Key::Escape);
    assert!(user.people() == 2 && user.state().study.is_none() && user.state().document.is_dirty());
    for file in ["scores-Ada.csv", "summary.csv"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
}

impl User {
    /// Looks at the study for actions, in a panel that is open.
    fn looks_for_actions(&mut self) {
        self.state().requests.show_actions = true;
        self.sees();
        self.harness.get_by_label("What can be done here?").click();
        self.waits(|state| state.life_now().is_some());
    }

    fn does(&mut self, action: &str) {
        self.harness.get_by_label_contains(action).click();
        self.sees();
        self.waits(|state| !state.is_living());
    }

    fn objects(&self) -> Vec<String> {
        let room = &self.harness.state().state.document.scene().room;
        room.objects.iter().map(|o| o.name.clone()).collect()
    }
}

#[test]
fn actions_are_suggested_most_probable_first_and_hovering_points_out_where() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    let tops: Vec<f32> = ["read on sofa (60 %)", "eat on sofa (30 %)", "nap on sofa (10 %)"]
        .map(|name| user.harness.get_by_label(name).rect().top())
        .to_vec();
    assert!(tops.windows(2).all(|pair| pair[0] < pair[1]), "{tops:?}");
    user.harness.get_by_label("read on sofa (60 %)").hover();
    user.sees();
    assert_eq!(user.state().living.pointed_out, [ObjectId(1)]);
    user.harness.get_by_label("Not possible here (1)");
}

#[test]
fn an_action_is_one_step_with_its_person_and_undo_takes_all_of_it_back() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    user.does("read on sofa (60");
    assert_eq!(user.history(), ["read on sofa"]);
    assert_eq!(user.objects(), ["Oak floor", "Red sofa", "book"]);
    let person = user.state().document.scene().people[0].clone();
    assert_eq!(person.body.translation.y, 0.9, "fitted");
    assert_eq!(user.state().measured(person.id).map(|m| m.report.metrics.penetration_max_mm), Some(2.0));
    assert!(user.harness.query_all_by_label_contains("book came, on Red sofa").count() > 0);
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!((user.objects().len(), user.people()), (2, 0));
    assert_eq!(user.state().life_now(), Some(0), "the panel knows where it is");
    user.presses(Modifiers { shift: true, ..Modifiers::COMMAND }, Key::Z);
    assert_eq!((user.objects().len(), user.state().life_now()), (3, Some(1)));
}

#[test]
fn two_futures_of_one_room_are_branches_that_one_can_go_to_and_fro_between() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    user.does("read on sofa (60");
    user.does("eat on sofa (30");
    user.state().re_roll_action();
    user.waits(|state| !state.is_living());
    let tree = &user.state().living.tree;
    assert_eq!(
        tree.iter().map(|node| (node.parent, node.roll)).collect::<Vec<_>>()[2..],
        [(Some(1), 0), (Some(1), 1)]
    );
    assert_eq!(user.people(), 1, "whoever ate before is gone");
    assert!(user.state().show_life(2));
    assert_eq!(user.state().life_now(), Some(2));
    assert!(user.state().show_life(0));
    assert_eq!((user.objects().len(), user.people()), (2, 0));
    assert_eq!(user.history().last().map(String::as_str), Some("Go to the room as it was"));
}

#[test]
fn a_sampled_chain_skips_what_is_not_possible_and_is_a_step_for_each_action() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    user.state().living.count = 3;
    user.state().start_chain();
    user.waits(|state| !state.is_living());
    assert_eq!(user.history(), ["read on sofa", "eat on sofa", "read on sofa"]);
    assert_eq!((user.objects().len(), user.people()), (5, 1));
}

#[test]
fn a_banned_kind_is_not_brought_again_and_a_cancelled_action_keeps_what_was_done() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    user.does("read on sofa (60");
    user.harness.get_by_label("Never bring: book").click_accesskit();
    user.sees();
    user.waits(|state| !state.is_living());
    assert_eq!(user.objects(), ["Oak floor", "Red sofa", "cup"]);
    *user.engine.making.lock().unwrap() = Making::Endless;
    user.state().apply(Command::MoveObject(ObjectId(1), Affine3A::from_translation(Vec3::X)));
    assert_eq!(user.state().life_now(), None, "changed by hand");
    user.sees();
    user.harness.get_by_label("Look at the room again").click();
    user.waits(|state| state.life_now().is_some());
    user.state().start_action(0);
    user.waits(|state| !state.ghosts.is_empty());
    user.state().cancel_all();
    assert!(user.history().last().is_some_and(|label| label == "read on sofa") && !user.state().is_living());
}

#[test]
fn an_action_that_is_not_possible_says_why_and_changes_nothing() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    user.does("nap on sofa (10");
    assert!(user.errors()[0].contains("it is too short"), "{:?}", user.errors());
    assert!(user.history().is_empty());
}

#[test]
fn a_replay_shows_the_way_here_and_changes_nothing() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    user.does("read on sofa (60");
    user.does("eat on sofa (30");
    let history = user.history();
    user.state().toggle_replay();
    let shown = |user: &mut User| {
        let number = user.state().replayed()?;
        user.state().life_scene(number).map(|(room, _)| (number, room.objects.len()))
    };
    assert_eq!(shown(&mut user), Some((0, 2)), "the room as it was");
    assert!(user.state().advance_replay(1.5));
    assert_eq!(shown(&mut user), Some((1, 3)));
    assert!(!user.state().advance_replay(10.0), "it ends by itself");
    assert_eq!((user.history(), user.objects().len()), (history, 4));
}

#[test]
fn sub_goals_that_change_while_a_motion_is_made_are_not_lost() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.5, 0.0), (0.5, 0.5)]);
    *user.engine.making.lock().unwrap() = Making::FirstThenEndless;
    user.presses(Modifiers { shift: true, ..Modifiers::COMMAND }, Key::Enter);
    user.places(&[(0.3, -0.5)]);
    assert!(user.state().jobs.moving());
    *user.engine.making.lock().unwrap() = Making::Quick;
    user.waits(|state| !state.jobs.any_running() && state.can_play());
    assert_eq!(
        (user.clip().goals.len(), user.clip().frames.len()),
        (3, 2 * LEG + 1),
        "made again with all three"
    );
}

impl User {
    /// Unfolds the list of things in the panel of actions.
    fn looks_at_the_things(&mut self) {
        self.state().requests.show_actions = true;
        self.sees();
        self.harness.get_by_label("Things (2)").click();
        self.waits(|state| state.thing_look("cup").is_some());
    }

    fn drops(&mut self, file: &str) {
        let file: egui::DroppedFileHandle = Arc::new(Dropped(PathBuf::from(file)));
        self.harness.input_mut().dropped_files.push(file);
        self.sees();
    }
}

#[test]
fn things_are_listed_with_pictures_bounded_and_banned() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    user.looks_at_the_things();
    let book = user.state().thing_kinds()[0].clone();
    user.state().set_most(&book, 1);
    user.does("read on sofa (60");
    user.does("read on sofa (60");
    assert!(user.errors()[0].contains("no room for another book"), "{:?}", user.errors());
    user.harness.get_by_label("Ban book").click_accesskit();
    user.sees();
    user.state().start_action(0);
    user.waits(|state| !state.is_living());
    assert_eq!(user.objects(), ["Oak floor", "Red sofa", "book", "cup"]);
    user.harness.get_by_label("Allow book").click_accesskit();
    user.sees();
    user.state().set_most(&book, book.most);
    assert!(user.state().living.choice.most.is_empty() && user.state().living.choice.banned.is_empty());
}

#[test]
fn a_dropped_model_becomes_a_thing_of_its_kind_and_size_and_is_there_in_the_next_session() {
    let folder = tempfile::tempdir().unwrap();
    let mut user = User::opens_the_study();
    user.state().remember_things(Some(folder.path().join("things")));
    user.drops("my_cup.obj");
    assert_eq!(user.state().document.scene().room.name, "Study", "nothing is opened unasked");
    user.harness.get_by_label("Add to the things").click();
    user.waits(|state| state.things.form.as_ref().is_some_and(|form| form.look.is_some()));
    for _ in 0..3 {
        user.harness.get_by_label("Tip over").click();
        user.sees();
    }
    user.waits(|state| !state.jobs.any_running());
    user.harness.get_by_label("Add").click();
    user.waits(|state| state.overlay == Overlay::None);
    let own = user.state().living.choice.own.clone();
    assert_eq!((own[0].kind.as_str(), own[0].name.as_str()), ("cup", "my cup"));
    let size_m = own[0].model.bounds().size();
    assert!((size_m - Vec3::new(0.06, 0.09, 0.06)).length() < 1e-4, "upright, in metres: {size_m}");
    let mut later = User::opens_the_study();
    user.waits(|_| crate::document::read_things(&folder.path().join("things")).0.len() == 1);
    later.state().remember_things(Some(folder.path().join("things")));
    later.waits(|state| state.living.choice.own.len() == 1);
}

#[test]
fn two_futures_are_seen_side_by_side_and_one_is_chosen() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    user.does("read on sofa (60");
    user.state().re_roll_action();
    user.waits(|state| !state.is_living());
    let history = user.history();
    assert_eq!(user.harness.query_all_by_label_contains("Show beside: ").count(), 2);
    user.state().toggle_beside(1);
    user.sees();
    user.harness.get_by_label("The other future");
    assert_eq!((user.state().shown_beside(), user.history()), (Some(1), history), "looking changes nothing");
    user.harness.get_by_label("Choose this one").click();
    user.sees();
    assert_eq!((user.state().life_now(), user.state().shown_beside()), (Some(1), None));
    assert!(user.harness.query_by_label("The other future").is_none());
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!(user.state().life_now(), Some(2), "choosing is one step");
}

#[test]
fn what_was_learned_is_a_graph_that_leads_to_the_plots_of_an_action_and_its_doubts() {
    let mut user = User::opens_the_study();
    user.state().overlay = Overlay::Learned(None);
    user.sees();
    user.harness.get_by_label("The graph of actions");
    user.harness.get_by_label("use computer on desk while sitting").click();
    user.sees();
    assert!(user.harness.query_all_by_label("rests on 11 instances").count() > 0);
    assert!(user.harness.query_all_by_label_contains("keyboard (").count() > 0);
}

#[test]
fn captured_pieces_are_looked_up_in_the_folder_that_is_named() {
    let mut user = User::opens_the_study();
    user.places(&[(-0.5, 0.0), (0.5, 0.5)]);
    user.state().motion.options.method = MotionMethod::Retrieval;
    user.state().requests.show_motion = true;
    user.sees();
    assert!(user.state().can_synthesise().is_err_and(|why| why.contains("folder")));
    user.state().motion.options.clips = "clips".to_owned();
    user.synthesises();
    let tasks = user.engine.moves.lock().unwrap();
    let task = tasks.last().unwrap();
    assert_eq!((task.method, task.clips.clone()), (MotionMethod::Retrieval, Some(PathBuf::from("clips"))));
}

#[test]
fn a_day_is_one_motion_one_step_and_the_room_changes_as_it_plays() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    user.state().living.count = 2;
    user.sees();
    user.harness.get_by_label("A day in this room (2 actions)").click();
    user.sees();
    user.waits(|state| !state.is_living());
    assert_eq!(user.history(), ["A day in this room"]);
    assert_eq!(user.objects(), ["Oak floor", "Red sofa", "book", "book"]);
    let objects = |user: &mut User, seconds: f32| {
        let length_s = user.state().play_seconds();
        user.state().motion.player.seek(seconds, length_s);
        let now = user.state().replayed().or(user.state().life_now()).unwrap();
        user.state().life_scene(now).map(|(room, _)| room.objects.len()).unwrap()
    };
    assert_eq!([0.0, 1.0, 1.9].map(|seconds| objects(&mut user, seconds)), [2, 3, 4]);
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!((user.objects().len(), user.state().document.scene().clips.len()), (2, 0));
}

#[test]
fn a_day_that_is_stopped_is_kept_as_far_as_it_has_come_as_one_step() {
    let mut user = User::opens_the_study();
    *user.engine.making.lock().unwrap() = Making::Endless;
    user.looks_for_actions();
    user.state().living.count = 3;
    user.state().start_day();
    user.waits(|state| state.jobs.day.as_ref().is_some_and(super::day::LivingDay::has_begun));
    user.harness.get_by_label("Stop and keep").click();
    user.sees();
    assert!(!user.state().is_living());
    assert_eq!(user.history(), ["A day in this room"]);
    assert_eq!(user.objects(), ["Oak floor", "Red sofa", "book"], "the first action of three");
    user.presses(Modifiers::COMMAND, Key::Z);
    assert_eq!((user.objects().len(), user.state().document.scene().clips.len()), (2, 0));
}

#[test]
fn a_day_is_exported_with_the_things_that_move_and_the_room_as_it_is_by_then() {
    let mut user = User::opens_the_study();
    user.looks_for_actions();
    user.state().living.count = 2;
    user.state().start_day();
    user.waits(|state| !state.is_living());
    let exports = |user: &mut User| {
        user.state().ask_motion_export(MotionFormat::GlbWithRoom);
        user.state().start_motion_export();
        user.waits(|state| !state.jobs.any_running());
        *user.engine.changes.lock().unwrap()
    };
    assert_eq!(exports(&mut user), (2, 3), "two things come, in three rooms one after the other");
    user.state().apply(Command::MoveObject(ObjectId(1), Affine3A::from_translation(Vec3::X)));
    assert_eq!(exports(&mut user), (0, 0));
    let said = user.state().notices.all().any(|(_, n)| n.text.contains("its things stand still"));
    assert!(said, "a room that was changed since is not passed off as the day's");
}
