use plotters::style::RGBColor;

use super::canvas::{Canvas, Drawn, Frame, Hang, INK, LABEL, SMALL, SOFT, color};

/// A density over the floor plan around somebody, seen from above.
#[derive(Clone, Default)]
pub struct PolarPanel {
    /// Title over the panel.
    pub title: String,
    /// A line under the title.
    pub note: String,
    /// Density at (to the right, to the front), any unit; darkest where it is largest.
    pub density: Option<std::sync::Arc<dyn Fn(f64, f64) -> f64 + Send + Sync>>,
    /// Places (to the right, to the front) that are marked.
    pub points: Vec<[f64; 2]>,
    /// Half the panel's width in the places' unit.
    pub reach: f64,
    /// Distance of the rings from one another.
    pub ring: f64,
    /// Whether the middle is a person, whose front is upwards, or an object.
    pub person: bool,
}

/// Panels side by side.
#[derive(Clone, Default)]
pub struct PolarChart {
    /// Title over all.
    pub title: String,
    /// Row by row.
    pub panels: Vec<PolarPanel>,
    /// Panels in a row.
    pub columns: usize,
    /// Unit of the rings.
    pub unit: String,
}

/// Side of a panel's cells in pixels.
const CELL: f64 = 4.0;
/// Room over a panel for its title and note.
const HEAD: f64 = 40.0;

pub fn draw(chart: &PolarChart, canvas: &Canvas<'_, '_>) -> Drawn {
    let top = canvas.head(&chart.title, &[])?;
    let columns = chart.columns.max(1);
    let rows = chart.panels.len().div_ceil(columns).max(1);
    let (width, height) = (canvas.width / columns as f64, (canvas.height - top) / rows as f64);
    for (index, panel) in chart.panels.iter().enumerate() {
        let (column, row) = ((index % columns) as f64, (index / columns) as f64);
        let left = column * width;
        let frame =
            Frame { left, top: top + row * height, right: left + width, bottom: top + (row + 1.0) * height };
        draw_panel(panel, &chart.unit, &frame, canvas)?;
    }
    Ok(())
}

fn draw_panel(panel: &PolarPanel, unit: &str, frame: &Frame, canvas: &Canvas<'_, '_>) -> Drawn {
    let radius = 0.5 * (frame.right - frame.left - 24.0).min(frame.bottom - frame.top - HEAD - 12.0);
    let middle = [0.5 * (frame.left + frame.right), frame.top + HEAD + radius];
    canvas.text(&panel.title, [middle[0], frame.top + 2.0], LABEL, INK, Hang::Below)?;
    canvas.text(&panel.note, [middle[0], frame.top + 20.0], SMALL, SOFT, Hang::Below)?;
    if radius < 10.0 || panel.reach <= 0.0 {
        return Ok(());
    }
    let scale = radius / panel.reach;
    if let Some(density) = &panel.density {
        draw_density(density.as_ref(), middle, radius, scale, canvas)?;
    }
    draw_rings(panel, unit, middle, scale, canvas)?;
    for [x, y] in &panel.points {
        if x.hypot(*y) <= panel.reach {
            canvas.disk([middle[0] + x * scale, middle[1] - y * scale], 1.6, color(5))?;
        }
    }
    draw_middle(panel.person, middle, canvas)
}

fn draw_density(
    density: &dyn Fn(f64, f64) -> f64,
    middle: [f64; 2],
    radius: f64,
    scale: f64,
    canvas: &Canvas<'_, '_>,
) -> Drawn {
    let cells = (2.0 * radius / CELL) as i32;
    let offset = |i: i32| -radius + (f64::from(i) + 0.5) * CELL;
    let inside = |x: f64, y: f64| x.hypot(y) <= radius;
    let mut values = Vec::new();
    for row in 0..cells {
        for column in 0..cells {
            let (x, y) = (offset(column), offset(row));
            if inside(x, y) {
                let value = density(x / scale, -y / scale);
                values.push((x, y, if value.is_finite() { value } else { 0.0 }));
            }
        }
    }
    // The brightest cells beside the pole would hide all others: the scale ends at the 99th percentile.
    let mut sorted: Vec<f64> = values.iter().map(|v| v.2).collect();
    sorted.sort_by(f64::total_cmp);
    let most = sorted.get(sorted.len() * 99 / 100).copied().unwrap_or(0.0);
    for (x, y, value) in values {
        let share = if most > 0.0 { (value / most).clamp(0.0, 1.0).sqrt() } else { 0.0 };
        if share > 0.03 {
            let (left, top) = (middle[0] + x - 0.5 * CELL, middle[1] + y - 0.5 * CELL);
            canvas.fill(Frame { left, top, right: left + CELL, bottom: top + CELL }, shade(share))?;
        }
    }
    Ok(())
}

/// White to blue.
fn shade(share: f64) -> RGBColor {
    let mix = |to: u8| (255.0 + (f64::from(to) - 255.0) * share) as u8;
    let blue = color(0);
    RGBColor(mix(blue.0), mix(blue.1), mix(blue.2))
}

fn draw_rings(
    panel: &PolarPanel,
    unit: &str,
    middle: [f64; 2],
    scale: f64,
    canvas: &Canvas<'_, '_>,
) -> Drawn {
    let rings = (panel.reach / panel.ring.max(1e-9)).min(12.0) as usize;
    for ring in 1..=rings {
        let r = ring as f64 * panel.ring;
        let points: Vec<[f64; 2]> = (0..=72)
            .map(|i| {
                let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 72.0).sin_cos();
                [middle[0] + r * scale * cos, middle[1] + r * scale * sin]
            })
            .collect();
        canvas.stroke(&points, RGBColor(196, 202, 210), 0.8)?;
        let text = if ring == rings { format!("{r} {unit}") } else { format!("{r}") };
        canvas.text(&text, [middle[0], middle[1] - r * scale], SMALL, SOFT, Hang::Below)?;
    }
    Ok(())
}

/// A head and shoulders with a nose towards the front, or a square.
fn draw_middle(person: bool, [x, y]: [f64; 2], canvas: &Canvas<'_, '_>) -> Drawn {
    if !person {
        return canvas.fill(Frame { left: x - 4.0, top: y - 4.0, right: x + 4.0, bottom: y + 4.0 }, INK);
    }
    canvas.stroke(&[[x - 9.0, y], [x + 9.0, y]], INK, 4.0)?;
    canvas.stroke(&[[x, y], [x, y - 9.0]], INK, 2.0)?;
    canvas.disk([x, y], 4.5, INK)
}
