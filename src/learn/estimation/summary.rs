//! The table of the estimators, and whether the scene's prior helps: a paired comparison with its uncertainty.

use std::collections::BTreeMap;

use rand::RngExt as _;
use serde::{Deserialize, Serialize};

use super::study::CaseResult;
use crate::evolve::EstimatorKind;
use crate::inspect::EstimateErrors;
use crate::job::Seed;

/// Draws of the bootstrap: enough for two digits of a 95 % interval.
const DRAWS: usize = 4_000;
/// How many of the worst cases are listed.
const WORST: usize = 12;

/// Means of one estimator over all cases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodRow {
    /// Name of the estimator.
    pub method: String,
    /// Means, millimetres.
    pub errors: EstimateErrors,
    /// Mean reprojection, pixels.
    pub reprojection_px: f32,
}

/// Mean V2V of every estimator for one pose group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupRow {
    /// `stand`, `lean`, `sit` or `lie`.
    pub group: String,
    /// Cases.
    pub cases: usize,
    /// Mean V2V by estimator, millimetres.
    pub v2v_mm: Vec<f32>,
}

/// One estimator against another on the same cases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// What is compared: negative differences mean that the first is better.
    pub what: String,
    /// Mean difference, millimetres.
    pub mean_mm: f32,
    /// 95 % interval of the mean: rooms drawn with replacement, for views of one room are alike.
    pub low_mm: f32,
    /// Upper end.
    pub high_mm: f32,
    /// Share of cases in which the first is better.
    pub better_share: f32,
}

/// Everything that the study says.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Summary {
    /// Cases that were estimated.
    pub cases: usize,
    /// Rooms that they come from.
    pub rooms: usize,
    /// Table 5.
    pub methods: Vec<MethodRow>,
    /// V2V by pose group.
    pub groups: Vec<GroupRow>,
    /// The scene's prior and the scene's terms, each against the estimator without.
    pub comparisons: Vec<Comparison>,
    /// The cases in which ours is worst, worst first.
    pub worst: Vec<CaseResult>,
}

/// Sums up a study; nothing else of the seed is used than the bootstrap's draws.
pub fn summarise(results: &[CaseResult], seed: Seed) -> Summary {
    let methods = EstimatorKind::ALL.iter().enumerate().map(|(m, kind)| method_row(results, m, *kind));
    let mut by_group: BTreeMap<&str, Vec<&CaseResult>> = BTreeMap::new();
    results.iter().for_each(|r| by_group.entry(r.family.group()).or_default().push(r));
    let groups = by_group.into_iter().map(|(group, cases)| GroupRow {
        group: group.to_owned(),
        cases: cases.len(),
        v2v_mm: (0..EstimatorKind::ALL.len())
            .map(|m| mean(cases.iter().map(|c| c.errors[m].v2v_mm)))
            .collect(),
    });
    let [smplify_x, prox, ours] = [0, 1, 2];
    let v2v = |e: &EstimateErrors| e.v2v_mm;
    let aligned = |e: &EstimateErrors| e.aligned_v2v_mm;
    let compare = |what: &str, pair: (usize, usize), of: &dyn Fn(&EstimateErrors) -> f32| {
        comparison(what, results, pair, of, seed)
    };
    let mut worst: Vec<CaseResult> = results.to_vec();
    worst.sort_by(|a, b| {
        b.errors[ours].v2v_mm.total_cmp(&a.errors[ours].v2v_mm).then(a.number.cmp(&b.number))
    });
    worst.truncate(WORST);
    let mut rooms: Vec<&str> = results.iter().map(|r| r.room.as_str()).collect();
    rooms.sort_unstable();
    rooms.dedup();
    Summary {
        cases: results.len(),
        rooms: rooms.len(),
        methods: methods.collect(),
        groups: groups.collect(),
        comparisons: vec![
            compare("V2V, ours less PROX (the scene's prior)", (ours, prox), &v2v),
            compare("p.V2V, ours less PROX (the scene's prior)", (ours, prox), &aligned),
            compare("V2V, PROX less SMPLify-X (contact and collision)", (prox, smplify_x), &v2v),
            compare("p.V2V, PROX less SMPLify-X (contact and collision)", (prox, smplify_x), &aligned),
        ],
        worst,
    }
}

