//! What has happened: facts that hold both sides, so that each can be taken back and done again.

use std::sync::Arc;

use glam::Affine3A;

use crate::scene::Category;
use crate::scene::Clip;
use crate::scene::Object;
use crate::scene::ObjectId;
use crate::scene::Person;
use crate::scene::Room;
use crate::scene::Scene;
use crate::scene::SubGoal;

/// Names a state of the room's solid geometry. Undo brings the earlier name back, so whatever was computed
/// for that state (ray tree, distance field) is right again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct RoomVersion(pub u64);

/// The numbers that the next person, object and motion get; none is ever given twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NextIds {
    /// The next person's.
    pub person: u32,
    /// The next object's.
    pub object: u32,
    /// The next motion's.
    pub clip: u32,
}

impl NextIds {
    /// Those that follow the largest in `scene`.
    pub fn after(scene: &Scene) -> Self {
        let next = |ids: &mut dyn Iterator<Item = u32>| ids.max().map_or(0, |id| id + 1);
        Self {
            person: next(&mut scene.people.iter().map(|p| p.id.0)),
            object: next(&mut scene.room.objects.iter().map(|o| o.id.0)),
            clip: next(&mut scene.clips.iter().map(|c| c.id.0)),
        }
    }

    /// The larger of both, number by number.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            person: self.person.max(other.person),
            object: self.object.max(other.object),
            clip: self.clip.max(other.clip),
        }
    }
}

/// A thing and its place in the list that held it.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbered<T> {
    /// Index in the list after the insertion.
    pub index: usize,
    /// The thing.
    pub value: T,
}

/// Everything about an object that can be edited.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectState {
    /// Which object.
    pub id: ObjectId,
    /// Name for people.
    pub name: String,
    /// What it is.
    pub category: Category,
    /// Where it stands.
    pub world_from_object: Affine3A,
    /// Shown and counted as geometry.
    pub visible: bool,
    /// Protected from being moved or removed.
    pub locked: bool,
}

impl ObjectState {
    /// The editable part of `object`.
    pub fn of(object: &Object) -> Self {
        Self {
            id: object.id,
            name: object.name.clone(),
            category: object.category,
            world_from_object: object.world_from_object,
            visible: object.visible,
            locked: object.locked,
        }
    }

    /// Whether the solid geometry differs between both states.
    pub fn differs_in_geometry(&self, other: &Self) -> bool {
        self.visible != other.visible || self.world_from_object != other.world_from_object
    }

    /// Gives `object` this state.
    pub fn write_to(&self, object: &mut Object) {
        object.name.clone_from(&self.name);
        object.category = self.category;
        object.world_from_object = self.world_from_object;
        object.visible = self.visible;
        object.locked = self.locked;
    }
}

/// A room with the people and motions in it, as one thing that can be exchanged for another.
#[derive(Clone, Debug)]
pub struct RoomState {
    /// The room; shared, never copied.
    pub room: Arc<Room>,
    /// Who was in it.
    pub people: Vec<Person>,
    /// The motions in it.
    pub clips: Vec<Arc<Clip>>,
}

/// A fact. Applying it and applying its inverse are exact opposites.
#[derive(Clone, Debug)]
pub enum Change {
    /// People came, in ascending order of index.
    PeopleAdded(Vec<Numbered<Person>>),
    /// People left, in ascending order of index.
    PeopleRemoved(Vec<Numbered<Person>>),
    /// People with the same ids became others.
    PeopleReplaced {
        /// As they were.
        before: Vec<Person>,
        /// As they are.
        after: Vec<Person>,
    },
    /// Objects were edited.
    ObjectsEdited {
        /// As they were.
        before: Vec<ObjectState>,
        /// As they are.
        after: Vec<ObjectState>,
    },
    /// Objects came, in ascending order of index.
    ObjectsAdded(Vec<Numbered<Object>>),
    /// Objects left, in ascending order of index.
    ObjectsRemoved(Vec<Numbered<Object>>),
    /// Motions came, in ascending order of index.
    ClipsAdded(Vec<Numbered<Arc<Clip>>>),
    /// Motions left, in ascending order of index.
    ClipsRemoved(Vec<Numbered<Arc<Clip>>>),
    /// Motions with the same ids became others.
    ClipsReplaced {
        /// As they were.
        before: Vec<Arc<Clip>>,
        /// As they are.
        after: Vec<Arc<Clip>>,
    },
    /// Another room was opened.
    RoomReplaced {
        /// What was there.
        before: RoomState,
        /// What is there.
        after: RoomState,
    },
}

