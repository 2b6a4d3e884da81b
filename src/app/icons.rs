//! Small pictures on buttons, drawn from lines: no font has to have them.

use egui::{Color32, Pos2, Rect, Response, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, pos2, vec2};

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Icon {
    /// An open eye.
    Eye,
    /// A closed eye.
    EyeClosed,
    /// A closed padlock.
    Lock,
    /// An open padlock.
    Unlock,
    /// A bell.
    Bell,
    /// A cross.
    Close,
    /// A die: another one.
    Dice,
    /// A crossed circle: never.
    Ban,
    /// Two views side by side.
    Beside,
}

/// A square button without frame that shows `icon` and is called `name` by screen readers and tooltip.
pub fn button(ui: &mut Ui, icon: Icon, name: &str, strength: f32) -> Response {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(18.0), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, ui.is_enabled(), name));
    if ui.is_rect_visible(rect) {
        let visuals = ui.style().interact(&response);
        if response.hovered() || response.has_focus() {
            ui.painter().rect_filled(rect, 4.0, visuals.bg_fill);
        }
        let full = response.hovered() || response.has_focus();
        let color = visuals.text_color().gamma_multiply(if full { 1.0 } else { strength });
        paint(ui, icon, rect.shrink(3.0), color);
    }
    response.on_hover_text(name)
}

/// Draws `icon` into `rect`.
pub fn paint(ui: &Ui, icon: Icon, rect: Rect, color: Color32) {
    let painter = ui.painter();
    let stroke = Stroke::new(1.3, color);
    let at = |x: f32, y: f32| -> Pos2 { rect.min + vec2(x * rect.width(), y * rect.height()) };
    let line = |points: Vec<Pos2>| {
        painter.line(points, stroke);
    };
    match icon {
        Icon::Eye => {
            line(arc(&at, 0.5, 0.86, 0.62, 215.0, 325.0));
            line(arc(&at, 0.5, 0.14, 0.62, 35.0, 145.0));
            painter.circle_filled(at(0.5, 0.5), rect.width() * 0.15, color);
        }
        Icon::EyeClosed => {
            line(arc(&at, 0.5, 0.14, 0.62, 35.0, 145.0));
            for (from, to) in
                [((0.2, 0.68), (0.1, 0.86)), ((0.5, 0.76), (0.5, 0.98)), ((0.8, 0.68), (0.9, 0.86))]
            {
                line(vec![at(from.0, from.1), at(to.0, to.1)]);
            }
        }
        Icon::Lock | Icon::Unlock => {
            let body = Rect::from_min_max(at(0.15, 0.48), at(0.85, 1.0));
            painter.rect_filled(body, 1.5, color);
            let shift = if icon == Icon::Lock { 0.0 } else { 0.34 };
            let mut shackle = arc(&at, 0.5 + shift, 0.3, 0.24, 180.0, 360.0);
            shackle.insert(0, at(0.26 + shift, 0.48));
            if icon == Icon::Lock {
                shackle.push(at(0.74, 0.48));
            }
            line(shackle);
        }
        Icon::Bell => {
            let mut bell = arc(&at, 0.5, 0.4, 0.3, 180.0, 360.0);
            bell.insert(0, at(0.08, 0.8));
            bell.insert(1, at(0.2, 0.66));
            bell.extend([at(0.8, 0.66), at(0.92, 0.8), at(0.08, 0.8)]);
            line(bell);
            painter.circle_filled(at(0.5, 0.94), rect.width() * 0.09, color);
        }
        Icon::Dice => {
            let stroke = Stroke::new(1.2, color);
            painter.rect_stroke(rect, 2.5, stroke, egui::StrokeKind::Inside);
            for (x, y) in [(0.3, 0.3), (0.7, 0.3), (0.5, 0.5), (0.3, 0.7), (0.7, 0.7)] {
                painter.circle_filled(at(x, y), rect.width() * 0.085, color);
            }
        }
        Icon::Ban => {
            painter.circle_stroke(at(0.5, 0.5), rect.width() * 0.44, stroke);
            line(vec![at(0.2, 0.8), at(0.8, 0.2)]);
        }
        Icon::Beside => {
            painter.rect_stroke(rect, 1.5, stroke, egui::StrokeKind::Inside);
            line(vec![at(0.5, 0.0), at(0.5, 1.0)]);
        }
        Icon::Close => {
            line(vec![at(0.15, 0.15), at(0.85, 0.85)]);
            line(vec![at(0.85, 0.15), at(0.15, 0.85)]);
        }
    }
}

/// Points of an arc about `(x, y)` with radius `r`, all as shares of the icon; degrees, clockwise from right.
fn arc(at: &impl Fn(f32, f32) -> Pos2, x: f32, y: f32, r: f32, from: f32, to: f32) -> Vec<Pos2> {
    let steps = 10;
    (0..=steps)
        .map(|i| {
            let angle = (from + (to - from) * i as f32 / steps as f32).to_radians();
            let p = at(x + r * angle.cos(), y + r * angle.sin());
            pos2(p.x, p.y)
        })
        .collect()
}
