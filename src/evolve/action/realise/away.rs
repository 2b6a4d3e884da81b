//! What is in the way goes as near as there is room (ADSE §5.2, eq. 11): on the surfaces that suit it, then on a
//! stack, then on the floor.

use std::cmp::Ordering;
use std::collections::HashSet;
use std::f32::consts::PI;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::Arc;

use glam::{Vec2, Vec3};
use rand::RngExt as _;

use super::crowd::Crowd;
use super::library::{Ground, Kind, Library};
use super::placing::{Avoid, Onto, Rest};
use super::shape::Shape;
use super::step::{Candidates, MoveReason, Sample, Verdict};
use super::world::{Ball, Held, Item, Lifted, Pose, World, flat};
use super::zone::Zone;
use crate::job::Rng;

/// ADSE §5.2: places drawn for one thing.
pub const AWAY_SAMPLES: usize = 10_000;
/// Places looked at closely in vain before an earlier decision is revised. ADSE §5.2 has 2,000, and counts all; those
/// that are plainly taken, or beside one that failed, don't count here.
const MOST_FAILURES: usize = 800;
/// Places in one square of the plan fail together; its side is this share of the thing's reach, within these metres.
const BESIDE: f32 = 0.12;
const BESIDE_M: std::ops::Range<f32> = 0.015..0.05;
/// Of these, a search of one kind (near by, anywhere) takes this share of what is left, so that the next has some too.
const AT_ONCE: usize = 2;
/// Share of the places that is drawn near by, where most things end.
const NEARBY: f32 = 0.3;
/// How near that is.
const NEARBY_M: f32 = 0.6;
/// Farther than this a stack, then the floor is better.
const FARTHEST_M: f32 = 3.0;
/// Highest stack over what it stands on.
const HIGHEST_STACK_M: f32 = 0.35;
/// What lies on a stack may be this much larger than what is below.
const LARGER: f32 = 1.6;
/// Samples kept for the overlay.
const KEPT: usize = 96;

/// How far something in the way is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    /// Up to [`FARTHEST_M`].
    Near,
    /// Through the whole room.
    Anywhere,
    /// Through the whole room, the working zone too.
    InTheZone,
}

/// Where something in the way can go.
pub struct Away<'a> {
    /// The room now, without what is lifted.
    pub world: &'a World,
    /// What kinds are like.
    pub library: &'a Library,
    /// What must stay free.
    pub zone: &'a Zone,
    /// People.
    pub balls: &'a [Ball],
    /// Things that are lifted for the moment.
    pub lifted: &'a Lifted,
}

/// A cell of a surface, by the surface's number.
type Cell = (usize, Vec3);

/// A place that was drawn.
#[derive(Clone, Copy)]
struct Drawn {
    /// From where the thing was.
    distance_m: f32,
    surface: usize,
    at: Vec3,
}

impl Drawn {
    fn order(&self, other: &Self) -> Ordering {
        let by_distance = self.distance_m.total_cmp(&other.distance_m);
        by_distance.then(self.at.x.total_cmp(&other.at.x)).then(self.at.z.total_cmp(&other.at.z))
    }
}

/// Drawn places, the nearest first. They are put in order only as far as they are asked for: most things find room
/// among the first hundred of thousands.
#[derive(Default)]
struct NearestFirst {
    drawn: Vec<Drawn>,
    /// So many are in order.
    ordered: usize,
    /// So many were handed out.
    given: usize,
}

/// So many places are put in order at first.
const FIRST_ORDERED: usize = 128;

impl Iterator for NearestFirst {
    type Item = Drawn;

    fn next(&mut self) -> Option<Drawn> {
        if self.given == self.ordered {
            let rest = &mut self.drawn[self.ordered..];
            // As many again as there are: all of them cost what sorting them at once does.
            let count = self.ordered.max(FIRST_ORDERED).min(rest.len());
            if count < rest.len() {
                rest.select_nth_unstable_by(count, Drawn::order);
            }
            rest[..count].sort_unstable_by(Drawn::order);
            self.ordered += count;
        }
        let drawn = self.drawn.get(self.given).copied()?;
        self.given += 1;
        Some(drawn)
    }
}

