//! The job that makes a motion of sub-goals: plays what is there so far, and keeps it when it is cancelled.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::engine::{MotionMethod, MovePreview, MoveTask, Moved};
use crate::app::state::EditorState;
use crate::document::Command;
use crate::document::RoomVersion;
use crate::evolve::journey::seed_of;
use crate::job::{Job, JobCtx, Seed};
use crate::scene::Clip;
use crate::scene::ClipId;
use crate::scene::SubGoal;
use crate::scene::SubGoalId;

/// A motion that is being made.
pub struct Making {
    pub job: Job<Moved, MovePreview>,
    version: RoomVersion,
    clip: ClipId,
    /// What the user chose; a clip made of it says so, whatever became of it on the way.
    seed: u64,
    /// The sub-goals that it is made of.
    goals: Vec<SubGoal>,
}

impl std::fmt::Debug for Making {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "motion {} is being made", self.clip.0)
    }
}

impl EditorState {
    /// Whether the active motion can be made now, or why not.
    ///
    /// # Errors
    /// What is missing, for people.
    pub fn can_synthesise(&self) -> Result<(), &'static str> {
        let clip =
            self.active_clip().ok_or("Place a sub-goal first: press Add sub-goals and click the floor.")?;
        if clip.goals.is_empty() {
            return Err("Place a sub-goal first: press Add sub-goals and click the floor.");
        }
        if clip.locked {
            return Err("This motion is locked.");
        }
        if self.geometry().is_none() {
            return Err("Waits for the room analysis.");
        }
        let options = &self.motion.options;
        if options.method == MotionMethod::Retrieval && options.clips.trim().is_empty() {
            return Err("Captured pieces need a folder of clips: choose one below the method.");
        }
        Ok(())
    }

    /// Starts to make the active motion; legs that nothing has changed are kept.
    pub fn start_synthesis(&mut self) {
        self.synthesise_anew(Vec::new());
    }

    /// The same, with other bodies at some sub-goals.
    pub fn synthesise_anew(&mut self, anew: Vec<SubGoalId>) {
        if let Err(why) = self.can_synthesise() {
            self.notices.warning(why);
            return;
        }
        let (Some(geometry), Some(clip)) = (self.geometry().cloned(), self.active_clip().cloned()) else {
            return;
        };
        let options = self.motion.options.clone();
        let scene = self.document.scene();
        let others = scene.clips.iter().filter(|c| c.id != clip.id && c.visible && !c.frames.is_empty());
        let others: Vec<Arc<Clip>> = others.cloned().collect();
        let walks = |id| Some(id) == clip.person || super::goals::moves(&others, id);
        let people = scene.people.iter().filter(|p| p.visible && !walks(p.id)).cloned().collect();
        let wanted = Clip { betas: options.betas, seed: options.seed, ..clip.as_ref().clone() };
        let room = scene.room.clone();
        let clips = Some(options.clips.trim()).filter(|folder| !folder.is_empty()).map(PathBuf::from);
        let method = options.method;
        let task = MoveTask { room, geometry, clip: wanted, method, anew, others, people, clips };
        let engine = self.engine.clone();
        let work = move |cx: &JobCtx<MovePreview>| engine.synthesise(&task, cx);
        let name = format!("Synthesise {}", clip.name);
        let job = Job::spawn(name, seed_of(Seed::root(options.seed), clip.id), self.waker(), work);
        let version = self.document.room_version();
        self.jobs.making =
            Some(Making { job, version, clip: clip.id, seed: options.seed, goals: clip.goals.clone() });
        self.motion.preview = None;
        // What is in the way stays to be read; that nothing is needs no word any more.
        self.motion.reach = self.motion.reach.take().filter(|(_, answer)| answer.is_err());
        self.requests.show_timeline = true;
    }

    pub(in crate::app) fn poll_making(&mut self) {
        let Some(making) = &mut self.jobs.making else { return };
        if let Some(preview) = making.job.take_preview() {
            let first = self.motion.preview.is_none();
            let shown = Clip { id: making.clip, seed: making.seed, ..preview.clip.as_ref().clone() };
            self.motion.preview = Some(Arc::new(shown));
            self.motion.player.playing |= first && preview.clip.frames.len() > 1;
        }
        let Some(making) = &mut self.jobs.making else { return };
        let Some(outcome) = making.job.poll() else { return };
        let (name, version, id) = (making.job.name().to_owned(), making.version, making.clip);
        let (seed, goals) = (making.seed, std::mem::take(&mut making.goals));
        self.jobs.making = None;
        self.motion.preview = None;
        let Some(moved) = self.taken(&name, outcome) else { return };
        if self.document.scene().clip(id).is_some_and(|clip| clip.goals != goals) {
            self.notices.info("Sub-goals were changed meanwhile: the motion is made again.");
            self.activate_clip(id);
            return self.start_synthesis();
        }
        for remark in &moved.remarks {
            self.notices.warning(remark.clone());
        }
        self.keep_motion(id, Clip { seed, ..moved.clip }, version);
        if let (Some(report), Some(clip)) = (moved.report, self.document.scene().clip(id).cloned()) {
            self.keep_clip_report(&clip, version, report);
        }
    }

    /// Puts a motion that was made in place of its plan; what belongs to the user stays as it is now.
    fn keep_motion(&mut self, id: ClipId, made: Clip, version: RoomVersion) -> bool {
        let Some(now) = self.document.scene().clip(id) else {
            self.notices.warning("The motion was removed while it was made.");
            return false;
        };
        let clip = Clip {
            id,
            name: now.name.clone(),
            person: now.person,
            palette: now.palette,
            visible: now.visible,
            locked: now.locked,
            ..made
        };
        self.apply(Command::ReplaceClip { clip, made_for: Some(version) })
    }

    /// Lets go of the job; the motion as it is so far stays, as one step.
    pub(in crate::app) fn stop_making(&mut self) {
        let Some(making) = self.jobs.making.take() else { return };
        making.job.cancel();
        let newest = making.job.take_preview().map(|preview| preview.clip);
        let same = self.document.scene().clip(making.clip).is_some_and(|clip| clip.goals == making.goals);
        let best = newest.or(self.motion.preview.take()).filter(|clip| same && !clip.frames.is_empty());
        self.motion.preview = None;
        match best {
            Some(clip) => {
                let best = Clip { seed: making.seed, ..clip.as_ref().clone() };
                if self.keep_motion(making.clip, best, making.version) {
                    self.notices.info("Cancelled. The motion as it was by then is kept; undo takes it back.");
                }
            }
            None => self.notices.info("Cancelled. Nothing was changed."),
        }
    }

    /// Makes the legs again that a change has touched, where the user wants that.
    pub(in crate::app) fn follow_change(&mut self, id: ClipId) {
        let stale = |clip: &Arc<Clip>| !clip.frames.is_empty() && clip.legs.iter().any(|leg| leg.key == 0);
        let touched = self.document.scene().clip(id).is_some_and(stale);
        if touched && self.motion.options.follow_changes && self.jobs.making.is_none() {
            self.activate_clip(id);
            if self.can_synthesise().is_ok() {
                self.start_synthesis();
            }
        }
    }
}
