//! Writes animated GIF (GIF89a), a frame at a time so that no more than two are in memory.
//!
//! Each frame holds only what has changed since the one before, in up to 255 colours of its own, so that a still
//! room behind a walking figure costs nothing and does not flicker.

mod colors;
mod lzw;

use colors::{Palette, TRANSPARENT};

/// Longest side; the format has 16 bits for it.
const MAX_SIDE: u32 = u16::MAX as u32;
/// Shortest time that viewers show a frame, hundredths of a second; many take less for a tenth.
const SHORTEST_CS: u64 = 2;

/// Why pictures can't become a GIF.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GifError {
    /// No picture, or one beyond the format.
    #[error("a GIF can't be {width} x {height} pixels large; choose sides from 1 to 65535")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Another number of bytes than the picture's size says.
    #[error("a frame has {found} bytes of colour instead of {expected}; give every frame the same size")]
    Length {
        /// Bytes that are there.
        found: usize,
        /// Bytes that are needed.
        expected: usize,
    },
}

/// A GIF while frames are added; it plays for ever.
pub struct GifWriter {
    width: u32,
    height: u32,
    fps: f64,
    frames: u64,
    shown_cs: u64,
    last: Vec<u8>,
    file: Vec<u8>,
}

/// Columns and rows of the picture that a frame covers.
#[derive(Clone, Copy)]
struct Area {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl GifWriter {
    /// A GIF of this size at `fps` frames a second; above 50 viewers slow it down.
    ///
    /// # Errors
    /// [`GifError::Size`].
    pub fn new(width: u32, height: u32, fps: f32) -> Result<Self, GifError> {
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(GifError::Size { width, height });
        }
        let mut file = b"GIF89a".to_vec();
        file.extend((width as u16).to_le_bytes());
        file.extend((height as u16).to_le_bytes());
        // No palette for all, eight bits a colour.
        file.extend([0x70, 0, 0]);
        file.extend(b"\x21\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00");
        let fps = if fps.is_finite() && fps > 0.0 { f64::from(fps) } else { 1.0 };
        Ok(Self { width, height, fps, frames: 0, shown_cs: 0, last: Vec::new(), file })
    }

    /// Adds a frame: sRGB with alpha, which is not looked at; `width * height * 4` bytes, top row first.
    ///
    /// # Errors
    /// [`GifError::Length`].
    pub fn add(&mut self, rgba: &[u8]) -> Result<(), GifError> {
        let expected = self.width as usize * self.height as usize * 4;
        if rgba.len() != expected {
            return Err(GifError::Length { found: rgba.len(), expected });
        }
        let area = self.changed(rgba);
        let is_new = |pixel: usize| {
            self.last.is_empty() || self.last[4 * pixel..4 * pixel + 3] != rgba[4 * pixel..4 * pixel + 3]
        };
        let places: Vec<usize> = area.pixels(self.width as usize).collect();
        let color = |pixel: usize| [rgba[4 * pixel], rgba[4 * pixel + 1], rgba[4 * pixel + 2]];
        let palette = Palette::of(places.iter().filter(|p| is_new(**p)).map(|p| color(*p)));
        let index = |p: &usize| if is_new(*p) { palette.index(color(*p)) } else { TRANSPARENT };
        let indices: Vec<u8> = places.iter().map(index).collect();
        self.write_frame(area, &palette, &indices);
        self.last.clear();
        self.last.extend_from_slice(rgba);
        Ok(())
    }

    /// The file's bytes.
    pub fn finish(mut self) -> Vec<u8> {
        self.file.push(0x3b);
        self.file
    }

    /// The smallest area that holds every pixel that has changed; one pixel if none has.
    fn changed(&self, rgba: &[u8]) -> Area {
        let (width, height) = (self.width as usize, self.height as usize);
        if self.last.is_empty() {
            return Area { left: 0, top: 0, width, height };
        }
        let (mut left, mut right, mut top, mut bottom) = (width, 0, height, 0);
        for y in 0..height {
            let row = 4 * width * y..4 * width * (y + 1);
            let (now, before) = (&rgba[row.clone()], &self.last[row]);
            let differs = |x: &usize| now[4 * x..4 * x + 3] != before[4 * x..4 * x + 3];
            let Some(first) = (0..width).find(differs) else { continue };
            let last = (0..width).rfind(differs).unwrap_or(first);
            (left, right) = (left.min(first), right.max(last));
            (top, bottom) = (top.min(y), y);
        }
        if left > right {
            return Area { left: 0, top: 0, width: 1, height: 1 };
        }
        Area { left, top, width: right + 1 - left, height: bottom + 1 - top }
    }

    fn write_frame(&mut self, area: Area, palette: &Palette, indices: &[u8]) {
        let delay = self.next_delay_cs();
        let file = &mut self.file;
        // Drawn over what is there, one colour transparent.
        file.extend([0x21, 0xf9, 4, 0b0000_0101]);
        file.extend(delay.to_le_bytes());
        file.extend([TRANSPARENT, 0, 0x2c]);
        for side in [area.left, area.top, area.width, area.height] {
            file.extend((side as u16).to_le_bytes());
        }
        // A palette of 256 of its own.
        file.push(0x87);
        file.extend(palette.bytes());
        file.push(lzw::SYMBOL_BITS);
        for block in lzw::compress(indices).chunks(255) {
            file.push(block.len() as u8);
            file.extend_from_slice(block);
        }
        file.push(0);
    }

