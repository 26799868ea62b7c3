//! What the echoes of a run say (`probes.csv`): the round trip that was measured, and the one that
//! the link had at the same instants.

use plan::{Phase, ProbeRow};
use serde::{Deserialize, Serialize};

use crate::statistics::{Moments, Quantiles, Spread, ms, ms_between};

/// Echoes through the link; those on the empty link only in `empty_p50_ms`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Probes {
    /// Echoes sent.
    pub count: u64,
    /// Echoes that did not come back.
    pub lost: u64,
    /// Round trips of those that did; `None` of none.
    pub rtt: Option<Spread>,
    /// Their quantiles.
    pub rtt_quantiles: Quantiles,
    /// Echoes that the link was to lose.
    pub due_lost: u64,
    /// What the link had for the others; `None` where it had no delay for any, as on loopback.
    pub due_rtt: Option<Spread>,
    /// Their quantiles; none likewise.
    pub due_quantiles: Quantiles,
    /// Median round trip of the empty link: what the machinery itself costs.
    pub empty_p50_ms: Option<f64>,
}

/// Probes under way.
#[derive(Debug, Default)]
pub(crate) struct ProbeCount {
    count: u64,
    rtt: Moments,
    rtt_ns: Vec<u64>,
    due_rtt: Moments,
    due_ns: Vec<u64>,
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
            self.rtt_ns.push(back_ns.saturating_sub(row.t_send_ns));
        }
        if !row.due_lost {
            self.due_rtt.push(ms(row.due_up_ns) + ms(row.due_down_ns));
            self.due_ns
                .push(row.due_up_ns.saturating_add(row.due_down_ns));
        }
    }

    pub(crate) fn finish(self) -> Probes {
        let due_rtt = self.due_rtt.spread().filter(|due| due.max_ms > 0.0);
        Probes {
            count: self.count,
            lost: self.count - self.rtt.count(),
            rtt: self.rtt.spread(),
            rtt_quantiles: Quantiles::of(self.rtt_ns),
            due_lost: self.count - self.due_rtt.count(),
            due_quantiles: match due_rtt {
                Some(_) => Quantiles::of(self.due_ns),
                None => Quantiles::default(),
            },
            due_rtt,
            empty_p50_ms: Quantiles::of(self.empty_ns).p50_ms,
        }
    }
}
