//! Things that actions bring: a list with pictures, bounds and bans; the pages that add one of the user's own.

use std::path::{Path, PathBuf};

use egui::{
    Button, CollapsingHeader, ComboBox, Context, DragValue, Grid, Id, Modal, RichText, ScrollArea, Sense,
    TextEdit, Ui, vec2,
};

use super::overlays::path_field;
use crate::app::actions;
use crate::app::engine::ThingKind;
use crate::app::icons::{self, Icon};
use crate::app::state::{EditorState, Overlay};
use crate::app::theme;
use crate::app::things::{MANY_TRIANGLES, ThingForm};

/// Side of a picture in the list.
const PICTURE: f32 = 40.0;
/// Most of a kind that a room may be said to take.
const MOST: usize = 99;
/// The list is as high as so many rows.
const ROWS: f32 = 5.5;
/// Files that a thing may come from.
pub const THING_FILES: [&str; 4] = ["glb", "gltf", "obj", "ply"];

/// Whether a file may hold a thing.
pub fn may_be_a_thing(path: &Path) -> bool {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    THING_FILES.contains(&ending.as_str())
}

/// The section of the actions panel.
pub fn things(ui: &mut Ui, state: &mut EditorState) {
    let kinds = state.thing_kinds();
    let title = format!("Things ({})", kinds.len());
    let header = CollapsingHeader::new(title).id_salt("things").default_open(state.things.unfolded);
    header.show(ui, |ui| {
        ui.horizontal(|ui| {
            let width = ui.available_width() - 92.0;
            let query =
                TextEdit::singleline(&mut state.things.query).hint_text("Filter").desired_width(width);
            let response = ui.add(query);
            response
                .widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Filter the things"));
            let tip = "A model of your own (GLB, OBJ, PLY): say what it is, how large and which side is the \
                       front. Files can be dropped on the window, too.";
            if ui.button("Add yours...").on_hover_text(tip).clicked() {
                state.requests.thing_dialog = true;
            }
        });
        let query = state.things.query.trim().to_lowercase();
        let listed: Vec<ThingKind> =
            kinds.iter().filter(|kind| kind.kind.contains(&query)).cloned().collect();
        if listed.is_empty() {
            ui.weak("No kind has these letters.");
        }
        ScrollArea::vertical().id_salt("list of things").max_height(ROWS * (PICTURE + 6.0)).show(ui, |ui| {
            rows(ui, state, &listed);
        });
    });
}

/// One row for each kind; only those that are seen get their pictures.
fn rows(ui: &mut Ui, state: &mut EditorState, listed: &[ThingKind]) {
    let mut seen = Vec::new();
    for kind in listed {
        ui.push_id(&kind.kind, |ui| {
            let row = ui.horizontal(|ui| row(ui, state, kind));
            if ui.is_rect_visible(row.response.rect) {
                seen.push(kind.kind.clone());
            }
        });
    }
    state.keep_things_drawn(&seen);
}

fn row(ui: &mut Ui, state: &mut EditorState, kind: &ThingKind) {
    picture(ui, state, kind);
    let banned = state.living.choice.banned.iter().any(|name| *name == kind.kind);
    let own = state.living.choice.own.iter().filter(|thing| thing.kind == kind.kind).count();
    let models = if kind.models == 1 { "1 model".to_owned() } else { format!("{} models", kind.models) };
    let yours = if own > 0 { format!(", {own} of yours") } else { String::new() };
    ui.allocate_ui(vec2((ui.available_width() - 76.0).max(40.0), PICTURE), |ui| {
        ui.vertical(|ui| {
            ui.add_space(3.0);
            let name = RichText::new(&kind.kind);
            let name = if banned { name.weak().strikethrough() } else { name };
            ui.add(egui::Label::new(name).truncate());
            ui.add(egui::Label::new(RichText::new(format!("{models}{yours}")).small().weak()).truncate());
        });
    });
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        // The scroll bar lies over the edge.
        ui.add_space(6.0);
        let verb = if banned { "Allow" } else { "Ban" };
        let strength = if banned { 1.0 } else { 0.35 };
        if icons::button(ui, Icon::Ban, &format!("{verb} {}", kind.kind), strength).clicked() {
            state.toggle_ban(&kind.kind);
        }
        let mut most = state.most_of(kind);
        let edited = most != kind.most;
        let drag = DragValue::new(&mut most).range(0..=MOST).speed(0.1);
        let response = ui.add_enabled_ui(!banned, |ui| ui.add(drag)).inner;
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::SpinButton, true, format!("Most of: {}", kind.kind))
        });
        let usual = if edited { format!(" The library says {}.", kind.most) } else { String::new() };
        let tip = format!("So many a room takes; then those that are there are used again.{usual}");
        if response.on_hover_text(tip).changed() {
            state.set_most(kind, most);
        }
    });
}

