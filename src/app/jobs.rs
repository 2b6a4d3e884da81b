//! What runs beside the window, and how its outcome becomes a command. A frame never waits: each poll looks
//! once at every job. A cancelled job is let go of at once; its thread ends at its next step.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use super::actions;
use super::day::LivingDay;
use super::engine::{FitTask, Made, Opened, Photo, PopulateTask, SampleMethod, Source};
use super::living::{Acting, Looking};
use super::motion::{Making, Measuring as MeasuringClip};
use super::rooms;
use super::samples::{self, Origin};
use super::selection::Item;
use super::state::{EditorState, Leaving, Overlay};
use super::things::ThingJobs;
use crate::document::Command;
use crate::document::Document;
use crate::document::RoomVersion;
use crate::evolve::PopulatePreview;
use crate::generate::sensor::SceneImage;
use crate::inspect::BodyReport;
use crate::job::{Job, Outcome, Progress, Seed};
use crate::scene::Person;
use crate::scene::PersonId;
use crate::scene::RoomGeometry;

/// Which job a row of the job list stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobKind {
    /// Reads a file.
    Open,
    /// Writes a file.
    Save,
    /// Writes files for other programs.
    Export,
    /// Builds ray tree, distance field and surfaces.
    Geometry,
    /// Makes people.
    Populate,
    /// Measures people.
    Measure,
    /// Samples candidates from a view.
    Sample,
    /// Draws candidates.
    Portraits,
    /// Makes a room to look at.
    MakeRoom,
    /// Looks at the room as a network does.
    See,
    /// Reads a photo.
    Photo,
    /// Makes a motion.
    Move,
    /// Measures a motion.
    MeasureMotion,
    /// Writes motions.
    ExportMotion,
    /// Looks for actions or does them.
    Act,
    /// Draws, reads or keeps things.
    Things,
}

/// A row of the job list.
#[derive(Clone, Debug)]
pub struct JobRow {
    /// Which.
    pub kind: JobKind,
    /// Name for people.
    pub name: String,
    /// How far it is.
    pub progress: Progress,
    /// Since it began.
    pub elapsed: Duration,
}

/// What to make once there is geometry.
#[derive(Clone, Debug, PartialEq)]
enum Wanted {
    New { people: usize, at: Option<glam::Vec3> },
    Again(Vec<PersonId>),
}

struct Populating {
    job: Job<Made, PopulatePreview>,
    version: RoomVersion,
    replacing: Vec<PersonId>,
    /// Set when candidates of the contact sheet are being fitted.
    source: Option<samples::Source>,
    /// The user has cancelled; whoever is there by now comes in a moment.
    stopping: bool,
}

struct Measuring {
    job: Job<Vec<(Person, BodyReport)>>,
    version: RoomVersion,
}

/// Everything that runs, and what waits.
#[derive(Default)]
pub struct Jobs {
    open: Option<Job<Opened>>,
    save: Option<(PathBuf, u64, Job<()>)>,
    export: Option<(PathBuf, Job<usize>)>,
    geometry: Option<(RoomVersion, Job<RoomGeometry>)>,
    populate: Option<Populating>,
    measure: Option<Measuring>,
    pub(super) sampling: Option<samples::Sampling>,
    pub(super) portraits: Option<samples::Portraits>,
    pub(super) making_room: Option<rooms::MakingRoom>,
    pub(super) seeing: Option<Job<SceneImage>>,
    pub(super) photo: Option<Job<Photo>>,
    pub(super) making: Option<Making>,
    pub(super) measuring_clip: Option<MeasuringClip>,
    pub(super) exporting_motion: Option<(PathBuf, Job<usize>)>,
    pub(super) looking: Option<Looking>,
    pub(super) acting: Option<Acting>,
    pub(super) day: Option<LivingDay>,
    pub(super) things: ThingJobs,
    wanted: Option<Wanted>,
    /// The room whose geometry failed; not tried again until the room changes.
    hopeless: Option<RoomVersion>,
    /// The revision at which measuring failed; not tried again until something changes.
    unmeasurable: Option<u64>,
}

