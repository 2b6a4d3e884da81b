//! Guesses a category from a name. The words are data (`words.txt`); here is only how names are taken apart.

use std::collections::HashMap;
use std::sync::LazyLock;

use crate::scene::Category;

/// Phrases as words, with what they mean.
static PHRASES: LazyLock<HashMap<Vec<String>, Category>> = LazyLock::new(|| {
    let lines = include_str!("words.txt").lines().filter(|line| !line.starts_with('#'));
    let mut phrases = HashMap::new();
    for (label, words) in lines.filter_map(|line| line.split_once(':')) {
        let Some(category) = Category::from_label(label.trim()) else { continue };
        for phrase in words.split(',') {
            phrases.insert(phrase.split_whitespace().map(str::to_string).collect(), category);
        }
    }
    phrases
});

/// Words in the file's longest phrase.
const MAX_PHRASE_WORDS: usize = 5;

/// Ends of compound words (`Gartenstuhl`, `sidechair`) that may be taken as the word itself.
const COMPOUND_ENDS: [&str; 22] = [
    "stuhl", "tisch", "sessel", "schrank", "bett", "lampe", "leuchte", "regal", "teppich", "fenster", "sofa",
    "hocker", "kissen", "chair", "table", "lamp", "desk", "shelf", "stool", "couch", "spiegel", "vorhang",
];

/// Words behind which only the purpose follows: the thing was named before them.
const LINKS: [&str; 12] = ["de", "da", "di", "del", "du", "des", "of", "for", "with", "mit", "fur", "von"];

/// Words that make a name a group's or a room's, not a thing's.
const PLACES: [&str; 16] = [
    "room",
    "rooms",
    "bedroom",
    "bathroom",
    "kitchen",
    "livingroom",
    "wohnzimmer",
    "schlafzimmer",
    "zimmer",
    "scene",
    "group",
    "set",
    "collection",
    "salon",
    "cuisine",
    "house",
];

/// What a thing called `name` is, if any of its words says so.
pub fn category(name: &str) -> Option<Category> {
    let words = words(name);
    let matches = matches(&words);
    let link = words.iter().position(|w| LINKS.contains(&w.as_str()));
    let before_link = link.and_then(|link| matches.iter().rev().find(|m| m.0 < link));
    before_link.or(matches.last()).map(|m| m.1)
}

/// Whether `name` names one piece of furniture and not a place or a group of things.
pub fn names_one_thing(name: &str) -> bool {
    let words = words(name);
    category(name).is_some_and(|c| !c.is_structure()) && !words.iter().any(|w| PLACES.contains(&w.as_str()))
}

/// The longest phrases from left to right: where each starts and what it means.
fn matches(words: &[String]) -> Vec<(usize, Category)> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < words.len() {
        let longest = (1..=MAX_PHRASE_WORDS.min(words.len() - at)).rev();
        let hit = longest.filter_map(|n| Some((n, phrase(&words[at..at + n])?))).next();
        if let Some((_, category)) = hit {
            found.push((at, category));
        }
        at += hit.map_or(1, |(n, _)| n);
    }
    found
}

/// What a run of words means: as it is, without a plural ending, or as a compound.
fn phrase(words: &[String]) -> Option<Category> {
    if let Some(&category) = PHRASES.get(words) {
        return Some(category);
    }
    let (last, before) = words.split_last()?;
    let singulars = ["s", "es", "n", "en"].into_iter().filter_map(|ending| last.strip_suffix(ending));
    for singular in singulars.filter(|s| s.len() > 2) {
        let words: Vec<String> = before.iter().cloned().chain([singular.to_string()]).collect();
        if let Some(&category) = PHRASES.get(&words) {
            return Some(category);
        }
    }
    let end = COMPOUND_ENDS
        .iter()
        .find(|end| before.is_empty() && last.len() > end.len() && last.ends_with(**end))?;
    PHRASES.get(&vec![(*end).to_string()]).copied()
}

/// Lower-case words of a name in any of the usual spellings: `DiningChair_02`, `dining-chair.001`.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut previous = ' ';
    let mut letters = name.chars().peekable();
    while let Some(c) = letters.next() {
        let next_is_lower = letters.peek().is_some_and(|n| n.is_lowercase());
        let new_hump =
            c.is_uppercase() && (previous.is_lowercase() || (previous.is_uppercase() && next_is_lower));
        if !c.is_alphabetic() || new_hump {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| c.is_alphabetic()) {
            word.extend(c.to_lowercase().map(without_accent));
        }
        previous = c;
    }
    words.retain(|w| !w.is_empty());
    words
}

fn without_accent(c: char) -> char {
    match c {
        'ä' | 'à' | 'á' | 'â' | 'ã' | 'å' => 'a',
        'é' | 'è' | 'ê' | 'ë' => 'e',
        'í' | 'ì' | 'î' | 'ï' => 'i',
        'ö' | 'ó' | 'ò' | 'ô' | 'õ' => 'o',
        'ü' | 'ú' | 'ù' | 'û' => 'u',
        'ç' => 'c',
        'ñ' => 'n',
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_are_known_by_their_names_in_five_languages_and_any_spelling() {
        let cases = [
            ("DiningChair_02", "chair"),
            ("coffee-table.001", "coffee table"),
            ("SM_KitchenIsland_A", "kitchen island"),
            ("Mesh047_Sofa_37", "couch"),
            ("SofaLegs", "couch"),
            ("couch pillows", "cushion"),
            ("Bürostuhl", "chair"),
            ("Gartenstuhl 3", "chair"),
            ("Kleiderschrank", "cabinet"),
            ("Schreibtisch", "office desk"),
            ("chaise de bureau", "chair"),
            ("table basse", "coffee table"),
            ("tavolo da pranzo", "dining table"),
            ("lampada da tavolo", "lighting"),
            ("mesita de noche", "table"),
            ("espejo", "mirror"),
            ("FloorLamp", "lighting"),
            ("TV_Stand", "cabinet"),
            ("TVStand", "cabinet"),
            ("wall_12", "wall"),
            ("curtains", "curtain"),
            ("Ceiling", "ceiling"),
            ("shelves", "shelving"),
        ];
        for (name, label) in cases {
            assert_eq!(category(name).map(Category::label), Some(label), "{name}");
        }
        for name in ["Object_12", "Cube.003", "", "Mesh_0", "Untitled"] {
            assert_eq!(category(name), None, "{name}");
        }
    }

    #[test]
    fn rooms_and_groups_are_not_things() {
        for name in ["Dining Room", "Bed Room", "chair group", "walls", "Living_Room_Furniture"] {
            assert!(!names_one_thing(name), "{name}");
        }
        assert!(names_one_thing("sofa"));
    }

    #[test]
    fn every_line_of_the_catalogue_names_a_category() {
        for line in include_str!("words.txt").lines().filter(|l| !l.starts_with('#')) {
            let (label, _) = line.split_once(':').unwrap();
            assert!(Category::from_label(label).is_some(), "{label}");
        }
    }
}
