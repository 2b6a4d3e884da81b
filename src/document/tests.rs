//! Promises in the user's words, with a sweep over the invariants after every step.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use proptest::prelude::*;

use super::*;
use crate::assets::{Material, Mesh};
use crate::scene::{
    BodyParams, Category, Clip, ClipId, Frame, GoalPose, Leg, Object, ObjectId, ObjectPart, Person, PersonId,
    PoseFamily, Room, Scene, SubGoal, SubGoalId,
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
        let clips: BTreeSet<u32> = scene.clips.iter().map(|c| c.id.0).collect();
        assert_eq!(clips.len(), scene.clips.len(), "two motions share an id");
        assert!(clips.iter().all(|id| *id < self.document.next_clip()));
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
    format!("{} {objects:?} {:?} {bits:?} {:?}", scene.room.name, scene.people, scene.clips)
}

fn goal(id: u32, x: f32) -> SubGoal {
    SubGoal {
        id: SubGoalId(id),
        at: Vec3::new(x, 0.0, 0.5),
        facing: Some(0.1),
        pose: GoalPose::Stand,
        stay_s: 0.0,
        planned: false,
        locked: false,
        body: None,
    }
}

fn leg(from: u32, to: u32, first: usize) -> Leg {
    Leg { from: SubGoalId(from), to: SubGoalId(to), first, last: first + 10, key: 77 + u64::from(from) }
}

/// From sub-goal 0 over 1 and 2 to 3, ten frames a leg, with numbers that are awkward to write down.
fn walk(name: &str) -> Clip {
    let frame = |i: usize| Frame {
        translation: Vec3::new(0.1 * i as f32, -0.0, 1.0 / 3.0),
        hands: [f32::MIN_POSITIVE / 8.0; crate::scene::HANDS],
        ..Frame::default()
    };
    Clip {
        name: name.to_owned(),
        frames: (0..31).map(frame).collect(),
        planted: (0..31).map(|i| [i % 2 == 0, i % 3 == 0]).collect(),
        goals: (0..4).map(|i| goal(i, i as f32)).collect(),
        legs: (0..3).map(|i| leg(i, i + 1, 10 * i as usize)).collect(),
        seed: 5,
        ..Clip::default()
    }
}

impl User {
    fn adds_a_walk(&mut self, name: &str) -> ClipId {
        let id = ClipId(self.document.next_clip());
        self.does(Command::AddClips { clips: vec![walk(name)], made_for: None }).unwrap();
        id
    }

    fn keys(&self, id: ClipId) -> Vec<u64> {
        self.document.scene().clip(id).unwrap().legs.iter().map(|leg| leg.key).collect()
    }
}

#[test]
fn moving_one_sub_goal_leaves_all_but_its_two_legs_as_they_are() {
    let mut user = User::opens_the_study();
    let id = user.adds_a_walk("Ada");
    let mut goals = walk("Ada").goals;
    goals[2].at.z += 0.25;
    user.does(Command::SetGoals(id, goals.clone())).unwrap();
    assert_eq!(user.keys(id), [77, 0, 0], "the leg between the first two stays");
    goals[2].locked = true;
    user.document.undo();
    let mut locked = walk("Ada").goals;
    locked[1].locked = true;
    user.does(Command::SetGoals(id, locked)).unwrap();
    assert_eq!(user.keys(id), [77, 78, 79], "a lock is no other way");
}

#[test]
fn a_sub_goal_put_in_between_or_taken_out_makes_the_legs_around_it_anew() {
    let mut user = User::opens_the_study();
    let id = user.adds_a_walk("Ada");
    let mut goals = walk("Ada").goals;
    goals.insert(1, goal(9, 0.5));
    user.does(Command::SetGoals(id, goals)).unwrap();
    assert_eq!(user.keys(id), [0, 78, 79]);
    user.document.undo();
    let mut goals = walk("Ada").goals;
    goals.remove(3);
    user.does(Command::SetGoals(id, goals)).unwrap();
    assert_eq!(user.keys(id), [77, 78, 0]);
}

#[test]
fn a_drag_of_a_sub_goal_is_one_step() {
    let mut user = User::opens_the_study();
    let id = user.adds_a_walk("Ada");
    user.document.begin("Move sub-goal");
    for i in 0..50 {
        let mut goals = walk("Ada").goals;
        goals[1].at.x += i as f32 * 0.01;
        user.does(Command::SetGoals(id, goals)).unwrap();
    }
    user.document.commit();
    assert_eq!(user.document.past_labels().collect::<Vec<_>>(), ["Add motion", "Move sub-goal"]);
    user.document.undo();
    assert_eq!(user.document.scene().clip(id).unwrap().goals, walk("Ada").goals);
}