fn picture(ui: &mut Ui, state: &EditorState, kind: &ThingKind) {
    let size = vec2(PICTURE, PICTURE);
    let Some(look) = state.thing_look(&kind.kind) else {
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        ui.painter().rect_filled(rect, 3.0, ui.visuals().faint_bg_color);
        return;
    };
    let response = look.picture.show(ui, size, Sense::hover(), &kind.kind);
    response.on_hover_ui(|ui| {
        look.picture.show(ui, vec2(96.0, 96.0), Sense::hover(), &kind.kind);
        let [w, h, d] = (look.size_m * 100.0).to_array();
        ui.label(format!("{w:.0} x {d:.0} cm, {h:.0} cm high"));
    });
}

/// What a dropped file is: asked where a room is open already.
pub fn dropped(ctx: &Context, state: &mut EditorState, path: &Path) {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let response = Modal::new(Id::unique("dropped")).show(ctx, |ui| {
        ui.set_width(380.0);
        ui.heading(&name);
        ui.label("Is it a room, or a thing that people bring and use in rooms?");
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            if ui.button("Open as a room").clicked() {
                state.overlay = Overlay::None;
                actions::open_file(state, path.to_path_buf());
            }
            if ui.button("Add to the things").clicked() {
                state.begin_thing(path);
            }
            if ui.button("Neither").clicked() {
                state.overlay = Overlay::None;
            }
        });
    });
    if response.should_close() {
        state.overlay = Overlay::None;
    }
}

/// The path of a thing, typed where the desktop has no file dialog.
pub fn thing_path(ctx: &Context, state: &mut EditorState, mut text: String) {
    let mut chosen = false;
    let response = Modal::new(Id::unique("thing path")).show(ctx, |ui| {
        ui.set_width(480.0_f32.min(ctx.content_rect().width() - 60.0));
        ui.heading("Add a thing of yours");
        let (entered, pressed) = path_field(ui, &mut text, "Path of a GLB, glTF, OBJ or PLY file", "Read");
        chosen = entered || pressed;
    });
    if chosen && !text.trim().is_empty() {
        state.begin_thing(&PathBuf::from(text.trim()));
    } else if response.should_close() {
        state.overlay = Overlay::None;
    } else {
        state.overlay = Overlay::ThingPath(text);
    }
}

/// Kind, size and front of a thing that is being added.
pub fn add_thing(ctx: &Context, state: &mut EditorState) {
    state.keep_form_fresh();
    let kinds = state.thing_kinds();
    let Some(mut form) = state.things.form.take() else {
        state.overlay = Overlay::None;
        return;
    };
    let (mut add, mut leave) = (false, false);
    Modal::new(Id::unique("add thing")).show(ctx, |ui| {
        ui.set_width(340.0_f32.min(ctx.content_rect().width() - 60.0));
        ui.heading("Add a thing of yours");
        preview(ui, &form);
        turning(ui, &mut form);
        fields(ui, &mut form, &kinds);
        remarks(ui, &form);
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let missing = form.missing();
            let palette = theme::palette(ui.visuals());
            let button = Button::new(RichText::new("Add").color(palette.on_accent)).fill(palette.accent);
            let response = ui.add_enabled(missing.is_none(), button);
            add = response.on_disabled_hover_text(missing.unwrap_or_default()).clicked();
            leave = ui.button("Cancel").clicked();
        });
    });
    if add {
        state.things.form = Some(form);
        state.add_thing();
    } else if leave {
        state.overlay = Overlay::None;
    } else {
        // A click beside it does not throw away what was typed; Escape does.
        state.things.form = Some(form);
    }
}

