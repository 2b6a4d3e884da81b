//! Surfaces that can hold somebody or something: seats, beds, sofas, table tops, found from the geometry
//! alone (no categories), so that they are found in soups and scans too.
//!
//! Tops of all columns are joined with neighbours at nearly the same height. The floor is left to
//! `floor`.

use std::collections::HashMap;

use glam::Vec3;

use super::ObjectId;
use super::bvh::TriangleBvh;
use super::columns::{Columns, Top};
use super::field::SignedDistanceField;
use super::step::{Pace, Step, Stopped, report};
use crate::math::Aabb;

/// Spacing of the columns: a chair's seat has about 12 across.
const COLUMN_M: f32 = 0.035;
/// Neighbours one column apart join up to this difference in height: slopes of 30 degrees.
const JOIN_M: f32 = 0.02;
/// Columns of one object join over a gap of one column (the crease between two cushions) up to this difference.
const JOIN_OVER_GAP_M: f32 = 0.03;
/// Smaller surfaces hold nobody: 20 x 20 cm.
const SMALLEST_M2: f32 = 0.04;
/// Lower surfaces are floor, rug or threshold.
const LOWEST_M: f32 = 0.1;
/// Surfaces with less room above hold nothing worth placing.
const LEAST_CLEARANCE_M: f32 = 0.12;

/// One column of a [`SupportSurface`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportCell {
    /// The point on the surface, world frame.
    pub position: Vec3,
    /// Free height above it in metres.
    pub clearance_m: f32,
}

/// A point on the border of a [`SupportSurface`] where it ends (not where a back rises).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePoint {
    /// On the surface, at its border.
    pub position: Vec3,
    /// Horizontal unit vector away from the surface.
    pub outward: Vec3,
    /// From the edge down to the next surface in front of it, in metres.
    pub drop_m: f32,
    /// How far free space goes outward halfway down to that surface (where legs hang), in metres, at most
    /// [`FREE_LIMIT_M`].
    pub leg_free_m: f32,
    /// How far free space goes outward 30 cm above the surface (where the body leans), at most [`FREE_LIMIT_M`].
    pub body_free_m: f32,
}

/// Free space in front of an edge is measured up to here.
pub const FREE_LIMIT_M: f32 = 1.5;

/// Something that rises at the border of a [`SupportSurface`]: backrest, armrest, headboard or wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Back {
    /// Horizontal unit vector from the surface towards it: who leans on it faces the other way.
    pub direction: Vec3,
    /// How far it rises above the surface, in metres, at most 0.8.
    pub height_m: f32,
    /// Length of border along which it rises, in metres.
    pub length_m: f32,
    /// What it belongs to, if known.
    pub object: Option<ObjectId>,
}

/// A roughly horizontal area that can hold somebody or something.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportSurface {
    /// What most of it belongs to.
    pub object: Option<ObjectId>,
    /// Mean height in metres, world frame.
    pub height_m: f32,
    /// Its columns.
    pub cells: Vec<SupportCell>,
    /// Spacing of the columns in metres.
    pub cell_m: f32,
    /// Area seen from above.
    pub area_m2: f32,
    /// Least free height above any of its columns, in metres.
    pub clearance_m: f32,
    /// The box around the cells.
    pub bounds: Aabb,
    /// Where it ends.
    pub edges: Vec<EdgePoint>,
    /// What rises at its border, the longest border first.
    pub backs: Vec<Back>,
}

/// Finds every support surface of a room. `owner` names the object of each triangle, or is empty.
///
/// # Errors
/// [`Stopped`] when `step` breaks off.
pub fn find_supports(
    bvh: &TriangleBvh,
    field: &SignedDistanceField,
    owner: &[ObjectId],
    step: Step,
) -> Result<Vec<SupportSurface>, Stopped> {
    let columns = Columns::new(bvh, field, COLUMN_M, step)?;
    let finder = Finder { bvh, owner, columns, step };
    let groups = finder.groups()?;
    let mut surfaces = Vec::new();
    for (done, group) in groups.iter().enumerate() {
        report(step, done, groups.len())?;
        if group.len() as f32 * COLUMN_M * COLUMN_M >= SMALLEST_M2 {
            surfaces.push(finder.surface(group)?);
        }
    }
    Ok(surfaces)
}

/// A top in its column.
type Place = ([usize; 2], Top);

