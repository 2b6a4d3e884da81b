//! Why a person is where it is: what the sampler saw, what it proposed, and what the fit made of it.

use egui::{Color32, Rect, RichText, ScrollArea, Sense, Ui, vec2};

use super::{empty, title};
use crate::app::engine::SampleMethod;
use crate::app::pictures::{kinds_seen, label_color};
use crate::app::samples::{Origin, Seen};
use crate::app::state::EditorState;
use crate::scene::Person;

/// Kinds of things that the legend names; the rest is small.
const NAMED: usize = 10;

/// Draws the panel.
pub fn why(ui: &mut Ui, state: &mut EditorState) {
    let active = state.selection.active_person();
    let Some(person) = active.and_then(|id| state.document.scene().person(id)).cloned() else {
        empty(ui, "Select a person to see why they are there.");
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let origin = state.origin(person.id).cloned();
        match &origin {
            None => {
                ui.weak("This person came with the file or was drawn by hand: how it was made is not known.");
            }
            Some(origin) => came_from(ui, state, &person, origin),
        }
        title(ui, "What the fit did");
        fit_curves(ui, state, &person);
        match origin.and_then(|origin| origin.seen.clone()) {
            Some(seen) => {
                title(ui, "What the sampler saw");
                images(ui, &seen);
            }
            None => look(ui, state),
        }
    });
}

fn came_from(ui: &mut Ui, state: &mut EditorState, person: &Person, origin: &Origin) {
    let text = match (origin.method, origin.seen.is_some()) {
        (SampleMethod::Search, false) => format!(
            "The search found a place on the {} where somebody can {}, set a body down there and fitted it.",
            person.on,
            person.family.label()
        ),
        (SampleMethod::Search, true) => {
            format!("The search found this place on the {} within the view below.", person.on)
        }
        (SampleMethod::Photo, _) => "Found in a photo by its keypoints.".to_owned(),
        (method, _) => {
            format!("{} drew this body from the two images below; then it was fitted.", method.label())
        }
    };
    ui.label(text);
    let before = state.engine().pose(&origin.before);
    let after = state.engine().pose(&person.body);
    let moved: f32 = before.iter().zip(after.iter()).map(|(a, b)| a.distance(*b)).sum();
    let mean_cm = 100.0 * moved / before.len().max(1) as f32;
    ui.checkbox(&mut state.view.before, "Show the body before the fit")
        .on_hover_text("A ghost in the view: as it was sampled. (B)");
    ui.label(RichText::new(format!("The fit moved the skin by {mean_cm:.1} cm on average.")).small().weak());
}

fn fit_curves(ui: &mut Ui, state: &EditorState, person: &Person) {
    let energies = state.measured(person.id).map(|m| m.energies.clone()).filter(|e| !e.is_empty());
    match energies {
        Some(energies) => {
            ui.label(
                RichText::new("Each term of the loss over the iterations; lower is better.").small().weak(),
            );
            super::energies::small_curves(ui, "why curves", &energies, 130.0);
        }
        None => {
            ui.weak("No fit of this session belongs to the body as it is now.");
        }
    }
}

/// For people whom no network saw: what one would see from here.
fn look(ui: &mut Ui, state: &mut EditorState) {
    title(ui, "What a network sees from here");
    let text = "The networks know a room only by two small images of the view: how far things are, and what they are.";
    ui.label(RichText::new(text).small().weak());
    let ready = state.geometry().is_some();
    if ui.add_enabled(ready, egui::Button::new("Look from this view")).clicked() {
        state.look_from_here();
    }
    if let Some(seen) = state.look.clone() {
        images(ui, &seen);
    }
}

/// Depth and kinds of things side by side, with their legends.
pub fn images(ui: &mut Ui, seen: &Seen) {
    let side = ((ui.available_width() - 8.0) * 0.5).clamp(64.0, 196.0);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let both = [(&seen.depth, "Depth: how far away things are"), (&seen.labels, "Kinds of things")];
        for (picture, name) in both {
            let size = |width: f32| vec2(width, width / picture.aspect().clamp(0.25, 4.0));
            let response = picture.show(ui, size(side), Sense::hover(), name);
            response.on_hover_ui(|ui| {
                ui.label(format!("{name}. The networks get it as 128 x 128 pixels."));
                picture.show(ui, size(384.0), Sense::hover(), name);
            });
        }
    });
    let far_m = seen.image.max_depth_m;
    ui.label(RichText::new(format!("Depth: bright is near, dark is {far_m:.1} m away.")).small().weak());
    legend(ui, seen);
}

fn legend(ui: &mut Ui, seen: &Seen) {
    let kinds = kinds_seen(&seen.image);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(10.0, 3.0);
        for (label, name, share) in kinds.into_iter().take(NAMED) {
            let text = RichText::new(name).small();
            let tip = format!("{:.0} % of the picture", 100.0 * share);
            entry(ui, label_color(label), text).on_hover_text(tip);
        }
    });
}

/// A coloured square and what it stands for.
pub fn entry(ui: &mut Ui, color: Color32, text: RichText) -> egui::Response {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let (rect, _) = ui.allocate_exact_size(vec2(10.0, 12.0), Sense::hover());
        ui.painter().rect_filled(Rect::from_center_size(rect.center(), vec2(10.0, 10.0)), 2.0, color);
        ui.label(text)
    })
    .inner
}
