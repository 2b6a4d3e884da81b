//! Curves, bars, floor plans and networks as pictures: training losses, tables of results, layouts, graphs. Takes numbers, returns pixels; plotters
//! draws the strokes, the layout is made here. Knows nothing of what the numbers mean and writes no file.

mod bars;
mod canvas;
mod lines;
mod network;
mod polar;
mod sheet;
mod ticks;

pub use bars::{BarChart, BarSeries, ReferenceLine};
pub use lines::{Curve, LineChart, Scale, VerticalMark};
pub use network::NetworkChart;
pub use polar::{PolarChart, PolarPanel};
pub use sheet::Captioned;

use super::Picture;

/// Smallest side of a chart in pixels: below it text covers the curves.
const LEAST_SIDE: u32 = 160;
/// Largest side of a chart in pixels.
const MOST_SIDE: u32 = 8192;

/// Why a chart can't be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// Too small or too big.
    #[error("a chart of {width} x {height} pixels: give each side {LEAST_SIDE} to {MOST_SIDE}")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The rasteriser refused.
    #[error("the chart '{title}' can't be drawn: {detail}")]
    Draw {
        /// Title of the chart.
        title: String,
        /// What the rasteriser says.
        detail: String,
    },
}

/// Draws a line chart of `size` pixels (width, height).
///
/// # Errors
/// [`PlotError`].
pub fn line_chart(chart: &LineChart, size: [u32; 2]) -> Result<Picture, PlotError> {
    canvas::painted(size, &chart.title, |canvas| lines::draw(chart, canvas))
}

/// Draws a bar chart of `size` pixels (width, height).
///
/// # Errors
/// [`PlotError`].
pub fn bar_chart(chart: &BarChart, size: [u32; 2]) -> Result<Picture, PlotError> {
    canvas::painted(size, &chart.title, |canvas| bars::draw(chart, canvas))
}

/// Draws densities over floor plans, `size` pixels (width, height).
///
/// # Errors
/// [`PlotError`].
pub fn polar_chart(chart: &PolarChart, size: [u32; 2]) -> Result<Picture, PlotError> {
    canvas::painted(size, &chart.title, |canvas| polar::draw(chart, canvas))
}

/// Draws a network of `size` pixels (width, height).
///
/// # Errors
/// [`PlotError`].
pub fn network_chart(chart: &NetworkChart, size: [u32; 2]) -> Result<Picture, PlotError> {
    canvas::painted(size, &chart.title, |canvas| network::draw(chart, canvas))
}

/// Pictures in rows of `columns`, each under its caption.
///
/// # Errors
/// [`PlotError`].
pub fn captioned_sheet(tiles: &[Captioned], columns: usize) -> Result<Picture, PlotError> {
    sheet::draw(tiles, columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn darkness(picture: &Picture) -> usize {
        picture.rgba.chunks_exact(4).filter(|p| p[0] < 200 || p[1] < 200 || p[2] < 200).count()
    }

    fn losses() -> LineChart {
        let curve = |name: &str, k: f64| Curve {
            name: name.into(),
            points: (1..60).map(|i| [f64::from(i), k / f64::from(i) + 0.01]).collect(),
        };
        LineChart {
            title: "Losses".into(),
            x_label: "epoch".into(),
            y_label: "loss".into(),
            curves: vec![curve("training", 1.0), curve("validation", 1.5)],
            ..LineChart::default()
        }
    }

    #[test]
    fn a_curve_ends_where_its_last_value_is() {
        let chart = |last: f64| LineChart {
            curves: vec![Curve { name: "a".into(), points: vec![[0.0, 0.0], [1.0, last]] }],
            y_range: Some([0.0, 1.0]),
            ..losses()
        };
        let is_blue = |p: [u8; 3]| p[2] > p[0].saturating_add(60);
        let highest = |last: f64| {
            let picture = line_chart(&chart(last), [400, 300]).expect("drawn");
            let rows = 80..300_u32;
            rows.into_iter().find(|&y| (50..400).any(|x| is_blue(picture.pixel(x, y)))).expect("a line")
        };
        assert!(highest(1.0) + 60 < highest(0.5), "{} {}", highest(1.0), highest(0.5));
    }

    #[test]
    fn a_value_that_is_not_finite_leaves_a_gap_and_no_panic() {
        let mut chart = losses();
        for scale in [Scale::Linear, Scale::Log] {
            chart.y_scale = scale;
            chart.curves[0].points[3][1] = f64::NAN;
            chart.curves[0].points[4][1] = f64::INFINITY;
            chart.curves[1].points = vec![[0.0, 0.0]];
            assert!(darkness(&line_chart(&chart, [500, 320]).expect("drawn")) > 500);
            chart.curves[1].points.clear();
            line_chart(&chart, [200, 200]).expect("an empty curve");
        }
        line_chart(&LineChart::default(), [300, 200]).expect("an empty chart");
        bar_chart(&BarChart::default(), [300, 200]).expect("an empty chart");
    }

    #[test]
    fn a_higher_bar_fills_more_and_a_missing_one_fills_nothing() {
        let chart = |value: Option<f64>| BarChart {
            title: "Scores".into(),
            y_label: "score".into(),
            groups: vec!["search".into(), "S1".into()],
            series: vec![BarSeries { name: "before".into(), values: vec![Some(1.0), value] }],
            y_range: Some([0.0, 1.0]),
            ..BarChart::default()
        };
        let fill = |value| darkness(&bar_chart(&chart(value), [400, 300]).expect("drawn"));
        assert!(fill(Some(0.9)) > fill(Some(0.4)) + 2000);
        assert!(fill(Some(0.4)) > fill(None) + 2000);
    }

    #[test]
    fn a_chart_too_small_to_read_is_refused() {
        assert!(matches!(line_chart(&losses(), [40, 300]), Err(PlotError::Size { width: 40, .. })));
    }

    #[test]
    fn a_density_is_dark_where_it_is_large_and_the_front_is_up() {
        let panel = PolarPanel {
            density: Some(std::sync::Arc::new(|_, front| if front > 0.3 { 1.0 } else { 0.0 })),
            reach: 1.0,
            ring: 0.5,
            person: true,
            ..PolarPanel::default()
        };
        let chart = PolarChart { panels: vec![panel], columns: 1, ..PolarChart::default() };
        let picture = polar_chart(&chart, [300, 340]).expect("drawn");
        let blue = |rows: std::ops::Range<u32>| {
            let pixels = rows.flat_map(|y| (0..300).map(move |x| (x, y)));
            pixels
                .filter(|(x, y)| {
                    let p = picture.pixel(*x, *y);
                    p[2] > p[0].saturating_add(60)
                })
                .count()
        };
        assert!(blue(60..180) > 2000 && blue(220..340) == 0, "{} {}", blue(60..180), blue(220..340));
        polar_chart(&PolarChart::default(), [300, 200]).expect("an empty chart");
    }

    #[test]
    fn a_more_probable_edge_is_drawn_stronger() {
        let chart = |p: f64| NetworkChart {
            title: "Actions".into(),
            nodes: vec![("a".into(), 1.0, 0), ("b".into(), 1.0, 1), ("c".into(), 1.0, 2)],
            probability: vec![vec![0.5, 0.5, 0.0], vec![0.0, 1.0 - p, p], vec![0.0, 0.0, 1.0]],
            successors: 2,
        };
        let ink = |p: f64| darkness(&network_chart(&chart(p), [900, 500]).expect("drawn"));
        assert!(ink(0.5) > ink(0.05) + 50);
        network_chart(&NetworkChart::default(), [300, 200]).expect("an empty chart");
    }
}
