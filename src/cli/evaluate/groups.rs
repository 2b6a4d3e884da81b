//! `inhabit evaluate groups`: what a group shares stands where all of it can reach it (ADSE §5.3), against the baseline
//! that deals shared things out to single people, from the same places and seeds (ADSE fig. 8).

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::bail;
use clap::Args;
use serde::Serialize;

use crate::cli::evolve::Shown;
use crate::cli::evolve::pictures::{Photographer, save, views_of};
use crate::cli::output::OutputFolder;
use crate::cli::progress::run_job;
use crate::cli::{Common, Ended, load, use_threads};
use crate::evolve::action::{
    ActionKind, ActionModel, Evolution, EvolutionConfig, GroupMode, Item, Library, Stage, embody, is_shared,
};
use crate::job::{JobCtx, Seed, Stop};
use crate::render::Picture;
use crate::render::plot::{Captioned, captioned_sheet};

/// Draws of one group that may fail before its seed is given up.
const DRAWS: u64 = 24;

/// Arguments of `evaluate groups`.
#[derive(Args, Debug)]
pub struct GroupsArguments {
    /// A room with a dining table: a file, a project or `sample:NAME`.
    #[arg(value_name = "ROOM")]
    pub room: PathBuf,
    /// How many people sit together.
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_values_t = [2, 3, 4])]
    pub sizes: Vec<usize>,
    /// Groups of each size, one for each seed from --seed on; the first that shares something is drawn.
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub groups: u64,
    /// Folder for the table and the pictures; must be new or empty.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// What was measured of groups of one size under one method.
#[derive(Clone, Debug, Default, Serialize)]
struct Row {
    people: usize,
    method: &'static str,
    /// Groups that found room.
    groups: usize,
    /// Things that all share, over all groups.
    things: usize,
    /// Share of them at places that eq. 6 calls shared.
    shared: f32,
    /// Mean distance of the person who is farthest from such a thing, metres.
    farthest_m: f32,
}

/// One group under both methods, from the same seed.
struct Pair {
    people: usize,
    shown: [Shown; 2],
}

/// All that the job computes.
struct Computed {
    rows: Vec<Row>,
    drawn: Vec<Pair>,
}

/// Runs the command.
///
/// # Errors
/// When the room can't be read, no group finds room in it, or the output can't be written.
pub fn run(arguments: &GroupsArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    if let Some(size) = arguments.sizes.iter().find(|size| !(2..=4).contains(*size)) {
        bail!("--sizes names {size}: two to four people sit at one table");
    }
    let loaded = load::load(Some(&arguments.room), &crate::scene::ImportOptions::default())?;
    let folder = OutputFolder::claim(&arguments.out, false)?;
    let (room, model) = (loaded.room, ActionModel::bundled()?);
    let (sizes, groups, seed) = (arguments.sizes.clone(), arguments.groups, arguments.common.seed);
    let work = move |cx: &JobCtx| {
        let stage = Arc::new(Stage::new(room, Library::bundled(), cx.ticker())?);
        compare(&stage, &model, &sizes, groups, seed, cx)
    };
    let root = Seed::root(seed);
    let Some(computed) = run_job("evaluate groups", root, arguments.common.quiet, work)? else {
        return Ok(Ended::Interrupted);
    };
    if computed.rows.iter().all(|row| row.groups == 0) {
        bail!("no group finds room in {}: name a room with a dining table", loaded.path);
    }
    let markdown = markdown(&computed.rows);
    folder.write("groups.md", markdown.as_bytes())?;
    folder.write("groups.json", serde_json::to_string_pretty(&computed.rows)?.as_bytes())?;
    draw(&folder, &computed.drawn)?;
    if !arguments.common.quiet {
        print!("{markdown}");
    }
    Ok(Ended::Clean)
}

fn compare(
    stage: &Arc<Stage>,
    model: &Arc<ActionModel>,
    sizes: &[usize],
    groups: u64,
    seed: u64,
    cx: &JobCtx,
) -> Result<Computed, Stop> {
    cx.stage("groups", sizes.len() * groups as usize)?;
    let mut computed = Computed { rows: Vec::new(), drawn: Vec::new() };
    for people in sizes {
        let mut rows = MODES.map(|mode| Row { people: *people, method: name_of(mode), ..Row::default() });
        let mut drawn: Option<[Evolution; 2]> = None;
        for number in 0..groups {
            cx.advance()?;
            let seed = Seed::root(seed + number);
            let [ours, baseline] = MODES.map(|mode| dinner(stage, model, *people, mode, seed));
            let (Some(ours), Some(baseline)) = (ours, baseline) else { continue };
            let both = [ours, baseline];
            rows.iter_mut().zip(&both).for_each(|(row, after)| add(row, after));
            // The first group that shares something shows what sharing is; else the first one.
            if drawn.as_ref().is_none_or(|[before, _]| shares(before) < shares(&both[0]).min(1)) {
                drawn = Some(both);
            }
        }
        if let Some([ours, baseline]) = drawn {
            let shown = [fitted(ours, cx)?, fitted(baseline, cx)?];
            computed.drawn.push(Pair { people: *people, shown });
        }
        computed.rows.extend(rows.map(Row::averaged));
    }
    Ok(computed)
}

