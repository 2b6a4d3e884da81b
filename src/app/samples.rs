//! People sampled from a view: the contact sheet of candidates, and what became of those that were accepted.
//! A candidate is nobody yet: the document knows only who was accepted and fitted.

use std::sync::Arc;

use super::engine::{Candidate, FitTask, SampleMethod, SampleTask, SampleView, Sampled};
use super::pictures::Shown;
use super::state::EditorState;
use crate::document::RoomVersion;
use crate::evolve::PopulatePreview;
use crate::generate::sensor::SceneImage;
use crate::inspect::Finding;
use crate::inspect::Limits;
use crate::inspect::Site;
use crate::job::{Job, JobCtx, Seed};
use crate::render::Picture;
use crate::scene::BodyParams;
use crate::scene::Person;
use crate::scene::PersonId;

/// From where the next samples are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewFrom {
    /// What the editor shows now.
    #[default]
    Here,
    /// Somebody who stands in the room.
    Agent,
}

/// What is sampled next.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleOptions {
    /// By what.
    pub method: SampleMethod,
    /// From where.
    pub from: ViewFrom,
    /// How many.
    pub count: usize,
    /// Root of the seed tree.
    pub seed: u64,
}

impl Default for SampleOptions {
    fn default() -> Self {
        Self { method: SampleMethod::Search, from: ViewFrom::Here, count: 12, seed: 1 }
    }
}

/// One candidate on the contact sheet.
#[derive(Debug)]
pub struct Card {
    /// Never used again.
    pub key: u64,
    /// Who.
    pub person: Person,
    /// What is above its limit as sampled, before any fit.
    pub findings: Vec<Finding>,
    /// How deep it sinks in as sampled, millimetres.
    pub penetration_mm: f32,
    /// Small picture, once it is drawn.
    pub picture: Option<Shown>,
    /// Re-rolls leave it alone.
    pub locked: bool,
    /// Where it stands.
    pub fate: Fate,
}

/// What became of a candidate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fate {
    /// Nobody has decided.
    #[default]
    Open,
    /// Is being fitted.
    Fitting,
    /// Is in the room.
    Accepted,
}

/// What a person was before it was fitted, and what the sampler saw.
#[derive(Clone, Debug)]
pub struct Origin {
    /// By what it was sampled.
    pub method: SampleMethod,
    /// The image that the sampler got; the search looks at the room itself.
    pub seen: Option<Arc<Seen>>,
    /// The body before the fit.
    pub before: BodyParams,
}

/// An image and its pictures.
#[derive(Debug)]
pub struct Seen {
    /// The image.
    pub image: SceneImage,
    /// Its depth to look at.
    pub depth: Shown,
    /// Its labels to look at.
    pub labels: Shown,
}

impl Seen {
    /// With pictures of it.
    pub fn new(image: SceneImage) -> Self {
        let (depth, labels) = (Shown::of_depth(&image), Shown::of_labels(&image));
        Self { image, depth, labels }
    }
}

/// The contact sheet.
#[derive(Debug, Default)]
pub struct Sheet {
    /// What is sampled next.
    pub options: SampleOptions,
    /// The candidates, the best first.
    pub cards: Vec<Card>,
    /// The one that is shown in the view.
    pub chosen: Option<u64>,
    /// What the sampler saw.
    pub seen: Option<Arc<Seen>>,
    /// How the candidates were made.
    pub made_by: SampleMethod,
    /// From where.
    view: Option<SampleView>,
    version: Option<RoomVersion>,
    next_key: u64,
    /// Raised with every re-roll, so that each gives somebody new.
    rolls: u64,
}

impl Sheet {
    /// The card that is shown in the view.
    pub fn chosen_card(&self) -> Option<&Card> {
        self.cards.iter().find(|card| Some(card.key) == self.chosen)
    }

    /// Keys of the cards that nobody has decided about.
    pub fn open_cards(&self) -> impl Iterator<Item = u64> + '_ {
        self.cards.iter().filter(|card| card.fate == Fate::Open).map(|card| card.key)
    }

    fn card_mut(&mut self, key: u64) -> Option<&mut Card> {
        self.cards.iter_mut().find(|card| card.key == key)
    }

    /// How many have no findings as they are.
    pub fn faultless(&self) -> usize {
        self.cards.iter().filter(|card| card.findings.is_empty()).count()
    }
}

/// A sampling that runs.
pub(super) struct Sampling {
    pub job: Job<Sampled, PopulatePreview>,
    version: RoomVersion,
    /// Cards that get somebody new; empty for a new sheet.
    replacing: Vec<u64>,
    view: SampleView,
    method: SampleMethod,
}

/// Small pictures being drawn: those that are done so far.
pub(super) type Portraits = Job<(), Vec<(u64, Picture)>>;

