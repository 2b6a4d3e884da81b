//! What lies over the window: palette, help, paths, import report, history, notifications.

use std::path::{Path, PathBuf};

use egui::{Align2, Context, Grid, Id, Key, Modal, RichText, ScrollArea, TextEdit, Ui, Window};

use super::toasts::level_color;
use crate::app::actions;
use crate::app::commands::{self, COMMANDS, CommandInfo, Menu};
use crate::app::engine::{ImportChoice, ImportSummary, MotionFormat, Source};
use crate::app::selection::Item;
use crate::app::state::{EditorState, Leaving, Overlay};
use crate::app::theme;
use crate::scene::UpAxis;

/// Draws what lies over the window, if anything does.
pub fn overlays(ctx: &Context, state: &mut EditorState) {
    match state.overlay.clone() {
        Overlay::None => {}
        Overlay::Palette { query, row } => palette(ctx, state, query, row),
        Overlay::Shortcuts => window(ctx, state, "Keyboard shortcuts", 560.0, |ui, _| shortcuts(ui)),
        Overlay::Help => window(ctx, state, "Help", 520.0, |ui, _| help(ui)),
        Overlay::OpenPath(text) => open_path(ctx, state, text),
        Overlay::SavePath(text) => save_path(ctx, state, text),
        Overlay::ExportPath(text) => export_path(ctx, state, text),
        Overlay::ExportMotion => export_motion(ctx, state),
        Overlay::Study => super::study::study_setup(ctx, state),
        Overlay::Import => window(ctx, state, "Import report", 460.0, import_report),
        Overlay::History => window(ctx, state, "History", 300.0, history),
        Overlay::Notifications => window(ctx, state, "Notifications", 460.0, notifications),
        Overlay::Rename(item, text) => rename(ctx, state, item, text),
        Overlay::Recover(path) => recover(ctx, state, &path),
        Overlay::Unsaved(leaving) => unsaved(ctx, state, &leaving),
        Overlay::Dropped(path) => super::things::dropped(ctx, state, &path),
        Overlay::ThingPath(text) => super::things::thing_path(ctx, state, text),
        Overlay::AddThing => super::things::add_thing(ctx, state),
        Overlay::Learned(node) => window(ctx, state, "What was learned", 880.0, |ui, state| {
            super::learned::learned(ui, state, node);
        }),
        Overlay::NewRoom => window(ctx, state, "New room", 520.0, super::new_room::new_room),
        Overlay::Networks(number) => window(ctx, state, "Networks", 780.0, |ui, state| {
            super::networks::networks(ui, state, number);
        }),
    }
}

fn window(
    ctx: &Context,
    state: &mut EditorState,
    title: &str,
    width: f32,
    contents: impl FnOnce(&mut Ui, &mut EditorState),
) {
    let mut open = true;
    let height = (ctx.content_rect().height() - 140.0).max(120.0);
    Window::new(title)
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .default_width(width.min(ctx.content_rect().width() - 40.0))
        .max_width(width.min(ctx.content_rect().width() - 40.0))
        .show(ctx, |ui| {
            ScrollArea::vertical()
                .max_height(height)
                .min_scrolled_height(height)
                .show(ui, |ui| contents(ui, state));
        });
    if !open {
        state.overlay = Overlay::None;
    }
}

