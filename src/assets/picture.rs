//! Decodes pictures, after their size has been checked against the budget.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::budget::Budget;
use super::error::{AssetError, Fault};
use super::model::{ImageFile, Texture};
use super::uri::read_plain_file;

/// A picture as a file holds it.
pub(super) struct EncodedPicture {
    pub name: String,
    /// Where it stands in the file.
    pub place: String,
    /// PNG or JPEG.
    pub bytes: Vec<u8>,
}

/// Decodes all pictures, on all threads. A picture that can't be decoded is replaced by a note: the room
/// is worth more than its wallpaper. Fails only when there are too many.
pub(super) fn decode_all(
    pictures: &[EncodedPicture],
    budget: &Budget,
) -> Result<Vec<Result<Arc<Texture>, String>>, Fault> {
    Budget::check("images", "images", pictures.len() as u64, budget.max_images as u64)?;
    let mut pixels = 0;
    let within: Vec<bool> = pictures
        .iter()
        .map(|picture| {
            // One that is too large by itself is left out with its own note.
            let decodable = sides(&picture.bytes).filter(|(w, h)| *w.max(h) <= budget.max_image_side);
            let (width, height) = decodable.unwrap_or_default();
            pixels += u64::from(width) * u64::from(height);
            pixels <= budget.max_pixels
        })
        .collect();
    let decode_one = |(picture, within): (&EncodedPicture, &bool)| match within {
        true => decode(picture, budget).map(Arc::new),
        false => Err(format!(
            "{}: left out, the pictures up to here have more pixels than the limit of {}. Make them smaller.",
            picture.place, budget.max_pixels
        )),
    };
    Ok(pictures.par_iter().zip(&within).map(decode_one).collect())
}

fn reader(bytes: &[u8]) -> Option<image::ImageReader<Cursor<&[u8]>>> {
    image::ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok()
}

fn sides(bytes: &[u8]) -> Option<(u32, u32)> {
    let mut reader = reader(bytes)?;
    // Only the header is read.
    reader.no_limits();
    reader.into_dimensions().ok()
}

fn decode(picture: &EncodedPicture, budget: &Budget) -> Result<Texture, String> {
    let left_out = |why: String| format!("{}: left out, {why}", picture.place);
    let (width, height) = sides(&picture.bytes).ok_or_else(|| {
        left_out("it is not a PNG or JPEG picture. Convert it to one of these.".to_string())
    })?;
    if width.max(height) > budget.max_image_side {
        return Err(left_out(format!(
            "{width} x {height} pixels are more than the limit of {} a side. Make it smaller.",
            budget.max_image_side
        )));
    }
    let mut reader = reader(&picture.bytes).ok_or_else(|| left_out("it can't be read".to_string()))?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(budget.max_image_side);
    limits.max_image_height = Some(budget.max_image_side);
    reader.limits(limits);
    let mime = match reader.format() {
        Some(image::ImageFormat::Jpeg) => "image/jpeg",
        _ => "image/png",
    };
    let decoded = reader.decode().map_err(|e| left_out(format!("it is damaged ({e}). Save it again.")))?;
    let mut kept = decoded.into_rgba8();
    while kept.width().max(kept.height()) > budget.kept_image_side {
        kept = halved(&kept);
    }
    let file = Some(ImageFile { mime, bytes: picture.bytes.as_slice().into() });
    let (width, height) = kept.dimensions();
    Ok(Texture { name: picture.name.clone(), width, height, rgba: kept.into_raw(), file })
}

/// Reads a photo, a PNG or JPEG file, and tells its columns and rows: large ones are kept halved.
///
/// # Errors
/// Names the file, what is wrong and what to do.
pub fn read_photo(path: &Path, budget: &Budget) -> Result<(Texture, [u32; 2]), AssetError> {
    let shown = path.display().to_string();
    let read = || {
        let bytes = read_plain_file(path, budget)?;
        let (width, height) = sides(&bytes)
            .ok_or_else(|| Fault::malformed("the first bytes", "it is not a PNG or JPEG picture"))?;
        let place = "the whole file".to_owned();
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let texture = decode(&EncodedPicture { name, place, bytes }, budget)
            .map_err(|why| Fault::malformed("the whole file", why))?;
        Ok((texture, [width, height]))
    };
    read().map_err(|fault: Fault| fault.in_file(&shown))
}

/// Every 2 x 2 pixels averaged into one.
fn halved(picture: &image::RgbaImage) -> image::RgbaImage {
    let (width, height) = (picture.width(), picture.height());
    image::RgbaImage::from_fn((width / 2).max(1), (height / 2).max(1), |x, y| {
        let at =
            |dx: u32, dy: u32| picture.get_pixel((2 * x + dx).min(width - 1), (2 * y + dy).min(height - 1)).0;
        let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        image::Rgba(std::array::from_fn(|c| (four.iter().map(|p| u32::from(p[c])).sum::<u32>() / 4) as u8))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(width: u32, height: u32) -> EncodedPicture {
        let mut bytes = Vec::new();
        let picture = image::RgbaImage::from_pixel(width, height, image::Rgba([200, 100, 50, 255]));
        picture.write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
        EncodedPicture { name: "wood".into(), place: "images[0]".into(), bytes }
    }

    #[test]
    fn a_picture_larger_than_is_kept_is_halved_until_it_fits() {
        let budget = Budget { kept_image_side: 10, ..Budget::default() };
        let texture = decode(&png(37, 5), &budget).unwrap();
        assert_eq!((texture.width, texture.height), (9, 1));
        assert!(texture.rgba.chunks(4).all(|p| p == [200, 100, 50, 255]));
    }

    #[test]
    fn pictures_over_the_limits_become_notes_that_name_their_place() {
        let small = Budget { max_image_side: 30, ..Budget::default() };
        assert!(decode(&png(37, 5), &small).unwrap_err().contains("images[0]"));
        let few = Budget { max_pixels: 100, ..Budget::default() };
        assert!(decode_all(&[png(37, 5)], &few).unwrap()[0].is_err());
    }
}
