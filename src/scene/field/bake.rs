//! From triangles to a signed distance field.
//!
//! # What counts as solid
//! Rooms come as closed boxes, single planes, triangle soup and open scans, with normals either way. No
//! single rule serves them all, so three are stacked, each for what it does well:
//!
//! 1. **Air must get there.** Blocks with 0.2 m of clearance all round that form a region of a room's size
//!    are where somebody could stand. From there a ball of 5 cm radius floods the samples; a step
//!    between two samples is closed when any triangle crosses it, whatever its orientation. What the flood
//!    never reaches is solid: closed furniture, walls with thickness, cushions that overlap a seat, a sofa
//!    without bottom that stands on the floor, the inside of a closed cupboard. Holes narrower than 10 cm
//!    let no ball through.
//! 2. **Surfaces have fronts.** The side of a connected surface that standing air sees (at least 80 % of
//!    axis-parallel views) is its front, whichever way its normals point. A sample behind a narrow gap (the slit
//!    between wardrobe and wall, the body of a sofa behind a hole in a scan) is air if along ±x, ±z and up it sees more
//!    fronts than backs. Surfaces seen from both sides, and those never seen, don't vote.
//! 3. **Backs all round mean inside.** What the ball does reach is solid only if it sees at least two backs and no front
//!    at all: the hollow of an open sofa on legs, or the space behind a scan's walls. In the middle of a room
//!    some front is always in sight, so this never makes holes in free air.
//!
//! Outside the room (virtual walls and ceiling where its box is open, the floor at `y = 0`, columns far from any
//! floor) all is solid.
//!
//! # Distances
//! Exact in a band about the surfaces, then carried outward by triangle (see `sweep`). Surfaces with solid on
//! both sides don't count (so depth inside overlapping furniture is depth to the air); sheets and plates thinner than a
//! cell are thickened to one (see `thin`).

use glam::Vec3;
use rayon::prelude::*;

use super::SignedDistanceField;
use super::distance::{Facet, NOBODY, Nearest, narrow_band, splat};
use super::grid::Grid;
use super::indoors::distance_indoors;
use super::lines::Lines;
use super::sign::{Surroundings, classify};
use super::sweep::sweep_outward;
use super::thin::{buried, thicken};
use crate::assets::ContentHasher;
use crate::assets::cache::Cache;
use crate::math::Aabb;
use crate::scene::step::{Pace, Step, Stopped, fill, report};

/// How fine the samples lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Cubes of `cell_m`, larger where the bake would take more than `max_bytes` of memory.
    Cells {
        /// Wanted spacing in metres.
        cell_m: f32,
        /// Limit for the memory that baking takes.
        max_bytes: usize,
    },
    /// This many samples over this box, first and last on its faces.
    Exactly {
        /// Samples along x, y and z; at least 2 each.
        dim: [usize; 3],
        /// Box in the world frame.
        bounds: Aabb,
    },
}

/// Settings of [`bake`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldConfig {
    /// How fine the samples lie.
    pub resolution: Resolution,
    /// Width of the band of exact distances on both sides of every surface, in metres.
    pub band_m: f32,
    /// A room without a ceiling gets a virtual one this high, or at its highest point.
    pub ceiling_m: f32,
}

impl Default for FieldConfig {
    fn default() -> Self {
        Self {
            // 2.5 cm resolves limbs (a wrist is 6 cm wide) at about 5 M samples for a living room.
            resolution: Resolution::Cells { cell_m: 0.025, max_bytes: 256 << 20 },
            // Contact and penetration are judged within 5 cm of a surface.
            band_m: 0.055,
            // Rooms are at least about 2.4 m high; a scan without ceiling still lets people stand.
            ceiling_m: 2.4,
        }
    }
}

/// Bytes per sample while baking: distance, triangle, gradient and five small marks.
const BYTES_PER_SAMPLE: usize = 18;
/// Samples beyond the virtual walls on every side, so that the walls are felt before the grid ends.
const MARGIN_CELLS: f32 = 2.0;
/// A room reaches down to a cellar or lower storey from this depth; above it is noise or a floor's thickness.
const BELOW_GROUND_M: f32 = 0.5;

