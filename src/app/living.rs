//! Rooms that get lived in: the tree of what was done, the jobs that look at a room and do actions, and how each step
//! becomes one command. Which step is shown follows from the document: undo and redo need no word here.

use std::sync::Arc;

use super::actions;
use super::day::ShownDay;
use super::lived::{ActionChoice, ActionStep, LivedRoom};
use super::state::EditorState;
use crate::document::Command;
use crate::document::RoomVersion;
use crate::inspect::BodyReport;
use crate::job::{Job, JobCtx, Seed, Stop};
use crate::scene::ObjectId;
use crate::scene::Person;
use crate::scene::PersonId;
use crate::scene::Room;

/// How long each state of a replay is shown, seconds.
const REPLAY_S: f32 = 1.2;
/// Draws of the chain that are not possible here before it is said to be at its end.
const DRAWS: u64 = 24;

/// One state of the room in the tree of its futures.
pub struct LifeNode {
    /// The one that it came from.
    pub parent: Option<usize>,
    /// What was done to get here; `None` for the room as it was looked at.
    pub step: Option<ActionStep>,
    /// Which outcome of that action.
    pub roll: u64,
    /// The room as a value.
    pub lived: Arc<dyn LivedRoom>,
    room: Arc<Room>,
    people: Vec<Person>,
    /// Under which names the document knows it: each time it is gone to, it gets another.
    versions: Vec<RoomVersion>,
    /// Who came with it, each time.
    ids: Vec<PersonId>,
}

/// What the panel of actions holds.
#[derive(Default)]
pub struct Living {
    /// What the user decides.
    pub choice: ActionChoice,
    /// Root of the seed tree.
    pub seed: u64,
    /// How many actions *Sample* lets run.
    pub count: usize,
    /// People are fitted, not only put there.
    pub fit: bool,
    /// The places that were tried are shown.
    pub marks: bool,
    /// Every state that was reached.
    pub tree: Vec<LifeNode>,
    /// Things that are pointed out in the view for now.
    pub pointed_out: Vec<ObjectId>,
    /// The way to the present state is being shown, state by state.
    pub replay: Option<Replay>,
    /// Another state that is shown beside the present one.
    pub beside: Option<usize>,
    /// The day that was made last.
    pub day: Option<ShownDay>,
}

/// States that are shown one after the other; only a way of looking.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// The states.
    path: Vec<usize>,
    /// Since it began, seconds.
    seconds: f32,
}

impl Replay {
    fn node(&self) -> Option<usize> {
        self.path.get((self.seconds / REPLAY_S) as usize).copied()
    }
}

/// A room that is being looked at.
pub(super) type Looking = (RoomVersion, Job<Arc<dyn LivedRoom>>);

/// Actions that are being done.
pub(super) struct Acting {
    pub job: Job<Vec<Done>, Vec<Done>>,
    from: usize,
    version: RoomVersion,
    newest: Vec<Done>,
}

/// One action that was done.
#[derive(Clone)]
pub struct Done {
    lived: Arc<dyn LivedRoom>,
    roll: u64,
    people: Vec<Person>,
    reports: Vec<BodyReport>,
}

impl LifeNode {
    /// A state on the way of a day: whoever lives it is in the day's motion.
    pub(super) fn of_day(parent: usize, lived: Arc<dyn LivedRoom>) -> Self {
        let (room, step) = (Arc::new(lived.room()), lived.last_step());
        let (people, versions, ids) = (Vec::new(), Vec::new(), Vec::new());
        Self { parent: Some(parent), step, roll: 0, lived, room, people, versions, ids }
    }
}

impl Living {
    /// With what a fresh window has.
    pub fn new() -> Self {
        Self { seed: 1, count: 5, fit: true, ..Self::default() }
    }

    /// Forgets every state; decisions stay.
    pub(super) fn forget(&mut self) {
        self.tree.clear();
        self.pointed_out.clear();
        self.replay = None;
        self.beside = None;
        self.day = None;
    }
}

