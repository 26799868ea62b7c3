//! What `summary.csv` holds of a cell: one measure a column.

use crate::deposit::field::Field;
use crate::deposit::field::Kind::{Integer, Number, String as Words};

use super::{always, sometimes};

/// `summary.csv`.
#[must_use]
pub fn summary() -> Vec<Field> {
    vec![
        always("cell", Words, "the cell's id, the name of its folder"),
        always("topology", Words, "the link's profile"),
        always("client", Words, "the program that closes the loop"),
        always(
            "setup",
            Words,
            "the client's preset, and what the experiment laid over it",
        ),
        always("transport", Words, "how messages are carried").one_of(&["http", "websocket"]),
        sometimes(
            "timer_floor_ms",
            Number,
            "least delay that the page gave its timers; empty where \
                   the client is no page",
        ),
        always(
            "mode",
            Words,
            "whether the plant answers with its state, or only acknowledges",
        )
        .one_of(&["open", "closed"]),
        always("rate", Words, "the rate in people's words, such as 333 Hz"),
        always("h_ns", Integer, "the sample time of plant and controller"),
        always("repeat", Integer, "which repeat it is, from 1"),
        sometimes(
            "backend",
            Words,
            "how it was run: netns, compose, attach, or sim, which is in virtual time; empty if it has not \
             been run",
        ),
        sometimes(
            "verdict",
            Words,
            "how the run ended; empty if it has not been run",
        )
        .one_of(&["complete", "unsupported", "disturbed", "invalid", "failed"]),
        sometimes(
            "disturbed",
            Words,
            "what disturbed the run from outside, the longest first; empty if nothing did",
        ),
        sometimes(
            "loop_verdict",
            Words,
            "what became of the loop, in closed loop",
        )
        .one_of(&["stable", "not-settled", "unstable"]),
        sometimes(
            "rtt_asked_ms",
            Number,
            "the profile's mean round trip over a long time, as it says itself",
        ),
        sometimes(
            "rtt_asked_p50_ms",
            Number,
            "median round trip of the profile over a long time",
        ),
        sometimes("rtt_asked_p90_ms", Number, "its 90th percentile"),
        sometimes(
            "rtt_due_ms",
            Number,
            "mean round trip of the link at the instants of the echoes",
        ),
        sometimes("rtt_due_p50_ms", Number, "their median"),
        sometimes("rtt_due_p90_ms", Number, "their 90th percentile"),
        sometimes(
            "rtt_measured_ms",
            Number,
            "mean round trip that the echoes measured",
        ),
        sometimes("rtt_measured_p50_ms", Number, "their median"),
        sometimes("rtt_measured_p90_ms", Number, "their 90th percentile"),
        sometimes(
            "stalled_asked",
            Number,
            "share of a long time in which the link is stalled, from 0 to 1; empty where it never is",
        ),
        sometimes(
            "stalled_due",
            Number,
            "share of the run in which the link was stalled, from 0 to 1",
        ),
        sometimes("probes", Integer, "echoes sent"),
        sometimes("probes_lost", Integer, "echoes lost"),
        always(
            "messages_due",
            Integer,
            "messages that the schedule asked for, one each h",
        ),
        sometimes("messages_sent", Integer, "messages that were sent"),
        sometimes("sent_share", Number, "sent of due, from 0 to 1"),
        sometimes("messages_answered", Integer, "messages that were answered"),
        sometimes(
            "messages_timeout",
            Integer,
            "messages without an answer in time",
        ),
        sometimes(
            "messages_failed",
            Integer,
            "messages whose connection or answer was broken",
        ),
        sometimes("messages_missed", Integer, "messages due and not sent"),
        sometimes(
            "message_rtt_p50_ms",
            Number,
            "median round trip of a message",
        ),
        sometimes("message_rtt_p90_ms", Number, "its 90th percentile"),
        sometimes("message_rtt_p99_ms", Number, "its 99th percentile"),
        sometimes("message_rtt_max_ms", Number, "the longest"),
        sometimes(
            "control_interval_avg_ms",
            Number,
            "mean interval between arrivals",
        ),
        sometimes(
            "control_interval_sd_ms",
            Number,
            "standard deviation of these intervals",
        ),
        sometimes(
            "control_interval_at_h",
            Number,
            "share of these intervals within a tenth of h",
        ),
        sometimes(
            "zero_exact",
            Number,
            "share of arrivals in the same ns as the one before",
        ),
        sometimes("zero_1ms", Number, "the same in ms"),
        sometimes("zero_10ms", Number, "the same in tens of ms"),
        sometimes("zero_tick", Number, "the same in ticks of the plant"),
        sometimes(
            "out_of_order",
            Integer,
            "messages that a later one had overtaken",
        ),
        sometimes(
            "schedule_slope",
            Number,
            "slope of the lateness over the schedule, s/s",
        ),
        sometimes("schedule_lag_s", Number, "lateness of the last arrival"),
        sometimes(
            "schedule_residual_p50_ms",
            Number,
            "median distance of the lateness from its line",
        ),
        sometimes("schedule_residual_max_ms", Number, "the greatest"),
        sometimes(
            "impulse_share",
            Number,
            "share of arrivals off that line, by more than five \
                   medians and 1 ms",
        ),
        sometimes("impulse_longest", Integer, "the most of them in a row"),
        sometimes("ticks", Integer, "the plant's ticks"),
        sometimes(
            "tick_interval_avg_ms",
            Number,
            "mean interval of the plant's ticks",
        ),
        sometimes("tick_interval_sd_ms", Number, "its standard deviation"),
        sometimes(
            "ticks_punctual",
            Number,
            "share of ticks within 0.1 ms of their deadline",
        ),
        sometimes(
            "tick_late_p99_ms",
            Number,
            "lateness of the ticks, 99th percentile",
        ),
        sometimes("ticks_missed", Integer, "ticks late by h or more"),
        sometimes("rise_ms", Number, "rise from 10 to 90 %"),
        sometimes(
            "settling_ms",
            Number,
            "settling into 2 %; empty if it did not settle",
        ),
        sometimes("overshoot_pct", Number, "overshoot, of the reference"),
        sometimes("peak", Number, "peak of the output"),
        sometimes(
            "final_value",
            Number,
            "mean of the output in the last fifth of the run",
        ),
        sometimes("iae_s", Number, "integral of the absolute error"),
        sometimes("torn_lines", Integer, "files whose last line was torn"),
    ]
}
