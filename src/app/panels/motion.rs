//! Motions: which there are, how the next one is made, its sub-goals; and the details of one that is selected.

use egui::{Button, DragValue, Grid, RichText, ScrollArea, Slider, TextEdit, Ui};

use super::inspector::{SHAPE_NAMES, name_field, row};
use super::outliner::{ITEM_ACTIONS, item_row, select_if_needed};
use super::{command_button, empty, title};
use crate::app::actions;
use crate::app::engine::{MotionFormat, MotionMethod};
use crate::app::goal_marks::{described, pose_label};
use crate::app::icons::{self, Icon};
use crate::app::jobs::JobKind;
use crate::app::motion::{GoalFigures, Trail};
use crate::app::selection::Item;
use crate::app::state::{EditorState, Tool};
use crate::app::theme;
use crate::scene::Clip;
use crate::scene::ClipId;
use crate::scene::GoalPose;
use crate::scene::SubGoalId;

/// What may be asked for at a sub-goal, with what it means.
const POSES: [(GoalPose, &str); 5] = [
    (GoalPose::Any, "Sits on seats, lies on beds, stands on the floor."),
    (GoalPose::Stand, "Stops there and stands."),
    (GoalPose::Sit, "Walks up, turns and sits down."),
    (GoalPose::Lie, "Sits down on the edge and lies down."),
    (GoalPose::Walk, "Passes without stopping."),
];
/// Furthest shape that still looks like somebody.
const MOST_SHAPE: f32 = 3.0;

/// Draws the panel.
pub fn motion(ui: &mut Ui, state: &mut EditorState) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        placing(ui, state);
        ui.add_space(2.0);
        synthesise(ui, state);
        method(ui, state);
        numbers(ui, state);
        title(ui, "Motions");
        clips(ui, state);
        goals(ui, state);
        title(ui, "Shown");
        shown(ui, state);
    });
}

/// What the next click in the view does.
fn placing(ui: &mut Ui, state: &mut EditorState) {
    ui.horizontal(|ui| {
        let on = state.tool == Tool::AddGoal;
        let tip = "Click the floor, a seat or a bed in the view; drag to say which way to face (Shift+I)";
        let button = Button::new("Add sub-goals").selected(on);
        if ui.add_enabled(state.has_room(), button).on_hover_text(tip).clicked() {
            actions::add_goals(state);
        }
        command_button(ui, state, "new-motion");
    });
    ui.horizontal_wrapped(|ui| {
        ui.label("There");
        for (pose, tip) in POSES {
            ui.selectable_value(&mut state.motion.options.pose, pose, pose_label(pose)).on_hover_text(tip);
        }
    });
    ui.horizontal(|ui| {
        let label = ui.label("Stay");
        let stay =
            DragValue::new(&mut state.motion.options.stay_s).range(0.0..=600.0).speed(0.1).suffix(" s");
        ui.add(stay).labelled_by(label.id).on_hover_text("How long one stays at the next sub-goal.");
    });
}

fn synthesise(ui: &mut Ui, state: &mut EditorState) {
    let palette = theme::palette(ui.visuals());
    let size = [ui.available_width(), 32.0];
    if state.jobs.moving() {
        let tip = "Stops; the motion as it is so far is kept, as one step";
        if ui.add_sized(size, Button::new("Stop and keep")).on_hover_text(tip).clicked() {
            state.cancel(JobKind::Move);
        }
        return;
    }
    let ready = state.can_synthesise();
    let text = RichText::new("Synthesise").size(14.0).color(palette.on_accent);
    let button = Button::new(text).fill(palette.accent);
    let response = ui.add_enabled_ui(ready.is_ok(), |ui| ui.add_sized(size, button)).inner;
    let tip = "Makes the motion; plays what is there so far (Ctrl+Shift+Enter)";
    if response.on_hover_text(tip).on_disabled_hover_text(ready.err().unwrap_or_default()).clicked() {
        actions::synthesise(state);
    }
    ui.horizontal(|ui| {
        command_button(ui, state, "another-way");
        export_menu(ui, state);
    });
}

fn export_menu(ui: &mut Ui, state: &mut EditorState) {
    ui.add_enabled_ui(state.can_play(), |ui| {
        ui.menu_button("Export...", |ui| {
            for format in MotionFormat::ALL {
                if ui.button(format.label()).on_hover_text(format.purpose()).clicked() {
                    state.ask_motion_export(format);
                    ui.close();
                }
            }
        });
    });
}

