//! What was learned of actions: which follows which as a graph, and of each action how many of what lie where.

use egui::{
    Align2, Color32, FontId, Grid, Pos2, Rect, RichText, ScrollArea, Sense, Shape, Stroke, Ui, pos2, vec2,
};

use crate::app::learned::{Learned, Plot, REACH_M, RING_M, learned as what_was_learned};
use crate::app::state::{EditorState, Overlay};
use crate::app::theme;
use crate::evolve::action::{ActionKind, ActionNode};

/// Width of the list of nodes.
const LIST: f32 = 300.0;
/// Least width of a plot.
const PLOT: f32 = 148.0;
/// Of each node's successors so many are drawn: all edges of twenty nodes would be a blot.
const SUCCESSORS: usize = 5;
/// Of those of the node that is pointed at so many are drawn and named.
const NAMED: usize = 6;

/// Draws the page: the graph, or one node.
pub fn learned(ui: &mut Ui, state: &mut EditorState, node: Option<usize>) {
    let learned = match what_was_learned() {
        Ok(learned) => learned,
        Err(why) => {
            ui.label(why);
            return;
        }
    };
    ui.horizontal_top(|ui| {
        let height = ui.available_height().max(420.0);
        let mut pointed = None;
        ui.allocate_ui(vec2(LIST, height), |ui| {
            ui.vertical(|ui| pointed = list(ui, state, learned, node));
        });
        ui.separator();
        ui.vertical(|ui| match node.and_then(|number| Some((number, learned.model.nodes.get(number)?))) {
            Some((number, of)) => one(ui, state, learned, number, of),
            None => pointed = graph(ui, state, learned, pointed).or(pointed),
        });
        if state.learned.pointed_at != pointed {
            state.learned.pointed_at = pointed;
            ui.ctx().request_repaint();
        }
    });
}

/// A colour for each type of action, readable on both themes.
fn kind_color(ui: &Ui, kind: ActionKind) -> Color32 {
    let number = ActionKind::ALL.iter().position(|k| *k == kind).unwrap_or(0);
    let (saturation, value) = if ui.visuals().dark_mode { (0.58, 0.9) } else { (0.75, 0.62) };
    egui::ecolor::Hsva::new(number as f32 / ActionKind::ALL.len() as f32, saturation, value, 1.0).into()
}

/// Every node with what it rests on; the one that is pointed at.
fn list(ui: &mut Ui, state: &mut EditorState, learned: &Learned, chosen: Option<usize>) -> Option<usize> {
    if ui.add(row_button(chosen.is_none(), "Which action follows which", ui)).clicked() {
        state.overlay = Overlay::Learned(None);
    }
    let mut pointed = None;
    let warn = theme::palette(ui.visuals()).warn;
    ScrollArea::vertical().id_salt("nodes").auto_shrink(false).show(ui, |ui| {
        for (number, node) in learned.model.nodes.iter().enumerate() {
            let label = node.label();
            ui.push_id(number, |ui| {
                ui.horizontal(|ui| {
                    ui.spacing_mut().item_spacing.x = 5.0;
                    let (dot, _) = ui.allocate_exact_size(vec2(10.0, 18.0), Sense::hover());
                    ui.painter().circle_filled(dot.center(), 4.0, kind_color(ui, node.kind));
                    count(ui, node.instances, &learned.warnings_of(&label).collect::<Vec<&str>>());
                    let width = ui.available_width() - 8.0;
                    let button =
                        egui::Button::selectable(chosen == Some(number), (&*label, egui::Atom::grow()));
                    let response = ui.add(button.truncate().min_size(vec2(width, 19.0)));
                    if state.learned.pointed_at == Some(number) && chosen.is_none() {
                        let rim = Stroke::new(1.0, warn);
                        ui.painter().rect_stroke(response.rect, 4.0, rim, egui::StrokeKind::Inside);
                    }
                    if response.hovered() {
                        pointed = Some(number);
                    }
                    if response.on_hover_text(&label).clicked() {
                        state.overlay = Overlay::Learned(Some(number));
                    }
                });
            });
        }
    });
    pointed
}

/// How many photos a node rests on, marked where that is doubtful.
fn count(ui: &mut Ui, instances: usize, doubts: &[&str]) {
    let text = RichText::new(format!("{instances:>3}")).monospace().small();
    let warn = theme::palette(ui.visuals()).warn;
    let text = if doubts.is_empty() { text.weak() } else { text.color(warn) };
    let tip = format!("{instances} people in photos\n{}", doubts.join("\n"));
    ui.label(text).on_hover_text(tip.trim_end());
}

fn row_button<'a>(chosen: bool, text: &'a str, ui: &Ui) -> egui::Button<'a> {
    egui::Button::selectable(chosen, (text, egui::Atom::grow()))
        .min_size(vec2(ui.available_width() - 20.0, 22.0))
}

