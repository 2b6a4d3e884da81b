//! Model files that are embedded in the program, by name.

use super::{AssetError, Budget, Model, read_model_bytes};

/// Files of one folder of `assets`, sorted by name.
pub struct Bundle(pub &'static [(&'static str, &'static [u8])]);

impl Bundle {
    /// The files' names, in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + use<> {
        self.0.iter().map(|(name, _)| *name)
    }

    /// The model of this file name; `None` if there is no such file.
    pub fn model(&self, name: &str) -> Option<Result<Model, AssetError>> {
        let index = self.0.binary_search_by(|(known, _)| (*known).cmp(name)).ok()?;
        Some(read_model_bytes(name, self.0[index].1, &Budget::default()))
    }
}

/// Embeds files of a folder of `assets`: `bundle! { "folder": "a.glb" "b.glb" }`, sorted by name.
macro_rules! bundle {
    ($folder:literal: $($name:literal)*) => {
        $crate::assets::bundle::Bundle(
            &[$(($name, include_bytes!(concat!("../../assets/", $folder, "/", $name)))),*]
        )
    };
}

pub(super) use bundle;
