//! Who and what is selected. Part of the window, not of the document: selecting is no undo step.

use std::collections::BTreeSet;

use crate::scene::ClipId;
use crate::scene::ObjectId;
use crate::scene::PersonId;
use crate::scene::Scene;
use crate::scene::SubGoalId;

/// Somebody or something in the room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Item {
    /// A person.
    Person(PersonId),
    /// An object.
    Object(ObjectId),
    /// A motion: somebody who moves.
    Clip(ClipId),
    /// A sub-goal of a motion.
    Goal(ClipId, SubGoalId),
}

/// The selected items; the one selected last is active, its details are shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    items: BTreeSet<Item>,
    active: Option<Item>,
}

impl Selection {
    /// Selects `item` alone.
    pub fn only(&mut self, item: Item) {
        self.items = BTreeSet::from([item]);
        self.active = Some(item);
    }

    /// Adds `item`, or takes it out if it is in.
    pub fn toggle(&mut self, item: Item) {
        if self.items.remove(&item) {
            self.active = self.items.last().copied();
        } else {
            self.items.insert(item);
            self.active = Some(item);
        }
    }

    /// Selects these.
    pub fn set(&mut self, items: impl IntoIterator<Item = Item>) {
        self.items = items.into_iter().collect();
        self.active = self.items.last().copied();
    }

    /// Adds these.
    pub fn extend(&mut self, items: impl IntoIterator<Item = Item>) {
        self.items.extend(items);
        self.active = self.active.or(self.items.last().copied());
    }

    /// Selects nothing.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Whether nothing is selected.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// How many are selected.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether `item` is selected.
    pub fn contains(&self, item: Item) -> bool {
        self.items.contains(&item)
    }

    /// The item whose details are shown.
    pub fn active(&self) -> Option<Item> {
        self.active
    }

    /// The active item, if it is a person.
    pub fn active_person(&self) -> Option<PersonId> {
        match self.active {
            Some(Item::Person(id)) => Some(id),
            _ => None,
        }
    }

    /// Every selected item.
    pub fn iter(&self) -> impl Iterator<Item = Item> + '_ {
        self.items.iter().copied()
    }

    /// The selected people in ascending order.
    pub fn people(&self) -> Vec<PersonId> {
        let person = |item: &Item| if let Item::Person(id) = item { Some(*id) } else { None };
        self.items.iter().filter_map(person).collect()
    }

    /// The selected objects in ascending order.
    pub fn objects(&self) -> Vec<ObjectId> {
        let object = |item: &Item| if let Item::Object(id) = item { Some(*id) } else { None };
        self.items.iter().filter_map(object).collect()
    }

    /// The selected motions in ascending order.
    pub fn clips(&self) -> Vec<ClipId> {
        let clip = |item: &Item| if let Item::Clip(id) = item { Some(*id) } else { None };
        self.items.iter().filter_map(clip).collect()
    }

    /// The selected sub-goals in ascending order.
    pub fn goals(&self) -> Vec<(ClipId, SubGoalId)> {
        let goal = |item: &Item| if let Item::Goal(clip, goal) = item { Some((*clip, *goal)) } else { None };
        self.items.iter().filter_map(goal).collect()
    }

    /// Forgets what is no longer in the scene.
    pub fn prune(&mut self, scene: &Scene) {
        let there = |item: &Item| match item {
            Item::Person(id) => scene.person(*id).is_some(),
            Item::Object(id) => scene.room.object(*id).is_some(),
            Item::Clip(id) => scene.clip(*id).is_some(),
            Item::Goal(clip, goal) => scene.clip(*clip).is_some_and(|clip| clip.goal(*goal).is_some()),
        };
        self.items.retain(there);
        if self.active.is_some_and(|item| !there(&item)) {
            self.active = self.items.last().copied();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_gone_is_no_longer_selected() {
        let mut selection = Selection::default();
        selection.only(Item::Person(PersonId(3)));
        selection.toggle(Item::Object(ObjectId(1)));
        assert_eq!(selection.active(), Some(Item::Object(ObjectId(1))));
        selection.prune(&Scene::default());
        assert!(selection.is_empty() && selection.active().is_none());
    }

    #[test]
    fn shift_click_adds_and_takes_away() {
        let mut selection = Selection::default();
        let (a, b) = (Item::Person(PersonId(1)), Item::Person(PersonId(2)));
        selection.toggle(a);
        selection.toggle(b);
        selection.toggle(b);
        assert_eq!(selection.people(), [PersonId(1)]);
        assert_eq!(selection.active(), Some(a));
    }
}
