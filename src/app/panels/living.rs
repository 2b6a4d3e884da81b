//! Actions: what can be done in the room next, what was done and why things are where they are.

use egui::{
    Button, CollapsingHeader, Color32, DragValue, Rect, RichText, ScrollArea, Sense, Slider, Ui, vec2,
};

use super::{empty, title};
use crate::app::icons::{self, Icon};
use crate::app::jobs::JobKind;
use crate::app::lived::Touched;
use crate::app::state::{EditorState, Overlay};
use crate::app::theme;
use crate::document::Command;
use crate::evolve::action::{ActionKind, Suggestion};

/// So many suggestions are seen at once; the rest unfolds.
const FIRST: usize = 7;

/// Draws the panel.
pub fn living(ui: &mut Ui, state: &mut EditorState) {
    let pointed_out = std::mem::take(&mut state.living.pointed_out);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let now = state.life_now();
        head(ui, state, now);
        super::things::things(ui, state);
        if let Some(now) = now {
            suggestions(ui, state, now);
            off(ui, state, now);
        }
        if !state.living.tree.is_empty() {
            title(ui, "What was done");
            replay(ui, state);
            tree(ui, state, now);
        }
        if let Some(now) = now {
            last_step(ui, state, now);
        }
    });
    if state.living.pointed_out != pointed_out {
        // The view was drawn before this panel: it shows them in the next frame.
        ui.ctx().request_repaint();
    }
}

fn head(ui: &mut Ui, state: &mut EditorState, now: Option<usize>) {
    let palette = theme::palette(ui.visuals());
    let size = [ui.available_width(), 32.0];
    if state.is_living() {
        let keeps = state.jobs.acting.is_some() || state.jobs.day.is_some();
        let text = if keeps { "Stop and keep" } else { "Cancel" };
        if ui.add_sized(size, Button::new(text)).clicked() {
            state.cancel(JobKind::Act);
        }
        return;
    }
    if now.is_none() {
        let known = !state.living.tree.is_empty();
        let text = if known { "Look at the room again" } else { "What can be done here?" };
        let button =
            Button::new(RichText::new(text).size(14.0).color(palette.on_accent)).fill(palette.accent);
        let tip = "Finds the desks, tables, couches and beds where something can be done, and everything that can be \
                   moved: a few seconds";
        let response = ui.add_enabled_ui(state.has_room(), |ui| ui.add_sized(size, button)).inner;
        if response.on_hover_text(tip).clicked() {
            state.look_for_actions();
        }
        if known {
            ui.label(RichText::new("The room was changed by hand since the last action.").small().weak());
        }
        return;
    }
    ui.horizontal(|ui| {
        let text =
            RichText::new(format!("Sample {}", state.living.count)).size(14.0).color(palette.on_accent);
        let button = Button::new(text).fill(palette.accent);
        let tip = "Lets the chain of actions run: each is drawn by what follows what in the photos";
        let sample = ui.add_sized([120.0, 30.0], button).on_hover_text(tip);
        ui.add(Slider::new(&mut state.living.count, 1..=30).show_value(false))
            .labelled_by(sample.id)
            .on_hover_text("How many actions");
        if sample.clicked() {
            state.start_chain();
        }
        let rolls = state.living.tree.get(now.unwrap_or(0)).is_some_and(|node| node.step.is_some());
        let re_roll = ui.add_enabled(rolls, Button::new("Re-roll"));
        if re_roll.on_hover_text("The last action again, with another outcome: a branch beside it").clicked()
        {
            state.re_roll_action();
        }
    });
    day(ui, state);
    choices(ui, state);
}

/// The same chain, lived by somebody who walks from one to the next.
fn day(ui: &mut Ui, state: &mut EditorState) {
    let text = format!("A day in this room ({} actions)", state.living.count);
    let tip = "Somebody walks from action to action; things come and move when they get there. One motion on the \
               timeline, one undo step; takes a minute or more";
    let button = Button::new(text).min_size(vec2(ui.available_width(), 24.0));
    if ui.add(button).on_hover_text(tip).clicked() {
        state.start_day();
    }
}

fn choices(ui: &mut Ui, state: &mut EditorState) {
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut state.living.fit, "Fit people")
            .on_hover_text("Bodies that sit and stand where they are; a second or two for each.");
        ui.checkbox(&mut state.living.marks, "Why here")
            .on_hover_text("Shows the places that were tried for each thing, and the working zone.");
    });
    CollapsingHeader::new("Choices").id_salt("action choices").show(ui, |ui| {
        ui.horizontal(|ui| {
            let label = ui.label("Seed");
            ui.add(DragValue::new(&mut state.living.seed).speed(0.05))
                .labelled_by(label.id)
                .on_hover_text("Used when the room is looked at.");
        });
        ui.horizontal(|ui| {
            ui.label("Groups of");
            for (size, text) in [(None, "any"), (Some(2), "2"), (Some(3), "3"), (Some(4), "4")] {
                ui.selectable_value(&mut state.living.choice.group_size, size, text);
            }
        });
        ui.checkbox(&mut state.living.choice.companions, "Plates, paper and the like")
            .on_hover_text("Things that the photos have no word for.");
        ui.checkbox(&mut state.living.choice.baseline, "Groups share at random")
            .on_hover_text("The baseline of ADSE fig. 8, to compare with.");
        for kind in ActionKind::ALL {
            let only = &mut state.living.choice.only;
            let mut on = only.is_empty() || only.contains(&kind);
            if ui.checkbox(&mut on, kind.label()).changed() {
                let mut kinds: Vec<ActionKind> =
                    ActionKind::ALL.into_iter().filter(|k| only.is_empty() || only.contains(k)).collect();
                kinds.retain(|k| *k != kind);
                if on {
                    kinds.push(kind);
                }
                *only = if kinds.len() == ActionKind::ALL.len() { Vec::new() } else { kinds };
            }
        }
    });
}

