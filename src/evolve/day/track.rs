//! How things move over a day: each at its place until an action wants it elsewhere.

use std::collections::BTreeMap;

use glam::{Affine3A, Quat, Vec3};

use super::{CHANGE_S, Moment};
use crate::assets::{ObjectKey, ObjectMotion};
use crate::evolve::action::Evolution;
use crate::scene::{ObjectId, Room};

/// Where a thing is at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Seconds from the day's beginning.
    pub at_s: f32,
    /// World, metres.
    pub at_m: Vec3,
    /// World from the thing.
    pub rotation: Quat,
}

/// A thing's way through the day: straight from each place to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Which.
    pub object: ObjectId,
    /// Its places at rising times; the last is that in the last state's room.
    pub places: Vec<Place>,
    /// When it comes; `None` for what was there before.
    pub comes_s: Option<f32>,
}

impl Track {
    /// From the thing's frame to the world in the last state's room.
    pub fn last(&self) -> Affine3A {
        self.places
            .last()
            .map_or(Affine3A::IDENTITY, |p| Affine3A::from_rotation_translation(p.rotation, p.at_m))
    }

    /// The same for a file of `room`, the last state's; `None` for what is not drawn there.
    pub fn motion_in(&self, room: &Room) -> Option<ObjectMotion> {
        let node = room.objects.iter().position(|o| o.id == self.object && !o.parts.is_empty())?;
        let key = |p: &Place| ObjectKey { at_s: p.at_s, translation_m: p.at_m, rotation: p.rotation };
        let keys = self.places.iter().map(key).collect();
        Some(ObjectMotion { node, model_from_object: self.last(), keys, comes_s: self.comes_s })
    }
}

/// The tracks of all that comes or moves, by the things' numbers.
pub(super) fn tracks(states: &[Evolution], moments: &[Moment]) -> Vec<Track> {
    let mut found: BTreeMap<ObjectId, Track> = BTreeMap::new();
    for (pair, moment) in states.windows(2).zip(moments) {
        for item in pair[1].world().items() {
            let now = place(&item.world_from_found(), moment.changes_s + CHANGE_S);
            match pair[0].world().item(item.id) {
                None => {
                    let came = Place { at_s: moment.changes_s, ..now };
                    let track =
                        Track { object: item.id, places: vec![came], comes_s: Some(moment.changes_s) };
                    found.insert(item.id, track);
                }
                Some(before) if before.pose != item.pose => {
                    let was = place(&before.world_from_found(), moment.changes_s);
                    let fresh = || Track { object: item.id, places: Vec::new(), comes_s: None };
                    found.entry(item.id).or_insert_with(fresh).places.extend([was, now]);
                }
                Some(_) => {}
            }
        }
    }
    found.into_values().collect()
}

fn place(world_from_thing: &Affine3A, at_s: f32) -> Place {
    let (_, rotation, at_m) = world_from_thing.to_scale_rotation_translation();
    Place { at_s, at_m, rotation }
}