fn palette(ctx: &Context, state: &mut EditorState, mut query: String, mut row: usize) {
    let before = query.clone();
    let found = matching(&query);
    row = row.min(found.len().saturating_sub(1));
    let (up, down, enter) = ctx.input_mut(|i| {
        let none = egui::Modifiers::NONE;
        (
            i.consume_key(none, Key::ArrowUp),
            i.consume_key(none, Key::ArrowDown),
            i.consume_key(none, Key::Enter),
        )
    });
    row = if up { row.saturating_sub(1) } else { row };
    row = if down { (row + 1).min(found.len().saturating_sub(1)) } else { row };
    let mut chosen = if enter { found.get(row).copied() } else { None };
    let response = Modal::new(Id::unique("palette")).show(ctx, |ui| {
        ui.set_width(440.0_f32.min(ctx.content_rect().width() - 60.0));
        let edit = TextEdit::singleline(&mut query).hint_text("Type a command").desired_width(f32::INFINITY);
        let edit = ui.add(edit);
        edit.request_focus();
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(320.0).auto_shrink([false, true]).show(ui, |ui| {
            if found.is_empty() {
                ui.weak("No command has these letters.");
            }
            for (i, command) in found.iter().enumerate() {
                if palette_row(ui, state, command, i == row, up || down) {
                    chosen = Some(command);
                }
            }
        });
    });
    if let Some(command) = chosen {
        state.overlay = Overlay::None;
        if (command.enabled)(state) {
            (command.run)(state);
        } else {
            state.notices.warning(format!("{} is not possible now.", command.label));
        }
    } else if response.should_close() {
        state.overlay = Overlay::None;
    } else {
        let row = if query == before { row } else { 0 };
        state.overlay = Overlay::Palette { query, row };
    }
}

fn palette_row(ui: &mut Ui, state: &EditorState, command: &CommandInfo, marked: bool, follow: bool) -> bool {
    let key = command.keys.first().map(commands::key_text).unwrap_or_default();
    let label = format!("{}: {}", command.menu.label(), command.label);
    let button = egui::Button::selectable(marked, label)
        .shortcut_text(key)
        .min_size(egui::vec2(ui.available_width(), 24.0));
    let response = ui.add_enabled((command.enabled)(state), button).on_hover_text(command.tip);
    if marked && follow {
        response.scroll_to_me(None);
    }
    response.clicked()
}

/// The commands that the typed letters find, the best first.
fn matching(query: &str) -> Vec<&'static CommandInfo> {
    let mut found: Vec<(usize, &CommandInfo)> = COMMANDS
        .iter()
        .filter(|c| c.id != "palette" && c.id != "escape")
        .filter_map(|c| commands::match_score(query, c.label).map(|score| (score, c)))
        .collect();
    found.sort_by_key(|(score, _)| *score);
    found.into_iter().map(|(_, command)| command).collect()
}

fn shortcuts(ui: &mut Ui) {
    ui.columns(2, |columns| {
        for (i, menu) in Menu::ALL.into_iter().enumerate() {
            let ui = &mut columns[usize::from(i > 2)];
            super::title(ui, menu.label());
            Grid::new(("keys", menu.label())).num_columns(2).spacing([14.0, 2.0]).show(ui, |ui| {
                for command in COMMANDS.iter().filter(|c| c.menu == menu && !c.keys.is_empty()) {
                    let keys: Vec<String> = command.keys.iter().map(commands::key_text).collect();
                    ui.label(command.label);
                    ui.label(RichText::new(keys.join(" or ")).monospace().weak());
                    ui.end_row();
                }
            });
        }
    });
    super::title(ui, "Mouse");
    Grid::new("mouse").num_columns(2).spacing([14.0, 2.0]).show(ui, |ui| {
        for (what, how) in MOUSE {
            ui.label(*what);
            ui.label(RichText::new(*how).monospace().weak());
            ui.end_row();
        }
    });
}

/// What the mouse does in the viewport.
const MOUSE: &[(&str, &str)] = &[
    ("Turn", "Middle drag, or Alt + left drag"),
    ("Move", "Shift + middle drag, or Alt + middle drag"),
    ("Zoom to the cursor", "Wheel"),
    ("Zoom", "Alt + right drag"),
    ("Look around and fly", "Right drag with W A S D, Q E; Shift fast, Ctrl slow, wheel: speed"),
    ("Move or turn the selection", "G or R, then X, Y, Z, a number; click or Enter keeps it"),
    ("Select, add or remove", "Click, Shift + click"),
    ("Select several", "Drag on empty ground"),
    ("Frame what is under the cursor", "Double click"),
    ("Read the distance under the cursor", "Hold Alt while the heat map is on"),
];

