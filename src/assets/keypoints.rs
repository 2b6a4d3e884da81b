//! People's keypoints in pictures: COCO json (annotations and results) and OpenPose json (BODY_25).

use std::collections::BTreeMap;
use std::path::Path;

use glam::Vec2;
use serde::Deserialize;
use serde_json::Value;

use super::budget::Budget;
use super::error::{AssetError, Fault, Problem};
use super::uri::read_plain_file;

/// Most people that a keypoint file may hold: twice all of COCO.
const MAX_PEOPLE: usize = 600_000;
/// Most bytes of a keypoint file: twice COCO's largest.
const MAX_BYTES: u64 = 512 << 20;
/// Farthest from the origin that a keypoint may lie: beyond every picture, pixels.
const FARTHEST_PX: f32 = 1e6;
/// Confidence of a COCO keypoint that is annotated though something hides it.
const HIDDEN: f32 = 0.5;

/// Which points of a person a keypoint file lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub enum KeypointSet {
    /// COCO's 17: nose, eyes, ears, shoulders, elbows, wrists, hips, knees, ankles; left before right.
    Coco17,
    /// OpenPose's 25: as COCO's, with neck, middle of the hips and three points a foot; right before left.
    Body25,
}

impl KeypointSet {
    /// How many points.
    pub fn len(self) -> usize {
        match self {
            Self::Coco17 => 17,
            Self::Body25 => 25,
        }
    }

    /// Never.
    pub fn is_empty(self) -> bool {
        false
    }
}

/// One point of a person in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Keypoint {
    /// Column and row in pixels from the top left corner.
    pub pixel: Vec2,
    /// 0 where nothing was found, to 1.
    pub confidence: f32,
}

/// One person in a picture.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PersonKeypoints {
    /// What the points are.
    pub set: KeypointSet,
    /// In the set's order.
    pub points: Vec<Keypoint>,
}

impl PersonKeypoints {
    /// Sum of the confidences: how much is known of this person.
    pub fn known(&self) -> f32 {
        self.points.iter().map(|p| p.confidence).sum()
    }
}

/// A picture of a keypoint file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureKeypoints {
    /// The file's name for it; `None` where the format has none (OpenPose writes one file a picture).
    pub name: Option<String>,
    /// Columns and rows, where the file says.
    pub size: Option<(u32, u32)>,
    /// Everybody in it with at least one point, in the file's order.
    pub people: Vec<PersonKeypoints>,
}

/// Reads keypoints from a file: COCO annotations or results (also AlphaPose's), or OpenPose's BODY_25. Pictures
/// without people are left out.
///
/// # Errors
/// Names the file, the place in it, what is wrong and what to do.
pub fn read_keypoints(path: &Path, budget: &Budget) -> Result<Vec<PictureKeypoints>, AssetError> {
    let shown = path.display().to_string();
    read_plain_file(path, budget).and_then(|bytes| read(&bytes)).map_err(|f| f.in_file(&shown))
}

/// Reads keypoints from memory, as [`read_keypoints`] does.
///
/// # Errors
/// As [`read_keypoints`]; `name` stands for the file.
pub fn read_keypoints_bytes(name: &str, bytes: &[u8]) -> Result<Vec<PictureKeypoints>, AssetError> {
    read(bytes).map_err(|fault| fault.in_file(name))
}

#[derive(Deserialize)]
struct CocoFile {
    #[serde(default)]
    images: Vec<CocoImage>,
    annotations: Vec<CocoPerson>,
}

#[derive(Deserialize)]
struct CocoImage {
    id: Value,
    #[serde(default)]
    file_name: Option<String>,
    #[serde(default)]
    width: Option<u32>,
    #[serde(default)]
    height: Option<u32>,
}

#[derive(Deserialize)]
struct CocoPerson {
    image_id: Value,
    #[serde(default)]
    keypoints: Vec<f32>,
}

#[derive(Deserialize)]
struct OpenPoseFile {
    people: Vec<OpenPosePerson>,
}

#[derive(Deserialize)]
struct OpenPosePerson {
    pose_keypoints_2d: Vec<f32>,
}

fn read(bytes: &[u8]) -> Result<Vec<PictureKeypoints>, Fault> {
    Budget::check("the file itself", "bytes", bytes.len() as u64, MAX_BYTES)?;
    let pictures = match first_mark(bytes) {
        Some(b'[') => results(parse(bytes)?)?,
        Some(b'{') => match marks(bytes)? {
            (true, _) => open_pose(parse(bytes)?)?,
            (_, true) => annotations(parse(bytes)?)?,
            _ => {
                return Err(unsupported(
                    "neither \"annotations\" (COCO) nor \"people\" (OpenPose) at the top".into(),
                ));
            }
        },
        _ => return Err(unsupported("no JSON object or list".into())),
    };
    Ok(pictures.into_iter().filter(|p| !p.people.is_empty()).collect())
}

