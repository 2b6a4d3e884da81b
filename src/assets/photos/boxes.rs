//! Boxes as text, one photo a line: its path, then `left,top,right,bottom,class` for each thing in it; the class is a
//! number among COCO's 80.

use glam::Vec2;

use super::coco::PERSON;
use super::{Fault, PhotoSet, PhotoThing, checked_box, key_of_name};

/// COCO's 80 categories in the order that detectors number them.
pub(super) const COCO_NAMES: [&str; 80] = [
    "person",
    "bicycle",
    "car",
    "motorcycle",
    "airplane",
    "bus",
    "train",
    "truck",
    "boat",
    "traffic light",
    "fire hydrant",
    "stop sign",
    "parking meter",
    "bench",
    "bird",
    "cat",
    "dog",
    "horse",
    "sheep",
    "cow",
    "elephant",
    "bear",
    "zebra",
    "giraffe",
    "backpack",
    "umbrella",
    "handbag",
    "tie",
    "suitcase",
    "frisbee",
    "skis",
    "snowboard",
    "sports ball",
    "kite",
    "baseball bat",
    "baseball glove",
    "skateboard",
    "surfboard",
    "tennis racket",
    "bottle",
    "wine glass",
    "cup",
    "fork",
    "knife",
    "spoon",
    "bowl",
    "banana",
    "apple",
    "sandwich",
    "orange",
    "broccoli",
    "carrot",
    "hot dog",
    "pizza",
    "donut",
    "cake",
    "chair",
    "couch",
    "potted plant",
    "bed",
    "dining table",
    "toilet",
    "tv",
    "laptop",
    "mouse",
    "remote",
    "keyboard",
    "cell phone",
    "microwave",
    "oven",
    "toaster",
    "sink",
    "refrigerator",
    "book",
    "clock",
    "vase",
    "scissors",
    "teddy bear",
    "hair drier",
    "toothbrush",
];

/// Numbers of one thing.
const NUMBERS: usize = 5;

/// Whether a line is a path and boxes.
pub(super) fn is_row(line: &str) -> bool {
    let mut words = line.split_whitespace();
    let path = words.next().is_some_and(|word| word.contains('.'));
    path && words.clone().next().is_some() && words.all(|word| word.split(',').count() == NUMBERS)
}

pub(super) fn add(set: &mut PhotoSet, text: &str) -> Result<(), Fault> {
    for (index, line) in text.lines().enumerate() {
        let place = format!("line {}", index + 1);
        let mut words = line.split_whitespace();
        let Some(path) = words.next() else { continue };
        let key = key_of_name(path);
        set.photo(&key)?.complete = true;
        for word in words {
            add_box(set, &key, word, &place)?;
        }
    }
    Ok(())
}

fn add_box(set: &mut PhotoSet, key: &str, word: &str, place: &str) -> Result<(), Fault> {
    let numbers: Vec<f32> = word.split(',').map_while(|n| n.parse().ok()).collect();
    let [left, top, right, bottom, class] = numbers[..] else {
        let what = format!("\"{}\" is not five numbers", word.chars().take(60).collect::<String>());
        return Err(Fault::malformed(place, what));
    };
    let bounds = checked_box(place, Vec2::new(left, top), Vec2::new(right, bottom))?;
    let name = (class >= 0.0 && class.fract() == 0.0).then(|| COCO_NAMES.get(class as usize)).flatten();
    let Some(name) = name else {
        return Err(Fault::out_of_range(place, "class", class.max(0.0) as usize, COCO_NAMES.len()));
    };
    if *name == PERSON {
        set.count_person()?;
        set.photo(key)?.person_in(bounds);
        return Ok(());
    }
    let category = (*name).to_owned();
    set.put_thing(key, PhotoThing { category, bounds, outline: Vec::new() }).map(|_| ())
}