struct Finder<'a> {
    bvh: &'a TriangleBvh,
    owner: &'a [ObjectId],
    columns: Columns,
    step: Step<'a>,
}

impl Finder<'_> {
    fn object(&self, triangle: usize) -> Option<ObjectId> {
        self.owner.get(triangle).copied()
    }

    /// Tops joined with their neighbours.
    fn groups(&self) -> Result<Vec<Vec<Place>>, Stopped> {
        let usable = |top: &Top| top.height_m >= LOWEST_M && top.clearance_m >= LEAST_CLEARANCE_M;
        let [nx, nz] = self.columns.dim;
        let mut taken: HashMap<([usize; 2], usize), ()> = HashMap::new();
        let mut groups = Vec::new();
        let mut pace = Pace::new(self.step, nx * nz);
        for column in (0..nx).flat_map(|x| (0..nz).map(move |z| [x, z])) {
            for (rank, top) in self.columns.tops(column).iter().enumerate() {
                if !usable(top) || taken.insert((column, rank), ()).is_some() {
                    continue;
                }
                let mut group = vec![(column, *top)];
                let mut next = 0;
                while next < group.len() {
                    let (from, at) = group[next];
                    next += 1;
                    pace.items(NEIGHBOURS.len())?;
                    for (by, reach_m, same_object) in NEIGHBOURS {
                        let Some(to) = self.columns.neighbour(from, by) else { continue };
                        for (rank, top) in self.columns.tops(to).iter().enumerate() {
                            let level = (top.height_m - at.height_m).abs() <= reach_m;
                            let kin = !same_object || self.object(top.triangle) == self.object(at.triangle);
                            if level && kin && usable(top) && taken.insert((to, rank), ()).is_none() {
                                group.push((to, *top));
                            }
                        }
                    }
                }
                groups.push(group);
            }
        }
        Ok(groups)
    }

    fn surface(&self, group: &[Place]) -> Result<SupportSurface, Stopped> {
        let cells: Vec<SupportCell> = group
            .iter()
            .map(|&(column, top)| SupportCell {
                position: self.columns.position(column, top.height_m),
                clearance_m: top.clearance_m,
            })
            .collect();
        let mut owners: HashMap<ObjectId, usize> = HashMap::new();
        for object in group.iter().filter_map(|(_, top)| self.object(top.triangle)) {
            *owners.entry(object).or_default() += 1;
        }
        let (edges, backs) = self.border(group)?;
        Ok(SupportSurface {
            object: owners.into_iter().max_by_key(|&(id, n)| (n, std::cmp::Reverse(id))).map(|(id, _)| id),
            height_m: cells.iter().map(|c| c.position.y).sum::<f32>() / cells.len() as f32,
            cell_m: COLUMN_M,
            area_m2: cells.len() as f32 * COLUMN_M * COLUMN_M,
            clearance_m: cells.iter().map(|c| c.clearance_m).fold(f32::INFINITY, f32::min),
            bounds: Aabb::of(cells.iter().map(|c| c.position)),
            cells,
            edges,
            backs,
        })
    }

    /// Walks along the border: where it ends freely and where something rises.
    fn border(&self, group: &[Place]) -> Result<(Vec<EdgePoint>, Vec<Back>), Stopped> {
        let members: HashMap<[usize; 2], ()> = group.iter().map(|&(column, _)| (column, ())).collect();
        let is_member = |from, by| self.columns.neighbour(from, by).is_some_and(|c| members.contains_key(&c));
        let mut edges = Vec::new();
        let mut rises = Vec::new();
        let mut pace = Pace::new(self.step, group.len());
        for &(column, top) in group {
            pace.item()?;
            if [[1, 0], [-1, 0], [0, 1], [0, -1]].iter().all(|&by| is_member(column, by)) {
                continue;
            }
            // Some ten rays.
            pace.items(RISE_STEPS)?;
            let Some(outward) = outward(|by| is_member(column, by)) else { continue };
            let position = self.columns.position(column, top.height_m);
            match self.rise(position, outward) {
                Some((height_m, object)) => rises.push((outward, height_m, object)),
                None => edges.extend(self.edge(position, outward)),
            }
        }
        Ok((edges, join_backs(&rises)))
    }

    /// How far something rises within a hand's breadth beyond the border, and whose it is.
    fn rise(&self, position: Vec3, outward: Vec3) -> Option<(f32, Option<ObjectId>)> {
        (1..=RISE_STEPS).rev().find_map(|i| {
            let height_m = i as f32 * RISE_STEP_M;
            let from = position + Vec3::Y * height_m - outward * COLUMN_M;
            let hit = self.bvh.cast(from, outward, RISE_REACH_M + COLUMN_M)?;
            Some((height_m, self.object(hit.triangle)))
        })
    }

    fn edge(&self, position: Vec3, outward: Vec3) -> Option<EdgePoint> {
        let position = position + outward * (0.5 * COLUMN_M);
        let front = position + outward * IN_FRONT_M;
        let below = self.columns.nearest(front).map_or(&[][..], |column| self.columns.tops(column));
        let ground_m =
            below.iter().map(|t| t.height_m).filter(|&y| y < position.y - JOIN_M).fold(0.0, f32::max);
        let drop_m = position.y - ground_m;
        let reach = |height_m: f32| {
            let from = (position + outward * 0.01).with_y(height_m);
            self.bvh.cast(from, outward, FREE_LIMIT_M).map_or(FREE_LIMIT_M, |hit| hit.distance_m)
        };
        (drop_m >= LEAST_DROP_M).then(|| EdgePoint {
            position,
            outward,
            drop_m,
            leg_free_m: reach(position.y - 0.5 * drop_m),
            body_free_m: reach(position.y + 0.3),
        })
    }
}

