//! Where people lie: along beds and sofas, the head where something rises or at either end.

use glam::Vec2;

use super::cells::Cells;
use super::place::{Place, category, flat, is_free_above, name_of};
use super::seat_places::main_directions;
use crate::body::FamilyHints;
use crate::scene::{Category, PoseFamily, Room, RoomGeometry, SupportSurface};

/// Heights over the floor that people lie down on.
const HEIGHT_M: std::ops::RangeInclusive<f32> = 0.12..=0.85;
/// Half the length and half the width of a lying adult that the surface should cover.
const HALF_SIZE_M: Vec2 = Vec2::new(0.78, 0.2);
/// Share of it that must be covered: feet may hang over an end.
const LEAST_COVERAGE: f32 = 0.9;
/// A back of a bed at least this long is its headboard or the wall behind it.
const HEADBOARD_M: f32 = 0.6;
/// From the middle of a lying body to its pelvis, towards the feet.
const MIDDLE_TO_PELVIS_M: f32 = 0.05;

/// Every place to lie on one surface.
pub fn lie_places(room: &Room, geometry: &RoomGeometry, index: usize, cells: &Cells) -> Vec<Place> {
    let surface = &geometry.supports[index];
    let category = category(room, surface);
    let soft = matches!(category, Category::Bed | Category::Sofa | Category::Unlabeled | Category::Furniture);
    let lowest_drop_m = surface.edges.iter().map(|e| e.drop_m).fold(f32::INFINITY, f32::min);
    if !soft || !HEIGHT_M.contains(&lowest_drop_m) || surface.area_m2 < 0.6 {
        return Vec::new();
    }
    let mut places = Vec::new();
    for cell in surface.cells.iter().step_by(5).map(|c| c.position) {
        for head in head_directions(surface, category) {
            let coverage = cells.coverage(flat(cell), head, HALF_SIZE_M);
            let pelvis = flat(cell) - head * MIDDLE_TO_PELVIS_M;
            let Some(under_pelvis) = cells.point_at(pelvis).filter(|_| coverage >= LEAST_COVERAGE) else {
                continue;
            };
            if !is_free_along(geometry, flat(cell), head, under_pelvis.y) {
                continue;
            }
            let weight = coverage * head_weight(surface, head);
            for family in [PoseFamily::LieUp, PoseFamily::LieDown, PoseFamily::LieSide] {
                places.push(Place {
                    family,
                    under_pelvis,
                    facing: head,
                    support: Some(index),
                    hints: FamilyHints::default(),
                    on: name_of(category, "bed"),
                    weight,
                });
            }
        }
    }
    places
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

/// Whether air lies over the whole length of the body.
fn is_free_along(geometry: &RoomGeometry, middle: Vec2, head: Vec2, height: f32) -> bool {
    [-0.6, -0.3, 0.0, 0.3, 0.6].iter().all(|along| {
        let p = middle + head * *along;
        is_free_above(geometry, super::place::at_height(p, height), 0.2, 0.5, 0.1)
    })
}