impl EditorState {
    /// Starts to sample people from the view that the options name.
    pub fn start_sampling(&mut self) {
        let view = match self.sheet.options.from {
            ViewFrom::Here => SampleView::Camera(self.orbit.camera(), self.aspect),
            ViewFrom::Agent => SampleView::Agent,
        };
        let (count, seed) = (self.sheet.options.count, Seed::root(self.sheet.options.seed));
        self.sheet.rolls = 0;
        self.sample(view, self.sheet.options.method, count, seed, Vec::new());
    }

    /// Somebody new on each of these cards but the locked and accepted ones.
    pub fn re_roll_cards(&mut self, keys: &[u64]) {
        let open = |card: &&Card| !card.locked && card.fate == Fate::Open && keys.contains(&card.key);
        let replacing: Vec<u64> = self.sheet.cards.iter().filter(open).map(|card| card.key).collect();
        let Some(view) = self.sheet.view.filter(|_| !replacing.is_empty()) else {
            self.notices.warning("Nobody to re-roll: all are locked or accepted.");
            return;
        };
        self.sheet.rolls += 1;
        let seed = Seed::root(self.sheet.options.seed).child("roll", self.sheet.rolls);
        self.sample(view, self.sheet.made_by, replacing.len(), seed, replacing);
    }

    fn sample(
        &mut self,
        view: SampleView,
        method: SampleMethod,
        count: usize,
        seed: Seed,
        replacing: Vec<u64>,
    ) {
        let Some(geometry) = self.geometry().cloned() else {
            self.notices.warning("The room is still being analysed: try again in a moment.");
            return;
        };
        let room = self.document.scene().room.clone();
        let task = SampleTask { room, geometry, view, method, count };
        let engine = self.engine.clone();
        let work = move |cx: &JobCtx<PopulatePreview>| engine.sample(&task, cx);
        let name = format!("Sample {count} by {}", method.label());
        let job = Job::spawn(name, seed, self.waker(), work);
        let version = self.document.room_version();
        self.jobs.sampling = Some(Sampling { job, version, replacing, view, method });
    }

    pub(super) fn poll_sampling(&mut self) {
        let Some(sampling) = &mut self.jobs.sampling else { return };
        if let Some(preview) = sampling.job.take_preview() {
            self.ghosts = preview.people;
        }
        let Some(outcome) = sampling.job.poll() else { return };
        let Some(sampling) = self.jobs.sampling.take() else { return };
        self.ghosts.clear();
        let name = sampling.job.name().to_owned();
        if let Some(sampled) = self.taken(&name, outcome) {
            self.put_on_sheet(sampled, &sampling);
        }
    }

    fn put_on_sheet(&mut self, sampled: Sampled, sampling: &Sampling) {
        if sampling.version != self.document.room_version() {
            self.notices.warning("The room changed while people were sampled: sample again.");
            return;
        }
        let mut cards: Vec<Card> = sampled.candidates.into_iter().map(|c| self.card(c)).collect();
        if sampling.replacing.is_empty() {
            cards.sort_by(|a, b| badness(a).total_cmp(&badness(b)));
            let sheet = &mut self.sheet;
            sheet.chosen = cards.first().map(|card| card.key);
            sheet.cards = cards;
            sheet.seen = Some(Arc::new(Seen::new(sampled.seen.as_ref().clone())));
            sheet.view = Some(sampling.view);
            sheet.made_by = sampling.method;
            sheet.version = Some(sampling.version);
            self.requests.show_sheet = true;
        } else {
            for (key, card) in sampling.replacing.iter().zip(cards) {
                if let Some(slot) = self.sheet.card_mut(*key) {
                    *slot = card;
                }
            }
            if self.sheet.chosen_card().is_none() {
                self.sheet.chosen = self.sheet.cards.first().map(|card| card.key);
            }
        }
        if let Some(shortfall) = sampled.shortfall {
            self.notices.warning(shortfall);
        }
        self.draw_portraits();
    }

    fn card(&mut self, candidate: Candidate) -> Card {
        self.sheet.next_key += 1;
        let site = Site { body: candidate.person.id.0, frame: None };
        Card {
            key: self.sheet.next_key,
            person: candidate.person,
            findings: Limits::default().findings(site, &candidate.report.metrics),
            penetration_mm: candidate.report.metrics.penetration_max_mm,
            picture: None,
            locked: false,
            fate: Fate::Open,
        }
    }

    /// Draws the cards that have no picture, beside the window.
    fn draw_portraits(&mut self) {
        let Some(geometry) = self.geometry().cloned() else { return };
        let wanted: Vec<(u64, Person)> = self
            .sheet
            .cards
            .iter()
            .filter(|card| card.picture.is_none())
            .map(|card| (card.key, card.person.clone()))
            .collect();
        if wanted.is_empty() {
            return;
        }
        let (engine, room) = (self.engine.clone(), self.document.scene().room.clone());
        let work = move |cx: &JobCtx<Vec<(u64, Picture)>>| {
            cx.stage("drawing", wanted.len())?;
            let mut done = Vec::new();
            for (key, person) in wanted {
                done.push((key, engine.portrait(&room, &geometry, &person, cx.ticker())?));
                cx.preview(done.clone());
                cx.advance()?;
            }
            Ok(())
        };
        self.jobs.portraits = Some(Job::spawn("Draw candidates", Seed::root(0), self.waker(), work));
    }