fn help(ui: &mut Ui) {
    for (head, text) in [
        (
            "Open a room",
            "Drop a GLB, glTF, OBJ or PLY file on the window, or use File > Open. Unit and up axis are detected; the import report says what was understood and lets you change it.",
        ),
        (
            "Put people in",
            "Press Populate, or choose 'Put somebody here' and click a seat, a bed or the floor. While it runs you see them settle; Cancel stops at once and changes nothing.",
        ),
        (
            "Sample from a view",
            "Turn the view to a corner of the room, open the Sample panel and press Sample: candidates come up below, the best first. Click one to see it in the view, double click to accept it; it is fitted as you watch. 'Why like this' shows what the sampler saw and what the fit changed.",
        ),
        (
            "Look closer",
            "Select a person: the inspector says how well it is held and how deep it sinks. M paints bodies by distance: blue is free, white touches, yellow to red is inside something.",
        ),
        (
            "Change your mind",
            "Everything can be undone. F9 makes the selected people anew with another seed; L protects those you like.",
        ),
        (
            "Take it along",
            "Save writes the people with all their numbers and the room; it opens again exactly as it was.",
        ),
    ] {
        ui.strong(head);
        ui.label(text);
        ui.add_space(6.0);
    }
    ui.weak("Ctrl+K finds every command, ? lists every key.");
}

fn open_path(ctx: &Context, state: &mut EditorState, mut text: String) {
    let recent = state.recent.clone();
    let mut chosen: Option<PathBuf> = None;
    let response = Modal::new(Id::unique("open path")).show(ctx, |ui| {
        ui.set_width(480.0_f32.min(ctx.content_rect().width() - 60.0));
        ui.heading("Open a file");
        let (entered, opened) = path_field(ui, &mut text, "Path of a room or project", "Open");
        if entered || opened {
            chosen = Some(PathBuf::from(text.trim()));
        }
        for path in recent.iter().take(8) {
            if ui.add(egui::Button::new(path.display().to_string()).frame(false).truncate()).clicked() {
                chosen = Some(path.clone());
            }
        }
    });
    if let Some(path) = chosen.filter(|p| !p.as_os_str().is_empty()) {
        state.overlay = Overlay::None;
        actions::open_file(state, path);
    } else if response.should_close() {
        state.overlay = Overlay::None;
    } else {
        state.overlay = Overlay::OpenPath(text);
    }
}

fn save_path(ctx: &Context, state: &mut EditorState, mut text: String) {
    let mut chosen = false;
    let response = Modal::new(Id::unique("save path")).show(ctx, |ui| {
        ui.set_width(480.0_f32.min(ctx.content_rect().width() - 60.0));
        ui.heading("Save the project");
        let (entered, saved) = path_field(ui, &mut text, "Path ending in .inhabit or .ron", "Save");
        chosen = entered || saved;
        ui.weak(".inhabit keeps all in one file; .ron writes the room beside it as room.glb.");
    });
    if chosen && !text.trim().is_empty() {
        state.overlay = Overlay::None;
        state.start_saving(with_project_extension(PathBuf::from(text.trim())));
    } else if response.should_close() {
        state.overlay = Overlay::None;
    } else {
        state.overlay = Overlay::SavePath(text);
    }
}

fn export_path(ctx: &Context, state: &mut EditorState, mut text: String) {
    let mut chosen = false;
    let response = Modal::new(Id::unique("export path")).show(ctx, |ui| {
        ui.set_width(480.0_f32.min(ctx.content_rect().width() - 60.0));
        ui.heading("Export room and people");
        let (entered, pressed) = path_field(ui, &mut text, "Path of a folder; it is made if it is missing", "Export");
        chosen = entered || pressed;
        ui.weak("room.glb and people/000.glb and so on, in one frame: metres, Y up. Files of these names are replaced.");
    });
    if chosen && !text.trim().is_empty() {
        state.overlay = Overlay::None;
        state.start_exporting(PathBuf::from(text.trim()));
    } else if response.should_close() {
        state.overlay = Overlay::None;
    } else {
        state.overlay = Overlay::ExportPath(text);
    }
}

