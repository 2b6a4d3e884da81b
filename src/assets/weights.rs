//! Weight files of networks: safetensors with named f32 or f16 tensors and a note about their making.

use std::collections::{BTreeMap, HashMap};

use half::f16;
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};

/// Key of the file's own metadata map that holds [`Weights::notes`] as JSON: one key, because the crate writes
/// several in the order of a hash map and the same weights must give the same bytes.
const NOTES_KEY: &str = "inhabit";
/// Most numbers of one file: a hundred times the largest network here.
const MAX_NUMBERS: usize = 2_000_000_000;

/// Why a weight file can't be used.
#[derive(Debug, thiserror::Error)]
pub enum WeightsError {
    /// Not a safetensors file, or a damaged one.
    #[error("{file}: not a readable safetensors file ({cause}); train or download the weights again")]
    Damaged {
        /// The file.
        file: String,
        /// What the reader says.
        cause: String,
    },
    /// No tensor of that name.
    #[error("{file}: has no tensor `{tensor}`; it belongs to another network or version: train it again")]
    Missing {
        /// The file.
        file: String,
        /// The name looked for.
        tensor: String,
    },
    /// A tensor of another shape than the network's.
    #[error(
        "{file}: tensor `{tensor}` has shape {found:?}, the network needs {expected:?}: train it again with this version"
    )]
    Shape {
        /// The file.
        file: String,
        /// The tensor.
        tensor: String,
        /// Its shape.
        found: Vec<usize>,
        /// The shape asked for.
        expected: Vec<usize>,
    },
    /// A tensor of integers, or of floats that are neither f32 nor f16.
    #[error("{file}: tensor `{tensor}` is of type {dtype}; save it as F32 or F16")]
    Type {
        /// The file.
        file: String,
        /// The tensor.
        tensor: String,
        /// Its type.
        dtype: String,
    },
    /// A number is NaN or infinite.
    #[error(
        "{file}: tensor `{tensor}` has a number that is not finite, at flat index {index}: the training diverged"
    )]
    NotFinite {
        /// The file.
        file: String,
        /// The tensor.
        tensor: String,
        /// Where, in C order.
        index: usize,
    },
}

/// How numbers are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Four bytes a number: checkpoints.
    #[default]
    Full,
    /// Two bytes a number: what ships.
    Half,
}

/// One tensor: its shape and its numbers in C order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WeightTensor {
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// The numbers.
    pub values: Vec<f32>,
}

/// Named tensors with notes: what a weight file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weights {
    /// The file's name, for errors.
    pub file: String,
    /// What the file says of itself: architecture, seed, corpus, steps.
    pub notes: BTreeMap<String, String>,
    tensors: BTreeMap<String, WeightTensor>,
}

impl Weights {
    /// No tensors yet; `file` stands in errors.
    pub fn new(file: &str) -> Self {
        Self { file: file.to_owned(), ..Self::default() }
    }

    /// Adds or replaces a tensor.
    ///
    /// # Panics
    /// When the shape and the count of values contradict each other: a bug of the caller.
    pub fn insert(&mut self, name: &str, shape: &[usize], values: Vec<f32>) {
        assert_eq!(shape.iter().product::<usize>(), values.len(), "{name}");
        self.tensors.insert(name.to_owned(), WeightTensor { shape: shape.to_vec(), values });
    }

