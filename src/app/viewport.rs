//! The 3-D view: mouse and keys move the camera, clicks select or place, the picture comes from the canvas.

use egui::{Align2, Color32, FontId, Key, Modifiers, PointerButton, Pos2, Rect, Response, Sense, Ui, vec2};
use glam::Vec3;

use super::actions;
use super::canvas::Canvas;
use super::goal_marks;
use super::life_marks;
use super::motion::Placing;
use super::overlay3d;
use super::panels;
use super::pick::{self, Picked, Ray};
use super::selection::Item;
use super::state::{EditorState, Heat, Tool};
use super::transform::{TransformKind, on_plane};

/// Points of wheel travel that count as one notch.
const POINTS_PER_NOTCH: f32 = 40.0;

/// Where the view is drawn: a second canvas for another future of the room.
pub struct Canvases<'a> {
    /// The document.
    pub main: &'a mut Canvas,
    /// What is shown beside it.
    pub beside: &'a mut Canvas,
}

/// Draws the view and handles what happens in it. Whether the pointer is over it.
pub fn viewport(ui: &mut Ui, state: &mut EditorState, canvases: Canvases<'_>) -> bool {
    let (whole, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "3-D view"));
    if whole.width() < 2.0 || whole.height() < 2.0 {
        return false;
    }
    let Some(other) = state.shown_beside().filter(|_| state.study.is_none()) else {
        return one_view(ui, state, canvases.main, whole, &response);
    };
    let (left, right) = whole.split_left_right_at_fraction(0.5);
    let [left, right] = [left.with_max_x(left.right() - 1.0), right.with_min_x(right.left() + 1.0)];
    let main = ui.interact(left, response.id.with("now"), Sense::click_and_drag());
    let over = one_view(ui, state, canvases.main, left, &main);
    let response = ui.interact(right, response.id.with("beside"), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "The other future"));
    navigate(ui, state, &response, right);
    canvases.beside.show_life(ui, right, state, other);
    beside_bars(ui, state, [left, right], other);
    over || response.contains_pointer()
}

/// Which future is which, and the buttons that choose one.
fn beside_bars(ui: &mut Ui, state: &mut EditorState, [left, right]: [Rect; 2], other: usize) {
    let now = state.life_now().map_or_else(|| "as it is now".to_owned(), |now| state.life_label(now));
    let (mut keep, mut choose) = (false, false);
    for (rect, text, button, pressed) in [
        (left, now, "Keep this one", &mut keep),
        (right, state.life_label(other), "Choose this one", &mut choose),
    ] {
        let bar = rect.shrink(6.0).with_min_y(rect.bottom() - 40.0);
        ui.scope_builder(egui::UiBuilder::new().max_rect(bar), |ui| {
            egui::Frame::popup(ui.style()).inner_margin(4).shadow(egui::Shadow::NONE).show(ui, |ui| {
                ui.horizontal(|ui| {
                    *pressed = ui.button(button).clicked();
                    ui.add(egui::Label::new(text).truncate());
                });
            });
        });
    }
    if keep {
        state.living.beside = None;
    } else if choose {
        state.choose_beside();
    }
}

fn one_view(
    ui: &mut Ui,
    state: &mut EditorState,
    canvas: &mut Canvas,
    rect: Rect,
    response: &Response,
) -> bool {
    state.aspect = rect.width() / rect.height();
    navigate(ui, state, response, rect);
    state.place_figures();
    let hovered = hovered(ui, state, response, rect);
    grip_goal(ui, state, response, rect);
    transform(ui, state, rect);
    canvas.show(ui, rect, state, hovered.map(|h| h.item));
    goal_marks::marks(ui, state, rect, hovered.map(|h| h.item));
    life_marks::marks(ui, state, rect);
    photo_over_view(ui, state, rect);
    if state.transform.is_some() {
        end_transform(ui, state, response);
    } else {
        place_goal(ui, state, response, rect);
        click(ui, state, response, hovered);
        select_by_box(ui, state, response, rect);
        menu(state, response);
    }
    overlay3d::axes(ui, state, rect);
    overlay3d::legend(ui, state, rect);
    value_under_cursor(ui, state, response, hovered);
    tool_cursor(ui, state, response);
    if state.orbit.advance(ui.input(|i| i.stable_dt)) {
        ui.ctx().request_repaint();
    }
    response.contains_pointer()
}

/// The ray through a point of the view.
fn ray_at(state: &EditorState, rect: Rect, at: Pos2) -> Ray {
    let x = (at.x - rect.left()) / rect.width();
    let y = (at.y - rect.top()) / rect.height();
    let (origin, direction) = state.orbit.camera().ray(x, y, rect.width() / rect.height());
    Ray { origin, direction }
}

