//! Colours that go together: chosen once a room, so that a room has a style.

use super::dice::Dice;
use crate::scene::layout::{Art, Floor, Item, Srgb};

const WALLS: &[Srgb] = &[
    Srgb(240, 234, 224),
    Srgb(236, 236, 232),
    Srgb(244, 240, 232),
    Srgb(226, 230, 226),
    Srgb(232, 226, 214),
    Srgb(222, 228, 234),
    Srgb(240, 228, 218),
];
const ACCENTS: &[Srgb] = &[
    Srgb(164, 182, 166),
    Srgb(146, 164, 182),
    Srgb(196, 160, 130),
    Srgb(122, 138, 128),
    Srgb(186, 120, 100),
    Srgb(208, 190, 150),
    Srgb(98, 116, 138),
    Srgb(214, 196, 190),
];
const FABRICS: &[Srgb] = &[
    Srgb(96, 110, 122),
    Srgb(168, 160, 148),
    Srgb(70, 96, 90),
    Srgb(178, 112, 84),
    Srgb(52, 64, 84),
    Srgb(206, 196, 180),
    Srgb(134, 128, 120),
    Srgb(196, 148, 70),
    Srgb(120, 72, 76),
    Srgb(90, 88, 92),
    Srgb(148, 164, 150),
];
const WOODS: &[Srgb] = &[
    Srgb(112, 74, 46),
    Srgb(176, 134, 92),
    Srgb(206, 172, 130),
    Srgb(74, 54, 42),
    Srgb(236, 232, 224),
    Srgb(60, 60, 62),
    Srgb(150, 106, 70),
];
const FLOORS: &[Srgb] = &[
    Srgb(188, 148, 106),
    Srgb(204, 170, 130),
    Srgb(150, 112, 80),
    Srgb(196, 184, 168),
    Srgb(128, 92, 66),
    Srgb(214, 192, 160),
];
const PLAIN_FLOORS: &[Srgb] = &[
    Srgb(168, 164, 158),
    Srgb(200, 194, 184),
    Srgb(132, 138, 142),
    Srgb(186, 172, 154),
    Srgb(112, 116, 120),
];
const LINEN: &[Srgb] = &[
    Srgb(232, 228, 220),
    Srgb(206, 212, 218),
    Srgb(188, 198, 210),
    Srgb(214, 200, 184),
    Srgb(150, 166, 156),
    Srgb(226, 210, 200),
    Srgb(120, 134, 156),
];
const BOOKS: &[Srgb] = &[
    Srgb(176, 84, 62),
    Srgb(232, 196, 120),
    Srgb(70, 104, 108),
    Srgb(92, 118, 140),
    Srgb(150, 80, 70),
    Srgb(222, 184, 120),
    Srgb(60, 62, 70),
    Srgb(226, 220, 208),
];
/// Warm white of lit shades.
pub const SHADE: Srgb = Srgb(255, 236, 204);
/// Painted wood of doors and window frames.
pub const PAINT: Srgb = Srgb(248, 246, 241);

/// A room's colours.
pub struct Palette {
    pub walls: Srgb,
    pub accent: Srgb,
    pub fabric: Srgb,
    pub fabric_2: Srgb,
    pub wood: Srgb,
    pub wood_2: Srgb,
    pub linen: Srgb,
    pub floor: Floor,
}

impl Palette {
    pub fn new(dice: &mut Dice) -> Self {
        let plain = dice.chance(30);
        Self {
            walls: *dice.pick(WALLS),
            accent: *dice.pick(ACCENTS),
            fabric: *dice.pick(FABRICS),
            fabric_2: *dice.pick(FABRICS),
            wood: *dice.pick(WOODS),
            wood_2: *dice.pick(WOODS),
            linen: *dice.pick(LINEN),
            floor: if plain {
                Floor::Plain(*dice.pick(PLAIN_FLOORS))
            } else {
                Floor::Planks(*dice.pick(FLOORS))
            },
        }
    }
}

pub fn books(dice: &mut Dice) -> Item {
    let count = dice.count(1, 4);
    Item::Books((0..count).map(|_| *dice.pick(BOOKS)).collect())
}

pub fn picture(dice: &mut Dice, size: (f32, f32), palette: &Palette) -> Item {
    let art = if dice.chance(50) { Art::Hills } else { Art::Arches };
    let colors = (*dice.pick(WALLS), *dice.pick(BOOKS), palette.accent, *dice.pick(FABRICS));
    Item::Picture { size, art, colors, frame: palette.wood }
}