    pub(super) fn poll_portraits(&mut self) {
        let Some(portraits) = &mut self.jobs.portraits else { return };
        let outcome = portraits.poll();
        for (key, picture) in portraits.take_preview().unwrap_or_default() {
            if let Some(card) = self.sheet.card_mut(key).filter(|card| card.picture.is_none()) {
                card.picture = Some(picture.into());
            }
        }
        if let Some(outcome) = outcome {
            let name = portraits.name().to_owned();
            self.jobs.portraits = None;
            self.taken(&name, outcome);
        }
    }

    /// Shows a candidate in the view.
    pub fn choose_card(&mut self, key: u64) {
        self.sheet.chosen = Some(key);
        self.selection.clear();
    }

    /// Locks a candidate, or unlocks it.
    pub fn lock_card(&mut self, key: u64) {
        if let Some(card) = self.sheet.card_mut(key) {
            card.locked = !card.locked;
        }
    }

    /// Fits these candidates and puts them into the room, as one step.
    pub fn accept_cards(&mut self, keys: &[u64]) {
        let Some(geometry) = self.geometry().cloned() else { return };
        if self.sheet.version != Some(self.document.room_version()) {
            self.notices.warning("The room has changed since these people were sampled: sample again.");
            return;
        }
        if self.jobs.populating() {
            self.notices.warning("People are being fitted already: wait or cancel.");
            return;
        }
        let wanted = |card: &&mut Card| card.fate == Fate::Open && keys.contains(&card.key);
        let mut people = Vec::new();
        let mut cards = Vec::new();
        for card in self.sheet.cards.iter_mut().filter(wanted) {
            card.fate = Fate::Fitting;
            cards.push((card.key, card.person.id));
            people.push(card.person.clone());
        }
        if people.is_empty() {
            return;
        }
        let first = self.document.next_person();
        for ((number, person), card) in (first..).zip(&mut people).zip(&mut cards) {
            person.id = PersonId(number);
            card.1 = person.id;
            person.name = format!("Person {}", number + 1);
            person.palette = number;
        }
        let method = self.sheet.made_by;
        let knows_family = method == SampleMethod::Search;
        let room = self.document.scene().room.clone();
        let clear_of = Some(self.document.scene().people.clone());
        let task = FitTask { room, geometry, people, clear_of, knows_family };
        let count = cards.len();
        let name = if count == 1 { "Fit candidate".to_owned() } else { format!("Fit {count} candidates") };
        let source = Source { method, seen: self.sheet.seen.clone(), cards };
        self.sheet.chosen = None;
        self.start_fitting(name, task, Vec::new(), Some(source));
    }

    /// The cards of a fit that has ended: accepted where somebody came of it, open again elsewhere.
    pub(super) fn settle_cards(&mut self, cards: &[(u64, PersonId)], made: &[Person]) {
        for (key, id) in cards {
            let there = made.iter().any(|person| person.id == *id);
            if let Some(card) = self.sheet.card_mut(*key) {
                card.fate = if there { Fate::Accepted } else { Fate::Open };
            }
        }
    }

    /// Looks at the room from here as a network would.
    pub fn look_from_here(&mut self) {
        let Some(geometry) = self.geometry().cloned() else { return };
        let (engine, room) = (self.engine.clone(), self.document.scene().room.clone());
        let view = SampleView::Camera(self.orbit.camera(), self.aspect);
        let work = move |cx: &JobCtx| engine.see(&room, &geometry, &view, Seed::root(0), cx.ticker());
        self.jobs.seeing = Some(Job::spawn("Look", Seed::root(0), self.waker(), work));
    }

    pub(super) fn poll_seeing(&mut self) {
        let Some(job) = &mut self.jobs.seeing else { return };
        let Some(outcome) = job.poll() else { return };
        let name = job.name().to_owned();
        self.jobs.seeing = None;
        if let Some(image) = self.taken(&name, outcome) {
            self.look = Some(Arc::new(Seen::new(image)));
        }
    }

    /// Forgets all candidates.
    pub fn clear_sheet(&mut self) {
        self.jobs.sampling = None;
        self.jobs.portraits = None;
        self.sheet.cards.clear();
        self.sheet.chosen = None;
        self.sheet.seen = None;
    }
}

/// Where people who are being fitted come from.
#[derive(Clone, Debug)]
pub(super) struct Source {
    pub method: SampleMethod,
    pub seen: Option<Arc<Seen>>,
    /// Cards and the numbers that their people have in the task.
    pub cards: Vec<(u64, PersonId)>,
}

/// Number to rank by: findings first, each by how far it is beyond its limit.
fn badness(card: &Card) -> f32 {
    let severe: f32 = card.findings.iter().map(|finding| finding.severity().min(100.0)).sum();
    1e3 * card.findings.len() as f32 + severe + 1e-3 * card.penetration_mm
}