/// The nodes on a circle, each with its most probable successors; the one that is pointed at.
fn graph(ui: &mut Ui, state: &mut EditorState, learned: &Learned, listed: Option<usize>) -> Option<usize> {
    ui.label("What people do after what, learned from what the photos have in common (ADSE 4.3).");
    ui.label(
        RichText::new("Point at an action to see what follows it; click it for its things.").small().weak(),
    );
    let side = ui.available_width().min(520.0);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), side), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "The graph of actions"));
    let places = circle(rect, learned.model.nodes.len());
    let near = |at: Pos2| {
        let nearest =
            (0..places.len()).min_by(|a, b| places[*a].distance(at).total_cmp(&places[*b].distance(at)))?;
        (places[nearest].distance(at) < 18.0).then_some(nearest)
    };
    let pointed = response.hover_pos().and_then(near);
    if let Some(number) = pointed.filter(|_| response.clicked()) {
        state.overlay = Overlay::Learned(Some(number));
    }
    let shown = pointed.or(listed);
    edges(ui, learned, &places, rect.center(), shown);
    dots(ui, learned, &places);
    if let Some(number) = shown {
        names(ui, learned, &places, rect, number);
    }
    pointed
}

fn circle(rect: Rect, count: usize) -> Vec<Pos2> {
    let radius = 0.5 * rect.height().min(rect.width()) - 26.0;
    let place = |i: usize| {
        let angle = std::f32::consts::TAU * (i as f32 / count.max(1) as f32 - 0.25);
        rect.center() + vec2(angle.cos(), angle.sin()) * radius
    };
    (0..count).map(place).collect()
}

/// What follows a node, the most probable first, itself left out.
fn successors(learned: &Learned, node: usize) -> Vec<(usize, f64)> {
    let row = learned.graph.probability.get(node).map_or(&[][..], Vec::as_slice);
    let mut others: Vec<(usize, f64)> =
        row.iter().copied().enumerate().filter(|(j, p)| *j != node && *p > 0.0).collect();
    others.sort_by(|a, b| b.1.total_cmp(&a.1));
    others
}

fn edges(ui: &Ui, learned: &Learned, places: &[Pos2], middle: Pos2, shown: Option<usize>) {
    let rows = learned.graph.probability.iter().flatten();
    let most = rows.fold(f64::MIN_POSITIVE, |most, p| most.max(*p));
    for (from, node) in learned.model.nodes.iter().enumerate() {
        let chosen = shown == Some(from);
        let faint = shown.is_some() && !chosen;
        let color = kind_color(ui, node.kind);
        let drawn = if chosen { NAMED } else { SUCCESSORS };
        for (to, probability) in successors(learned, from).into_iter().take(drawn) {
            let share = (probability / most) as f32;
            let strength = if faint { 0.06 } else { 0.25 + 0.6 * share };
            let stroke = Stroke::new(if chosen { 1.0 + 3.0 * share } else { 0.6 + 1.8 * share }, color);
            let control = pos2(
                0.175 * (places[from].x + places[to].x) + 0.65 * middle.x,
                0.175 * (places[from].y + places[to].y) + 0.65 * middle.y,
            );
            let curve = egui::epaint::QuadraticBezierShape::from_points_stroke(
                [places[from], control, places[to]],
                false,
                Color32::TRANSPARENT,
                Stroke::new(stroke.width, color.gamma_multiply(strength)),
            );
            ui.painter().add(Shape::QuadraticBezier(curve));
        }
    }
}

fn dots(ui: &Ui, learned: &Learned, places: &[Pos2]) {
    let most = learned.model.nodes.iter().map(|node| node.instances).max().unwrap_or(1).max(1);
    for (node, at) in learned.model.nodes.iter().zip(places) {
        let radius = 4.0 + 7.0 * (node.instances as f32 / most as f32).sqrt();
        let rim = Stroke::new(1.0, ui.visuals().window_fill);
        ui.painter().circle(*at, radius, kind_color(ui, node.kind), rim);
    }
}

/// The names of a node and of what follows it most probably, inside of the picture.
fn names(ui: &Ui, learned: &Learned, places: &[Pos2], rect: Rect, number: usize) {
    let followers = successors(learned, number).into_iter().take(NAMED);
    let own = learned.graph.probability[number][number];
    let all = std::iter::once((number, own)).chain(followers);
    let mut taken: Vec<Rect> = Vec::new();
    for (node, probability) in all {
        let again = if node == number { ", again" } else { "" };
        let text = format!("{}{again} {:.0} %", learned.model.nodes[node].label(), 100.0 * probability);
        let color = ui.visuals().strong_text_color();
        let galley = ui.painter().layout_no_wrap(text, FontId::proportional(11.5), color);
        let right = places[node].x >= rect.center().x;
        let (hang, side) = if right { (Align2::RIGHT_CENTER, -14.0) } else { (Align2::LEFT_CENTER, 14.0) };
        let mut area = hang.anchor_size(places[node] + vec2(side, 0.0), galley.size()).expand(3.0);
        area = area.translate(vec2(
            (rect.left() - area.left()).max(0.0) + (rect.right() - area.right()).min(0.0),
            0.0,
        ));
        while let Some(other) = taken.iter().find(|other| other.intersects(area)) {
            area = area.translate(vec2(0.0, other.bottom() - area.top() + 1.0));
        }
        taken.push(area);
        ui.painter().rect_filled(area, 3.0, ui.visuals().window_fill.gamma_multiply(0.92));
        ui.painter().galley(area.min + vec2(3.0, 3.0), galley, color);
    }
}