impl Change {
    /// The fact that takes this one back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        match self {
            Self::PeopleAdded(people) => Self::PeopleRemoved(people.clone()),
            Self::PeopleRemoved(people) => Self::PeopleAdded(people.clone()),
            Self::PeopleReplaced { before, after } => {
                Self::PeopleReplaced { before: after.clone(), after: before.clone() }
            }
            Self::ObjectsEdited { before, after } => {
                Self::ObjectsEdited { before: after.clone(), after: before.clone() }
            }
            Self::ObjectsAdded(objects) => Self::ObjectsRemoved(objects.clone()),
            Self::ObjectsRemoved(objects) => Self::ObjectsAdded(objects.clone()),
            Self::ClipsAdded(clips) => Self::ClipsRemoved(clips.clone()),
            Self::ClipsRemoved(clips) => Self::ClipsAdded(clips.clone()),
            Self::ClipsReplaced { before, after } => {
                Self::ClipsReplaced { before: after.clone(), after: before.clone() }
            }
            Self::RoomReplaced { before, after } => {
                Self::RoomReplaced { before: after.clone(), after: before.clone() }
            }
        }
    }

    /// Lets it happen to `scene`. The scene must be the one that it was decided for.
    pub(super) fn evolve(&self, scene: &mut Scene) {
        match self {
            Self::PeopleAdded(people) => insert(&mut scene.people, people),
            Self::PeopleRemoved(people) => {
                scene.people.retain(|p| people.iter().all(|gone| gone.value.id != p.id));
            }
            Self::PeopleReplaced { after, .. } => replace_people(&mut scene.people, after),
            Self::ObjectsEdited { after, .. } => edit_objects(Arc::make_mut(&mut scene.room), after),
            Self::ObjectsAdded(objects) => insert(&mut Arc::make_mut(&mut scene.room).objects, objects),
            Self::ObjectsRemoved(objects) => {
                let room = Arc::make_mut(&mut scene.room);
                room.objects.retain(|o| objects.iter().all(|gone| gone.value.id != o.id));
            }
            Self::ClipsAdded(clips) => insert(&mut scene.clips, clips),
            Self::ClipsRemoved(clips) => {
                scene.clips.retain(|c| clips.iter().all(|gone| gone.value.id != c.id));
            }
            Self::ClipsReplaced { after, .. } => replace_clips(&mut scene.clips, after),
            Self::RoomReplaced { after, .. } => {
                scene.room = after.room.clone();
                scene.people.clone_from(&after.people);
                scene.clips.clone_from(&after.clips);
            }
        }
    }

    /// Whether the room's solid geometry differs before and after.
    pub fn touches_geometry(&self) -> bool {
        match self {
            Self::PeopleAdded(_)
            | Self::PeopleRemoved(_)
            | Self::PeopleReplaced { .. }
            | Self::ClipsAdded(_)
            | Self::ClipsRemoved(_)
            | Self::ClipsReplaced { .. } => false,
            Self::ObjectsEdited { before, after } => {
                before.iter().zip(after).any(|(before, after)| before.differs_in_geometry(after))
            }
            Self::ObjectsAdded(_) | Self::ObjectsRemoved(_) | Self::RoomReplaced { .. } => true,
        }
    }

    /// Bytes that only the history keeps alive because of this fact, about.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::PeopleAdded(people) | Self::PeopleRemoved(people) => people.len() * size_of::<Person>(),
            Self::PeopleReplaced { before, after } => (before.len() + after.len()) * size_of::<Person>(),
            Self::ObjectsEdited { before, after } => (before.len() + after.len()) * size_of::<ObjectState>(),
            Self::ObjectsAdded(objects) | Self::ObjectsRemoved(objects) => {
                objects.iter().map(|o| object_bytes(&o.value)).sum()
            }
            Self::ClipsAdded(clips) | Self::ClipsRemoved(clips) => {
                clips.iter().map(|clip| clip_bytes(&clip.value)).sum()
            }
            Self::ClipsReplaced { before, after } => before.iter().chain(after).map(|c| clip_bytes(c)).sum(),
            Self::RoomReplaced { before, after } => room_bytes(&before.room) + room_bytes(&after.room),
        }
    }
}

fn insert<T: Clone>(list: &mut Vec<T>, things: &[Numbered<T>]) {
    for thing in things {
        list.insert(thing.index.min(list.len()), thing.value.clone());
    }
}

fn replace_people(people: &mut [Person], after: &[Person]) {
    for person in people {
        if let Some(new) = after.iter().find(|new| new.id == person.id) {
            person.clone_from(new);
        }
    }
}

fn replace_clips(clips: &mut [Arc<Clip>], after: &[Arc<Clip>]) {
    for clip in clips {
        if let Some(new) = after.iter().find(|new| new.id == clip.id) {
            clip.clone_from(new);
        }
    }
}

fn clip_bytes(clip: &Clip) -> usize {
    size_of::<Clip>()
        + size_of_val(&clip.frames[..])
        + size_of_val(&clip.planted[..])
        + clip.goals.len() * size_of::<SubGoal>()
        + size_of_val(&clip.legs[..])
}

fn edit_objects(room: &mut Room, after: &[ObjectState]) {
    for object in &mut room.objects {
        if let Some(state) = after.iter().find(|state| state.id == object.id) {
            state.write_to(object);
        }
    }
}

fn object_bytes(object: &Object) -> usize {
    let mesh = |part: &crate::scene::ObjectPart| {
        let mesh = &part.mesh;
        size_of_val(&mesh.positions[..])
            + size_of_val(&mesh.normals[..])
            + size_of_val(&mesh.uvs[..])
            + size_of_val(&mesh.colors[..])
            + size_of_val(&mesh.triangles[..])
    };
    size_of::<Object>() + object.parts.iter().map(mesh).sum::<usize>()
}

fn room_bytes(room: &Room) -> usize {
    let pictures: usize = room.textures.iter().map(|t| t.rgba.len()).sum();
    pictures + room.objects.iter().map(object_bytes).sum::<usize>()
}
