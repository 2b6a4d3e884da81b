use super::canvas::{Canvas, Drawn, Frame, Hang, INK, LABEL, SMALL, SOFT, color, step_of};
use super::ticks;

/// Share of a group's width that its bars fill.
const FILLED: f64 = 0.78;

/// Bars of one colour, one a group.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BarSeries {
    /// Name in the legend.
    pub name: String,
    /// One value a group; `None` where there is none.
    pub values: Vec<Option<f64>>,
}

/// A dashed level to compare the bars with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReferenceLine {
    /// Where.
    pub y: f64,
    /// What it is, in a few words.
    pub label: String,
}

/// Groups of bars.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BarChart {
    /// Title over the chart.
    pub title: String,
    /// What the height is, with its unit.
    pub y_label: String,
    /// Names under the groups.
    pub groups: Vec<String>,
    /// Bars of each colour.
    pub series: Vec<BarSeries>,
    /// Levels to compare with.
    pub references: Vec<ReferenceLine>,
    /// Smallest and largest height shown; 0 to the highest when `None`.
    pub y_range: Option<[f64; 2]>,
}

pub fn draw(chart: &BarChart, canvas: &Canvas<'_, '_>) -> Drawn {
    let names: Vec<&str> = chart.series.iter().map(|s| s.name.as_str()).collect();
    let top = canvas.head(&chart.title, &names)?;
    let [low, high] = y_range(chart);
    let values = ticks::nice(low, high, 5);
    let lines = wrapped(chart, canvas);
    let deepest = lines.iter().map(Vec::len).max().unwrap_or(1);
    let frame = canvas.frame(top, 16.0 + 17.0 * deepest as f64, &values);
    let height =
        |v: f64| frame.bottom - (v.clamp(low, high) - low) / (high - low) * (frame.bottom - frame.top);
    let step = step_of(&values);
    let placed: Vec<(f64, String)> = values.iter().map(|v| (height(*v), ticks::text(*v, step))).collect();
    canvas.y_axis(&frame, &chart.y_label, &placed)?;
    let group_width = (frame.right - frame.left) / chart.groups.len().max(1) as f64;
    for (group, lines) in lines.iter().enumerate() {
        let left = frame.left + group_width * group as f64;
        for (row, line) in lines.iter().enumerate() {
            let at = [left + 0.5 * group_width, frame.bottom + 7.0 + 17.0 * row as f64];
            canvas.text(line, at, LABEL, INK, Hang::Below)?;
        }
        draw_group(chart, canvas, group, [left, group_width], &frame, &height)?;
    }
    canvas.stroke(&[[frame.left, frame.bottom], [frame.right, frame.bottom]], SOFT, 1.0)?;
    for line in &chart.references {
        let y = height(line.y);
        canvas.dashes([frame.left, y], [frame.right, y], INK)?;
        canvas.text(&line.label, [frame.right - 4.0, y - 9.0], SMALL, INK, Hang::Right)?;
    }
    Ok(())
}

fn y_range(chart: &BarChart) -> [f64; 2] {
    if let Some([low, high]) = chart.y_range.filter(|[low, high]| high > low) {
        return [low, high];
    }
    let values = chart.series.iter().flat_map(|s| s.values.iter().flatten().copied());
    let all = values.chain(chart.references.iter().map(|r| r.y)).filter(|v| v.is_finite());
    let (low, high) = all.fold((0.0_f64, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
    if high > low { [low * 1.08, high * 1.08] } else { [0.0, 1.0] }
}

/// The groups' names broken at spaces where they are wider than their group.
fn wrapped(chart: &BarChart, canvas: &Canvas<'_, '_>) -> Vec<Vec<String>> {
    let room = (canvas.width - 90.0) / chart.groups.len().max(1) as f64 - 8.0;
    let wrap = |name: &String| {
        let mut lines = vec![String::new()];
        for word in name.split(' ') {
            let last = lines.last().cloned().unwrap_or_default();
            let joined = if last.is_empty() { word.to_owned() } else { format!("{last} {word}") };
            if last.is_empty() || canvas.width_of(&joined, LABEL) <= room {
                lines.pop();
                lines.push(joined);
            } else {
                lines.push(word.to_owned());
            }
        }
        lines
    };
    chart.groups.iter().map(wrap).collect()
}

fn draw_group(
    chart: &BarChart,
    canvas: &Canvas<'_, '_>,
    group: usize,
    [left, group_width]: [f64; 2],
    frame: &Frame,
    height: &dyn Fn(f64) -> f64,
) -> Drawn {
    let width = group_width * FILLED / chart.series.len().max(1) as f64;
    for (index, series) in chart.series.iter().enumerate() {
        let from = left + 0.5 * (1.0 - FILLED) * group_width + width * index as f64;
        let middle = from + 0.5 * width;
        match series.values.get(group).copied().flatten().filter(|v| v.is_finite()) {
            Some(value) => {
                let (base, y) = (height(0.0).min(frame.bottom), height(value));
                let (upper, lower) = (y.min(base), y.max(base));
                let bar = Frame { left: from + 1.0, top: upper, right: from + width - 1.0, bottom: lower };
                canvas.fill(bar, color(index))?;
                let text = short(value);
                if canvas.width_of(&text, SMALL) <= width + 4.0 {
                    canvas.text(&text, [middle, upper - 3.0], SMALL, INK, Hang::Above)?;
                }
            }
            None => canvas.text("–", [middle, frame.bottom - 4.0], SMALL, SOFT, Hang::Above)?,
        }
    }
    Ok(())
}

/// A value in about three digits.
fn short(value: f64) -> String {
    match value.abs() {
        v if v >= 100.0 => format!("{value:.0}"),
        v if v >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}
