use super::*;

fn photos(files: &[(&str, &str)]) -> Vec<Photo> {
    let mut set = PhotoSet::default();
    for (name, text) in files {
        set.add_bytes(name, text.as_bytes()).expect("sound");
    }
    set.finish().photos
}

fn refusal(text: &str) -> String {
    PhotoSet::default().add_bytes("file", text.as_bytes()).expect_err("must refuse").to_string()
}

/// 17 joints as JSON numbers, all seen, at (10 + i, 20 + i).
fn joints() -> String {
    (0..17).map(|i| format!("{},{},2", 10 + i, 20 + i)).collect::<Vec<_>>().join(",")
}

const INSTANCES: &str = r#"{"images":[{"id":7,"file_name":"000000000007.jpg","width":640,"height":480}],
    "categories":[{"id":1,"name":"person"},{"id":73,"name":"laptop"}],
    "annotations":[
      {"id":1,"image_id":7,"category_id":1,"bbox":[5,15,30,40],"iscrowd":0},
      {"id":2,"image_id":7,"category_id":73,"bbox":[100,100,40,20],"iscrowd":0,
       "segmentation":[[100,100,140,100,140,120,100,120],[0,0,1,0,1,1]]},
      {"id":3,"image_id":7,"category_id":73,"bbox":[0,0,600,400],"iscrowd":1,"segmentation":{"counts":[1],"size":[2,2]}}]}"#;

#[test]
fn three_coco_files_and_v_coco_speak_of_the_same_person_and_laptop() {
    let people = format!(
        r#"{{"images":[{{"id":7,"file_name":"000000000007.jpg"}}],"categories":[{{"id":1,"name":"person"}}],
            "annotations":[{{"image_id":7,"category_id":1,"bbox":[5,15,30,40],"keypoints":[{}]}}]}}"#,
        joints()
    );
    let captions = r#"{"images":[],"annotations":[{"image_id":7,"caption":" Somebody using a laptop. "}]}"#;
    let verbs = r#"{"classes":["hold obj","work_on_computer instr"],"objects":["background","laptop"],
        "annotations":[{"file_name":"COCO_train2014_000000000007.jpg","boxes_h":[[5,15,35,55],[5,15,35,55]],
        "boxes_o":[[100.3,99.8,140,120],[100.3,99.8,140,120]],"actions":[0,1],"objects":[1,1]}]}"#;
    let files = [("a", INSTANCES), ("b", &people), ("c", captions), ("d", verbs)];
    for order in [[0, 1, 2, 3], [3, 2, 1, 0]] {
        let found = photos(&order.map(|i| files[i]));
        assert_eq!(found.len(), 1);
        let photo = &found[0];
        assert_eq!((photo.key.as_str(), photo.size_px), ("7", Some(Vec2::new(640.0, 480.0))));
        assert_eq!(photo.captions, ["Somebody using a laptop."]);
        assert!(photo.complete);
        assert_eq!(photo.people.len(), 1, "one person in four files");
        assert_eq!(photo.people[0].marked(), 17);
        assert_eq!(photo.people[0].joint(3), Some(Vec2::new(13.0, 23.0)));
        assert!(photo.people[0].does("work_on_computer instr"));
        assert_eq!(photo.things.len(), 1, "crowds are no things, and both files name one laptop");
        assert_eq!(photo.things[0].center(), Vec2::new(120.0, 110.0), "the larger outline");
    }
}

#[test]
fn boxes_as_text_captions_as_csv_and_joints_as_tsv_are_read() {
    let boxes = "/any/where/000000000009.jpg 10,20,30,60,0 100,100,140,120,63\n";
    let captions =
        "image_id,id,caption,image\n9,1,\"A cat, a \"\"dog\"\"\nand a man\",x.jpg\n9,2,Second,x.jpg\n";
    let zeros = "0.5 0.25 1 ".repeat(17);
    let joints = format!("val2017\t9\t0 0.1 0.1 0.1 0.1 {}\n", zeros.trim());
    let sizes = r#"{"images":[{"id":9,"width":200,"height":400}],"annotations":[]}"#;
    let found = photos(&[("j", &joints), ("b", boxes), ("c", captions), ("s", sizes)]);
    let photo = &found[0];
    assert!(photo.complete && photo.things[0].category == "laptop");
    assert_eq!(photo.captions, ["A cat, a \"dog\"\nand a man", "Second"]);
    assert_eq!(photo.people.len(), 1, "the box in pixels and the share of the photo are one person");
    let nose = photo.people[0].joints[0];
    assert_eq!((nose.pixel, nose.confidence), (Vec2::new(100.0, 100.0), 0.5));
}

#[test]
fn people_whose_photo_has_no_size_are_counted_and_left_out() {
    let joints = format!("val2017\t9\t0 0.1 0.1 0.1 0.1 {}\n", "0 0 0 ".repeat(17).trim());
    let mut set = PhotoSet::default();
    set.add_bytes("joints", joints.as_bytes()).expect("sound");
    let found = set.finish();
    assert_eq!((found.photos.len(), found.people_without_size), (0, 1));
}

