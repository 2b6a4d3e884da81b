//! A room that the program makes: its kind, its seed, a picture, and the button that opens it.

use egui::{DragValue, RichText, Sense, Ui, vec2};

use super::super::icons::{self, Icon};
use crate::app::state::EditorState;
use crate::app::theme;

/// Draws the page.
pub fn new_room(ui: &mut Ui, state: &mut EditorState) {
    let kinds = state.engine().room_kinds();
    if kinds.is_empty() {
        ui.weak("This program was built without the room maker.");
        return;
    }
    ui.label("Furnished by rules from real furniture models: every seed is another room.");
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        for (number, kind) in kinds.iter().enumerate() {
            let chosen = state.new_room.request.kind == number;
            if ui.selectable_label(chosen, kind).clicked() {
                state.new_room.request.kind = number;
            }
        }
    });
    ui.horizontal(|ui| {
        let label = ui.label("Seed");
        ui.add(DragValue::new(&mut state.new_room.request.seed).speed(0.05))
            .labelled_by(label.id)
            .on_hover_text("The same kind and seed give the same room.");
        if icons::button(ui, Icon::Dice, "Another one", 0.8).clicked() {
            state.new_room.request.seed = state.new_room.request.seed.wrapping_add(1);
        }
    });
    state.keep_new_room_fresh();
    picture(ui, state);
    facts(ui, state);
    open(ui, state);
}

fn picture(ui: &mut Ui, state: &EditorState) {
    let width = ui.available_width();
    match &state.new_room.made {
        Some(made) => {
            let size = vec2(width, width / made.picture.aspect().max(0.1));
            made.picture.show(ui, size, Sense::hover(), "The new room");
        }
        None => {
            let (rect, _) = ui.allocate_exact_size(vec2(width, width * 0.6), Sense::hover());
            ui.painter().rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
            if state.jobs.making_room() {
                let middle = egui::Rect::from_center_size(rect.center(), vec2(28.0, 28.0));
                egui::Spinner::new().size(28.0).paint_at(ui, middle);
            }
        }
    }
}

fn facts(ui: &mut Ui, state: &EditorState) {
    let text = match &state.new_room.made {
        Some(made) if made.request == state.new_room.request => {
            let summary = &made.opened.summary;
            let size = summary.extent_m;
            format!(
                "{:.1} x {:.1} m, {} objects, {} triangles",
                size.x, size.z, summary.objects, summary.triangles
            )
        }
        _ if state.jobs.making_room() => "Making it...".to_owned(),
        _ => String::new(),
    };
    ui.label(RichText::new(text).small().weak());
}

fn open(ui: &mut Ui, state: &mut EditorState) {
    let palette = theme::palette(ui.visuals());
    let ready = state.new_room.made.as_ref().is_some_and(|made| made.request == state.new_room.request);
    let text = RichText::new("Open this room").color(palette.on_accent);
    let button = egui::Button::new(text).fill(palette.accent);
    let size = [ui.available_width(), 30.0];
    let response = ui.add_enabled_ui(ready, |ui| ui.add_sized(size, button)).inner;
    if response.on_hover_text("Replaces the present room; Ctrl+Z brings that back.").clicked() {
        state.open_new_room();
    }
}
