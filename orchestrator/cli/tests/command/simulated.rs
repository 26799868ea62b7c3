//! Virtual time through the binary: the same rows whatever the jobs, the folder, the time zone and
//! the language, and a campaign that can be shown and reported and agrees with itself.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use sha2::{Digest, Sha256};

const EXPERIMENT: &str = "name = \"mine\"\n\
[[cells]]\n\
topology = [\"arima\", \"couva\", \"diego-vpn\"]\n\
client = [\"native\", \"python\"]\n\
mode = \"closed\"\n\
h = [\"3ms\"]\n\
duration = \"2s\"\n\
repeats = 2\n";

fn webloop(arguments: &[&str], variables: &[(&str, &str)]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_webloop"))
        .args(arguments)
        .envs(variables.iter().copied())
        .env_remove("RUST_LOG")
        .output();
    output.unwrap()
}

fn run(place: &Path, name: &str, more: &[&str], variables: &[(&str, &str)]) -> Output {
    let experiment = place.join("mine.toml");
    fs::write(&experiment, EXPERIMENT).unwrap();
    let (experiment, out) = (experiment.to_str().unwrap(), place.join(name));
    let out = out.to_str().unwrap();
    let arguments = [&["run", experiment, "--backend", "sim", "--out", out], more].concat();
    webloop(&arguments, variables)
}

/// Every file of rows, by its path within the folder.
fn rows(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut rows = BTreeMap::new();
    for cell in fs::read_dir(folder.join("cells")).unwrap() {
        let cell = cell.unwrap().path();
        for file in ["ticks.csv", "arrivals.csv", "messages.csv", "probes.csv"] {
            let path = cell.join(file);
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            rows.insert(name, fs::read(&path).unwrap());
        }
        assert!(!cell.join("packets.csv").exists(), "there is no rate limit");
    }
    rows
}

#[test]
fn a_seed_gives_the_same_rows_whatever_is_around_it_and_another_seed_others() {
    let place = tempfile::tempdir().unwrap();
    let first = run(place.path(), "first", &["--jobs", "1"], &[]);
    let said = String::from_utf8_lossy(&first.stderr).into_owned();
    assert_eq!(first.status.code(), Some(0), "{said}");
    let first = rows(&place.path().join("first"));
    assert_eq!(first.len(), 12 * 4);
    assert!(first.values().all(|content| content.len() > 100));

    let elsewhere = [("TZ", "Pacific/Kiritimati"), ("LC_ALL", "de_DE.UTF-8")];
    let second = run(place.path(), "a/second", &["--jobs", "2"], &elsewhere);
    assert_eq!(second.status.code(), Some(0));
    assert_eq!(rows(&place.path().join("a/second")), first);

    let other = run(place.path(), "other", &["--seed", "2"], &[]);
    assert_eq!(other.status.code(), Some(0));
    assert_ne!(rows(&place.path().join("other")), first);

    let more = if seeds().is_some() { 8 } else { 0 };
    for n in 0..more {
        let jobs = if n % 2 == 0 { "1" } else { "2" };
        let zone = ["UTC", "Asia/Kathmandu", "America/St_Johns", "Pacific/Apia"][n / 2];
        let around = [("TZ", zone), ("LC_ALL", "C"), ("HOSTNAME", zone)];
        let name = format!("{n}/again");
        let again = run(place.path(), &name, &["--jobs", jobs], &around);
        assert_eq!(again.status.code(), Some(0));
        assert_eq!(rows(&place.path().join(name)), first);
    }
    println!(
        "row 5: {} runs with other jobs, folders, zones and languages: equal rows",
        2 + more
    );
}

/// As many seeds as are asked for.
fn seeds() -> Option<usize> {
    let count = std::env::var("WEBLOOP_TEST_SEEDS").ok()?;
    Some(count.parse().unwrap())
}

