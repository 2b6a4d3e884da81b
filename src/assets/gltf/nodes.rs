//! Walks the node hierarchy: where each mesh stands, under which names.

use glam::{Affine3A, Mat3, Mat4, Quat, Vec3};

use super::json::{Document, Node};
use crate::assets::budget::Budget;
use crate::assets::error::{Fault, Problem};

/// A node that shows a mesh.
pub struct Placed {
    pub node: usize,
    pub mesh: usize,
    pub path: Vec<String>,
    pub file_from_mesh: Affine3A,
}

impl Placed {
    /// Mesh `mesh` of a file without nodes, as if node `mesh` showed it.
    pub fn at_origin(mesh: usize) -> Self {
        Self { node: mesh, mesh, path: Vec::new(), file_from_mesh: Affine3A::IDENTITY }
    }
}

/// Every mesh that the chosen scene shows, in the order of the hierarchy. A file without nodes shows
/// nothing.
pub fn placed(document: &Document, budget: &Budget, notes: &mut Vec<String>) -> Result<Vec<Placed>, Fault> {
    let nodes = &document.nodes;
    budget.check_nodes("nodes", "nodes", nodes.len())?;
    let parents = parents(nodes, notes)?;
    check_depths(&parents, budget)?;
    let names = group_names(nodes, &parents);
    let path_of = |node: usize| {
        let mut above: Vec<String> =
            std::iter::successors(parents[node], |&p| parents[p]).map(|p| names[p].clone()).collect();
        above.reverse();
        above
    };
    let mut found = Vec::new();
    let mut names_above = 0;
    let mut pending: Vec<(usize, Affine3A)> =
        roots(document, &parents, notes)?.into_iter().rev().map(|root| (root, Affine3A::IDENTITY)).collect();
    let mut seen = vec![false; nodes.len()];
    while let Some((index, file_from_parent)) = pending.pop() {
        if std::mem::replace(&mut seen[index], true) {
            continue;
        }
        let place = format!("nodes[{index}]");
        let node = &nodes[index];
        let file_from_node = file_from_parent * local(node, &place)?;
        if !file_from_node.is_finite() {
            return Err(Fault::malformed(place, "its place is not finite"));
        }
        if let Some(mesh) = node.mesh {
            let path = path_of(index);
            names_above += path.len() as u64;
            Budget::check(&place, "names above all nodes", names_above, 10 * budget.max_nodes as u64)?;
            found.push(Placed { node: index, mesh, path, file_from_mesh: file_from_node });
        }
        let children = node.children.iter().rev().filter(|child| parents[**child] == Some(index));
        pending.extend(children.map(|&child| (child, file_from_node)));
    }
    Ok(found)
}

/// The parent of every node; the first counts where a file names two.
fn parents(nodes: &[Node], notes: &mut Vec<String>) -> Result<Vec<Option<usize>>, Fault> {
    let mut parents = vec![None; nodes.len()];
    let mut second_parents = 0;
    for (index, node) in nodes.iter().enumerate() {
        for &child in &node.children {
            let place = format!("nodes[{index}].children");
            let parent = parents
                .get_mut(child)
                .ok_or_else(|| Fault::out_of_range(place, "node", child, nodes.len()))?;
            second_parents += usize::from(parent.is_some_and(|first| first != index));
            parent.get_or_insert(index);
        }
    }
    if second_parents > 0 {
        notes.push(format!("{second_parents} nodes have two parents: only the first was followed"));
    }
    Ok(parents)
}

/// Refuses cycles and hierarchies that are too deep, so that every later walk to a root is short.
fn check_depths(parents: &[Option<usize>], budget: &Budget) -> Result<(), Fault> {
    let mut depths: Vec<Option<u64>> = vec![None; parents.len()];
    let mut walk = Vec::new();
    let mut on_walk = vec![false; parents.len()];
    for start in 0..parents.len() {
        let mut at = Some(start);
        while let Some(node) = at.filter(|&node| depths[node].is_none()) {
            if std::mem::replace(&mut on_walk[node], true) {
                return Err(Fault::malformed(format!("nodes[{node}]"), "it is its own ancestor (a cycle)"));
            }
            walk.push(node);
            at = parents[node];
        }
        let mut depth = at.and_then(|node| depths[node]).map_or(0, |above| above + 1);
        while let Some(node) = walk.pop() {
            let limit = budget.max_depth as u64;
            Budget::check(&format!("nodes[{node}]"), "nodes above one another", depth, limit)?;
            depths[node] = Some(depth);
            depth += 1;
        }
    }
    Ok(())
}

