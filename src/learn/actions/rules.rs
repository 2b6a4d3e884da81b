//! What is looked for in captions, interactions and labels, as data.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use serde::Deserialize;

use crate::assets::photos::Photo;
use crate::evolve::action::{ActionKind, KeyObject, Posture};

const BUNDLED: &str = include_str!("../../../assets/actions/rules.ron");

/// Which list of phrases captions are searched for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Search {
    /// The paper's words and the obvious ones for the other actions.
    Strict,
    /// Synonyms too.
    #[default]
    Wide,
}

/// A verb of V-COCO that is an action when done with one of these things.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct VerbRule {
    /// Verb and role.
    pub verb: String,
    /// Categories.
    pub things: Vec<String>,
}

/// How one type of action is found.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ActionRule {
    /// Which.
    pub kind: ActionKind,
    /// Phrases of the strict list.
    pub strict: Vec<Phrase>,
    /// What the wide list has beside them.
    pub wide: Vec<Phrase>,
    /// Words that a matching caption may not have.
    pub without: Vec<String>,
    /// Interactions that are this action.
    pub verbs: Vec<VerbRule>,
    /// One of these must be in the photo.
    pub requires: Vec<String>,
    /// Fewest and most people in the photo.
    pub people: (usize, usize),
    /// Where it happens when nothing else says so.
    pub key: KeyObject,
    /// How it is done when nothing else says so.
    pub posture: Posture,
}

/// What a caption says about how somebody is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum PostureHint {
    /// Lying.
    Lie,
    /// Sitting.
    Sit,
    /// Standing.
    Stand,
}

/// Everything that is looked for.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Rules {
    /// By type.
    pub actions: Vec<ActionRule>,
    /// Labels of things that are key objects.
    pub key_labels: Vec<(String, KeyObject)>,
    /// Words of captions that say which table a table is, first match wins.
    pub table_words: Vec<(KeyObject, Vec<String>)>,
    /// Verbs with a thing that is then the key object, on which the person is.
    pub seat_verbs: Vec<(String, String, KeyObject)>,
    /// Verbs of somebody who sits.
    pub sit_verbs: Vec<String>,
    /// Verbs of somebody who lies.
    pub lie_verbs: Vec<String>,
    /// Words of captions about postures, first match wins.
    pub posture_words: Vec<(PostureHint, Vec<String>)>,
    /// Categories that actions place.
    pub objects: Vec<String>,
    /// In this type of action the second name stands for the first.
    pub renamed: Vec<(ActionKind, String, String)>,
}

/// Why rules can't be used.
#[derive(Debug, thiserror::Error)]
#[error("rules of actions: {0}; compare with the bundled assets/actions/rules.ron")]
pub struct RulesError(#[from] ron::error::SpannedError);

impl Rules {
    /// Reads the RON text of rules.
    ///
    /// # Errors
    /// [`RulesError`].
    pub fn from_ron(text: &str) -> Result<Self, RulesError> {
        Ok(ron::from_str(text)?)
    }

    /// The rules that ship with the program.
    ///
    /// # Panics
    /// Never with the embedded text, which a test reads.
    pub fn bundled() -> &'static Self {
        static RULES: OnceLock<Rules> = OnceLock::new();
        RULES.get_or_init(|| Self::from_ron(BUNDLED).expect("the bundled rules are sound"))
    }

    /// The rule of a type.
    pub fn action(&self, kind: ActionKind) -> Option<&ActionRule> {
        self.actions.iter().find(|rule| rule.kind == kind)
    }

    /// The category as a type of action names it; `None` for what actions don't place.
    pub fn object_name<'a>(&'a self, kind: ActionKind, category: &'a str) -> Option<&'a str> {
        if !self.objects.iter().any(|o| o == category) {
            return None;
        }
        let renamed = self.renamed.iter().find(|(k, from, _)| *k == kind && from == category);
        Some(renamed.map_or(category, |(_, _, to)| to.as_str()))
    }

    /// The key object that a label is.
    pub fn key_of_label(&self, label: &str) -> Option<KeyObject> {
        self.key_labels.iter().find(|(name, _)| name == label).map(|(_, key)| *key)
    }
}

/// Words that stand in one caption, each with its alternatives.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(from = "String")]
pub struct Phrase(Vec<Vec<Word>>);

/// A word, or several that follow each other.
#[derive(Clone, Debug, PartialEq)]
enum Word {
    One(String),
    Sequence(String),
}

impl Word {
    fn of(text: &str) -> Self {
        if text.contains('_') {
            Self::Sequence(format!(" {} ", text.replace('_', " ")))
        } else {
            Self::One(text.to_owned())
        }
    }

