//! A room after some actions, as a value: suggestions, the next action, undo and branches by keeping values.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

use rand::seq::SliceRandom as _;

use super::furnish;
use super::library::Library;
use super::perform::Performance;
use super::spot::PlacedPerson;
use super::stage::Stage;
use super::step::{EvolutionStep, Inserted, MoveReason, Moved, StepPerson};
use super::world::{Held, Item, World};
use crate::evolve::action::{
    ActionGraph, ActionKind, ActionModel, ActionNode, KeyObject, KeyRelation, Posture,
};
use crate::job::Seed;
use crate::scene::{ObjectId, PoseFamily, Room};

/// Key objects of one kind that are tried before the action is said to be impossible.
const KEYS_TRIED: usize = 4;

/// How people of a group use what they share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GroupMode {
    /// ADSE §5.3: shared things stand where all can reach them.
    #[default]
    Shared,
    /// The baseline of ADSE fig. 8: shared things are dealt out at random, as if each were somebody's own.
    Baseline,
}

/// What the user decides about an evolution.
#[derive(Clone, Debug, Default)]
pub struct EvolutionConfig {
    /// Only these types of action; all when empty.
    pub only: Vec<ActionKind>,
    /// Kinds that are never brought or used.
    pub banned: BTreeSet<String>,
    /// Things that the photos have no word for (plates, paper) come too.
    pub companions: bool,
    /// How groups share.
    pub group: GroupMode,
    /// So many people in a group; drawn when `None`.
    pub group_size: Option<usize>,
    /// Another library than the stage's: other bounds, own models.
    pub library: Option<Arc<Library>>,
}

impl EvolutionConfig {
    /// What the program starts with: everything allowed, companions too.
    pub fn usual() -> Self {
        Self { companions: true, ..Self::default() }
    }
}

/// An action that can be next.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestion {
    /// Number of its node in the model.
    pub node: usize,
    /// "use laptop on desk while sitting".
    pub action: String,
    /// Probability of it being next (§4.3, re-normalised over what is possible here).
    pub probability: f64,
    /// Where it can happen.
    pub keys: Vec<ObjectId>,
}

/// An action that this room does not allow.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Off {
    /// Number of its node in the model.
    pub node: usize,
    /// Its label.
    pub action: String,
    /// Why, for people.
    pub why: String,
}

/// An action that could not be done; nothing was changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{action}\" is not possible here: {why}")]
pub struct NotPossible {
    /// Its label.
    pub action: String,
    /// Why, for people.
    pub why: String,
}

/// A room after some actions. Cheap to clone: keep earlier values to undo, apply different actions to copies to
/// branch.
#[derive(Clone)]
pub struct Evolution {
    stage: Arc<Stage>,
    model: Arc<ActionModel>,
    graph: Arc<ActionGraph>,
    off: Arc<Vec<Off>>,
    config: Arc<EvolutionConfig>,
    seed: Seed,
    world: World,
    steps: Vec<Arc<EvolutionStep>>,
}

impl Evolution {
    /// The room as it was found (ADSE §5.1: actions that it does not allow are off, weights re-normalised).
    pub fn new(stage: Arc<Stage>, model: Arc<ActionModel>, config: EvolutionConfig, seed: Seed) -> Self {
        let off: Vec<Off> = model
            .nodes
            .iter()
            .enumerate()
            .filter_map(|(node, spec)| {
                let why = why_off(spec, &stage, &config)?;
                Some(Off { node, action: spec.label(), why })
            })
            .collect();
        let on: Vec<bool> = (0..model.nodes.len()).map(|n| off.iter().all(|o| o.node != n)).collect();
        let graph = Arc::new(ActionGraph::adapted(&model.nodes, &on));
        let world = World::new(stage.clone());
        Self {
            stage,
            model,
            graph,
            off: Arc::new(off),
            config: Arc::new(config),
            seed,
            world,
            steps: Vec::new(),
        }
    }

    /// What can be done next, most probable first.
    pub fn suggestions(&self) -> Vec<Suggestion> {
        let last = self.steps.last().map(|s| s.node);
        let suggest = |(node, probability): (usize, f64)| {
            let spec = &self.model.nodes[node];
            let keys = self.stage.keys.get(&spec.key).cloned().unwrap_or_default();
            Suggestion { node, action: spec.label(), probability, keys }
        };
        self.graph.successors(last).into_iter().map(suggest).collect()
    }

