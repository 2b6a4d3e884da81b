//! The timeline: play and step, and for each motion its sub-goals, legs, planted feet and, frame by frame, where it
//! sinks in, slides and touches. A click anywhere goes to that time.

use std::sync::Arc;

use egui::{
    Align2, Color32, DragValue, FontId, Pos2, Rect, Response, ScrollArea, Sense, Stroke, Ui, pos2, vec2,
};

use super::{command_button, empty};
use crate::app::actions;
use crate::app::day::ShownDay;
use crate::app::motion::SPEEDS;
use crate::app::selection::Item;
use crate::app::state::EditorState;
use crate::app::theme::{self, Palette};
use crate::inspect::FrameRecord;
use crate::inspect::MotionLimits;
use crate::inspect::MotionReport;
use crate::scene::CLIP_FPS;
use crate::scene::Clip;
use crate::scene::Leg;

/// Width of the names at the left, points.
const NAMES: f32 = 108.0;
/// Heights of a motion's rows, points.
const GOALS: f32 = 20.0;
const LEGS: f32 = 13.0;
const STRIP: f32 = 8.0;
const GAP: f32 = 2.0;
/// What the colours mean is left out where there is less room for it than this, points.
const LEGEND: f32 = 215.0;
/// Height of the ruler.
const RULER: f32 = 18.0;

/// Draws the panel.
pub fn timeline(ui: &mut Ui, state: &mut EditorState) {
    let clips = state.document.scene().clips.clone();
    if clips.iter().all(|clip| clip.frames.is_empty()) && !state.jobs.moving() {
        empty(ui, "No motion yet. In the Motion panel, add sub-goals and press Synthesise.");
        return;
    }
    transport(ui, state);
    let length_s = state.play_seconds().max(1.0 / CLIP_FPS);
    let shown = state.shown_clips();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let scale = Scale::of(ui, length_s);
        ruler(ui, state, &scale);
        for clip in clips {
            let clip = shown.iter().find(|shown| shown.id == clip.id).cloned().unwrap_or(clip);
            track(ui, state, &scale, &clip);
        }
        cursor(ui, state, &scale);
    });
}

/// Where times are on the screen.
#[derive(Clone, Copy)]
struct Scale {
    left: f32,
    right: f32,
    top: f32,
    length_s: f32,
}

impl Scale {
    fn of(ui: &Ui, length_s: f32) -> Self {
        let rect = ui.available_rect_before_wrap();
        Self { left: rect.left() + NAMES, right: rect.right() - 10.0, top: rect.top(), length_s }
    }

    fn x(&self, seconds: f32) -> f32 {
        self.left + (self.right - self.left) * seconds / self.length_s
    }

    fn seconds(&self, x: f32) -> f32 {
        ((x - self.left) / (self.right - self.left).max(1.0) * self.length_s).clamp(0.0, self.length_s)
    }
}

fn transport(ui: &mut Ui, state: &mut EditorState) {
    ui.horizontal(|ui| {
        let can = state.can_play();
        ui.add_enabled_ui(can, |ui| {
            let playing = state.motion.player.playing;
            for (text, name, id) in [
                ("|<", "First frame", "first-frame"),
                ("<", "Previous frame", "previous-frame"),
                (if playing { "Pause" } else { "Play" }, "Play or pause", "play"),
                (">", "Next frame", "next-frame"),
                (">|", "Last frame", "last-frame"),
            ] {
                step_button(ui, state, text, name, id);
            }
        });
        frame_number(ui, state);
        let speed = state.motion.player.speed;
        let label = ui.label("Speed");
        egui::ComboBox::from_id_salt("speed")
            .selected_text(format!("{speed}x"))
            .width(62.0)
            .show_ui(ui, |ui| {
                for speed in SPEEDS {
                    ui.selectable_value(&mut state.motion.player.speed, speed, format!("{speed}x"));
                }
            })
            .response
            .labelled_by(label.id);
        ui.checkbox(&mut state.motion.player.looping, "Loop");
        command_button(ui, state, "insert-goal");
        if ui.available_width() > LEGEND {
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| legend(ui));
        }
    });
}

