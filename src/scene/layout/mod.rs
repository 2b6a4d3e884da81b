//! Room layouts: a small RON text that says how a room is built and furnished, and what it means as a model.
//!
//! [`Layout::read`] takes the text, [`compose`] builds the room: walls of real thickness with windows and
//! doors, floor, ceiling, skirting, and furniture from model files or made on the spot. Pure: the furniture
//! files come from the caller. The same layout and furniture give the same model, bit for bit.

mod mesh;
mod pieces;
mod place;
mod procedural;
mod seats;
mod shell;
mod soft;
mod surface;
#[cfg(test)]
mod tests;
mod things;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::assets::Model;
pub use pieces::{Art, Item};
pub use procedural::{RoomType, procedural_layout};
pub use things::{made_names, made_thing};

/// A colour as people give it: red, green and blue from 0 to 255, sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Srgb(pub u8, pub u8, pub u8);

/// A room and its furniture. Metres; Y up; the floor at `y = 0`; plan coordinates are `(x, z)`.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layout {
    /// Name of the room.
    pub name: String,
    /// Where the walls' inner faces run.
    pub outline: Outline,
    /// From floor to ceiling.
    pub height_m: f32,
    /// Thickness of the walls.
    #[serde(default = "default_wall_thickness")]
    pub wall_thickness_m: f32,
    /// What the floor is made of.
    pub floor: Floor,
    /// Colour of the walls.
    pub walls: Srgb,
    /// Walls of another colour, by number.
    #[serde(default)]
    pub accent_walls: BTreeMap<usize, Srgb>,
    /// Colour of the ceiling.
    pub ceiling: Srgb,
    /// Boards along the foot of the walls.
    #[serde(default)]
    pub skirting: Option<Skirting>,
    /// Windows, each in one wall.
    #[serde(default)]
    pub windows: Vec<Window>,
    /// Doors, each in one wall.
    #[serde(default)]
    pub doors: Vec<Door>,
    /// What stands, lies and hangs in the room.
    #[serde(default)]
    pub furniture: Vec<Placement>,
}

fn default_wall_thickness() -> f32 {
    0.1
}

/// The inner edge of the walls in plan. Wall `i` runs from corner `i` to the next.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Outline {
    /// Width (x) and depth (z) about the origin. Wall 0 is at the back (-z), 1 right (+x), 2 front, 3 left.
    Box(f32, f32),
    /// Corners `(x, z)`, clockwise seen from above (from +x towards +z).
    Polygon(Vec<(f32, f32)>),
}

/// What the floor is made of.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub enum Floor {
    /// Wooden planks along x, of about this colour.
    Planks(Srgb),
    /// One colour.
    Plain(Srgb),
}

/// Boards along the foot of the walls, left out at doors.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Skirting {
    /// Height of the boards.
    pub height_m: f32,
    /// How far they stand out from the wall.
    pub depth_m: f32,
    /// Their colour.
    pub color: Srgb,
}

/// A window in a wall: frame, glass and an inner sill.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// Number of the wall.
    pub wall: usize,
    /// From the wall's first corner to the window's middle.
    pub at_m: f32,
    /// From the floor to the opening.
    pub sill_m: f32,
    /// Width of the opening.
    pub width_m: f32,
    /// Height of the opening.
    pub height_m: f32,
    /// Colour of the frame.
    pub color: Srgb,
}

/// A closed door in a wall.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Door {
    /// Number of the wall.
    pub wall: usize,
    /// From the wall's first corner to the door's middle.
    pub at_m: f32,
    /// Width of the opening.
    pub width_m: f32,
    /// Height of the opening.
    pub height_m: f32,
    /// Colour of leaf and frame.
    pub color: Srgb,
}

/// One thing in the room.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// What it is: a model file or a piece made on the spot. Its front looks along +z, its origin is the
    /// middle of its underside.
    pub item: Item,
    /// Name of the object.
    pub name: String,
    /// Category by its label, such as `"couch"`.
    pub category: String,
    /// Where its origin goes; with `on`, the height counts from the top of that object.
    pub at: (f32, f32, f32),
    /// Turn about the vertical in degrees: 0 looks along +z, 90 along +x.
    #[serde(default)]
    pub yaw_deg: f32,
    /// Size against the original.
    #[serde(default = "default_scale")]
    pub scale: f32,
    /// Name of the object it stands on, which must come earlier; the floor if none.
    #[serde(default)]
    pub on: Option<String>,
    /// Colours every material of a model.
    #[serde(default)]
    pub tint: Option<Srgb>,
    /// Gives single materials of a model, by name, a plain colour instead of their own look.
    #[serde(default)]
    pub finish: BTreeMap<String, Srgb>,
}

fn default_scale() -> f32 {
    1.0
}

