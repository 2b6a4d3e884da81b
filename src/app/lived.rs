//! A room that gets lived in, as the window sees it: what can be done next, what an action did, in words and marks.
//! Behind a trait, so that tests can put a small room in its place.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::document::OwnThing;
use crate::evolve::action::ActionKind;
use crate::evolve::action::ActionModel;
use crate::evolve::action::Evolution;
use crate::evolve::action::EvolutionConfig;
use crate::evolve::action::EvolutionStep;
use crate::evolve::action::GroupMode;
use crate::evolve::action::Library;
use crate::evolve::action::Off;
use crate::evolve::action::Stage;
use crate::evolve::action::StepPerson;
use crate::evolve::action::Suggestion;
use crate::evolve::action::Verdict;
use crate::evolve::action::embody;
use crate::evolve::day::{Day, DayRequest, Moment, Track, day};
use crate::inspect::BodyReport;
use crate::job::{Cancelled, JobCtx, Seed, Stop, Ticker};
use crate::scene::Clip;
use crate::scene::ObjectId;
use crate::scene::Person;
use crate::scene::PersonId;
use crate::scene::Room;

/// What the user decides about the actions of a room.
#[derive(Clone, Debug)]
pub struct ActionChoice {
    /// Only these types; all when empty.
    pub only: Vec<ActionKind>,
    /// Kinds of things that are never brought or used.
    pub banned: Vec<String>,
    /// Things that photos have no word for (plates, paper) come too.
    pub companions: bool,
    /// So many people in a group; drawn when `None`.
    pub group_size: Option<usize>,
    /// Groups share as the baseline of ADSE fig. 8 does: at random.
    pub baseline: bool,
    /// How many of these kinds a room takes, where that is not the library's number.
    pub most: BTreeMap<String, usize>,
    /// Models of the user's own.
    pub own: Vec<Arc<OwnThing>>,
}

impl Default for ActionChoice {
    fn default() -> Self {
        Self {
            only: Vec::new(),
            banned: Vec::new(),
            companions: true,
            group_size: None,
            baseline: false,
            most: BTreeMap::new(),
            own: Vec::new(),
        }
    }
}

/// A place that was tried for a thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// The thing.
    pub object: String,
    /// Where.
    pub at: Vec3,
    /// What became of it.
    pub verdict: Verdict,
    /// How good it would have been.
    pub score: f32,
}

/// Something that an action brought or moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Touched {
    /// Its number in the room.
    pub id: ObjectId,
    /// "chair moved 31 cm: somebody sits on it".
    pub line: String,
    /// Its kind, by which it can be banned; empty for what was there from the beginning.
    pub kind: String,
}

/// What one action did, for people.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ActionStep {
    /// Number of its node in the model.
    pub node: usize,
    /// "use laptop on desk while sitting".
    pub action: String,
    /// Where it happened.
    pub key: Option<ObjectId>,
    /// What came and what moved, and why.
    pub touched: Vec<Touched>,
    /// What it wanted and did not get, and why.
    pub failed: Vec<String>,
    /// The places that were tried.
    pub marks: Vec<Mark>,
    /// The working zone: its plan (x, z), and the height of what is worked on.
    pub zone: (Vec<Vec2>, f32),
}

/// A day in a room: one person's motion, and how the room changes on the way.
#[derive(Clone)]
pub struct LivedDay {
    /// The motion; its numbers mean nothing.
    pub clip: Clip,
    /// The room after each action.
    pub states: Vec<Arc<dyn LivedRoom>>,
    /// What was done when, one for each state.
    pub moments: Vec<Moment>,
    /// How things come and move, in the last state's room.
    pub tracks: Vec<Track>,
    /// Actions that could not be done or walked to, and why.
    pub refused: Vec<String>,
}

/// A room after some actions, as a value.
pub trait LivedRoom: Send + Sync {
    /// What can be done next, the most probable first.
    fn suggestions(&self) -> Vec<Suggestion>;
    /// What this room does not allow, and why.
    fn off(&self) -> Vec<Off>;
    /// The action that the chain draws next, after so many draws that were not possible.
    fn draw_next(&self, refused: u64) -> Option<usize>;
    /// The room after one more action; `roll` above 0 gives another outcome of it.
    ///
    /// # Errors
    /// Why it is not possible here.
    fn apply(&self, node: usize, roll: u64) -> Result<Arc<dyn LivedRoom>, Stop>;
    /// The same room under other decisions and locks.
    fn decided(&self, choice: &ActionChoice, locked: &[ObjectId]) -> Arc<dyn LivedRoom>;
    /// What was done last.
    fn last_step(&self) -> Option<ActionStep>;
    /// How many actions there were.
    fn step_count(&self) -> usize;
    /// The room to draw and to save.
    fn room(&self) -> Room;
    /// Who is at the last action, numbered from `first_id`: as representative bodies.
    fn people(&self, first_id: u32) -> Vec<Person>;
    /// The same, fitted to the room: a second or two for each.
    ///
    /// # Errors
    /// Cancelled.
    fn fitted_people(&self, first_id: u32, ticker: &Ticker) -> Result<Vec<(Person, BodyReport)>, Cancelled>;
    /// Somebody goes from action to action, so many of them, from this room on; previews are the day so far.
    ///
    /// # Errors
    /// Why nothing can be done or walked to; or cancelled.
    fn day(&self, actions: usize, cx: &JobCtx<LivedDay>) -> Result<LivedDay, Stop>;
}

