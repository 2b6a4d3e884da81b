//! `inhabit stage` as people run it: what it writes, that it goes on where it was stopped, that it never mixes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn stage(out: &Path, people: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inhabit"));
    command.args(["stage", "--without-samples", "--quiet", "--sheet", "0", "--views", "1"]);
    command.args(["--people", people, "--out"]).arg(out).args(arguments);
    command.output().expect("runs")
}

/// Every file under a folder with its bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(fs::read_dir(&path).expect("a folder").map(|e| e.expect("an entry").path()));
        } else {
            let name = path.strip_prefix(folder).expect("inside").display().to_string();
            found.insert(name, fs::read(&path).expect("a file"));
        }
    }
    found
}

#[test]
fn a_corpus_is_resumed_to_the_same_bytes_and_never_mixed_with_another() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = folder.path().join("corpus");
    let first = stage(&root, "2", &["--rooms", "2", "--threads", "2"]);
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    let whole = files(&root);
    for name in
        ["corpus.ron", "README.md", "room_0000/layout.ron", "room_0001/room.glb", "room_0001/samples.npz"]
    {
        assert!(whole.contains_key(name), "{name} is missing of {:?}", whole.keys());
    }
    let card = String::from_utf8_lossy(&whole["README.md"]).into_owned();
    assert!(card.contains("staged, not captured"), "{card}");

    // As if it had been stopped while the second room was written.
    fs::remove_file(root.join("corpus.ron")).expect("removes");
    fs::remove_file(root.join("room_0001/samples.npz")).expect("removes");
    fs::create_dir(root.join("room_0001.unfinished")).expect("makes");
    let refused = stage(&root, "2", &["--rooms", "2"]);
    assert!(!refused.status.success(), "an occupied folder needs --resume");
    let resumed = stage(&root, "2", &["--rooms", "2", "--resume", "--threads", "1"]);
    assert!(resumed.status.success(), "{}", String::from_utf8_lossy(&resumed.stderr));
    assert!(files(&root) == whole, "the same files, on one thread as on two");

    let other = stage(&root, "3", &["--rooms", "2", "--resume"]);
    let message = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(!other.status.success() && message.contains("was begun with"), "{message}");
}
