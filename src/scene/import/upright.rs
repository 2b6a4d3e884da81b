//! Which way is up, what the unit is, where the floor lies. Tries the candidates, scores each by what a room
//! is like, and says in words what decided. Scores are natural logarithms of how likely a room is so.

use glam::{Affine3A, Mat3, Vec3};
use serde::{Deserialize, Serialize};

use super::ImportOptions;
use super::measure::{BINS, Patch, Profile, patches, robust_bounds};
use super::names;
use crate::assets::Model;
use crate::math::Aabb;
use crate::scene::Category;
use crate::scene::step::{Step, Stopped, report};

/// An axis of a file that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[expect(missing_docs, reason = "each name says what it is")]
pub enum UpAxis {
    X,
    #[default]
    Y,
    Z,
    #[serde(rename = "-X")]
    NegX,
    #[serde(rename = "-Y")]
    NegY,
    #[serde(rename = "-Z")]
    NegZ,
}

impl UpAxis {
    /// Every axis, the most usual first.
    pub const ALL: [Self; 6] = [Self::Y, Self::Z, Self::NegY, Self::NegZ, Self::X, Self::NegX];

    /// Name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::X => "X",
            Self::Y => "Y",
            Self::Z => "Z",
            Self::NegX => "-X",
            Self::NegY => "-Y",
            Self::NegZ => "-Z",
        }
    }

    /// The rotation that turns this axis up to +Y.
    pub fn upright_from_file(self) -> Mat3 {
        let (x, y, z) = match self {
            Self::Y => (Vec3::X, Vec3::Y, Vec3::Z),
            Self::NegY => (Vec3::X, Vec3::NEG_Y, Vec3::NEG_Z),
            Self::Z => (Vec3::X, Vec3::NEG_Z, Vec3::Y),
            Self::NegZ => (Vec3::X, Vec3::Z, Vec3::NEG_Y),
            Self::X => (Vec3::Y, Vec3::NEG_X, Vec3::Z),
            Self::NegX => (Vec3::NEG_Y, Vec3::X, Vec3::Z),
        };
        Mat3::from_cols(x, y, z)
    }
}

/// How a model stands, and why.
pub struct Stance {
    pub up: UpAxis,
    pub unit: &'static str,
    pub unit_scale: f32,
    /// Height of the floor above the file's origin, metres.
    pub floor_m: f32,
    /// Height of the ceiling above the floor, metres, where there is one.
    pub ceiling_m: Option<f32>,
    /// Middle of the ground plan before centring, metres, upright frame.
    pub centre_m: Vec3,
    /// From the file's frame to the world's.
    pub world_from_file: Affine3A,
    pub evidence: Vec<String>,
}

/// Metres of each unit, its name, and how unlikely it is a priori in glTF (metres by definition) and in files
/// that state no unit.
const UNITS: [(f32, &str, f32, f32); 5] = [
    (1.0, "metre", 0.0, 0.0),
    (0.01, "centimetre", -4.0, -1.0),
    (0.001, "millimetre", -4.0, -1.0),
    (0.0254, "inch", -5.0, -1.5),
    (0.3048, "foot", -5.0, -2.5),
];

/// How unlikely it is that a room is modelled in no unit at all.
const FREE_UNIT: f32 = -7.0;

/// Storey heights: median 2.65 m, a quarter of it as the spread of the logarithm covers 2.1 to 3.4 m.
const STOREY_M: f32 = 2.65;
const STOREY_SPREAD: f32 = 0.25;

/// Rooms between these heights need no further argument.
const PLAUSIBLE_STOREY_M: std::ops::RangeInclusive<f32> = 1.9..=5.0;

/// Usual heights of things in metres with the spread of their logarithm.
const USUAL_HEIGHTS: [(Category, f32, f32); 12] = [
    (Category::Chair, 0.88, 0.25),
    (Category::DiningTable, 0.76, 0.15),
    (Category::Table, 0.68, 0.35),
    (Category::OfficeDesk, 0.76, 0.2),
    (Category::CoffeeTable, 0.43, 0.25),
    (Category::Sofa, 0.82, 0.25),
    (Category::Bed, 0.75, 0.45),
    (Category::Door, 2.06, 0.15),
    (Category::Toilet, 0.75, 0.25),
    (Category::Bathtub, 0.6, 0.3),
    (Category::Counter, 0.92, 0.2),
    (Category::Stool, 0.58, 0.35),
];

