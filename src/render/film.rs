//! Motions as a sequence of pictures at even times. Draws one when asked; writes no file.

use std::sync::Arc;

use super::RenderError;
use super::draw::{PersonDraw, SceneDraw};
use super::painter::Painter;
use super::picture::Picture;
use crate::body::Body;
use crate::scene::{Camera, Clip, PersonId};

/// Numbers of moving people lie apart from those of people who stand in the room, who count from 0.
const MOVING_IDS: u32 = 1 << 30;

/// What a film shows: a scene, and the clips that play in it.
#[derive(Clone, Debug)]
pub struct Film {
    /// Room, look and whoever does not move; needs its body surface.
    pub scene: SceneDraw,
    /// Who moves. All begin together; whoever is done stays as in the last frame.
    pub clips: Vec<Arc<Clip>>,
    /// From where.
    pub camera: Camera,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Pictures in a second.
    pub fps: f32,
}

impl Film {
    /// How many pictures there are; 1 where nothing moves.
    pub fn pictures(&self) -> usize {
        let seconds = self.clips.iter().map(|clip| clip.seconds()).fold(0.0, f32::max);
        (seconds * self.fps + 1e-3).floor() as usize + 1
    }

    /// What picture number `picture` shows.
    pub fn scene_at(&self, picture: usize) -> SceneDraw {
        let seconds = picture as f32 / self.fps;
        let moving = self.clips.iter().filter_map(|clip| moving_at(clip, seconds));
        let mut scene = self.scene.clone();
        scene.people.extend(moving);
        scene
    }

    /// Draws picture number `picture`.
    ///
    /// # Errors
    /// As [`Painter::picture`].
    pub fn draw(&self, painter: &Painter, picture: usize) -> Result<Picture, RenderError> {
        painter.picture(&self.scene_at(picture), &self.camera, self.size)
    }
}

/// The person of a clip at a time; nobody in a clip without frames.
fn moving_at(clip: &Clip, seconds: f32) -> Option<PersonDraw> {
    let frame = clip.frames.get(clip.frame_at(seconds))?;
    let vertices = Body::bundled().pose_frame(&clip.betas, frame).vertices.into();
    Some(PersonDraw::new(PersonId(MOVING_IDS + clip.id.0), vertices, clip.palette))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Frame;
    use glam::Vec3;

    #[test]
    fn a_film_of_two_clips_lasts_as_long_as_the_longer_and_the_other_waits() {
        let walk = |frames: usize| {
            let frame = |i: usize| Frame { translation: Vec3::X * i as f32 * 0.1, ..Frame::default() };
            Arc::new(Clip { frames: (0..frames).map(frame).collect(), ..Clip::default() })
        };
        let film = Film {
            scene: SceneDraw::default(),
            clips: vec![walk(31), walk(61), walk(0)],
            camera: Camera::default(),
            size: [8, 8],
            fps: 10.0,
        };
        assert_eq!(film.pictures(), 21, "two seconds and both ends");
        let x = |picture: usize, person: usize| {
            let people = film.scene_at(picture).people;
            assert_eq!(people.len(), 2, "a plan shows nobody");
            people[person].vertices.iter().map(|v| v.x).sum::<f32>() / people[person].vertices.len() as f32
        };
        assert!((x(10, 1) - x(0, 1) - 3.0).abs() < 1e-3, "one second is thirty frames");
        assert!((x(20, 0) - x(10, 0)).abs() < 1e-6 && (x(20, 1) - x(10, 1) - 3.0).abs() < 1e-3);
    }
}
