//! What a busy machine does to a test that takes wall-clock time, and how long a test program bears it.
#![allow(clippy::print_stdout)]

use std::fs;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// How often a thing is tried that a busy machine can spoil.
const TRIES: usize = 5;

/// What all further tries of a program may take together. On a machine that spoils every one, tests come to
/// their end all the same.
const PATIENCE: Duration = Duration::from_secs(180);

/// How much of it is gone.
static SPENT: Mutex<Duration> = Mutex::new(Duration::ZERO);

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
