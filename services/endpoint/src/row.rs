//! The rows that the two ends record: one struct per CSV file, one field per column.
//!
//! The plant writes `ticks.csv` and `arrivals.csv`, and `second.csv` if it has a second input or output; the
//! controller writes `messages.csv`. Inputs and outputs in the others are the first. All times are
//! nanoseconds on the run's monotonic clock; an empty field means that there was nothing to record.
//! The comment on a column is what the data package and the book say of it. Writing and reading files is the task of
//! others.

use text::row;

row!(
    /// One tick of the plant (`ticks.csv`): a row every h, whatever happens.
    TickRow {
        /// Number of the tick, from 0.
        k: u64,
        /// When the tick was due, monotonic: start + k h.
        t_due_ns: u64,
        /// When it happened.
        t_tick_ns: u64,
        /// The commanded input that the plant held.
        u: f64,
        /// The output after the step.
        ///
        /// Without the sensor's noise.
        y: f64,
        /// The command that set u; empty before the first.
        seq: Option<u64>,
    } later {
        /// The input that the plant was stepped with, behind watchdog and actuator; older files do not have it.
        ///
        /// Without a disturbance.
        u_applied: Option<f64>,
    }
);

row!(
    /// The second input and output at a tick (`second.csv`), of a plant that has one of them; the first are in
    /// [`TickRow`].
    SecondRow {
        /// Number of the tick, from 0.
        k: u64,
        /// The second commanded input; empty where it has one input.
        u2: Option<f64>,
        /// The second output after the step; empty where it has one output.
        ///
        /// Without the sensor's noise.
        y2: Option<f64>,
    } later {
        /// The second input that the plant was stepped with; older files do not have it.
        u2_applied: Option<f64>,
    }
);

row!(
    /// One command that reached the plant (`arrivals.csv`), in order of arrival.
    ArrivalRow {
        /// Number of the arrival, from 0.
        n: u64,
        /// The command's sequence number; that of the arrival if the controller gave none.
        seq: u64,
        /// When the controller says that it sent the command; empty if it does not say.
        t_send_ns: Option<u64>,
        /// When the plant had the whole request.
        t_arrive_ns: u64,
        /// The plant's latest tick at that moment.
        tick: u64,
        /// The commanded input.
        u: f64,
        /// What became of it: the plant's input from the next tick on, dropped as no newer than one applied or as too
        /// long under way, or in open loop only acknowledged.
        outcome: ArrivalOutcome,
    }
);

text::choice!(
    /// What became of a command at the plant.
    ArrivalOutcome, "outcome", {
        /// It became the plant's input, held from the next tick on.
        Applied = "applied",
        /// It was older than the newest applied one and was dropped.
        Stale = "stale",
        /// It was longer under way than the plant permits and was dropped.
        Aged = "aged",
        /// Open loop: it was acknowledged, and the input left alone.
        Acknowledged = "acknowledged",
    }
);

row!(
    /// One deadline of the controller (`messages.csv`), and the message it sent.
    ///
    /// Rows are in the order in which the messages ended, not in order of `seq`.
    MessageRow {
        /// Number of the deadline and of its message, from 0.
        seq: u64,
        /// When the message was due, monotonic.
        t_due_ns: u64,
        /// When it was sent; empty if it was not.
        t_send_ns: Option<u64>,
        /// When its answer was received.
        t_receive_ns: Option<u64>,
        /// When it reached the plant, by the plant's answer.
        t_arrive_ns: Option<u64>,
        /// The reference.
        r: f64,
        /// The newest output known when it was sent; empty in open loop.
        ///
        /// The commanded input follows from it. (The answer's own `y` is used in the next message.)
        y: Option<f64>,
        /// The error r - y.
        e: Option<f64>,
        /// The commanded input.
        u: Option<f64>,
        /// The plant's latest tick when it arrived, by the answer.
        tick: Option<u64>,
        /// What became of it: answered, no answer in time, connection or answer broken, nothing sent, or it reached the
        /// plant and more only its controller knows.
        outcome: MessageOutcome,
    } later {
        /// The message whose answer brought `y`; empty before the first answer, and in older files.
        y_seq: Option<u64>,
    }
);

text::choice!(
    /// What became of a deadline of the controller.
    MessageOutcome, "outcome", {
        /// The message was sent and a valid answer came.
        Answered = "answered",
        /// The message was sent and no answer came within the timeout.
        Timeout = "timeout",
        /// The message was sent, and the connection or the answer was broken.
        Failed = "failed",
        /// Nothing was sent: no request was free, or the moment had passed.
        Missed = "missed",
        /// The message reached the plant. What became of its answer, only a controller of somebody's own
        /// knows, which left no rows.
        Arrived = "arrived",
    }
);

impl TickRow {
    /// The file of these rows, in a run's folder.
    pub const FILE: &str = "ticks.csv";
}

impl SecondRow {
    /// The file of these rows, in a run's folder.
    pub const FILE: &str = "second.csv";
}

impl ArrivalRow {
    /// The file of these rows, in a run's folder.
    pub const FILE: &str = "arrivals.csv";
}

impl MessageRow {
    /// The file of these rows, in a run's folder.
    pub const FILE: &str = "messages.csv";
}

#[cfg(test)]
mod tests {
    use serde::Serialize;

    use super::*;

    /// A file gets a header even if it stays empty, so the header is a constant; it must equal the
    /// one that serde derives.
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
            u_applied: Some(0.0),
        };
        check(tick, TickRow::COLUMNS, "3,9,10,0.1,1e-9,,0.0");
        let second = SecondRow {
            k: 3,
            u2: None,
            y2: Some(-0.25),
            u2_applied: None,
        };
        check(second, SecondRow::COLUMNS, "3,,-0.25,");
        let arrival = ArrivalRow {
            n: 0,
            seq: 7,
            t_send_ns: Some(1),
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
            y_seq: None,
        };
        check(missed, MessageRow::COLUMNS, "4,12,,,,1.0,,,,,missed,");
    }
}