    /// How long the next frame is shown: hundredths of a second that add up to the frame rate in the long run.
    fn next_delay_cs(&mut self) -> u16 {
        self.frames += 1;
        let due = (self.frames as f64 * 100.0 / self.fps).round() as u64;
        let delay = due.saturating_sub(self.shown_cs).clamp(SHORTEST_CS, u64::from(u16::MAX));
        self.shown_cs += delay;
        delay as u16
    }
}

impl Area {
    /// Numbers of its pixels in a picture so many columns wide, row by row.
    fn pixels(self, columns: usize) -> impl Iterator<Item = usize> {
        let row = move |y: usize| (self.left..self.left + self.width).map(move |x| y * columns + x);
        (self.top..self.top + self.height).flat_map(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a viewer shows after each frame and for how many hundredths of a second: a reader of its own.
    fn shown(file: &[u8]) -> Vec<(Vec<[u8; 3]>, u16)> {
        let word = |at: usize| u16::from_le_bytes([file[at], file[at + 1]]);
        let (width, height) = (usize::from(word(6)), usize::from(word(8)));
        let mut canvas = vec![[0u8; 3]; width * height];
        let (mut at, mut frames, mut delay, mut clear) = (13, Vec::new(), 0, None);
        loop {
            match file[at] {
                0x3b => return frames,
                0x21 => {
                    if file[at + 1] == 0xf9 {
                        (delay, clear) = (word(at + 4), (file[at + 3] & 1 == 1).then_some(file[at + 6]));
                    }
                    at += 2;
                    while file[at] != 0 {
                        at += 1 + usize::from(file[at]);
                    }
                    at += 1;
                }
                0x2c => {
                    let [left, top, columns, rows] = [1, 3, 5, 7].map(|i| usize::from(word(at + i)));
                    let colors = 2usize << (file[at + 9] & 7);
                    let palette: Vec<[u8; 3]> =
                        file[at + 10..at + 10 + 3 * colors].chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
                    at += 10 + 3 * colors;
                    let bits = file[at];
                    let mut data = Vec::new();
                    at += 1;
                    while file[at] != 0 {
                        data.extend_from_slice(&file[at + 1..at + 1 + usize::from(file[at])]);
                        at += 1 + usize::from(file[at]);
                    }
                    at += 1;
                    let indices = lzw::expand(&data, bits);
                    assert_eq!(indices.len(), columns * rows);
                    for (i, index) in indices.iter().enumerate().filter(|(_, i)| Some(**i) != clear) {
                        canvas[(top + i / columns) * width + left + i % columns] =
                            palette[usize::from(*index)];
                    }
                    frames.push((canvas.clone(), delay));
                }
                other => panic!("{other:#x} at {at}"),
            }
        }
    }

    fn picture(color: impl Fn(usize, usize) -> [u8; 3], width: usize, height: usize) -> Vec<u8> {
        (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .flat_map(|(x, y)| {
                let [r, g, b] = color(x, y);
                [r, g, b, 255]
            })
            .collect()
    }

    #[test]
    fn a_viewer_shows_the_pictures_that_were_added() {
        let (width, height) = (61, 37);
        let room = |x: usize, y: usize| [(x * 4) as u8, (y * 6) as u8, 90];
        let with_figure = |at: usize| {
            move |x: usize, y: usize| if x.abs_diff(at) < 4 && y > 20 { [250, 20, 30] } else { room(x, y) }
        };
        let pictures: Vec<Vec<u8>> =
            [5, 20, 20, 40].map(|at| picture(with_figure(at), width, height)).to_vec();
        let mut writer = GifWriter::new(width as u32, height as u32, 30.0).expect("a size");
        pictures.iter().for_each(|p| writer.add(p).expect("adds"));
        let frames = shown(&writer.finish());
        assert_eq!(frames.iter().map(|(_, delay)| *delay).collect::<Vec<_>>(), [3, 4, 3, 3], "30 a second");
        for ((shown, _), picture) in frames.iter().zip(&pictures) {
            for (pixel, (shown, wanted)) in shown.iter().zip(picture.chunks(4)).enumerate() {
                let apart = (0..3).map(|c| shown[c].abs_diff(wanted[c])).max();
                assert!(apart <= Some(24), "pixel {pixel}: {shown:?} for {wanted:?}");
            }
        }
    }

    #[test]
    fn few_colours_are_kept_exactly_and_a_still_picture_costs_next_to_nothing() {
        let flag = picture(|x, _| [[255, 255, 255], [12, 34, 56], [200, 0, 1]][x / 20], 60, 30);
        let mut writer = GifWriter::new(60, 30, 10.0).expect("a size");
        writer.add(&flag).expect("adds");
        let one = writer.file.len();
        writer.add(&flag).expect("adds");
        assert!(writer.file.len() - one < 900, "mostly its palette");
        let frames = shown(&writer.finish());
        for (pixel, wanted) in frames[1].0.iter().zip(flag.chunks(4)) {
            assert_eq!(pixel, &wanted[..3]);
        }
    }

    #[test]
    fn frames_of_another_size_are_refused() {
        assert_eq!(GifWriter::new(0, 4, 10.0).err(), Some(GifError::Size { width: 0, height: 4 }));
        let mut writer = GifWriter::new(4, 4, 10.0).expect("a size");
        assert_eq!(writer.add(&[0; 12]), Err(GifError::Length { found: 12, expected: 64 }));
    }
}