impl EditorState {
    /// The state of the tree that the document shows; `None` when the room was changed by hand since.
    pub fn life_now(&self) -> Option<usize> {
        let version = self.document.room_version();
        self.living.tree.iter().position(|node| node.versions.contains(&version))
    }

    /// Whether actions are being done or looked for.
    pub fn is_living(&self) -> bool {
        self.jobs.looking.is_some() || self.jobs.acting.is_some() || self.jobs.day.is_some()
    }

    /// Shows how the room came to be as it is, action by action; again to stop.
    pub fn toggle_replay(&mut self) {
        if self.living.replay.take().is_some() {
            return;
        }
        let mut path: Vec<usize> = Vec::new();
        let mut at = self.life_now();
        while let Some(node) = at {
            path.push(node);
            at = self.living.tree[node].parent;
        }
        path.reverse();
        self.living.replay = (path.len() > 1).then_some(Replay { path, seconds: 0.0 });
    }

    /// Time goes on in a replay; whether one runs.
    pub(super) fn advance_replay(&mut self, passed_s: f32) -> bool {
        let Some(replay) = &mut self.living.replay else { return false };
        replay.seconds += passed_s;
        if replay.node().is_none() {
            self.living.replay = None;
        }
        self.living.replay.is_some()
    }

    /// The state that a replay or a day shows now.
    pub fn replayed(&self) -> Option<usize> {
        let replayed = self.living.replay.as_ref().and_then(Replay::node).or_else(|| self.day_node());
        replayed.filter(|number| *number < self.living.tree.len())
    }

    /// Shows a state beside the present one, or no longer.
    pub fn toggle_beside(&mut self, number: usize) {
        self.living.beside = if self.living.beside == Some(number) { None } else { Some(number) };
    }

    /// The state that is shown beside the present one; none while the present one is that.
    pub fn shown_beside(&self) -> Option<usize> {
        let number = self.living.beside.filter(|number| *number < self.living.tree.len())?;
        (self.life_now() != Some(number)).then_some(number)
    }

    /// Goes to the state that is shown beside, alone.
    pub fn choose_beside(&mut self) {
        if let Some(number) = self.shown_beside()
            && self.show_life(number)
        {
            self.living.beside = None;
        }
    }

    /// Room and people of a state of the tree.
    pub fn life_scene(&self, number: usize) -> Option<(&Arc<Room>, &[Person])> {
        self.living.tree.get(number).map(|node| (&node.room, node.people.as_slice()))
    }

    /// A state of the tree in words: how many actions there were, and the last one.
    pub fn life_label(&self, number: usize) -> String {
        let Some(node) = self.living.tree.get(number) else { return String::new() };
        let what = node.step.as_ref().map_or("the room as it was", |step| step.action.as_str());
        // Before the name, which a narrow panel cuts.
        let roll = if node.roll > 0 { format!(" outcome {}:", node.roll + 1) } else { String::new() };
        format!("{} {roll} {what}", node.lived.step_count())
    }

    /// Starts to look at the room as it is: what can be done in it.
    pub fn look_for_actions(&mut self) {
        if !self.has_room() {
            return self.notices.warning("Open a room first.");
        }
        let (engine, room) = (self.engine.clone(), self.document.scene().room.clone());
        let (choice, seed) = (self.living.choice.clone(), self.living.seed);
        let work = move |cx: &JobCtx| engine.look_for_actions(&room, &choice, seed, cx.ticker());
        let job = Job::spawn("Look for actions", Seed::root(seed), self.waker(), work);
        self.jobs.looking = Some((self.document.room_version(), job));
    }

    /// Starts to do one action.
    pub fn start_action(&mut self, node: usize) {
        self.act("Action", vec![Some(node)], None);
    }

    /// Starts to let the chain of actions run.
    pub fn start_chain(&mut self) {
        let count = self.living.count.max(1);
        self.act("Sample actions", vec![None; count], None);
    }

