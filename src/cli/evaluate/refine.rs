//! `inhabit evaluate refine`: how plausible bodies get that were put somewhere badly.

use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueEnum};
use rayon::prelude::*;

use crate::body::Body;
use crate::cli::load;
use crate::cli::output::OutputFolder;
use crate::cli::pictures::Photographer;
use crate::cli::progress::run_job;
use crate::cli::{Common, Ended, use_threads};
use crate::evolve::{PopulateRequest, PopulatedPerson, RefineRequest, Refined, populate, refine};
use crate::fit::FitPreset;
use crate::inspect::{BodyMetrics, inspect_body};
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::{Disturbance, PlausibilityRow, random_placements};
use crate::scene::{BodyParams, Person, PersonId, Room, RoomGeometry, Scene};

/// Most people that the search is asked for in one room before they are disturbed.
const MOST_DISTURBED: usize = 16;

/// Arguments of `evaluate refine`.
#[derive(Args, Debug)]
pub struct RefineArguments {
    /// Rooms: files, projects or `sample:NAME`.
    #[arg(value_name = "ROOM", required = true)]
    pub rooms: Vec<PathBuf>,
    /// How many people are placed at random in each room; up to 16 of the search's are disturbed besides.
    #[arg(long, default_value_t = 50, value_name = "N")]
    pub people: usize,
    /// How bodies are fitted.
    #[arg(long, value_enum, default_value_t = Fit::Rescue)]
    pub fit: Fit,
    /// Folder for `refine.json` and `refine.md`; nothing is written when left out.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Draw this many refined people of each room, from two sides and by penetration, into `--out`.
    #[arg(long, default_value_t = 0, value_name = "N", requires = "out")]
    pub pictures: usize,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// Fits as the command line names them.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// Ours: what the body does is guessed, starts are searched, the best fit is taken.
    Rescue,
    /// PSI eq. 8 as `fitting_proxe` ships it.
    PsiProxe,
    /// PSI eq. 8 as `fitting_habitat` ships it.
    PsiMatterport,
    /// PSI eq. 8 as the demonstration notebook has it.
    PsiNotebook,
}

impl Fit {
    /// The preset of this name.
    pub fn preset(self) -> FitPreset {
        match self {
            Self::Rescue => FitPreset::Rescue,
            Self::PsiProxe => FitPreset::PsiProxe,
            Self::PsiMatterport => FitPreset::PsiMatterport,
            Self::PsiNotebook => FitPreset::PsiNotebook,
        }
    }
}

/// One body beyond rescue, for the report.
#[derive(serde::Serialize)]
struct Lost {
    room: String,
    samples: String,
    body: usize,
    family: &'static str,
    on: String,
    moved_m: f32,
    findings: Vec<crate::inspect::Finding>,
}

#[derive(serde::Serialize, Default)]
struct Report {
    rows: Vec<PlausibilityRow>,
    beyond_rescue: Vec<Lost>,
}

/// One room's share of the report, and what its pictures need.
struct OfRoom {
    report: Report,
    geometry: RoomGeometry,
    refined: Vec<Refined>,
}

/// Runs the command.
///
/// # Errors
/// When a room can't be read or the output can't be written.
pub fn run(arguments: &RefineArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let folder = arguments.out.as_ref().map(|root| OutputFolder::claim(root, false)).transpose()?;
    let mut report = Report::default();
    let mut first_picture = 0;
    for path in &arguments.rooms {
        let loaded = load::load(Some(path), &crate::scene::ImportOptions::default())?;
        let (room, people, preset) = (loaded.room.clone(), arguments.people, arguments.fit.preset());
        let name = path.file_stem().map_or_else(|| loaded.path.clone(), |n| n.to_string_lossy().into_owned());
        let work = move |cx: &JobCtx| one_room(&room, &name, people, preset, cx);
        let seed = Seed::root(arguments.common.seed);
        let Some(mut of_room) = run_job("evaluate refine", seed, arguments.common.quiet, work)? else {
            return Ok(Ended::Interrupted);
        };
        report.rows.append(&mut of_room.report.rows);
        report.beyond_rescue.append(&mut of_room.report.beyond_rescue);
        if let Some(folder) = &folder {
            for index in 0..arguments.pictures.min(of_room.refined.len()) {
                draw(folder, &loaded.room, &of_room, index, first_picture + index)?;
            }
        }
        first_picture += arguments.pictures;
    }
    let (json, table) = (serde_json::to_string_pretty(&report)?, markdown(&report.rows));
    if let Some(folder) = folder {
        folder.write("refine.json", json.as_bytes())?;
        folder.write("refine.md", table.as_bytes())?;
    }
    println!("{}", if arguments.common.json { json } else { table });
    Ok(if report.beyond_rescue.is_empty() { Ended::Clean } else { Ended::WithFindings })
}

