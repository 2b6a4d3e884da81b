//! The window itself: panels in a dock around the viewport, keys, dropped files, dialogs.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use egui::{Context, Key, Modifiers, Ui, ViewportCommand};
use egui_tiles::{
    Container, Linear, LinearDir, SimplificationOptions, Tile, TileId, Tiles, Tree, UiResponse,
};

use super::actions;
use super::autosave::Autosave;
use super::canvas::Canvas;
use super::commands;
use super::engine::Engine;
use super::frames::{FrameClock, FrameTimes};
use super::panels;
use super::panels::RenderStatus;
use super::state::{EditorState, Overlay};
use super::theme;
use super::viewport;
use super::viewport::Canvases;
use crate::document::Settings;
use crate::document::is_leftover;
use crate::job::{Job, Outcome, Seed};

/// Jobs report hundreds of steps a second; a frame for each would take the processor from them.
const NEWS_EVERY: Duration = Duration::from_millis(80);

/// A panel of the dock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pane {
    Viewport,
    Objects,
    People,
    Populate,
    Sample,
    Photo,
    Motion,
    Actions,
    Inspector,
    Why,
    Candidates,
    Timeline,
    Findings,
    Energies,
    Jobs,
}

/// The eframe application.
pub struct Window {
    /// The editor.
    pub state: EditorState,
    /// A job has asked for a frame and none was drawn since: thousands of steps a second cost one request.
    woken: Arc<AtomicBool>,
    canvas: Canvas,
    beside: Canvas,
    tree: Tree<Pane>,
    dialog: Option<Dialog>,
    keys: Vec<&'static commands::CommandInfo>,
    over_viewport: bool,
    script: Option<super::screenshot::Script>,
    leaving: bool,
    title: String,
    settings: Option<Remembered>,
    autosave: Option<Autosave>,
    clock: FrameClock,
    times: Option<Arc<Mutex<FrameTimes>>>,
}

/// Where settings are kept, and as they were kept last.
struct Remembered {
    path: PathBuf,
    kept: Settings,
    keeping: Option<Job<()>>,
}

/// A file dialog of the desktop that is open; it runs on a thread of its own.
enum Dialog {
    Open(Job<Option<PathBuf>>),
    Save(Job<Option<PathBuf>>),
    Export(Job<Option<PathBuf>>),
    /// A photo (false) or its keypoints (true).
    Photo(Job<Option<PathBuf>>, bool),
    /// A model of the user's own.
    Thing(Job<Option<PathBuf>>),
    /// A folder of motion clips.
    Clips(Job<Option<PathBuf>>),
}

impl Window {
    /// A window over `engine`, on the graphics device of `cc` if it has one.
    pub fn new(cc: &eframe::CreationContext<'_>, engine: Arc<dyn Engine>) -> Self {
        theme::install(&cc.egui_ctx);
        let ctx = cc.egui_ctx.clone();
        let woken = Arc::new(AtomicBool::new(false));
        let asked = woken.clone();
        let wake = Arc::new(move || {
            if !asked.swap(true, Ordering::AcqRel) {
                ctx.request_repaint_after(NEWS_EVERY);
            }
        });
        Self {
            state: EditorState::new(engine, wake),
            woken,
            canvas: Canvas::new(cc.wgpu_render_state.as_ref()),
            beside: Canvas::new(cc.wgpu_render_state.as_ref()),
            tree: layout(),
            dialog: None,
            keys: Vec::new(),
            over_viewport: false,
            script: None,
            leaving: false,
            title: String::new(),
            settings: None,
            autosave: None,
            clock: FrameClock::default(),
            times: None,
        }
    }

    /// Puts the times of all frames into `times` when the window closes.
    #[must_use]
    pub fn keeping_times(self, times: Arc<Mutex<FrameTimes>>) -> Self {
        Self { times: Some(times), ..self }
    }

    /// Takes recent files and theme from `path`, and keeps them there from now on.
    pub fn remember(&mut self, path: Option<PathBuf>) {
        let Some(path) = path else { return };
        let kept = Settings::load(&path);
        self.state.recent.clone_from(&kept.recent);
        self.state.view.dark = !kept.light;
        self.settings = Some(Remembered { path, kept, keeping: None });
    }

