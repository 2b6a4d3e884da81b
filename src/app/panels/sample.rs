//! What to sample from a view, and the button that does it.

use egui::{Button, DragValue, RichText, ScrollArea, Slider, Ui};

use super::title;
use super::why::images;
use crate::app::actions;
use crate::app::engine::SampleMethod;
use crate::app::jobs::JobKind;
use crate::app::samples::ViewFrom;
use crate::app::state::EditorState;
use crate::app::theme;

/// Draws the panel.
pub fn sample(ui: &mut Ui, state: &mut EditorState) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        methods(ui, state);
        view_from(ui, state);
        numbers(ui, state);
        ui.add_space(2.0);
        button(ui, state);
        if let Some(seen) = state.sheet.seen.clone() {
            title(ui, "What it saw");
            images(ui, &seen);
        }
    });
}

/// One row a method; what it is good at stands below for the chosen one and in the tip for all.
fn methods(ui: &mut Ui, state: &mut EditorState) {
    let missing = state.engine().missing_methods();
    let chosen = state.sheet.options.method;
    ui.horizontal(|ui| {
        let label = ui.label("Method");
        let combo = egui::ComboBox::from_id_salt("sample method")
            .selected_text(chosen.label())
            .width(ui.available_width() - 8.0);
        let response = combo.show_ui(ui, |ui| {
            for method in SampleMethod::ALL {
                let why_not = missing.iter().find(|(m, _)| *m == method).map(|(_, why)| why.as_str());
                let entry = Button::selectable(method == chosen, method.label());
                let response = ui.add_enabled(why_not.is_none(), entry).on_hover_text(method.strength());
                let response = response.on_disabled_hover_text(why_not.unwrap_or_default());
                if response.clicked() {
                    state.sheet.options.method = method;
                }
            }
        });
        response.response.labelled_by(label.id).on_hover_text("Who proposes the people.");
    });
    ui.label(RichText::new(state.sheet.options.method.strength()).small().weak());
}

fn view_from(ui: &mut Ui, state: &mut EditorState) {
    ui.horizontal(|ui| {
        ui.label("Seen from");
        let choices = [
            (ViewFrom::Here, "this view", "What the 3-D view shows now. Turn it to where people should be."),
            (
                ViewFrom::Agent,
                "somebody there",
                "Somebody 1.8 m tall who stands in the room and looks around; another place with every seed.",
            ),
        ];
        for (from, label, tip) in choices {
            ui.selectable_value(&mut state.sheet.options.from, from, label).on_hover_text(tip);
        }
    });
}

fn numbers(ui: &mut Ui, state: &mut EditorState) {
    egui::Grid::new("sample numbers").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let label = ui.label("Candidates");
        ui.add(Slider::new(&mut state.sheet.options.count, 1..=48)).labelled_by(label.id);
        ui.end_row();
        let label = ui.label("Seed");
        ui.add(DragValue::new(&mut state.sheet.options.seed).range(0..=u64::MAX).speed(0.05))
            .labelled_by(label.id)
            .on_hover_text("The same seed and view give the same candidates, bit by bit.");
        ui.end_row();
    });
}

fn button(ui: &mut Ui, state: &mut EditorState) {
    let palette = theme::palette(ui.visuals());
    let size = [ui.available_width(), 32.0];
    if state.jobs.sampling() {
        if ui.add_sized(size, Button::new("Cancel sampling")).clicked() {
            state.cancel(JobKind::Sample);
        }
        return;
    }
    let text = RichText::new("Sample").size(14.0).color(palette.on_accent);
    let button = Button::new(text).fill(palette.accent);
    let ready = state.geometry().is_some();
    let response = ui.add_enabled_ui(ready, |ui| ui.add_sized(size, button)).inner;
    let tip = "Proposes people for what is seen. They come up as candidates below; nothing changes until you accept \
               one (Shift+S)";
    if response.on_hover_text(tip).on_disabled_hover_text("Waits for the room analysis.").clicked() {
        actions::sample_view(state);
    }
}
