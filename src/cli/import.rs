//! Options for reading a room's file: what the import guesses can be said instead.

use clap::{Args, ValueEnum};

use crate::scene::{ImportOptions, UpAxis};

/// Overrides of the import's guesses.
#[derive(Args, Debug, Clone, Default)]
pub struct ImportArguments {
    /// Metres per unit of the file, instead of the guess.
    #[arg(long, value_name = "METRES")]
    pub unit_scale: Option<f32>,
    /// The file's up axis, instead of the guess.
    #[arg(long, value_enum, value_name = "AXIS")]
    pub up: Option<Up>,
}

/// Up axes as the command line names them.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// +X.
    X,
    /// +Y.
    Y,
    /// +Z.
    Z,
    /// -X.
    NegX,
    /// -Y.
    NegY,
    /// -Z.
    NegZ,
}

impl ImportArguments {
    /// The import's options.
    ///
    /// # Errors
    /// When the scale is no positive number.
    pub fn options(&self) -> anyhow::Result<ImportOptions> {
        if let Some(scale) = self.unit_scale {
            anyhow::ensure!(
                scale.is_finite() && scale > 0.0,
                "--unit-scale {scale}: write metres per unit as a positive number, such as 0.01 for centimetres"
            );
        }
        let up = self.up.map(|up| match up {
            Up::X => UpAxis::X,
            Up::Y => UpAxis::Y,
            Up::Z => UpAxis::Z,
            Up::NegX => UpAxis::NegX,
            Up::NegY => UpAxis::NegY,
            Up::NegZ => UpAxis::NegZ,
        });
        Ok(ImportOptions { unit_scale: self.unit_scale, up })
    }
}