fn step_button(ui: &mut Ui, state: &mut EditorState, text: &str, name: &str, id: &str) {
    let Some(command) = crate::app::commands::find(id) else { return };
    let response = ui.button(text).on_hover_text(super::tip(command));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
    if response.clicked() {
        (command.run)(state);
    }
}

/// The frame as a number that can be typed, and the time.
fn frame_number(ui: &mut Ui, state: &mut EditorState) {
    let length_s = state.play_seconds();
    let last = (length_s * CLIP_FPS).round() as usize;
    let mut frame = (state.motion.player.seconds * CLIP_FPS).round() as usize;
    let label = ui.label("Frame");
    let response = ui.add(DragValue::new(&mut frame).range(0..=last)).labelled_by(label.id);
    if response.on_hover_text("Drag, or click and type").changed() {
        state.motion.player.seek(frame as f32 / CLIP_FPS, length_s);
    }
    ui.monospace(format!("{:5.2} / {length_s:.2} s", state.motion.player.seconds));
}

fn legend(ui: &mut Ui) {
    let palette = theme::palette(ui.visuals());
    for (color, text) in
        [(palette.bad, "beyond its limit"), (palette.warn, "near it"), (palette.good, "fine")]
    {
        ui.label(egui::RichText::new(text).small().weak());
        let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
        ui.painter().rect_filled(rect, 2.0, color);
    }
}

fn ruler(ui: &mut Ui, state: &mut EditorState, scale: &Scale) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), RULER), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, "Time ruler"));
    scrub(state, scale, &response);
    let every = [0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 300.0];
    let fits = |step: &&f32| (scale.right - scale.left) * **step / scale.length_s > 46.0;
    let step = every.iter().find(fits).copied().unwrap_or(600.0);
    let weak = ui.visuals().weak_text_color();
    let painter = ui.painter();
    let mut seconds = 0.0;
    while seconds <= scale.length_s + 1e-3 {
        let x = scale.x(seconds);
        painter.line_segment([pos2(x, rect.bottom() - 4.0), pos2(x, rect.bottom())], Stroke::new(1.0, weak));
        let text = if step < 1.0 { format!("{seconds:.1}") } else { format!("{seconds:.0} s") };
        painter.text(pos2(x, rect.top()), Align2::CENTER_TOP, text, FontId::proportional(10.0), weak);
        seconds += step;
    }
}

/// A click or a drag goes to that time.
fn scrub(state: &mut EditorState, scale: &Scale, response: &Response) {
    if (response.clicked() || response.dragged())
        && let Some(at) = response.interact_pointer_pos()
    {
        let length_s = state.play_seconds();
        state.motion.player.seek(scale.seconds(at.x), length_s);
    }
}

/// The rows of one motion.
fn track(ui: &mut Ui, state: &mut EditorState, scale: &Scale, clip: &Arc<Clip>) {
    let height = GOALS + LEGS + 2.0 * STRIP + 3.0 * STRIP + 6.0 * GAP;
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click_and_drag());
    let name = format!("Timeline of {}", clip.name);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, &name));
    let report = state.clip_report(clip).cloned();
    press(state, scale, clip, rect, &response);
    if let Some(at) = response.hover_pos().filter(|at| at.x > scale.left) {
        let seconds = scale.seconds(at.x);
        let told_of_day = state.day_of(clip.id).and_then(|day| day.told_at(seconds));
        let text = told_of_day.unwrap_or_else(|| told(clip, report.as_deref(), seconds));
        response.clone().on_hover_text_at_pointer(text);
    }
    if !ui.is_rect_visible(rect) {
        return;
    }
    let palette = theme::palette(ui.visuals());
    ui.painter().rect_filled(rect.with_min_x(scale.left), 3.0, ui.visuals().extreme_bg_color);
    let mut rows = Rows { y: rect.top() + GAP, scale: *scale };
    let active = state.motion.active == Some(clip.id);
    let title = if active { format!("> {}", clip.name) } else { clip.name.clone() };
    goals(ui, state, clip, rows.next(GOALS), scale, palette);
    names(ui, rect, &title, ui.visuals().strong_text_color());
    match state.day_of(clip.id) {
        Some(day) => actions_of_day(ui, day, rows.next(LEGS), scale, palette),
        None => legs(ui, clip, rows.next(LEGS), scale, palette),
    }
    feet(ui, clip, [rows.next(STRIP), rows.next(STRIP)], scale);
    let strips =
        [("sinks in", rows.next(STRIP)), ("slides", rows.next(STRIP)), ("touches", rows.next(STRIP))];
    for (row, (label, area)) in strips.into_iter().enumerate() {
        row_name(ui, rect.left(), area, label);
        if let Some(report) = &report {
            strip(ui, clip, report, area, scale, row);
        }
    }
}

