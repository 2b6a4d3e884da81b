//! From instances to action nodes: occurrence, layouts, groups (ADSE §4.2 and 4.4).

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::instances::{Found, Group, Instance, PlacedThing};
use super::layout::PolarUnits;
use super::rules::Rules;
use crate::evolve::action::{
    ActionKind, ActionModel, ActionNode, Evidence, GroupModel, KeyObject, KeyRelation, Occurrence,
    PEOPLE_APART_M, PairPlacement, Placement, PolarDensity, Posture, is_shared,
};
use crate::job::Seed;
use crate::math::LogNormal;
use crate::math::directions::{MixtureConfig, VonMises, VonMisesMixture};

/// Settings of [`build_model`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelConfig {
    /// ε_C (ADSE §4.2): objects that occur less often are never involved.
    pub occurrence_least: f64,
    /// Weight of the prior of occurrence, in instances: a node's is what its type does, a type's is what its people
    /// were marked as using. Nodes of tens of photos hardly feel it, nodes of three do.
    pub prior_instances: f64,
    /// Instances of a node below which it is left out, unless it is its type's largest.
    pub node_least: usize,
    /// Places from which on a layout is called a node's own, or its type's.
    pub own_places: usize,
    /// Weight, in places, that a type's layout has in a node's and everybody's in a type's. 0: a node has its own from
    /// `own_places` on or its type's, nothing between, as the paper.
    pub prior_places: f64,
    /// Places from which on any layout is fitted.
    pub places_least: usize,
    /// Pairs that are together less often have no relation (ADSE §4.2: 0.5).
    pub together_least: f64,
    /// Instances of its type that must show an object: one alone is chance.
    pub seen_least: usize,
    /// Smallest standard deviation of ln distance.
    pub sigma_least: f64,
    /// Mixtures of directions.
    pub mixture: MixtureConfig,
}

impl Default for ModelConfig {
    fn default() -> Self {
        Self {
            occurrence_least: 0.1,
            prior_instances: 5.0,
            node_least: 8,
            own_places: 15,
            prior_places: 15.0,
            places_least: 4,
            together_least: 0.5,
            seen_least: 2,
            sigma_least: 0.15,
            mixture: MixtureConfig::default(),
        }
    }
}

/// Pieces of one kind beyond which counts are one.
pub const MOST_PIECES: usize = 6;
/// Things farther off than this many torsos belong to the room, unless the action needs them or somebody uses them.
const REACH: f64 = 5.0;
/// Of one kind so many places are taken an instance, the nearest: a shelf of books is not thirty instances of reading.
const PLACES_EACH: usize = 2;
/// Nobody's thing is farther off, torsos: places beyond come from degenerate poses.
const FARTHEST: f64 = 12.0;

/// What makes a node.
pub type NodeKey = (ActionKind, KeyObject, KeyRelation, Posture);

/// The node that an instance is of.
pub fn node_key(instance: &Instance) -> NodeKey {
    (instance.kind, instance.key, instance.relation, instance.posture)
}

/// How many of each object an instance has within reach; what the action needs and what is used counts at any
/// distance.
pub fn counts(instance: &Instance, rules: &Rules) -> BTreeMap<String, usize> {
    let needed =
        |object: &str| rules.action(instance.kind).is_some_and(|r| r.requires.iter().any(|o| o == object));
    let mut counts = BTreeMap::new();
    for thing in &instance.things {
        if thing.used || needed(&thing.object) || thing.from_person.distance < REACH {
            let count: &mut usize = counts.entry(thing.object.clone()).or_default();
            *count = (*count + 1).min(MOST_PIECES);
        }
    }
    counts
}

/// The things of an instance whose places are learned: of each kind those in use, or the nearest.
pub fn placed(instance: &Instance) -> Vec<&PlacedThing> {
    let mut things: Vec<&PlacedThing> =
        instance.things.iter().filter(|t| t.from_person.distance < FARTHEST).collect();
    things.sort_by(|a, b| a.from_person.distance.total_cmp(&b.from_person.distance));
    let used: BTreeSet<&str> = things.iter().filter(|t| t.used).map(|t| t.object.as_str()).collect();
    let mut taken: BTreeMap<&str, usize> = BTreeMap::new();
    things.retain(|thing| {
        let count = taken.entry(&thing.object).or_default();
        let wanted = (thing.used || !used.contains(thing.object.as_str())) && *count < PLACES_EACH;
        *count += usize::from(wanted);
        wanted
    });
    things
}

