//! One bit that is wrong in a results folder, anywhere in a file that a manifest vouches for: it is found.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

const EXPERIMENT: &str = "name = \"flipped\"\n[[cells]]\ntopology = [\"diego-vpn\"]\nclient = [\"native\"]\nmode = \"closed\"\n\
h = [\"10ms\"]\nduration = \"1s\"\n";

fn webloop(arguments: &[&Path]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_webloop"));
    command.args(arguments).output().unwrap()
}

/// `WEBLOOP_TEST_FLIPS=1000` flips as many, one at a time.
#[test]
fn a_flipped_bit_is_found() {
    const COUNT: &str = "WEBLOOP_TEST_FLIPS";
    let count: usize = std::env::var(COUNT).map_or(30, |count| count.parse().expect(COUNT));
    let place = tempfile::tempdir().unwrap();
    let (experiment, out) = (place.path().join("flipped.toml"), place.path().join("out"));
    fs::write(&experiment, EXPERIMENT).unwrap();
    let word = Path::new;
    let ran = webloop(&[
        word("run"),
        &experiment,
        word("--backend"),
        word("sim"),
        word("--out"),
        &out,
    ]);
    assert!(ran.status.success());
    let cell = fs::read_dir(out.join("cells"))
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    let files: Vec<PathBuf> = fs::read_dir(cell)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.file_name() != Some("manifest.json".as_ref()))
        .collect();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut below = |most: usize| (random.next_u64() % most as u64) as usize;
    for n in 0..count {
        let path = &files[below(files.len())];
        let whole = fs::read(path).unwrap();
        let mut flipped = whole.clone();
        flipped[below(whole.len())] ^= 1 << below(8);
        fs::write(path, flipped).unwrap();
        let merged = place.path().join(format!("merged-{n}"));
        let collected = webloop(&[word("collect"), &out, word("--out"), &merged]);
        let said = String::from_utf8_lossy(&collected.stderr);
        let name = path.file_name().unwrap().to_string_lossy();
        assert_eq!(collected.status.code(), Some(1), "{name}: {said}");
        assert!(said.contains(&*name), "{name}: {said}");
        fs::write(path, whole).unwrap();
        fs::remove_dir_all(merged).unwrap();
    }
    println!(
        "row 26: {count} of {count} flipped bits found by `webloop collect`, each with its file, in the {} files that a manifest vouches for",
        files.len()
    );
}
