//! Pictures beside and below each other, each under a line that says what it shows.

use super::PlotError;
use super::canvas::{self, Hang, INK, LABEL};
use crate::render::Picture;

/// Height of a caption, pixels.
const CAPTION: usize = 30;
/// Air between pictures, pixels.
const AIR: usize = 6;

/// A picture and what it shows.
#[derive(Clone, Debug)]
pub struct Captioned {
    /// In a few words.
    pub caption: String,
    /// The picture.
    pub picture: Picture,
}

/// Where tile `number` is on a sheet of `columns`, and how large: as all are, the largest sides of any.
struct Grid {
    columns: usize,
    tile: [usize; 2],
}

impl Grid {
    fn corner(&self, number: usize) -> [usize; 2] {
        let [width, height] = self.tile;
        [number % self.columns * (width + AIR), number / self.columns * (height + CAPTION + AIR)]
    }

    fn size(&self, count: usize) -> [u32; 2] {
        let [width, height] = self.tile;
        let rows = count.div_ceil(self.columns);
        [self.columns * (width + AIR) - AIR, rows * (height + CAPTION + AIR) - AIR].map(|side| side as u32)
    }
}

/// The sheet.
pub fn draw(tiles: &[Captioned], columns: usize) -> Result<Picture, PlotError> {
    let largest =
        |side: fn(&Picture) -> u32| tiles.iter().map(|t| side(&t.picture)).max().unwrap_or(0) as usize;
    let grid = Grid {
        columns: columns.clamp(1, tiles.len().max(1)),
        tile: [largest(|p| p.width), largest(|p| p.height)],
    };
    let title = tiles.first().map_or("", |tile| &tile.caption);
    let mut sheet = canvas::painted(grid.size(tiles.len()), title, |canvas| {
        tiles.iter().enumerate().try_for_each(|(number, tile)| {
            let [left, top] = grid.corner(number);
            let at = [left as f64 + 8.0, top as f64 + 0.5 * CAPTION as f64];
            canvas.text(&tile.caption, at, LABEL, INK, Hang::Left)
        })
    })?;
    for (number, tile) in tiles.iter().enumerate() {
        let [left, top] = grid.corner(number);
        sheet.paste([left, top + CAPTION], &tile.picture);
    }
    sheet.backend = tiles.first().map_or_else(String::new, |tile| tile.picture.backend.clone());
    Ok(sheet)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(grey: u8, [width, height]: [u32; 2]) -> Captioned {
        let rgba = [grey, grey, grey, 255].repeat((width * height) as usize);
        let picture = Picture { width, height, rgba, backend: String::new() };
        Captioned { caption: format!("grey {grey}"), picture }
    }

    #[test]
    fn every_picture_stands_whole_below_its_caption() {
        let tiles = [plain(10, [200, 90]), plain(20, [200, 90]), plain(30, [180, 90])];
        let sheet = draw(&tiles, 2).expect("drawn");
        assert_eq!([sheet.width, sheet.height], [406, 2 * (90 + 30) + 6]);
        let count = |grey: u8| sheet.rgba.chunks_exact(4).filter(|p| p[..3] == [grey; 3]).count();
        assert_eq!([count(10), count(20), count(30)], [200 * 90, 200 * 90, 180 * 90]);
        let inked = |rows: std::ops::Range<u32>| {
            rows.flat_map(|y| (0..sheet.width).map(move |x| (x, y)))
                .filter(|(x, y)| sheet.pixel(*x, *y)[0] < 120)
                .count()
        };
        assert!(inked(0..30) > 40, "the captions of the first row can be read");
        assert_eq!(sheet.pixel(5, 30), [10; 3]);
    }
}