    fn is_in(&self, caption: &Caption) -> bool {
        match self {
            Self::One(word) => caption.words.contains(word.as_str()),
            Self::Sequence(words) => caption.text.contains(words),
        }
    }
}

impl From<String> for Phrase {
    fn from(text: String) -> Self {
        let slot = |slot: &str| slot.split('|').map(Word::of).collect();
        Self(text.split_whitespace().map(slot).collect())
    }
}

impl Phrase {
    /// Whether a caption has one alternative of every word.
    pub fn is_in(&self, caption: &Caption) -> bool {
        self.0.iter().all(|slot| slot.iter().any(|word| word.is_in(caption)))
    }
}

/// A caption as it is searched.
#[derive(Clone, Debug)]
pub struct Caption {
    /// Lower case, words apart by one space, a space at either end.
    text: String,
    words: BTreeSet<String>,
}

impl Caption {
    /// Of what somebody wrote.
    pub fn of(text: &str) -> Self {
        let clean: String =
            text.chars().map(|c| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { ' ' }).collect();
        let words: Vec<&str> = clean.split_whitespace().collect();
        Self {
            text: format!(" {} ", words.join(" ")),
            words: words.iter().map(|w| (*w).to_owned()).collect(),
        }
    }

    /// Whether it has the word; `_` joins words that follow each other.
    pub fn has(&self, word: &str) -> bool {
        Word::of(word).is_in(self)
    }
}

impl ActionRule {
    /// Whether a caption of the photo says this action.
    pub fn is_said(&self, captions: &[Caption], search: Search) -> bool {
        let says = |caption: &Caption| {
            let phrases = self
                .strict
                .iter()
                .chain((search == Search::Wide).then_some(&self.wide).into_iter().flatten());
            let mut phrases = phrases;
            phrases.any(|p| p.is_in(caption)) && !self.without.iter().any(|w| caption.has(w))
        };
        captions.iter().any(says)
    }

    /// Whether somebody with these interactions does this action.
    pub fn is_done(&self, photo: &Photo, person: usize) -> bool {
        photo.people[person].interactions.iter().any(|i| {
            let category = photo.things.get(i.thing).map_or("", |t| t.category.as_str());
            self.verbs.iter().any(|v| v.verb == i.verb && v.things.iter().any(|t| t == category))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(kind: ActionKind, caption: &str, search: Search) -> bool {
        let rule = Rules::bundled().action(kind).expect("a rule");
        rule.is_said(&[Caption::of(caption)], search)
    }

    #[test]
    fn every_type_has_a_rule_with_phrases_and_objects() {
        for kind in ActionKind::ALL {
            let rule = Rules::bundled().action(kind).expect("a rule");
            assert!(!rule.strict.is_empty() && !rule.requires.is_empty(), "{}", kind.label());
        }
    }

    #[test]
    fn words_match_in_any_order_whole_and_in_one_caption() {
        use ActionKind::{UseComputer, UseLaptop};
        assert!(said(UseLaptop, "A laptop that a man is USING, at home.", Search::Strict));
        assert!(!said(UseLaptop, "A laptop because of the house.", Search::Strict), "\"use\" inside a word");
        assert!(
            !said(UseComputer, "A man using a laptop computer", Search::Strict),
            "laptops are no computers"
        );
        let rule = Rules::bundled().action(UseLaptop).expect("a rule");
        let two = [Caption::of("A man working."), Caption::of("A laptop.")];
        assert!(!rule.is_said(&two, Search::Strict), "two captions are not one");
    }

    #[test]
    fn the_wide_list_finds_what_the_strict_one_misses() {
        let caption = "A woman cutting vegetables in a bowl";
        assert!(!said(ActionKind::PrepareFood, caption, Search::Strict));
        assert!(said(ActionKind::PrepareFood, caption, Search::Wide));
    }

    #[test]
    fn words_that_follow_each_other_are_told_from_words_apart() {
        let caption = Caption::of("Coffee on a table.");
        assert!(!caption.has("coffee_table") && Caption::of("A coffee table.").has("coffee_table"));
    }

    #[test]
    fn a_computers_screen_is_a_monitor_and_cars_are_not_placed() {
        let rules = Rules::bundled();
        assert_eq!(rules.object_name(ActionKind::UseComputer, "tv"), Some("monitor"));
        assert_eq!(rules.object_name(ActionKind::WatchTv, "tv"), Some("tv"));
        assert_eq!(rules.object_name(ActionKind::WatchTv, "car"), None);
    }
}
