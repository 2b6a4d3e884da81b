use std::sync::Arc;

use glam::{Affine3A, Vec3};
use serde::{Deserialize, Serialize};

use super::{Category, Clip, ClipId, Person, PersonId};
use crate::assets::{Material, Mesh, Texture};
use crate::math::Aabb;

/// Names an object of a room for as long as the project lives; never used again after a removal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ObjectId(pub u32);

/// A mesh with one material, in its object's frame.
#[derive(Clone, Debug)]
pub struct ObjectPart {
    /// Shared between copies of the object.
    pub mesh: Arc<Mesh>,
    /// Index into [`Room::materials`].
    pub material: usize,
    /// From the mesh's frame to the object's; may mirror or scale.
    pub object_from_mesh: Affine3A,
}

/// A thing in the room that can be named, hidden and moved.
#[derive(Clone, Debug)]
pub struct Object {
    /// Stable name of the object.
    pub id: ObjectId,
    /// Name for people.
    pub name: String,
    /// What it is.
    pub category: Category,
    /// Its meshes.
    pub parts: Vec<ObjectPart>,
    /// Where it stands.
    pub world_from_object: Affine3A,
    /// Shown and counted as geometry.
    pub visible: bool,
    /// Protected from being moved or removed by actions.
    pub locked: bool,
}

impl Object {
    /// Every triangle in the world frame, corner order kept right under mirroring.
    pub fn world_triangles(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        self.parts.iter().flat_map(move |part| {
            let world_from_mesh = self.world_from_object * part.object_from_mesh;
            let mirrored = world_from_mesh.matrix3.determinant() < 0.0;
            (0..part.mesh.triangles.len()).map(move |t| {
                let [a, b, c] = part.mesh.corners(t).map(|p| world_from_mesh.transform_point3(p));
                if mirrored { [a, c, b] } else { [a, b, c] }
            })
        })
    }

    /// The box around it in the world frame.
    pub fn world_bounds(&self) -> Aabb {
        Aabb::of(self.world_triangles().flatten())
    }

    /// Triangles over all parts.
    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|p| p.mesh.triangles.len()).sum()
    }
}

/// A room: objects with materials, upright, in metres.
#[derive(Clone, Debug, Default)]
pub struct Room {
    /// Name for people.
    pub name: String,
    /// Everything in it, walls and floor too.
    pub objects: Vec<Object>,
    /// Looks that the parts point to.
    pub materials: Vec<Material>,
    /// Pictures that the materials point to.
    pub textures: Vec<Arc<Texture>>,
}

impl Room {
    /// The object named `id`.
    pub fn object(&self, id: ObjectId) -> Option<&Object> {
        self.objects.iter().find(|o| o.id == id)
    }

    /// Every visible triangle with its object, in the world frame.
    pub fn world_triangles(&self) -> impl Iterator<Item = (ObjectId, [Vec3; 3])> + '_ {
        self.objects.iter().filter(|o| o.visible).flat_map(|o| o.world_triangles().map(move |t| (o.id, t)))
    }

    /// Triangles over all objects.
    pub fn triangle_count(&self) -> usize {
        self.objects.iter().map(Object::triangle_count).sum()
    }

    /// The box around all visible objects in the world frame.
    pub fn bounds(&self) -> Aabb {
        Aabb::of(self.world_triangles().flat_map(|(_, t)| t))
    }
}

/// A room, the people in it and their motions: what the document holds and the renderer draws.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The room.
    pub room: Arc<Room>,
    /// The people, in the order they came.
    pub people: Vec<Person>,
    /// The motions, in the order they came; shared, because frames are many.
    pub clips: Vec<Arc<Clip>>,
}

impl Scene {
    /// The person named `id`.
    pub fn person(&self, id: PersonId) -> Option<&Person> {
        self.people.iter().find(|p| p.id == id)
    }

    /// The motion named `id`.
    pub fn clip(&self, id: ClipId) -> Option<&Arc<Clip>> {
        self.clips.iter().find(|c| c.id == id)
    }
}