#[test]
fn a_motion_that_was_removed_or_locked_meanwhile_is_not_brought_back_or_changed() {
    let mut user = User::opens_the_study();
    let (first, second) = (user.adds_a_walk("Ada"), user.adds_a_walk("Bo"));
    let again = |id| Command::ReplaceClip { clip: Clip { id, seed: 6, ..walk("again") }, made_for: None };
    user.does(Command::SetClipsLocked(vec![second], true)).unwrap();
    assert_eq!(user.does(again(second)), Err(Refused::Locked("Bo".to_owned())));
    assert_eq!(user.does(Command::RemoveClips(vec![second])), Err(Refused::Locked("Bo".to_owned())));
    user.does(Command::RemoveClips(vec![first])).unwrap();
    assert_eq!(user.does(again(first)), Err(Refused::NoSuchClip(first)));
    let third = user.adds_a_walk("Cleo");
    assert!(third != first && third != second, "an id is never given again");
}

#[test]
fn a_motion_made_for_a_room_that_has_changed_is_refused() {
    let mut user = User::opens_the_study();
    let made_for = Some(user.document.room_version());
    user.does(Command::MoveObject(ObjectId(1), Affine3A::from_translation(Vec3::X))).unwrap();
    let refused = user.does(Command::AddClips { clips: vec![walk("Ada")], made_for });
    assert_eq!(refused, Err(Refused::RoomChanged));
}

#[test]
fn another_room_takes_the_motions_along_and_undo_brings_them_back() {
    let mut user = User::opens_the_study();
    let id = user.adds_a_walk("Ada");
    user.does(Command::OpenRoom { room: room() }).unwrap();
    assert!(user.document.scene().clips.is_empty());
    user.document.undo();
    assert!(user.document.scene().clip(id).is_some());
}

#[test]
fn numbers_that_are_none_and_sub_goals_of_one_name_never_enter_a_motion() {
    let mut user = User::opens_the_study();
    let id = user.adds_a_walk("Ada");
    let mut goals = walk("Ada").goals;
    goals[3].id = SubGoalId(0);
    assert_eq!(user.does(Command::SetGoals(id, goals)), Err(Refused::GoalTwice("Ada".to_owned())));
    let mut clip = walk("Bo");
    clip.frames[30].pose[4].y = f32::NAN;
    let refused = user.does(Command::AddClips { clips: vec![clip], made_for: None });
    assert_eq!(refused, Err(Refused::NotFinite("Bo".to_owned())));
}

#[test]
fn long_motions_count_in_what_the_history_keeps() {
    let mut document = Document::of_room(room()).with_history_bytes(200_000);
    for i in 0..40 {
        let clips = vec![walk(&format!("W{i}"))];
        document.apply(Command::AddClips { clips, made_for: None }).unwrap();
    }
    let remembered = document.past_labels().count();
    assert!((10..40).contains(&remembered), "{remembered}");
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
fn an_action_changes_room_and_people_in_one_step_and_what_stays_keeps_its_number() {
    let mut user = User::opens_the_study();
    let ids = user.adds(&["Ada", "Bo"]);
    let made_for = Some(user.document.room_version());
    let mut lived = user.document.scene().room.as_ref().clone();
    lived.objects.push(object(2, "Book", Category::Chair));
    let lived = Arc::new(lived);
    let read = |room: &Arc<Room>, made_for| Command::ChangeRoom {
        label: "read book on sofa".to_owned(),
        room: room.clone(),
        leaving: vec![ids[0]],
        arriving: vec![person("Cleo")],
        made_for,
    };
    user.does(read(&lived, made_for)).unwrap();
    assert_eq!(user.names(), ["Bo", "Cleo"]);
    assert_eq!(user.document.scene().room.objects.len(), 3);
    assert_eq!(user.document.past_labels().last(), Some("read book on sofa"));
    assert_eq!(user.does(read(&lived, made_for)), Err(Refused::RoomChanged));
    user.document.undo();
    assert_eq!((user.names(), Some(user.document.room_version())), (vec!["Ada", "Bo"], made_for));
    let mut twice = lived.as_ref().clone();
    twice.objects[2].id = ObjectId(0);
    assert_eq!(user.does(read(&Arc::new(twice), None)), Err(Refused::ObjectTwice(ObjectId(0))));
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
        Just(Command::AddClips { clips: vec![walk("New")], made_for: None }),
        (0u32..4).prop_map(|id| Command::RemoveClips(vec![ClipId(id)])),
        ((0u32..4), -2.0f32..2.0)
            .prop_map(|(id, x)| Command::SetGoals(ClipId(id), vec![goal(0, x), goal(2, 1.0)])),
        ((0u32..4), any::<bool>()).prop_map(|(id, on)| Command::SetClipsLocked(vec![ClipId(id)], on)),
    ]
}

