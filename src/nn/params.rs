//! A network's numbers: named, on the CPU, initialised from a seed; what Adam and weight files work on.

use half::f16;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};

use crate::assets::{Precision, Weights, WeightsError};

/// Names one array of a [`Params`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ParamId(usize);

impl ParamId {
    /// Its place in [`Params::entries`].
    pub fn index(self) -> usize {
        self.0
    }
}

/// What an array is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Moved by the optimiser.
    Trained,
    /// Kept by the network itself: running statistics of batch normalisation.
    Running,
}

/// How an array starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Init {
    /// All the same.
    Constant(f32),
    /// Even between minus and plus this.
    Uniform(f32),
    /// Normal with this standard deviation.
    Normal(f32),
}

/// One array.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Name in weight files.
    pub name: String,
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// The numbers, C order.
    pub values: Vec<f32>,
    /// What it is for.
    pub role: Role,
}

/// All arrays of a network, in the order of their declaration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Params {
    entries: Vec<Entry>,
}

/// Collects a network's arrays while its layers are made.
pub struct Declaration {
    params: Params,
    rng: ChaCha8Rng,
}

impl Declaration {
    /// Starts a network whose initial numbers come from `seed`.
    pub fn new(seed: u64) -> Self {
        Self { params: Params::default(), rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// Adds an array.
    pub fn add(&mut self, name: &str, shape: &[usize], init: Init, role: Role) -> ParamId {
        let count = shape.iter().product();
        let values = match init {
            Init::Constant(value) => vec![value; count],
            Init::Uniform(bound) => (0..count).map(|_| self.rng.random_range(-bound..=bound)).collect(),
            Init::Normal(deviation) => match Normal::new(0.0, deviation) {
                Ok(normal) => (0..count).map(|_| normal.sample(&mut self.rng)).collect(),
                Err(_) => vec![0.0; count],
            },
        };
        self.params.entries.push(Entry { name: name.to_owned(), shape: shape.to_vec(), values, role });
        ParamId(self.params.entries.len() - 1)
    }

    /// The finished arrays.
    pub fn finish(self) -> Params {
        self.params
    }
}

impl Params {
    /// The arrays in the order of their declaration.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The arrays, to be changed in place.
    pub fn entries_mut(&mut self) -> &mut [Entry] {
        &mut self.entries
    }

    /// The array of `id`.
    pub fn entry(&self, id: ParamId) -> &Entry {
        &self.entries[id.0]
    }

    /// Replaces the numbers of `id`, as running statistics are.
    pub fn replace(&mut self, id: ParamId, values: Vec<f32>) {
        debug_assert_eq!(values.len(), self.entries[id.0].values.len(), "an array keeps its size");
        self.entries[id.0].values = values;
    }

    /// How many trained numbers there are: what papers call the number of parameters.
    pub fn trained_count(&self) -> usize {
        self.entries.iter().filter(|e| e.role == Role::Trained).map(|e| e.values.len()).sum()
    }

    /// Takes every array from a weight file; arrays that the network doesn't have are left alone.
    ///
    /// # Errors
    /// [`WeightsError`] when one is missing or has another shape; then nothing is changed.
    pub fn load(&mut self, weights: &Weights) -> Result<(), WeightsError> {
        let values = |e: &Entry| weights.values(&e.name, &e.shape).map(<[f32]>::to_vec);
        let loaded: Result<Vec<Vec<f32>>, WeightsError> = self.entries.iter().map(values).collect();
        self.entries.iter_mut().zip(loaded?).for_each(|(entry, values)| entry.values = values);
        Ok(())
    }

    /// Puts every array into a weight file.
    pub fn store(&self, weights: &mut Weights) {
        self.entries.iter().for_each(|e| weights.insert(&e.name, &e.shape, e.values.clone()));
    }

    /// The network as it will be once it was stored at `precision` and read again.
    #[must_use]
    pub fn rounded(&self, precision: Precision) -> Self {
        let mut copy = self.clone();
        if precision == Precision::Half {
            let numbers = copy.entries.iter_mut().flat_map(|e| &mut e.values);
            numbers.for_each(|value| *value = f16::from_f32(*value).to_f32());
        }
        copy
    }
}
