//! The status bar: what the mouse does now, what runs, and what is in the scene.

use egui::{Align, Layout, RichText, Ui};

use super::jobs::{details, progress_bar};
use crate::app::state::{EditorState, Tool};

/// What the renderer has to say for the status bar.
#[derive(Clone, Debug, Default)]
pub struct RenderStatus {
    /// Name of the graphics adapter; empty without one.
    pub adapter: String,
    /// Milliseconds that the last frame took.
    pub frame_ms: f32,
}

/// Draws the bar.
pub fn status_bar(ui: &mut Ui, state: &mut EditorState, render: &RenderStatus) {
    ui.horizontal(|ui| {
        let text = state
            .transform
            .as_ref()
            .map_or_else(|| hint(state).to_owned(), super::super::transform::Transform::text);
        ui.label(RichText::new(text).small());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            facts(ui, state, render);
            if let Some(row) = state.jobs.rows().into_iter().next() {
                ui.separator();
                ui.scope(|ui| {
                    ui.set_max_width(120.0);
                    progress_bar(ui, &row);
                });
                let text = format!("{}: {}", row.name, row.progress.stage);
                ui.label(RichText::new(text).small()).on_hover_text(details(&row));
            }
        });
    });
}

fn facts(ui: &mut Ui, state: &EditorState, render: &RenderStatus) {
    let scene = state.document.scene();
    if !render.adapter.is_empty() {
        let text = format!("{:.0} ms", render.frame_ms);
        ui.label(RichText::new(text).small().weak()).on_hover_text(&render.adapter);
        ui.separator();
    }
    let people = scene.people.len();
    let people = format!("{people} {}", if people == 1 { "person" } else { "people" });
    ui.label(RichText::new(people).small().weak());
    ui.separator();
    let triangles = format!("{} triangles", grouped(scene.room.triangle_count()));
    ui.label(RichText::new(triangles).small().weak());
    if state.document.is_dirty() {
        ui.separator();
        ui.label(RichText::new("not saved").small().weak());
    }
}

fn hint(state: &EditorState) -> &'static str {
    match state.tool {
        _ if !state.has_room() => "Open a room or drop a file here. Ctrl+K finds every command.",
        Tool::PutHere => "Click a seat, a bed or the floor: somebody appears there. Esc ends.",
        Tool::AddGoal => {
            "Click where somebody should be; drag to say which way they face. A click on a seat or bed is to sit or lie. Esc ends."
        }
        Tool::Select if !state.selection.goals().is_empty() => {
            "Drag or G: move   R: turn   F9: another body   L: lock   X: remove   Ctrl+Shift+Enter: synthesise   Space: play"
        }
        Tool::Select if state.selection.is_empty() => {
            "Click: select   Middle drag: turn   Shift+middle: move   Wheel: zoom   Right drag: look, WASD: fly   F1: help"
        }
        Tool::Select => {
            "G: move   R: turn   T: settle   F: frame   X: remove   L: lock   F9: re-roll   M: heat map   Shift+W: why like this"
        }
    }
}

/// A number with thin groups of three digits.
fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_numbers_are_read_in_groups() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_234_567), "1 234 567");
    }
}
