use rand::RngExt as _;
use rayon::prelude::*;

use crate::job::Seed;

/// Clusters of rows.
#[derive(Clone, Debug, PartialEq)]
pub struct KMeans {
    /// Middles, one after another.
    pub centres: Vec<f32>,
    /// The cluster of each row.
    pub cluster: Vec<usize>,
    /// Mean squared distance of a row to its middle.
    pub error: f32,
}

/// Lloyd's K-means from k-means++ starts (Arthur and Vassilvitskii 2007), the best of `starts`. `rows` are of
/// `width` numbers each. Fewer rows than clusters leave middles twice.
pub fn kmeans(rows: &[f32], width: usize, clusters: usize, starts: u64, seed: Seed) -> KMeans {
    let runs = (0..starts.max(1)).into_par_iter().map(|s| one_run(rows, width, clusters, seed.child("start", s)));
    let all: Vec<KMeans> = runs.collect();
    let best = all.into_iter().min_by(|a, b| a.error.total_cmp(&b.error));
    best.unwrap_or(KMeans { centres: Vec::new(), cluster: Vec::new(), error: 0.0 })
}

/// Rounds of moving; settled long before with the sizes used here.
const ROUNDS: usize = 60;

fn one_run(rows: &[f32], width: usize, clusters: usize, seed: Seed) -> KMeans {
    let mut centres = spread_start(rows, width, clusters, seed);
    let (mut cluster, mut error) = assign(rows, width, &centres);
    for _ in 0..ROUNDS {
        centres = middles(rows, width, &cluster, &centres);
        let (next, now) = assign(rows, width, &centres);
        let settled = next == cluster;
        (cluster, error) = (next, now);
        if settled {
            break;
        }
    }
    KMeans { centres, cluster, error }
}

/// The first middle by chance, each further one with a chance that grows with its squared distance.
fn spread_start(rows: &[f32], width: usize, clusters: usize, seed: Seed) -> Vec<f32> {
    let count = rows.len() / width.max(1);
    let mut rng = seed.rng();
    if count == 0 {
        return vec![0.0; clusters * width];
    }
    let row = |i: usize| &rows[i * width..(i + 1) * width];
    let mut centres = row(rng.random_range(0..count)).to_vec();
    let mut nearest: Vec<f32> = (0..count).map(|i| squared(row(i), &centres)).collect();
    while centres.len() < clusters * width {
        let total: f32 = nearest.iter().sum();
        let mut left = rng.random_range(0.0..1.0f32) * total;
        let drawn = nearest.iter().position(|d| {
            left -= d;
            left < 0.0
        });
        let chosen = row(drawn.unwrap_or(0)).to_vec();
        for (i, d) in nearest.iter_mut().enumerate() {
            *d = d.min(squared(row(i), &chosen));
        }
        centres.extend(chosen);
    }
    centres
}

fn assign(rows: &[f32], width: usize, centres: &[f32]) -> (Vec<usize>, f32) {
    let nearest = |row: &[f32]| {
        let all = centres.chunks(width).map(|c| squared(row, c)).enumerate();
        all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    };
    let found: Vec<(usize, f32)> = rows.chunks(width).map(nearest).collect();
    let error = found.iter().map(|(_, d)| d).sum::<f32>() / found.len().max(1) as f32;
    (found.into_iter().map(|(c, _)| c).collect(), error)
}

/// An empty cluster keeps its middle.
fn middles(rows: &[f32], width: usize, cluster: &[usize], before: &[f32]) -> Vec<f32> {
    let mut sums = vec![0.0; before.len()];
    let mut counts = vec![0usize; before.len() / width];
    for (row, c) in rows.chunks(width).zip(cluster) {
        counts[*c] += 1;
        sums[c * width..(c + 1) * width].iter_mut().zip(row).for_each(|(s, x)| *s += x);
    }
    for (i, count) in counts.iter().enumerate() {
        let range = i * width..(i + 1) * width;
        match count {
            0 => sums[range.clone()].copy_from_slice(&before[range]),
            _ => sums[range].iter_mut().for_each(|s| *s /= *count as f32),
        }
    }
    sums
}

fn squared(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heaps_are_found_and_the_same_seed_finds_them_alike() {
        let heap = |x: f32, i: usize| [x + (i as f32 * 0.7).sin() * 0.1, -x + (i as f32 * 1.3).cos() * 0.1];
        let rows: Vec<f32> = (0..90).flat_map(|i| heap([0.0, 5.0, 9.0][i % 3], i)).collect();
        let found = kmeans(&rows, 2, 3, 4, Seed::root(1));
        assert!((0..90).all(|i| found.cluster[i] == found.cluster[i % 3]), "{:?}", found.cluster);
        assert!(found.error < 0.02, "{}", found.error);
        assert_eq!(found, kmeans(&rows, 2, 3, 4, Seed::root(1)));
    }
}
