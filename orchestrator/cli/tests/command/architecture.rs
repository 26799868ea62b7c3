//! Checks ARCHITECTURE.md against the manifests: what each crate uses, and whether it is pure.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

const TOP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A crate as described by a row of the map, or by its manifest.
#[derive(Debug, PartialEq, Eq)]
struct Known {
    is_pure: bool,
    uses: BTreeSet<String>,
}

#[test]
fn the_map_says_of_each_crate_what_it_uses_and_whether_it_is_pure() {
    let said = said();
    let found = found();
    for (name, known) in &found {
        assert_eq!(said.get(name), Some(known), "{name} in ARCHITECTURE.md");
    }
    assert_eq!(said.len(), found.len(), "a crate of the map is gone");
}

#[test]
fn every_decision_that_the_map_names_is_there_and_every_one_that_is_there_is_named() {
    let map = fs::read_to_string(Path::new(TOP).join("ARCHITECTURE.md")).unwrap();
    let named: BTreeSet<String> = map
        .split("(docs/decisions/")
        .skip(1)
        .map(|rest| rest.split(')').next().unwrap().to_owned())
        .collect();
    let there = fs::read_dir(Path::new(TOP).join("docs/decisions")).unwrap();
    let there = there.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert_eq!(named, there.collect());
}

/// What `cargo test` leaves out, nobody would run if an alias forgot it.
#[test]
fn cargo_real_names_each_test_that_cargo_test_leaves_out() {
    let left_out: BTreeSet<String> = folders()
        .iter()
        .flat_map(|folder| tests(folder))
        .filter(|test| {
            test.get("test")
                .is_some_and(|is_in| is_in.as_bool() == Some(false))
        })
        .map(|test| test["name"].as_str().unwrap().to_owned())
        .collect();
    let config: toml::Table = read(&Path::new(TOP).join(".cargo/config.toml"));
    for alias in ["real", "real-clippy"] {
        let words = config["alias"][alias].as_str().unwrap();
        let named = words.split(" --test ").skip(1).map(str::to_owned);
        assert_eq!(named.collect::<BTreeSet<_>>(), left_out, "{alias}");
    }
}

/// The tests that a crate's manifest has something to say of.
fn tests(folder: &Path) -> Vec<toml::Value> {
    let manifest: toml::Table = read(&folder.join("Cargo.toml"));
    let tests = manifest.get("test").and_then(toml::Value::as_array);
    tests.cloned().unwrap_or_default()
}

fn read(file: &Path) -> toml::Table {
    fs::read_to_string(file).unwrap().parse().unwrap()
}

/// The rows `| `folder/name` | what it is (pure) | uses |`.
fn said() -> BTreeMap<String, Known> {
    let map = fs::read_to_string(Path::new(TOP).join("ARCHITECTURE.md")).unwrap();
    let crates = folders().into_iter().map(|folder| {
        let own = format!("| `{}` |", folder.strip_prefix(TOP).unwrap().display());
        let row = map.lines().find(|line| line.starts_with(&own));
        let row = row.unwrap_or_else(|| panic!("no row {own} in ARCHITECTURE.md"));
        let columns: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let uses = columns[2].split(", ").filter(|name| !name.is_empty());
        let known = Known {
            is_pure: columns[1].ends_with("(pure)"),
            uses: uses.map(str::to_owned).collect(),
        };
        (name(&folder), known)
    });
    crates.collect()
}

/// The same from the crates' manifests and their lists of what is banned.
fn found() -> BTreeMap<String, Known> {
    let folders = folders();
    let names: BTreeSet<String> = folders.iter().map(|folder| name(folder)).collect();
    let crates = folders.iter().map(|folder| {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        let own = manifest
            .split("\n[dependencies]\n")
            .nth(1)
            .unwrap_or_default();
        let own = own.split("\n[").next().unwrap_or_default();
        let uses = own.lines().filter_map(|line| line.split(['.', ' ']).next());
        let known = Known {
            is_pure: folder.join("clippy.toml").exists(),
            uses: uses
                .filter(|name| names.contains(*name))
                .map(str::to_owned)
                .collect(),
        };
        (name(folder), known)
    });
    crates.collect()
}

fn folders() -> Vec<PathBuf> {
    let crates =
        ["base", "netem", "services", "orchestrator"].map(|part| Path::new(TOP).join(part));
    let folders = crates.iter().flat_map(|part| fs::read_dir(part).unwrap());
    let mut folders: Vec<PathBuf> = folders
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.join("Cargo.toml").exists())
        .collect();
    folders.sort();
    folders
}

fn name(folder: &Path) -> String {
    folder.file_name().unwrap().to_str().unwrap().to_owned()
}