/// A named thing of the file: its category and its box in the file's frame.
struct Named {
    category: Category,
    bounds: Aabb,
}

/// Finds out how `model` stands; what `options` say is taken as it is.
///
/// # Errors
/// [`Stopped`] when `step` breaks off.
pub fn stance(model: &Model, options: &ImportOptions, step: Step) -> Result<Stance, Stopped> {
    let patches = patches(model, step)?;
    let robust = robust_bounds(model, &patches, step)?;
    let named = named_things(model);
    let mut evidence = Vec::new();
    let (up, profile) = choose_up(model, options, (&patches, robust), &named, &mut evidence, step)?;
    let is_room = looks_like_a_room(&profile);
    if !is_room {
        evidence.push("it does not look like a room: there is no floor with walls around".to_string());
    }
    let heights = StoreyHeights::of(&profile);
    let (unit_scale, unit) = match options.unit_scale {
        Some(scale) => (scale, given_unit(scale, &mut evidence)),
        None => choose_unit(model, up, &profile, &heights, &named, is_room, &mut evidence),
    };
    let floor_bin = heights.floor;
    let floor = refined_floor(&patches, up, &profile, floor_bin, 0.2 / unit_scale);
    let floor_m = if is_room { floor * unit_scale } else { profile.low * unit_scale };
    let rotation = up.upright_from_file();
    let centre_m = rotation * robust.center() * unit_scale;
    let centre_m = Vec3::new(centre_m.x, 0.0, centre_m.z);
    evidence.push(format!(
        "the floor lies at {floor_m:.2} m along {} and was moved to 0; the room was moved by ({:.2}, {:.2}) m in x and z to be centred",
        up.label(),
        -centre_m.x,
        -centre_m.z
    ));
    let ceiling_m = heights.ceiling.map(|bin| profile.height_of(bin) * unit_scale - floor_m);
    let translation = Vec3::new(-centre_m.x, -floor_m, -centre_m.z);
    let world_from_file = Affine3A::from_mat3_translation(rotation * unit_scale, translation);
    Ok(Stance { up, unit, unit_scale, floor_m, ceiling_m, centre_m, world_from_file, evidence })
}

fn is_gltf(model: &Model) -> bool {
    let name = model.name.to_lowercase();
    name.ends_with(".glb") || name.ends_with(".gltf")
}

fn named_things(model: &Model) -> Vec<Named> {
    let mut things: Vec<(usize, Named)> = Vec::new();
    for part in &model.parts {
        let Some(category) = names::category(&part.name) else { continue };
        let bounds = part.mesh.bounds();
        let corners = (0..8).map(|i| {
            let pick =
                |bit: usize, axis: usize| if i >> bit & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
            part.file_from_mesh.transform_point3(Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2)))
        });
        let bounds = Aabb::of(corners);
        match things.last_mut().filter(|(node, _)| *node == part.node) {
            Some((_, thing)) => thing.bounds = thing.bounds.union(bounds),
            None => things.push((part.node, Named { category, bounds })),
        }
    }
    things.into_iter().map(|(_, thing)| thing).collect()
}

fn choose_up(
    model: &Model,
    options: &ImportOptions,
    (patches, robust): (&[Patch], Aabb),
    named: &[Named],
    evidence: &mut Vec<String>,
    step: Step,
) -> Result<(UpAxis, Profile), Stopped> {
    let profile = |up: UpAxis| Profile::of(patches, Affine3A::from_mat3(up.upright_from_file()), robust);
    if let Some(up) = options.up {
        evidence.push(format!("{} is up because you said so", up.label()));
        return Ok((up, profile(up)));
    }
    let mut best: Option<(f32, UpAxis, Profile, Vec<String>)> = None;
    let mut second = f32::NEG_INFINITY;
    for (done, up) in UpAxis::ALL.into_iter().enumerate() {
        report(step, done, UpAxis::ALL.len())?;
        let profile = profile(up);
        let (score, reasons) = up_score(model, up, &profile, named);
        if best.as_ref().is_none_or(|b| score > b.0) {
            second = best.as_ref().map_or(second, |b| b.0);
            best = Some((score, up, profile, reasons));
        } else {
            second = second.max(score);
        }
    }
    Ok(match best {
        Some((score, up, profile, reasons)) => {
            let sure = if score - second > 1.5 { "" } else { " (not sure: check it)" };
            let reasons = if reasons.is_empty() { "it fits best".to_string() } else { reasons.join(", ") };
            evidence.push(format!("{} is up{sure}: {reasons}", up.label()));
            (up, profile)
        }
        None => (UpAxis::Y, profile(UpAxis::Y)),
    })
}

