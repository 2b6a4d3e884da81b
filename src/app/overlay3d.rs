//! What is painted over the 3-D view: the axes, which can be clicked, and the legend of the heat map.

use egui::{Align2, Color32, FontId, Mesh, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};
use glam::Vec3;

use super::actions;

use super::orbit::AxisView;
use super::state::{EditorState, Heat};
use crate::render::DEEP_END_M;
use crate::render::FREE_END_M;
use crate::render::TICKS;
use crate::render::heat_color;
use crate::render::heat_position;

/// Length of an axis of the gizmo in points.
const AXIS_POINTS: f32 = 30.0;

/// The axes in the upper right corner; a click on an end looks along it.
pub fn axes(ui: &Ui, state: &mut EditorState, rect: Rect) {
    if rect.width() < 200.0 || rect.height() < 160.0 {
        return;
    }
    let middle = rect.right_top() + vec2(-52.0, 52.0);
    let camera = state.orbit.camera();
    let (right, up) = camera.right_up();
    let place = |axis: Vec3| middle + vec2(axis.dot(right), -axis.dot(up)) * AXIS_POINTS;
    let mut ends: Vec<(Vec3, Color32, &str, AxisView, bool)> = vec![
        (Vec3::X, Color32::from_rgb(222, 86, 86), "X", AxisView::Right, true),
        (Vec3::Y, Color32::from_rgb(120, 186, 72), "Y", AxisView::Top, true),
        (Vec3::Z, Color32::from_rgb(84, 140, 226), "Z", AxisView::Front, true),
        (Vec3::NEG_X, Color32::from_rgb(222, 86, 86), "-X", AxisView::Left, false),
        (Vec3::NEG_Y, Color32::from_rgb(120, 186, 72), "-Y", AxisView::Bottom, false),
        (Vec3::NEG_Z, Color32::from_rgb(84, 140, 226), "-Z", AxisView::Back, false),
    ];
    ends.sort_by(|a, b| b.0.dot(camera.forward()).total_cmp(&a.0.dot(camera.forward())));
    ui.painter().circle_filled(middle, AXIS_POINTS + 14.0, Color32::from_black_alpha(40));
    for (axis, color, name, view, positive) in ends {
        let end = place(axis);
        axis_end(ui, middle, end, color, name, positive);
        let id = ui.scope_id().with(("axis", name));
        let response = ui.interact(Rect::from_center_size(end, vec2(18.0, 18.0)), id, Sense::click());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Button, true, format!("Look along {name}"))
        });
        if response.clicked() {
            actions::view(state, view);
        }
    }
}

fn axis_end(ui: &Ui, middle: Pos2, end: Pos2, color: Color32, name: &str, positive: bool) {
    let painter = ui.painter();
    if positive {
        painter.line_segment([middle, end], Stroke::new(2.0, color));
        painter.circle_filled(end, 8.0, color);
        painter.text(end, Align2::CENTER_CENTER, name, FontId::proportional(11.0), Color32::from_gray(16));
    } else {
        painter.circle(end, 6.0, color.gamma_multiply(0.25), Stroke::new(1.5, color.gamma_multiply(0.8)));
    }
}

/// The colour scale of the heat map with its marks in millimetres.
pub fn legend(ui: &Ui, state: &EditorState, rect: Rect) {
    if state.view.heat == Heat::Off || rect.height() < 220.0 {
        return;
    }
    let height = (rect.height() - 120.0).min(190.0);
    let frame =
        Rect::from_min_size(rect.left_bottom() + vec2(12.0, -height - 48.0), vec2(128.0, height + 36.0));
    let painter = ui.painter();
    painter.rect_filled(frame, 6.0, Color32::from_black_alpha(150));
    let text = |at: Pos2, align: Align2, text: &str, size: f32| {
        painter.text(at, align, text, FontId::proportional(size), Color32::from_gray(235));
    };
    text(frame.left_top() + vec2(10.0, 6.0), Align2::LEFT_TOP, "Distance to the room", 11.0);
    let bar = Rect::from_min_size(frame.left_top() + vec2(10.0, 26.0), vec2(14.0, height));
    painter.add(gradient(bar));
    for tick in TICKS {
        let y = bar.top() + heat_position(tick.distance_m) * bar.height();
        painter.line_segment(
            [pos2(bar.right(), y), pos2(bar.right() + 4.0, y)],
            Stroke::new(1.0, Color32::from_gray(220)),
        );
        text(pos2(bar.right() + 8.0, y), Align2::LEFT_CENTER, tick.label, 11.0);
    }
}

/// The bar, from free space at the top to deep inside at the bottom.
fn gradient(bar: Rect) -> Shape {
    let (free_m, deep_m) = (FREE_END_M, DEEP_END_M);
    let steps = 64;
    let mut mesh = Mesh::default();
    for i in 0..=steps {
        let share = i as f32 / steps as f32;
        let [r, g, b] = heat_color(free_m + (deep_m - free_m) * share);
        let y = bar.top() + share * bar.height();
        for x in [bar.left(), bar.right()] {
            mesh.colored_vertex(pos2(x, y), Color32::from_rgb(r, g, b));
        }
        if i > 0 {
            let v = 2 * i as u32;
            mesh.add_triangle(v - 2, v - 1, v);
            mesh.add_triangle(v - 1, v, v + 1);
        }
    }
    Shape::mesh(mesh)
}
