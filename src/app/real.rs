//! The work behind the window as it really is: files, geometry, generation and measurement.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;

use super::engine::{
    Energies, Engine, FitTask, ImportChoice, ImportSummary, Made, MotionExport, MovePreview, MoveTask, Moved,
    NetworkCard, Opened, OpenedProject, Photo, PhotoTask, PopulateTask, RoomRequest, SampleMethod,
    SampleTask, SampleView, Sampled, Source, ThingKind, ThingPicture,
};
use super::jobs::is_project_file;
use super::lived::{self, ActionChoice, LivedRoom};
use super::moving;
use super::moving::Memories;
use super::networks;
use super::photos;
use super::sampling;
use super::thing_pictures;
use crate::assets::Budget;
use crate::assets::Model;
use crate::assets::glb_from_model;
use crate::assets::read_model;
use crate::assets::read_model_bytes;
use crate::assets::sample_rooms;
use crate::body::Body;
use crate::document::Project;
use crate::document::load_project;
use crate::document::save_project;
use crate::document::write_folder;
use crate::evolve;
use crate::evolve::OnCancel;
use crate::evolve::PopulatePreview;
use crate::evolve::PopulateRequest;
use crate::evolve::PopulatedPerson;
use crate::fit::TERMS;
use crate::generate::sensor::SceneImage;
use crate::generate::sensor::Sensor;
use crate::inspect::BodyReport;
use crate::inspect::MotionReport;
use crate::inspect::inspect_body;
use crate::job::{JobCtx, Seed, Stop, Ticker};
use crate::render::Backend;
use crate::render::BodySurface;
use crate::render::Cutaway;
use crate::render::Picture;
use crate::render::SceneDraw;
use crate::render::Shown;
use crate::render::person_glb;
use crate::render::picture;
use crate::render::room_views;
use crate::scene::BETAS;
use crate::scene::BodyParams;
use crate::scene::Clip;
use crate::scene::Frame;
use crate::scene::GeometryConfig;
use crate::scene::ImportOptions;
use crate::scene::Person;
use crate::scene::Room;
use crate::scene::RoomGeometry;
use crate::scene::Scene;
use crate::scene::SubGoal;
use crate::scene::SubGoalId;
use crate::scene::layout::RoomType;
use crate::scene::layout::new_room;
use crate::scene::model_from_room;
use crate::scene::understand;

/// Size of the picture of a new room in pixels.
const OVERVIEW: [u32; 2] = [800, 480];

/// Behind it: neither glaring on a dark page nor a hole in a light one.
const OVERVIEW_GROUND: [u8; 3] = [104, 109, 116];

/// The program's own engine.
#[derive(Default)]
pub struct RealEngine {
    memories: Memories,
}

impl Engine for RealEngine {
    fn samples(&self) -> Vec<String> {
        sample_rooms().iter().map(|sample| sample.title.to_owned()).collect()
    }

    fn open(&self, source: &Source, ticker: &Ticker) -> Result<Opened, Stop> {
        ticker.stage("reading", 0)?;
        match source {
            Source::File(path, _) if is_project_file(path) => open_project(path, source),
            Source::File(path, choice) => {
                let model = read_model(path, &Budget::default())?;
                ticker.stage("understanding", 0)?;
                understood(&model, source, *choice, ticker)
            }
            Source::Sample(number) => open_sample(*number, source, ticker),
            Source::Made(request) => self.make_room(request, ticker),
        }
    }

    fn save(&self, path: &Path, project: &Project, ticker: &Ticker) -> Result<(), Stop> {
        ticker.stage("writing", 0)?;
        Ok(save_project(path, project)?)
    }

    fn export(&self, folder: &Path, scene: &Scene, ticker: &Ticker) -> Result<usize, Stop> {
        ticker.stage("writing", scene.people.len() + 1)?;
        let surface = self.surface();
        let mut files = vec![("room.glb".to_owned(), glb_from_model(&model_from_room(&scene.room))?)];
        for person in scene.people.iter().filter(|person| person.visible) {
            ticker.advance()?;
            files.push((format!("people/{:03}.glb", person.id.0), person_glb(person, &surface)?));
        }
        write_folder(folder, &files)?;
        Ok(files.len())
    }

    fn geometry(&self, room: &Room, ticker: &Ticker) -> Result<RoomGeometry, Stop> {
        ticker.stage("rays, distances, surfaces", 0)?;
        RoomGeometry::build(room, &GeometryConfig::default(), &asks(ticker)).map_err(|_| Stop::Cancelled)
    }

    fn populate(&self, task: &PopulateTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
        let request = PopulateRequest {
            people: task.people,
            at: task.at,
            families: task.families.clone(),
            existing: task.existing.clone(),
            next_id: task.next_id,
            on_cancel: OnCancel::KeepBest,
            ..PopulateRequest::default()
        };
        let populated = evolve::populate(&task.room, &task.geometry, &request, cx)?;
        let mut made = Made { shortfall: populated.shortfall, ..Made::default() };
        for PopulatedPerson { person, proposed, report, trace, .. } in populated.people {
            made.people.push(person);
            made.before.push(proposed);
            made.reports.push(report);
            made.energies.push(by_term(&trace));
        }
        Ok(made)
    }

