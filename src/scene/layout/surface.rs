//! Pictures made on the spot: plank floors and paintings. Integer noise, no clock, no random device.

use crate::assets::{ImageFile, Texture, encode_jpeg};

use super::{Art, LayoutError, Srgb};

/// Side of the square floor picture.
const PLANK_PIXELS: u32 = 512;
/// Metres that the floor picture covers: a plank is 1 m long and an eighth of a metre wide.
pub const PLANK_TILE_M: f32 = 2.0;
const PLANK_LENGTH: u32 = PLANK_PIXELS / 2;
const PLANK_WIDTH: u32 = PLANK_PIXELS / 16;

/// JPEG quality at which flat colours show no blocks.
const QUALITY: u8 = 88;

/// Boards of slightly different tone with a faint grain and dark joints; tiles without a seam.
pub fn planks(tone: Srgb) -> Result<Texture, LayoutError> {
    picture("planks", PLANK_PIXELS, PLANK_PIXELS, |x, y| {
        let row = y / PLANK_WIDTH;
        let along = (x + hash(row, 7) % PLANK_LENGTH * 3) % PLANK_PIXELS;
        let plank = hash(row, 31 + along / PLANK_LENGTH);
        let board = f64::from(plank % 1000) / 1000.0 - 0.5;
        let coarse = grain(along, y, 64, 4, plank) - 0.5;
        let fine = grain(along, y, 16, 2, plank ^ 0x5bd1) - 0.5;
        let edge = [y % PLANK_WIDTH, along % PLANK_LENGTH].into_iter().min() == Some(0);
        let light = 1.0 + 0.13 * board + 0.10 * coarse + 0.05 * fine;
        let light = if edge { light * 0.72 } else { light };
        // Darker boards are redder too, as in real wood.
        [0.97, 1.0, 1.05].map(|warm: f64| light.powf(warm)).map(f64::abs).scale(tone)
    })
}

/// A painting of `width` to `height` metres in four colours: sky, sun, far and near.
pub fn painting(art: Art, size_m: (f32, f32), colors: [Srgb; 4]) -> Result<Texture, LayoutError> {
    let width = 192;
    let height = (width as f32 * size_m.1 / size_m.0).round().clamp(48.0, 384.0) as u32;
    picture("painting", width, height, |x, y| {
        let u = (f64::from(x) + 0.5) / f64::from(width);
        let v = (f64::from(y) + 0.5) / f64::from(height);
        let aspect = f64::from(height) / f64::from(width);
        let canvas = 0.98 + 0.04 * f64::from(hash(x, y) % 100) / 100.0;
        let color = match art {
            Art::Hills => hills(u, v, aspect, colors),
            Art::Arches => arches(u, v, aspect, colors),
        };
        [canvas; 3].scale(color)
    })
}

/// A low sun over three ranges of hills.
fn hills(u: f64, v: f64, aspect: f64, [sky, sun, far, near]: [Srgb; 4]) -> Srgb {
    let ridge = |base: f64, swing: f64, waves: f64, shift: f64| {
        base + swing * ((u * waves + shift).sin() + 0.4 * (u * waves * 2.3 + shift * 1.7).sin())
    };
    let from_sun = ((u - 0.66).powi(2) + ((v - 0.38) * aspect).powi(2)).sqrt();
    if v > ridge(0.86, 0.05, 5.0, 0.4) {
        near
    } else if v > ridge(0.70, 0.05, 6.0, 2.0) {
        mix(near, far, 0.5)
    } else if v > ridge(0.56, 0.06, 4.0, 4.1) {
        far
    } else if from_sun < 0.13 {
        sun
    } else {
        mix(sky, Srgb(255, 255, 255), 0.5 * v)
    }
}

/// Nested arches on a ground line.
fn arches(u: f64, v: f64, aspect: f64, [ground, outer, middle, inner]: [Srgb; 4]) -> Srgb {
    let (x, y) = (u - 0.5, (v - 0.88) * aspect);
    let reach = if y < -0.2 { (x.powi(2) + (y + 0.2).powi(2)).sqrt() } else { x.abs() };
    if y > 0.0 {
        return ground;
    }
    match reach {
        r if r < 0.10 => inner,
        r if r < 0.16 => ground,
        r if r < 0.24 => middle,
        r if r < 0.29 => ground,
        r if r < 0.38 => outer,
        _ => ground,
    }
}

/// Colour times light.
trait Scale {
    fn scale(self, color: Srgb) -> [u8; 3];
}

impl Scale for [f64; 3] {
    fn scale(self, color: Srgb) -> [u8; 3] {
        let channels = [color.0, color.1, color.2];
        std::array::from_fn(|k| (f64::from(channels[k]) * self[k]).round().clamp(0.0, 255.0) as u8)
    }
}

fn mix(a: Srgb, b: Srgb, share_of_b: f64) -> Srgb {
    let blend = |a: u8, b: u8| {
        (f64::from(a) * (1.0 - share_of_b) + f64::from(b) * share_of_b).round().clamp(0.0, 255.0) as u8
    };
    Srgb(blend(a.0, b.0), blend(a.1, b.1), blend(a.2, b.2))
}

/// Smooth noise from 0 to 1 that is long in x and short in y and repeats with the picture.
fn grain(x: u32, y: u32, cell_x: u32, cell_y: u32, seed: u32) -> f64 {
    let corner = |dx: u32, dy: u32| {
        let cx = (x / cell_x + dx) % (PLANK_PIXELS / cell_x);
        let cy = (y / cell_y + dy) % (PLANK_PIXELS / cell_y);
        f64::from(hash(cx ^ seed, cy) % 1024) / 1023.0
    };
    let fx = f64::from(x % cell_x) / f64::from(cell_x);
    let fy = f64::from(y % cell_y) / f64::from(cell_y);
    let top = corner(0, 0) * (1.0 - fx) + corner(1, 0) * fx;
    let bottom = corner(0, 1) * (1.0 - fx) + corner(1, 1) * fx;
    top * (1.0 - fy) + bottom * fy
}

/// A well-mixed number for a pair (the finaliser of MurmurHash3).
fn hash(a: u32, b: u32) -> u32 {
    let mut h = a.wrapping_mul(0x9E37_79B1) ^ b.wrapping_mul(0x85EB_CA77) ^ 0x27D4_EB2F;
    h = (h ^ (h >> 16)).wrapping_mul(0x85EB_CA6B);
    h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE35);
    h ^ (h >> 16)
}

/// A picture by its pixels, with its JPEG file.
fn picture(
    name: &str,
    width: u32,
    height: u32,
    pixel: impl Fn(u32, u32) -> [u8; 3],
) -> Result<Texture, LayoutError> {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let rgb: Vec<[u8; 3]> = pixels.map(|(x, y)| pixel(x, y)).collect();
    let bytes = encode_jpeg(width, height, rgb.as_flattened(), QUALITY)?;
    Ok(Texture {
        name: name.to_owned(),
        width,
        height,
        rgba: rgb.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect(),
        file: Some(ImageFile { mime: "image/jpeg", bytes: bytes.into() }),
    })
}
