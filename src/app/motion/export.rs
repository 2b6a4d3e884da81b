//! Writes motions for other programs, beside the window.

use std::path::PathBuf;

use crate::app::day::RoomIsAnother;
use crate::app::engine::{MotionExport, MotionFormat, RoomChanges};
use crate::app::state::{EditorState, Overlay};
use crate::job::{Job, JobCtx, Seed};

/// Longer side of the pictures of a film in pixels: full HD's half, which a page shows well.
const LONG_SIDE: f32 = 960.0;

impl EditorState {
    /// Asks where to write the motions.
    pub fn ask_motion_export(&mut self, format: MotionFormat) {
        let name = self.active_clip().map_or_else(|| "motion".to_owned(), |clip| file_name(&clip.name));
        let folder = self.project.as_ref().and_then(|path| path.parent()).map(PathBuf::from);
        let name =
            if format == MotionFormat::Pictures { name } else { format!("{name}.{}", format.ending()) };
        let path = folder.unwrap_or_default().join(name);
        self.motion.export = super::MotionExportChoice { format, path: path.display().to_string() };
        self.overlay = Overlay::ExportMotion;
    }

    /// Starts to write the motions that are shown.
    pub fn start_motion_export(&mut self) {
        let choice = self.motion.export.clone();
        let clips: Vec<_> = self.shown_clips().into_iter().filter(|clip| !clip.frames.is_empty()).collect();
        if clips.is_empty() || choice.path.trim().is_empty() {
            self.notices.warning("There is no motion to write yet: synthesise one first.");
            return;
        }
        let even = |side: f32| ((side / 2.0).round() as u32 * 2).max(2);
        let size = if self.aspect >= 1.0 {
            [even(LONG_SIDE), even(LONG_SIDE / self.aspect)]
        } else {
            [even(LONG_SIDE * self.aspect), even(LONG_SIDE)]
        };
        let changes = self.room_changes(&clips).unwrap_or_else(|RoomIsAnother| {
            let still = "The room was changed since the day was made: in the file its things stand still.";
            self.notices.warning(still);
            RoomChanges::default()
        });
        let (scene, camera) = (self.document.scene().clone(), self.orbit.camera());
        let export = MotionExport { format: choice.format, scene, clips, changes, camera, size };
        let (engine, path) = (self.engine.clone(), PathBuf::from(choice.path.trim()));
        let target = path.clone();
        let work = move |cx: &JobCtx| engine.export_motion(&target, &export, cx.ticker());
        let name = format!("Export {}", choice.format.label());
        self.jobs.exporting_motion = Some((path, Job::spawn(name, Seed::root(0), self.waker(), work)));
    }

    pub(in crate::app) fn poll_motion_export(&mut self) {
        let Some((_, job)) = &mut self.jobs.exporting_motion else { return };
        let Some(outcome) = job.poll() else { return };
        let Some((path, job)) = self.jobs.exporting_motion.take() else { return };
        if let Some(files) = self.taken(job.name(), outcome) {
            let what = if files == 1 { "1 file".to_owned() } else { format!("{files} files") };
            self.notices.info(format!("{}: {what} written to {}", job.name(), path.display()));
        }
    }
}

/// A name that every file system takes.
fn file_name(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_alphanumeric() || c == '-' { c } else { '_' }).collect();
    if plain.is_empty() { "motion".to_owned() } else { plain }
}
