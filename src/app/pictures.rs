//! Small pictures in panels: pixels that become a texture when they are first shown.

use std::sync::OnceLock;

use egui::{
    Color32, ColorImage, Pos2, Rect, Response, Sense, TextureHandle, TextureOptions, Ui, Vec2, pos2, vec2,
};

use crate::generate::sensor::SIDE;
use crate::generate::sensor::SceneImage;
use crate::generate::sensor::Valid;
use crate::generate::sensor::category_of;
use crate::render::Picture;
use crate::scene::Category;

/// All of a picture.
const WHOLE: Rect = Rect { min: Pos2::ZERO, max: pos2(1.0, 1.0) };

/// A picture and its texture.
#[derive(Clone)]
pub struct Shown {
    image: ColorImage,
    /// Pixels stay sharp: they mean something.
    sharp: bool,
    /// The part that is shown, in shares of the whole.
    part: Rect,
    texture: OnceLock<TextureHandle>,
}

impl std::fmt::Debug for Shown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Shown({} x {})", self.image.size[0], self.image.size[1])
    }
}

impl From<Picture> for Shown {
    fn from(picture: Picture) -> Self {
        let size = [picture.width as usize, picture.height as usize];
        let image = ColorImage::from_rgba_unmultiplied(size, &picture.rgba);
        Self { image, sharp: false, part: WHOLE, texture: OnceLock::new() }
    }
}

impl Shown {
    /// White with this much of it seen, 0 to 1, at each pixel (column, row): to be painted in any colour.
    pub fn of_shares(side: usize, share: impl Fn(usize, usize) -> f32) -> Self {
        let alpha = |i: usize| (share(i % side, i / side).clamp(0.0, 1.0) * 255.0) as u8;
        let pixels = (0..side * side).map(|i| Color32::from_white_alpha(alpha(i))).collect();
        let image = ColorImage::new([side, side], pixels);
        Self { image, sharp: false, part: WHOLE, texture: OnceLock::new() }
    }

    /// The part of a network's image that is not padding.
    fn of_pixels(valid: &Valid, color: impl Fn(usize) -> Color32) -> Self {
        let pixels = (0..SIDE * SIDE).map(color).collect();
        let share = |pixels: u32| pixels as f32 / SIDE as f32;
        let corner = pos2(share(valid.left), share(valid.top));
        let part = Rect::from_min_size(corner, vec2(share(valid.width), share(valid.height)));
        Self { image: ColorImage::new([SIDE, SIDE], pixels), sharp: true, part, texture: OnceLock::new() }
    }

    /// Depth from near (bright) to far (dark), on the scale that the networks take it by.
    pub fn of_depth(seen: &SceneImage) -> Self {
        let far_m = seen.max_depth_m.max(f32::MIN_POSITIVE);
        Self::of_pixels(&seen.valid, |i| depth_color(seen.depth_m[i] / far_m))
    }

    /// What is seen, a colour for each kind of thing.
    pub fn of_labels(seen: &SceneImage) -> Self {
        Self::of_pixels(&seen.valid, |i| label_color(seen.labels[i]))
    }

    /// Width over height.
    pub fn aspect(&self) -> f32 {
        let size = vec2(self.image.size[0] as f32, self.image.size[1] as f32) * self.part.size();
        size.x / size.y.max(f32::MIN_POSITIVE)
    }

    /// Puts it into `ui`; `name` is for those who can't see it.
    pub fn show(&self, ui: &mut Ui, size: Vec2, sense: Sense, name: &str) -> Response {
        let (rect, response) = ui.allocate_exact_size(size, sense);
        let role = if sense.senses_click() { egui::Role::Button } else { egui::Role::Image };
        response.widget_info(|| egui::WidgetInfo::labeled(role, ui.is_enabled(), name));
        if ui.is_rect_visible(rect) {
            self.paint(ui, rect);
        }
        response
    }

    /// Paints it into a rectangle.
    pub fn paint(&self, ui: &Ui, rect: Rect) {
        self.paint_tinted(ui, rect, Color32::WHITE);
    }

    /// Paints it into a rectangle, each pixel times `tint`.
    pub fn paint_tinted(&self, ui: &Ui, rect: Rect, tint: Color32) {
        let options = if self.sharp { TextureOptions::NEAREST } else { TextureOptions::LINEAR };
        let load = || ui.ctx().load_texture("picture", self.image.clone(), options);
        egui::Image::new(self.texture.get_or_init(load))
            .uv(self.part)
            .corner_radius(3.0)
            .tint(tint)
            .paint_at(ui, rect);
    }
}

/// Near is bright and warm, far is dark and cold: read like a lamp at the camera.
fn depth_color(share: f32) -> Color32 {
    let stops = [[250.0, 246.0, 222.0], [226.0, 158.0, 92.0], [132.0, 62.0, 110.0], [24.0, 18.0, 62.0]];
    let place = share.clamp(0.0, 1.0) * (stops.len() - 1) as f32;
    let i = (place as usize).min(stops.len() - 2);
    let t = place - i as f32;
    let [r, g, b] = std::array::from_fn(|c| (stops[i][c] + (stops[i + 1][c] - stops[i][c]) * t) as u8);
    Color32::from_rgb(r, g, b)
}

/// The colour of a label: quiet for the building, clear hues for furniture, black where nothing is.
pub fn label_color(label: u8) -> Color32 {
    let Some(category) = category_of(label) else { return Color32::BLACK };
    match category {
        Category::Floor => Color32::from_rgb(150, 132, 108),
        Category::Wall => Color32::from_rgb(176, 182, 188),
        Category::Ceiling => Color32::from_rgb(208, 208, 204),
        Category::Door => Color32::from_rgb(128, 106, 90),
        Category::Window => Color32::from_rgb(160, 206, 226),
        _ => {
            // Golden angle: neighbouring numbers get unlike hues.
            let hue = (f32::from(label) * 0.381_966).fract();
            egui::ecolor::Hsva::new(hue, 0.62, 0.86, 1.0).into()
        }
    }
}

/// The kinds of things in an image, those that fill most of it first, with their share of the picture.
pub fn kinds_seen(seen: &SceneImage) -> Vec<(u8, &'static str, f32)> {
    let mask = seen.valid.mask();
    let mut counts = [0_usize; 256];
    for (label, _) in seen.labels.iter().zip(&mask).filter(|(_, valid)| **valid) {
        counts[usize::from(*label)] += 1;
    }
    let all: usize = counts.iter().sum();
    let mut kinds: Vec<_> = (0..=255_u8)
        .filter(|label| counts[usize::from(*label)] > 0)
        .map(|label| {
            let name = category_of(label).map_or("nothing", Category::label);
            (label, name, counts[usize::from(label)] as f32 / all.max(1) as f32)
        })
        .collect();
    kinds.sort_by(|a, b| b.2.total_cmp(&a.2));
    kinds
}