fn navigate(ui: &Ui, state: &mut EditorState, response: &Response, rect: Rect) {
    let modifiers = ui.input(|i| i.modifiers);
    let delta = response.drag_delta();
    let dragged = |button| response.dragged_by(button);
    let middle = dragged(PointerButton::Middle);
    let free = state.transform.is_none();
    let (left, right) = (free && dragged(PointerButton::Primary), free && dragged(PointerButton::Secondary));
    if middle && (modifiers.shift || modifiers.alt) {
        state.orbit.pan(delta.x, delta.y, rect.height());
    } else if middle || (left && modifiers.alt) {
        state.orbit.turn(delta.x, delta.y);
    } else if right && modifiers.alt {
        state.orbit.dolly((delta.x - delta.y) / POINTS_PER_NOTCH);
    } else if right {
        state.orbit.look(delta.x, delta.y);
        fly(ui, state, modifiers);
    }
    wheel(ui, state, response, rect, right);
}

/// The photo that a person is found in, and the person's keypoints.
fn photo_over_view(ui: &Ui, state: &EditorState, rect: Rect) {
    let Some(photo) = &state.photo.photo else { return };
    let place = photo.place(rect);
    let painter = ui.painter().with_clip_rect(rect);
    photo.picture.paint_tinted(ui, place, Color32::WHITE.gamma_multiply(state.photo.opacity));
    painter.rect_stroke(place, 0.0, egui::Stroke::new(1.0, Color32::WHITE), egui::StrokeKind::Inside);
    let Some(person) = state.photo_keypoints() else { return };
    let scale = place.width() / photo.size_px[0].max(1) as f32;
    for point in person.points.iter().filter(|point| point.confidence > 0.0) {
        let at = place.min + vec2(point.pixel.x, point.pixel.y) * scale;
        let color = Color32::from_rgb(255, 196, 0).gamma_multiply(0.4 + 0.6 * point.confidence.min(1.0));
        painter.circle(at, 4.0, color, egui::Stroke::new(1.0, Color32::BLACK));
    }
}

/// What is moved by hand follows the mouse.
fn transform(ui: &Ui, state: &mut EditorState, rect: Rect) {
    if state.transform.is_none() {
        return;
    }
    let (at, snap) = ui.input(|i| (i.pointer.latest_pos(), i.modifiers.command));
    if let Some(at) = at {
        let ray = ray_at(state, rect, at);
        state.drag_transform(&ray, snap);
    }
    ui.ctx().set_cursor_icon(egui::CursorIcon::Move);
}

/// A drag that begins on a sub-goal moves it.
fn grip_goal(ui: &Ui, state: &mut EditorState, response: &Response, rect: Rect) {
    let modifiers = ui.input(|i| i.modifiers);
    let free = state.transform.is_none() && state.tool == Tool::Select && !modifiers.alt && !modifiers.shift;
    if !free || !response.drag_started_by(PointerButton::Primary) {
        return;
    }
    let Some(from) = ui.input(|i| i.pointer.press_origin()) else { return };
    let picked = picked_at(state, rect, from);
    if let Some(Picked { item: item @ Item::Goal(..), .. }) = picked {
        if !state.selection.contains(item) {
            state.selection.only(item);
        }
        state.begin_transform(TransformKind::Move);
        let ray = ray_at(state, rect, from);
        state.drag_transform(&ray, false);
        if let Some(transform) = &mut state.transform {
            transform.by_drag = true;
        }
    }
}

/// A press places a sub-goal, a drag from there says which way it faces.
fn place_goal(ui: &Ui, state: &mut EditorState, response: &Response, rect: Rect) {
    if state.tool != Tool::AddGoal || ui.input(|i| i.modifiers.alt) {
        return;
    }
    let (from, now) = ui.input(|i| (i.pointer.press_origin(), i.pointer.latest_pos()));
    if response.drag_started_by(PointerButton::Primary) {
        // A drag that a slow frame has seen begin and end has no origin any more.
        let from = from.or(response.interact_pointer_pos());
        let picked = from.and_then(|from| pick::pick_object(state, &ray_at(state, rect, from)));
        state.motion.placing = picked.map(|p| Placing { at: p.point, towards: p.point });
    }
    if let (Some(placing), Some(now)) = (state.motion.placing, now) {
        let towards = on_plane(&ray_at(state, rect, now), placing.at, Vec3::Y).unwrap_or(placing.towards);
        state.motion.placing = Some(Placing { towards, ..placing });
    }
    if response.drag_stopped_by(PointerButton::Primary)
        && let Some(placing) = state.motion.placing.take()
    {
        state.place_goal(placing);
    } else if response.clicked() {
        let at = response.interact_pointer_pos();
        let picked = at.and_then(|at| pick::pick_object(state, &ray_at(state, rect, at)));
        match picked {
            Some(picked) => state.place_goal(Placing { at: picked.point, towards: picked.point }),
            None => state.notices.warning("There is nothing to be on at this spot."),
        }
    }
}

