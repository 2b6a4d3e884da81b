//! Why things are where they are, painted over the view: the places that were tried and the working zone.

use egui::{Color32, Rect, Stroke, Ui};
use glam::Vec3;

use super::goal_marks::project;
use super::state::EditorState;
use super::theme;
use crate::evolve::action::Verdict;

/// What can become of a place, and what that means.
pub const VERDICTS: [(Verdict, &str); 5] = [
    (Verdict::Taken, "taken"),
    (Verdict::Collides, "runs into something"),
    (Verdict::Overhangs, "too little under it"),
    (Verdict::InTheZone, "in the working zone"),
    (Verdict::NotTried, "not tried"),
];

/// Colour of a verdict.
pub fn color(verdict: Verdict) -> Color32 {
    match verdict {
        Verdict::Taken => Color32::from_rgb(72, 200, 140),
        Verdict::Collides => Color32::from_rgb(230, 90, 80),
        Verdict::Overhangs => Color32::from_rgb(236, 170, 60),
        Verdict::InTheZone => Color32::from_rgb(170, 120, 230),
        Verdict::NotTried => Color32::from_gray(170),
    }
}

/// Paints the marks of the action that is shown, if they are wanted.
pub fn marks(ui: &Ui, state: &EditorState, rect: Rect) {
    if !state.living.marks {
        return;
    }
    let Some(step) = state.life_now().and_then(|now| state.living.tree[now].step.as_ref()) else { return };
    let painter = ui.painter().with_clip_rect(rect);
    let (hull, height_m) = &step.zone;
    let corners: Option<Vec<_>> =
        hull.iter().map(|p| project(state, rect, Vec3::new(p.x, *height_m, p.y))).collect();
    if let Some(corners) = corners.filter(|corners| corners.len() > 2) {
        let accent = theme::palette(ui.visuals()).accent;
        let fill = accent.gamma_multiply(0.12);
        painter.add(egui::Shape::convex_polygon(corners, fill, Stroke::new(1.5, accent)));
    }
    let best = step.marks.iter().map(|m| m.score).fold(f32::MIN, f32::max);
    let least = step.marks.iter().map(|m| m.score).fold(f32::MAX, f32::min);
    let mut marks: Vec<_> = step.marks.iter().collect();
    // What is there now lies over what was only tried.
    marks.sort_by_key(|mark| mark.verdict == Verdict::Taken);
    for mark in marks {
        let Some(at) = project(state, rect, mark.at) else { continue };
        let share = (mark.score - least) / (best - least).max(1e-6);
        let taken = mark.verdict == Verdict::Taken;
        let radius = match mark.verdict {
            Verdict::Taken => 5.0,
            Verdict::NotTried => 1.0,
            _ => 1.2 + 1.6 * share,
        };
        let edge = if taken { Stroke::new(1.5, Color32::WHITE) } else { Stroke::NONE };
        painter.circle(at, radius, color(mark.verdict).gamma_multiply(if taken { 1.0 } else { 0.8 }), edge);
        if taken {
            let place = at + egui::vec2(9.0, 0.0);
            let font = egui::FontId::proportional(11.0);
            let galley = painter.layout_no_wrap(mark.object.clone(), font, Color32::WHITE);
            let area = egui::Align2::LEFT_CENTER.anchor_size(place, galley.size());
            painter.rect_filled(area.expand(2.0), 3.0, Color32::from_black_alpha(150));
            painter.galley(area.min, galley, Color32::WHITE);
        }
    }
}
