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
pub fn curves(ui: &mut Ui, id: &str, energies: &Energies) {
    let plot = Plot::new(id)
        .legend(Legend::default())
        .allow_scroll(false)
        .x_axis_label("iteration")
        .y_axis_label("log10 of energy");
    plot.show(ui, |plot| {
        for (name, values) in energies {
            let points = values.iter().enumerate().map(|(i, v)| [i as f64, f64::from(v.max(FLOOR).log10())]);
            plot.line(Line::new(name, PlotPoints::from_iter(points)).width(1.6));
        }
    });
}
