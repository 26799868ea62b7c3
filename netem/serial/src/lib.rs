//! Runs tests one after another, in their own main: tests that depend on wall-clock time must not run
//! in parallel, and tests that the machine does not support are reported as skipped.
//!
//! Arguments and output are those of the usual harness, from `libtest-mimic`. Each test runs in the
//! calling thread, which is the only one of the process unless a test starts another.
#![allow(clippy::print_stdout)]

use std::panic::{UnwindSafe, catch_unwind, resume_unwind};
use std::process::ExitCode;
use std::time::Instant;

pub use libtest_mimic::Trial;
use libtest_mimic::{Arguments, Completion};

/// The result of a test: nothing, or the reason why it cannot run on this machine.
pub trait Outcome {
    /// Why the test could not run here, if so.
    fn lack(self) -> Option<String>;
}

impl Outcome for () {
    fn lack(self) -> Option<String> {
        None
    }
}

impl Outcome for Result<(), String> {
    fn lack(self) -> Option<String> {
        self.err()
    }
}

/// The tests at these paths, which also serve as their names.
#[macro_export]
macro_rules! tests {
    ($($test:path),* $(,)?) => {
        vec![$($crate::test(stringify!($test), $test)),*]
    };
}

/// A test; it fails if it panics.
pub fn test<T: Outcome>(
    name: &'static str,
    test: impl FnOnce() -> T + Send + UnwindSafe + 'static,
) -> Trial {
    Trial::ignorable_test(name, move || {
        let begun = Instant::now();
        let outcome = catch_unwind(test);
        print!("({:.1} s) ", begun.elapsed().as_secs_f64());
        match outcome.map(Outcome::lack) {
            Ok(None) => Ok(Completion::Completed),
            Ok(Some(lack)) => Ok(Completion::ignored_with(format!("SKIPPED: {lack}"))),
            Err(panic) => {
                // Output of the test may stand between its name and its result.
                println!("\ntest {name} ... FAILED");
                resume_unwind(panic)
            }
        }
    })
}

/// Runs the tests that the command line selects. `lack` returns why this machine can run none of
/// them; it is called only if a test is to run.
pub fn run(mut tests: Vec<Trial>, lack: impl FnOnce() -> Option<String>) -> ExitCode {
    let mut arguments = Arguments::from_args();
    arguments.test_threads = Some(1);
    let is_none_asked =
        arguments.list || arguments.ignored && !tests.iter().any(Trial::has_ignored_flag);
    if !is_none_asked && let Some(lack) = lack() {
        println!("SKIPPED all of these: {lack}");
        (arguments.ignored, arguments.include_ignored) = (false, false);
        let ignored = tests.into_iter().map(|test| test.with_ignored_flag(true));
        tests = ignored.collect();
    }
    libtest_mimic::run(&arguments, tests).exit_code()
}
