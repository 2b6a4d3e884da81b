use serde::{Deserialize, Serialize};

/// What an object is: the 40 categories of Matterport3D (mpcat40) and the papers' key objects that are
/// finer than these (desk, dining table, coffee table, kitchen island).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[expect(missing_docs, reason = "each name says what it is")]
pub enum Category {
    Wall,
    Floor,
    Chair,
    Door,
    Table,
    Picture,
    Cabinet,
    Cushion,
    Window,
    Sofa,
    Bed,
    Curtain,
    ChestOfDrawers,
    Plant,
    Sink,
    Stairs,
    Ceiling,
    Toilet,
    Stool,
    Towel,
    Mirror,
    TvMonitor,
    Shower,
    Column,
    Bathtub,
    Counter,
    Fireplace,
    Lighting,
    Beam,
    Railing,
    Shelving,
    Blinds,
    GymEquipment,
    Seating,
    BoardPanel,
    Furniture,
    Appliances,
    Clothes,
    Objects,
    Misc,
    OfficeDesk,
    DiningTable,
    CoffeeTable,
    KitchenIsland,
    #[default]
    Unlabeled,
}

impl Category {
    /// Every category, in mpcat40's order, then the key objects, then `Unlabeled`.
    pub const ALL: [Self; 45] = [
        Self::Wall,
        Self::Floor,
        Self::Chair,
        Self::Door,
        Self::Table,
        Self::Picture,
        Self::Cabinet,
        Self::Cushion,
        Self::Window,
        Self::Sofa,
        Self::Bed,
        Self::Curtain,
        Self::ChestOfDrawers,
        Self::Plant,
        Self::Sink,
        Self::Stairs,
        Self::Ceiling,
        Self::Toilet,
        Self::Stool,
        Self::Towel,
        Self::Mirror,
        Self::TvMonitor,
        Self::Shower,
        Self::Column,
        Self::Bathtub,
        Self::Counter,
        Self::Fireplace,
        Self::Lighting,
        Self::Beam,
        Self::Railing,
        Self::Shelving,
        Self::Blinds,
        Self::GymEquipment,
        Self::Seating,
        Self::BoardPanel,
        Self::Furniture,
        Self::Appliances,
        Self::Clothes,
        Self::Objects,
        Self::Misc,
        Self::OfficeDesk,
        Self::DiningTable,
        Self::CoffeeTable,
        Self::KitchenIsland,
        Self::Unlabeled,
    ];

    /// Number in mpcat40: 1 wall to 40 misc, 41 unlabelled. Key objects give their coarse category's number.
    pub fn mpcat40(self) -> u8 {
        match self {
            Self::OfficeDesk | Self::DiningTable | Self::CoffeeTable => Self::Table.mpcat40(),
            Self::KitchenIsland => Self::Counter.mpcat40(),
            Self::Unlabeled => 41,
            coarse => coarse as u8 + 1,
        }
    }

    /// Name for people, reports and the command line.
    pub fn label(self) -> &'static str {
        match self {
            Self::Wall => "wall",
            Self::Floor => "floor",
            Self::Chair => "chair",
            Self::Door => "door",
            Self::Table => "table",
            Self::Picture => "picture",
            Self::Cabinet => "cabinet",
            Self::Cushion => "cushion",
            Self::Window => "window",
            Self::Sofa => "couch",
            Self::Bed => "bed",
            Self::Curtain => "curtain",
            Self::ChestOfDrawers => "chest of drawers",
            Self::Plant => "plant",
            Self::Sink => "sink",
            Self::Stairs => "stairs",
            Self::Ceiling => "ceiling",
            Self::Toilet => "toilet",
            Self::Stool => "stool",
            Self::Towel => "towel",
            Self::Mirror => "mirror",
            Self::TvMonitor => "tv monitor",
            Self::Shower => "shower",
            Self::Column => "column",
            Self::Bathtub => "bathtub",
            Self::Counter => "counter",
            Self::Fireplace => "fireplace",
            Self::Lighting => "lighting",
            Self::Beam => "beam",
            Self::Railing => "railing",
            Self::Shelving => "shelving",
            Self::Blinds => "blinds",
            Self::GymEquipment => "gym equipment",
            Self::Seating => "seating",
            Self::BoardPanel => "board panel",
            Self::Furniture => "furniture",
            Self::Appliances => "appliances",
            Self::Clothes => "clothes",
            Self::Objects => "objects",
            Self::Misc => "misc",
            Self::OfficeDesk => "office desk",
            Self::DiningTable => "dining table",
            Self::CoffeeTable => "coffee table",
            Self::KitchenIsland => "kitchen island",
            Self::Unlabeled => "unlabeled",
        }
    }

    /// The category that a label (of [`Category::label`]) names.
    pub fn from_label(label: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.label() == label)
    }

    /// Whether it is part of the building: never moved, never sat on (but for the floor).
    pub fn is_structure(self) -> bool {
        matches!(
            self,
            Self::Wall
                | Self::Floor
                | Self::Ceiling
                | Self::Door
                | Self::Window
                | Self::Column
                | Self::Beam
                | Self::Stairs
                | Self::Railing
        )
    }

    /// Whether people sit on it.
    pub fn is_seat(self) -> bool {
        matches!(self, Self::Chair | Self::Sofa | Self::Stool | Self::Bed | Self::Seating)
    }

    /// Whether it is a table, desk, counter or island: something to lean on and to put things on.
    pub fn is_table(self) -> bool {
        matches!(
            self,
            Self::Table
                | Self::OfficeDesk
                | Self::DiningTable
                | Self::CoffeeTable
                | Self::KitchenIsland
                | Self::Counter
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn categories_keep_matterports_numbers_and_names() {
        assert_eq!(Category::Wall.mpcat40(), 1);
        assert_eq!(Category::Bed.mpcat40(), 11);
        assert_eq!(Category::Misc.mpcat40(), 40);
        assert_eq!(Category::CoffeeTable.mpcat40(), 5);
        for c in Category::ALL {
            assert_eq!(Category::from_label(c.label()), Some(c));
        }
    }
}