fn first_mark(bytes: &[u8]) -> Option<u8> {
    bytes.trim_ascii_start().first().copied()
}

/// Whether the top object has `people` and `annotations`, without building either.
fn marks(bytes: &[u8]) -> Result<(bool, bool), Fault> {
    #[derive(Deserialize)]
    struct Top {
        people: Option<serde::de::IgnoredAny>,
        annotations: Option<serde::de::IgnoredAny>,
    }
    let top: Top = parse(bytes)?;
    Ok((top.people.is_some(), top.annotations.is_some()))
}

fn parse<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, Fault> {
    serde_json::from_slice(bytes).map_err(|error| {
        let place = format!("line {}, column {}", error.line(), error.column());
        Fault::malformed(place, error.to_string())
    })
}

fn unsupported(feature: String) -> Fault {
    let remedy = "COCO keypoint json and OpenPose's BODY_25 json are read.";
    Fault::new("the whole file", Problem::Unsupported { feature, remedy })
}

/// COCO's annotation file: visibility 0 (not there), 1 (hidden), 2 (seen) beside each point.
fn annotations(file: CocoFile) -> Result<Vec<PictureKeypoints>, Fault> {
    let mut pictures = Pictures::default();
    for image in file.images {
        let size = image.width.zip(image.height);
        pictures.add(key(&image.id), PictureKeypoints { name: image.file_name, size, people: Vec::new() });
    }
    let seen = |visibility: f32| match visibility {
        v if v >= 2.0 => 1.0,
        v if v >= 1.0 => HIDDEN,
        _ => 0.0,
    };
    for (index, person) in file.annotations.into_iter().enumerate() {
        // Boxes and captions share the list with people in many files.
        if !person.keypoints.is_empty() {
            let place = format!("annotations[{index}].keypoints");
            let person_keypoints = person_of(&place, KeypointSet::Coco17, &person.keypoints, &seen)?;
            pictures.put(&person.image_id, person_keypoints)?;
        }
    }
    Ok(pictures.list)
}

/// COCO's result list: a score beside each point.
fn results(list: Vec<CocoPerson>) -> Result<Vec<PictureKeypoints>, Fault> {
    let mut pictures = Pictures::default();
    for (index, person) in list.into_iter().enumerate() {
        let place = format!("[{index}].keypoints");
        let keypoints = person_of(&place, KeypointSet::Coco17, &person.keypoints, &|score| score)?;
        pictures.put(&person.image_id, keypoints)?;
    }
    Ok(pictures.list)
}

fn open_pose(file: OpenPoseFile) -> Result<Vec<PictureKeypoints>, Fault> {
    Budget::check("people", "people", file.people.len() as u64, MAX_PEOPLE as u64)?;
    let person = |(index, person): (usize, OpenPosePerson)| {
        let place = format!("people[{index}].pose_keypoints_2d");
        person_of(&place, KeypointSet::Body25, &person.pose_keypoints_2d, &|score| score)
    };
    let people = file.people.into_iter().enumerate().map(person).collect::<Result<Vec<_>, _>>()?;
    let known = people.into_iter().filter(|p| p.known() > 0.0).collect();
    Ok(vec![PictureKeypoints { name: None, size: None, people: known }])
}

/// Pictures by their number or name in the file, in the order of their first mention.
#[derive(Default)]
struct Pictures {
    list: Vec<PictureKeypoints>,
    by_key: BTreeMap<String, usize>,
    people: usize,
}

impl Pictures {
    fn add(&mut self, key: String, picture: PictureKeypoints) {
        self.by_key.insert(key, self.list.len());
        self.list.push(picture);
    }

    fn put(&mut self, image: &Value, person: PersonKeypoints) -> Result<(), Fault> {
        self.people += 1;
        Budget::check("annotations", "people", self.people as u64, MAX_PEOPLE as u64)?;
        let key = key(image);
        if !self.by_key.contains_key(&key) {
            let name = Some(key.clone());
            self.add(key.clone(), PictureKeypoints { name, ..PictureKeypoints::default() });
        }
        if person.known() > 0.0 {
            self.list[self.by_key[&key]].people.push(person);
        }
        Ok(())
    }
}

/// Numbers and texts name pictures alike.
fn key(id: &Value) -> String {
    id.as_str().map_or_else(|| id.to_string(), str::to_owned)
}

