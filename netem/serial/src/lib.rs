//! Tests one after another, in a main of their own: what takes wall-clock time must not run beside
//! itself, and tests that the machine does not allow are reported as skipped.
//!
//! Arguments and output are the usual harness's, as `libtest-mimic` has them. Each test runs in the
//! calling thread, which stays the only one of the process as long as no test starts another.
#![allow(clippy::print_stdout)]

use std::panic::{UnwindSafe, catch_unwind, resume_unwind};
use std::process::ExitCode;
use std::time::Instant;

pub use libtest_mimic::Trial;
use libtest_mimic::{Arguments, Completion};

/// What a test gives back: nothing, or that this machine cannot make it.
pub trait Outcome {
    /// Why the test could not be made here, if so.
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

/// The tests at these paths, which are their names too.
#[macro_export]
macro_rules! tests {
    ($($test:path),* $(,)?) => {
        vec![$($crate::test(stringify!($test), $test)),*]
    };
}

/// A test. One that panics has failed.
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
                // What the test has printed may stand between its name and its result.
                println!("\ntest {name} ... FAILED");
                resume_unwind(panic)
            }
        }
    })
}

/// Runs the tests that the command line asks for. What `lack` gives is why this machine can make
/// none of them; it is asked only where one is to be made.
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
