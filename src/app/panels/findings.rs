//! Everything above its limit, the worst first.

use std::sync::Arc;

use egui::{Grid, RichText, ScrollArea, Ui};

use super::empty;
use crate::app::actions;
use crate::app::state::EditorState;
use crate::app::theme;
use crate::inspect::Finding;
use crate::scene::Clip;
use crate::scene::PersonId;

/// Draws the table; a click selects and frames the person.
pub fn findings(ui: &mut Ui, state: &mut EditorState) {
    let findings = state.findings();
    let of_motions = state.worst_clip_findings();
    if findings.is_empty() && of_motions.is_empty() {
        let people = state.document.scene().people.len();
        let unmeasured = state.unmeasured().len();
        empty(
            ui,
            match (people, unmeasured) {
                (0, _) => "Findings appear here once there are people.",
                (_, 0) => "Everybody is within every limit.",
                _ => "Measuring...",
            },
        );
        return;
    }
    let names: Vec<String> = findings
        .iter()
        .map(|f| {
            state.document.scene().person(PersonId(f.site.body)).map_or(String::new(), |p| p.name.clone())
        })
        .collect();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        Grid::new("findings").num_columns(4).striped(true).spacing([16.0, 4.0]).show(ui, |ui| {
            for head in ["Person", "What", "Value", "Limit"] {
                ui.label(RichText::new(head).small().weak());
            }
            ui.end_row();
            for (number, (finding, name)) in findings.iter().zip(&names).enumerate() {
                let marked = state.finding == Some(number);
                let row = ui.selectable_label(marked, name);
                if row.on_hover_text("Select and frame (N, P)").clicked() {
                    actions::go_to_finding(state, number);
                }
                ui.label(finding.metric.label());
                let color = theme::palette(ui.visuals()).bad;
                ui.label(RichText::new(number_text(finding.value)).monospace().color(color));
                ui.label(RichText::new(number_text(finding.limit)).monospace().weak());
                ui.end_row();
            }
        });
        motions(ui, state, names.len(), &of_motions);
    });
}

/// The worst frame of each motion in each respect; a click shows it.
fn motions(ui: &mut Ui, state: &mut EditorState, people: usize, findings: &[(Arc<Clip>, Finding)]) {
    Grid::new("findings of motions").num_columns(5).striped(true).spacing([16.0, 4.0]).show(ui, |ui| {
        for (number, (clip, finding)) in findings.iter().enumerate() {
            let marked = state.finding == Some(people + number);
            let frame = finding.site.frame.map_or("all of it".to_owned(), |frame| format!("frame {frame}"));
            let row = ui.push_id(("motion", number), |ui| ui.selectable_label(marked, &clip.name)).inner;
            if row.on_hover_text("Show this frame").clicked() {
                actions::go_to_finding(state, people + number);
            }
            ui.label(finding.metric.label());
            let color = theme::palette(ui.visuals()).bad;
            ui.label(RichText::new(number_text(finding.value)).monospace().color(color));
            ui.label(RichText::new(number_text(finding.limit)).monospace().weak());
            ui.weak(frame);
            ui.end_row();
        }
    });
}

/// A number with as many digits as mean something.
pub fn number_text(value: f32) -> String {
    if value == value.trunc() {
        format!("{value:.0}")
    } else if value.abs() < 2.0 {
        format!("{value:.3}")
    } else {
        format!("{value:.1}")
    }
}
