//! Where people sit: on chairs, sofas and stools, on the edge of beds and benches, and with straight legs.

use glam::{Vec2, Vec3};

use super::cells::Cells;
use super::place::{Place, at_height, category, flat, is_free_above, name_of};
use crate::body::FamilyHints;
use crate::scene::{Category, EdgePoint, PoseFamily, Room, RoomGeometry, SupportSurface};

/// Seat heights over the floor that an adult sits down on without climbing.
const SEAT_HEIGHT_M: std::ops::RangeInclusive<f32> = 0.26..=0.62;
/// Stools and bar stools go higher.
const STOOL_HEIGHT_M: std::ops::RangeInclusive<f32> = 0.26..=0.9;
/// From the front edge back to below the pelvis joint: thigh length less what overhangs.
const THIGH_ON_SEAT_M: f32 = 0.36;
/// Who sits on a deep seat sits so much farther back at most: then the calves lie against its front.
const FARTHER_BACK_M: f32 = 0.03;
/// From the backrest to below the pelvis joint: half the depth of the buttocks.
const PELVIS_TO_BACK_M: f32 = 0.14;
/// Weight of places that one sits on only where there is nothing else.
pub const LAST_RESORT: f32 = 0.05;
/// Least room for the pelvis on a seat.
const LEAST_DEPTH_M: f32 = 0.2;
/// Smaller surfaces with a back are no seats: 35 x 35 cm.
const LEAST_SEAT_M2: f32 = 0.12;
/// Half the width that somebody sitting takes.
const HALF_WIDTH_M: f32 = 0.16;
/// Room over the seat for torso and head.
const SITTING_HEIGHT_M: f32 = 0.85;
/// Room in front of the edge for the shins.
const LEG_ROOM_M: f32 = 0.22;
/// Surfaces smaller than this are stools when nothing rises behind them.
const STOOL_AREA_M2: f32 = 0.3;
/// Surfaces wider than this, with a back, are sofas when their name does not say.
const SOFA_WIDTH_M: f32 = 1.1;
/// Heights over the floor of tables that one sits at.
const TABLE_HEIGHT_M: std::ops::RangeInclusive<f32> = 0.62..=0.85;
/// From the pelvis to the nearest edge of a table that the hands still reach.
const TABLE_REACH_M: f32 = 0.5;
/// How far behind that edge the hands lie.
const HANDS_ON_TABLE_M: f32 = 0.1;
/// Shorter borders that rise are seams and corners, not backs.
const LEAST_BACK_M: f32 = 0.25;
/// Heights of armrests over the seat.
const ARMREST_HEIGHT_M: std::ops::RangeInclusive<f32> = 0.12..=0.32;
/// Length on a bed or sofa that straight legs need in front of the pelvis.
const STRAIGHT_LEGS_M: f32 = 0.95;

/// Every place to sit on one surface.
pub fn seat_places(room: &Room, geometry: &RoomGeometry, index: usize, cells: &Cells) -> Vec<Place> {
    let surface = &geometry.supports[index];
    let category = category(room, surface);
    if inviting(category) == 0.0 || is_rim(geometry, surface) {
        return Vec::new();
    }
    let mut places: Vec<Place> = surface
        .edges
        .iter()
        .filter_map(|edge| edge_seat(geometry, index, surface, category, cells, edge))
        .collect();
    places.extend(straight_seats(geometry, index, surface, category, cells));
    places
}

fn edge_seat(
    geometry: &RoomGeometry,
    index: usize,
    surface: &SupportSurface,
    category: Category,
    cells: &Cells,
    edge: &EdgePoint,
) -> Option<Place> {
    let family = family_of(surface, category);
    let heights = if family == PoseFamily::SitStool { STOOL_HEIGHT_M } else { SEAT_HEIGHT_M };
    if !heights.contains(&edge.drop_m) || edge.leg_free_m < LEG_ROOM_M || faces_a_back(surface, edge) {
        return None;
    }
    let outward = flat(edge.outward).normalize_or_zero();
    let inward_m = cells.extent(flat(edge.position), -outward, 1.2);
    let depth_m = seat_depth(inward_m)?;
    let under = flat(edge.position) - outward * depth_m;
    let height = cells.height_at(under)?;
    let aside = outward.perp() * HALF_WIDTH_M;
    let wide = [aside, -aside].iter().filter(|a| cells.height_at(under + **a).is_some()).count();
    let narrow_ok = surface.area_m2 < STOOL_AREA_M2 && wide >= 1;
    if wide < 2 && !narrow_ok {
        return None;
    }
    let under_pelvis = at_height(under, height);
    if !is_free_above(geometry, under_pelvis, 0.3, SITTING_HEIGHT_M, 0.09) {
        return None;
    }
    let table = table_in_front(geometry, under, height - edge.drop_m, outward);
    Some(Place {
        family,
        under_pelvis,
        facing: outward,
        support: Some(index),
        hints: FamilyHints {
            seat_height_m: Some(edge.drop_m),
            seat_behind_m: Some(inward_m - depth_m),
            armrest_above_seat_m: armrest(surface, outward),
            table_height_m: table.map(|t| t.height_m),
            table_reach_m: table.map(|t| t.reach_m),
            ..FamilyHints::default()
        },
        on: name_of(category, "seat"),
        weight: inviting(category) * if wide == 2 { 1.0 } else { 0.3 },
    })
}

