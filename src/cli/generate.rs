//! `inhabit generate`: the main job without a window.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use glam::Vec3;

use super::load::{self, Loaded};
use super::network::Network;
use super::output::OutputFolder;
use super::pictures::Photographer;
use super::progress::run_job;
use super::report::{BodyRow, GenerateReport, Seconds, Summary};
use super::{Common, Ended, Method, WindowArguments, use_threads};
use crate::body::Body;
use crate::document::{Project, save_project};
use crate::evolve::{LearnedRequest, PopulateRequest, Populated, populate, populate_learned};
use crate::job::{JobCtx, Seed};
use crate::nn::psi::PsiMethod;
use crate::render::{BodySurface, person_glb};
use crate::scene::{Person, PoseFamily, RoomGeometry, Scene};

/// How many people come when nobody says.
const DEFAULT_PEOPLE: usize = 8;

/// Arguments of `generate`.
#[derive(Args, Debug)]
pub struct GenerateArguments {
    /// A room (GLB, glTF, OBJ, PLY), a project, or `sample:living`, `sample:bedroom`, `sample:office`.
    #[arg(value_name = "ROOM")]
    pub room: Option<PathBuf>,
    /// How many people.
    #[arg(long, default_value_t = DEFAULT_PEOPLE, value_name = "N")]
    pub people: usize,
    /// Where samples come from.
    #[arg(long, value_enum, default_value_t = Method::Search)]
    pub method: Method,
    /// Weights of `inhabit train psi` instead of those that come with the program.
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Only near this point: metres, world frame.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub at: Option<Vec3>,
    /// Only poses of this family.
    #[arg(long, value_enum, value_name = "FAMILY")]
    pub family: Option<FamilyGroup>,
    /// Folder for everything that is written; must be new or empty.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write over an earlier run in the same folder.
    #[arg(long)]
    pub resume: bool,
    /// Pictures from this many sides.
    #[arg(long, default_value_t = 2, value_name = "N")]
    pub sides: usize,
    /// No pictures.
    #[arg(long)]
    pub no_pictures: bool,
    /// How the room's file is to be read.
    #[command(flatten)]
    pub import: super::import::ImportArguments,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// Pose families as the command line names them.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum FamilyGroup {
    /// On chairs, sofas, stools, edges, and with straight legs.
    Sit,
    /// Free on the floor.
    Stand,
    /// Face up, face down or on the side.
    Lie,
    /// Against tables, counters and walls.
    Lean,
}

impl FamilyGroup {
    fn families(self) -> Vec<PoseFamily> {
        let name = match self {
            Self::Sit => "sit",
            Self::Stand => "stand",
            Self::Lie => "lie",
            Self::Lean => "lean",
        };
        PoseFamily::ALL.into_iter().filter(|f| f.group() == name).collect()
    }
}

impl GenerateArguments {
    /// The job that stands in for the window where there is no display.
    pub fn without_display(window: &WindowArguments) -> Self {
        Self {
            room: window.open.clone(),
            people: window.populate.unwrap_or(DEFAULT_PEOPLE),
            method: Method::Search,
            weights: None,
            at: None,
            family: None,
            out: None,
            resume: false,
            sides: 2,
            no_pictures: false,
            import: super::import::ImportArguments::default(),
            common: Common { seed: window.seed, threads: None, quiet: false, json: false },
        }
    }
}

/// Three numbers `X,Y,Z` as a point in metres.
///
/// # Errors
/// What to write instead.
pub fn parse_point(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers.as_slice() {
        [x, y, z] if numbers.iter().all(|n| n.is_finite()) => Ok(Vec3::new(*x, *y, *z)),
        _ => Err(format!("`{text}` is no point: write three numbers in metres as X,Y,Z")),
    }
}

/// All that the job computes, before anything is written.
struct Computed {
    geometry: RoomGeometry,
    populated: Populated,
    field_seconds: f64,
}

/// Runs the command.
///
/// # Errors
/// When the room can't be read or the output can't be written.
pub fn run(arguments: &GenerateArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let started = Instant::now();
    let mut loaded = load::load(arguments.room.as_deref(), &arguments.import.options()?)?;
    let mut seconds = Seconds { load: started.elapsed().as_secs_f64(), ..Seconds::default() };
    let root = arguments.out.clone().unwrap_or_else(load::default_output);
    let folder = OutputFolder::claim(&root, arguments.resume)?;
    let Some(computed) = compute(arguments, &loaded)? else {
        return Ok(Ended::Interrupted);
    };
    seconds.field = computed.field_seconds;
    seconds.generate = computed.populated.generate_seconds;
    seconds.fit = computed.populated.fit_seconds;
    let writing = Instant::now();
    loaded.people.extend(computed.populated.people.iter().map(|p| p.person.clone()));
    let scene = Scene { room: loaded.room.clone(), people: loaded.people.clone(), clips: Vec::new() };
    write_scene(&folder, &scene)?;
    let pictures_by = if arguments.no_pictures {
        "nobody: --no-pictures".to_owned()
    } else {
        photograph(&folder, &scene, &computed, arguments.sides)?
    };
    seconds.write = writing.elapsed().as_secs_f64();
    seconds.total = started.elapsed().as_secs_f64();
    let report = report(arguments, &loaded, &computed, seconds, pictures_by);
    let json = serde_json::to_string_pretty(&report)?;
    folder.write("report.json", json.as_bytes())?;
    tell(arguments, &report, &folder, &json);
    Ok(if report.findings.is_empty() && report.shortfall.is_none() {
        Ended::Clean
    } else {
        Ended::WithFindings
    })
}