struct Rows {
    y: f32,
    scale: Scale,
}

impl Rows {
    fn next(&mut self, height: f32) -> Rect {
        let rect = Rect::from_min_max(pos2(self.scale.left, self.y), pos2(self.scale.right, self.y + height));
        self.y += height + GAP;
        rect
    }
}

/// A click on a sub-goal selects it; anything else goes to that time.
fn press(state: &mut EditorState, scale: &Scale, clip: &Arc<Clip>, rect: Rect, response: &Response) {
    let Some(at) = response.interact_pointer_pos() else { return };
    if response.clicked() || response.drag_started() {
        state.activate_clip(clip.id);
    }
    if response.clicked() && at.x < scale.left {
        state.selection.only(Item::Clip(clip.id));
        return;
    }
    if response.clicked() && at.y < rect.top() + GOALS + GAP {
        let near =
            stops(clip).into_iter().find(|(_, frame)| (scale.x(*frame as f32 / clip.fps) - at.x).abs() < 8.0);
        if let Some((goal, frame)) = near {
            state.selection.only(Item::Goal(clip.id, goal));
            actions::go_to_frame(state, clip, frame);
            return;
        }
    }
    scrub(state, scale, response);
}

/// When the motion is at each sub-goal.
fn stops(clip: &Clip) -> Vec<(crate::scene::SubGoalId, usize)> {
    let of = |goal: &crate::scene::SubGoal| {
        let arrives = clip.legs.iter().find(|leg| leg.to == goal.id).map(|leg| leg.last);
        let frame = arrives.or_else(|| clip.legs.iter().find(|leg| leg.from == goal.id).map(|leg| leg.first));
        Some((goal.id, frame?))
    };
    clip.goals.iter().filter_map(of).collect()
}

fn names(ui: &Ui, rect: Rect, title: &str, color: Color32) {
    let painter = ui.painter().with_clip_rect(rect.with_max_x(rect.left() + NAMES - 6.0));
    painter.text(
        rect.left_top() + vec2(2.0, 3.0),
        Align2::LEFT_TOP,
        title,
        FontId::proportional(12.5),
        color,
    );
}

fn row_name(ui: &Ui, left: f32, area: Rect, text: &str) {
    let at = pos2(left + NAMES - 6.0, area.center().y);
    let color = ui.visuals().weak_text_color();
    ui.painter().text(at, Align2::RIGHT_CENTER, text, FontId::proportional(9.5), color);
}

fn goals(ui: &Ui, state: &EditorState, clip: &Clip, area: Rect, scale: &Scale, palette: &Palette) {
    let painter = ui.painter();
    let mut number = 0;
    for (id, frame) in stops(clip) {
        let Some(goal) = clip.goal(id) else { continue };
        let at = pos2(scale.x(frame as f32 / clip.fps), area.center().y);
        let selected = state.selection.contains(Item::Goal(clip.id, id));
        let edge = Stroke::new(if selected { 2.0 } else { 0.0 }, ui.visuals().strong_text_color());
        if goal.planned {
            painter.circle(at, 3.0, ui.visuals().weak_text_color(), edge);
            continue;
        }
        number += 1;
        painter.circle(at, 7.5, palette.accent, edge);
        let font = FontId::proportional(10.0);
        painter.text(at, Align2::CENTER_CENTER, number.to_string(), font, palette.on_accent);
    }
}

