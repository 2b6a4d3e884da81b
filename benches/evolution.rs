//! What one action costs, choice, placing and clearing away, as things gather in the living room: the curve to 500
//! things. Prints a table: things in the room, actions timed, their mean and slowest.
//!
//! Every kind is allowed a thousand times, so that things gather as fast as actions bring them.

use std::sync::Arc;

use inhabit::assets::{Budget, read_model_bytes, sample_rooms};
use inhabit::evolve::action::{ActionModel, Evolution, EvolutionConfig, KindId, Library, Stage};
use inhabit::job::{Seed, Ticker};
use inhabit::scene::{ImportOptions, room_from_model};

/// Things at which the curve ends.
const MOST_THINGS: usize = 500;
/// Actions that are tried at most.
const MOST_ACTIONS: usize = 1500;
/// Things between two rows.
const STEP: usize = 50;

fn main() {
    let sample = &sample_rooms()[0];
    let model = read_model_bytes(sample.key, sample.glb, &Budget::default()).expect("bundled");
    let room = Arc::new(room_from_model(&model, &ImportOptions::default()).room);
    let mut library = (*Library::bundled()).clone();
    (0..library.kinds().count()).for_each(|k| library.set_most(KindId(k), 1000));
    let stage = Arc::new(Stage::new(room, Arc::new(library), &Ticker::silent()).expect("not cancelled"));
    let actions = ActionModel::bundled().expect("bundled");
    let mut evolution = Evolution::new(stage, actions, EvolutionConfig::usual(), Seed::root(1));
    println!("{:>8} {:>8} {:>10} {:>12}", "things", "actions", "mean ms", "slowest ms");
    let (mut times, mut row, mut refused) = (Vec::new(), STEP, 0);
    for _ in 0..MOST_ACTIONS {
        let Some(node) = evolution.draw_next_after(refused) else { break };
        match evolution.apply(node, refused) {
            Ok(next) => {
                times.extend(next.steps().last().map(|s| s.seconds * 1e3));
                (evolution, refused) = (next, 0);
            }
            Err(_) => refused += 1,
        }
        if evolution.world().len() >= row || refused > 60 {
            let mean = times.iter().sum::<f64>() / times.len().max(1) as f64;
            let slowest = times.iter().fold(0.0_f64, |a, b| a.max(*b));
            println!("{:>8} {:>8} {mean:>10.1} {slowest:>12.1}", evolution.world().len(), times.len());
            times.clear();
            row += STEP;
        }
        if evolution.world().len() >= MOST_THINGS || refused > 60 {
            break;
        }
    }
}
