//! The menu bar.

use std::path::PathBuf;

use egui::{Button, RichText, Ui};

use super::tip;
use crate::app::actions;
use crate::app::commands::{self, COMMANDS, Menu};
use crate::app::engine::Source;
use crate::app::icons::{self, Icon};
use crate::app::state::EditorState;
use crate::app::theme;

/// Draws the menus from the command table, and the bell.
pub fn menu_bar(ui: &mut Ui, state: &mut EditorState) {
    egui::MenuBar::new().ui(ui, |ui| {
        ui.label(RichText::new("Inhabit").strong().color(theme::palette(ui.visuals()).accent));
        ui.add_space(6.0);
        for menu in Menu::ALL {
            ui.menu_button(menu.label(), |ui| menu_entries(ui, state, menu));
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| bell(ui, state));
    });
}

fn menu_entries(ui: &mut Ui, state: &mut EditorState, menu: Menu) {
    ui.set_min_width(230.0);
    for command in COMMANDS.iter().filter(|c| c.menu == menu) {
        let key = command.keys.first().map(commands::key_text).unwrap_or_default();
        let enabled = (command.enabled)(state);
        let button = Button::new(command.label).shortcut_text(key);
        let response = ui.add_enabled(enabled, button).on_hover_text(tip(command));
        if response.clicked() {
            (command.run)(state);
            ui.close();
        }
        if command.id == "sample" {
            file_lists(ui, state);
        }
    }
}

/// The sample rooms and the recent files.
fn file_lists(ui: &mut Ui, state: &mut EditorState) {
    let samples = state.engine().samples();
    ui.menu_button("Sample rooms", |ui| {
        for (number, name) in samples.iter().enumerate() {
            if ui.button(name).clicked() {
                state.open(Source::Sample(number));
                ui.close();
            }
        }
    });
    let recent: Vec<PathBuf> = state.recent.clone();
    ui.add_enabled_ui(!recent.is_empty(), |ui| {
        ui.menu_button("Recent files", |ui| {
            for path in recent {
                if ui.button(path.display().to_string()).clicked() {
                    actions::open_file(state, path);
                    ui.close();
                }
            }
        });
    });
}

fn bell(ui: &mut Ui, state: &mut EditorState) {
    let unread = state.notices.unread();
    let name = if unread == 0 { "Notifications".to_owned() } else { format!("Notifications: {unread} new") };
    if icons::button(ui, Icon::Bell, &name, 0.7).clicked() {
        actions::show_notifications(state);
    }
    if unread > 0 {
        ui.label(RichText::new(unread.to_string()).small().color(theme::palette(ui.visuals()).accent));
    }
}
