//! Which renderer draws the pictures of a report: the card where there is one, else the processor.

use super::RenderError;
use super::context::RenderContext;
use super::cpu::{BACKEND, render_on_processor};
use super::draw::{SceneDraw, Shown};
use super::legend;
use super::picture::{Picture, render_image};
use crate::scene::Camera;

/// Who may draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The graphics adapter if there is one (software adapters too), else the processor;
    /// [`Picture::backend`] says which it was.
    #[default]
    Auto,
    /// The graphics adapter or nothing.
    Gpu,
    /// The processor.
    Cpu,
}

/// Draws pictures for reports. Make one and draw many: the adapter is opened once.
pub struct Painter {
    context: Option<RenderContext>,
    fallback: Option<RenderError>,
}

impl Painter {
    /// Opens what `backend` asks for.
    ///
    /// # Errors
    /// With [`Backend::Gpu`] whatever [`RenderContext::headless`] says; never with the others.
    pub fn new(backend: Backend) -> Result<Self, RenderError> {
        match backend {
            Backend::Cpu => Ok(Self { context: None, fallback: None }),
            Backend::Gpu => Ok(Self { context: Some(RenderContext::headless()?), fallback: None }),
            Backend::Auto => Ok(match RenderContext::headless() {
                Ok(context) => Self { context: Some(context), fallback: None },
                Err(error) => Self { context: None, fallback: Some(error) },
            }),
        }
    }

    /// What draws: the adapter's name, or the processor.
    pub fn backend(&self) -> &str {
        self.context.as_ref().map_or(BACKEND, RenderContext::adapter)
    }

    /// Why the processor draws although an adapter would have been welcome.
    pub fn fallback_reason(&self) -> Option<&RenderError> {
        self.fallback.as_ref()
    }

    /// Draws one picture, with the heat map's legend when anybody is painted by heat and the look asks
    /// for it.
    ///
    /// # Errors
    /// As [`render_image`] and [`render_on_processor`].
    pub fn picture(&self, draw: &SceneDraw, camera: &Camera, size: [u32; 2]) -> Result<Picture, RenderError> {
        let mut picture = match &self.context {
            Some(context) => render_image(context, draw, camera, size)?,
            None => render_on_processor(draw, camera, size)?,
        };
        if draw.look.legend == Shown::Yes && draw.people.iter().any(|p| p.heat.is_some()) {
            legend::draw(&mut picture);
        }
        Ok(picture)
    }
}

/// One picture, once; for several make a [`Painter`].
///
/// # Errors
/// As [`Painter::new`] and [`Painter::picture`].
pub fn picture(
    draw: &SceneDraw,
    camera: &Camera,
    size: [u32; 2],
    backend: Backend,
) -> Result<Picture, RenderError> {
    Painter::new(backend)?.picture(draw, camera, size)
}
