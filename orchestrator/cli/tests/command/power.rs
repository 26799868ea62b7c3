//! The power fails at any moment: a manifest that is on the disk vouches for files that are.
//!
//! strace's record of the calls tells what is on the disk for certain: what was synced after it was last written.
//! A manifest has its name by one call, so if all was there before that call, it does not matter after which call
//! the power fails. A disk that says that it has synced and has not is another matter.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use record::Manifest;

use crate::traced::{WEBLOOP, experiment, strace};

/// What has reached the disk, by file: `false` while a write of it has not.
#[derive(Default)]
struct Disk(BTreeMap<PathBuf, bool>);

/// A call by its record: `write(5</path>, …`, `rename("/from", "/to")`.
enum Call<'a> {
    Write(&'a Path),
    Sync(&'a Path),
    /// Of all that was written before.
    SyncAll,
    Rename(&'a Path, &'a Path),
}

impl Call<'_> {
    /// `None` for what is no such call, or a part of one that began on an earlier line.
    fn read(line: &str) -> Option<Call<'_>> {
        let (_, call) = line.trim_start().split_once(' ')?;
        let (name, rest) = call.trim_start().split_once('(')?;
        let file = || {
            let (_, rest) = rest.split_once('<')?;
            Some(Path::new(rest.split_once('>')?.0))
        };
        match name {
            "write" | "writev" | "pwrite64" => file().map(Call::Write),
            "fsync" | "fdatasync" => file().map(Call::Sync),
            "syncfs" => Some(Call::SyncAll),
            "rename" | "renameat" | "renameat2" => {
                let mut names = rest.split('"').skip(1).step_by(2);
                Some(Call::Rename(
                    Path::new(names.next()?),
                    Path::new(names.next()?),
                ))
            }
            _ => None,
        }
    }
}

/// Checks a record; the number of its calls and of the files that its manifests vouch for.
fn check(record: &str) -> [usize; 2] {
    let mut disk = Disk::default();
    let (mut calls, mut files) = (0, 0);
    for call in record.lines().filter_map(Call::read) {
        calls += 1;
        match call {
            Call::Write(path) => {
                disk.0.insert(path.to_owned(), false);
            }
            Call::Sync(path) => {
                disk.0.insert(path.to_owned(), true);
            }
            Call::SyncAll => disk.0.values_mut().for_each(|synced| *synced = true),
            Call::Rename(from, to) => {
                let synced = disk.0.remove(from);
                if to.ends_with(Manifest::FILE) {
                    assert_eq!(synced, Some(true), "{}: synced before", from.display());
                    let text = fs::read_to_string(to).unwrap();
                    for name in Manifest::from_json(&text).unwrap().files.keys() {
                        let file = to.with_file_name(name);
                        let state = disk.0.get(&file);
                        assert_eq!(state, Some(&true), "{}: synced before", file.display());
                        files += 1;
                    }
                }
                disk.0.insert(to.to_owned(), synced.unwrap_or(true));
            }
        }
    }
    [calls, files]
}

#[test]
fn wherever_the_power_fails_a_manifest_vouches_for_what_is_on_the_disk() {
    let place = tempfile::tempdir().unwrap();
    let Some(experiment) = experiment(place.path(), 3) else {
        return;
    };
    let log = place.path().join("log");
    let ran = strace()
        .args(["-y", "-s", "0", "-e"])
        .arg("trace=write,writev,pwrite64,fsync,fdatasync,syncfs,rename,renameat,renameat2")
        .arg("-o")
        .arg(&log)
        .args([WEBLOOP, "run", "--backend", "sim", "--no-report"])
        .arg(&experiment)
        .arg("--out")
        .arg(place.path().join("out"))
        .output()
        .unwrap();
    assert!(ran.status.success(), "{ran:?}");
    let [calls, files] = check(&fs::read_to_string(log).unwrap());
    assert!(files >= 3 * 5, "{files}");
    println!(
        "row 7: the power fails after any of {calls} calls of a campaign: each of the {files} files that its manifests vouch for had been synced before the manifest had its name"
    );
}

#[test]
fn a_manifest_that_comes_before_its_rows_is_found() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name).display().to_string();
    let sample =
        include_str!("../cmd/input/ran/cells/arima-native-open-10hz-r01-000001/manifest.json");
    fs::write(at("manifest.json"), sample).unwrap();
    let record = format!(
        "1 write(5<{}>, \"\"..., 9) = 9\n1 fsync(5<{0}>) = 0\n1 rename(\"{0}\", \"{}\") = 0\n",
        at("manifest.partial"),
        at("manifest.json")
    );
    assert!(std::panic::catch_unwind(|| check(&record)).is_err());
}
