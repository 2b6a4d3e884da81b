//! The bundled networks' cards and training curves, read once out of what ships with the program.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use serde_json::Value;

use super::engine::{Curve, NetworkCard};
use crate::assets::Weights;
use crate::body::PoseDecoder;
use crate::generate::learned::LearnedMethod;
use crate::generate::learned::LearnedSampler;
use crate::nn::psi::PsiMethod;

/// Every bundled network.
pub fn cards() -> Arc<[NetworkCard]> {
    static CARDS: OnceLock<Arc<[NetworkCard]>> = OnceLock::new();
    CARDS.get_or_init(|| all().into()).clone()
}

fn all() -> Vec<NetworkCard> {
    let prior = include_str!("../../assets/networks/pose_prior.md");
    let notes = PoseDecoder::bundled_weights().map(|weights| weights.notes).unwrap_or_default();
    let mut cards = vec![card("Pose prior", prior.to_owned(), &notes)];
    for method in LearnedMethod::ALL {
        let Some(file) = LearnedSampler::bundled_file(method) else { continue };
        let label = method.label();
        let notes = Weights::from_bytes(&label, file).map(|weights| weights.notes).unwrap_or_default();
        cards.push(card(name_of(method), text_of(method).to_owned(), &notes));
    }
    cards.extend(MOTION.map(|(name, text, csv)| of_table(name, text, csv)));
    cards.extend(MEASURED.map(|(name, text)| of_table(name, text, "")));
    cards
}

/// The networks of motion: card and curves as they ship beside the weights.
const MOTION: [(&str, &str, &str); 3] = [
    (
        "RouteNet",
        include_str!("../../assets/networks/motion_route.md"),
        include_str!("../../assets/networks/motion_route.csv"),
    ),
    (
        "PoseNet",
        include_str!("../../assets/networks/motion_pose.md"),
        include_str!("../../assets/networks/motion_pose.csv"),
    ),
    (
        "Sub-goal bodies",
        include_str!("../../assets/networks/motion_subgoal.md"),
        include_str!("../../assets/networks/motion_subgoal.csv"),
    ),
];

/// What was measured of them, beside the papers' tables.
const MEASURED: [(&str, &str); 2] = [
    ("Measured: people", include_str!("../../assets/networks/evaluation.md")),
    ("Measured: motion", include_str!("../../assets/networks/motion_evaluation.md")),
];

/// Columns that are no losses, and what they are called.
const MEASURES: [(&str, &str); 4] = [
    ("place_cm", "place off by, cm"),
    ("turn_x100", "rotation off by, 1/100"),
    ("pose_x100", "pose off by, 1/100"),
    ("labelled_rightly", "labelled rightly"),
];

/// A card with the curves of a table whose first column counts epochs.
fn of_table(name: &str, text: &str, csv: &str) -> NetworkCard {
    let (measures, curves) = columns(csv)
        .into_iter()
        .partition(|curve: &Curve| MEASURES.iter().any(|(_, label)| *label == curve.name));
    NetworkCard { name: name.to_owned(), text: text.to_owned(), curves, measures }
}

/// The columns after the first; those that are 0 all along are left out.
fn columns(csv: &str) -> Vec<Curve> {
    let mut lines = csv.lines();
    let named = lines.next().into_iter().flat_map(|head| head.split(',').skip(1));
    let label = |name: &str| {
        let known = MEASURES.iter().find(|(column, _)| *column == name);
        known.map_or_else(|| name.replace('_', " "), |(_, label)| (*label).to_owned())
    };
    let mut curves: Vec<Curve> = named.map(|name| Curve { name: label(name), points: Vec::new() }).collect();
    for line in lines {
        let mut numbers = line.split(',').map(|cell| cell.trim().parse::<f64>().unwrap_or(f64::NAN));
        let Some(epoch) = numbers.next() else { continue };
        for (curve, value) in curves.iter_mut().zip(numbers).filter(|(_, value)| value.is_finite()) {
            curve.points.push([epoch, value]);
        }
    }
    curves.retain(|curve| curve.points.iter().any(|point| point[1] != 0.0));
    curves
}

