//! The panels around the viewport. Each is a function of the editor's state that draws itself and sends
//! commands; none keeps anything of its own.

mod drop_hint;
mod energies;
mod findings;
mod inspector;
mod jobs;
mod learned;
mod living;
mod menu;
mod motion;
mod networks;
mod new_room;
mod outliner;
mod overlays;
mod people;
mod photo;
mod populate;
mod sample;
mod sheet;
mod status;
mod study;
mod things;
mod timeline;
mod toasts;
mod welcome;
mod why;

pub use drop_hint::drop_hint;
pub use energies::energies;
pub use findings::findings;
pub use inspector::inspector;
pub use jobs::jobs;
pub use living::living;
pub use menu::menu_bar;
pub use motion::motion;
pub use outliner::outliner;
pub use overlays::{overlays, with_project_extension};
pub use people::people;
pub use photo::photo;
pub use populate::populate;
pub use sample::sample;
pub use sheet::sheet;
pub use status::{RenderStatus, status_bar};
pub use study::study_bar;
pub use things::{THING_FILES, may_be_a_thing};
pub use timeline::timeline;
pub use toasts::toasts;
pub use welcome::welcome;
pub use why::why;

use egui::{Response, RichText, Ui};

use super::commands;
use super::state::EditorState;

/// A button for the command called `id`: its label, its key in the tooltip, grey when it is not possible.
pub fn command_button(ui: &mut Ui, state: &mut EditorState, id: &str) -> Option<Response> {
    let command = commands::find(id)?;
    let enabled = (command.enabled)(state);
    let response = ui.add_enabled(enabled, egui::Button::new(command.label));
    let response = response.on_hover_text(tip(command)).on_disabled_hover_text(tip(command));
    if response.clicked() {
        (command.run)(state);
    }
    Some(response)
}

/// An entry of a context menu for the command called `id`; whether it was chosen.
pub fn menu_entry(ui: &mut Ui, state: &mut EditorState, id: &str) -> bool {
    let Some(command) = commands::find(id) else { return false };
    let key = command.keys.first().map(commands::key_text).unwrap_or_default();
    let button = egui::Button::new(command.label).shortcut_text(key);
    let chosen = ui.add_enabled((command.enabled)(state), button).on_hover_text(command.tip).clicked();
    if chosen {
        (command.run)(state);
    }
    chosen
}

/// What a command does, and its key.
pub fn tip(command: &commands::CommandInfo) -> String {
    match command.keys.first() {
        Some(key) => format!("{} ({})", command.tip, commands::key_text(key)),
        None => command.tip.to_owned(),
    }
}

/// A section's title.
pub fn title(ui: &mut Ui, text: &str) {
    ui.add_space(2.0);
    ui.label(RichText::new(text.to_uppercase()).small().weak());
}

/// What a panel says while it has nothing to show.
pub fn empty(ui: &mut Ui, text: &str) {
    ui.add_space(12.0);
    ui.vertical_centered(|ui| ui.weak(text));
}