fn preview(ui: &mut Ui, form: &ThingForm) {
    let side = ui.available_width().min(240.0);
    ui.vertical_centered(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Image, true, "The thing, seen by somebody before it")
        });
        ui.painter().rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
        let fresh = form.look.as_ref().is_some_and(|(of, _)| *of == form.attitude);
        if let Some((_, picture)) = &form.look {
            let tint = if fresh { 255 } else { 110 };
            picture.paint_tinted(ui, rect, egui::Color32::from_white_alpha(tint));
        }
        if !fresh {
            let middle = egui::Rect::from_center_size(rect.center(), vec2(28.0, 28.0));
            egui::Spinner::new().size(28.0).paint_at(ui, middle);
        }
    });
}

fn turning(ui: &mut Ui, form: &mut ThingForm) {
    ui.label(RichText::new("Turn it until it stands upright and its front looks at you.").small().weak());
    ui.horizontal(|ui| {
        let attitude = &mut form.attitude;
        if ui.button("Turn").on_hover_text("A quarter turn about the vertical").clicked() {
            attitude.turns = (attitude.turns + 1) % 4;
        }
        if ui.button("Tip over").on_hover_text("A quarter turn forward").clicked() {
            attitude.tips = (attitude.tips + 1) % 4;
        }
        if ui.button("As in the file").clicked() {
            *attitude = super::super::things::Attitude::default();
        }
    });
}

fn fields(ui: &mut Ui, form: &mut ThingForm, kinds: &[ThingKind]) {
    Grid::new("own thing").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let label = ui.label("Name");
        ui.add(TextEdit::singleline(&mut form.name).desired_width(200.0)).labelled_by(label.id);
        ui.end_row();
        let label = ui.label("Kind");
        let shown = if form.kind.is_empty() { "choose..." } else { form.kind.as_str() }.to_owned();
        let combo = ComboBox::from_id_salt("kind of thing").selected_text(shown).width(200.0);
        let combo = combo.show_ui(ui, |ui| {
            for kind in kinds {
                ui.selectable_value(&mut form.kind, kind.kind.clone(), &kind.kind);
            }
        });
        combo.response.labelled_by(label.id).on_hover_text("Actions bring it where they bring this kind.");
        ui.end_row();
        let label = ui.label("Longest side");
        let mut cm = form.longest_m * 100.0;
        let drag = DragValue::new(&mut cm).range(0.5..=600.0).speed(0.5).suffix(" cm").max_decimals(1);
        if ui.add(drag).labelled_by(label.id).changed() {
            (form.longest_m, form.sized) = (cm / 100.0, true);
        }
        ui.end_row();
    });
}

fn remarks(ui: &mut Ui, form: &ThingForm) {
    let Some(model) = &form.model else { return };
    if let Some(size_m) = form.size_m() {
        let [w, h, d] = (size_m * 100.0).to_array();
        ui.label(RichText::new(format!("{w:.0} cm wide, {d:.0} cm deep, {h:.0} cm high")).small().weak());
    }
    let triangles = model.triangle_count();
    let text = format!("{triangles} triangles");
    if triangles > MANY_TRIANGLES {
        let warn = theme::palette(ui.visuals()).warn;
        ui.label(RichText::new(format!("{text}: every action with it will be slow.")).small().color(warn));
    } else {
        ui.label(RichText::new(text).small().weak());
    }
}
