use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Settings of [`kmeans`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KMeansConfig {
    /// How many clusters.
    pub clusters: usize,
    /// Runs from different starts, of which the one with the smallest mean distance is kept.
    pub restarts: usize,
    /// Most iterations of a run.
    pub iterations: usize,
    /// A run ends when the mean distance falls by less than this.
    pub least_change: f64,
}

impl Default for KMeansConfig {
    /// PSI §4.1.4: 20 clusters; restarts and the end of a run as in the published evaluation (scipy's defaults).
    fn default() -> Self {
        Self { clusters: 20, restarts: 20, iterations: 300, least_change: 1e-5 }
    }
}

/// What [`kmeans`] found.
#[derive(Clone, Debug, PartialEq)]
pub struct KMeans {
    /// Mean of each cluster. As many as asked for, fewer when there are fewer rows.
    pub centers: Vec<Vec<f32>>,
    /// The cluster of each row.
    pub assignment: Vec<usize>,
    /// Mean Euclidean distance of a row to its cluster's centre.
    pub mean_distance: f64,
}

impl KMeans {
    /// Rows of each cluster.
    pub fn histogram(&self) -> Vec<usize> {
        let mut counts = vec![0; self.centers.len()];
        self.assignment.iter().for_each(|c| counts[*c] += 1);
        counts
    }
}

/// Lloyd's algorithm from randomly chosen rows. Rows must have one length and finite numbers. The same seed gives
/// the same clusters, whatever the number of threads; a cluster that loses all its rows stays where it was.
pub fn kmeans(rows: &[Vec<f32>], config: &KMeansConfig, seed: u64) -> KMeans {
    let run = |restart: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(restart as u64);
        one_run(rows, config, &mut rng)
    };
    let runs: Vec<KMeans> = (0..config.restarts.max(1)).into_par_iter().map(run).collect();
    let better = |best: KMeans, next: KMeans| match next.mean_distance < best.mean_distance {
        true => next,
        false => best,
    };
    let nothing = KMeans { centers: Vec::new(), assignment: Vec::new(), mean_distance: f64::INFINITY };
    runs.into_iter().fold(nothing, better)
}

fn one_run(rows: &[Vec<f32>], config: &KMeansConfig, rng: &mut ChaCha8Rng) -> KMeans {
    let mut centers = starts(rows, config.clusters, rng);
    let (mut assignment, mut mean_distance) = assign(rows, &centers);
    for _ in 0..config.iterations {
        move_centers(rows, &assignment, &mut centers);
        let (next, distance) = assign(rows, &centers);
        let change = mean_distance - distance;
        (assignment, mean_distance) = (next, distance);
        if change < config.least_change {
            break;
        }
    }
    KMeans { centers, assignment, mean_distance }
}

/// Different rows, drawn without replacement (Fisher and Yates).
fn starts(rows: &[Vec<f32>], count: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f32>> {
    let mut order: Vec<usize> = (0..rows.len()).collect();
    let count = count.min(rows.len());
    for i in 0..count {
        let other = rng.random_range(i..rows.len());
        order.swap(i, other);
    }
    order[..count].iter().map(|i| rows[*i].clone()).collect()
}

/// The nearest centre of each row and the mean distance.
fn assign(rows: &[Vec<f32>], centers: &[Vec<f32>]) -> (Vec<usize>, f64) {
    let squared = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
    let nearest = |row: &Vec<f32>| {
        centers.iter().enumerate().fold((0, f32::INFINITY), |best, (index, center)| {
            let distance2 = squared(row, center);
            if distance2 < best.1 { (index, distance2) } else { best }
        })
    };
    let found: Vec<(usize, f32)> = rows.iter().map(nearest).collect();
    let total: f64 = found.iter().map(|(_, d2)| f64::from(*d2).sqrt()).sum();
    (found.into_iter().map(|(index, _)| index).collect(), total / rows.len().max(1) as f64)
}

fn move_centers(rows: &[Vec<f32>], assignment: &[usize], centers: &mut [Vec<f32>]) {
    for (index, center) in centers.iter_mut().enumerate() {
        let mut sum = vec![0.0_f64; center.len()];
        let mut count = 0;
        for (row, _) in rows.iter().zip(assignment).filter(|(_, c)| **c == index) {
            sum.iter_mut().zip(row).for_each(|(s, x)| *s += f64::from(*x));
            count += 1;
        }
        if count > 0 {
            center.iter_mut().zip(&sum).for_each(|(c, s)| *c = (s / f64::from(count)) as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three tight groups: 0, 1 and 2; 100 and 102; and one alone at 1000.
    fn groups() -> Vec<Vec<f32>> {
        [0.0, 1.0, 2.0, 100.0, 102.0, 1000.0].iter().map(|x| vec![*x, 5.0]).collect()
    }

    #[test]
    fn groups_that_lie_apart_are_found_with_their_means_and_sizes() {
        let found = kmeans(&groups(), &KMeansConfig { clusters: 3, ..KMeansConfig::default() }, 1);
        let mut centers: Vec<f32> = found.centers.iter().map(|c| c[0]).collect();
        centers.sort_by(f32::total_cmp);
        assert_eq!(centers, [1.0, 101.0, 1000.0]);
        let mut sizes = found.histogram();
        sizes.sort_unstable();
        assert_eq!(sizes, [1, 2, 3]);
        // Distances 1, 0, 1 and 1, 1 and 0 over six rows.
        assert!((found.mean_distance - 4.0 / 6.0).abs() < 1e-6, "{}", found.mean_distance);
        assert_eq!(found.assignment[0], found.assignment[2]);
        assert_ne!(found.assignment[2], found.assignment[3]);
    }

    #[test]
    fn a_seed_repeats_on_any_number_of_threads() {
        let rows: Vec<Vec<f32>> =
            (0..300).map(|i| vec![(i as f32 * 7.3).sin(), (i as f32 * 3.1).cos()]).collect();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| kmeans(&rows, &KMeansConfig::default(), 9))
        };
        assert_eq!(on(1), on(2));
    }

    #[test]
    fn fewer_rows_than_clusters_are_clusters_of_one() {
        let found = kmeans(&groups()[..2], &KMeansConfig::default(), 0);
        assert_eq!((found.histogram(), found.mean_distance), (vec![1, 1], 0.0));
        assert!(kmeans(&[], &KMeansConfig::default(), 0).assignment.is_empty());
    }
}
