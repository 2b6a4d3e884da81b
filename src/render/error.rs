use crate::scene::PersonId;

/// Why a picture could not be drawn. Every variant says what the user can do about it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// No adapter answered: a server without graphics driver.
    #[error(
        "no graphics adapter was found ({detail}); install a Vulkan driver (on Debian and Ubuntu the \
         software one is mesa-vulkan-drivers) or draw on the processor"
    )]
    NoAdapter {
        /// What the graphics library said.
        detail: String,
    },
    /// An adapter is there but opens no device.
    #[error(
        "the graphics adapter {adapter} opens no device ({detail}); update its driver or draw on the processor"
    )]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        /// What the graphics library said.
        detail: String,
    },
    /// A picture without pixels, or with more than the device can hold.
    #[error("a picture of {width} x {height} pixels was asked for; each side has to be 1 to {limit}")]
    Size {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
        /// Longest side that can be drawn.
        limit: u32,
    },
    /// The device is gone (driver reset, suspend, unplugged); nothing of it can be used any more.
    #[error("the graphics device was lost ({detail}); make a new RenderContext, or draw on the processor")]
    DeviceLost {
        /// What the driver said.
        detail: String,
    },
    /// The driver refused a call: out of memory, or a fault of ours.
    #[error("the graphics driver refused a call ({detail}); draw a smaller picture or on the processor")]
    Driver {
        /// What the driver said.
        detail: String,
    },
    /// A person's vertices or heat values do not belong to the body surface.
    #[error("person {} has {found} {what}, the body surface has {expected} vertices", person.0)]
    PersonShape {
        /// Whose.
        person: PersonId,
        /// `vertices` or `heat values`.
        what: &'static str,
        /// How many came.
        found: usize,
        /// How many belong.
        expected: usize,
    },
    /// People are to be drawn, but the surface that joins their vertices is missing.
    #[error("{people} people are to be drawn without a body surface; set SceneDraw::body")]
    NoBodySurface {
        /// How many people there are.
        people: usize,
    },
    /// The camera looks from or to a point that is not a number.
    #[error("the camera is not finite: eye {eye}, target {target}")]
    Camera {
        /// Where it stands.
        eye: String,
        /// Where it looks.
        target: String,
    },
}
