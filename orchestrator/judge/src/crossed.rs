//! What the messages say of one way, and what follows from it: each limit is in `limit` or with its client.

use link::Way;
use plan::evidence::{Crossed, Shows};

use crate::fault::LinkFault;
use crate::lateness::Lateness;
use crate::limit::{
    DEVIATIONS, FLOOR_QUANTILE, LATE_MS, QUICKER_PER_MILLE, RESENT, RESENT_DEVIATIONS,
    RESENT_PER_MILLE, Tail,
};
use crate::quantile::{beyond, quantile, thousandths};
use crate::terms::Terms;

/// Sets the figures of how much later than the link the messages were, each within its bounds.
pub(crate) fn with_lateness(
    crossed: Crossed,
    all: &[Lateness],
    way: Way,
    terms: &Terms,
) -> Crossed {
    let each = |of: fn(&Lateness) -> f64| -> Vec<f64> { all.iter().map(of).collect() };
    let (mut most_ms, least_ms) = (each(|one| one.most_ms), each(|one| one.least_ms));
    let base_ms = quantile(&mut most_ms, FLOOR_QUANTILE);
    let mut figure = |q: f64| quantile(&mut most_ms, q).map_or(0.0, thousandths);
    let tail = terms.tail(way, crossed.count);
    let beyond =
        |step_ms: f64| base_ms.map_or(0, |base_ms| beyond(&least_ms, base_ms + step_ms) as u64);
    let [first, ..] = tail;
    let share = (most_beyond(first, all.len() as f64).floor() + 1.0) / all.len() as f64;
    Crossed {
        judged: all.len() as u64,
        // What is not known of the link's own delay of nine messages of ten hides as much.
        shows: quantile(
            &mut each(|one| one.most_ms - one.least_ms),
            1.0 - FLOOR_QUANTILE,
        )
        .filter(|_| share <= 1.0)
        .map(|unknown_ms| Shows {
            later_ms: thousandths(first.beyond_ms + unknown_ms),
            share: thousandths(share),
        }),
        excess_p10_ms: figure(FLOOR_QUANTILE),
        excess_p50_ms: figure(0.5),
        excess_p99_ms: figure(0.99),
        beyond: tail.map(|step| beyond(step.beyond_ms)),
        ..crossed
    }
}

pub(crate) fn judge(crossed: &Crossed, way: Way, terms: &Terms, faults: &mut Vec<LinkFault>) {
    let count = crossed.count;
    let quicker = QUICKER_PER_MILLE * count / 1_000;
    if crossed.quicker > quicker {
        faults.push(LinkFault {
            words: format!(
                "{} of {count} messages went {way} quicker than the link allows: they went \
                 around it (limit {quicker})",
                crossed.quicker
            ),
            by_lateness: false,
            is_busy: false,
        });
    }
    faults.extend(floor(crossed, way, terms));
    faults.extend(tail(crossed, way, terms));
    judge_late(crossed, way, terms, faults);
    let deviation = (crossed.lost_variance + crossed.lost as f64).sqrt();
    if (crossed.lost_due - crossed.lost as f64).abs() > 2.0 + RESENT_DEVIATIONS * deviation {
        faults.push(LinkFault {
            words: format!(
                "{} messages were lost on the way {way}; the link should have lost about {:.0}",
                crossed.lost, crossed.lost_due
            ),
            by_lateness: crossed.lost as f64 > crossed.lost_due,
            is_busy: false,
        });
    }
}

/// Whether even the quickest take too long.
fn floor(crossed: &Crossed, way: Way, terms: &Terms) -> Option<LinkFault> {
    let (floor_ms, p10_ms) = (terms.floor_ms(way, crossed.count), crossed.excess_p10_ms);
    let waited_ms = terms.waited_each_ms(crossed.count);
    (p10_ms > floor_ms).then(|| LinkFault {
        words: format!(
            "nine of ten messages took {p10_ms:.1} ms more than the link on the way {way}: \
             something else delays them (limit {floor_ms:.1} ms)"
        ),
        by_lateness: true,
        is_busy: p10_ms <= floor_ms + waited_ms,
    })
}

/// Whether more of them are later than the quickest than their client and its machine explain.
fn tail(crossed: &Crossed, way: Way, terms: &Terms) -> Option<LinkFault> {
    let judged = crossed.judged as f64;
    let steps = terms
        .tail(way, crossed.count)
        .into_iter()
        .zip(crossed.beyond);
    let found = steps.filter_map(|(step, beyond)| {
        let limit = most_beyond(step, judged);
        let busy = terms.busy_explains(crossed.judged, step.beyond_ms);
        (beyond as f64 > limit).then(|| LinkFault {
            words: format!(
                "{beyond} of {} messages took {:.1} ms more on the way {way} than the quickest \
                 tenth, beyond what the link did to them: something else delays them now and \
                 then (limit {limit:.0})",
                crossed.judged, step.beyond_ms
            ),
            by_lateness: true,
            is_busy: beyond as f64 <= limit + busy,
        })
    });
    // What the machine does not explain says more.
    found.min_by_key(|fault| fault.is_busy)
}

fn judge_late(crossed: &Crossed, way: Way, terms: &Terms, faults: &mut Vec<LinkFault>) {
    let count = crossed.count;
    let resent = RESENT + RESENT_PER_MILLE * count / 1_000;
    let late = resent.max((terms.allowance.late_share * count as f64) as u64);
    let busy = |late_ms: f64| terms.busy_explains(count, late_ms);
    if crossed.resent > resent {
        faults.push(LinkFault {
            words: format!(
                "{} of {count} messages were resent on the way {way}, but the link lost none \
                 of them (limit {resent})",
                crossed.resent
            ),
            by_lateness: true,
            is_busy: false,
        });
    } else if crossed.late > late {
        faults.push(LinkFault {
            words: format!(
                "{} of {count} messages were late on the way {way}, by more than {LATE_MS} ms \
                 plus a tenth, and no loss on the link explains it (limit {late})",
                crossed.late
            ),
            by_lateness: true,
            is_busy: crossed.late as f64 <= late as f64 + busy(LATE_MS),
        });
    }
}

/// How many of `judged` messages may lie beyond a step: its share of them, what chance adds, and one.
fn most_beyond(step: Tail, judged: f64) -> f64 {
    let due = step.share * judged;
    due + DEVIATIONS * due.sqrt() + 1.0
}
