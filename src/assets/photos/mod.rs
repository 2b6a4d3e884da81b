//! What people wrote about photos: captions, boxes and outlines of things, joints of people, who does what with
//! which thing. Never the photos themselves.
//!
//! Formats, told by their content: COCO json (instances, captions, person_keypoints, or all in one), V-COCO's
//! interactions, lists of people with joints and interactions, LabelMe json, captions as csv, boxes as text, joints as
//! tsv (also gzipped). Many files speak of one photo: [`PhotoSet`] puts together what they say, told by the photo's
//! number or name, and by boxes that lie on each other.

mod boxes;
mod captions;
mod coco;
mod gzip;
mod labelme;
mod persons;
mod poses;
mod vcoco;

use std::collections::BTreeMap;
use std::path::Path;

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::budget::Budget;
use super::error::{AssetError, Fault, Problem};
use super::keypoints::Keypoint;
use super::uri::read_plain_file;

/// Joints of a person: COCO's 17, in the order of [`super::KeypointSet::Coco17`].
pub const PHOTO_JOINTS: usize = 17;
/// Most bytes of one file: more than COCO's largest.
const MAX_BYTES: u64 = 768 << 20;
/// Most photos, people and things over all files: four times all of COCO.
const MAX_PHOTOS: usize = 1_200_000;
const MAX_PEOPLE: usize = 2_400_000;
const MAX_THINGS: usize = 4_000_000;
/// Most captions of one photo.
const MAX_CAPTIONS: usize = 64;
/// Farthest from the origin that anything may lie: beyond every picture, pixels.
const FARTHEST_PX: f32 = 1e6;
/// Boxes of people in different files that overlap by more than this are one person.
const SAME_PERSON: f32 = 0.7;
/// Boxes of things of one category in different files that overlap by more than this are one thing; rounding to whole
/// pixels takes a fifth of small boxes.
const SAME_THING: f32 = 0.6;

/// A rectangle in a photo, pixels from the top left corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PixelBox {
    /// Left and upper border.
    pub min: Vec2,
    /// Right and lower border.
    pub max: Vec2,
}

impl PixelBox {
    /// Around points; `None` without any.
    pub fn around(points: impl IntoIterator<Item = Vec2>) -> Option<Self> {
        points.into_iter().map(|p| Self { min: p, max: p }).reduce(|a, b| a.union(&b))
    }

    /// Its middle.
    pub fn center(&self) -> Vec2 {
        (self.min + self.max) * 0.5
    }

    /// Square pixels.
    pub fn area(&self) -> f32 {
        let size = (self.max - self.min).max(Vec2::ZERO);
        size.x * size.y
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Area of the overlap over the area of both together; 0 for boxes without area.
    pub fn overlap(&self, other: &Self) -> f32 {
        let both = Self { min: self.min.max(other.min), max: self.max.min(other.max) }.area();
        let either = self.area() + other.area() - both;
        if either > 0.0 { both / either } else { 0.0 }
    }

    /// Shortest distance between the two, 0 where they overlap, pixels.
    pub fn gap(&self, other: &Self) -> f32 {
        (self.min - other.max).max(other.min - self.max).max(Vec2::ZERO).length()
    }
}

/// A labelled thing in a photo.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhotoThing {
    /// COCO's name of its category, or the file's own word, lower case.
    pub category: String,
    /// Around it.
    pub bounds: PixelBox,
    /// Its outline, pixels; empty where only the box is known.
    pub outline: Vec<Vec2>,
}

impl PhotoThing {
    /// The middle of its outline's area, or of its box.
    pub fn center(&self) -> Vec2 {
        polygon_center(&self.outline).unwrap_or_else(|| self.bounds.center())
    }
}

/// The centroid of a polygon's area; `None` without area.
fn polygon_center(outline: &[Vec2]) -> Option<Vec2> {
    let origin = *outline.first()?;
    let (mut area, mut sum) = (0.0, Vec2::ZERO);
    for (index, a) in outline.iter().enumerate() {
        let (a, b) = (*a - origin, outline[(index + 1) % outline.len()] - origin);
        let cross = a.perp_dot(b);
        area += cross;
        sum += (a + b) * cross;
    }
    (area.abs() > 1e-3).then(|| origin + sum / (3.0 * area))
}

