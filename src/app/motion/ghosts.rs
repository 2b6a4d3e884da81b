//! Figures at sub-goals and along the way: who is drawn but not there.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{GoalFigure, GoalFigures, Trail};
use crate::app::selection::Item;
use crate::app::state::EditorState;
use crate::scene::BETAS;
use crate::scene::Clip;
use crate::scene::ClipId;
use crate::scene::Frame;
use crate::scene::GoalPose;
use crate::scene::SubGoal;
use crate::scene::SubGoalId;

/// Seconds between the figures of a trail.
const APART_S: f32 = 0.5;
/// Figures before now, and as many after.
const FIGURES: i32 = 3;

/// Place holders, made once for each place.
pub type StandIns = BTreeMap<(ClipId, SubGoalId), (SubGoal, [f32; BETAS], Frame)>;

impl EditorState {
    /// Puts somebody at each sub-goal of the active motion, as far as figures are wanted, for the view.
    pub fn place_figures(&mut self) {
        self.motion.shown_figures = self.goal_figures();
    }

    fn goal_figures(&mut self) -> Vec<GoalFigure> {
        let Some(clip) = self.active_clip().filter(|clip| clip.visible).cloned() else {
            self.motion.stand_ins.clear();
            return Vec::new();
        };
        let which = self.motion.figures;
        let chosen = |goal: &&SubGoal| {
            let selected = self.selection.contains(Item::Goal(clip.id, goal.id));
            selected
                || match which {
                    GoalFigures::Off => false,
                    GoalFigures::Wanted => !goal.planned && goal.pose != GoalPose::Walk,
                    GoalFigures::All => true,
                }
        };
        let goals: Vec<SubGoal> = clip.goals.iter().filter(chosen).cloned().collect();
        goals.iter().map(|goal| self.goal_figure(&clip, goal)).collect()
    }

    fn goal_figure(&mut self, clip: &Clip, goal: &SubGoal) -> GoalFigure {
        let frame = match &goal.body {
            Some(frame) => frame.clone(),
            None => self.stand_in(clip, goal),
        };
        let item = Item::Goal(clip.id, goal.id);
        GoalFigure { item, betas: clip.betas, frame, palette: clip.palette, stand_in: goal.body.is_none() }
    }

    fn stand_in(&mut self, clip: &Clip, goal: &SubGoal) -> Frame {
        let key = (clip.id, goal.id);
        match self.motion.stand_ins.get(&key) {
            Some((of, betas, frame)) if of == goal && *betas == clip.betas => frame.clone(),
            _ => {
                let frame = self.engine.stand_in(goal, &clip.betas);
                self.motion.stand_ins.insert(key, (goal.clone(), clip.betas, frame.clone()));
                frame
            }
        }
    }

    /// Frames before and after now of the active motion, and how much is seen of each.
    pub fn trail_figures(&self) -> Vec<(Arc<Clip>, usize, f32)> {
        let clip = self.shown_clips().into_iter().find(|clip| Some(clip.id) == self.motion.active);
        let Some(clip) = clip.filter(|_| self.motion.trail == Trail::Figures) else { return Vec::new() };
        let Some(now) = self.frame_now(&clip) else { return Vec::new() };
        let apart = (APART_S * clip.fps).round() as i64;
        // Figures stand at fixed times, so that they don't run along with the one who moves.
        let base = (now as i64 / apart.max(1)) * apart;
        let frames = (-FIGURES..=FIGURES + 1).map(|i| base + i64::from(i) * apart);
        frames
            .filter_map(|frame| usize::try_from(frame).ok().filter(|f| *f < clip.frames.len() && *f != now))
            .map(|frame| {
                let away = frame.abs_diff(now) as f32 / (apart as f32 * (FIGURES + 1) as f32);
                (clip.clone(), frame, 0.4 * (1.0 - away).max(0.12))
            })
            .collect()
    }
}