/// What a press at a point of the view is on: marks of sub-goals before all else.
fn picked_at(state: &EditorState, rect: Rect, at: Pos2) -> Option<Picked> {
    let ray = ray_at(state, rect, at);
    let marked = goal_marks::mark_at(state, rect, at).map(|(item, point)| Picked {
        item,
        point,
        distance_m: point.distance(ray.origin),
        vertex: None,
    });
    marked.or_else(|| pick::pick(state, &ray))
}

/// The left button keeps it, the right one leaves everything as it was.
fn end_transform(ui: &Ui, state: &mut EditorState, response: &Response) {
    if state.transform.as_ref().is_some_and(|transform| transform.by_drag) {
        if !ui.input(|i| i.pointer.primary_down()) {
            state.end_transform(true);
        } else if ui.input(|i| i.pointer.button_pressed(PointerButton::Secondary)) {
            state.end_transform(false);
        }
        return;
    }
    let (left, right) = ui.input(|i| {
        (i.pointer.button_pressed(PointerButton::Primary), i.pointer.button_pressed(PointerButton::Secondary))
    });
    if response.contains_pointer() && (left || right) {
        state.end_transform(left);
    }
}

fn fly(ui: &Ui, state: &mut EditorState, modifiers: Modifiers) {
    let axis = |plus: Key, minus: Key| {
        ui.input(|i| f32::from(u8::from(i.key_down(plus))) - f32::from(u8::from(i.key_down(minus))))
    };
    let way = Vec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S));
    if way != Vec3::ZERO {
        let pace = if modifiers.shift {
            3.0
        } else if modifiers.ctrl {
            0.3
        } else {
            1.0
        };
        state.orbit.fly(way, pace, ui.input(|i| i.stable_dt));
    }
    ui.ctx().request_repaint();
}

fn wheel(ui: &Ui, state: &mut EditorState, response: &Response, rect: Rect, flying: bool) {
    let Some(at) = response.hover_pos().filter(|_| response.contains_pointer()) else { return };
    let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta.y, i.zoom_delta()));
    let notches = scroll / POINTS_PER_NOTCH + if pinch == 1.0 { 0.0 } else { pinch.ln() * 8.0 };
    if notches == 0.0 {
        return;
    }
    if flying {
        let speed = state.orbit.fly_speed_m_s * 1.2_f32.powf(notches);
        state.orbit.fly_speed_m_s = speed.clamp(0.1, 20.0);
        return;
    }
    let ray = ray_at(state, rect, at);
    let under = pick::pick_object(state, &ray).map(|picked| picked.point);
    let camera = state.orbit.camera();
    let at_target = || {
        let along = ray.direction.dot(camera.forward()).max(0.05);
        ray.origin + ray.direction * ((state.orbit.target - ray.origin).dot(camera.forward()) / along)
    };
    let point = under.unwrap_or_else(at_target);
    state.orbit.zoom_to(point, notches);
    ui.ctx().request_repaint();
}

/// What the pointer is over, unless something is being dragged.
fn hovered(ui: &Ui, state: &EditorState, response: &Response, rect: Rect) -> Option<Picked> {
    let at = response.hover_pos()?;
    let busy = response.dragged() || ui.input(|i| i.pointer.any_down() && !i.pointer.any_pressed());
    (response.contains_pointer() && !busy && state.has_room() && state.study.is_none())
        .then(|| picked_at(state, rect, at))
        .flatten()
}

fn click(ui: &Ui, state: &mut EditorState, response: &Response, hovered: Option<Picked>) {
    if response.double_clicked() {
        if let Some(picked) = hovered {
            actions::frame_item(state, picked.item);
        }
        return;
    }
    if !response.clicked() {
        return;
    }
    match state.tool {
        Tool::PutHere => return place(ui, state, hovered),
        Tool::AddGoal => return,
        Tool::Select => {}
    }
    if let Some(Picked { item: Item::Clip(clip) | Item::Goal(clip, _), .. }) = hovered {
        state.activate_clip(clip);
    }
    let add = ui.input(|i| i.modifiers.shift);
    match hovered {
        Some(picked) if add => state.selection.toggle(picked.item),
        Some(picked) => state.selection.only(picked.item),
        None if !add => state.selection.clear(),
        None => {}
    }
}

