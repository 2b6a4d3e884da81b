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

/// Where unsaved work is kept against crashes, in a folder that is made if it is missing; `None` when the system names
/// no such place.
pub fn autosave_path() -> Option<PathBuf> {
    let path = Settings::default_path()?.with_file_name("autosave.inhabit");
    // A folder that can't be made is told when the first save fails.
    let _ = path.parent().map(std::fs::create_dir_all);
    Some(path)
}

/// Whether an earlier session that did not end on purpose left its work at `path`.
pub fn is_leftover(path: &Path) -> bool {
    path.is_file()
}

/// Removes work that was kept at `path`; that it may be gone already is fine.
pub fn remove_leftover(path: &Path) {
    let _ = std::fs::remove_file(path);
}