/// What a person does with a thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interaction {
    /// V-COCO's verb and role, such as `eat obj`, `cut instr`, `work_on_computer instr`.
    pub verb: String,
    /// Number of the thing in [`Photo::things`].
    pub thing: usize,
}

/// A person in a photo.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhotoPerson {
    /// Around the person.
    pub bounds: PixelBox,
    /// Joints; confidence 0 where nobody marked one.
    pub joints: [Keypoint; PHOTO_JOINTS],
    /// What the person does.
    pub interactions: Vec<Interaction>,
}

impl PhotoPerson {
    /// Somebody of whom only the box is known.
    pub fn in_box(bounds: PixelBox) -> Self {
        Self { bounds, joints: [Keypoint::default(); PHOTO_JOINTS], interactions: Vec::new() }
    }

    /// How many joints are marked.
    pub fn marked(&self) -> usize {
        self.joints.iter().filter(|j| j.confidence > 0.0).count()
    }

    /// The pixel of a joint, where it is marked.
    pub fn joint(&self, index: usize) -> Option<Vec2> {
        let joint = self.joints[index];
        (joint.confidence > 0.0).then_some(joint.pixel)
    }

    /// Whether the person does this (verb and role, [`Interaction::verb`]).
    pub fn does(&self, verb: &str) -> bool {
        self.interactions.iter().any(|i| i.verb == verb)
    }
}

/// Everything that is known of one photo.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Photo {
    /// COCO's number in decimal, or the file's name without its ending.
    pub key: String,
    /// Columns and rows, where some file says.
    pub size_px: Option<Vec2>,
    /// What people wrote under it.
    pub captions: Vec<String>,
    /// Everything in it but people.
    pub things: Vec<PhotoThing>,
    /// Everybody in it.
    pub people: Vec<PhotoPerson>,
    /// Whether every thing of the categories was marked, not only what somebody uses.
    pub complete: bool,
    /// The file that each thing came from.
    #[serde(skip)]
    sources: Vec<usize>,
}

impl Photo {
    /// The person in this box, put in when nobody is there yet.
    fn person_in(&mut self, bounds: PixelBox) -> &mut PhotoPerson {
        let overlap = |p: &PhotoPerson| p.bounds.overlap(&bounds);
        let best = (0..self.people.len())
            .max_by(|a, b| overlap(&self.people[*a]).total_cmp(&overlap(&self.people[*b])));
        let index = match best.filter(|i| overlap(&self.people[*i]) > SAME_PERSON) {
            Some(index) => index,
            None => {
                self.people.push(PhotoPerson::in_box(bounds));
                self.people.len() - 1
            }
        };
        &mut self.people[index]
    }

    /// Puts a thing in, or finds it as another file put it, and gives its number. An outline replaces a box.
    fn put_thing(&mut self, thing: PhotoThing, source: usize) -> usize {
        let same = |(index, there): (usize, &PhotoThing)| {
            let overlap = there.bounds.overlap(&thing.bounds);
            let other_file = self.sources[index] != source || overlap > 0.999;
            (there.category == thing.category && other_file && overlap > SAME_THING)
                .then_some((index, overlap))
        };
        let there = self.things.iter().enumerate().filter_map(same).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((index, _)) = there else {
            self.things.push(thing);
            self.sources.push(source);
            return self.things.len() - 1;
        };
        if self.things[index].outline.is_empty() && !thing.outline.is_empty() {
            self.things[index] = thing;
        }
        index
    }

    fn put_caption(&mut self, caption: &str) {
        let caption = caption.trim();
        let is_new = self.captions.len() < MAX_CAPTIONS && self.captions.iter().all(|c| c != caption);
        if is_new && !caption.is_empty() {
            self.captions.push(caption.to_owned());
        }
    }
}

/// Joints and box of a person as shares of the photo's width and height, waiting for its size.
struct ShareOfPhoto {
    key: String,
    bounds: PixelBox,
    joints: [Keypoint; PHOTO_JOINTS],
}

