//! Which atoms make up one thing: legs and the top they carry, a shell and its feet, a frame and its glass.
//! Things that only stand on or beside each other stay apart.

use std::collections::{BTreeSet, HashMap};

use glam::{Affine3A, Vec3};

use super::atoms::{Atom, is_furniture_sized, join, root, world_triangles};
use crate::assets::Model;
use crate::math::Aabb;
use crate::scene::Category;
use crate::scene::step::{Pace, Step, Stopped, group};

/// Surfaces that come this close touch.
const TOUCH_M: f32 = 0.012;

/// Cells in which touching is looked for; with [`TOUCH_M`] to either side.
const CELL_M: f32 = 0.03;

/// Things of one cell that are compared with each other.
const MAX_IN_CELL: usize = 12;

/// Merging changes boxes, and boxes decide: repeated until nothing changes, at most this often.
const MAX_ROUNDS: usize = 8;

/// Loose pieces of one node that are smaller than this stay together: handles, buttons, leaves.
const LOOSE_M: f32 = 0.35;

/// What reaches down to here stands on the floor.
const STANDS_M: f32 = 0.08;

/// What a growing cluster is like.
#[derive(Clone, Copy)]
struct Cluster {
    bounds: Aabb,
    category: Option<Category>,
    /// The box around what has a name.
    named: Aabb,
}

impl Cluster {
    fn of(atom: &Atom) -> Self {
        let named = if atom.category.is_some() { atom.bounds } else { Aabb::EMPTY };
        Self { bounds: atom.bounds, category: atom.category, named }
    }

    fn with(self, other: Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            category: self.category.or(other.category),
            named: self.named.union(other.named),
        }
    }

    /// Whether what has a name makes up enough of the whole to give it its name: a plant in a cupboard doesn't
    /// make the cupboard a plant.
    fn deserves_its_name(&self) -> bool {
        let volume = |b: Aabb| b.size().max(Vec3::splat(0.02)).element_product();
        self.category.is_none() || volume(self.bounds) < 3.0 * volume(self.named)
    }
}

/// The clusters of `atoms`, each as atom numbers; ordered by their first atom, every atom in exactly one.
///
/// # Errors
/// [`Stopped`] when `step` breaks off.
pub fn clusters(
    model: &Model,
    atoms: &[Atom],
    world_from_file: Affine3A,
    step: Step,
) -> Result<Vec<Vec<usize>>, Stopped> {
    let mut roots: Vec<u32> = (0..atoms.len() as u32).collect();
    let mut clusters: Vec<Cluster> = atoms.iter().map(Cluster::of).collect();
    let touching = touching(model, atoms, world_from_file, step)?;
    for _ in 0..MAX_ROUNDS {
        let mut changed = false;
        for &(a, b) in &touching {
            let (a, b) = (root(&mut roots, a), root(&mut roots, b));
            let (first, second) = (clusters[a as usize], clusters[b as usize]);
            if a == b || !belong_together(first, second) {
                continue;
            }
            join(&mut roots, a, b);
            clusters[a.min(b) as usize] = first.with(second);
            changed = true;
        }
        if !changed {
            break;
        }
    }
    join_leftovers(atoms, &clusters, &mut roots);
    let mut found: Vec<Vec<usize>> = Vec::new();
    let mut number_of: HashMap<u32, usize> = HashMap::new();
    for atom in 0..atoms.len() {
        let next = found.len();
        let number = *number_of.entry(root(&mut roots, atom as u32)).or_insert(next);
        if number == next {
            found.push(Vec::new());
        }
        found[number].push(atom);
    }
    Ok(found)
}

/// What was taken apart for nothing goes together again: the building's parts, the small loose pieces of a
/// node, and all pieces of a node of furniture's size that doesn't hold several standing things.
fn join_leftovers(atoms: &[Atom], clusters: &[Cluster], roots: &mut [u32]) {
    let is_standing = |c: &Cluster| c.bounds.min.y < STANDS_M && c.bounds.size().y > LOOSE_M;
    let mut standing: HashMap<usize, BTreeSet<u32>> = HashMap::new();
    let mut groups_in: HashMap<u32, BTreeSet<usize>> = HashMap::new();
    let mut group_bounds: HashMap<usize, Aabb> = HashMap::new();
    for (number, atom) in atoms.iter().enumerate() {
        let own = root(roots, number as u32);
        groups_in.entry(own).or_default().insert(atom.group);
        let bounds = group_bounds.entry(atom.group).or_insert(Aabb::EMPTY);
        *bounds = bounds.union(atom.bounds);
        if is_standing(&clusters[own as usize]) {
            standing.entry(atom.group).or_default().insert(own);
        }
    }
    let mut together: HashMap<(usize, bool), u32> = HashMap::new();
    for (number, atom) in atoms.iter().enumerate() {
        let own = root(roots, number as u32);
        let Some(cluster) = clusters.get(own as usize) else { continue };
        let alone = groups_in.get(&own).is_some_and(|groups| groups.len() == 1);
        let several = standing.get(&atom.group).is_some_and(|s| s.len() > 1);
        let small = cluster.category.is_none() && cluster.bounds.size().max_element() < LOOSE_M;
        let one_thing = is_furniture_sized(group_bounds[&atom.group]) && !(several && is_standing(cluster));
        if !atom.is_movable() || (alone && (small || one_thing)) {
            join(roots, *together.entry((atom.group, atom.is_movable())).or_insert(own), own);
        }
    }
}

