//! What the surfaces of a model say about its posture: how much area lies level, upright, low and high.

use glam::{Affine3A, Vec3};
use rayon::prelude::*;

use crate::assets::{Model, Part};
use crate::math::Aabb;
use crate::scene::step::{Step, Stopped, report};

/// Slices of the height range; for a room of 3 m 15 mm each.
pub const BINS: usize = 200;

/// Cosine of 18°: a surface that is level within that counts as level. Noisy scans need so much.
const LEVEL_COS: f32 = 0.95;

/// One triangle as seen by the statistics.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    pub centre: Vec3,
    pub normal: Vec3,
    pub area: f32,
}

/// A mesh of so many triangles may be a scan, whose single triangles point anywhere: its smooth normals count.
const SCAN_TRIANGLES: usize = 50_000;

/// Triangles that one task measures.
const CHUNK: usize = 1 << 14;

/// Every triangle of `model` with an area, in the file's frame.
pub fn patches(model: &Model, step: Step) -> Result<Vec<Patch>, Stopped> {
    let chunks_of = |part: usize| {
        let count = model.parts[part].mesh.triangles.len();
        (0..count).step_by(CHUNK).map(move |first| (part, first..(first + CHUNK).min(count)))
    };
    let tasks: Vec<_> = (0..model.parts.len()).flat_map(chunks_of).collect();
    let measured = tasks.par_iter().enumerate().map(|(done, (part, range))| {
        report(step, done, tasks.len())?;
        Ok(patches_of(&model.parts[*part], range.clone()))
    });
    Ok(measured.collect::<Result<Vec<_>, Stopped>>()?.concat())
}

fn patches_of(part: &Part, range: std::ops::Range<usize>) -> Vec<Patch> {
    let linear = part.file_from_mesh.matrix3;
    let sign = linear.determinant().signum();
    let smooth_from_mesh = linear.inverse().transpose();
    let is_scan = part.mesh.triangles.len() > SCAN_TRIANGLES && !part.mesh.normals.is_empty();
    let patches = range.filter_map(|t| {
        let [a, b, c] = part.mesh.corners(t).map(|p| part.file_from_mesh.transform_point3(p));
        let cross = (b - a).cross(c - a) * (0.5 * sign);
        let own = cross.try_normalize()?;
        let smooth = || part.mesh.triangles[t].iter().map(|v| part.mesh.normals[*v as usize]).sum::<Vec3>();
        let normal = if is_scan { (smooth_from_mesh * smooth()).normalize_or(own) } else { own };
        // Noise folds a surface up: what counts is its area seen along the smooth normal.
        Some(Patch { centre: (a + b + c) / 3.0, normal, area: cross.dot(normal).abs() })
    });
    patches.filter(|p| p.area.is_finite() && p.area > 0.0).collect()
}

/// The box that holds all but the outermost 0.2 % of the area on each side, from corner to corner where
/// triangles are large.
pub fn robust_bounds(model: &Model, patches: &[Patch], step: Step) -> Result<Aabb, Stopped> {
    let full = model.bounds();
    let total: f64 = patches.iter().map(|p| f64::from(p.area)).sum();
    let mut bounds = full;
    for axis in 0..3 {
        report(step, axis, 3)?;
        let mut along: Vec<(f32, f32)> = patches.iter().map(|p| (p.centre[axis], p.area)).collect();
        along.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let low = first_beyond(along.iter(), 0.002 * total).unwrap_or(full.min[axis]);
        let high = first_beyond(along.iter().rev(), 0.002 * total).unwrap_or(full.max[axis]);
        // Centres of large triangles lie inside: only far outliers are cut off.
        let slack = 0.15 * (high - low);
        bounds.min[axis] = if full.min[axis] < low - slack { low } else { full.min[axis] };
        bounds.max[axis] = if full.max[axis] > high + slack { high } else { full.max[axis] };
    }
    Ok(bounds)
}

/// Where the areas, added up in their order, first reach `share`.
fn first_beyond<'a>(along: impl Iterator<Item = &'a (f32, f32)>, share: f64) -> Option<f32> {
    let mut sum = 0.0;
    along
        .skip_while(|(_, area)| {
            sum += f64::from(*area);
            sum < share
        })
        .map(|(at, _)| *at)
        .next()
}

/// Sides of the smallest rectangle, turned in steps of 3°, that holds the ground plan of what lies in
/// `bounds`; from at most some ten thousand triangles, and no larger than `bounds` itself.
fn turned_rectangle(patches: &[Patch], upright_from_file: Affine3A, bounds: Aabb) -> [f32; 2] {
    let step = (patches.len() / 10_000).max(1);
    let inside = bounds.grown(1e-3 * bounds.size().max_element());
    let points: Vec<Vec3> = patches
        .iter()
        .step_by(step)
        .map(|p| upright_from_file.transform_point3(p.centre))
        .filter(|p| inside.contains(*p))
        .collect();
    let size = bounds.size().max(Vec3::splat(f32::MIN_POSITIVE));
    let sides_at = |degrees: usize| {
        let turn = glam::Mat3::from_rotation_y((degrees as f32).to_radians());
        let turned = Aabb::of(points.iter().map(|p| turn * *p)).size();
        [turned.x, turned.z]
    };
    let upright = sides_at(0);
    // Centres lie inside large triangles: only how much a turn saves is known from them.
    let area = |s: [f32; 2]| s[0] * s[1];
    let best = (0..90).step_by(3).map(sides_at).min_by(|a, b| area(*a).total_cmp(&area(*b)));
    match best {
        Some(best) if points.len() > 100 && area(best) > 0.0 && area(best) < 0.9 * area(upright) => best,
        _ => [size.x, size.z],
    }
}

