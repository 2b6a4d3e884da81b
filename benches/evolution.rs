//! What one action costs, choice, placing and clearing away, as things gather.
//!
//! Without arguments: the curve to 500 things in the living room, where every kind is allowed a thousand times so that
//! things gather as fast as actions bring them; a table of things in the room, actions timed, their mean and slowest.
//! With arguments ROOM ACTIONS SEED... (`cargo bench --bench evolution -- ROOM 100 1 2`): what they cost for each seed,
//! and what was wrong with the room after any of them.
//!
//! Times are of the processor where the system tells (Linux), so that other programs don't count; else of the clock.

use std::collections::BTreeSet;
use std::fmt::{Display, Formatter};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use inhabit::assets::{Budget, read_model, read_model_bytes, sample_rooms};
use inhabit::evolve::action::{ActionModel, Evolution, EvolutionConfig, KindId, Library, Stage, measure};
use inhabit::job::{Seed, Ticker};
use inhabit::scene::{ImportOptions, Room, room_from_model};

/// Things at which the curve ends.
const MOST_THINGS: usize = 500;
/// Actions that are tried at most.
const MOST_ACTIONS: usize = 1500;
/// Things between two rows.
const STEP: usize = 50;
/// Refused actions in a row after which nothing more can be done.
const MOST_REFUSED: u64 = 60;

fn main() {
    let given: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    match given.split_first() {
        Some((room, numbers)) => in_room(room, numbers),
        None if std::env::args().any(|argument| argument == "--bench") => curve(MOST_THINGS),
        // As a test: the first row shows that it runs.
        None => curve(STEP),
    }
}

/// Seconds that this thread computed; of the clock where nobody tells.
fn processor_s(started: &Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.as_deref().and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| started.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

/// The next action that is possible, and its milliseconds; those of attempts that were not go to `in_vain`.
fn next(evolution: &Evolution, started: &Instant, in_vain: &mut Vec<f64>) -> Option<(Evolution, f64)> {
    (0..MOST_REFUSED).find_map(|refused| {
        let node = evolution.draw_next_after(refused)?;
        let before = processor_s(started);
        let next = evolution.apply(node, refused);
        let ms = (processor_s(started) - before) * 1e3;
        next.map(|next| (next, ms)).map_err(|_| in_vain.push(ms)).ok()
    })
}

fn mean_and_slowest(times: &[f64]) -> (f64, f64) {
    let mean = times.iter().sum::<f64>() / times.len().max(1) as f64;
    (mean, times.iter().fold(0.0_f64, |a, b| a.max(*b)))
}

fn start(room: Room, library: Library, seed: u64) -> Evolution {
    let stage = Stage::new(Arc::new(room), Arc::new(library), &Ticker::silent()).expect("not cancelled");
    let actions = ActionModel::bundled().expect("bundled");
    Evolution::new(Arc::new(stage), actions, EvolutionConfig::usual(), Seed::root(seed))
}

fn sample(number: usize) -> Room {
    let sample = &sample_rooms()[number];
    let model = read_model_bytes(sample.key, sample.glb, &Budget::default()).expect("bundled");
    room_from_model(&model, &ImportOptions::default()).room
}

fn curve(most_things: usize) {
    let mut library = (*Library::bundled()).clone();
    (0..library.kinds().count()).for_each(|k| library.set_most(KindId(k), 1000));
    let (mut evolution, started) = (start(sample(0), library, 1), Instant::now());
    let heads = ["things", "actions", "mean ms", "slowest ms", "in vain", "mean ms"];
    heads.iter().for_each(|head| print!("{head:>12}"));
    println!();
    let (mut times, mut in_vain, mut row) = (Vec::new(), Vec::new(), STEP);
    for _ in 0..MOST_ACTIONS {
        let Some((after, ms)) = next(&evolution, &started, &mut in_vain) else { break };
        evolution = after;
        times.push(ms);
        let things = evolution.world().len();
        if things >= row {
            let (mean, slowest) = mean_and_slowest(&times);
            let vain = mean_and_slowest(&in_vain).0;
            println!(
                "{things:>12}{:>12}{mean:>12.1}{slowest:>12.1}{:>12}{vain:>12.1}",
                times.len(),
                in_vain.len()
            );
            times.clear();
            in_vain.clear();
            row += STEP;
        }
        if things >= most_things {
            break;
        }
    }
}

/// As `inhabit evolve ROOM --actions N --seed S`, without bodies.
fn in_room(name: &str, numbers: &[String]) {
    let number = |text: &String| text.parse::<u64>().expect("ROOM ACTIONS SEED...");
    let actions = numbers.first().map_or(100, number);
    let known = sample_rooms().iter().position(|s| name.strip_prefix("sample:") == Some(s.key));
    let room = || match known {
        Some(known) => sample(known),
        None => {
            let model = read_model(Path::new(name), &Budget::default()).expect("a room's file");
            room_from_model(&model, &ImportOptions::default()).room
        }
    };
    for seed in numbers.iter().skip(1).map(number) {
        let (mut evolution, started) = (start(room(), (*Library::bundled()).clone(), seed), Instant::now());
        let (mut times, mut in_vain, mut wrong) = (Vec::new(), Vec::new(), Wrong::default());
        for _ in 0..actions {
            let Some((after, ms)) = next(&evolution, &started, &mut in_vain) else { break };
            evolution = after;
            times.push(ms);
            wrong.add(&evolution);
        }
        let (mean, slowest) = mean_and_slowest(&times);
        let half = times.len() / 2;
        println!(
            "{name} seed {seed}: {} actions, {} in vain, {} things, mean {mean:.1} ms (first half {:.1}, second {:.1}), slowest {slowest:.1}",
            times.len(),
            in_vain.len(),
            evolution.world().len(),
            mean_and_slowest(&times[..half]).0,
            mean_and_slowest(&times[half..]).0,
        );
        println!("    {wrong}");
    }
}

/// What was wrong after any action, summed over the actions.
#[derive(Default)]
struct Wrong {
    interpenetrations: usize,
    unsupported: usize,
    out_of_bounds: usize,
    wanted_in_vain: usize,
    which: BTreeSet<String>,
}

impl Wrong {
    fn add(&mut self, evolution: &Evolution) {
        let found = measure(evolution);
        self.interpenetrations += found.interpenetrations;
        self.unsupported += found.unsupported;
        self.out_of_bounds += found.out_of_bounds;
        self.wanted_in_vain += evolution.steps().last().map_or(0, |step| step.failed.len());
        let pairs = found.pairs.iter().map(|pair| format!("{} in {:?}", pair.object, pair.other));
        self.which.extend(pairs.chain(found.unsupported_objects).chain(found.out_of_bounds_objects));
    }
}

impl Display for Wrong {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let Self { interpenetrations, unsupported, out_of_bounds, wanted_in_vain, which } = self;
        write!(
            f,
            "interpenetrations {interpenetrations}, unsupported {unsupported}, out of bounds {out_of_bounds}, things wanted \
             in vain {wanted_in_vain} {which:?}"
        )
    }
}
