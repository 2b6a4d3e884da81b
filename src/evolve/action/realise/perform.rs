//! One action, from the choice of a place to the last thing out of the way (ADSE §5.2 and §5.3).

use std::cell::RefCell;
use std::collections::{BTreeMap, HashSet, VecDeque};
use std::sync::Arc;

use glam::Vec3;
use rand::RngExt as _;

use super::active::{self, Task};
use super::away::Away;
use super::evolution::{EvolutionConfig, GroupMode};
use super::library::{KindId, Library};
use super::placing::Rest;
use super::shape::Shape;
use super::spot::{Chair, PlacedPerson, SpotFinder};
use super::stage::Stage;
use super::step::{Candidates, Failed, MoveReason};
use super::wanted::{self, Layout, Want, ZONE_FREQUENCY};
use super::world::{Ball, Item, Lifted, Pose, Source, World, flat};
use super::zone::Zone;
use crate::evolve::action::{ActionKind, ActionNode, PersonFrame, is_shared, shared_potential};
use crate::job::{Rng, Seed};
use crate::math::Aabb;
use crate::scene::ObjectId;

/// Things this near to the key object are lifted while an action finds its place.
const AROUND_M: f32 = 2.2;
/// What lies this near to a person is rather used again than doubled.
const AT_HAND_M: f32 = 1.3;
/// How often.
const USE_AGAIN: f64 = 0.6;
/// A thing of the room that is larger than its kind's models by this factor is no such thing to handle: a tree is a
/// potted plant, and yet nobody puts it on the table.
const LARGER_THAN_USUAL: f32 = 1.6;
/// Earlier decisions that are revised for one thing before it is given up.
const MOST_REVISIONS: usize = 3;

/// An action while it happens.
pub struct Performance<'a> {
    pub node: &'a ActionNode,
    pub config: &'a EvolutionConfig,
    pub library: Arc<Library>,
    pub stage: Arc<Stage>,
    pub key: ObjectId,
    /// The room, changed bit by bit.
    pub world: World,
    pub number: usize,
    pub people: Vec<PlacedPerson>,
    /// Number of each person's chair.
    pub chairs: Vec<Option<ObjectId>>,
    /// In their places now: they may not be moved again.
    pub active: Lifted,
    /// Lifted for the moment.
    pub lifted: Lifted,
    /// Standing on what was moved: must find a new place.
    uprooted: Lifted,
    /// What matters enough for the working zone.
    zoned: Lifted,
    pub reasons: BTreeMap<ObjectId, MoveReason>,
    pub owners: BTreeMap<ObjectId, Option<usize>>,
    pub used: Vec<ObjectId>,
    /// What all of a group wants, wherever it stands.
    pub shared: Vec<ObjectId>,
    pub failed: Vec<Failed>,
    pub candidates: Vec<Candidates>,
    pub zone: Zone,
}

/// What was put down for a want, and how to take it back.
struct Done {
    want: Want,
    id: ObjectId,
    /// The thing before, and whether it was lifted; `None` when it was brought.
    before: Option<(Arc<Item>, bool)>,
}

impl<'a> Performance<'a> {
    /// Before anything has happened.
    pub fn new(
        world: &World,
        node: &'a ActionNode,
        key: ObjectId,
        number: usize,
        config: &'a EvolutionConfig,
    ) -> Self {
        let stage = world.stage.clone();
        let around = stage.room.object(key).map_or(Aabb::EMPTY, |o| o.world_bounds()).grown(AROUND_M);
        let library = config.library.clone().unwrap_or_else(|| stage.library.clone());
        let stays = |item: &Item| item.locked || item.kind.is_some_and(|k| library.kind(k).stays);
        let lifted = world.near(&around).into_iter().filter(|i| !stays(i)).map(|i| i.id).collect();
        Self {
            node,
            config,
            library: library.clone(),
            stage: stage.clone(),
            key,
            world: world.clone(),
            number,
            people: Vec::new(),
            chairs: Vec::new(),
            active: Lifted::new(),
            lifted,
            uprooted: Lifted::new(),
            zoned: Lifted::new(),
            reasons: BTreeMap::new(),
            owners: BTreeMap::new(),
            used: Vec::new(),
            shared: Vec::new(),
            failed: Vec::new(),
            candidates: Vec::new(),
            zone: Zone::default(),
        }
    }

