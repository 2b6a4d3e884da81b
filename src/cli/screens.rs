//! What stands between a camera and somebody in a room. Draws nothing.

use glam::Vec3;

use crate::math::Aabb;
use crate::scene::{Camera, Category, Object, Room, TriangleBvh};

/// A thing's own depth: what is nearer than this to a point of it does not hide it.
const OWN_DEPTH_M: f32 = 0.05;
/// Walls this near to the room's box are outer ones, metres.
const OUTER_M: f32 = 0.35;
/// A camera stands at least this far from walls and furniture, metres.
const ROOM_FOR_CAMERA_M: f32 = 0.12;

/// What hides somebody from a camera: furniture, and walls but for the outer ones that are cut away for a camera outside.
pub struct Screens {
    bounds: Aabb,
    furniture: TriangleBvh,
    shell: TriangleBvh,
}

impl Screens {
    /// The screens of a room.
    pub fn of(room: &Room) -> Self {
        let triangles = |keep: fn(&Object) -> bool| {
            let kept = room.objects.iter().filter(|o| o.visible && keep(o));
            TriangleBvh::new(kept.flat_map(Object::world_triangles).collect())
        };
        Self { bounds: room.bounds(), furniture: triangles(|o| !is_shell(o)), shell: triangles(is_shell) }
    }

    /// Share of points that a camera sees; 0 where no camera could stand.
    pub fn seen(&self, camera: &Camera, points: &[Vec3]) -> f32 {
        let near = |tree: &TriangleBvh| tree.closest(camera.eye, ROOM_FOR_CAMERA_M).is_some();
        if near(&self.furniture) || near(&self.shell) {
            return 0.0;
        }
        let seen = points.iter().filter(|point| !self.hide(**point, camera.eye));
        seen.count() as f32 / points.len().max(1) as f32
    }

    fn hide(&self, point: Vec3, eye: Vec3) -> bool {
        let way = eye - point;
        let direction = way.normalize_or(Vec3::Y);
        let (from, far_m) = (point + direction * OWN_DEPTH_M, way.length() - OWN_DEPTH_M);
        let wall = self.shell.cast(from, direction, far_m).map(|hit| from + direction * hit.distance_m);
        let cut_away = |at: Vec3| !self.bounds.contains(eye) && self.is_outer(at);
        wall.is_some_and(|at| !cut_away(at)) || self.furniture.any_hit(from, direction, far_m)
    }

    /// Whether a point of a wall or a ceiling is at the room's box.
    fn is_outer(&self, at: Vec3) -> bool {
        let aside = (at - self.bounds.min).min(self.bounds.max - at);
        aside.x.min(aside.z).min(self.bounds.max.y - at.y) < OUTER_M
    }
}

/// Walls, floor and ceiling, and what hangs on them.
fn is_shell(object: &Object) -> bool {
    use Category::{Beam, Blinds, Ceiling, Curtain, Door, Floor, Mirror, Picture, Wall, Window};
    matches!(
        object.category,
        Wall | Ceiling | Floor | Beam | Door | Window | Picture | Curtain | Blinds | Mirror
    )
}
