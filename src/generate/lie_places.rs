//! Where people lie: along beds and sofas, the head on a pillow or where something rises, or at either end; on short
//! sofas with the legs drawn up or the head on the armrest.

use glam::{Vec2, Vec3};

use super::cells::Cells;
use super::place::{Place, at_height, category, flat, is_free_above, name_of};
use super::seat_places::main_directions;
use crate::body::{FamilyHints, LyingSide};
use crate::scene::{Category, PoseFamily, Room, RoomGeometry, SupportSurface};

/// Heights over the floor that people lie down on.
const HEIGHT_M: std::ops::RangeInclusive<f32> = 0.12..=0.85;
/// Smaller surfaces are too small even for somebody who curls up.
const LEAST_M2: f32 = 0.4;
/// From the pelvis to the top of the shoulders and to the crown, towards the head.
const SHOULDERS_M: f32 = 0.48;
const CROWN_M: f32 = 0.83;
/// Half the width of what is under a head.
const HALF_HEAD_M: f32 = 0.1;
/// Half the width of a pillow that one lies in the middle of.
const HALF_PILLOW_M: f32 = 0.2;
/// A pillow is even where its height differs by less than this, metres.
const EVEN_M: f32 = 0.03;
/// Share that must be covered: feet may hang over an end.
const LEAST_COVERAGE: f32 = 0.9;
/// Share of the head's place that a pillow covers at least.
const LEAST_PILLOW: f32 = 0.75;
/// Things this much higher than where one lies, if they are soft or part of the same thing, lift a head.
const PILLOW_M: std::ops::RangeInclusive<f32> = 0.03..=0.26;
/// Knees and shanks of somebody curled up on the side, before the pelvis and towards the feet, metres; the share of them
/// that lies on something.
const KNEES_M: (f32, f32) = (0.22, 0.25);
const LEAST_KNEES: f32 = 0.75;
/// A back of a bed at least this long is its headboard or the wall behind it.
const HEADBOARD_M: f32 = 0.6;
/// How much a pillow is worth against a bare end of a bed.
const ON_PILLOW: f32 = 1.5;
/// Somebody with a back of this height at one side lies with their own back to it.
const BACKREST_M: f32 = 0.25;

/// How long somebody makes themselves.
#[derive(Clone, Copy)]
struct Length {
    /// From the pelvis towards the feet that the surface should cover.
    legs_m: f32,
    /// From the crown to the toes; `None` for stretched out.
    whole_m: Option<f32>,
    /// Half the width that the surface should cover, and the room around the body's middle.
    half_m: f32,
    free_m: f32,
    /// Against lying stretched out.
    weight: f32,
}

/// Stretched out (the ankles may lie at the end), legs drawn up, and curled up; drawn up one makes do with the width of a
/// trunk on its side.
const LENGTHS: [Length; 3] = [
    Length { legs_m: 0.73, whole_m: None, half_m: 0.2, free_m: 0.1, weight: 1.0 },
    Length { legs_m: 0.6, whole_m: Some(1.4), half_m: 0.15, free_m: 0.07, weight: 0.5 },
    Length { legs_m: 0.48, whole_m: Some(1.3), half_m: 0.15, free_m: 0.07, weight: 0.35 },
];
/// Of a bed's columns one in so many is tried, of a sofa's one in fewer: there one lies just so or not at all.
const EVERY: [usize; 2] = [5, 2];

/// A surface to lie on, and what lifts heads on it.
struct Bed<'a> {
    geometry: &'a RoomGeometry,
    surface: &'a SupportSurface,
    category: Category,
    cells: &'a Cells,
    pillows: Cells,
}

/// Where a head lies: how well, and on how high a pillow.
struct HeadRest {
    weight: f32,
    pillow_m: Option<f32>,
}