/// Learns the model of instances. `metres_per_unit` turns their distances into metres.
pub fn build_model(
    found: &Found,
    rules: &Rules,
    config: &ModelConfig,
    metres_per_unit: f64,
    seed: Seed,
) -> ActionModel {
    let samples = Samples::of(&found.instances);
    let learner = Learner { samples, rules, config, metres_per_unit, seed, fitted: Mutex::default() };
    let grouped: Vec<_> = grouped(&found.instances, config.node_least).into_iter().collect();
    let mut nodes: Vec<ActionNode> =
        grouped.par_iter().with_max_len(1).map(|(key, members)| learner.node(*key, members)).collect();
    if let Some(node) = learner.group_node(&found.groups, &nodes) {
        nodes.push(node);
    }
    nodes.sort_by_key(|n| (n.kind, n.key, n.relation, n.posture));
    let photos: BTreeSet<&str> = found
        .instances
        .iter()
        .map(|i| i.photo.as_str())
        .chain(found.groups.iter().map(|g| g.photo.as_str()))
        .collect();
    let mut model = ActionModel { metres_per_unit, nodes, ..ActionModel::default() };
    model.provenance.images = photos.len();
    model
}

/// Instances by node, without nodes of too few; each type keeps its largest.
fn grouped(instances: &[Instance], least: usize) -> BTreeMap<NodeKey, Vec<&Instance>> {
    let mut nodes: BTreeMap<NodeKey, Vec<&Instance>> = BTreeMap::new();
    for instance in instances {
        nodes.entry(node_key(instance)).or_default().push(instance);
    }
    let mut largest: BTreeMap<ActionKind, usize> = BTreeMap::new();
    for (key, members) in &nodes {
        let most = largest.entry(key.0).or_default();
        *most = (*most).max(members.len());
    }
    nodes.retain(|key, members| members.len() >= least || members.len() == largest[&key.0]);
    nodes
}

/// Places of one object, or of one seen from another, with the node that each is from.
type Places = Vec<(NodeKey, PolarUnits)>;

/// All places and directions of all instances.
struct Samples<'a> {
    instances: &'a [Instance],
    objects: BTreeMap<String, Places>,
    pairs: BTreeMap<(String, String), Places>,
    key_angles: Places,
}

impl<'a> Samples<'a> {
    fn of(instances: &'a [Instance]) -> Self {
        let mut samples =
            Self { instances, objects: BTreeMap::new(), pairs: BTreeMap::new(), key_angles: Vec::new() };
        for instance in instances {
            let node = node_key(instance);
            let things = placed(instance);
            for (index, a) in things.iter().enumerate() {
                samples.objects.entry(a.object.clone()).or_default().push((node, a.from_person));
                for (_, b) in things.iter().enumerate().filter(|(other, _)| *other != index) {
                    let from = instance.frame.polar_from(a.pixel, b.pixel);
                    if from.distance > 0.0 && from.distance < FARTHEST {
                        let pair = (a.object.clone(), b.object.clone());
                        samples.pairs.entry(pair).or_default().push((node, from));
                    }
                }
            }
            samples.key_angles.extend(instance.key_seen.map(|seen| (node, seen)));
        }
        samples
    }
}

struct Learner<'a> {
    samples: Samples<'a>,
    rules: &'a Rules,
    config: &'a ModelConfig,
    metres_per_unit: f64,
    seed: Seed,
    /// Layouts by what they are of and whose places they rest on: many nodes share those of their type.
    fitted: Mutex<BTreeMap<String, Fitted>>,
}

/// A layout that whoever asks first fits, while others who ask for the same wait. Each has a seed of its own, so nothing
/// depends on who that is.
type Fitted = Arc<OnceLock<Option<PolarDensity>>>;

