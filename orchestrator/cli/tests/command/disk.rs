//! A disk that is full or broken at any moment: whichever write, sync or rename fails, no run says that it is
//! complete unless all that it wrote is there, nothing panics, and the cause is named.
//!
//! strace makes the system calls fail. `WEBLOOP_TEST_LONG=1` takes each of them, otherwise some are taken.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use plan::Verdict;
use record::Manifest;

use crate::traced::{WEBLOOP, experiment, strace};

const ERRORS: [(&str, &str); 2] = [
    ("ENOSPC", "No space left on device"),
    ("EIO", "Input/output error"),
];

/// strace of a run of the plan's cell into a folder.
fn traced_cell(place: &Path, out: &Path, arguments: &[&str]) -> Command {
    let mut command = strace();
    command
        .args(arguments)
        .args([WEBLOOP, "run-cell", "--backend", "sim", "--index", "0"])
        .arg("--plan")
        .arg(place.join("plan.json"))
        .arg("--out")
        .arg(out);
    command
}

/// Runs a simulated cell whose system call `call` fails with `error` at its nth time.
fn run(place: &Path, out: &Path, call: &str, error: &str, nth: usize) -> Output {
    let trace = format!("trace={call}");
    let inject = format!("inject={call}:error={error}:when={nth}");
    let arguments = ["-o", "/dev/null", "-e", &trace, "-e", &inject];
    traced_cell(place, out, &arguments).output().unwrap()
}

/// How often the run makes this call.
fn count(place: &Path, call: &str) -> usize {
    let (out, log) = (place.join(format!("count-{call}")), place.join("log"));
    let trace = format!("trace={call}");
    let arguments = ["-e", &trace, "-o", &log.display().to_string()];
    let status = traced_cell(place, &out, &arguments).status();
    assert!(status.unwrap().success());
    let log = fs::read_to_string(log).unwrap();
    log.lines()
        .filter(|line| line.contains(&format!("{call}(")))
        .count()
}

/// Whether a cell of the folder says that it is complete. Each manifest that is there must be whole.
fn is_complete(out: &Path) -> bool {
    let cells = fs::read_dir(out.join("cells"));
    let cells = cells.into_iter().flatten().flatten();
    let texts = cells.filter_map(|cell| fs::read_to_string(cell.path().join("manifest.json")).ok());
    let mut manifests = texts.map(|text| Manifest::from_json(&text).unwrap());
    manifests.any(|manifest| manifest.verdict == Verdict::Complete)
}

/// Whether every checksum of the folder holds.
fn verifies(place: &Path, out: &Path) -> bool {
    let other = tempfile::tempdir_in(place).unwrap();
    let status = Command::new(WEBLOOP)
        .arg("collect")
        .arg(out)
        .arg("--out")
        .arg(other.path().join("new"))
        .output();
    status.unwrap().status.success()
}

#[test]
fn whatever_of_the_disk_fails_is_named_and_no_run_is_complete_without_its_rows() {
    let place = tempfile::tempdir().unwrap();
    let Some(experiment) = experiment(place.path(), 1) else {
        return;
    };
    let matrix = Command::new(WEBLOOP)
        .arg("matrix")
        .arg(&experiment)
        .arg("--plan")
        .arg(place.path().join("plan.json"))
        .output();
    assert!(matrix.unwrap().status.success());
    let is_long = std::env::var_os("WEBLOOP_TEST_LONG").is_some();
    let (mut injected, mut failed, mut whole, mut unnamed) = (0, 0, 0, Vec::new());
    for call in ["write", "fsync", "rename", "mkdir"] {
        let calls = count(place.path(), call);
        assert!(calls > 0, "{call}");
        let step = if is_long { 1 } else { calls.div_ceil(5) };
        for (error, words) in ERRORS {
            for nth in (1..=calls).step_by(step) {
                let name = format!("{call}-{error}-{nth}");
                let out = place.path().join(&name);
                let output = run(place.path(), &out, call, error, nth);
                let said = String::from_utf8_lossy(&output.stderr);
                let code = output.status.code();
                assert!(
                    code.is_some_and(|code| code < 100),
                    "{name}: {:?} {said}",
                    output.status
                );
                assert!(!said.contains("panicked"), "{name}: {said}");
                injected += 1;
                if is_complete(&out) {
                    assert!(
                        verifies(place.path(), &out),
                        "{name}: complete and not whole"
                    );
                    whole += 1;
                } else {
                    assert_ne!(code, Some(0), "{name}: {said}");
                    failed += 1;
                }
                // What was to be printed may be what could not be written.
                if code != Some(0) && !said.contains(words) && !said.is_empty() {
                    unnamed.push(format!("{name}: {said}"));
                }
                let _ = fs::remove_dir_all(&out);
            }
        }
    }
    assert!(unnamed.is_empty(), "{unnamed:#?}");
    println!(
        "row 9: {injected} times a write, sync, rename or mkdir failed: {failed} runs failed with the cause named, {whole} complete with all they wrote, 0 panics"
    );
    println!(
        "row 7: {injected} calls that failed: no manifest mixed, {whole} of {whole} complete runs verify"
    );
    println!(
        "row 4: {failed} of {failed} runs that failed by the disk ended with another code than 0"
    );
}

/// Cells of a campaign in virtual time ask the disk together.
#[test]
fn a_disk_that_fails_a_campaign_s_cells_together_is_named_and_none_of_them_is_complete() {
    let place = tempfile::tempdir().unwrap();
    let Some(experiment) = experiment(place.path(), 3) else {
        return;
    };
    let out = place.path().join("out");
    let run = |more: &[&str]| {
        strace()
            .args(["-o", "/dev/null", "-e", "trace=syncfs"])
            .args(more)
            .args([WEBLOOP, "run", "--backend", "sim", "--no-report"])
            .arg(&experiment)
            .arg("--out")
            .arg(&out)
            .output()
            .unwrap()
    };
    let failed = run(&["-e", "inject=syncfs:error=EIO"]);
    let said = String::from_utf8_lossy(&failed.stderr);
    assert!(said.contains("Input/output error"), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    assert_eq!(failed.status.code(), Some(1), "{said}");
    assert!(!is_complete(&out));
    let again = run(&[]);
    let said = String::from_utf8_lossy(&again.stderr);
    assert_eq!(again.status.code(), Some(0), "{said}");
    assert!(verifies(place.path(), &out));
}
