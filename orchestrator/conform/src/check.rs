//! Compares what a trial saw of a controller with the contract.
//!
//! Each check is a function of the trial and the record, and finds at most one fault.

use std::collections::{BTreeMap, BTreeSet};

use control::seconds;

use crate::breach::Breach;
use crate::record::{Arrival, Record};
use crate::trial::{REFUSAL, S, STALL, Script, Trial};

/// How long a controller may still run after its time, ns. The supervisor sends SIGTERM after 2 s, so
/// what ends within this ended by itself.
pub(crate) const OVERTIME_NS: u64 = 1_800_000_000;

/// How long a controller and its supervisor may take to end after SIGTERM, ns: 1 s for the controller.
pub(crate) const TERM_WITHIN_NS: u64 = 1_500_000_000;

/// How long after a disturbance messages must have come again, ns.
const RESUME_WITHIN_NS: u64 = S;

/// Oldest `t_send_ns` of an arriving message, ns: there is no link that could delay it.
const OLDEST_NS: u64 = S;

/// Number of connections that is always accepted.
const FEW_CONNECTIONS: u64 = 4;

type Check = fn(&Trial, &Record) -> Option<Breach>;

static ALWAYS: [Check; 7] = [silent, early, rate, refused, other_mode, quiet, ending];

/// What is asked while nothing out of the ordinary happens: after a lost message a controller may, for
/// instance, send its number again.
static UNDISTURBED: [Check; 5] = [first_seq, repeated_seq, falling_seq, send_time, connections];

/// Everything that a controller did wrong in a trial.
pub(crate) fn faults(trial: &Trial, record: &Record) -> Vec<Breach> {
    let undisturbed: &[Check] = match trial.script {
        Script::Plain => &UNDISTURBED,
        _ => &[],
    };
    let checks = ALWAYS.iter().chain(undisturbed);
    checks.filter_map(|check| check(trial, record)).collect()
}

/// What is wrong with how a controller follows the reference; no fault, since its law may be meant for
/// another plant.
pub(crate) fn strays(trial: &Trial, record: &Record) -> Option<String> {
    /// The part of the loop that is looked at, from its end, ns.
    const LAST_NS: u64 = 300_000_000;
    const BAND: f64 = 0.05;
    if !trial.notes_r {
        return None;
    }
    let from_ns = trial.stop_ns(record.start_ns).saturating_sub(LAST_NS);
    let late = record
        .heard
        .arrivals
        .iter()
        .filter(|one| one.t_ns >= from_ns);
    let y = late.filter_map(|one| one.y);
    let worst = y.max_by(|a, b| (a - trial.r).abs().total_cmp(&(b - trial.r).abs()))?;
    ((worst - trial.r).abs() > BAND * trial.r.abs()).then(|| {
        format!(
            "does not follow r: y is {worst:.3} at the end and r is {}; take r from WEBLOOP_R, if the \
             law is meant for the paper's motor",
            trial.r
        )
    })
}

fn silent(trial: &Trial, record: &Record) -> Option<Breach> {
    let mode = trial.mode;
    record
        .heard
        .arrivals
        .is_empty()
        .then_some(Breach::Silent { mode })
}

fn early(trial: &Trial, record: &Record) -> Option<Breach> {
    let before_ns = record
        .start_ns
        .saturating_sub(record.heard.arrivals.first()?.t_ns);
    (before_ns > trial.h.ns()).then(|| Breach::Early {
        before_ms: ms(before_ns),
        h: trial.h,
    })
}

fn rate(trial: &Trial, record: &Record) -> Option<Breach> {
    let first_ns = record.heard.arrivals.first()?.t_ns;
    let (sent, due) = (record.heard.messages(), trial.due());
    let most = (trial.shares.end() * due as f64).ceil() as u64;
    if sent > most {
        return Some(Breach::Flood { sent, due, most });
    }
    ((sent as f64) < trial.shares.start() * due as f64).then(|| Breach::Slow {
        sent,
        due,
        first_s: seconds(first_ns.saturating_sub(record.start_ns)),
        h: trial.h,
    })
}

fn refused(_: &Trial, record: &Record) -> Option<Breach> {
    let first = record.heard.first_refused.clone()?;
    let count = record.heard.refused;
    Some(Breach::Refused { count, first })
}

fn other_mode(trial: &Trial, record: &Record) -> Option<Breach> {
    let others = || {
        record
            .heard
            .arrivals
            .iter()
            .filter(|one| one.mode != trial.mode)
    };
    Some(Breach::OtherMode {
        other: others().next()?.mode,
        count: others().count() as u64,
        told: trial.mode,
    })
}