    /// Keeps unsaved people in `path` against crashes; offers what an earlier session left there.
    pub fn keep_safe(&mut self, path: Option<PathBuf>) {
        let Some(path) = path else { return };
        if is_leftover(&path) {
            self.state.overlay = Overlay::Recover(path.clone());
        }
        self.state.autosave = Some(path.clone());
        self.autosave = Some(Autosave::new(path));
    }

    /// Writes the settings beside the window when they have changed.
    fn keep_settings(&mut self) {
        let Some(remembered) = &mut self.settings else { return };
        let now = Settings { recent: self.state.recent.clone(), light: !self.state.view.dark };
        if now == remembered.kept {
            return;
        }
        let (path, settings) = (remembered.path.clone(), now.clone());
        let keep = move |_: &crate::job::JobCtx| Ok(settings.save(&path)?);
        remembered.keeping = Some(Job::spawn("Keep settings", Seed::root(0), || (), keep));
        remembered.kept = now;
    }

    /// The window's title: the room, and a mark while there is something to save.
    fn show_title(&mut self, ctx: &Context) {
        let name = &self.state.document.scene().room.name;
        let mark = if self.state.document.is_dirty() { "*" } else { "" };
        let title = if name.is_empty() || self.state.study.is_some() {
            "Inhabit".to_owned()
        } else {
            format!("{name}{mark} - Inhabit")
        };
        if title != self.title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Lets a script drive the window.
    #[must_use]
    pub fn with_script(self, script: Option<super::screenshot::Script>) -> Self {
        Self { script, ..self }
    }

    fn take_keys(&mut self, ctx: &Context) {
        for command in std::mem::take(&mut self.keys) {
            run_if_possible(&mut self.state, command);
        }
        let typing = ctx.text_edit_focused();
        let flying = ctx.input(|i| i.pointer.secondary_down());
        let events = ctx.input(|i| i.events.clone());
        for event in events {
            let egui::Event::Key { key, pressed: true, modifiers, .. } = event else { continue };
            if !typing && (self.state.key_in_study(key) || self.state.key_in_transform(key, modifiers)) {
                ctx.input_mut(|i| i.consume_key(modifiers, key));
                continue;
            }
            if let Some(command) = command_for(key, modifiers, typing, flying, &self.state.overlay) {
                ctx.input_mut(|i| i.consume_key(modifiers, key));
                run_if_possible(&mut self.state, command);
            }
        }
    }

    fn take_drops(&mut self, ctx: &Context) {
        let dropped = ctx.input(|i| i.raw.dropped_files.clone());
        for file in dropped {
            let path = file.path().to_path_buf();
            if self.state.has_room() && panels::may_be_a_thing(&path) {
                self.state.overlay = Overlay::Dropped(path);
            } else {
                actions::open_file(&mut self.state, path);
            }
        }
    }

    fn do_requests(&mut self, ctx: &Context) {
        let requests = std::mem::take(&mut self.state.requests);
        if requests.close {
            self.leaving = true;
            ctx.send_viewport_cmd(ViewportCommand::Close);
        }
        if requests.full_screen {
            let full = ctx.input(|i| i.viewport().fullscreen.unwrap_or(false));
            ctx.send_viewport_cmd(ViewportCommand::Fullscreen(!full));
        }
        if requests.reset_layout {
            self.tree = layout();
        }
        for (asked, pane) in [
            (requests.show_sheet, Pane::Candidates),
            (requests.show_sample, Pane::Sample),
            (requests.show_why, Pane::Why),
            (requests.show_photo, Pane::Photo),
            (requests.show_motion, Pane::Motion),
            (requests.show_actions, Pane::Actions),
            (requests.show_timeline, Pane::Timeline),
        ] {
            if asked {
                self.tree.make_active(|_, tile| matches!(tile, Tile::Pane(of) if *of == pane));
                ctx.request_repaint();
            }
        }
        if requests.open_dialog {
            self.dialog = Some(Dialog::Open(super::dialog::ask_open(ctx)));
        }
        if requests.save_dialog {
            self.dialog = Some(Dialog::Save(super::dialog::ask_save(ctx)));
        }
        if let Some(keypoints) = requests.photo_dialog {
            self.dialog = Some(Dialog::Photo(super::dialog::ask_photo(ctx, keypoints), keypoints));
        }
        if requests.thing_dialog {
            self.dialog = Some(Dialog::Thing(super::dialog::ask_thing(ctx)));
        }
        if requests.clips_dialog {
            self.dialog = Some(Dialog::Clips(super::dialog::ask_clips(ctx)));
        }
        if requests.export_dialog {
            self.dialog = Some(Dialog::Export(super::dialog::ask_folder(ctx)));
        }
        let dark = self.state.view.dark;
        ctx.set_theme(if dark { egui::Theme::Dark } else { egui::Theme::Light });
    }

    /// What the user chose in a dialog; without a dialog on this desktop, a field for the path instead.
    fn poll_dialog(&mut self) {
        let waiting = self.dialog.as_mut().map(|dialog| match dialog {
            Dialog::Open(job)
            | Dialog::Save(job)
            | Dialog::Export(job)
            | Dialog::Photo(job, _)
            | Dialog::Thing(job)
            | Dialog::Clips(job) => job,
        });
        let Some(job) = waiting else { return };
        let Some(outcome) = job.poll() else { return };
        let Some(dialog) = self.dialog.take() else { return };
        let state = &mut self.state;
        match (outcome, dialog) {
            (Outcome::Done(Some(path)), Dialog::Open(_)) => actions::open_file(state, path),
            (Outcome::Done(Some(path)), Dialog::Save(_)) => {
                state.start_saving(panels::with_project_extension(path));
            }
            (Outcome::Done(Some(path)), Dialog::Export(_)) => state.start_exporting(path),
            (Outcome::Done(Some(path)), Dialog::Photo(_, true)) => {
                state.photo.keypoints_path = path.display().to_string();
            }
            (Outcome::Done(Some(path)), Dialog::Photo(_, false)) => {
                state.photo.picture_path = path.display().to_string();
            }
            (Outcome::Done(Some(path)), Dialog::Thing(_)) => state.begin_thing(&path),
            (Outcome::Done(Some(path)), Dialog::Clips(_)) => {
                state.motion.options.clips = path.display().to_string();
            }
            (Outcome::Done(None), _) => {}
            (_, Dialog::Thing(_)) => state.overlay = Overlay::ThingPath(String::new()),
            (_, Dialog::Photo(..) | Dialog::Clips(_)) => {
                state.notices.warning("This desktop has no file dialog: type the path.");
            }
            (_, Dialog::Open(_)) => state.overlay = Overlay::OpenPath(String::new()),
            (_, Dialog::Save(_)) => state.overlay = Overlay::SavePath(String::new()),
            (_, Dialog::Export(_)) => state.overlay = Overlay::ExportPath(String::new()),
        }
    }

    /// Asks before the window closes with unsaved people in it.
    fn guard_close(&mut self, ctx: &Context) {
        let closing = ctx.input(|i| i.viewport().close_requested());
        if closing {
            self.state.leave_study();
        }
        if closing && self.state.has_unsaved_work() && !self.leaving && self.script.is_none() {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.state.overlay = Overlay::Unsaved(super::state::Leaving::Quit);
        }
    }

    /// Time goes on in the motions that play.
    fn play(&mut self, ctx: &Context, passed: Duration) {
        let length_s = if self.state.motion.player.playing { self.state.play_seconds() } else { 0.0 };
        if self.state.motion.player.playing {
            self.state.motion.player.advance(passed.as_secs_f32(), length_s);
            ctx.request_repaint();
        }
        if self.state.advance_replay(passed.as_secs_f32()) {
            ctx.request_repaint_after(NEWS_EVERY);
        }
    }

    /// A study shows the view and the scale, and nothing that could give away what is shown.
    fn show_study(&mut self, ui: &mut Ui, ctx: &Context) {
        egui::Panel::bottom("study").show(ui, |ui| panels::study_bar(ui, &mut self.state));
        let frame = egui::Frame::central_panel(ui.style()).inner_margin(0);
        egui::CentralPanel::default().frame(frame).show(ui, |ui| {
            let canvases = Canvases { main: &mut self.canvas, beside: &mut self.beside };
            viewport::viewport(ui, &mut self.state, canvases);
        });
        panels::overlays(ctx, &mut self.state);
        panels::toasts(ctx, &mut self.state);
        self.do_requests(ctx);
    }

    fn dock(&mut self, ui: &mut Ui) {
        let (state, canvas, beside) = (&mut self.state, &mut self.canvas, &mut self.beside);
        let mut panes = Panes { state, canvas, beside, over_viewport: &mut self.over_viewport };
        self.tree.ui(&mut panes, ui);
    }
}

impl eframe::App for Window {
    fn logic(&mut self, ctx: &Context, _frame: &mut eframe::Frame) {
        self.clock.begin(self.state.jobs.populating());
        // Before the jobs are looked at, so that news during the look ask for another frame.
        self.woken.store(false, Ordering::Release);
        self.state.poll();
        self.poll_dialog();
        self.keep_settings();
        if let Some(next) = self.autosave.as_mut().and_then(|autosave| autosave.keep(&mut self.state)) {
            ctx.request_repaint_after(next);
        }
        self.show_title(ctx);
        let passed = Duration::from_secs_f32(ctx.input(|i| i.unstable_dt).min(1.0));
        self.play(ctx, passed);
        if let Some(next) = self.state.notices.advance(passed) {
            ctx.request_repaint_after(next.min(Duration::from_millis(500)));
        }
        if let Some(script) = &mut self.script {
            script.advance(ctx, &mut self.state);
        }
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.take_keys(&ctx);
        self.take_drops(&ctx);
        self.guard_close(&ctx);
        if self.state.study.is_some() {
            return self.show_study(ui, &ctx);
        }
        egui::Panel::top("menu").show(ui, |ui| panels::menu_bar(ui, &mut self.state));
        let render = RenderStatus { adapter: self.canvas.adapter(), frame_ms: self.canvas.frame_ms() };
        egui::Panel::bottom("status").show(ui, |ui| panels::status_bar(ui, &mut self.state, &render));
        let frame = egui::Frame::central_panel(ui.style()).inner_margin(0);
        egui::CentralPanel::default().frame(frame).show(ui, |ui| {
            if self.state.has_room() || self.state.jobs.opening() {
                self.dock(ui);
            } else {
                panels::welcome(ui, &mut self.state);
            }
        });
        panels::overlays(&ctx, &mut self.state);
        panels::drop_hint(&ctx);
        panels::toasts(&ctx, &mut self.state);
        self.do_requests(&ctx);
        self.clock.end(self.state.jobs.populating());
    }