    fn missing_methods(&self) -> Vec<(SampleMethod, String)> {
        let missing = |method| Some((method, sampling::why_missing(method)?));
        SampleMethod::ALL.into_iter().filter_map(missing).collect()
    }

    fn see(
        &self,
        room: &Room,
        geometry: &RoomGeometry,
        view: &SampleView,
        seed: Seed,
        ticker: &Ticker,
    ) -> Result<SceneImage, Stop> {
        ticker.stage("looking", 0)?;
        let view = sampling::view_of(room, geometry, view, seed)?;
        Ok(Sensor::new(room, geometry).scene_image(&view))
    }

    fn sample(&self, task: &SampleTask, cx: &JobCtx<PopulatePreview>) -> Result<Sampled, Stop> {
        sampling::sample(task, cx)
    }

    fn fit(&self, task: &FitTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
        sampling::fit(task, cx)
    }

    fn portrait(
        &self,
        room: &Room,
        geometry: &RoomGeometry,
        person: &Person,
        ticker: &Ticker,
    ) -> Result<Picture, Stop> {
        sampling::portrait(room, geometry, person, &self.surface(), ticker)
    }

    fn open_photo(&self, picture: &Path, keypoints: &Path, ticker: &Ticker) -> Result<Photo, Stop> {
        ticker.stage("reading", 0)?;
        photos::open(picture, keypoints)
    }

    fn fit_photo(&self, task: &PhotoTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
        photos::fit(task, cx)
    }

    fn room_kinds(&self) -> Vec<String> {
        RoomType::ALL.map(|kind| kind.label().to_owned()).to_vec()
    }

    fn make_room(&self, request: &RoomRequest, ticker: &Ticker) -> Result<Opened, Stop> {
        ticker.stage("furnishing", 0)?;
        let kind = RoomType::ALL.get(request.kind).copied();
        let kind = kind.ok_or_else(|| Stop::Failed("there is no such kind of room".to_owned()))?;
        let model = new_room(kind, request.seed)?;
        ticker.stage("understanding", 0)?;
        let source = Source::Made(request.clone());
        let mut opened = understood(&model, &source, ImportChoice::default(), ticker)?;
        opened.summary.name = format!("{} {}", kind.label(), request.seed);
        if let Some(room) = Arc::get_mut(&mut opened.scene.room) {
            room.name.clone_from(&opened.summary.name);
        }
        Ok(opened)
    }

    fn overview(&self, room: &Arc<Room>, ticker: &Ticker) -> Result<Picture, Stop> {
        ticker.stage("drawing", 0)?;
        let [width, height] = OVERVIEW;
        let scene = Scene { room: room.clone(), ..Scene::default() };
        let mut draw = SceneDraw::of_room(&scene);
        draw.look.cutaway = Cutaway::Outside;
        draw.look.grid = Shown::No;
        draw.look.background = OVERVIEW_GROUND;
        let [camera, _] = room_views(room, width as f32 / height as f32);
        Ok(picture(&draw, &camera, OVERVIEW, Backend::Auto)?)
    }

    fn networks(&self) -> Arc<[NetworkCard]> {
        networks::cards()
    }

    fn measure(
        &self,
        geometry: &RoomGeometry,
        body: &BodyParams,
        ticker: &Ticker,
    ) -> Result<BodyReport, Stop> {
        ticker.check()?;
        Ok(inspect_body(geometry, Body::bundled(), body))
    }

    fn pose(&self, body: &BodyParams) -> Arc<[Vec3]> {
        Body::bundled().pose(body).vertices.into()
    }

    fn pose_frame(&self, betas: &[f32; BETAS], frame: &Frame) -> Arc<[Vec3]> {
        Body::bundled().pose_frame(betas, frame).vertices.into()
    }

    fn synthesise(&self, task: &MoveTask, cx: &JobCtx<MovePreview>) -> Result<Moved, Stop> {
        moving::synthesise(task, &self.memories, cx)
    }

    fn measure_clip(
        &self,
        geometry: &RoomGeometry,
        clip: &Clip,
        ticker: &Ticker,
    ) -> Result<MotionReport, Stop> {
        moving::measure(geometry, clip, ticker)
    }

    fn reach(
        &self,
        room: &Room,
        geometry: &RoomGeometry,
        clip: &Clip,
        goal: SubGoalId,
    ) -> Result<(), String> {
        moving::reach(room, geometry, clip, goal)
    }

    fn stand_in(&self, goal: &SubGoal, betas: &[f32; BETAS]) -> Frame {
        moving::stand_in(goal, betas)
    }

