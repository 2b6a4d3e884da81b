//! All that a room's geometry says, derived once and shared by everything that puts people into it.

use glam::Vec3;

use super::bvh::TriangleBvh;
use super::field::{FieldConfig, SignedDistanceField, bake_cached};
use super::floor::{WalkableFloor, Walker};
use super::room::{ObjectId, Room};
use super::step::{Pace, Step, Stopped, report};
use super::support::{SupportSurface, find_supports};
use crate::math::Aabb;

/// Settings of [`RoomGeometry::build`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GeometryConfig {
    /// How the distance field is baked.
    pub field: FieldConfig,
    /// Who must be able to stand on the floor.
    pub walker: Walker,
}

/// A room's geometry, ready for search and optimisation. Plain data; world frame, metres.
#[derive(Debug)]
pub struct RoomGeometry {
    /// Rays and closest points.
    pub bvh: TriangleBvh,
    /// Signed distances.
    pub field: SignedDistanceField,
    /// Seats, beds, table tops.
    pub supports: Vec<SupportSurface>,
    /// Where somebody can stand.
    pub floor: WalkableFloor,
    /// The box around the visible objects.
    pub bounds: Aabb,
    /// The object of each triangle of `bvh`.
    pub owner: Vec<ObjectId>,
}

impl RoomGeometry {
    /// Derives everything from the room's visible objects; the field comes from the disk cache if the same
    /// triangles were baked before.
    ///
    /// # Errors
    /// [`Stopped`] when `step` breaks off.
    pub fn build(room: &Room, config: &GeometryConfig, step: Step) -> Result<Self, Stopped> {
        let (mut owner, mut triangles) = (Vec::new(), Vec::new());
        let mut pace = Pace::new(step, 0);
        for (object, triangle) in room.world_triangles() {
            pace.item()?;
            owner.push(object);
            triangles.push(triangle);
        }
        let field = bake_cached(&triangles, &config.field, step)?;
        Self::from_field(triangles, owner, field, config, step)
    }

    /// Derives the rest from a field that is there already.
    ///
    /// # Errors
    /// [`Stopped`] when `step` breaks off.
    pub fn from_field(
        triangles: Vec<[Vec3; 3]>,
        owner: Vec<ObjectId>,
        field: SignedDistanceField,
        config: &GeometryConfig,
        step: Step,
    ) -> Result<Self, Stopped> {
        let bounds = Aabb::of(triangles.iter().flatten().copied());
        report(step, 0, 1)?;
        let bvh = TriangleBvh::build(triangles, step)?;
        let supports = find_supports(&bvh, &field, &owner, step)?;
        let floor = WalkableFloor::new(&bvh, &field, config.walker, step)?;
        Ok(Self { bvh, field, supports, floor, bounds, owner })
    }