fn quiet(trial: &Trial, record: &Record) -> Option<Breach> {
    record.heard.arrivals.first()?;
    let start_ns = record.start_ns;
    let (event, ends_ns) = match trial.script {
        Script::Stall => ("the held answers came", vec![start_ns + STALL.end]),
        Script::Refuse => ("the last refusal", vec![start_ns + REFUSAL.end]),
        Script::Drop { .. } => (
            "the plant closed a connection",
            record.heard.closed_ns.clone(),
        ),
        Script::Plain | Script::ListenLate | Script::Terminate => return None,
    };
    // Towards the end no more messages may be due.
    let last_ns = trial.stop_ns(start_ns).saturating_sub(RESUME_WITHIN_NS);
    let is_quiet = |end_ns: &u64| {
        let after = *end_ns + 1..=*end_ns + RESUME_WITHIN_NS;
        let mut arrivals = record.heard.arrivals.iter();
        *end_ns <= last_ns && !arrivals.any(|one| after.contains(&one.t_ns))
    };
    let end_ns = ends_ns.into_iter().find(is_quiet)?;
    Some(Breach::Quiet {
        event,
        at_s: seconds(end_ns.saturating_sub(start_ns)),
    })
}

fn ending(trial: &Trial, record: &Record) -> Option<Breach> {
    let ending = &record.ending;
    if let Some(told_ns) = ending.told_ns {
        let last_ns = told_ns + TERM_WITHIN_NS;
        let is_late = ending.ended_ns.is_none_or(|ended_ns| ended_ns > last_ns);
        return (is_late || ending.is_killed).then_some(Breach::IgnoredTerm);
    }
    let stop_ns = trial.stop_ns(record.start_ns);
    let Some(ended_ns) = ending.ended_ns.filter(|ns| *ns <= stop_ns + OVERTIME_NS) else {
        return Some(Breach::RanOn {
            within_s: seconds(OVERTIME_NS),
        });
    };
    if ending.is_unsupported {
        return Some(Breach::Unsupported);
    }
    if let Some(words) = ending.problem.clone() {
        return Some(Breach::Failed { words });
    }
    // It may end with its last message, which is due h before its time, and come early by h.
    (ended_ns + 2 * trial.h.ns() < stop_ns).then(|| Breach::EndedEarly {
        before_s: seconds(stop_ns - ended_ns),
    })
}

fn first_seq(trial: &Trial, record: &Record) -> Option<Breach> {
    let first = record.heard.arrivals.first()?;
    let seq = first.request.seq?;
    // The numbers of deadlines that were missed may be left out.
    let missed = first.t_ns.saturating_sub(record.start_ns) / trial.h.ns();
    (seq > missed).then_some(Breach::FirstSeq { seq })
}

fn repeated_seq(_: &Trial, record: &Record) -> Option<Breach> {
    let mut seen = BTreeSet::new();
    let mut numbers = record
        .heard
        .arrivals
        .iter()
        .filter_map(|one| one.request.seq);
    let seq = numbers.find(|seq| !seen.insert(*seq))?;
    Some(Breach::RepeatedSeq { seq })
}

/// Only within a connection: messages on two of them may overtake each other.
fn falling_seq(_: &Trial, record: &Record) -> Option<Breach> {
    let mut newest = BTreeMap::new();
    record.heard.arrivals.iter().find_map(|one| {
        let seq = one.request.seq?;
        let after = newest.insert(one.connection, seq)?;
        (seq < after).then_some(Breach::FallingSeq { seq, after })
    })
}

fn send_time(_: &Trial, record: &Record) -> Option<Breach> {
    let fault = |one: &Arrival| {
        let (sent_ns, t_ns) = (one.request.t_send_ns?, one.t_ns);
        if sent_ns > t_ns {
            return Some(Breach::SentLater {
                ahead_ms: ms(sent_ns - t_ns),
            });
        }
        (t_ns - sent_ns > OLDEST_NS).then(|| Breach::SentLongBefore {
            before_s: seconds(t_ns - sent_ns),
        })
    };
    record.heard.arrivals.iter().find_map(fault)
}

fn connections(_: &Trial, record: &Record) -> Option<Breach> {
    let (connections, messages) = (record.heard.connections, record.heard.messages());
    let most = FEW_CONNECTIONS.max(messages / 10);
    (messages > 0 && connections > most).then_some(Breach::Connections {
        connections,
        messages,
        most,
    })
}

fn ms(ns: u64) -> f64 {
    ns as f64 / 1e6
}

#[cfg(test)]
mod tests;
