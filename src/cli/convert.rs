//! `inhabit convert`: between any two formats that are read and written.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use clap::Args;

use super::import::ImportArguments;
use super::{Common, Ended, load, use_threads};
use crate::assets::{self, Budget};
use crate::document::{Project, save_project};
use crate::scene::layout::{Layout, compose};
use crate::scene::{Scene, model_from_room};

/// Arguments of `convert`.
#[derive(Args, Debug)]
pub struct ConvertArguments {
    /// A room (GLB, glTF, OBJ, PLY), a project, a `.layout.ron` or `sample:living` and the like.
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// `.glb` for the room, `.ron` or `.inhabit` for a project.
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
    /// Folder of the models that a layout names; its own when left out.
    #[arg(long, value_name = "DIR")]
    pub furniture: Option<PathBuf>,
    /// How the room's file is to be read.
    #[command(flatten)]
    pub import: ImportArguments,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// Runs the command.
///
/// # Errors
/// When the input can't be read, the output can't be written, or there is no such format.
pub fn run(arguments: &ConvertArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let (input, output) = (&arguments.input, &arguments.output);
    if input.to_string_lossy().ends_with(".layout.ron") {
        let glb = compose_layout(input, arguments.furniture.as_deref())?;
        anyhow::ensure!(ending(output) == "glb", "a layout becomes a .glb, not {}", output.display());
        write(output, &glb)?;
    } else {
        let loaded = load::load(Some(input), &arguments.import.options()?)?;
        let scene = Scene { room: loaded.room, people: loaded.people, clips: Vec::new() };
        match ending(output).as_str() {
            "glb" => write(output, &assets::glb_from_model(&model_from_room(&scene.room))?)?,
            "ron" | "inhabit" => save_project(output, &Project::of_scene(scene))?,
            other => bail!("{}: `{other}` is not written; choose .glb, .ron or .inhabit", output.display()),
        }
    }
    if !arguments.common.quiet {
        println!("{}", output.display());
    }
    Ok(Ended::Clean)
}

fn compose_layout(input: &Path, furniture: Option<&Path>) -> anyhow::Result<Vec<u8>> {
    let text = fs::read_to_string(input).with_context(|| format!("can't read {}", input.display()))?;
    let layout = Layout::read(&text).with_context(|| input.display().to_string())?;
    let folder = furniture.or_else(|| input.parent()).unwrap_or_else(|| Path::new("."));
    let budget = Budget::default();
    let load = |file: &str| assets::read_model(&folder.join(file), &budget).map_err(|e| e.to_string());
    let model = compose(&layout, &load).with_context(|| input.display().to_string())?;
    Ok(assets::glb_from_model(&model)?)
}

fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    fs::write(path, bytes).with_context(|| format!("can't write {}", path.display()))
}
