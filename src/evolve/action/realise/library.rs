//! What kinds of things there are: models, attitudes, where they may stand, how many a room takes. The bundled
//! library is data (`assets/objects/library.ron`); own kinds and models are added to a copy.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use glam::{Affine3A, EulerRot, Quat, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::assets::{Model, furniture_model, library_text, object_model};
use crate::math::Aabb;
use crate::scene::Category;
use crate::scene::layout::made_thing;

use super::shape::Shape;

/// Number of a kind in its [`Library`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KindId(pub usize);

/// Where a thing's front (+z) looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Faces {
    /// At the person who uses it.
    Person,
    /// Away from that person: a mouse, a remote control.
    Away,
    /// At the nearest seat or bed.
    Seat,
    /// Anywhere.
    #[default]
    Free,
}

/// What a thing may stand on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Ground {
    /// Tops of tables, desks, counters.
    Table,
    /// Tops of cabinets, chests, shelves.
    Stand,
    /// Beds, couches, fixed armchairs.
    Seat,
    /// The floor.
    Floor,
}

/// One kind of thing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kind {
    /// Its name, singular, lower case.
    pub kind: String,
    /// COCO's categories that are this.
    #[serde(default)]
    pub labels: Vec<String>,
    /// Words that tell it in the names of a room's objects.
    #[serde(default)]
    pub words: Vec<String>,
    /// Label of the room category that its objects get.
    pub category: String,
    /// Where its front looks.
    #[serde(default)]
    pub faces: Faces,
    /// How far it is off that, standard deviation in degrees.
    #[serde(default)]
    pub spread_deg: f32,
    /// How many a room takes before they are re-used.
    pub most: usize,
    /// How many one person uses at once: photos show other people's things too.
    #[serde(default = "one")]
    pub at_once: usize,
    /// What it may stand on, best first.
    pub on: Vec<Ground>,
    /// Kinds that it may lie on where there is no free surface.
    #[serde(default)]
    pub stacks_on: Vec<String>,
    /// Kinds that it lies on while in use.
    #[serde(default)]
    pub served_on: Vec<String>,
    /// Attitudes as degrees about x, y, z; upright when empty.
    #[serde(default)]
    pub rests: Vec<(f32, f32, f32)>,
    /// Stays where it is once it is there: a television, a microwave.
    #[serde(default)]
    pub stays: bool,
    /// Its models: `objects/FILE`, `furniture/FILE`, `made/NAME` or `own/NAME`.
    pub models: Vec<String>,
}

fn one() -> usize {
    1
}

/// How often something that the photos have no word for is there, and where; written by hand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Companion {
    /// Label of the action type.
    pub action: String,
    /// The kind.
    pub object: String,
    /// Probability of none, one, two …
    pub probability: Vec<f64>,
    /// Median distance from the person, metres.
    pub distance_m: f64,
    /// Standard deviation of the distance's logarithm.
    pub spread: f64,
    /// Direction in degrees: 0 to the person's right, 90 in front.
    pub angle_deg: f64,
    /// Concentration of the direction.
    pub kappa: f64,
}

