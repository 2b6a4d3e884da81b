//! Takes a model apart into the smallest things that may be moved by themselves: nodes, or the connected
//! components of a mesh that holds many things. Every triangle belongs to exactly one.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::names;
use crate::assets::{Mesh, Model, NumberMap, Part};
use crate::math::Aabb;
use crate::scene::Category;
use crate::scene::step::{Pace, Step, Stopped, report};

/// Furniture is no longer and no higher than this.
const MAX_LENGTH_M: f32 = 3.6;
const MAX_HEIGHT_M: f32 = 2.6;

/// Corners this close are one: exporters write cracks of rounding errors.
const WELD_M: f32 = 1e-3;

/// More components than this are leaves, hair or noise of a scan: not worth taking apart.
const MAX_COMPONENTS: usize = 4_000;

/// Some or all triangles of one part.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Index into [`Model::parts`].
    pub part: usize,
    /// The triangles, or `None` for all.
    pub triangles: Option<Vec<u32>>,
}

/// A thing that is not taken apart further.
#[derive(Clone, Debug)]
pub struct Atom {
    pub pieces: Vec<Piece>,
    pub bounds: Aabb,
    /// What its name or its extras say.
    pub category: Option<Category>,
    /// Number of the group (node or named ancestor) that it comes from.
    pub group: usize,
    /// Area, square metres.
    pub area: f32,
}

impl Atom {
    /// Whether it is of furniture's size and not part of the building.
    pub fn is_movable(&self) -> bool {
        !self.category.is_some_and(Category::is_structure) && is_furniture_sized(self.bounds)
    }
}

/// Whether a box may hold one piece of furniture.
pub fn is_furniture_sized(bounds: Aabb) -> bool {
    let size = bounds.size();
    size.x.max(size.z) <= MAX_LENGTH_M && size.y <= MAX_HEIGHT_M
}

/// The triangles of a piece in the world frame.
pub fn world_triangles<'a>(
    model: &'a Model,
    piece: &'a Piece,
    world_from_file: Affine3A,
) -> impl Iterator<Item = [Vec3; 3]> + 'a {
    let part = &model.parts[piece.part];
    let world_from_mesh = world_from_file * part.file_from_mesh;
    let count = piece.triangles.as_ref().map_or(part.mesh.triangles.len(), Vec::len);
    (0..count).map(move |i| {
        let t = piece.triangles.as_ref().map_or(i, |list| list[i] as usize);
        part.mesh.corners(t).map(|p| world_from_mesh.transform_point3(p))
    })
}

/// The mesh of a piece: the part's own, or a new one of the triangles in the piece.
///
/// # Errors
/// [`Stopped`] when `step` breaks off.
pub fn mesh_of(part: &Part, piece: &Piece, step: Step) -> Result<Arc<Mesh>, Stopped> {
    let Some(triangles) = &piece.triangles else { return Ok(part.mesh.clone()) };
    let mut pace = Pace::new(step, 0);
    let mut new_of_old: NumberMap<u32, u32> = NumberMap::default();
    let mut old_of_new = Vec::new();
    let mut number = |old: u32| {
        *new_of_old.entry(old).or_insert_with(|| {
            old_of_new.push(old as usize);
            old_of_new.len() as u32 - 1
        })
    };
    let renumbered = triangles.iter().map(|t| {
        pace.item()?;
        Ok(part.mesh.triangles[*t as usize].map(&mut number))
    });
    let triangles = renumbered.collect::<Result<_, Stopped>>()?;
    Ok(Arc::new(Mesh {
        positions: picked(&part.mesh.positions, &old_of_new),
        normals: picked(&part.mesh.normals, &old_of_new),
        uvs: picked(&part.mesh.uvs, &old_of_new),
        colors: picked(&part.mesh.colors, &old_of_new),
        triangles,
    }))
}

fn picked<T: Copy>(of: &[T], which: &[usize]) -> Vec<T> {
    if of.is_empty() { Vec::new() } else { which.iter().map(|&v| of[v]).collect() }
}

/// Every atom of `model`, in the order of the file.
///
/// # Errors
/// [`Stopped`] when `step` breaks off.
pub fn atoms(model: &Model, world_from_file: Affine3A, step: Step) -> Result<Vec<Atom>, Stopped> {
    let mut atoms = Vec::new();
    for (group, parts) in groups(model, world_from_file).into_iter().enumerate() {
        report(step, 0, 0)?;
        let category = category(model, &parts);
        let whole =
            atom(model, parts.iter().map(|&part| Piece { part, triangles: None }).collect(), world_from_file);
        let whole = Atom { category, group, ..whole };
        // A named thing is one thing, unless it is as large as many.
        if category.is_some_and(|c| c.is_structure() || is_furniture_sized(whole.bounds)) {
            atoms.push(whole);
            continue;
        }
        let components = components(model, &parts, world_from_file, step)?;
        if components.len() < 2 || components.len() > MAX_COMPONENTS {
            atoms.push(whole);
            continue;
        }
        let category = category.filter(|_| false);
        for pieces in components {
            report(step, 0, 0)?;
            atoms.push(Atom { category, group, ..atom(model, pieces, world_from_file) });
        }
    }
    Ok(atoms)
}

fn atom(model: &Model, pieces: Vec<Piece>, world_from_file: Affine3A) -> Atom {
    let (mut bounds, mut area) = (Aabb::EMPTY, 0.0);
    for [a, b, c] in pieces.iter().flat_map(|piece| world_triangles(model, piece, world_from_file)) {
        bounds = bounds.include(a).include(b).include(c);
        area += (b - a).cross(c - a).length() * 0.5;
    }
    Atom { pieces, bounds, category: None, group: 0, area }
}

