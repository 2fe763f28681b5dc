//! The library's layers: the mesh knows nothing of planets, planets nothing of files and pictures.

use std::fs;
use std::path::{Path, PathBuf};

/// Longest file of the library, in lines.
const LONGEST: usize = 600;

/// Every Rust file under a folder of the sources, with its text.
fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("src")
        .join(folder);
    let mut files = Vec::new();
    let mut folders = vec![root];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                files.push((path, text));
            }
        }
    }
    assert!(!files.is_empty(), "no sources in {folder}");
    files.sort();
    files
}

/// The code of a line, without its comment.
fn code(line: &str) -> &str {
    line.split("//").next().unwrap_or_default()
}

/// Whether a word stands in a line of code on its own.
fn names(line: &str, word: &str) -> bool {
    let part_of_name = |c: char| c.is_alphanumeric() || c == '_';
    code(line).match_indices(word).any(|(at, _)| {
        let before = code(line)[..at].chars().next_back();
        let after = code(line)[at + word.len()..].chars().next();
        !before.is_some_and(part_of_name) && !after.is_some_and(part_of_name)
    })
}

fn assert_never_names(folder: &str, words: &[&str]) {
    for (path, text) in sources(folder) {
        for (number, line) in text.lines().enumerate() {
            for word in words {
                assert!(
                    !names(line, word),
                    "{}:{}: {folder} must not know of {word}",
                    path.display(),
                    number + 1
                );
            }
        }
    }
}

/// Rooms are named by their paths: a word like `render` also stands in names of Bevy's.
fn assert_never_names_rooms(folder: &str, rooms: &[&str]) {
    let paths: Vec<String> = rooms.iter().map(|room| format!("crate::{room}")).collect();
    let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
    assert_never_names(folder, &paths);
}

#[test]
fn the_search_finds_what_it_looks_for() {
    assert!(names("use bevy::prelude::*;", "bevy"));
    assert!(names("use crate::{mesh, export};", "export"));
    assert!(!names("// as in bevy", "bevy"));
    assert!(!names("use bevy_tectonics::mesh;", "bevy"));
    assert!(!names("let exported = 1;", "export"));
}

#[test]
fn the_mesh_stands_alone() {
    assert_never_names(
        "mesh",
        &[
            "bevy",
            "bevy_tectonics",
            "simulation",
            "export",
            "render",
            "serde",
            "png",
            "rand",
            "std::time",
            "Instant",
        ],
    );
}

#[test]
fn the_simulation_knows_no_files_and_no_pictures() {
    assert_never_names(
        "simulation",
        &[
            "export",
            "render",
            "png",
            "serde_json",
            "std::fs",
            "File",
            "println",
            "eprintln",
        ],
    );
}

#[test]
fn what_reads_files_knows_histories_alone() {
    assert_never_names_rooms(
        "import",
        &["surface", "planet", "render", "editor", "export"],
    );
    assert_never_names_rooms("simulation", &["import"]);
}

#[test]
fn saves_know_histories_alone() {
    assert_never_names_rooms(
        "save",
        &["surface", "planet", "render", "editor", "export", "import"],
    );
    for folder in ["simulation", "surface", "render", "export", "import"] {
        assert_never_names_rooms(folder, &["save"]);
    }
}

#[test]
fn upper_rooms_stay_apart() {
    const UPPER: [&str; 3] = ["export", "render", "editor"];
    for folder in ["surface", "planet"] {
        assert_never_names_rooms(folder, &UPPER);
    }
    assert_never_names_rooms("surface", &["planet"]);
    for folder in UPPER {
        let others: Vec<&str> = UPPER.into_iter().filter(|room| *room != folder).collect();
        assert_never_names_rooms(folder, &others);
    }
}

/// Threads finish in any order, and hash maps iterate in one that changes from run to run.
#[test]
fn the_simulation_holds_nothing_that_depends_on_the_run() {
    for folder in ["mesh", "simulation"] {
        assert_never_names(
            folder,
            &[
                "HashMap",
                "HashSet",
                "EntityHashMap",
                "thread_rng",
                "SystemTime",
                "par_iter",
                "par_iter_mut",
            ],
        );
    }
}

#[test]
fn files_stay_short() {
    for (path, text) in sources("") {
        let lines = text.lines().count();
        assert!(lines <= LONGEST, "{} has {lines} lines", path.display());
    }
}
