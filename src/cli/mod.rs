//! The same jobs without a window: JSON reports, PNG pictures, exit codes.
//!
//! The contract that scripts rely on: names of commands and fields stay as they are. Never names `app`; the
//! window is opened by `main`, which asks [`parse`] what to do.

mod clips;
mod convert;
mod corpus;
mod estimate;
mod evaluate;
mod evolve;
mod figures;
mod generate;
mod import;
mod inspect;
mod learn;
mod load;
mod move_room;
mod network;
mod output;
mod pictures;
mod progress;
mod report;
mod scene_prior;
mod screens;
mod sheet;
mod stage;
mod train;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand, ValueEnum};

pub use report::{BodyRow, FieldRow, GenerateReport, RoomRow, Summary};

/// Exit codes of every command.
pub mod exit {
    /// Done.
    pub const DONE: u8 = 0;
    /// Failed; the reason stands on stderr.
    pub const FAILED: u8 = 1;
    /// Done, with findings above their limit.
    pub const FINDINGS: u8 = 3;
    /// Interrupted by the user.
    pub const INTERRUPTED: u8 = 130;
}

/// Puts people into rooms.
#[derive(Parser, Debug)]
#[command(name = "inhabit", version, about, args_conflicts_with_subcommands = true)]
pub struct Arguments {
    /// What to do; without a command the editor's window opens.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The window's own arguments.
    #[command(flatten)]
    pub window: WindowArguments,
}

/// What the editor's window opens with.
#[derive(Args, Debug, Clone)]
pub struct WindowArguments {
    /// A project or a room (GLB, glTF, OBJ, PLY); a bundled sample room when left out.
    #[arg(value_name = "PROJECT|ROOM")]
    pub open: Option<PathBuf>,
    /// Save a picture of the window to this PNG and quit.
    #[arg(long, value_name = "FILE")]
    pub screenshot: Option<PathBuf>,
    /// Put this many people in before the picture is taken.
    #[arg(long, value_name = "N")]
    pub populate: Option<usize>,
    /// Sample this many candidates from the view before the picture is taken.
    #[arg(long, value_name = "N", requires = "screenshot")]
    pub sample: Option<usize>,
    /// Sample by this: `search`, `s1`, `s2` or `baseline`.
    #[arg(long, value_name = "METHOD", requires = "sample")]
    pub method: Option<String>,
    /// Sample from what somebody in the room sees instead of from this view.
    #[arg(long, requires = "sample")]
    pub agent: bool,
    /// Accept and fit the best so many candidates.
    #[arg(long, value_name = "N", requires = "sample", default_value_t = 0)]
    pub accept: usize,
    /// Turn the view while the people of --populate are made, say how far apart the frames were, and quit.
    #[arg(long, requires = "populate", hide = true)]
    pub frame_times: bool,
    /// Root of the seed tree for --populate.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Colour the people by penetration and contact in the picture.
    #[arg(long, requires = "screenshot")]
    pub heat: bool,
    /// Place a sub-goal at `X,Z` or `X,Z,stand|sit|lie|walk` (metres) and make the motion; once for each sub-goal.
    #[arg(long, value_name = "GOAL", requires = "screenshot", allow_hyphen_values = true)]
    pub goal: Vec<String>,
    /// Show the motion at this time, seconds.
    #[arg(long, value_name = "S", requires = "goal", default_value_t = 0.0)]
    pub at: f32,
    /// Let this many actions happen before the picture is taken.
    #[arg(long, value_name = "N", requires = "screenshot", default_value_t = 0)]
    pub actions: usize,
    /// Show this in the picture: `palette`, `shortcuts`, `help`, `import`, `history`, `samples`, `why`, `new-room`,
    /// `networks`, `motion`, `actions`, `things`, `futures`, `learned`, `graph` or `study`.
    #[arg(long, value_name = "NAME", requires = "screenshot")]
    pub overlay: Option<String>,
    /// Zoom on the selected person.
    #[arg(long, requires = "select")]
    pub frame: bool,
    /// The light theme.
    #[arg(long, requires = "screenshot")]
    pub light: bool,
    /// Select this person (0 is the first) in the picture.
    #[arg(long, value_name = "N", requires = "screenshot")]
    pub select: Option<usize>,
}

