//! Judges the two ends by what they record: whether the plant ticked, and the controller sent, when
//! due.
//!
//! If a deadline is missed while the client has as many requests under way as it may, the link caused
//! it, and it is a result of the loop. What a client causes itself is covered by its
//! [allowance](crate::Allowance).

use endpoint::{MessageRow, TickNoise, TickRow};
use plan::Disturbance;

use crate::hit::Hits;
use crate::limit::{BEHIND_MS, Stillness};
use crate::machine::describe;

/// A delay shorter than this needs no excuse.
const BEHIND_LEAST_NS: u64 = 100_000;

/// When something was due, and how late it happened.
#[derive(Debug, Clone, Copy)]
struct Due {
    t_ns: u64,
    /// `u64::MAX` if it never happened.
    behind_ns: u64,
}

/// Judges whether the plant's ticks were held up between `from_ns` and `to_ns`. `limit` is that
/// of its thread.
/// `noise` is the time that the ticks were asked to wait beyond their deadlines, and `hits` are the faults that
/// were asked for.
#[must_use]
pub fn plant(
    ticks: &[TickRow],
    noise: Option<TickNoise>,
    hits: &Hits,
    h_ns: u64,
    limit: Stillness,
    from_ns: u64,
    to_ns: u64,
) -> Option<Disturbance> {
    // A tick that waits longer than h holds up the next.
    let mut asked_ns = 0;
    let dues = ticks.iter().filter_map(|row| {
        let extra_ns = noise.map_or(0, |noise| noise.extra_ns(row.k));
        asked_ns = asked_ns.max(row.t_due_ns.saturating_add(extra_ns));
        (from_ns..to_ns).contains(&row.t_due_ns).then(|| Due {
            t_ns: row.t_due_ns,
            behind_ns: row
                .t_tick_ns
                .saturating_sub(asked_ns)
                .saturating_sub(hits.kept_ns(asked_ns, row.t_tick_ns)),
        })
    });
    judge("plant", "ticks", dues, h_ns, limit, from_ns)
}

/// Judges whether the controller's deadlines were held up, on an absolute schedule. `outstanding` is
/// how many requests it may have under way. `is_swamped` says whether, at an instant, the link stalls
/// or releases what waited in it, or a fault that was asked for hit an end: a controller that gets hundreds of
/// answers at once has a reason to be late.
#[must_use]
pub fn controller(
    messages: &[MessageRow],
    outstanding: usize,
    h_ns: u64,
    limit: Stillness,
    from_ns: u64,
    to_ns: u64,
    is_swamped: impl Fn(u64) -> bool,
) -> Option<Disturbance> {
    let mut sends: Vec<u64> = messages.iter().filter_map(|row| row.t_send_ns).collect();
    let mut ends: Vec<u64> = messages
        .iter()
        .filter(|row| row.t_send_ns.is_some())
        .map(|row| row.t_receive_ns.unwrap_or(u64::MAX))
        .collect();
    sends.sort_unstable();
    ends.sort_unstable();
    let is_full = |t_ns: u64| {
        let sent = sends.partition_point(|sent_ns| *sent_ns < t_ns);
        // A request that ended less than h ago may still have been the reason.
        let ended = ends.partition_point(|end_ns| end_ns.saturating_add(h_ns) <= t_ns);
        sent.saturating_sub(ended) >= outstanding
    };
    let is_inside = |row: &&MessageRow| (from_ns..to_ns).contains(&row.t_due_ns);
    let dues = messages.iter().filter(is_inside).map(|row| {
        let behind_ns = row
            .t_send_ns
            .map_or(u64::MAX, |sent_ns| sent_ns.saturating_sub(row.t_due_ns));
        let t_ns = row.t_due_ns;
        let is_excused = behind_ns >= BEHIND_LEAST_NS && (is_full(t_ns) || is_swamped(t_ns));
        Due {
            t_ns,
            behind_ns: if is_excused { 0 } else { behind_ns },
        }
    });
    judge("controller", "deadlines", dues, h_ns, limit, from_ns)
}

