//! The output folder of a run: made if missing, never mixed with an earlier run.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};

/// A folder that this run alone writes to.
pub struct OutputFolder {
    root: PathBuf,
}

impl OutputFolder {
    /// Takes `root`: makes it if missing, refuses it when something is in it, unless `resume` is given.
    ///
    /// # Errors
    /// When the folder holds an earlier run or can't be made.
    pub fn claim(root: &Path, resume: bool) -> anyhow::Result<Self> {
        fs::create_dir_all(root).with_context(|| {
            format!("can't make the output folder {}: name another with --out", root.display())
        })?;
        let occupied = fs::read_dir(root)?.next().is_some();
        if occupied && !resume {
            bail!(
                "{} is not empty: runs are never mixed. Name another folder with --out, or pass --resume to \
                 write this run over the earlier one",
                root.display()
            );
        }
        Ok(Self { root: root.to_owned() })
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Writes `bytes` to the relative path `name`, making the folders above it.
    ///
    /// # Errors
    /// When the file can't be written.
    pub fn write(&self, name: &str, bytes: &[u8]) -> anyhow::Result<PathBuf> {
        let path = self.root.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        fs::write(&path, bytes)
            .with_context(|| format!("can't write {}: is the disk full?", path.display()))?;
        Ok(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_never_mixed_with_an_earlier_one() {
        let folder = tempfile::tempdir().expect("temp folder");
        let root = folder.path().join("out");
        let first = OutputFolder::claim(&root, false).expect("new folder");
        first.write("people/000.glb", b"x").expect("write");
        let refused = OutputFolder::claim(&root, false).err().expect("must refuse").to_string();
        assert!(refused.contains("--resume"), "{refused}");
        assert!(OutputFolder::claim(&root, true).is_ok());
    }
}