/// What can be done next, the most probable first; hovering points out where.
fn suggestions(ui: &mut Ui, state: &mut EditorState, now: usize) {
    ui.horizontal(|ui| {
        title(ui, "What comes next");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let tip = "The graph that these numbers come from, and where things lie: as plots";
            if ui.small_button("Why so probable?").on_hover_text(tip).clicked() {
                state.overlay = Overlay::Learned(None);
            }
        });
    });
    let suggestions = state.living.tree[now].lived.suggestions();
    if suggestions.is_empty() {
        empty(ui, "Nothing that is known can be done in this room. See below, and why.");
    }
    let most = suggestions.first().map_or(1.0, |s| s.probability).max(1e-9);
    let (first, rest) = suggestions.split_at(suggestions.len().min(FIRST));
    rows(ui, state, first, most);
    if !rest.is_empty() {
        let as_probable = rest.first().zip(first.last()).is_some_and(|(a, b)| a.probability == b.probability);
        let title = if as_probable { "As probable and less" } else { "Less probable" };
        CollapsingHeader::new(format!("{title} ({})", rest.len()))
            .id_salt("less probable")
            .show(ui, |ui| rows(ui, state, rest, most));
    }
}

fn rows(ui: &mut Ui, state: &mut EditorState, suggestions: &[Suggestion], most: f64) {
    for suggestion in suggestions {
        let response = suggestion_row(ui, suggestion, most, !state.is_living());
        if response.hovered() {
            state.living.pointed_out.clone_from(&suggestion.keys);
        }
        if response.clicked() {
            state.start_action(suggestion.node);
        }
    }
}

fn suggestion_row(ui: &mut Ui, suggestion: &Suggestion, most: f64, enabled: bool) -> egui::Response {
    let accent = theme::palette(ui.visuals()).accent;
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 21.0), Sense::click());
    let name = format!("{} ({:.0} %)", suggestion.action, suggestion.probability * 100.0);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, &name));
    let visuals = ui.style().interact(&response);
    let share = (suggestion.probability / most) as f32;
    let bar = Rect::from_min_size(rect.min, vec2(rect.width() * share, rect.height()));
    let painter = ui.painter();
    let back = if response.hovered() { visuals.bg_fill } else { Color32::TRANSPARENT };
    painter.rect_filled(rect, 3.0, back);
    painter.rect_filled(bar, 3.0, accent.gamma_multiply(if response.hovered() { 0.4 } else { 0.22 }));
    let font = egui::FontId::proportional(12.5);
    let mut job =
        egui::text::LayoutJob::simple_singleline(suggestion.action.clone(), font, visuals.text_color());
    job.wrap = egui::text::TextWrapping::truncate_at_width(rect.width() - 62.0);
    let galley = painter.layout_job(job);
    let left = rect.left_center() + vec2(6.0, -0.5 * galley.size().y);
    painter.galley(left, galley, visuals.text_color());
    painter.text(
        rect.right_center() - vec2(6.0, 0.0),
        egui::Align2::RIGHT_CENTER,
        format!("{:.1} %", suggestion.probability * 100.0),
        egui::FontId::monospace(11.0),
        ui.visuals().weak_text_color(),
    );
    response.on_hover_text(format!("Click: {}", suggestion.action))
}

fn off(ui: &mut Ui, state: &EditorState, now: usize) {
    let off = state.living.tree[now].lived.off();
    if off.is_empty() {
        return;
    }
    CollapsingHeader::new(format!("Not possible here ({})", off.len())).id_salt("off").show(ui, |ui| {
        for action in off {
            ui.label(RichText::new(format!("{}: {}", action.action, action.why)).small().weak());
        }
    });
}

fn replay(ui: &mut Ui, state: &mut EditorState) {
    let running = state.living.replay.is_some();
    let can = state.life_now().is_some_and(|now| state.living.tree[now].parent.is_some());
    let button = Button::new(if running { "Stop replay" } else { "Replay" }).selected(running);
    if ui.add_enabled(can, button).on_hover_text("Shows how the room came to be as it is").clicked() {
        state.toggle_replay();
    }
}

/// What was asked of a row of the tree.
enum Wanted {
    GoTo(usize),
    Beside(usize),
}

