//! `inhabit evaluate motion`: LTM's tables on held-out clips in staged rooms.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;

use super::super::clips::read_clips;
use super::super::network::read_weights;
use super::super::output::OutputFolder;
use super::super::progress::run_job;
use super::super::{Common, Ended, use_threads};
use crate::assets::{PoseClip, encode_png};
use crate::job::{JobCtx, Seed, Stop};
use crate::learn::motion::evaluate::{
    MotionNets, MotionStudyConfig, MotionStudyRow, motion_csv, motion_markdown, run_motion_study,
};
use crate::learn::motion::{MotionData, MotionDataConfig};
use crate::motion::bundled::bundled_networks;
use crate::render::plot::{BarChart, BarSeries, bar_chart};

/// Pixels of the charts.
const CHART: [u32; 2] = [1180, 460];

/// Arguments of `evaluate motion`.
#[derive(Args, Debug)]
pub struct MotionArguments {
    /// Folder with motion clips, the same as the networks were trained with: those held out then are measured on.
    #[arg(long, value_name = "DIR")]
    corpus: PathBuf,
    /// Take the networks from this folder (every `.safetensors` of `inhabit train`) instead of the program's own.
    #[arg(long, value_name = "DIR")]
    networks: Option<PathBuf>,
    /// Folder for the tables; must be new or empty.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Write over an earlier run in the same folder.
    #[arg(long)]
    resume: bool,
    /// Windows of two seconds.
    #[arg(long, value_name = "N", default_value_t = MotionStudyConfig::default().windows)]
    windows: usize,
    /// Of these so many are optimised, by the paper's and by our weights.
    #[arg(long, value_name = "N", default_value_t = MotionStudyConfig::default().optimised)]
    optimised: usize,
    /// Motions of two, four and six seconds through several sub-goals, of each length.
    #[arg(long, value_name = "N", default_value_t = MotionStudyConfig::default().long)]
    long: usize,
    #[command(flatten)]
    common: Common,
}

/// Runs the command.
///
/// # Errors
/// When corpus or networks can't be used, or a file can't be written.
pub fn run(arguments: &MotionArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let clips = read_clips(&arguments.corpus)?;
    let nets = match &arguments.networks {
        Some(folder) => read_networks(folder)?,
        None => {
            let mut nets = MotionNets::default();
            for weights in bundled_networks() {
                nets.add(&weights?)?;
            }
            nets
        }
    };
    let folder = OutputFolder::claim(&arguments.out, arguments.resume)?;
    let config = MotionStudyConfig {
        windows: arguments.windows,
        optimised: arguments.optimised,
        long: arguments.long,
        seed: arguments.common.seed,
    };
    let partial = folder.root().join("tables.csv");
    let work = move |cx: &JobCtx| study(&clips, &nets, &config, &partial, cx);
    let seed = Seed::root(arguments.common.seed);
    let Some(rows) = run_job("evaluate motion", seed, arguments.common.quiet, work)? else {
        eprintln!("interrupted; what was measured so far stands in {}", arguments.out.display());
        return Ok(Ended::Interrupted);
    };
    write_tables(&folder, arguments, &rows)?;
    if arguments.common.json {
        println!("{}", serde_json::to_string_pretty(&rows)?);
    } else if !arguments.common.quiet {
        print!("{}", motion_markdown(&rows));
    }
    Ok(Ended::Clean)
}

/// Every weight file of a folder that holds a network of motion.
fn read_networks(folder: &Path) -> anyhow::Result<MotionNets> {
    let mut nets = MotionNets::default();
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .with_context(|| format!("can't read {}: name a folder with --networks", folder.display()))?
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "safetensors"))
        .filter(|path| !path.file_stem().is_some_and(|s| s.to_string_lossy().ends_with(".checkpoint")))
        .collect();
    files.sort();
    for file in &files {
        nets.add(&read_weights(file)?).with_context(|| format!("{}", file.display()))?;
    }
    anyhow::ensure!(!files.is_empty(), "{} holds no .safetensors", folder.display());
    Ok(nets)
}

/// Measures, and appends each row to the CSV as soon as it is known.
fn study(
    clips: &[PoseClip],
    nets: &MotionNets,
    config: &MotionStudyConfig,
    csv: &Path,
    cx: &JobCtx,
) -> Result<Vec<MotionStudyRow>, Stop> {
    let data_config = MotionDataConfig { family_bodies: 0, ..MotionDataConfig::default() };
    let data = MotionData::from_clips(clips, &data_config, cx.ticker())?;
    let mut rows = Vec::new();
    let mut file = fs::File::create(csv)?;
    let mut each = |row: &MotionStudyRow| {
        let text = motion_csv(std::slice::from_ref(row));
        let line = if rows.is_empty() { &text } else { text.split_once('\n').map_or("", |(_, line)| line) };
        rows.push(());
        Ok(file.write_all(line.as_bytes())?)
    };
    run_motion_study(&data, nets, config, cx.ticker(), &mut each)
}

fn write_tables(
    folder: &OutputFolder,
    arguments: &MotionArguments,
    rows: &[MotionStudyRow],
) -> anyhow::Result<()> {
    folder.write("tables.csv", motion_csv(rows).as_bytes())?;
    let mut text = String::from("# Long-term motion\n\n");
    writeln!(
        text,
        "inhabit {} evaluate motion, seed {}: clips held out of the training, each in a room staged around it; {} \
         windows of two seconds, {} of them optimised, {} motions of each length.\n",
        env!("CARGO_PKG_VERSION"),
        arguments.common.seed,
        arguments.windows,
        arguments.optimised,
        arguments.long
    )?;
    text += &motion_markdown(rows);
    folder.write("tables.md", text.as_bytes())?;
    for (file, title, axis, value) in [
        (
            "mpjpe",
            "Joints against the captured ones",
            "MPJPE, mm",
            (|r| r.errors.mpjpe_mm) as fn(&MotionStudyRow) -> f32,
        ),
        ("neighbour_v2v", "First and last body against the frames beside them", "cm", |r| r.neighbour_v2v_cm),
        ("skate", "Planted feet", "cm/s", |r| r.metrics.skate_cm_per_s),
    ] {
        let bar = |r: &MotionStudyRow| {
            format!(
                "{}{} {} s, {}",
                r.method,
                if r.scene { "" } else { " ×" },
                r.seconds,
                r.optimised.label()
            )
        };
        let chart = BarChart {
            title: title.to_owned(),
            y_label: axis.to_owned(),
            groups: rows.iter().map(bar).collect(),
            series: vec![BarSeries {
                name: axis.to_owned(),
                values: rows.iter().map(|r| Some(f64::from(value(r)))).collect(),
            }],
            references: Vec::new(),
            y_range: None,
        };
        let picture = bar_chart(&chart, CHART)?;
        let png = encode_png(picture.width, picture.height, &picture.rgba)?;
        folder.write(&format!("plots/{file}.png"), &png)?;
    }
    Ok(())
}
