//! Drives the window from the command line: opens, populates, waits for the work, takes the window's picture
//! and closes. The pictures of the documentation are made this way, so anybody can make them again.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use egui::{ColorImage, Context, ViewportCommand};
use glam::Vec3;

use super::actions;
use super::engine::SampleMethod;
use super::motion::{Placing, Trail};
use super::samples::ViewFrom;
use super::selection::Item;
use super::state::{EditorState, Heat, Overlay};
use crate::scene::GoalPose;

/// Frames drawn after the last change, so that glides, layout and the last full-quality picture are done.
const SETTLE_FRAMES: u32 = 12;

/// Nothing that one sits or lies on is higher, metres.
const HEAD_M: f32 = 1.3;

/// What to do before the picture is taken.
#[derive(Clone, Debug, Default)]
pub struct ScreenshotPlan {
    /// Where the PNG goes; none is taken when `None`.
    pub file: Option<PathBuf>,
    /// Turn the view while people are made and take the times of all frames.
    pub frame_times: bool,
    /// Sample this many candidates from the view.
    pub sample: usize,
    /// By which method: `search`, `s1`, `s2` or `baseline`.
    pub method: Option<String>,
    /// Look from the agent in the room instead of from the editor's camera.
    pub agent: bool,
    /// Accept the first so many candidates.
    pub accept: usize,
    /// How many people to make; 0 for none.
    pub people: usize,
    /// Seed of the people.
    pub seed: u64,
    /// Paint bodies by distance.
    pub heat: bool,
    /// Select this person, counted from 0.
    pub select: Option<usize>,
    /// Zoom on the selected person.
    pub frame_selected: bool,
    /// The light theme.
    pub light: bool,
    /// Place these sub-goals and make the motion: `X,Z` or `X,Z,POSE`, metres.
    pub goals: Vec<String>,
    /// Show the motion at this time, seconds.
    pub at_s: f32,
    /// Let this many actions happen.
    pub actions: usize,
    /// Show this: `palette`, `shortcuts`, `help`, `import`, `history`, `samples`, `why`, `new-room`, `networks`, `motion`,
    /// `actions`, `things`, `futures`, `learned`, `graph`, `study`.
    pub overlay: Option<String>,
}

/// A plan being carried out.
pub struct Script {
    plan: ScreenshotPlan,
    stage: Stage,
    result: Arc<Mutex<Option<Result<(), String>>>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Opening,
    Analysing,
    Populating,
    Sampling,
    Accepting,
    Moving,
    Looking,
    Acting,
    Settling(u32),
    Taking,
    Done,
}

impl Script {
    /// Begins `plan`. The outcome is put into `result` before the window closes.
    pub fn new(plan: ScreenshotPlan, result: Arc<Mutex<Option<Result<(), String>>>>) -> Self {
        Self { plan, stage: Stage::Opening, result }
    }

    /// Goes on as far as the work allows; called once a frame.
    pub fn advance(&mut self, ctx: &Context, state: &mut EditorState) {
        if self.stage == Stage::Done {
            return;
        }
        ctx.request_repaint();
        if self.plan.frame_times && state.jobs.populating() {
            state.orbit.turn(2.0, 0.0);
        }
        let idle = !state.jobs.any_running();
        self.stage = match self.stage {
            Stage::Opening if state.jobs.opening() => Stage::Opening,
            // Timed runs begin with a room that is analysed, as a user would.
            Stage::Opening if self.plan.frame_times => Stage::Analysing,
            Stage::Opening => self.begin(state),
            Stage::Analysing if state.has_room() && state.geometry().is_some() && idle => self.begin(state),
            Stage::Populating if idle => self.sample(state),
            Stage::Sampling if idle => self.accept(state),
            Stage::Accepting if idle => self.make_motion(state),
            Stage::Moving if idle => self.look_for_actions(state),
            Stage::Looking if idle => self.act(state),
            Stage::Acting if idle => self.look(state),
            Stage::Settling(0) => self.take(ctx),
            Stage::Settling(left) if idle => Stage::Settling(left - 1),
            stage => stage,
        };
    }

    fn begin(&mut self, state: &mut EditorState) -> Stage {
        state.view.dark = !self.plan.light;
        if self.plan.people > 0 && state.has_room() {
            state.populate.people = self.plan.people;
            state.populate.seed = self.plan.seed;
            actions::populate(state);
        }
        Stage::Populating
    }

    fn sample(&mut self, state: &mut EditorState) -> Stage {
        if self.plan.sample > 0 {
            let wanted = self.plan.method.as_deref();
            let method = SampleMethod::ALL.into_iter().find(|method| Some(method.key()) == wanted);
            let options = &mut state.sheet.options;
            options.count = self.plan.sample;
            options.seed = self.plan.seed;
            options.method = method.unwrap_or_default();
            options.from = if self.plan.agent { ViewFrom::Agent } else { ViewFrom::Here };
            actions::sample_view(state);
        }
        Stage::Sampling
    }

