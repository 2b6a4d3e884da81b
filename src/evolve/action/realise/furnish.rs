//! The room as a whole again: what stays, what was moved, what was brought.

use std::collections::BTreeMap;

use glam::Affine3A;

use super::library::{Library, Thing};
use super::stage::Stage;
use super::world::{Item, Source, World};
use crate::assets::Material;
use crate::scene::{Category, Object, ObjectPart, Room};

/// The room of `stage` with everything where `world` has it. Moved objects keep their meshes, materials and numbers.
pub fn room(stage: &Stage, world: &World, library: &Library) -> Room {
    let mut room = (*stage.room).clone();
    for found in &stage.movable {
        let Some(item) = world.item(found.id) else { continue };
        let now_from_then = item.world_from_found() * Affine3A::from_translation(-found.at);
        if let Some(object) = room.objects.iter_mut().find(|o| o.id == found.id) {
            object.world_from_object = now_from_then * object.world_from_object;
            object.locked = item.locked;
        }
    }
    let mut looks: BTreeMap<String, usize> = BTreeMap::new();
    for item in world.items() {
        if let Source::Brought { thing, .. } = &item.source {
            let first = *looks.entry(thing.name.clone()).or_insert_with(|| add_looks(&mut room, thing));
            let object = object_of(item, thing, first, library);
            room.objects.push(object);
        }
    }
    room
}

/// Adds a thing's materials and pictures; the number of its first material.
fn add_looks(room: &mut Room, thing: &Thing) -> usize {
    let (first, pictures) = (room.materials.len(), room.textures.len());
    room.textures.extend(thing.model.textures.iter().cloned());
    let moved = |material: &Material| Material {
        base_color_texture: material.base_color_texture.map(|t| t + pictures),
        ..material.clone()
    };
    room.materials.extend(thing.model.materials.iter().map(moved));
    first
}

fn object_of(item: &Item, thing: &Thing, first_material: usize, library: &Library) -> Object {
    let category = item.kind.and_then(|k| Category::from_label(&library.kind(k).category));
    let parts = thing.model.parts.iter().map(|part| ObjectPart {
        mesh: part.mesh.clone(),
        material: first_material + part.material,
        object_from_mesh: thing.thing_from_file * part.file_from_mesh,
    });
    Object {
        id: item.id,
        name: item.name.clone(),
        category: category.unwrap_or(Category::Objects),
        parts: parts.collect(),
        world_from_object: item.world_from_item(),
        visible: true,
        locked: item.locked,
    }
}