/// Name for people.
fn name_of(method: LearnedMethod) -> &'static str {
    match (method.network, method.scene_loss) {
        (PsiMethod::S1, false) => "S1",
        (PsiMethod::S1, true) => "S1 with scene loss",
        (PsiMethod::S2, false) => "S2",
        (PsiMethod::S2, true) => "S2 with scene loss",
        (PsiMethod::Baseline, _) => "Baseline",
    }
}

/// The card that ships beside the weights.
fn text_of(method: LearnedMethod) -> &'static str {
    match (method.network, method.scene_loss) {
        (PsiMethod::S1, false) => include_str!("../../assets/networks/s1.md"),
        (PsiMethod::S1, true) => include_str!("../../assets/networks/s1_hs.md"),
        (PsiMethod::S2, false) => include_str!("../../assets/networks/s2.md"),
        (PsiMethod::S2, true) => include_str!("../../assets/networks/s2_hs.md"),
        (PsiMethod::Baseline, _) => include_str!("../../assets/networks/baseline.md"),
    }
}

/// A card with the curves that the weights' own notes hold.
fn card(name: &str, text: String, notes: &BTreeMap<String, String>) -> NetworkCard {
    let curves = notes.values().flat_map(|note| curves_of(note)).collect();
    NetworkCard { name: name.to_owned(), text, curves, measures: Vec::new() }
}

/// The curves of a note that is a list of records, each with a step or an epoch and some numbers; those that
/// are 0 all along, for terms that a network does not have, are left out.
fn curves_of(note: &str) -> Vec<Curve> {
    let records = match serde_json::from_str(note) {
        Ok(Value::Array(records)) => records,
        Ok(Value::Object(of)) => match of.into_iter().find(|(_, value)| value.is_array()) {
            Some((_, Value::Array(records))) => records,
            _ => return Vec::new(),
        },
        _ => return Vec::new(),
    };
    let mut curves: Vec<Curve> = Vec::new();
    for record in records.iter().filter_map(Value::as_object) {
        let Some(at) = ["epoch", "step"].iter().find_map(|key| record.get(*key)?.as_f64()) else { continue };
        for (name, value) in record.iter().filter(|(name, _)| !matches!(name.as_str(), "epoch" | "step")) {
            let Some(value) = value.as_f64() else { continue };
            match curves.iter_mut().find(|curve| curve.name == *name) {
                Some(curve) => curve.points.push([at, value]),
                None => curves.push(Curve { name: name.clone(), points: vec![[at, value]] }),
            }
        }
    }
    curves.retain(|curve| curve.points.iter().any(|point| point[1] != 0.0));
    curves
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bundled_network_says_how_it_was_trained_and_shows_that_it_learned() {
        let cards = cards();
        assert_eq!(cards.iter().filter(|card| card.curves.is_empty()).count(), MEASURED.len());
        for card in cards.iter().filter(|card| !card.curves.is_empty()) {
            assert!(card.text.contains("inhabit train"), "{} names no command", card.name);
            let is_loss = |curve: &&Curve| {
                curve.name.contains("loss") || curve.name == "reconstruction" || curve.name == "training"
            };
            let loss = card.curves.iter().find(is_loss).expect(&card.name);
            let (first, last) = (loss.points[0], loss.points[loss.points.len() - 1]);
            assert!(last[0] > first[0] && last[1] < first[1], "{}: {first:?} to {last:?}", card.name);
        }
    }

    #[test]
    fn the_networks_of_motion_show_how_far_off_they_are_beside_their_losses() {
        let cards = cards();
        let route = cards.iter().find(|card| card.name == "RouteNet").expect("bundled");
        let names: Vec<&str> = route.measures.iter().map(|curve| curve.name.as_str()).collect();
        assert_eq!(names, ["place off by, cm", "rotation off by, 1/100"]);
        assert!(columns("epoch,a\n1,x\n").is_empty() && columns("").is_empty());
    }

    #[test]
    fn a_note_that_is_no_list_of_records_has_no_curves() {
        for note in ["", "7", "{\"a\": 1}", "[1, 2]", "[{\"loss\": 3}]"] {
            assert!(curves_of(note).is_empty(), "{note}");
        }
        let curves =
            curves_of("[{\"epoch\": 0, \"loss\": 3.5}, {\"epoch\": 1, \"loss\": 2, \"note\": \"x\"}]");
        assert_eq!(curves, [Curve { name: "loss".to_owned(), points: vec![[0.0, 3.5], [1.0, 2.0]] }]);
    }
}