impl Learner<'_> {
    fn node(&self, key: NodeKey, members: &[&Instance]) -> ActionNode {
        let (kind, place, relation, posture) = key;
        let complete: Vec<&Instance> = members.iter().copied().filter(|i| i.complete).collect();
        let (occurrence, around_person) = self.objects(key, &complete);
        let between = self.pairs(key, &complete, &occurrence);
        let key_angle = (relation == KeyRelation::Around).then(|| self.key_angle(key));
        ActionNode {
            kind,
            key: place,
            relation,
            posture,
            instances: members.len(),
            complete_instances: complete.len(),
            key_angle: key_angle.flatten(),
            occurrence,
            around_person,
            between,
            group: None,
        }
    }

    /// C(o, n) and P(o, H) of the objects that occur often enough and have been seen often enough to be placed.
    fn objects(&self, key: NodeKey, complete: &[&Instance]) -> (Vec<Occurrence>, Vec<Placement>) {
        let of_kind: Vec<&Instance> = self.samples.instances.iter().filter(|i| i.kind == key.0).collect();
        let own: Vec<_> = complete.iter().map(|i| counts(i, self.rules)).collect();
        let typical: Vec<_> = of_kind.iter().filter(|i| i.complete).map(|i| counts(i, self.rules)).collect();
        let used: Vec<_> = of_kind.iter().map(|i| used_counts(i)).collect();
        let mut found: Vec<(Occurrence, Placement)> = Vec::new();
        for object in self.samples.objects.keys() {
            let seen =
                |lists: &[BTreeMap<String, usize>]| lists.iter().filter(|c| c.contains_key(object)).count();
            if seen(&typical).max(seen(&used)) < self.config.seen_least {
                continue;
            }
            let prior = shares(&used, object);
            let prior = shrunk(&typical, object, &prior, self.config.prior_instances);
            let probability = shrunk(&own, object, &prior, self.config.prior_instances);
            let occurrence = Occurrence { object: object.clone(), probability: trimmed(probability) };
            if occurrence.frequency() < self.config.occurrence_least {
                continue;
            }
            if let Some(density) = self.density(&self.samples.objects[object], key, object) {
                found.push((occurrence, Placement { object: object.clone(), density }));
            }
        }
        found.sort_by(|a, b| b.0.frequency().total_cmp(&a.0.frequency()));
        found.into_iter().unzip()
    }

    /// P(o, o') of the pairs that are together in enough complete instances.
    fn pairs(&self, key: NodeKey, complete: &[&Instance], objects: &[Occurrence]) -> Vec<PairPlacement> {
        let of_kind: Vec<&Instance> =
            self.samples.instances.iter().filter(|i| i.kind == key.0 && i.complete).collect();
        let mut found = Vec::new();
        for ((object, reference), places) in &self.samples.pairs {
            let known = |name: &str| objects.iter().any(|o| o.object == name);
            if !known(object) || !known(reference) {
                continue;
            }
            let both = |list: &[&Instance]| {
                list.iter().filter(|i| has_both(&counts(i, self.rules), object, reference)).count() as f64
            };
            let (prior, alpha) = (both(&of_kind) / of_kind.len().max(1) as f64, self.config.prior_instances);
            let together = (both(complete) + alpha * prior) / (complete.len() as f64 + alpha);
            if together < self.config.together_least {
                continue;
            }
            if let Some(density) = self.density(places, key, &format!("{object} from {reference}")) {
                let (object, reference) = (object.clone(), reference.clone());
                found.push(PairPlacement { object, reference, together, density });
            }
        }
        found
    }

    /// The layout of places: of the node's own, leaning on its type's where they are few, and that on everybody's.
    fn density(&self, places: &Places, key: NodeKey, what: &str) -> Option<PolarDensity> {
        let levels = [
            (places.iter().map(|(_, p)| *p).collect(), Evidence::Everything, 0),
            (of_kind(places, key.0), Evidence::Action, key.0 as u64),
            (of_node(places, key), Evidence::Node, key_number(key)),
        ];
        let mut density: Option<PolarDensity> = None;
        for (chosen, evidence, number) in levels {
            // Without leaning only what is enough by itself counts.
            let least = if self.config.prior_places > 0.0 { 2 } else { self.config.own_places };
            if chosen.len() < if density.is_some() { least } else { self.config.places_least } {
                continue;
            }
            let own = self.fitted(&chosen, evidence, &format!("{what}, {evidence:?} {number}"))?;
            density = Some(match density {
                Some(wider) => self.leaning(&own, &wider),
                None => own,
            });
        }
        density
    }

    /// The layout of places alone, fitted once.
    fn fitted(&self, places: &[PolarUnits], evidence: Evidence, name: &str) -> Option<PolarDensity> {
        let fitted: Fitted = {
            let mut known = self.fitted.lock().unwrap_or_else(PoisonError::into_inner);
            known.entry(name.to_owned()).or_default().clone()
        };
        let fit = || {
            let seed = self.seed.child(name, 0);
            fit_density(places, evidence, self.config, self.metres_per_unit, seed)
        };
        fitted.get_or_init(fit).clone()
    }

    /// A layout of few places with the wider one as its prior, which weighs as much as `prior_places` of them. Told as
    /// the wider one's until its own places are enough.
    fn leaning(&self, own: &PolarDensity, wider: &PolarDensity) -> PolarDensity {
        let share = own.samples as f64 / (own.samples as f64 + self.config.prior_places);
        let (a, b) = (own.distance_m, wider.distance_m);
        let apart = a.mu - b.mu;
        let variance = share * a.sigma * a.sigma
            + (1.0 - share) * b.sigma * b.sigma
            + share * (1.0 - share) * apart * apart;
        let told = if own.samples >= self.config.own_places { own } else { wider };
        PolarDensity {
            distance_m: LogNormal { mu: share * a.mu + (1.0 - share) * b.mu, sigma: variance.sqrt() },
            direction: own.direction.mixed(&wider.direction, share, self.config.mixture.most_components),
            samples: told.samples,
            evidence: told.evidence,
        }
    }

    /// P(H, K) of the node's own angles where they are enough, else of its type's, else of all.
    fn key_angle(&self, key: NodeKey) -> Option<VonMises> {
        let places = &self.samples.key_angles;
        let all = || places.iter().map(|(_, p)| *p).collect::<Vec<_>>();
        let enough = |list: &Vec<PolarUnits>| list.len() >= self.config.own_places;
        let same_key =
            || places.iter().filter(|(n, _)| n.1 == key.1 && n.2 == key.2).map(|(_, p)| *p).collect();
        let chosen = [of_node(places, key), of_kind(places, key.0), same_key(), all()];
        let chosen = chosen.iter().find(|list| enough(list)).or(chosen.last())?;
        let angles: Vec<f64> = chosen.iter().map(|p| p.angle_rad).collect();
        (!angles.is_empty()).then(|| VonMises::fit(&angles, self.config.mixture.most_kappa))
    }

    /// The group's node: everybody does what one at dinner does, and all share what stands between them.
    fn group_node(&self, groups: &[Group], nodes: &[ActionNode]) -> Option<ActionNode> {
        let at_table = |n: &&ActionNode| {
            n.kind == ActionKind::EatDinner && n.key == KeyObject::DiningTable && n.posture == Posture::Sit
        };
        let single = nodes.iter().find(at_table)?;
        let group = self.group_model(groups)?;
        Some(ActionNode {
            kind: ActionKind::EatDinnerInGroup,
            instances: groups.iter().map(|g| g.people.len()).sum(),
            complete_instances: groups.iter().filter(|g| g.complete).map(|g| g.people.len()).sum(),
            group: Some(group),
            ..single.clone()
        })
    }

    fn group_model(&self, groups: &[Group]) -> Option<GroupModel> {
        let complete: Vec<BTreeMap<String, usize>> =
            groups.iter().filter(|g| g.complete).map(shared_counts).collect();
        if groups.is_empty() {
            return None;
        }
        let names: BTreeSet<&String> = complete.iter().flat_map(BTreeMap::keys).collect();
        let occurrence = |object: &&String| Occurrence {
            object: (*object).clone(),
            probability: trimmed(shares(&complete, object)),
        };
        let mut shared: Vec<Occurrence> = names.iter().map(occurrence).collect();
        shared.retain(|o| o.frequency() >= self.config.occurrence_least);
        shared.sort_by(|a, b| b.frequency().total_cmp(&a.frequency()));
        let share = |size: usize| {
            groups.iter().filter(|g| g.people.len() == size).count() as f64 / groups.len() as f64
        };
        Some(GroupModel {
            sizes: (2..=4).map(|size| (size, share(size))).collect(),
            shared,
            people_apart_m: PEOPLE_APART_M,
            groups: groups.len(),
        })
    }
}

