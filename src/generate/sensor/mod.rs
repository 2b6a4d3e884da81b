//! What a camera sees of a room: depth and semantics, as the networks get them (PSI §3.1, §4.1.1).
//!
//! Pinhole cameras ([`View`]), captures by ray casting on the processor ([`Sensor`]), the 128 x 128 image of the
//! networks ([`SceneImage`]) with PSI's normalising projection ([`Projection`]), and where cameras stand:
//! PROX-E's virtual cameras around a body ([`virtual_cameras`]) and MP3D-R's agent ([`agent_views`]).
//!
//! May not draw, keep files or know networks. Pure: the same room, view and seed give the same numbers.
//! Camera frame: metres, x right, y **down**, z forward (as PSI and OpenCV); world frame: Y up.

mod agent;
mod cameras;
mod capture;
mod image;
mod projection;
#[cfg(test)]
mod tests_room;
mod view;

pub use agent::{AgentConfig, agent_views};
pub use cameras::{VirtualCameraConfig, virtual_cameras, visible_share};
pub use capture::{Capture, Enclosure, Sensor};
pub use image::{SIDE, SceneImage, Valid};
pub use projection::Projection;
pub use view::{Intrinsics, View};

use crate::scene::Category;

/// Depth beyond this is cut in [`SceneImage`], in metres (PSI-release; algorithms 1.1).
pub const MAX_DEPTH_M: f32 = 6.0;

/// Labels of an image: 0 is nothing, `1..LABELS` are [`Category::ALL`] in order.
pub const LABELS: usize = Category::ALL.len() + 1;

/// The label of a category in captures: its place in [`Category::ALL`], from 1. The first 40 are mpcat40's
/// numbers.
pub fn label_of(category: Category) -> u8 {
    category as u8 + 1
}

/// The category of a label; `None` for 0 (nothing) and for numbers that no category has.
pub fn category_of(label: u8) -> Option<Category> {
    Category::ALL.get(usize::from(label).checked_sub(1)?).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_the_categories_in_order_with_mpcat40_first() {
        for (index, category) in Category::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(label_of(category)), index + 1);
            assert_eq!(category_of(label_of(category)), Some(category));
        }
        assert_eq!(label_of(Category::Bed), Category::Bed.mpcat40());
        assert_eq!(category_of(0), None);
        assert_eq!(category_of(LABELS as u8), None);
    }
}