/// A digest of the rows of each cell, by the cell's folder.
fn digests(folder: &Path) -> BTreeMap<String, [u8; 32]> {
    let mut digests: BTreeMap<String, Sha256> = BTreeMap::new();
    for (name, content) in rows(folder) {
        let (cell, _) = name.rsplit_once('/').unwrap();
        digests.entry(cell.to_owned()).or_default().update(content);
    }
    let digests = digests.into_iter();
    digests
        .map(|(cell, digest)| (cell, digest.finalize().into()))
        .collect()
}

/// Each repeat has a seed of its own. `WEBLOOP_TEST_SEEDS=1000` takes as many.
#[test]
fn every_seed_gives_its_own_rows_and_twice_the_same() {
    let place = tempfile::tempdir().unwrap();
    let count = seeds().unwrap_or(6);
    let experiment = place.path().join("seeds.toml");
    let text = format!(
        "name = \"seeds\"\n[[cells]]\ntopology = [\"diego-vpn\"]\nclient = [\"native\"]\nmode = \"closed\"\n\
         h = [\"3ms\"]\nduration = \"500ms\"\nrepeats = {count}\n"
    );
    fs::write(&experiment, text).unwrap();
    let run = |name: &str, more: &[&str]| {
        let out = place.path().join(name);
        let paths = [&experiment, &out].map(|path| path.to_str().unwrap());
        let all = [
            "run",
            paths[0],
            "--backend",
            "sim",
            "--no-report",
            "--out",
            paths[1],
        ];
        let ran = webloop(&[&all, more].concat(), &[]);
        let said = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert_eq!(ran.status.code(), Some(0), "{said}");
        let digests = digests(&out);
        assert_eq!(digests.len(), count);
        digests
    };
    let first = run("first", &["--jobs", "1"]);
    assert_eq!(run("second", &["--jobs", "2"]), first);
    let own: BTreeSet<_> = first.values().collect();
    assert_eq!(own.len(), count, "each seed its own rows");
    let other = run("other", &["--seed", "2"]);
    let differ = other.values().filter(|digest| !own.contains(digest));
    assert_eq!(differ.count(), count);
    println!("row 5: {count} seeds run twice: equal; {count} of {count} others differ");
}

/// At 64 kbit/s an echo alone takes 10.5 ms each way, and waits for the messages before it.
#[test]
fn a_link_with_a_rate_limit_holds_its_certificate_and_keeps_its_packets() {
    let place = tempfile::tempdir().unwrap();
    let topologies = ["64kbit", "1mbit", "10mbit"].map(|rate| {
        let path = place.path().join(format!("r{rate}.toml"));
        let text = format!(
            "name = \"r{rate}\"\nabout = \"x\"\n[both]\nrate = \"{rate}\"\ndelay = {{ base = \"2ms\" }}\n"
        );
        fs::write(&path, text).unwrap();
        format!("{path:?}")
    });
    let experiment = place.path().join("rates.toml");
    let text = EXPERIMENT
        .replace(
            "\"arima\", \"couva\", \"diego-vpn\"",
            &topologies.join(", "),
        )
        .replace("\"3ms\"", "\"100ms\", \"3ms\"");
    fs::write(&experiment, text).unwrap();
    let out = place.path().join("out");
    let paths = [&experiment, &out].map(|path| path.to_str().unwrap());
    let ran = webloop(
        &["run", paths[0], "--backend", "sim", "--out", paths[1]],
        &[],
    );
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert_eq!(ran.status.code(), Some(0), "{said}");
    let mut cells = 0;
    for cell in fs::read_dir(out.join("cells")).unwrap() {
        let packets = fs::read_to_string(cell.unwrap().path().join("packets.csv")).unwrap();
        let mut lines = packets.lines();
        assert_eq!(lines.next(), Some("t_ns,way,bytes"));
        // The first packet is the first echo after link time 0, which is 1 s: it leaves within its
        // 20 ms.
        let first: Vec<&str> = lines.next().unwrap().split(',').collect();
        let t_ns: u64 = first[0].parse().unwrap();
        assert!((1_100_000_000..1_120_000_000).contains(&t_ns), "{t_ns}");
        assert_eq!(first[1..], ["up", "84"]);
        cells += 1;
    }
    assert_eq!(cells, 3 * 2 * 2 * 2);
}

