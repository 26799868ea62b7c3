//! Files of every kind that somebody or a disk has damaged: each command that reads one ends within 2 s of processor
//! time and 200 MB, without a panic, and says with its exit code how it ended.
//!
//! `WEBLOOP_TEST_MUTATIONS=10000` damages each kind so many times. The limits are the kernel's, on a child process:
//! so a busy machine does not matter. `mutation` has the ways to damage a file.
#![allow(clippy::unwrap_used)]

mod mutation;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;
use record::FileFact;
use tempfile::TempDir;

use crate::ended::{Ended, ended};
use crate::falsified::place::{copy, edit_json};

/// Processor time that a command may take, s: of one that is compiled for tests, thrice as much.
const MOST_S: u32 = if cfg!(debug_assertions) { 6 } else { 2 };
/// Memory of its own, KiB.
const MOST_KIB: u32 = 200_000_000 / 1024;

/// So much of the end of what a command said is told.
const SAID_BYTES: usize = 2000;

/// Two links and a system with two outputs, a second of each; one link loses, stalls and has a queue.
const EXPERIMENT: &str = "name = \"mine\"\n[[cells]]\ntopology = [\"couva\", \"./mine-link.toml\"]\nsystem = [\"motor\"]\n\
client = [\"native\"]\nmode = \"closed\"\nh = [\"10ms\"]\nduration = \"1s\"\n\
[[cells]]\ntopology = [\"couva\"]\nsystem = [\"cart\"]\nclient = [\"native\"]\nmode = \"closed\"\nh = [\"10ms\"]\n\
duration = \"1s\"\n";

const PROFILE: &str = "name = \"mine-link\"\nabout = \"a trace up, a queue down\"\n\
[up.trace]\nfile = \"mine-trace.csv\"\n[down.delay]\nbase = \"5ms\"\n\
[down.loss.random]\nshare = \"2%\"\n";

const TRACE: &str =
    "t_ms,delay_ms,loss_percent\n0,5,0\n500,20,1\n1000,7.5,0\n2250,30,50\n3000,6,0\n";

const SYSTEM: &str = "name = \"mine\"\nabout = \"a lag\"\n[plant]\nnum = [2.0]\nden = [0.5, 1.0, 0.0]\ndead_time = \"25ms\"\n\
[controller]\nlaw = \"pid\"\nkp = 0.5\nki = 0.2\n";

const SWEEP: &str = include_str!("../../../experiments/loss-jitter.toml");

/// Commands that read a results folder, which is `victim`.
const READERS: [&str; 8] = [
    "show victim",
    "show victim --format budget",
    "show victim --format lateness",
    "show victim --format intervals",
    "report victim",
    "compare honest victim",
    "agree honest victim",
    "collect victim --out collected",
];

/// Commands that read a link, with the file that it names.
const LINK_READERS: [&str; 4] = [
    "link show ./mine-link.toml",
    "link lint ./mine-link.toml",
    "link show ./mine-link.toml --tc",
    "margin --topology ./mine-link.toml --h 10ms",
];

/// A kind of file, and the commands that read it.
struct Kind {
    /// Its path; for a file of a cell, in there.
    file: &'static str,
    commands: &'static [&'static str],
    is_of_cell: bool,
}

const fn of_cell(file: &'static str) -> Kind {
    Kind {
        file,
        commands: &READERS,
        is_of_cell: true,
    }
}

