//! Messages over the lower right of the window.

use egui::{Align2, Area, Frame, Id, RichText, Stroke};

use crate::app::icons::{self, Icon};
use crate::app::notices::{Level, Notice};
use crate::app::state::EditorState;
use crate::app::theme::{self, Palette};

/// Most messages shown at once; older ones are in the history.
const SHOWN: usize = 5;

/// Draws the messages that are still fresh.
pub fn toasts(ctx: &egui::Context, state: &mut EditorState) {
    let shown: Vec<(usize, Notice)> =
        state.notices.all().filter(|(_, n)| n.shown).map(|(i, n)| (i, n.clone())).collect();
    if shown.is_empty() {
        return;
    }
    let area = Area::new(Id::unique("toasts"))
        .anchor(Align2::RIGHT_BOTTOM, egui::vec2(-14.0, -36.0))
        .order(egui::Order::Foreground);
    area.show(ctx, |ui| {
        ui.set_max_width(380.0);
        for (number, notice) in shown.iter().rev().take(SHOWN).rev() {
            if toast(ui, notice) {
                state.notices.close(*number);
            }
        }
    });
}

/// Draws one message; whether it was closed.
fn toast(ui: &mut egui::Ui, notice: &Notice) -> bool {
    let palette = theme::palette(ui.visuals());
    let color = level_color(notice.level, palette);
    let frame = Frame::popup(ui.style()).stroke(Stroke::new(1.0, color.gamma_multiply(0.7)));
    let mut closed = false;
    frame.inner_margin(10).show(ui, |ui| {
        ui.set_width(350.0);
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| {
                ui.set_width(318.0);
                ui.label(RichText::new(&notice.text).color(ui.visuals().strong_text_color()));
                if !notice.details.is_empty() {
                    ui.label(RichText::new(&notice.details).small());
                }
                if notice.level == Level::Error && ui.small_button("Copy details").clicked() {
                    ui.ctx().copy_text(notice.for_clipboard());
                }
            });
            closed = icons::button(ui, Icon::Close, "Close message", 0.7).clicked();
        });
    });
    closed
}

/// The colour of a message's border and of its row in the history.
pub fn level_color(level: Level, palette: &Palette) -> egui::Color32 {
    match level {
        Level::Info => palette.accent,
        Level::Warning => palette.warn,
        Level::Error => palette.bad,
    }
}
