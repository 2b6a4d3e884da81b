//! A person out of a photo: a picture with keypoints, laid over the 3-D view, whose camera is the present view.

use std::path::PathBuf;

use egui::{Rect, Vec2};

use super::engine::{Photo, PhotoMethod, PhotoTask};
use super::pictures::Shown;
use super::samples::Source;
use super::state::EditorState;
use crate::assets::PersonKeypoints;
use crate::job::{Job, JobCtx, Seed};
use crate::scene::Camera;

/// What the photo panel holds.
#[derive(Debug)]
pub struct PhotoPanel {
    /// Path of the picture as typed.
    pub picture_path: String,
    /// Path of its keypoints as typed.
    pub keypoints_path: String,
    /// The photo, once it is read.
    pub photo: Option<OpenedPhoto>,
    /// Which of its people.
    pub person: usize,
    /// How much of the photo is seen over the room.
    pub opacity: f32,
    /// How the person is found.
    pub method: PhotoMethod,
}

impl Default for PhotoPanel {
    fn default() -> Self {
        Self {
            picture_path: String::new(),
            keypoints_path: String::new(),
            photo: None,
            person: 0,
            opacity: 0.5,
            method: PhotoMethod::Scene,
        }
    }
}

/// A photo that was read.
#[derive(Debug)]
pub struct OpenedPhoto {
    /// Its pixels, perhaps fewer than the file's.
    pub picture: Shown,
    /// Columns and rows of the file.
    pub size_px: [u32; 2],
    /// Everybody who has keypoints.
    pub people: Vec<PersonKeypoints>,
}

impl OpenedPhoto {
    /// Where it lies in a view: as large as fits, in the middle.
    pub fn place(&self, view: Rect) -> Rect {
        let aspect = self.size_px[0] as f32 / self.size_px[1].max(1) as f32;
        let width = view.width().min(view.height() * aspect);
        Rect::from_center_size(view.center(), Vec2::new(width, width / aspect))
    }

    /// The camera that took it, when what it shows lies under it in a view `aspect` times as wide as high.
    pub fn camera(&self, view: &Camera, aspect: f32) -> Camera {
        let own = self.size_px[0] as f32 / self.size_px[1].max(1) as f32;
        let share_of_height = (aspect / own).min(1.0);
        let half = (0.5 * view.fov_y).tan() * share_of_height;
        Camera { fov_y: 2.0 * half.atan(), ortho_height_m: None, ..*view }
    }
}

impl EditorState {
    /// Reads the photo and the keypoints that the paths name.
    pub fn open_photo(&mut self) {
        let engine = self.engine.clone();
        let picture = PathBuf::from(self.photo.picture_path.trim());
        let keypoints = PathBuf::from(self.photo.keypoints_path.trim());
        let work = move |cx: &JobCtx| engine.open_photo(&picture, &keypoints, cx.ticker());
        self.jobs.photo = Some(Job::spawn("Open photo", Seed::root(0), self.waker(), work));
    }

    pub(super) fn poll_photo(&mut self) {
        let Some(job) = &mut self.jobs.photo else { return };
        let Some(outcome) = job.poll() else { return };
        let name = job.name().to_owned();
        self.jobs.photo = None;
        if let Some(Photo { picture, size_px, people }) = self.taken(&name, outcome) {
            let known = |person: &PersonKeypoints| person.known();
            let best = (0..people.len()).max_by(|&a, &b| known(&people[a]).total_cmp(&known(&people[b])));
            self.photo.person = best.unwrap_or_default();
            self.photo.photo = Some(OpenedPhoto { picture: picture.into(), size_px, people });
        }
    }

    /// Takes the photo off the view.
    pub fn close_photo(&mut self) {
        self.photo.photo = None;
    }

    /// Finds the chosen person of the photo in the room, the present view being the photo's camera.
    pub fn fit_photo(&mut self) {
        let Some(geometry) = self.geometry().cloned() else { return };
        let Some(photo) = &self.photo.photo else { return };
        let Some(keypoints) = photo.people.get(self.photo.person).cloned() else {
            self.notices.warning("The keypoint file has nobody for this photo.");
            return;
        };
        if self.jobs.populating() {
            self.notices.warning("People are being fitted already: wait or cancel.");
            return;
        }
        let task = PhotoTask {
            room: self.document.scene().room.clone(),
            geometry,
            camera: photo.camera(&self.orbit.camera(), self.aspect),
            size_px: photo.size_px,
            keypoints,
            method: self.photo.method,
            id: self.document.next_person(),
        };
        let source = Source { method: super::engine::SampleMethod::Photo, seen: None, cards: Vec::new() };
        let engine = self.engine.clone();
        let work = move |cx: &JobCtx<_>| engine.fit_photo(&task, cx);
        self.start_making("Fit to photo".to_owned(), work, source);
    }

    /// The person of the photo who is to be found.
    pub fn photo_keypoints(&self) -> Option<&PersonKeypoints> {
        self.photo.photo.as_ref()?.people.get(self.photo.person)
    }
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    fn photo(size_px: [u32; 2]) -> OpenedPhoto {
        let picture =
            crate::render::Picture { width: 1, height: 1, rgba: vec![0; 4], backend: String::new() };
        OpenedPhoto { picture: picture.into(), size_px, people: Vec::new() }
    }

    #[test]
    fn what_lies_under_a_pixel_of_the_photo_is_what_its_camera_sees_there() {
        let view = Rect::from_min_max(pos2(0.0, 0.0), pos2(900.0, 600.0));
        let camera = Camera { eye: glam::Vec3::new(3.0, 2.0, 1.0), ..Camera::default() };
        for size_px in [[400, 800], [1600, 400], [300, 200]] {
            let photo = photo(size_px);
            let place = photo.place(view);
            let own = photo.camera(&camera, 1.5);
            let point = glam::Vec3::new(0.3, 0.8, -0.2);
            let at = |camera: &Camera, aspect: f32, rect: Rect| {
                let ndc = camera.clip_from_world(aspect).project_point3(point);
                rect.min + Vec2::new((ndc.x + 1.0) * 0.5 * rect.width(), (1.0 - ndc.y) * 0.5 * rect.height())
            };
            let in_view = at(&camera, 1.5, view);
            let in_photo = at(&own, size_px[0] as f32 / size_px[1] as f32, place);
            assert!((in_view - in_photo).length() < 0.1, "{size_px:?}: {in_view} {in_photo}");
        }
    }
}