/// Bakes the signed distance field of a room's triangles (world frame, metres). Same bytes for the same
/// input, whatever the number of threads.
///
/// # Errors
/// [`Stopped`] when `step` breaks off.
pub fn bake(
    triangles: &[[Vec3; 3]],
    config: &FieldConfig,
    step: Step,
) -> Result<SignedDistanceField, Stopped> {
    let enclosure = enclosure(triangles, config);
    let grid = grid_for(&enclosure, config.resolution);
    let mut facets = facets_of(triangles, step)?;
    // Every surface must reach some sample, at most half a cell's diagonal away.
    let band_m = config.band_m.max(0.6 * grid.cell_m.length());
    let mut nearest = narrow_band(&grid, &facets, band_m, step)?;
    let along = |axis: usize| Lines::new(&grid, triangles, axis, step);
    let lines = [along(0)?, along(1)?, along(2)?];
    let edge_m = distance_indoors(&grid, &lines[1], step)?;
    let indoors: Vec<bool> = edge_m.iter().map(|&d| d > 0.0).collect();
    let distance_m = &nearest.distance_m;
    let room =
        Surroundings { grid: &grid, lines: &lines, triangles, distance_m, enclosure, indoors: &indoors };
    let solid = classify(&room, step)?;
    refine(&grid, &lines, &solid, &mut facets, band_m, &mut nearest, step)?;
    sweep_outward(&grid, &facets, &solid, band_m, &mut nearest, step)?;
    let values = signed_values(&grid, &solid, &nearest.distance_m, &enclosure, &edge_m, step)?;
    Ok(SignedDistanceField { dim: grid.dim, origin: grid.origin, cell_m: grid.cell_m, values })
}

fn facets_of(triangles: &[[Vec3; 3]], step: Step) -> Result<Vec<Facet>, Stopped> {
    let Some(first) = triangles.first() else { return Ok(Vec::new()) };
    let mut facets = vec![Facet::new(first); triangles.len()];
    fill(&mut facets, step, |t| Facet::new(&triangles[t]))?;
    Ok(facets)
}

/// Thickens sheets and forgets buried surfaces, in the band that is there already.
fn refine(
    grid: &Grid,
    lines: &[Lines; 3],
    solid: &[bool],
    facets: &mut [Facet],
    band_m: f32,
    nearest: &mut Nearest,
    step: Step,
) -> Result<(), Stopped> {
    let buried = buried(grid, lines, solid, facets, step)?;
    let sheets = thicken(grid, lines, solid, facets, step)?;
    nearest.distance_m.par_iter_mut().zip(&mut nearest.triangle).for_each(|(distance_m, triangle)| {
        if *triangle != NOBODY && buried[*triangle as usize] {
            (*distance_m, *triangle) = (f32::INFINITY, NOBODY);
        }
    });
    splat(grid, facets, &sheets, band_m, nearest, |index| !solid[index], step)
}

/// The box that holds all free space.
fn enclosure(triangles: &[[Vec3; 3]], config: &FieldConfig) -> Aabb {
    let mut around = Aabb::of(triangles.iter().flatten().copied());
    if around.is_empty() {
        around = Aabb { min: Vec3::ZERO, max: Vec3::ZERO };
    }
    if around.min.y > -BELOW_GROUND_M {
        around.min.y = 0.0;
    }
    around.max.y = around.max.y.max(around.min.y + config.ceiling_m);
    // Nothing to stand in: give a lone object or an empty room some space around it.
    for axis in [0, 2] {
        let missing = 2.0 - (around.max[axis] - around.min[axis]);
        if missing > 0.0 {
            around.min[axis] -= 0.5 * missing;
            around.max[axis] += 0.5 * missing;
        }
    }
    around
}

fn grid_for(enclosure: &Aabb, resolution: Resolution) -> Grid {
    match resolution {
        Resolution::Exactly { dim, bounds } => {
            let steps = Vec3::from_array(dim.map(|n| (n.max(2) - 1) as f32));
            Grid { dim: dim.map(|n| n.max(2)), origin: bounds.min, cell_m: bounds.size() / steps }
        }
        Resolution::Cells { cell_m, max_bytes } => {
            let volume = enclosure.size().element_product();
            let most = (max_bytes / BYTES_PER_SAMPLE) as f32;
            let cell_m = cell_m.max((volume / most).cbrt() * 1.02);
            let span = enclosure.grown(MARGIN_CELLS * cell_m);
            let dim = (span.size() / cell_m).ceil().to_array().map(|n| n as usize + 1);
            Grid { dim, origin: span.min, cell_m: Vec3::splat(cell_m) }
        }
    }
}