/// The commands.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Say what was understood of a room or project: units, up axis, objects, surfaces, field.
    Inspect(inspect::InspectArguments),
    /// Put people into a room and write them, a report and pictures.
    Generate(generate::GenerateArguments),
    /// Let somebody walk, sit down, lie and get up in a room, and write the motion.
    Move(move_room::MoveArguments),
    /// Let actions happen in a room: people come, things are brought, moved and left about.
    Evolve(evolve::EvolveArguments),
    /// Learn statistics of people: actions from annotated photos, poses from clips.
    #[command(subcommand)]
    Learn(learn::Learn),
    /// Train networks on data.
    #[command(subcommand)]
    Train(train::Train),
    /// Say how good something is: tables and pictures.
    #[command(subcommand)]
    Evaluate(evaluate::Evaluate),
    /// Stage a corpus: rooms made by rule, people in them, views of them.
    Stage(stage::StageArguments),
    /// Find the person of a photo in the room where it was taken, from keypoints and a camera.
    Estimate(estimate::EstimateArguments),
    /// Convert a room, layout or project to another format.
    Convert(convert::ConvertArguments),
}

/// Options of every command.
#[derive(Args, Debug, Clone)]
pub struct Common {
    /// Root of the seed tree: the same seed gives the same bytes.
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u64,
    /// Threads to compute with; all cores when left out.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// No progress on stderr.
    #[arg(long)]
    pub quiet: bool,
    /// Print the report on stdout as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Where samples come from.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Affordance search: surfaces, heights, clearance, facing.
    Search,
    /// The one-stage network of PSI, from what a camera sees.
    S1,
    /// The two-stage network of PSI: first where, then how.
    S2,
    /// The older network that PSI compares with.
    Baseline,
}

/// How a command ended, when it did not fail.
pub enum Ended {
    /// Nothing to complain of.
    Clean,
    /// Done, but findings are above their limit.
    WithFindings,
    /// The user interrupted it.
    Interrupted,
}

/// Reads the program's arguments; on wrong usage prints it and exits with 2.
pub fn parse() -> Arguments {
    Arguments::parse()
}

/// Runs one command and gives the program's exit code.
pub fn run(command: Command) -> ExitCode {
    let result = match command {
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Generate(arguments) => generate::run(&arguments),
        Command::Move(arguments) => move_room::run(&arguments),
        Command::Evolve(arguments) => evolve::run(&arguments),
        Command::Learn(subject) => learn::run(&subject),
        Command::Train(subject) => train::run(&subject),
        Command::Evaluate(subject) => evaluate::run(&subject),
        Command::Stage(arguments) => stage::run(&arguments),
        Command::Estimate(arguments) => estimate::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
    };
    exit_code(result)
}

/// The main job where there is no display: people in the bundled living room, written to `out`.
pub fn run_without_display(reason: &str, window: &WindowArguments) -> ExitCode {
    eprintln!("No window: {reason}. Running the same job without one (see `inhabit generate --help`).");
    exit_code(generate::run(&generate::GenerateArguments::without_display(window)))
}

fn exit_code(result: anyhow::Result<Ended>) -> ExitCode {
    match result {
        Ok(Ended::Clean) => exit::DONE.into(),
        Ok(Ended::WithFindings) => exit::FINDINGS.into(),
        Ok(Ended::Interrupted) => exit::INTERRUPTED.into(),
        Err(error) => {
            eprintln!("inhabit: {error:#}");
            exit::FAILED.into()
        }
    }
}

/// Limits the number of computing threads, once, before any work.
fn use_threads(threads: Option<usize>) -> anyhow::Result<()> {
    if let Some(threads) = threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build_global()?;
    }
    Ok(())
}