    fn export_motion(&self, path: &Path, export: &MotionExport, ticker: &Ticker) -> Result<usize, Stop> {
        moving::export(path, export, &self.surface(), ticker)
    }

    fn look_for_actions(
        &self,
        room: &Arc<Room>,
        choice: &ActionChoice,
        seed: u64,
        ticker: &Ticker,
    ) -> Result<Arc<dyn LivedRoom>, Stop> {
        lived::look_at(room, choice, seed, ticker)
    }

    fn thing_kinds(&self) -> Vec<ThingKind> {
        thing_pictures::kinds()
    }

    fn thing_picture(&self, kind: &str, ticker: &Ticker) -> Result<ThingPicture, Stop> {
        thing_pictures::of_kind(kind, ticker)
    }

    fn read_thing(&self, path: &Path, ticker: &Ticker) -> Result<Model, Stop> {
        ticker.stage("reading", 0)?;
        Ok(read_model(path, &Budget::default())?)
    }

    fn model_picture(&self, model: &Model, ticker: &Ticker) -> Result<ThingPicture, Stop> {
        thing_pictures::of_model(model, ticker)
    }

    fn faces(&self) -> Arc<[[u32; 3]]> {
        Body::bundled().model.faces.as_slice().into()
    }

    fn surface(&self) -> Arc<BodySurface> {
        Arc::new(BodySurface::of(Body::bundled()))
    }
}

/// The step of a library function that asks `ticker` whether to go on.
pub(super) fn asks(ticker: &Ticker) -> impl Fn(usize, usize) -> ControlFlow<()> + Sync {
    |done, total| match ticker.step(done, total) {
        Ok(()) => ControlFlow::Continue(()),
        Err(_) => ControlFlow::Break(()),
    }
}

fn open_sample(number: usize, source: &Source, ticker: &Ticker) -> Result<Opened, Stop> {
    let rooms = sample_rooms();
    let sample = rooms.get(number).or(rooms.first());
    let sample = sample.ok_or_else(|| Stop::Failed("no sample room is bundled".to_owned()))?;
    let model = read_model_bytes(&format!("{}.glb", sample.key), sample.glb, &Budget::default())?;
    let mut opened = understood(&model, source, ImportChoice::default(), ticker)?;
    sample.title.clone_into(&mut opened.summary.name);
    if let Some(room) = Arc::get_mut(&mut opened.scene.room) {
        sample.title.clone_into(&mut room.name);
    }
    Ok(opened)
}

fn open_project(path: &Path, source: &Source) -> Result<Opened, Stop> {
    let loaded = load_project(path)?;
    let Project { scene, next } = loaded.project;
    let summary = ImportSummary {
        source: source.clone(),
        name: scene.room.name.clone(),
        unit_m: 1.0,
        up: crate::scene::UpAxis::Y,
        triangles: scene.room.triangle_count(),
        objects: scene.room.objects.len(),
        extent_m: size_m(&scene.room),
        evidence: Vec::new(),
        notes: loaded.notes,
    };
    let project = Some(OpenedProject { path: path.to_path_buf(), next });
    Ok(Opened { scene, summary, project })
}

/// The room that a model is understood as.
fn understood(model: &Model, source: &Source, choice: ImportChoice, ticker: &Ticker) -> Result<Opened, Stop> {
    let options = ImportOptions { unit_scale: choice.unit_m, up: choice.up };
    let imported = understand(model, &options, &asks(ticker)).map_err(|_| Stop::Cancelled)?;
    let report = imported.report;
    let summary = ImportSummary {
        source: source.clone(),
        name: report.source,
        unit_m: report.unit_scale,
        up: report.up,
        triangles: report.triangles,
        objects: report.objects,
        extent_m: Vec3::from_array(report.extent_m),
        evidence: report.evidence,
        notes: report.notes,
    };
    let scene = Scene { room: Arc::new(imported.room), ..Scene::default() };
    Ok(Opened { scene, summary, project: None })
}

fn size_m(room: &Room) -> Vec3 {
    let bounds = room.bounds();
    if bounds.is_empty() { Vec3::ZERO } else { bounds.size() }
}

/// One curve for each term of the energy.
pub(super) fn by_term(trace: &[[f32; TERMS.len()]]) -> Energies {
    let curve = |i: usize| trace.iter().map(|terms| terms[i]).collect();
    TERMS.iter().enumerate().map(|(i, term)| (term.label().to_owned(), curve(i))).collect()
}

/// The source that an argument of the command line names: a file, or `sample:KEY`.
pub fn source_named(path: Option<PathBuf>) -> Source {
    let Some(path) = path else { return Source::Sample(0) };
    let key = path.to_str().and_then(|text| text.strip_prefix("sample:"));
    let number = key.and_then(|key| sample_rooms().iter().position(|sample| sample.key == key));
    number.map_or(Source::File(path, ImportChoice::default()), Source::Sample)
}
