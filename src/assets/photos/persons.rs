//! Lists of people: a JSON list of `image_id`, `file_name`, `width`, `height`, `bbox_xyxy`, `keypoints` (17 triples)
//! and `objects` (`category`, `bbox_xyxy`, `roles`: V-COCO's verbs).

use glam::Vec2;
use serde::Deserialize;

use super::{
    Fault, Interaction, PhotoSet, PhotoThing, checked_box, checked_joints, key_of_number, parse_json,
};

#[derive(Deserialize)]
struct Person {
    image_id: u64,
    width: f32,
    height: f32,
    bbox_xyxy: [f32; 4],
    keypoints: Vec<[f32; 3]>,
    #[serde(default)]
    objects: Vec<Thing>,
}

#[derive(Deserialize)]
struct Thing {
    category: String,
    bbox_xyxy: [f32; 4],
    #[serde(default)]
    roles: Vec<String>,
}

pub(super) fn add(set: &mut PhotoSet, bytes: &[u8]) -> Result<(), Fault> {
    let people: Vec<Person> = parse_json(bytes)?;
    for (index, person) in people.into_iter().enumerate() {
        add_person(set, person, &format!("[{index}]"))?;
    }
    Ok(())
}

fn add_person(set: &mut PhotoSet, person: Person, place: &str) -> Result<(), Fault> {
    set.count_person()?;
    let corners = |[left, top, right, bottom]: [f32; 4], place: &str| {
        checked_box(place, Vec2::new(left, top), Vec2::new(right, bottom))
    };
    let bounds = corners(person.bbox_xyxy, &format!("{place}.bbox_xyxy"))?;
    let joints = checked_joints(&format!("{place}.keypoints"), person.keypoints.as_flattened())?;
    let key = key_of_number(person.image_id);
    let mut interactions = Vec::new();
    for (number, thing) in person.objects.into_iter().enumerate() {
        let bounds = corners(thing.bbox_xyxy, &format!("{place}.objects[{number}].bbox_xyxy"))?;
        let category = thing.category.to_lowercase();
        let index = set.put_thing(&key, PhotoThing { category, bounds, outline: Vec::new() })?;
        interactions.extend(thing.roles.into_iter().map(|verb| Interaction { verb, thing: index }));
    }
    let photo = set.photo(&key)?;
    photo.size_px = photo.size_px.or(Some(Vec2::new(person.width, person.height)));
    let there = photo.person_in(bounds);
    there.joints = joints;
    for interaction in interactions {
        if !there.interactions.contains(&interaction) {
            there.interactions.push(interaction);
        }
    }
    Ok(())
}