    /// What this room does not allow, and why.
    pub fn off(&self) -> &[Off] {
        &self.off
    }

    /// The action that the chain draws next; `None` when nothing can be done here.
    pub fn draw_next(&self) -> Option<usize> {
        self.draw_next_after(0)
    }

    /// Another draw, after `refused` earlier ones that were not possible.
    pub fn draw_next_after(&self, refused: u64) -> Option<usize> {
        let seed = self.seed.child("next", self.steps.len() as u64).child("draw", refused);
        self.graph.draw(self.steps.last().map(|s| s.node), &mut seed.rng())
    }

    /// The room after one more action. `roll` above 0 gives another outcome of the same action.
    ///
    /// # Errors
    /// [`NotPossible`]; this value stays as it is.
    pub fn apply(&self, node: usize, roll: u64) -> Result<Self, NotPossible> {
        let spec = &self.model.nodes[node];
        let keys = self.stage.keys.get(&spec.key).cloned().unwrap_or_default();
        self.apply_at(node, &keys, roll)
    }

    /// As [`Evolution::apply`], at one of these key objects only.
    ///
    /// # Errors
    /// [`NotPossible`]; this value stays as it is.
    pub fn apply_at(&self, node: usize, keys: &[ObjectId], roll: u64) -> Result<Self, NotPossible> {
        let started = Instant::now();
        let spec = &self.model.nodes[node];
        let refuse = |why: String| NotPossible { action: spec.label(), why };
        if let Some(off) = self.off.iter().find(|o| o.node == node) {
            return Err(refuse(off.why.clone()));
        }
        let number = self.steps.len() + 1;
        let seed = self.seed_of(number).child("roll", roll);
        let mut keys = keys.to_vec();
        keys.shuffle(&mut seed.child("key", 0).rng());
        let mut why = format!("there is no {} here", spec.key.label());
        for key in keys.into_iter().take(KEYS_TRIED) {
            let mut performance = Performance::new(&self.world, spec, key, number, &self.config);
            match performance.run(seed.child("at", u64::from(key.0))) {
                Ok(()) => {
                    let step = self.record(node, performance, started);
                    return Ok(step);
                }
                Err(reason) => why = reason,
            }
        }
        Err(refuse(why))
    }

    /// The next value: the performance's world, and the step that tells what it changed.
    fn record(&self, node: usize, performance: Performance<'_>, started: Instant) -> Self {
        let spec = &self.model.nodes[node];
        let Performance {
            world,
            key,
            number,
            people,
            chairs,
            reasons,
            owners,
            used,
            shared,
            failed,
            candidates,
            zone,
            ..
        } = performance;
        let person = |(person, chair): (&PlacedPerson, &Option<ObjectId>)| StepPerson {
            family: person.figure.family,
            body: person.params(),
            spot: person.spot.clone(),
            frame: person.frame,
            on: person.on.clone(),
            chair: *chair,
            place: person.place.clone(),
        };
        let people = people.iter().zip(&chairs).map(person).collect();
        let before = |item: &Item| self.world.item(item.id).map(|i| i.pose);
        let on = |item: &Item| name_of_support(&world, item);
        let (mut inserted, mut moved) = (Vec::new(), Vec::new());
        for item in world.items() {
            match before(item) {
                None => inserted.push(Inserted {
                    id: item.id,
                    name: item.name.clone(),
                    kind: item.kind.map(|k| self.library().kind(k).kind.clone()).unwrap_or_default(),
                    pose: item.pose,
                    on: on(item),
                    person: owners.get(&item.id).copied().flatten(),
                }),
                Some(from) if from != item.pose => moved.push(Moved {
                    id: item.id,
                    name: item.name.clone(),
                    from,
                    to: item.pose,
                    why: reasons.get(&item.id).copied().unwrap_or(MoveReason::InTheWay),
                    on: on(item),
                }),
                Some(_) => {}
            }
        }
        let step = EvolutionStep {
            number,
            node,
            kind: spec.kind,
            action: spec.label(),
            key,
            key_name: self.stage.name_of(key),
            people,
            inserted,
            moved,
            used,
            shared,
            failed,
            zone,
            candidates,
            seconds: started.elapsed().as_secs_f64(),
        };
        let mut steps = self.steps.clone();
        steps.push(Arc::new(step));
        Self {
            stage: self.stage.clone(),
            model: self.model.clone(),
            graph: self.graph.clone(),
            off: self.off.clone(),
            config: self.config.clone(),
            seed: self.seed,
            world,
            steps,
        }
    }