fn method(ui: &mut Ui, state: &mut EditorState) {
    let chosen = state.motion.options.method;
    ui.horizontal(|ui| {
        let label = ui.label("Method");
        let combo = egui::ComboBox::from_id_salt("motion method")
            .selected_text(chosen.label())
            .width(ui.available_width() - 8.0);
        let response = combo.show_ui(ui, |ui| {
            for method in MotionMethod::ALL {
                let entry = Button::selectable(method == chosen, method.label());
                if ui.add(entry).on_hover_text(method.strength()).clicked() {
                    state.motion.options.method = method;
                }
            }
        });
        response.response.labelled_by(label.id).on_hover_text("Who makes the steps between the sub-goals.");
    });
    ui.label(RichText::new(state.motion.options.method.strength()).small().weak());
    if state.motion.options.method == MotionMethod::Retrieval {
        clips_folder(ui, state);
    }
}

/// Where the captured pieces are: none come with the program.
fn clips_folder(ui: &mut Ui, state: &mut EditorState) {
    ui.horizontal(|ui| {
        let label = ui.label("Clips");
        let path =
            TextEdit::singleline(&mut state.motion.options.clips).hint_text("folder of npz or BVH files");
        let path = path.desired_width(ui.available_width() - 46.0);
        ui.add(path).labelled_by(label.id).on_hover_text("Pieces are looked up in all clips of this folder.");
        let browse = ui.button("...").on_hover_text("Choose the folder");
        browse.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Button, true, "Choose the folder of clips")
        });
        if browse.clicked() {
            state.requests.clips_dialog = true;
        }
    });
}

fn numbers(ui: &mut Ui, state: &mut EditorState) {
    let options = &mut state.motion.options;
    Grid::new("motion numbers").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let label = ui.label("Seed");
        ui.add(DragValue::new(&mut options.seed).range(0..=u64::MAX).speed(0.05))
            .labelled_by(label.id)
            .on_hover_text("The same seed gives the same motion, bit by bit.");
        ui.end_row();
        for (name, beta) in SHAPE_NAMES.into_iter().zip(&mut options.betas) {
            let label = ui.label(name);
            ui.add(Slider::new(beta, -MOST_SHAPE..=MOST_SHAPE).fixed_decimals(1))
                .labelled_by(label.id)
                .on_hover_text("Body shape; another shape makes every leg again.");
            ui.end_row();
        }
    });
    ui.checkbox(&mut options.follow_changes, "Make changed legs at once").on_hover_text(
        "When a sub-goal is moved, turned or removed, the legs to and from it are made again, and no others.",
    );
}

/// Every motion; the active one is marked.
fn clips(ui: &mut Ui, state: &mut EditorState) {
    let clips = state.document.scene().clips.clone();
    if clips.is_empty() {
        empty(ui, "None yet. Press Add sub-goals and click where somebody should go.");
        return;
    }
    for clip in clips {
        let item = Item::Clip(clip.id);
        let active = state.motion.active == Some(clip.id);
        let name = if active { format!("> {}", clip.name) } else { clip.name.clone() };
        let response = item_row(ui, state, item, &name, clip.visible, clip.locked);
        if response.clicked() {
            state.activate_clip(clip.id);
        }
        response.on_hover_text(summary(&clip)).context_menu(|ui| {
            for (label, action) in ITEM_ACTIONS.iter().filter(|(label, _)| *label != "Duplicate") {
                if ui.button(*label).clicked() {
                    select_if_needed(state, item);
                    action(state);
                    ui.close();
                }
            }
        });
    }
}

fn summary(clip: &Clip) -> String {
    let wanted = clip.goals.iter().filter(|goal| !goal.planned).count();
    if clip.frames.is_empty() {
        return format!("A plan of {wanted} sub-goals; not made yet");
    }
    let stale = clip.legs.iter().filter(|leg| leg.key == 0).count();
    let again = if stale > 0 { format!("; {stale} legs to be made again") } else { String::new() };
    format!("{:.1} s, {wanted} sub-goals, {} legs{again}", clip.seconds(), clip.legs.len())
}