/// The room as it really is.
struct Real(Evolution);

/// Looks at a room: what could be done in it.
///
/// # Errors
/// When the bundled actions can't be read; or cancelled.
pub fn look_at(
    room: &Arc<Room>,
    choice: &ActionChoice,
    seed: u64,
    ticker: &Ticker,
) -> Result<Arc<dyn LivedRoom>, Stop> {
    let model = ActionModel::bundled()?;
    let stage = Stage::new(room.clone(), Library::bundled(), ticker)?;
    Ok(Arc::new(Real(Evolution::new(Arc::new(stage), model, config(choice), Seed::root(seed)))))
}

fn config(choice: &ActionChoice) -> EvolutionConfig {
    EvolutionConfig {
        only: choice.only.clone(),
        banned: choice.banned.iter().cloned().collect(),
        companions: choice.companions,
        group: if choice.baseline { GroupMode::Baseline } else { GroupMode::Shared },
        group_size: choice.group_size,
        library: library(choice),
        ..EvolutionConfig::usual()
    }
}

/// The bundled library with other bounds and the user's own models; `None` where it is as it is bundled.
fn library(choice: &ActionChoice) -> Option<Arc<Library>> {
    if choice.most.is_empty() && choice.own.is_empty() {
        return None;
    }
    let mut library = (*Library::bundled()).clone();
    for (kind, most) in &choice.most {
        if let Some(id) = library.named(kind) {
            library.set_most(id, *most);
        }
    }
    for thing in &choice.own {
        if let Some(id) = library.named(&thing.kind) {
            library.add_model(id, &thing.name, thing.model.clone());
        }
    }
    Some(Arc::new(library))
}

impl LivedRoom for Real {
    fn suggestions(&self) -> Vec<Suggestion> {
        self.0.suggestions()
    }

    fn off(&self) -> Vec<Off> {
        self.0.off().to_vec()
    }

    fn draw_next(&self, refused: u64) -> Option<usize> {
        self.0.draw_next_after(refused)
    }

    fn apply(&self, node: usize, roll: u64) -> Result<Arc<dyn LivedRoom>, Stop> {
        Ok(Arc::new(Self(self.0.apply(node, roll)?)))
    }

    fn decided(&self, choice: &ActionChoice, locked: &[ObjectId]) -> Arc<dyn LivedRoom> {
        let mut evolution = self.0.with_config(config(choice));
        for object in &evolution.room().objects {
            evolution.lock(object.id, locked.contains(&object.id));
        }
        Arc::new(Self(evolution))
    }

    fn last_step(&self) -> Option<ActionStep> {
        self.0.steps().last().map(|step| told(step))
    }

    fn step_count(&self) -> usize {
        self.0.steps().len()
    }

    fn room(&self) -> Room {
        self.0.room()
    }

    fn people(&self, first_id: u32) -> Vec<Person> {
        let Some(step) = self.0.steps().last() else { return Vec::new() };
        let number = |i: usize| first_id + i as u32;
        step.people.iter().enumerate().map(|(i, person)| representative(person, number(i))).collect()
    }

    fn fitted_people(&self, first_id: u32, ticker: &Ticker) -> Result<Vec<(Person, BodyReport)>, Cancelled> {
        let embodied = embody(&self.0, first_id, ticker)?;
        Ok(embodied.into_iter().map(|one| (one.person, one.report)).collect())
    }

    fn day(&self, actions: usize, cx: &JobCtx<LivedDay>) -> Result<LivedDay, Stop> {
        let request = DayRequest { actions, ..DayRequest::default() };
        Ok(of_day(day(&self.0, &request, &cx.mapped(of_day))?))
    }
}

fn of_day(made: Day) -> LivedDay {
    let state = |state| Arc::new(Real(state)) as Arc<dyn LivedRoom>;
    LivedDay {
        tracks: made.tracks(),
        clip: made.clip,
        states: made.states.into_iter().skip(1).map(state).collect(),
        moments: made.moments,
        refused: made.refused,
    }
}

fn representative(person: &StepPerson, id: u32) -> Person {
    Person {
        id: PersonId(id),
        name: format!("Person {}", id + 1),
        body: person.body.clone(),
        family: person.family,
        on: person.on.clone(),
        seed: 0,
        palette: id,
        visible: true,
        locked: false,
    }
}

/// A step in words.
fn told(step: &EvolutionStep) -> ActionStep {
    let inserted = step.inserted.iter().map(|new| Touched {
        id: new.id,
        line: format!("{} came, on {}", new.name, new.on),
        kind: new.kind.clone(),
    });
    let moved = step.moved.iter().map(|thing| {
        let far_cm = 100.0 * thing.distance_m();
        Touched {
            id: thing.id,
            line: format!("{} moved {far_cm:.0} cm: {}", thing.name, thing.why.label()),
            kind: String::new(),
        }
    });
    let marks = step.candidates.iter().flat_map(|of| {
        of.samples.iter().map(|sample| Mark {
            object: of.object.clone(),
            at: sample.at,
            verdict: sample.verdict,
            score: sample.score,
        })
    });
    ActionStep {
        node: step.node,
        action: step.action.clone(),
        key: Some(step.key),
        touched: inserted.chain(moved).collect(),
        failed: step.failed.iter().map(|f| format!("no {}: {}", f.object, f.why)).collect(),
        marks: marks.collect(),
        zone: (step.zone.hull.clone(), step.zone.low_m),
    }
}