fn export_motion(ctx: &Context, state: &mut EditorState) {
    let mut chosen = false;
    let response = Modal::new(Id::unique("export motion")).show(ctx, |ui| {
        ui.set_width(520.0_f32.min(ctx.content_rect().width() - 60.0));
        ui.heading("Export motion");
        ui.horizontal_wrapped(|ui| {
            for format in MotionFormat::ALL {
                let on = state.motion.export.format == format;
                if ui.selectable_label(on, format.label()).on_hover_text(format.purpose()).clicked() && !on {
                    state.ask_motion_export(format);
                }
            }
        });
        ui.weak(state.motion.export.format.purpose());
        let hint = if state.motion.export.format == MotionFormat::Pictures {
            "Path of a folder; it is made if it is missing"
        } else {
            "Path of the file"
        };
        let (entered, pressed) = path_field(ui, &mut state.motion.export.path, hint, "Export");
        chosen = entered || pressed;
    });
    if chosen && !state.motion.export.path.trim().is_empty() {
        state.overlay = Overlay::None;
        state.start_motion_export();
    } else if response.should_close() {
        state.overlay = Overlay::None;
    }
}

/// The path with `.inhabit` if it has no project's extension.
pub fn with_project_extension(path: PathBuf) -> PathBuf {
    if crate::app::jobs::is_project_file(&path) {
        return path;
    }
    let mut name = path.into_os_string();
    name.push(".inhabit");
    PathBuf::from(name)
}

/// A field for a path with its button: whether Enter was pressed, whether the button was.
pub(super) fn path_field(ui: &mut Ui, text: &mut String, hint: &str, button: &str) -> (bool, bool) {
    ui.horizontal(|ui| {
        let width = ui.available_width() - 70.0;
        let edit = ui.add(TextEdit::singleline(text).hint_text(hint).desired_width(width));
        let entered = edit.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
        if !entered {
            edit.request_focus();
        }
        (entered, ui.button(button).clicked())
    })
    .inner
}

fn rename(ctx: &Context, state: &mut EditorState, item: Item, mut text: String) {
    let mut chosen = false;
    let response = Modal::new(Id::unique("rename")).show(ctx, |ui| {
        ui.set_width(320.0);
        ui.heading("Rename");
        let (entered, pressed) = path_field(ui, &mut text, "New name", "Rename");
        chosen = entered || pressed;
    });
    if chosen {
        state.overlay = Overlay::None;
        actions::give_name(state, item, text);
    } else if response.should_close() {
        state.overlay = Overlay::None;
    } else {
        state.overlay = Overlay::Rename(item, text);
    }
}

fn recover(ctx: &Context, state: &mut EditorState, path: &Path) {
    let response = Modal::new(Id::unique("recover")).show(ctx, |ui| {
        ui.set_width(380.0);
        ui.heading("The last session did not end on purpose");
        ui.label("Its people were kept. They come back as they were a minute before; save them under a name of yours.");
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            if ui.button("Recover").clicked() {
                state.overlay = Overlay::None;
                state.open_now(Source::File(path.to_path_buf(), ImportChoice::default()));
            }
            if ui.button("Not needed").clicked() {
                state.overlay = Overlay::None;
                crate::document::remove_leftover(path);
            }
        });
    });
    if response.should_close() {
        state.overlay = Overlay::None;
    }
}

fn unsaved(ctx: &Context, state: &mut EditorState, leaving: &Leaving) {
    let response = Modal::new(Id::unique("unsaved")).show(ctx, |ui| {
        ui.set_width(360.0);
        ui.heading("There are unsaved changes");
        ui.label("They are lost unless you save them first.");
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            if ui.button("Save first").clicked() {
                state.overlay = Overlay::None;
                actions::save(state);
            }
            if ui.button("Discard changes").clicked() {
                state.overlay = Overlay::None;
                match leaving.clone() {
                    Leaving::Quit => state.requests.close = true,
                    Leaving::Open(source) => state.open_now(source),
                }
            }
            if ui.button("Stay").clicked() {
                state.overlay = Overlay::None;
            }
        });
    });
    if response.should_close() {
        state.overlay = Overlay::None;
    }
}

