//! Photos and the people in them, as it really is: the part of the engine behind *Fit to a photo*.

use std::path::Path;

use super::engine::{Made, Photo, PhotoTask};
use crate::assets::Budget;
use crate::assets::PictureKeypoints;
use crate::assets::read_keypoints;
use crate::assets::read_photo;
use crate::evolve::PopulatePreview;
use crate::job::{JobCtx, Stop};
use crate::render::Picture;

/// Reads a photo and the keypoints of whoever is in it.
///
/// # Errors
/// What, which file and place, what to do.
pub fn open(picture: &Path, keypoints: &Path) -> Result<Photo, Stop> {
    let budget = Budget::default();
    let (texture, size_px) = read_photo(picture, &budget)?;
    let name = picture.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let pictures = read_keypoints(keypoints, &budget)?;
    let people = of_picture(pictures, &name).ok_or_else(|| {
        let file = keypoints.display();
        Stop::Failed(format!("{file}: it has keypoints of other pictures, but none of {name}. Choose the file that belongs to it."))
    })?;
    let (width, height) = (texture.width, texture.height);
    let picture = Picture { width, height, rgba: texture.rgba, backend: String::new() };
    Ok(Photo { picture, size_px, people: people.people })
}

/// The entry of the picture called `name`; the only one where the file names none.
fn of_picture(mut pictures: Vec<PictureKeypoints>, name: &str) -> Option<PictureKeypoints> {
    let by_name = pictures.iter().position(|picture| {
        let file = picture.name.as_deref().map(|of| of.rsplit(['/', '\\']).next().unwrap_or(of));
        file == Some(name)
    });
    match by_name {
        Some(at) => Some(pictures.swap_remove(at)),
        None if pictures.len() == 1 => pictures.pop(),
        None => None,
    }
}

/// Finds a person of a photo in the room.
///
/// # Errors
/// Why it can't be found; or cancelled.
pub fn fit(_task: &PhotoTask, _cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
    Err(Stop::Failed("the estimator is not part of this build".to_owned()))
}
