//! How probable held-out photos are under the learned model and under simpler ones.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::instances::{Found, Instance, PlacedThing};
use super::nodes::{self, MOST_PIECES, ModelConfig, build_model};
use super::rules::Rules;
use crate::evolve::action::{ActionModel, ActionNode, Evidence, Polar, PolarDensity};
use crate::job::{Cancelled, Seed, Ticker};

/// Mean natural logarithms of the probability of what held-out photos show.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LikelihoodRow {
    /// The model.
    pub model: String,
    /// Of how many of each object there are, an instance of a photo where everything is marked; nats.
    pub counts: f64,
    /// Of where an object lies, density per square metre; nats.
    pub place: f64,
    /// Of both together, an instance with all its objects; nats.
    pub instance: f64,
}

/// The comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Likelihood {
    /// The learned model first, then the baselines.
    pub rows: Vec<LikelihoodRow>,
    /// Held-out instances.
    pub instances: usize,
    /// Of these, where everything is marked.
    pub complete_instances: usize,
    /// Objects whose place was asked for.
    pub places: usize,
    /// Parts that the photos were split into; each was held out once.
    pub folds: usize,
}

/// Parts of the photos.
const FOLDS: u64 = 5;
/// Places farther than this are not asked for: the uniform baseline needs an end. Metres.
const WITHIN_M: f64 = 4.0;
/// Share of every model that is uniform, so that what was never seen stays possible; the same for all.
const SMOOTHING: f64 = 0.02;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Learned,
    PairwiseOnly,
    OccurrenceOnly,
    Uniform,
}

const KINDS: [(Kind, &str); 4] = [
    (Kind::Learned, "learned (occurrence, person, objects)"),
    (Kind::PairwiseOnly, "pairwise only (person to object, no actions)"),
    (Kind::OccurrenceOnly, "occurrence only"),
    (Kind::Uniform, "uniform"),
];

#[derive(Default)]
struct Sums {
    counts: [f64; 4],
    places: [f64; 4],
    instances: usize,
    complete: usize,
    things: usize,
}

impl Sums {
    fn plus(mut self, other: &Self) -> Self {
        (0..KINDS.len()).for_each(|k| self.counts[k] += other.counts[k]);
        (0..KINDS.len()).for_each(|k| self.places[k] += other.places[k]);
        self.instances += other.instances;
        self.complete += other.complete;
        self.things += other.things;
        self
    }
}

/// Learns on four fifths of the photos and asks for the rest, five times.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn held_out_likelihood(
    found: &Found,
    rules: &Rules,
    config: &ModelConfig,
    metres_per_unit: f64,
    seed: Seed,
    ticker: &Ticker,
) -> Result<Likelihood, Cancelled> {
    ticker.stage("asking held-out photos", FOLDS as usize)?;
    let fold = |fold: u64| {
        let (held_out, kept): (Vec<Instance>, Vec<Instance>) =
            found.instances.iter().cloned().partition(|i| fold_of(&i.photo) == fold);
        let kept = Found { instances: kept, ..Found::default() };
        let model = build_model(&kept, rules, config, metres_per_unit, seed.child("fold", fold));
        let pooled = Pooled::of(&kept, rules, config, metres_per_unit, seed);
        let mut sums = Sums::default();
        for instance in &held_out {
            add(&mut sums, instance, &model, &pooled, rules, metres_per_unit);
        }
        ticker.advance()?;
        Ok(sums)
    };
    let parts: Vec<Sums> = (0..FOLDS).into_par_iter().map(fold).collect::<Result<_, Cancelled>>()?;
    let sums = parts.iter().fold(Sums::default(), Sums::plus);
    let row = |(index, (_, name)): (usize, &(Kind, &str))| {
        let counts = sums.counts[index] / sums.complete.max(1) as f64;
        let place = sums.places[index] / sums.things.max(1) as f64;
        let each = sums.places[index] / sums.instances.max(1) as f64;
        LikelihoodRow { model: (*name).to_owned(), counts, place, instance: counts + each }
    };
    Ok(Likelihood {
        rows: KINDS.iter().enumerate().map(row).collect(),
        instances: sums.instances,
        complete_instances: sums.complete,
        places: sums.things,
        folds: FOLDS as usize,
    })
}

/// The part of a photo, by its key alone.
fn fold_of(photo: &str) -> u64 {
    Seed::root(0).child(photo, 0).value() % FOLDS
}

/// What all actions together do: the baseline without actions.
struct Pooled {
    occurrence: BTreeMap<String, Vec<f64>>,
    around: BTreeMap<String, PolarDensity>,
}

impl Pooled {
    fn of(kept: &Found, rules: &Rules, config: &ModelConfig, metres_per_unit: f64, seed: Seed) -> Self {
        let complete = kept.instances.iter().filter(|i| i.complete);
        let counted: Vec<_> = complete.map(|i| nodes::counts(i, rules)).collect();
        let mut places: BTreeMap<String, Vec<super::layout::PolarUnits>> = BTreeMap::new();
        for thing in kept.instances.iter().flat_map(nodes::placed) {
            places.entry(thing.object.clone()).or_default().push(thing.from_person);
        }
        let shares = |object: &String| {
            let mut numbers = [0.0; MOST_PIECES + 1];
            counted.iter().for_each(|c| numbers[c.get(object).copied().unwrap_or(0)] += 1.0);
            numbers.iter().map(|n| n / counted.len().max(1) as f64).collect()
        };
        let fit =
            |places: &Vec<_>| nodes::fit_density(places, Evidence::Everything, config, metres_per_unit, seed);
        Self {
            occurrence: places.keys().map(|o| (o.clone(), shares(o))).collect(),
            around: places.par_iter().filter_map(|(o, p)| Some((o.clone(), fit(p)?))).collect(),
        }
    }
}