/// The sub-goals of the active motion that somebody asked for.
fn goals(ui: &mut Ui, state: &mut EditorState) {
    let Some(clip) = state.active_clip().cloned() else { return };
    title(ui, "Sub-goals");
    if clip.goals.is_empty() {
        ui.weak("Click in the view to place the first one.");
    }
    let mut number = 0;
    for goal in clip.goals.iter().filter(|goal| !goal.planned) {
        number += 1;
        let item = Item::Goal(clip.id, goal.id);
        ui.push_id(goal.id.0, |ui| {
            ui.horizontal(|ui| {
                let selected = state.selection.contains(item);
                let text = format!("{number}  {}", described(goal));
                let width = ui.available_width() - 48.0;
                let button = Button::selectable(selected, (text, egui::Atom::grow()));
                if ui.add(button.truncate().min_size(egui::vec2(width, 20.0))).clicked() {
                    state.selection.only(item);
                    go_to(state, &clip, goal.id);
                }
                let (lock, verb, strength) =
                    if goal.locked { (Icon::Lock, "Unlock", 0.9) } else { (Icon::Unlock, "Lock", 0.25) };
                if icons::button(ui, lock, &format!("{verb} sub-goal {number}"), strength).clicked() {
                    let locked = !goal.locked;
                    state.edit_goals(&[(clip.id, goal.id)], |goal| goal.locked = locked);
                }
                if icons::button(ui, Icon::Close, &format!("Remove sub-goal {number}"), 0.4).clicked() {
                    state.selection.only(item);
                    actions::delete(state);
                }
            });
        });
    }
    let planned = clip.goals.iter().filter(|goal| goal.planned).count();
    if planned > 0 {
        ui.label(RichText::new(format!("and {planned} that the planner put in between")).small().weak());
    }
}

/// Shows the frame at which a motion is at a sub-goal.
fn go_to(state: &mut EditorState, clip: &Clip, goal: SubGoalId) {
    let arrives = clip.legs.iter().find(|leg| leg.to == goal).map(|leg| leg.last);
    let frame = arrives.or_else(|| clip.legs.iter().find(|leg| leg.from == goal).map(|leg| leg.first));
    if let Some(frame) = frame {
        actions::go_to_frame(state, clip, frame);
    }
}

fn shown(ui: &mut Ui, state: &mut EditorState) {
    ui.horizontal(|ui| {
        ui.label("Trail");
        for (trail, label, tip) in [
            (Trail::Off, "off", "Only where people are now."),
            (Trail::Line, "line", "The way along the floor."),
            (Trail::Figures, "figures", "The way, and figures before and after now, half a second apart."),
        ] {
            ui.selectable_value(&mut state.motion.trail, trail, label).on_hover_text(tip);
        }
    });
    ui.horizontal(|ui| {
        ui.label("Figures");
        for (figures, label, tip) in [
            (GoalFigures::Off, "none", "Marks on the floor only."),
            (GoalFigures::Wanted, "asked for", "Somebody at each sub-goal that you placed."),
            (GoalFigures::All, "all", "Somebody at every sub-goal, the planner's too."),
        ] {
            ui.selectable_value(&mut state.motion.figures, figures, label).on_hover_text(tip);
        }
    });
}

/// Details of a motion, for the inspector.
pub fn clip_details(ui: &mut Ui, state: &mut EditorState, id: ClipId) {
    let Some(clip) = state.document.scene().clip(id).cloned() else { return };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        name_field(ui, state, Item::Clip(id), &clip.name);
        Grid::new("clip").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
            row(ui, "Lasts", &format!("{:.1} s, {} frames", clip.seconds(), clip.frames.len()));
            row(ui, "Sub-goals", &clip.goals.len().to_string());
            row(ui, "Seed", &clip.seed.to_string());
        });
        let Some(report) = state.clip_report(&clip).cloned() else {
            if !clip.frames.is_empty() {
                ui.weak("Measuring...");
            }
            return;
        };
        title(ui, "Measured");
        metrics(ui, &report.metrics);
    });
}

