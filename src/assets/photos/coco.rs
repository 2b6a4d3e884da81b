//! COCO json: instances, captions and person_keypoints, in one file or three.

use glam::Vec2;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;

use super::{
    Fault, PhotoSet, PhotoThing, PixelBox, checked_box, checked_joints, key_of_name, key_of_number,
    parse_json,
};

/// COCO's name for people among its categories.
pub(super) const PERSON: &str = "person";
/// Most points of one outline.
const MAX_OUTLINE: usize = 20_000;

#[derive(Deserialize)]
struct File {
    #[serde(default)]
    images: Vec<Image>,
    annotations: Vec<Annotation>,
    /// Some files carry captions beside boxes.
    #[serde(default)]
    captions: Vec<Annotation>,
    #[serde(default)]
    categories: Vec<Category>,
}

#[derive(Deserialize)]
struct Image {
    id: u64,
    #[serde(default)]
    file_name: Option<String>,
    #[serde(default)]
    width: Option<f32>,
    #[serde(default)]
    height: Option<f32>,
}

#[derive(Deserialize)]
struct Category {
    id: u64,
    name: String,
}

#[derive(Deserialize)]
struct Annotation {
    image_id: u64,
    #[serde(default)]
    caption: Option<String>,
    #[serde(default)]
    category_id: Option<u64>,
    #[serde(default)]
    bbox: Option<[f32; 4]>,
    #[serde(default)]
    segmentation: Option<Segmentation>,
    #[serde(default)]
    keypoints: Option<Vec<f32>>,
    #[serde(default)]
    iscrowd: u8,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Segmentation {
    Polygons(Vec<Vec<f32>>),
    /// Run lengths, which crowds have.
    Runs(IgnoredAny),
}

pub(super) fn add(set: &mut PhotoSet, bytes: &[u8]) -> Result<(), Fault> {
    let file: File = parse_json(bytes)?;
    // A file of things marks every thing of its images; one of people or captions says nothing about things.
    let names: BTreeMap<u64, String> =
        file.categories.into_iter().map(|c| (c.id, c.name.to_lowercase())).collect();
    let marks_things = names.values().any(|name| name != PERSON);
    let mut keys = BTreeMap::new();
    for image in file.images {
        let key = image.file_name.as_deref().map_or_else(|| key_of_number(image.id), key_of_name);
        let photo = set.photo(&key)?;
        photo.size_px = image.width.zip(image.height).map(|(w, h)| Vec2::new(w, h)).or(photo.size_px);
        photo.complete |= marks_things;
        keys.insert(image.id, key);
    }
    for (list, annotations) in [("annotations", file.annotations), ("captions", file.captions)] {
        for (index, annotation) in annotations.into_iter().enumerate() {
            let number = annotation.image_id;
            let key = keys.get(&number).cloned().unwrap_or_else(|| key_of_number(number));
            add_annotation(set, &key, &format!("{list}[{index}]"), annotation, &names)?;
        }
    }
    Ok(())
}

fn add_annotation(
    set: &mut PhotoSet,
    key: &str,
    place: &str,
    annotation: Annotation,
    names: &BTreeMap<u64, String>,
) -> Result<(), Fault> {
    if let Some(caption) = &annotation.caption {
        set.photo(key)?.put_caption(caption);
    }
    // Crowds are regions of many, not one thing or person.
    let Some([x, y, width, height]) = annotation.bbox.filter(|_| annotation.iscrowd == 0) else {
        return Ok(());
    };
    let min = Vec2::new(x, y);
    let bounds = checked_box(&format!("{place}.bbox"), min, min + Vec2::new(width, height))?;
    let name = match annotation.category_id {
        Some(id) => names.get(&id).ok_or_else(|| {
            Fault::malformed(format!("{place}.category_id"), format!("there is no category {id}"))
        })?,
        None => PERSON,
    };
    if name == PERSON {
        return add_person(set, key, place, bounds, annotation.keypoints.as_deref());
    }
    let outline = annotation.segmentation.map(largest_outline).unwrap_or_default();
    set.put_thing(key, PhotoThing { category: name.to_owned(), bounds, outline })?;
    Ok(())
}

fn add_person(
    set: &mut PhotoSet,
    key: &str,
    place: &str,
    bounds: PixelBox,
    keypoints: Option<&[f32]>,
) -> Result<(), Fault> {
    set.count_person()?;
    let joints = keypoints.map(|k| checked_joints(&format!("{place}.keypoints"), k)).transpose()?;
    let person = set.photo(key)?.person_in(bounds);
    if let Some(joints) = joints
        && joints.iter().any(|j| j.confidence > 0.0)
    {
        person.joints = joints;
    }
    Ok(())
}

/// The polygon with the largest box: things that something hides in part have several.
fn largest_outline(segmentation: Segmentation) -> Vec<Vec2> {
    let Segmentation::Polygons(polygons) = segmentation else {
        return Vec::new();
    };
    let points = |numbers: Vec<f32>| -> Vec<Vec2> {
        numbers.chunks_exact(2).map(Vec2::from_slice).filter(|p| p.is_finite()).take(MAX_OUTLINE).collect()
    };
    let area = |outline: &[Vec2]| PixelBox::around(outline.iter().copied()).map_or(0.0, |b| b.area());
    polygons.into_iter().map(points).max_by(|a, b| area(a).total_cmp(&area(b))).unwrap_or_default()
}
