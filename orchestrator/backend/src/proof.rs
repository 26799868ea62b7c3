//! The link proves itself: which echoes are sent through it, their rows, and the certificate.
//!
//! Sending them is the site's business, and judging one the shaper's.

use std::net::Ipv4Addr;

use link::{Profile, Way};
use plan::{Phase, ProbeRow};
use shaper::{Baseline, Certificate, Echo, Edge, ProbePlan, Timeline, certify_within, predict};

use crate::schedule::Series;

/// How long an echo may come later than its link says: a machine that is busy beyond this
/// could not be judged anyway.
const GRACE_NS: u64 = 500_000_000;

/// A link under test.
#[derive(Clone, Copy)]
pub(crate) struct Proof<'a> {
    /// The plant's address.
    pub(crate) target: Ipv4Addr,
    pub(crate) profile: &'a Profile,
    pub(crate) seed: u64,
    pub(crate) epoch_ns: u64,
}

impl Proof<'_> {
    /// What the prober is asked for a series.
    pub(crate) fn plan(&self, series: Series) -> ProbePlan {
        ProbePlan {
            target: self.target,
            start_ns: series.start_ns,
            interval_ns: series.interval_ns,
            count: series.count,
            grace_ns: self.longest_ns(series).saturating_add(GRACE_NS),
            id: series.phase as u16,
        }
    }

    /// The longest round trip that the link has for the last echoes of a series: there is no
    /// use in waiting longer for one that was lost.
    fn longest_ns(&self, series: Series) -> u64 {
        /// A stall that began before the last echo may hold it; no need to look back further.
        const LOOK_BACK: u32 = 1_000;
        if self.profile.is_loopback() {
            return 0;
        }
        let mut timeline = self.timeline();
        let first = series.count.saturating_sub(LOOK_BACK);
        (first..series.count)
            .map(|seq| {
                let sent_ns = series.start_ns + u64::from(seq) * series.interval_ns;
                let up_ns = timeline.state_at(Way::Up, sent_ns).delay_ns;
                up_ns + timeline.state_at(Way::Down, sent_ns + up_ns).delay_ns
            })
            .max()
            .unwrap_or(0)
    }

    /// What the crossing of the player itself costs; `None` if no echo came back.
    pub(crate) fn baseline(&self, empty: &[Echo]) -> Option<Baseline> {
        if self.profile.is_loopback() {
            return Some(Baseline::default());
        }
        Baseline::of(empty)
    }

    /// Holds all echoes after the epoch against the link, as exactly as its player keeps to its
    /// times; `None` on loopback, where there is no link to judge.
    pub(crate) fn certificate(
        &self,
        echoes: &[Echo],
        baseline: Baseline,
        edge: Edge,
    ) -> Option<Certificate> {
        (!self.profile.is_loopback())
            .then(|| certify_within(echoes, self.timeline(), baseline, edge))
    }

    /// The rows of a series, each beside its prediction.
    pub(crate) fn rows(&self, phase: Phase, echoes: &[Echo]) -> Vec<ProbeRow> {
        let row = |echo: &Echo, (due_up_ns, due_down_ns, due_lost)| ProbeRow {
            phase,
            seq: echo.seq,
            t_send_ns: echo.t_send_ns,
            t_reach_ns: echo.t_reach_ns,
            t_back_ns: echo.t_back_ns,
            due_up_ns,
            due_down_ns,
            due_lost,
        };
        if self.profile.is_loopback() {
            return echoes.iter().map(|echo| row(echo, (0, 0, false))).collect();
        }
        predict(echoes, &mut self.timeline())
            .iter()
            .zip(echoes)
            .map(|(due, echo)| {
                row(
                    echo,
                    (due.up.delay_ns, due.down.delay_ns, due.rtt_ns().is_none()),
                )
            })
            .collect()
    }

    fn timeline(&self) -> Timeline {
        Timeline::new(self.profile, self.seed, self.epoch_ns)
    }
}