/// A table that somebody on a seat can lay their hands on.
#[derive(Clone, Copy)]
struct Table {
    /// Over the floor.
    height_m: f32,
    /// From the pelvis to where the hands lie.
    reach_m: f32,
}

/// The nearest table top in front of a seat, within reach of the forearms.
fn table_in_front(geometry: &RoomGeometry, under: Vec2, floor_y: f32, facing: Vec2) -> Option<Table> {
    let tops = geometry.supports.iter().filter(|s| TABLE_HEIGHT_M.contains(&(s.height_m - floor_y)));
    let near = tops.flat_map(|top| {
        let ahead = top.cells.iter().map(move |cell| flat(cell.position) - under);
        let within = ahead.filter(|to| to.dot(facing) > 0.0 && to.perp_dot(facing).abs() < HALF_WIDTH_M);
        within.map(move |to| (to.dot(facing), top.height_m - floor_y))
    });
    let (distance_m, height_m) = near.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (distance_m < TABLE_REACH_M).then_some(Table { height_m, reach_m: distance_m + HANDS_ON_TABLE_M })
}

/// Height over the seat of what rises at the sitter's side, if it is as high as an armrest.
fn armrest(surface: &SupportSurface, facing: Vec2) -> Option<f32> {
    let beside = surface.backs.iter().filter(|b| flat(b.direction).dot(facing).abs() < 0.5);
    beside.map(|b| b.height_m).find(|height| ARMREST_HEIGHT_M.contains(height))
}

/// How far behind the edge the pelvis goes on a surface this deep; `None` when it is no seat.
fn seat_depth(inward_m: f32) -> Option<f32> {
    if inward_m < LEAST_DEPTH_M {
        return None;
    }
    let before_back = inward_m - PELVIS_TO_BACK_M;
    let comfortable = THIGH_ON_SEAT_M.max(before_back.min(THIGH_ON_SEAT_M + FARTHER_BACK_M));
    Some(comfortable.min(before_back.max(inward_m * 0.5)))
}

/// Whether something rises behind this edge: nobody faces the backrest they sit against.
fn faces_a_back(surface: &SupportSurface, edge: &EdgePoint) -> bool {
    surface.backs.iter().any(|b| b.length_m > LEAST_BACK_M && b.direction.dot(edge.outward) > 0.7)
}

/// How one sits on a surface of a room.
pub fn seat_family(room: &Room, surface: &SupportSurface) -> PoseFamily {
    family_of(surface, category(room, surface))
}

fn family_of(surface: &SupportSurface, category: Category) -> PoseFamily {
    let width = surface.bounds.size().max_element();
    match category {
        Category::Sofa => PoseFamily::SitSofa,
        Category::Chair => PoseFamily::SitChair,
        Category::Stool => PoseFamily::SitStool,
        Category::Bed | Category::Stairs => PoseFamily::SitEdge,
        c if c.is_table() => PoseFamily::SitEdge,
        _ if surface.backs.is_empty() && surface.area_m2 < STOOL_AREA_M2 => PoseFamily::SitStool,
        _ if surface.backs.is_empty() => PoseFamily::SitEdge,
        _ if width > SOFA_WIDTH_M => PoseFamily::SitSofa,
        _ => PoseFamily::SitChair,
    }
}

/// Seats are made to sit on; tables and stairs will do where there is nothing else; 0 for what nobody sits on.
fn inviting(category: Category) -> f32 {
    match category {
        c if c.is_seat() => 1.0,
        Category::Unlabeled | Category::Misc | Category::Furniture => 0.5,
        Category::Stairs | Category::CoffeeTable | Category::ChestOfDrawers => LAST_RESORT,
        _ => 0.0,
    }
}

