//! Details of what is selected: a person's metrics, findings and shape; an object's name and category.

use egui::{Color32, Grid, RichText, ScrollArea, Slider, SliderClamping, Ui};

use super::findings::number_text;
use super::outliner::capitalised;
use super::{empty, title};
use crate::app::actions;
use crate::app::selection::Item;
use crate::app::state::EditorState;
use crate::app::theme;
use crate::document::Command;
use crate::inspect::BodyMetrics;
use crate::inspect::Limits;
use crate::inspect::Site;
use crate::scene::Category;
use crate::scene::Object;
use crate::scene::ObjectId;
use crate::scene::Person;
use crate::scene::PersonId;

/// What the first shape numbers change; the rest have no everyday name.
pub const SHAPE_NAMES: [&str; 3] = ["Size", "Weight", "Build"];

/// Draws the details of the active item.
pub fn inspector(ui: &mut Ui, state: &mut EditorState) {
    let scene = state.document.scene();
    match state.selection.active() {
        Some(Item::Person(id)) => {
            if let Some(person) = scene.person(id).cloned() {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| person_details(ui, state, &person));
            }
        }
        Some(Item::Object(id)) => {
            let room = scene.room.clone();
            if let Some(object) = room.object(id) {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| object_details(ui, state, object));
            }
        }
        Some(Item::Clip(id)) => super::motion::clip_details(ui, state, id),
        Some(Item::Goal(clip, goal)) => super::motion::goal_details(ui, state, clip, goal),
        None => room_details(ui, state),
    }
}

fn person_details(ui: &mut Ui, state: &mut EditorState, person: &Person) {
    name_field(ui, state, Item::Person(person.id), &person.name);
    Grid::new("person").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        row(ui, "Does", person.family.label());
        row(ui, "Held by", &person.on);
        row(ui, "Seed", &person.seed.to_string());
    });
    ui.horizontal(|ui| {
        super::command_button(ui, state, "re-roll");
        super::command_button(ui, state, "frame");
        super::command_button(ui, state, "delete");
    });
    title(ui, "Measured");
    match state.measured(person.id).map(|m| m.report.clone()) {
        Some(report) => metrics(ui, person.id, &report.metrics),
        None => {
            ui.weak(if state.geometry().is_some() { "Measuring..." } else { "Waits for the room analysis." });
        }
    }
    title(ui, "Shape");
    ui.add_enabled_ui(!person.locked, |ui| shape(ui, state, person));
}

fn metrics(ui: &mut Ui, id: PersonId, metrics: &BodyMetrics) {
    let palette = theme::palette(ui.visuals());
    let limits = Limits::default();
    let findings = limits.findings(Site { body: id.0, frame: None }, metrics);
    let yes_no = |yes: bool| if yes { "yes" } else { "no" }.to_owned();
    let good = |fine: bool| if fine { palette.good } else { palette.bad };
    let deep = metrics.penetration_max_mm;
    let rows: [(&str, String, Color32, &str); 7] = [
        (
            "Non-collision",
            format!("{:.4}", metrics.psi_non_collision),
            good(metrics.psi_non_collision >= limits.psi_non_collision),
            "PSI 4.1.4: share of the body's vertices in free space.",
        ),
        ("Contact", yes_no(metrics.contact_2cm), good(metrics.contact_2cm), "Skin within 2 cm of a surface."),
        (
            "Held",
            yes_no(metrics.supported),
            good(metrics.supported),
            "The weight stands over what carries it.",
        ),
        (
            "Deepest penetration",
            format!("{deep:.1} mm"),
            good(deep <= limits.penetration_max_mm),
            "Of the body in the room and of the room's surfaces in the body.",
        ),
        (
            "Mean penetration",
            format!("{:.1} mm", metrics.penetration_mean_mm),
            ui.visuals().text_color(),
            "Over the vertices that penetrate.",
        ),
        (
            "Contact area",
            format!("{:.0} cm²", metrics.contact_area_cm2),
            ui.visuals().text_color(),
            "Skin within 2 cm of a surface.",
        ),
        (
            "Beyond joint limits",
            format!("{:.0}°", metrics.joint_limit_deg),
            good(metrics.joint_limit_deg <= limits.joint_limit_deg),
            "Largest excess over what a joint can bend.",
        ),
    ];
    Grid::new("metrics").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        for (name, value, color, tip) in rows {
            ui.label(name).on_hover_text(tip);
            ui.label(RichText::new(value).monospace().color(color));
            ui.end_row();
        }
    });
    areas(ui, metrics);
    for finding in findings {
        let (value, limit) = (number_text(finding.value), number_text(finding.limit));
        let text = format!("{}: {value}, limit {limit}", finding.metric.label());
        ui.label(RichText::new(text).small().color(palette.bad));
    }
}