/// How much speaks for `up`, and the reasons that count most.
fn up_score(model: &Model, up: UpAxis, profile: &Profile, named: &[Named]) -> (f32, Vec<String>) {
    let mut reasons = Vec::new();
    let prior = up_prior(model, up);
    if is_gltf(model) && up == UpAxis::Y {
        reasons.push("glTF says so".to_string());
    }
    let (floor, cover) = best_cover(profile, 0..BINS * 2 / 5);
    let (_, ceiling) = best_cover(profile, BINS * 3 / 5..BINS);
    if cover > 0.3 {
        reasons.push(format!("a floor covers {:.0} % of the ground plan", cover * 100.0));
    }
    let below: f32 =
        profile.up[..floor.saturating_sub(4)].iter().chain(&profile.down[..floor.saturating_sub(4)]).sum();
    let below = (below / profile.footprint()).min(1.0);
    let standing = 6.0 * (0.5 - profile.inner_height) * (profile.inner_share / 0.1).min(1.0);
    if standing > 0.4 {
        reasons.push("things stand low above it".to_string());
    }
    let others = (profile.across[0] * profile.across[1]).sqrt();
    let flat = -(profile.range() / others.max(f32::MIN_POSITIVE)).ln().clamp(-1.0, 1.0);
    let named = named_floor_score(up, profile, named);
    if named > 1.0 {
        reasons.push("what is named floor, wall or ceiling lies accordingly".to_string());
    }
    let score = prior + 3.0 * cover - 3.0 * below
        + 1.5 * (cover - ceiling)
        + standing
        + flat
        + 6.0 * profile.aligned_share
        + 1.5 * profile.inner_facing * (profile.inner_share / 0.1).min(1.0)
        + named;
    (score, reasons)
}

/// What the format promises.
fn up_prior(model: &Model, up: UpAxis) -> f32 {
    let gltf = is_gltf(model);
    match up {
        UpAxis::Y => {
            if gltf {
                3.0
            } else {
                0.5
            }
        }
        UpAxis::Z => {
            if gltf {
                0.0
            } else {
                0.5
            }
        }
        UpAxis::NegY => -1.5,
        UpAxis::NegZ => -2.0,
        UpAxis::X | UpAxis::NegX => -2.5,
    }
}

/// The slice of `bins` with the most cover.
fn best_cover(profile: &Profile, bins: std::ops::Range<usize>) -> (usize, f32) {
    bins.map(|b| (b, profile.cover(b))).fold((0, 0.0), |best, new| if new.1 > best.1 { new } else { best })
}

/// Floors lie flat and low, ceilings flat and high, walls stand.
fn named_floor_score(up: UpAxis, profile: &Profile, named: &[Named]) -> f32 {
    let rotation = up.upright_from_file();
    let mut scores = Vec::new();
    for thing in named {
        let bounds = Aabb::of([rotation * thing.bounds.min, rotation * thing.bounds.max]);
        let size = bounds.size();
        let flat = size.y < 0.25 * size.x.min(size.z);
        let height = (bounds.center().y - profile.low) / profile.range().max(f32::MIN_POSITIVE);
        match thing.category {
            Category::Floor => scores.push(if !flat {
                -3.0
            } else if height < 0.35 {
                4.0
            } else {
                -2.0
            }),
            Category::Ceiling => scores.push(if !flat {
                -3.0
            } else if height > 0.65 {
                4.0
            } else {
                -2.0
            }),
            Category::Wall => scores.push(if flat { -1.0 } else { 0.5 }),
            _ => {}
        }
    }
    if scores.is_empty() { 0.0 } else { scores.iter().sum::<f32>() / scores.len() as f32 }
}

/// A floor that covers much of the ground plan and surfaces that stand on it.
fn looks_like_a_room(profile: &Profile) -> bool {
    let (_, floor) = best_cover(profile, 0..BINS / 2);
    floor > 0.25 && profile.upright_share > 0.1
}

