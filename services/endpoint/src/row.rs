//! The rows that the two ends record: one struct a CSV file, one field a column.
//!
//! The plant writes `ticks.csv` and `arrivals.csv`, the controller
//! `messages.csv`. All times are nanoseconds on the run's monotonic clock; an
//! empty field means that there was nothing to record. Writing and reading the
//! files is left to others.

use serde::{Deserialize, Serialize};

/// One tick of the plant (`ticks.csv`): a row every h, whatever happens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TickRow {
    /// Number of the tick, from 0.
    pub k: u64,
    /// When the tick was due: start + k h.
    pub t_due_ns: u64,
    /// When it really happened.
    pub t_tick_ns: u64,
    /// The input that the plant was stepped with.
    pub u: f64,
    /// The output after the step.
    pub y: f64,
    /// Sequence number of the command that set `u`; empty before the first.
    pub seq: Option<u64>,
}

/// One command that reached the plant (`arrivals.csv`), in order of arrival.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArrivalRow {
    /// Number of the arrival, from 0.
    pub n: u64,
    /// The command's sequence number.
    pub seq: u64,
    /// When the controller says that it sent the command.
    pub t_send_ns: u64,
    /// When the plant had the whole request.
    pub t_arrive_ns: u64,
    /// The plant's latest tick at that moment.
    pub tick: u64,
    /// The commanded input.
    pub u: f64,
    /// What became of it.
    pub outcome: ArrivalOutcome,
}

/// What became of a command at the plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ArrivalOutcome {
    /// It became the plant's input, held from the next tick on.
    Applied,
    /// It was older than the newest applied one and was dropped.
    Stale,
    /// Open loop: it was acknowledged, and the input left alone.
    Acknowledged,
}

/// One deadline of the controller (`messages.csv`), and the message it sent.
///
/// Rows are in the order in which the messages ended, not in order of `seq`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MessageRow {
    /// Number of the deadline, from 0, and the sequence number of its message.
    pub seq: u64,
    /// When the message was due.
    pub t_due_ns: u64,
    /// When it was really sent; empty if it was not.
    pub t_send_ns: Option<u64>,
    /// When its answer was received.
    pub t_receive_ns: Option<u64>,
    /// When it reached the plant, by the plant's answer.
    pub t_arrive_ns: Option<u64>,
    /// The reference.
    pub r: f64,
    /// The newest output known at the moment of sending, from which `u` follows;
    /// empty in open loop. (The answer's own `y` is in the next message.)
    pub y: Option<f64>,
    /// The error r - y.
    pub e: Option<f64>,
    /// The commanded input.
    pub u: Option<f64>,
    /// The plant's latest tick when the message arrived there, by its answer.
    pub tick: Option<u64>,
    /// What became of it.
    pub outcome: MessageOutcome,
}

/// What became of a deadline of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MessageOutcome {
    /// The message was sent and a valid answer came.
    Answered,
    /// The message was sent and no answer came within the timeout.
    Timeout,
    /// The message was sent, and the connection or the answer was broken.
    Failed,
    /// Nothing was sent: no request was free, or the moment had passed.
    Missed,
}

impl TickRow {
    /// The file of these rows, in a run's folder.
    pub const FILE: &str = "ticks.csv";
    /// The columns of `ticks.csv`, in order.
    pub const COLUMNS: &[&str] = &["k", "t_due_ns", "t_tick_ns", "u", "y", "seq"];
}

impl ArrivalRow {
    /// The file of these rows, in a run's folder.
    pub const FILE: &str = "arrivals.csv";
    /// The columns of `arrivals.csv`, in order.
    pub const COLUMNS: &[&str] = &[
        "n",
        "seq",
        "t_send_ns",
        "t_arrive_ns",
        "tick",
        "u",
        "outcome",
    ];
}

impl MessageRow {
    /// The file of these rows, in a run's folder.
    pub const FILE: &str = "messages.csv";
    /// The columns of `messages.csv`, in order.
    pub const COLUMNS: &[&str] = &[
        "seq",
        "t_due_ns",
        "t_send_ns",
        "t_receive_ns",
        "t_arrive_ns",
        "r",
        "y",
        "e",
        "u",
        "tick",
        "outcome",
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file is written with a header even when it stays empty, so the header
    /// is a constant; it has to be the one that serde derives.
    fn check<R: Serialize>(row: R, columns: &[&str], line: &str) {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.serialize(row).expect("a row is a flat struct");
        let bytes = writer.into_inner().expect("a Vec takes every byte");
        let text = String::from_utf8(bytes).expect("csv of numbers is ASCII");
        assert_eq!(text, format!("{}\n{line}\n", columns.join(",")));
    }

    #[test]
    fn columns_are_the_fields_in_order_and_nothing_is_an_empty_field() {
        let tick = TickRow {
            k: 3,
            t_due_ns: 9,
            t_tick_ns: 10,
            u: 0.1,
            y: 1e-9,
            seq: None,
        };
        check(tick, TickRow::COLUMNS, "3,9,10,0.1,1e-9,");
        let arrival = ArrivalRow {
            n: 0,
            seq: 7,
            t_send_ns: 1,
            t_arrive_ns: 2,
            tick: 3,
            u: -0.5,
            outcome: ArrivalOutcome::Stale,
        };
        check(arrival, ArrivalRow::COLUMNS, "0,7,1,2,3,-0.5,stale");
        let missed = MessageRow {
            seq: 4,
            t_due_ns: 12,
            t_send_ns: None,
            t_receive_ns: None,
            t_arrive_ns: None,
            r: 1.0,
            y: None,
            e: None,
            u: None,
            tick: None,
            outcome: MessageOutcome::Missed,
        };
        check(missed, MessageRow::COLUMNS, "4,12,,,,1.0,,,,,missed");
    }
}
