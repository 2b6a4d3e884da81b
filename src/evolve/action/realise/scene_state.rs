//! A room as the `sceneState` JSON that SceneEval and the Scene Toolkit read: one entry per object with its 4 x 4
//! matrix, column by column. Y up, front +Z, metres.

use serde_json::{Value, json};

use super::evolution::Evolution;
use super::world::{Held, Source};
use crate::scene::{Object, ObjectId};

/// The present state. Walls, floor and other parts of the building are listed by `arch`, things and furniture by
/// `object`; a thing's parent is what it stands on.
pub fn scene_state(evolution: &Evolution, name: &str) -> Value {
    let room = evolution.room();
    let world = evolution.world();
    let (building, things): (Vec<&Object>, Vec<&Object>) =
        room.objects.iter().filter(|o| o.visible).partition(|o| o.category.is_structure());
    let index_of = |id: ObjectId| things.iter().position(|o| o.id == id);
    let parent = |object: &Object| -> i64 {
        let held = world.item(object.id).map(|i| i.held);
        let owner = match held {
            Some(Held::Item(id)) => Some(id),
            Some(Held::Surface(number)) => world.stage.surfaces.get(number).and_then(|s| s.owner),
            _ => None,
        };
        owner.and_then(index_of).map_or(-1, |i| i as i64)
    };
    let model = |object: &Object| match world.item(object.id).map(|i| &i.source) {
        Some(Source::Brought { thing, .. }) => format!("inhabit.{}", thing.name),
        _ => format!("room.{}", object.name),
    };
    let entry = |(index, object): (usize, &&Object)| {
        json!({
            "modelId": model(object),
            "index": index,
            "parentIndex": parent(object),
            "label": object.category.label(),
            "name": object.name,
            "transform": { "rows": 4, "cols": 4, "data": matrix(object) },
        })
    };
    let part = |object: &&Object| {
        let bounds = object.world_bounds();
        json!({
            "id": object.name,
            "type": object.category.label(),
            "bounds": { "min": bounds.min.to_array(), "max": bounds.max.to_array() },
        })
    };
    json!({
        "format": "sceneState",
        "scene": {
            "version": "scene@1.0.2",
            "id": name,
            "up": [0, 1, 0],
            "front": [0, 0, 1],
            "unit": 1.0,
            "assetSource": ["inhabit"],
            "arch": { "elements": building.iter().map(part).collect::<Vec<_>>() },
            "object": things.iter().enumerate().map(entry).collect::<Vec<_>>(),
        },
        "selected": [],
    })
}

fn matrix(object: &Object) -> Vec<f32> {
    let m = object.world_from_object;
    let column = |c: glam::Vec3A, w: f32| [c.x, c.y, c.z, w];
    [column(m.matrix3.x_axis, 0.0), column(m.matrix3.y_axis, 0.0), column(m.matrix3.z_axis, 0.0)]
        .into_iter()
        .chain([column(m.translation, 1.0)])
        .flatten()
        .collect()
}
