//! Promises in the user's words, with a sweep over the invariants after every step.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use proptest::prelude::*;

use super::*;
use crate::assets::{Material, Mesh};
use crate::scene::{
    BodyParams, Category, Object, ObjectId, ObjectPart, Person, PersonId, PoseFamily, Room, Scene,
};

fn person(name: &str) -> Person {
    Person {
        id: PersonId(0),
        name: name.to_owned(),
        body: BodyParams::default(),
        family: PoseFamily::Stand,
        on: "floor".to_owned(),
        seed: 7,
        palette: 0,
        visible: true,
        locked: false,
    }
}

fn object(id: u32, name: &str, category: Category) -> Object {
    let mesh =
        Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z], triangles: vec![[0, 2, 1]], ..Mesh::default() };
    let part = ObjectPart { mesh: Arc::new(mesh), material: 0, object_from_mesh: Affine3A::IDENTITY };
    Object {
        id: ObjectId(id),
        name: name.to_owned(),
        category,
        parts: vec![part],
        world_from_object: Affine3A::IDENTITY,
        visible: true,
        locked: false,
    }
}

fn room() -> Arc<Room> {
    Arc::new(Room {
        name: "Study".to_owned(),
        objects: vec![object(0, "Floor", Category::Floor), object(1, "Sofa", Category::Sofa)],
        materials: vec![Material::default()],
        textures: Vec::new(),
    })
}

/// A user who does one thing after the other; each step is followed by a sweep over the invariants.
struct User {
    document: Document,
    people_seen: BTreeSet<u32>,
}

impl User {
    fn opens_the_study() -> Self {
        Self { document: Document::of_room(room()), people_seen: BTreeSet::new() }
    }

    fn does(&mut self, command: Command) -> Result<bool, Refused> {
        let before = snapshot(self.document.scene());
        let revision = self.document.revision();
        let steps = self.document.past_labels().count();
        let in_gesture = self.document.in_gesture();
        let outcome = self.document.apply(command).map(|change| change.is_some());
        let changed = outcome == Ok(true);
        if changed {
            assert!(self.document.revision() > revision, "a change raises the revision");
            if !in_gesture {
                assert_eq!(self.document.past_labels().count(), steps + 1, "a change is one step");
                self.sees_undo_and_redo_bring_back_exactly(&before);
            }
        } else if !in_gesture {
            assert_eq!(snapshot(self.document.scene()), before, "nothing done, nothing changed");
            assert_eq!(self.document.past_labels().count(), steps, "no step without a change");
        }
        self.sweep();
        outcome
    }

    fn sees_undo_and_redo_bring_back_exactly(&mut self, before: &str) {
        let (after, version) = (snapshot(self.document.scene()), self.document.room_version());
        assert!(self.document.undo().is_some());
        assert_eq!(snapshot(self.document.scene()), before, "undo brings back what was there");
        assert!(self.document.redo().is_some());
        assert_eq!(snapshot(self.document.scene()), after, "redo brings back what was done");
        assert_eq!(self.document.room_version(), version);
    }

    fn sweep(&mut self) {
        let scene = self.document.scene();
        let people: BTreeSet<u32> = scene.people.iter().map(|p| p.id.0).collect();
        assert_eq!(people.len(), scene.people.len(), "two people share an id");
        let objects: BTreeSet<u32> = scene.room.objects.iter().map(|o| o.id.0).collect();
        assert_eq!(objects.len(), scene.room.objects.len(), "two objects share an id");
        assert!(people.iter().all(|id| *id < self.document.next_person()));
        assert!(objects.iter().all(|id| *id < self.document.next_object()));
        self.people_seen.extend(people);
    }

    fn adds(&mut self, names: &[&str]) -> Vec<PersonId> {
        let first = self.document.next_person();
        let people = names.iter().map(|n| person(n)).collect();
        self.does(Command::AddPeople { people, made_for: None }).unwrap();
        (0..names.len() as u32).map(|i| PersonId(first + i)).collect()
    }

