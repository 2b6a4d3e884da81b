//! Reads a corpus from its folder, for every command that learns or measures.

use std::fs;
use std::path::Path;

use anyhow::Context as _;
use rayon::prelude::*;

use crate::assets::{self, Budget};
use crate::job::{Stop, Ticker};
use crate::learn::corpus::{Corpus, CorpusRoom, MANIFEST, Manifest, ROOM, RoomEntry, SAMPLES};
use crate::scene::{ImportOptions, Room, room_from_model};

/// The manifest of the corpus in a folder.
///
/// # Errors
/// When there is none; the message says how to make one.
pub fn read_manifest(folder: &Path) -> anyhow::Result<Manifest> {
    let path = folder.join(MANIFEST);
    let text = fs::read_to_string(&path).with_context(|| {
        format!(
            "can't read {}: make a corpus with `inhabit stage --out {}`, or finish it with --resume",
            path.display(),
            folder.display()
        )
    })?;
    Manifest::from_ron(&text).with_context(|| folder.display().to_string())
}

/// People and views of one room of a corpus.
///
/// # Errors
/// When its file is missing or damaged; the message names it.
pub fn read_room(folder: &Path, entry: &RoomEntry) -> anyhow::Result<CorpusRoom> {
    let path = folder.join(&entry.name).join(SAMPLES);
    let bytes = fs::read(&path).with_context(|| format!("can't read {}", path.display()))?;
    Ok(CorpusRoom::from_npz(entry, &path.display().to_string(), &bytes)?)
}

/// The room itself, as it was staged.
///
/// # Errors
/// When its file is missing or damaged; the message names it.
pub fn read_room_model(folder: &Path, entry: &RoomEntry) -> anyhow::Result<Room> {
    let model = assets::read_model(&folder.join(&entry.name).join(ROOM), &Budget::default())?;
    Ok(room_from_model(&model, &ImportOptions::default()).room)
}

/// The whole corpus in a folder, on all threads; 50 kB a view.
///
/// # Errors
/// When a file is missing or damaged; [`Stop::Cancelled`] once the user cancelled.
pub fn read_corpus(folder: &Path, ticker: &Ticker) -> Result<Corpus, Stop> {
    let failed = |error: anyhow::Error| Stop::Failed(format!("{error:#}"));
    let manifest = read_manifest(folder).map_err(failed)?;
    ticker.stage("reading the corpus", manifest.rooms.len())?;
    let read = |entry: &RoomEntry| {
        let room = read_room(folder, entry).map_err(failed)?;
        ticker.advance()?;
        Ok(room)
    };
    let rooms = manifest.rooms.par_iter().map(read).collect::<Result<_, Stop>>()?;
    Ok(Corpus { manifest, rooms })
}
