//! Values to GLB (glTF 2.0, binary): placed models, and skinned bodies that are posed or move.
//!
//! Every node gets at most one matrix, so positions and transforms read back bit for bit; meshes and pictures
//! that are shared stay shared. May not touch the disk: it returns the file's bytes.

mod buffer;
mod json;
mod model;
mod motion;
mod moving;
mod skinned;
#[cfg(test)]
mod tests;

pub use model::glb_from_model;
pub use motion::SkinMotion;
pub use moving::{ObjectKey, ObjectMotion};
pub use skinned::{SkinJoint, SkinnedMesh, glb_from_skinned, glb_of_motions, glb_with_people};

/// Why a value can't be written as GLB.
#[derive(Debug, thiserror::Error)]
pub enum GlbWriteError {
    /// A coordinate is NaN or infinite.
    #[error("'{what}' holds a number that is not finite in its {array}; repair the mesh before exporting it")]
    NotFinite {
        /// Object or mesh.
        what: String,
        /// Which of its arrays.
        array: &'static str,
    },
    /// An index points past the end of what it indexes.
    #[error("'{what}' points to {array} number {index}, but there are only {count}")]
    OutOfRange {
        /// Object or mesh.
        what: String,
        /// Which array it points into.
        array: &'static str,
        /// The bad index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Two arrays that belong together differ in length.
    #[error("'{what}' has {found} {array}, but {expected} are needed")]
    Length {
        /// Object or mesh.
        what: String,
        /// Which array.
        array: &'static str,
        /// Its length.
        found: usize,
        /// The length it needs.
        expected: usize,
    },
    /// A vertex follows no joint.
    #[error("vertex {vertex} of '{what}' has no positive skin weight; give it at least one")]
    Unweighted {
        /// The mesh.
        what: String,
        /// Its vertex.
        vertex: usize,
    },
    /// An object's `extras` are not JSON.
    #[error("the extras of '{what}' are not JSON: {source}")]
    Extras {
        /// The object.
        what: String,
        /// What the parser says.
        source: serde_json::Error,
    },
    /// A picture can't be encoded.
    #[error("picture '{what}' can't be encoded as PNG: {source}")]
    Picture {
        /// The picture.
        what: String,
        /// What the encoder says.
        source: image::ImageError,
    },
    /// The file would not fit GLB's 32-bit lengths.
    #[error("the file would be {bytes} bytes long; GLB ends at 4 GiB: export fewer objects at once")]
    TooLarge {
        /// Length it would have.
        bytes: usize,
    },
    /// The JSON chunk can't be written.
    #[error("the JSON chunk can't be written: {0}")]
    Json(#[from] serde_json::Error),
}
