//! Adam over a network's numbers, with a state that is saved whole: a resumed training goes on to the bit.

use rayon::prelude::*;

use super::params::{Entry, Params, Role};
use crate::assets::{Weights, WeightsError};
use crate::math::AdamConfig;

/// Adam (Kingma and Ba 2015) with one pair of moments for each trained number.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkAdam {
    config: AdamConfig,
    steps: u64,
    moments: Vec<Moments>,
}

#[derive(Clone, Debug, PartialEq)]
struct Moments {
    first: Vec<f32>,
    second: Vec<f32>,
}

impl NetworkAdam {
    /// Fresh state for `params`.
    pub fn new(params: &Params, config: AdamConfig) -> Self {
        let moments = |e: &Entry| {
            let count = if e.role == Role::Trained { e.values.len() } else { 0 };
            Moments { first: vec![0.0; count], second: vec![0.0; count] }
        };
        Self { config, steps: 0, moments: params.entries().iter().map(moments).collect() }
    }

    /// Steps taken so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// One step of `rate` times the configured step size along `gradients`, which stand in the order of the
    /// entries; an empty one leaves its array alone.
    pub fn step(&mut self, params: &mut Params, gradients: &[Vec<f32>], rate: f32) {
        self.steps += 1;
        let step = self.config.at_step(i32::try_from(self.steps).unwrap_or(i32::MAX));
        let arrays = params.entries_mut().par_iter_mut().zip(&mut self.moments).zip(gradients);
        arrays.for_each(|((entry, moments), gradient)| {
            if entry.role != Role::Trained || gradient.is_empty() {
                return;
            }
            let numbers = entry.values.iter_mut().zip(&mut moments.first).zip(&mut moments.second);
            for (((value, first), second), g) in numbers.zip(gradient) {
                step.apply(value, first, second, *g, rate);
            }
        });
    }

    /// Puts the state into a weight file, under names that start with `prefix`.
    pub fn store(&self, prefix: &str, params: &Params, weights: &mut Weights) {
        for (entry, moments) in params.entries().iter().zip(&self.moments) {
            if entry.role == Role::Trained {
                let mut put = |part: &str, values: &[f32]| {
                    weights.insert(&format!("{prefix}.{part}.{}", entry.name), &entry.shape, values.to_vec());
                };
                put("first", &moments.first);
                put("second", &moments.second);
            }
        }
    }

    /// Takes the state of [`NetworkAdam::store`] and the number of steps taken.
    ///
    /// # Errors
    /// [`WeightsError`] when an array is missing or belongs to another network.
    pub fn load(
        &mut self,
        prefix: &str,
        params: &Params,
        weights: &Weights,
        steps: u64,
    ) -> Result<(), WeightsError> {
        for (entry, moments) in params.entries().iter().zip(&mut self.moments) {
            if entry.role == Role::Trained {
                let read =
                    |part: &str| weights.values(&format!("{prefix}.{part}.{}", entry.name), &entry.shape);
                *moments = Moments { first: read("first")?.to_vec(), second: read("second")?.to_vec() };
            }
        }
        self.steps = steps;
        Ok(())
    }
}
