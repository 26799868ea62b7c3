//! What is known of a link in a run, echo by echo: what a back-end leaves in `probes.csv` and the
//! analysis reads.
//!
//! It lives here because those two do not know each other.

endpoint::row!(
    /// One echo through the link. Times are monotonic; an empty one did not come.
    #[derive(Eq)]
    ProbeRow {
        /// When in the run it was sent.
        phase: Phase,
        /// Its number in its phase, from 0.
        seq: u32,
        /// When it was sent.
        t_send_ns: u64,
        /// When it reached the plant.
        t_reach_ns: Option<u64>,
        /// When it was back; empty if it was lost.
        t_back_ns: Option<u64>,
        /// The delay that the link had for it on the way up.
        due_up_ns: u64,
        /// The delay that the link had for it on the way down.
        due_down_ns: u64,
        /// Whether the link was to lose it.
        due_lost: bool,
    }
);

endpoint::choice!(
    /// When in a run an echo was sent.
    Phase, "phase", "empty, before, during or after", {
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