    /// Starts to do the last action again with another outcome: a branch beside it.
    pub fn re_roll_action(&mut self) {
        let Some(now) = self.life_now() else { return };
        let node = &self.living.tree[now];
        let (Some(parent), Some(step)) = (node.parent, &node.step) else {
            return self.notices.warning("No action was done yet.");
        };
        let action = step.node;
        let siblings = self.living.tree.iter().filter(|other| {
            other.parent == Some(parent) && other.step.as_ref().is_some_and(|s| s.node == action)
        });
        let roll = siblings.map(|other| other.roll + 1).max().unwrap_or(1);
        self.act("Re-roll action", vec![Some(action)], Some((parent, roll)));
    }

    /// Does actions one after the other, from the state that is shown or from another, by a job.
    fn act(&mut self, name: &str, actions: Vec<Option<usize>>, from: Option<(usize, u64)>) {
        if self.is_living() {
            return self.notices.warning("An action is being done already: wait or cancel.");
        }
        let Some(now) = self.life_now() else {
            return self.notices.warning("The room was changed by hand: look for actions again first.");
        };
        let (parent, roll) = from.unwrap_or((now, 0));
        let objects = self.document.scene().room.objects.iter();
        let locked: Vec<ObjectId> = objects.filter(|o| o.locked).map(|o| o.id).collect();
        let start = self.living.tree[parent].lived.decided(&self.living.choice, &locked);
        let (first_id, fit) = (self.document.next_person(), self.living.fit);
        let work = move |cx: &JobCtx<Vec<Done>>| run(start, &actions, roll, first_id, fit, cx);
        let job = Job::spawn(name, Seed::root(self.living.seed), self.waker(), work);
        let version = self.document.room_version();
        self.jobs.acting = Some(Acting { job, from: parent, version, newest: Vec::new() });
    }

    pub(super) fn poll_living(&mut self) {
        self.poll_looking();
        let Some(acting) = &mut self.jobs.acting else { return };
        if let Some(done) = acting.job.take_preview() {
            self.ghosts = done.last().map(|last| last.people.clone()).unwrap_or_default();
            acting.newest = done;
        }
        let Some(outcome) = acting.job.poll() else { return };
        let Some(acting) = self.jobs.acting.take() else { return };
        self.ghosts.clear();
        if let Some(done) = self.taken(acting.job.name(), outcome) {
            self.take_in_actions(done, acting.from, acting.version);
        }
    }

    fn poll_looking(&mut self) {
        let Some((version, job)) = &mut self.jobs.looking else { return };
        let Some(outcome) = job.poll() else { return };
        let version = *version;
        self.jobs.looking = None;
        let Some(lived) = self.taken("Look for actions", outcome) else { return };
        if version != self.document.room_version() {
            return self.notices.warning("The room changed while it was looked at: look again.");
        }
        let room = self.document.scene().room.clone();
        let (people, ids, versions) = (Vec::new(), Vec::new(), vec![version]);
        self.living.tree.push(LifeNode {
            parent: None,
            step: None,
            roll: 0,
            lived,
            room,
            people,
            versions,
            ids,
        });
    }

    /// Every action becomes one step of the history.
    fn take_in_actions(&mut self, done: Vec<Done>, from: usize, version: RoomVersion) {
        if version != self.document.room_version() {
            return self.notices.warning("The room was changed while this was done, so it no longer fits.");
        }
        let mut parent = from;
        for one in done {
            let (room, step) = (Arc::new(one.lived.room()), one.lived.last_step());
            let node = LifeNode {
                parent: Some(parent),
                step,
                roll: one.roll,
                lived: one.lived,
                room,
                people: one.people,
                versions: Vec::new(),
                ids: Vec::new(),
            };
            self.living.tree.push(node);
            parent = self.living.tree.len() - 1;
            if !self.show_life(parent) {
                return;
            }
            for (id, report) in self.living.tree[parent].ids.clone().into_iter().zip(one.reports) {
                if let Some(person) = self.document.scene().person(id).cloned() {
                    self.keep_measured(&person, self.document.room_version(), report, Vec::new());
                }
            }
        }
    }

