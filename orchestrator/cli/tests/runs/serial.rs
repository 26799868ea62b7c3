//! Tests one after another, in a main of their own: what takes wall-clock time must not run beside
//! itself, and what a machine does not let us test is said and not swallowed.
//!
//! Arguments are as the usual harness has them: part of a test's name, `--list`.

use std::panic::catch_unwind;
use std::process::ExitCode;
use std::time::Instant;

/// A test gives back why it could not be made on this machine, if so.
pub(crate) type Test = (&'static str, fn() -> Result<(), String>);

/// Runs them, or says why this machine can run none: what `lack` gives.
pub(crate) fn run(tests: &[Test], lack: impl FnOnce() -> Option<String>) -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let has = |flag: &str| arguments.iter().any(|argument| argument == flag);
    if has("--ignored") {
        // None is.
        return ExitCode::SUCCESS;
    }
    if has("--list") {
        tests.iter().for_each(|(name, _)| println!("{name}: test"));
        return ExitCode::SUCCESS;
    }
    if let Some(lack) = lack() {
        println!("SKIPPED all of these: {lack}");
        return ExitCode::SUCCESS;
    }
    let filters: Vec<&String> = arguments
        .iter()
        .filter(|argument| !argument.starts_with('-'))
        .collect();
    let mut failed = 0;
    for (name, test) in tests {
        if !filters.is_empty() && !filters.iter().any(|filter| name.contains(filter.as_str())) {
            continue;
        }
        println!("test {name} ...");
        let started = Instant::now();
        let result = match catch_unwind(*test) {
            Ok(Ok(())) => "ok".to_owned(),
            Ok(Err(lack)) => format!("SKIPPED: {lack}"),
            Err(_) => {
                failed += 1;
                "FAILED".to_owned()
            }
        };
        println!(
            "test {name} ... {result} ({:.1} s)",
            started.elapsed().as_secs_f64()
        );
    }
    if failed == 0 {
        ExitCode::SUCCESS
    } else {
        println!("{failed} failed");
        ExitCode::FAILURE
    }
}