/// Squares of surfaces in which a place was tried in vain: another in the same square would fail too, as a rule.
struct Failed {
    square_m: f32,
    squares: HashSet<u64, BuildHasherDefault<Spread>>,
}

/// Spreads numbers of squares over a table; nobody chooses them to collide.
#[derive(Default)]
struct Spread(u64);

impl Hasher for Spread {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u64(u64::from(*byte)));
    }

    fn write_u64(&mut self, number: u64) {
        // Multiplying by 2^64 over the golden ratio fills the high bits, which the table takes.
        let mixed = (self.0 ^ number).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = mixed ^ (mixed >> 32);
    }
}

impl Failed {
    fn of(shape: &Shape) -> Self {
        let square_m = (shape.reach_m * BESIDE).clamp(BESIDE_M.start, BESIDE_M.end);
        Self { square_m, squares: HashSet::default() }
    }

    /// A number for each square of each surface.
    fn square(&self, surface: usize, at: Vec3) -> u64 {
        let square = (flat(at) / self.square_m).floor().as_ivec2();
        (surface as u64) << 48 | (square.x as u64 & 0xFF_FFFF) << 24 | (square.y as u64 & 0xFF_FFFF)
    }

    fn is_beside(&self, surface: usize, at: Vec3) -> bool {
        self.squares.contains(&self.square(surface, at))
    }

    fn add(&mut self, surface: usize, at: Vec3) {
        self.squares.insert(self.square(surface, at));
    }
}

/// Places that were tried for one thing.
struct Tries<'a> {
    samples: Vec<Sample>,
    /// How many may still be looked at closely.
    left: usize,
    avoid: Avoid<'a>,
    crowd: Crowd<'a>,
}

/// The place that was found for something in the way.
pub struct Found {
    /// The place, with the reason to report.
    pub rest: Option<(Rest, MoveReason)>,
    /// For the overlay.
    pub candidates: Candidates,
}

