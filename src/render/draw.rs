//! What is to be drawn, apart from how: plain values, cheap to clone, compared by pointer on their way to
//! the graphics card. Draws nothing itself.

use std::sync::Arc;

use glam::Vec3;

use super::RenderError;
use super::dress::BodySurface;
use crate::math::Aabb;
use crate::scene::{Camera, ObjectId, PersonId, Room, Scene};

/// Everything that one picture shows. Room and vertices are compared by pointer, so keep the `Arc`s of
/// what has not changed: only what is new goes to the graphics card.
#[derive(Clone, Debug, Default)]
pub struct SceneDraw {
    /// The room, hidden objects left out.
    pub room: Arc<Room>,
    /// The surface that all people share; needed as soon as there are people.
    pub body: Option<Arc<BodySurface>>,
    /// The people to draw.
    pub people: Vec<PersonDraw>,
    /// Objects with a selection outline.
    pub selected_objects: Vec<ObjectId>,
    /// Straight lines: axes, gizmos, rays, camera frusta.
    pub lines: Vec<Line>,
    /// Round markers.
    pub points: Vec<Point>,
    /// How the picture is made.
    pub look: Look,
}

impl SceneDraw {
    /// The room of `scene` and nobody in it; people come as [`PersonDraw`] because their vertices are
    /// computed elsewhere.
    pub fn of_room(scene: &Scene) -> Self {
        Self { room: Arc::clone(&scene.room), ..Self::default() }
    }

    /// The box around room and people in the world frame.
    pub fn bounds(&self) -> Aabb {
        let people = self.people.iter().flat_map(|p| p.vertices.iter().copied());
        Aabb::of(people).union(self.room.bounds())
    }

    /// Checks that every person's arrays belong to the body surface.
    ///
    /// # Errors
    /// [`RenderError::NoBodySurface`] and [`RenderError::PersonShape`].
    pub fn check(&self) -> Result<(), RenderError> {
        let Some(body) = &self.body else {
            return match self.people.len() {
                0 => Ok(()),
                people => Err(RenderError::NoBodySurface { people }),
            };
        };
        let expected = body.vertex_count();
        for person in &self.people {
            let heat = person.heat.as_ref().map_or(expected, |h| h.len());
            for (what, found) in [("vertices", person.vertices.len()), ("heat values", heat)] {
                if found != expected {
                    return Err(RenderError::PersonShape { person: person.id, what, found, expected });
                }
            }
        }
        Ok(())
    }
}

/// One person to draw.
#[derive(Clone, Debug)]
pub struct PersonDraw {
    /// Who it is; names the buffers that are kept on the graphics card.
    pub id: PersonId,
    /// Vertices of the posed body, metres, world frame, in the order of [`BodySurface`].
    pub vertices: Arc<[Vec3]>,
    /// Chooses clothes, skin and hair: [`crate::scene::Person::palette`].
    pub palette: u32,
    /// Signed distance in metres of each vertex to the room (negative inside something solid): painted
    /// in the colours of [`super::heat_color`] instead of clothes.
    pub heat: Option<Arc<[f32]>>,
    /// 1 solid; less draws a ghost (a preview that is still being fitted).
    pub alpha: f32,
    /// Drawn with the selection outline.
    pub selected: bool,
}

impl PersonDraw {
    /// A solid, dressed, unselected person.
    pub fn new(id: PersonId, vertices: Arc<[Vec3]>, palette: u32) -> Self {
        Self { id, vertices, palette, heat: None, alpha: 1.0, selected: false }
    }
}

/// A straight line of constant width on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// One end, metres, world frame.
    pub from: Vec3,
    /// The other end.
    pub to: Vec3,
    /// sRGB with alpha.
    pub color: [u8; 4],
    /// Width in pixels.
    pub width_px: f32,
    /// Whether things in front hide it.
    pub depth: DepthTest,
}

/// A round marker of constant size on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where, metres, world frame.
    pub at: Vec3,
    /// sRGB with alpha.
    pub color: [u8; 4],
    /// Diameter in pixels.
    pub size_px: f32,
    /// Whether things in front hide it.
    pub depth: DepthTest,
}

/// Whether things in front hide a line or marker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DepthTest {
    /// Hidden by what is nearer to the camera.
    #[default]
    Hidden,
    /// Always on top, as gizmos are.
    OnTop,
}

/// How much work a picture may cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// For software adapters and moving cameras: fewer shadow and occlusion samples.
    Low,
    /// For graphics cards and still pictures.
    #[default]
    High,
}

/// When walls and ceiling between camera and room are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cutaway {
    /// While the camera stands outside the room.
    #[default]
    Outside,
    /// Never: everything is drawn as it is.
    Off,
}

/// Whether a part of the picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// It is.
    Yes,
    /// It is not.
    No,
}

/// How a picture is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Work per picture.
    pub quality: Quality,
    /// Walls and ceiling between camera and room.
    pub cutaway: Cutaway,
    /// The ground grid, 1 m apart, fading out.
    pub grid: Shown,
    /// The colour scale of the heat map, drawn into headless pictures when anybody is painted by heat.
    pub legend: Shown,
    /// sRGB colour behind everything.
    pub background: [u8; 3],
}

impl Default for Look {
    fn default() -> Self {
        Self {
            quality: Quality::High,
            cutaway: Cutaway::Outside,
            grid: Shown::Yes,
            legend: Shown::Yes,
            background: [58, 61, 66],
        }
    }
}

impl Look {
    /// The point that the room's shell is cut open for: the eye, or far behind an orthographic picture.
    pub(super) fn cut_eye(camera: &Camera) -> Vec3 {
        match camera.ortho_height_m {
            None => camera.eye,
            Some(_) => camera.target - camera.forward() * 1000.0,
        }
    }

    /// Whether the room within `bounds` is cut open for `camera`: it stands outside.
    pub(super) fn cuts(&self, camera: &Camera, bounds: &Aabb) -> bool {
        let outside = camera.ortho_height_m.is_some() || !bounds.contains(camera.eye);
        self.cutaway == Cutaway::Outside && outside
    }
}

/// Refuses a camera that is not finite; one that looks nowhere is fine (it looks along -z).
///
/// # Errors
/// [`RenderError::Camera`].
pub fn check_camera(camera: &Camera) -> Result<(), RenderError> {
    let finite = camera.eye.is_finite() && camera.target.is_finite() && camera.fov_y.is_finite();
    if finite && camera.ortho_height_m.is_none_or(f32::is_finite) {
        return Ok(());
    }
    Err(RenderError::Camera { eye: camera.eye.to_string(), target: camera.target.to_string() })
}
