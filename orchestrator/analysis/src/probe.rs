//! What the echoes of a run say (`probes.csv`): the round trip that was measured, and the one that
//! the link had at the same instants.

use serde::{Deserialize, Serialize};

use crate::statistics::{Moments, Quantiles, Spread, ms, ms_between};

/// One echo, as the back-end writes it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ProbeRow {
    /// When in the run it was sent.
    pub phase: Phase,
    /// Its number in its phase, from 0.
    pub seq: u32,
    /// When it was sent.
    pub t_send_ns: u64,
    /// When it reached the plant.
    pub t_reach_ns: Option<u64>,
    /// When it was back; empty if it was lost.
    pub t_back_ns: Option<u64>,
    /// The delay that the link had for it on the way up.
    pub due_up_ns: u64,
    /// The delay that the link had for it on the way down.
    pub due_down_ns: u64,
    /// Whether the link was to lose it.
    pub due_lost: bool,
}

/// When in a run an echo was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// On the empty link, before link time 0.
    Empty,
    /// Before the controller's first message.
    Before,
    /// While the controller sends.
    During,
    /// After it ended.
    After,
}

impl ProbeRow {
    /// The columns of `probes.csv`, in order.
    pub const COLUMNS: &[&str] = &[
        "phase",
        "seq",
        "t_send_ns",
        "t_reach_ns",
        "t_back_ns",
        "due_up_ns",
        "due_down_ns",
        "due_lost",
    ];
}

/// Echoes through the link; those on the empty link only in `empty_p50_ms`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Probes {
    /// Echoes sent.
    pub count: u64,
    /// Echoes that did not come back.
    pub lost: u64,
    /// Round trips of those that did; `None` of none.
    pub rtt: Option<Spread>,
    /// Echoes that the link was to lose.
    pub due_lost: u64,
    /// What the link had for the others; `None` where it had no delay for any, as on loopback.
    pub due_rtt: Option<Spread>,
    /// Median round trip of the empty link: what the machinery itself costs.
    pub empty_p50_ms: Option<f64>,
}

/// Probes under way.
#[derive(Debug, Default)]
pub(crate) struct ProbeCount {
    count: u64,
    rtt: Moments,
    due_rtt: Moments,
    empty_ns: Vec<u64>,
}

impl ProbeCount {
    pub(crate) fn push(&mut self, row: &ProbeRow) {
        if row.phase == Phase::Empty {
            self.empty_ns
                .extend(row.t_back_ns.map(|back| back.saturating_sub(row.t_send_ns)));
            return;
        }
        self.count += 1;
        if let Some(back_ns) = row.t_back_ns {
            self.rtt.push(ms_between(row.t_send_ns, back_ns));
        }
        if !row.due_lost {
            self.due_rtt.push(ms(row.due_up_ns) + ms(row.due_down_ns));
        }
    }

    pub(crate) fn finish(self) -> Probes {
        Probes {
            count: self.count,
            lost: self.count - self.rtt.count(),
            rtt: self.rtt.spread(),
            due_lost: self.count - self.due_rtt.count(),
            due_rtt: self.due_rtt.spread().filter(|due| due.max_ms > 0.0),
            empty_p50_ms: Quantiles::of(self.empty_ns).p50_ms,
        }
    }
}
