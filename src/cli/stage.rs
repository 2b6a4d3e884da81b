//! `inhabit stage`: a corpus of people in rooms, resumable room by room.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::Context as _;
use clap::Args;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::output::OutputFolder;
use super::progress::run_job;
use super::sheet::contact_sheet;
use super::{Common, Ended, use_threads};
use crate::assets::{self, Budget};
use crate::job::{JobCtx, Seed, Stop, Ticker};
use crate::learn::corpus::{LAYOUT, MANIFEST, Manifest, ROOM, RoomEntry, SAMPLES, Split};
use crate::learn::stage::{RoomPlan, StageConfig, make_room, manifest, plan_rooms, stage_room};
use crate::scene::{ImportOptions, PoseFamily, room_from_model};

/// File that says what a folder was begun with, so that `--resume` never mixes two corpora.
const SETTINGS: &str = "settings.ron";

/// Arguments of `stage`.
#[derive(Args, Debug)]
pub struct StageArguments {
    /// How many rooms are made by rule.
    #[arg(long, default_value_t = 200, value_name = "N")]
    pub rooms: usize,
    /// How many people in each room, at most: what is not plausible is left out.
    #[arg(long, default_value_t = 24, value_name = "N")]
    pub people: usize,
    /// How many virtual cameras look at each person, at most.
    #[arg(long, default_value_t = 4, value_name = "N")]
    pub views: usize,
    /// How many views from a walker's eye height show each person, at most.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub agent_views: usize,
    /// Leave the program's own sample rooms out.
    #[arg(long)]
    pub without_samples: bool,
    /// Folder of the corpus; must be new or empty.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Go on where an earlier run with the same settings stopped; more rooms may be asked for than then.
    #[arg(long)]
    pub resume: bool,
    /// Draw this many bodies from their views into `sheet.png`, to be looked at; 0 for none.
    #[arg(long, default_value_t = 24, value_name = "N")]
    pub sheet: usize,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// What must be the same when a run is resumed.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Settings {
    version: String,
    seed: u64,
    people: usize,
    views: usize,
    agent_views: usize,
}

/// Runs the command.
///
/// # Errors
/// When the folder can't be used or a room can't be made; the message says which.
pub fn run(arguments: &StageArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let config = StageConfig {
        rooms: arguments.rooms,
        people: arguments.people,
        views: arguments.views,
        agent_views: arguments.agent_views,
        sample_rooms: !arguments.without_samples,
        seed: arguments.common.seed,
        ..StageConfig::default()
    };
    let folder = OutputFolder::claim(&arguments.out, arguments.resume)?;
    check_settings(&folder, &config)?;
    let (root, plans) = (folder.root().to_owned(), plan_rooms(&config));
    let work = move |cx: &JobCtx| stage_all(&root, &plans, &config, cx.ticker());
    let quiet = arguments.common.quiet;
    let Some(entries) = run_job("stage", Seed::root(config.seed), quiet, work)? else {
        return Ok(Ended::Interrupted);
    };
    let manifest = manifest(&config, entries);
    let families = families(folder.root(), &manifest)?;
    folder.write("README.md", card(&manifest, &families).as_bytes())?;
    folder.write(MANIFEST, manifest.to_ron()?.as_bytes())?;
    if arguments.sheet > 0 {
        let picture = contact_sheet(folder.root(), &manifest, arguments.sheet)?;
        folder.write("sheet.png", &assets::encode_png(picture.width, picture.height, &picture.rgba)?)?;
    }
    tell(arguments, &manifest, &families)?;
    Ok(Ended::Clean)
}

fn check_settings(folder: &OutputFolder, config: &StageConfig) -> anyhow::Result<()> {
    let wanted = Settings {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed: config.seed,
        people: config.people,
        views: config.views,
        agent_views: config.agent_views,
    };
    let path = folder.root().join(SETTINGS);
    if !path.exists() {
        anyhow::ensure!(
            fs::read_dir(folder.root())?.next().is_none(),
            "{} holds no corpus that was begun here ({SETTINGS} is missing); name another folder with --out",
            folder.root().display()
        );
        folder.write(SETTINGS, ron::to_string(&wanted)?.as_bytes())?;
        return Ok(());
    }
    let text = fs::read_to_string(&path).with_context(|| format!("can't read {}", path.display()))?;
    let begun: Settings = ron::from_str(&text).with_context(|| path.display().to_string())?;
    anyhow::ensure!(
        begun == wanted,
        "{} was begun with {begun:?}, not with {wanted:?}: resume with those, or name another folder with --out",
        folder.root().display()
    );
    Ok(())
}

/// Stages every room that is not there yet, several at a time; gives the manifest's lines in order.
fn stage_all(
    root: &Path,
    plans: &[RoomPlan],
    config: &StageConfig,
    ticker: &Ticker,
) -> Result<Vec<RoomEntry>, Stop> {
    ticker.stage("staging rooms", plans.len())?;
    let (inner, done) = (ticker.without_progress(), AtomicUsize::new(0));
    let one = |plan: &RoomPlan| {
        ticker.check()?;
        let entry = match counted(root, plan) {
            Some(entry) => entry?,
            None => stage_one(root, plan, config, &inner).map_err(|stop| named(plan, stop))?,
        };
        ticker.step(done.fetch_add(1, Ordering::Relaxed) + 1, plans.len())?;
        Ok(entry)
    };
    plans.par_iter().with_max_len(1).map(one).collect()
}