/// Whether two touching clusters are one thing, by how their boxes lie.
fn belong_together(first: Cluster, second: Cluster) -> bool {
    let agree = match (first.category, second.category) {
        (Some(a), Some(b)) => a == b,
        _ => first.with(second).deserves_its_name(),
    };
    if !agree || !is_furniture_sized(first.bounds.union(second.bounds)) {
        return false;
    }
    let (lower, upper) = match first.bounds.center().y <= second.bounds.center().y {
        true => (first.bounds, second.bounds),
        false => (second.bounds, first.bounds),
    };
    // What lies flat on the floor carries things but is none of them.
    if lower.size().y < 0.03 && lower.max.y < 0.05 && plan_area(lower) > 0.25 {
        return false;
    }
    let plan = plan_overlap(lower, upper);
    let (lower_plan, upper_plan) = (plan_area(lower), plan_area(upper));
    let shared_height = (lower.max.y.min(upper.max.y) - lower.min.y.max(upper.min.y)).max(0.0);
    let smaller = lower_plan.min(upper_plan);
    let thinner_height = lower.size().y.min(upper.size().y).max(1e-3);
    let inside = plan / smaller * (shared_height / thinner_height).min(1.0);
    let same_plan = plan / (lower_plan + upper_plan - plan) > 0.5;
    let carries = plan / lower_plan > 0.75 && lower_plan < 0.8 * upper_plan;
    let grows_out = plan / smaller > 0.6 && shared_height > 0.02 && shared_height / thinner_height > 0.3;
    if is_backrest(lower, upper) {
        return true;
    }
    if lower.min.y.max(upper.min.y) < STANDS_M {
        // Both stand on the floor: a chair pushed under a table is no part of it, a leg is.
        let beneath = lower.max.y < upper.min.y + 0.03;
        return inside > 0.8 || same_plan || (carries && beneath);
    }
    inside > 0.5 || same_plan || carries || grows_out
}

/// Whether `upper` is the back or an arm of the seat `lower`: thin, higher than the seat, as long as it, and
/// reaching down beside it, not standing on it as a screen on its board does.
fn is_backrest(lower: Aabb, upper: Aabb) -> bool {
    let size = upper.size();
    let (long, thickness) = if size.x > size.z { (0, size.z) } else { (2, size.x) };
    let shared = lower.max[long].min(upper.max[long]) - lower.min[long].max(upper.min[long]);
    let longer = lower.size()[long].max(size[long]);
    let is_seat = (0.3..0.62).contains(&lower.max.y);
    let reaches_down = upper.min.y < lower.max.y - 0.03;
    is_seat && reaches_down && (0.5..1.3).contains(&upper.max.y) && thickness < 0.35 && shared > 0.75 * longer
}

/// Area of a box's ground plan, 1 cm at least a side, square metres.
fn plan_area(bounds: Aabb) -> f32 {
    let size = bounds.size().max(Vec3::splat(0.01));
    size.x * size.z
}

/// Area that the ground plans share, each grown by half of [`TOUCH_M`].
fn plan_overlap(a: Aabb, b: Aabb) -> f32 {
    let low = a.min.max(b.min);
    let high = a.max.min(b.max);
    let size = (high - low + Vec3::splat(TOUCH_M)).max(Vec3::ZERO);
    (size.x * size.z).min(plan_area(a)).min(plan_area(b))
}

/// Pairs of movable atoms whose surfaces touch, in order.
fn touching(
    model: &Model,
    atoms: &[Atom],
    world_from_file: Affine3A,
    step: Step,
) -> Result<BTreeSet<(u32, u32)>, Stopped> {
    let mut in_cell: Vec<([i32; 3], u32)> = Vec::new();
    let mut pace = Pace::new(step, 0);
    for (number, atom) in atoms.iter().enumerate().filter(|(_, a)| a.is_movable()) {
        let start = in_cell.len();
        for triangle in atom.pieces.iter().flat_map(|piece| world_triangles(model, piece, world_from_file)) {
            let before = in_cell.len();
            sampled(triangle, |p| {
                for shift in [-TOUCH_M * 0.5, TOUCH_M * 0.5] {
                    let cell = ((p + Vec3::splat(shift)) / CELL_M).floor().as_ivec3().to_array();
                    // Neighbouring samples fall into one cell.
                    if in_cell.len() < start + 2 || !in_cell[in_cell.len() - 2..].iter().any(|c| c.0 == cell)
                    {
                        in_cell.push((cell, number as u32));
                    }
                }
            });
            pace.items(1 + in_cell.len() - before)?;
        }
    }
    let cells = group(in_cell, step, |([x, y, z], _)| {
        u64::from(*x as u32) ^ u64::from(*y as u32).rotate_left(21) ^ u64::from(*z as u32).rotate_left(42)
    })?;
    let mut pairs = BTreeSet::new();
    let mut pace = Pace::new(step, 0);
    for mut in_cell in cells {
        in_cell.dedup();
        pace.items(in_cell.len())?;
        for cell in in_cell.chunk_by(|a, b| a.0 == b.0) {
            let here = &cell[..cell.len().min(MAX_IN_CELL)];
            for (i, a) in here.iter().enumerate() {
                pairs.extend(here[i + 1..].iter().map(|b| (a.1, b.1)));
            }
        }
    }
    Ok(pairs)
}

/// Calls `with` for points of a triangle no further apart than two thirds of a cell.
fn sampled([a, b, c]: [Vec3; 3], mut with: impl FnMut(Vec3)) {
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    // Furniture's triangles are at most a few metres long.
    let steps = ((longest / (CELL_M * 0.66)).ceil() as usize).clamp(1, 400);
    for i in 0..=steps {
        for j in 0..=steps - i {
            let (u, v) = (i as f32 / steps as f32, j as f32 / steps as f32);
            with(a + (b - a) * u + (c - a) * v);
        }
    }
}
