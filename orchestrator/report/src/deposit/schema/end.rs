//! What the two ends and the echoes between them leave.

use crate::deposit::field::Field;
use crate::deposit::field::Kind::{Boolean, Integer, Number, String as Words};

use super::{always, sometimes};

/// `ticks.csv`.
#[must_use]
pub fn ticks() -> Vec<Field> {
    vec![
        always("k", Integer, "number of the tick, from 0"),
        always(
            "t_due_ns",
            Integer,
            "when the tick was due, monotonic: start + k h",
        ),
        always("t_tick_ns", Integer, "when it happened"),
        always("u", Number, "the input that the plant was stepped with"),
        always("y", Number, "the output after the step"),
        sometimes(
            "seq",
            Integer,
            "the command that set u; empty before the first",
        ),
    ]
}

/// `arrivals.csv`.
#[must_use]
pub fn arrivals() -> Vec<Field> {
    vec![
        always("n", Integer, "number of the arrival, from 0"),
        always("seq", Integer, "the command's sequence number"),
        always(
            "t_send_ns",
            Integer,
            "when the controller says that it sent the command",
        ),
        always(
            "t_arrive_ns",
            Integer,
            "when the plant had the whole request",
        ),
        always("tick", Integer, "the plant's latest tick at that moment"),
        always("u", Number, "the commanded input"),
        always(
            "outcome",
            Words,
            "what became of it: the plant's input from the next tick on, \
                dropped as older than one applied, or in open loop only acknowledged",
        )
        .one_of(&["applied", "stale", "acknowledged"]),
    ]
}

/// `messages.csv`.
#[must_use]
pub fn messages() -> Vec<Field> {
    vec![
        always(
            "seq",
            Integer,
            "number of the deadline and of its message, from 0",
        ),
        always("t_due_ns", Integer, "when the message was due, monotonic"),
        sometimes(
            "t_send_ns",
            Integer,
            "when it was sent; empty if it was not",
        ),
        sometimes("t_receive_ns", Integer, "when its answer was received"),
        sometimes(
            "t_arrive_ns",
            Integer,
            "when it reached the plant, by the plant's answer",
        ),
        always("r", Number, "the reference"),
        sometimes(
            "y",
            Number,
            "the newest output known when it was sent; empty in open loop",
        ),
        sometimes("e", Number, "the error r - y"),
        sometimes("u", Number, "the commanded input"),
        sometimes(
            "tick",
            Integer,
            "the plant's latest tick when it arrived, by the answer",
        ),
        always(
            "outcome",
            Words,
            "what became of it: answered, no answer in time, connection or \
                answer broken, or nothing sent",
        )
        .one_of(&["answered", "timeout", "failed", "missed"]),
    ]
}

/// `probes.csv`.
#[must_use]
pub fn probes() -> Vec<Field> {
    vec![
        always(
            "phase",
            Words,
            "when in the run it was sent: on the empty link, before the loop, \
                during it, after it",
        )
        .one_of(&["empty", "before", "during", "after"]),
        always("seq", Integer, "number of the echo in its phase, from 0"),
        always("t_send_ns", Integer, "when it was sent, monotonic"),
        sometimes("t_reach_ns", Integer, "when it reached the plant's end"),
        sometimes(
            "t_back_ns",
            Integer,
            "when it was back; empty if it was lost",
        ),
        always(
            "due_up_ns",
            Integer,
            "delay that the link had for it towards the plant",
        ),
        always(
            "due_down_ns",
            Integer,
            "delay that the link had for it towards the controller",
        ),
        always("due_lost", Boolean, "whether the link was to lose it"),
    ]
}

/// `packets.csv`.
#[must_use]
pub fn packets() -> Vec<Field> {
    vec![
        always(
            "t_ns",
            Integer,
            "when it entered the link, monotonic; never before link time 0",
        ),
        always("way", Words, "the way that it took: to the plant, or back").one_of(&["up", "down"]),
        always("bytes", Integer, "its length as an IP packet"),
    ]
}