/// The levels that a storey may reach between, file units.
struct StoreyHeights {
    floor: usize,
    ceiling: Option<usize>,
    /// Possible storey heights, file units.
    candidates: Vec<f32>,
}

impl StoreyHeights {
    fn of(profile: &Profile) -> Self {
        let levels = profile.levels(0.3);
        let floor = floor_level(profile, &levels);
        let above: Vec<usize> = levels.into_iter().filter(|&l| l > floor + BINS * 15 / 100).collect();
        let height = |from: usize, to: usize| (to - from) as f32 / BINS as f32 * profile.range();
        let mut steps = vec![floor];
        steps.extend(&above);
        let mut candidates: Vec<f32> = steps.windows(2).map(|w| height(w[0], w[1])).collect();
        if above.is_empty() {
            candidates.push(profile.high - profile.height_of(floor));
        }
        Self { floor, ceiling: above.first().copied(), candidates }
    }
}

/// The lowest big level; of levels close above it the topmost one: a floor lies on its slab.
fn floor_level(profile: &Profile, levels: &[usize]) -> usize {
    let lowest = levels.first().copied().filter(|&l| l < BINS * 3 / 5);
    let lowest = lowest.unwrap_or_else(|| best_cover(profile, 0..BINS / 2).0);
    // 12 % of a room of 2.7 m are 0.3 m: no slab is thicker, no seat lower.
    let close = lowest..(lowest + BINS * 12 / 100).min(BINS);
    let needed = 0.6 * profile.cover(lowest);
    let on_top = close
        .filter(|&b| profile.cover_facing_up(b) >= needed)
        .max_by(|a, b| profile.cover_facing_up(*a).total_cmp(&profile.cover_facing_up(*b)).then(b.cmp(a)));
    on_top.unwrap_or(lowest)
}

/// The area's median height within `reach` of the floor's slice, of surfaces that face up where there are any.
fn refined_floor(patches: &[Patch], up: UpAxis, profile: &Profile, floor_bin: usize, reach: f32) -> f32 {
    let middle = profile.height_of(floor_bin);
    let reach = (1.6 * profile.range() / BINS as f32).min(reach);
    let up_axis = up.upright_from_file().transpose() * Vec3::Y;
    let near = |p: &&Patch| (p.centre.dot(up_axis) - middle).abs() <= reach;
    let mut level: Vec<(f32, f32)> = Vec::new();
    for sign in [1.0, -1.0] {
        if level.is_empty() {
            let facing = patches.iter().filter(near).filter(|p| p.normal.dot(up_axis) * sign > 0.95);
            level = facing.map(|p| (p.centre.dot(up_axis), p.area)).collect();
        }
    }
    level.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let half = level.iter().map(|l| f64::from(l.1)).sum::<f64>() * 0.5;
    let mut sum = 0.0;
    let median = level.iter().find(|l| {
        sum += f64::from(l.1);
        sum >= half
    });
    median.map_or(middle, |l| l.0)
}

fn given_unit(scale: f32, evidence: &mut Vec<String>) -> &'static str {
    evidence.push(format!("one unit is {scale} m because you said so"));
    UNITS.iter().find(|u| (u.0 / scale - 1.0).abs() < 1e-4).map_or("free", |u| u.1)
}

fn choose_unit(
    model: &Model,
    up: UpAxis,
    profile: &Profile,
    heights: &StoreyHeights,
    named: &[Named],
    is_room: bool,
    evidence: &mut Vec<String>,
) -> (f32, &'static str) {
    let gltf = is_gltf(model);
    let score = |scale: f32| {
        let storey = storey_score(heights, scale, is_room).0;
        storey + named_score(up, named, scale) + level_score(profile, heights.floor, scale)
    };
    let mut best = (f32::NEG_INFINITY, 1.0, "metre");
    for (scale, unit, prior_gltf, prior) in UNITS {
        let total = score(scale) + if gltf { prior_gltf } else { prior };
        if total > best.0 {
            best = (total, scale, unit);
        }
    }
    let storey = storey_score(heights, best.1, is_room).1;
    if is_room && !PLAUSIBLE_STOREY_M.contains(&storey) {
        for step in -20..=20 {
            for candidate in &heights.candidates {
                let scale = STOREY_M / candidate.max(f32::MIN_POSITIVE) * (0.02 * step as f32).exp();
                let total = score(scale) + FREE_UNIT;
                if total > best.0 && scale.is_finite() {
                    best = (total, scale, "free");
                }
            }
        }
    }
    let (_, scale, unit) = best;
    explain_unit(heights, scale, unit, is_room, gltf, evidence);
    explain_named(up, named, scale, evidence);
    (scale, unit)
}