fn method_row(results: &[CaseResult], method: usize, kind: EstimatorKind) -> MethodRow {
    let of = |pick: &dyn Fn(&EstimateErrors) -> f32| mean(results.iter().map(|r| pick(&r.errors[method])));
    MethodRow {
        method: kind.label().to_owned(),
        errors: EstimateErrors {
            pje_mm: of(&|e| e.pje_mm),
            v2v_mm: of(&|e| e.v2v_mm),
            aligned_pje_mm: of(&|e| e.aligned_pje_mm),
            aligned_v2v_mm: of(&|e| e.aligned_v2v_mm),
        },
        reprojection_px: mean(results.iter().map(|r| r.reprojection_px[method])),
    }
}

fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0f64, 0usize), |(sum, count), v| (sum + f64::from(v), count + 1));
    (sum / count.max(1) as f64) as f32
}

fn comparison(
    what: &str,
    results: &[CaseResult],
    (first, second): (usize, usize),
    of: &dyn Fn(&EstimateErrors) -> f32,
    seed: Seed,
) -> Comparison {
    let difference = |r: &CaseResult| of(&r.errors[first]) - of(&r.errors[second]);
    let mut by_room: BTreeMap<&str, (f64, usize)> = BTreeMap::new();
    for result in results {
        let (sum, count) = by_room.entry(&result.room).or_default();
        *sum += f64::from(difference(result));
        *count += 1;
    }
    let rooms: Vec<(f64, usize)> = by_room.into_values().collect();
    let (low_mm, high_mm) = interval(&rooms, seed);
    let better = results.iter().filter(|r| difference(r) < 0.0).count();
    Comparison {
        what: what.to_owned(),
        mean_mm: mean(results.iter().map(difference)),
        low_mm,
        high_mm,
        better_share: better as f32 / results.len().max(1) as f32,
    }
}

/// 95 % percentile interval of the mean over rooms drawn with replacement, from each room's sum and count
/// (Efron and Tibshirani 1993, §13; clusters as units).
fn interval(rooms: &[(f64, usize)], seed: Seed) -> (f32, f32) {
    if rooms.is_empty() {
        return (0.0, 0.0);
    }
    let mut rng = seed.child("bootstrap", 0).rng();
    let mut means: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let drawn = (0..rooms.len()).map(|_| rooms[rng.random_range(0..rooms.len())]);
            let (sum, count) = drawn.fold((0.0, 0), |(sum, count), room| (sum + room.0, count + room.1));
            sum / count as f64
        })
        .collect();
    means.sort_by(f64::total_cmp);
    let at = |share: f64| means[((DRAWS - 1) as f64 * share).round() as usize] as f32;
    (at(0.025), at(0.975))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::PoseFamily;

    fn result(number: u64, room: &str, v2v: [f32; 3]) -> CaseResult {
        CaseResult {
            room: room.to_owned(),
            number,
            family: PoseFamily::SitSofa,
            points: 25,
            depth_m: 3.0,
            errors: v2v
                .iter()
                .map(|v2v_mm| EstimateErrors { v2v_mm: *v2v_mm, ..Default::default() })
                .collect(),
            reprojection_px: vec![1.0; 3],
        }
    }

    #[test]
    fn differences_are_paired_and_their_interval_holds_the_mean() {
        let results: Vec<CaseResult> = (0..200)
            .map(|i| {
                let hard = 100.0 * (i % 7) as f32;
                let gain = 10.0 + (i % 5) as f32;
                result(
                    i,
                    ["a", "b", "c", "d", "e", "f"][i as usize % 6],
                    [hard + 90.0, hard + 60.0, hard + 60.0 - gain],
                )
            })
            .collect();
        let summary = summarise(&results, Seed::root(1));
        let ours = &summary.comparisons[0];
        assert_eq!((summary.cases, summary.rooms), (200, 6));
        assert!((ours.mean_mm + 12.0).abs() < 1e-3, "{ours:?}");
        assert!(ours.low_mm < -12.0 && ours.high_mm > -12.0 && ours.high_mm < -11.0, "{ours:?}");
        assert_eq!(ours.better_share, 1.0);
        assert_eq!(summary.groups[0].group, "sit");
        assert!(summary.worst[0].errors[2].v2v_mm >= summary.worst[1].errors[2].v2v_mm);
        assert_eq!(summarise(&results, Seed::root(1)).comparisons, summary.comparisons);
    }

    #[test]
    fn no_difference_gives_an_interval_around_zero() {
        let results: Vec<CaseResult> = (0..60)
            .map(|i| {
                let off = if i % 2 == 0 { 5.0 } else { -5.0 };
                result(i, &format!("room {}", i % 20), [50.0, 50.0, 50.0 + off])
            })
            .collect();
        let ours = &summarise(&results, Seed::root(3)).comparisons[0];
        assert!(ours.low_mm <= 0.0 && ours.high_mm >= 0.0, "{ours:?}");
    }
}
