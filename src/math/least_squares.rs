/// Linear least squares with a little ridge, by normal equations: many targets of the same regressors.
#[derive(Clone, Debug)]
pub struct LeastSquares {
    regressors: usize,
    targets: usize,
    /// `Xᵀ W X`, row-major.
    gram: Vec<f64>,
    /// `Xᵀ W Y`, row-major, one row a regressor.
    moment: Vec<f64>,
}

impl LeastSquares {
    /// Of rows with this many regressors and targets.
    pub fn new(regressors: usize, targets: usize) -> Self {
        Self {
            regressors,
            targets,
            gram: vec![0.0; regressors * regressors],
            moment: vec![0.0; regressors * targets],
        }
    }

    /// Adds a row of weight `weight`; `x` has one number a regressor, `y` one a target.
    pub fn add(&mut self, weight: f64, x: &[f64], y: &[f64]) {
        debug_assert!(x.len() == self.regressors && y.len() == self.targets);
        for (i, xi) in x.iter().enumerate() {
            let row = &mut self.gram[i * self.regressors..(i + 1) * self.regressors];
            row.iter_mut().zip(x).for_each(|(g, xj)| *g += weight * xi * xj);
            let row = &mut self.moment[i * self.targets..(i + 1) * self.targets];
            row.iter_mut().zip(y).for_each(|(m, yj)| *m += weight * xi * yj);
        }
    }

    /// Coefficients, for each target one a regressor, that minimise `Σ w |x·c - y|² + Σ ridge[i] c[i]²`; `None` when
    /// the regressors do not determine them.
    pub fn solve(&self, ridge: &[f64]) -> Option<Vec<Vec<f64>>> {
        let n = self.regressors;
        let mut factor = self.gram.clone();
        (0..n).for_each(|i| factor[i * n + i] += ridge[i]);
        for i in 0..n {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| factor[i * n + k] * factor[j * n + k]).sum();
                let left = factor[i * n + j] - known;
                if i != j {
                    factor[i * n + j] = left / factor[j * n + j];
                } else if left > 1e-12 * self.gram[i * n + i].max(f64::MIN_POSITIVE) {
                    factor[i * n + i] = left.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some((0..self.targets).map(|t| self.substitute(&factor, t)).collect())
    }

    fn substitute(&self, factor: &[f64], target: usize) -> Vec<f64> {
        let n = self.regressors;
        let mut c: Vec<f64> = (0..n).map(|i| self.moment[i * self.targets + target]).collect();
        for i in 0..n {
            let known: f64 = (0..i).map(|k| factor[i * n + k] * c[k]).sum();
            c[i] = (c[i] - known) / factor[i * n + i];
        }
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| factor[k * n + i] * c[k]).sum();
            c[i] = (c[i] - known) / factor[i * n + i];
        }
        c
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_that_made_the_data_are_found_again() {
        let mut fit = LeastSquares::new(2, 2);
        for i in 0..20 {
            let x = f64::from(i) * 0.3;
            fit.add(1.0, &[1.0, x], &[2.0 - 0.5 * x, 3.0 * x]);
        }
        let found = fit.solve(&[0.0; 2]).expect("determined");
        let expected = [[2.0, -0.5], [0.0, 3.0]];
        for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((a - b).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn regressors_that_say_the_same_are_refused() {
        let mut fit = LeastSquares::new(2, 1);
        (0..9).for_each(|_| fit.add(1.0, &[1.0, 1.0], &[1.0]));
        assert_eq!(fit.solve(&[0.0; 2]), None);
        assert!(fit.solve(&[1e-3; 2]).is_some(), "ridge decides");
    }
}