fn explain_unit(
    heights: &StoreyHeights,
    scale: f32,
    unit: &str,
    is_room: bool,
    gltf: bool,
    evidence: &mut Vec<String>,
) {
    let storey = storey_score(heights, scale, is_room).1;
    let as_metres = storey / scale;
    let mut words = match unit {
        "free" => format!("no common unit fits: one unit was taken as {scale:.4} m"),
        _ => format!("one unit is one {unit}"),
    };
    if is_room {
        let top = if heights.ceiling.is_some() {
            "from floor to ceiling"
        } else {
            "from the floor to the top of the walls"
        };
        words += &format!(", so the room measures {storey:.2} m {top}");
        if unit != "metre" {
            words += &format!("; in metres it would be {as_metres:.2} m");
        }
    }
    if gltf && unit == "metre" {
        words += ", as glTF prescribes";
    }
    evidence.push(words);
}

/// The best storey height in metres under `scale`, and how likely it is.
fn storey_score(heights: &StoreyHeights, scale: f32, is_room: bool) -> (f32, f32) {
    // What isn't a room has no storey: its height says little.
    let worst = if is_room { -14.0 } else { -3.0 };
    let one = |height: f32| {
        let metres = height * scale;
        let off = (metres / STOREY_M).ln() / STOREY_SPREAD;
        ((-0.5 * off * off).max(worst), metres)
    };
    let scored = heights.candidates.iter().map(|h| one(*h)).filter(|s| s.0.is_finite());
    scored.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((worst, 0.0))
}

/// Median heights of named things against usual ones.
fn named_score(up: UpAxis, named: &[Named], scale: f32) -> f32 {
    let scores = USUAL_HEIGHTS.iter().filter_map(|(category, usual_m, spread)| {
        let metres = median_height(up, named, *category)? * scale;
        let off = (metres / usual_m).ln() / spread.max(0.2);
        Some((-0.5 * off * off).max(-6.0))
    });
    let scores: Vec<f32> = scores.filter(|s| s.is_finite()).collect();
    // Many kinds of things agree or disagree together: don't count them as if they were independent.
    if scores.is_empty() { 0.0 } else { scores.iter().sum::<f32>() / (scores.len() as f32).sqrt() }
}

fn explain_named(up: UpAxis, named: &[Named], scale: f32, evidence: &mut Vec<String>) {
    let heights: Vec<String> = USUAL_HEIGHTS
        .iter()
        .filter_map(|(category, usual_m, _)| {
            let metres = median_height(up, named, *category)? * scale;
            Some(format!("{} {metres:.2} m (usually {usual_m:.2})", category.label()))
        })
        .collect();
    if !heights.is_empty() {
        evidence.push(format!("heights of what is named: {}", heights.join(", ")));
    }
}

fn median_height(up: UpAxis, named: &[Named], category: Category) -> Option<f32> {
    let rotation = up.upright_from_file();
    let of = named.iter().filter(|n| n.category == category);
    let mut heights: Vec<f32> =
        of.map(|n| (rotation * n.bounds.size()).y.abs()).filter(|h| *h > 0.0).collect();
    heights.sort_unstable_by(f32::total_cmp);
    heights.get(heights.len() / 2).copied()
}

/// Seats lie 0.40 to 0.50 m and tables 0.70 to 0.80 m above the floor: the share of level surfaces there.
fn level_score(profile: &Profile, floor_bin: usize, scale: f32) -> f32 {
    let floor = profile.height_of(floor_bin);
    let (mut typical, mut all) = (0.0, 0.0);
    for bin in floor_bin..BINS {
        let height_m = (profile.height_of(bin) - floor) * scale;
        let area = profile.up[bin];
        if (0.2..1.3).contains(&height_m) {
            all += area;
            typical +=
                if (0.40..0.50).contains(&height_m) || (0.70..0.80).contains(&height_m) { area } else { 0.0 };
        }
    }
    // Less than half a percent of the ground plan is no furniture.
    if all < 0.005 * profile.footprint() { 0.0 } else { 2.0 * typical / all }
}
