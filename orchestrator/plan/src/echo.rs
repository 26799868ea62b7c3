//! The row of an echo, which shows how the link was: back-ends write it to `probes.csv`, and the
//! analysis reads it.
//!
//! It is defined here because those two do not depend on each other.

text::row!(
    /// One echo through the link. Times are monotonic; a time is empty if the echo did not get there.
    #[derive(Eq)]
    ProbeRow {
        /// When in the run it was sent: on the empty link, before the loop, during it, after it.
        phase: Phase,
        /// Number of the echo in its phase, from 0.
        seq: u32,
        /// When it was sent, monotonic.
        t_send_ns: u64,
        /// When it reached the plant's end.
        t_reach_ns: Option<u64>,
        /// When it was back; empty if it was lost.
        t_back_ns: Option<u64>,
        /// Delay that the link had for it towards the plant.
        due_up_ns: u64,
        /// Delay that the link had for it towards the controller.
        due_down_ns: u64,
        /// Whether the link was to lose it.
        due_lost: bool,
    }
);

text::choice!(
    /// When in a run an echo was sent.
    Phase, "phase", {
        /// On the empty link, before link time 0.
        Empty = "empty",
        /// Before the controller's first message.
        Before = "before",
        /// While the controller sends.
        During = "during",
        /// After it ended.
        After = "after",
    }
);