    /// Seed of step `number`, from 1.
    pub fn seed_of(&self, number: usize) -> Seed {
        self.seed.child("step", number as u64)
    }

    /// What was done so far.
    pub fn steps(&self) -> &[Arc<EvolutionStep>] {
        &self.steps
    }

    /// Where everything movable is.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// What stays of the room.
    pub fn stage(&self) -> &Arc<Stage> {
        &self.stage
    }

    /// What people do.
    pub fn model(&self) -> &Arc<ActionModel> {
        &self.model
    }

    /// What things there are.
    pub fn library(&self) -> &Arc<Library> {
        self.config.library.as_ref().unwrap_or(&self.stage.library)
    }

    /// Locks a thing where it is, or frees it.
    pub fn lock(&mut self, id: ObjectId, locked: bool) {
        self.world.lock(id, locked);
    }

    /// What the user decided.
    pub fn config(&self) -> &EvolutionConfig {
        &self.config
    }

    /// Other decisions of the user from here on.
    #[must_use]
    pub fn with_config(&self, config: EvolutionConfig) -> Self {
        let fresh = Self::new(self.stage.clone(), self.model.clone(), config, self.seed);
        Self { world: self.world.clone(), steps: self.steps.clone(), ..fresh }
    }

    /// The room as it is now: the objects it had, moved, then those that were brought.
    pub fn room(&self) -> Room {
        furnish::room(&self.stage, &self.world, self.library())
    }
}

/// Name of what a thing stands on.
fn name_of_support(world: &World, item: &Item) -> String {
    match item.held {
        Held::Surface(number) => {
            let owner = world.stage.surfaces.get(number).and_then(|s| s.owner);
            owner.map_or_else(|| "floor".to_owned(), |id| world.stage.name_of(id))
        }
        Held::Item(id) => world.item(id).map_or_else(String::new, |i| i.name.clone()),
        Held::AsFound => "as it was found".to_owned(),
    }
}

/// Why an action is off in a room (§5.1); `None` when it is on.
fn why_off(node: &ActionNode, stage: &Stage, config: &EvolutionConfig) -> Option<String> {
    if !config.only.is_empty() && !config.only.contains(&node.kind) {
        return Some("its type was left out".to_owned());
    }
    let keys = stage.keys.get(&node.key).cloned().unwrap_or_default();
    if keys.is_empty() {
        return Some(format!("there is no {} here", node.key.label()));
    }
    let is_table = !matches!(node.key, KeyObject::Bed | KeyObject::Couch);
    // Photos have people who stand somewhere near a couch; that says nothing about where, nor where they look.
    if node.posture == Posture::Stand && !is_table {
        return Some(format!("a {} is nothing to stand at", node.key.label()));
    }
    let on_chair_or_feet = match node.posture {
        Posture::Stand => true,
        Posture::Sit | Posture::SitStraight => is_table,
        Posture::LieUp | Posture::LieDown => false,
    };
    if node.relation == KeyRelation::Around && on_chair_or_feet {
        return None;
    }
    let fits = |family: PoseFamily| match node.posture {
        Posture::LieUp => family == PoseFamily::LieUp,
        Posture::LieDown => family == PoseFamily::LieDown,
        Posture::SitStraight => family == PoseFamily::SitStraight,
        Posture::Sit => family.group() == "sit" && family != PoseFamily::SitStraight,
        Posture::Stand => false,
    };
    let on_key = |support: Option<usize>| {
        let owner = support.and_then(|i| stage.geometry.supports.get(i)).and_then(|s| s.object);
        owner.is_some_and(|id| keys.contains(&id))
    };
    let there = stage.places.iter().any(|p| fits(p.family) && on_key(p.support));
    (!there).then(|| format!("nobody can be {} on the {} here", node.posture.label(), node.key.label()))
}