    fn names(&self) -> Vec<&str> {
        self.document.scene().people.iter().map(|p| p.name.as_str()).collect()
    }
}

/// Everything that a document keeps, in a form that compares bit by bit.
fn snapshot(scene: &Scene) -> String {
    let objects: Vec<_> = scene.room.objects.iter().map(ObjectState::of).collect();
    let bits: Vec<Vec<u32>> =
        scene.people.iter().map(|p| p.body.to_vector().iter().map(|x| x.to_bits()).collect()).collect();
    format!("{} {objects:?} {:?} {bits:?}", scene.room.name, scene.people)
}

#[test]
fn populating_is_one_step_that_undo_takes_back_whole() {
    let mut user = User::opens_the_study();
    user.adds(&["Ada", "Bo", "Cleo"]);
    assert_eq!(user.document.past_labels().collect::<Vec<_>>(), ["Add 3 people"]);
    user.document.undo();
    assert!(user.names().is_empty());
    user.document.redo();
    assert_eq!(user.names(), ["Ada", "Bo", "Cleo"]);
}

#[test]
fn an_id_is_never_given_again() {
    let mut user = User::opens_the_study();
    let first = user.adds(&["Ada"]);
    user.document.undo();
    let second = user.adds(&["Bo"]);
    user.does(Command::RemovePeople(second.clone())).unwrap();
    let third = user.adds(&["Cleo"]);
    assert!(first != second && second != third && first != third);
}

#[test]
fn a_result_for_somebody_deleted_is_refused_and_nobody_comes_back() {
    let mut user = User::opens_the_study();
    let ids = user.adds(&["Ada", "Bo"]);
    let rerolled = user.document.scene().people.clone();
    user.does(Command::RemovePeople(vec![ids[0]])).unwrap();
    let refused = user.does(Command::ReplacePeople { people: rerolled, made_for: None });
    assert_eq!(refused, Err(Refused::NoSuchPerson(ids[0])));
    assert_eq!(user.names(), ["Bo"]);
}

#[test]
fn people_made_for_a_room_that_has_changed_are_refused_until_undo_brings_it_back() {
    let mut user = User::opens_the_study();
    let made_for = Some(user.document.room_version());
    let moved = Affine3A::from_translation(Vec3::X);
    user.does(Command::MoveObject(ObjectId(1), moved)).unwrap();
    let people = vec![person("Ada")];
    let refused = user.does(Command::AddPeople { people: people.clone(), made_for });
    assert_eq!(refused, Err(Refused::RoomChanged));
    user.document.undo();
    assert_eq!(user.does(Command::AddPeople { people, made_for }), Ok(true));
}

#[test]
fn naming_and_labelling_a_thing_keeps_the_geometry_valid() {
    let mut user = User::opens_the_study();
    let version = user.document.room_version();
    user.does(Command::RenameObject(ObjectId(1), "  Red couch ".to_owned())).unwrap();
    user.does(Command::SetCategory(vec![ObjectId(1)], Category::Bed)).unwrap();
    assert_eq!(user.document.room_version(), version);
    assert_eq!(user.document.scene().room.objects[1].name, "Red couch");
    user.does(Command::SetObjectsVisible(vec![ObjectId(1)], false)).unwrap();
    assert_ne!(user.document.room_version(), version);
}

#[test]
fn locked_things_stay() {
    let mut user = User::opens_the_study();
    let ids = user.adds(&["Ada"]);
    user.does(Command::SetPeopleLocked(ids.clone(), true)).unwrap();
    user.does(Command::SetObjectsLocked(vec![ObjectId(1)], true)).unwrap();
    let ada = Err(Refused::Locked("Ada".to_owned()));
    let sofa = Err(Refused::Locked("Sofa".to_owned()));
    assert_eq!(user.does(Command::RemovePeople(ids.clone())), ada);
    assert_eq!(user.does(Command::SetBody(ids[0], BodyParams::default())), ada);
    assert_eq!(user.does(Command::RemoveObjects(vec![ObjectId(1)])), sofa);
    assert_eq!(user.does(Command::MoveObject(ObjectId(1), Affine3A::from_scale(Vec3::splat(2.0)))), sofa);
}

