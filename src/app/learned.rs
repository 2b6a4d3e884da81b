//! What was learned of actions, as it ships: the nodes, which follows which, where things lie, and what rests on few
//! photos. Read once; no file is touched.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use super::pictures::Shown;
use crate::evolve::action::ActionGraph;
use crate::evolve::action::ActionModel;
use crate::evolve::action::ActionNode;
use crate::evolve::action::Evidence;
use crate::evolve::action::Polar;
use crate::evolve::action::PolarDensity;

/// The learner's report on the model that ships.
const REPORT: &str = include_str!("../../assets/actions/actions.md");
/// Half the width of a plot, metres.
pub const REACH_M: f32 = 1.5;
/// Distance of a plot's rings, metres.
pub const RING_M: f32 = 0.5;
/// Cells along a plot's side: two fingers wide each.
const CELLS: usize = 72;
/// Nearer to the pole than this the density of an area has no bound, metres.
const POLE_M: f32 = 0.05;
/// Width of a plot's soft rim, metres.
const RIM_M: f32 = 0.06;
/// Plots of one node.
const MOST_PLOTS: usize = 15;
/// A place must have so much of the highest density's root to be painted.
const LEAST_SHARE: f32 = 0.03;

/// What was learned.
pub struct Learned {
    /// The nodes.
    pub model: Arc<ActionModel>,
    /// Which follows which.
    pub graph: ActionGraph,
    /// Label of a node, and what is doubtful about it.
    warnings: Vec<(String, String)>,
}

/// Where one object lies, from above.
pub struct Plot {
    /// "laptop (96 %)".
    pub title: String,
    /// What it rests on.
    pub note: String,
    /// How dense it is: white, to be painted in any colour.
    pub density: Shown,
    /// In the middle is a person, looking up, rather than an object.
    pub person: bool,
}

/// The page of what was learned.
#[derive(Default)]
pub struct LearnedPage {
    plots: BTreeMap<usize, Vec<Plot>>,
    /// The node that the pointer was on in the last frame.
    pub pointed_at: Option<usize>,
}

impl LearnedPage {
    /// The plots of a node, made when they are first looked at.
    pub fn plots(&mut self, learned: &Learned, node: usize) -> &[Plot] {
        let of = learned.model.nodes.get(node);
        self.plots.entry(node).or_insert_with(|| of.map(plots_of).unwrap_or_default())
    }
}

/// What ships with the program; why not, if it is damaged.
pub fn learned() -> Result<&'static Learned, String> {
    static READ: OnceLock<Result<Learned, String>> = OnceLock::new();
    let read = || {
        let model = ActionModel::bundled().map_err(|error| error.to_string())?;
        let graph = model.graph();
        Ok(Learned { model, graph, warnings: warnings(REPORT) })
    };
    READ.get_or_init(read).as_ref().map_err(Clone::clone)
}

impl Learned {
    /// What is doubtful about a node.
    pub fn warnings_of<'a>(&'a self, label: &'a str) -> impl Iterator<Item = &'a str> {
        self.warnings.iter().filter(move |(of, _)| of == label).map(|(_, text)| text.as_str())
    }
}

/// The warnings of a report: `- "label" what` or `- "label": what`.
fn warnings(report: &str) -> Vec<(String, String)> {
    let of_line = |line: &str| {
        let (label, text) = line.strip_prefix("- \"")?.split_once('"')?;
        Some((label.to_owned(), text.trim_start_matches(':').trim().to_owned()))
    };
    let from = report.find("## Warnings").unwrap_or(report.len());
    report[from..].lines().filter_map(of_line).collect()
}

fn plots_of(node: &ActionNode) -> Vec<Plot> {
    let mut often: Vec<_> = node.around_person.iter().map(|p| (node.frequency(&p.object), p)).collect();
    often.sort_by(|a, b| b.0.total_cmp(&a.0));
    let around = often.into_iter().map(|(share, p)| {
        let title = format!("{} ({:.0} %)", p.object, 100.0 * share);
        plot(title, &p.density, true)
    });
    let between = node.between.iter().map(|p| {
        let title = format!("{} from {} ({:.0} %)", p.object, p.reference, 100.0 * p.together);
        plot(title, &p.density, false)
    });
    around.chain(between).take(MOST_PLOTS).collect()
}

fn plot(title: String, density: &PolarDensity, person: bool) -> Plot {
    let whose = match density.evidence {
        Evidence::Node => "places of this action",
        Evidence::Action => "places of all actions of its type",
        Evidence::Everything => "places of all actions",
    };
    let note = format!("{} {whose}", density.samples);
    Plot { title, note, density: picture(density), person }
}

fn picture(density: &PolarDensity) -> Shown {
    let place = |cell: usize| REACH_M * (2.0 * (cell as f32 + 0.5) / CELLS as f32 - 1.0);
    let at = |column: usize, row: usize| {
        let (right, front) = (place(column), -place(row));
        let distance_m = right.hypot(front);
        if distance_m > REACH_M {
            return 0.0;
        }
        let polar = Polar { distance_m: distance_m.max(POLE_M), angle_rad: front.atan2(right) };
        let value = density.density_per_m2(polar) as f32;
        if value.is_finite() { value } else { 0.0 }
    };
    let values: Vec<f32> = (0..CELLS * CELLS).map(|i| at(i % CELLS, i / CELLS)).collect();
    // The brightest cells beside the pole would hide all others: the scale ends at the 99th percentile.
    let mut sorted: Vec<f32> = values.iter().copied().filter(|value| *value > 0.0).collect();
    sorted.sort_by(f32::total_cmp);
    let most = sorted.get(sorted.len() * 99 / 100).copied().unwrap_or(1.0).max(f32::MIN_POSITIVE);
    Shown::of_shares(CELLS, |column, row| {
        let share = (values[row * CELLS + column] / most).min(1.0).sqrt();
        // The rim is soft: hard cells would stand out of the circle.
        let rim = ((REACH_M - place(column).hypot(place(row))) / RIM_M).clamp(0.0, 1.0);
        if share > LEAST_SHARE { share * rim } else { 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_warning_of_the_report_is_about_a_node_that_is_there() {
        let learned = learned().unwrap();
        assert!(learned.warnings.len() > 10);
        for (label, text) in &learned.warnings {
            assert!(learned.model.nodes.iter().any(|node| node.label() == *label), "{label}");
            assert!(!text.is_empty() && !text.starts_with(':'), "{text}");
        }
        let thin = learned.warnings_of("use computer on desk while sitting").next();
        assert_eq!(thin, Some("rests on 11 instances"));
    }

    #[test]
    fn every_node_has_plots_the_most_frequent_things_first() {
        let learned = learned().unwrap();
        let mut page = LearnedPage::default();
        for (number, node) in learned.model.nodes.iter().enumerate() {
            let plots = page.plots(learned, number);
            assert!(!plots.is_empty(), "{}", node.label());
        }
        let laptop = learned.model.nodes.iter().position(|n| n.label() == "use laptop on desk while sitting");
        let plots = page.plots(learned, laptop.unwrap());
        assert!(plots[0].title.starts_with("laptop (") && plots[0].person, "{}", plots[0].title);
    }
}
