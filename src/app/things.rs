//! The library of things that actions bring: pictures of its kinds, how many of each a room takes, which never come,
//! and models of the user's own, which are turned upright, given a size and kept for later sessions.

use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};

use super::engine::{ThingKind, ThingPicture};
use super::pictures::Shown;
use super::state::{EditorState, Overlay};
use crate::assets::Model;
use crate::document::OwnThing;
use crate::document::keep_thing;
use crate::document::read_things;
use crate::job::{Job, JobCtx, Seed};

/// Pictures that one job draws: few enough that the first ones come at once.
const AT_ONCE: usize = 6;
/// More triangles than this make every action slow.
pub const MANY_TRIANGLES: usize = 20_000;
/// What a model of one metre may be called in its file: metres, centimetres, millimetres, inches.
const UNITS_M: [f32; 4] = [1.0, 0.01, 0.001, 0.0254];
/// A thing is about as large as others of its kind: within this factor its file's unit is believed.
const BELIEVED: f32 = 3.0;

/// What a kind looks like.
#[derive(Debug)]
pub struct Look {
    /// Its first model.
    pub picture: Shown,
    /// Width, height and depth of it, metres.
    pub size_m: Vec3,
}

/// The library in the window.
#[derive(Default)]
pub struct Things {
    /// Letters that a kind's name must have to be listed.
    pub query: String,
    /// The list is unfolded when it is first shown.
    pub unfolded: bool,
    /// Where the user's own things are kept; they last for this session only when `None`.
    pub folder: Option<PathBuf>,
    /// The thing that is being added.
    pub form: Option<ThingForm>,
    kinds: Option<Arc<[ThingKind]>>,
    /// `None` where a picture could not be drawn.
    looks: BTreeMap<String, Option<Look>>,
}

/// Which way a model is turned, as quarter turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attitude {
    /// About the vertical.
    pub turns: u8,
    /// Forward, about the line from left to right; before the turns.
    pub tips: u8,
}

impl Attitude {
    /// From the file's frame to one in which the thing stands upright and its front looks along +Z.
    pub fn rotation(self) -> Quat {
        let quarter = |times: u8| FRAC_PI_2 * f32::from(times % 4);
        Quat::from_rotation_y(quarter(self.turns)) * Quat::from_rotation_x(quarter(self.tips))
    }
}

/// A model of the user's that is being added.
#[derive(Debug)]
pub struct ThingForm {
    /// The file.
    pub path: PathBuf,
    /// Name for people.
    pub name: String,
    /// The kind that it is one of.
    pub kind: String,
    /// Its longest side, metres.
    pub longest_m: f32,
    /// The user has chosen the size.
    pub sized: bool,
    /// How it is turned.
    pub attitude: Attitude,
    /// The file's content, once it is read.
    pub model: Option<Arc<Model>>,
    /// Size of the file's content in its own unit and frame.
    extent_in_file: Vec3,
    /// What it looks like, and in which attitude.
    pub look: Option<(Attitude, Shown)>,
    /// The attitude that could not be drawn; not tried again.
    failed: Option<Attitude>,
}

impl ThingForm {
    fn new(path: PathBuf, kinds: &[ThingKind]) -> Self {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().replace(['_', '-'], " ");
        let kind = kind_in_name(&stem, kinds);
        Self {
            path,
            name: stem.trim().to_owned(),
            kind: kind.unwrap_or_default(),
            longest_m: 0.3,
            sized: false,
            attitude: Attitude::default(),
            model: None,
            extent_in_file: Vec3::ONE,
            look: None,
            failed: None,
        }
    }

    /// Width, height and depth as it would stand in a room, metres.
    pub fn size_m(&self) -> Option<Vec3> {
        self.model.as_ref()?;
        let turned = (self.attitude.rotation() * self.extent_in_file).abs();
        Some(turned * (self.longest_m / turned.max_element().max(f32::MIN_POSITIVE)))
    }

