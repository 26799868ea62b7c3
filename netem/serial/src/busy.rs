//! What a busy machine does to a test that takes wall-clock time, and how long a test program bears it.
#![allow(clippy::print_stdout)]

use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, mpsc};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// How often a thing is tried that a busy machine can spoil.
const TRIES: usize = 5;

/// What all further tries of a program may take together. On a machine that spoils every one, tests come to
/// their end all the same.
const PATIENCE: Duration = Duration::from_secs(180);

/// How much of it is gone.
static SPENT: Mutex<Duration> = Mutex::new(Duration::ZERO);

/// What the words of a test contain that found no quiet moment.
pub(crate) const BUSY: &str = "too busy";

/// So many tests in a row that found no quiet moment are a failure: a suite that shows nothing must not pass.
pub(crate) const IN_A_ROW: usize = 10;

/// Tests in a row that found no quiet moment.
static LOUD: AtomicUsize = AtomicUsize::new(0);

/// Whether the tests of this program find a quiet moment.
pub(crate) enum Quiet {}

impl Quiet {
    /// A test found one.
    pub(crate) fn found() {
        LOUD.store(0, Ordering::Relaxed);
    }

    /// One more found none; whether there were too many in a row.
    pub(crate) fn is_hopeless() -> bool {
        LOUD.fetch_add(1, Ordering::Relaxed) + 1 >= IN_A_ROW
    }
}

/// Tests that failed and were made again, though nothing was seen of the machine.
pub(crate) enum Flaky {}

impl Flaky {
    /// Whether one more is borne: two of a program are, since a third is no chance.
    pub(crate) fn is_borne() -> bool {
        static SEEN: AtomicUsize = AtomicUsize::new(0);
        SEEN.fetch_add(1, Ordering::Relaxed) < 2
    }
}

/// The tries of one thing; see [`tries`].
#[derive(Debug)]
pub struct Tries {
    made: usize,
    since: Instant,
}

/// Numbers of tries, from 0 on, of what a busy machine can spoil: five, or fewer once the further tries of
/// this program have taken three minutes. There is always a first.
#[must_use]
pub fn tries() -> Tries {
    Tries {
        made: 0,
        since: Instant::now(),
    }
}

impl Iterator for Tries {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        let mut spent = SPENT.lock().ok()?;
        // The first is what the test takes anyway.
        if self.made > 1 {
            *spent += self.since.elapsed();
        }
        if self.made == TRIES || self.made > 0 && *spent > PATIENCE {
            return None;
        }
        self.since = Instant::now();
        self.made += 1;
        Some(self.made - 1)
    }
}

/// The processor time that this machine's host takes from it, from an instant on.
#[derive(Debug)]
pub struct Stolen {
    since: Instant,
    before_s: f64,
}

impl Stolen {
    /// From now on.
    #[must_use]
    pub fn since_now() -> Stolen {
        Stolen {
            since: Instant::now(),
            before_s: stolen_s(),
        }
    }

    /// The share of all processors' time; 0 if unknown.
    #[must_use]
    pub fn share(&self) -> f64 {
        let processors = std::thread::available_parallelism().map_or(1, usize::from) as f64;
        (stolen_s() - self.before_s) / self.since.elapsed().as_secs_f64() / processors
    }

    /// Whether it is so much that a run may fail in any of its parts; if so, that is printed.
    #[must_use]
    pub fn is_much(&self) -> bool {
        const MUCH: f64 = 0.1;
        let share = self.share();
        if share > MUCH {
            println!(
                "  too busy: the host took {:.0} % of the time",
                100.0 * share
            );
        }
        share > MUCH
    }
}

/// What a thread that sleeps and wakes sees of a machine that stands still: a host may stop all of it, and then its
/// kernel counts nothing as [`Stolen`].
#[derive(Debug)]
pub(crate) struct Vigil {
    stolen: Stolen,
    stop: mpsc::Sender<()>,
    thread: JoinHandle<Standstill>,
}

/// How long a machine stood still.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Standstill {
    /// At once, at most.
    longest: Duration,
    /// Altogether.
    total: Duration,
}

