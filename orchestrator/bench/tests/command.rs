//! The command line: what can be typed, and what is said where nothing can be measured. No network, no waiting.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const BENCH: &str = env!("CARGO_BIN_EXE_webloop-bench");

fn bench(program: &Path, words: &[&str], folder: &Path) -> Output {
    Command::new(program)
        .args(words)
        .current_dir(folder)
        .env_remove("RUST_LOG")
        .output()
        .unwrap()
}

/// Holds what is printed on standard error, and that the exit code is that of a wrong command line.
fn is_wrong_usage(output: &Output, said: &str) {
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains(said), "{error}");
    assert_eq!(output.status.code(), Some(2), "{error}");
}

#[test]
fn the_help_names_each_table_and_option_and_not_what_it_starts_itself() {
    let folder = tempfile::tempdir().unwrap();
    let output = bench(Path::new(BENCH), &["--help"], folder.path());
    assert_eq!(output.status.code(), Some(0));
    let help = String::from_utf8(output.stdout).unwrap();
    assert!(
        help.contains("Usage: webloop-bench [OPTIONS] [TABLE]...\n"),
        "{help}"
    );
    for word in [
        "step",
        "rate",
        "tick",
        "delay",
        "stream",
        "virtual",
        "rows",
        "cell",
        "memory",
        "report",
        "browser",
        "compose",
        "--times <N>",
        "--measure-ms <MS>",
        "--out <DIR>",
        "--webloop <PATH>",
        "[default: 5]",
        "[default: 2000]",
    ] {
        assert!(help.contains(word), "{word}: {help}");
    }
    assert!(!help.contains("Commands:"), "{help}");
}

#[test]
fn without_webloop_beside_it_the_error_says_how_to_build_it_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let alone = folder.path().join("webloop-bench");
    fs::copy(BENCH, &alone).unwrap();
    let output = bench(&alone, &["step", "--out", "figures"], folder.path());
    let beside = folder.path().join("webloop");
    let said = format!(
        "webloop-bench: there is no webloop at {}; build it by `cargo build",
        beside.display()
    );
    is_wrong_usage(&output, &said);
    let words = ["step", "--webloop", "elsewhere", "--out", "figures"];
    let output = bench(&alone, &words, folder.path());
    let elsewhere = folder.path().join("elsewhere");
    let said = format!("there is no webloop at {}; ", elsewhere.display());
    is_wrong_usage(&output, &said);
    assert!(!folder.path().join("figures").exists());
}

#[test]
fn figures_of_an_earlier_run_are_not_mixed_with_others() {
    let folder = tempfile::tempdir().unwrap();
    let webloop = folder.path().join("webloop");
    fs::write(webloop, "").unwrap();
    fs::write(folder.path().join("bench.csv"), "").unwrap();
    let words = ["step", "--webloop", "webloop", "--out", "."];
    let output = bench(Path::new(BENCH), &words, folder.path());
    is_wrong_usage(
        &output,
        "has figures of an earlier run; give --out another folder",
    );
}

#[test]
fn an_unknown_table_or_end_is_named_with_those_there_are() {
    let folder = tempfile::tempdir().unwrap();
    let output = bench(Path::new(BENCH), &["steps"], folder.path());
    is_wrong_usage(&output, "memory, report, browser or compose");
    for words in [&["end", "nothing"][..], &["end", "ping", "here", "1", "1"]] {
        let output = bench(Path::new(BENCH), words, folder.path());
        let said = format!("there is no end `{}`; choose echo, ", words[1..].join(" "));
        is_wrong_usage(&output, &said);
    }
}
