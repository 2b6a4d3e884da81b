use crate::learn::evaluate_psi::{Evaluation, PhysicalRow, Stage};
use crate::render::Picture;
use crate::render::plot::{BarChart, BarSeries, PlotError, ReferenceLine, bar_chart};

/// Size of the charts.
const SIZE: [u32; 2] = [1180, 460];

/// A figure that is drawn: file name, title, axis, value, range, levels to compare with.
struct Figure {
    file: &'static str,
    title: &'static str,
    axis: &'static str,
    value: fn(&PhysicalRow) -> Option<f32>,
    range: Option<[f64; 2]>,
    reference: Option<(f64, &'static str)>,
}

const FIGURES: [Figure; 6] = [
    Figure {
        file: "non_collision",
        title: "Non-collision (PSI)",
        axis: "share of vertices in free space",
        value: |r| Some(r.psi_non_collision),
        range: Some([0.5, 1.02]),
        reference: Some((0.98, "0.98 asked for")),
    },
    Figure {
        file: "contact_2cm",
        title: "Contact within 2 cm",
        axis: "share of bodies",
        value: |r| Some(r.contact_2cm),
        range: Some([0.0, 1.08]),
        reference: Some((0.98, "0.98 asked for")),
    },
    Figure {
        file: "psi_contact",
        title: "Contact (PSI: some vertex at or in a surface)",
        axis: "share of bodies",
        value: |r| Some(r.psi_contact),
        range: Some([0.0, 1.08]),
        reference: None,
    },
    Figure {
        file: "faultless",
        title: "Bodies without findings",
        axis: "share of bodies",
        value: |r| Some(r.faultless),
        range: Some([0.0, 1.08]),
        reference: None,
    },
    Figure {
        file: "entropy_camera",
        title: "Diversity: entropy over 20 clusters, camera frames",
        axis: "nats",
        value: |r| r.entropy_camera_nats,
        range: Some([0.0, 3.2]),
        reference: Some((2.9957, "ln 20")),
    },
    Figure {
        file: "cluster_size_camera",
        title: "Diversity: mean cluster size, camera frames",
        axis: "distance to the cluster's centre",
        value: |r| r.cluster_size_camera,
        range: None,
        reference: None,
    },
];

/// A chart of every figure for every set of rooms, with its file name; none of a figure that no method has.
pub fn charts(evaluation: &Evaluation) -> Result<Vec<(String, Picture)>, PlotError> {
    let figures = FIGURES.iter().flat_map(|f| evaluation.sets().into_iter().map(move |s| (f, s)));
    figures
        .map(|(figure, set)| (figure, set, chart(evaluation, figure, set)))
        .filter(|(_, _, chart)| chart.series.iter().any(|s| s.values.iter().any(Option::is_some)))
        .map(|(figure, set, chart)| {
            let picture = bar_chart(&chart, SIZE)?;
            Ok((format!("plots/{}_{}.png", figure.file, set.replace(' ', "_")), picture))
        })
        .collect()
}

fn chart(evaluation: &Evaluation, figure: &Figure, set: &str) -> BarChart {
    let methods = evaluation.methods();
    let value = |method: &str, stage: Stage| {
        let row = evaluation.of_set(method, set, stage).filter(|r| r.bodies > 0)?;
        (figure.value)(row).map(f64::from)
    };
    let series = Stage::ALL.into_iter().map(|stage| BarSeries {
        name: stage.label().to_owned(),
        values: methods.iter().map(|m| value(m, stage)).collect(),
    });
    let references = figure.reference.into_iter();
    BarChart {
        title: format!("{}: {set}", figure.title),
        y_label: figure.axis.to_owned(),
        groups: methods.iter().map(|m| (*m).to_owned()).collect(),
        series: series.collect(),
        references: references.map(|(y, label)| ReferenceLine { y, label: label.to_owned() }).collect(),
        y_range: figure.range,
    }
}
