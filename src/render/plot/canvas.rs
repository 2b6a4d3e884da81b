//! The sheet that charts are drawn on: title, legend, axes, text. Drawn at twice the size and averaged, so that
//! edges and letters are smooth.

use std::sync::OnceLock;

use plotters::prelude::{
    BitMapBackend, Circle, DrawingArea, EmptyElement, IntoDrawingArea, IntoFont, PathElement, Rectangle, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, RGBColor, ShapeStyle, TextStyle, register_font};

use super::{LEAST_SIDE, MOST_SIDE, PlotError, ticks};
use crate::render::Picture;

/// Drawn this many times as big, then averaged.
const OVERSAMPLE: u32 = 2;
/// Name of the embedded font.
const FONT: &str = "inhabit";
/// Text and axes.
pub const INK: RGBColor = RGBColor(38, 42, 48);
/// Lesser text.
pub const SOFT: RGBColor = RGBColor(104, 110, 120);
/// Grid lines.
const GRID: RGBColor = RGBColor(228, 231, 235);
/// Colours of the curves, told apart with colour-blind eyes too (after Okabe and Ito 2008).
const PALETTE: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 141, 0),
    RGBColor(0, 148, 109),
    RGBColor(204, 80, 140),
    RGBColor(86, 160, 220),
    RGBColor(200, 72, 16),
    RGBColor(120, 100, 190),
    RGBColor(110, 110, 110),
];

/// Font sizes in pixels.
pub const TITLE: f64 = 19.0;
/// Size of labels and legend.
pub const LABEL: f64 = 14.0;
/// Size of ticks and notes.
pub const SMALL: f64 = 12.5;

/// What drawing functions return; the text says what went wrong.
pub type Drawn = Result<(), String>;

/// The colour of curve or series `index`.
pub fn color(index: usize) -> RGBColor {
    PALETTE[index % PALETTE.len()]
}

/// Where text hangs on its point.
#[derive(Clone, Copy, Debug)]
pub enum Hang {
    /// Its left end, middle height.
    Left,
    /// Its right end, middle height.
    Right,
    /// Its middle, the text below the point.
    Below,
    /// Its middle, the text above the point.
    Above,
}

/// A rectangle in pixels.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Left border.
    pub left: f64,
    /// Upper border.
    pub top: f64,
    /// Right border.
    pub right: f64,
    /// Lower border.
    pub bottom: f64,
}

/// The sheet; positions and sizes in pixels of the finished picture.
pub struct Canvas<'a, 'b> {
    area: &'a DrawingArea<BitMapBackend<'b>, plotters::coord::Shift>,
    /// Columns.
    pub width: f64,
    /// Rows.
    pub height: f64,
}

/// A picture painted by `paint` on a white sheet.
pub fn painted(
    size: [u32; 2],
    title: &str,
    paint: impl FnOnce(&Canvas<'_, '_>) -> Drawn,
) -> Result<Picture, PlotError> {
    let [width, height] = size;
    let allowed = LEAST_SIDE..=MOST_SIDE;
    if !allowed.contains(&width) || !allowed.contains(&height) {
        return Err(PlotError::Size { width, height });
    }
    let big = (width * OVERSAMPLE, height * OVERSAMPLE);
    let mut rgb = vec![255_u8; big.0 as usize * big.1 as usize * 3];
    let refused = |detail: String| PlotError::Draw { title: title.to_owned(), detail };
    font().map_err(refused)?;
    {
        let area = BitMapBackend::with_buffer(&mut rgb, big).into_drawing_area();
        let canvas = Canvas { area: &area, width: f64::from(width), height: f64::from(height) };
        paint(&canvas).map_err(refused)?;
        area.present().map_err(|e| refused(e.to_string()))?;
    }
    Ok(Picture { width, height, rgba: averaged(&rgb, size), backend: "plotters".into() })
}

fn font() -> Drawn {
    static FONTS: OnceLock<bool> = OnceLock::new();
    let known = FONTS
        .get_or_init(|| register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok());
    if *known { Ok(()) } else { Err("the embedded font can't be read".into()) }
}

fn averaged(rgb: &[u8], [width, height]: [u32; 2]) -> Vec<u8> {
    let n = OVERSAMPLE as usize;
    let row = width as usize * n * 3;
    let mut rgba = Vec::with_capacity(width as usize * height as usize * 4);
    for y in 0..height as usize {
        for x in 0..width as usize {
            for channel in 0..3 {
                let at = |i: usize| (y * n + i / n) * row + (x * n + i % n) * 3 + channel;
                let sum: u32 = (0..n * n).map(|i| u32::from(rgb[at(i)])).sum();
                rgba.push((sum / (n * n) as u32) as u8);
            }
            rgba.push(255);
        }
    }
    rgba
}

fn big(v: f64) -> i32 {
    (v * f64::from(OVERSAMPLE)).round().clamp(-1e6, 1e6) as i32
}

fn style(size: f64, color: RGBColor) -> TextStyle<'static> {
    (FONT, size * f64::from(OVERSAMPLE)).into_font().color(&color)
}

impl Canvas<'_, '_> {
    /// A stroke through points.
    pub fn stroke(&self, points: &[[f64; 2]], color: RGBColor, width: f64) -> Drawn {
        let points: Vec<(i32, i32)> = points.iter().map(|[x, y]| (big(*x), big(*y))).collect();
        let stroke =
            ShapeStyle { color: color.to_rgba(), filled: false, stroke_width: big(width).max(1) as u32 };
        self.area.draw(&PathElement::new(points, stroke)).map_err(|e| e.to_string())
    }

