//! Decides what a command leads to. Pure: looks at the scene, changes nothing.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::change::{Change, NextIds, Numbered, ObjectState, RoomState, RoomVersion};
use super::command::{Command, Refused};
use super::decide_clips as clips;
use crate::scene::BodyParams;
use crate::scene::Object;
use crate::scene::ObjectId;
use crate::scene::Person;
use crate::scene::PersonId;
use crate::scene::Room;
use crate::scene::Scene;

/// The scene and the numbers that ids are taken from.
pub(super) struct State<'a> {
    pub scene: &'a Scene,
    pub version: RoomVersion,
    pub next: NextIds,
}

pub(super) type Decision = Result<Option<Change>, Refused>;

/// What follows from `command`: a fact, nothing (`None`: all is already so), or a refusal.
pub(super) fn decide(state: &State, command: Command) -> Decision {
    match command {
        Command::OpenRoom { room } => Ok(Some(open_room(state, room))),
        Command::ChangeRoom { room, leaving, arriving, made_for, .. } => {
            change_room(state, room, &leaving, arriving, made_for)
        }
        Command::AddPeople { people, made_for } => add_people(state, people, made_for),
        Command::ReplacePeople { people, made_for } => replace_people(state, people, made_for),
        Command::RemovePeople(ids) => remove_people(state, &ids),
        Command::SetBody(id, body) => set_body(state, id, &body),
        Command::RenamePerson(id, name) => {
            let name = checked_name(&name)?;
            edit_people(state, &[id], |person| person.name.clone_from(&name))
        }
        Command::SetPeopleVisible(ids, shown) => edit_people(state, &ids, |p| p.visible = shown),
        Command::SetPeopleLocked(ids, locked) => edit_people(state, &ids, |p| p.locked = locked),
        Command::RenameObject(id, name) => {
            let name = checked_name(&name)?;
            edit_objects(state, &[id], |object| object.name.clone_from(&name))
        }
        Command::SetCategory(ids, category) => edit_objects(state, &ids, |o| o.category = category),
        Command::SetObjectsVisible(ids, shown) => edit_objects(state, &ids, |o| o.visible = shown),
        Command::SetObjectsLocked(ids, locked) => edit_objects(state, &ids, |o| o.locked = locked),
        Command::MoveObject(id, world_from_object) => move_object(state, id, world_from_object),
        Command::RemoveObjects(ids) => remove_objects(state, &ids),
        Command::DuplicateObjects(ids, offset_m) => duplicate_objects(state, &ids, offset_m),
        Command::AddClips { clips, made_for } => clips::add(state, clips, made_for),
        Command::ReplaceClip { clip, made_for } => clips::replace(state, clip, made_for),
        Command::RemoveClips(ids) => clips::remove(state, &ids),
        Command::SetGoals(id, goals) => clips::set_goals(state, id, goals),
        Command::RenameClip(id, name) => {
            let name = checked_name(&name)?;
            clips::edit(state, &[id], |clip| clip.name.clone_from(&name))
        }
        Command::SetClipsVisible(ids, shown) => clips::edit(state, &ids, |clip| clip.visible = shown),
        Command::SetClipsLocked(ids, locked) => clips::edit(state, &ids, |clip| clip.locked = locked),
    }
}

/// The new room's objects get numbers that no object had before, so that nothing meant for the old room
/// can ever hit the new one.
fn open_room(state: &State, mut room: Arc<Room>) -> Change {
    let Scene { room: old, people, clips } = state.scene.clone();
    let before = RoomState { room: old, people, clips };
    if room.objects.iter().any(|o| o.id.0 < state.next.object) {
        for (i, object) in Arc::make_mut(&mut room).objects.iter_mut().enumerate() {
            object.id = ObjectId(state.next.object + i as u32);
        }
    }
    let after = RoomState { room, people: Vec::new(), clips: Vec::new() };
    Change::RoomReplaced { before, after }
}

