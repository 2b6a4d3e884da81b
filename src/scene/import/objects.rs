//! Which parts belong together, what each thing is, where it stands.

use glam::{Affine3A, Mat3, Vec3};

use super::names;
use super::shape::{self, Shape, Surrounding};
use super::upright::Stance;
use crate::assets::{Model, Part};
use crate::math::Aabb;
use crate::scene::{Category, Object, ObjectId, ObjectPart, Room};

/// The room of `model`, standing as `stance` says.
pub fn room(model: &Model, stance: &Stance) -> Room {
    let mut objects: Vec<Object> = Vec::new();
    for group in groups(model) {
        objects.push(object(model, &group, stance, objects.len()));
    }
    let bounds = Aabb::of(objects.iter().map(Object::world_bounds).flat_map(|b| [b.min, b.max]));
    let around = Surrounding { bounds, ceiling_m: stance.ceiling_m.unwrap_or(bounds.max.y) };
    for object in &mut objects {
        if object.category == Category::Unlabeled {
            object.category = shape::category(&Shape::of(object.world_triangles()), &around);
        }
    }
    Room {
        name: model.name.rsplit_once('.').map_or(model.name.as_str(), |(stem, _)| stem).to_string(),
        objects,
        materials: model.materials.clone(),
        textures: model.textures.clone(),
    }
}

/// Parts of one node, in the order of the file.
fn groups(model: &Model) -> Vec<Vec<&Part>> {
    let mut order: Vec<usize> = Vec::new();
    let mut by_node: std::collections::HashMap<usize, Vec<&Part>> = std::collections::HashMap::new();
    for part in &model.parts {
        by_node.entry(part.node).or_insert_with(|| {
            order.push(part.node);
            Vec::new()
        });
        by_node.entry(part.node).or_default().push(part);
    }
    order.iter().filter_map(|node| by_node.remove(node)).collect()
}

fn object(model: &Model, parts: &[&Part], stance: &Stance, number: usize) -> Object {
    let first = parts.first();
    let name = first.map_or("", |p| p.name.as_str());
    let stated = first.and_then(|p| stated_category(p));
    let named = stated.or_else(|| names::category(name)).or_else(|| material_category(model, parts));
    let world_bounds = Aabb::of(parts.iter().flat_map(|p| {
        let world_from_mesh = stance.world_from_file * p.file_from_mesh;
        p.mesh.positions.iter().map(move |v| world_from_mesh.transform_point3(*v))
    }));
    let centre = world_bounds.center();
    let origin = Vec3::new(centre.x, world_bounds.min.y, centre.z);
    let object_from_file = Affine3A::from_mat3_translation(Mat3::IDENTITY, -origin) * stance.world_from_file;
    Object {
        id: ObjectId(number as u32),
        name: if name.is_empty() { format!("object {number}") } else { name.to_string() },
        category: named.unwrap_or_default(),
        parts: parts
            .iter()
            .map(|p| ObjectPart {
                mesh: p.mesh.clone(),
                material: p.material,
                object_from_mesh: object_from_file * p.file_from_mesh,
            })
            .collect(),
        world_from_object: Affine3A::from_translation(origin),
        visible: true,
        locked: named.is_some_and(Category::is_structure),
    }
}

/// The category that a node's extras state.
fn stated_category(part: &Part) -> Option<Category> {
    let extras: serde_json::Value = serde_json::from_str(part.extras.as_deref()?).ok()?;
    Category::from_label(extras.get("category")?.as_str()?)
}

/// What all materials of a thing say, if they agree.
fn material_category(model: &Model, parts: &[&Part]) -> Option<Category> {
    // Glass, paper and light are what many things are made of.
    let vague = |c: &Category| {
        matches!(
            c,
            Category::Objects | Category::Misc | Category::Clothes | Category::Picture | Category::Lighting
        )
    };
    let named = parts.iter().filter_map(|p| names::category(&model.materials.get(p.material)?.name));
    let mut found = named.filter(|c| !vague(c));
    let first = found.next()?;
    found.all(|c| c == first).then_some(first)
}
