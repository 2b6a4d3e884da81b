//! Remakes the sample rooms: every `assets/rooms/*.layout.ron` becomes a GLB beside it.
//!
//! Run `cargo run --release --example bake_rooms` in the repository's folder after changing a layout.

use std::path::Path;

use anyhow::{Context, Result};
use inhabit::assets::{Budget, glb_from_model, read_model};
use inhabit::scene::layout::{Layout, compose};

fn main() -> Result<()> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    for entry in std::fs::read_dir(assets.join("rooms"))? {
        let path = entry?.path();
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        if let Some(key) = name.strip_suffix(".layout.ron") {
            let glb = bake(&path, &assets.join("furniture")).with_context(|| name.to_owned())?;
            println!("{key}: {} bytes", glb.len());
            std::fs::write(path.with_file_name(format!("{key}.glb")), glb)?;
        }
    }
    Ok(())
}

fn bake(layout: &Path, furniture: &Path) -> Result<Vec<u8>> {
    let layout = Layout::read(&std::fs::read_to_string(layout)?)?;
    let budget = Budget::default();
    let load = |file: &str| read_model(&furniture.join(file), &budget).map_err(|e| e.to_string());
    Ok(glb_from_model(&compose(&layout, &load)?)?)
}