#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "forty at most")]
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

/// Bodies whose numbers are awkward to write down: tiny, huge, negative zero, no short decimal.
fn awkward(id: u32) -> Person {
    let mut x = [0.0f32; crate::scene::PARAMS];
    for (i, value) in x.iter_mut().enumerate() {
        let bits = (i as u32 + 1).wrapping_mul(0x9e37_79b9).wrapping_add(id) & 0xbfff_ffff;
        let number = f32::from_bits(bits);
        *value = if number.is_finite() { number } else { -0.0 };
    }
    x[4] = -0.0;
    x[5] = f32::MIN_POSITIVE / 8.0;
    x[6] = 1.0 / 3.0;
    Person { id: PersonId(id), body: BodyParams::from_vector(&x), ..person("Zoë \"Z\" O'Hara\\\n") }
}

fn project() -> Project {
    let mut room = room().as_ref().clone();
    room.objects[1].world_from_object =
        Affine3A::from_rotation_y(0.3) * Affine3A::from_scale(Vec3::new(-1.0, 1.1, 0.7));
    room.objects[1].visible = false;
    room.objects[1].locked = true;
    room.objects[1].category = Category::Bed;
    let elsewhere = Affine3A::from_translation(Vec3::new(0.1, 0.2, 0.3));
    let first = room.objects[1].parts[0].clone();
    room.objects[1].parts.push(ObjectPart { object_from_mesh: elsewhere, ..first.clone() });
    room.objects[1].parts.push(first);
    Project {
        scene: Scene { room: Arc::new(room), people: vec![awkward(3), awkward(8)], clips: Vec::new() },
        next: NextIds { person: 12, object: 40, clip: 9 },
    }
}

fn bits_of(project: &Project) -> String {
    format!("{} {} {}", snapshot(&project.scene), project.next.person, project.next.object)
}

#[test]
fn a_saved_project_opens_again_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["project.ron", "other.ron", "all.inhabit"] {
        let path = folder.path().join(name);
        let saved = project();
        save_project(&path, &saved).unwrap();
        let loaded = load_project(&path).unwrap();
        assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
        assert_eq!(bits_of(&loaded.project), bits_of(&saved), "{name}");
        let triangles = |p: &Project| p.scene.room.world_triangles().count();
        assert_eq!(triangles(&loaded.project), triangles(&saved));
        assert_eq!(loaded.project.scene.room.bounds(), saved.scene.room.bounds());
    }
    let names: BTreeSet<String> =
        std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    let expected = ["all.inhabit", "other.ron", "other.room.glb", "project.ron", "room.glb"];
    assert_eq!(names, expected.map(str::to_owned).into(), "no temporary file is left");
}

#[test]
fn motions_open_again_bit_by_bit_and_stand_beside_the_text() {
    let folder = tempfile::tempdir().unwrap();
    let mut saved = project();
    let mut plan = Clip { id: ClipId(7), ..walk("plan") };
    plan.frames.clear();
    plan.planted.clear();
    plan.legs.clear();
    saved.scene.clips = vec![Arc::new(Clip { id: ClipId(3), locked: true, ..walk("Ada") }), Arc::new(plan)];
    for name in ["project.ron", "other.ron", "all.inhabit"] {
        let path = folder.path().join(name);
        save_project(&path, &saved).unwrap();
        let loaded = load_project(&path).unwrap().project;
        assert_eq!(bits_of(&loaded), bits_of(&saved), "{name}");
        assert_eq!(loaded.next, saved.next);
        assert!(loaded.scene.clips[0].frames[0].translation.y.is_sign_negative(), "minus zero stays so");
    }
    let text = std::fs::read_to_string(folder.path().join("project.ron")).unwrap();
    assert!(text.len() < 12_000, "there are frames in {} letters of text", text.len());
    std::fs::remove_file(folder.path().join("motions.npz")).unwrap();
    let said = load_project(&folder.path().join("project.ron")).unwrap_err().to_string();
    assert!(said.contains("motions.npz"), "{said}");
    std::fs::copy(folder.path().join("room.glb"), folder.path().join("motions.npz")).unwrap();
    let said = load_project(&folder.path().join("project.ron")).unwrap_err().to_string();
    assert!(said.contains("the motions of"), "{said}");
}

