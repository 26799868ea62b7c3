//! The tests that need `sch_netem`, on a machine whose own kernel has none: this same program once
//! more, in a kernel that has it. `netem/kernel/run` boots one; `.ci/run` prepares it.

use std::process::{Command, Output};

use crate::attempt::TOO_BUSY;
use crate::tests;

/// Part of the name of each test that needs netem, and of no other: the guest is too slow to play
/// a link in user space.
const NEEDS_NETEM: &str = "tc_";

/// Longer than they take on the guest's one slow core: beyond it the guest hangs.
const TIMEOUT_S: &str = "900";

/// Set in the guest, so that it boots no guest of its own.
const GUEST: &str = "WEBLOOP_NETEM_GUEST";

pub(crate) fn what_needs_netem_holds_in_a_kernel_that_has_it() {
    if std::env::var_os(GUEST).is_some() {
        return println!("  SKIPPED: this is that kernel");
    }
    if run(&["--check"]).status.success() {
        return println!("  SKIPPED: this machine's own kernel has netem");
    }
    if !tests().iter().any(|test| test.name().contains(NEEDS_NETEM)) {
        return println!("  SKIPPED: no test has `{NEEDS_NETEM}` in its name");
    }
    // Who types `cargo test` does not ask for packages to be installed.
    let ready = run(&["--no-install", "--", "true"]);
    if !ready.status.success() {
        return println!("  SKIPPED: {}", said(&ready));
    }
    let program = std::env::current_exe().unwrap();
    let guest = run(&[
        "--no-install",
        "--timeout",
        TIMEOUT_S,
        "--",
        "env",
        &format!("{GUEST}=1"),
        program.to_str().unwrap(),
        NEEDS_NETEM,
    ]);
    let said = said(&guest);
    for line in said.lines() {
        println!("  | {line}");
    }
    assert!(guest.status.success(), "{}", guest.status);
    assert!(
        said.contains("test result: ok. ") && !said.contains(" 0 passed"),
        "no test has `{NEEDS_NETEM}` in its name"
    );
    // An emulated processor may be too slow to show what a link does; that its kernel lacks nothing holds.
    let skipped = said
        .lines()
        .filter(|line| line.contains("SKIPPED") && !line.contains(TOO_BUSY));
    let skipped: Vec<_> = skipped.collect();
    assert!(skipped.is_empty(), "this kernel has netem: {skipped:?}");
}

fn run(arguments: &[&str]) -> Output {
    Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../kernel/run"))
        .args(arguments)
        .output()
        .unwrap()
}

fn said(output: &Output) -> String {
    let said = [&output.stdout[..], &output.stderr[..]].concat();
    String::from_utf8_lossy(&said).trim().to_owned()
}