/// The node that fits an instance best: its own, or the largest of its type.
fn node_of<'a>(model: &'a ActionModel, instance: &Instance) -> Option<&'a ActionNode> {
    let own = nodes::node_key(instance);
    let is_own = |n: &&ActionNode| (n.kind, n.key, n.relation, n.posture) == own;
    let of_kind = model.nodes.iter().filter(|n| n.kind == instance.kind);
    model.nodes.iter().find(is_own).or_else(|| of_kind.max_by_key(|n| n.instances))
}

fn add(
    sums: &mut Sums,
    instance: &Instance,
    model: &ActionModel,
    pooled: &Pooled,
    rules: &Rules,
    metres_per_unit: f64,
) {
    let node = node_of(model, instance);
    sums.instances += 1;
    if instance.complete {
        sums.complete += 1;
        let counts = nodes::counts(instance, rules);
        for object in &rules.objects {
            let n = counts.get(object).copied().unwrap_or(0);
            for (sum, (kind, _)) in sums.counts.iter_mut().zip(KINDS) {
                *sum += smoothed(
                    count_probability(kind, object, n, node, pooled),
                    1.0 / (MOST_PIECES + 1) as f64,
                )
                .ln();
            }
        }
    }
    let mut things: Vec<&PlacedThing> = nodes::placed(instance);
    things.retain(|t| t.from_person.distance * metres_per_unit < WITHIN_M);
    // As objects are placed: the most frequent first, each seeing those before.
    let often = |t: &PlacedThing| node.map_or(0.0, |n| n.frequency(&t.object));
    things.sort_by(|a, b| often(b).total_cmp(&often(a)));
    sums.things += things.len();
    let uniform = 1.0 / (std::f64::consts::PI * WITHIN_M * WITHIN_M);
    for (index, thing) in things.iter().enumerate() {
        let before = &things[..index];
        for (sum, (kind, _)) in sums.places.iter_mut().zip(KINDS) {
            let density = match kind {
                Kind::Learned => placed_density(model, node, instance, thing, before, metres_per_unit),
                Kind::PairwiseOnly => pooled
                    .around
                    .get(&thing.object)
                    .map(|d| d.density_per_m2(metres(thing.from_person, metres_per_unit))),
                Kind::OccurrenceOnly | Kind::Uniform => None,
            };
            *sum += smoothed(density.unwrap_or(uniform), uniform).ln();
        }
    }
}

fn smoothed(probability: f64, uniform: f64) -> f64 {
    (1.0 - SMOOTHING) * probability + SMOOTHING * uniform
}

fn count_probability(kind: Kind, object: &str, n: usize, node: Option<&ActionNode>, pooled: &Pooled) -> f64 {
    let never = if n == 0 { 1.0 } else { 0.0 };
    match kind {
        Kind::Learned | Kind::OccurrenceOnly => node
            .and_then(|node| node.occurrence_of(object))
            .map_or(never, |o| o.probability.get(n).copied().unwrap_or(0.0)),
        Kind::PairwiseOnly => pooled.occurrence.get(object).map_or(never, |p| p[n]),
        Kind::Uniform => 1.0 / (MOST_PIECES + 1) as f64,
    }
}

fn metres(units: super::layout::PolarUnits, metres_per_unit: f64) -> Polar {
    Polar { distance_m: (units.distance * metres_per_unit) as f32, angle_rad: units.angle_rad as f32 }
}

/// Eq. 10 as a density per square metre: P(o, H) and the P(o, o') of what lies already, weighted by f and normalised.
/// An object that the node does not know lies as at the node that knows it best.
fn placed_density(
    model: &ActionModel,
    node: Option<&ActionNode>,
    instance: &Instance,
    thing: &PlacedThing,
    before: &[&PlacedThing],
    metres_per_unit: f64,
) -> Option<f64> {
    let elsewhere = || {
        let known = model.nodes.iter().filter_map(|n| n.placement(&thing.object));
        known.max_by_key(|p| p.density.samples)
    };
    let own = node.and_then(|n| n.placement(&thing.object)).or_else(elsewhere)?;
    let (mut sum, mut weight) = (own.density.density_per_m2(metres(thing.from_person, metres_per_unit)), 1.0);
    for other in before {
        let pair = node.and_then(|n| n.pairs_of(&thing.object).find(|p| p.reference == other.object));
        if let Some(pair) = pair {
            let seen = instance.frame.polar_from(thing.pixel, other.pixel);
            sum += pair.together * pair.density.density_per_m2(metres(seen, metres_per_unit));
            weight += pair.together;
        }
    }
    Some(sum / weight)
}
