//! Honest programs of other people's habits are not called cheats: a share of `tests/strangers`, by what a machine
//! has beyond Python's own library or not.

use std::path::Path;

use plan::Verdict;

use crate::webloop::{cells_of, code, command, manifest, said};

/// One habit of each kind: a connection that is kept, opened early, or opened for each message; with and without
/// numbers and times; in the program, in a library of its language, in a process for each message.
const STRANGERS: [&str; 6] = [
    "httpclient-t",
    "httpclient-each-q-t",
    "socket-early-q-t",
    "urllib-each-q",
    "curl-each-q-t",
    "node-fetch-q-t",
];

/// One whose round trip is short beside what a program takes, and one that varies.
const TOPOLOGIES: [&str; 2] = ["buccoo", "couva"];

/// How many run at a time: each mostly waits.
const JOBS: &str = "3";

pub(crate) fn honest_programs_are_not_called_cheats() -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/strangers/strangers.toml");
    let mut run = command();
    run.arg("run").arg(file).arg("--out").arg(&out);
    run.args(["--jobs", JOBS, "--tries", "1", "--no-report"]);
    for topology in TOPOLOGIES {
        for name in STRANGERS {
            run.args(["--only", &format!("{topology}-{name}-closed-50hz-r01")]);
        }
    }
    let ran = run.output().unwrap();
    assert!(matches!(code(&ran), Some(0 | 1)), "{}", said(&ran));
    let (mut complete, mut disturbed, mut not_here, mut called) = (0, 0, 0, Vec::new());
    for cell in cells_of(&out) {
        let manifest = manifest(&cell);
        match manifest.verdict {
            Verdict::Complete => complete += 1,
            Verdict::Disturbed => disturbed += 1,
            // Python is there, or this test would not be: it is Node or curl.
            Verdict::Unsupported => not_here += 1,
            verdict => called.push(format!(
                "{}: {verdict}: {:?}",
                manifest.cell.id, manifest.reasons
            )),
        }
    }
    println!(
        "of {} honest programs {complete} complete, {disturbed} disturbed by the machine, {not_here} not on this machine",
        STRANGERS.len() * TOPOLOGIES.len()
    );
    assert!(called.is_empty(), "{called:#?}");
    match complete {
        0 if disturbed == 0 => Err("no Python, no Node and no curl here".to_owned()),
        0 => Err(crate::webloop::too_busy("a program of others")),
        _ => Ok(()),
    }
}
