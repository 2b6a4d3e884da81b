//! What every command starts with: a room from a file or the bundled sample, and its geometry.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;

use crate::assets::{self, Budget};
use crate::document::load_project;
use crate::job::{Stop, Ticker};
use crate::scene::layout::{RoomType, new_room as new_room_model};
use crate::scene::{self, Clip, GeometryConfig, ImportOptions, ImportReport, Person, Room, RoomGeometry};

use super::report::{FieldRow, RoomRow};

/// A room as a command sees it.
pub struct Loaded {
    /// The room.
    pub room: Arc<Room>,
    /// Who was in it, when it came from a project.
    pub people: Vec<Person>,
    /// Who moved in it, when it came from a project.
    pub clips: Vec<Arc<Clip>>,
    /// What was understood; `None` for a room out of a project, which was understood when it was made.
    pub import: Option<ImportReport>,
    /// File or sample it came from.
    pub path: String,
}

/// Opens a room, a project, or with `None` the first bundled sample.
///
/// # Errors
/// When the file can't be read; the message names the file, the place and the remedy.
pub fn load(path: Option<&Path>, options: &ImportOptions) -> anyhow::Result<Loaded> {
    let Some(path) = path else {
        return sample(None, options);
    };
    if let Some(key) = sample_key(path) {
        return sample(Some(&key), options);
    }
    if let Some(wanted) = path.to_str().and_then(|p| p.strip_prefix("new:")) {
        return new_room(wanted, options);
    }
    let shown = path.display().to_string();
    if is_project(path) {
        let scene = load_project(path)?.project.scene;
        return Ok(Loaded {
            room: scene.room,
            people: scene.people,
            clips: scene.clips,
            import: None,
            path: shown,
        });
    }
    let model = assets::read_model(path, &Budget::default())?;
    let imported = scene::room_from_model(&model, options);
    Ok(Loaded {
        room: Arc::new(imported.room),
        people: Vec::new(),
        clips: Vec::new(),
        import: Some(imported.report),
        path: shown,
    })
}

/// `sample:living` names a bundled room.
fn sample_key(path: &Path) -> Option<String> {
    path.to_str()?.strip_prefix("sample:").map(str::to_owned)
}

/// `new:living:7` makes the living room of seed 7; without a number it is that of seed 0.
fn new_room(wanted: &str, options: &ImportOptions) -> anyhow::Result<Loaded> {
    let (key, seed) = wanted.split_once(':').unwrap_or((wanted, "0"));
    let keys = || RoomType::ALL.map(RoomType::key).join(", ");
    let kind = RoomType::from_key(key)
        .with_context(|| format!("there is no kind of room `new:{key}`: there are {}", keys()))?;
    let seed: u64 = seed
        .parse()
        .with_context(|| format!("`new:{wanted}`: write a whole number as seed, such as new:{key}:7"))?;
    let imported = scene::room_from_model(&new_room_model(kind, seed)?, options);
    let path = format!("new:{key}:{seed}");
    Ok(Loaded {
        room: Arc::new(imported.room),
        people: Vec::new(),
        clips: Vec::new(),
        import: Some(imported.report),
        path,
    })
}

fn sample(key: Option<&str>, options: &ImportOptions) -> anyhow::Result<Loaded> {
    let rooms = assets::sample_rooms();
    let found = key.map_or_else(|| rooms.first(), |key| rooms.iter().find(|r| r.key == key));
    let keys = || rooms.iter().map(|r| r.key).collect::<Vec<_>>().join(", ");
    let sample = found.with_context(|| {
        format!("there is no bundled room `sample:{}`: there are {}", key.unwrap_or(""), keys())
    })?;
    let model = assets::read_model_bytes(&format!("{}.glb", sample.key), sample.glb, &Budget::default())?;
    let imported = scene::room_from_model(&model, options);
    let path = format!("sample:{}", sample.key);
    Ok(Loaded {
        room: Arc::new(imported.room),
        people: Vec::new(),
        clips: Vec::new(),
        import: Some(imported.report),
        path,
    })
}

/// Whether `path` names a project by its ending.
pub fn is_project(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ron") || e.eq_ignore_ascii_case("inhabit"))
}

/// Builds the room's geometry under a job's progress.
///
/// # Errors
/// [`Stop::Cancelled`] when interrupted.
pub fn geometry(room: &Room, ticker: &Ticker) -> Result<RoomGeometry, Stop> {
    geometry_of(room, &GeometryConfig::default(), ticker)
}

/// Builds the room's geometry as `config` says, under a job's progress.
///
/// # Errors
/// [`Stop::Cancelled`] when interrupted.
pub fn geometry_of(room: &Room, config: &GeometryConfig, ticker: &Ticker) -> Result<RoomGeometry, Stop> {
    ticker.stage("understanding the room", 0)?;
    let step = |done: usize, total: usize| match ticker.step(done, total) {
        Ok(()) => std::ops::ControlFlow::Continue(()),
        Err(_) => std::ops::ControlFlow::Break(()),
    };
    RoomGeometry::build(room, config, &step).map_err(|_| Stop::Cancelled)
}

/// The room's row of a report.
pub fn room_row(loaded: &Loaded, geometry: &RoomGeometry, field_seconds: f64) -> RoomRow {
    let import = loaded.import.as_ref();
    RoomRow {
        path: loaded.path.clone(),
        triangles: loaded.room.triangle_count(),
        extent_m: loaded.room.bounds().size().to_array(),
        unit_scale: import.map_or(1.0, |r| r.unit_scale),
        up: import.map_or_else(|| "Y".to_owned(), |r| r.up.label().to_owned()),
        objects: loaded.room.objects.len(),
        field: FieldRow {
            dim: geometry.field.dim,
            cell_m: geometry.field.cell_m.max_element(),
            seconds: field_seconds,
        },
        notes: import.map_or_else(Vec::new, |r| r.notes.clone()),
    }
}

/// The folder a run without `--out` writes to, next to where the user is.
pub fn default_output() -> PathBuf {
    let free = |n: u32| {
        let name = if n == 0 { "inhabit-out".to_owned() } else { format!("inhabit-out-{n}") };
        Some(PathBuf::from(name)).filter(|p| !p.exists())
    };
    (0..).find_map(free).unwrap_or_else(|| PathBuf::from("inhabit-out"))
}