    /// Makes the document show a state of the tree, as one step.
    pub fn show_life(&mut self, number: usize) -> bool {
        let Some(node) = self.living.tree.get(number) else { return false };
        let back = self.life_now().is_some_and(|now| now == number);
        if back {
            return true;
        }
        let label = match &node.step {
            Some(step) if node.versions.is_empty() => step.action.clone(),
            Some(step) => format!("Go to: {}", step.action),
            None => "Go to the room as it was".to_owned(),
        };
        let leaving: Vec<PersonId> = self
            .living
            .tree
            .iter()
            .flat_map(|node| node.ids.iter().copied())
            .filter(|id| self.document.scene().person(*id).is_some())
            .collect();
        let (room, arriving, first) = (node.room.clone(), node.people.clone(), self.document.next_person());
        if !self.apply(Command::ChangeRoom { label, room, leaving, arriving, made_for: None }) {
            return false;
        }
        let version = self.document.room_version();
        let people = self.document.scene().people.iter().map(|p| p.id);
        let ids: Vec<PersonId> = people.filter(|id| id.0 >= first).collect();
        let node = &mut self.living.tree[number];
        node.versions.push(version);
        node.ids.extend(ids);
        true
    }

    /// Never brings this kind of thing again, and does the last action once more without it.
    pub fn ban_kind(&mut self, kind: &str) {
        if !kind.is_empty() && !self.living.choice.banned.iter().any(|known| known == kind) {
            self.living.choice.banned.push(kind.to_owned());
            self.re_roll_action();
        }
    }

    /// Shows an object and says so in the selection.
    pub fn look_at_object(&mut self, id: ObjectId) {
        self.selection.only(super::selection::Item::Object(id));
        actions::frame_selection(self);
    }

    /// Lets go of the job; what was done by then stays, a step for each action.
    pub(super) fn stop_acting(&mut self) {
        let Some(mut acting) = self.jobs.acting.take() else { return };
        acting.job.cancel();
        acting.newest = acting.job.take_preview().unwrap_or(acting.newest);
        self.ghosts.clear();
        let kept = acting.newest.len();
        if kept == 0 {
            self.notices.info("Cancelled. Nothing was changed.");
        } else {
            self.take_in_actions(acting.newest, acting.from, acting.version);
            self.notices.info(format!("Cancelled. {kept} actions were done by then; undo takes them back."));
        }
    }
}

/// Does the actions one after the other; `None` draws one from the chain. Who is fitted is at the last one.
fn run(
    start: Arc<dyn LivedRoom>,
    actions: &[Option<usize>],
    roll: u64,
    first_id: u32,
    fit: bool,
    cx: &JobCtx<Vec<Done>>,
) -> Result<Vec<Done>, Stop> {
    cx.stage("actions", actions.len())?;
    let mut done: Vec<Done> = Vec::with_capacity(actions.len());
    let mut now = start;
    for action in actions {
        cx.check()?;
        now = match action {
            Some(node) => now.apply(*node, roll)?,
            None => match drawn(now.as_ref())? {
                Some(next) => next,
                None => break,
            },
        };
        let people = now.people(first_id);
        done.push(Done { lived: now.clone(), roll, people, reports: Vec::new() });
        cx.preview(done.clone());
        cx.advance()?;
    }
    if let Some(last) = done.last_mut().filter(|_| fit) {
        cx.stage("fitting people", last.people.len())?;
        let fitted = last.lived.fitted_people(first_id, cx.ticker())?;
        if !fitted.is_empty() {
            (last.people, last.reports) = fitted.into_iter().unzip();
        }
    }
    if done.is_empty() {
        return Err(Stop::Failed("nothing can be done in this room: see what is off, and why".to_owned()));
    }
    Ok(done)
}

/// The room after an action drawn from the chain; `None` when nothing that it draws is possible.
fn drawn(now: &dyn LivedRoom) -> Result<Option<Arc<dyn LivedRoom>>, Stop> {
    for refused in 0..DRAWS {
        let Some(node) = now.draw_next(refused) else { return Ok(None) };
        match now.apply(node, 0) {
            Ok(next) => return Ok(Some(next)),
            Err(Stop::Cancelled) => return Err(Stop::Cancelled),
            Err(Stop::Failed(_)) => {}
        }
    }
    Ok(None)
}
