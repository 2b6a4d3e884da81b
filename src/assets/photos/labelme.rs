//! LabelMe json, one photo a file. Shapes are things (label = category) and people (label `person`); points named as
//! COCO's joints (`left_shoulder`) belong to the person of their `group_id`. A label's text after `#` is passed over
//! (`cup#2`); flags that are on are captions.

use std::collections::BTreeMap;

use glam::Vec2;
use serde::Deserialize;

use super::super::keypoints::Keypoint;
use super::coco::PERSON;
use super::{Fault, PHOTO_JOINTS, PhotoSet, PhotoThing, PixelBox, checked_box, key_of_name, parse_json};

/// COCO's names of its joints.
const JOINT_NAMES: [&str; PHOTO_JOINTS] = [
    "nose",
    "left_eye",
    "right_eye",
    "left_ear",
    "right_ear",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_hip",
    "right_hip",
    "left_knee",
    "right_knee",
    "left_ankle",
    "right_ankle",
];
/// Most shapes of one photo.
const MAX_SHAPES: usize = 10_000;

#[derive(Deserialize)]
struct File {
    #[serde(rename = "imagePath")]
    image_path: String,
    #[serde(rename = "imageWidth", default)]
    width: Option<f32>,
    #[serde(rename = "imageHeight", default)]
    height: Option<f32>,
    #[serde(default)]
    flags: BTreeMap<String, bool>,
    shapes: Vec<Shape>,
}

#[derive(Deserialize)]
struct Shape {
    label: String,
    points: Vec<[f32; 2]>,
    #[serde(default)]
    group_id: Option<i64>,
    #[serde(default)]
    shape_type: Option<String>,
}

/// Box and joints of a person as shapes name them.
#[derive(Default)]
struct Parts {
    bounds: Option<PixelBox>,
    joints: [Keypoint; PHOTO_JOINTS],
}

pub(super) fn add(set: &mut PhotoSet, bytes: &[u8]) -> Result<(), Fault> {
    let file: File = parse_json(bytes)?;
    super::Budget::check("shapes", "shapes", file.shapes.len() as u64, MAX_SHAPES as u64)?;
    let key = key_of_name(&file.image_path);
    let photo = set.photo(&key)?;
    photo.size_px = file.width.zip(file.height).map(|(w, h)| Vec2::new(w, h)).or(photo.size_px);
    photo.complete = true;
    file.flags.iter().filter(|(_, on)| **on).for_each(|(flag, _)| photo.put_caption(flag));
    // People without a group are told apart by their place in the file.
    let mut people: BTreeMap<(bool, i64), Parts> = BTreeMap::new();
    for (index, shape) in file.shapes.into_iter().enumerate() {
        let label = shape.label.split('#').next().unwrap_or_default().trim().to_lowercase();
        let outline: Vec<Vec2> = shape.points.iter().copied().map(Vec2::from_array).collect();
        let Some(bounds) = PixelBox::around(outline.iter().copied()) else { continue };
        let bounds = checked_box(&format!("shapes[{index}].points"), bounds.min, bounds.max)?;
        let group = shape.group_id.map_or((true, index as i64), |id| (false, id));
        if let Some(joint) = JOINT_NAMES.iter().position(|name| *name == label.replace(' ', "_")) {
            people.entry(group).or_default().joints[joint] = Keypoint { pixel: bounds.min, confidence: 1.0 };
        } else if label == PERSON {
            people.entry(group).or_default().bounds = Some(bounds);
        } else {
            let is_outline = shape.shape_type.as_deref().unwrap_or("polygon") == "polygon";
            let outline = if is_outline && outline.len() > 2 { outline } else { Vec::new() };
            set.put_thing(&key, PhotoThing { category: label, bounds, outline })?;
        }
    }
    for parts in people.values() {
        add_person(set, &key, parts)?;
    }
    Ok(())
}

fn add_person(set: &mut PhotoSet, key: &str, parts: &Parts) -> Result<(), Fault> {
    set.count_person()?;
    let marked = parts.joints.iter().filter(|j| j.confidence > 0.0).map(|j| j.pixel);
    let Some(bounds) = parts.bounds.or_else(|| PixelBox::around(marked)) else { return Ok(()) };
    let person = set.photo(key)?.person_in(bounds);
    if person.marked() == 0 {
        person.joints = parts.joints;
    }
    Ok(())
}