    fn on_exit(&mut self) {
        if let Some(autosave) = &mut self.autosave {
            autosave.discard();
        }
        if let Some(times) = &self.times {
            *times.lock().unwrap_or_else(PoisonError::into_inner) = self.clock.times().clone();
        }
    }

    /// Tab goes through the people, not through the widgets, while nobody types.
    fn raw_input_hook(&mut self, ctx: &Context, input: &mut egui::RawInput) {
        if ctx.text_edit_focused() || self.state.overlay != Overlay::None || !self.over_viewport {
            return;
        }
        let keys = &mut self.keys;
        input.events.retain(|event| {
            let egui::Event::Key { key: Key::Tab, pressed, modifiers, .. } = event else { return true };
            if *pressed {
                keys.extend(commands::for_key(Key::Tab, *modifiers));
            }
            false
        });
    }
}

fn run_if_possible(state: &mut EditorState, command: &commands::CommandInfo) {
    if (command.enabled)(state) {
        (command.run)(state);
    }
}

/// The command that a key means now. While a text field is typed in or a question is asked, only Escape is a
/// command; while flying, letters steer.
fn command_for(
    key: Key,
    modifiers: Modifiers,
    typing: bool,
    flying: bool,
    overlay: &Overlay,
) -> Option<&'static commands::CommandInfo> {
    if key == Key::Escape && (!typing || *overlay != Overlay::None) {
        return commands::for_key(key, modifiers);
    }
    let steers = matches!(key, Key::W | Key::A | Key::S | Key::D | Key::Q | Key::E);
    if typing || overlay.takes_keys() || (flying && steers) {
        return None;
    }
    commands::for_key(key, modifiers)
}

