//! Reads glTF 2.0, as GLB or as JSON with its buffers beside it. Its own reader and not a crate's, because a
//! file from anywhere must end in a model or an error that names the place, never in a panic.

mod accessor;
mod container;
mod json;
mod material;
mod mesh;
mod nodes;

use std::sync::Arc;

use rayon::prelude::*;

use super::error::Fault;
use super::mend::Dropped;
use super::model::{Mesh, Model, Part};
use super::uri::Surroundings;
use accessor::Buffers;
use json::{Document, MeshJson, Primitive};

/// A primitive's mesh, shared by all nodes that show it, and its material.
type ReadPrimitive = Option<(Arc<Mesh>, usize)>;

/// Reads a GLB or glTF document.
pub(super) fn read(bytes: &[u8], around: Surroundings) -> Result<Model, Fault> {
    let (document, bin) = container::open(bytes)?;
    nodes::refuse_required_extensions(&document)?;
    let buffers = Buffers::load(&document, bin, around)?;
    let mut model = Model::default();
    let mut placed = nodes::placed(&document, around.budget, &mut model.notes)?;
    if document.nodes.is_empty() && !document.meshes.is_empty() {
        model.notes.push("the file has meshes but no nodes: every mesh was placed at the origin".to_string());
        placed = (0..document.meshes.len()).map(nodes::Placed::at_origin).collect();
    }
    let looks = material::read(&buffers, around, &mut model.notes)?;
    let meshes = read_meshes(&buffers, &placed, looks.materials.len() - 1, around, &mut model.notes)?;
    let mut triangles = 0;
    for place in &placed {
        let primitives = meshes.get(place.mesh).map_or(&[][..], Vec::as_slice);
        for (mesh, material) in primitives.iter().flatten() {
            triangles += mesh.triangles.len();
            around.budget.check_triangles(&format!("nodes[{}]", place.node), triangles)?;
            model.parts.push(part(&document, place, mesh, *material));
        }
    }
    model.materials = looks.materials;
    model.textures = looks.textures;
    note_skins(&document, &mut model.notes);
    Ok(model)
}

/// The primitives of every mesh that some node shows, read on all threads.
fn read_meshes(
    buffers: &Buffers,
    placed: &[nodes::Placed],
    default_material: usize,
    around: Surroundings,
    notes: &mut Vec<String>,
) -> Result<Vec<Vec<ReadPrimitive>>, Fault> {
    let meshes = &buffers.document.meshes;
    around.budget.check_nodes("meshes", "meshes", meshes.len())?;
    let mut shown = vec![false; meshes.len()];
    for place in placed {
        let here = format!("nodes[{}].mesh", place.node);
        *shown
            .get_mut(place.mesh)
            .ok_or_else(|| Fault::out_of_range(here, "mesh", place.mesh, meshes.len()))? = true;
    }
    let primitives: Vec<(usize, usize, &Primitive)> = (0..meshes.len())
        .filter(|m| shown[*m])
        .flat_map(|m| meshes[m].primitives.iter().enumerate().map(move |(p, primitive)| (m, p, primitive)))
        .collect();
    around.budget.check_nodes("meshes", "primitives", primitives.len())?;
    check_corners(buffers.document, &primitives, around)?;
    let read: Vec<_> = primitives
        .par_iter()
        .map(|(m, p, primitive)| {
            let place = format!("meshes[{m}].primitives[{p}]");
            read_primitive(buffers, primitive, &place, default_material, around)
        })
        .collect::<Result<_, _>>()?;
    let mut found: Vec<Vec<ReadPrimitive>> = meshes.iter().map(|_: &MeshJson| Vec::new()).collect();
    let (mut dropped, mut vertices, mut lines) = (Dropped::default(), 0, 0);
    for ((m, p, _), primitive) in primitives.iter().zip(read) {
        lines += usize::from(primitive.is_none());
        if let Some((mesh, _, lost)) = &primitive {
            dropped.add(*lost);
            vertices += mesh.positions.len();
            around.budget.check_vertices(&format!("meshes[{m}].primitives[{p}]"), vertices)?;
        }
        found[*m].push(primitive.map(|(mesh, material, _)| (mesh, material)));
    }
    notes.extend(dropped.notes());
    if lines > 0 {
        notes.push(format!("{lines} primitives of points or lines were left out"));
    }
    Ok(found)
}

/// Refuses a file whose primitives, sharing long accessors, would unfold to more than the budget.
fn check_corners(
    document: &Document,
    primitives: &[(usize, usize, &Primitive)],
    around: Surroundings,
) -> Result<(), Fault> {
    let mut corners: u64 = 0;
    for (m, p, primitive) in primitives {
        let accessor = primitive.indices.or_else(|| primitive.attributes.get("POSITION").copied());
        corners =
            corners.saturating_add(accessor.and_then(|a| document.accessors.get(a)).map_or(0, |a| a.count));
        let limit = (around.budget.max_triangles as u64).saturating_mul(3);
        super::Budget::check(&format!("meshes[{m}].primitives[{p}]"), "corners", corners, limit)?;
    }
    Ok(())
}

fn read_primitive(
    buffers: &Buffers,
    primitive: &Primitive,
    place: &str,
    default_material: usize,
    around: Surroundings,
) -> Result<Option<(Arc<Mesh>, usize, Dropped)>, Fault> {
    let materials = &buffers.document.materials;
    let material = primitive.material.unwrap_or(default_material);
    if material > default_material || (material == default_material && primitive.material.is_some()) {
        return Err(Fault::out_of_range(place, "material", material, materials.len()));
    }
    let texture = materials.get(material).and_then(material::base_texture);
    let read = mesh::read(buffers, primitive, texture, place, around.budget)?;
    Ok(read
        .filter(|(mesh, _)| !mesh.triangles.is_empty())
        .map(|(mesh, lost)| (Arc::new(mesh), material, lost)))
}

fn part(document: &Document, place: &nodes::Placed, mesh: &Arc<Mesh>, material: usize) -> Part {
    let node = document.nodes.get(place.node);
    let mesh_name = document.meshes.get(place.mesh).and_then(|m| m.name.clone());
    let name =
        node.and_then(|n| n.name.clone()).or(mesh_name).unwrap_or_else(|| format!("node {}", place.node));
    Part {
        name,
        node: place.node,
        path: place.path.clone(),
        mesh: mesh.clone(),
        material,
        file_from_mesh: place.file_from_mesh,
        extras: node.and_then(|n| n.extras.as_ref()).map(ToString::to_string),
    }
}

fn note_skins(document: &Document, notes: &mut Vec<String>) {
    let skinned = document.nodes.iter().filter(|n| n.skin.is_some() && n.mesh.is_some()).count();
    if skinned > 0 {
        notes.push(format!("{skinned} skinned meshes are shown in their rest pose"));
    }
}