#[test]
fn a_drag_of_many_moves_is_one_step_and_one_back_to_the_start_is_none() {
    let mut user = User::opens_the_study();
    let id = user.adds(&["Ada"])[0];
    user.document.begin("Height");
    for i in 0..100 {
        let mut body = BodyParams::default();
        body.betas[0] = i as f32 * 0.01;
        user.does(Command::SetBody(id, body)).unwrap();
    }
    user.document.commit();
    assert_eq!(user.document.past_labels().collect::<Vec<_>>(), ["Add person", "Height"]);
    user.document.undo();
    assert_eq!(user.document.scene().people[0].body.betas[0], 0.0);

    user.document.begin("Nothing");
    for beta in [1.0, 2.0, 0.0] {
        let mut body = BodyParams::default();
        body.betas[0] = beta;
        user.does(Command::SetBody(id, body)).unwrap();
    }
    user.document.commit();
    assert_eq!(user.document.past_labels().collect::<Vec<_>>(), ["Add person"]);
}

#[test]
fn escape_in_a_drag_puts_everything_back() {
    let mut user = User::opens_the_study();
    let before = snapshot(user.document.scene());
    user.document.begin("Move");
    user.does(Command::MoveObject(ObjectId(1), Affine3A::from_translation(Vec3::X))).unwrap();
    user.does(Command::MoveObject(ObjectId(1), Affine3A::from_translation(Vec3::Z))).unwrap();
    user.document.abort();
    assert_eq!(snapshot(user.document.scene()), before);
    assert!(!user.document.can_undo());
}

#[test]
fn not_a_number_never_enters_the_document() {
    let mut user = User::opens_the_study();
    let mut ada = person("Ada");
    ada.body.pose[3] = f32::NAN;
    let refused = user.does(Command::AddPeople { people: vec![ada], made_for: None });
    assert_eq!(refused, Err(Refused::NotFinite("Ada".to_owned())));
    let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let refused = user.does(Command::MoveObject(ObjectId(1), flat));
    assert_eq!(refused, Err(Refused::BadTransform("Sofa".to_owned())));
}

#[test]
fn opening_another_room_can_be_undone_and_its_objects_have_new_ids() {
    let mut user = User::opens_the_study();
    user.adds(&["Ada"]);
    user.does(Command::OpenRoom { room: room() }).unwrap();
    assert!(user.names().is_empty());
    assert_eq!(user.document.scene().room.objects[0].id, ObjectId(2));
    user.document.undo();
    assert_eq!(user.names(), ["Ada"]);
    assert_eq!(user.document.scene().room.objects[0].id, ObjectId(0));
}

#[test]
fn copies_share_their_mesh() {
    let mut user = User::opens_the_study();
    user.does(Command::DuplicateObjects(vec![ObjectId(1)], Vec3::X)).unwrap();
    let room = &user.document.scene().room;
    assert_eq!(room.objects[2].id, ObjectId(2));
    assert!(Arc::ptr_eq(&room.objects[1].parts[0].mesh, &room.objects[2].parts[0].mesh));
    assert_eq!(room.objects[2].world_bounds().min.x, 1.0);
}

#[test]
fn undoing_to_the_saved_state_makes_the_document_clean_again() {
    let mut user = User::opens_the_study();
    assert!(!user.document.is_dirty());
    user.adds(&["Ada"]);
    user.document.mark_saved();
    user.adds(&["Bo"]);
    assert!(user.document.is_dirty());
    user.document.undo();
    assert!(!user.document.is_dirty());
    user.document.undo();
    assert!(user.document.is_dirty());
}

