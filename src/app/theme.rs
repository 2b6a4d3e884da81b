//! How the window looks: one dark and one light theme, one accent colour, one scale of sizes and spaces.

use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, Style, TextStyle, Theme, Visuals};

/// Colours that egui's style has no place for.
#[derive(Clone, Copy, Debug)]
pub struct Palette {
    /// The accent: what is selected, running or to be pressed.
    pub accent: Color32,
    /// Text on the accent.
    pub on_accent: Color32,
    /// Fine.
    pub good: Color32,
    /// Doubtful.
    pub warn: Color32,
    /// Above a limit.
    pub bad: Color32,
    /// Behind the 3-D view.
    pub background: [u8; 3],
    /// Tab bars and status bar.
    pub recessed: Color32,
}

const DARK: Palette = Palette {
    accent: Color32::from_rgb(64, 168, 158),
    on_accent: Color32::from_rgb(8, 24, 22),
    good: Color32::from_rgb(112, 190, 130),
    warn: Color32::from_rgb(224, 172, 84),
    bad: Color32::from_rgb(226, 104, 94),
    background: [49, 52, 57],
    recessed: Color32::from_rgb(22, 23, 26),
};

const LIGHT: Palette = Palette {
    accent: Color32::from_rgb(14, 122, 113),
    on_accent: Color32::WHITE,
    good: Color32::from_rgb(30, 120, 58),
    warn: Color32::from_rgb(148, 92, 0),
    bad: Color32::from_rgb(186, 42, 34),
    background: [214, 217, 221],
    recessed: Color32::from_rgb(226, 228, 231),
};

/// The palette of the theme in use.
pub fn palette(visuals: &Visuals) -> &'static Palette {
    if visuals.dark_mode { &DARK } else { &LIGHT }
}

/// The palette for texts on dark labels in the view, whatever the theme.
pub fn on_dark() -> &'static Palette {
    &DARK
}

/// Gives both themes their looks.
pub fn install(ctx: &egui::Context) {
    ctx.options_mut(|options| options.input_options.max_click_duration = LONGEST_CLICK_S);
    ctx.style_mut_of(Theme::Dark, |style| dress(style, dark()));
    ctx.style_mut_of(Theme::Light, |style| dress(style, light()));
}

/// Pressing and letting go is a click up to this long, seconds: on a software driver that shares the processor with a
/// job a frame can take half a second, and a quick click would be none.
const LONGEST_CLICK_S: f64 = 2.5;

/// Sizes and spaces on a grid of 4 points.
fn dress(style: &mut Style, visuals: Visuals) {
    style.visuals = visuals;
    let sizes = [
        (TextStyle::Small, 11.0, FontFamily::Proportional),
        (TextStyle::Body, 13.0, FontFamily::Proportional),
        (TextStyle::Button, 13.0, FontFamily::Proportional),
        (TextStyle::Heading, 17.0, FontFamily::Proportional),
        (TextStyle::Monospace, 12.0, FontFamily::Monospace),
    ];
    style.text_styles =
        sizes.into_iter().map(|(text, size, family)| (text, FontId::new(size, family))).collect();
    let spacing = &mut style.spacing;
    spacing.item_spacing = egui::vec2(8.0, 5.0);
    spacing.button_padding = egui::vec2(8.0, 3.0);
    spacing.interact_size.y = 22.0;
    spacing.indent = 14.0;
    spacing.window_margin = Margin::same(12);
    spacing.menu_margin = Margin::same(6);
    spacing.tooltip_width = 320.0;
    spacing.slider_rail_height = 4.0;
    // The bar of a scrolled panel has room of its own: it would lie over the icons at the right edge.
    spacing.scroll.floating_allocated_width = spacing.scroll.bar_width;
    style.interaction.selectable_labels = false;
}

fn dark() -> Visuals {
    let mut v = Visuals::dark();
    let gray = Color32::from_gray;
    v.panel_fill = Color32::from_rgb(30, 31, 35);
    v.window_fill = Color32::from_rgb(36, 37, 42);
    v.extreme_bg_color = Color32::from_rgb(18, 19, 21);
    v.faint_bg_color = Color32::from_rgb(35, 36, 41);
    v.window_stroke = Stroke::new(1.0, gray(58));
    v.weak_text_color = Some(gray(142));
    shape(&mut v, &DARK);
    let w = &mut v.widgets;
    w.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(48, 50, 56));
    w.noninteractive.fg_stroke = Stroke::new(1.0, gray(206));
    fill(&mut w.inactive, Color32::from_rgb(50, 52, 58), gray(216));
    fill(&mut w.hovered, Color32::from_rgb(64, 67, 74), gray(244));
    fill(&mut w.active, Color32::from_rgb(76, 80, 88), Color32::WHITE);
    fill(&mut w.open, Color32::from_rgb(56, 58, 65), gray(236));
    v
}

fn light() -> Visuals {
    let mut v = Visuals::light();
    let gray = Color32::from_gray;
    v.panel_fill = Color32::from_rgb(244, 245, 246);
    v.window_fill = Color32::from_rgb(252, 252, 253);
    v.extreme_bg_color = Color32::WHITE;
    v.faint_bg_color = Color32::from_rgb(237, 239, 241);
    v.window_stroke = Stroke::new(1.0, gray(196));
    v.weak_text_color = Some(gray(104));
    shape(&mut v, &LIGHT);
    let w = &mut v.widgets;
    w.noninteractive.bg_stroke = Stroke::new(1.0, gray(212));
    w.noninteractive.fg_stroke = Stroke::new(1.0, gray(48));
    fill(&mut w.inactive, gray(226), gray(40));
    fill(&mut w.hovered, gray(214), gray(16));
    fill(&mut w.active, gray(200), gray(0));
    fill(&mut w.open, gray(220), gray(24));
    v
}

fn shape(v: &mut Visuals, palette: &Palette) {
    v.selection.bg_fill = palette.accent.gamma_multiply(if v.dark_mode { 0.42 } else { 0.28 });
    v.selection.stroke = Stroke::new(1.0, if v.dark_mode { Color32::WHITE } else { Color32::from_gray(12) });
    v.hyperlink_color = palette.accent;
    v.warn_fg_color = palette.warn;
    v.error_fg_color = palette.bad;
    v.window_corner_radius = CornerRadius::same(8);
    v.menu_corner_radius = CornerRadius::same(6);
    v.slider_trailing_fill = true;
    v.indent_has_left_vline = false;
    for widget in [
        &mut v.widgets.noninteractive,
        &mut v.widgets.inactive,
        &mut v.widgets.hovered,
        &mut v.widgets.active,
        &mut v.widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(4);
        widget.expansion = 0.0;
    }
}

fn fill(widget: &mut egui::style::WidgetVisuals, background: Color32, text: Color32) {
    widget.bg_fill = background;
    widget.weak_bg_fill = background;
    widget.bg_stroke = Stroke::NONE;
    widget.fg_stroke = Stroke::new(1.0, text);
}
