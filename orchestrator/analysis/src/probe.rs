//! Metrics of a run's echoes (`probes.csv`): the measured round trip, and the one that the link had
//! at the same instants.

use plan::{Phase, ProbeRow};
use serde::{Deserialize, Serialize};

use crate::statistics::{Moments, Quantiles, Spread, ms, ms_between};

/// Echoes through the link. Those on the empty link count only in `empty_p50_ms`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Probes {
    /// Echoes sent.
    pub count: u64,
    /// Echoes that did not come back.
    pub lost: u64,
    /// Round trips of the echoes that came back; `None` if none did.
    pub rtt: Option<Spread>,
    /// Quantiles of these round trips.
    pub rtt_quantiles: Quantiles,
    /// Echoes that the link was predicted to lose.
    pub due_lost: u64,
    /// Round trips that the link had for the other echoes; `None` if it delayed none, as on loopback.
    pub due_rtt: Option<Spread>,
    /// Quantiles of these round trips; all `None` if `due_rtt` is `None`.
    pub due_quantiles: Quantiles,
    /// Median round trip on the empty link, ms: what the machinery itself costs.
    pub empty_p50_ms: Option<f64>,
}

/// Accumulates [`Probes`] row by row.
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
