//! The room as a signed distance field: positive in free space, negative inside solids.
//!
//! See [`bake`] for how it is made and what counts as solid. May not name objects or categories: it sees
//! triangles only.

mod bake;
mod distance;
mod fronts;
pub(super) mod grid;
pub(super) mod indoors;
pub(super) mod lines;
mod open;
mod sign;
mod standing;
mod sweep;
#[cfg(test)]
pub(super) mod test_room;
#[cfg(test)]
mod tests;
mod thin;

use glam::{UVec3, Vec3};

use crate::math::Aabb;

pub use bake::{FieldConfig, Resolution, bake, bake_cached};
pub use open::OpenBlocks;

#[cfg(test)]
pub(in crate::scene) use test_room::triangles as test_room_triangles;

/// Distances at the nodes of a regular grid, interpolated trilinearly between them.
#[derive(Clone, Debug, PartialEq)]
pub struct SignedDistanceField {
    /// Samples along x, y and z; at least 2 each.
    pub dim: [usize; 3],
    /// Position of sample (0, 0, 0), world frame.
    pub origin: Vec3,
    /// Spacing of the samples in metres.
    pub cell_m: Vec3,
    /// Distance in metres, positive in free space; sample (x, y, z) at `(x * dim[1] + y) * dim[2] + z`.
    pub values: Vec<f32>,
}

impl SignedDistanceField {
    /// The box that the samples span.
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.origin, max: self.origin + self.last() * self.cell_m }
    }

    /// Whether `p` lies inside the grid.
    pub fn contains(&self, p: Vec3) -> bool {
        self.bounds().contains(p)
    }

    /// Position of sample (x, y, z).
    pub fn position(&self, x: usize, y: usize, z: usize) -> Vec3 {
        self.origin + Vec3::new(x as f32, y as f32, z as f32) * self.cell_m
    }

    /// The value at sample (x, y, z).
    pub fn at(&self, x: usize, y: usize, z: usize) -> f32 {
        self.values[(x * self.dim[1] + y) * self.dim[2] + z]
    }

    fn last(&self) -> Vec3 {
        Vec3::new((self.dim[0] - 1) as f32, (self.dim[1] - 1) as f32, (self.dim[2] - 1) as f32)
    }

    /// The eight corners of the cell that holds `p` (clamped into the grid), the place inside the cell
    /// (0 to 1 each) and how far `p` was moved by the clamping, in metres.
    #[inline]
    fn cell(&self, p: Vec3) -> ([f32; 8], Vec3, Vec3) {
        let in_cells = (p - self.origin) / self.cell_m;
        // max before min, so that NaN ends at sample 0 and never indexes outside.
        let inside = in_cells.max(Vec3::ZERO).min(self.last());
        // Truncation is the floor of what is not negative, and needs no call on any processor.
        let cells = UVec3::new(self.dim[0] as u32, self.dim[1] as u32, self.dim[2] as u32) - 2;
        let corner = inside.as_uvec3().min(cells);
        let base = corner.as_vec3();
        let (x, y, z) = (corner.x as usize, corner.y as usize, corner.z as usize);
        let row = self.dim[2];
        let plane = self.dim[1] * row;
        let start = x * plane + y * row + z;
        let block = &self.values[start..start + plane + row + 2];
        let corners = [
            block[0],
            block[1],
            block[row],
            block[row + 1],
            block[plane],
            block[plane + 1],
            block[plane + row],
            block[plane + row + 1],
        ];
        (corners, inside - base, (in_cells - inside) * self.cell_m)
    }

    /// Signed distance at `p` in metres. Outside the grid: the value at the border, at most 0, less the
    /// distance to the grid, so that nothing out there is ever free space.
    #[inline]
    pub fn sample(&self, p: Vec3) -> f32 {
        let (c, f, beyond) = self.cell(p);
        let value = interpolate(&c, f).0;
        if beyond == Vec3::ZERO { value } else { value.min(0.0) - beyond.length() }
    }

    /// Signed distance at `p` and its exact derivative by `p`. Outside the grid the derivative points back to it.
    #[inline]
    pub fn sample_gradient(&self, p: Vec3) -> (f32, Vec3) {
        let (c, f, beyond) = self.cell(p);
        let (value, slope) = interpolate(&c, f);
        let mut gradient = slope / self.cell_m;
        if beyond == Vec3::ZERO {
            return (value, gradient);
        }
        if value > 0.0 {
            gradient = Vec3::ZERO;
        }
        let away = beyond.length();
        let clamped = Vec3::select(beyond.cmpeq(Vec3::ZERO), gradient, Vec3::ZERO);
        (value.min(0.0) - away, clamped - beyond / away)
    }
}

/// Trilinear value and its derivative by the place in the cell; corners with z fastest, then y, then x.
#[inline]
fn interpolate(c: &[f32; 8], f: Vec3) -> (f32, Vec3) {
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let (z00, z01) = (lerp(c[0], c[1], f.z), lerp(c[2], c[3], f.z));
    let (z10, z11) = (lerp(c[4], c[5], f.z), lerp(c[6], c[7], f.z));
    let (y0, y1) = (lerp(z00, z01, f.y), lerp(z10, z11, f.y));
    let dz0 = lerp(c[1] - c[0], c[3] - c[2], f.y);
    let dz1 = lerp(c[5] - c[4], c[7] - c[6], f.y);
    let slope = Vec3::new(y1 - y0, lerp(z01 - z00, z11 - z10, f.x), lerp(dz0, dz1, f.x));
    (lerp(y0, y1, f.x), slope)
}
