use crate::math::{KMeansConfig, kmeans, rotation};
use crate::scene::{BodyParams, PARAMS};

/// Numbers of the vector that is clustered: `t 3 | rotation as axis-angle 3 | betas 10 | pose 32 | hands 24`, raw
/// and unwhitened, as in PSI's evaluation (algorithms 1.6).
pub const FEATURES: usize = PARAMS - 3;

/// Fewest bodies whose diversity says something: five a cluster. With fewer, entropy measures how many there are.
pub const DIVERSITY_BODIES: usize = 100;

/// How different a set of bodies is (PSI §4.1.4, Table 2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Diversity {
    /// Shannon entropy in nats of the histogram over clusters; `ln 20 = 2.996` when all are equally full.
    pub entropy_nats: f32,
    /// Mean Euclidean distance of a body's numbers to its cluster's centre ("cluster size").
    pub cluster_size: f32,
    /// Bodies counted: those whose numbers are all finite.
    pub bodies: usize,
}

/// Clusters bodies by K-means (20 clusters, 20 restarts) and says how evenly the clusters are filled and how big
/// they are. In camera frames, as the paper gives its figures, views of one place count as different; in
/// the world frame only the bodies do: the frame is that of the parameters. The same seed gives the same numbers.
/// Nothing for fewer than [`DIVERSITY_BODIES`] bodies.
pub fn diversity(bodies: &[BodyParams], seed: u64) -> Option<Diversity> {
    let rows: Vec<Vec<f32>> =
        bodies.iter().map(features).filter(|r| r.iter().all(|x| x.is_finite())).collect();
    if rows.len() < DIVERSITY_BODIES {
        return None;
    }
    let clusters = kmeans(&rows, &KMeansConfig::default(), seed);
    Some(Diversity {
        entropy_nats: entropy_nats(&clusters.histogram()),
        cluster_size: clusters.mean_distance as f32,
        bodies: rows.len(),
    })
}

fn features(body: &BodyParams) -> Vec<f32> {
    let turn = rotation::axis_angle_from_matrix(body.rotation());
    let mut row = Vec::with_capacity(FEATURES);
    row.extend_from_slice(&body.translation.to_array());
    row.extend_from_slice(&turn.to_array());
    row.extend_from_slice(&body.betas);
    row.extend_from_slice(&body.pose);
    row.extend_from_slice(&body.hands);
    row
}

/// Shannon entropy of a histogram, natural logarithm.
pub fn entropy_nats(histogram: &[usize]) -> f32 {
    let total = histogram.iter().sum::<usize>().max(1) as f64;
    let term = |count: &usize| {
        let share = *count as f64 / total;
        if share > 0.0 { -share * share.ln() } else { 0.0 }
    };
    histogram.iter().map(term).sum::<f64>() as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat3, Vec3};

    fn at(x: f32) -> BodyParams {
        BodyParams { translation: Vec3::new(x, 0.0, 0.0), ..BodyParams::default() }
    }

    #[test]
    fn even_clusters_have_the_entropy_of_their_number() {
        assert!((entropy_nats(&[7, 7, 7, 7]) - 4f32.ln()).abs() < 1e-6);
        assert_eq!(entropy_nats(&[9, 0, 0]), 0.0);
        // 3/4 and 1/4: 0.75 ln(4/3) + 0.25 ln 4.
        assert!((entropy_nats(&[3, 1]) - (0.75 * (4f32 / 3.0).ln() + 0.25 * 4f32.ln())).abs() < 1e-6);
    }

    #[test]
    fn groups_far_apart_make_twenty_even_clusters() {
        // Twenty places 10 m apart, six bodies at each, in two spots 20 cm apart.
        let bodies: Vec<BodyParams> =
            (0..120).map(|i| at(10.0 * (i / 6) as f32 + 0.2 * (i % 2) as f32)).collect();
        let found = diversity(&bodies, 3).unwrap();
        assert_eq!(found.bodies, 120);
        // K-means from random rows need not find every group, but comes near.
        assert!(found.entropy_nats > 2.6 && found.entropy_nats <= 20f32.ln() + 1e-4, "{found:?}");
        let same = vec![at(1.0); 150];
        let collapsed = diversity(&same, 3).unwrap();
        assert_eq!((collapsed.entropy_nats, collapsed.cluster_size), (0.0, 0.0), "a collapsed sampler");
    }

    #[test]
    fn the_turn_of_a_body_counts_as_three_numbers_and_broken_bodies_dont_count() {
        let mut turned = at(0.0);
        turned.set_rotation(&Mat3::from_rotation_y(0.5));
        assert_eq!(features(&turned).len(), FEATURES);
        assert!((features(&turned)[4] - 0.5).abs() < 1e-5);
        let mut bodies: Vec<BodyParams> = (0..DIVERSITY_BODIES).map(|i| at(i as f32)).collect();
        bodies.push(at(f32::NAN));
        assert_eq!(diversity(&bodies, 0).unwrap().bodies, DIVERSITY_BODIES);
    }

    #[test]
    fn twenty_clusters_of_a_handful_of_bodies_say_nothing() {
        let few: Vec<BodyParams> = (1..DIVERSITY_BODIES).map(|i| at(i as f32)).collect();
        assert_eq!(diversity(&few, 0), None);
        assert_eq!(diversity(&[], 0), None);
    }
}
