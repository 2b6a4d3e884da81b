/// Constants of Adam (Kingma and Ba 2015); the papers keep PyTorch's defaults.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct AdamConfig {
    /// Step size.
    pub learning_rate: f32,
    /// Decay of the first moment.
    pub beta1: f32,
    /// Decay of the second moment.
    pub beta2: f32,
    /// Added to the root of the second moment.
    pub epsilon: f32,
}

impl Default for AdamConfig {
    fn default() -> Self {
        Self { learning_rate: 0.05, beta1: 0.9, beta2: 0.999, epsilon: 1e-8 }
    }
}

impl AdamConfig {
    /// What one step does to each number; `steps` counts from 1 and includes it.
    pub fn at_step(self, steps: i32) -> AdamStep {
        AdamStep {
            config: self,
            correction1: 1.0 - self.beta1.powi(steps),
            correction2: 1.0 - self.beta2.powi(steps),
        }
    }
}

/// One step of Adam with its bias corrections: the update rule, for whoever keeps values and moments.
#[derive(Clone, Copy, Debug)]
pub struct AdamStep {
    config: AdamConfig,
    correction1: f32,
    correction2: f32,
}

impl AdamStep {
    /// Moves one value and its two moments along gradient `g`; `scale` multiplies the step size.
    pub fn apply(&self, value: &mut f32, first: &mut f32, second: &mut f32, g: f32, scale: f32) {
        let AdamConfig { learning_rate, beta1, beta2, epsilon } = self.config;
        *first = beta1 * *first + (1.0 - beta1) * g;
        *second = beta2 * *second + (1.0 - beta2) * g * g;
        let mean = *first / self.correction1;
        let root = (*second / self.correction2).sqrt();
        *value -= learning_rate * scale * mean / (root + epsilon);
    }
}

/// Adam over a flat vector of parameters. One instance serves one optimisation: the moments of one
/// body must never leak into the next (algorithms: fault 2 of the published fitting code).
#[derive(Clone, Debug)]
pub struct Adam {
    config: AdamConfig,
    first: Vec<f32>,
    second: Vec<f32>,
    steps: i32,
}

impl Adam {
    /// Fresh state for `parameters` numbers.
    pub fn new(parameters: usize, config: AdamConfig) -> Self {
        Self { config, first: vec![0.0; parameters], second: vec![0.0; parameters], steps: 0 }
    }

    /// One descent step on `values` along `gradient`; `scale` multiplies the step size of each parameter
    /// (0 freezes it).
    pub fn step(&mut self, values: &mut [f32], gradient: &[f32], scale: &[f32]) {
        self.steps += 1;
        let step = self.config.at_step(self.steps);
        for (i, value) in values.iter_mut().enumerate() {
            step.apply(value, &mut self.first[i], &mut self.second[i], gradient[i], scale[i]);
        }
    }

    /// First and second moments, for a checkpoint.
    pub fn moments(&self) -> (&[f32], &[f32]) {
        (&self.first, &self.second)
    }

    /// The state of a checkpoint after `steps` steps.
    pub fn resume(config: AdamConfig, first: Vec<f32>, second: Vec<f32>, steps: i32) -> Self {
        Self { config, first, second, steps }
    }

    /// Replaces the step size, for schedules; the moments stay.
    pub fn set_learning_rate(&mut self, learning_rate: f32) {
        self.config.learning_rate = learning_rate;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_moves_every_parameter_by_the_learning_rate() {
        let mut adam = Adam::new(2, AdamConfig { learning_rate: 0.1, ..AdamConfig::default() });
        let mut values = [1.0, 1.0];
        adam.step(&mut values, &[4.0, -0.001], &[1.0, 1.0]);
        assert!((values[0] - 0.9).abs() < 1e-5 && (values[1] - 1.1).abs() < 1e-4, "{values:?}");
    }

    #[test]
    fn a_bowl_is_descended_to_its_bottom() {
        let mut adam = Adam::new(2, AdamConfig { learning_rate: 0.1, ..AdamConfig::default() });
        let mut values = [3.0f32, -2.0];
        for _ in 0..500 {
            let gradient = [2.0 * (values[0] - 1.0), 20.0 * (values[1] - 0.5)];
            adam.step(&mut values, &gradient, &[1.0, 1.0]);
        }
        assert!((values[0] - 1.0).abs() < 1e-2 && (values[1] - 0.5).abs() < 1e-2, "{values:?}");
    }
}
