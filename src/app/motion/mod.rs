//! Motion in the window: sub-goals that are placed by hand, the job that makes a motion of them, playing it, and
//! what was measured of it.

mod export;
mod ghosts;
mod goals;
mod making;
mod measuring;
mod player;

use std::collections::BTreeMap;
use std::sync::Arc;

pub use goals::{Placing, carried_goal, moves, renumbered};
pub use making::Making;
pub use measuring::{MeasuredClip, Measuring};
pub use player::{Player, SPEEDS};

use super::engine::{MotionFormat, MotionMethod};
use super::selection::Item;
use super::state::EditorState;
use crate::inspect::MotionReport;
use crate::math::Aabb;
use crate::scene::BETAS;
use crate::scene::Clip;
use crate::scene::ClipId;
use crate::scene::Frame;
use crate::scene::GoalPose;
use crate::scene::SubGoal;
use crate::scene::SubGoalId;

/// What is made next.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionOptions {
    /// By what.
    pub method: MotionMethod,
    /// What is done at the next sub-goal that is placed.
    pub pose: GoalPose,
    /// How long one stays there, seconds.
    pub stay_s: f32,
    /// Root of the seed tree.
    pub seed: u64,
    /// Body shape.
    pub betas: [f32; BETAS],
    /// Legs that a change touches are made again at once.
    pub follow_changes: bool,
    /// Folder of motion clips, for the method that looks pieces up.
    pub clips: String,
}

impl Default for MotionOptions {
    fn default() -> Self {
        Self {
            method: MotionMethod::default(),
            pose: GoalPose::Any,
            stay_s: 2.0,
            seed: 1,
            betas: [0.0; BETAS],
            follow_changes: true,
            clips: String::new(),
        }
    }
}

/// What is shown of where somebody was and will be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trail {
    /// Nothing.
    Off,
    /// A line along the floor.
    #[default]
    Line,
    /// The line, and figures before and after now.
    Figures,
}

/// Which sub-goals show a figure; marks on the floor are there for all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GoalFigures {
    /// None.
    Off,
    /// Those that somebody asked for.
    #[default]
    Wanted,
    /// Those of the planner too.
    All,
}

/// The state of motion in the window.
#[derive(Debug, Default)]
pub struct MotionPanel {
    /// What is made next.
    pub options: MotionOptions,
    /// What is shown of the way.
    pub trail: Trail,
    /// Which sub-goals show a figure.
    pub figures: GoalFigures,
    /// The motion that sub-goals are added to and that is made next.
    pub active: Option<ClipId>,
    /// What time it is.
    pub player: Player,
    /// The motion that is being made, as it is so far.
    pub preview: Option<Arc<Clip>>,
    /// What is in the way of the sub-goal that is being moved; `Ok` where nothing is.
    pub reach: Option<(Item, Result<(), String>)>,
    /// A sub-goal that is being placed: the button is down.
    pub placing: Option<Placing>,
    /// The export that was asked for.
    pub export: MotionExportChoice,
    pub(super) measured: BTreeMap<ClipId, MeasuredClip>,
    /// The revision at which measuring failed; not tried again until something changes.
    pub(super) unmeasurable: Option<u64>,
    /// The figures that the view shows at sub-goals.
    pub(super) shown_figures: Vec<GoalFigure>,
    pub(super) stand_ins: ghosts::StandIns,
}

impl MotionPanel {
    /// Forgets everything that belongs to a room that is no longer open; choices stay.
    pub(super) fn forget(&mut self) {
        let (options, trail, figures) = (self.options.clone(), self.trail, self.figures);
        *self = Self { options, trail, figures, ..Self::default() };
    }
}

/// What is exported, and where to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionExportChoice {
    /// As what.
    pub format: MotionFormat,
    /// The file or, for pictures, the folder.
    pub path: String,
}

/// Somebody at a sub-goal.
#[derive(Clone, Debug, PartialEq)]
pub struct GoalFigure {
    /// Which sub-goal.
    pub item: Item,
    /// Body shape.
    pub betas: [f32; BETAS],
    /// The body.
    pub frame: Frame,
    /// Colours of the clothes.
    pub palette: u32,
    /// It is a place holder: how the body will really be is not known yet.
    pub stand_in: bool,
}

impl EditorState {
    /// The motion that sub-goals are added to.
    pub fn active_clip(&self) -> Option<&Arc<Clip>> {
        self.document.scene().clip(self.motion.active?)
    }

    /// The sub-goal of an item.
    pub fn goal(&self, clip: ClipId, goal: SubGoalId) -> Option<&SubGoal> {
        self.document.scene().clip(clip)?.goal(goal)
    }

    /// The motions that are shown, the one that is being made as it is so far.
    pub fn shown_clips(&self) -> Vec<Arc<Clip>> {
        let only = self.view.isolated.as_ref();
        let shown =
            |clip: &&Arc<Clip>| clip.visible && only.is_none_or(|only| only.contains(&Item::Clip(clip.id)));
        let clips = self.document.scene().clips.iter().filter(shown);
        let preview = self.motion.preview.as_ref();
        clips.map(|clip| preview.filter(|p| p.id == clip.id).unwrap_or(clip).clone()).collect()
    }

    /// Whether there is anything to play.
    pub fn can_play(&self) -> bool {
        self.play_seconds() > 0.0
    }

    /// How long the longest motion that is shown lasts, seconds.
    pub fn play_seconds(&self) -> f32 {
        self.shown_clips().iter().map(|clip| clip.seconds()).fold(0.0, f32::max)
    }

    /// The frame of a motion that is shown now; `None` while it has none.
    pub fn frame_now(&self, clip: &Clip) -> Option<usize> {
        (!clip.frames.is_empty()).then(|| clip.frame_at(self.motion.player.seconds))
    }

    /// What was measured of a motion, if it still holds.
    pub fn clip_report(&self, clip: &Arc<Clip>) -> Option<&Arc<MotionReport>> {
        let measured = self.motion.measured.get(&clip.id)?;
        measured.holds(clip, self.document.room_version()).then_some(&measured.report)
    }

    /// Makes a motion the one that is worked on, and its shape and seed those of the panel.
    pub fn activate_clip(&mut self, id: ClipId) {
        let Some(clip) = self.document.scene().clip(id).cloned() else { return };
        if self.motion.active != Some(id) {
            self.motion.active = Some(id);
            self.motion.options.betas = clip.betas;
            self.motion.options.seed = clip.seed;
        }
    }

    /// The box around a motion's person as shown now, or around its sub-goals while there are no frames.
    pub(super) fn clip_bounds(&self, id: ClipId) -> Aabb {
        let Some(clip) = self.document.scene().clip(id) else { return Aabb::EMPTY };
        match self.frame_now(clip) {
            Some(frame) => Aabb::of(self.engine.pose_frame(&clip.betas, &clip.frames[frame]).iter().copied()),
            None => clip
                .goals
                .iter()
                .fold(Aabb::EMPTY, |all, goal| all.union(self.bounds_of(Item::Goal(id, goal.id)))),
        }
    }

    /// Forgets what belongs to motions that are gone.
    pub(super) fn prune_motion(&mut self) {
        let scene = self.document.scene();
        let motion = &mut self.motion;
        motion.active = motion.active.filter(|id| scene.clip(*id).is_some());
        motion.active = motion.active.or(scene.clips.last().map(|clip| clip.id));
        motion.measured.retain(|id, _| scene.clip(*id).is_some());
        let length_s = self.play_seconds();
        self.motion.player.clamp(length_s);
    }
}