fn named(plan: &RoomPlan, stop: Stop) -> Stop {
    match stop {
        Stop::Failed(message) => Stop::Failed(format!("{}: {message}", plan.name)),
        Stop::Cancelled => Stop::Cancelled,
    }
}

/// The line of a room that an earlier run finished.
fn counted(root: &Path, plan: &RoomPlan) -> Option<Result<RoomEntry, Stop>> {
    let file = root.join(&plan.name).join(SAMPLES);
    if !file.exists() {
        return None;
    }
    let npz = assets::npz::Npz::open(&file).map_err(Stop::from);
    Some(npz.and_then(|npz| {
        let people = npz.ints("people/family", &[None])?.0[0];
        let views = npz.ints("views/kind", &[None])?.0[0];
        Ok(plan.entry(people, views))
    }))
}

/// Makes, stages and writes one room: into a folder beside its own, which is renamed when all is in it.
fn stage_one(root: &Path, plan: &RoomPlan, config: &StageConfig, ticker: &Ticker) -> Result<RoomEntry, Stop> {
    let (layout, model) = make_room(&plan.source)?;
    let glb = assets::glb_from_model(&model)?;
    // Read back, so that everyone who reads the file sees the very same room.
    let model = assets::read_model_bytes(&plan.name, &glb, &Budget::default())?;
    let room = room_from_model(&model, &ImportOptions::default()).room;
    let staged = stage_room(plan, &room, config, ticker)?;
    let unfinished = root.join(format!("{}.unfinished", plan.name));
    if unfinished.exists() {
        fs::remove_dir_all(&unfinished)?;
    }
    fs::create_dir_all(&unfinished)?;
    if let Some(layout) = layout {
        let text = ron::ser::to_string_pretty(&layout, ron::ser::PrettyConfig::new().depth_limit(3))?;
        fs::write(unfinished.join(LAYOUT), text)?;
    }
    fs::write(unfinished.join(ROOM), &glb)?;
    fs::write(unfinished.join(SAMPLES), staged.to_npz()?)?;
    let target = root.join(&plan.name);
    if target.exists() {
        fs::remove_dir_all(&target)?;
    }
    fs::rename(&unfinished, &target)?;
    Ok(plan.entry(staged.people.len(), staged.views.len()))
}

/// How many people do what.
fn families(root: &Path, manifest: &Manifest) -> anyhow::Result<BTreeMap<&'static str, usize>> {
    let mut counts = BTreeMap::new();
    for entry in &manifest.rooms {
        let npz = assets::npz::Npz::open(&root.join(&entry.name).join(SAMPLES))?;
        for number in npz.ints("people/family", &[None])?.1 {
            let family = usize::try_from(number).ok().and_then(|n| PoseFamily::ALL.get(n));
            let family = family.with_context(|| format!("{}: no family has number {number}", entry.name))?;
            *counts.entry(family.label()).or_insert(0) += 1;
        }
    }
    Ok(counts)
}

/// What stands in the corpus's README.
fn card(manifest: &Manifest, families: &BTreeMap<&'static str, usize>) -> String {
    let of = |split: Split| {
        let rooms = manifest.rooms.iter().filter(|r| r.split == split);
        rooms.fold((0, 0, 0), |(n, p, v), r| (n + 1, p + r.people, v + r.views))
    };
    let row = |name: &str, split| {
        let (rooms, people, views) = of(split);
        format!("| {name} | {rooms} | {people} | {views} |\n")
    };
    let families: String = families.iter().map(|(name, n)| format!("| {name} | {n} |\n")).collect();
    format!(
        "# A corpus of people in rooms\n\n{}.\n\n\
         **These people are staged, not captured.** Poses come from inhabit's pose families, places from its affordance search;\n\
         each body was fitted alone into its room and kept only if it is held by something, free of penetration (2 cm at\n\
         most) and within joint limits. People of one room may overlap each other. Rooms are made by rule (`new:KIND:SEED`).\n\n\
         | split | rooms | people | views |\n|---|---|---|---|\n{}{}{}\n\
         | pose | people |\n|---|---|\n{families}\n\
         `{MANIFEST}` lists the rooms; each has a folder with `{ROOM}`, `{LAYOUT}` (rooms made by rule) and `{SAMPLES}`: people as\n\
         translation, rotation, shape, 21 axis-angles and hand codes; views as camera, depth in millimetres and labels, 128 x 128\n\
         (x right, y down, z forward). Array by array: `inhabit::learn::corpus`. `sheet.png` shows some of them.\n",
        manifest.about,
        row("train", Split::Train),
        row("validation", Split::Validation),
        row("test", Split::Test),
    )
}

/// The command's report as JSON.
#[derive(Serialize)]
struct Report<'a> {
    command: &'static str,
    version: &'static str,
    seed: u64,
    rooms: usize,
    people: usize,
    views: usize,
    families: &'a BTreeMap<&'static str, usize>,
}

fn tell(
    arguments: &StageArguments,
    manifest: &Manifest,
    families: &BTreeMap<&'static str, usize>,
) -> anyhow::Result<()> {
    let report = Report {
        command: "stage",
        version: env!("CARGO_PKG_VERSION"),
        seed: manifest.seed,
        rooms: manifest.rooms.len(),
        people: manifest.rooms.iter().map(|r| r.people).sum(),
        views: manifest.rooms.iter().map(|r| r.views).sum(),
        families,
    };
    if arguments.common.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else if !arguments.common.quiet {
        println!(
            "{} people in {} rooms, {} views: {}",
            report.people,
            report.rooms,
            report.views,
            arguments.out.display()
        );
    }
    Ok(())
}
