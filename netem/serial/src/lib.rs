//! Runs tests one after another, in their own main: tests that depend on wall-clock time must not run
//! in parallel, and tests that the machine does not support are reported as skipped.
//!
//! A test that fails while the machine stands still for a moment is made again, twice at most. If its host takes
//! much of the time each time, nothing is known: it is reported as skipped. So is a test that sees itself that the
//! machine spoilt each of its [`tries`]. Ten that found no quiet moment, one after another, fail.
//!
//! One that fails while nothing is seen of the machine is made twice more, and has to pass both times: what a real
//! network and a real scheduler do is not all seen from one thread. It is told as `FLAKY`, and a program bears two.
//!
//! [`timed`] does the same for a test of the usual harness.
//!
//! Arguments and output are those of the usual harness, from `libtest-mimic`. Each test runs in the
//! calling thread; beside it there are those that it starts, and one that watches the machine.
#![allow(clippy::print_stdout)]

mod busy;

use std::any::Any;
use std::io::Write as _;
use std::panic::{RefUnwindSafe, catch_unwind, resume_unwind};
use std::process::ExitCode;
use std::time::Instant;

use busy::{BUSY, Flaky, IN_A_ROW, Quiet, Stood, Vigil};
pub use busy::{Stolen, Tries, tries};
pub use libtest_mimic::Trial;
use libtest_mimic::{Arguments, Completion};

/// The result of a test: nothing, or the reason why it cannot run on this machine.
pub trait Termination {
    /// Why the test could not run here, if so.
    fn lack(self) -> Option<String>;
}

impl Termination for () {
    fn lack(self) -> Option<String> {
        None
    }
}

impl Termination for Result<(), String> {
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
pub fn test<T: Termination + 'static>(
    name: &'static str,
    test: impl Fn() -> T + Send + RefUnwindSafe + 'static,
) -> Trial {
    Trial::ignorable_test(name, move || {
        let begun = Instant::now();
        let tried = tried(name, &test);
        print!("({:.1} s) ", begun.elapsed().as_secs_f64());
        let lack = match tried {
            Tried::Panicked(panic) => fail(name, panic),
            Tried::Spoilt(panic) if Quiet::is_hopeless() => fail(name, panic),
            Tried::Spoilt(_) => format!("the machine was {BUSY} for this test each time"),
            Tried::Came(outcome) => match outcome.lack() {
                None => {
                    Quiet::found();
                    return Ok(Completion::Completed);
                }
                Some(lack) if lack.contains(BUSY) && Quiet::is_hopeless() => {
                    fail(name, Box::new(format!("{IN_A_ROW} tests in a row: {lack}")))
                }
                Some(lack) => lack,
            },
        };
        Ok(Completion::ignored_with(format!("SKIPPED: {lack}")))
    })
}

/// Makes a test of the usual harness that takes wall-clock time, as [`test()`] does, though beside others of its
/// program. One that the machine spoilt each time says so on standard error, and passes: the usual harness knows no
/// test that cannot be made here.
///
/// # Panics
///
/// If the test fails.
pub fn timed(name: &'static str, test: impl Fn() + RefUnwindSafe) {
    match tried(name, &test) {
        Tried::Came(()) => Quiet::found(),
        Tried::Panicked(panic) => resume_unwind(panic),
        Tried::Spoilt(panic) if Quiet::is_hopeless() => resume_unwind(panic),
        // Written past the harness, which keeps what a test prints that passes.
        Tried::Spoilt(_) => {
            let told = format!("SKIPPED {name}: the machine was {BUSY} for this test each time\n");
            let _ = std::io::stderr().write_all(told.as_bytes());
        }
    }
}

fn fail(name: &str, panic: Box<dyn Any + Send>) -> ! {
    // Output of the test may stand between its name and its result.
    println!("\ntest {name} ... FAILED");
    resume_unwind(panic)
}

/// How a test ended.
enum Tried<T> {
    /// It came to its end.
    Came(T),
    /// It failed, and the machine had the time that it needs.
    Panicked(Box<dyn Any + Send>),
    /// It failed each time, and each time the machine stood still for much of the time.
    Spoilt(Box<dyn Any + Send>),
}

/// How often a test is made at most.
const TRIES: usize = 3;

fn tried<T>(name: &str, test: &(impl Fn() -> T + RefUnwindSafe)) -> Tried<T> {
    match once(name, test) {
        Ok(outcome) => Tried::Came(outcome),
        Err(failed) if failed.seen.is_felt() => until_quiet(name, test, failed),
        Err(failed) if Flaky::is_borne() => twice_more(name, test, failed),
        Err(failed) => Tried::Panicked(failed.panic),
    }
}

/// A test that failed, and what the machine did meanwhile.
struct Failed {
    panic: Box<dyn Any + Send>,
    seen: Stood,
}

fn once<T>(name: &str, test: &(impl Fn() -> T + RefUnwindSafe)) -> Result<T, Failed> {
    let watch = Vigil::start();
    let ended = catch_unwind(test);
    let seen = watch.end();
    ended.map_err(|panic| {
        if seen.is_felt() {
            println!("  failed, and {seen}: {name}");
        }
        Failed { panic, seen }
    })
}

/// Makes a test again that a standstill may have spoilt.
fn until_quiet<T>(
    name: &str,
    test: &(impl Fn() -> T + RefUnwindSafe),
    mut failed: Failed,
) -> Tried<T> {
    let mut is_known = !failed.seen.is_much();
    for _ in 1..TRIES {
        failed = match once(name, test) {
            Ok(outcome) => return Tried::Came(outcome),
            Err(failed) => failed,
        };
        if !failed.seen.is_felt() {
            return Tried::Panicked(failed.panic);
        }
        is_known |= !failed.seen.is_much();
    }
    if is_known {
        Tried::Panicked(failed.panic)
    } else {
        Tried::Spoilt(failed.panic)
    }
}

/// Makes a test again that failed, nobody knows why: it has to pass each time from now on.
fn twice_more<T>(name: &str, test: &(impl Fn() -> T + RefUnwindSafe), failed: Failed) -> Tried<T> {
    let again = once(name, test).and_then(|_| once(name, test));
    match again {
        Ok(outcome) => {
            let told = format!("  FLAKY: {name} failed once, and passed both times after it\n");
            let _ = std::io::stderr().write_all(told.as_bytes());
            Tried::Came(outcome)
        }
        // The first failure is the one that nothing excuses.
        Err(_) => Tried::Panicked(failed.panic),
    }
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
