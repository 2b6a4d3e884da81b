//! The desktop's file dialogs. Each waits on a thread of its own; a desktop without them is no fault.

use std::path::PathBuf;

use crate::job::{Job, Seed, Stop};

/// Endings of the files that can be opened.
const READABLE: [&str; 6] = ["glb", "gltf", "obj", "ply", "ron", "inhabit"];

/// Asks for a file to open. `None` when the user changed their mind; failed where there is no dialog.
pub fn ask_open(ctx: &egui::Context) -> Job<Option<PathBuf>> {
    ask(ctx, "Open dialog", || {
        rfd::FileDialog::new()
            .set_title("Open a room or project")
            .add_filter("Rooms and projects", &READABLE)
            .pick_file()
    })
}

/// Asks for a file to save to.
pub fn ask_save(ctx: &egui::Context) -> Job<Option<PathBuf>> {
    ask(ctx, "Save dialog", || {
        rfd::FileDialog::new()
            .set_title("Save the project")
            .add_filter("Inhabit project", &["inhabit"])
            .set_file_name("room.inhabit")
            .save_file()
    })
}

/// Asks for a photo, or for its keypoints.
pub fn ask_photo(ctx: &egui::Context, keypoints: bool) -> Job<Option<PathBuf>> {
    ask(ctx, "Photo dialog", move || {
        let dialog = rfd::FileDialog::new();
        if keypoints {
            dialog.set_title("Choose the keypoints").add_filter("COCO or OpenPose", &["json"]).pick_file()
        } else {
            dialog.set_title("Choose a photo").add_filter("Pictures", &["png", "jpg", "jpeg"]).pick_file()
        }
    })
}

/// Asks for a model that is to be a thing.
pub fn ask_thing(ctx: &egui::Context) -> Job<Option<PathBuf>> {
    ask(ctx, "Open dialog", || {
        rfd::FileDialog::new()
            .set_title("Choose a thing of yours")
            .add_filter("Models", &super::panels::THING_FILES)
            .pick_file()
    })
}

/// Asks for a folder of motion clips.
pub fn ask_clips(ctx: &egui::Context) -> Job<Option<PathBuf>> {
    ask(ctx, "Folder dialog", || {
        rfd::FileDialog::new().set_title("Choose a folder of motion clips").pick_folder()
    })
}

/// Asks for a folder to export to.
pub fn ask_folder(ctx: &egui::Context) -> Job<Option<PathBuf>> {
    ask(ctx, "Export dialog", || {
        rfd::FileDialog::new().set_title("Export room and people into a folder").pick_folder()
    })
}

fn ask(
    ctx: &egui::Context,
    name: &str,
    dialog: impl FnOnce() -> Option<PathBuf> + Send + 'static,
) -> Job<Option<PathBuf>> {
    let ctx = ctx.clone();
    Job::spawn(
        name,
        Seed::root(0),
        move || ctx.request_repaint(),
        move |_| {
            if cfg!(target_os = "linux") && std::env::var_os("DBUS_SESSION_BUS_ADDRESS").is_none() {
                return Err(Stop::Failed("this desktop has no file dialog".to_owned()));
            }
            Ok(dialog())
        },
    )
}
