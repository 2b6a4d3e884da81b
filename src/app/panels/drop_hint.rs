//! What would happen if the file over the window were dropped.

use egui::{Align2, Color32, Context, FontId, Id, LayerId, Order, Stroke, StrokeKind};

use crate::app::theme;

/// Endings of rooms.
const ROOMS: [&str; 4] = ["glb", "gltf", "obj", "ply"];
/// Endings of projects.
const PROJECTS: [&str; 2] = ["ron", "inhabit"];

/// Draws the hint while a file is held over the window.
pub fn drop_hint(ctx: &Context) {
    let Some(file) = ctx.input(|i| i.raw.hovered_files.first().cloned()) else { return };
    let name = file.path.as_deref().and_then(|p| p.file_name()).map(|n| n.to_string_lossy().into_owned());
    let name = name.unwrap_or_else(|| "this file".to_owned());
    let ending = name.rsplit('.').next().unwrap_or_default().to_lowercase();
    let text = if ROOMS.contains(&ending.as_str()) {
        format!("Open {name} as a room, or add it to the things that people use")
    } else if PROJECTS.contains(&ending.as_str()) {
        format!("Open the project {name}")
    } else {
        format!("{name}: rooms are GLB, glTF, OBJ or PLY, projects .inhabit or .ron")
    };
    let painter = ctx.layer_painter(LayerId::new(Order::Foreground, Id::unique("drop hint")));
    let rect = ctx.content_rect();
    let accent = theme::palette(&ctx.global_style().visuals).accent;
    painter.rect_filled(rect, 0.0, Color32::from_black_alpha(150));
    painter.rect_stroke(rect.shrink(10.0), 8.0, Stroke::new(2.0, accent), StrokeKind::Inside);
    painter.text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(20.0), Color32::WHITE);
}