/// What can be wrong with a library.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    /// Not the text it should be.
    #[error("object library: {0}; compare with the library that comes with the program")]
    Syntax(#[from] ron::error::SpannedError),
    /// A kind's model can't be had.
    #[error("object library, kind \"{kind}\", model {model}: {problem}")]
    Model {
        /// The kind.
        kind: String,
        /// The model's name.
        model: String,
        /// Why not.
        problem: String,
    },
    /// A kind without models or with an unknown category.
    #[error("object library, kind \"{kind}\": {problem}")]
    Kind {
        /// The kind.
        kind: String,
        /// What is wrong.
        problem: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    kinds: Vec<Kind>,
    fixtures: Vec<String>,
    companions: Vec<Companion>,
}

/// A model in one attitude, ready to be placed: stands on y = 0 about its middle, front along +z.
#[derive(Debug)]
pub struct Thing {
    /// Its model's name in the library.
    pub name: String,
    /// The model.
    pub model: Arc<Model>,
    /// From the model's file frame to the thing's.
    pub thing_from_file: Affine3A,
    /// Its geometry.
    pub shape: Arc<Shape>,
}

/// Things that were made, by model and number of the attitude.
type Made = BTreeMap<(String, usize), Arc<Thing>>;

/// All kinds.
#[derive(Debug)]
pub struct Library {
    kinds: Vec<Kind>,
    fixtures: Vec<String>,
    companions: Vec<Companion>,
    own: BTreeMap<String, Arc<Model>>,
    made: Mutex<Made>,
}

impl Clone for Library {
    fn clone(&self) -> Self {
        Self {
            kinds: self.kinds.clone(),
            fixtures: self.fixtures.clone(),
            companions: self.companions.clone(),
            own: self.own.clone(),
            made: Mutex::new(self.made.lock().unwrap_or_else(PoisonError::into_inner).clone()),
        }
    }
}

static BUNDLED: LazyLock<Arc<Library>> = LazyLock::new(|| {
    let empty = Library {
        kinds: vec![],
        fixtures: vec![],
        companions: vec![],
        own: BTreeMap::new(),
        made: Mutex::default(),
    };
    // The bundled text is read by a test: what is wrong with it is found there.
    Arc::new(Library::read(library_text()).unwrap_or(empty))
});

impl Library {
    /// The library that comes with the program.
    pub fn bundled() -> Arc<Self> {
        BUNDLED.clone()
    }

    /// Reads a library from RON text.
    ///
    /// # Errors
    /// [`LibraryError`] names the kind or the place in the text.
    pub fn read(text: &str) -> Result<Self, LibraryError> {
        let text: Text = ron::from_str(text)?;
        let mut library = Self {
            kinds: Vec::new(),
            fixtures: text.fixtures,
            companions: text.companions,
            own: BTreeMap::new(),
            made: Mutex::default(),
        };
        text.kinds.into_iter().try_for_each(|kind| library.add(kind).map(|_| ()))?;
        Ok(library)
    }

    /// Adds a kind, or replaces that of the same name.
    ///
    /// # Errors
    /// [`LibraryError::Kind`].
    pub fn add(&mut self, kind: Kind) -> Result<KindId, LibraryError> {
        let wrong =
            |problem: &str| Err(LibraryError::Kind { kind: kind.kind.clone(), problem: problem.to_owned() });
        if kind.models.is_empty() {
            return wrong("it has no model");
        }
        if kind.on.is_empty() {
            return wrong("it may stand on nothing: list Table, Stand, Seat or Floor");
        }
        if Category::from_label(&kind.category).is_none() {
            return wrong("its category is none of a room's");
        }
        match self.kinds.iter().position(|k| k.kind == kind.kind) {
            Some(known) => {
                self.kinds[known] = kind;
                Ok(KindId(known))
            }
            None => {
                self.kinds.push(kind);
                Ok(KindId(self.kinds.len() - 1))
            }
        }
    }

    /// Adds a model of one's own to a kind: metres, Y up, front along +z, anywhere. Later things of the kind may show it.
    pub fn add_model(&mut self, kind: KindId, name: &str, model: Model) {
        let name = format!("own/{name}");
        self.own.insert(name.clone(), Arc::new(model));
        if let Some(kind) = self.kinds.get_mut(kind.0) {
            kind.models.push(name);
        }
    }

    /// Sets how many of a kind a room takes.
    pub fn set_most(&mut self, kind: KindId, most: usize) {
        if let Some(kind) = self.kinds.get_mut(kind.0) {
            kind.most = most;
        }
    }

    /// Every kind with its number.
    pub fn kinds(&self) -> impl Iterator<Item = (KindId, &Kind)> {
        self.kinds.iter().enumerate().map(|(i, kind)| (KindId(i), kind))
    }

    /// A kind by its number, which must be of this library.
    pub fn kind(&self, id: KindId) -> &Kind {
        &self.kinds[id.0]
    }

    /// The kind of this name.
    pub fn named(&self, kind: &str) -> Option<KindId> {
        self.kinds.iter().position(|k| k.kind == kind).map(KindId)
    }

    /// The kind that a COCO category is, or that is called so.
    pub fn of_label(&self, label: &str) -> Option<KindId> {
        let by_label = self.kinds.iter().position(|k| k.labels.iter().any(|l| l == label));
        by_label.map(KindId).or_else(|| self.named(label))
    }

    /// Whether a COCO category is part of the building's kitchen or bath: neither inserted nor moved.
    pub fn is_fixture(&self, label: &str) -> bool {
        self.fixtures.iter().any(|f| f == label)
    }

    /// The kind that an object's name tells: the longest phrase in it wins, the last of equally long ones.
    pub fn of_name(&self, name: &str) -> Option<KindId> {
        let words = words(name);
        let mut best: Option<(usize, usize, KindId)> = None;
        for (id, kind) in self.kinds() {
            for phrase in &kind.words {
                let phrase: Vec<&str> = phrase.split(' ').collect();
                let place = words
                    .windows(phrase.len())
                    .rposition(|w| w.iter().zip(&phrase).all(|(a, b)| same_word(a, b)));
                let Some(place) = place else { continue };
                if best.is_none_or(|(long, at, _)| (phrase.len(), place) > (long, at)) {
                    best = Some((phrase.len(), place, id));
                }
            }
        }
        best.map(|(_, _, id)| id)
    }

    /// What the photos have no word for, of one type of action.
    pub fn companions<'a>(&'a self, action: &'a str) -> impl Iterator<Item = &'a Companion> {
        self.companions.iter().filter(move |c| c.action == action)
    }

    /// How many looks a kind has: models times attitudes.
    pub fn looks(&self, kind: KindId) -> usize {
        let kind = self.kind(kind);
        kind.models.len() * kind.rests.len().max(1)
    }

    /// Whether a model is of something that lies open.
    pub fn is_open_model(model: &str) -> bool {
        model.contains("_open")
    }

    /// Whether look number `look` of a kind is open.
    pub fn is_open(&self, kind: KindId, look: usize) -> bool {
        let models = &self.kind(kind).models;
        models.get(look % models.len().max(1)).is_some_and(|model| Self::is_open_model(model))
    }

    /// Whether things of a kind can be open.
    pub fn opens(&self, kind: KindId) -> bool {
        self.kind(kind).models.iter().any(|model| Self::is_open_model(model))
    }

    /// Look number `look` (below [`Library::looks`]) of a kind; made once, then shared.
    ///
    /// # Errors
    /// [`LibraryError::Model`] when the model is missing or damaged.
    pub fn thing(&self, kind: KindId, look: usize) -> Result<Arc<Thing>, LibraryError> {
        let spec = self.kind(kind);
        let model = &spec.models[look % spec.models.len()];
        let rest = (look / spec.models.len()) % spec.rests.len().max(1);
        let key = (model.clone(), rest);
        let known = self.made.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if let Some(thing) = known {
            return Ok(thing);
        }
        let wrong =
            |problem: String| LibraryError::Model { kind: spec.kind.clone(), model: model.clone(), problem };
        let read = self.model(model).map_err(wrong)?;
        let thing = Arc::new(Thing::new(model, read, spec.rests.get(rest).copied().unwrap_or_default()));
        self.made.lock().unwrap_or_else(PoisonError::into_inner).insert(key, thing.clone());
        Ok(thing)
    }

    /// Makes every look of every kind, on all threads, so that no action waits for a file to be read. Kinds whose
    /// models are missing are told when they are asked for.
    pub fn warm(&self) {
        let looks: Vec<(KindId, usize)> =
            self.kinds().flat_map(|(id, _)| (0..self.looks(id)).map(move |look| (id, look))).collect();
        looks.par_iter().for_each(|(id, look)| drop(self.thing(*id, *look)));
    }

    fn model(&self, name: &str) -> Result<Arc<Model>, String> {
        let missing = || "there is no such model".to_owned();
        let (folder, file) = name.split_once('/').ok_or_else(missing)?;
        let read = match folder {
            "objects" => object_model(file).ok_or_else(missing)?.map_err(|e| e.to_string())?,
            "furniture" => furniture_model(file).ok_or_else(missing)?.map_err(|e| e.to_string())?,
            "made" => made_thing(file).ok_or_else(missing)?,
            _ => return self.own.get(name).cloned().ok_or_else(missing),
        };
        Ok(Arc::new(read))
    }
}

impl Thing {
    fn new(name: &str, model: Arc<Model>, (x, y, z): (f32, f32, f32)) -> Self {
        let turn = Quat::from_euler(EulerRot::XYZ, x.to_radians(), y.to_radians(), z.to_radians());
        let turned = Affine3A::from_quat(turn);
        let corners = |place: Affine3A| {
            model.parts.iter().flat_map(move |part| {
                let place = place * part.file_from_mesh;
                part.mesh.positions.iter().map(move |p| place.transform_point3(*p))
            })
        };
        let bounds = Aabb::of(corners(turned));
        let middle = bounds.center();
        let foot = Vec3::new(middle.x, bounds.min.y, middle.z);
        let thing_from_file = Affine3A::from_translation(-foot) * turned;
        let triangles = model.parts.iter().flat_map(|part| {
            let place = thing_from_file * part.file_from_mesh;
            (0..part.mesh.triangles.len())
                .map(move |t| part.mesh.corners(t).map(|p| place.transform_point3(p)))
        });
        let shape = Arc::new(Shape::new(triangles.collect()));
        Self { name: name.to_owned(), model, thing_from_file, shape }
    }
}

/// Lower-case words of a name in any of the usual spellings: `Potted plant 2`, `wine-glass.001`, `DeskLamp`.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for c in name.chars() {
        if !c.is_alphabetic() || (c.is_uppercase() && was_lower) {
            words.push(String::new());
        }
        if c.is_alphabetic()
            && let Some(word) = words.last_mut()
        {
            word.extend(c.to_lowercase());
        }
        was_lower = c.is_lowercase();
    }
    words.retain(|w| !w.is_empty());
    words
}

