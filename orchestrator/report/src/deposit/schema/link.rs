//! What the players of a link leave.

use crate::deposit::field::Field;
use crate::deposit::field::Kind::{Integer, Number, String as Words};

use super::always;

/// A link's file where webloop plays.
#[must_use]
pub fn link() -> Vec<Field> {
    vec![
        always("t_ns", Integer, "end of the second, monotonic"),
        way(),
        always("packets", Integer, "IPv4 packets that entered"),
        always("bytes", Integer, "their length, IP headers included"),
        always("delivered", Integer, "packets that left at the other end"),
        always("lost", Integer, "packets that the link lost"),
        always(
            "overflow",
            Integer,
            "packets that found the link's queue full",
        ),
        always(
            "foreign",
            Integer,
            "frames that are not forwarded: no IPv4, or a stranger's",
        ),
        always(
            "dropped",
            Integer,
            "packets that the player itself lost, which it must not",
        ),
        always(
            "late_mean_us",
            Number,
            "mean lateness of the departures; 0 if there were none",
        ),
        always("late_max_us", Number, "greatest lateness of a departure"),
    ]
}

/// A link's file where tc plays.
#[must_use]
pub fn link_tc() -> Vec<Field> {
    vec![
        always("t_ns", Integer, "when the counters were read, monotonic"),
        way(),
        always(
            "delivered",
            Integer,
            "packets that left, ARP and the like included",
        ),
        always("bytes", Integer, "their length, without Ethernet headers"),
        always("lost", Integer, "packets that the link lost"),
        always(
            "overflow",
            Integer,
            "packets that may have found the link's queue full",
        ),
        always(
            "dropped",
            Integer,
            "packets that the player may have lost, which it must not",
        ),
        always(
            "queued",
            Integer,
            "packets in netem at the end of the second",
        ),
        always("changes", Integer, "changes of netem's setting"),
        always(
            "late_mean_us",
            Number,
            "mean lateness of these; 0 if there were none",
        ),
        always("late_max_us", Number, "greatest lateness of a change"),
    ]
}

fn way() -> Field {
    always("way", Words, "from controller to plant, or back").one_of(&["up", "down"])
}
