//! Holds the layering table: who may name whom, and where the heavy dependencies may appear.

use std::fs;
use std::path::{Path, PathBuf};

/// A module and the modules of the crate that it may name.
const TABLE: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("job", &[]),
    ("assets", &["math"]),
    ("scene", &["math", "assets"]),
    ("body", &["math", "assets", "scene"]),
    ("inspect", &["math", "scene", "body"]),
    ("nn", &["math", "assets"]),
    ("generate", &["math", "job", "assets", "scene", "body", "inspect", "nn"]),
    ("fit", &["math", "job", "assets", "scene", "body", "inspect", "nn"]),
    ("motion", &["math", "job", "assets", "scene", "body", "inspect", "nn"]),
    ("evolve", &["math", "job", "assets", "scene", "body", "inspect", "nn", "generate", "fit", "motion"]),
    (
        "learn",
        &["math", "job", "assets", "scene", "body", "inspect", "nn", "generate", "fit", "motion", "evolve"],
    ),
    ("document", &["math", "assets", "scene", "body", "inspect"]),
    ("render", &["math", "assets", "scene", "body", "inspect"]),
    (
        "app",
        &[
            "math", "job", "assets", "scene", "body", "inspect", "nn", "generate", "fit", "motion", "evolve",
            "learn", "document", "render",
        ],
    ),
    (
        "cli",
        &[
            "math", "job", "assets", "scene", "body", "inspect", "nn", "generate", "fit", "motion", "evolve",
            "learn", "document", "render",
        ],
    ),
];

/// A path prefix of the outside world and the only modules that may name it.
const RESERVED: &[(&str, &[&str])] = &[
    ("egui", &["app"]),
    ("eframe", &["app"]),
    ("egui_wgpu", &["app"]),
    ("egui_tiles", &["app"]),
    ("egui_plot", &["app"]),
    ("rfd", &["app"]),
    ("wgpu", &["render", "app"]),
    ("burn", &["nn", "learn"]),
    ("plotters", &["render"]),
    ("anyhow", &["app", "cli"]),
    ("std::fs", &["assets", "document", "cli"]),
];

/// What `source` of `module` names against the table, one line each.
fn violations(module: &str, source: &str) -> Vec<String> {
    let code = without_comments(source);
    let mut found = Vec::new();
    let allowed = TABLE.iter().find(|(name, _)| *name == module).map_or(&[][..], |(_, allowed)| allowed);
    for (other, _) in TABLE {
        if *other != module && !allowed.contains(other) && names(&code, &format!("crate::{other}")) {
            found.push(format!("{module} names crate::{other}"));
        }
    }
    for (path, homes) in RESERVED {
        if !homes.contains(&module) && uses_path(&code, path) {
            found.push(format!("{module} names {path}"));
        }
    }
    if code.contains("crate::{") {
        found.push(format!("{module} groups imports at the crate's root: name each module by itself"));
    }
    found
}

/// Whether `path` stands in `code` as a whole path, not as part of a longer name.
fn names(code: &str, path: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(path).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        let after = code[at + path.len()..].chars().next();
        !before.is_some_and(|c| is_word(c) || c == ':') && !after.is_some_and(is_word)
    })
}

/// Whether `path` is used as a path (`path::…` or `use path;`), not as a variable of that name.
fn uses_path(code: &str, path: &str) -> bool {
    ["::", ";"].iter().any(|end| {
        code.match_indices(&format!("{path}{end}")).any(|(at, _)| {
            let before = &code[..at];
            let starts = !before.ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
            starts && (*end == "::" || before.ends_with("use "))
        })
    })
}

fn without_comments(source: &str) -> String {
    source.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("source folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files
}

#[test]
fn every_module_names_only_the_layers_below_it() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    for (module, _) in TABLE {
        let folder = source.join(module);
        assert!(folder.is_dir(), "{module} stands in the table but not in src");
        for file in rust_files(&folder) {
            let text = fs::read_to_string(&file).expect("source file");
            found.extend(violations(module, &text).into_iter().map(|v| format!("{}: {v}", file.display())));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn every_module_of_the_crate_stands_in_the_table() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in fs::read_dir(source).expect("src").flatten().filter(|e| e.path().is_dir()) {
        let name = entry.file_name().into_string().expect("module name");
        assert!(TABLE.iter().any(|(module, _)| *module == name), "src/{name} has no row in the table");
    }
}

#[test]
fn every_module_says_what_it_may_not_do() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for (module, _) in TABLE {
        let header = fs::read_to_string(source.join(module).join("mod.rs")).expect("mod.rs");
        let header: String = header.lines().take_while(|l| l.starts_with("//!")).collect();
        let says = ["may not", "May not", "never", "Never", "May name", "only", "Only", "no other"];
        assert!(says.iter().any(|s| header.contains(s)), "{module}'s header states no limit: {header}");
    }
}

#[test]
fn the_check_can_fail() {
    assert_eq!(violations("math", "use crate::scene::Room;"), ["math names crate::scene"]);
    assert_eq!(violations("generate", "let x = crate::fit::fit(y);"), ["generate names crate::fit"]);
    assert_eq!(violations("render", "use egui::Context;"), ["render names egui"]);
    assert_eq!(violations("fit", "std::fs::read(path)"), ["fit names std::fs"]);
    assert_eq!(violations("scene", "use wgpu;"), ["scene names wgpu"]);
    assert_eq!(violations("math", "use crate::{scene, job};").len(), 1);
    assert!(violations("scene", "// crate::app is named in a comment only").is_empty());
    assert!(violations("fit", "use crate::job::Ticker;").is_empty());
}
