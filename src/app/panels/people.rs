//! The people in the room.

use egui::{RichText, ScrollArea, Ui};

use super::outliner::{ITEM_ACTIONS, item_row, select_if_needed};
use super::{command_button, empty};
use crate::app::selection::Item;
use crate::app::state::EditorState;
use crate::app::theme;

/// Draws the list.
pub fn people(ui: &mut Ui, state: &mut EditorState) {
    ui.horizontal(|ui| {
        command_button(ui, state, "put-here");
        command_button(ui, state, "re-roll");
    });
    let people = state.document.scene().people.clone();
    if people.is_empty() {
        empty(ui, "Nobody is here yet.");
        return;
    }
    let findings = state.findings();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for person in people {
            let item = Item::Person(person.id);
            let failing = findings.iter().any(|f| f.site.body == person.id.0);
            let place = format!("{}, {}", person.family.label(), person.on);
            let name = if failing { format!("! {}", person.name) } else { person.name.clone() };
            let response = item_row(ui, state, item, &name, person.visible, person.locked);
            response.clone().on_hover_text(&place).context_menu(|ui| {
                for (label, action) in ITEM_ACTIONS {
                    if ui.button(*label).clicked() {
                        select_if_needed(state, item);
                        action(state);
                        ui.close();
                    }
                }
            });
            let color =
                if failing { theme::palette(ui.visuals()).bad } else { ui.visuals().weak_text_color() };
            ui.painter().text(
                response.rect.right_center() - egui::vec2(6.0, 0.0),
                egui::Align2::RIGHT_CENTER,
                person.family.label(),
                egui::FontId::proportional(11.0),
                color,
            );
        }
        let count = state.document.scene().people.len();
        let people = if count == 1 { "1 person".to_owned() } else { format!("{count} people") };
        let found =
            if findings.len() == 1 { "1 finding".to_owned() } else { format!("{} findings", findings.len()) };
        ui.label(RichText::new(format!("{people}, {found}")).small().weak());
    });
}
