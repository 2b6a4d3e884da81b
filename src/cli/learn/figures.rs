//! The report of `learn actions` as Markdown and pictures.

use std::fmt::Write as _;
use std::sync::Arc;

use rayon::prelude::*;

use super::super::output::OutputFolder;
use crate::assets::encode_png;
use crate::evolve::action::{ActionKind, ActionModel, ActionNode, Evidence, Polar, PolarDensity};
use crate::learn::actions::simulate::Recovery;
use crate::learn::actions::{ActionReport, Found, Funnel, places_of};
use crate::render::Picture;
use crate::render::plot::{
    BarChart, BarSeries, NetworkChart, PlotError, PolarChart, PolarPanel, bar_chart, network_chart,
    polar_chart,
};

/// Panels of one node, the most frequent objects and pairs first.
const MOST_PANELS: usize = 8;
/// Panels in a row and their size in pixels.
const COLUMNS: usize = 4;
const PANEL: [u32; 2] = [280, 310];
/// Half the width of a panel, metres.
const REACH_M: f64 = 1.5;

/// Draws everything and writes it: `graph.png`, `likelihood.png`, `funnel.png`, `nodes/*.png`.
pub fn write(
    folder: &OutputFolder,
    model: &ActionModel,
    found: &Found,
    report: &ActionReport,
    simulated: &[(String, Recovery)],
) -> anyhow::Result<()> {
    save(folder, "graph.png", &graph(model)?)?;
    save(folder, "likelihood.png", &bar_chart(&likelihood(report), [900, 420])?)?;
    save(folder, "funnel.png", &bar_chart(&funnel(report), [1180, 460])?)?;
    if !simulated.is_empty() {
        save(folder, "simulation.png", &bar_chart(&simulation(simulated), [1300, 460])?)?;
    }
    let sheets: Vec<(String, Picture)> = model
        .nodes
        .par_iter()
        .map(|node| Ok((format!("nodes/{}.png", node.label().replace(' ', "_")), sheet(node, model, found)?)))
        .collect::<Result<_, PlotError>>()?;
    sheets.iter().try_for_each(|(name, picture)| save(folder, name, picture))
}

fn save(folder: &OutputFolder, name: &str, picture: &Picture) -> anyhow::Result<()> {
    folder.write(name, &encode_png(picture.width, picture.height, &picture.rgba)?)?;
    Ok(())
}

fn graph(model: &ActionModel) -> Result<Picture, PlotError> {
    let group = |kind: ActionKind| ActionKind::ALL.iter().position(|k| *k == kind).unwrap_or(0);
    let chart = NetworkChart {
        title: "Which action follows which: each node's five most probable successors".into(),
        nodes: model.nodes.iter().map(|n| (n.label(), n.instances as f64, group(n.kind))).collect(),
        probability: model.graph().probability,
        successors: 5,
    };
    network_chart(&chart, [1560, 920])
}

fn likelihood(report: &ActionReport) -> BarChart {
    let rows = &report.likelihood.rows;
    let series = |name: &str, value: &dyn Fn(&crate::learn::actions::LikelihoodRow) -> f64| BarSeries {
        name: name.into(),
        values: rows.iter().map(|r| Some(value(r))).collect(),
    };
    BarChart {
        title: "Held-out photos: mean log-likelihood, higher is better".into(),
        y_label: "nats".into(),
        groups: rows.iter().map(|r| r.model.split(" (").next().unwrap_or_default().to_owned()).collect(),
        series: vec![
            series("counts, an instance", &|r| r.counts),
            series("place, an object", &|r| r.place),
            series("both, an instance", &|r| r.instance),
        ],
        ..BarChart::default()
    }
}

