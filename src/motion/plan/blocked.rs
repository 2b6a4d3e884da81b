//! Why somebody can't get somewhere, with what is in the way.

use glam::{Vec2, Vec3};

use super::{Planner, Spot, flat};
use crate::scene::{ObjectId, Room};

/// Heights at which something in the way is looked for, metres: shins, seats, table tops, chests.
const LOOK_M: [f32; 4] = [0.25, 0.45, 0.75, 1.2];
/// Farthest thing that is named as what leaves no room, metres.
const NEAR_M: f32 = 1.0;

/// Why a spot can't be reached.
#[derive(Clone, Debug, PartialEq)]
pub enum Blocked {
    /// It lies outside the room's floor.
    OffFloor {
        /// The spot.
        at: Vec3,
    },
    /// Nobody fits there.
    NobodyFits {
        /// The spot.
        at: Vec3,
        /// Free radius there, metres.
        clearance_m: f32,
        /// Free radius that a person needs, metres.
        needed_m: f32,
        /// What stands nearest.
        object: Option<ObjectId>,
    },
    /// There is room at both ends and no way between them.
    NoWay {
        /// Where one comes from.
        from: Vec3,
        /// Where one wants to go.
        to: Vec3,
        /// Whether the goal lies in an area of its own, shut off from the largest part of the floor.
        enclosed: bool,
        /// The nearest thing on the straight line.
        object: Option<ObjectId>,
    },
    /// The room affords nothing of the kind near the spot.
    NoPlace {
        /// The spot.
        at: Vec3,
        /// What was looked for.
        wanted: &'static str,
    },
}

impl Blocked {
    /// What, where, and what to do, for people.
    pub fn in_words(&self, room: &Room) -> String {
        let name = |id: &Option<ObjectId>| {
            id.and_then(|id| room.object(id)).map_or_else(|| "something".to_owned(), |o| o.name.clone())
        };
        let place = |p: &Vec3| format!("({:.2}, {:.2}, {:.2})", p.x, p.y, p.z);
        match self {
            Self::OffFloor { at } => {
                format!("{} lies outside the room's floor: choose a point inside", place(at))
            }
            Self::NobodyFits { at, clearance_m, needed_m, object } => format!(
                "nobody fits at {}: {:.0} cm are free around it, {:.0} cm are needed, {} is too near; move the goal or \
                 the furniture",
                place(at),
                100.0 * clearance_m,
                100.0 * needed_m,
                name(object)
            ),
            Self::NoWay { from, to, enclosed, object } => format!(
                "there is no way from {} to {}: {} is in the way{}; make a gap of 32 cm or choose another goal",
                place(from),
                place(to),
                name(object),
                if *enclosed { ", and the goal lies in an area of its own" } else { "" }
            ),
            Self::NoPlace { at, wanted } => {
                format!("there is nothing to {wanted} on near {}: choose a seat, a sofa or a bed", place(at))
            }
        }
    }
}

impl Planner<'_> {
    /// Why nobody can stand at `spot`.
    pub(super) fn no_room(&self, spot: &Spot, needed_m: f32) -> Blocked {
        let floor = self.floor();
        let at = self.on_floor(spot.at);
        match floor.cell_at(spot.at) {
            None => Blocked::OffFloor { at },
            Some(cell) => Blocked::NobodyFits {
                at,
                clearance_m: floor.clearance_m[cell],
                needed_m,
                object: self.nearest_object(at),
            },
        }
    }

    /// Why there is no way between two spots that have room.
    pub(super) fn apart(&self, from: &Spot, to: &Spot) -> Blocked {
        let (from, to) = (self.on_floor(from.at), self.on_floor(to.at));
        let area = |p: Vec3| self.floor().cell_at(flat(p)).and_then(|cell| self.floor().area[cell]);
        let enclosed = area(to).is_some_and(|a| a != 0) && area(from) != area(to);
        Blocked::NoWay { from, to, enclosed, object: self.object_between(from, to) }
    }

    /// The point of the floor below (x, z).
    pub fn on_floor(&self, xz: Vec2) -> Vec3 {
        let height_m = self.floor().cell_at(xz).map_or(0.0, |cell| self.floor().height_m[cell]);
        Vec3::new(xz.x, height_m, xz.y)
    }

    /// The nearest thing that a person who goes straight from `from` to `to` would run into.
    pub fn object_between(&self, from: Vec3, to: Vec3) -> Option<ObjectId> {
        let way = to - from;
        let direction = way.try_normalize()?;
        let hits = LOOK_M.iter().filter_map(|height_m| {
            self.geometry.bvh.cast(from + Vec3::Y * *height_m, direction, way.length())
        });
        let first = hits.min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))?;
        self.geometry.object_of(first.triangle)
    }

    fn nearest_object(&self, at: Vec3) -> Option<ObjectId> {
        let near = LOOK_M.iter().filter_map(|h| self.geometry.bvh.closest(at + Vec3::Y * *h, NEAR_M));
        let nearest = near.min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))?;
        self.geometry.object_of(nearest.triangle)
    }
}