/// Every place to lie on one surface.
pub fn lie_places(room: &Room, geometry: &RoomGeometry, index: usize, cells: &Cells) -> Vec<Place> {
    let surface = &geometry.supports[index];
    let category = category(room, surface);
    let soft = matches!(category, Category::Bed | Category::Sofa | Category::Unlabeled | Category::Furniture);
    let lowest_drop_m = surface.edges.iter().map(|e| e.drop_m).fold(f32::INFINITY, f32::min);
    if !soft || !HEIGHT_M.contains(&lowest_drop_m) || surface.area_m2 < LEAST_M2 {
        return Vec::new();
    }
    let pillows = pillows(room, geometry, surface);
    let bed = Bed { geometry, surface, category, cells, pillows };
    let mut places = Vec::new();
    let every = EVERY[usize::from(category == Category::Sofa)];
    for cell in surface.cells.iter().step_by(every).map(|c| flat(c.position)) {
        for head in head_directions(surface, category) {
            places.extend(bed.lies(index, cell, head));
        }
    }
    places
}

/// What lifts heads on a surface: cushions, and the lower parts of the same thing that rise beside it.
fn pillows(room: &Room, geometry: &RoomGeometry, surface: &SupportSurface) -> Cells {
    let is_pillow = |other: &SupportSurface| {
        let kin = other.object.is_some() && other.object == surface.object;
        kin || matches!(category(room, other), Category::Cushion | Category::Bed | Category::Sofa)
    };
    let near = surface.bounds.grown(0.4);
    let rises = |y: f32| PILLOW_M.contains(&(y - surface.height_m));
    let others = geometry.supports.iter().filter(|s| is_pillow(s));
    let tops = others.flat_map(|s| &s.cells).filter(|c| {
        let p = c.position;
        rises(p.y) && (near.min.x..near.max.x).contains(&p.x) && (near.min.z..near.max.z).contains(&p.z)
    });
    Cells::of_points(tops.map(|c| c.position))
}