impl Jobs {
    /// Whether anything runs or waits.
    pub fn any_running(&self) -> bool {
        !self.rows().is_empty() || self.wanted.is_some()
    }

    /// Whether a file is being read.
    pub fn opening(&self) -> bool {
        self.open.is_some()
    }

    /// Whether people are being made or wait for geometry.
    pub fn populating(&self) -> bool {
        self.populate.is_some() || self.wanted.is_some()
    }

    /// Whether candidates are being sampled.
    pub fn sampling(&self) -> bool {
        self.sampling.is_some()
    }

    /// Whether a room is being made to look at.
    pub fn making_room(&self) -> bool {
        self.making_room.is_some()
    }

    /// Whether a motion is being made.
    pub fn moving(&self) -> bool {
        self.making.is_some()
    }

    /// Whether people wait for geometry.
    pub fn waiting(&self) -> bool {
        self.wanted.is_some()
    }

    /// One row for each job that runs.
    pub fn rows(&self) -> Vec<JobRow> {
        let mut rows = Vec::new();
        if let Some(job) = &self.open {
            rows.push(row(JobKind::Open, job));
        }
        if let Some((_, _, job)) = &self.save {
            rows.push(row(JobKind::Save, job));
        }
        if let Some((_, job)) = &self.export {
            rows.push(row(JobKind::Export, job));
        }
        if let Some((_, job)) = &self.geometry {
            rows.push(row(JobKind::Geometry, job));
        }
        if let Some(populating) = &self.populate {
            rows.push(row(JobKind::Populate, &populating.job));
        }
        if let Some(measuring) = &self.measure {
            rows.push(row(JobKind::Measure, &measuring.job));
        }
        if let Some(sampling) = &self.sampling {
            rows.push(row(JobKind::Sample, &sampling.job));
        }
        if let Some(job) = &self.portraits {
            rows.push(row(JobKind::Portraits, job));
        }
        if let Some(job) = &self.making_room {
            rows.push(row(JobKind::MakeRoom, job));
        }
        if let Some(job) = &self.seeing {
            rows.push(row(JobKind::See, job));
        }
        if let Some(job) = &self.photo {
            rows.push(row(JobKind::Photo, job));
        }
        if let Some(making) = &self.making {
            rows.push(row(JobKind::Move, &making.job));
        }
        if let Some(measuring) = &self.measuring_clip {
            rows.push(row(JobKind::MeasureMotion, &measuring.job));
        }
        if let Some((_, job)) = &self.exporting_motion {
            rows.push(row(JobKind::ExportMotion, job));
        }
        if let Some((_, job)) = &self.looking {
            rows.push(row(JobKind::Act, job));
        }
        if let Some(acting) = &self.acting {
            rows.push(row(JobKind::Act, &acting.job));
        }
        if let Some(living) = &self.day {
            rows.push(row(JobKind::Act, &living.job));
        }
        if let Some(job) = &self.things.pictures {
            rows.push(row(JobKind::Things, job));
        }
        if let Some(job) = &self.things.reading {
            rows.push(row(JobKind::Things, job));
        }
        rows
    }
}

fn row<T: Send + 'static, P: Send + 'static>(kind: JobKind, job: &Job<T, P>) -> JobRow {
    JobRow { kind, name: job.name().to_owned(), progress: job.progress(), elapsed: job.elapsed() }
}

