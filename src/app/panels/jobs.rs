//! What runs: stage, rate, time left, cancel.

use std::time::Duration;

use egui::{ProgressBar, RichText, ScrollArea, Ui};

use super::empty;
use crate::app::jobs::JobRow;
use crate::app::state::EditorState;

/// A job shorter than this is not worth a detail.
const DETAIL_AFTER: Duration = Duration::from_secs(1);

/// Draws the list.
pub fn jobs(ui: &mut Ui, state: &mut EditorState) {
    let rows = state.jobs.rows();
    if rows.is_empty() {
        empty(ui, "Nothing is running.");
        return;
    }
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for row in rows {
            job_row(ui, state, &row);
        }
        if state.jobs.waiting() {
            ui.weak("Populate waits for the room analysis.");
        }
    });
}

fn job_row(ui: &mut Ui, state: &mut EditorState, row: &JobRow) {
    ui.horizontal(|ui| {
        ui.strong(&row.name);
        ui.weak(row.progress.stage);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.button("Cancel").on_hover_text(format!("Cancel {}", row.name)).clicked() {
                state.cancel(row.kind);
            }
        });
    });
    progress_bar(ui, row);
    if row.elapsed > DETAIL_AFTER {
        ui.label(RichText::new(details(row)).small().weak());
    }
    ui.add_space(4.0);
}

/// The bar; empty while the total is unknown.
pub fn progress_bar(ui: &mut Ui, row: &JobRow) {
    let known = row.progress.total > 0;
    let bar = ProgressBar::new(if known { row.progress.fraction() } else { 0.0 });
    let response = ui.add(bar.desired_height(6.0));
    response.widget_info(|| {
        let label = format!("{}: {}", row.name, row.progress.stage);
        egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, label)
    });
}

/// Rate and time left, as far as they are known.
pub fn details(row: &JobRow) -> String {
    let progress = &row.progress;
    let seconds = progress.elapsed.as_secs_f32();
    let mut text = String::new();
    if progress.total > 0 {
        text = format!("{} of {}", progress.done, progress.total);
        if seconds > 0.2 && progress.done > 0 {
            text.push_str(&format!(", {:.1} per second", progress.done as f32 / seconds));
        }
        if let Some(left) = progress.remaining() {
            text.push_str(&format!(", about {:.0} s left", left.as_secs_f32().max(1.0)));
        }
        text.push_str(", ");
    }
    text + &format!("{:.0} s so far", row.elapsed.as_secs_f32())
}
