//! The heat map's colour scale, drawn into pictures that leave the program (the window draws its own from
//! [`super::TICKS`]). Letters are five by seven dots: only those that the legend needs.

use super::heat::{DEEP_END_M, FREE_END_M, TICKS, heat_color, heat_position};
use super::picture::Picture;

/// Share of the picture's height that the bar takes.
const BAR_SHARE: f32 = 0.40;

/// Letters, each seven rows of five bits, the leftmost bit first.
const GLYPHS: [(char, [u8; 7]); 24] = [
    ('0', [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110]),
    ('1', [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('2', [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111]),
    ('3', [0b11111, 0b00010, 0b00100, 0b00010, 0b00001, 0b10001, 0b01110]),
    ('4', [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010]),
    ('5', [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110]),
    ('6', [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110]),
    ('7', [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000]),
    ('8', [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110]),
    ('9', [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100]),
    ('-', [0b00000, 0b00000, 0b00000, 0b11111, 0b00000, 0b00000, 0b00000]),
    ('a', [0b00000, 0b00000, 0b01110, 0b00001, 0b01111, 0b10001, 0b01111]),
    ('c', [0b00000, 0b00000, 0b01110, 0b10000, 0b10000, 0b10001, 0b01110]),
    ('d', [0b00001, 0b00001, 0b01101, 0b10011, 0b10001, 0b10001, 0b01111]),
    ('e', [0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110]),
    ('f', [0b00110, 0b01001, 0b01000, 0b11100, 0b01000, 0b01000, 0b01000]),
    ('i', [0b00100, 0b00000, 0b01100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('m', [0b00000, 0b00000, 0b11010, 0b10101, 0b10101, 0b10101, 0b10101]),
    ('n', [0b00000, 0b00000, 0b10110, 0b11001, 0b10001, 0b10001, 0b10001]),
    ('o', [0b00000, 0b00000, 0b01110, 0b10001, 0b10001, 0b10001, 0b01110]),
    ('r', [0b00000, 0b00000, 0b10110, 0b11001, 0b10000, 0b10000, 0b10000]),
    ('s', [0b00000, 0b00000, 0b01111, 0b10000, 0b01110, 0b00001, 0b11110]),
    ('t', [0b01000, 0b01000, 0b11100, 0b01000, 0b01000, 0b01001, 0b00110]),
    (' ', [0; 7]),
];

/// Draws bar, ticks and labels at the left edge of `picture`; one too small to hold them stays as it is.
pub fn draw(picture: &mut Picture) {
    let dot = (picture.height / 360).max(1);
    let (bar_w, margin) = (14 * dot, 12 * dot);
    let bar_h = (picture.height as f32 * BAR_SHARE) as u32;
    let text_w = TICKS.iter().map(|t| t.label.len()).max().unwrap_or(0) as u32 * 6 * dot;
    let panel = [bar_w + text_w + 8 * dot + margin, bar_h + margin * 2];
    if panel[0] + margin > picture.width || panel[1] + margin > picture.height || bar_h < 80 * dot {
        return;
    }
    let mut canvas = Canvas { picture, dot };
    let top = margin + margin / 2;
    canvas.shade(margin / 2, margin / 2, panel[0], panel[1]);
    for row in 0..bar_h {
        let position = row as f32 / (bar_h - 1) as f32;
        let color = heat_color(FREE_END_M + (DEEP_END_M - FREE_END_M) * position);
        canvas.fill(margin, top + row, bar_w, 1, color);
    }
    for tick in TICKS {
        let y = top + (heat_position(tick.distance_m) * (bar_h - 1) as f32) as u32;
        canvas.fill(margin + bar_w, y, 4 * dot, dot, [235; 3]);
        canvas.text(margin + bar_w + 8 * dot, y.saturating_sub(3 * dot), tick.label);
    }
}

struct Canvas<'a> {
    picture: &'a mut Picture,
    dot: u32,
}

impl Canvas<'_> {
    fn each(&mut self, [x, y, w, h]: [u32; 4], paint: impl Fn(&mut [u8])) {
        for row in y..(y + h).min(self.picture.height) {
            for column in x..(x + w).min(self.picture.width) {
                let at = (row as usize * self.picture.width as usize + column as usize) * 4;
                paint(&mut self.picture.rgba[at..at + 3]);
            }
        }
    }

    fn fill(&mut self, x: u32, y: u32, w: u32, h: u32, color: [u8; 3]) {
        self.each([x, y, w, h], |pixel| pixel.copy_from_slice(&color));
    }

    /// Darkens what lies under the legend.
    fn shade(&mut self, x: u32, y: u32, w: u32, h: u32) {
        self.each([x, y, w, h], |pixel| pixel.iter_mut().for_each(|c| *c = 20 + *c / 4));
    }

    fn text(&mut self, x: u32, y: u32, text: &str) {
        for (i, letter) in text.chars().enumerate() {
            let Some((_, rows)) = GLYPHS.iter().find(|(c, _)| *c == letter) else { continue };
            for (row, bits) in rows.iter().enumerate() {
                for column in (0..5u32).filter(|column| bits >> (4 - column) & 1 == 1) {
                    let (left, top) = (x + (i as u32 * 6 + column) * self.dot, y + row as u32 * self.dot);
                    self.fill(left, top, self.dot, self.dot, [235; 3]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_of_the_legend_can_be_drawn() {
        for letter in TICKS.iter().flat_map(|t| t.label.chars()) {
            assert!(GLYPHS.iter().any(|(c, _)| *c == letter), "no glyph for {letter:?}");
        }
    }

    #[test]
    fn the_legend_shows_the_colours_of_the_heat_map_from_free_to_deep() {
        let (width, height) = (320, 240);
        let rgba = vec![128; (width * height * 4) as usize];
        let mut picture = Picture { width, height, rgba, backend: String::new() };
        draw(&mut picture);
        let (x, top) = (14, 18);
        let bottom = top + (height as f32 * BAR_SHARE) as u32 - 1;
        assert_eq!(picture.pixel(x, top), heat_color(FREE_END_M));
        assert_eq!(picture.pixel(x, bottom), heat_color(DEEP_END_M));
        assert_eq!(picture.pixel(300, 200), [128; 3], "the rest of the picture stays");
    }
}
