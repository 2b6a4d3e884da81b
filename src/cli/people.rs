//! People as files: posed, skinned, in their painted clothes.

use crate::assets;
use crate::body::{self, Body};
use crate::render::{BodySurface, Outfit, SurfacePart, srgb_from_linear};
use crate::scene::Person;

/// Width over which colours blend at a seam: less than the mesh's own spacing, so every vertex has one colour.
const SEAM_M: f32 = 1e-3;

/// One person as a skinned GLB in the room's frame.
///
/// # Errors
/// When the body can't be written, which would be a bug.
pub fn person_glb(person: &Person, surface: &BodySurface) -> anyhow::Result<Vec<u8>> {
    let colors = colors(surface, person.palette);
    let skinned = body::skinned_mesh(Body::bundled(), &person.name, &person.body, colors);
    Ok(assets::glb_from_skinned(&skinned)?)
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