fn change_room(
    state: &State,
    room: Arc<Room>,
    leaving: &[PersonId],
    arriving: Vec<Person>,
    made_for: Option<RoomVersion>,
) -> Decision {
    same_room(state, made_for)?;
    let mut seen = BTreeSet::new();
    if let Some(twice) = room.objects.iter().find(|object| !seen.insert(object.id)) {
        return Err(Refused::ObjectTwice(twice.id));
    }
    if let Some(bad) = room.objects.iter().find(|object| !object.world_from_object.is_finite()) {
        return Err(Refused::BadTransform(bad.name.clone()));
    }
    arriving.iter().try_for_each(finite)?;
    let Scene { room: old, people, clips } = state.scene.clone();
    let mut after: Vec<Person> = people.iter().filter(|p| !leaving.contains(&p.id)).cloned().collect();
    let numbers = (state.next.person..).map(PersonId);
    after.extend(arriving.into_iter().zip(numbers).map(|(person, id)| Person { id, ..person }));
    let before = RoomState { room: old, people, clips: clips.clone() };
    Ok(Some(Change::RoomReplaced { before, after: RoomState { room, people: after, clips } }))
}

fn add_people(state: &State, people: Vec<Person>, made_for: Option<RoomVersion>) -> Decision {
    same_room(state, made_for)?;
    let first = state.scene.people.len();
    let mut added = Vec::with_capacity(people.len());
    for (i, mut person) in people.into_iter().enumerate() {
        finite(&person)?;
        person.id = PersonId(state.next.person + i as u32);
        added.push(Numbered { index: first + i, value: person });
    }
    Ok((!added.is_empty()).then_some(Change::PeopleAdded(added)))
}

fn replace_people(state: &State, people: Vec<Person>, made_for: Option<RoomVersion>) -> Decision {
    same_room(state, made_for)?;
    let ids: Vec<PersonId> = people.iter().map(|p| p.id).collect();
    let before = people_by_id(state.scene, &ids)?;
    unlocked_people(&before)?;
    people.iter().try_for_each(finite)?;
    Ok(replaced(before, people))
}

fn remove_people(state: &State, ids: &[PersonId]) -> Decision {
    unlocked_people(&people_by_id(state.scene, ids)?)?;
    let leaves = |p: &Person| ids.contains(&p.id);
    let gone = numbered(&state.scene.people, leaves);
    Ok((!gone.is_empty()).then_some(Change::PeopleRemoved(gone)))
}

fn set_body(state: &State, id: PersonId, body: &BodyParams) -> Decision {
    let before = people_by_id(state.scene, &[id])?;
    unlocked_people(&before)?;
    let after: Vec<Person> =
        before.iter().map(|person| Person { body: body.clone(), ..person.clone() }).collect();
    after.iter().try_for_each(finite)?;
    Ok(replaced(before, after))
}

fn edit_people(state: &State, ids: &[PersonId], edit: impl Fn(&mut Person)) -> Decision {
    let before = people_by_id(state.scene, ids)?;
    let mut after = before.clone();
    after.iter_mut().for_each(edit);
    Ok(replaced(before, after))
}

/// The replacement of those that really differ.
fn replaced(before: Vec<Person>, after: Vec<Person>) -> Option<Change> {
    let (before, after): (Vec<_>, Vec<_>) =
        before.into_iter().zip(after).filter(|(before, after)| before != after).unzip();
    (!before.is_empty()).then_some(Change::PeopleReplaced { before, after })
}

fn edit_objects(state: &State, ids: &[ObjectId], edit: impl Fn(&mut ObjectState)) -> Decision {
    let objects = objects_by_id(state.scene, ids)?;
    let mut befores = Vec::new();
    let mut afters = Vec::new();
    for object in objects {
        let before = ObjectState::of(object);
        let mut after = before.clone();
        edit(&mut after);
        if before != after {
            befores.push(before);
            afters.push(after);
        }
    }
    Ok((!befores.is_empty()).then_some(Change::ObjectsEdited { before: befores, after: afters }))
}