fn one_room(
    room: &Arc<Room>,
    name: &str,
    people: usize,
    preset: FitPreset,
    cx: &JobCtx,
) -> Result<OfRoom, Stop> {
    let geometry = load::geometry(room, cx.ticker())?;
    let request = PopulateRequest { people: people.min(MOST_DISTURBED), ..PopulateRequest::default() };
    let found = populate(room, &geometry, &request, &JobCtx::watched(cx.seed, cx.ticker().clone()))?;
    let bodies: Vec<BodyParams> = found.people.into_iter().map(|p| p.person.body).collect();
    let mut report = Report::default();
    let mut all = Vec::new();
    for (kind, samples) in [
        ("disturbed", Disturbance::default().apply(&bodies, cx.seed)),
        ("random", random_placements(&geometry, people, cx.seed)),
    ] {
        let title = format!("{name}, {kind}");
        let before = measured(&geometry, &samples, cx)?;
        report.rows.push(PlausibilityRow::of_metrics(&format!("{title}, before"), before.iter()));
        let request = RefineRequest::of_preset(preset);
        let cx = JobCtx::watched(cx.seed, cx.ticker().clone());
        let refined = refine(room, &geometry, &samples, &request, &cx)?;
        report.rows.push(PlausibilityRow::of_refined(&format!("{title}, after"), &refined));
        report.beyond_rescue.extend(lost(name, kind, &refined));
        all.extend(refined);
    }
    Ok(OfRoom { report, geometry, refined: all })
}

/// One refined person alone in the room.
fn draw(
    folder: &OutputFolder,
    room: &Arc<Room>,
    of_room: &OfRoom,
    index: usize,
    number: usize,
) -> anyhow::Result<()> {
    let refined = &of_room.refined[index];
    let person = Person {
        id: PersonId(number as u32),
        name: format!("Person {}", number + 1),
        body: refined.params.clone(),
        family: refined.family,
        on: refined.on.clone(),
        seed: 0,
        palette: number as u32,
        visible: true,
        locked: false,
    };
    let scene = Scene { room: room.clone(), people: vec![person.clone()], clips: Vec::new() };
    let shown = PopulatedPerson {
        person,
        proposed: refined.before.clone(),
        report: refined.report.clone(),
        findings: refined.findings.clone(),
        trace: refined.trace.clone(),
        seconds: refined.seconds,
    };
    Photographer::new(folder, &scene)?.person(&shown, &of_room.geometry, 2)
}

fn measured(geometry: &RoomGeometry, samples: &[BodyParams], cx: &JobCtx) -> Result<Vec<BodyMetrics>, Stop> {
    cx.stage("measuring people", samples.len())?;
    let one = |sample: &BodyParams| {
        cx.advance()?;
        Ok(inspect_body(geometry, Body::bundled(), sample).metrics)
    };
    samples.par_iter().map(one).collect()
}

fn lost(room: &str, samples: &str, refined: &[Refined]) -> Vec<Lost> {
    let of = |(body, r): (usize, &Refined)| Lost {
        room: room.to_owned(),
        samples: samples.to_owned(),
        body,
        family: r.family.label(),
        on: r.on.clone(),
        moved_m: r.moved_m,
        findings: r.findings.clone(),
    };
    refined.iter().enumerate().filter(|(_, r)| !r.findings.is_empty()).map(of).collect()
}

fn markdown(rows: &[PlausibilityRow]) -> String {
    let mut table = String::from(
        "| bodies | n | non-collision | contact (PSI) | contact 2 cm | supported | deepest, mm | no finding | moved, m | s a body |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        table += &format!(
            "| {} | {} | {:.4} | {:.3} | {:.3} | {:.3} | {:.1} | {:.3} | {:.2} | {:.2} |\n",
            r.name,
            r.bodies,
            r.psi_non_collision,
            r.psi_contact,
            r.contact_2cm,
            r.supported,
            r.penetration_mm,
            r.clean,
            r.moved_m,
            r.seconds
        );
    }
    table
}
