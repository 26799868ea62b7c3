//! Made-up records: a good one of each trial has no fault, and each way to spoil one has its own.

use endpoint::{Mode, Request};

use super::*;
use crate::record::{Ending, Heard};
use crate::trial::TERMINATE_NS;

const MS: u64 = 1_000_000;
const START_NS: u64 = 100 * S;

fn trials() -> Vec<Trial> {
    Trial::all("10ms".parse().expect("a sample time"))
}

fn trial(name: &str) -> Trial {
    let mut trials = trials().into_iter();
    trials.find(|trial| trial.name == name).expect(name)
}

/// The record of a controller that does what the trial asks.
fn good(trial: &Trial) -> Record {
    let arrival = |seq: u64| {
        let due_ns = START_NS + seq * trial.h.ns();
        Arrival {
            t_ns: due_ns + MS,
            connection: 1,
            mode: trial.mode,
            request: Request {
                seq: Some(seq),
                t_send_ns: Some(due_ns),
                u: 0.5.into(),
            },
            y: Some(trial.r),
        }
    };
    let told_ns = (trial.script == Script::Terminate).then_some(START_NS + TERMINATE_NS);
    let over_ns = told_ns.unwrap_or(trial.stop_ns(START_NS));
    let arrivals = (0..trial.due()).map(arrival);
    Record {
        start_ns: START_NS,
        heard: Heard {
            connections: 1,
            arrivals: arrivals.filter(|one| one.t_ns < over_ns).collect(),
            ..Heard::default()
        },
        ending: Ending {
            ended_ns: Some(over_ns + 50 * MS),
            told_ns,
            ..Ending::default()
        },
    }
}

/// Names of the faults in a record.
fn names(trial: &Trial, record: &Record) -> Vec<String> {
    let name = |fault: &Breach| {
        let text = format!("{fault:?}");
        let end = text.find(' ').unwrap_or(text.len());
        text[..end].to_owned()
    };
    faults(trial, record).iter().map(name).collect()
}

/// Leaves out the messages of a part of the trial, ms after the start.
fn silence(record: &mut Record, from_ms: u64, to_ms: u64) {
    let part = START_NS + from_ms * MS..START_NS + to_ms * MS;
    record
        .heard
        .arrivals
        .retain(|one| !part.contains(&one.t_ns));
}

#[test]
fn a_good_record_has_no_fault_in_any_trial() {
    for trial in trials() {
        let record = good(&trial);
        assert_eq!(faults(&trial, &record), [], "{}", trial.name);
        assert_eq!(strays(&trial, &record), None, "{}", trial.name);
    }
}

#[test]
fn seq_and_t_send_may_be_left_out_and_missed_deadlines_too() {
    let trial = trial("steady");
    let mut record = good(&trial);
    silence(&mut record, 0, 35);
    silence(&mut record, 500, 600);
    assert_eq!(faults(&trial, &record), []);
    for one in &mut record.heard.arrivals {
        one.request.seq = None;
        one.request.t_send_ns = None;
    }
    assert_eq!(faults(&trial, &record), []);
}

#[test]
fn each_way_to_spoil_a_record_is_a_fault_with_its_name() {
    type Spoil = fn(&mut Record);
    let cases: [(&str, &str, Spoil); 25] = [
        ("Silent", "steady", |record| record.heard.arrivals.clear()),
        ("Early", "steady", |record| {
            record.heard.arrivals[0].t_ns = START_NS - 11 * MS;
            record.heard.arrivals[0].request.t_send_ns = None;
        }),
        ("Slow", "steady", |record| silence(record, 500, 1_000)),
        ("Slow", "late-start", |record| silence(record, 0, 500)),
        ("Slow", "open", |record| silence(record, 500, 1_000)),
        ("Slow", "dropped", |record| silence(record, 900, 2_000)),
        ("Flood", "two", |record| {
            let more = record.heard.arrivals.iter().take(41).cloned();
            let more: Vec<_> = more.map(unnumbered).collect();
            record.heard.arrivals.extend(more);
        }),
        ("Flood", "stall", |record| {
            let arrivals = &mut record.heard.arrivals;
            let more: Vec<_> = arrivals
                .iter()
                .cloned()
                .chain(arrivals.first().cloned())
                .collect();
            arrivals.extend(more);
        }),
        ("Refused", "steady", |record| {
            record.heard.refuse("field `u` is missing");
        }),
        ("OtherMode", "steady", |record| {
            record.heard.arrivals[7].mode = Mode::Open;
        }),
        ("FirstSeq", "steady", |record| {
            for one in &mut record.heard.arrivals {
                one.request.seq = one.request.seq.map(|seq| seq + 1);
            }
        }),
        ("RepeatedSeq", "steady", |record| {
            record.heard.arrivals[8].request.seq = Some(7);
        }),
        ("FallingSeq", "steady", |record| {
            record.heard.arrivals[7].request.seq = Some(8);
            record.heard.arrivals[8].request.seq = Some(7);
        }),
        ("SentLater", "steady", |record| {
            let one = &mut record.heard.arrivals[7];
            one.request.t_send_ns = Some(one.t_ns + 1);
        }),
        ("SentLongBefore", "steady", |record| {
            let one = &mut record.heard.arrivals[7];
            one.request.t_send_ns = Some(one.t_ns - S - 1);
        }),
        ("Connections", "steady", |record| {
            record.heard.connections = 21;
        }),
        ("Quiet", "stall", |record| silence(record, 2_500, 3_501)),
        ("Quiet", "refusal", |record| silence(record, 1_100, 2_101)),
        ("Quiet", "dropped", |record| {
            record.heard.closed_ns.push(START_NS + 900 * MS);
            silence(record, 901, 1_901);
        }),
        ("Unsupported", "steady", |record| {
            record.ending.is_unsupported = true;
            record.ending.problem = Some("the controller ended with exit status: 3".to_owned());
        }),
        ("Failed", "steady", |record| {
            record.ending.problem = Some("the controller ended with exit status: 1".to_owned());
        }),
        ("EndedEarly", "steady", |record| {
            record.ending.ended_ns = Some(START_NS + 1_979 * MS);
        }),
        ("RanOn", "steady", |record| record.ending.ended_ns = None),
        ("IgnoredTerm", "stop", |record| {
            record.ending.ended_ns = None;
        }),
        ("IgnoredTerm", "stop", |record| {
            record.ending.is_killed = true;
        }),
    ];
    for (fault, name, spoil) in cases {
        let trial = trial(name);
        let mut record = good(&trial);
        spoil(&mut record);
        assert_eq!(names(&trial, &record), [fault], "{name}");
    }
}

/// The same message without number and time.
fn unnumbered(mut arrival: Arrival) -> Arrival {
    arrival.request.seq = None;
    arrival.request.t_send_ns = None;
    arrival
}

#[test]
fn messages_on_two_connections_may_overtake_each_other() {
    let trial = trial("steady");
    let mut record = good(&trial);
    record.heard.connections = 2;
    record.heard.arrivals[8].connection = 2;
    record.heard.arrivals.swap(7, 8);
    assert_eq!(faults(&trial, &record), []);
}

#[test]
fn a_controller_that_does_not_follow_r_is_told_so_without_a_fault() {
    let trial = trial("reference");
    let mut record = good(&trial);
    for one in &mut record.heard.arrivals {
        one.y = Some(1.0);
    }
    assert_eq!(faults(&trial, &record), []);
    let note = strays(&trial, &record).expect("a note");
    assert!(
        note.contains("y is 1.000 at the end and r is 0.5"),
        "{note}"
    );
}