/// The layout of places in metres; `None` without places.
pub fn fit_density(
    places: &[PolarUnits],
    evidence: Evidence,
    config: &ModelConfig,
    metres_per_unit: f64,
    seed: Seed,
) -> Option<PolarDensity> {
    let distances: Vec<f64> = places.iter().map(|p| p.distance).collect();
    let angles: Vec<f64> = places.iter().map(|p| p.angle_rad).collect();
    Some(PolarDensity {
        distance_m: LogNormal::fit(&distances, config.sigma_least)?.scaled(metres_per_unit),
        direction: VonMisesMixture::fit(&angles, &config.mixture, seed.value()),
        samples: places.len(),
        evidence,
    })
}

fn of_node(places: &Places, key: NodeKey) -> Vec<PolarUnits> {
    places.iter().filter(|(node, _)| *node == key).map(|(_, p)| *p).collect()
}

fn of_kind(places: &Places, kind: ActionKind) -> Vec<PolarUnits> {
    places.iter().filter(|(node, _)| node.0 == kind).map(|(_, p)| *p).collect()
}

/// Of the things of a group those that eq. 6 calls shared, counted by kind.
fn shared_counts(group: &Group) -> BTreeMap<String, usize> {
    let spread = group.people_apart.iter().copied().fold(0.0, f64::max) as f32;
    let mut counts = BTreeMap::new();
    for (object, distances) in &group.things {
        let distances: Vec<f32> = distances.iter().map(|d| *d as f32).collect();
        if is_shared(&distances, spread) {
            let count: &mut usize = counts.entry(object.clone()).or_default();
            *count = (*count + 1).min(MOST_PIECES);
        }
    }
    counts
}