    /// Does all of it.
    ///
    /// # Errors
    /// Why the action can't happen here, for people.
    pub fn run(&mut self, seed: Seed) -> Result<(), String> {
        self.place_people(&mut seed.child("people", 0).rng())?;
        let mut rng = seed.child("things", 0).rng();
        let mut failed = std::mem::take(&mut self.failed);
        let library = self.library.clone();
        let companions = self.config.companions;
        let mut wants: Vec<Vec<Want>> = (0..self.people.len())
            .map(|_| wanted::draw(self.node, &library, companions, &mut rng, &mut failed))
            .collect();
        self.failed = failed;
        self.failed.dedup();
        for want in self.shared_wants(&mut rng) {
            match self.config.group {
                GroupMode::Shared => self.share(&want, &mut rng),
                GroupMode::Baseline => {
                    let someone = rng.random_range(0..wants.len());
                    wants[someone].insert(0, want);
                }
            }
        }
        for (person, wants) in wants.into_iter().enumerate() {
            self.lay_out(person, wants, &mut rng);
        }
        self.clear_away(&mut seed.child("away", 0).rng())
    }

    // People ----------------------------------------------------------------------------------------------------

    fn place_people(&mut self, rng: &mut Rng) -> Result<(), String> {
        let wanted = self.group_size(rng);
        let watched = self.watched();
        let node = self.node;
        let likes = |frame: &PersonFrame| -> f64 {
            let seen = |(label, at): &(String, Vec3)| {
                node.placement(label).map_or(0.0, |p| p.density.density(frame.polar_of(*at)))
            };
            watched.iter().map(seen).sum()
        };
        let likes: Option<&dyn Fn(&PersonFrame) -> f64> =
            if watched.is_empty() { None } else { Some(&likes) };
        for number in 0..wanted {
            let finder = SpotFinder {
                world: &self.world,
                node: self.node,
                key: self.key,
                lifted: &self.lifted,
                others: &self.people,
                apart_m: self.node.group.as_ref().map(|g| g.people_apart_m),
                figures: RefCell::default(),
            };
            match finder.find(rng, likes) {
                Ok(person) => self.seat(person),
                // A group of two is one too.
                Err(_) if number >= 2 => break,
                Err(why) if number == 1 => return Err(format!("{why}; a group needs two")),
                Err(why) => return Err(why),
            }
        }
        Ok(())
    }

    fn group_size(&self, rng: &mut Rng) -> usize {
        let Some(group) = &self.node.group else { return 1 };
        if let Some(size) = self.config.group_size {
            return size.clamp(2, 4);
        }
        let mut left: f64 = rng.random();
        let drawn = group.sizes.iter().find(|(_, probability)| {
            left -= probability;
            left < 0.0
        });
        drawn.map_or(2, |(size, _)| (*size).clamp(2, 4))
    }

    /// Things that stay where they are and that the action is about: a television.
    fn watched(&self) -> Vec<(String, Vec3)> {
        let of_label = |label: &String| -> Vec<(String, Vec3)> {
            let Some(kind) = self.library.of_label(label).filter(|k| self.library.kind(*k).stays) else {
                return Vec::new();
            };
            self.in_place(kind).into_iter().map(|(_, at)| (label.clone(), at)).collect()
        };
        self.node.occurrence.iter().flat_map(|o| of_label(&o.object)).collect()
    }

    /// Things of a kind that are used where they are.
    fn in_place(&self, kind: KindId) -> Vec<(ObjectId, Vec3)> {
        let fixed = self.stage.fixed.iter().filter(|f| f.0 == kind).map(|f| (f.1, f.2));
        let things = self.world.of_kind(kind).map(|i| (i.id, i.bounds.center()));
        fixed.chain(things.filter(|_| self.library.kind(kind).stays)).collect()
    }

    /// Puts the person's chair where they sit.
    fn seat(&mut self, person: PlacedPerson) {
        let mut chair = None;
        if let Some(taken) = &person.chair {
            let id = match &taken.chair {
                Chair::Item(id) => {
                    self.uproot(*id);
                    self.world.put(*id, &taken.rest);
                    self.reasons.insert(*id, MoveReason::SatOn);
                    *id
                }
                Chair::New(kind, thing) => {
                    let id = self.world.fresh_id();
                    let name = self.fresh_name(*kind);
                    self.world.bring(id, name, *kind, thing, &taken.rest, self.number);
                    id
                }
            };
            self.settle(id, Some(self.people.len()));
            chair = Some(id);
        }
        self.chairs.push(chair);
        self.people.push(person);
    }

    /// What stands on a thing that is moved has to find another place.
    fn uproot(&mut self, id: ObjectId) {
        for carried in self.world.carried_by(id) {
            self.uprooted.insert(carried);
            self.lifted.insert(carried);
        }
    }