    /// Why it can't be added yet.
    pub fn missing(&self) -> Option<&'static str> {
        if self.model.is_none() {
            Some("The file is being read.")
        } else if self.kind.is_empty() {
            Some("Choose what kind of thing it is.")
        } else if self.name.trim().is_empty() {
            Some("Give it a name.")
        } else {
            None
        }
    }
}

/// The kind whose name stands in a file's name, the longest one.
fn kind_in_name(name: &str, kinds: &[ThingKind]) -> Option<String> {
    let name = format!(" {} ", name.to_lowercase());
    let named = kinds.iter().map(|kind| &kind.kind).filter(|kind| name.contains(&format!(" {kind} ")));
    named.max_by_key(|kind| kind.len()).cloned()
}

/// The model turned and scaled: metres, upright, front along +Z.
pub fn upright(model: &Model, attitude: Attitude, longest_m: f32) -> Model {
    let longest = model.bounds().size().max_element().max(f32::MIN_POSITIVE);
    let scale = Vec3::splat(longest_m / longest);
    let thing_from_file = Affine3A::from_scale_rotation_translation(scale, attitude.rotation(), Vec3::ZERO);
    let mut model = model.clone();
    for part in &mut model.parts {
        part.file_from_mesh = thing_from_file * part.file_from_mesh;
    }
    model
}

/// How long a thing probably is whose file says `in_file`, others of its kind being `usual_m` long: the file's number
/// in the unit that makes it most like them, or else as long as they are.
fn likely_length_m(in_file: f32, usual_m: Option<f32>) -> f32 {
    let usual = usual_m.filter(|usual| *usual > 0.0);
    let unlike = |length_m: f32| (length_m / usual.unwrap_or(0.5)).max(1e-9).ln().abs();
    let best =
        UNITS_M.map(|unit_m| in_file * unit_m).into_iter().min_by(|a, b| unlike(*a).total_cmp(&unlike(*b)));
    match (best, usual) {
        (Some(best), Some(usual)) if unlike(best) > BELIEVED.ln() => usual,
        (best, _) => best.unwrap_or(0.3),
    }
}

/// Jobs of the library.
#[derive(Default)]
pub(super) struct ThingJobs {
    pub pictures: Option<Job<Vec<(String, Option<ThingPicture>)>>>,
    pub reading: Option<Job<Model>>,
    pub drawing: Option<Job<(Attitude, ThingPicture)>>,
    pub keeping: Option<Job<PathBuf>>,
    pub remembering: Option<Job<(Vec<OwnThing>, Vec<String>)>>,
}

impl EditorState {
    /// The kinds that actions bring.
    pub fn thing_kinds(&mut self) -> Arc<[ThingKind]> {
        let engine = &self.engine;
        self.things.kinds.get_or_insert_with(|| engine.thing_kinds().into()).clone()
    }

    /// What a kind looks like, once that is drawn.
    pub fn thing_look(&self, kind: &str) -> Option<&Look> {
        self.things.looks.get(kind)?.as_ref()
    }

    /// How many of a kind a room takes: the user's number, or else the library's.
    pub fn most_of(&self, kind: &ThingKind) -> usize {
        self.living.choice.most.get(&kind.kind).copied().unwrap_or(kind.most)
    }

    /// Says how many of a kind a room takes.
    pub fn set_most(&mut self, kind: &ThingKind, most: usize) {
        let chosen = &mut self.living.choice.most;
        if most == kind.most {
            chosen.remove(&kind.kind);
        } else {
            chosen.insert(kind.kind.clone(), most);
        }
    }

    /// Actions never bring or use this kind, or may again.
    pub fn toggle_ban(&mut self, kind: &str) {
        let banned = &mut self.living.choice.banned;
        let before = banned.len();
        banned.retain(|known| known != kind);
        if banned.len() == before {
            banned.push(kind.to_owned());
        }
    }

    /// Takes the things of earlier sessions from `folder`, and keeps new ones there.
    pub fn remember_things(&mut self, folder: Option<PathBuf>) {
        let Some(folder) = folder else { return };
        self.things.folder = Some(folder.clone());
        let work = move |_: &JobCtx| Ok(read_things(&folder));
        self.jobs.things.remembering = Some(Job::spawn("Own things", Seed::root(0), self.waker(), work));
    }