impl Bed<'_> {
    /// Ways to lie with the pelvis over a point and the head in a direction, no longer than there is room for.
    fn lies(&self, index: usize, pelvis: Vec2, head: Vec2) -> Vec<Place> {
        let Some(under_pelvis) = self.cells.point_at(pelvis) else { return Vec::new() };
        let Some((length, rest, covered)) = LENGTHS.iter().find_map(|length| {
            let (rest, covered) = self.fits(pelvis, head, length)?;
            Some((length, rest, covered))
        }) else {
            return Vec::new();
        };
        if !self.is_free_along(under_pelvis, head, length, rest.pillow_m.unwrap_or(0.0)) {
            return Vec::new();
        }
        let weight = covered * rest.weight * length.weight;
        let lies_on = self.lies_on(head);
        let families: &[PoseFamily] = match length.whole_m {
            None => &[PoseFamily::LieUp, PoseFamily::LieDown, PoseFamily::LieSide],
            Some(_) if self.holds_knees(pelvis, head, lies_on) => &[PoseFamily::LieUp, PoseFamily::LieSide],
            Some(_) => &[PoseFamily::LieUp],
        };
        let place = |family: &PoseFamily| Place {
            family: *family,
            under_pelvis,
            facing: head,
            support: Some(index),
            hints: FamilyHints {
                lying_length_m: length.whole_m,
                pillow_m: rest.pillow_m,
                lies_on,
                ..FamilyHints::default()
            },
            on: name_of(self.category, "bed"),
            weight,
        };
        families.iter().map(place).collect()
    }

    /// Whether somebody of a length has room: trunk and legs on the surface, the head on a pillow or on the surface too.
    fn fits(&self, pelvis: Vec2, head: Vec2, length: &Length) -> Option<(HeadRest, f32)> {
        let over = |from_m: f32, to_m: f32, half_m: f32, cells: &Cells| {
            let half = Vec2::new(0.5 * (to_m - from_m), half_m);
            cells.coverage(pelvis + head * (0.5 * (from_m + to_m)), head, half)
        };
        let side = head_weight(self.surface, head);
        let pillow = over(0.55, 0.72, HALF_HEAD_M, &self.pillows);
        if pillow >= LEAST_PILLOW {
            let trunk = over(-length.legs_m, SHOULDERS_M, length.half_m, self.cells);
            let lifted = self.pillows.height_at(pelvis + head * 0.64);
            let pillow_m = lifted.map(|y| y - self.surface.height_m);
            // The middle of a pillow rather than its edge, or the gap between two.
            let middle = 0.4 + 0.6 * self.evenness(pelvis + head * 0.64, head.perp());
            let rest = HeadRest { weight: ON_PILLOW * side * middle, pillow_m };
            return (trunk >= LEAST_COVERAGE).then_some((rest, trunk));
        }
        let whole = over(-length.legs_m, CROWN_M, length.half_m, self.cells);
        (whole >= LEAST_COVERAGE).then_some((HeadRest { weight: side, pillow_m: None }, whole))
    }

    /// Share of a pillow to both sides of a point that is as high as it is there.
    fn evenness(&self, at: Vec2, aside: Vec2) -> f32 {
        let Some(middle_m) = self.pillows.height_at(at) else { return 0.0 };
        let steps = 4;
        let even = (-steps..=steps).filter(|step| {
            let p = at + aside * (HALF_PILLOW_M * *step as f32 / steps as f32);
            self.pillows.height_at(p).is_some_and(|y| (y - middle_m).abs() < EVEN_M)
        });
        even.count() as f32 / (2 * steps + 1) as f32
    }

    /// Whether the drawn-up legs of somebody on the side lie on the surface, not in the air before it.
    fn holds_knees(&self, pelvis: Vec2, head: Vec2, lies_on: Option<LyingSide>) -> bool {
        let front = match lies_on {
            Some(LyingSide::Left) => head.perp(),
            Some(LyingSide::Right) => -head.perp(),
            None => return true,
        };
        let knees = pelvis + front * KNEES_M.0 - head * KNEES_M.1;
        self.cells.coverage(knees, head, Vec2::new(0.2, 0.07)) >= LEAST_KNEES
    }

    /// On which side one lies: with the back to a backrest, where there is one at one side alone.
    fn lies_on(&self, head: Vec2) -> Option<LyingSide> {
        // Seen from above with the head ahead, the left is at the perpendicular's other side: x, z is left-handed.
        let left = -head.perp();
        let rises = |aside: Vec2| {
            let tall = self.surface.backs.iter().filter(|b| b.height_m >= BACKREST_M && b.length_m > 0.5);
            tall.map(|b| flat(b.direction).dot(aside)).any(|along| along > 0.7)
        };
        // Who lies on the right side has the front to the left.
        match (rises(left), rises(-left)) {
            (true, false) => Some(LyingSide::Left),
            (false, true) => Some(LyingSide::Right),
            _ => None,
        }
    }

    /// Whether air lies over the whole length of the body.
    fn is_free_along(&self, under_pelvis: Vec3, head: Vec2, length: &Length, pillow_m: f32) -> bool {
        let free = |along_m: f32, from_m: f32| {
            let p = at_height(flat(under_pelvis) + head * along_m, under_pelvis.y + from_m);
            is_free_above(self.geometry, p, 0.2, 0.5, length.free_m)
        };
        let legs = [0.85 * length.legs_m, 0.45 * length.legs_m];
        legs.iter().all(|along| free(-along, 0.0))
            && [0.05, 0.35].iter().all(|along| free(*along, 0.0))
            && free(0.65, pillow_m)
    }
}

/// Both ways along a bed as its headboard tells, or along the longer side of anything else.
fn head_directions(surface: &SupportSurface, category: Category) -> [Vec2; 2] {
    let headboard = surface.backs.iter().find(|b| category == Category::Bed && b.length_m > HEADBOARD_M);
    let head = headboard.map_or(main_directions(surface)[0], |b| flat(b.direction).normalize_or(Vec2::X));
    [head, -head]
}

/// The head goes where the headboard or armrest is.
fn head_weight(surface: &SupportSurface, head: Vec2) -> f32 {
    let toward = |sign: f32| surface.backs.iter().any(|b| flat(b.direction).dot(head) * sign > 0.7);
    match (toward(1.0), toward(-1.0)) {
        (true, false) => 1.0,
        (false, true) => 0.15,
        _ => 0.5,
    }
}