const fn given(file: &'static str, commands: &'static [&'static str]) -> Kind {
    Kind {
        file,
        commands,
        is_of_cell: false,
    }
}

const KINDS: [Kind; 16] = [
    of_cell("ticks.csv"),
    of_cell("second.csv"),
    of_cell("arrivals.csv"),
    of_cell("messages.csv"),
    of_cell("probes.csv"),
    of_cell("manifest.json"),
    of_cell("plant.json"),
    of_cell("controller.json"),
    of_cell("link.json"),
    of_cell("profile.toml"),
    given("victim/plan.json", &READERS),
    given(
        "mine.toml",
        &["run mine.toml --dry-run", "matrix mine.toml"],
    ),
    given("mine-link.toml", &LINK_READERS),
    given("mine-trace.csv", &LINK_READERS),
    given(
        "mine-system.toml",
        &[
            "system lint ./mine-system.toml",
            "system show ./mine-system.toml",
            "margin --system ./mine-system.toml",
        ],
    ),
    given("mine-sweep.toml", &["run mine-sweep.toml --dry-run"]),
];

/// What is damaged, and what it is compared with.
struct Place {
    folder: TempDir,
    cells: Vec<PathBuf>,
}

impl Place {
    fn new() -> Place {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [
            ("mine.toml", EXPERIMENT),
            ("mine-link.toml", PROFILE),
            ("mine-trace.csv", TRACE),
            ("mine-system.toml", SYSTEM),
            ("mine-sweep.toml", SWEEP),
        ] {
            fs::write(folder.path().join(name), text).unwrap();
        }
        let ran = webloop(
            folder.path(),
            "run mine.toml --backend sim --out honest --progress quiet",
        );
        assert_eq!(ran.code, Some(0), "{}", ran.said);
        copy(&folder.path().join("honest"), &folder.path().join("victim"));
        let cells = fs::read_dir(folder.path().join("victim/cells")).unwrap();
        let mut cells: Vec<PathBuf> = cells.map(|cell| cell.unwrap().path()).collect();
        cells.sort();
        Place { folder, cells }
    }

    /// Damages a kind of file for the n-th time, runs a command, and mends it. Returns what went wrong.
    fn damage(&self, kind: &Kind, n: u64) -> Option<String> {
        let cells: Vec<&PathBuf> = self
            .cells
            .iter()
            .filter(|cell| cell.join(kind.file).exists())
            .collect();
        let cell = cells.get(n as usize % cells.len().max(1));
        let path = match cell {
            Some(cell) if kind.is_of_cell => cell.join(kind.file),
            _ => self.folder.path().join(kind.file),
        };
        let whole = fs::read(&path).unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(n);
        let (damaged, how) = mutation::damaged(&whole, &mut random);
        fs::write(&path, &damaged).unwrap();
        let manifest = cell.map(|cell| cell.join("manifest.json"));
        let sealed = manifest
            .filter(|path| kind.is_of_cell && kind.file != "manifest.json" && path.exists());
        // Every second time the checksum is brought up to it, so that what is behind that is tried.
        let before = sealed.filter(|_| n.is_multiple_of(2)).map(|manifest| {
            let text = fs::read(&manifest).unwrap();
            let fact = FileFact::of(File::open(&path).unwrap()).unwrap();
            edit_json(&manifest, |json| {
                json["files"][kind.file] = serde_json::to_value(&fact).unwrap();
            });
            (manifest, text)
        });
        let command = kind.commands[(n / 2) as usize % kind.commands.len()];
        let _ = fs::remove_dir_all(self.folder.path().join("collected"));
        let ended = webloop(self.folder.path(), command);
        fs::write(&path, whole).unwrap();
        if let Some((manifest, text)) = before {
            fs::write(manifest, text).unwrap();
        }
        let is_fine = matches!(ended.code, Some(0..=3)) && !ended.said.contains("panicked");
        (!is_fine).then(|| {
            let Ended { code, said } = ended;
            let file = kind.file;
            let from = said.len().saturating_sub(SAID_BYTES);
            let said = String::from_utf8_lossy(&said.as_bytes()[from..]);
            format!("{file}, number {n}, {how}: `{command}` ended with {code:?}: {said}")
        })
    }
}

/// Runs a command within the limits.
fn webloop(place: &Path, words: &str) -> Ended {
    let limits = format!("ulimit -d {MOST_KIB}; ulimit -t {MOST_S}; exec \"$@\"");
    let mut command = Command::new("sh");
    command
        .args(["-c", &limits, "sh", env!("CARGO_BIN_EXE_webloop")])
        .args(words.split(' '))
        .current_dir(place);
    ended(&mut command)
}

/// Tries each job in one of two threads, which each have a place of their own. Returns what went wrong.
fn by_two<J, P>(
    jobs: impl Iterator<Item = J> + Send,
    place: impl Fn() -> P + Sync,
    tried: impl Fn(&P, J) -> Option<String> + Sync,
) -> Vec<String> {
    let jobs = Mutex::new(jobs);
    let wrong = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                let place = place();
                loop {
                    let job = jobs.lock().unwrap().next();
                    let Some(job) = job else { return };
                    wrong.lock().unwrap().extend(tried(&place, job));
                }
            });
        }
    });
    wrong.into_inner().unwrap()
}

#[test]
fn margins_end_within_their_limits_whatever_a_number_of_a_system() {
    let cart = plan::system::System::built_in("cart").unwrap();
    let texts = [SYSTEM, cart].map(|text| mutation::out_of_proportion(text.as_bytes()));
    let copies = texts.into_iter().flatten();
    let place = || tempfile::tempdir().unwrap();
    let wrong = by_two(copies, place, |folder, copy| {
        fs::write(folder.path().join("mine.toml"), &copy).unwrap();
        let Ended { code, said } = webloop(folder.path(), "margin --system ./mine.toml");
        let is_fine = matches!(code, Some(0..=3)) && !said.contains("panicked");
        let copy = String::from_utf8_lossy(&copy);
        (!is_fine).then(|| format!("ended with {code:?}: {said}\n{copy}"))
    });
    assert!(wrong.is_empty(), "{}: {}", wrong.len(), wrong.join("\n"));
}

#[test]
fn every_command_ends_within_its_limits_on_whatever_file() {
    const COUNT: &str = "WEBLOOP_TEST_MUTATIONS";
    let count: u64 = std::env::var(COUNT).map_or(20, |count| count.parse().expect(COUNT));
    let only = std::env::var("WEBLOOP_TEST_KIND").unwrap_or_default();
    let kinds: Vec<&Kind> = KINDS
        .iter()
        .filter(|kind| kind.file.contains(&only))
        .collect();
    let jobs = kinds
        .iter()
        .flat_map(|kind| (0..count).map(move |n| (*kind, n)));
    let wrong = by_two(jobs, Place::new, |place, (kind, n)| place.damage(kind, n));
    println!(
        "{} of {} damaged files were too much for a command",
        wrong.len(),
        kinds.len() as u64 * count
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
