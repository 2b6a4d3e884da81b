//! Sub-goals on the picture: a disc on the spot, an arrow where they face, a number, and while one is moved what is in
//! its way. Says what lies under the pointer.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, Ui, vec2};
use glam::Vec3;

use super::selection::Item;
use super::state::EditorState;
use super::theme::{self, Palette};
use crate::scene::GoalPose;
use crate::scene::SubGoal;
use crate::scene::direction_of;

/// Radius of a mark in points; one that the planner put in is smaller.
const WANTED: f32 = 9.0;
const PLANNED: f32 = 4.5;
/// A press so near to a mark is on it, points.
const GRIP: f32 = 12.0;
/// A number is dark on a mark lighter than this, and light on others.
const LIGHT: f32 = 0.45;
/// Length of the arrow, metres.
const ARROW_M: f32 = 0.42;

/// Where a point of the world is on the picture; nowhere behind the camera.
pub fn project(state: &EditorState, rect: Rect, point: Vec3) -> Option<Pos2> {
    let ndc = state.orbit.camera().clip_from_world(rect.width() / rect.height()).project_point3(point);
    let x = rect.left() + (ndc.x * 0.5 + 0.5) * rect.width();
    let y = rect.top() + (0.5 - ndc.y * 0.5) * rect.height();
    ((0.0..=1.0).contains(&ndc.z) && ndc.is_finite()).then(|| Pos2::new(x, y))
}

/// The sub-goal whose mark is under the pointer, those that somebody asked for first.
pub fn mark_at(state: &EditorState, rect: Rect, at: Pos2) -> Option<(Item, Vec3)> {
    let clip = state.active_clip().filter(|clip| clip.visible)?;
    let near = clip.goals.iter().filter_map(|goal| {
        let away = project(state, rect, goal.at)?.distance(at);
        (away < GRIP).then_some((goal.planned, away, goal))
    });
    let nearest = near.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)))?;
    Some((Item::Goal(clip.id, nearest.2.id), nearest.2.at))
}

/// Paints the marks of the active motion.
pub fn marks(ui: &Ui, state: &EditorState, rect: Rect, hovered: Option<Item>) {
    let painter = ui.painter().with_clip_rect(rect);
    let palette = theme::palette(ui.visuals());
    placing(&painter, state, rect, palette);
    let Some(clip) = state.active_clip().filter(|clip| clip.visible) else { return };
    let mut number = 0;
    for goal in &clip.goals {
        number += usize::from(!goal.planned);
        let item = Item::Goal(clip.id, goal.id);
        let marked = state.selection.contains(item) || hovered == Some(item);
        let blocked = matches!(&state.motion.reach, Some((of, Err(_))) if *of == item);
        let text = if goal.planned { String::new() } else { number.to_string() };
        let color = match () {
            () if blocked => palette.bad,
            () if goal.planned => Color32::from_gray(190),
            () => palette.accent,
        };
        mark(&painter, state, rect, goal, &Look { text, color, marked });
    }
    reach(&painter, state, rect);
}

struct Look {
    text: String,
    color: Color32,
    marked: bool,
}

fn mark(painter: &Painter, state: &EditorState, rect: Rect, goal: &SubGoal, look: &Look) {
    let Some(at) = project(state, rect, goal.at) else { return };
    if let Some(facing) = goal.facing {
        arrow(painter, state, rect, goal.at, facing, look.color);
    }
    let radius = if goal.planned { PLANNED } else { WANTED } + if look.marked { 2.0 } else { 0.0 };
    let edge = if look.marked { Color32::WHITE } else { Color32::from_black_alpha(200) };
    painter.circle(at, radius, look.color, Stroke::new(if look.marked { 2.0 } else { 1.2 }, edge));
    if goal.locked {
        painter.circle_stroke(at, radius + 3.0, Stroke::new(1.2, look.color));
    }
    let ink = if look.color.intensity() > LIGHT { Color32::from_gray(12) } else { Color32::WHITE };
    painter.text(at, Align2::CENTER_CENTER, &look.text, FontId::proportional(11.0), ink);
    if look.marked {
        label(painter, at + vec2(0.0, -radius - 8.0), &described(goal), Color32::WHITE);
    }
}

/// What is done at a sub-goal, in words.
pub fn described(goal: &SubGoal) -> String {
    let what = pose_label(goal.pose);
    let stay = if goal.stay_s > 0.0 { format!(", {:.1} s", goal.stay_s) } else { String::new() };
    let whose = if goal.planned { " (planned)" } else { "" };
    let locked = if goal.locked { ", locked" } else { "" };
    format!("{what}{stay}{locked}{whose}")
}

/// Name of a pose for people.
pub fn pose_label(pose: GoalPose) -> &'static str {
    match pose {
        GoalPose::Any => "whatever suits",
        GoalPose::Walk => "walk through",
        GoalPose::Stand => "stand",
        GoalPose::Sit => "sit",
        GoalPose::Lie => "lie",
    }
}

fn arrow(painter: &Painter, state: &EditorState, rect: Rect, at: Vec3, facing: f32, color: Color32) {
    let way = direction_of(facing);
    let way = Vec3::new(way.x, 0.0, way.y);
    let side = Vec3::new(-way.z, 0.0, way.x);
    let place = |p: Vec3| project(state, rect, p);
    let tip = at + way * ARROW_M;
    let corners = [at, tip, tip - way * 0.14 + side * 0.09, tip - way * 0.14 - side * 0.09].map(place);
    if let [Some(from), Some(tip), Some(left), Some(right)] = corners {
        painter.line_segment([from, tip], Stroke::new(2.5, color));
        painter.add(Shape::convex_polygon(vec![tip, left, right], color, Stroke::NONE));
    }
}

/// The sub-goal that is being placed.
fn placing(painter: &Painter, state: &EditorState, rect: Rect, palette: &Palette) {
    let Some(placing) = state.motion.placing else { return };
    let Some(at) = project(state, rect, placing.at) else { return };
    if let Some(facing) = placing.facing() {
        arrow(painter, state, rect, placing.at, facing, palette.accent);
    }
    painter.circle(at, WANTED, palette.accent, Stroke::new(2.0, Color32::WHITE));
}

/// Whether one gets to the sub-goal that was moved last, and what is in the way.
fn reach(painter: &Painter, state: &EditorState, rect: Rect) {
    let palette = theme::on_dark();
    let Some((Item::Goal(clip, id), answer)) = &state.motion.reach else { return };
    let Some(at) = state.goal(*clip, *id).and_then(|goal| project(state, rect, goal.at)) else { return };
    let (text, color) = match answer {
        Ok(()) => ("can be reached".to_owned(), palette.good),
        Err(why) => (why.clone(), palette.bad),
    };
    label(painter, at + vec2(0.0, 30.0), &text, color);
}

fn label(painter: &Painter, at: Pos2, text: &str, color: Color32) {
    let galley = painter.layout(text.to_owned(), FontId::proportional(12.0), color, 260.0);
    let place = Align2::CENTER_CENTER.anchor_size(at, galley.size());
    painter.rect_filled(place.expand(4.0), 4.0, Color32::from_black_alpha(190));
    painter.galley(place.min, galley, color);
}