#[test]
fn lists_of_people_carry_their_things_and_verbs() {
    let joints = (0..17).map(|i| format!("[{i},5,{}]", i % 3)).collect::<Vec<_>>().join(",");
    let text = format!(
        r#"[{{"image_id":3,"width":100,"height":80,"bbox_xyxy":[0,0,50,80],"keypoints":[{joints}],
            "objects":[{{"category":"book","bbox_xyxy":[20,20,30,30],"roles":["read obj","hold obj"]}}]}}]"#
    );
    let photo = &photos(&[("p", &text)])[0];
    assert!(!photo.complete, "only what somebody uses is marked");
    assert_eq!(photo.people[0].marked(), 11);
    assert!(photo.people[0].does("read obj") && photo.people[0].does("hold obj"));
}

#[test]
fn label_me_files_give_things_outlines_and_the_joints_of_groups() {
    let text = r#"{"imagePath":"kitchen.jpg","imageWidth":300,"imageHeight":200,"flags":{"prepare food":true,"blurred":false},
        "shapes":[{"label":"person","points":[[10,10],[60,150]],"shape_type":"rectangle","group_id":1},
          {"label":"left_shoulder","points":[[40,40]],"shape_type":"point","group_id":1},
          {"label":"Cup#2","points":[[0,0],[10,0],[0,10]],"shape_type":"polygon"}]}"#;
    let photo = &photos(&[("k.json", text)])[0];
    assert_eq!(
        (photo.key.as_str(), photo.captions.as_slice()),
        ("kitchen", &["prepare food".to_owned()][..])
    );
    assert_eq!(photo.people[0].joint(5), Some(Vec2::new(40.0, 40.0)));
    assert_eq!(photo.things[0].category, "cup");
    assert!((photo.things[0].center() - Vec2::splat(10.0 / 3.0)).length() < 1e-4);
}

#[test]
fn damaged_files_are_refused_with_their_place() {
    for (text, says) in [
        ("", "byte 0"),
        ("{\"a\":1}", "annotations"),
        ("[{\"image_id\":1}]", "line 1"),
        ("hello", "neither"),
        ("a.jpg 1,2,3,4,5 1,2,3,4,99", "class 99"),
        ("a.jpg 1,2,3,4,5 9,2,3,4,5", "no box"),
        ("a.jpg 1,2,3,4,5 x,2,3,4,5", "five numbers"),
        (
            r#"{"classes":[],"objects":[],"annotations":[{"file_name":"a","boxes_h":[[0,0,1,1]],"boxes_o":[[0,0,1,1]],"actions":[5],"objects":[0]}]}"#,
            "annotations[0].actions[0]",
        ),
        (
            r#"{"classes":[],"objects":[],"annotations":[{"file_name":"a","boxes_h":[],"boxes_o":[],"actions":[5],"objects":[0]}]}"#,
            "1 actions",
        ),
        (r#"{"annotations":[{"image_id":1,"category_id":4,"bbox":[0,0,1,1]}]}"#, "category 4"),
        (r#"{"annotations":[{"image_id":1,"bbox":[0,0,-1,1]}]}"#, "annotations[0].bbox"),
        (r#"{"annotations":[{"image_id":1,"bbox":[0,0,1,1],"keypoints":[1,2]}]}"#, "keypoints"),
        (r#"{"annotations":[{"image_id":1,"bbox":[0,0,1e30,1]}]}"#, "no box"),
    ] {
        let message = refusal(text);
        assert!(message.starts_with("file, ") && message.contains(says), "{message} for {text}");
    }
    let mut set = PhotoSet::default();
    assert!(set.add_bytes("gz", &[0x1f, 0x8b, 8, 0, 0]).is_err());
    assert!(set.add_bytes("binary", &[0xff, 0xfe, 0]).is_err());
}

#[test]
fn photos_are_known_by_number_or_name() {
    for (name, key) in [
        ("COCO_val2014_000000203564.jpg", "203564"),
        ("000000000165.jpg", "165"),
        ("photos/kitchen 3.jpeg", "kitchen 3"),
        ("IMG_2041.jpg", "IMG_2041"),
    ] {
        assert_eq!(key_of_name(name), key);
    }
}

#[test]
fn boxes_measure_overlap_and_gap() {
    let square = |x: f32| PixelBox { min: Vec2::new(x, 0.0), max: Vec2::new(x + 2.0, 2.0) };
    assert!((square(0.0).overlap(&square(1.0)) - 1.0 / 3.0).abs() < 1e-6);
    assert_eq!((square(0.0).gap(&square(5.0)), square(0.0).gap(&square(1.0))), (3.0, 0.0));
    assert_eq!(PixelBox::default().overlap(&PixelBox::default()), 0.0);
}