/// Where the panels are at first.
fn layout() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let mut tabs = |panes: &[Pane]| {
        let children = panes.iter().map(|pane| tiles.insert_pane(*pane)).collect();
        tiles.insert_tab_tile(children)
    };
    let objects = tabs(&[Pane::Objects]);
    let people = tabs(&[Pane::People]);
    let view = tabs(&[Pane::Viewport]);
    let below = tabs(&[Pane::Findings, Pane::Timeline, Pane::Candidates, Pane::Energies, Pane::Jobs]);
    let populate = tabs(&[Pane::Populate, Pane::Sample, Pane::Photo, Pane::Motion, Pane::Actions]);
    let inspector = tabs(&[Pane::Inspector, Pane::Why]);
    let mut column =
        |children: [TileId; 2], shares: [f32; 2]| linear(&mut tiles, LinearDir::Vertical, &children, &shares);
    let left = column([objects, people], [0.6, 0.4]);
    let middle = column([view, below], [0.74, 0.26]);
    let right = column([populate, inspector], [0.6, 0.4]);
    let root = linear(&mut tiles, LinearDir::Horizontal, &[left, middle, right], &[0.17, 0.61, 0.22]);
    Tree::new(egui::Id::unique("dock"), root, tiles)
}

fn linear(tiles: &mut Tiles<Pane>, dir: LinearDir, children: &[TileId], shares: &[f32]) -> TileId {
    let mut linear = Linear::new(dir, children.to_vec());
    for (child, share) in children.iter().zip(shares) {
        linear.shares.set_share(*child, *share);
    }
    tiles.insert_container(Container::Linear(linear))
}