/// Whether the surface is the top of a seat's back or armrests: the same thing has a lower surface that these
/// rise from.
fn is_rim(geometry: &RoomGeometry, surface: &SupportSurface) -> bool {
    let same = |s: &&SupportSurface| s.object.is_some() && s.object == surface.object;
    let lower = |s: &&SupportSurface| s.height_m < surface.height_m - 0.05 && could_be_seat(s);
    surface.object.is_some()
        && geometry.supports.iter().filter(same).filter(lower).any(|s| {
            let (a, b) = (s.bounds.grown(0.15), surface.bounds);
            a.min.x < b.max.x && b.min.x < a.max.x && a.min.z < b.max.z && b.min.z < a.max.z
        })
}

/// Whether somebody could sit on the surface itself: something rises from it, and it is high and large enough.
fn could_be_seat(surface: &SupportSurface) -> bool {
    let high = surface.edges.iter().any(|e| SEAT_HEIGHT_M.contains(&e.drop_m) && e.leg_free_m > LEG_ROOM_M);
    high && !surface.backs.is_empty() && surface.area_m2 > LEAST_SEAT_M2
}

/// Straight legs along a bed or sofa: something to rest the back on is welcome, not needed.
fn straight_seats(
    geometry: &RoomGeometry,
    index: usize,
    surface: &SupportSurface,
    category: Category,
    cells: &Cells,
) -> Vec<Place> {
    let soft = matches!(category, Category::Bed | Category::Sofa | Category::Unlabeled | Category::Furniture);
    if !soft || surface.area_m2 < 0.8 {
        return Vec::new();
    }
    let directions = main_directions(surface);
    let place = |cell: Vec3, facing: Vec2| -> Option<Place> {
        let p = flat(cell);
        let legs = cells.coverage(
            p + facing * (STRAIGHT_LEGS_M * 0.5),
            facing,
            Vec2::new(STRAIGHT_LEGS_M * 0.5, 0.15),
        );
        let behind_m = cells.extent(p, -facing, 0.5);
        let enough = legs > 0.92 && behind_m >= PELVIS_TO_BACK_M;
        let free = enough && is_free_above(geometry, cell, 0.3, SITTING_HEIGHT_M, 0.09);
        let has_back = surface.backs.iter().any(|b| flat(b.direction).dot(facing) < -0.7) && behind_m < 0.3;
        free.then(|| Place {
            family: PoseFamily::SitStraight,
            under_pelvis: cell,
            facing,
            support: Some(index),
            hints: FamilyHints::default(),
            on: name_of(category, "bed"),
            weight: if has_back { 1.0 } else { 0.4 },
        })
    };
    // A cell in every few is enough: neighbours give the same seat.
    let sparse = surface.cells.iter().step_by(7).map(|c| c.position);
    sparse.flat_map(|cell| directions.map(|facing| place(cell, facing))).flatten().collect()
}

/// Both ways along and across a surface's longest extent.
pub fn main_directions(surface: &SupportSurface) -> [Vec2; 4] {
    let axis = principal_axis(surface.cells.iter().map(|c| flat(c.position)));
    [axis, -axis, axis.perp(), -axis.perp()]
}

/// Unit direction of the largest spread of some points.
fn principal_axis(points: impl Iterator<Item = Vec2> + Clone) -> Vec2 {
    let count = points.clone().count().max(1) as f32;
    let mean = points.clone().sum::<Vec2>() / count;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in points.map(|p| p - mean) {
        xx += p.x * p.x;
        xy += p.x * p.y;
        yy += p.y * p.y;
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    Vec2::from_angle(angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pelvis_goes_to_the_back_of_a_chair_and_near_the_edge_of_a_bed() {
        assert_eq!(seat_depth(0.1), None);
        let chair = seat_depth(0.42).expect("a chair is a seat");
        assert!((0.2..0.3).contains(&chair), "{chair}");
        let bed = seat_depth(1.2).expect("a bed is a seat");
        // Deeper, the calves of an adult would be in the front of the seat.
        assert!((0.3..0.4).contains(&bed), "{bed}");
    }

    #[test]
    fn the_principal_axis_runs_along_the_longer_side() {
        let points = [Vec2::new(0.0, 0.0), Vec2::new(2.0, 2.0), Vec2::new(0.1, -0.1), Vec2::new(2.1, 1.9)];
        let axis = principal_axis(points.into_iter());
        assert!(axis.dot(Vec2::ONE.normalize()).abs() > 0.99, "{axis}");
    }
}
