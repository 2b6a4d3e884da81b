//! People for other programs: posed or moving, skinned, in their painted clothes, as the bytes of a GLB.

use super::dress::{BodySurface, Outfit, SurfacePart};
use super::light::srgb_from_linear;
use crate::assets::{self, GlbWriteError, ObjectMotion};
use crate::body::{self, Body};
use crate::scene::{Clip, Person, Room, model_from_room};

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

/// The people of `clips` as moving, skinned bodies in one GLB, with `room` around them if it is given. Clips without
/// frames are left out; motions begin together.
///
/// # Errors
/// When a body or the room can't be written, which would be a bug.
pub fn clips_glb<'a>(
    name: &str,
    room: Option<&Room>,
    clips: impl IntoIterator<Item = &'a Clip>,
    surface: &BodySurface,
) -> Result<Vec<u8>, GlbWriteError> {
    moving_room_glb(name, room, &[], clips, surface)
}

/// As [`clips_glb`], with objects of the room that move or come on the same timeline.
///
/// # Errors
/// When a body or the room can't be written, which would be a bug.
pub fn moving_room_glb<'a>(
    name: &str,
    room: Option<&Room>,
    objects: &[ObjectMotion],
    clips: impl IntoIterator<Item = &'a Clip>,
    surface: &BodySurface,
) -> Result<Vec<u8>, GlbWriteError> {
    let moving = |clip: &Clip| body::skinned_clip(Body::bundled(), clip, colors(surface, clip.palette));
    let people: Vec<_> = clips.into_iter().filter_map(moving).collect();
    let room = room.map(model_from_room);
    assets::glb_of_motions(name, room.as_ref(), objects, &people)
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