/// What is wrong with a layout.
#[derive(Debug, thiserror::Error)]
pub enum LayoutError {
    /// The text isn't a layout.
    #[error("line {line}, column {column}: {problem}")]
    Syntax {
        /// Line in the text, from 1.
        line: usize,
        /// Column in the text, from 1.
        column: usize,
        /// What the parser expected.
        problem: String,
    },
    /// A size is zero, negative or absurd.
    #[error("{what} is {value_m} m; give it {least_m} to {most_m} m")]
    Size {
        /// Which measure.
        what: String,
        /// Its value.
        value_m: f32,
        /// The smallest that makes sense.
        least_m: f32,
        /// The largest that makes sense.
        most_m: f32,
    },
    /// The outline encloses no room.
    #[error("the outline {problem}; list at least three corners (x, z), clockwise seen from above")]
    Outline {
        /// What is wrong with it.
        problem: String,
    },
    /// A window or door is in a wall that doesn't exist.
    #[error("{what} is in wall {wall}, but the walls are numbered 0 to {last}")]
    NoSuchWall {
        /// The window or door.
        what: String,
        /// The number it gives.
        wall: usize,
        /// The last wall's number.
        last: usize,
    },
    /// A window or door sticks out of its wall or into another opening.
    #[error("{what} doesn't fit into wall {wall}: {problem}; move it with at_m or make it smaller")]
    Opening {
        /// The window or door.
        what: String,
        /// The wall's number.
        wall: usize,
        /// What it collides with.
        problem: String,
    },
    /// A category isn't one of the known labels.
    #[error(
        "'{name}' has the unknown category '{category}'; use a label such as \"couch\", \"chair\" or \"objects\""
    )]
    Category {
        /// The object.
        name: String,
        /// What it gives as its category.
        category: String,
    },
    /// Two objects have one name.
    #[error("two objects are called '{name}'; names must differ, so that `on` and reports are clear")]
    SameName {
        /// The name.
        name: String,
    },
    /// A furniture model can't be had.
    #[error("the model '{model}' of '{name}': {problem}")]
    Furniture {
        /// The object.
        name: String,
        /// The model's file name.
        model: String,
        /// Why not.
        problem: String,
    },
    /// `finish` names a material that the model lacks.
    #[error("'{name}' gives a finish to '{material}', which its model lacks; it has {known}")]
    Finish {
        /// The object.
        name: String,
        /// The unknown material.
        material: String,
        /// The materials there are.
        known: String,
    },
    /// `on` names nothing, or nothing below the object.
    #[error("'{name}' stands on '{on}', which {problem}")]
    Support {
        /// The object.
        name: String,
        /// What it should stand on.
        on: String,
        /// Why it can't.
        problem: String,
    },
    /// An object sticks out of the room.
    #[error("'{name}' sticks {outside_m:.3} m out of the room; move it with `at`")]
    Outside {
        /// The object.
        name: String,
        /// How far.
        outside_m: f32,
    },
    /// A picture made on the spot can't be encoded.
    #[error("a texture can't be encoded: {0}")]
    Texture(#[from] image::ImageError),
}

impl Layout {
    /// Reads a layout from RON text. Errors say line and column.
    pub fn read(text: &str) -> Result<Self, LayoutError> {
        ron::from_str(text).map_err(|error| LayoutError::Syntax {
            line: error.span.start.line,
            column: error.span.start.col,
            problem: error.code.to_string(),
        })
    }
}

/// Where furniture comes from: a model for a file name, or why there is none.
pub type Furniture<'a> = dyn Fn(&str) -> Result<Model, String> + 'a;

/// Builds the room: one node per object, named, with extras `{"category": label}`, in metres and Y up.
///
/// `furniture` is asked once for each model file that the layout names. Errors name the object or wall, and
/// what to change.
pub fn compose(layout: &Layout, furniture: &Furniture<'_>) -> Result<Model, LayoutError> {
    let shell = shell::Shell::new(layout)?;
    let mut model = mesh::ModelBuilder::new(&layout.name);
    shell.build(layout, &mut model)?;
    place::furnish(layout, &shell, furniture, &mut model)?;
    Ok(model.finish())
}

/// The bundled model of a file name: the furniture of [`compose`] for procedural rooms and for the samples' layouts.
///
/// # Errors
/// When no such model comes with the program.
pub fn bundled_furniture(file: &str) -> Result<Model, String> {
    let found = crate::assets::furniture_model(file);
    let model = found.ok_or_else(|| "no such model comes with the program".to_owned())?;
    model.map_err(|error| error.to_string())
}

/// A new furnished room of a kind: [`procedural_layout`] composed with the bundled furniture.
///
/// # Errors
/// None is known; a layout that doesn't compose is a mistake of the rules and says what is wrong.
pub fn new_room(kind: RoomType, seed: u64) -> Result<Model, LayoutError> {
    compose(&procedural_layout(kind, seed), &bundled_furniture)
}
