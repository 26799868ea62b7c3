//! Checks the link: which echoes are sent through it, their rows, and the certificate.
//!
//! The site sends the echoes, and the `certificate` crate judges them.

use std::net::Ipv4Addr;
use std::sync::atomic::AtomicBool;

use link::certificate::{
    Baseline, Certificate, Echo, Edge, Prediction, certify_within, predict, predict_within,
};
use link::{Epoch, LinkTime, PacketRow, Profile, Timeline, Way};
use plan::{Cell, Phase, ProbeRow};
use shaper::ProbePlan;

use crate::error::RunError;
use crate::schedule::Series;
use crate::site::Site;

/// How much later than predicted an echo may come back, ns: a machine that is busier than this could
/// not be judged anyway.
const GRACE_NS: u64 = 500_000_000;

/// How much later than planned an echo may be sent. If its fate changes within this time, nobody knows it beforehand.
const LATE_NS: u64 = 5_000_000;

/// How much later than predicted an echo may come that may as well be lost, ns: if it is lost, as it often is, the run
/// does not wait for it any longer.
const DOUBT_NS: u64 = 2_000_000;

/// How long it was listened after an echo was due whose absence counts, ns.
const LISTENED_NS: u64 = 20_000_000;

/// For a link that has not been played yet: nothing is known about what entered it.
pub(crate) const NOTHING_ENTERED: [Option<Vec<PacketRow>>; 2] = [None, None];

/// A series of echoes that was sent.
#[derive(Debug)]
pub(crate) struct Sent {
    pub(crate) phase: Phase,
    pub(crate) echoes: Vec<Echo>,
    /// Until when each was waited for at least, monotonic.
    pub(crate) until_ns: Vec<u64>,
}

impl Sent {
    /// Sends the echoes of a plan.
    pub(crate) fn send(
        site: &dyn Site,
        phase: Phase,
        plan: &ProbePlan,
        stop: &AtomicBool,
    ) -> Result<Sent, RunError> {
        let until_ns = plan.until_ns.iter();
        Ok(Sent {
            phase,
            echoes: site.echoes(plan, stop)?,
            until_ns: until_ns
                .map(|ns| plan.start_ns.saturating_add(*ns))
                .collect(),
        })
    }
}

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
    /// The link time after which nothing that is asked about is of this run.
    pub(crate) closes: LinkTime,
    /// The packets that entered each way, if the link has a rate limit and they are known.
    pub(crate) entered: &'a [Option<Vec<PacketRow>>; 2],
}

impl<'a> LinkCheck<'a> {
    /// The link of a cell, with the plant on this machine, while nothing is known of what entered it.
    pub(crate) fn of(cell: &Cell, profile: &'a Profile, epoch: Epoch, opens: LinkTime) -> Self {
        LinkCheck {
            target: Ipv4Addr::LOCALHOST,
            profile,
            seed: cell.link_seed,
            epoch,
            opens,
            closes: cell.closes_at(),
            entered: &NOTHING_ENTERED,
        }
    }

    /// The request to the prober for a series.
    pub(crate) fn plan(&self, series: Series) -> ProbePlan {
        let mut plan = ProbePlan {
            target: self.target,
            start_ns: series.start_ns,
            interval_ns: series.interval_ns,
            seed: Some(self.seed),
            until_ns: Vec::new(),
            id: series.phase as u16,
        };
        let sent_ns = |seq| plan.due_ns(series.start_ns, seq);
        let echoes: Vec<Echo> = (0..series.count)
            .map(|seq| Echo {
                seq,
                t_send_ns: sent_ns(seq),
                t_reach_ns: None,
                t_back_ns: None,
            })
            .collect();
        let late = Edge {
            after_ns: LATE_NS,
            ..Edge::USER
        };
        let until_ns = |(echo, Prediction { up, down }): (&Echo, Prediction)| {
            let due_ns = up.delay_ns.saturating_add(down.delay_ns);
            let may_be_lost = [&up, &down].iter().any(|way| way.lost || way.either_fate);
            // Behind a rate limit nobody knows which packets a full queue drops.
            let is_doubtful = may_be_lost && !self.profile.has_rate();
            let more_ns = if is_doubtful { DOUBT_NS } else { GRACE_NS };
            (echo.t_send_ns - series.start_ns)
                .saturating_add(due_ns)
                .saturating_add(more_ns)
        };
        let predictions = predict_within(&echoes, &mut self.timeline(), late);
        plan.until_ns = echoes.iter().zip(predictions).map(until_ns).collect();
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

    /// The echoes of a series without those whose absence says nothing: nobody is known to have listened for long
    /// enough after they were due. Such an echo met the link just before or after a change, or waits in a queue that
    /// grows.
    pub(crate) fn heard(&self, sent: &Sent) -> Vec<Echo> {
        let times = |echo: &Echo| [Some(echo.t_send_ns), echo.t_reach_ns, echo.t_back_ns];
        let last_ns = sent.echoes.iter().flat_map(times).flatten().max();
        let is_heard = |(echo, due): &(&Echo, Prediction)| {
            let [up, down] = [&due.up, &due.down];
            let due_ns = up.delay_ns.saturating_add(down.delay_ns);
            if echo.t_back_ns.is_some() || self.profile.has_rate() {
                return echo.t_back_ns.is_some() || due_ns <= GRACE_NS;
            }
            // One that reached the plant has crossed the way up, whatever was likely.
            let (missing, back_ns) = match echo.t_reach_ns {
                Some(reach_ns) => (down, reach_ns.saturating_add(down.delay_ns)),
                None => (up, echo.t_send_ns.saturating_add(due_ns)),
            };
            let may_be_lost = missing.lost || missing.either_fate;
            let until_ns = sent.until_ns.get(echo.seq as usize).copied().max(last_ns);
            may_be_lost || until_ns >= Some(back_ns.saturating_add(LISTENED_NS))
        };
        let predictions = predict(&sent.echoes, &mut self.timeline());
        let each = sent.echoes.iter().zip(predictions);
        each.filter(is_heard).map(|(echo, _)| *echo).collect()
    }

    /// The rows of a series, each with its prediction.
    pub(crate) fn rows(&self, phase: Phase, echoes: &[Echo]) -> Vec<ProbeRow> {
        let row = |(echo, due): (&Echo, Prediction)| ProbeRow {
            phase,
            seq: echo.seq,
            t_send_ns: echo.t_send_ns,
            t_reach_ns: echo.t_reach_ns,
            t_back_ns: echo.t_back_ns,
            due_up_ns: due.up.delay_ns,
            due_down_ns: due.down.delay_ns,
            due_lost: due.rtt_ns().is_none(),
        };
        let predictions = predict(echoes, &mut self.timeline());
        echoes.iter().zip(predictions).map(row).collect()
    }

    /// The link that was asked for.
    pub(crate) fn timeline(&self) -> Timeline {
        let timeline = Timeline::new(self.profile, self.seed, self.epoch)
            .opening(self.opens)
            .closing(self.closes);
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

#[cfg(test)]
mod tests;
