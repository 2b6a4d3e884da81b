use glam::{Vec2, Vec3};

use crate::body::FamilyHints;
use crate::scene::{Category, ObjectId, PoseFamily, Room, RoomGeometry, SupportSurface};

/// Somewhere that affords a pose: where the pelvis goes and which way the person faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// What can be done there.
    pub family: PoseFamily,
    /// The point of the supporting surface under the pelvis, world frame.
    pub under_pelvis: Vec3,
    /// Horizontal unit vector (x, z): where a standing or sitting person faces; for lying families from the
    /// pelvis to the head.
    pub facing: Vec2,
    /// Number of the surface that is sat, lain or leaned on; `None` for floor and walls.
    pub support: Option<usize>,
    /// What the place says about the pose: seat, table and armrest heights, how to lean.
    pub hints: FamilyHints,
    /// Name of what holds the person.
    pub on: String,
    /// How inviting it is among places of its family; 1 for a usual one.
    pub weight: f32,
}

/// What a support surface is: its object's category, or `Unlabeled` when no object owns it.
pub fn category(room: &Room, surface: &SupportSurface) -> Category {
    object_category(room, surface.object)
}

fn object_category(room: &Room, object: Option<ObjectId>) -> Category {
    object.and_then(|id| room.object(id)).map_or(Category::Unlabeled, |o| o.category)
}

/// Name of a category in reports; the shape's name where the category is unknown.
pub fn name_of(category: Category, shape: &'static str) -> String {
    if matches!(category, Category::Unlabeled | Category::Misc | Category::Furniture | Category::Objects) {
        shape.to_owned()
    } else {
        category.label().to_owned()
    }
}

/// Name of a surface in reports; `shape` where what it belongs to is unknown.
pub fn support_name(room: &Room, surface: &SupportSurface, shape: &'static str) -> String {
    name_of(category(room, surface), shape)
}

/// The horizontal part of a world vector as (x, z).
pub fn flat(v: Vec3) -> Vec2 {
    Vec2::new(v.x, v.z)
}

/// A horizontal (x, z) pair at height `y`.
pub fn at_height(p: Vec2, y: f32) -> Vec3 {
    Vec3::new(p.x, y, p.y)
}

/// Whether air fills a column of radius about 10 cm over `from`, from `low_m` to `high_m` above it.
pub fn is_free_above(geometry: &RoomGeometry, from: Vec3, low_m: f32, high_m: f32, radius_m: f32) -> bool {
    let steps = ((high_m - low_m) / 0.12).ceil().max(1.0) as usize;
    (0..=steps).all(|i| {
        let height = low_m + (high_m - low_m) * i as f32 / steps as f32;
        geometry.field.sample(from + Vec3::Y * height) > radius_m
    })
}