#[test]
fn a_project_of_a_program_that_knew_no_motions_opens() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("project.ron");
    save_project(&path, &project()).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("version: 1"), "without motions every program can read it");
    let older: String =
        text.lines().filter(|l| !l.contains("motions:") && !l.contains("next_clip:")).collect();
    std::fs::write(&path, older).unwrap();
    assert_eq!(bits_of(&load_project(&path).unwrap().project), bits_of(&project()));
}

#[test]
fn a_project_saved_again_after_opening_has_the_same_text() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (folder.path().join("project.ron"), folder.path().join("again/project.ron"));
    std::fs::create_dir(folder.path().join("again")).unwrap();
    save_project(&first, &project()).unwrap();
    save_project(&second, &load_project(&first).unwrap().project).unwrap();
    let objects = |path: &std::path::Path| {
        let text = std::fs::read_to_string(path).unwrap();
        text[text.find("objects").unwrap()..].to_owned()
    };
    assert_eq!(objects(&first), objects(&second));
}

#[test]
fn a_bad_project_names_file_place_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("project.ron");
    save_project(&path, &project()).unwrap();
    let good = std::fs::read_to_string(&path).unwrap();
    let complaint = |text: &str| {
        std::fs::write(&path, text).unwrap();
        load_project(&path).unwrap_err().to_string()
    };
    let cases = [
        (good[..good.len() / 2].to_owned(), "line"),
        (good.replace("inhabit project", "cooking recipe"), "cooking recipe"),
        (good.replace("version: 1", "version: 99"), "version 99"),
        (good.replace("file: \"room.glb\"", "file: \"../room.glb\""), "without a folder"),
        (good.replace("file: \"room.glb\"", "file: \"gone.glb\""), "gone.glb"),
        (good.replace("id: (8)", "id: (3)"), "the id of another person"),
        ("\0\u{1}".to_owned(), "line 1"),
        (String::new(), "line 1"),
    ];
    for (text, expected) in cases {
        let said = complaint(&text);
        assert!(said.contains(expected), "{expected}: {said}");
        assert!(said.contains(folder.path().to_str().unwrap()), "names no file: {said}");
    }
    std::fs::write(&path, &good).unwrap();
    std::fs::write(folder.path().join("room.glb"), b"glTF").unwrap();
    assert!(load_project(&path).unwrap_err().to_string().contains("room"));
}

#[test]
fn a_damaged_archive_is_refused_and_a_failed_save_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.inhabit");
    save_project(&path, &project()).unwrap();
    let good = std::fs::read(&path).unwrap();
    let mut broken = project();
    Arc::make_mut(&mut broken.scene.room).objects[0].world_from_object.translation.x = f32::NAN;
    assert!(save_project(&path, &broken).unwrap_err().to_string().contains("was not written"));
    assert_eq!(std::fs::read(&path).unwrap(), good);
    std::fs::write(&path, &good[..good.len() - 40]).unwrap();
    assert!(load_project(&path).unwrap_err().to_string().contains("damaged"));
    let nowhere = folder.path().join("no/such/folder/a.inhabit");
    assert!(save_project(&nowhere, &project()).unwrap_err().to_string().contains("can't be written"));
}

#[test]
fn settings_survive_a_restart_and_a_broken_file_is_no_reason_to_fail() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep/settings.ron");
    let settings = Settings { recent: vec!["/rooms/a.glb".into()], light: true };
    settings.save(&path).unwrap();
    assert_eq!(Settings::load(&path), settings);
    std::fs::write(&path, "((((").unwrap();
    assert_eq!(Settings::load(&path), Settings::default());
}

#[test]
fn a_project_of_a_bare_scene_never_gives_a_number_twice() {
    let scene = project().scene;
    let project = Project::of_scene(scene);
    assert_eq!(project.next, NextIds { person: 9, object: 2, clip: 0 });
    let empty = Project::of_scene(Scene::default());
    assert_eq!(empty.next, NextIds::default());
}
