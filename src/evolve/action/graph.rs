use rand::RngExt as _;
use serde::{Deserialize, Serialize};

use super::model::ActionNode;

/// ADSE eq. 4: two actions without anything in common still follow each other with this correlation.
const LEAST_CORRELATION: f64 = 0.5;
/// ADSE eq. 4: correlation of an action with itself.
const SELF_CORRELATION: f64 = 1.0;

/// Which action follows which: a Markov chain over the nodes of a model (ADSE §4.3).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActionGraph {
    /// `probability[i][j]` of action j right after action i; each row sums to one, rows and columns of actions that
    /// are off are zero.
    pub probability: Vec<Vec<f64>>,
}

/// s_ij of eq. 5 before its floor: one for the same key object, and how much the occurrence frequencies overlap
/// (intersection over union of the two histograms). 0 to 2.
pub fn correlation(a: &ActionNode, b: &ActionNode) -> f64 {
    let same_key = if a.key == b.key { 1.0 } else { 0.0 };
    let (mut both, mut either) = (0.0, 0.0);
    for here in &a.occurrence {
        let there = b.frequency(&here.object);
        both += here.frequency().min(there);
        either += here.frequency().max(there);
    }
    let only_there = b.occurrence.iter().filter(|o| a.occurrence_of(&o.object).is_none());
    either += only_there.map(super::model::Occurrence::frequency).sum::<f64>();
    same_key + if either > 0.0 { both / either } else { 0.0 }
}

impl ActionGraph {
    /// The graph of a model's nodes, eq. 3 to 5.
    pub fn of(nodes: &[ActionNode]) -> Self {
        Self::adapted(nodes, &vec![true; nodes.len()])
    }

    /// The graph with only the nodes that are on (ADSE §5.1): the others are left out of every sum.
    pub fn adapted(nodes: &[ActionNode], on: &[bool]) -> Self {
        let floored = |i: usize, j: usize| match i == j {
            true => SELF_CORRELATION,
            false => correlation(&nodes[i], &nodes[j]).max(LEAST_CORRELATION),
        };
        let is_on = |i: usize| on.get(i).copied().unwrap_or(false);
        let row = |i: usize| {
            let weights: Vec<f64> =
                (0..nodes.len()).map(|j| if is_on(i) && is_on(j) { floored(i, j) } else { 0.0 }).collect();
            let total: f64 = weights.iter().sum();
            weights.iter().map(|w| if total > 0.0 { w / total } else { 0.0 }).collect()
        };
        Self { probability: (0..nodes.len()).map(row).collect() }
    }

    /// What can follow `last`, most probable first, with probabilities that sum to one. Before any action (`None`)
    /// every action that is on is as probable as any other (ADSE §5: the chain begins with a random action).
    pub fn successors(&self, last: Option<usize>) -> Vec<(usize, f64)> {
        let is_on = |i: usize| self.probability[i].iter().any(|p| *p > 0.0);
        let on = (0..self.probability.len()).filter(|i| is_on(*i));
        let mut found: Vec<(usize, f64)> = match last.and_then(|i| self.probability.get(i)) {
            Some(row) if row.iter().any(|p| *p > 0.0) => {
                row.iter().copied().enumerate().filter(|(_, p)| *p > 0.0).collect()
            }
            _ => {
                let share = 1.0 / on.clone().count().max(1) as f64;
                on.map(|i| (i, share)).collect()
            }
        };
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found
    }

    /// Draws the action after `last`; `None` when no action is on.
    pub fn draw(&self, last: Option<usize>, rng: &mut impl rand::Rng) -> Option<usize> {
        let options = self.successors(last);
        let mut left: f64 = rng.random();
        for (index, probability) in &options {
            left -= probability;
            if left <= 0.0 {
                return Some(*index);
            }
        }
        options.first().map(|(index, _)| *index)
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::tests::node;
    use super::super::model::{ActionKind, KeyObject};
    use super::*;
    use rand::SeedableRng as _;

    fn nodes() -> Vec<ActionNode> {
        vec![
            node(ActionKind::UseLaptop, KeyObject::OfficeDesk, &[("laptop", 1.0), ("cup", 0.5)]),
            node(ActionKind::ReadBook, KeyObject::OfficeDesk, &[("book", 1.0), ("cup", 0.3)]),
            node(ActionKind::EatDinner, KeyObject::DiningTable, &[("fork", 0.8)]),
        ]
    }

    #[test]
    fn probabilities_are_equations_three_to_five_by_hand() {
        let nodes = nodes();
        // Same key: 1, and cups overlap: 0.3 of laptop 1 + cup 0.5 + book 1.
        let s = 1.0 + 0.3 / 2.5;
        assert!((correlation(&nodes[0], &nodes[1]) - s).abs() < 1e-12);
        assert!((correlation(&nodes[1], &nodes[0]) - s).abs() < 1e-12);
        assert_eq!(correlation(&nodes[0], &nodes[2]), 0.0);
        let graph = ActionGraph::of(&nodes);
        let total = 1.0 + s + 0.5;
        for (found, expected) in graph.probability[0].iter().zip([1.0 / total, s / total, 0.5 / total]) {
            assert!((found - expected).abs() < 1e-12);
        }
        // Asymmetric, since each row is normalised by itself.
        assert!((graph.probability[2][0] - 0.25).abs() < 1e-12);
    }

    #[test]
    fn suggestions_come_in_falling_probability_and_leave_out_what_is_off() {
        let graph = ActionGraph::adapted(&nodes(), &[true, false, true]);
        assert_eq!(graph.successors(Some(0)), [(0, 1.0 / 1.5), (2, 0.5 / 1.5)]);
        assert_eq!(graph.successors(None), [(0, 0.5), (2, 0.5)]);
        // The action before was switched off since: begin anew.
        assert_eq!(graph.successors(Some(1)), [(0, 0.5), (2, 0.5)]);
        assert!(ActionGraph::adapted(&nodes(), &[false; 3]).successors(None).is_empty());
    }

    #[test]
    fn drawn_chains_follow_the_probabilities() {
        let graph = ActionGraph::of(&nodes());
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let mut counts = [0.0; 3];
        (0..20_000).for_each(|_| counts[graph.draw(Some(0), &mut rng).expect("on")] += 1.0 / 20_000.0);
        for (count, probability) in counts.iter().zip(&graph.probability[0]) {
            assert!((count - probability).abs() < 0.01, "{count} for {probability}");
        }
        assert_eq!(ActionGraph::adapted(&nodes(), &[false; 3]).draw(None, &mut rng), None);
    }
}