fn used_counts(instance: &Instance) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for thing in instance.things.iter().filter(|t| t.used) {
        let count: &mut usize = counts.entry(thing.object.clone()).or_default();
        *count = (*count + 1).min(MOST_PIECES);
    }
    counts
}

/// N(o, n) / N_a.
fn shares(lists: &[BTreeMap<String, usize>], object: &str) -> Vec<f64> {
    shrunk(lists, object, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.0)
}

/// (N(o, n) + α prior(n)) / (N_a + α); the prior itself without instances.
fn shrunk(lists: &[BTreeMap<String, usize>], object: &str, prior: &[f64], alpha: f64) -> Vec<f64> {
    if lists.is_empty() {
        return prior.to_vec();
    }
    let mut numbers: Vec<f64> =
        (0..=MOST_PIECES).map(|n| alpha * prior.get(n).copied().unwrap_or(0.0)).collect();
    for counts in lists {
        numbers[counts.get(object).copied().unwrap_or(0)] += 1.0;
    }
    let total = lists.len() as f64 + alpha;
    numbers.iter().map(|n| n / total).collect()
}

/// Without the empty end.
fn trimmed(mut probability: Vec<f64>) -> Vec<f64> {
    while probability.len() > 1 && probability.last() == Some(&0.0) {
        probability.pop();
    }
    probability
}

fn has_both(counts: &BTreeMap<String, usize>, a: &str, b: &str) -> bool {
    if a == b {
        counts.get(a).is_some_and(|n| *n > 1)
    } else {
        counts.contains_key(a) && counts.contains_key(b)
    }
}

/// A number for the seed of a node's fits.
fn key_number((kind, key, relation, posture): NodeKey) -> u64 {
    ((kind as u64 * 8 + key as u64) * 2 + relation as u64) * 8 + posture as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(numbers: &[usize]) -> Vec<BTreeMap<String, usize>> {
        numbers
            .iter()
            .map(|n| if *n > 0 { BTreeMap::from([("cup".to_owned(), *n)]) } else { BTreeMap::new() })
            .collect()
    }

    #[test]
    fn occurrence_is_counted_and_few_instances_lean_on_the_prior() {
        assert_eq!(trimmed(shares(&counted(&[0, 1, 1, 2]), "cup")), [0.25, 0.5, 0.25]);
        let prior = [0.0, 1.0];
        let one = shrunk(&counted(&[0]), "cup", &prior, 5.0);
        assert!((one[1] - 5.0 / 6.0).abs() < 1e-12 && (one.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let many = shrunk(&counted(&[0; 100]), "cup", &prior, 5.0);
        assert!(many[1] < 0.05);
        assert_eq!(shrunk(&[], "cup", &prior, 5.0), prior);
    }

    #[test]
    fn pairs_of_one_kind_need_two_pieces() {
        let cups = |n| BTreeMap::from([("cup".to_owned(), n), ("fork".to_owned(), 1)]);
        assert!(has_both(&cups(1), "cup", "fork") && !has_both(&cups(1), "cup", "cup"));
        assert!(has_both(&cups(2), "cup", "cup"));
    }
}