#[test]
fn a_full_history_forgets_the_oldest_steps_only() {
    let mut document = Document::of_room(room()).with_history_bytes(20_000);
    for i in 0..200 {
        let people = vec![person(&format!("P{i}"))];
        document.apply(Command::AddPeople { people, made_for: None }).unwrap();
    }
    let remembered = document.past_labels().count();
    assert!(remembered > 5 && remembered < 200, "{remembered}");
    for _ in 0..remembered {
        assert!(document.undo().is_some());
    }
    assert_eq!(document.scene().people.len(), 200 - remembered);
}

/// Any command with ids that may or may not exist.
fn any_command() -> impl Strategy<Value = Command> {
    let person_ids = || prop::collection::vec((0u32..8).prop_map(PersonId), 0..4);
    let object_ids = || prop::collection::vec((0u32..6).prop_map(ObjectId), 0..3);
    let offset = || (-2.0f32..2.0, -2.0f32..2.0).prop_map(|(x, z)| Vec3::new(x, 0.0, z));
    prop_oneof![
        (0usize..3).prop_map(|n| Command::AddPeople { people: vec![person("New"); n], made_for: None }),
        person_ids().prop_map(Command::RemovePeople),
        ((0u32..8), -3.0f32..3.0).prop_map(|(id, beta)| {
            let mut body = BodyParams::default();
            body.betas[1] = beta;
            Command::SetBody(PersonId(id), body)
        }),
        (person_ids(), any::<bool>()).prop_map(|(ids, on)| Command::SetPeopleLocked(ids, on)),
        (person_ids(), any::<bool>()).prop_map(|(ids, on)| Command::SetPeopleVisible(ids, on)),
        (object_ids(), any::<bool>()).prop_map(|(ids, on)| Command::SetObjectsVisible(ids, on)),
        (object_ids(), any::<bool>()).prop_map(|(ids, on)| Command::SetObjectsLocked(ids, on)),
        (object_ids(), 0usize..45).prop_map(|(ids, c)| Command::SetCategory(ids, Category::ALL[c])),
        ((0u32..6), offset())
            .prop_map(|(id, at)| Command::MoveObject(ObjectId(id), Affine3A::from_translation(at))),
        object_ids().prop_map(Command::RemoveObjects),
        (object_ids(), offset()).prop_map(|(ids, at)| Command::DuplicateObjects(ids, at)),
        Just(Command::OpenRoom { room: room() }),
    ]
}

#[derive(Clone, Debug)]
enum Deed {
    Apply(Command),
    Undo,
    Redo,
    Begin,
    Commit,
    Abort,
}

fn any_deed() -> impl Strategy<Value = Deed> {
    prop_oneof![
        6 => any_command().prop_map(Deed::Apply),
        2 => Just(Deed::Undo),
        1 => Just(Deed::Redo),
        1 => Just(Deed::Begin),
        1 => Just(Deed::Commit),
        1 => Just(Deed::Abort),
    ]
}

proptest! {
    #[test]
    fn whatever_is_done_can_be_taken_back_to_the_beginning_and_done_again(
        deeds in prop::collection::vec(any_deed(), 1..40)
    ) {
        let mut user = User::opens_the_study();
        let beginning = snapshot(user.document.scene());
        for deed in deeds {
            match deed {
                Deed::Apply(command) => drop(user.does(command)),
                Deed::Undo => drop(user.document.undo()),
                Deed::Redo => drop(user.document.redo()),
                Deed::Begin => user.document.begin("Gesture"),
                Deed::Commit => user.document.commit(),
                Deed::Abort => user.document.abort(),
            }
            user.sweep();
        }
        user.document.commit();
        while user.document.redo().is_some() {}
        let end = snapshot(user.document.scene());
        while user.document.undo().is_some() {}
        prop_assert_eq!(snapshot(user.document.scene()), beginning);
        while user.document.redo().is_some() {}
        prop_assert_eq!(snapshot(user.document.scene()), end);
    }
}