/// Puts somebody where it was clicked; with Shift the tool stays for the next one.
fn place(ui: &Ui, state: &mut EditorState, hovered: Option<Picked>) {
    let Some(picked) = hovered else {
        state.notices.warning("There is nothing to be on at this spot.");
        return;
    };
    state.start_populating(Some(picked.point));
    if !ui.input(|i| i.modifiers.shift) {
        state.tool = Tool::Select;
    }
}

/// A drag with the left button selects all people, or else all objects, whose middle lies in the box.
fn select_by_box(ui: &Ui, state: &mut EditorState, response: &Response, rect: Rect) {
    let modifiers = ui.input(|i| i.modifiers);
    if modifiers.alt || state.tool != Tool::Select {
        return;
    }
    let left = response.dragged_by(PointerButton::Primary);
    let stopped = response.drag_stopped_by(PointerButton::Primary);
    if !left && !stopped {
        return;
    }
    let Some((from, to)) = ui.input(|i| i.pointer.press_origin().zip(i.pointer.latest_pos())) else {
        return;
    };
    let area = Rect::from_two_pos(from, to).intersect(rect);
    if left {
        let accent = super::theme::palette(ui.visuals()).accent;
        ui.painter().rect(
            area,
            0.0,
            accent.gamma_multiply(0.15),
            egui::Stroke::new(1.0, accent),
            egui::StrokeKind::Inside,
        );
    }
    if stopped {
        let items = items_in(state, rect, area);
        if modifiers.shift {
            state.selection.extend(items);
        } else {
            state.selection.set(items);
        }
    }
}

fn items_in(state: &EditorState, rect: Rect, area: Rect) -> Vec<Item> {
    let clip = state.orbit.camera().clip_from_world(rect.width() / rect.height());
    let inside = |item: Item| {
        let bounds = state.bounds_of(item);
        let ndc = clip.project_point3(bounds.center());
        let x = rect.left() + (ndc.x * 0.5 + 0.5) * rect.width();
        let y = rect.top() + (0.5 - ndc.y * 0.5) * rect.height();
        !bounds.is_empty() && (0.0..=1.0).contains(&ndc.z) && area.contains(Pos2::new(x, y))
    };
    let scene = state.document.scene();
    let people = scene.people.iter().filter(|p| p.visible).map(|p| Item::Person(p.id));
    let people: Vec<Item> = people.filter(|item| inside(*item)).collect();
    if !people.is_empty() {
        return people;
    }
    let things = scene.room.objects.iter().filter(|o| o.visible && !o.category.is_structure());
    things.map(|o| Item::Object(o.id)).filter(|item| inside(*item)).collect()
}

/// With Alt held over a painted body: the signed distance there.
fn value_under_cursor(ui: &Ui, state: &EditorState, response: &Response, hovered: Option<Picked>) {
    let Some(Picked { item: Item::Person(id), vertex: Some(vertex), .. }) = hovered else { return };
    if state.view.heat == Heat::Off || !ui.input(|i| i.modifiers.alt) {
        return;
    }
    let distance_m = state.measured(id).and_then(|m| m.distances_m.get(vertex)).copied();
    if let (Some(distance_m), Some(at)) = (distance_m, response.hover_pos()) {
        let text = format!("{:+.0} mm", distance_m * 1e3);
        let place = at + vec2(14.0, -14.0);
        let galley = ui.painter().layout_no_wrap(text, FontId::monospace(12.0), Color32::WHITE);
        let rect = Align2::LEFT_BOTTOM.anchor_size(place, galley.size()).expand(4.0);
        ui.painter().rect_filled(rect, 4.0, Color32::from_black_alpha(190));
        ui.painter().galley(rect.min + vec2(4.0, 4.0), galley, Color32::WHITE);
    }
}

fn tool_cursor(ui: &Ui, state: &EditorState, response: &Response) {
    if state.tool != Tool::Select && response.hovered() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Crosshair);
    }
}

fn menu(state: &mut EditorState, response: &Response) {
    if state.selection.is_empty() {
        return;
    }
    response.context_menu(|ui| {
        for id in [
            "frame",
            "why",
            "move",
            "turn",
            "settle",
            "re-roll",
            "isolate",
            "hide",
            "lock",
            "duplicate",
            "rename",
            "delete",
        ] {
            if panels::menu_entry(ui, state, id) {
                ui.close();
            }
        }
    });
}
