//! Judges what has no rows of its own to show that it was held up: the player, a process that was
//! stopped or starved, a processor that stood still.

use link::certificate::Pause;
use plan::Disturbance;
use plan::evidence::{Pulse, Watched};

use crate::limit::{OTHERS_SHARE, Stillness, WAITED_SHARE};
use crate::met::Met;
use crate::quantile::thousandths;

/// Makes a disturbance; its time counts from `from_ns`.
pub(crate) fn describe(
    what: &str,
    t_ns: u64,
    from_ns: u64,
    longest_ms: f64,
    words: String,
) -> Disturbance {
    let at_s = (t_ns as f64 - from_ns as f64) * 1e-9;
    Disturbance {
        what: what.to_owned(),
        at_s: thousandths(at_s),
        longest_ms: thousandths(longest_ms),
        words,
    }
}

/// Judges whether the longest gap between `from_ns` and `to_ns` is too long, or all gaps together are.
fn still(
    what: &str,
    gaps: &[Pause],
    limit: Stillness,
    processors: usize,
    from_ns: u64,
    to_ns: u64,
    hint: &str,
) -> Option<Disturbance> {
    let inside = || {
        gaps.iter()
            .filter(|gap| gap.t_ns > from_ns && gap.t_ns.saturating_sub(gap.ns) < to_ns)
    };
    let longest = inside().max_by_key(|gap| gap.ns)?;
    let longest_ms = longest.ns as f64 * 1e-6;
    let all_ms = inside().map(|gap| gap.ns as f64 * 1e-6).sum::<f64>();
    let time_ms = to_ns.saturating_sub(from_ns) as f64 * 1e-6 * processors.max(1) as f64;
    let share = all_ms / time_ms.max(1.0);
    if longest_ms < limit.longest_ms && share <= limit.share {
        return None;
    }
    Some(describe(
        what,
        longest.t_ns,
        from_ns,
        longest_ms,
        format!(
            "the {what} was held up {} times, for {longest_ms:.0} ms at the longest (limit {:.0} \
             ms) and {:.1} % of the time (limit {:.0} %){hint}",
            inside().count(),
            limit.longest_ms,
            100.0 * share,
            100.0 * limit.share
        ),
    ))
}

/// Judges whether the player was held up.
pub(crate) fn player(
    pauses: &[Pause],
    met: &Met,
    limit: Stillness,
    from_ns: u64,
    to_ns: u64,
) -> Option<Disturbance> {
    still("player", &met.those(pauses), limit, 1, from_ns, to_ns, "")
}

/// Judges whether a processor stood still, or was taken away from all parts of the run.
pub(crate) fn pulse(pulse: &Pulse, met: &Met, from_ns: u64, to_ns: u64) -> Option<Disturbance> {
    let hint = if pulse.stolen_ms >= 1.0 {
        format!("; the host took {:.0} ms of them", pulse.stolen_ms)
    } else {
        String::new()
    };
    still(
        "machine",
        &met.those(&pulse.gaps),
        Stillness::of(pulse.real_time),
        pulse.processors,
        from_ns,
        to_ns,
        &hint,
    )
}

/// What the host took of this machine's processors, if it was so much that it explains what nothing else does: it
/// may take them for less than a beat at a time.
#[must_use]
pub fn taken(pulse: &Pulse, from_ns: u64, to_ns: u64) -> Option<Disturbance> {
    let limit = Stillness::REAL_TIME.share;
    let time_ms = to_ns.saturating_sub(from_ns) as f64 * 1e-6 * pulse.processors.max(1) as f64;
    let share = pulse.stolen_ms / time_ms.max(1.0);
    (share > limit).then(|| {
        let words = format!(
            "the host took {:.0} ms of this machine's processors, {:.1} % of the time (limit {:.0} %)",
            pulse.stolen_ms,
            100.0 * share,
            100.0 * limit
        );
        describe("machine", from_ns, from_ns, pulse.stolen_ms, words)
    })
}

/// Judges whether the process called `what` was stopped, or starved by other programs.
#[must_use]
pub fn watched(watched: &Watched, what: &str, from_ns: u64, to_ns: u64) -> Option<Disturbance> {
    let time_ms = to_ns.saturating_sub(from_ns) as f64 * 1e-6;
    if watched.stopped > 0 {
        let share = watched.stopped as f64 / watched.looks.max(1) as f64;
        return Some(describe(
            what,
            watched.stopped_at_ns,
            from_ns,
            share * time_ms,
            format!(
                "the {what} was stopped by a signal or a debugger in {} of {} looks",
                watched.stopped, watched.looks
            ),
        ));
    }
    let share = watched.waited_ms / time_ms.max(1.0);
    (share > WAITED_SHARE && watched.others > OTHERS_SHARE).then(|| {
        describe(
            what,
            from_ns,
            from_ns,
            watched.waited_ms,
            format!(
                "the {what} was starved: its threads waited {:.0} ms for a processor, {:.0} % of \
                 the time (limit {:.0} %), and other programs had {:.0} % of all processors (limit \
                 {:.0} %)",
                watched.waited_ms,
                100.0 * share,
                100.0 * WAITED_SHARE,
                100.0 * watched.others,
                100.0 * OTHERS_SHARE
            ),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;
    const S: u64 = 1_000 * MS;

    fn gap(t_ms: u64, ms: u64) -> Pause {
        Pause {
            t_ns: t_ms * MS,
            ns: ms * MS,
        }
    }

    #[test]
    fn one_long_pause_and_many_short_ones_count_and_those_outside_the_run_do_not() {
        let player = |gaps: &[Pause]| player(gaps, &Met::Any, Stillness::REAL_TIME, S, 3 * S);
        assert_eq!(player(&[gap(900, 300)]), None);
        assert_eq!(player(&[gap(3400, 300)]), None);
        assert_eq!(player(&[gap(1500, 6), gap(2000, 6)]), None);
        let once = player(&[gap(1500, 300)]).expect("300 ms");
        assert_eq!((once.at_s, once.longest_ms), (0.5, 300.0));
        let often: Vec<Pause> = (0..10).map(|n| gap(1000 + 100 * n, 6)).collect();
        assert!(
            player(&often)
                .expect("3 % of the time")
                .words
                .contains("9 times")
        );
    }

    #[test]
    fn what_the_host_takes_in_small_pieces_counts_too() {
        let words = |stolen_ms| {
            let pulse = Pulse {
                processors: 2,
                stolen_ms,
                ..Pulse::default()
            };
            assert_eq!(super::pulse(&pulse, &Met::Any, S, 3 * S), None);
            taken(&pulse, S, 3 * S).map(|one| one.words)
        };
        assert_eq!(words(30.0), None);
        assert!(words(60.0).expect("1.5 %").contains("60 ms"));
    }

    #[test]
    fn without_real_time_scheduling_a_pulse_tells_less() {
        let mut pulse = Pulse {
            processors: 2,
            real_time: true,
            gaps: vec![gap(1500, 30)],
            ..Pulse::default()
        };
        assert!(super::pulse(&pulse, &Met::Any, S, 3 * S).is_some());
        pulse.real_time = false;
        assert_eq!(super::pulse(&pulse, &Met::Any, S, 3 * S), None);
    }
}
