use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::projection::Projection;
use super::view::{Intrinsics, View};
use super::{MAX_DEPTH_M, category_of};

/// Columns and rows of the networks' images (PSI §3.1).
pub const SIDE: usize = 128;
/// Labels are cut here in the paper's scalar encoding: mpcat40's unlabelled (PSI-release).
const LAST_MPCAT40: f32 = 41.0;

/// The part of a [`SceneImage`] that isn't padding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Valid {
    /// First column.
    pub left: u32,
    /// First row.
    pub top: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// What the networks see: depth and semantics, 128 x 128, from a camera whose picture is that square.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneImage {
    /// Depth along the axis in metres, cut at [`MAX_DEPTH_M`], row by row; 0 where nothing is and in the padding.
    pub depth_m: Vec<f32>,
    /// What is seen ([`super::label_of`]); 0 where nothing is and in the padding.
    pub labels: Vec<u8>,
    /// Where the picture is not padding.
    pub valid: Valid,
    /// The largest depth in the image after cutting; [`MAX_DEPTH_M`] if nothing is seen.
    pub max_depth_m: f32,
    /// The camera of the whole square.
    pub view: View,
}

impl Valid {
    /// The square camera that sees what `view` sees, its long side on 128 pixels, and where in the square the
    /// picture lies. The short side is rounded to an even number (PSI-release), and centred.
    pub fn of(view: &View) -> (View, Self) {
        let Intrinsics { width, height, focal_px } = view.intrinsics;
        let scale = SIDE as f32 / width.max(height).max(1) as f32;
        let even = |pixels: u32| (((pixels as f32 * scale * 0.5).round() as u32) * 2).clamp(2, SIDE as u32);
        let (columns, rows) = (even(width), even(height));
        let valid = Self {
            left: (SIDE as u32 - columns) / 2,
            top: (SIDE as u32 - rows) / 2,
            width: columns,
            height: rows,
        };
        let intrinsics = Intrinsics { width: SIDE as u32, height: SIDE as u32, focal_px: focal_px * scale };
        (View { intrinsics, ..*view }, valid)
    }

    /// Whether the pixel in column `x` and row `y` is part of the picture.
    pub fn contains(&self, x: usize, y: usize) -> bool {
        let within = |at: usize, first: u32, size: u32| (first..first + size).contains(&(at as u32));
        within(x, self.left, self.width) && within(y, self.top, self.height)
    }

    /// One value a pixel of the square, row by row.
    pub fn mask(&self) -> Vec<bool> {
        (0..SIDE * SIDE).map(|at| self.contains(at % SIDE, at / SIDE)).collect()
    }
}

impl SceneImage {
    /// From the pixels of the valid part, row by row.
    pub(super) fn padded(view: View, valid: Valid, depth_m: &[f32], labels: &[u8]) -> Self {
        let (mut all_depth_m, mut all_labels) = (vec![0.0; SIDE * SIDE], vec![0; SIDE * SIDE]);
        let width = valid.width as usize;
        for row in 0..valid.height as usize {
            let to = (valid.top as usize + row) * SIDE + valid.left as usize;
            all_depth_m[to..to + width].copy_from_slice(&depth_m[row * width..(row + 1) * width]);
            all_labels[to..to + width].copy_from_slice(&labels[row * width..(row + 1) * width]);
        }
        Self::new(view, valid, all_depth_m, all_labels)
    }

    /// From the whole square, row by row: for corpora that store it. Depth is cut and its largest value found.
    /// `view` is the square camera, `depth_m` and `labels` have 128 x 128 entries.
    pub fn new(view: View, valid: Valid, mut depth_m: Vec<f32>, labels: Vec<u8>) -> Self {
        depth_m.iter_mut().for_each(|d| *d = d.clamp(0.0, MAX_DEPTH_M));
        let deepest = depth_m.iter().copied().fold(0.0, f32::max);
        let max_depth_m = if deepest > 0.0 { deepest } else { MAX_DEPTH_M };
        Self { depth_m, labels, valid, max_depth_m, view }
    }

