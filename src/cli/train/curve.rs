//! Curves of the pose prior's training, as numbers and as a picture.

use crate::assets::encode_png;
use crate::learn::PosePriorPoint;
use crate::render::plot::{Curve, LineChart, Scale, line_chart};

/// One line a point.
pub fn csv(curve: &[PosePriorPoint]) -> String {
    let row = |p: &PosePriorPoint| {
        format!(
            "{},{:.3},{:.3},{:.2},{:.2},{:.2}\n",
            p.step, p.loss, p.divergence, p.training_mm, p.held_out_clips_mm, p.held_out_families_mm
        )
    };
    let head = "step,loss_nats,divergence_nats,training_mm,held_out_clips_mm,held_out_families_mm\n";
    head.to_owned() + &curve.iter().map(row).collect::<String>()
}

/// Errors in millimetres and the divergence over the steps, as a PNG.
///
/// # Errors
/// When the chart can't be drawn.
pub fn curve_png(points: &[PosePriorPoint]) -> anyhow::Result<Vec<u8>> {
    let curve = |name: &str, of: fn(&PosePriorPoint) -> f32| Curve {
        name: name.to_owned(),
        points: points.iter().map(|p| [p.step as f64, f64::from(of(p))]).collect(),
    };
    let chart = LineChart {
        title: "Training of the pose prior".to_owned(),
        x_label: "step".to_owned(),
        y_label: "mm, nats".to_owned(),
        curves: vec![
            curve("training, with noise, mm rms", |p| p.training_mm),
            curve("held-out clips, joints, mm", |p| p.held_out_clips_mm),
            curve("held-out families, joints, mm", |p| p.held_out_families_mm),
            curve("divergence, nats", |p| p.divergence),
        ],
        y_scale: Scale::Log,
        ..LineChart::default()
    };
    let picture = line_chart(&chart, [900, 480])?;
    Ok(encode_png(picture.width, picture.height, &picture.rgba)?)
}
