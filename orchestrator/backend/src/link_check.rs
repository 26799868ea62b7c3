//! Checks the link: which echoes are sent through it, their rows, and the certificate.
//!
//! The site sends the echoes, and the `certificate` crate judges them.

use std::net::Ipv4Addr;

use certificate::{Baseline, Certificate, Echo, Edge, Prediction, certify_within, predict};
use link::{Epoch, LinkTime, PacketRow, Profile, Timeline, Way};
use plan::{Phase, ProbeRow};
use shaper::ProbePlan;

use crate::schedule::Series;

/// How much later than predicted an echo may come back, ns: a machine that is busier than this could
/// not be judged anyway.
const GRACE_NS: u64 = 500_000_000;

/// For a link that has not been played yet: nothing is known about what entered it.
pub(crate) const NOTHING_ENTERED: [Option<Vec<PacketRow>>; 2] = [None, None];

/// A link under test.
#[derive(Clone, Copy)]
pub(crate) struct LinkCheck<'a> {
    /// The plant's address.
    pub(crate) target: Ipv4Addr,
    pub(crate) profile: &'a Profile,
    pub(crate) seed: u64,
    pub(crate) epoch: Epoch,
    /// The link time from which on the link is in force.
    pub(crate) opens: LinkTime,
    /// The packets that entered each way, if the link has a rate limit and they are known.
    pub(crate) entered: &'a [Option<Vec<PacketRow>>; 2],
}

impl LinkCheck<'_> {
    /// The request to the prober for a series.
    pub(crate) fn plan(&self, series: Series) -> ProbePlan {
        let mut plan = ProbePlan {
            target: self.target,
            start_ns: series.start_ns,
            interval_ns: series.interval_ns,
            count: series.count,
            seed: Some(self.seed),
            lost: Vec::new(),
            back_ns: 0,
            grace_ns: GRACE_NS,
            id: series.phase as u16,
        };
        let mut timeline = self.timeline();
        for seq in 0..series.count {
            let sent_ns = plan.due_ns(series.start_ns, seq);
            let up = timeline.state_at(Way::Up, sent_ns);
            let down = timeline.state_at(Way::Down, sent_ns + up.delay_ns);
            let back_ns = sent_ns + up.delay_ns + down.delay_ns;
            plan.back_ns = plan.back_ns.max(back_ns - series.start_ns);
            // Behind a rate limit nobody knows which packets a full queue drops.
            if (up.lost || down.lost) && !self.profile.has_rate() {
                plan.lost.push(seq);
            }
        }
        plan
    }

    /// Cost of crossing the player itself; `None` if no echo came back.
    pub(crate) fn baseline(&self, empty: &[Echo]) -> Option<Baseline> {
        if self.profile.is_loopback() {
            return Some(Baseline::default());
        }
        Baseline::of(empty)
    }

    /// Compares all echoes after the epoch with the link, as exactly as its player keeps to its times.
    pub(crate) fn certificate(
        &self,
        echoes: &[Echo],
        baseline: Baseline,
        edge: Edge,
    ) -> Certificate {
        certify_within(echoes, self.timeline(), baseline, edge)
    }

    /// The echoes in order of sending, without those whose answer was due after listening had ended. If
    /// a queue grows over the run, nobody knows in advance how long to listen.
    pub(crate) fn heard(&self, echoes: Vec<Echo>) -> Vec<Echo> {
        if !self.profile.has_rate() {
            return echoes;
        }
        let predictions = predict(&echoes, &mut self.timeline());
        let is_heard = |(echo, due): &(Echo, Prediction)| {
            let due_ns = due.up.delay_ns.saturating_add(due.down.delay_ns);
            echo.t_back_ns.is_some() || due_ns <= GRACE_NS
        };
        let each = echoes.into_iter().zip(predictions);
        each.filter(is_heard).map(|(echo, _)| echo).collect()
    }

    /// The rows of a series, each with its prediction.
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

    /// The link that was asked for.
    pub(crate) fn timeline(&self) -> Timeline {
        let timeline = Timeline::new(self.profile, self.seed, self.epoch).opening(self.opens);
        let ways = [Way::Up, Way::Down].into_iter().zip(self.entered);
        ways.fold(timeline, |timeline, (way, entered)| match entered {
            Some(packets) => {
                let packets = packets.iter().map(|packet| (packet.t_ns, packet.bytes));
                timeline.with_load(way, packets)
            }
            None => timeline,
        })
    }
}
