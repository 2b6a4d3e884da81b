/// Eigenvalues and unit eigenvectors of a symmetric matrix, largest eigenvalue first, by cyclic Jacobi
/// rotations (Golub and Van Loan 2013, §8.5). Each eigenvector's largest component is positive, so the
/// result does not depend on the rotations' path. Meant for matrices of at most a few hundred rows.
///
/// # Panics
/// If `matrix` is not square.
pub fn symmetric_eigen(matrix: &[Vec<f64>]) -> Vec<(f64, Vec<f64>)> {
    let n = matrix.len();
    assert!(matrix.iter().all(|row| row.len() == n), "the matrix is square");
    let mut a = matrix.to_vec();
    // Row i of `v` becomes eigenvector i.
    let mut v: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| if i == j { 1.0 } else { 0.0 }).collect()).collect();
    for _ in 0..MAX_SWEEPS {
        let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i][j] * a[i][j]).sum();
        let scale: f64 = (0..n).map(|i| a[i][i] * a[i][i]).sum();
        if off <= 1e-24 * scale {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                rotate(&mut a, &mut v, p, q);
            }
        }
    }
    let mut pairs: Vec<(f64, Vec<f64>)> = (0..n).map(|i| (a[i][i], with_positive_peak(&v[i]))).collect();
    pairs.sort_by(|x, y| y.0.total_cmp(&x.0));
    pairs
}

/// Jacobi converges quadratically; ten sweeps are ample.
const MAX_SWEEPS: usize = 30;

/// Zeroes entry (p, q) by a plane rotation.
fn rotate(a: &mut [Vec<f64>], v: &mut [Vec<f64>], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for row in a.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    for k in 0..a.len() {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
        (v[p][k], v[q][k]) = (c * v[p][k] - s * v[q][k], s * v[p][k] + c * v[q][k]);
    }
}

fn with_positive_peak(vector: &[f64]) -> Vec<f64> {
    let peak = vector.iter().copied().max_by(|x, y| x.abs().total_cmp(&y.abs())).unwrap_or(1.0);
    vector.iter().map(|x| x * peak.signum()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_the_sum_of_its_eigenpairs() {
        let n = 9;
        let matrix: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| ((i * j) as f64).sin() + ((i + j) as f64).cos()).collect())
            .collect();
        let pairs = symmetric_eigen(&matrix);
        assert!(pairs.windows(2).all(|w| w[0].0 >= w[1].0));
        for i in 0..n {
            for j in 0..n {
                let sum: f64 = pairs.iter().map(|(value, vector)| value * vector[i] * vector[j]).sum();
                assert!((sum - matrix[i][j]).abs() < 1e-10, "({i}, {j}): {sum} against {}", matrix[i][j]);
            }
        }
    }

    #[test]
    fn a_diagonal_matrix_keeps_its_axes_in_falling_order() {
        let pairs = symmetric_eigen(&[vec![1.0, 0.0], vec![0.0, 3.0]]);
        assert_eq!(pairs, [(3.0, vec![0.0, 1.0]), (1.0, vec![1.0, 0.0])]);
    }
}