fn legs(ui: &Ui, clip: &Clip, area: Rect, scale: &Scale, palette: &Palette) {
    row_name(ui, area.left() - NAMES, area, "legs");
    let painter = ui.painter().with_clip_rect(area);
    for (i, leg) in clip.legs.iter().enumerate() {
        let span = Rect::from_min_max(
            pos2(scale.x(leg.first as f32 / clip.fps), area.top()),
            pos2(scale.x(leg.last as f32 / clip.fps) - 1.0, area.bottom()),
        );
        let shade = if i % 2 == 0 { 0.38 } else { 0.26 };
        let color = if leg.key == 0 { palette.warn } else { palette.accent };
        painter.rect_filled(span, 2.0, color.gamma_multiply(shade));
        let text = leg_text(clip, leg);
        if span.width() > 9.0 * text.len() as f32 * 0.62 {
            let color = ui.visuals().text_color();
            painter.text(span.center(), Align2::CENTER_CENTER, text, FontId::proportional(9.5), color);
        }
    }
}

/// When a day's actions are done.
fn actions_of_day(ui: &Ui, day: &ShownDay, area: Rect, scale: &Scale, palette: &Palette) {
    row_name(ui, area.left() - NAMES, area, "actions");
    for moment in &day.moments {
        let span = Rect::from_min_max(
            pos2(scale.x(moment.arrives_s), area.top()),
            pos2(scale.x(moment.leaves_s) - 1.0, area.bottom()),
        );
        let painter = ui.painter().with_clip_rect(span);
        painter.rect_filled(span, 2.0, palette.accent.gamma_multiply(0.45));
        let font = FontId::proportional(9.5);
        let left = span.left_center() + vec2(3.0, 0.0);
        painter.text(left, Align2::LEFT_CENTER, &moment.action, font, ui.visuals().text_color());
    }
}

/// What is done in a leg.
fn leg_text(clip: &Clip, leg: &Leg) -> String {
    if leg.key == 0 {
        return "to be made again".to_owned();
    }
    let what = clip.goal(leg.to).map_or("", |goal| crate::app::goal_marks::pose_label(goal.pose));
    if leg.from == leg.to { format!("stays: {what}") } else { format!("to {what}") }
}

/// When the left and the right foot is planted.
fn feet(ui: &Ui, clip: &Clip, areas: [Rect; 2], scale: &Scale) {
    let color = ui.visuals().text_color().gamma_multiply(0.55);
    for (foot, area) in areas.into_iter().enumerate() {
        row_name(ui, area.left() - NAMES, area, ["left foot", "right foot"][foot]);
        for (first, last) in runs(&clip.planted, foot) {
            let span = Rect::from_min_max(
                pos2(scale.x(first as f32 / clip.fps), area.top() + 1.0),
                pos2(scale.x((last + 1) as f32 / clip.fps).min(area.right()), area.bottom() - 1.0),
            );
            ui.painter().rect_filled(span, 1.5, color);
        }
    }
}

/// First and last frame of each stance of a foot.
fn runs(planted: &[[bool; 2]], foot: usize) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for frame in (0..planted.len()).filter(|frame| planted[*frame][foot]) {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == frame => *last = frame,
            _ => runs.push((frame, frame)),
        }
    }
    runs
}

/// How bad a frame is in one of the strips: 1 is at the limit.
fn badness(frame: &FrameRecord, row: usize) -> f32 {
    let limits = MotionLimits::default();
    match row {
        0 => frame.penetration_max_mm / limits.penetration_max_mm,
        1 => {
            let slides = frame.skate_cm_per_s[0].max(frame.skate_cm_per_s[1]);
            slides / (limits.skate_cm_per_s * MotionLimits::SINGLE_FRAME)
        }
        _ => {
            let hovers = frame.hover_mm / limits.hover_mm;
            if frame.contact { hovers } else { 2.0 }
        }
    }
}

