//! A folder of which anything was changed is not believed, whatever it was.

use std::fs;
use std::path::{Path, PathBuf};

use analysis::Campaign;
use plan::Verdict;
use proptest::prelude::*;
use proptest::sample::Index;

/// Two runs of a second each.
const RAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../cli/tests/cmd/input/ran");

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a writable folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("a name");
        let to = to.join(entry.file_name());
        if entry.file_type().expect("a kind").is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).expect("a writable folder");
        }
    }
}

/// A copy of the runs, with the files that their manifests list.
fn folder() -> (tempfile::TempDir, Vec<PathBuf>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    copy(Path::new(RAN), folder.path());
    let campaign = Campaign::read(folder.path()).expect("a results folder");
    assert_eq!(campaign.damage(), []);
    let runs = campaign.runs.iter();
    let listed = runs.flat_map(|run| {
        let files = &run.manifest.as_ref().expect("it was run").files;
        files.keys().map(|name| run.folder.join(name))
    });
    (folder, listed.collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_byte_that_was_changed_taken_or_added_damages_its_file_and_no_other(
        which in any::<Index>(),
        at in any::<Index>(),
        change in 0_u8..3,
        byte in 1_u8..,
    ) {
        let (folder, listed) = folder();
        let path = which.get(&listed);
        let mut bytes = fs::read(path).expect("a file");
        let at = at.index(bytes.len());
        match change {
            0 => bytes[at] ^= byte,
            1 => drop(bytes.remove(at)),
            _ => bytes.insert(at, byte),
        }
        fs::write(path, bytes).expect("a writable folder");
        let campaign = Campaign::read(folder.path()).expect("a results folder");
        let damaged: Vec<PathBuf> = campaign.damage().into_iter().map(|damage| damage.path).collect();
        // Of a report the rows' counts are read too, and may differ from them.
        prop_assert!(damaged.contains(path), "{damaged:?}");
        for run in &campaign.runs {
            let is_its = path.starts_with(&run.folder);
            prop_assert_eq!(run.metrics.is_none(), is_its);
            prop_assert_eq!(run.is_complete(), !is_its);
            prop_assert_eq!(run.verdict(), Some(Verdict::Complete));
        }
        let own = path.parent().expect("a cell's folder");
        prop_assert!(damaged.iter().all(|path| path.starts_with(own)));
    }
}