/// How the area of a model is spread over the heights above the lowest point, for one choice of up.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Lowest and highest height, file units.
    pub low: f32,
    pub high: f32,
    /// Sides of the smallest rectangle around the ground plan, however it is turned, file units.
    pub across: [f32; 2],
    /// Area of surfaces that face up and down, by slice.
    pub up: Vec<f32>,
    pub down: Vec<f32>,
    /// Share of the area that is level or upright.
    pub aligned_share: f32,
    /// Share of the area that is upright.
    pub upright_share: f32,
    /// Mean height of what lies inside, not on the outer faces, from 0 (low) to 1 (high).
    pub inner_height: f32,
    /// Share of the area that lies inside.
    pub inner_share: f32,
    /// Level inner area that faces up less that which faces down, as a share of both.
    pub inner_facing: f32,
}

impl Profile {
    /// The profile of `patches` once they are turned upright by `upright_from_file`.
    pub fn of(patches: &[Patch], upright_from_file: Affine3A, robust_file: Aabb) -> Self {
        let corners = [robust_file.min, robust_file.max].map(|c| upright_from_file.transform_point3(c));
        let bounds = Aabb::of(corners);
        let size = bounds.size().max(Vec3::splat(f32::MIN_POSITIVE));
        let mut profile = Self {
            low: bounds.min.y,
            high: bounds.max.y,
            across: turned_rectangle(patches, upright_from_file, bounds),
            up: vec![0.0; BINS],
            down: vec![0.0; BINS],
            aligned_share: 0.0,
            upright_share: 0.0,
            inner_height: 0.5,
            inner_share: 0.0,
            inner_facing: 0.0,
        };
        let (mut total, mut aligned, mut upright) = (0.0f64, 0.0f64, 0.0f64);
        let (mut inner, mut inner_moment, mut inner_up, mut inner_down) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
        for patch in patches {
            let at = (upright_from_file.transform_point3(patch.centre) - bounds.min) / size;
            let facing = upright_from_file.transform_vector3(patch.normal).y;
            let area = f64::from(patch.area);
            total += area;
            if at.y < -0.01 || at.y > 1.01 {
                continue;
            }
            let bin = ((at.y * BINS as f32) as usize).min(BINS - 1);
            let is_inner = at.cmpgt(Vec3::splat(0.04)).all() && at.cmplt(Vec3::splat(0.96)).all();
            if facing.abs() > LEVEL_COS {
                let (side, inner_side) = match facing > 0.0 {
                    true => (&mut profile.up, &mut inner_up),
                    false => (&mut profile.down, &mut inner_down),
                };
                side[bin] += patch.area;
                *inner_side += if is_inner { area } else { 0.0 };
            }
            aligned += if facing.abs() > LEVEL_COS || facing.abs() < 0.1 { area } else { 0.0 };
            upright += if facing.abs() < 0.2 { area } else { 0.0 };
            if is_inner {
                inner += area;
                inner_moment += area * f64::from(at.y);
            }
        }
        let share = |part: f64, whole: f64| if whole > 0.0 { (part / whole) as f32 } else { 0.0 };
        profile.aligned_share = share(aligned, total);
        profile.upright_share = share(upright, total);
        profile.inner_share = share(inner, total);
        profile.inner_height = if inner > 0.0 { share(inner_moment, inner) } else { 0.5 };
        profile.inner_facing = share(inner_up - inner_down, inner_up + inner_down);
        profile
    }

    /// Height of the range, file units.
    pub fn range(&self) -> f32 {
        self.high - self.low
    }

    /// Area of the ground plan, square file units.
    pub fn footprint(&self) -> f32 {
        self.across[0] * self.across[1]
    }

    /// Share of the ground plan that level surfaces cover in the slices around `bin`, facing either way
    /// (double-sided slabs count once).
    pub fn cover(&self, bin: usize) -> f32 {
        let window = |side: &[f32]| -> f32 { side[bin.saturating_sub(1)..(bin + 2).min(BINS)].iter().sum() };
        (window(&self.up).max(window(&self.down)) / self.footprint()).min(1.0)
    }

    /// Share of the ground plan that surfaces facing up cover around `bin`.
    pub fn cover_facing_up(&self, bin: usize) -> f32 {
        let window: f32 = self.up[bin.saturating_sub(1)..(bin + 2).min(BINS)].iter().sum();
        (window / self.footprint()).min(1.0)
    }

    /// Height of the middle of `bin` in the file's units, above the file's origin.
    pub fn height_of(&self, bin: usize) -> f32 {
        self.low + (bin as f32 + 0.5) / BINS as f32 * self.range()
    }

    /// Slices where level surfaces cover at least `share` of the ground plan, lowest first, each the best of
    /// its neighbourhood of 3 % of the range.
    pub fn levels(&self, share: f32) -> Vec<usize> {
        let reach = BINS * 3 / 100;
        let cover: Vec<f32> = (0..BINS).map(|b| self.cover(b)).collect();
        let best_around = |b: usize| {
            let around = b.saturating_sub(reach)..(b + reach + 1).min(BINS);
            // The middle of equals, so that a level of three slices is met once.
            around.clone().all(|o| cover[o] < cover[b] || (cover[o] == cover[b] && o >= b))
        };
        (0..BINS).filter(|&b| cover[b] >= share && best_around(b)).collect()
    }
}