/// Steps to neighbours, the difference in height that still joins, and whether only within one object.
const NEIGHBOURS: [([isize; 2], f32, bool); 8] = [
    ([1, 0], JOIN_M, false),
    ([-1, 0], JOIN_M, false),
    ([0, 1], JOIN_M, false),
    ([0, -1], JOIN_M, false),
    ([2, 0], JOIN_OVER_GAP_M, true),
    ([-2, 0], JOIN_OVER_GAP_M, true),
    ([0, 2], JOIN_OVER_GAP_M, true),
    ([0, -2], JOIN_OVER_GAP_M, true),
];
/// A back counts from 10 cm above the surface up to 80 cm.
const RISE_STEP_M: f32 = 0.1;
const RISE_STEPS: usize = 8;
/// A back stands at most this far beyond the border (cushions hide the rear of a seat).
const RISE_REACH_M: f32 = 0.15;
/// Where the surface in front of an edge is looked for: beyond the overhang of a cushion.
const IN_FRONT_M: f32 = 0.12;
/// Lower steps aren't edges that legs hang from.
const LEAST_DROP_M: f32 = 0.05;
/// Columns around a border column that tell which way is out.
const OUTWARD_WINDOW: isize = 3;

/// The horizontal direction away from the members around a border column.
fn outward(is_member: impl Fn([isize; 2]) -> bool) -> Option<Vec3> {
    let window = -OUTWARD_WINDOW..=OUTWARD_WINDOW;
    let mut away = Vec3::ZERO;
    for (dx, dz) in window.clone().flat_map(|dx| window.clone().map(move |dz| (dx, dz))) {
        if is_member([dx, dz]) {
            away -= Vec3::new(dx as f32, 0.0, dz as f32);
        }
    }
    away.try_normalize()
}

/// Joins rises whose directions lie within 45 degrees.
fn join_backs(rises: &[(Vec3, f32, Option<ObjectId>)]) -> Vec<Back> {
    let mut joined: Vec<Vec<&(Vec3, f32, Option<ObjectId>)>> = Vec::new();
    let mut means: Vec<Vec3> = Vec::new();
    for rise in rises {
        let near = means.iter().position(|mean| mean.normalize_or_zero().dot(rise.0) >= 0.7);
        match near {
            Some(i) => {
                means[i] += rise.0;
                joined[i].push(rise);
            }
            None => {
                means.push(rise.0);
                joined.push(vec![rise]);
            }
        }
    }
    let mut backs: Vec<Back> = means
        .iter()
        .zip(&joined)
        .map(|(mean, members)| {
            let mut heights: Vec<f32> = members.iter().map(|m| m.1).collect();
            heights.sort_unstable_by(f32::total_cmp);
            Back {
                direction: mean.normalize_or(Vec3::X),
                height_m: heights[heights.len() / 2],
                length_m: members.len() as f32 * COLUMN_M,
                object: members[members.len() / 2].2,
            }
        })
        .collect();
    backs.sort_by(|a, b| b.length_m.total_cmp(&a.length_m));
    backs
}