fn metrics(ui: &mut Ui, m: &crate::inspect::MotionMetrics) {
    let limits = crate::inspect::MotionLimits::default();
    let palette = theme::palette(ui.visuals());
    let maybe = |value: Option<f32>, unit: &str| value.map_or("-".to_owned(), |v| format!("{v:.1} {unit}"));
    let rows: [(&str, String, bool, &str); 9] = [
        (
            "Non-collision",
            format!("{:.2} %", m.non_collision_pct),
            m.non_collision_pct >= limits.non_collision_pct,
            "LTM 4.3: share of vertices in free space, mean over the frames.",
        ),
        (
            "Contact",
            format!("{:.1} %", m.contact_pct),
            m.contact_pct >= limits.contact_pct,
            "Share of frames in which the skin touches something.",
        ),
        (
            "Deepest penetration",
            format!("{:.1} mm", m.penetration_max_mm),
            m.penetration_max_mm <= limits.penetration_max_mm,
            "Deepest vertex in solid matter in any frame.",
        ),
        (
            "Feet slide",
            format!("{:.2} cm/s", m.skate_cm_per_s),
            m.skate_cm_per_s <= limits.skate_cm_per_s,
            "Mean speed of planted feet along the floor.",
        ),
        (
            "Feet wander",
            format!("{:.2} cm", m.stance_drift_cm),
            m.stance_drift_cm <= limits.stance_drift_cm,
            "How far the worst planted foot left the place where it was put down.",
        ),
        (
            "Feet hover",
            format!("{:.0} mm", m.hover_max_mm),
            m.hover_max_mm <= limits.hover_mm,
            "Greatest height of a planted foot above what is under it.",
        ),
        (
            "Off its sub-goals",
            maybe(m.goal_error_cm, "cm"),
            m.goal_error_cm.is_none_or(|e| e <= limits.goal_error_cm),
            "Greatest distance from where somebody was asked to be.",
        ),
        (
            "Turned from them",
            maybe(m.goal_error_deg, "°"),
            m.goal_error_deg.is_none_or(|e| e <= limits.goal_error_deg),
            "Greatest difference from the facing that was asked for.",
        ),
        (
            "Jump between legs",
            maybe(m.boundary_speed_ratio, "x"),
            m.boundary_speed_ratio.is_none_or(|r| r <= limits.boundary_speed_ratio),
            "Speed where legs meet over the speed beside it.",
        ),
    ];
    Grid::new("clip metrics").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        for (name, value, fine, tip) in rows {
            ui.label(name).on_hover_text(tip);
            let color = if fine { palette.good } else { palette.bad };
            ui.label(RichText::new(value).monospace().color(color));
            ui.end_row();
        }
    });
}

/// Details of a sub-goal, for the inspector.
pub fn goal_details(ui: &mut Ui, state: &mut EditorState, clip: ClipId, id: SubGoalId) {
    let Some(goal) = state.goal(clip, id).cloned() else { return };
    ui.heading(if goal.planned { "Planned sub-goal" } else { "Sub-goal" });
    let mut wanted = goal.clone();
    ui.horizontal_wrapped(|ui| {
        for (pose, tip) in POSES {
            ui.selectable_value(&mut wanted.pose, pose, pose_label(pose)).on_hover_text(tip);
        }
    });
    let mut response = None;
    Grid::new("goal").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        row(ui, "At", &format!("{:.2}, {:.2}, {:.2} m", goal.at.x, goal.at.y, goal.at.z));
        let label = ui.label("Stay");
        let stay = DragValue::new(&mut wanted.stay_s).range(0.0..=600.0).speed(0.1).suffix(" s");
        response = Some(ui.add(stay).labelled_by(label.id));
        ui.end_row();
        let label = ui.label("Facing");
        let mut degrees = wanted.facing.unwrap_or(0.0).to_degrees();
        let facing = ui.add(DragValue::new(&mut degrees).speed(1.0).suffix("°")).labelled_by(label.id);
        if facing.on_hover_text("0 faces +Z; R turns it in the view").changed() {
            wanted.facing = Some(degrees.to_radians());
        }
        ui.end_row();
    });
    ui.horizontal(|ui| {
        let free = wanted.facing.is_some();
        if ui.add_enabled(free, Button::new("Any facing")).on_hover_text("Leave it to the planner").clicked()
        {
            wanted.facing = None;
        }
        command_button(ui, state, "re-roll");
        command_button(ui, state, "delete");
    });
    if wanted != goal {
        // Whoever stood there before no longer fits what is asked for.
        let stays = wanted.pose == goal.pose && wanted.facing == goal.facing;
        wanted.body = wanted.body.filter(|_| stays);
        wanted.locked |= wanted.planned;
        state.edit_goals(&[(clip, id)], |goal| goal.clone_from(&wanted));
        if response.is_some_and(|response| !response.dragged()) {
            state.follow_change(clip);
        }
    }
}
