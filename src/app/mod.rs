//! The editor's window: panels, viewport, tools, commands, jobs, notifications. The only place that names
//! egui. Sends intents to the document and never edits the scene in place; never names `cli`.
//!
//! [`EditorState`] is the editor without its window: actions, jobs and picking work on it and are tested
//! there. `Window` only draws it and hands on what the user does.

mod actions;
mod actors;
mod autosave;
mod canvas;
mod commands;
mod day;
mod dialog;
mod engine;
mod frames;
mod goal_marks;
mod icons;
mod jobs;
mod learned;
mod life_marks;
mod lived;
mod living;
mod motion;
mod moving;
mod networks;
mod notices;
mod orbit;
mod overlay3d;
mod panels;
mod photo;
mod photos;
mod pick;
mod pictures;
mod real;
mod rooms;
mod samples;
mod sampling;
mod screenshot;
mod selection;
mod state;
mod study;
#[cfg(test)]
mod tests;
mod theme;
mod thing_pictures;
mod things;
mod transform;
mod viewport;
mod window;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

pub use frames::FrameTimes;
pub use motion::Placing;
pub use orbit::{AxisView, Orbit};
pub use screenshot::ScreenshotPlan;
pub use state::EditorState;

use crate::document::Settings;
use crate::document::autosave_path;
use crate::document::things_folder;
use real::RealEngine;
use window::Window;

/// How the window starts.
#[derive(Clone, Debug, Default)]
pub struct AppOptions {
    /// A room, a project or `sample:KEY` to open; the first sample room when `None`.
    pub project_or_room: Option<PathBuf>,
    /// Take a picture of the window and close.
    pub screenshot: Option<ScreenshotPlan>,
    /// Size of the window in points.
    pub size: Option<[f32; 2]>,
}

/// The window leaves a core to itself: with all of them at the fits its frames would come late.
fn leave_a_core_for_the_window() {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    // Somebody may have made the pool before, as tests do; then it stays as it is.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(cores.saturating_sub(1).max(1)).build_global();
}

/// The editor without its window, with the program's own work behind it, opening `room` (as in [`AppOptions`]). Whoever
/// drives it calls [`EditorState::poll`] until what they wait for is there.
pub fn editor(room: Option<PathBuf>) -> EditorState {
    let mut state = EditorState::new(Arc::new(RealEngine::default()), Arc::new(|| ()));
    state.open(real::source_named(room));
    state
}

/// Opens the window and returns when it is closed: how smooth it was, if that was asked for.
///
/// # Errors
/// When there is no display or no graphics adapter, or the picture of [`AppOptions::screenshot`] could not be
/// taken. Nothing that happens inside the window is an error here.
pub fn run(options: AppOptions) -> anyhow::Result<Option<FrameTimes>> {
    leave_a_core_for_the_window();
    let result = Arc::new(Mutex::new(None));
    let script =
        options.screenshot.as_ref().map(|plan| screenshot::Script::new(plan.clone(), result.clone()));
    let photographs = script.is_some();
    let timed = options.screenshot.as_ref().is_some_and(|plan| plan.frame_times);
    let times = Arc::new(Mutex::new(FrameTimes::default()));
    let kept = times.clone();
    let size = options.size.unwrap_or([1440.0, 900.0]);
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Inhabit")
            .with_app_id("inhabit")
            .with_inner_size(size)
            .with_min_inner_size([640.0, 400.0])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        ..eframe::NativeOptions::default()
    };
    let source = real::source_named(options.project_or_room);
    let create: eframe::AppCreator<'_> = Box::new(move |cc| {
        let mut window =
            Window::new(cc, Arc::new(RealEngine::default())).with_script(script).keeping_times(kept);
        if !photographs {
            window.remember(Settings::default_path());
            window.keep_safe(autosave_path());
            window.state.remember_things(things_folder());
        }
        window.state.open(source);
        Ok(Box::new(window))
    });
    eframe::run_native("Inhabit", native, create)
        .map_err(|error| anyhow::anyhow!("the window can't be opened: {error}"))?;
    let taken = result.lock().unwrap_or_else(PoisonError::into_inner).take();
    match taken {
        Some(Err(why)) => Err(anyhow::anyhow!(why)),
        None if photographs => Err(anyhow::anyhow!("the window was closed before its picture was taken")),
        Some(Ok(())) | None => {
            let times = times.lock().unwrap_or_else(PoisonError::into_inner);
            Ok(timed.then(|| times.clone()))
        }
    }
}