    /// A dashed straight line.
    pub fn dashes(&self, from: [f64; 2], to: [f64; 2], color: RGBColor) -> Drawn {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let at =
            |s: f64| [from[0] + (to[0] - from[0]) * s / length, from[1] + (to[1] - from[1]) * s / length];
        let pieces = (length / 8.0).ceil() as usize;
        (0..pieces).try_for_each(|i| {
            let start = i as f64 * 8.0;
            self.stroke(&[at(start), at((start + 4.5).min(length))], color, 1.0)
        })
    }

    /// A filled disk.
    pub fn disk(&self, at: [f64; 2], radius: f64, color: RGBColor) -> Drawn {
        let disk =
            EmptyElement::at((big(at[0]), big(at[1]))) + Circle::new((0, 0), big(radius), color.filled());
        self.area.draw(&disk).map_err(|e| e.to_string())
    }

    /// A filled rectangle.
    pub fn fill(&self, frame: Frame, color: RGBColor) -> Drawn {
        let corners = [(big(frame.left), big(frame.top)), (big(frame.right), big(frame.bottom))];
        self.area.draw(&Rectangle::new(corners, color.filled())).map_err(|e| e.to_string())
    }

    /// A line of text.
    pub fn text(&self, text: &str, at: [f64; 2], size: f64, color: RGBColor, hang: Hang) -> Drawn {
        let pos = match hang {
            Hang::Left => Pos::new(HPos::Left, VPos::Center),
            Hang::Right => Pos::new(HPos::Right, VPos::Center),
            Hang::Below => Pos::new(HPos::Center, VPos::Top),
            Hang::Above => Pos::new(HPos::Center, VPos::Bottom),
        };
        let style = style(size, color).pos(pos);
        let text = Text::new(text.to_owned(), (big(at[0]), big(at[1])), style);
        self.area.draw(&text).map_err(|e| e.to_string())
    }

    /// Text that reads upwards, its middle at the point.
    pub fn upright(&self, text: &str, at: [f64; 2], size: f64, color: RGBColor) -> Drawn {
        let font = (FONT, size * f64::from(OVERSAMPLE)).into_font().transform(FontTransform::Rotate270);
        let style = TextStyle::from(font).color(&color).pos(Pos::new(HPos::Center, VPos::Center));
        let text = Text::new(text.to_owned(), (big(at[0]), big(at[1])), style);
        self.area.draw(&text).map_err(|e| e.to_string())
    }

    /// Width of a line of text in pixels.
    pub fn width_of(&self, text: &str, size: f64) -> f64 {
        let measured = self.area.estimate_text_size(text, &style(size, INK));
        measured.map_or(0.0, |(width, _)| f64::from(width) / f64::from(OVERSAMPLE))
    }

    /// Draws title and legend (of more than one name); gives the height that they take.
    pub fn head(&self, title: &str, names: &[&str]) -> Result<f64, String> {
        let mut y = 26.0;
        if !title.is_empty() {
            self.text(title, [18.0, y], TITLE, INK, Hang::Left)?;
            y += 26.0;
        }
        if names.len() < 2 {
            return Ok(y);
        }
        let mut x = 18.0;
        for (index, name) in names.iter().enumerate() {
            let width = 20.0 + self.width_of(name, LABEL) + 18.0;
            if x + width > self.width && x > 18.0 {
                (x, y) = (18.0, y + 20.0);
            }
            let swatch = Frame { left: x, top: y - 5.0, right: x + 14.0, bottom: y + 5.0 };
            self.fill(swatch, color(index))?;
            self.text(name, [x + 20.0, y], LABEL, INK, Hang::Left)?;
            x += width;
        }
        Ok(y + 22.0)
    }

    /// Draws the y axis: grid lines with their numbers left of them, and what it shows.
    pub fn y_axis(&self, frame: &Frame, label: &str, ticks: &[(f64, String)]) -> Drawn {
        for (y, text) in ticks {
            self.stroke(&[[frame.left, *y], [frame.right, *y]], GRID, 1.0)?;
            self.text(text, [frame.left - 8.0, *y], SMALL, SOFT, Hang::Right)?;
        }
        self.upright(label, [16.0, 0.5 * (frame.top + frame.bottom)], LABEL, SOFT)
    }

    /// The frame that is left below `top` for the data, given the texts of the y ticks.
    pub fn frame(&self, top: f64, bottom_margin: f64, y_ticks: &[f64]) -> Frame {
        let step = step_of(y_ticks);
        let widest = y_ticks.iter().map(|t| self.width_of(&ticks::text(*t, step), SMALL)).fold(0.0, f64::max);
        Frame {
            left: 40.0 + widest,
            top: top + 4.0,
            right: self.width - 22.0,
            bottom: self.height - bottom_margin,
        }
    }
}

/// The smallest step between neighbouring ticks; a lone tick's own size.
pub fn step_of(ticks: &[f64]) -> f64 {
    let step = ticks.windows(2).map(|w| (w[1] - w[0]).abs()).fold(f64::INFINITY, f64::min);
    let lone = ticks.first().map_or(1.0, |t| t.abs().max(0.1));
    if step.is_finite() { step } else { lone }
}