/// A filter: its name, and how many instances are left after it.
type Filter = (&'static str, fn(&Funnel) -> usize);

/// The filters in their order.
const FILTERS: [Filter; 8] = [
    ("found", |f| f.found),
    ("with things", |f| f.with_things),
    ("with pose", |f| f.with_pose),
    ("number of people", |f| f.with_people),
    ("needed thing", |f| f.with_required),
    ("two categories", |f| f.with_categories),
    ("key object", |f| f.with_key),
    ("instances", |f| f.instances),
];

fn funnel(report: &ActionReport) -> BarChart {
    let of = |kind: &ActionKind| report.funnels.get(kind.label()).cloned().unwrap_or_default();
    let series = |(name, value): &(&str, fn(&Funnel) -> usize)| BarSeries {
        name: (*name).into(),
        values: ActionKind::ALL.iter().map(|kind| Some(value(&of(kind)) as f64)).collect(),
    };
    BarChart {
        title: "Photos left after each filter".into(),
        y_label: "photos".into(),
        groups: ActionKind::ALL.iter().map(|k| k.label().to_owned()).collect(),
        series: FILTERS.iter().map(series).collect(),
        ..BarChart::default()
    }
}

fn simulation(rows: &[(String, Recovery)]) -> BarChart {
    let series = |name: &str, value: &dyn Fn(&Recovery) -> f64| BarSeries {
        name: name.into(),
        values: rows.iter().map(|(_, r)| Some(value(r))).collect(),
    };
    BarChart {
        title: "Simulated photos: largest error of what is learned".into(),
        y_label: "error".into(),
        groups: rows.iter().map(|(name, _)| name.clone()).collect(),
        series: vec![
            series("C(o, n)", &|r| r.occurrence),
            series("mu", &|r| r.mu),
            series("sigma", &|r| r.sigma),
            series("directions apart", &|r| r.direction_apart),
        ],
        ..BarChart::default()
    }
}

/// The layouts of one node.
fn sheet(node: &ActionNode, model: &ActionModel, found: &Found) -> Result<Picture, PlotError> {
    let key = (node.kind, node.key, node.relation, node.posture);
    let mut panels: Vec<PolarPanel> = node
        .around_person
        .iter()
        .take(MOST_PANELS)
        .map(|p| {
            let places = places_of(found, key, &p.object);
            let points = places.iter().map(|u| {
                let r = u.distance * model.metres_per_unit;
                [r * u.angle_rad.cos(), r * u.angle_rad.sin()]
            });
            let often = format!("{} ({:.0} %)", p.object, 100.0 * node.frequency(&p.object));
            PolarPanel { points: points.collect(), ..panel(often, &p.density, true) }
        })
        .collect();
    let pairs = node.between.iter().take(2 * MOST_PANELS - panels.len());
    panels.extend(pairs.map(|p| {
        let title = format!("{} from {} ({:.0} %)", p.object, p.reference, 100.0 * p.together);
        panel(title, &p.density, false)
    }));
    let rows = panels.len().div_ceil(COLUMNS).max(1) as u32;
    let chart = PolarChart {
        title: format!(
            "{}: {} instances, {} complete",
            node.label(),
            node.instances,
            node.complete_instances
        ),
        panels,
        columns: COLUMNS,
        unit: "m".into(),
    };
    polar_chart(&chart, [PANEL[0] * COLUMNS as u32, PANEL[1] * rows + 60])
}

fn panel(title: String, density: &PolarDensity, person: bool) -> PolarPanel {
    let whose = match density.evidence {
        Evidence::Node => "its own places",
        Evidence::Action => "places of its type",
        Evidence::Everything => "places of all",
    };
    let owned = density.clone();
    PolarPanel {
        title,
        note: format!("{} {whose}", density.samples),
        density: Some(Arc::new(move |right, front| {
            // Beside the pole the density of an area has no bound.
            let distance_m = right.hypot(front).max(0.05) as f32;
            owned.density_per_m2(Polar { distance_m, angle_rad: front.atan2(right) as f32 })
        })),
        points: Vec::new(),
        reach: REACH_M,
        ring: 0.5,
        person,
    }
}

/// The report as Markdown.
pub fn markdown(report: &ActionReport, simulated: &[(String, Recovery)]) -> String {
    let mut text = format!(
        "# Learned actions\n\n{} photos with captions, {} with interactions; {} give at least one instance. {} people were \
         left out for want of their photo's size. Seconds: {}.\n\n",
        report.photos_with_captions,
        report.photos_with_interactions,
        report.photos_used,
        report.people_without_size,
        report.seconds.iter().map(|(k, v)| format!("{k} {v:.1}")).collect::<Vec<_>>().join(", ")
    );
    write_funnels(&mut text, report);
    write_nodes(&mut text, report);
    write_reference(&mut text, report);
    write_likelihood(&mut text, report);
    write_simulation(&mut text, simulated);
    let _ = writeln!(text, "## Warnings\n");
    report.warnings.iter().for_each(|w| {
        let _ = writeln!(text, "- {w}");
    });
    text
}

fn write_funnels(text: &mut String, report: &ActionReport) {
    let _ = writeln!(
        text,
        "## Photos after each filter\n\n| action | said in a caption | marked | {} | of complete photos |\n|{}",
        FILTERS.map(|(name, _)| name).join(" | "),
        "---|".repeat(FILTERS.len() + 4)
    );
    for kind in ActionKind::ALL {
        let Some(funnel) = report.funnels.get(kind.label()) else { continue };
        let counts = FILTERS.map(|(_, value)| value(funnel).to_string()).join(" | ");
        let _ = writeln!(
            text,
            "| {} | {} | {} | {counts} | {} |",
            kind.label(),
            funnel.said,
            funnel.done,
            funnel.complete_instances
        );
    }
    let evidence =
        report.posture_evidence.iter().map(|(k, v)| format!("{k} {v}")).collect::<Vec<_>>().join(", ");
    let _ = writeln!(text, "\nPostures are known by: {evidence}.");
    if let Some(share) = report.seated_told_by_angles {
        let _ = writeln!(
            text,
            "Of {} people marked as sitting with two leg angles seen, eq. 1 calls {:.0} % seated.",
            report.seated_asked,
            100.0 * share
        );
    }
    text.push('\n');
}

fn write_nodes(text: &mut String, report: &ActionReport) {
    let _ = writeln!(
        text,
        "## Nodes\n\n| node | instances | complete | key seen at (κ) | objects: frequency, median distance, places |\n|---|---|---|---|---|"
    );
    for node in &report.nodes {
        let key =
            node.key_angle.map_or_else(|| "-".to_owned(), |[mean, kappa]| format!("{mean:.0}° ({kappa:.1})"));
        let objects = node.objects.iter().map(|o| {
            let mark = match o.evidence {
                Evidence::Node => "",
                Evidence::Action => " of its type",
                Evidence::Everything => " of all",
            };
            format!("{} {:.0} % {:.2} m {}{mark}", o.object, 100.0 * o.frequency, o.distance_m, o.places)
        });
        let objects = objects.collect::<Vec<_>>().join("; ");
        let _ =
            writeln!(text, "| {} | {} | {} | {key} | {objects} |", node.node, node.instances, node.complete);
    }
    text.push('\n');
}

fn write_reference(text: &mut String, report: &ActionReport) {
    let _ = writeln!(
        text,
        "## Layouts of things in use beside reference fits (pitch 20°, torso lengths)\n\n\
         | pair | places | ln r: μ | σ | mean direction | concentration |\n|---|---|---|---|---|---|"
    );
    for row in &report.reference {
        let both = |[own, theirs]: [f64; 2], digits: usize| format!("{own:.digits$} ({theirs:.digits$})");
        let _ = writeln!(
            text,
            "| {} | {} ({}) | {} | {} | {} | {} |",
            row.pair,
            row.places[0],
            row.places[1],
            both(row.mu, 2),
            both(row.sigma, 2),
            both(row.direction_deg, 0),
            both(row.concentration, 2)
        );
    }
    text.push('\n');
}

fn write_likelihood(text: &mut String, report: &ActionReport) {
    let likelihood = &report.likelihood;
    let _ = writeln!(
        text,
        "## Held-out photos\n\n{} instances ({} of complete photos), {} places, {} folds by photo. Nats, higher is better.\n\n\
         | model | counts, an instance | place, an object | both, an instance |\n|---|---|---|---|",
        likelihood.instances, likelihood.complete_instances, likelihood.places, likelihood.folds
    );
    for row in &likelihood.rows {
        let _ =
            writeln!(text, "| {} | {:.2} | {:.2} | {:.2} |", row.model, row.counts, row.place, row.instance);
    }
    text.push('\n');
}

fn write_simulation(text: &mut String, simulated: &[(String, Recovery)]) {
    if simulated.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "## Simulated photos whose truth is known: largest errors\n\n\
         | conditions | instances | C(o, n) | μ | σ | mean direction | directions apart | key's direction | κ of it, learned over true |\n\
         |---|---|---|---|---|---|---|---|---|"
    );
    for (name, r) in simulated {
        let _ = writeln!(
            text,
            "| {name} | {} | {:.3} | {:.2} | {:.2} | {:.0}° | {:.2} | {:.0}° | {:.2} |",
            r.instances,
            r.occurrence,
            r.mu,
            r.sigma,
            r.direction_deg,
            r.direction_apart,
            r.key_deg,
            r.key_kappa_ratio
        );
    }
    text.push('\n');
}
