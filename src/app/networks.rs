//! The bundled networks' cards and training curves, read once out of what ships with the program.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use serde_json::Value;

use super::engine::{Curve, NetworkCard};
use crate::assets::Weights;
use crate::body::PoseDecoder;
use crate::generate::learned::LearnedMethod;
use crate::generate::learned::LearnedSampler;

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
        cards.push(card(&label, made_by(&label, &notes), &notes));
    }
    cards
}

/// How a sampler was trained, out of its file's own notes.
fn made_by(label: &str, notes: &BTreeMap<String, String>) -> String {
    let mut text = format!("Made by `inhabit train psi`: {label}.\n");
    for (name, note) in notes.iter().filter(|(_, note)| curves_of(note).is_empty()) {
        text.push_str(&format!("- {name}: {note}\n"));
    }
    text
}

/// A card with the curves that the weights' own notes hold.
fn card(name: &str, text: String, notes: &BTreeMap<String, String>) -> NetworkCard {
    let curves = notes.values().flat_map(|note| curves_of(note)).collect();
    NetworkCard { name: name.to_owned(), text, curves }
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
        for card in cards().iter() {
            assert!(card.text.contains("inhabit train"), "{} names no command", card.name);
            let is_loss = |curve: &&Curve| curve.name.contains("loss") || curve.name == "reconstruction";
            let loss = card.curves.iter().find(is_loss).expect(&card.name);
            let (first, last) = (loss.points[0], loss.points[loss.points.len() - 1]);
            assert!(last[0] > first[0] && last[1] < first[1], "{}: {first:?} to {last:?}", card.name);
        }
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