/// One node: how many of what, and where.
fn one(ui: &mut Ui, state: &mut EditorState, learned: &Learned, number: usize, node: &ActionNode) {
    let label = node.label();
    ui.heading(&label);
    ui.label(format!(
        "{} people in photos, {} of them with all their things in sight",
        node.instances, node.complete_instances
    ));
    let warn = theme::palette(ui.visuals()).warn;
    for doubt in learned.warnings_of(&label) {
        ui.label(RichText::new(doubt).small().color(warn));
    }
    if let Some(key) = node.key_angle {
        let text = format!(
            "The {} is at {:.0}° (0 right, 90 in front; concentration {:.1})",
            node.key.label(),
            key.mean_rad.to_degrees(),
            key.kappa
        );
        ui.label(RichText::new(text).small().weak());
    }
    ScrollArea::vertical().id_salt(("node", number)).auto_shrink(false).show(ui, |ui| {
        follows(ui, state, learned, number);
        super::title(ui, "Where, from above; rings are half a metre apart");
        plots(ui, state.learned.plots(learned, number));
        super::title(ui, "How many");
        counts(ui, node);
    });
}

fn follows(ui: &mut Ui, state: &mut EditorState, learned: &Learned, number: usize) {
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new("Then:").small().weak());
        for (next, probability) in successors(learned, number).into_iter().take(4) {
            let text = format!("{} {:.0} %", learned.model.nodes[next].label(), 100.0 * probability);
            if ui.add(egui::Button::new(RichText::new(text).small())).clicked() {
                state.overlay = Overlay::Learned(Some(next));
            }
        }
    });
}

fn plots(ui: &mut Ui, plots: &[Plot]) {
    let columns = ((ui.available_width() / PLOT) as usize).max(1);
    let width = (ui.available_width() - 12.0) / columns as f32 - 6.0;
    Grid::new("plots").num_columns(columns).spacing([6.0, 8.0]).show(ui, |ui| {
        for (i, plot) in plots.iter().enumerate() {
            ui.vertical(|ui| {
                ui.set_width(width);
                ui.add(egui::Label::new(RichText::new(&plot.title).strong()).truncate());
                draw(ui, plot, width);
                ui.add(egui::Label::new(RichText::new(&plot.note).small().weak()).truncate());
            });
            if (i + 1) % columns == 0 {
                ui.end_row();
            }
        }
    });
}

fn draw(ui: &mut Ui, plot: &Plot, side: f32) {
    let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &plot.title));
    if !ui.is_rect_visible(rect) {
        return;
    }
    let (middle, scale) = (rect.center(), 0.5 * side / REACH_M);
    let (ink, soft) = (ui.visuals().text_color(), ui.visuals().weak_text_color());
    ui.painter().circle_filled(middle, REACH_M * scale, ui.visuals().extreme_bg_color);
    plot.density.paint_tinted(ui, rect, theme::palette(ui.visuals()).accent);
    let painter = ui.painter();
    let rings = (REACH_M / RING_M).round() as usize;
    for ring in 1..=rings {
        let radius_m = RING_M * ring as f32;
        painter.circle_stroke(middle, radius_m * scale - 0.5, Stroke::new(0.7, soft.gamma_multiply(0.55)));
    }
    if plot.person {
        // Shoulders, and a nose to the front.
        painter.line_segment([middle - vec2(8.0, 0.0), middle + vec2(8.0, 0.0)], Stroke::new(4.0, ink));
        painter.line_segment([middle, middle - vec2(0.0, 8.0)], Stroke::new(2.0, ink));
        painter.circle_filled(middle, 4.0, ink);
    } else {
        painter.rect_filled(Rect::from_center_size(middle, vec2(8.0, 8.0)), 1.0, ink);
    }
    if let Some(at) = response.hover_pos() {
        let (right_m, front_m) = ((at.x - middle.x) / scale, (middle.y - at.y) / scale);
        let whose = if plot.person { "the person's" } else { "its" };
        response.on_hover_text(format!("{right_m:+.2} m to {whose} right, {front_m:+.2} m to the front"));
    }
}

fn counts(ui: &mut Ui, node: &ActionNode) {
    let mut objects: Vec<_> = node.occurrence.iter().collect();
    objects.sort_by(|a, b| b.frequency().total_cmp(&a.frequency()));
    Grid::new("counts").striped(true).spacing([16.0, 3.0]).show(ui, |ui| {
        for head in ["thing", "none", "one", "two", "more"] {
            ui.label(RichText::new(head).small().weak());
        }
        ui.end_row();
        for object in objects {
            ui.label(&object.object);
            let of = |n: usize| object.probability.get(n).copied().unwrap_or(0.0);
            let more: f64 = object.probability.iter().skip(3).sum();
            for share in [of(0), of(1), of(2), more] {
                ui.label(RichText::new(format!("{:.0} %", 100.0 * share)).monospace().small());
            }
            ui.end_row();
        }
    });
}
