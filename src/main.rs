//! Arguments to the command line or the window; nothing else.

use std::process::ExitCode;

use inhabit::app::{self, AppOptions, ScreenshotPlan};
use inhabit::cli::{self, WindowArguments};

fn main() -> ExitCode {
    let arguments = cli::parse();
    match arguments.command {
        Some(command) => cli::run(command),
        None => open_window(&arguments.window),
    }
}

/// The editor, or where there is no display the same job without it.
fn open_window(window: &WindowArguments) -> ExitCode {
    if !has_display() {
        return cli::run_without_display("no display was found", window);
    }
    match app::run(options(window)) {
        Ok(times) => {
            if let Some(times) = times {
                println!("{times}");
            }
            ExitCode::SUCCESS
        }
        Err(error) if window.screenshot.is_none() && !window.frame_times => {
            cli::run_without_display(&format!("the window could not be opened ({error:#})"), window)
        }
        Err(error) => {
            eprintln!("inhabit: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn options(window: &WindowArguments) -> AppOptions {
    let plan = ScreenshotPlan {
        file: window.screenshot.clone(),
        frame_times: window.frame_times,
        people: window.populate.unwrap_or(0),
        seed: window.seed,
        sample: window.sample.unwrap_or(0),
        method: window.method.clone(),
        agent: window.agent,
        accept: window.accept,
        heat: window.heat,
        goals: window.goal.clone(),
        at_s: window.at,
        actions: window.actions,
        select: window.select,
        frame_selected: window.frame,
        light: window.light,
        overlay: window.overlay.clone(),
    };
    let scripted = window.screenshot.is_some() || window.frame_times;
    AppOptions {
        project_or_room: window.open.clone(),
        screenshot: scripted.then_some(plan),
        ..AppOptions::default()
    }
}

/// On Linux and the BSDs a window needs an X or Wayland server; elsewhere there is always a desktop.
fn has_display() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|v| !v.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || set("DISPLAY") || set("WAYLAND_DISPLAY")
}
