//! `inhabit evolve`: actions happen in a room, step by step, without a window.

mod day;
pub(super) mod pictures;
mod report;
mod views;

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context as _, bail};
use clap::Args;

use super::load::{self, Loaded};
use super::output::OutputFolder;
use super::progress::run_job;
use super::{Common, Ended, use_threads};
use crate::assets::glb_from_model;
use crate::body::Body;
use crate::document::{Project, save_project};
use crate::evolve::action::{
    ActionKind, ActionModel, Embodied, Evolution, EvolutionConfig, GroupMode, Library, RoomMeasures, Stage,
    embody, measure, scene_state,
};
use crate::job::{JobCtx, Seed};
use crate::render::{BodySurface, person_glb};
use crate::scene::{ObjectId, Person, Scene, model_from_room};
use report::{EvolveReport, Parts};

/// Steps that pictures are taken after; the last one too.
const PICTURED: [usize; 4] = [1, 4, 10, 30];
/// Draws in a row that turn out impossible before the run ends early.
const MOST_REFUSALS: u64 = 40;

/// Arguments of `evolve`.
#[derive(Args, Debug)]
pub struct EvolveArguments {
    /// A room (GLB, glTF, OBJ, PLY), a project, or `sample:living`, `sample:bedroom`, `sample:office`.
    #[arg(value_name = "ROOM")]
    pub room: Option<PathBuf>,
    /// How many actions.
    #[arg(long, default_value_t = 10, value_name = "N")]
    pub actions: usize,
    /// What people do: the output of `inhabit learn actions`, instead of what comes with the program.
    #[arg(long, value_name = "FILE")]
    pub actions_model: Option<PathBuf>,
    /// Only these types of action, such as "use laptop,read book".
    #[arg(long, value_name = "TYPE,…", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Kinds of things that never come and are never used, such as "cup,bottle".
    #[arg(long, value_name = "KIND,…", value_delimiter = ',')]
    pub ban: Vec<String>,
    /// Objects of the room, by name, that must stay where they are.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub lock: Vec<String>,
    /// One person goes from action to action on one timeline: `day.glb` (they and the things move), picture strips and
    /// `evolution.json` with the times. What people do in groups is left out.
    #[arg(long)]
    pub day: bool,
    /// So many people in a group; as learned when left out.
    #[arg(long, value_name = "N")]
    pub group: Option<usize>,
    /// What a group shares is dealt out to single people, as in the baseline that the method is compared with.
    #[arg(long)]
    pub group_baseline: bool,
    /// Only things that the photos have words for: no plates, paper or cushions.
    #[arg(long)]
    pub strict: bool,
    /// Folder for everything that is written; must be new or empty.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write over an earlier run in the same folder.
    #[arg(long)]
    pub resume: bool,
    /// No pictures.
    #[arg(long)]
    pub no_pictures: bool,
    /// No bodies: the steps tell where people are, but none is fitted.
    #[arg(long)]
    pub no_people: bool,
    /// How the room's file is to be read.
    #[command(flatten)]
    pub import: super::import::ImportArguments,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// A pictured state: after so many actions, with its people.
pub struct Shown {
    /// The state.
    pub evolution: Evolution,
    /// Its people, fitted.
    pub people: Vec<Embodied>,
}

/// All that the job computes.
struct Computed {
    states: Vec<(Evolution, RoomMeasures)>,
    shown: Vec<Shown>,
    refused: Vec<String>,
    stage_seconds: f64,
    fit_seconds: f64,
}

/// Runs the command.
///
/// # Errors
/// When the room or the action model can't be read, no action is possible, or the output can't be written.
pub fn run(arguments: &EvolveArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let started = Instant::now();
    let loaded = load::load(arguments.room.as_deref(), &arguments.import.options()?)?;
    let model = action_model(arguments)?;
    let config = config(arguments)?;
    let root = arguments.out.clone().unwrap_or_else(load::default_output);
    let folder = OutputFolder::claim(&root, arguments.resume)?;
    let locked = locked(arguments, &loaded)?;
    if arguments.day {
        return day::run(arguments, loaded.room.clone(), model, config, &locked, &folder);
    }
    let Some(computed) = compute(arguments, &loaded, &model, config, locked)? else {
        return Ok(Ended::Interrupted);
    };
    let Some((last, _)) = computed.states.last() else {
        bail!("no state was made: this is a bug, please report it")
    };
    if last.steps().is_empty() && arguments.actions > 0 {
        let reasons: Vec<String> = last.off().iter().map(|o| format!("{}: {}", o.action, o.why)).collect();
        let first = computed.refused.iter().chain(&reasons).take(4).cloned().collect::<Vec<_>>().join("; ");
        bail!(
            "nothing can be done in {}: {first}. Name a room with a desk, table, bed or couch",
            loaded.path
        );
    }
    write(&folder, &computed)?;
    let pictures_by = match arguments.no_pictures {
        true => "nobody: --no-pictures".to_owned(),
        false => pictures::take(&folder, &computed.shown)?,
    };
    let parts = Parts {
        seed: arguments.common.seed,
        loaded: &loaded,
        states: &computed.states,
        shown: &computed.shown,
        refused: &computed.refused,
        requested: arguments.actions,
        stage_seconds: computed.stage_seconds,
        fit_seconds: computed.fit_seconds,
        total_seconds: started.elapsed().as_secs_f64(),
        pictures_by,
    };
    let report = EvolveReport::new(&parts);
    let json = serde_json::to_string_pretty(&report)?;
    folder.write("report.json", json.as_bytes())?;
    tell(arguments, &report, &folder, &json);
    Ok(if report.is_clean() { Ended::Clean } else { Ended::WithFindings })
}

fn action_model(arguments: &EvolveArguments) -> anyhow::Result<Arc<ActionModel>> {
    let Some(path) = &arguments.actions_model else {
        return Ok(ActionModel::bundled()?);
    };
    let text = fs::read_to_string(path).with_context(|| {
        format!("can't read the action model {}: name the output of `inhabit learn actions`", path.display())
    })?;
    Ok(Arc::new(ActionModel::from_ron(&text).with_context(|| path.display().to_string())?))
}

fn config(arguments: &EvolveArguments) -> anyhow::Result<EvolutionConfig> {
    let kind = |label: &String| {
        let labels = || ActionKind::ALL.map(ActionKind::label).join(", ");
        ActionKind::from_label(label.trim())
            .with_context(|| format!("there is no type of action `{label}`: there are {}", labels()))
    };
    let library = Library::bundled();
    for banned in &arguments.ban {
        if library.named(banned.trim()).is_none() {
            let kinds: Vec<&str> = library.kinds().map(|(_, k)| k.kind.as_str()).collect();
            bail!("there is no kind of thing `{banned}`: there are {}", kinds.join(", "));
        }
    }
    Ok(EvolutionConfig {
        only: arguments.only.iter().map(kind).collect::<anyhow::Result<_>>()?,
        banned: arguments.ban.iter().map(|b| b.trim().to_owned()).collect(),
        companions: !arguments.strict,
        group: if arguments.group_baseline { GroupMode::Baseline } else { GroupMode::Shared },
        group_size: arguments.group,
        library: None,
    })
}

/// The objects that `--lock` names.
fn locked(arguments: &EvolveArguments, loaded: &Loaded) -> anyhow::Result<Vec<ObjectId>> {
    let mut locked = Vec::new();
    for name in &arguments.lock {
        let known = locked.len();
        locked.extend(loaded.room.objects.iter().filter(|o| o.name == name.trim()).map(|o| o.id));
        if locked.len() == known {
            bail!("--lock names `{name}`, which {} does not have; `inhabit inspect` lists them", loaded.path);
        }
    }
    Ok(locked)
}

fn compute(
    arguments: &EvolveArguments,
    loaded: &Loaded,
    model: &Arc<ActionModel>,
    config: EvolutionConfig,
    locked: Vec<ObjectId>,
) -> anyhow::Result<Option<Computed>> {
    let (room, model) = (loaded.room.clone(), model.clone());
    let (wanted, with_people) = (arguments.actions, !arguments.no_people);
    let work = move |cx: &JobCtx| {
        let started = Instant::now();
        let stage = Arc::new(Stage::new(room, Library::bundled(), cx.ticker())?);
        let stage_seconds = started.elapsed().as_secs_f64();
        let mut evolution = Evolution::new(stage, model, config, cx.seed);
        locked.iter().for_each(|id| evolution.lock(*id, true));
        let mut computed = Computed {
            states: vec![(evolution.clone(), measure(&evolution))],
            shown: Vec::new(),
            refused: Vec::new(),
            stage_seconds,
            fit_seconds: 0.0,
        };
        act(&mut computed, wanted, with_people, cx)?;
        Ok(computed)
    };
    run_job("evolve", Seed::root(arguments.common.seed), arguments.common.quiet, work)
}

/// Lets the chain run, measures every state, and fits people where pictures are taken.
fn act(
    computed: &mut Computed,
    wanted: usize,
    with_people: bool,
    cx: &JobCtx,
) -> Result<(), crate::job::Stop> {
    cx.stage("acting", wanted)?;
    let mut refusals = 0;
    while let Some((evolution, _)) = computed.states.last().cloned() {
        let done = evolution.steps().len();
        if done == wanted || refusals == MOST_REFUSALS {
            break;
        }
        let Some(node) = evolution.draw_next_after(refusals) else { break };
        match evolution.apply(node, refusals) {
            Ok(next) => {
                refusals = 0;
                if PICTURED.contains(&(done + 1)) || done + 1 == wanted {
                    let started = Instant::now();
                    let people = if with_people { embody(&next, 0, cx.ticker())? } else { Vec::new() };
                    computed.fit_seconds += started.elapsed().as_secs_f64();
                    computed.shown.push(Shown { evolution: next.clone(), people });
                }
                computed.states.push((next.clone(), measure(&next)));
            }
            Err(refused) => {
                refusals += 1;
                computed.refused.push(refused.to_string());
            }
        }
        cx.step(done, wanted)?;
    }
    Ok(())
}

/// Writes the room after every step, the people of the pictured ones, and the last state as a project.
fn write(folder: &OutputFolder, computed: &Computed) -> anyhow::Result<()> {
    for (evolution, _) in &computed.states {
        let number = evolution.steps().len();
        let name = format!("{number:03}");
        folder.write(&format!("steps/{name}.glb"), &glb_from_model(&model_from_room(&evolution.room()))?)?;
    }
    let surface = BodySurface::of(Body::bundled());
    for shown in &computed.shown {
        let number = shown.evolution.steps().len();
        for (i, person) in shown.people.iter().enumerate() {
            folder.write(&format!("people/{number:03}_{i}.glb"), &person_glb(&person.person, &surface)?)?;
        }
        let state = scene_state(&shown.evolution, &format!("step {number}"));
        folder.write(
            &format!("scene_state/{number:03}.json"),
            serde_json::to_string_pretty(&state)?.as_bytes(),
        )?;
    }
    if let Some((evolution, _)) = computed.states.last() {
        let of_last = |s: &&Shown| s.evolution.steps().len() == evolution.steps().len();
        let people = computed.shown.iter().find(of_last).map_or_else(Vec::new, people_of);
        let scene = Scene { room: Arc::new(evolution.room()), people, clips: Vec::new() };
        save_project(&folder.root().join("project.ron"), &Project::of_scene(scene))?;
    }
    Ok(())
}

fn people_of(shown: &Shown) -> Vec<Person> {
    shown.people.iter().map(|p| p.person.clone()).collect()
}

fn tell(arguments: &EvolveArguments, report: &EvolveReport, folder: &OutputFolder, json: &str) {
    if arguments.common.json {
        println!("{json}");
    } else if !arguments.common.quiet {
        let s = &report.summary;
        println!(
            "{} actions, {} things ({} brought); interpenetrations {} (worst {:.1} mm), unsupported {}, out of bounds \
             {}; {:.0} ms an action",
            report.steps.len(),
            s.objects,
            s.brought,
            s.interpenetrations,
            s.worst_interpenetration_mm,
            s.unsupported,
            s.out_of_bounds,
            s.milliseconds_per_action
        );
        println!(
            "Written to {}: steps/, people/, pictures/, scene_state/, project.ron, report.json",
            folder.root().display()
        );
    }
    if report.steps.len() < report.actions_requested {
        eprintln!(
            "inhabit: {} of {} actions: {}",
            report.steps.len(),
            report.actions_requested,
            report.refused.last().map_or("nothing more can be done here", String::as_str)
        );
    }
}