/// Photos as they come together from many files.
#[derive(Default)]
pub struct PhotoSet {
    photos: BTreeMap<String, Photo>,
    waiting: Vec<ShareOfPhoto>,
    sources: usize,
    people: usize,
    things: usize,
}

/// What [`PhotoSet::finish`] gives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Photos {
    /// By key.
    pub photos: Vec<Photo>,
    /// People whose joints were given as shares of a photo whose size no file says: left out.
    pub people_without_size: usize,
}

impl PhotoSet {
    /// Endings of files that may be annotations; others in a folder are passed over.
    pub const ENDINGS: [&'static str; 5] = ["json", "csv", "tsv", "txt", "gz"];

    /// Adds what a file says. Files can come in any order.
    ///
    /// # Errors
    /// Names the file, the place in it, what is wrong and what to do.
    pub fn add_file(&mut self, path: &Path) -> Result<(), AssetError> {
        let shown = path.display().to_string();
        let budget = Budget { max_file_bytes: MAX_BYTES, ..Budget::default() };
        read_plain_file(path, &budget)
            .and_then(|bytes| self.add(&bytes))
            .map_err(|fault| fault.in_file(&shown))
    }

    /// Adds what a file in memory says, as [`Self::add_file`] does.
    ///
    /// # Errors
    /// As [`Self::add_file`]; `name` stands for the file.
    pub fn add_bytes(&mut self, name: &str, bytes: &[u8]) -> Result<(), AssetError> {
        self.add(bytes).map_err(|fault| fault.in_file(name))
    }

    fn add(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        Budget::check("the file itself", "bytes", bytes.len() as u64, MAX_BYTES)?;
        self.sources += 1;
        if gzip::is_gzip(bytes) {
            let unpacked = gzip::unpack(bytes, MAX_BYTES)?;
            return self.add_plain(&unpacked);
        }
        self.add_plain(bytes)
    }

    fn add_plain(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        match bytes.trim_ascii_start().first() {
            Some(b'{') => self.add_json_object(bytes),
            Some(b'[') => persons::add(self, bytes),
            Some(_) => self.add_text(bytes),
            None => Err(Fault::malformed("byte 0", "the file is empty")),
        }
    }

    fn add_json_object(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        #[derive(Deserialize)]
        struct Top {
            shapes: Option<serde::de::IgnoredAny>,
            classes: Option<serde::de::IgnoredAny>,
            annotations: Option<serde::de::IgnoredAny>,
        }
        let top: Top = parse_json(bytes)?;
        match (top.shapes.is_some(), top.classes.is_some(), top.annotations.is_some()) {
            (true, ..) => labelme::add(self, bytes),
            (_, true, true) => vcoco::add(self, bytes),
            (_, _, true) => coco::add(self, bytes),
            _ => Err(unknown(
                "a JSON object with neither \"annotations\" (COCO, V-COCO) nor \"shapes\" (LabelMe)",
            )),
        }
    }

    fn add_text(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        let text = std::str::from_utf8(bytes)
            .map_err(|e| Fault::malformed(format!("byte {}", e.valid_up_to()), "it is not UTF-8 text"))?;
        let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
        if captions::is_header(first) {
            captions::add(self, text)
        } else if poses::is_row(first) {
            poses::add(self, text)
        } else if boxes::is_row(first) {
            boxes::add(self, text)
        } else {
            Err(unknown("text that is neither captions (csv), boxes nor joints (tsv)"))
        }
    }

    /// The photo of a key, put in when it is new.
    fn photo(&mut self, key: &str) -> Result<&mut Photo, Fault> {
        if !self.photos.contains_key(key) {
            Budget::check("photos", "photos", self.photos.len() as u64 + 1, MAX_PHOTOS as u64)?;
            self.photos.insert(key.to_owned(), Photo { key: key.to_owned(), ..Photo::default() });
        }
        self.photos.get_mut(key).ok_or_else(|| Fault::malformed("photos", "a photo vanished"))
    }

    /// Counts another person against the limit.
    fn count_person(&mut self) -> Result<(), Fault> {
        self.people += 1;
        Budget::check("people", "people", self.people as u64, MAX_PEOPLE as u64)
    }

    /// Puts a thing into a photo and gives its number there.
    fn put_thing(&mut self, key: &str, thing: PhotoThing) -> Result<usize, Fault> {
        self.things += 1;
        Budget::check("things", "things", self.things as u64, MAX_THINGS as u64)?;
        let source = self.sources;
        Ok(self.photo(key)?.put_thing(thing, source))
    }

    /// Puts everything together: people whose places were shares of a photo get pixels.
    pub fn finish(mut self) -> Photos {
        let mut people_without_size = 0;
        for person in std::mem::take(&mut self.waiting) {
            let photo = self.photos.get_mut(&person.key);
            let Some((photo, size)) = photo.and_then(|p| p.size_px.map(|size| (p, size))) else {
                people_without_size += 1;
                continue;
            };
            let bounds = PixelBox { min: person.bounds.min * size, max: person.bounds.max * size };
            let there = photo.person_in(bounds);
            if there.marked() == 0 {
                there.joints = person.joints.map(|j| Keypoint { pixel: j.pixel * size, ..j });
            }
        }
        Photos { photos: self.photos.into_values().collect(), people_without_size }
    }
}

fn unknown(feature: &str) -> Fault {
    let remedy = "COCO, V-COCO and LabelMe json, captions as csv, boxes as text and joints as tsv are read.";
    Fault::new("the whole file", Problem::Unsupported { feature: feature.to_owned(), remedy })
}

fn parse_json<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, Fault> {
    serde_json::from_slice(bytes).map_err(|error| {
        let place = format!("line {}, column {}", error.line(), error.column());
        Fault::malformed(place, error.to_string())
    })
}

/// The key of a COCO image's number.
fn key_of_number(number: u64) -> String {
    number.to_string()
}

/// The key of a file's name: COCO's number where it is one (`000000000165.jpg`, `COCO_train2014_000000000165.jpg`),
/// or the name without folder and ending.
fn key_of_name(name: &str) -> String {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let digits = stem.rsplit('_').next().unwrap_or(stem);
    match digits.parse::<u64>() {
        Ok(number) if digits.len() == COCO_DIGITS => key_of_number(number),
        _ => stem.to_owned(),
    }
}

/// Digits of the number in COCO's file names.
const COCO_DIGITS: usize = 12;

/// A box from its borders, checked.
fn checked_box(place: &str, min: Vec2, max: Vec2) -> Result<PixelBox, Fault> {
    let sound = min.is_finite() && max.is_finite() && min.abs().max(max.abs()).max_element() <= FARTHEST_PX;
    if sound && max.cmpge(min).all() {
        return Ok(PixelBox { min, max });
    }
    let what = format!("({}, {}) to ({}, {}) is no box of a picture", min.x, min.y, max.x, max.y);
    Err(Fault::malformed(place, what))
}

/// Joints from `x, y, visibility` triples (0 not marked, 1 hidden, 2 seen), checked.
fn checked_joints(place: &str, numbers: &[f32]) -> Result<[Keypoint; PHOTO_JOINTS], Fault> {
    if numbers.len() != 3 * PHOTO_JOINTS {
        let what = format!("{} numbers of joints where {} are needed", numbers.len(), 3 * PHOTO_JOINTS);
        return Err(Fault::malformed(place, what));
    }
    let mut joints = [Keypoint::default(); PHOTO_JOINTS];
    for (index, (joint, n)) in joints.iter_mut().zip(numbers.chunks_exact(3)).enumerate() {
        let pixel = Vec2::new(n[0], n[1]);
        if !pixel.is_finite() || pixel.abs().max_element() > FARTHEST_PX || !n[2].is_finite() {
            let what = format!("({}, {}, {}) is no point of a picture", n[0], n[1], n[2]);
            return Err(Fault::malformed(format!("{place}[{}]", 3 * index), what));
        }
        if n[2] >= 1.0 {
            *joint = Keypoint { pixel, confidence: if n[2] >= 2.0 { 1.0 } else { 0.5 } };
        }
    }
    Ok(joints)
}

#[cfg(test)]
mod tests;
