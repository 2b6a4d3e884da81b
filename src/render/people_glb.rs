//! People for other programs: posed, skinned, in their painted clothes, as the bytes of a GLB.

use super::dress::{BodySurface, Outfit, SurfacePart};
use super::light::srgb_from_linear;
use crate::assets::{self, GlbWriteError};
use crate::body::{self, Body};
use crate::scene::Person;

/// Width over which colours blend at a seam: less than the mesh's own spacing, so every vertex has one colour.
const SEAM_M: f32 = 1e-3;

/// One person as a skinned GLB in the room's frame.
///
/// # Errors
/// When the body can't be written, which would be a bug.
pub fn person_glb(person: &Person, surface: &BodySurface) -> Result<Vec<u8>, GlbWriteError> {
    let colors = colors(surface, person.palette);
    let skinned = body::skinned_mesh(Body::bundled(), &person.name, &person.body, colors);
    assets::glb_from_skinned(&skinned)
}

/// sRGB colour of every vertex in the clothes that `palette` chooses.
fn colors(surface: &BodySurface, palette: u32) -> Vec<[u8; 4]> {
    let outfit = Outfit::from_palette(palette);
    let color = |vertex: usize| {
        let rest = surface.rest(vertex);
        let linear = match surface.part(vertex) {
            SurfacePart::Eye => outfit.eye_at(rest, SEAM_M),
            _ => outfit.color_at(rest, SEAM_M),
        };
        let [r, g, b] = linear.to_array().map(srgb_from_linear);
        [r, g, b, 255]
    };
    (0..surface.vertex_count()).map(color).collect()
}