/// The roots of the scene to show: the default one, else the first, else every node without a parent.
fn roots(
    document: &Document,
    parents: &[Option<usize>],
    notes: &mut Vec<String>,
) -> Result<Vec<usize>, Fault> {
    let scenes = &document.scenes;
    let chosen = document.scene.unwrap_or(0);
    if scenes.is_empty() {
        return Ok((0..parents.len()).filter(|&n| parents[n].is_none()).collect());
    }
    let scene =
        scenes.get(chosen).ok_or_else(|| Fault::out_of_range("scene", "scene", chosen, scenes.len()))?;
    if scenes.len() > 1 {
        let name = scene.name.as_deref().unwrap_or("without a name");
        notes.push(format!("scene {chosen} ({name}) of {} was read, the others were left out", scenes.len()));
    }
    let place = format!("scenes[{chosen}].nodes");
    if let Some(&bad) = scene.nodes.iter().find(|n| **n >= parents.len()) {
        return Err(Fault::out_of_range(place, "node", bad, parents.len()));
    }
    let mut listed = vec![false; parents.len()];
    for &node in &scene.nodes {
        listed[node] = true;
    }
    // Some exporters list every node here; those that hang under another are reached from there.
    let reached = |node: usize| std::iter::successors(parents[node], |&p| parents[p]).any(|p| listed[p]);
    Ok(scene.nodes.iter().copied().filter(|&n| !reached(n)).collect())
}

/// Names of nodes as parts of a path: siblings that share a name are numbered, so that a path names one node.
fn group_names(nodes: &[Node], parents: &[Option<usize>]) -> Vec<String> {
    let mut times = std::collections::HashMap::new();
    let named = |index: usize| nodes[index].name.clone().unwrap_or_else(|| format!("node {index}"));
    (0..nodes.len())
        .map(|index| {
            let name = named(index);
            let time = times.entry((parents[index], name.clone())).or_insert(0);
            *time += 1;
            if *time == 1 { name } else { format!("{name} #{time}") }
        })
        .collect()
}

/// A node's own transform (§3.5.3).
fn local(node: &Node, place: &str) -> Result<Affine3A, Fault> {
    if let Some(matrix) = node.matrix {
        let matrix = Mat4::from_cols_array(&matrix);
        if !matrix.is_finite() {
            return Err(Fault::malformed(format!("{place}.matrix"), "it has a number that is not finite"));
        }
        return Ok(Affine3A::from_mat4(matrix));
    }
    let rotation = Quat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let scale = Vec3::from_array(node.scale.unwrap_or([1.0; 3]));
    let translation = Vec3::from_array(node.translation.unwrap_or([0.0; 3]));
    if !(rotation.is_finite() && scale.is_finite() && translation.is_finite()) {
        return Err(Fault::malformed(place, "its place has a number that is not finite"));
    }
    let length = rotation.length();
    let rotation = if length > 1e-6 && length.is_finite() { rotation / length } else { Quat::IDENTITY };
    Ok(Affine3A::from_mat3_translation(Mat3::from_quat(rotation) * Mat3::from_diagonal(scale), translation))
}

/// Refuses documents that name an extension without which they can't be understood.
pub fn refuse_required_extensions(document: &Document) -> Result<(), Fault> {
    const UNDERSTOOD: [&str; 16] = [
        "KHR_mesh_quantization",
        "KHR_texture_transform",
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_materials_transmission",
        "KHR_materials_unlit",
        "KHR_materials_emissive_strength",
        "KHR_materials_clearcoat",
        "KHR_materials_ior",
        "KHR_materials_specular",
        "KHR_materials_sheen",
        "KHR_materials_volume",
        "KHR_lights_punctual",
        "KHR_texture_basisu",
        "EXT_texture_webp",
        "KHR_materials_variants",
        "KHR_draco_mesh_compression",
    ];
    // Draco and meshopt are refused where they are used, with the place; pictures are left out with a note.
    let known =
        |name: &str| UNDERSTOOD.contains(&name) || name.contains("meshopt") || name.contains("_materials_");
    match document.extensions_required.iter().find(|name| !known(name)) {
        Some(name) => Err(Fault::new(
            "extensionsRequired",
            Problem::Unsupported {
                feature: format!("the glTF extension {name}"),
                remedy: "Export it without that extension.",
            },
        )),
        None => Ok(()),
    }
}