    /// The object that triangle `index` belongs to.
    pub fn object_of(&self, triangle: usize) -> Option<ObjectId> {
        self.owner.get(triangle).copied()
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use glam::Vec2;

    use super::*;
    use crate::scene::SupportSurface;
    use crate::scene::field::{Resolution, bake, test_room_triangles};

    fn furnished_room() -> RoomGeometry {
        let triangles = test_room_triangles(10_000);
        let go_on = |_, _| ControlFlow::Continue(());
        let config = GeometryConfig::default();
        let field = bake(&triangles, &config.field, &go_on).expect("not stopped");
        RoomGeometry::from_field(triangles, Vec::new(), field, &config, &go_on).expect("not stopped")
    }

    fn at_height(room: &RoomGeometry, height_m: f32, xz: Vec2) -> &SupportSurface {
        room.supports
            .iter()
            .find(|s| {
                let near = |p: Vec3| Vec2::new(p.x, p.z).distance(xz) < 0.05;
                (s.height_m - height_m).abs() < 0.01 && s.cells.iter().any(|c| near(c.position))
            })
            .unwrap_or_else(|| panic!("no surface {height_m} m high at {xz}"))
    }

    #[test]
    fn seats_tables_and_beds_are_found_with_their_height_area_and_room_above() {
        let room = furnished_room();
        let table = at_height(&room, 0.75, Vec2::new(1.2, -0.1));
        assert!((table.area_m2 - 1.4 * 0.8).abs() < 0.08, "{}", table.area_m2);
        assert!((table.clearance_m - (2.7 - 0.75)).abs() < 0.01);
        assert!(table.backs.is_empty() && !table.edges.is_empty());
        assert!(table.edges.iter().all(|e| (e.drop_m - 0.75).abs() < 0.01));
        let bed = at_height(&room, 0.5, Vec2::new(-2.0, 1.8));
        assert!((bed.area_m2 - 1.7 * 1.2).abs() < 0.12, "{}", bed.area_m2);
        let stool = at_height(&room, 0.45, Vec2::new(-0.75, 0.85));
        assert!(stool.backs.is_empty() && (stool.area_m2 - 0.25).abs() < 0.04);
    }

    #[test]
    fn a_sofa_knows_where_its_back_is_and_where_legs_hang() {
        let room = furnished_room();
        let seat = at_height(&room, 0.45, Vec2::new(-1.2, -1.9));
        let back = &seat.backs[0];
        assert!(back.direction.dot(Vec3::NEG_Z) > 0.95, "{back:?}");
        assert!((0.3..=0.5).contains(&back.height_m) && back.length_m > 1.5, "{back:?}");
        let front = seat.edges.iter().find(|e| e.outward.dot(Vec3::Z) > 0.95).expect("a front edge");
        assert!((front.drop_m - 0.45).abs() < 0.01 && front.leg_free_m > 1.0);
        assert!(seat.edges.iter().all(|e| e.outward.dot(Vec3::NEG_Z) < 0.8), "no edge under the back");
    }

    #[test]
    fn people_can_stand_where_there_is_room_and_nowhere_else() {
        let floor = furnished_room().floor;
        assert!(floor.is_walkable(Vec2::new(0.0, 0.0)));
        for (x, z) in [(1.2, 0.0), (-1.2, -2.0), (2.6, -1.0), (-2.0, 1.8), (2.95, 2.45), (5.0, 0.0)] {
            assert!(!floor.is_walkable(Vec2::new(x, z)), "({x}, {z}) is furniture, corner or outside");
        }
        let clearance = floor.clearance_at(Vec2::new(0.0, -0.1));
        assert!((clearance - 0.5).abs() < 0.08, "half a metre to the table, not {clearance}");
        let cell = floor.nearest_walkable(Vec2::new(1.2, -0.1)).expect("somewhere");
        assert!(floor.area[cell] == Some(0));
    }

    /// Every stage of the work on `triangles`, with a step that breaks at its `at`-th call; how often it was called.
    fn built_until(triangles: &[[Vec3; 3]], at: usize) -> (bool, usize) {
        let asked = AtomicUsize::new(0);
        let step = |_, _| match asked.fetch_add(1, Ordering::Relaxed) {
            n if n >= at => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let resolution = Resolution::Cells { cell_m: 0.1, max_bytes: 1 << 24 };
        let field = FieldConfig { resolution, ..FieldConfig::default() };
        let config = GeometryConfig { field, ..GeometryConfig::default() };
        let built = bake(triangles, &config.field, &step).and_then(|field| {
            RoomGeometry::from_field(triangles.to_vec(), Vec::new(), field, &config, &step)
        });
        (built.is_ok(), asked.into_inner())
    }

    #[test]
    fn whenever_it_is_told_to_stop_it_stops() {
        let triangles = test_room_triangles(8_000);
        let (done, steps) = built_until(&triangles, usize::MAX);
        assert!(done && steps > 100, "{steps} questions are too few for {} triangles", triangles.len());
        for at in (0..steps - 2).step_by(steps / 20) {
            let (done, asked) = built_until(&triangles, at);
            assert!(!done, "told to stop at question {at} of {steps}, it went on to the end");
            // Each thread may be in the middle of a piece.
            assert!(asked <= at + 1 + rayon::current_num_threads(), "{asked} questions, stopped at {at}");
        }
    }
}
