//! Keeps the processors from halting: a halted one takes tens of microseconds to wake, several times that on a
//! virtual machine.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};

use clock::now::now_ns;
use clock::pacer::Pacer;
use clock::scheduling::Granted;

use crate::unable::Unable;

/// The kernel's file for it: while a process holds it open, an idle processor does not fall asleep more deeply
/// than it can wake within the time written into it.
const LATENCY: &str = "/dev/cpu_dma_latency";

/// No processor of this machine halts while this exists. They use energy, and a rented machine may count that
/// as work and take the processors away in turn.
#[derive(Debug)]
pub struct Awake(#[expect(dead_code, reason = "held open, never read")] File);

impl Awake {
    /// Keeps all processors awake from now on.
    ///
    /// # Errors
    /// The system's if this process may not: it needs root on the machine itself, and in a container the device.
    pub fn keep() -> io::Result<Self> {
        let mut latency = OpenOptions::new().write(true).open(LATENCY)?;
        // In us, and in the machine's own byte order.
        latency.write_all(&0_i32.to_ne_bytes())?;
        Ok(Self(latency))
    }
}

/// What sleeping threads saw of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    /// How late a wake was, us: the median, and the longest.
    late_us: [f64; 2],
    /// Share of all processors' time that the host took.
    stolen: f64,
}

/// Measures whether it pays here, for six tenths of a second, and says so.
///
/// # Errors
/// Why the processors cannot be kept awake.
pub(crate) fn trial() -> Result<String, Unable> {
    let halting = nap()?;
    let awake = Awake::keep().map_err(|problem| Unable::new(format!("{LATENCY}: {problem}")))?;
    let kept = nap()?;
    drop(awake);
    Ok(told(halting, kept))
}

/// Sleeps for three tenths of a second, a millisecond at a time, as a plant does.
fn nap() -> Result<Seen, Unable> {
    const NAPS: u64 = 300;
    const NAP_NS: u64 = 1_000_000;
    let slept = std::thread::spawn(|| {
        clock::scheduling::ask(Some(1));
        // It is to be late by as much as the machine makes it.
        let mut pacer = Pacer::new(&Granted::ordinary());
        let (start_ns, stolen_ns) = (now_ns(), process::stolen_ns());
        let late_us = |nap: u64| {
            let due_ns = start_ns + nap * NAP_NS;
            pacer.sleep_until(due_ns);
            (now_ns() - due_ns) as f64 * 1e-3
        };
        let mut late_us: Vec<f64> = (1..=NAPS).map(late_us).collect();
        late_us.sort_by(f64::total_cmp);
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let time_ns = (now_ns() - start_ns) as f64 * cores as f64;
        Seen {
            late_us: [late_us[late_us.len() / 2], late_us[late_us.len() - 1]],
            stolen: process::stolen_ns().saturating_sub(stolen_ns) as f64 / time_ns,
        }
    });
    slept.join().map_err(|_| Unable::new("the trial failed"))
}

/// What the two tell of each other. The host pays for it where it takes more than before: a fiftieth of the time,
/// or a pause of some milliseconds that was not there.
fn told(halting: Seen, kept: Seen) -> String {
    const STOLEN: f64 = 0.02;
    const PAUSE_US: f64 = 3_000.0;
    let [(before, longest_before), (after, longest)] =
        [halting, kept].map(|seen| (seen.late_us[0], seen.late_us[1]));
    let verdict = if kept.stolen - halting.stolen >= STOLEN || longest - longest_before >= PAUSE_US
    {
        "it costs pauses here: leave it off"
    } else if after <= before / 2.0 {
        "it pays here"
    } else {
        "it changes little here"
    };
    format!(
        "a wake is {before:.0} us late, {after:.0} us with --awake (at most {longest_before:.0} and {longest:.0}); \
         the host takes {:.1} % and {:.1} %: {verdict}",
        100.0 * halting.stolen,
        100.0 * kept.stolen
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_pays_where_wakes_are_earlier_and_the_host_takes_no_more() {
        let seen = |median, longest, stolen| Seen {
            late_us: [median, longest],
            stolen,
        };
        let halting = seen(43.0, 250.0, 0.0);
        assert_eq!(
            told(halting, seen(4.0, 90.0, 0.01)),
            "a wake is 43 us late, 4 us with --awake (at most 250 and 90); the host takes 0.0 % and 1.0 %: \
             it pays here"
        );
        for (kept, verdict) in [
            (seen(30.0, 90.0, 0.0), "it changes little here"),
            (seen(4.0, 90.0, 0.05), "leave it off"),
            (seen(4.0, 80_000.0, 0.0), "leave it off"),
        ] {
            let said = told(halting, kept);
            assert!(said.ends_with(verdict), "{said}");
        }
    }

    #[test]
    fn the_trial_says_what_it_found_or_why_it_cannot() {
        match trial() {
            Ok(said) => assert!(said.contains("with --awake"), "{said}"),
            Err(why) => assert!(why.to_string().contains(LATENCY), "{why}"),
        }
    }
}
