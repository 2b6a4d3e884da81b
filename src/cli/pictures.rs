//! Pictures of a run: the whole room from opposite corners and everybody from at least two sides.

use std::sync::Arc;

use super::output::OutputFolder;
use crate::assets;
use crate::body::Body;
use crate::evolve::PopulatedPerson;
use crate::render::{
    Backend, BodySurface, Cutaway, Painter, PersonDraw, Picture, SceneDraw, person_views, room_views,
};
use crate::scene::{Camera, Person, PersonId, RoomGeometry, Scene};

/// Size of the overview pictures.
const ROOM_SIZE: [u32; 2] = [1280, 800];
/// Size of the pictures of one person.
const PERSON_SIZE: [u32; 2] = [560, 560];

/// Draws a run's pictures into its folder.
pub struct Photographer<'a> {
    folder: &'a OutputFolder,
    painter: Painter,
    draw: SceneDraw,
}

impl<'a> Photographer<'a> {
    /// For `scene` with everybody in it, dressed.
    ///
    /// # Errors
    /// None with the default backend: without an adapter the processor draws.
    pub fn new(folder: &'a OutputFolder, scene: &Scene) -> anyhow::Result<Self> {
        let body = Body::bundled();
        let mut draw = SceneDraw::of_room(scene);
        draw.body = Some(Arc::new(BodySurface::of(body)));
        let dressed = |p: &Person| PersonDraw::new(p.id, body.pose(&p.body).vertices.into(), p.palette);
        draw.people = scene.people.iter().filter(|p| p.visible).map(dressed).collect();
        Ok(Self { folder, painter: Painter::new(Backend::Auto)?, draw })
    }

    /// The adapter's name, or the ray caster's, and why it had to stand in.
    pub fn made_by(&self) -> String {
        match self.painter.fallback_reason() {
            Some(reason) => format!("{}, because {reason}", self.painter.backend()),
            None => self.painter.backend().to_owned(),
        }
    }

    /// The room from two opposite corners, its near walls cut away.
    ///
    /// # Errors
    /// When a picture can't be drawn or written.
    pub fn room(&self) -> anyhow::Result<()> {
        let mut draw = self.draw.clone();
        draw.look.cutaway = Cutaway::Outside;
        let aspect = ROOM_SIZE[0] as f32 / ROOM_SIZE[1] as f32;
        for (i, camera) in room_views(&draw.room, aspect).iter().enumerate() {
            self.save(&format!("room_{i}"), &self.painter.picture(&draw, camera, ROOM_SIZE)?)?;
        }
        Ok(())
    }

    /// One person from `sides` sides, and once more by penetration and contact.
    ///
    /// # Errors
    /// When a picture can't be drawn or written.
    pub fn person(
        &self,
        person: &PopulatedPerson,
        geometry: &RoomGeometry,
        sides: usize,
    ) -> anyhow::Result<()> {
        let id = person.person.id;
        let Some(index) = self.draw.people.iter().position(|p| p.id == id) else { return Ok(()) };
        let vertices = &self.draw.people[index].vertices;
        let views: Vec<Camera> = person_views(vertices, &geometry.bvh, sides.max(2), 1.0);
        for (i, camera) in views.iter().enumerate() {
            let picture = self.painter.picture(&in_view_of(&self.draw, id, camera), camera, PERSON_SIZE)?;
            self.save(&format!("person_{:03}_side{i}", id.0), &picture)?;
        }
        let mut heat = self.draw.clone();
        heat.people[index].heat = Some(person.report.signed_distances_m.clone().into());
        if let Some(camera) = views.first() {
            let picture = self.painter.picture(&in_view_of(&heat, id, camera), camera, PERSON_SIZE)?;
            self.save(&format!("person_{:03}_heat", id.0), &picture)?;
        }
        Ok(())
    }

    fn save(&self, name: &str, picture: &Picture) -> anyhow::Result<()> {
        let png = assets::encode_png(picture.width, picture.height, &picture.rgba)?;
        self.folder.write(&format!("pictures/{name}.png"), &png)?;
        Ok(())
    }
}

/// The scene without the people who stand between the camera and the person it looks at.
fn in_view_of(draw: &SceneDraw, person: PersonId, camera: &Camera) -> SceneDraw {
    let nearest_m = |p: &PersonDraw| {
        let ahead = p.vertices.iter().map(|v| (*v - camera.eye).dot(camera.forward()));
        ahead.fold(f32::INFINITY, f32::min)
    };
    let limit = draw.people.iter().find(|p| p.id == person).map_or(0.0, nearest_m);
    let mut draw = draw.clone();
    draw.people.retain(|p| p.id == person || nearest_m(p) > limit);
    draw
}
