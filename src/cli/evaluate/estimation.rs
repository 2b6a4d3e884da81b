//! `inhabit evaluate estimation`: PSI table 5 on bodies whose truth is known.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use crate::cli::load;
use crate::cli::output::OutputFolder;
use crate::cli::progress::run_job;
use crate::cli::{Common, Ended, use_threads};
use crate::evolve::{PopulateRequest, populate};
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::estimation::{
    CaseResult, ObserveConfig, Summary, cases_of_room, scene_code_by_search, study_room, summarise,
};
use crate::scene::{BodyParams, PoseFamily, Room};

/// People in each room.
const PEOPLE: usize = 10;

/// Arguments of `evaluate estimation`.
#[derive(Args, Debug)]
pub struct EstimationArguments {
    /// Rooms: files, projects or `sample:NAME`; people are put into them by search and fit.
    #[arg(value_name = "ROOM", required = true)]
    pub rooms: Vec<PathBuf>,
    /// Views over all rooms.
    #[arg(long, default_value_t = 200, value_name = "N")]
    pub views: usize,
    /// Noise of well-seen keypoints in pixels of a picture 1920 wide.
    #[arg(long, default_value_t = 8.0, value_name = "PX")]
    pub noise_px: f32,
    /// Folder for `estimation.md`, `.csv` and `.json`; must be new or empty.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// What is written as JSON.
#[derive(serde::Serialize)]
struct Report<'a> {
    command: &'static str,
    version: &'static str,
    seed: u64,
    scene_prior: &'static str,
    keypoints: ObserveConfig,
    summary: &'a Summary,
    cases: &'a [CaseResult],
}

/// Runs the command.
///
/// # Errors
/// When a room can't be read or the output can't be written.
pub fn run(arguments: &EstimationArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let folder = OutputFolder::claim(&arguments.out, false)?;
    let observe = ObserveConfig { noise_px: arguments.noise_px.max(0.0), ..ObserveConfig::default() };
    let seed = Seed::root(arguments.common.seed);
    let views_a_room = arguments.views.div_ceil(arguments.rooms.len().max(1));
    let mut results: Vec<CaseResult> = Vec::new();
    for (index, path) in arguments.rooms.iter().enumerate() {
        let loaded = load::load(Some(path), &crate::scene::ImportOptions::default())?;
        let name = path.file_stem().map_or_else(|| loaded.path.clone(), |n| n.to_string_lossy().into_owned());
        let (room, first) = (loaded.room.clone(), (index * views_a_room) as u64);
        let work = move |cx: &JobCtx| of_room(&room, &name, views_a_room, first, observe, cx);
        let seed = seed.child("room", index as u64);
        let Some(of_room) = run_job("evaluate estimation", seed, arguments.common.quiet, work)? else {
            return Ok(Ended::Interrupted);
        };
        results.extend(of_room);
    }
    anyhow::ensure!(
        !results.is_empty(),
        "no body is seen by any camera in these rooms: name rooms that people fit into"
    );
    let summary = summarise(&results, seed);
    write(&folder, arguments, observe, &summary, &results)?;
    Ok(Ended::Clean)
}

fn of_room(
    room: &Arc<Room>,
    name: &str,
    views: usize,
    first: u64,
    observe: ObserveConfig,
    cx: &JobCtx,
) -> Result<Vec<CaseResult>, Stop> {
    let geometry = load::geometry(room, cx.ticker())?;
    let request = PopulateRequest { people: PEOPLE, ..PopulateRequest::default() };
    let found = populate(room, &geometry, &request, &JobCtx::watched(cx.seed, cx.ticker().clone()))?;
    let people: Vec<(BodyParams, PoseFamily)> =
        found.people.into_iter().map(|p| (p.person.body, p.person.family)).collect();
    let each = views.div_ceil(people.len().max(1));
    let mut cases = cases_of_room(name, &geometry, &people, each, first, cx.seed);
    cases.truncate(views);
    // Other people than those who are estimated: another branch of the seeds.
    let code = scene_code_by_search(room, &geometry, cx.seed.child("scene prior", 0), cx.ticker())?;
    cases.iter_mut().for_each(|case| case.scene_code = code);
    cx.stage("estimating people", cases.len())?;
    Ok(study_room(&geometry, &cases, &observe, cx.seed, cx.ticker())?)
}