/// One strip: each point of the screen shows the worst of its frames.
fn strip(ui: &Ui, clip: &Clip, report: &MotionReport, area: Rect, scale: &Scale, row: usize) {
    let palette = theme::palette(ui.visuals());
    let x = |frame: usize| scale.x(frame as f32 / clip.fps);
    let mut mesh = egui::Mesh::default();
    let (mut first, count) = (0, report.frames.len());
    while first < count {
        let next = (first + 1..=count).find(|next| x(*next) - x(first) >= 1.0).unwrap_or(count);
        let worst = report.frames[first..next].iter().map(|f| badness(f, row)).fold(0.0, f32::max);
        let span =
            Rect::from_min_max(pos2(x(first), area.top()), pos2(x(next).min(area.right()), area.bottom()));
        mesh.add_colored_rect(span, heat(palette, worst));
        first = next;
    }
    ui.painter().add(mesh);
}

fn heat(palette: &Palette, badness: f32) -> Color32 {
    match badness {
        b if b > 1.0 || b.is_nan() => palette.bad,
        b if b > 0.6 => palette.warn,
        b => palette.good.gamma_multiply(0.25 + 0.5 * b.max(0.0)),
    }
}

/// What is known of a moment.
fn told(clip: &Clip, report: Option<&MotionReport>, seconds: f32) -> String {
    let frame = clip.frame_at(seconds);
    let mut text = format!("{}: frame {frame}, {:.2} s", clip.name, frame as f32 / clip.fps);
    if let Some(leg) = clip.legs.iter().find(|leg| (leg.first..=leg.last).contains(&frame)) {
        text.push_str(&format!("\n{}", leg_text(clip, leg)));
    }
    if let Some(record) = report.and_then(|report| report.frames.get(frame)) {
        let slides = record.skate_cm_per_s[0].max(record.skate_cm_per_s[1]);
        let touches = if record.contact { "touches something" } else { "touches nothing" };
        text.push_str(&format!(
            "\nsinks in {:.0} mm, feet slide {slides:.1} cm/s, hover {:.0} mm, {touches}",
            record.penetration_max_mm, record.hover_mm
        ));
    }
    text
}

/// Where the time is, over everything.
fn cursor(ui: &Ui, state: &EditorState, scale: &Scale) {
    let x = scale.x(state.motion.player.seconds.min(scale.length_s));
    let bottom = ui.min_rect().bottom();
    let color = theme::palette(ui.visuals()).accent;
    let top: Pos2 = pos2(x, scale.top);
    ui.painter().line_segment([top, pos2(x, bottom)], Stroke::new(1.5, color));
    let grip = vec![top + vec2(-5.0, 0.0), top + vec2(5.0, 0.0), top + vec2(0.0, 7.0)];
    ui.painter().add(egui::Shape::convex_polygon(grip, color, Stroke::NONE));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stances_are_runs_of_planted_frames() {
        let planted = [true, true, false, true, false, false, true].map(|left| [left, !left]);
        assert_eq!(runs(&planted, 0), [(0, 1), (3, 3), (6, 6)]);
        assert_eq!(runs(&planted, 1), [(2, 2), (4, 5)]);
        assert!(runs(&[], 0).is_empty());
    }

    #[test]
    fn a_frame_that_floats_or_sinks_is_red_and_a_good_one_is_not() {
        let good = FrameRecord { contact: true, penetration_max_mm: 3.0, ..FrameRecord::default() };
        assert!((0..3).all(|row| badness(&good, row) < 0.6));
        let sinks = FrameRecord { penetration_max_mm: 60.0, ..good };
        assert!(badness(&sinks, 0) > 1.0 && badness(&sinks, 1) < 1.0);
        assert!(badness(&FrameRecord { contact: false, ..good }, 2) > 1.0);
        assert!(badness(&FrameRecord { skate_cm_per_s: [0.0, 30.0], ..good }, 1) > 1.0);
    }
}