impl EditorState {
    pub(super) fn waker(&self) -> impl Fn() + Send + Sync + 'static {
        let wake = self.wake.clone();
        move || wake()
    }

    /// Starts to read a room or project. Asks first when that would lose unsaved work.
    pub fn open(&mut self, source: Source) {
        let is_project = matches!(&source, Source::File(path, _) if is_project_file(path));
        if is_project && self.has_unsaved_work() {
            self.overlay = Overlay::Unsaved(Leaving::Open(source));
        } else {
            self.open_now(source);
        }
    }

    /// Starts to read a room or project without asking.
    pub fn open_now(&mut self, source: Source) {
        let name = match &source {
            Source::File(path, _) => format!("Open {}", file_name(path)),
            Source::Sample(number) => {
                format!("Open {}", self.engine.samples().get(*number).map_or("sample room", |s| s))
            }
            Source::Made(_) => "Make room".to_owned(),
        };
        let engine = self.engine.clone();
        let waker = self.waker();
        let work = move |cx: &crate::job::JobCtx| engine.open(&source, cx.ticker());
        self.jobs.open = Some(Job::spawn(name, Seed::root(0), waker, work));
        self.overlay = Overlay::None;
    }

    /// Starts to write the project.
    pub fn start_saving(&mut self, path: PathBuf) {
        self.document.commit();
        let project = self.document.project();
        let (engine, target) = (self.engine.clone(), path.clone());
        let work = move |cx: &crate::job::JobCtx| engine.save(&target, &project, cx.ticker());
        let name = format!("Save {}", file_name(&path));
        let job = Job::spawn(name, Seed::root(0), self.waker(), work);
        self.jobs.save = Some((path, self.document.revision(), job));
    }

    /// Starts to make people near `at` (one) or anywhere (as many as the options say).
    pub fn start_populating(&mut self, at: Option<glam::Vec3>) {
        let people = if at.is_some() { 1 } else { self.populate.people };
        self.want(Wanted::New { people, at });
    }

    /// Starts to make these people anew.
    pub fn start_re_rolling(&mut self, ids: &[PersonId]) {
        self.want(Wanted::Again(ids.to_vec()));
    }

    /// Now if the geometry is there, otherwise as soon as it is.
    fn want(&mut self, wanted: Wanted) {
        if !self.has_room() {
            self.notices.warning("Open a room first.");
            return;
        }
        self.jobs.populate = None;
        self.ghosts.clear();
        self.jobs.wanted = Some(wanted);
        self.jobs.hopeless = None;
        self.keep_geometry_fresh();
        self.start_wanted();
    }

    fn start_wanted(&mut self) {
        let Some(geometry) = self.geometry().cloned() else { return };
        let Some(wanted) = self.jobs.wanted.take() else { return };
        let seed = Seed::root(self.populate.seed);
        let version = self.document.room_version();
        let (tasks, replacing, name) = match wanted {
            Wanted::New { people, at } => {
                let task = self.task(&geometry, people, at, &[]);
                let name = if at.is_some() {
                    "Put somebody here".to_owned()
                } else {
                    format!("Populate: {people} people")
                };
                (vec![task], Vec::new(), name)
            }
            Wanted::Again(ids) => (self.tasks_again(&geometry, &ids), ids, "Re-roll".to_owned()),
        };
        let engine = self.engine.clone();
        let work = move |cx: &crate::job::JobCtx<PopulatePreview>| {
            let mut all = Made::default();
            for mut task in tasks {
                task.existing.extend(all.people.iter().cloned());
                let made = engine.populate(&task, cx)?;
                all.people.extend(made.people);
                all.reports.extend(made.reports);
                all.energies.extend(made.energies);
                all.before.extend(made.before);
                all.shortfall = all.shortfall.or(made.shortfall);
            }
            Ok(all)
        };
        let job = Job::spawn(name, seed, self.waker(), work);
        self.jobs.populate = Some(Populating { job, version, replacing, source: None, stopping: false });
    }

    /// Starts to fit people from where they are: candidates, or people of the document (`replacing`).
    pub(super) fn start_fitting(
        &mut self,
        name: String,
        task: FitTask,
        replacing: Vec<PersonId>,
        source: Option<samples::Source>,
    ) {
        let engine = self.engine.clone();
        let work = move |cx: &crate::job::JobCtx<PopulatePreview>| engine.fit(&task, cx);
        let job = Job::spawn(name, Seed::root(self.populate.seed), self.waker(), work);
        let version = self.document.room_version();
        self.jobs.populate = Some(Populating { job, version, replacing, source, stopping: false });
    }

    /// Starts to make people by `work`.
    pub(super) fn start_making(
        &mut self,
        name: String,
        work: impl FnOnce(&crate::job::JobCtx<PopulatePreview>) -> Result<Made, crate::job::Stop> + Send + 'static,
        source: samples::Source,
    ) {
        let job = Job::spawn(name, Seed::root(self.populate.seed), self.waker(), work);
        let version = self.document.room_version();
        self.jobs.populate =
            Some(Populating { job, version, replacing: Vec::new(), source: Some(source), stopping: false });
    }

    /// One task for each person who is to become somebody else at about the same place.
    fn tasks_again(&self, geometry: &Arc<RoomGeometry>, ids: &[PersonId]) -> Vec<PopulateTask> {
        let scene = self.document.scene();
        let people = ids.iter().filter_map(|id| scene.person(*id));
        people
            .map(|person| {
                let mut task = self.task(geometry, 1, Some(person.body.translation), ids);
                task.families = Some(vec![person.family]);
                task.next_id = person.id.0;
                task
            })
            .collect()
    }

    fn task(
        &self,
        geometry: &Arc<RoomGeometry>,
        people: usize,
        at: Option<glam::Vec3>,
        without: &[PersonId],
    ) -> PopulateTask {
        let scene = self.document.scene();
        let families = &self.populate.families;
        let all = families.len() == crate::scene::PoseFamily::ALL.len();
        PopulateTask {
            room: scene.room.clone(),
            geometry: geometry.clone(),
            people,
            at,
            families: (!all).then(|| families.iter().copied().collect()),
            existing: scene.people.iter().filter(|p| !without.contains(&p.id)).cloned().collect(),
            next_id: self.document.next_person(),
        }
    }

    /// Fits these people to where they are now.
    pub fn settle(&mut self, ids: &[PersonId]) {
        let Some(geometry) = self.geometry().cloned() else {
            self.notices.warning("The room is still being analysed: settle them in a moment (T).");
            return;
        };
        if self.jobs.populating() {
            self.notices.warning("People are being fitted already: wait or cancel, then press T.");
            return;
        }
        let scene = self.document.scene();
        let there = |id: &PersonId| scene.person(*id).filter(|person| !person.locked);
        let people: Vec<Person> = ids.iter().filter_map(there).cloned().collect();
        if people.is_empty() {
            return;
        }
        let ids = people.iter().map(|person| person.id).collect();
        let room = scene.room.clone();
        let task = FitTask { room, geometry, people, clear_of: None, knows_family: true };
        self.start_fitting("Settle".to_owned(), task, ids, None);
    }

    /// Starts to write room and people for other programs into a folder.
    pub fn start_exporting(&mut self, folder: PathBuf) {
        let (engine, scene) = (self.engine.clone(), self.document.scene().clone());
        let name = format!("Export to {}", file_name(&folder));
        let target = folder.clone();
        let work = move |cx: &crate::job::JobCtx| engine.export(&target, &scene, cx.ticker());
        self.jobs.export = Some((folder, Job::spawn(name, Seed::root(0), self.waker(), work)));
    }

    fn poll_export(&mut self) {
        let Some((folder, job)) = &mut self.jobs.export else { return };
        let Some(outcome) = job.poll() else { return };
        let (folder, name) = (folder.clone(), job.name().to_owned());
        self.jobs.export = None;
        if let Some(files) = self.taken(&name, outcome) {
            self.notices.info(format!("Exported {files} files to {}", folder.display()));
        }
    }

    /// Lets go of one job.
    pub fn cancel(&mut self, kind: JobKind) {
        match kind {
            JobKind::Open => self.jobs.open = None,
            JobKind::Save => self.jobs.save = None,
            JobKind::Export => self.jobs.export = None,
            JobKind::Geometry => {
                self.jobs.hopeless = self.jobs.geometry.take().map(|(version, _)| version);
                self.jobs.wanted = None;
            }
            JobKind::Populate => {
                self.ghosts.clear();
                if self.stop_and_keep() {
                    return;
                }
                let populating = self.jobs.populate.take();
                if let Some(source) = populating.and_then(|p| p.source) {
                    self.settle_cards(&source.cards, &[]);
                }
                self.jobs.wanted = None;
            }
            JobKind::Measure => self.jobs.measure = None,
            JobKind::Sample => {
                self.jobs.sampling = None;
                self.ghosts.clear();
            }
            JobKind::Portraits => self.jobs.portraits = None,
            JobKind::MakeRoom => self.jobs.making_room = None,
            JobKind::See => self.jobs.seeing = None,
            JobKind::Photo => self.jobs.photo = None,
            JobKind::Move => return self.stop_making(),
            JobKind::MeasureMotion => {
                self.jobs.measuring_clip = None;
                self.motion.unmeasurable = Some(self.document.revision());
            }
            JobKind::ExportMotion => self.jobs.exporting_motion = None,
            JobKind::Act if self.jobs.acting.is_some() => return self.stop_acting(),
            JobKind::Act if self.jobs.day.is_some() => return self.stop_day(),
            JobKind::Act => self.jobs.looking = None,
            JobKind::Things => {
                self.jobs.things.pictures = None;
                if self.jobs.things.reading.take().is_some() {
                    self.things.form = None;
                    self.overlay = Overlay::None;
                }
            }
        }
        self.notices.info("Cancelled. Nothing was changed.");
    }

    /// Tells a job that makes new people to stop with those that are there; a second time it is let go of.
    fn stop_and_keep(&mut self) -> bool {
        let Some(populating) = &mut self.jobs.populate else { return false };
        let keeps = populating.replacing.is_empty() && populating.source.is_none() && !populating.stopping;
        if keeps {
            populating.stopping = true;
            populating.job.cancel();
            self.jobs.wanted = None;
        }
        keeps
    }

    /// Lets go of every job.
    pub fn cancel_all(&mut self) {
        for row in self.jobs.rows() {
            self.cancel(row.kind);
        }
        self.jobs.wanted = None;
    }

    /// Looks once at every job and does what follows. Never waits.
    pub fn poll(&mut self) {
        self.poll_open();
        self.poll_save();
        self.poll_export();
        self.poll_geometry();
        self.poll_populate();
        self.poll_measure();
        self.poll_sampling();
        self.poll_portraits();
        self.poll_made_room();
        self.poll_seeing();
        self.poll_photo();
        self.poll_making();
        self.poll_clip_measure();
        self.poll_motion_export();
        self.poll_living();
        self.poll_day();
        self.poll_things();
        self.poll_study();
        if self.study.is_some() {
            // Nothing is measured while somebody rates: the processor belongs to what is shown.
            return;
        }
        self.keep_geometry_fresh();
        self.start_wanted();
        self.keep_measured_fresh();
        self.keep_clips_measured();
    }

    fn poll_open(&mut self) {
        let Some(job) = &mut self.jobs.open else { return };
        let Some(outcome) = job.poll() else { return };
        let name = job.name().to_owned();
        self.jobs.open = None;
        if let Some(opened) = self.taken(&name, outcome) {
            self.show_opened(opened);
        }
    }

    pub(super) fn show_opened(&mut self, opened: Opened) {
        let summary = opened.summary;
        let recovered =
            matches!(&summary.source, Source::File(path, _) if Some(path) == self.autosave.as_ref());
        if let Source::File(path, _) = &summary.source
            && !recovered
        {
            self.remember_recent(path.clone());
        }
        match opened.project {
            Some(project) => {
                let mut document = Document::new(opened.scene);
                document.reserve_ids(project.next);
                self.exchange_document(document);
                self.project = (!recovered).then_some(project.path);
            }
            None if self.has_room() => {
                self.apply(Command::OpenRoom { room: opened.scene.room });
                self.project = None;
            }
            None => self.exchange_document(Document::of_room(opened.scene.room)),
        }
        self.jobs.populate = None;
        self.jobs.measure = None;
        self.jobs.wanted = None;
        self.ghosts.clear();
        self.clear_sheet();
        self.jobs.making = None;
        self.jobs.looking = None;
        self.jobs.acting = None;
        self.jobs.day = None;
        self.jobs.measuring_clip = None;
        self.motion.forget();
        self.living.forget();
        self.prune_motion();
        self.look = None;
        self.selection.clear();
        self.view.isolated = None;
        self.finding = None;
        actions::home_view(self);
        self.orbit.arrive();
        let size = summary.extent_m;
        self.notices.info(format!(
            "{}: {} objects, {:.1} x {:.1} m, {:.1} m high",
            summary.name, summary.objects, size.x, size.z, size.y
        ));
        if !summary.notes.is_empty() {
            let notes = summary.notes.len();
            self.notices
                .warning(format!("{notes} remarks about the file: see the import report (File menu)."));
        }
        self.import = Some(summary);
    }

    /// Another document altogether: nothing that was computed for the old one may be taken for it.
    pub(super) fn exchange_document(&mut self, document: Document) {
        self.document = document;
        self.project = None;
        self.measured.clear();
        self.origins.clear();
        self.geometry = None;
        self.jobs.geometry = None;
        self.jobs.hopeless = None;
        self.jobs.unmeasurable = None;
    }

    fn poll_save(&mut self) {
        let Some((path, revision, job)) = &mut self.jobs.save else { return };
        let Some(outcome) = job.poll() else { return };
        let (path, revision, name) = (path.clone(), *revision, job.name().to_owned());
        self.jobs.save = None;
        if self.taken(&name, outcome).is_some() {
            self.notices.info(format!("Saved {}", path.display()));
            self.remember_recent(path.clone());
            self.project = Some(path);
            if self.document.revision() == revision {
                self.document.mark_saved();
            }
        }
    }

    fn poll_geometry(&mut self) {
        let Some((version, job)) = &mut self.jobs.geometry else { return };
        let Some(outcome) = job.poll() else { return };
        let (version, name) = (*version, job.name().to_owned());
        self.jobs.geometry = None;
        match self.taken(&name, outcome) {
            Some(geometry) => self.geometry = Some((version, Arc::new(geometry))),
            None => {
                self.jobs.hopeless = Some(version);
                self.jobs.wanted = None;
            }
        }
    }

    fn poll_populate(&mut self) {
        let Some(populating) = &mut self.jobs.populate else { return };
        if let Some(preview) = populating.job.take_preview().filter(|_| !populating.stopping) {
            self.ghosts = preview.people;
        }
        let Some(outcome) = populating.job.poll() else { return };
        let (version, name) = (populating.version, populating.job.name().to_owned());
        let replacing = std::mem::take(&mut populating.replacing);
        let source = populating.source.take();
        self.jobs.populate = None;
        self.ghosts.clear();
        let made = self.taken(&name, outcome);
        if let Some(source) = &source {
            let people = made.as_ref().map_or(&[][..], |made| made.people.as_slice());
            self.settle_cards(&source.cards, people);
        }
        if let Some(made) = made {
            self.take_in(made, version, replacing, source);
        }
    }

    /// Turns people that were made into a command.
    fn take_in(
        &mut self,
        made: Made,
        version: RoomVersion,
        replacing: Vec<PersonId>,
        source: Option<samples::Source>,
    ) {
        let made_for = Some(version);
        let mut people = made.people;
        let ids: Vec<PersonId> = if replacing.is_empty() {
            let first = self.document.next_person();
            self.apply(Command::AddPeople { people, made_for });
            let scene = self.document.scene();
            scene.people.iter().map(|p| p.id).filter(|id| id.0 >= first).collect()
        } else {
            keep_who_they_are(&mut people, &replacing, &self.document);
            self.apply(Command::ReplacePeople { people, made_for });
            replacing
        };
        for (i, (id, report)) in ids.iter().zip(made.reports).enumerate() {
            if let Some(person) = self.document.scene().person(*id).cloned() {
                let energies = made.energies.get(i).cloned().unwrap_or_default();
                self.keep_measured(&person, version, report, energies);
            }
        }
        let (method, seen) = source.map_or((SampleMethod::Search, None), |s| (s.method, s.seen));
        for (id, before) in ids.iter().zip(made.before) {
            let origin = Origin { method, seen: seen.clone(), before };
            self.origins.insert(*id, Arc::new(origin));
        }
        if let Some(first) = ids.first() {
            self.selection.only(Item::Person(*first));
        }
        self.last_made = ids;
        self.finding = None;
        if let Some(shortfall) = made.shortfall {
            self.notices.warning(shortfall);
        }
    }

    fn poll_measure(&mut self) {
        let Some(measuring) = &mut self.jobs.measure else { return };
        let Some(outcome) = measuring.job.poll() else { return };
        let (version, name) = (measuring.version, measuring.job.name().to_owned());
        self.jobs.measure = None;
        let Some(reports) = self.taken(&name, outcome) else {
            self.jobs.unmeasurable = Some(self.document.revision());
            return;
        };
        for (person, report) in reports {
            let energies = self.measured.get(&person.id).map(|m| m.energies.as_ref().clone());
            self.keep_measured(&person, version, report, energies.unwrap_or_default());
        }
    }

    /// Builds geometry when the room is not the one it was built for.
    fn keep_geometry_fresh(&mut self) {
        let version = self.document.room_version();
        let running = self.jobs.geometry.as_ref().is_some_and(|(of, _)| *of == version);
        let idle = !self.has_room() || self.document.in_gesture() || self.jobs.hopeless == Some(version);
        if running || idle || self.geometry().is_some() {
            return;
        }
        let (engine, room) = (self.engine.clone(), self.document.scene().room.clone());
        let work = move |cx: &crate::job::JobCtx| engine.geometry(&room, cx.ticker());
        let job = Job::spawn("Analyse room", Seed::root(0), self.waker(), work);
        self.jobs.geometry = Some((version, job));
    }

    /// Measures whoever has changed, unless somebody is being dragged or made.
    fn keep_measured_fresh(&mut self) {
        let busy = self.jobs.measure.is_some() || self.jobs.populate.is_some();
        let failed = self.jobs.unmeasurable == Some(self.document.revision());
        // People who are moved by hand are painted by what they touch.
        let dragged = self.document.in_gesture() && self.transform.is_none();
        if busy || failed || dragged {
            return;
        }
        let Some(geometry) = self.geometry().cloned() else { return };
        let people = self.unmeasured();
        if people.is_empty() {
            return;
        }
        let engine = self.engine.clone();
        let work = move |cx: &crate::job::JobCtx| {
            cx.stage("measuring", people.len())?;
            let mut reports = Vec::new();
            for person in people {
                let report = engine.measure(&geometry, &person.body, cx.ticker())?;
                reports.push((person, report));
                cx.advance()?;
            }
            Ok(reports)
        };
        let job = Job::spawn("Measure", Seed::root(0), self.waker(), work);
        self.jobs.measure = Some(Measuring { job, version: self.document.room_version() });
    }

    /// The result of a job that ended well; otherwise says what happened.
    pub(super) fn taken<T>(&mut self, name: &str, outcome: Outcome<T>) -> Option<T> {
        match outcome {
            Outcome::Done(value) => return Some(value),
            Outcome::Cancelled => self.notices.info(format!("{name}: cancelled")),
            Outcome::Failed(message) => self.notices.error(format!("{name}: not done"), message),
            Outcome::Panicked(message) => self.notices.error(
                format!("{name}: stopped by a fault of the program"),
                format!("{message}\nYour room and people are unharmed. Please report this with the details."),
            ),
        }
        None
    }

    fn remember_recent(&mut self, path: PathBuf) {
        self.recent.retain(|known| *known != path);
        self.recent.insert(0, path);
        self.recent.truncate(12);
    }
}

/// A re-rolled person keeps name, id, colours and whether it is shown; the body is new.
fn keep_who_they_are(people: &mut [Person], replacing: &[PersonId], document: &Document) {
    for (new, id) in people.iter_mut().zip(replacing) {
        if let Some(old) = document.scene().person(*id) {
            new.name.clone_from(&old.name);
            new.palette = old.palette;
            new.visible = old.visible;
        }
        new.id = *id;
    }
}

/// Whether the file is a project rather than a room.
pub fn is_project_file(path: &std::path::Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    extension.eq_ignore_ascii_case("ron") || extension.eq_ignore_ascii_case("inhabit")
}

fn file_name(path: &std::path::Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