fn write(
    folder: &OutputFolder,
    arguments: &EstimationArguments,
    observe: ObserveConfig,
    summary: &Summary,
    results: &[CaseResult],
) -> anyhow::Result<()> {
    let report = Report {
        command: "evaluate estimation",
        version: env!("CARGO_PKG_VERSION"),
        seed: arguments.common.seed,
        scene_prior: "search",
        keypoints: observe,
        summary,
        cases: results,
    };
    let (json, table) = (serde_json::to_string_pretty(&report)?, markdown(summary));
    folder.write("estimation.json", json.as_bytes())?;
    folder.write("estimation.md", table.as_bytes())?;
    folder.write("estimation.csv", csv(results).as_bytes())?;
    println!("{}", if arguments.common.json { json } else { table });
    Ok(())
}

fn markdown(summary: &Summary) -> String {
    let mut text = format!(
        "{} views in {} rooms; millimetres, means over views.\n\n| method | PJE | V2V | p.PJE | p.V2V | keypoints, px |\n\
         |---|---|---|---|---|---|\n",
        summary.cases, summary.rooms
    );
    for row in &summary.methods {
        let e = &row.errors;
        text += &format!(
            "| {} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} |\n",
            row.method, e.pje_mm, e.v2v_mm, e.aligned_pje_mm, e.aligned_v2v_mm, row.reprojection_px
        );
    }
    text += "\n| difference | mean, mm | 95 % interval | better in |\n|---|---|---|---|\n";
    for c in &summary.comparisons {
        text += &format!(
            "| {} | {:+.1} | {:+.1} to {:+.1} | {:.0} % |\n",
            c.what,
            c.mean_mm,
            c.low_mm,
            c.high_mm,
            c.better_share * 100.0
        );
    }
    text += "\n| V2V of people who | views | SMPLify-X | PROX | ours |\n|---|---|---|---|---|\n";
    for group in &summary.groups {
        let errors: String = group.v2v_mm.iter().map(|v| format!(" {v:.1} |")).collect();
        text += &format!("| {} | {} |{errors}\n", group.group, group.cases);
    }
    text +=
        "\n| worst of ours | does | keypoints | V2V: SMPLify-X | PROX | ours |\n|---|---|---|---|---|---|\n";
    for case in &summary.worst {
        let errors: String = case.errors.iter().map(|e| format!(" {:.0} |", e.v2v_mm)).collect();
        text += &format!(
            "| {}, view {} | {} | {} |{errors}\n",
            case.room,
            case.number,
            case.family.label(),
            case.points
        );
    }
    text
}

fn csv(results: &[CaseResult]) -> String {
    let mut text = String::from("room,view,family,keypoints,depth_m");
    for method in ["smplify_x", "prox", "ours"] {
        for error in ["pje_mm", "v2v_mm", "p_pje_mm", "p_v2v_mm", "reprojection_px"] {
            text += &format!(",{method}_{error}");
        }
    }
    text += "\n";
    for case in results {
        let room = case.room.replace(['"', ','], "_");
        text +=
            &format!("{room},{},{},{},{:.3}", case.number, case.family.label(), case.points, case.depth_m);
        for (e, px) in case.errors.iter().zip(&case.reprojection_px) {
            text += &format!(
                ",{:.2},{:.2},{:.2},{:.2},{px:.2}",
                e.pje_mm, e.v2v_mm, e.aligned_pje_mm, e.aligned_v2v_mm
            );
        }
        text += "\n";
    }
    text
}