/// Equal but for a plural's ending.
fn same_word(found: &str, known: &str) -> bool {
    found == known || found.strip_suffix('s') == Some(known) || found.strip_suffix("es") == Some(known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bundled_library_knows_forty_kinds_and_more_and_all_can_be_had() {
        let library = Library::read(library_text()).expect("reads");
        assert!(library.kinds().count() >= 60, "{}", library.kinds().count());
        for (id, kind) in library.kinds() {
            for look in 0..library.looks(id) {
                let thing = library.thing(id, look).expect("there");
                let size = thing.shape.bounds.size();
                assert!(size.min_element() > 0.0005 && size.max_element() < 1.2, "{}: {size}", thing.name);
                assert!(thing.model.triangle_count() < 10_000, "{}", thing.name);
            }
            for other in kind.stacks_on.iter().chain(&kind.served_on) {
                assert!(library.named(other).is_some(), "{} on unknown {other}", kind.kind);
            }
        }
    }

    #[test]
    fn names_of_a_rooms_objects_tell_what_they_are() {
        let library = Library::bundled();
        let kind = |name: &str| library.of_name(name).map(|id| library.kind(id).kind.clone());
        for (name, expected) in [
            ("Potted plant", "plant"),
            ("Books on the sideboard", "book"),
            ("wine-glass.001", "wine glass"),
            ("Desk chair", "chair"),
            ("Laptop 2", "laptop"),
            ("Left pillow", "cushion"),
            ("DeskLamp_03", "desk lamp"),
        ] {
            assert_eq!(kind(name).as_deref(), Some(expected), "{name}");
        }
        assert_eq!(kind("Wall 3"), None);
    }

    #[test]
    fn a_library_says_what_is_wrong_with_it() {
        let mut library = (*Library::bundled()).clone();
        let bare = Kind {
            kind: "lamp post".into(),
            category: "objects".into(),
            on: vec![Ground::Floor],
            ..Kind::default()
        };
        let message = library.add(bare.clone()).expect_err("no model").to_string();
        assert!(message.contains("lamp post") && message.contains("no model"), "{message}");
        let id = library.add(Kind { models: vec!["own/post".into()], ..bare }).expect("fine");
        let message = library.thing(id, 0).expect_err("no such model").to_string();
        assert!(message.contains("own/post"), "{message}");
        assert!(Library::read("(kinds: [").is_err());
    }
}
