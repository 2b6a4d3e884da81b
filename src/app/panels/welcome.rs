//! What is seen before a room is open.

use std::path::PathBuf;

use egui::{Align, Button, Layout, RichText, Ui};

use crate::app::actions;
use crate::app::engine::Source;
use crate::app::state::EditorState;
use crate::app::theme;

/// Draws the page.
pub fn welcome(ui: &mut Ui, state: &mut EditorState) {
    let width = ui.available_width().min(620.0);
    let side = (ui.available_width() - width) * 0.5;
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.horizontal_top(|ui| {
            ui.add_space(side);
            ui.with_layout(Layout::top_down(Align::Min), |ui| {
                ui.set_max_width(width);
                ui.add_space((ui.ctx().content_rect().height() * 0.14).min(120.0));
                ui.label(RichText::new("Inhabit").size(34.0).strong());
                ui.label(RichText::new("Puts people into rooms, with real contact.").size(15.0).weak());
                ui.add_space(20.0);
                samples(ui, state);
                ui.add_space(16.0);
                own_files(ui, state);
                ui.add_space(16.0);
                steps(ui);
            });
        });
    });
}

fn samples(ui: &mut Ui, state: &mut EditorState) {
    let names = state.engine().samples();
    if names.is_empty() {
        return;
    }
    super::title(ui, "Start with a sample room");
    let accent = theme::palette(ui.visuals());
    ui.horizontal_wrapped(|ui| {
        for (number, name) in names.iter().enumerate() {
            let (fill, text) = if number == 0 {
                (accent.accent, accent.on_accent)
            } else {
                (ui.visuals().widgets.inactive.bg_fill, ui.visuals().widgets.inactive.text_color())
            };
            let button = Button::new(RichText::new(name).size(14.0).color(text)).fill(fill);
            if ui.add_sized([150.0, 40.0], button).clicked() {
                state.open(Source::Sample(number));
            }
        }
    });
}

fn own_files(ui: &mut Ui, state: &mut EditorState) {
    super::title(ui, "Or bring your own");
    ui.horizontal(|ui| {
        super::command_button(ui, state, "open");
        super::command_button(ui, state, "open-path");
        ui.weak("or drop a GLB, glTF, OBJ, PLY or project file anywhere.");
    });
    let recent: Vec<PathBuf> = state.recent.iter().take(5).cloned().collect();
    for path in recent {
        let text = path.display().to_string();
        let button = Button::new(text).frame(false).truncate();
        if ui.add(button).on_hover_text("Open this file").clicked() {
            actions::open_file(state, path);
        }
    }
}

fn steps(ui: &mut Ui) {
    super::title(ui, "Then");
    for (number, step) in [
        "Look around: middle drag turns, the wheel zooms to the cursor, right drag with WASD flies.",
        "Press Populate: people sit, stand and lie where the room lets them.",
        "Press M to see where bodies touch and where they sink in; N goes to the worst.",
        "Press Ctrl+K to find any command.",
    ]
    .iter()
    .enumerate()
    {
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(format!("{}", number + 1)).strong());
            ui.label(*step);
        });
    }
}