    /// Draws the pictures of `kinds` that are not there yet, a few at a time; called while they are looked at.
    pub fn keep_things_drawn(&mut self, kinds: &[String]) {
        if self.jobs.things.pictures.is_some() {
            return;
        }
        let known = |kind: &&String| !self.things.looks.contains_key(*kind);
        let next: Vec<String> = kinds.iter().filter(known).take(AT_ONCE).cloned().collect();
        if next.is_empty() {
            return;
        }
        let engine = self.engine.clone();
        let work = move |cx: &JobCtx| {
            cx.stage("drawing things", next.len())?;
            let mut drawn = Vec::new();
            for kind in next {
                cx.check()?;
                let picture = engine.thing_picture(&kind, cx.ticker()).ok();
                drawn.push((kind, picture));
                cx.advance()?;
            }
            Ok(drawn)
        };
        self.jobs.things.pictures = Some(Job::spawn("Draw things", Seed::root(0), self.waker(), work));
    }

    /// Starts to add a model of the user's.
    pub fn begin_thing(&mut self, path: &Path) {
        let kinds = self.thing_kinds();
        self.things.form = Some(ThingForm::new(path.to_path_buf(), &kinds));
        self.overlay = Overlay::AddThing;
        let (engine, file) = (self.engine.clone(), path.to_path_buf());
        let work = move |cx: &JobCtx| engine.read_thing(&file, cx.ticker());
        let name = format!("Read {}", path.file_name().unwrap_or_default().to_string_lossy());
        self.jobs.things.reading = Some(Job::spawn(name, Seed::root(0), self.waker(), work));
    }

    /// Keeps size and picture of the thing that is being added up to date.
    pub fn keep_form_fresh(&mut self) {
        let Some(form) = &self.things.form else { return };
        let kind = form.kind.clone();
        if !kind.is_empty() {
            self.keep_things_drawn(std::slice::from_ref(&kind));
        }
        let usual_m = self.thing_look(&kind).map(|look| look.size_m.max_element());
        let Some(form) = &mut self.things.form else { return };
        let Some(model) = form.model.clone() else { return };
        if !form.sized {
            form.longest_m = likely_length_m(form.extent_in_file.max_element(), usual_m);
        }
        let (wanted, busy) = (form.attitude, self.jobs.things.drawing.is_some());
        let done = form.look.as_ref().is_some_and(|(of, _)| *of == wanted) || form.failed == Some(wanted);
        if done || busy {
            return;
        }
        let engine = self.engine.clone();
        let work = move |cx: &JobCtx| {
            let turned = upright(&model, wanted, 1.0);
            Ok((wanted, engine.model_picture(&turned, cx.ticker())?))
        };
        self.jobs.things.drawing = Some(Job::spawn("Draw thing", Seed::root(0), self.waker(), work));
    }

    /// Adds the thing of the form: actions may bring it from now on, and in later sessions.
    pub fn add_thing(&mut self) {
        let Some(form) = self.things.form.take_if(|form| form.missing().is_none()) else { return };
        let Some(model) = &form.model else { return };
        let model = upright(model, form.attitude, form.longest_m);
        let thing = Arc::new(OwnThing { kind: form.kind, name: form.name.trim().to_owned(), model });
        self.overlay = Overlay::None;
        self.requests.show_actions = true;
        let own = &mut self.living.choice.own;
        own.retain(|known| (&known.kind, &known.name) != (&thing.kind, &thing.name));
        own.push(thing.clone());
        let text = format!("{} is a {} from now on: actions may bring it.", thing.name, thing.kind);
        self.notices.info(text);
        let Some(folder) = self.things.folder.clone() else { return };
        let work = move |_: &JobCtx| Ok(keep_thing(&folder, &thing)?);
        self.jobs.things.keeping = Some(Job::spawn("Keep thing", Seed::root(0), self.waker(), work));
    }

