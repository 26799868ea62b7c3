//! A campaign that is killed again and again: no cell that was finished runs again, and the tables in the end are
//! those of a campaign that nobody disturbed.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, SystemTime};

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// 24 cells.
const EXPERIMENT: &str = "name = \"resumed\"\n[[cells]]\ntopology = [\"arima\", \"couva\", \"diego-vpn\"]\n\
client = [\"native\", \"python\"]\nmode = \"closed\"\nh = [\"3ms\"]\nduration = \"2s\"\nrepeats = 4\n";
const KILLS: usize = 10;

fn run(experiment: &Path, out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_webloop"));
    command
        .arg("run")
        .arg(experiment)
        .args(["--backend", "sim", "--jobs", "1", "--out"]);
    command.arg(out).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// When the manifest of each finished cell was written.
fn finished(out: &Path) -> BTreeMap<String, SystemTime> {
    let cells = fs::read_dir(out.join("cells"))
        .into_iter()
        .flatten()
        .flatten();
    let cells = cells.filter_map(|cell| {
        let manifest = fs::metadata(cell.path().join("manifest.json")).ok()?;
        Some((
            cell.file_name().to_string_lossy().into_owned(),
            manifest.modified().ok()?,
        ))
    });
    cells.collect()
}

#[test]
fn a_campaign_that_is_killed_again_and_again_ends_as_an_undisturbed_one() {
    let place = tempfile::tempdir().unwrap();
    let experiment = place.path().join("resumed.toml");
    fs::write(&experiment, EXPERIMENT).unwrap();
    let (whole, broken) = (place.path().join("whole"), place.path().join("broken"));
    assert!(run(&experiment, &whole).status().unwrap().success());
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let (mut before, mut kills) = (BTreeMap::new(), 0);
    while kills < KILLS {
        let mut campaign = run(&experiment, &broken).spawn().unwrap();
        // Two or three cells, in a build for tests.
        thread::sleep(Duration::from_millis(100 + random.next_u64() % 200));
        if campaign.try_wait().unwrap().is_none() {
            campaign.kill().unwrap();
            kills += 1;
        } else {
            // All are finished: from the beginning.
            fs::remove_dir_all(&broken).unwrap();
            before.clear();
        }
        campaign.wait().unwrap();
        let now = finished(&broken);
        for (cell, written) in &before {
            assert_eq!(now.get(cell), Some(written), "{cell}");
        }
        before = now;
    }
    assert!(run(&experiment, &broken).status().unwrap().success());
    let now = finished(&broken);
    for (cell, written) in &before {
        assert_eq!(now.get(cell), Some(written), "{cell}");
    }
    for name in ["summary.csv", "table.txt"] {
        let read = |folder: &Path| fs::read(folder.join(name)).unwrap();
        assert!(read(&whole) == read(&broken), "{name}");
    }
    println!(
        "row 8: {KILLS} kills in 24 cells: 0 finished cells run again, tables equal to those of an undisturbed run"
    );
}
