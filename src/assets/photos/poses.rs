//! Joints as tab-separated text, one person a line: split, image number, then `class cx cy w h` and 17 times
//! `x y visibility`, places as shares of the photo's width and height.

use glam::Vec2;

use super::super::budget::Budget;
use super::{
    Fault, MAX_PEOPLE, PHOTO_JOINTS, PhotoSet, ShareOfPhoto, checked_box, checked_joints, key_of_number,
};

/// Numbers of a person: class, box, joints.
const NUMBERS: usize = 1 + 4 + 3 * PHOTO_JOINTS;

/// Whether a line is a person.
pub(super) fn is_row(line: &str) -> bool {
    let mut columns = line.split('\t').skip(1);
    columns.next().is_some_and(|id| id.parse::<u64>().is_ok())
        && columns.next().is_some_and(|numbers| numbers.split(' ').count() == NUMBERS)
}

pub(super) fn add(set: &mut PhotoSet, text: &str) -> Result<(), Fault> {
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.is_empty()) {
        let place = format!("line {}", index + 1);
        Budget::check(&place, "people", set.waiting.len() as u64, MAX_PEOPLE as u64)?;
        let person = person_of(line, &place)?;
        set.waiting.push(person);
    }
    Ok(())
}

fn person_of(line: &str, place: &str) -> Result<ShareOfPhoto, Fault> {
    let mut columns = line.split('\t').skip(1);
    let id = columns.next().and_then(|id| id.parse().ok());
    let id = id.ok_or_else(|| Fault::malformed(place, "the second column is no image number"))?;
    let mut numbers = [0.0_f32; NUMBERS];
    let mut words = columns.next().unwrap_or_default().split(' ');
    for number in &mut numbers {
        let word = words.next().and_then(|word| word.parse().ok());
        *number = word
            .ok_or_else(|| Fault::malformed(place, format!("the third column is not {NUMBERS} numbers")))?;
    }
    let [_, x, y, width, height, ..] = numbers;
    let (center, half) = (Vec2::new(x, y), Vec2::new(width, height) * 0.5);
    let bounds = checked_box(place, center - half, center + half)?;
    let joints = checked_joints(place, &numbers[5..])?;
    Ok(ShareOfPhoto { key: key_of_number(id), bounds, joints })
}
