//! The bundled networks: what they were trained on, how that went and what came of it.

use egui::text::{LayoutJob, TextFormat};
use egui::{FontId, RichText, ScrollArea, Ui};
use egui_plot::{Legend, Line, Plot, PlotPoints};

use crate::app::engine::{Curve, NetworkCard};
use crate::app::state::{EditorState, Overlay};

/// Least width of a column of a table; wider tables are scrolled.
const COLUMN: f32 = 64.0;

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
        losses(ui, card);
        measures(ui, card);
        markdown(ui, &card.text);
    }
}

fn losses(ui: &mut Ui, card: &NetworkCard) {
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

fn measures(ui: &mut Ui, card: &NetworkCard) {
    if card.measures.is_empty() {
        return;
    }
    let plot = Plot::new(("measures", &card.name))
        .legend(Legend::default())
        .height(150.0)
        .include_y(0.0)
        .allow_scroll(false)
        .x_axis_label("epoch")
        .y_axis_label("on validation clips");
    plot.show(ui, |plot| {
        for curve in &card.measures {
            plot.line(Line::new(&curve.name, PlotPoints::from(curve.points.clone())).width(1.6));
        }
    });
}

/// Nobody trains so many epochs: the numbers are steps.
fn counts_steps(card: &NetworkCard) -> bool {
    let last = |curve: &Curve| curve.points.last().is_some_and(|point| point[0] > 400.0);
    card.curves.iter().any(last)
}

/// What a card is made of.
enum Block<'a> {
    Heading(&'a str),
    Item(String),
    Command(&'a str),
    Paragraph(String),
    Table(Vec<Vec<&'a str>>),
}

/// The few marks that the cards use: headings, lists, tables, commands, and paragraphs over several lines.
fn markdown(ui: &mut Ui, text: &str) {
    for (number, block) in blocks(text).into_iter().enumerate() {
        match block {
            Block::Heading(text) => {
                ui.add_space(4.0);
                ui.strong(text);
            }
            Block::Item(text) => {
                ui.horizontal_top(|ui| {
                    ui.label("•");
                    let job = inline(ui, &text);
                    ui.label(job);
                });
            }
            Block::Command(text) => {
                let shown = RichText::new(text).monospace().background_color(ui.visuals().faint_bg_color);
                ui.label(shown);
            }
            Block::Paragraph(text) => {
                let job = inline(ui, &text);
                ui.label(job);
            }
            Block::Table(rows) => show_table(ui, number, &rows),
        }
    }
}

fn blocks(text: &str) -> Vec<Block<'_>> {
    let mut blocks: Vec<Block<'_>> = Vec::new();
    let mut open = false;
    for line in text.lines().map(str::trim_end) {
        let goes_on = std::mem::take(&mut open);
        let heading = line.trim_start_matches('#');
        if let Some(row) = line.strip_prefix('|') {
            let cells: Vec<&str> = row.trim_end_matches('|').split('|').map(str::trim).collect();
            let rule = cells.iter().all(|cell| cell.chars().all(|c| matches!(c, '-' | ':' | ' ')));
            match blocks.last_mut() {
                _ if rule => {}
                Some(Block::Table(rows)) => rows.push(cells),
                _ => blocks.push(Block::Table(vec![cells])),
            }
        } else if heading.len() < line.len() {
            blocks.push(Block::Heading(heading.trim()));
        } else if let Some(command) = line.strip_prefix("    ") {
            blocks.push(Block::Command(command));
        } else if line.starts_with("![") || line.is_empty() {
            // Pictures are drawn as plots here.
        } else if let Some(item) = line.strip_prefix("- ") {
            blocks.push(Block::Item(item.to_owned()));
            open = true;
        } else {
            open = true;
            match blocks.last_mut() {
                Some(Block::Paragraph(so_far) | Block::Item(so_far)) if goes_on => {
                    so_far.push(' ');
                    so_far.push_str(line.trim());
                }
                _ => blocks.push(Block::Paragraph(line.trim().to_owned())),
            }
        }
    }
    blocks
}

/// Strong words and code within a line.
fn inline(ui: &Ui, text: &str) -> LayoutJob {
    let body = egui::TextStyle::Body.resolve(ui.style());
    let plain = TextFormat::simple(body.clone(), ui.visuals().text_color());
    let strong = TextFormat::simple(body.clone(), ui.visuals().strong_text_color());
    let code = TextFormat::simple(FontId::monospace(body.size - 1.0), ui.visuals().text_color());
    let mut job = LayoutJob::default();
    for (i, part) in text.split("**").enumerate() {
        for (j, piece) in part.split('`').enumerate() {
            let format = match (i % 2, j % 2) {
                (_, 1) => &code,
                (1, _) => &strong,
                _ => &plain,
            };
            job.append(piece, 0.0, format.clone());
        }
    }
    job
}

fn show_table(ui: &mut Ui, number: usize, rows: &[Vec<&str>]) {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1).max(1);
    let width = (ui.available_width() / columns as f32 - 16.0).max(COLUMN);
    ScrollArea::horizontal().id_salt(("card table", number)).show(ui, |ui| {
        egui::Grid::new(("cells", number)).striped(true).spacing([14.0, 3.0]).show(ui, |ui| {
            for (i, row) in rows.iter().enumerate() {
                for cell in row {
                    let text = RichText::new(cell.replace("**", "")).small();
                    // Long cells are broken into lines: the page stays as wide as it is.
                    ui.vertical(|ui| {
                        ui.set_width(width);
                        ui.label(if i == 0 { text.weak() } else { text });
                    });
                }
                ui.end_row();
            }
        });
    });
}
