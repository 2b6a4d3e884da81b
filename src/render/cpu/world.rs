//! All triangles of a scene in the world frame with one tree over them, and whose each is.

use std::sync::Arc;

use glam::Vec3;

use crate::assets::{AlphaMode, Material, Mesh};
use crate::math::Aabb;
use crate::render::draw::{PersonDraw, SceneDraw};
use crate::render::dress::{BodySurface, Outfit};
use crate::render::normals::corner_normals;
use crate::render::shell::{Shell, hung_inward};
use crate::scene::{Hit, Object, ObjectId, ObjectPart, Room, TriangleBvh};

/// Past a triangle that lets the ray through, the ray starts again this much farther on.
const STEP_M: f32 = 1e-4;

/// More layers than any room has in one line of sight.
const MAX_LAYERS: usize = 64;

/// A mesh of the room, placed.
pub struct Placed {
    /// Whose part it is.
    pub object: ObjectId,
    /// In its own frame.
    pub mesh: Arc<Mesh>,
    /// Its look.
    pub material: Material,
    /// World normals of the triangles' corners.
    pub normals: Vec<Vec3>,
    shell: Option<Shell>,
    hung: Option<(Vec3, Vec3)>,
}

/// Somebody in the room.
pub struct Dressed<'a> {
    /// Who.
    pub person: &'a PersonDraw,
    /// In what.
    pub outfit: Outfit,
    /// How the vertices join.
    pub body: &'a BodySurface,
    /// World normals of the vertices.
    pub normals: Vec<Vec3>,
}

/// Whose a triangle is, and its number there.
pub enum Owner<'w, 'a> {
    /// A part of the room.
    Room(&'w Placed, usize),
    /// A person.
    Person(&'w Dressed<'a>, usize),
}

/// The scene as rays see it.
pub struct World<'a> {
    tree: TriangleBvh,
    placed: Vec<Placed>,
    dressed: Vec<Dressed<'a>>,
    /// Number of the first triangle of each part, then of each person.
    starts: Vec<usize>,
    /// The box around the room.
    pub bounds: Aabb,
}

impl World<'static> {
    /// The visible objects of a room, without anybody in it.
    pub fn of_room(room: &Room) -> Self {
        Self::build(room, std::iter::empty(), None)
    }
}

impl<'a> World<'a> {
    /// Collects everything that is visible and builds the tree.
    pub fn new(draw: &'a SceneDraw) -> Self {
        Self::build(&draw.room, draw.people.iter().filter(|p| p.alpha > 0.0), draw.body.as_deref())
    }

    fn build(
        room: &Room,
        people: impl Iterator<Item = &'a PersonDraw>,
        body: Option<&'a BodySurface>,
    ) -> Self {
        let bounds = room.bounds();
        let (mut triangles, mut starts, mut placed) = (Vec::new(), Vec::new(), Vec::new());
        for object in room.objects.iter().filter(|o| o.visible) {
            for part in &object.parts {
                starts.push(triangles.len());
                placed.push(Placed::new(room, object, part, &bounds, &mut triangles));
            }
        }
        let mut dressed = Vec::new();
        for (person, body) in people.filter_map(|p| body.map(|b| (p, b))) {
            starts.push(triangles.len());
            let corner = |v: u32| person.vertices[v as usize];
            triangles.extend(body.triangles().iter().map(|t| t.map(corner)));
            let outfit = Outfit::from_palette(person.palette);
            dressed.push(Dressed { person, outfit, body, normals: body.normals(&person.vertices) });
        }
        Self { tree: TriangleBvh::new(triangles), placed, dressed, starts, bounds }
    }

    /// Whose a triangle is.
    pub fn owner(&self, triangle: usize) -> Owner<'_, 'a> {
        let index = self.owner_index(triangle);
        let own = triangle - self.starts[index];
        match index.checked_sub(self.placed.len()) {
            None => Owner::Room(&self.placed[index], own),
            Some(person) => Owner::Person(&self.dressed[person], own),
        }
    }

    /// Number of the part or person that a triangle belongs to.
    pub fn owner_index(&self, triangle: usize) -> usize {
        self.starts.partition_point(|start| *start <= triangle) - 1
    }

    /// First hit whose triangle `stops` the ray.
    pub fn trace(
        &self,
        origin: Vec3,
        unit_direction: Vec3,
        max_m: f32,
        stops: impl Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let mut start_m = 0.0;
        for _ in 0..MAX_LAYERS {
            let from = origin + unit_direction * start_m;
            let near = self.tree.cast(from, unit_direction, max_m - start_m)?;
            let hit = Hit { distance_m: start_m + near.distance_m, ..near };
            if stops(&hit) {
                return Some(hit);
            }
            start_m = hit.distance_m + STEP_M;
        }
        None
    }

    /// Corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.tree.triangles()[triangle]
    }

    /// Geometric unit normal of a triangle.
    pub fn flat_normal(&self, triangle: usize) -> Vec3 {
        self.tree.normal(triangle)
    }

    /// Whether a triangle is left out when the room is cut open for a point.
    pub fn is_cut_for(&self, triangle: usize, eye: Vec3) -> bool {
        let Owner::Room(placed, _) = self.owner(triangle) else { return false };
        let corners = self.corners(triangle);
        placed.hung.is_some_and(|(at, inward)| inward.dot(eye - at) < 0.0)
            || placed.shell.is_some_and(|shell| shell.inward(corners).dot(eye - corners[0]) < 0.0)
    }

    /// Whether a triangle throws a shadow: glass and ghosts do not, nor does the side of the shell that
    /// lets the key light in.
    pub fn casts_shadow(&self, triangle: usize, to_key: Vec3) -> bool {
        match self.owner(triangle) {
            Owner::Person(dressed, _) => dressed.person.alpha >= 1.0,
            Owner::Room(placed, _) => {
                let lets_in = |s: Shell| s.inward(self.corners(triangle)).dot(to_key) < 0.0;
                placed.material.alpha != AlphaMode::Blend && !placed.shell.is_some_and(lets_in)
            }
        }
    }
}

impl Placed {
    fn new(
        room: &Room,
        object: &Object,
        part: &ObjectPart,
        bounds: &Aabb,
        triangles: &mut Vec<[Vec3; 3]>,
    ) -> Self {
        let world_from_mesh = object.world_from_object * part.object_from_mesh;
        let corners = (0..part.mesh.triangles.len()).map(|t| part.mesh.corners(t));
        triangles.extend(corners.map(|t| t.map(|p| world_from_mesh.transform_point3(p))));
        let cofactor = world_from_mesh.matrix3.inverse().transpose();
        let normals = corner_normals(&part.mesh).into_iter();
        Self {
            mesh: Arc::clone(&part.mesh),
            object: object.id,
            material: room.materials.get(part.material).cloned().unwrap_or_default(),
            normals: normals.map(|n| (cofactor * n).normalize_or(n)).collect(),
            shell: Shell::of(object, bounds),
            hung: hung_inward(object, bounds),
        }
    }
}