fn move_object(state: &State, id: ObjectId, world_from_object: Affine3A) -> Decision {
    let objects = objects_by_id(state.scene, &[id])?;
    unlocked_objects(&objects)?;
    let volume = world_from_object.matrix3.determinant();
    if !world_from_object.is_finite() || volume.abs() < 1e-12 {
        return Err(Refused::BadTransform(objects[0].name.clone()));
    }
    edit_objects(state, &[id], |object| object.world_from_object = world_from_object)
}

fn remove_objects(state: &State, ids: &[ObjectId]) -> Decision {
    unlocked_objects(&objects_by_id(state.scene, ids)?)?;
    let gone = numbered(&state.scene.room.objects, |o| ids.contains(&o.id));
    Ok((!gone.is_empty()).then_some(Change::ObjectsRemoved(gone)))
}

fn duplicate_objects(state: &State, ids: &[ObjectId], offset_m: Vec3) -> Decision {
    if !offset_m.is_finite() {
        return Err(Refused::BadTransform("the copy".to_owned()));
    }
    let first = state.scene.room.objects.len();
    let copies: Vec<_> = objects_by_id(state.scene, ids)?
        .into_iter()
        .enumerate()
        .map(|(i, object)| {
            let mut copy = object.clone();
            copy.id = ObjectId(state.next.object + i as u32);
            copy.name = format!("{} copy", object.name);
            copy.locked = false;
            copy.world_from_object = Affine3A::from_translation(offset_m) * object.world_from_object;
            Numbered { index: first + i, value: copy }
        })
        .collect();
    Ok((!copies.is_empty()).then_some(Change::ObjectsAdded(copies)))
}

pub(super) fn numbered<T: Clone>(list: &[T], which: impl Fn(&T) -> bool) -> Vec<Numbered<T>> {
    let mut found = Vec::new();
    for (index, value) in list.iter().enumerate() {
        if which(value) {
            found.push(Numbered { index, value: value.clone() });
        }
    }
    found
}

/// The people named by `ids`, each once, in the order asked for.
fn people_by_id(scene: &Scene, ids: &[PersonId]) -> Result<Vec<Person>, Refused> {
    let mut seen = BTreeSet::new();
    let once = ids.iter().filter(|id| seen.insert(**id));
    once.map(|id| scene.person(*id).cloned().ok_or(Refused::NoSuchPerson(*id))).collect()
}

/// The objects named by `ids`, each once, in the order asked for.
fn objects_by_id<'a>(scene: &'a Scene, ids: &[ObjectId]) -> Result<Vec<&'a Object>, Refused> {
    let mut seen = BTreeSet::new();
    let once = ids.iter().filter(|id| seen.insert(**id));
    once.map(|id| scene.room.object(*id).ok_or(Refused::NoSuchObject(*id))).collect()
}

pub(super) fn same_room(state: &State, made_for: Option<RoomVersion>) -> Result<(), Refused> {
    match made_for {
        Some(version) if version != state.version => Err(Refused::RoomChanged),
        _ => Ok(()),
    }
}

fn unlocked_people(people: &[Person]) -> Result<(), Refused> {
    let locked = people.iter().find(|p| p.locked);
    locked.map_or(Ok(()), |person| Err(Refused::Locked(person.name.clone())))
}

fn unlocked_objects(objects: &[&Object]) -> Result<(), Refused> {
    let locked = objects.iter().find(|o| o.locked);
    locked.map_or(Ok(()), |object| Err(Refused::Locked(object.name.clone())))
}

fn finite(person: &Person) -> Result<(), Refused> {
    let finite = person.body.to_vector().iter().all(|x| x.is_finite());
    if finite { Ok(()) } else { Err(Refused::NotFinite(person.name.clone())) }
}

fn checked_name(name: &str) -> Result<String, Refused> {
    let name = name.trim();
    if name.is_empty() { Err(Refused::EmptyName) } else { Ok(name.to_owned()) }
}
