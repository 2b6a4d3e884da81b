//! The objects of the room, grouped by category.

use std::collections::BTreeMap;

use egui::{CollapsingHeader, Response, ScrollArea, Ui};

use super::empty;
use crate::app::actions;
use crate::app::icons::{self, Icon};
use crate::app::selection::Item;
use crate::app::state::EditorState;
use crate::document::Command;
use crate::scene::Category;
use crate::scene::ObjectId;

/// What a row needs to know of an object.
struct Row {
    id: ObjectId,
    name: String,
    visible: bool,
    locked: bool,
}

/// Draws the outliner.
pub fn outliner(ui: &mut Ui, state: &mut EditorState) {
    if !state.has_room() {
        empty(ui, "No room is open.");
        return;
    }
    let mut groups: BTreeMap<Category, Vec<Row>> = BTreeMap::new();
    for object in &state.document.scene().room.objects {
        let (id, name) = (object.id, object.name.clone());
        let row = Row { id, name, visible: object.visible, locked: object.locked };
        groups.entry(object.category).or_default().push(row);
    }
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for (category, rows) in groups {
            let title = format!("{} ({})", capitalised(category.label()), rows.len());
            CollapsingHeader::new(title)
                .id_salt(("category", category))
                .default_open(!category.is_structure() && rows.len() < 30)
                .show(ui, |ui| rows.into_iter().for_each(|row| object_row(ui, state, &row, category)));
        }
    });
}

fn object_row(ui: &mut Ui, state: &mut EditorState, row: &Row, category: Category) {
    let item = Item::Object(row.id);
    let response = item_row(ui, state, item, &row.name, row.visible, row.locked);
    response.context_menu(|ui| {
        ui.menu_button("Category", |ui| category_menu(ui, state, row.id, category));
        for (label, action) in ITEM_ACTIONS {
            if ui.button(*label).clicked() {
                select_if_needed(state, item);
                action(state);
                ui.close();
            }
        }
    });
}

type Action = fn(&mut EditorState);

/// What the context menu of a row offers.
pub const ITEM_ACTIONS: &[(&str, Action)] = &[
    ("Rename", actions::rename),
    ("Frame", actions::frame_selection),
    ("Isolate", actions::isolate),
    ("Duplicate", actions::duplicate),
    ("Remove", actions::delete),
];

/// Selects `item` unless it is part of the selection already.
pub fn select_if_needed(state: &mut EditorState, item: Item) {
    if !state.selection.contains(item) {
        state.selection.only(item);
    }
}

/// A row with eye, lock and a name that can be clicked, shift-clicked and double-clicked.
pub fn item_row(
    ui: &mut Ui,
    state: &mut EditorState,
    item: Item,
    name: &str,
    visible: bool,
    locked: bool,
) -> Response {
    ui.horizontal(|ui| {
        eye_and_lock(ui, state, item, name, visible, locked);
        let selected = state.selection.contains(item);
        let mut text = egui::RichText::new(name);
        if !visible {
            text = text.weak();
        }
        let width = ui.available_width();
        let label = (text, egui::Atom::grow());
        let button = egui::Button::selectable(selected, label).truncate().min_size(egui::vec2(width, 20.0));
        let response = ui.add(button);
        if response.clicked() {
            if ui.input(|i| i.modifiers.shift || i.modifiers.command) {
                state.selection.toggle(item);
            } else {
                state.selection.only(item);
            }
        }
        if response.double_clicked() {
            actions::frame_item(state, item);
        }
        response
    })
    .inner
}

fn eye_and_lock(ui: &mut Ui, state: &mut EditorState, item: Item, name: &str, visible: bool, locked: bool) {
    ui.spacing_mut().item_spacing.x = 2.0;
    let (eye, verb) = if visible { (Icon::Eye, "Hide") } else { (Icon::EyeClosed, "Show") };
    if icons::button(ui, eye, &format!("{verb} {name}"), 0.45).clicked() {
        state.apply(match item {
            Item::Person(id) => Command::SetPeopleVisible(vec![id], !visible),
            Item::Object(id) => Command::SetObjectsVisible(vec![id], !visible),
            Item::Clip(id) | Item::Goal(id, _) => Command::SetClipsVisible(vec![id], !visible),
        });
    }
    let (lock, verb, strength) =
        if locked { (Icon::Lock, "Unlock", 0.9) } else { (Icon::Unlock, "Lock", 0.25) };
    if icons::button(ui, lock, &format!("{verb} {name}"), strength).clicked() {
        state.apply(match item {
            Item::Person(id) => Command::SetPeopleLocked(vec![id], !locked),
            Item::Object(id) => Command::SetObjectsLocked(vec![id], !locked),
            Item::Clip(id) | Item::Goal(id, _) => Command::SetClipsLocked(vec![id], !locked),
        });
    }
}

/// Every category as a menu; the present one is marked.
pub fn category_menu(ui: &mut Ui, state: &mut EditorState, id: ObjectId, present: Category) {
    ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
        for category in Category::ALL {
            let label = capitalised(category.label());
            if ui.selectable_label(category == present, label).clicked() {
                state.apply(Command::SetCategory(vec![id], category));
                ui.close();
            }
        }
    });
}

/// The text with its first letter as a capital.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}