fn import_report(ui: &mut Ui, state: &mut EditorState) {
    let Some(summary) = state.import.clone() else {
        ui.weak("Nothing was imported in this session.");
        return;
    };
    ui.heading(&summary.name);
    let size = summary.extent_m;
    Grid::new("import").num_columns(2).spacing([14.0, 5.0]).show(ui, |ui| {
        for (name, value) in [
            ("Objects", summary.objects.to_string()),
            ("Triangles", summary.triangles.to_string()),
            ("Size", format!("{:.2} x {:.2} m, {:.2} m high", size.x, size.z, size.y)),
        ] {
            ui.weak(name);
            ui.label(value);
            ui.end_row();
        }
    });
    if let Source::File(path, choice) = summary.source.clone() {
        ui.weak(path.display().to_string());
        import_choice(ui, state, &summary, path, choice);
    }
    if !summary.evidence.is_empty() {
        super::title(ui, "How it was understood");
    }
    for line in &summary.evidence {
        ui.label(line);
    }
    super::title(ui, "Remarks");
    if summary.notes.is_empty() {
        ui.weak("None: everything in the file was understood.");
    }
    for note in &summary.notes {
        ui.label(note);
    }
}

/// Unit and up axis; changing one reads the file again.
fn import_choice(
    ui: &mut Ui,
    state: &mut EditorState,
    summary: &ImportSummary,
    path: PathBuf,
    choice: ImportChoice,
) {
    let mut wanted = choice;
    ui.horizontal(|ui| {
        ui.weak("Unit");
        for (label, metres) in [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("inch", 0.0254), ("foot", 0.3048)] {
            let on = (summary.unit_m / metres - 1.0).abs() < 1e-3;
            if ui.selectable_label(on, label).clicked() {
                wanted.unit_m = Some(metres);
            }
        }
    });
    ui.horizontal(|ui| {
        ui.weak("Up");
        for up in UpAxis::ALL {
            if ui.selectable_label(summary.up == up, up.label()).clicked() {
                wanted.up = Some(up);
            }
        }
    });
    if wanted != choice {
        state.open(Source::File(path, wanted));
    }
}

fn history(ui: &mut Ui, state: &mut EditorState) {
    let past: Vec<String> = state.document.past_labels().map(str::to_owned).collect();
    let future: Vec<String> = state.document.future_labels().map(str::to_owned).collect();
    let mut travel = 0;
    if ui.selectable_label(past.is_empty(), "Beginning").clicked() {
        travel = -(past.len() as isize);
    }
    for (i, label) in past.iter().enumerate() {
        let now = i + 1 == past.len();
        ui.push_id(i, |ui| {
            if ui.selectable_label(now, label).clicked() {
                travel = i as isize + 1 - past.len() as isize;
            }
        });
    }
    for (i, label) in future.iter().enumerate() {
        ui.push_id(("future", i), |ui| {
            if ui.selectable_label(false, RichText::new(label).weak()).clicked() {
                travel = i as isize + 1;
            }
        });
    }
    actions::travel(state, travel);
}

fn notifications(ui: &mut Ui, state: &mut EditorState) {
    if state.notices.all().count() == 0 {
        ui.weak("Nothing was said yet.");
        return;
    }
    if ui.button("Clear").clicked() {
        state.notices.clear();
    }
    let palette = theme::palette(ui.visuals());
    for (number, notice) in state.notices.all().rev() {
        ui.push_id(number, |ui| {
            ui.separator();
            ui.label(RichText::new(&notice.text).color(level_color(notice.level, palette)));
            if !notice.details.is_empty() {
                ui.label(RichText::new(&notice.details).small());
                if ui.small_button("Copy details").clicked() {
                    ui.ctx().copy_text(notice.for_clipboard());
                }
            }
        });
    }
}
