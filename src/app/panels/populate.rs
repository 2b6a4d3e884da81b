//! What to generate, and the button that does it.

use egui::{Button, DragValue, RichText, Ui};

use super::title;
use crate::app::actions;
use crate::app::jobs::JobKind;
use crate::app::state::{EditorState, Tool};
use crate::app::theme;
use crate::scene::PoseFamily;

/// Draws the panel.
pub fn populate(ui: &mut Ui, state: &mut EditorState) {
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        numbers(ui, state);
        ui.add_space(2.0);
        buttons(ui, state);
        title(ui, "What they do");
        families(ui, state);
        title(ui, "By hand");
        ui.checkbox(&mut state.populate.settle, "Settle after moving").on_hover_text(
            "People whom you move (G) or turn (R) are fitted to where they are then. T does it at any time.",
        );
    });
}

fn numbers(ui: &mut Ui, state: &mut EditorState) {
    egui::Grid::new("populate numbers").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let label = ui.label("People");
        ui.add(egui::Slider::new(&mut state.populate.people, 1..=30)).labelled_by(label.id);
        ui.end_row();
        let label = ui.label("Seed");
        ui.add(DragValue::new(&mut state.populate.seed).range(0..=u64::MAX).speed(0.05))
            .labelled_by(label.id)
            .on_hover_text("The same seed gives the same people, bit by bit.");
        ui.end_row();
        ui.label("Method");
        ui.label("Affordance search").on_hover_text(
            "Looks for places where a body is held: seats, beds, free floor, walls and tables to lean on.",
        );
        ui.end_row();
    });
}

fn families(ui: &mut Ui, state: &mut EditorState) {
    ui.columns(2, |columns| {
        for (i, family) in PoseFamily::ALL.into_iter().enumerate() {
            let ui = &mut columns[i * 2 / PoseFamily::ALL.len()];
            let mut on = state.populate.families.contains(&family);
            if ui.checkbox(&mut on, family.label()).changed() {
                if on {
                    state.populate.families.insert(family);
                } else {
                    state.populate.families.remove(&family);
                }
            }
        }
    });
    ui.horizontal(|ui| {
        if ui.small_button("All families").clicked() {
            state.populate.families = PoseFamily::ALL.into_iter().collect();
        }
        if ui.small_button("No family").clicked() {
            state.populate.families.clear();
        }
    });
}

fn buttons(ui: &mut Ui, state: &mut EditorState) {
    let palette = theme::palette(ui.visuals());
    let width = ui.available_width();
    if state.jobs.populating() {
        let waiting = state.jobs.waiting();
        let text = if waiting { "Cancel (waits for the room analysis)" } else { "Cancel" };
        if ui.add_sized([width, 32.0], Button::new(text)).clicked() {
            state.cancel(JobKind::Populate);
        }
        return;
    }
    let ready = state.has_room() && !state.populate.families.is_empty();
    let text = RichText::new("Populate").size(14.0).color(palette.on_accent);
    let button = Button::new(text).fill(palette.accent);
    let hint = "Puts people into the room (Ctrl+Enter)";
    let why_not =
        if state.has_room() { "Choose at least one thing that people may do." } else { "Open a room first." };
    let response = ui.add_enabled_ui(ready, |ui| ui.add_sized([width, 32.0], button)).inner;
    if response.on_hover_text(hint).on_disabled_hover_text(why_not).clicked() {
        actions::populate(state);
    }
    ui.horizontal(|ui| {
        let placing = state.tool == Tool::PutHere;
        let button = Button::new("Put somebody here").selected(placing);
        if ui.add_enabled(ready, button).on_hover_text("Then click a spot (Shift+A)").clicked() {
            actions::put_here(state);
        }
        super::command_button(ui, state, "re-roll");
    });
}
