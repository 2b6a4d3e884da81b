use super::error::{Fault, Problem};

/// How much of everything a file may ask for. Checked before anything is allocated.
#[derive(Clone, Debug, PartialEq)]
pub struct Budget {
    /// Bytes of one file, and of all files that it refers to.
    pub max_file_bytes: u64,
    /// Vertices over all different meshes.
    pub max_vertices: usize,
    /// Triangles over all placed meshes, each copy counted.
    pub max_triangles: usize,
    /// Nodes, groups, meshes and materials, each.
    pub max_nodes: usize,
    /// Nodes above one another.
    pub max_depth: usize,
    /// Pictures.
    pub max_images: usize,
    /// Columns or rows of one picture as stored.
    pub max_image_side: u32,
    /// Pixels over all pictures as stored.
    pub max_pixels: u64,
    /// Columns or rows of one picture as kept: larger ones are halved until they fit.
    pub kept_image_side: u32,
}

impl Default for Budget {
    /// Room for whole houses and ten-million-triangle scans on a machine with 8 GiB of memory.
    fn default() -> Self {
        Self {
            max_file_bytes: 2 << 30,
            max_vertices: 40_000_000,
            max_triangles: 40_000_000,
            max_nodes: 200_000,
            max_depth: 200,
            max_images: 2_000,
            max_image_side: 16_384,
            max_pixels: 1 << 30,
            kept_image_side: 2_048,
        }
    }
}

impl Budget {
    /// Refuses a `found` above `limit`.
    pub(super) fn check(place: &str, what: &'static str, found: u64, limit: u64) -> Result<(), Fault> {
        if found <= limit {
            return Ok(());
        }
        Err(Fault::new(place, Problem::OverBudget { what, found, limit }))
    }

    pub(super) fn check_bytes(&self, place: &str, bytes: u64) -> Result<(), Fault> {
        Self::check(place, "bytes", bytes, self.max_file_bytes)
    }

    pub(super) fn check_vertices(&self, place: &str, count: usize) -> Result<(), Fault> {
        Self::check(place, "vertices", count as u64, self.max_vertices as u64)
    }

    pub(super) fn check_triangles(&self, place: &str, count: usize) -> Result<(), Fault> {
        Self::check(place, "triangles", count as u64, self.max_triangles as u64)
    }

    pub(super) fn check_nodes(&self, place: &str, what: &'static str, count: usize) -> Result<(), Fault> {
        Self::check(place, what, count as u64, self.max_nodes as u64)
    }
}
