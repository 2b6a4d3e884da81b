use super::canvas::{Canvas, Drawn, Frame, Hang, INK, LABEL, SMALL, SOFT, color, step_of};
use super::ticks;

/// How values are spread over an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm; values of 0 and less leave gaps.
    Log,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Points (x, y) in the order they are joined; one that isn't finite leaves a gap.
    pub points: Vec<[f64; 2]>,
}

/// Something that happened at an x.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VerticalMark {
    /// Where.
    pub x: f64,
    /// What, in a few words.
    pub label: String,
}

/// Curves over a common x axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineChart {
    /// Title over the chart.
    pub title: String,
    /// What x is, with its unit.
    pub x_label: String,
    /// What y is, with its unit.
    pub y_label: String,
    /// The curves; a legend names them when there is more than one.
    pub curves: Vec<Curve>,
    /// Dashed verticals with a note each.
    pub marks: Vec<VerticalMark>,
    /// How y is spread.
    pub y_scale: Scale,
    /// Smallest and largest y shown; that of the values when `None`.
    pub y_range: Option<[f64; 2]>,
}

/// From values to pixels.
struct Axes {
    frame: Frame,
    x: [f64; 2],
    /// Range of y, as logarithms on a logarithmic axis.
    y: [f64; 2],
    scale: Scale,
}

impl Axes {
    /// The pixel of a value; `None` where it has none.
    fn place(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let y = spread(y, self.scale)?;
        let share = |v: f64, [low, high]: [f64; 2]| (v - low) / (high - low);
        let (h, v) = (share(x, self.x), share(y, self.y));
        let f = &self.frame;
        let at = [f.left + h * (f.right - f.left), f.bottom - v.clamp(-0.01, 1.01) * (f.bottom - f.top)];
        (h.is_finite() && v.is_finite()).then_some(at)
    }
}

/// A value as its axis spreads it.
fn spread(value: f64, scale: Scale) -> Option<f64> {
    let spread = match scale {
        Scale::Linear => value,
        Scale::Log => value.log10(),
    };
    spread.is_finite().then_some(spread)
}

/// Least and largest of the values; apart from each other and never empty.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    match high - low {
        span if span.is_finite() && span > 0.0 => [low, high],
        span if span.is_finite() => [low - 0.5, high + 0.5],
        _ => [0.0, 1.0],
    }
}

pub fn draw(chart: &LineChart, canvas: &Canvas<'_, '_>) -> Drawn {
    let names: Vec<&str> = chart.curves.iter().map(|c| c.name.as_str()).collect();
    let top = canvas.head(&chart.title, &names)?;
    let points = || chart.curves.iter().flat_map(|c| &c.points);
    let x = range(points().map(|p| p[0]).filter(|x| x.is_finite()));
    let y = y_range(chart);
    let values = match chart.y_scale {
        Scale::Linear => ticks::nice(y[0], y[1], 6),
        Scale::Log => ticks::decades(10f64.powf(y[0]), 10f64.powf(y[1])),
    };
    let axes = Axes { frame: canvas.frame(top, 52.0, &values), x, y, scale: chart.y_scale };
    draw_axes(chart, canvas, &axes, &values)?;
    for (index, curve) in chart.curves.iter().enumerate() {
        draw_curve(curve, color(index), canvas, &axes)?;
    }
    Ok(())
}

/// The range of y as the axis spreads it, with a little air.
fn y_range(chart: &LineChart) -> [f64; 2] {
    let spread = |y: f64| spread(y, chart.y_scale);
    if let Some([Some(low), Some(high)]) = chart.y_range.map(|r| r.map(spread))
        && high > low
    {
        return [low, high];
    }
    let [low, high] = range(chart.curves.iter().flat_map(|c| &c.points).filter_map(|p| spread(p[1])));
    let air = 0.05 * (high - low);
    // A curve that starts at zero stands on the axis.
    let low =
        if chart.y_scale == Scale::Linear && (0.0..0.3 * high).contains(&low) { 0.0 } else { low - air };
    [low, high + air]
}

fn draw_axes(chart: &LineChart, canvas: &Canvas<'_, '_>, axes: &Axes, values: &[f64]) -> Drawn {
    let frame = &axes.frame;
    let step = step_of(values);
    let placed = values.iter().filter_map(|v| {
        let text = if chart.y_scale == Scale::Log { ticks::text(*v, *v) } else { ticks::text(*v, step) };
        Some((axes.place([axes.x[0], *v])?[1], text))
    });
    canvas.y_axis(frame, &chart.y_label, &placed.collect::<Vec<_>>())?;
    canvas.stroke(&[[frame.left, frame.bottom], [frame.right, frame.bottom]], SOFT, 1.0)?;
    let columns = ticks::nice(axes.x[0], axes.x[1], ((frame.right - frame.left) / 90.0) as usize);
    let step = step_of(&columns);
    for x in &columns {
        let at = frame.left + (x - axes.x[0]) / (axes.x[1] - axes.x[0]) * (frame.right - frame.left);
        canvas.stroke(&[[at, frame.bottom], [at, frame.bottom + 4.0]], SOFT, 1.0)?;
        canvas.text(&ticks::text(*x, step), [at, frame.bottom + 7.0], SMALL, SOFT, Hang::Below)?;
    }
    let middle = 0.5 * (frame.left + frame.right);
    canvas.text(&chart.x_label, [middle, canvas.height - 24.0], LABEL, SOFT, Hang::Below)?;
    for mark in chart.marks.iter().filter(|m| (axes.x[0]..=axes.x[1]).contains(&m.x)) {
        let at = frame.left + (mark.x - axes.x[0]) / (axes.x[1] - axes.x[0]) * (frame.right - frame.left);
        canvas.dashes([at, frame.top], [at, frame.bottom], SOFT)?;
        let (hang, x) = if at > middle { (Hang::Right, at - 6.0) } else { (Hang::Left, at + 6.0) };
        canvas.text(&mark.label, [x, frame.top + 8.0], SMALL, INK, hang)?;
    }
    Ok(())
}

fn draw_curve(
    curve: &Curve,
    color: plotters::style::RGBColor,
    canvas: &Canvas<'_, '_>,
    axes: &Axes,
) -> Drawn {
    let placed: Vec<Option<[f64; 2]>> = curve.points.iter().map(|p| axes.place(*p)).collect();
    for piece in placed.split(Option::is_none) {
        let piece: Vec<[f64; 2]> = piece.iter().flatten().copied().collect();
        match piece.as_slice() {
            [] => {}
            [lone] => canvas.disk(*lone, 2.5, color)?,
            _ => canvas.stroke(&piece, color, 1.8)?,
        }
    }
    Ok(())
}
