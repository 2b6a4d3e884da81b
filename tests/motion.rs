//! Motions made in the window and by the program: the same bytes for the same seed, and a stop that keeps what is there.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use glam::Vec3;
use inhabit::app::{EditorState, Placing, editor};
use inhabit::document::load_project;
use inhabit::scene::{Clip, GoalPose};

/// Where somebody is to be in the sample bedroom: across the free floor.
const PLACES: [Vec3; 3] = [Vec3::new(-0.4, 0.0, 0.6), Vec3::new(0.7, 0.0, 0.9), Vec3::new(-0.3, 0.0, 1.1)];
const SEED: u64 = 5;

/// Lets the editor work until something holds.
fn waits(state: &mut EditorState, until: impl Fn(&EditorState) -> bool) {
    let begun = Instant::now();
    while !until(state) {
        state.poll();
        std::thread::sleep(Duration::from_millis(2));
        assert!(begun.elapsed() < Duration::from_secs(300), "waited in vain");
    }
}

/// The editor with the sub-goals placed, as by a click on each.
fn with_sub_goals() -> EditorState {
    let mut state = editor(Some("sample:bedroom".into()));
    waits(&mut state, |state| state.geometry().is_some());
    state.motion.options.pose = GoalPose::Stand;
    state.motion.options.stay_s = 0.5;
    state.motion.options.seed = SEED;
    for at in PLACES {
        state.place_goal(Placing { at, towards: at });
    }
    state
}

fn clip_of(state: &EditorState) -> Clip {
    state.document.scene().clips[0].as_ref().clone()
}

/// What the program makes of the same sub-goals.
fn by_the_program(folder: &Path) -> Clip {
    let place = |at: Vec3| format!("(at: ({}, {}, {}), pose: Stand, stay_s: 0.5)", at.x, at.y, at.z);
    let goals = folder.join("goals.ron");
    std::fs::write(&goals, format!("[{}]", PLACES.map(place).join(", "))).expect("written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_inhabit"));
    command.args([
        "move",
        "sample:bedroom",
        "--quiet",
        "--no-pictures",
        "--seed",
        &SEED.to_string(),
        "--goals",
    ]);
    let output = command.arg(&goals).arg("--out").arg(folder.join("out")).output().expect("runs");
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}: {told}", output.status);
    let loaded = load_project(&folder.join("out/project.ron")).expect("opens");
    loaded.project.scene.clips[0].as_ref().clone()
}

#[test]
fn the_window_and_the_program_make_the_same_bytes_of_the_same_seed() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = by_the_program(folder.path());
    let mut state = with_sub_goals();
    state.start_synthesis();
    waits(&mut state, |state| !state.jobs.moving());
    let window = clip_of(&state);
    assert!(window.frames.len() > 60, "{} frames", window.frames.len());
    assert_eq!(window, program);
    state.motion.export.path = folder.path().join("window.glb").display().to_string();
    state.start_motion_export();
    waits(&mut state, |state| !state.jobs.any_running());
    let bytes =
        |file: &str| std::fs::read(folder.path().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
    assert!(bytes("window.glb") == bytes("out/clip.glb"), "the files differ");
}

#[test]
fn a_motion_that_is_stopped_is_kept_as_it_is_by_then_as_exactly_one_step() {
    let mut state = with_sub_goals();
    let steps = |state: &EditorState| state.document.past_labels().map(str::to_owned).collect::<Vec<_>>();
    let placed = steps(&state);
    state.start_synthesis();
    waits(&mut state, |state| state.motion.preview.as_ref().is_some_and(|clip| clip.frames.len() > 1));
    let begun = Instant::now();
    state.cancel_all();
    let answered = begun.elapsed();
    assert!(!state.jobs.moving() && answered < Duration::from_millis(200), "{answered:?}");
    let kept = clip_of(&state);
    assert!(kept.frames.len() > 1 && kept.goals.len() >= PLACES.len());
    // The worker ends by itself; whatever it still finds out changes nothing.
    for _ in 0..50 {
        state.poll();
        std::thread::sleep(Duration::from_millis(4));
    }
    assert_eq!(steps(&state), [&placed[..], &["Synthesise motion".to_owned()]].concat());
    assert_eq!(clip_of(&state), kept);
    assert!(state.document.undo().is_some());
    assert!(clip_of(&state).frames.is_empty() && clip_of(&state).goals.len() == PLACES.len());
    assert!(state.document.redo().is_some());
    assert_eq!(clip_of(&state), kept);
}
