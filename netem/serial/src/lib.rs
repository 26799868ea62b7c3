//! Runs tests one after another, in their own main: tests that depend on wall-clock time must not run
//! in parallel, and tests that the machine does not support are reported as skipped.
//!
//! A test that fails while the machine's host takes much of its time is made again, twice at most: it passes
//! once, or fails. [`tries`] is for tests that see themselves that the machine spoilt a run.
//!
//! Arguments and output are those of the usual harness, from `libtest-mimic`. Each test runs in the
//! calling thread, which is the only one of the process unless a test starts another.
#![allow(clippy::print_stdout)]

mod busy;

use std::panic::{RefUnwindSafe, catch_unwind, resume_unwind};
use std::process::ExitCode;
use std::time::Instant;

pub use busy::{Stolen, Tries, tries};
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
pub fn test<T: Outcome + 'static>(
    name: &'static str,
    test: impl Fn() -> T + Send + RefUnwindSafe + 'static,
) -> Trial {
    Trial::ignorable_test(name, move || {
        let begun = Instant::now();
        let outcome = outcome(name, &test);
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

/// What a test comes to: at its first try, unless it fails while the host takes much of the machine's time.
fn outcome<T>(name: &str, test: &(impl Fn() -> T + RefUnwindSafe)) -> std::thread::Result<T> {
    const TRIES: usize = 3;
    /// Half of what excuses a run: a test that is made again has to pass all the same.
    const SPOILT: f64 = 0.05;
    for _ in 1..TRIES {
        let stolen = Stolen::since_now();
        let outcome = catch_unwind(test);
        let share = stolen.share();
        if outcome.is_ok() || share <= SPOILT {
            return outcome;
        }
        println!(
            "  once more, since the host took {:.0} % of the time: {name}",
            100.0 * share
        );
    }
    catch_unwind(test)
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