    fn accept(&mut self, state: &mut EditorState) -> Stage {
        let keys: Vec<u64> = state.sheet.open_cards().take(self.plan.accept).collect();
        state.accept_cards(&keys);
        Stage::Accepting
    }

    fn make_motion(&mut self, state: &mut EditorState) -> Stage {
        state.motion.options.seed = self.plan.seed;
        for text in &self.plan.goals {
            if let Some((at, pose)) = goal_of(text, state) {
                state.motion.options.pose = pose;
                state.place_goal(Placing { at, towards: at });
            }
        }
        if !self.plan.goals.is_empty() {
            state.start_synthesis();
        }
        Stage::Moving
    }

    fn look_for_actions(&mut self, state: &mut EditorState) -> Stage {
        if self.plan.actions > 0 {
            (state.living.seed, state.living.count) = (self.plan.seed, self.plan.actions);
            state.look_for_actions();
        }
        Stage::Looking
    }

    fn act(&mut self, state: &mut EditorState) -> Stage {
        if self.plan.actions > 0 {
            state.start_chain();
        }
        Stage::Acting
    }

    fn look(&mut self, state: &mut EditorState) -> Stage {
        state.view.heat = if self.plan.heat { Heat::Distance } else { Heat::Off };
        state.selection.clear();
        let person = self.plan.select.and_then(|n| state.document.scene().people.get(n)).map(|p| p.id);
        if let Some(id) = person {
            state.selection.only(Item::Person(id));
            if self.plan.frame_selected {
                actions::frame_selection(state);
                state.orbit.arrive();
            }
        }
        state.overlay = match self.plan.overlay.as_deref() {
            Some("palette") => Overlay::Palette { query: String::new(), row: 0 },
            Some("shortcuts") => Overlay::Shortcuts,
            Some("help") => Overlay::Help,
            Some("import") => Overlay::Import,
            Some("history") => Overlay::History,
            Some("new-room") => Overlay::NewRoom,
            Some("networks") => Overlay::Networks(0),
            Some("learned") => Overlay::Learned(Some(0)),
            Some("graph") => Overlay::Learned(None),
            Some("study") => Overlay::Study,
            _ => Overlay::None,
        };
        match self.plan.overlay.as_deref() {
            Some("samples") => state.requests.show_sheet = true,
            Some("motion") => show_motion(state),
            Some("actions") => {
                state.requests.show_actions = true;
                state.living.marks = true;
            }
            Some("things") => {
                state.requests.show_actions = true;
                state.things.unfolded = true;
            }
            Some("futures") => {
                state.requests.show_actions = true;
                state.toggle_beside(0);
            }
            Some("why") => {
                actions::show_why(state);
                state.view.before = true;
            }
            _ => {}
        }
        if self.plan.overlay.as_deref() != Some("samples") {
            state.sheet.chosen = None;
        }
        let length_s = state.play_seconds();
        state.motion.player.seek(self.plan.at_s, length_s);
        state.notices.hide_news();
        Stage::Settling(SETTLE_FRAMES)
    }

    fn take(&self, ctx: &Context) -> Stage {
        let (result, again) = (self.result.clone(), ctx.clone());
        let Some(file) = self.plan.file.clone() else {
            *result.lock().unwrap_or_else(PoisonError::into_inner) = Some(Ok(()));
            again.send_viewport_cmd(ViewportCommand::Close);
            return Stage::Taking;
        };
        ctx.request_screenshot(move |picture| {
            *result.lock().unwrap_or_else(PoisonError::into_inner) = Some(write_png(&file, &picture));
            again.send_viewport_cmd(ViewportCommand::Close);
            again.request_repaint();
        });
        Stage::Taking
    }
}

/// The panel and the timeline of motions, with the way that somebody goes.
fn show_motion(state: &mut EditorState) {
    state.requests.show_motion = true;
    state.requests.show_timeline = true;
    state.motion.trail = Trail::Figures;
}

/// The topmost surface below head height at `X,Z`, and what is to be done there.
fn goal_of(text: &str, state: &EditorState) -> Option<(Vec3, GoalPose)> {
    let mut parts = text.split(',');
    let mut number = || parts.next()?.trim().parse::<f32>().ok();
    let (x, z) = (number()?, number()?);
    let pose = match parts.next().map(str::trim) {
        Some("stand") => GoalPose::Stand,
        Some("sit") => GoalPose::Sit,
        Some("lie") => GoalPose::Lie,
        Some("walk") => GoalPose::Walk,
        _ => GoalPose::Any,
    };
    let above = Vec3::new(x, HEAD_M, z);
    let hit = state.geometry()?.bvh.cast(above, Vec3::NEG_Y, 2.0 * HEAD_M)?;
    Some((above - Vec3::Y * hit.distance_m, pose))
}

fn write_png(file: &std::path::Path, picture: &ColorImage) -> Result<(), String> {
    let [width, height] = picture.size;
    let (width, height) = (width as u32, height as u32);
    image::save_buffer(file, picture.as_raw(), width, height, image::ColorType::Rgba8).map_err(|error| {
        format!("{}: {error}. Check that the folder exists and may be written to.", file.display())
    })
}
