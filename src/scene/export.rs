//! A room as the plain model that the writers of 3-D files take.

use crate::assets::{Model, Part};

use super::{Object, Room};

/// The room as a model in the world frame: one node per object, in the room's order, with its name and
/// `extras` of `{"category": label}`. Hidden objects are part of it. Meshes stay shared.
pub fn model_from_room(room: &Room) -> Model {
    let parts = room.objects.iter().enumerate().flat_map(|(node, object)| {
        object.parts.iter().map(move |part| Part {
            name: object.name.clone(),
            node,
            path: Vec::new(),
            mesh: part.mesh.clone(),
            material: part.material,
            file_from_mesh: object.world_from_object * part.object_from_mesh,
            extras: Some(extras(object)),
        })
    });
    Model {
        name: room.name.clone(),
        parts: parts.collect(),
        materials: room.materials.clone(),
        textures: room.textures.clone(),
        notes: Vec::new(),
    }
}

fn extras(object: &Object) -> String {
    serde_json::json!({ "category": object.category.label() }).to_string()
}