/// Judges whether too many were late, or one was late by too much.
fn judge(
    what: &str,
    things: &str,
    dues: impl Iterator<Item = Due>,
    h_ns: u64,
    limit: Stillness,
    from_ns: u64,
) -> Option<Disturbance> {
    let behind_ns = h_ns.min((BEHIND_MS * 1e6) as u64);
    let (mut count, mut behind, mut longest) = (
        0_u64,
        0_u64,
        Due {
            t_ns: 0,
            behind_ns: 0,
        },
    );
    // Consecutive missed deadlines count as one delay, as long as all of them.
    let mut missed_from_ns = None;
    let mut dues: Vec<Due> = dues.collect();
    dues.sort_by_key(|due| due.t_ns);
    for due in dues {
        count += 1;
        behind += u64::from(due.behind_ns >= behind_ns);
        let lasted_ns = match due.behind_ns {
            u64::MAX => due.t_ns + h_ns - *missed_from_ns.get_or_insert(due.t_ns),
            late_ns => {
                missed_from_ns = None;
                late_ns
            }
        };
        if lasted_ns > longest.behind_ns {
            longest = Due {
                t_ns: due.t_ns,
                behind_ns: lasted_ns,
            };
        }
    }
    let longest_ms = longest.behind_ns as f64 * 1e-6;
    let share = behind as f64 / count.max(1) as f64;
    // One or two late ones are too few to make a share.
    let are_many = behind > 2 && share > limit.share;
    let limit_ms = behind_ns as f64 / 1e6;
    // In a slow loop, a tick that is late by less than the limit makes no difference.
    if longest_ms < limit.longest_ms && !are_many {
        return None;
    }
    Some(describe(
        what,
        longest.t_ns,
        from_ns,
        longest_ms,
        format!(
            "the {what} was held up: {behind} of {count} {things} were {limit_ms} ms or more \
             late or missed, and the link does not explain it (limit {:.0} %), the worst by \
             {longest_ms:.0} ms (limit {:.0} ms)",
            100.0 * limit.share,
            limit.longest_ms
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use endpoint::MessageOutcome;

    const MS: u64 = 1_000_000;

    fn ticks(late_ms: impl Fn(u64) -> f64) -> Vec<TickRow> {
        (0..1000)
            .map(|k| TickRow {
                k,
                t_due_ns: k * 3 * MS,
                t_tick_ns: k * 3 * MS + (late_ms(k) * 1e6) as u64,
                u: 0.0,
                y: 0.0,
                seq: None,
                u_applied: None,
            })
            .collect()
    }

    fn message(seq: u64, sent_ms: Option<u64>, received_ms: Option<u64>) -> MessageRow {
        MessageRow {
            seq,
            t_due_ns: seq * 3 * MS,
            t_send_ns: sent_ms.map(|ms| ms * MS),
            t_receive_ns: received_ms.map(|ms| ms * MS),
            t_arrive_ns: None,
            r: 1.0,
            y: None,
            e: None,
            u: None,
            tick: None,
            outcome: MessageOutcome::Missed,
            y_seq: None,
        }
    }

    #[test]
    fn a_plant_that_is_punctual_or_a_little_late_now_and_then_is_not_held_up() {
        let held_up = |late_ms: &dyn Fn(u64) -> f64| {
            plant(
                &ticks(late_ms),
                None,
                &Hits::default(),
                3 * MS,
                Stillness::REAL_TIME,
                0,
                u64::MAX,
            )
        };
        assert_eq!(held_up(&|_| 0.1), None);
        assert_eq!(held_up(&|k| if k % 200 == 0 { 4.0 } else { 0.0 }), None);
    }

    #[test]
    fn a_plant_that_stands_still_once_or_often_is_named_with_when() {
        let once = plant(
            &ticks(|k| if k == 500 { 40.0 } else { 0.0 }),
            None,
            &Hits::default(),
            3 * MS,
            Stillness::REAL_TIME,
            500 * MS,
            u64::MAX,
        );
        let once = once.expect("40 ms are too long");
        assert_eq!((once.at_s, once.longest_ms), (1.0, 40.0));
        let often = plant(
            &ticks(|k| if k % 20 == 0 { 6.0 } else { 0.0 }),
            None,
            &Hits::default(),
            3 * MS,
            Stillness::REAL_TIME,
            0,
            u64::MAX,
        );
        assert!(often.expect("5 %").words.contains("50 of 1000 ticks"));
    }

    #[test]
    fn a_deadline_that_waits_for_an_answer_is_no_disturbance_and_one_that_waits_for_nothing_is() {
        // Each answer takes 90 ms, and the client may have one request under way.
        let blocked: Vec<MessageRow> = (0..300)
            .map(|seq| match seq % 30 {
                0 => message(seq, Some(seq * 3), Some(seq * 3 + 89)),
                _ => message(seq, None, None),
            })
            .collect();
        assert_eq!(
            controller(
                &blocked,
                1,
                3 * MS,
                Stillness::REAL_TIME,
                0,
                u64::MAX,
                |_| false
            ),
            None
        );
        let late = |is_drained: bool| {
            controller(
                &blocked,
                usize::MAX,
                3 * MS,
                Stillness::REAL_TIME,
                0,
                u64::MAX,
                |_| is_drained,
            )
        };
        assert_eq!(late(true), None);
        let found = late(false).expect("nothing to wait for");
        assert_eq!(found.longest_ms, 87.0);
    }
}
