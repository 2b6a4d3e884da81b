//! The room's objects: which atoms each is made of, what it is and what it is called.

use std::collections::{BTreeMap, HashMap};

use glam::{Affine3A, Mat3, Vec3};

use super::atoms::{Atom, Piece, atoms, mesh_of};
use super::cluster::clusters;
use super::shape::{self, Shape, Surrounding};
use super::upright::Stance;
use crate::assets::Model;
use crate::math::Aabb;
use crate::scene::step::{Step, Stopped, report};
use crate::scene::{Category, Object, ObjectId, ObjectPart, Room};

/// The room of `model`, standing as `stance` says.
///
/// # Errors
/// [`Stopped`] when `step` breaks off.
pub fn room(model: &Model, stance: &Stance, step: Step) -> Result<Room, Stopped> {
    let atoms = atoms(model, stance.world_from_file, step)?;
    let mut names = HashMap::new();
    let mut objects: Vec<Object> = Vec::new();
    let clusters = clusters(model, &atoms, stance.world_from_file, step)?;
    for (number, members) in clusters.iter().enumerate() {
        report(step, number, clusters.len())?;
        let members: Vec<&Atom> = members.iter().map(|&m| &atoms[m]).collect();
        let name = unique(&mut names, name(model, &members).unwrap_or_else(|| format!("object {number}")));
        objects.push(object(model, &members, stance, (ObjectId(number as u32), name), step)?);
    }
    let bounds = atoms.iter().fold(Aabb::EMPTY, |all, atom| all.union(atom.bounds));
    let around = Surrounding { bounds, ceiling_m: stance.ceiling_m.unwrap_or(bounds.max.y) };
    for object in objects.iter_mut().filter(|o| o.category == Category::Unlabeled) {
        report(step, 0, 0)?;
        object.category = shape::category(&Shape::of(object.world_triangles()), &around);
        object.locked = object.category.is_structure();
    }
    Ok(Room {
        name: model.name.rsplit_once('.').map_or(model.name.as_str(), |(stem, _)| stem).to_string(),
        objects,
        materials: model.materials.clone(),
        textures: model.textures.clone(),
    })
}

/// The name of the member that says what it is, else of the largest.
fn name(model: &Model, members: &[&Atom]) -> Option<String> {
    let largest = |a: &&&Atom, b: &&&Atom| a.area.total_cmp(&b.area);
    let telling = members.iter().filter(|a| a.category.is_some()).max_by(largest);
    let atom = telling.or_else(|| members.iter().max_by(largest))?;
    let part = &model.parts[atom.pieces.first()?.part];
    // A numbered child of the thing itself, as this program and others write things of several meshes.
    let is_child_of =
        |parent: &&String| part.name.strip_prefix(parent.as_str()).is_some_and(|n| n.starts_with('.'));
    let name = part.path.last().filter(|p| !p.is_empty()).filter(is_child_of).unwrap_or(&part.name);
    (!name.is_empty()).then(|| name.clone())
}

/// `name`, numbered when it was used before.
fn unique(used: &mut HashMap<String, usize>, name: String) -> String {
    let times = used.entry(name.clone()).or_insert(0);
    *times += 1;
    if *times == 1 { name } else { format!("{name} {times}") }
}

/// One piece for each part, in the order of the file; whole where all of a part's triangles are there.
fn whole_pieces(model: &Model, members: &[&Atom]) -> Vec<Piece> {
    let mut of_part: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    for piece in members.iter().flat_map(|atom| &atom.pieces) {
        let all = 0..model.parts[piece.part].mesh.triangles.len() as u32;
        let triangles = piece.triangles.clone().unwrap_or_else(|| all.collect());
        of_part.entry(piece.part).or_default().extend(triangles);
    }
    let whole = |part: usize, triangles: &[u32]| triangles.len() == model.parts[part].mesh.triangles.len();
    of_part
        .into_iter()
        .map(|(part, mut triangles)| {
            triangles.sort_unstable();
            let triangles = (!whole(part, &triangles)).then_some(triangles);
            Piece { part, triangles }
        })
        .collect()
}

fn object(
    model: &Model,
    members: &[&Atom],
    stance: &Stance,
    (id, name): (ObjectId, String),
    step: Step,
) -> Result<Object, Stopped> {
    let category = members.iter().find_map(|a| a.category);
    let bounds = members.iter().fold(Aabb::EMPTY, |all, atom| all.union(atom.bounds));
    let centre = bounds.center();
    let origin = Vec3::new(centre.x, bounds.min.y, centre.z);
    let object_from_file = Affine3A::from_mat3_translation(Mat3::IDENTITY, -origin) * stance.world_from_file;
    let parts = whole_pieces(model, members).into_iter().map(|piece| {
        let part = &model.parts[piece.part];
        Ok(ObjectPart {
            mesh: mesh_of(part, &piece, step)?,
            material: part.material,
            object_from_mesh: object_from_file * part.file_from_mesh,
        })
    });
    Ok(Object {
        id,
        name,
        category: category.unwrap_or_default(),
        parts: parts.collect::<Result<_, Stopped>>()?,
        world_from_object: Affine3A::from_translation(origin),
        visible: true,
        locked: category.is_some_and(Category::is_structure),
    })
}