struct Panes<'a> {
    state: &'a mut EditorState,
    canvas: &'a mut Canvas,
    beside: &'a mut Canvas,
    over_viewport: &'a mut bool,
}

impl egui_tiles::Behavior<Pane> for Panes<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        if *pane == Pane::Viewport {
            let canvases = Canvases { main: self.canvas, beside: self.beside };
            *self.over_viewport = viewport::viewport(ui, self.state, canvases);
            return UiResponse::None;
        }
        let show: fn(&mut Ui, &mut EditorState) = match pane {
            Pane::Viewport | Pane::Objects => panels::outliner,
            Pane::People => panels::people,
            Pane::Populate => panels::populate,
            Pane::Sample => panels::sample,
            Pane::Photo => panels::photo,
            Pane::Motion => panels::motion,
            Pane::Actions => panels::living,
            Pane::Inspector => panels::inspector,
            Pane::Why => panels::why,
            Pane::Candidates => panels::sheet,
            Pane::Timeline => panels::timeline,
            Pane::Findings => panels::findings,
            Pane::Energies => panels::energies,
            Pane::Jobs => panels::jobs,
        };
        egui::Frame::new().inner_margin(8).show(ui, |ui| show(ui, self.state));
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        match pane {
            Pane::Viewport => "View".to_owned(),
            Pane::Objects => "Objects".to_owned(),
            Pane::People => format!("People {}", self.state.document.scene().people.len()),
            Pane::Populate => "Populate".to_owned(),
            Pane::Sample => "Sample".to_owned(),
            Pane::Photo => "Photo".to_owned(),
            Pane::Motion => "Motion".to_owned(),
            Pane::Actions => "Actions".to_owned(),
            Pane::Timeline => "Timeline".to_owned(),
            Pane::Inspector => "Inspector".to_owned(),
            Pane::Why => "Why like this".to_owned(),
            Pane::Candidates => format!("Candidates {}", self.state.sheet.cards.len()),
            Pane::Findings => format!("Findings {}", self.state.findings().len()),
            Pane::Energies => "Energies".to_owned(),
            Pane::Jobs => "Jobs".to_owned(),
        }
        .into()
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
    }

    fn tab_bar_color(&self, visuals: &egui::Visuals) -> egui::Color32 {
        theme::palette(visuals).recessed
    }

    fn tab_bar_height(&self, _style: &egui::Style) -> f32 {
        26.0
    }

    fn gap_width(&self, _style: &egui::Style) -> f32 {
        2.0
    }
}
