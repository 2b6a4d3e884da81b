use super::canvas::{Canvas, Drawn, Hang, INK, SMALL, SOFT, color};
use plotters::style::RGBColor;

/// Things on a circle and how probably each follows each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NetworkChart {
    /// Title over the chart.
    pub title: String,
    /// Name, size (any unit) and group (colour) of each.
    pub nodes: Vec<(String, f64, usize)>,
    /// Probability of column after row.
    pub probability: Vec<Vec<f64>>,
    /// Of each node's successors so many are drawn, the most probable; all edges of twenty nodes would be a blot.
    pub successors: usize,
}

/// Room beside the circle for the names.
const MARGIN: f64 = 330.0;

pub fn draw(chart: &NetworkChart, canvas: &Canvas<'_, '_>) -> Drawn {
    let top = canvas.head(&chart.title, &[])?;
    let radius = (0.5 * (canvas.width - 2.0 * MARGIN)).min(0.5 * (canvas.height - top) - 30.0).max(20.0);
    let middle = [0.5 * canvas.width, top + 0.5 * (canvas.height - top)];
    let count = chart.nodes.len().max(1) as f64;
    let at = |index: usize, r: f64| {
        let (sin, cos) = (std::f64::consts::TAU * (index as f64 / count - 0.25)).sin_cos();
        [middle[0] + r * cos, middle[1] + r * sin]
    };
    draw_edges(chart, middle, &|i| at(i, radius), canvas)?;
    let largest = chart.nodes.iter().map(|n| n.1).fold(f64::MIN_POSITIVE, f64::max);
    for (index, (_, size, group)) in chart.nodes.iter().enumerate() {
        canvas.disk(at(index, radius), 4.0 + 8.0 * (size / largest).sqrt(), color(*group))?;
    }
    for right in [false, true] {
        let side = (0..chart.nodes.len()).filter(|i| (at(*i, 1.0)[0] >= middle[0]) == right);
        draw_names(chart, side.map(|i| (i, at(i, radius), at(i, radius + 18.0))).collect(), right, canvas)?;
    }
    Ok(())
}

/// Smallest distance of names under one another.
const LINE: f64 = 17.0;

/// Names of one side, moved apart where they would lie on each other, with a line to their node.
fn draw_names(
    chart: &NetworkChart,
    mut side: Vec<(usize, [f64; 2], [f64; 2])>,
    right: bool,
    canvas: &Canvas<'_, '_>,
) -> Drawn {
    side.sort_by(|a, b| a.2[1].total_cmp(&b.2[1]));
    // From the middle row outwards, so that names stay near their nodes.
    let half = side.len() / 2;
    for k in (0..half).rev() {
        side[k].2[1] = side[k].2[1].min(side[k + 1].2[1] - LINE);
    }
    for k in half + 1..side.len() {
        side[k].2[1] = side[k].2[1].max(side[k - 1].2[1] + LINE);
    }
    for (index, node, place) in side {
        let own = chart.probability.get(index).and_then(|row| row.get(index)).copied().unwrap_or(0.0);
        let text = format!("{} (again {:.0} %)", chart.nodes[index].0, 100.0 * own);
        let hang = if right { Hang::Left } else { Hang::Right };
        let end = [place[0] + if right { -3.0 } else { 3.0 }, place[1]];
        canvas.stroke(&[node, end], pale(SOFT, 0.5), 0.8)?;
        canvas.text(&text, place, SMALL, INK, hang)?;
    }
    Ok(())
}

/// Curves bent towards the middle, thick where probable, in the colour of where they begin.
fn draw_edges(
    chart: &NetworkChart,
    middle: [f64; 2],
    at: &dyn Fn(usize) -> [f64; 2],
    canvas: &Canvas<'_, '_>,
) -> Drawn {
    let edges = chart.probability.iter().enumerate().flat_map(|(i, row)| {
        let mut others: Vec<(usize, f64)> =
            row.iter().copied().enumerate().filter(|(j, p)| *j != i && *p > 0.0).collect();
        others.sort_by(|a, b| b.1.total_cmp(&a.1));
        others.into_iter().take(chart.successors).map(move |(j, p)| (i, j, p))
    });
    let mut edges: Vec<(usize, usize, f64)> = edges.collect();
    edges.sort_by(|a, b| a.2.total_cmp(&b.2));
    let most = edges.last().map_or(1.0, |e| e.2);
    for (i, j, p) in edges {
        let (from, to, share) = (at(i), at(j), p / most);
        let points: Vec<[f64; 2]> = (0..=24)
            .map(|k| {
                let t = f64::from(k) / 24.0;
                // A quadratic curve whose middle point is drawn half-way to the middle of the circle.
                let mix = |axis: usize| {
                    let control = 0.35 * 0.5 * (from[axis] + to[axis]) + 0.65 * middle[axis];
                    (1.0 - t).powi(2) * from[axis] + 2.0 * t * (1.0 - t) * control + t * t * to[axis]
                };
                [mix(0), mix(1)]
            })
            .collect();
        let group = chart.nodes.get(i).map_or(0, |n| n.2);
        canvas.stroke(&points, pale(color(group), 0.75 - 0.55 * share), 0.6 + 2.6 * share)?;
    }
    Ok(())
}

fn pale(c: RGBColor, share: f64) -> RGBColor {
    let mix = |from: u8| (f64::from(from) + (255.0 - f64::from(from)) * share) as u8;
    RGBColor(mix(c.0), mix(c.1), mix(c.2))
}
