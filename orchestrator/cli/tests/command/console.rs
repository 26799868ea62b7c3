//! Output that cannot be written: a line for people that is lost changes nothing, and what was asked for and is lost
//! is told by the exit code. A full disk is `/dev/full`.
#![allow(clippy::unwrap_used)]

use std::fs::{self, File, OpenOptions};
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// A folder of two runs.
const RAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cmd/input/ran");

/// Commands with what they end with. `OUT` is a new folder; the others are files of this folder.
const COMMANDS: [(&str, i32); 12] = [
    ("--help", 0),
    ("--no-such-option", 2),
    ("show RAN", 0),
    ("show no-such-folder", 2),
    ("link show couva", 0),
    ("link lint wrong.toml", 2),
    ("system lint wrong.toml", 2),
    ("run no-such-experiment", 2),
    ("run wrong.toml --backend sim --out OUT", 2),
    ("run good.toml --backend sim --progress plain --out OUT", 0),
    ("margin", 0),
    ("matrix good.toml", 0),
];

fn webloop(place: &Path, line: &str, out: Stdio, error: Stdio) -> Output {
    let folder = tempfile::tempdir_in(place).unwrap();
    let new = folder.path().join("new");
    let words = line.split(' ').map(|word| match word {
        "RAN" => RAN.into(),
        "OUT" => new.clone().into_os_string(),
        word => word.into(),
    });
    let mut command = Command::new(env!("CARGO_BIN_EXE_webloop"));
    let command = command.args(words).current_dir(place);
    // Log lines as well.
    let command = command.env("RUST_LOG", "debug").stdout(out).stderr(error);
    command.output().unwrap()
}

fn full() -> Stdio {
    OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap()
        .into()
}

fn nowhere() -> Stdio {
    File::open("/dev/null").unwrap().into()
}

#[test]
fn what_cannot_be_printed_ends_nothing() {
    let place = tempfile::tempdir().unwrap();
    let good = "name = \"good\"\n[[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\nmode = \"closed\"\n\
                h = [\"10ms\"]\nduration = \"1s\"\nrepeats = 3\n";
    fs::write(place.path().join("good.toml"), good).unwrap();
    fs::write(
        place.path().join("wrong.toml"),
        "name = \"wrong\"\n[[cells\n",
    )
    .unwrap();
    for (line, expected) in COMMANDS {
        let code = |out, error| webloop(place.path(), line, out, error).status.code();
        assert_eq!(
            code(Stdio::piped(), Stdio::piped()),
            Some(expected),
            "{line}"
        );
        // Read-only: each write fails.
        for error in [full(), nowhere()] {
            assert_eq!(
                code(Stdio::piped(), error),
                Some(expected),
                "{line}, no stderr"
            );
        }
        let output = webloop(place.path(), line, full(), Stdio::piped());
        let said = String::from_utf8_lossy(&output.stderr);
        let is_asked = expected == 0 && line != "--help";
        let told = output.status.code() == Some(1)
            && said.contains("standard output cannot be written: No space left on device");
        assert!(
            if is_asked {
                told
            } else {
                output.status.code() == Some(expected)
            },
            "{line}, no stdout: {:?} {said}",
            output.status
        );
        let both = code(full(), full());
        assert!(
            both == Some(1) || both == Some(expected),
            "{line}: {both:?}"
        );
    }
}