/// Contact by region, the largest first; regions without contact are left out.
fn areas(ui: &mut Ui, metrics: &BodyMetrics) {
    let mut areas: Vec<_> = metrics.contact_area_by_region_cm2.iter().filter(|(_, a)| **a >= 0.5).collect();
    areas.sort_by(|a, b| b.1.total_cmp(a.1));
    if areas.is_empty() {
        return;
    }
    egui::CollapsingHeader::new("Contact by region").id_salt("contact areas").show(ui, |ui| {
        Grid::new("areas").num_columns(2).spacing([12.0, 2.0]).show(ui, |ui| {
            for (region, area) in areas {
                row(ui, region, &format!("{area:.0} cm²"));
            }
        });
    });
}

fn shape(ui: &mut Ui, state: &mut EditorState, person: &Person) {
    ui.spacing_mut().slider_width = (ui.available_width() - 150.0).clamp(60.0, 220.0);
    Grid::new("betas").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        for i in 0..person.body.betas.len() {
            let name = SHAPE_NAMES.get(i).map_or_else(|| format!("Shape {}", i + 1), |n| (*n).to_owned());
            let label = ui.label(name);
            let mut value = person.body.betas[i];
            // Neither clamped nor rounded: a slider that is only looked at must not change anybody.
            let slider = Slider::new(&mut value, -3.0..=3.0)
                .clamping(SliderClamping::Never)
                .custom_formatter(|number, _| format!("{number:.2}"));
            let response = ui.add(slider).labelled_by(label.id);
            drag_step(state, &response, "Change shape");
            if response.changed() {
                actions::set_beta(state, person.id, i, value);
            }
            ui.end_row();
        }
    });
}

/// Makes one undo step of a whole drag.
fn drag_step(state: &mut EditorState, response: &egui::Response, label: &str) {
    if response.drag_started() {
        state.document.begin(label);
    }
    if response.drag_stopped() {
        state.document.commit();
    }
}

fn object_details(ui: &mut Ui, state: &mut EditorState, object: &Object) {
    name_field(ui, state, Item::Object(object.id), &object.name);
    category_field(ui, state, object.id, object.category);
    let bounds = object.world_bounds();
    let (size, at) = (bounds.size(), bounds.center());
    Grid::new("object").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        row(ui, "Size", &format!("{:.2} x {:.2} x {:.2} m", size.x, size.y, size.z));
        row(ui, "Centre", &format!("{:.2}, {:.2}, {:.2} m", at.x, at.y, at.z));
        row(ui, "Triangles", &object.triangle_count().to_string());
    });
    ui.horizontal(|ui| {
        super::command_button(ui, state, "frame");
        super::command_button(ui, state, "isolate");
        super::command_button(ui, state, "delete");
    });
}

fn category_field(ui: &mut Ui, state: &mut EditorState, id: ObjectId, present: Category) {
    ui.horizontal(|ui| {
        let label = ui.label("Category");
        let combo = egui::ComboBox::from_id_salt("object category")
            .selected_text(capitalised(present.label()))
            .width(160.0)
            .height(360.0);
        let response = combo.show_ui(ui, |ui| {
            for category in Category::ALL {
                if ui.selectable_label(category == present, capitalised(category.label())).clicked() {
                    state.apply(Command::SetCategory(vec![id], category));
                }
            }
        });
        response.response.labelled_by(label.id);
    });
}

/// A name that is taken when Enter is pressed or the field is left.
pub fn name_field(ui: &mut Ui, state: &mut EditorState, item: Item, name: &str) {
    let id = ui.scope_id().with(("name", item));
    let mut text = ui.data(|d| d.get_temp::<String>(id)).unwrap_or_else(|| name.to_owned());
    let edit = egui::TextEdit::singleline(&mut text)
        .hint_text("Name")
        .desired_width(f32::INFINITY)
        .font(egui::TextStyle::Heading);
    let response = ui.add(edit);
    if response.lost_focus() {
        ui.data_mut(|d| d.remove::<String>(id));
        if ui.input(|i| !i.key_pressed(egui::Key::Escape)) && text != name {
            actions::give_name(state, item, text);
        }
    } else if response.has_focus() {
        ui.data_mut(|d| d.insert_temp(id, text));
    }
    ui.add_space(2.0);
}

fn room_details(ui: &mut Ui, state: &mut EditorState) {
    if !state.has_room() {
        empty(ui, "Nothing is open.");
        return;
    }
    let room = state.document.scene().room.clone();
    ui.heading(&room.name);
    let size = state.import.as_ref().map_or(glam::Vec3::ZERO, |i| i.extent_m);
    Grid::new("room").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        row(ui, "Objects", &room.objects.len().to_string());
        row(ui, "Triangles", &room.triangle_count().to_string());
        row(ui, "Size", &format!("{:.1} x {:.1} m, {:.1} m high", size.x, size.z, size.y));
        row(ui, "Analysis", if state.geometry().is_some() { "ready" } else { "under way" });
    });
    super::command_button(ui, state, "import-report");
    ui.add_space(6.0);
    ui.weak("Click a person or an object to see its details.");
}

pub fn row(ui: &mut Ui, name: &str, value: &str) {
    ui.weak(name);
    ui.label(value);
    ui.end_row();
}
