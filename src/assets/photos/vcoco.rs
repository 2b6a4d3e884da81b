//! V-COCO's interactions: for each photo parallel lists of a person's box, a thing's box, a verb and a category.

use glam::Vec2;
use serde::Deserialize;

use super::coco::PERSON;
use super::{Fault, Interaction, PhotoSet, PhotoThing, checked_box, key_of_name, parse_json};

#[derive(Deserialize)]
struct File {
    annotations: Vec<Annotation>,
    /// Verbs with their roles, such as `eat obj`.
    classes: Vec<String>,
    /// Categories; number 0 is the background.
    objects: Vec<String>,
}

#[derive(Deserialize)]
struct Annotation {
    file_name: String,
    boxes_h: Vec<[f32; 4]>,
    boxes_o: Vec<[f32; 4]>,
    actions: Vec<usize>,
    objects: Vec<usize>,
}

pub(super) fn add(set: &mut PhotoSet, bytes: &[u8]) -> Result<(), Fault> {
    let file: File = parse_json(bytes)?;
    for (index, annotation) in file.annotations.iter().enumerate() {
        let place = format!("annotations[{index}]");
        let rows = annotation.actions.len();
        let lengths = [annotation.boxes_h.len(), annotation.boxes_o.len(), annotation.objects.len()];
        if lengths.iter().any(|length| *length != rows) {
            let what = format!("{rows} actions stand beside {lengths:?} persons, things and categories");
            return Err(Fault::malformed(place, what));
        }
        for row in 0..rows {
            add_row(set, &file, annotation, row, &place)?;
        }
    }
    Ok(())
}

fn add_row(
    set: &mut PhotoSet,
    file: &File,
    annotation: &Annotation,
    row: usize,
    place: &str,
) -> Result<(), Fault> {
    let named = |list: &[String], what: &'static str, number: usize| {
        let found = list.get(number).map(|name| name.to_lowercase());
        found.ok_or_else(|| Fault::out_of_range(format!("{place}.{what}[{row}]"), what, number, list.len()))
    };
    let verb = named(&file.classes, "actions", annotation.actions[row])?;
    let category = named(&file.objects, "objects", annotation.objects[row])?;
    let corners = |numbers: &[f32; 4], what: &str| {
        let [left, top, right, bottom] = *numbers;
        checked_box(&format!("{place}.{what}[{row}]"), Vec2::new(left, top), Vec2::new(right, bottom))
    };
    let person = corners(&annotation.boxes_h[row], "boxes_h")?;
    let key = key_of_name(&annotation.file_name);
    set.count_person()?;
    if category == PERSON {
        // What people do with each other has no thing.
        set.photo(&key)?.person_in(person);
        return Ok(());
    }
    let bounds = corners(&annotation.boxes_o[row], "boxes_o")?;
    let thing = set.put_thing(&key, PhotoThing { category, bounds, outline: Vec::new() })?;
    let interactions = &mut set.photo(&key)?.person_in(person).interactions;
    let interaction = Interaction { verb, thing };
    if !interactions.contains(&interaction) {
        interactions.push(interaction);
    }
    Ok(())
}