/// Ours first.
const MODES: [GroupMode; 2] = [GroupMode::Shared, GroupMode::Baseline];

impl Row {
    /// Sums made means.
    fn averaged(self) -> Self {
        let count = self.things.max(1) as f32;
        Self { shared: self.shared / count, farthest_m: self.farthest_m / count, ..self }
    }
}

fn shares(evolution: &Evolution) -> usize {
    evolution.steps().last().map_or(0, |step| step.shared.len())
}

fn fitted(evolution: Evolution, cx: &JobCtx) -> Result<Shown, Stop> {
    let people = embody(&evolution, 0, cx.ticker())?;
    Ok(Shown { evolution, people })
}

fn name_of(mode: GroupMode) -> &'static str {
    match mode {
        GroupMode::Shared => "ours (ADSE §5.3)",
        GroupMode::Baseline => "baseline",
    }
}

/// A room after so many people have sat down to eat in it; `None` where that finds no room.
fn dinner(
    stage: &Arc<Stage>,
    model: &Arc<ActionModel>,
    people: usize,
    mode: GroupMode,
    seed: Seed,
) -> Option<Evolution> {
    let config = EvolutionConfig {
        only: vec![ActionKind::EatDinnerInGroup],
        group: mode,
        group_size: Some(people),
        ..EvolutionConfig::usual()
    };
    let before = Evolution::new(stage.clone(), model.clone(), config, seed);
    let apply = |roll: u64| before.apply(before.draw_next_after(roll)?, roll).ok();
    (0..DRAWS).filter_map(apply).find(|after| seated(after) == people)
}

fn seated(evolution: &Evolution) -> usize {
    evolution.steps().last().map_or(0, |step| step.people.len())
}

/// Measures what the group of the last step shares.
fn add(row: &mut Row, evolution: &Evolution) {
    let Some(step) = evolution.steps().last() else { return };
    let centres: Vec<_> = step.people.iter().map(|p| flat(p.frame.centre_m)).collect();
    let pairs = centres.iter().flat_map(|a| centres.iter().map(move |b| a.distance(*b)));
    let spread_m = pairs.fold(0.0, f32::max);
    for item in step.shared.iter().filter_map(|id| evolution.world().item(*id)) {
        let at = flat(item.bounds.center());
        let distances: Vec<f32> = centres.iter().map(|centre| centre.distance(at)).collect();
        row.things += 1;
        row.shared += f32::from(u8::from(is_shared(&distances, spread_m)));
        row.farthest_m += distances.iter().copied().fold(0.0, f32::max);
    }
    row.groups += 1;
}

fn flat(at: glam::Vec3) -> glam::Vec2 {
    glam::Vec2::new(at.x, at.z)
}

fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| people | method | groups | shared things | at a shared place (eq. 6) | farthest person, m |\n|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {:.0} % | {:.2} |",
            row.people,
            row.method,
            row.groups,
            row.things,
            100.0 * row.shared,
            row.farthest_m
        );
    }
    text
}

/// Ours and the baseline side by side from one camera, a row for each size.
fn draw(folder: &OutputFolder, drawn: &[Pair]) -> anyhow::Result<()> {
    let photographer = Photographer::new()?;
    let mut tiles = Vec::new();
    for pair in drawn {
        let cameras = views_of(&pair.shown[0], 1);
        for (shown, mode) in pair.shown.iter().zip(MODES) {
            let caption = format!("{} people, {}{}", pair.people, name_of(mode), told(&shown.evolution));
            let pictures = photographer.from(shown, &cameras)?;
            let tile = |picture: &Picture| Captioned { caption: caption.clone(), picture: picture.halved() };
            tiles.extend(pictures.iter().map(tile));
        }
    }
    if !tiles.is_empty() {
        save(folder, "groups", &captioned_sheet(&tiles, 2)?)?;
    }
    Ok(())
}

/// What is shared, and how far from it the person is who is farthest: ": pizza 0.78 m from the farthest".
fn told(evolution: &Evolution) -> String {
    let Some(step) = evolution.steps().last() else { return String::new() };
    let far = |item: &Arc<Item>| {
        let at = flat(item.bounds.center());
        let far_m = step.people.iter().map(|p| flat(p.frame.centre_m).distance(at)).fold(0.0, f32::max);
        format!("{} {far_m:.2} m", item.name.to_lowercase())
    };
    let items = step.shared.iter().filter_map(|id| evolution.world().item(*id));
    let told: Vec<String> = items.map(far).collect();
    if told.is_empty() { String::new() } else { format!(": {} from the farthest", told.join(", ")) }
}