    /// Names of all tensors, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.tensors.keys().map(String::as_str)
    }

    /// A tensor of whatever shape.
    ///
    /// # Errors
    /// [`WeightsError::Missing`].
    pub fn tensor(&self, name: &str) -> Result<&WeightTensor, WeightsError> {
        self.tensors
            .get(name)
            .ok_or_else(|| WeightsError::Missing { file: self.file.clone(), tensor: name.to_owned() })
    }

    /// The numbers of a tensor of this shape, C order.
    ///
    /// # Errors
    /// [`WeightsError::Missing`] or [`WeightsError::Shape`].
    pub fn values(&self, name: &str, shape: &[usize]) -> Result<&[f32], WeightsError> {
        let tensor = self.tensor(name)?;
        if tensor.shape == shape {
            return Ok(&tensor.values);
        }
        Err(WeightsError::Shape {
            file: self.file.clone(),
            tensor: name.to_owned(),
            found: tensor.shape.clone(),
            expected: shape.to_vec(),
        })
    }

    /// Reads a safetensors file from memory.
    ///
    /// # Errors
    /// [`WeightsError`]: damaged, a type that is neither F32 nor F16, a number that is not finite.
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Self, WeightsError> {
        let damaged = |cause: String| WeightsError::Damaged { file: file.to_owned(), cause };
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| damaged(e.to_string()))?;
        let notes = header.metadata().as_ref().and_then(|m| m.get(NOTES_KEY));
        let notes = notes.map(|text| serde_json::from_str(text)).transpose();
        let mut weights = Self::new(file);
        weights.notes = notes.map_err(|e| damaged(e.to_string()))?.unwrap_or_default();
        let archive = SafeTensors::deserialize(bytes).map_err(|e| damaged(e.to_string()))?;
        for (name, view) in archive.iter() {
            let values = numbers(file, name, &view)?;
            weights.tensors.insert(name.to_owned(), WeightTensor { shape: view.shape().to_vec(), values });
        }
        Ok(weights)
    }

    /// The bytes of a safetensors file. The same weights give the same bytes.
    ///
    /// # Errors
    /// [`WeightsError::Damaged`] with what the writer says; never on weights of a size that fits the memory.
    pub fn to_bytes(&self, precision: Precision) -> Result<Vec<u8>, WeightsError> {
        let damaged = |cause: String| WeightsError::Damaged { file: self.file.clone(), cause };
        let bytes: Vec<(&str, &[usize], Vec<u8>)> = self
            .tensors
            .iter()
            .map(|(name, t)| (&**name, &*t.shape, encoded(&t.values, precision)))
            .collect();
        let dtype = match precision {
            Precision::Full => Dtype::F32,
            Precision::Half => Dtype::F16,
        };
        let views: Result<Vec<_>, _> = bytes
            .iter()
            .map(|(name, shape, data)| Ok((*name, TensorView::new(dtype, shape.to_vec(), data)?)))
            .collect();
        let views = views.map_err(|e: safetensors::SafeTensorError| damaged(e.to_string()))?;
        let notes = serde_json::to_string(&self.notes).map_err(|e| damaged(e.to_string()))?;
        let header = HashMap::from([(NOTES_KEY.to_owned(), notes)]);
        safetensors::serialize(views, Some(header)).map_err(|e| damaged(e.to_string()))
    }
}

fn encoded(values: &[f32], precision: Precision) -> Vec<u8> {
    match precision {
        Precision::Full => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        Precision::Half => values.iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect(),
    }
}

fn numbers(file: &str, name: &str, view: &TensorView<'_>) -> Result<Vec<f32>, WeightsError> {
    let data = view.data();
    if data.len() > MAX_NUMBERS {
        let cause = format!("tensor `{name}` of {} bytes is larger than any network here", data.len());
        return Err(WeightsError::Damaged { file: file.to_owned(), cause });
    }
    let values: Vec<f32> = match view.dtype() {
        Dtype::F32 => data.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
        Dtype::F16 => data.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect(),
        other => {
            let (file, tensor) = (file.to_owned(), name.to_owned());
            return Err(WeightsError::Type { file, tensor, dtype: format!("{other:?}") });
        }
    };
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(WeightsError::NotFinite { file: file.to_owned(), tensor: name.to_owned(), index }),
        None => Ok(values),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> Weights {
        let mut weights = Weights::new("some.safetensors");
        weights.insert("b", &[2, 3], vec![0.5, -1.25, 3.0, 4.0, 5.0, 6.5]);
        weights.insert("a", &[1], vec![2.0]);
        for key in ["seed", "steps", "corpus", "command"] {
            weights.notes.insert(key.into(), format!("{key}!"));
        }
        weights
    }

    #[test]
    fn weights_survive_a_round_trip_and_always_give_the_same_bytes() {
        for precision in [Precision::Full, Precision::Half] {
            let bytes = some().to_bytes(precision).expect("bytes");
            assert_eq!(bytes, some().to_bytes(precision).expect("bytes"));
            assert_eq!(Weights::from_bytes("some.safetensors", &bytes).expect("weights"), some());
        }
    }

    #[test]
    fn a_wrong_file_says_what_is_wrong() {
        let bytes = some().to_bytes(Precision::Full).expect("bytes");
        let cut = Weights::from_bytes("cut", &bytes[..bytes.len() - 3]);
        assert!(matches!(cut, Err(WeightsError::Damaged { .. })), "{cut:?}");
        let weights = Weights::from_bytes("w", &bytes).expect("weights");
        let error = weights.values("b", &[3, 2]).expect_err("another shape").to_string();
        assert!(error.contains("`b`") && error.contains("[2, 3]") && error.contains("[3, 2]"), "{error}");
        assert!(matches!(weights.values("c", &[1]), Err(WeightsError::Missing { .. })));
        let mut diverged = some();
        diverged.insert("b", &[2], vec![1.0, f32::NAN]);
        let bytes = diverged.to_bytes(Precision::Full).expect("bytes");
        let read = Weights::from_bytes("w", &bytes);
        assert!(matches!(read, Err(WeightsError::NotFinite { index: 1, .. })), "{read:?}");
    }
}