/// The network that proposes, or none for the search.
fn network_of(arguments: &GenerateArguments) -> anyhow::Result<Option<Network>> {
    let method = match arguments.method {
        Method::Search => return Ok(None),
        Method::S1 => PsiMethod::S1,
        Method::S2 => PsiMethod::S2,
        Method::Baseline => PsiMethod::Baseline,
    };
    Network::of(method, arguments.weights.as_deref()).map(Some)
}

fn compute(arguments: &GenerateArguments, loaded: &Loaded) -> anyhow::Result<Option<Computed>> {
    let room = loaded.room.clone();
    let request = PopulateRequest {
        people: arguments.people,
        at: arguments.at,
        families: arguments.family.map(FamilyGroup::families),
        existing: loaded.people.clone(),
        next_id: loaded.people.iter().map(|p| p.id.0 + 1).max().unwrap_or(0),
        ..PopulateRequest::default()
    };
    let network = network_of(arguments)?;
    let work = move |cx: &JobCtx| {
        let started = Instant::now();
        let geometry = load::geometry(&room, cx.ticker())?;
        let field_seconds = started.elapsed().as_secs_f64();
        let cx = JobCtx::watched(cx.seed, cx.ticker().clone());
        let populated = match &network {
            None => populate(&room, &geometry, &request, &cx)?,
            Some(network) => {
                let request = LearnedRequest { populate: request, ..LearnedRequest::default() };
                populate_learned(&room, &geometry, network, &request, &cx)?
            }
        };
        Ok(Computed { geometry, populated, field_seconds })
    };
    run_job("generate", Seed::root(arguments.common.seed), arguments.common.quiet, work)
}

/// Writes the project with its room, and everybody in it.
fn write_scene(folder: &OutputFolder, scene: &Scene) -> anyhow::Result<()> {
    let project = Project::of_scene(scene.clone());
    save_project(&folder.root().join("project.ron"), &project)?;
    let surface = BodySurface::of(Body::bundled());
    for person in &scene.people {
        folder.write(&person_file(person), &person_glb(person, &surface)?)?;
    }
    Ok(())
}

/// Draws the room and every new person; gives the name of what drew.
fn photograph(
    folder: &OutputFolder,
    scene: &Scene,
    computed: &Computed,
    sides: usize,
) -> anyhow::Result<String> {
    let photographer = Photographer::new(folder, scene)?;
    photographer.room()?;
    for person in &computed.populated.people {
        photographer.person(person, &computed.geometry, sides)?;
    }
    Ok(photographer.made_by())
}

fn person_file(person: &Person) -> String {
    format!("people/{:03}.glb", person.id.0)
}

fn report(
    arguments: &GenerateArguments,
    loaded: &Loaded,
    computed: &Computed,
    seconds: Seconds,
    pictures_by: String,
) -> GenerateReport {
    let people = &computed.populated.people;
    let bodies: Vec<BodyRow> = people
        .iter()
        .map(|p| BodyRow::new(&p.person, &p.report.metrics, p.seconds, person_file(&p.person)))
        .collect();
    let mut findings: Vec<_> = people.iter().flat_map(|p| p.findings.clone()).collect();
    findings.sort_by(|a, b| b.severity().total_cmp(&a.severity()));
    GenerateReport {
        command: "generate".to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed: arguments.common.seed,
        room: load::room_row(loaded, &computed.geometry, computed.field_seconds),
        summary: Summary::of(&bodies),
        bodies,
        findings,
        seconds,
        people_requested: arguments.people,
        shortfall: computed.populated.shortfall.clone(),
        pictures_by,
    }
}

fn tell(arguments: &GenerateArguments, report: &GenerateReport, folder: &OutputFolder, json: &str) {
    if arguments.common.json {
        println!("{json}");
    } else if !arguments.common.quiet {
        let s = &report.summary;
        println!(
            "{} people in {:.1} s: non-collision {:.3}, contact {:.0} %, deepest penetration {:.0} mm, supported \
             {:.0} %, {:?}",
            report.bodies.len(),
            report.seconds.total,
            s.psi_non_collision_mean,
            s.contact_2cm_mean * 100.0,
            s.penetration_max_mm,
            s.supported_share * 100.0,
            s.families
        );
        println!(
            "Written to {}: project.ron, room.glb, people/, pictures/, report.json",
            folder.root().display()
        );
    }
    if let Some(shortfall) = &report.shortfall {
        eprintln!("inhabit: {shortfall}.");
    }
    for finding in &report.findings {
        eprintln!(
            "inhabit: person {}: {} is {:.3}, limit {:.3}",
            finding.site.body,
            finding.metric.label(),
            finding.value,
            finding.limit
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_three_numbers_and_everything_else_is_explained() {
        assert_eq!(parse_point("1, -2.5,3"), Ok(Vec3::new(1.0, -2.5, 3.0)));
        for wrong in ["", "1,2", "1,2,x", "1,2,3,4", "nan,0,0"] {
            assert!(parse_point(wrong).expect_err(wrong).contains("X,Y,Z"));
        }
    }
}