/// Puts the sign to the distances and closes the room by virtual walls.
fn signed_values(
    grid: &Grid,
    solid: &[bool],
    distance_m: &[f32],
    enclosure: &Aabb,
    edge_m: &[f32],
    step: Step,
) -> Result<Vec<f32>, Stopped> {
    // A room without any triangle is all walls.
    let far = enclosure.size().length();
    let inside = |[x, y, z]: [usize; 3]| {
        let index = grid.index([x, y, z]);
        let p = grid.position([x, y, z]);
        let distance = distance_m[index].min(far);
        let edge_m = edge_m[x * grid.dim[2] + z];
        let to_wall = (p - enclosure.min).min(enclosure.max - p).min_element().min(edge_m);
        if !solid[index] {
            distance.min(to_wall.max(0.0))
        } else if edge_m <= 0.0 {
            -distance.min(-edge_m)
        } else {
            -distance
        }
    };
    let mut values = vec![0.0; grid.len()];
    fill(&mut values, step, |index| {
        let place = grid.place(index);
        let p = grid.position(place);
        if enclosure.contains(p) {
            return inside(place);
        }
        let nearest_inside: [usize; 3] = std::array::from_fn(|axis| {
            let span = grid.span(axis, enclosure.min[axis], enclosure.max[axis]);
            span.map_or(place[axis], |(first, last)| place[axis].clamp(first, last))
        });
        -enclosure.distance(p) + inside(nearest_inside).min(0.0)
    })?;
    Ok(values)
}

/// Changes whenever the same input gives another field, so that older entries of the cache are not used.
const CACHE_VERSION: u64 = 1;

/// As [`bake`], but takes the field from the disk cache if the same triangles were baked with the same
/// settings before.
///
/// # Errors
/// [`Stopped`] when `step` breaks off.
pub fn bake_cached(
    triangles: &[[Vec3; 3]],
    config: &FieldConfig,
    step: Step,
) -> Result<SignedDistanceField, Stopped> {
    bake_kept(Cache::of_user().as_ref(), triangles, config, step)
}

/// As [`bake_cached`], with a cache of the caller's.
pub(super) fn bake_kept(
    cache: Option<&Cache>,
    triangles: &[[Vec3; 3]],
    config: &FieldConfig,
    step: Step,
) -> Result<SignedDistanceField, Stopped> {
    let Some(cache) = cache else { return bake(triangles, config, step) };
    let key = cache_key(triangles, config, step)?;
    if let Some(field) = cache.get(&key).and_then(|bytes| from_bytes(&bytes)) {
        return Ok(field);
    }
    report(step, 0, 1)?;
    let field = bake(triangles, config, step)?;
    cache.put(&key, &to_bytes(&field));
    Ok(field)
}

pub(super) fn cache_key(
    triangles: &[[Vec3; 3]],
    config: &FieldConfig,
    step: Step,
) -> Result<String, Stopped> {
    let mut hasher = ContentHasher::default();
    hasher.write_number(CACHE_VERSION);
    hasher.write(format!("{config:?}").as_bytes());
    let mut pace = Pace::new(step, triangles.len());
    for part in triangles.chunks(4096) {
        pace.items(part.len())?;
        let numbers: Vec<u8> =
            part.iter().flatten().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes).collect();
        hasher.write(&numbers);
    }
    Ok(format!("field-{:032x}", hasher.finish()))
}

fn to_bytes(field: &SignedDistanceField) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(36 + 4 * field.values.len());
    for n in field.dim {
        bytes.extend_from_slice(&(n as u32).to_le_bytes());
    }
    let frame = field.origin.to_array().into_iter().chain(field.cell_m.to_array());
    for number in frame.chain(field.values.iter().copied()) {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    bytes
}

fn from_bytes(bytes: &[u8]) -> Option<SignedDistanceField> {
    let (words, []) = bytes.as_chunks::<4>() else { return None };
    let (dim, numbers) = words.split_at_checked(3)?;
    let dim = [0, 1, 2].map(|i| u32::from_le_bytes(dim[i]) as usize);
    let mut numbers = numbers.iter().map(|&w| f32::from_le_bytes(w));
    let mut vector = || Some(Vec3::new(numbers.next()?, numbers.next()?, numbers.next()?));
    let (origin, cell_m) = (vector()?, vector()?);
    let values: Vec<f32> = numbers.collect();
    let whole = dim.iter().all(|&n| n >= 2) && dim.iter().product::<usize>() == values.len();
    whole.then_some(SignedDistanceField { dim, origin, cell_m, values })
}
