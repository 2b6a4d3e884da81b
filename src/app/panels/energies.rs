//! How the fit of the selected person went: each term of the energy over the iterations.

use egui::Ui;
use egui_plot::{Legend, Line, Plot, PlotPoints};

use super::empty;
use crate::app::engine::Energies;
use crate::app::state::EditorState;

/// Below this an energy is drawn as this: the plot's height is its logarithm.
const FLOOR: f32 = 1e-6;

/// Draws the plot.
pub fn energies(ui: &mut Ui, state: &mut EditorState) {
    let Some(id) = state.selection.active_person() else {
        empty(ui, "Select a person to see how its fit went.");
        return;
    };
    let energies = state.measured(id).map(|m| m.energies.clone());
    let Some(energies) = energies.filter(|e| !e.is_empty()) else {
        empty(ui, "This person was not fitted in this session, so there are no energies to plot.");
        return;
    };
    curves(ui, "energies", &energies);
}

/// Each term over the iterations, filling what room there is.
fn curves(ui: &mut Ui, id: &str, energies: &Energies) {
    plot(ui, Plot::new(id).legend(Legend::default()).y_axis_label("log10 of energy"), energies);
}

/// The same in little room: the names stand below, and terms that never mattered are left out.
pub fn small_curves(ui: &mut Ui, id: &str, energies: &Energies, height: f32) {
    let counted = |(_, values): &&(String, Vec<f32>)| values.iter().any(|value| *value > COUNTS);
    let counting: Energies = energies.iter().filter(counted).cloned().collect();
    plot(ui, Plot::new(id).height(height), &counting);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = egui::vec2(10.0, 3.0);
        for (i, (name, _)) in counting.iter().enumerate() {
            super::why::entry(ui, color(i), egui::RichText::new(name).small());
        }
    });
}

/// A term that never was above this is not worth a line in a small plot.
const COUNTS: f32 = 1e-4;

fn plot(ui: &mut Ui, plot: Plot<'_>, energies: &Energies) {
    plot.allow_scroll(false).x_axis_label("iteration").show(ui, |plot| {
        for (i, (name, values)) in energies.iter().enumerate() {
            let points = values.iter().enumerate().map(|(i, v)| [i as f64, f64::from(v.max(FLOOR).log10())]);
            plot.line(Line::new(name, PlotPoints::from_iter(points)).width(1.6).color(color(i)));
        }
    });
}

/// Colours that are told apart on dark and light ground: the golden angle between neighbours.
fn color(i: usize) -> egui::Color32 {
    let hue = (0.02 + i as f32 * 0.381_966).fract();
    egui::ecolor::Hsva::new(hue, 0.72, 0.82, 1.0).into()
}
