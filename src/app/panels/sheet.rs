//! The contact sheet: small pictures of the candidates, the best first; click to see one in the view, accept,
//! lock or re-roll it.

use egui::{Align2, Color32, FontId, Rect, RichText, ScrollArea, Sense, Stroke, StrokeKind, Ui, vec2};

use super::empty;
use crate::app::actions;
use crate::app::icons::{self, Icon};
use crate::app::samples::{Card, Fate};
use crate::app::state::EditorState;
use crate::app::theme::{self, Palette};

/// Side of a candidate's picture in points.
const SIDE: f32 = 116.0;

/// Draws the sheet.
pub fn sheet(ui: &mut Ui, state: &mut EditorState) {
    if state.sheet.cards.is_empty() {
        let text = if state.jobs.sampling() {
            "Sampling..."
        } else {
            "No candidates yet. Turn the view to where people should be and press Sample (Shift+S)."
        };
        empty(ui, text);
        return;
    }
    heading(ui, state);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = vec2(8.0, 8.0);
            for number in 0..state.sheet.cards.len() {
                card(ui, state, number);
            }
        });
    });
}

fn heading(ui: &mut Ui, state: &mut EditorState) {
    let sheet = &state.sheet;
    let (all, faultless) = (sheet.cards.len(), sheet.faultless());
    let text = format!(
        "{all} candidates by {}, the best first; {faultless} without findings before fitting",
        sheet.made_by.label()
    );
    ui.horizontal(|ui| {
        ui.label(RichText::new(text).small().weak());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            super::command_button(ui, state, "clear-candidates");
            super::command_button(ui, state, "re-roll-candidates");
            super::command_button(ui, state, "accept-all");
            super::command_button(ui, state, "accept");
        });
    });
}

fn card(ui: &mut Ui, state: &mut EditorState, number: usize) {
    let palette = theme::palette(ui.visuals());
    let key = state.sheet.cards[number].key;
    ui.push_id(key, |ui| {
        ui.vertical(|ui| {
            ui.set_width(SIDE);
            ui.spacing_mut().item_spacing = vec2(4.0, 4.0);
            picture(ui, state, number, palette);
            buttons(ui, state, number);
        });
    });
}

fn picture(ui: &mut Ui, state: &mut EditorState, number: usize, palette: &Palette) {
    let card = &state.sheet.cards[number];
    let (key, chosen) = (card.key, state.sheet.chosen == Some(card.key));
    let (rect, response) = ui.allocate_exact_size(vec2(SIDE, SIDE), Sense::click());
    let name = format!("Candidate {}: {}", number + 1, card.person.family.label());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, chosen, name.clone()));
    if ui.is_rect_visible(rect) {
        paint(ui, card, number, rect, palette);
        let stroke = match (chosen, response.hovered()) {
            (true, _) => Stroke::new(2.0, palette.accent),
            (_, true) => Stroke::new(1.0, ui.visuals().widgets.hovered.fg_stroke.color),
            _ => Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color),
        };
        ui.painter().rect_stroke(rect, 3.0, stroke, StrokeKind::Inside);
    }
    let tip = tip(card);
    let response = response.on_hover_ui(|ui| tip_ui(ui, &tip));
    if response.double_clicked() {
        state.accept_cards(&[key]);
    } else if response.clicked() {
        state.choose_card(key);
    }
}

fn paint(ui: &Ui, card: &Card, number: usize, rect: Rect, palette: &Palette) {
    let painter = ui.painter();
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    match &card.picture {
        Some(picture) => picture.paint(ui, rect),
        None => {
            egui::Spinner::new()
                .size(20.0)
                .paint_at(ui, Rect::from_center_size(rect.center(), vec2(20.0, 20.0)));
        }
    }
    let faults = card.findings.len();
    let strip = Rect::from_min_max(rect.left_bottom() - vec2(0.0, 18.0), rect.right_bottom());
    painter.rect_filled(strip, 0.0, Color32::from_black_alpha(170));
    let font = FontId::proportional(11.0);
    let light = Color32::from_gray(235);
    painter.text(
        strip.left_center() + vec2(6.0, 0.0),
        Align2::LEFT_CENTER,
        card.person.family.label(),
        font.clone(),
        light,
    );
    let color = if faults == 0 { palette.good } else { palette.warn };
    painter.circle_filled(strip.right_center() - vec2(9.0, 0.0), 3.5, color);
    if faults > 0 {
        let place = strip.right_center() - vec2(16.0, 0.0);
        painter.text(place, Align2::RIGHT_CENTER, faults.to_string(), font.clone(), light);
    }
    let fate = match card.fate {
        Fate::Open => "",
        Fate::Fitting => "being fitted",
        Fate::Accepted => "in the room",
    };
    if !fate.is_empty() {
        painter.rect_filled(rect, 3.0, Color32::from_black_alpha(120));
        let pill = Rect::from_center_size(rect.center(), vec2(78.0, 20.0));
        painter.rect_filled(pill, 10.0, palette.accent);
        painter.text(pill.center(), Align2::CENTER_CENTER, fate, font.clone(), palette.on_accent);
    }
    let corner = Rect::from_min_size(rect.left_top(), vec2(20.0, 16.0));
    painter.rect_filled(corner, 3.0, Color32::from_black_alpha(150));
    painter.text(corner.center(), Align2::CENTER_CENTER, (number + 1).to_string(), font, light);
}

/// What is said of a candidate: a line each, the first strong.
fn tip(card: &Card) -> Vec<String> {
    let mut lines = vec![format!("{}, {}", card.person.family.label(), card.person.on)];
    if card.findings.is_empty() {
        lines.push("No findings, even before fitting.".to_owned());
    }
    lines.extend(card.findings.iter().map(|f| {
        let (value, limit) = (super::findings::number_text(f.value), super::findings::number_text(f.limit));
        format!("{}: {value}, limit {limit}", f.metric.label())
    }));
    lines.push("Click: show it in the view. Double click: accept; it is fitted then.".to_owned());
    lines
}

fn tip_ui(ui: &mut Ui, lines: &[String]) {
    for (i, line) in lines.iter().enumerate() {
        if i == 0 {
            ui.strong(line)
        } else {
            ui.label(line)
        };
    }
}

fn buttons(ui: &mut Ui, state: &mut EditorState, number: usize) {
    let card = &state.sheet.cards[number];
    let (key, fate, locked) = (card.key, card.fate, card.locked);
    let n = number + 1;
    ui.add_enabled_ui(fate == Fate::Open, |ui| {
        ui.horizontal(|ui| {
            let accept = ui.small_button("Accept");
            accept.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::Button, true, format!("Accept candidate {n}"))
            });
            if accept.on_hover_text("Fits it to the room and puts it in.").clicked() {
                state.accept_cards(&[key]);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if icons::button(ui, Icon::Dice, &format!("Re-roll candidate {n}"), 0.6).clicked() {
                    actions::re_roll_card(state, key);
                }
                let (icon, verb, strength) =
                    if locked { (Icon::Lock, "Unlock", 0.9) } else { (Icon::Unlock, "Lock", 0.35) };
                if icons::button(ui, icon, &format!("{verb} candidate {n}"), strength).clicked() {
                    state.lock_card(key);
                }
            });
        });
    });
}