/// Every state that was reached, branches indented; a click goes there.
fn tree(ui: &mut Ui, state: &mut EditorState, now: Option<usize>) {
    let mut wanted = None;
    for root in 0..state.living.tree.len() {
        if state.living.tree[root].parent.is_none() {
            tree_row(ui, state, root, 0, now, &mut wanted);
        }
    }
    match wanted {
        Some(Wanted::GoTo(node)) => {
            state.show_life(node);
        }
        Some(Wanted::Beside(node)) => state.toggle_beside(node),
        None => {}
    }
}

/// A row of the tree from the right edge on; what was asked of it.
fn tree_row_widgets(ui: &mut Ui, state: &EditorState, node: usize, is_now: bool) -> Option<Wanted> {
    let text = state.life_label(node);
    let mut wanted = None;
    if is_now {
        ui.add_space(26.0);
    } else {
        let (name, strength) = match state.living.beside == Some(node) {
            true => (format!("No longer beside: {text}"), 1.0),
            false => (format!("Show beside: {text}"), 0.45),
        };
        if icons::button(ui, Icon::Beside, &name, strength).clicked() {
            wanted = Some(Wanted::Beside(node));
        }
    }
    if filling(ui, is_now, &text).on_hover_text(format!("{text}\nClick to go there")).clicked() {
        wanted = Some(Wanted::GoTo(node));
    }
    wanted
}

fn tree_row(
    ui: &mut Ui,
    state: &EditorState,
    node: usize,
    depth: usize,
    now: Option<usize>,
    wanted: &mut Option<Wanted>,
) {
    ui.push_id(("life", node), |ui| {
        ui.horizontal(|ui| {
            ui.add_space(12.0 * depth as f32);
            row_with_icons(ui, 20.0, |ui| {
                if let Some(asked) = tree_row_widgets(ui, state, node, now == Some(node)) {
                    *wanted = Some(asked);
                }
            });
        });
    });
    let children: Vec<usize> =
        (0..state.living.tree.len()).filter(|child| state.living.tree[*child].parent == Some(node)).collect();
    for (i, child) in children.iter().enumerate() {
        // The first future goes on below, others stand beside it.
        tree_row(ui, state, *child, depth + usize::from(i > 0), now, wanted);
    }
}

/// What the action that is shown did: what came, what moved, what it did without.
fn last_step(ui: &mut Ui, state: &mut EditorState, now: usize) {
    let Some(step) = state.living.tree[now].step.clone() else { return };
    let palette = theme::palette(ui.visuals());
    title(ui, &step.action);
    if step.touched.is_empty() {
        ui.weak("Nothing had to come or to move.");
    }
    for (i, thing) in step.touched.iter().enumerate() {
        ui.push_id(("touched", i), |ui| row_with_icons(ui, 19.0, |ui| touched(ui, state, thing)));
    }
    for failed in &step.failed {
        ui.label(RichText::new(failed).small().color(palette.warn));
    }
    if state.living.marks {
        legend(ui);
    }
}

/// A row whose icons stand at the right edge; what is added last fills what is left.
fn row_with_icons(ui: &mut Ui, height: f32, contents: impl FnOnce(&mut Ui)) {
    let size = vec2(ui.available_width(), height);
    ui.allocate_ui_with_layout(size, egui::Layout::right_to_left(egui::Align::Center), contents);
}

/// A button that fills a row; its text is cut where it is too long.
fn filling(ui: &mut Ui, marked: bool, text: &str) -> egui::Response {
    let button = Button::selectable(marked, (text, egui::Atom::grow())).truncate();
    ui.add(button.min_size(vec2(ui.available_width(), 19.0)))
}

/// One thing that the last action brought or moved, from the right edge on.
fn touched(ui: &mut Ui, state: &mut EditorState, thing: &Touched) {
    if thing.kind.is_empty() {
        ui.add_space(26.0);
    } else {
        let name = format!("Never bring: {}", thing.kind);
        if icons::button(ui, Icon::Ban, &name, 0.5).clicked() {
            state.ban_kind(&thing.kind);
        }
    }
    let locked = state.document.scene().room.object(thing.id).is_some_and(|object| object.locked);
    let (icon, verb, strength) =
        if locked { (Icon::Lock, "Unlock", 0.9) } else { (Icon::Unlock, "Lock", 0.3) };
    if icons::button(ui, icon, &format!("{verb} {}", thing.line), strength).clicked() {
        state.apply(Command::SetObjectsLocked(vec![thing.id], !locked));
    }
    let response = filling(ui, false, &thing.line).on_hover_text(format!("{}. Click to see it", thing.line));
    if response.hovered() {
        state.living.pointed_out.push(thing.id);
    }
    if response.clicked() {
        state.look_at_object(thing.id);
    }
}

/// What the colours of the marks in the view mean.
fn legend(ui: &mut Ui) {
    ui.horizontal_wrapped(|ui| {
        for (verdict, text) in crate::app::life_marks::VERDICTS {
            let (rect, _) = ui.allocate_exact_size(vec2(9.0, 9.0), Sense::hover());
            ui.painter().circle_filled(rect.center(), 4.0, crate::app::life_marks::color(verdict));
            ui.label(RichText::new(text).small().weak());
        }
    });
}