fn person_of(
    place: &str,
    set: KeypointSet,
    numbers: &[f32],
    confidence: &dyn Fn(f32) -> f32,
) -> Result<PersonKeypoints, Fault> {
    if numbers.len() != 3 * set.len() {
        return Err(Fault::new(
            place,
            Problem::Unsupported {
                feature: format!(
                    "{} numbers a person where {} are needed (x, y, score for {} points)",
                    numbers.len(),
                    3 * set.len(),
                    set.len()
                ),
                remedy: "Write COCO's 17 or OpenPose's 25 body points (--model_pose BODY_25).",
            },
        ));
    }
    let point = |(index, n): (usize, &[f32])| {
        let pixel = Vec2::new(n[0], n[1]);
        if !pixel.is_finite() || pixel.abs().max_element() > FARTHEST_PX || !n[2].is_finite() {
            let what = format!("({}, {}, {}) is no point of a picture", n[0], n[1], n[2]);
            return Err(Fault::malformed(format!("{place}[{}]", 3 * index), what));
        }
        Ok(Keypoint { pixel, confidence: confidence(n[2]).clamp(0.0, 1.0) })
    };
    let points = numbers.chunks_exact(3).enumerate().map(point).collect::<Result<Vec<_>, _>>()?;
    Ok(PersonKeypoints { set, points })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(points: usize, third: f32) -> String {
        (0..points).map(|i| format!("{i}.5,{},{third}", 2 * i)).collect::<Vec<_>>().join(",")
    }

    fn error(text: &str) -> String {
        read_keypoints_bytes("photo.json", text.as_bytes()).expect_err("must refuse").to_string()
    }

    #[test]
    fn coco_annotations_are_read_by_picture_with_hidden_points_trusted_less() {
        let text = format!(
            r#"{{"images":[{{"id":7,"file_name":"a.jpg","width":640,"height":480}},{{"id":8,"file_name":"empty.jpg"}}],
                "annotations":[{{"image_id":7,"keypoints":[{}]}},{{"image_id":7,"bbox":[1,2,3,4]}},
                               {{"image_id":7,"keypoints":[{}]}},{{"image_id":7,"keypoints":[{}]}}]}}"#,
            numbers(17, 2.0),
            numbers(17, 1.0),
            numbers(17, 0.0)
        );
        let pictures = read_keypoints_bytes("photo.json", text.as_bytes()).expect("sound");
        assert_eq!(pictures.len(), 1, "a picture without people is left out");
        assert_eq!((pictures[0].name.as_deref(), pictures[0].size), (Some("a.jpg"), Some((640, 480))));
        let people = &pictures[0].people;
        assert_eq!(people.len(), 2, "a person without any point is nobody");
        assert_eq!(people[0].points[3], Keypoint { pixel: Vec2::new(3.5, 6.0), confidence: 1.0 });
        assert_eq!(people[1].points[3].confidence, HIDDEN);
    }

    #[test]
    fn results_and_open_pose_files_keep_their_scores() {
        let text = format!(r#"[{{"image_id":"b.jpg","score":3.1,"keypoints":[{}]}}]"#, numbers(17, 0.25));
        let pictures = read_keypoints_bytes("photo.json", text.as_bytes()).expect("sound");
        assert_eq!(pictures[0].name.as_deref(), Some("b.jpg"));
        assert_eq!(pictures[0].people[0].points[0].confidence, 0.25);
        let text = format!(
            r#" {{"version":1.3,"people":[{{"person_id":[-1],"pose_keypoints_2d":[{}],"face_keypoints_2d":[]}}]}}"#,
            numbers(25, 0.75)
        );
        let pictures = read_keypoints_bytes("photo.json", text.as_bytes()).expect("sound");
        assert_eq!(pictures[0].people[0].set, KeypointSet::Body25);
        assert_eq!(pictures[0].people[0].points[24].pixel, Vec2::new(24.5, 48.0));
    }

    #[test]
    fn broken_files_are_refused_with_file_and_place() {
        for (text, says) in [
            (r#"{"people":[{"pose_keypoints_2d":[1,2]}]}"#.to_owned(), "people[0].pose_keypoints_2d"),
            (format!(r#"{{"people":[{{"pose_keypoints_2d":[{}]}}]}}"#, numbers(18, 1.0)), "BODY_25"),
            (
                format!(r#"[{{"image_id":1,"keypoints":[{}]}}]"#, numbers(17, 1.0).replace("3.5", "9e9")),
                "[0].keypoints[9]",
            ),
            (r#"{"annotations":[{"image_id":1,"keypoints":["x"]}]}"#.to_owned(), "line 1, column"),
            (r#"{"photos":[]}"#.to_owned(), "annotations"),
            (r#"{"people":[{"pose_keypoints_2d":["#.to_owned(), "line 1"),
            ("PNG".to_owned(), "JSON"),
            (String::new(), "JSON"),
            ("[".repeat(100_000), "line 1"),
        ] {
            let message = error(&text);
            assert!(message.starts_with("photo.json, ") && message.contains(says), "{message} for {says}");
        }
    }
}
