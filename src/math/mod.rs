//! Rotations (6-D, axis-angle), Adam, L-BFGS, a smoother, boxes, clusters, statistics of directions and lengths.
//! Knows nothing else of the crate.
//!
//! May not name any other module, read files or hold domain types. Names carry frame and unit.

mod aabb;
mod adam;
mod banded;
mod bessel;
pub mod directions;
mod eigen;
mod kmeans;
mod lasso;
mod lbfgs;
mod least_squares;
mod lognormal;
pub mod rotation;
mod spectral;

pub use aabb::Aabb;
pub use adam::{Adam, AdamConfig, AdamStep};
pub use banded::Smoother;
pub use bessel::{bessel_ratio, ln_bessel_i0_scaled};
pub use eigen::symmetric_eigen;
pub use kmeans::{KMeans, KMeansConfig, kmeans};
pub use lasso::{LassoConfig, lasso};
pub use lbfgs::{LbfgsConfig, minimise};
pub use least_squares::LeastSquares;
pub use lognormal::LogNormal;
pub use spectral::{Rows, orthonormal_rows, singular_values, spectral_proximal};