    pub(super) fn poll_things(&mut self) {
        self.poll_thing_pictures();
        self.poll_thing_form();
        if let Some(outcome) = self.jobs.things.keeping.as_mut().and_then(Job::poll) {
            self.jobs.things.keeping = None;
            self.taken("Keep thing", outcome);
        }
        if let Some(outcome) = self.jobs.things.remembering.as_mut().and_then(Job::poll) {
            self.jobs.things.remembering = None;
            let Some((things, faults)) = self.taken("Own things", outcome) else { return };
            self.living.choice.own.extend(things.into_iter().map(Arc::new));
            for fault in faults {
                self.notices.error("One of your things can't be read", fault);
            }
        }
    }

    fn poll_thing_pictures(&mut self) {
        let Some(outcome) = self.jobs.things.pictures.as_mut().and_then(Job::poll) else { return };
        self.jobs.things.pictures = None;
        let Some(drawn) = self.taken("Draw things", outcome) else { return };
        let look = |drawn: ThingPicture| Look { picture: drawn.picture.into(), size_m: drawn.size_m };
        self.things.looks.extend(drawn.into_iter().map(|(kind, drawn)| (kind, drawn.map(look))));
    }

    fn poll_thing_form(&mut self) {
        if let Some(outcome) = self.jobs.things.reading.as_mut().and_then(Job::poll) {
            let name = self.jobs.things.reading.take().map(|job| job.name().to_owned()).unwrap_or_default();
            match (self.taken(&name, outcome), &mut self.things.form) {
                (Some(model), Some(form)) => {
                    form.extent_in_file = model.bounds().size();
                    form.model = Some(Arc::new(model));
                }
                (None, _) => {
                    self.things.form = None;
                    self.overlay = Overlay::None;
                }
                _ => {}
            }
        }
        let Some(outcome) = self.jobs.things.drawing.as_mut().and_then(Job::poll) else { return };
        self.jobs.things.drawing = None;
        let drawn = self.taken("Draw thing", outcome);
        let Some(form) = &mut self.things.form else { return };
        match drawn {
            Some((attitude, drawn)) => form.look = Some((attitude, drawn.picture.into())),
            None => form.failed = Some(form.attitude),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds() -> Vec<ThingKind> {
        ["cup", "plant", "potted plant"]
            .map(|kind| ThingKind { kind: kind.to_owned(), most: 4, models: 1 })
            .to_vec()
    }

    #[test]
    fn a_file_s_name_says_its_kind_if_it_can() {
        let of = |name: &str| ThingForm::new(PathBuf::from(name), &kinds());
        assert_eq!(of("a/my_potted_plant_2.glb").kind, "potted plant");
        assert_eq!(
            (of("cupboard.obj").kind, of("cupboard.obj").name),
            (String::new(), "cupboard".to_owned())
        );
        assert_eq!(of("cupboard.obj").missing(), Some("The file is being read."));
    }

    #[test]
    fn the_unit_that_makes_a_thing_like_its_kind_is_taken() {
        for (in_file, usual_m, length_m) in
            [(9.0, Some(0.1), 0.09), (0.12, Some(0.1), 0.12), (95.0, Some(0.1), 0.095), (40.0, None, 0.4)]
        {
            assert!((likely_length_m(in_file, usual_m) - length_m).abs() < 1e-4, "{in_file}");
        }
        assert_eq!(likely_length_m(0.000_01, Some(0.1)), 0.1, "no unit fits");
    }

    #[test]
    fn what_lay_on_its_back_stands_and_its_side_looks_to_the_front() {
        let up = Attitude { turns: 0, tips: 3 }.rotation() * Vec3::Z;
        assert!((up - Vec3::Y).length() < 1e-5, "z-up files are tipped three times: {up}");
        let front = Attitude { turns: 3, tips: 0 }.rotation() * Vec3::X;
        assert!((front - Vec3::Z).length() < 1e-5, "{front}");
    }
}