    fn settle(&mut self, id: ObjectId, person: Option<usize>) {
        self.lifted.remove(&id);
        self.uprooted.remove(&id);
        self.active.insert(id);
        self.owners.insert(id, person);
    }

    fn fresh_name(&self, kind: KindId) -> String {
        let name = &self.library.kind(kind).kind;
        let mut letters = name.chars();
        let capital: String =
            letters.next().map(|c| c.to_uppercase().chain(letters).collect()).unwrap_or_default();
        let of_things = self.world.items().map(|i| i.name.as_str());
        let of_room = self.stage.room.objects.iter().map(|o| o.name.as_str());
        let taken: HashSet<&str> =
            of_things.chain(of_room).filter(|name| name.starts_with(&capital)).collect();
        let numbered = (2..).map(|n| format!("{capital} {n}"));
        let mut names = std::iter::once(capital.clone()).chain(numbered);
        names.find(|name| !taken.contains(name.as_str())).unwrap_or(capital)
    }

    // Things that are used --------------------------------------------------------------------------------------

    fn shared_wants(&self, rng: &mut Rng) -> Vec<Want> {
        let Some(group) = &self.node.group else { return Vec::new() };
        let mut wants: Vec<Want> = Vec::new();
        for occurrence in &group.shared {
            let count = occurrence.draw(rng);
            let Some(kind) = self.library.of_label(&occurrence.object) else { continue };
            let (label, frequency) = (occurrence.object.clone(), occurrence.frequency());
            let want = Want { kind, label, frequency, shared: true };
            wants.extend((0..count).map(|_| want.clone()));
        }
        let size = |want: &Want| self.library.thing(want.kind, 0).map_or(0.0, |t| t.shape.volume_m3());
        wants.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.label.cmp(&b.label)));
        wants
    }

    /// Puts down what a group shares (eq. 12).
    fn share(&mut self, want: &Want, rng: &mut Rng) {
        let centres: Vec<Vec3> = self.people.iter().map(|p| p.frame.centre_m).collect();
        let spread = spread_m(&centres);
        let value = move |at: Vec3| {
            let distances: Vec<f32> = centres.iter().map(|c| flat(*c).distance(flat(at))).collect();
            if is_shared(&distances, spread) { shared_potential(&distances) } else { 0.0 }
        };
        if self.provide(want, None, &value, rng).is_none() {
            self.give_up(want);
        }
    }

    /// Puts down what one person uses, most frequent and largest first; what finds no place makes the one before
    /// it find another.
    fn lay_out(&mut self, person: usize, wants: Vec<Want>, rng: &mut Rng) {
        let (node, library) = (self.node, self.library.clone());
        let mut done: Vec<Done> = Vec::new();
        let mut revisions = 0;
        let mut queue: VecDeque<Want> = wants.into();
        while let Some(want) = queue.pop_front() {
            let mut layout = Layout::new(node, &library, self.people[person].frame);
            for other in &done {
                let at = self.world.item(other.id).map_or(Vec3::ZERO, |i| i.pose.at);
                layout.add(&other.want.label, at);
            }
            let preference = layout.of(&want.label);
            let value = |at: Vec3| preference.at(at);
            match self.provide(&want, Some(person), &value, rng) {
                Some(put) => done.extend(put),
                None if revisions < MOST_REVISIONS && done.last().is_some_and(|d| d.want != want) => {
                    revisions += 1;
                    if let Some(last) = done.pop() {
                        self.take_back(&last);
                        queue.push_front(last.want);
                    }
                    queue.push_front(want);
                }
                None => self.give_up(&want),
            }
        }
    }

    fn give_up(&mut self, want: &Want) {
        let kind = self.library.kind(want.kind);
        let why = match self.config.banned.contains(&kind.kind) {
            true => "it is banned".to_owned(),
            false if self.nothing_free(want.kind) => {
                format!("the room takes {} and all are locked or in use", kind.most)
            }
            false => format!("no free place for it around {}", self.stage.name_of(self.key)),
        };
        self.failed.push(Failed { object: kind.kind.clone(), why });
    }

    fn nothing_free(&self, kind: KindId) -> bool {
        let full = self.world.of_kind(kind).count() >= self.library.kind(kind).most;
        full && !self.world.of_kind(kind).any(|i| !i.locked && !self.active.contains(&i.id))
    }

    /// Finds the thing, new or one of the room's, and its place. `None` when there is none of either; `Some(None)`
    /// when it is used where it is.
    #[expect(clippy::option_option, reason = "no place, used in place, or put somewhere")]
    fn provide(
        &mut self,
        want: &Want,
        person: Option<usize>,
        value: &dyn Fn(Vec3) -> f32,
        rng: &mut Rng,
    ) -> Option<Option<Done>> {
        let library = self.library.clone();
        let kind = library.kind(want.kind);
        if self.config.banned.contains(&kind.kind) {
            return None;
        }
        let centre = self.people[person.unwrap_or(0)].frame.centre_m;
        let in_place = self.in_place(want.kind);
        let nearest = in_place.iter().min_by(|a, b| a.1.distance(centre).total_cmp(&b.1.distance(centre)));
        if let Some((id, _)) = nearest {
            self.used.push(*id);
            return Some(None);
        }
        let again = self.to_use_again(want.kind, centre, rng);
        let (shape, thing) = match again.and_then(|id| self.world.item(id)) {
            Some(item) => (item.to_be_moved().shape, None),
            None if self.world.of_kind(want.kind).count() >= kind.most => return None,
            None => {
                let thing = library.thing(want.kind, self.look(want.kind, rng)).ok()?;
                (thing.shape.clone(), Some(thing))
            }
        };
        let rest = self.choose_place(want, &shape, again, person, value, rng)?;
        let before = again.and_then(|id| self.world.item(id)).cloned();
        let id = match (again, thing) {
            (Some(id), _) => {
                self.uproot(id);
                self.world.put(id, &rest);
                self.reasons.insert(id, MoveReason::Used);
                id
            }
            (None, Some(thing)) => {
                let id = self.world.fresh_id();
                let name = self.fresh_name(want.kind);
                self.world.bring(id, name, want.kind, &thing, &rest, self.number);
                id
            }
            (None, None) => return None,
        };
        let was_lifted = self.lifted.contains(&id);
        self.settle(id, person);
        self.shared.extend(want.shared.then_some(id));
        if want.frequency > ZONE_FREQUENCY {
            self.zoned.insert(id);
        }
        Some(Some(Done { want: want.clone(), id, before: before.map(|b| (b, was_lifted)) }))
    }

    fn choose_place(
        &mut self,
        want: &Want,
        shape: &Shape,
        again: Option<ObjectId>,
        person: Option<usize>,
        value: &dyn Fn(Vec3) -> f32,
        rng: &mut Rng,
    ) -> Option<Rest> {
        let library = self.library.clone();
        let kind = library.kind(want.kind);
        let mut lifted = self.lifted.clone();
        if let Some(id) = again {
            lifted.insert(id);
            lifted.extend(self.world.carried_by(id));
        }
        let serving: Vec<KindId> = kind.served_on.iter().filter_map(|k| library.named(k)).collect();
        let is_free = |id: &ObjectId| {
            let of_person = self.owners.get(id) == Some(&person);
            let serves = self.world.item(*id).and_then(|i| i.kind).is_some_and(|k| serving.contains(&k));
            of_person && serves && self.world.carried_by(*id).is_empty()
        };
        let servers = self.active.iter().filter(|id| is_free(id)).copied().collect();
        let balls: Vec<Ball> = self.people.iter().flat_map(PlacedPerson::trunk).collect();
        let person = self.people[person.unwrap_or(0)].frame;
        let task = Task { kind, shape, key: self.key, person, servers, value };
        let chosen = active::choose(&self.world, &task, &lifted, &balls, rng);
        self.candidates.push(chosen.candidates);
        chosen.rest
    }

    /// A thing of the room that is used again: always when the room takes no more, often when it is at hand.
    fn to_use_again(&self, kind: KindId, centre: Vec3, rng: &mut Rng) -> Option<ObjectId> {
        let largest_m = LARGER_THAN_USUAL * self.usual_size_m(kind);
        let fits = |i: &&Arc<Item>| i.shape.bounds.size().max_element() < largest_m;
        let free =
            self.world.of_kind(kind).filter(|i| !i.locked && !self.active.contains(&i.id)).filter(fits);
        let opens = self.node.kind == ActionKind::ReadBook && self.library.opens(kind);
        let is_shut = |i: &Arc<Item>| opens && !is_open(i);
        let mut near: Vec<(bool, f32, ObjectId)> =
            free.map(|i| (is_shut(i), flat(i.pose.at).distance(flat(centre)), i.id)).collect();
        near.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let (shut, distance_m, id) = *near.first()?;
        let full = self.world.of_kind(kind).count() >= self.library.kind(kind).most;
        let at_hand = distance_m < AT_HAND_M && rng.random_bool(USE_AGAIN);
        (full || at_hand && !shut).then_some(id)
    }

    /// How a new thing looks: who reads has the book open.
    fn look(&self, kind: KindId, rng: &mut Rng) -> usize {
        let looks = self.library.looks(kind);
        let drawn = rng.random_range(0..looks);
        if self.node.kind != ActionKind::ReadBook {
            return drawn;
        }
        let open: Vec<usize> = (0..looks).filter(|look| self.library.is_open(kind, *look)).collect();
        if open.is_empty() { drawn } else { open[drawn % open.len()] }
    }

    /// Size of the largest look of a kind.
    fn usual_size_m(&self, kind: KindId) -> f32 {
        let looks = (0..self.library.looks(kind)).filter_map(|look| self.library.thing(kind, look).ok());
        looks.map(|t| t.shape.bounds.size().max_element()).fold(0.0, f32::max)
    }

    fn take_back(&mut self, done: &Done) {
        self.active.remove(&done.id);
        self.zoned.remove(&done.id);
        self.owners.remove(&done.id);
        self.shared.retain(|id| *id != done.id);
        match &done.before {
            Some((item, was_lifted)) => {
                self.world.restore(item.clone());
                self.reasons.remove(&done.id);
                if *was_lifted {
                    self.lifted.insert(done.id);
                }
            }
            None => {
                self.world.leave(done.id);
            }
        }
    }

    // Things that are in the way --------------------------------------------------------------------------------

    fn clear_away(&mut self, rng: &mut Rng) -> Result<(), String> {
        let balls: Vec<Ball> = self.people.iter().flat_map(PlacedPerson::trunk).collect();
        self.zone = self.working_zone(&balls);
        let mut displaced: Vec<ObjectId> = Vec::new();
        for id in &self.lifted {
            let Some(item) = self.world.item(*id) else { continue };
            let in_the_way = self.uprooted.contains(id)
                || self.zone.holds(&item.shape, &item.pose)
                || World::touches(&item.shape, &item.pose, &balls)
                || self.world.meets_any(item, &self.active);
            if in_the_way {
                displaced.push(*id);
            }
        }
        let carried: Vec<ObjectId> = displaced.iter().flat_map(|id| self.world.carried_by(*id)).collect();
        displaced.extend(carried.into_iter().filter(|id| !self.active.contains(id)));
        let size = |id: &ObjectId| self.world.item(*id).map_or(0.0, |i| i.shape.volume_m3());
        displaced.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.cmp(b)));
        displaced.dedup();
        self.lifted = displaced.iter().copied().collect();
        self.put_away(displaced, &balls, rng)
    }

    fn put_away(&mut self, displaced: Vec<ObjectId>, balls: &[Ball], rng: &mut Rng) -> Result<(), String> {
        let mut queue: VecDeque<ObjectId> = displaced.into();
        let mut done: Vec<Arc<Item>> = Vec::new();
        let mut revisions = 0;
        while let Some(id) = queue.pop_front() {
            let Some(item) = self.world.item(id).cloned() else { continue };
            let away = Away {
                world: &self.world,
                library: &self.library,
                zone: &self.zone,
                balls,
                lifted: &self.lifted,
            };
            let found = away.find(&item.to_be_moved(), rng);
            self.candidates.push(found.candidates);
            if let Some((rest, why)) = found.rest {
                self.world.put(id, &rest);
                self.lifted.remove(&id);
                self.reasons.insert(id, why);
                done.push(item);
            } else if revisions < MOST_REVISIONS && !done.is_empty() {
                revisions += 1;
                if let Some(before) = done.pop() {
                    self.lifted.insert(before.id);
                    queue.push_front(before.id);
                    self.world.restore(before);
                }
                queue.push_front(id);
            } else {
                return Err(format!("{} is in the way and there is no room left for it", item.name));
            }
        }
        Ok(())
    }

    fn working_zone(&self, balls: &[Ball]) -> Zone {
        let things: Vec<(&Shape, Pose)> =
            self.zoned.iter().filter_map(|id| self.world.item(*id)).map(|i| (&*i.shape, i.pose)).collect();
        let lowest = things.iter().map(|(_, pose)| pose.at.y).fold(f32::INFINITY, f32::min);
        let work_m = self.stage.work_surface(self.key).map_or(0.0, |i| self.stage.surfaces[i].height_m);
        Zone::around(balls, &things, work_m.min(lowest))
    }
}

/// The largest distance between two people in plan.
fn spread_m(centres: &[Vec3]) -> f32 {
    let pairs = centres.iter().flat_map(|a| centres.iter().map(move |b| flat(*a).distance(flat(*b))));
    pairs.fold(0.0, f32::max)
}

/// Whether a thing is a book that lies open.
fn is_open(item: &Item) -> bool {
    matches!(&item.source, Source::Brought { thing, .. } if Library::is_open_model(&thing.name))
}
