//! Rooms made by rule: a kind of room and a seed give a furnished [`Layout`].
//!
//! Furniture stands at walls or in groups as people use it: a sofa looks at its coffee table and at the television, chairs
//! stand around tables in number by the table's size, desks have a chair, beds have nightstands and room to get in.
//! Doors and windows stay free, nothing overlaps, and from the door one can walk everywhere. Pure and repeatable: no
//! clock, no files. The layout names bundled models; who composes it brings them.

mod building;
mod clutter;
mod dice;
mod group;
mod kits;
mod palette;
mod plan;
mod rooms;
mod stock;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use super::Layout;
use dice::Dice;
use palette::Palette;

/// Rooms made before one is accepted whose essentials found no place: never more than a few are needed.
const ATTEMPTS: u64 = 40;

/// A kind of room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum RoomType {
    /// Sofa, television, sometimes a dining table.
    Living,
    /// A bed for two, wardrobe.
    Bedroom,
    /// Desks.
    Office,
    /// A dining table, with or without a kitchen.
    Dining,
    /// Everything in one room.
    Studio,
    /// Rows of seats, as where people wait.
    Lounge,
    /// A small bed, low table, toys.
    Children,
    /// A bed, an armchair.
    Guest,
}

impl RoomType {
    /// Every kind.
    pub const ALL: [Self; 8] = [
        Self::Living,
        Self::Bedroom,
        Self::Office,
        Self::Dining,
        Self::Studio,
        Self::Lounge,
        Self::Children,
        Self::Guest,
    ];

    /// Name on the command line.
    pub fn key(self) -> &'static str {
        match self {
            Self::Living => "living",
            Self::Bedroom => "bedroom",
            Self::Office => "office",
            Self::Dining => "dining",
            Self::Studio => "studio",
            Self::Lounge => "lounge",
            Self::Children => "children",
            Self::Guest => "guest",
        }
    }

    /// Name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Living => "Living room",
            Self::Bedroom => "Bedroom",
            Self::Office => "Office",
            Self::Dining => "Kitchen and dining room",
            Self::Studio => "Studio flat",
            Self::Lounge => "Lounge or waiting room",
            Self::Children => "Children's room",
            Self::Guest => "Guest room",
        }
    }

    /// The kind that a [`RoomType::key`] names.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.key() == key)
    }
}

/// A furnished room of a kind. The same seed gives the same layout on every machine.
pub fn procedural_layout(kind: RoomType, seed: u64) -> Layout {
    let (mut layout, mut done) = attempt(kind, seed, 0);
    for number in 1..ATTEMPTS {
        if done {
            break;
        }
        (layout, done) = attempt(kind, seed, number);
    }
    layout
}

/// One try; whether it has what makes it this kind of room.
fn attempt(kind: RoomType, seed: u64, number: u64) -> (Layout, bool) {
    let mut dice = Dice::new(seed.wrapping_mul(ATTEMPTS).wrapping_add(number) ^ ((kind as u64) << 56));
    let palette = Palette::new(&mut dice);
    let (mut layout, mut room) = building::building(&mut dice, kind.label(), &rooms::sizes(kind), &palette);
    let height_m = layout.height_m;
    let mut recipe = rooms::Recipe { dice: &mut dice, room: &mut room, palette: &palette, height_m };
    let done = rooms::furnish(kind, &mut recipe);
    clutter::clutter(&mut dice, &mut room);
    layout.furniture = room.placements;
    (layout, done)
}
