//! `inhabit move`, `inhabit evolve` and `inhabit learn actions` as people run them, on tiny input: what they write, that
//! what is asked for is kept, and that the same seed gives the same bytes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use inhabit::document::load_project;
use inhabit::evolve::action::ActionModel;
use serde_json::{Value, json};

fn inhabit(arguments: &[&str], out: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inhabit"));
    command.args(arguments).arg("--out").arg(out).arg("--quiet");
    command.output().expect("runs")
}

/// The program's word on how it went, for a failed assertion.
fn said(output: &Output) -> String {
    format!("{}: {}", output.status, String::from_utf8_lossy(&output.stderr))
}

/// Whether a run ended by itself, with or without findings.
fn is_done(output: &Output) -> bool {
    matches!(output.status.code(), Some(0 | 3))
}

fn read_json(file: &Path) -> Value {
    let text = fs::read(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    serde_json::from_slice(&text).expect("json")
}

/// Names of the channels' targets in a GLB's animations.
fn animated(file: &Path) -> Vec<String> {
    let bytes = fs::read(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let glb = gltf::Gltf::from_slice(&bytes).expect("a GLB");
    let names = glb.animations().flat_map(|animation| {
        let of_nodes = animation.channels().map(|c| c.target().node().name().unwrap_or_default().to_owned());
        of_nodes.collect::<Vec<_>>()
    });
    names.collect()
}

#[test]
fn a_walk_is_written_in_every_format_and_the_same_on_one_thread_and_on_two() {
    let folder = tempfile::tempdir().expect("a folder");
    let goals = folder.path().join("goals.ron");
    fs::write(
        &goals,
        "[(at: (-0.4, 0.0, 0.6), pose: Stand), (at: (0.6, 0.0, 0.9), pose: Stand, stay_s: 0.5)]",
    )
    .expect("written");
    let walk = |threads: &str| {
        let out = folder.path().join(threads);
        let goals = goals.display().to_string();
        let arguments = ["move", "sample:bedroom", "--goals", &goals, "--no-pictures", "--threads", threads];
        let output = inhabit(&arguments, &out);
        assert!(is_done(&output), "{}", said(&output));
        out
    };
    let (one, two) = (walk("1"), walk("2"));
    for file in ["clip.glb", "clip.bvh", "clip.npz", "project.ron", "motions.npz"] {
        let bytes = |root: &Path| fs::read(root.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert!(bytes(&one) == bytes(&two), "{file} depends on the number of threads");
    }
    let clip = &load_project(&one.join("project.ron")).expect("opens").project.scene.clips[0];
    assert_eq!((clip.name.as_str(), clip.seed), ("Motion 1", 0));
    let report = read_json(&one.join("report.json"));
    let wanted: Vec<&Value> = report["clips"][0]["goals"]
        .as_array()
        .expect("goals")
        .iter()
        .filter(|g| g["planned"] == false)
        .collect();
    assert_eq!(wanted.len(), 2, "{wanted:?}");
    assert!(report["clips"][0]["complaints"].as_array().is_some_and(Vec::is_empty), "{report}");
    let last = clip.frames.last().expect("frames").translation;
    let first = clip.frames[0].translation;
    assert!((last - first).length() > 0.9, "from {first} to {last}");
    assert!(animated(&one.join("clip.glb")).len() > 20, "every joint moves");
}

#[test]
fn actions_leave_what_is_locked_bring_nothing_that_is_banned_and_say_what_they_did() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let lived = ["evolve", "sample:office", "--actions", "3", "--seed", "1", "--no-people", "--no-pictures"];
    let output = inhabit(&[&lived[..], &["--lock", "Office chair 1", "--ban", "laptop"]].concat(), &out);
    assert!(is_done(&output), "{}", said(&output));
    let report = read_json(&out.join("report.json"));
    let steps = report["steps"].as_array().expect("steps");
    assert_eq!(steps.len(), 3);
    assert!((0..=3).all(|step| out.join(format!("steps/{step:03}.glb")).is_file()));
    let rows =
        |key: &str| steps.iter().flat_map(|s| s[key].as_array().expect("rows").clone()).collect::<Vec<_>>();
    assert!(rows("moved").iter().all(|moved| moved["object"] != "Office chair 1"));
    let brought = rows("inserted");
    assert!(!brought.is_empty() && brought.iter().all(|thing| thing["kind"] != "laptop"), "{brought:?}");
    let project = load_project(&out.join("project.ron")).expect("opens").project;
    let names: Vec<&str> = project.scene.room.objects.iter().map(|o| o.name.as_str()).collect();
    for thing in &brought {
        let name = thing["object"].as_str().expect("a name");
        assert!(names.contains(&name), "{name} is not in the room: {names:?}");
    }
    let refused = inhabit(&["evolve", "sample:office", "--lock", "Throne"], &folder.path().join("refused"));
    assert!(refused.status.code() == Some(1) && said(&refused).contains("Throne"), "{}", said(&refused));
}

#[test]
fn a_day_has_its_action_on_the_timeline_moves_what_comes_and_leaves_what_is_locked() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let day = ["evolve", "sample:office", "--day", "--actions", "1", "--seed", "1", "--no-pictures"];
    let output = inhabit(
        &[&day[..], &["--only", "use laptop", "--lock", "Office chair 1,Office chair 2"]].concat(),
        &out,
    );
    assert!(is_done(&output), "{}", said(&output));
    let told = read_json(&out.join("evolution.json"));
    let moment = &told["moments"][0];
    let seconds = |key: &str| moment[key].as_f64().expect("seconds");
    assert!(moment["action"].as_str().is_some_and(|action| action.starts_with("use laptop")), "{moment}");
    assert!(seconds("changes_s") <= seconds("arrives_s") && seconds("arrives_s") < seconds("leaves_s"));
    assert!(seconds("leaves_s") <= told["seconds"].as_f64().expect("seconds") + 0.1);
    let moved = moment["moved"].as_array().expect("moved");
    assert!(moved.iter().all(|m| !m["object"].as_str().is_some_and(|name| name.starts_with("Office chair"))));
    let targets = animated(&out.join("day.glb"));
    for thing in moment["inserted"].as_array().expect("brought") {
        let name = thing["object"].as_str().expect("a name");
        assert!(targets.contains(&format!("{name} moves")), "{name} does not come: {targets:?}");
    }
    assert!(load_project(&out.join("project.ron")).is_ok_and(|loaded| loaded.project.scene.clips.len() == 1));
}

/// Somebody who sits at a table with a laptop, as COCO marks them: joints as column, row, 2; `[0, 0, 0]` unmarked.
fn sitting() -> Vec<f64> {
    let marked = [
        [320.0, 120.0],
        [328.0, 112.0],
        [312.0, 112.0],
        [338.0, 116.0],
        [302.0, 116.0],
        [362.0, 170.0],
        [278.0, 170.0],
        [380.0, 235.0],
        [260.0, 235.0],
        [352.0, 275.0],
        [288.0, 275.0],
        [346.0, 300.0],
        [294.0, 300.0],
    ];
    let legs = [[0.0; 3]; 4];
    marked.iter().map(|[x, y]| [*x, *y, 2.0]).chain(legs).flatten().collect()
}

/// Twelve photos of somebody with a laptop, one of them too small, and three of something else.
fn photos() -> Value {
    let (mut images, mut captions, mut annotations) = (Vec::new(), Vec::new(), Vec::new());
    for id in 0..15 {
        images.push(json!({ "id": id, "width": 640, "height": 480 }));
        let caption = if id < 12 { "A man using a laptop on a desk." } else { "A dog runs on a beach." };
        captions.push(json!({ "image_id": id, "caption": caption }));
        let boxed = |category: u32, bounds: [f64; 4]| json!({ "image_id": id, "category_id": category, "bbox": bounds, "iscrowd": 0 });
        let small = id == 11;
        let mut person =
            boxed(1, if small { [310.0, 110.0, 12.0, 20.0] } else { [240.0, 90.0, 160.0, 300.0] });
        person["keypoints"] = json!(sitting());
        annotations.extend([person, boxed(2, [150.0, 260.0, 340.0, 180.0])]);
        annotations.push(boxed(3, [290.0 + f64::from(id), 250.0, 70.0, 60.0]));
    }
    let names = ["person", "dining table", "laptop"];
    let categories: Vec<Value> =
        names.iter().enumerate().map(|(i, name)| json!({ "id": i + 1, "name": name })).collect();
    json!({ "images": images, "annotations": annotations, "captions": captions, "categories": categories })
}

#[test]
fn actions_are_learned_from_photos_with_a_count_after_each_filter_and_a_warning_where_they_are_few() {
    let folder = tempfile::tempdir().expect("a folder");
    let (data, out) = (folder.path().join("photos.json"), folder.path().join("actions.ron"));
    fs::write(&data, photos().to_string()).expect("written");
    let output = inhabit(&["learn", "actions", &data.display().to_string()], &out);
    assert!(output.status.success(), "{}", said(&output));
    let model = ActionModel::from_ron(&fs::read_to_string(&out).expect("written")).expect("a model");
    let labels: Vec<String> = model.nodes.iter().map(|node| node.label()).collect();
    assert!(labels.iter().any(|label| label.starts_with("use laptop")), "{labels:?}");
    let report = read_json(&folder.path().join("actions_report/report.json"));
    let funnel = &report["funnels"]["use laptop"];
    let counts =
        ["said", "found", "with_pose", "instances"].map(|key| funnel[key].as_u64().expect("a count"));
    assert_eq!(counts, [12, 12, 11, 11], "{funnel}");
    let laptop =
        report["nodes"][0]["objects"].as_array().expect("objects").iter().find(|o| o["object"] == "laptop");
    assert!(
        laptop.is_some_and(|o| o["frequency"].as_f64().is_some_and(|f| f > 0.9)),
        "{:?}",
        report["nodes"]
    );
    assert!(report["warnings"].as_array().is_some_and(|w| !w.is_empty()), "eleven photos are few");
    assert!(folder.path().join("actions_report/report.md").is_file());
    let nothing = inhabit(&["learn", "actions", "nowhere.json"], &folder.path().join("other.ron"));
    assert!(
        nothing.status.code() == Some(1) && said(&nothing).contains("nowhere.json"),
        "{}",
        said(&nothing)
    );
}
