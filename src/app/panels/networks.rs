//! The bundled networks: what they were trained on, how that went and what came of it.

use egui::{RichText, Ui};
use egui_plot::{Legend, Line, Plot, PlotPoints};

use crate::app::engine::{Curve, NetworkCard};
use crate::app::state::{EditorState, Overlay};

/// Draws the page of the network with this number.
pub fn networks(ui: &mut Ui, state: &mut EditorState, number: usize) {
    let cards = state.engine().networks();
    if cards.is_empty() {
        ui.label("No network is bundled with this program. `inhabit train psi` makes some.");
        return;
    }
    ui.horizontal_wrapped(|ui| {
        for (i, card) in cards.iter().enumerate() {
            if ui.selectable_label(i == number, &card.name).clicked() {
                state.overlay = Overlay::Networks(i);
            }
        }
    });
    ui.separator();
    if let Some(card) = cards.get(number).or(cards.first()) {
        curves(ui, card);
        markdown(ui, &card.text);
    }
}

fn curves(ui: &mut Ui, card: &NetworkCard) {
    if card.curves.is_empty() {
        return;
    }
    let log = |p: &[f64; 2]| [p[0], p[1].max(1e-9).log10()];
    let plot = Plot::new(("training", &card.name))
        .legend(Legend::default())
        .height(220.0)
        .allow_scroll(false)
        .x_axis_label(if counts_steps(card) { "step" } else { "epoch" })
        .y_axis_label("log10 of loss");
    plot.show(ui, |plot| {
        for curve in &card.curves {
            let points: Vec<[f64; 2]> = curve.points.iter().map(log).collect();
            plot.line(Line::new(&curve.name, PlotPoints::from(points)).width(1.6));
        }
    });
}

/// Nobody trains so many epochs: the numbers are steps.
fn counts_steps(card: &NetworkCard) -> bool {
    let last = |curve: &Curve| curve.points.last().is_some_and(|point| point[0] > 400.0);
    card.curves.iter().any(last)
}

/// The few marks that the cards use: headings, lists, tables, and plain paragraphs.
fn markdown(ui: &mut Ui, text: &str) {
    let mut table: Vec<Vec<&str>> = Vec::new();
    for (number, line) in text.lines().map(str::trim_end).chain([""]).enumerate() {
        if let Some(row) = line.strip_prefix('|') {
            let cells: Vec<&str> = row.trim_end_matches('|').split('|').map(str::trim).collect();
            if !cells.iter().all(|cell| cell.chars().all(|c| matches!(c, '-' | ':' | ' '))) {
                table.push(cells);
            }
            continue;
        }
        if !table.is_empty() {
            show_table(ui, number, &std::mem::take(&mut table));
        }
        let plain = line.trim_start_matches('#');
        if plain.len() < line.len() {
            ui.add_space(4.0);
            ui.strong(plain.trim());
        } else if let Some(item) = line.strip_prefix("- ") {
            ui.horizontal_wrapped(|ui| {
                ui.label("•");
                ui.label(item);
            });
        } else if !line.starts_with("![") && !line.is_empty() {
            ui.label(line);
        }
    }
}

fn show_table(ui: &mut Ui, number: usize, rows: &[Vec<&str>]) {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1).max(1);
    let width = (ui.available_width() / columns as f32 - 16.0).max(40.0);
    egui::Grid::new(("card table", number)).striped(true).spacing([14.0, 3.0]).show(ui, |ui| {
        for (i, row) in rows.iter().enumerate() {
            for cell in row {
                let text = RichText::new(*cell).small();
                // Long cells are broken into lines: the page stays as wide as it is.
                ui.vertical(|ui| {
                    ui.set_width(width);
                    ui.label(if i == 0 { text.weak() } else { text });
                });
            }
            ui.end_row();
        }
    });
}