/// Parts (by index) of each node, or of the outermost node above that names one piece of furniture and is of
/// such a size.
fn groups(model: &Model, world_from_file: Affine3A) -> Vec<Vec<usize>> {
    let mut box_of_prefix: HashMap<&[String], Aabb> = HashMap::new();
    for part in &model.parts {
        let bounds = world_bounds(part, world_from_file);
        for depth in (1..=part.path.len()).filter(|&d| names::names_one_thing(&part.path[d - 1])) {
            let whole = box_of_prefix.entry(&part.path[..depth]).or_insert(Aabb::EMPTY);
            *whole = whole.union(bounds);
        }
    }
    let mut number_of: HashMap<(Option<&[String]>, usize), usize> = HashMap::new();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (index, part) in model.parts.iter().enumerate() {
        let mut prefixes = (1..=part.path.len()).map(|depth| &part.path[..depth]);
        let holder = prefixes.find(|p| box_of_prefix.get(p).is_some_and(|b| is_furniture_sized(*b)));
        let own = holder.is_none_or(|above| is_its_own_thing(part, above, world_from_file));
        let key = if own { (None, part.node) } else { (holder, 0) };
        let next = groups.len();
        let number = *number_of.entry(key).or_insert(next);
        if number == next {
            groups.push(Vec::new());
        }
        groups[number].push(index);
    }
    groups
}

/// Whether a part below a named thing is another thing by its own name, and large enough to be one: a chair
/// below "table", not a cushion below "sofa".
fn is_its_own_thing(part: &Part, above: &[String], world_from_file: Affine3A) -> bool {
    let holder = above.last().and_then(|name| names::category(name));
    let own = names::category(&part.name).filter(|c| !matches!(c, Category::Cushion | Category::Objects));
    own.is_some() && own != holder && world_bounds(part, world_from_file).size().max_element() > 0.4
}

fn world_bounds(part: &Part, world_from_file: Affine3A) -> Aabb {
    let world_from_mesh = world_from_file * part.file_from_mesh;
    Aabb::of(part.mesh.positions.iter().map(|p| world_from_mesh.transform_point3(*p)))
}

/// What extras, names or materials say of the parts of a group.
fn category(model: &Model, parts: &[usize]) -> Option<Category> {
    let parts: Vec<&Part> = parts.iter().map(|&p| &model.parts[p]).collect();
    let first = parts.first()?;
    let several = parts.iter().any(|p| p.node != first.node);
    let above = first.path.iter().rev().find(|name| names::names_one_thing(name)).filter(|_| several);
    let stated = parts.iter().find_map(|p| stated_category(p));
    let named = || above.and_then(|name| names::category(name)).or_else(|| names::category(&first.name));
    stated.or_else(named).or_else(|| material_category(model, &parts))
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

/// Connected components of the triangles of `parts`, in the order of their first triangle.
fn components(
    model: &Model,
    parts: &[usize],
    world_from_file: Affine3A,
    step: Step,
) -> Result<Vec<Vec<Piece>>, Stopped> {
    let mut number_of: NumberMap<[i32; 3], u32> = NumberMap::default();
    let mut roots: Vec<u32> = Vec::new();
    let mut place_of: Vec<Vec<u32>> = Vec::new();
    let mut pace = Pace::new(step, 0);
    for &part in parts {
        let part = &model.parts[part];
        let world_from_mesh = world_from_file * part.file_from_mesh;
        let mut place = |p: &Vec3| {
            let world = world_from_mesh.transform_point3(*p);
            let next = roots.len() as u32;
            let number =
                *number_of.entry((world / WELD_M).round().to_array().map(|c| c as i32)).or_insert(next);
            if number == next {
                roots.push(next);
            }
            pace.item()?;
            Ok(number)
        };
        place_of.push(part.mesh.positions.iter().map(&mut place).collect::<Result<_, Stopped>>()?);
    }
    for (places, &part) in place_of.iter().zip(parts) {
        for [a, b, c] in model.parts[part].mesh.triangles.iter().map(|t| t.map(|v| places[v as usize])) {
            pace.item()?;
            join(&mut roots, a, b);
            join(&mut roots, b, c);
        }
    }
    let mut order: NumberMap<u32, usize> = NumberMap::default();
    let mut found: Vec<Vec<Piece>> = Vec::new();
    for (places, &part) in place_of.iter().zip(parts) {
        for (t, triangle) in model.parts[part].mesh.triangles.iter().enumerate() {
            pace.item()?;
            let next = found.len();
            let component = *order.entry(root(&mut roots, places[triangle[0] as usize])).or_insert(next);
            if component == next {
                found.push(Vec::new());
            }
            let pieces = &mut found[component];
            if pieces.last().is_none_or(|p| p.part != part) {
                pieces.push(Piece { part, triangles: Some(Vec::new()) });
            }
            if let Some(list) = pieces.last_mut().and_then(|p| p.triangles.as_mut()) {
                list.push(t as u32);
            }
        }
    }
    Ok(found)
}

/// The root of `at`, halving the path to it.
pub fn root(roots: &mut [u32], mut at: u32) -> u32 {
    while roots[at as usize] != at {
        roots[at as usize] = roots[roots[at as usize] as usize];
        at = roots[at as usize];
    }
    at
}

/// Joins two sets; the smaller number becomes the root, so that the order of the file is kept.
pub fn join(roots: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(roots, a), root(roots, b));
    roots[a.max(b) as usize] = a.min(b);
}
