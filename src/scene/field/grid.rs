//! The sample grid while it is being baked: indices, positions and neighbours.

use glam::Vec3;

/// A regular grid of samples, z fastest.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Grid {
    /// Samples along x, y and z.
    pub dim: [usize; 3],
    /// Position of sample (0, 0, 0).
    pub origin: Vec3,
    /// Spacing in metres.
    pub cell_m: Vec3,
}

impl Grid {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.dim.iter().product()
    }

    /// Steps between neighbours along x, y and z.
    pub fn strides(&self) -> [usize; 3] {
        [self.dim[1] * self.dim[2], self.dim[2], 1]
    }

    /// Index of sample (x, y, z).
    #[inline]
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.dim[1] + y) * self.dim[2] + z
    }

    /// Sample (x, y, z) of an index.
    #[inline]
    pub fn place(&self, index: usize) -> [usize; 3] {
        let z = index % self.dim[2];
        let rest = index / self.dim[2];
        [rest / self.dim[1], rest % self.dim[1], z]
    }

    /// Position of sample (x, y, z).
    #[inline]
    pub fn position(&self, [x, y, z]: [usize; 3]) -> Vec3 {
        self.origin + Vec3::new(x as f32, y as f32, z as f32) * self.cell_m
    }

    /// Smallest and largest sample index along `axis` inside `low..=high` (metres), if there is any.
    #[inline]
    pub fn span(&self, axis: usize, low: f32, high: f32) -> Option<(usize, usize)> {
        let first = ((low - self.origin[axis]) / self.cell_m[axis]).ceil().max(0.0);
        let last = ((high - self.origin[axis]) / self.cell_m[axis]).floor().min((self.dim[axis] - 1) as f32);
        (first <= last).then_some((first as usize, last as usize))
    }
}