/// As in every back-end: the folder of a cell shows which loop it was.
#[test]
fn a_cell_keeps_the_text_of_its_system() {
    let place = tempfile::tempdir().unwrap();
    let (experiment, out) = (place.path().join("mine.toml"), place.path().join("out"));
    let text = EXPERIMENT.replace("client = [\"native\", \"python\"]", "client = [\"native\"]");
    fs::write(&experiment, text + "system = [\"motor\", \"lag\"]\n").unwrap();
    let paths = [&experiment, &out].map(|path| path.to_str().unwrap());
    let ran = webloop(
        &["run", paths[0], "--backend", "sim", "--out", paths[1]],
        &[],
    );
    assert_eq!(ran.status.code(), Some(0));
    let lag = plan::system::System::built_in("lag").unwrap();
    let mut kept = 0;
    for cell in fs::read_dir(out.join("cells")).unwrap() {
        let own = cell.unwrap().path().join("system.toml");
        // The paper's system is the default, and is not stored.
        if let Ok(text) = fs::read_to_string(&own) {
            assert_eq!(text, lag, "{}", own.display());
            kept += 1;
        }
    }
    assert_eq!(kept, 3 * 2);
}

#[test]
fn its_folder_is_like_any_other_and_agrees_with_itself() {
    let place = tempfile::tempdir().unwrap();
    let ran = run(place.path(), "ran", &[], &[]);
    let table = String::from_utf8_lossy(&ran.stdout).into_owned();
    assert!(
        table.contains("12/12") || table.contains("holds"),
        "{table}"
    );
    let folder = place.path().join("ran");
    let folder = folder.to_str().unwrap();
    for command in ["show", "report"] {
        let output = webloop(&[command, folder], &[]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{command}: {said}");
    }
    let agreed = webloop(&["agree", folder, folder], &[]);
    let said = String::from_utf8_lossy(&agreed.stdout).into_owned();
    assert_eq!(agreed.status.code(), Some(0), "{said}");
    assert!(said.contains("and 0 differ."), "{said}");
}

#[test]
fn a_folder_that_lacks_a_cell_is_shown_with_its_name_and_exit_one() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), "ran", &["--no-report"], &[]);
    let folder = place.path().join("ran");
    let mut cells = fs::read_dir(folder.join("cells")).unwrap();
    let gone = cells.next().unwrap().unwrap();
    fs::remove_dir_all(gone.path()).unwrap();
    let folder = folder.to_str().unwrap();
    for format in ["table", "csv", "lateness"] {
        let shown = webloop(&["show", folder, "--format", format], &[]);
        let said = String::from_utf8_lossy(&shown.stderr).into_owned();
        assert_eq!(shown.status.code(), Some(1), "{format}: {said}");
        let name = gone.file_name().to_string_lossy().into_owned();
        assert!(
            said.contains(&format!("1 of 12 cells have not been run: {name}")),
            "{said}"
        );
        let allowed = webloop(
            &["show", folder, "--format", format, "--allow-missing"],
            &[],
        );
        assert_eq!(allowed.status.code(), Some(0));
    }
}

#[test]
fn timings_that_are_none_are_refused_with_their_place() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("timings.toml");
    fs::write(&file, "[native.3ms]\nlate_ns = [1, 2]\n").unwrap();
    let file = file.to_str().unwrap();
    let output = run(place.path(), "ran", &["--timing", file], &[]);
    assert_ne!(output.status.code(), Some(0));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("33 quantiles"), "{said}");
}
