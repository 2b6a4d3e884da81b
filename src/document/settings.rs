//! What the editor remembers between two runs: recent files and the theme. Small, and never a reason to fail.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::files::{ProjectError, replace};

/// Remembered settings.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Files opened lately, the newest first.
    pub recent: Vec<PathBuf>,
    /// The light theme.
    pub light: bool,
}

impl Settings {
    /// Where settings are kept for this user; `None` when the system names no such place.
    pub fn default_path() -> Option<PathBuf> {
        let named = |variable: &str| std::env::var_os(variable).filter(|v| !v.is_empty()).map(PathBuf::from);
        let folder = named("XDG_CONFIG_HOME")
            .or_else(|| named("APPDATA"))
            .or_else(|| named("HOME").map(|home| home.join(".config")))?;
        Some(folder.join("inhabit").join("settings.ron"))
    }

    /// The settings in `path`; the defaults when there are none or they can't be read.
    pub fn load(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        ron::from_str(&text).unwrap_or_default()
    }

    /// Writes the settings, making the folder if it is missing.
    ///
    /// # Errors
    /// [`ProjectError::Write`] when the disk refuses.
    pub fn save(&self, path: &Path) -> Result<(), ProjectError> {
        let fail = |source| ProjectError::Write { file: path.display().to_string(), source };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(fail)?;
        }
        let text = ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new())
            .map_err(|error| fail(std::io::Error::other(error)))?;
        replace(path, text.as_bytes())
    }
}
