use glam::{Affine3A, Mat3};

use super::*;
use crate::body::joints::BODY_JOINTS;
use crate::generate::sensor::{Intrinsics, SIDE};
use crate::job::Ticker;
use crate::learn::stage::{StageConfig, make_room, plan_rooms, stage_room};
use crate::scene::{ImportOptions, room_from_model};

fn entry(people: usize, views: usize) -> RoomEntry {
    let source = RoomSource::Procedural { kind: RoomType::Guest, seed: 7 };
    RoomEntry { name: "room_0000".into(), split: Split::Test, source, people, views }
}

fn person(number: usize) -> CorpusPerson {
    let f = number as f32;
    CorpusPerson {
        translation: Vec3::new(f, 0.9, -f),
        rotation6: [1.0, 0.0, 0.0, 1.0, 0.0, f],
        betas: [0.1 * f; BETAS],
        body_pose: [Vec3::new(0.1, f, 0.3); BODY_JOINTS],
        hands: [0.2; HANDS],
        family: PoseFamily::ALL[number],
    }
}

fn view(body: usize) -> CorpusView {
    let turn = Mat3::from_rotation_y(0.3) * Mat3::from_rotation_x(0.2);
    let intrinsics = Intrinsics { width: SIDE as u32, height: SIDE as u32, focal_px: 70.7 };
    let world_from_camera = Affine3A::from_mat3_translation(turn, Vec3::new(1.0, 2.0, 3.0));
    CorpusView {
        kind: ViewKind::Agent,
        body,
        view: View { world_from_camera, intrinsics },
        valid: Valid { left: 0, top: 28, width: 128, height: 72 },
        depth_mm: (0..SIDE * SIDE).map(|i| (i % 6000) as u16).collect(),
        labels: (0..SIDE * SIDE).map(|i| (i % 46) as u8).collect(),
    }
}

fn room() -> CorpusRoom {
    let RoomEntry { name, split, source, .. } = entry(0, 0);
    CorpusRoom {
        name,
        split,
        source,
        people: vec![person(0), person(9)],
        views: vec![view(1), view(0), view(1)],
    }
}

#[test]
fn a_room_survives_its_file_and_gives_the_same_bytes() {
    let bytes = room().to_npz().expect("writes");
    let read = CorpusRoom::from_npz(&entry(2, 3), "samples.npz", &bytes).expect("reads");
    assert_eq!(read, room());
    assert_eq!(read.to_npz().expect("writes"), bytes);
    let image = read.views[0].scene_image();
    assert_eq!(image.depth_m[100 * SIDE], f32::from(view(0).depth_mm[100 * SIDE]) * 1e-3);
    assert_eq!(image.labels, view(0).labels);
}

#[test]
fn what_is_wrong_with_a_file_is_named() {
    let problem = |change: &dyn Fn(&mut CorpusRoom), entry: &RoomEntry| {
        let mut room = room();
        change(&mut room);
        let bytes = room.to_npz().expect("writes");
        CorpusRoom::from_npz(entry, "a/samples.npz", &bytes).expect_err("must be refused").to_string()
    };
    let whole = entry(2, 3);
    let of = problem(&|room| room.views[2].body = 2, &whole);
    assert!(of.contains("a/samples.npz") && of.contains("`views/body` at 2: 2 is not from 0 to 1"), "{of}");
    let of = problem(&|room| room.views[0].labels[5] = 46, &whole);
    assert!(of.contains("`views/labels` at 0: 46"), "{of}");
    let of = problem(&|room| room.views[1].valid.top = 100, &whole);
    assert!(of.contains("`views/valid` at 1"), "{of}");
    let of = problem(&|room| drop(room.people[0].betas[0] = f32::NAN), &whole);
    assert!(of.contains("not finite"), "{of}");
    let of = problem(&|_| (), &entry(2, 4));
    assert!(of.contains("3 views, the manifest says 4"), "{of}");
    assert!(CorpusRoom::from_npz(&whole, "x", b"no archive").is_err());
}

#[test]
fn a_manifest_survives_its_text_and_other_formats_are_refused() {
    let manifest = Manifest { format: FORMAT, about: "a test".into(), seed: 3, rooms: vec![entry(1, 2)] };
    let text = manifest.to_ron().expect("text");
    assert_eq!(Manifest::from_ron(&text).expect("reads"), manifest);
    let other = Manifest::from_ron(&text.replace("format: 1", "format: 9")).expect_err("refused").to_string();
    assert!(other.contains("format 9"), "{other}");
    let damaged = Manifest::from_ron("(format: 1,\n rooms: 3)").expect_err("refused").to_string();
    assert!(damaged.contains("line 2"), "{damaged}");
}

#[test]
fn a_body_of_the_corpus_is_the_body_that_was_staged() {
    let body = Body::bundled();
    let mut params = BodyParams { translation: Vec3::new(0.4, 0.1, -2.0), ..BodyParams::default() };
    params.pose = std::array::from_fn(|i| (i as f32 * 1.3).sin());
    params.hands[3] = 0.7;
    let back = CorpusPerson::new(&params, PoseFamily::Stand, body).params(body);
    let (then, now) = (body.pose(&params).vertices, body.pose(&back).vertices);
    let worst = then.iter().zip(&now).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(worst < 0.03, "{worst} m apart");
}

/// Stages a room of a corpus on some threads.
fn staged(threads: usize) -> (CorpusRoom, Vec<u8>) {
    let config =
        StageConfig { rooms: 8, people: 2, views: 2, sample_rooms: false, seed: 5, ..StageConfig::default() };
    let plan = &plan_rooms(&config)[7];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let (_, model) = make_room(&plan.source).expect("a room");
        let room = room_from_model(&model, &ImportOptions::default()).room;
        let staged = stage_room(plan, &room, &config, &Ticker::silent()).expect("not stopped");
        let bytes = staged.to_npz().expect("writes");
        (staged, bytes)
    })
}

#[test]
fn a_staged_room_has_people_held_by_something_and_views_of_them_on_any_number_of_threads() {
    let (room, bytes) = staged(1);
    assert_eq!(room.people.len(), 2);
    let body = Body::bundled();
    for (index, person) in room.people.iter().enumerate() {
        let lowest =
            body.pose(&person.params(body)).vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
        assert!(lowest > -0.03, "nobody is sunk into the floor: {lowest}");
        assert!(room.views.iter().any(|v| v.body == index), "person {index} is in no view");
    }
    for view in &room.views {
        let pelvis =
            body.model.rest_joints(&room.people[view.body].betas)[0] + room.people[view.body].translation;
        let (pixel, _) = view.view.project(pelvis).expect("in front of the camera");
        assert!(view.view.holds(pixel), "the body is in its view");
        assert!(view.depth_mm.iter().any(|d| *d > 500));
    }
    assert!(staged(2).1 == bytes, "the same bytes on two threads");
}
