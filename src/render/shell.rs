//! The room's shell: walls, floor and ceiling, and what hangs on them; how it is told whether it stands
//! between an outside camera and the inside. Draws nothing.

use glam::Vec3;

use crate::math::Aabb;
use crate::scene::{Category, Object};

/// An unnamed scan's triangle belongs to the shell when it lies this close to the room's box, in metres.
/// Walls and what hangs on them are told by the same measure.
const SHELL_DEPTH_M: f32 = 0.35;

/// What part of a room stands between an outside camera and the inside, and how it is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shell {
    bounds: Aabb,
    kind: ShellKind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum ShellKind {
    /// One wall of its own: the whole of it, by the side it stands at.
    Panel(Vec3),
    /// Walls in one piece: every triangle; at the room's box also ends, reveals and tops, which look along
    /// the wall.
    Walls,
    /// Floor and ceiling: every triangle.
    Slab,
    /// One mesh for the whole room: triangles close to its box.
    Scan,
}

impl Shell {
    /// The shell that `object` is part of in a room of these bounds; `None` for furniture.
    pub fn of(object: &Object, bounds: &Aabb) -> Option<Self> {
        use Category::{Beam, Ceiling, Floor, Misc, Objects, Unlabeled, Wall};
        let kind = match object.category {
            Wall => panel_inward(&object.world_bounds(), bounds).map_or(ShellKind::Walls, ShellKind::Panel),
            Ceiling | Floor | Beam => ShellKind::Slab,
            Unlabeled | Misc | Objects if fills(&object.world_bounds(), bounds) => ShellKind::Scan,
            _ => return None,
        };
        Some(Self { bounds: *bounds, kind })
    }

    /// Unit normal of a world triangle towards the inside; zero for what is never left out.
    pub fn inward(&self, [a, b, c]: [Vec3; 3]) -> Vec3 {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let middle = (a + b + c) / 3.0;
        let to_center = self.bounds.center() - middle;
        let inward = if normal.dot(to_center) < 0.0 { -normal } else { normal };
        match self.kind {
            ShellKind::Panel(inward) => inward,
            ShellKind::Walls => self.side_of(middle).unwrap_or(inward),
            ShellKind::Slab => inward,
            ShellKind::Scan if self.is_at_the_box(middle, inward) => inward,
            ShellKind::Scan => Vec3::ZERO,
        }
    }

    /// Direction inwards from the upright side of the room's box that a point lies at, if it is one side.
    fn side_of(&self, at: Vec3) -> Option<Vec3> {
        let sides = [(0, 1.0), (0, -1.0), (2, 1.0), (2, -1.0)].into_iter().filter(|(axis, sign)| {
            let edge = if *sign > 0.0 { self.bounds.min[*axis] } else { self.bounds.max[*axis] };
            (at[*axis] - edge).abs() < SHELL_DEPTH_M
        });
        let mut found = sides.map(|(axis, sign)| {
            let mut inward = Vec3::ZERO;
            inward[axis] = sign;
            inward
        });
        match (found.next(), found.next()) {
            (Some(only), None) => Some(only),
            _ => None,
        }
    }

    fn is_at_the_box(&self, at: Vec3, inward: Vec3) -> bool {
        (0..3).any(|axis| {
            let near_min = at[axis] - self.bounds.min[axis] < SHELL_DEPTH_M && inward[axis] > 0.5;
            let near_max = self.bounds.max[axis] - at[axis] < SHELL_DEPTH_M && inward[axis] < -0.5;
            near_min || near_max
        })
    }
}

/// Whether a box takes up most of the room's in every direction.
fn fills(object: &Aabb, room: &Aabb) -> bool {
    (object.size() / room.size().max(Vec3::splat(1e-3))).min_element() > 0.7
}

/// Direction into the room of something thin that stands at one upright side of the room's box; `None` for
/// what stands free or takes up a corner.
fn panel_inward(own: &Aabb, room: &Aabb) -> Option<Vec3> {
    let (size, middle) = (own.size(), own.center());
    let axis = if size.x < size.z { 0 } else { 2 };
    let from_side = (middle[axis] - room.min[axis]).min(room.max[axis] - middle[axis]);
    let to_center = room.center()[axis] - middle[axis];
    if own.is_empty() || size[axis] > 2.0 * SHELL_DEPTH_M || from_side > SHELL_DEPTH_M {
        return None;
    }
    let mut inward = Vec3::ZERO;
    inward[axis] = to_center.signum();
    (to_center.abs() > SHELL_DEPTH_M).then_some(inward)
}

/// Doors, windows, pictures and curtains hang on walls and vanish with them: a point of it and the direction
/// into the room.
pub fn hung_inward(object: &Object, bounds: &Aabb) -> Option<(Vec3, Vec3)> {
    use Category::{Blinds, BoardPanel, Curtain, Door, Mirror, Picture, TvMonitor, Window};
    let hangs = matches!(
        object.category,
        Door | Window | Picture | Curtain | Blinds | BoardPanel | Mirror | TvMonitor
    );
    let own = if hangs { object.world_bounds() } else { return None };
    panel_inward(&own, bounds).map(|inward| (own.center(), inward))
}
