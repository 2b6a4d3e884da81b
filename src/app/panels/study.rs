//! The study mode: what is to be rated, and the bar below the view while it runs.

use egui::{Button, Context, DragValue, Grid, Id, Modal, RichText, TextEdit, Ui};

use crate::app::state::{EditorState, Overlay};
use crate::app::theme;
use crate::document::StudyKind;

/// What the ends and steps of the scale mean.
const SCALE: [&str; 5] = ["not at all", "hardly", "somewhat", "mostly", "completely"];

/// Asks for what is to be rated and by whom.
pub fn study_setup(ctx: &Context, state: &mut EditorState) {
    let response = Modal::new(Id::unique("study")).show(ctx, |ui| {
        ui.set_width(520.0_f32.min(ctx.content_rect().width() - 60.0));
        ui.heading("Human study");
        ui.weak(
            "Results are shown blind and in random order; each gets 1 to 5 by key. The folder has a folder for each \
             method, and in these projects or rooms, by the same names for the same tasks.",
        );
        ui.add_space(6.0);
        let setup = &mut state.study_setup;
        Grid::new("study setup").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
            for (name, text, hint) in [
                ("Folder", &mut setup.folder, "Path of the folder"),
                ("Rater", &mut setup.rater, "Your name or number"),
                ("Question", &mut setup.question, "What is asked of each result"),
            ] {
                let label = ui.label(name);
                let width = ui.available_width().max(360.0);
                ui.add(TextEdit::singleline(text).hint_text(hint).desired_width(width)).labelled_by(label.id);
                ui.end_row();
            }
            ui.label("Shown");
            ui.horizontal(|ui| {
                ui.selectable_value(&mut setup.kind, StudyKind::Single, "one by one");
                ui.selectable_value(&mut setup.kind, StudyKind::Pairs, "in pairs")
                    .on_hover_text("Two methods' results of the same task; A and B switch between them.");
            });
            ui.end_row();
            let label = ui.label("Seed");
            ui.add(DragValue::new(&mut setup.seed)).labelled_by(label.id).on_hover_text("Chooses the order.");
            ui.end_row();
        });
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let ready = !state.study_setup.folder.trim().is_empty();
            if ui.add_enabled(ready, Button::new("Begin")).clicked() {
                state.start_study();
            }
            if ui.button("Not now").clicked() {
                state.overlay = Overlay::None;
            }
        });
    });
    if response.should_close() {
        state.overlay = Overlay::None;
    }
}

/// The question, the scale and how far the rater is.
pub fn study_bar(ui: &mut Ui, state: &mut EditorState) {
    let Some(run) = &state.study else { return };
    if run.is_done() {
        return done(ui, state);
    }
    let (at, all) = (run.at + 1, run.study.trials.len());
    let (side, trial) = (run.side, run.study.trials[run.at].clone());
    let (question, ready) = (run.question.clone(), run.is_shown());
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        ui.heading(question);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.button("Leave").on_hover_text("Esc; scores so far are kept").clicked() {
                state.leave_study();
            }
            if ui.add_enabled(at > 1, Button::new("Back")).on_hover_text("Backspace").clicked() {
                state.previous_trial();
            }
            ui.weak(format!("{at} of {all}"));
        });
    });
    ui.horizontal(|ui| {
        if trial.shown.len() > 1 {
            for (i, name) in ["A", "B"].into_iter().enumerate() {
                let scored = trial.scores[i].map_or(String::new(), |score| format!(": {score}"));
                let button =
                    Button::new(RichText::new(format!("{name}{scored}")).size(15.0)).selected(i == side);
                if ui.add_sized([64.0, 34.0], button).on_hover_text(format!("Key {name}")).clicked() {
                    state.show_side(i);
                }
            }
            ui.separator();
        }
        ui.add_enabled_ui(ready, |ui| scale(ui, state, trial.scores[side]));
        if !ready {
            ui.spinner();
        }
    });
    ui.add_space(6.0);
}

fn scale(ui: &mut Ui, state: &mut EditorState, given: Option<u8>) {
    for (i, meaning) in SCALE.into_iter().enumerate() {
        let score = i as u8 + 1;
        let text = RichText::new(format!("{score}  {meaning}")).size(14.0);
        let button = Button::new(text).selected(given == Some(score));
        if ui.add_sized([124.0, 34.0], button).on_hover_text(format!("Key {score}")).clicked() {
            state.score(score);
        }
    }
}

/// Everything is scored: what all raters thought.
fn done(ui: &mut Ui, state: &mut EditorState) {
    let Some(run) = &state.study else { return };
    let palette = theme::palette(ui.visuals());
    ui.add_space(6.0);
    ui.heading("Thank you: everything is scored.");
    Grid::new("study summary").num_columns(4).striped(true).spacing([24.0, 4.0]).show(ui, |ui| {
        for head in ["Method", "Scores", "Mean", "Standard deviation"] {
            ui.label(RichText::new(head).small().weak());
        }
        ui.end_row();
        for method in &run.summary {
            ui.label(&method.method);
            ui.monospace(method.count.to_string());
            ui.label(RichText::new(format!("{:.2}", method.mean)).monospace().color(palette.accent));
            ui.monospace(format!("{:.2}", method.deviation));
            ui.end_row();
        }
    });
    if ui.button("Leave").clicked() {
        state.leave_study();
    }
    ui.add_space(6.0);
}