impl Away<'_> {
    /// The nearest free place for a thing.
    pub fn find(&self, item: &Item, rng: &mut Rng) -> Found {
        let kind = item.kind.map(|k| self.library.kind(k));
        let suited = |ground: Ground| suits(kind, item, self.world, ground);
        let mut tries = Tries {
            samples: Vec::new(),
            left: MOST_FAILURES,
            avoid: Avoid::new(self.lifted, self.balls),
            crowd: Crowd::around(self.world, item, self.lifted),
        };
        let lies_on_floor = self.ground_now(item) == Some(Ground::Floor);
        let tops = |g: Ground| suited(g) && (g != Ground::Floor || lies_on_floor);
        let floor = |g: Ground| g == Ground::Floor;
        let clean = kind.is_some_and(|k| !k.on.contains(&Ground::Floor));
        let mut on = |allowed: &dyn Fn(Ground) -> bool, reach: Reach, why: MoveReason, rng: &mut Rng| {
            self.on_surfaces(item, allowed, reach, rng, &mut tries).map(|rest| (rest, why))
        };
        let rest = on(&tops, Reach::Near, MoveReason::InTheWay, rng)
            .or_else(|| self.on_a_stack(item, kind, rng).map(|rest| (rest, MoveReason::Stacked)))
            .or_else(|| clean.then(|| on(&tops, Reach::Anywhere, MoveReason::InTheWay, rng)).flatten())
            // Food and china rather crowd the table than lie on the floor.
            .or_else(|| clean.then(|| on(&tops, Reach::InTheZone, MoveReason::Crowded, rng)).flatten())
            .or_else(|| on(&floor, Reach::Anywhere, MoveReason::ToTheFloor, rng));
        let mut samples = tries.samples;
        let drawn = samples.len();
        samples.truncate(KEPT);
        Found { rest, candidates: Candidates { object: item.name.clone(), samples, drawn } }
    }

    fn ground_now(&self, item: &Item) -> Option<Ground> {
        match item.held {
            Held::Surface(number) => self.world.stage.surfaces.get(number).map(|s| s.ground),
            _ => None,
        }
    }

    fn on_surfaces(
        &self,
        item: &Item,
        allowed: &dyn Fn(Ground) -> bool,
        reach: Reach,
        rng: &mut Rng,
        tries: &mut Tries<'_>,
    ) -> Option<Rest> {
        let (cells, nearby) = self.cells(item, allowed, reach);
        let near_count = if nearby.is_empty() { 0 } else { (AWAY_SAMPLES as f32 * NEARBY) as usize };
        let least = tries.left - tries.left / AT_ONCE;
        let mut failed = Failed::of(&item.shape);
        for (cells, count) in [(nearby, near_count), (cells, AWAY_SAMPLES - near_count)] {
            for Drawn { distance_m, surface, at } in self.draw(&cells, count, item.pose.at, rng) {
                if failed.is_beside(surface, at) {
                    continue;
                }
                let found = self.try_in_turn(item, (surface, at), reach, tries);
                let verdict = found.err().unwrap_or(Verdict::Taken);
                tries.samples.push(Sample { at, score: -distance_m, verdict });
                if found.is_ok() {
                    return found.ok();
                }
                failed.add(surface, at);
                if tries.left <= least {
                    return None;
                }
            }
        }
        None
    }

    /// Looks at a place, closely only if it isn't plainly taken.
    fn try_in_turn(
        &self,
        item: &Item,
        (surface, at): Cell,
        reach: Reach,
        tries: &mut Tries<'_>,
    ) -> Result<Rest, Verdict> {
        // Why a place won't do is told of those that are kept for the overlay; of the others only that it won't.
        if tries.samples.len() >= KEPT && tries.crowd.has_taken(surface, flat(at)) {
            return Err(Verdict::Collides);
        }
        let soft = self.world.stage.surfaces[surface].soft;
        let onto = Onto::Surface { number: surface, height_m: at.y, soft };
        if let Some(verdict) = self.plainly_not(item, flat(at), onto, reach, &tries.avoid) {
            return Err(verdict);
        }
        let found = self.try_at(item, flat(at), onto, reach, &tries.avoid);
        tries.left -= usize::from(found.is_err());
        found
    }

    /// Where a thing may stand: all cells, and of them those near to where it is.
    fn cells(&self, item: &Item, allowed: &dyn Fn(Ground) -> bool, reach: Reach) -> (Vec<Cell>, Vec<Cell>) {
        let from = item.pose.at;
        let farthest_m = if reach == Reach::Near { FARTHEST_M } else { f32::INFINITY };
        let height_m = item.shape.bounds.size().y;
        let (mut cells, mut nearby): (Vec<Cell>, Vec<Cell>) = Default::default();
        let surfaces = self.world.stage.surfaces.iter().enumerate().filter(|(_, s)| allowed(s.ground));
        for (number, surface) in surfaces {
            for (at, clear_m) in &surface.cells {
                let distance_m = at.distance(from);
                let fits = *clear_m > height_m && distance_m < farthest_m;
                if fits && (reach == Reach::InTheZone || !self.zone.holds_point(flat(*at), at.y)) {
                    cells.push((number, *at));
                    if distance_m < NEARBY_M {
                        nearby.push((number, *at));
                    }
                }
            }
        }
        (cells, nearby)
    }

    /// Places, the nearest to `from` first.
    fn draw(&self, cells: &[Cell], count: usize, from: Vec3, rng: &mut Rng) -> NearestFirst {
        if cells.is_empty() {
            return NearestFirst::default();
        }
        let one = |_| {
            let (surface, cell) = cells[rng.random_range(0..cells.len())];
            let half = 0.5 * self.world.stage.surfaces[surface].cell_m;
            let at = cell + Vec3::new(rng.random_range(-half..half), 0.0, rng.random_range(-half..half));
            Drawn { distance_m: at.distance(from), surface, at }
        };
        NearestFirst { drawn: (0..count).map(one).collect(), ..NearestFirst::default() }
    }

    /// What is known of a place without looking closely.
    fn plainly_not(
        &self,
        item: &Item,
        at: Vec2,
        onto: Onto,
        reach: Reach,
        avoid: &Avoid<'_>,
    ) -> Option<Verdict> {
        let nominal = Pose { at: Vec3::new(at.x, onto.height_m(), at.y), ..item.pose };
        if reach != Reach::InTheZone && self.zone.holds(&item.shape, &nominal) {
            return Some(Verdict::InTheZone);
        }
        let taken = self.world.is_plainly_taken(&item.shape, at, item.pose.yaw_rad, onto, avoid);
        taken.then_some(Verdict::Collides)
    }

    fn try_at(
        &self,
        item: &Item,
        at: Vec2,
        onto: Onto,
        reach: Reach,
        avoid: &Avoid<'_>,
    ) -> Result<Rest, Verdict> {
        let rest = self
            .world
            .place_closely(&item.shape, at, item.pose.yaw_rad, onto, avoid)
            .map_err(Verdict::from)?;
        if reach != Reach::InTheZone && self.zone.holds(&item.shape, &rest.pose) {
            return Err(Verdict::InTheZone);
        }
        Ok(rest)
    }

    /// On top of something that its kind may lie on, the nearest first.
    fn on_a_stack(&self, item: &Item, kind: Option<&Kind>, rng: &mut Rng) -> Option<Rest> {
        let below = |name: &String| self.library.named(name);
        let kinds: Vec<_> = kind?.stacks_on.iter().filter_map(below).collect();
        let mut bases: Vec<(f32, &Arc<Item>)> = self
            .world
            .items()
            .filter(|base| base.id != item.id && !self.lifted.contains(&base.id))
            .filter(|base| base.kind.is_some_and(|k| kinds.contains(&k)))
            .filter(|base| item.shape.plan_m2() < LARGER * base.shape.plan_m2())
            .filter(|base| self.world.carried_by(base.id).is_empty())
            .map(|base| (base.pose.at.distance(item.pose.at), base))
            .filter(|(distance_m, _)| *distance_m < FARTHEST_M)
            .collect();
        bases.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.id.cmp(&b.1.id)));
        let avoid = Avoid::new(self.lifted, self.balls);
        bases.into_iter().take(12).find_map(|(_, base)| {
            if self.stack_m(base) > HIGHEST_STACK_M {
                return None;
            }
            let onto = Onto::Item { id: base.id, top_m: base.bounds.max.y };
            (0..6).find_map(|k| {
                let off = Vec2::from_angle(rng.random_range(-PI..PI)) * 0.02 * k as f32 / 6.0;
                let at = flat(base.bounds.center()) + off;
                let plainly_not = self.plainly_not(item, at, onto, Reach::Near, &avoid).is_some();
                if plainly_not { None } else { self.try_at(item, at, onto, Reach::Near, &avoid).ok() }
            })
        })
    }

    /// How high a thing's top is over what the stack that it belongs to stands on.
    fn stack_m(&self, top: &Arc<Item>) -> f32 {
        let mut base = top;
        for _ in 0..32 {
            let Held::Item(id) = base.held else { break };
            let Some(next) = self.world.item(id) else { break };
            base = next;
        }
        top.bounds.max.y - base.bounds.min.y
    }
}

/// Whether a thing may be put on a ground: where its kind says, or where it was found.
fn suits(kind: Option<&Kind>, item: &Item, world: &World, ground: Ground) -> bool {
    match (kind, item.held) {
        (Some(kind), _) => kind.on.contains(&ground),
        (None, Held::Surface(number)) => {
            world.stage.surfaces.get(number).is_some_and(|s| s.ground == ground) || ground == Ground::Table
        }
        (None, _) => matches!(ground, Ground::Table | Ground::Stand),
    }
}