    /// π of this image.
    pub fn projection(&self) -> Projection {
        Projection::new(&self.view.intrinsics, self.max_depth_m)
    }

    /// Depth as PSI's networks take it: `2 d / max_depth - 1`, row by row; 0, the middle value, in the padding.
    pub fn depth_channel(&self) -> Vec<f32> {
        let value = |at: usize| 2.0 * self.depth_m[at] / self.max_depth_m - 1.0;
        self.channel(value)
    }

    /// Semantics as the published code takes them: `2 l / max - 1` with mpcat40's number `l` (at most 41) and the
    /// image's own largest number; 0 in the padding. One class has different values in different images:
    /// networks of ours embed [`SceneImage::labels`] by class; this is the paper's preset.
    pub fn paper_semantics_channel(&self) -> Vec<f32> {
        let number = |at: usize| {
            category_of(self.labels[at]).map_or(0.0, |c| f32::from(c.mpcat40())).min(LAST_MPCAT40)
        };
        let most = (0..SIDE * SIDE).map(number).fold(1.0, f32::max);
        self.channel(|at| 2.0 * number(at) / most - 1.0)
    }

    fn channel(&self, value: impl Fn(usize) -> f32) -> Vec<f32> {
        let at = |at: usize| if self.valid.contains(at % SIDE, at / SIDE) { value(at) } else { 0.0 };
        (0..SIDE * SIDE).map(at).collect()
    }

    /// The depth in metres at a pixel (column, row) of the square; `None` where nothing is seen.
    pub fn depth_at(&self, pixel: Vec2) -> Option<f32> {
        let inside = self.view.holds(pixel);
        let at = inside.then(|| pixel.y as usize * SIDE + pixel.x as usize)?;
        (self.depth_m[at] > 0.0).then_some(self.depth_m[at])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::sensor::label_of;
    use crate::scene::Category;
    use glam::Vec3;

    fn wide() -> (View, Valid) {
        Valid::of(&View::look_at(Vec3::ZERO, Vec3::Z, Intrinsics::PROX_E))
    }

    #[test]
    fn a_wide_picture_is_centred_between_padding_with_its_aspect_kept() {
        let (square, valid) = wide();
        assert_eq!(valid, Valid { left: 0, top: 28, width: 128, height: 72 });
        assert_eq!(valid.mask().iter().filter(|v| **v).count(), 128 * 72);
        let tall = Intrinsics { width: 100, height: 401, focal_px: 300.0 };
        let (_, valid) = Valid::of(&View { intrinsics: tall, ..square });
        assert_eq!((valid.left, valid.width, valid.height), (48, 32, 128));
    }

    #[test]
    fn the_square_camera_normalises_points_as_the_original_one() {
        let (square, _) = wide();
        let p = Vec3::new(0.7, -0.4, 2.5);
        let original = Projection::new(&Intrinsics::PROX_E, 5.0).normalize(p);
        assert!(Projection::new(&square.intrinsics, 5.0).normalize(p).abs_diff_eq(original, 1e-5));
    }

    #[test]
    fn channels_are_scaled_by_the_images_largest_value_and_padding_is_zero() {
        let (view, valid) = wide();
        let (mut depth_m, mut labels) = (vec![2.0; 128 * 72], vec![label_of(Category::Wall); 128 * 72]);
        (depth_m[0], labels[0]) = (9.0, label_of(Category::CoffeeTable));
        let image = SceneImage::padded(view, valid, &depth_m, &labels);
        assert_eq!(image.max_depth_m, MAX_DEPTH_M);
        let (depth, semantics) = (image.depth_channel(), image.paper_semantics_channel());
        let first = 28 * SIDE;
        assert_eq!((depth[0], semantics[0]), (0.0, 0.0));
        assert_eq!((depth[first], semantics[first]), (1.0, 1.0));
        assert!((depth[first + 1] - (2.0 * 2.0 / 6.0 - 1.0)).abs() < 1e-6);
        assert!((semantics[first + 1] - (2.0 / 5.0 - 1.0)).abs() < 1e-6, "wall is 1, table is 5");
    }
}
