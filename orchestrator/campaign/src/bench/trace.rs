//! Records a run as it goes: the data for its figures, in memory that is reused.

use std::ops::Range;

use analysis::sweep::{Figures, growth, is_stable};
use control::{StepSettings, sampled_step_info};
use endpoint::{MessageRow, TickRow};
use sim::Record;

const NS_PER_MS: f64 = 1e6;

/// Records what the figures of a step response need.
///
/// A response has the ticks that are due from the first deadline to the planned end, whatever arrived, as in
/// `analysis`.
#[derive(Debug, Default)]
pub(super) struct Trace {
    h_s: f64,
    r: f64,
    rho: f64,
    /// The first deadline and the planned end, ns.
    run_ns: Range<u64>,
    y: Vec<f64>,
    sums: Sums,
    rtt_ns: Vec<u64>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    iae: f64,
    cost: f64,
}

impl Trace {
    /// Starts a new recording: a response to `r` sampled at `h_s`, of the ticks in `run_ns`.
    pub(super) fn begin(&mut self, h_s: f64, r: f64, rho: f64, run_ns: Range<u64>) {
        let (mut y, mut rtt_ns) = (
            std::mem::take(&mut self.y),
            std::mem::take(&mut self.rtt_ns),
        );
        y.clear();
        rtt_ns.clear();
        *self = Trace {
            h_s,
            r,
            rho,
            run_ns,
            y,
            rtt_ns,
            ..Trace::default()
        };
    }

    /// The figures of the recorded run.
    pub(super) fn figures(&mut self, counts: endpoint::Counts) -> Figures {
        let y = self.y.as_slice();
        let to_r = StepSettings {
            final_value: Some(self.r),
            ..StepSettings::default()
        };
        let info = sampled_step_info(self.h_s * 1e3, y, &to_r).ok();
        let figure = |x: Option<f64>| x.filter(|x| x.is_finite());
        let there = |x: f64| figure((!y.is_empty()).then_some(x));
        let rtt_ns = self.rtt_ns.as_mut_slice();
        let mut rtt_ms = |share: f64| {
            let last = rtt_ns.len().checked_sub(1)?;
            let at = (share * last as f64).round() as usize;
            // Sorting all of them took an eighth of a run.
            Some(*rtt_ns.select_nth_unstable(at).1 as f64 / NS_PER_MS)
        };
        Figures {
            stable: is_stable(y, self.r),
            growth: figure(growth(y, self.r)),
            settling_ms: figure(info.map(|info| info.settling_time)),
            rise_ms: figure(info.map(|info| info.rise_time)),
            overshoot_pct: figure(info.map(|info| info.overshoot)),
            iae_s: there(self.sums.iae),
            cost_s: there(self.sums.cost),
            sent_pct: figure(Some(100.0 * counts.sent as f64 / counts.due as f64)),
            rtt_median_ms: rtt_ms(0.5),
            rtt_p95_ms: rtt_ms(0.95),
            rtt_max_ms: rtt_ms(1.0),
        }
    }
}

impl Record for Trace {
    fn tick(&mut self, row: &TickRow) {
        if !self.run_ns.contains(&row.t_due_ns) {
            return;
        }
        let e = self.r - row.y;
        self.y.push(row.y);
        self.sums.iae += e.abs() * self.h_s;
        self.sums.cost += (e * e + self.rho * row.u * row.u) * self.h_s;
    }

    fn message(&mut self, row: &MessageRow) {
        if let (Some(send_ns), Some(receive_ns)) = (row.t_send_ns, row.t_receive_ns) {
            self.rtt_ns.push(receive_ns.saturating_sub(send_ns));
        }
    }
}
