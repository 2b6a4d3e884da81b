//! A person out of a photo: paths, how it lies over the view, and the button that finds the person.

use egui::{Button, RichText, ScrollArea, Slider, TextEdit, Ui};

use super::title;
use crate::app::engine::PhotoMethod;
use crate::app::jobs::JobKind;
use crate::app::state::EditorState;
use crate::app::theme;

/// Draws the panel.
pub fn photo(ui: &mut Ui, state: &mut EditorState) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.label(
            RichText::new(
                "Finds a person of a photo in this room. The view has to look as the photo's camera did.",
            )
            .small()
            .weak(),
        );
        files(ui, state);
        if state.photo.photo.is_some() {
            over_the_view(ui, state);
            estimator(ui, state);
            button(ui, state);
        }
    });
}

fn files(ui: &mut Ui, state: &mut EditorState) {
    for (name, hint, keypoints) in
        [("Photo", "PNG or JPEG", false), ("Keypoints", "COCO or OpenPose json", true)]
    {
        ui.horizontal(|ui| {
            let label = ui.add_sized([66.0, 20.0], egui::Label::new(name).halign(egui::Align::LEFT));
            let path =
                if keypoints { &mut state.photo.keypoints_path } else { &mut state.photo.picture_path };
            let width = ui.available_width() - 62.0;
            ui.add(TextEdit::singleline(path).hint_text(hint).desired_width(width)).labelled_by(label.id);
            let browse = ui.button("...").on_hover_text(format!("Choose the {} file", name.to_lowercase()));
            browse.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::Button, true, format!("Choose {}", name.to_lowercase()))
            });
            if browse.clicked() {
                state.requests.photo_dialog = Some(keypoints);
            }
        });
    }
    let ready = !state.photo.picture_path.trim().is_empty() && !state.photo.keypoints_path.trim().is_empty();
    ui.horizontal(|ui| {
        if ui.add_enabled(ready, Button::new("Open photo")).clicked() {
            state.open_photo();
        }
        if state.photo.photo.is_some() && ui.button("Close photo").clicked() {
            state.close_photo();
        }
    });
}

fn over_the_view(ui: &mut Ui, state: &mut EditorState) {
    title(ui, "Over the view");
    egui::Grid::new("photo view").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let label = ui.label("Photo");
        ui.add(Slider::new(&mut state.photo.opacity, 0.0..=1.0).show_value(false))
            .labelled_by(label.id)
            .on_hover_text("How much of the photo is seen over the room.");
        ui.end_row();
        let label = ui.label("Lens");
        let mut degrees = state.orbit.fov_y.to_degrees();
        let slider = Slider::new(&mut degrees, 20.0..=100.0).suffix("°");
        let response = ui.add(slider).labelled_by(label.id);
        if response.on_hover_text("Vertical angle of the view; phones have about 50°.").changed() {
            state.orbit.fov_y = degrees.to_radians();
        }
        ui.end_row();
        let people = state.photo.photo.as_ref().map_or(0, |photo| photo.people.len());
        if people > 1 {
            let label = ui.label("Person");
            ui.add(Slider::new(&mut state.photo.person, 0..=people - 1)).labelled_by(label.id);
            ui.end_row();
        }
    });
    ui.label(
        RichText::new("Turn and move the view until walls and furniture lie on those of the photo.")
            .small()
            .weak(),
    );
}

fn estimator(ui: &mut Ui, state: &mut EditorState) {
    title(ui, "How");
    for (kind, label, tip) in [
        (
            PhotoMethod::Scene,
            "Room and what people do here",
            "Keypoints, contact with the room, and poses that the network expects in this view (PSI 4.2).",
        ),
        (
            PhotoMethod::Room,
            "Room",
            "Keypoints and contact with the room: no sinking in, no hovering (PROX).",
        ),
        (PhotoMethod::Keypoints, "Keypoints alone", "As if there were no room (SMPLify-X)."),
    ] {
        ui.radio_value(&mut state.photo.method, kind, label).on_hover_text(tip);
    }
}

fn button(ui: &mut Ui, state: &mut EditorState) {
    let palette = theme::palette(ui.visuals());
    let size = [ui.available_width(), 32.0];
    ui.add_space(4.0);
    if state.jobs.populating() {
        if ui.add_sized(size, Button::new("Cancel fitting")).clicked() {
            state.cancel(JobKind::Populate);
        }
        return;
    }
    let text = RichText::new("Fit to photo").size(14.0).color(palette.on_accent);
    let ready = state.geometry().is_some() && state.photo_keypoints().is_some();
    let button = Button::new(text).fill(palette.accent);
    let response = ui.add_enabled_ui(ready, |ui| ui.add_sized(size, button)).inner;
    let why_not = "Needs a room that is analysed and somebody with keypoints.";
    if response
        .on_hover_text("Finds the body and puts it into the room.")
        .on_disabled_hover_text(why_not)
        .clicked()
    {
        state.fit_photo();
    }
}