/// What a machine did while a test was made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stood {
    /// The share of the time in which the test had no processor.
    pub(crate) share: f64,
    longest: Duration,
}

impl Vigil {
    /// From now on.
    pub(crate) fn start() -> Vigil {
        let (stop, stopped) = mpsc::channel();
        Vigil {
            stolen: Stolen::since_now(),
            stop,
            thread: thread::spawn(move || Standstill::until(&stopped)),
        }
    }

    /// Until now.
    pub(crate) fn end(self) -> Stood {
        drop(self.stop);
        let took = self.stolen.since.elapsed().as_secs_f64();
        let stood = self.thread.join().unwrap_or_default();
        Stood {
            share: self.stolen.share().max(stood.total.as_secs_f64() / took),
            longest: stood.longest,
        }
    }
}

impl Standstill {
    /// Sleeps, and counts how late it wakes, until the other end is dropped.
    fn until(stopped: &mpsc::Receiver<()>) -> Standstill {
        const SLEEP: Duration = Duration::from_millis(5);
        /// A scheduler with more threads than processors makes one wait as long as this.
        const USUAL: Duration = Duration::from_millis(10);
        let mut stood = Standstill::default();
        loop {
            let since = Instant::now();
            let stops = stopped.recv_timeout(SLEEP) != Err(mpsc::RecvTimeoutError::Timeout);
            let late = since.elapsed().saturating_sub(SLEEP);
            if late > USUAL {
                stood.longest = stood.longest.max(late);
                stood.total += late;
            }
            if stops {
                return stood;
            }
        }
    }
}

impl Stood {
    /// Whether it can have spoilt a test in any of its moments: that is made again.
    pub(crate) fn is_felt(self) -> bool {
        const FELT: Duration = Duration::from_millis(20);
        self.is_much() || self.longest > FELT
    }

    /// Whether it is so much that nothing is known of a test that failed: half of what excuses a run, since a test
    /// that is made again has to pass all the same.
    pub(crate) fn is_much(self) -> bool {
        const SPOILT: f64 = 0.05;
        self.share > SPOILT
    }
}

impl std::fmt::Display for Stood {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Stood { share, longest } = self;
        let percent = 100.0 * share;
        let ms = longest.as_millis();
        write!(
            out,
            "the machine stood still for {percent:.0} % of the time, at most {ms} ms at once"
        )
    }
}

/// Since the machine started; 0 if unknown.
fn stolen_s() -> f64 {
    /// The kernel counts in hundredths of a second, whatever its own tick.
    const TICK_S: f64 = 0.01;
    /// After the word `cpu`: user, nice, system, idle, disk, interrupts, soft interrupts.
    const AT: usize = 8;
    let text = fs::read_to_string("/proc/stat").unwrap_or_default();
    let line = text.lines().next().unwrap_or_default();
    let ticks = line
        .split_whitespace()
        .nth(AT)
        .and_then(|field| field.parse::<f64>().ok());
    ticks.unwrap_or_default() * TICK_S
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standstill_is_what_lies_between_two_wakings() {
        let (stop, stopped) = mpsc::channel::<()>();
        drop(stop);
        assert!(Standstill::until(&stopped).total < Duration::from_secs(1));
        let seen = |share, ms| Stood {
            share,
            longest: Duration::from_millis(ms),
        };
        assert!(!seen(0.0, 15).is_felt() && seen(0.0, 40).is_felt() && seen(0.1, 0).is_felt());
        assert!(!seen(0.01, 40).is_much() && seen(0.1, 0).is_much());
    }

    #[test]
    fn nine_in_a_row_are_told_and_a_tenth_fails() {
        for _ in 0..2 {
            assert!((1..IN_A_ROW).all(|_| !Quiet::is_hopeless()));
            Quiet::found();
        }
        assert!((1..IN_A_ROW).all(|_| !Quiet::is_hopeless()));
        assert!(Quiet::is_hopeless());
    }

    #[test]
    fn two_flaky_tests_are_borne_and_no_third() {
        let borne = [(); 4].map(|()| Flaky::is_borne());
        assert_eq!(borne, [true, true, false, false]);
    }
}
