//! Who is drawn by frames of motions: those who move, the figures at sub-goals, the figures of a trail; and the way
//! as a line along the floor.

use std::sync::Arc;

use super::motion::Trail;
use super::selection::Item;
use super::state::EditorState;
use crate::render::DepthTest;
use crate::render::Line;
use crate::scene::BETAS;
use crate::scene::Clip;
use crate::scene::Frame;

/// Numbers of those who move, of figures and of trails lie apart from those of people, who count from 0, and of
/// ghosts.
const MOVER_IDS: u32 = 1 << 30;
const FIGURE_IDS: u32 = 1 << 29;
const TRAIL_IDS: u32 = 1 << 28;
/// How much is seen of a sub-goal's figure, and of one that only holds the place.
const FIGURE_ALPHA: f32 = 0.5;
const STAND_IN_ALPHA: f32 = 0.32;
/// The line is made of every so many frames: a tenth of a second.
const LINE_STRIDE: usize = 3;
/// The line lies so far above the floor, metres.
const ABOVE_M: f32 = 0.015;

/// Somebody who is drawn as in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Actor {
    /// Names the buffers on the graphics card.
    pub id: u32,
    /// Body shape.
    pub betas: [f32; BETAS],
    /// The body.
    pub frame: Frame,
    /// Colours of the clothes.
    pub palette: u32,
    /// 1 solid.
    pub alpha: f32,
    /// Drawn with the selection's outline.
    pub selected: bool,
}

/// Everybody of [`Actor`]'s kind that the view shows now.
pub fn actors(state: &EditorState, hovered: Option<Item>) -> Vec<Actor> {
    let marked = |item: Item| state.selection.contains(item) || hovered == Some(item);
    let of = |clip: &Clip, frame: usize, id: u32, alpha: f32, selected: bool| Actor {
        id,
        betas: clip.betas,
        frame: clip.frames[frame].clone(),
        palette: clip.palette,
        alpha,
        selected,
    };
    let clips = state.shown_clips();
    let movers = clips.iter().filter_map(|clip| {
        let frame = state.frame_now(clip)?;
        Some(of(clip, frame, MOVER_IDS + clip.id.0, 1.0, marked(Item::Clip(clip.id))))
    });
    let mut all: Vec<Actor> = movers.collect();
    for (i, figure) in state.motion.shown_figures.iter().enumerate() {
        let (betas, frame, palette) = (figure.betas, figure.frame.clone(), figure.palette);
        let alpha = if figure.stand_in { STAND_IN_ALPHA } else { FIGURE_ALPHA };
        let id = FIGURE_IDS + i as u32;
        all.push(Actor { id, betas, frame, palette, alpha, selected: marked(figure.item) });
    }
    for (i, (clip, frame, alpha)) in state.trail_figures().into_iter().enumerate() {
        all.push(of(&clip, frame, TRAIL_IDS + i as u32, alpha, false));
    }
    all
}

/// The motion whose way is drawn.
fn on_its_way(state: &EditorState) -> Option<Arc<Clip>> {
    let active = |clip: &Arc<Clip>| Some(clip.id) == state.motion.active && !clip.frames.is_empty();
    state.shown_clips().into_iter().find(active).filter(|_| state.motion.trail != Trail::Off)
}

/// Tells ways apart without looking at them.
pub fn way_key(state: &EditorState) -> (usize, Trail) {
    (on_its_way(state).map_or(0, |clip| Arc::as_ptr(&clip).addr()), state.motion.trail)
}

/// The way of the active motion: what lies behind strong, what comes pale.
pub fn way(state: &EditorState) -> Vec<Line> {
    let Some(clip) = on_its_way(state) else { return Vec::new() };
    let now = state.frame_now(&clip).unwrap_or(0);
    let height_m = clip.goals.iter().map(|goal| goal.at.y).fold(f32::INFINITY, f32::min);
    let height_m = if height_m.is_finite() { height_m } else { 0.0 } + ABOVE_M;
    let stops: Vec<usize> = (0..clip.frames.len()).step_by(LINE_STRIDE).collect();
    let color = |frame: usize| if frame < now { [64, 190, 176, 255] } else { [160, 168, 176, 190] };
    let line = |pair: &[usize]| Line {
        from: clip.frames[pair[0]].translation.with_y(height_m),
        to: clip.frames[pair[1]].translation.with_y(height_m),
        color: color(pair[0]),
        width_px: 3.0,
        depth: DepthTest::Hidden,
    };
    stops.windows(2).map(line).collect()
}
