//! A cell as one row: of `summary.csv`, and of the table.

use std::time::Duration;

use endpoint::{Mode, Transport};
use link::{Profile, Typical};
use plan::{Cell, Client, Condition, Disturbance, START_AT, Setup, Verdict};
use record::Manifest;
use record::whole::VIRTUAL;
use serde::{Deserialize, Serialize};

use crate::layout;
use crate::metrics::Metrics;
use crate::recovery::Recovery;
use crate::statistics::{Quantiles, ms, share};
use crate::verdict::LoopVerdict;

/// What is known about a cell's link without a run; all `None` on loopback.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LinkFacts {
    /// Mean round trip that the profile asks for, ms.
    pub rtt_avg_ms: Option<f64>,
    /// Quantiles of the round trip over a long time.
    pub typical: Option<Typical>,
    /// Share of time, over a long time, in which the link is stalled; `None` if it never is.
    pub stalled: Option<f64>,
    /// Share of the run in which it is stalled; `None` if it never is.
    pub stalled_in_run: Option<f64>,
}

impl LinkFacts {
    /// The facts of the profile, without those of a run.
    #[must_use]
    pub fn of(profile: &Profile) -> LinkFacts {
        if profile.is_loopback() {
            return LinkFacts::default();
        }
        LinkFacts {
            rtt_avg_ms: profile.asked().map(|asked| asked.rtt_avg_ms),
            typical: link::typical(profile),
            stalled: profile.stalled_by_law(),
            stalled_in_run: None,
        }
    }

    /// Adds how long the link is stalled while the cell is measured.
    #[must_use]
    pub fn in_run(self, profile: &Profile, cell: &Cell) -> LinkFacts {
        let end = START_AT.after(cell.duration_ns);
        LinkFacts {
            stalled_in_run: profile.stalled(cell.link_seed, START_AT, end),
            ..self
        }
    }
}

text::table!(
    /// One cell of a campaign. Names end in the unit, shares are from 0 to 1, and an empty field does not
    /// apply or was not measured.
    #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
    Summary {
        /// The cell's id, the name of its folder.
        cell: String,
        /// The link's profile.
        topology: String,
        /// The program that closes the loop.
        client: Client,
        /// The client's preset, and what the experiment laid over it.
        setup: Setup,
        /// How messages are carried.
        transport: Transport,
        /// Least delay that the page gave its timers; empty where the client is no page.
        timer_floor_ms: Option<f64>,
        /// Whether the plant answers with its state, or only acknowledges.
        mode: Mode,
        /// The rate in people's words, such as 333 Hz.
        rate: String,
        /// The sample time of plant and controller.
        h_ns: u64,
        /// Which repeat it is, from 1.
        repeat: u32,
        /// How it was run: netns, compose, attach, or sim, which is in virtual time; empty if it has not been run.
        backend: Option<String>,
        /// How the run ended; empty if it has not been run.
        verdict: Option<Verdict>,
        /// What disturbed the run from outside, the longest first; empty if nothing did.
        ///
        /// The worst disturbance, and the number of others.
        disturbed: Option<String>,
        /// What became of the loop, in closed loop.
        loop_verdict: Option<LoopVerdict>,
        /// Why the loop does not just hold; empty if it does.
        loop_reason: Option<String>,
        /// The profile's mean round trip over a long time, as it says itself.
        rtt_asked_ms: Option<f64>,
        /// Median round trip of the profile over a long time.
        rtt_asked_p50_ms: Option<f64>,
        /// Its 90th percentile.
        rtt_asked_p90_ms: Option<f64>,
        /// Mean round trip of the link at the instants of the echoes.
        rtt_due_ms: Option<f64>,
        /// Their median.
        rtt_due_p50_ms: Option<f64>,
        /// Their 90th percentile.
        rtt_due_p90_ms: Option<f64>,
        /// Mean round trip that the echoes measured.
        rtt_measured_ms: Option<f64>,
        /// Their median.
        rtt_measured_p50_ms: Option<f64>,
        /// Their 90th percentile.
        rtt_measured_p90_ms: Option<f64>,
        /// Share of a long time in which the link is stalled, from 0 to 1; empty where it never is.
        stalled_asked: Option<f64>,
        /// Share of the run in which the link was stalled, from 0 to 1.
        ///
        /// From the first due message on.
        stalled_due: Option<f64>,
        /// Echoes sent.
        probes: Option<u64>,
        /// Echoes lost.
        probes_lost: Option<u64>,
        /// Messages that the schedule asked for, one each h.
        ///
        /// A client that drifts sends fewer.
        messages_due: u64,
        /// Messages that were sent.
        messages_sent: Option<u64>,
        /// Sent of due, from 0 to 1.
        sent_share: Option<f64>,
        /// Messages that were answered.
        ///
        /// All others that were sent and whose fate is known are later than the time-out in each quantile of the round
        /// trips.
        messages_answered: Option<u64>,
        /// Messages without an answer in time.
        messages_timeout: Option<u64>,
        /// Messages whose connection or answer was broken.
        messages_failed: Option<u64>,
        /// Messages due and not sent.
        ///
        /// Deadlines without a message, and those that a drifting client never reached.
        messages_missed: Option<u64>,
        /// Median round trip of a message; empty if it falls among those without an answer, as the next three.
        message_rtt_p50_ms: Option<f64>,
        /// Its 90th percentile.
        message_rtt_p90_ms: Option<f64>,
        /// Its 99th percentile.
        message_rtt_p99_ms: Option<f64>,
        /// The longest.
        ///
        /// Empty if one had no answer.
        message_rtt_max_ms: Option<f64>,
        /// Mean interval between arrivals.
        control_interval_avg_ms: Option<f64>,
        /// Standard deviation of these intervals.
        control_interval_sd_ms: Option<f64>,
        /// Share of these intervals within a tenth of h.
        control_interval_at_h: Option<f64>,
        /// Share of arrivals in the same ns as the one before.
        zero_exact: Option<f64>,
        /// The same in ms.
        zero_1ms: Option<f64>,
        /// The same in tens of ms.
        zero_10ms: Option<f64>,
        /// The same in ticks of the plant.
        zero_tick: Option<f64>,
        /// Messages that a later one had overtaken.
        ///
        /// They arrived after one with a higher `seq`.
        out_of_order: Option<u64>,
        /// Slope of the lateness over the schedule, s/s.
        schedule_slope: Option<f64>,
        /// Lateness of the last arrival.
        schedule_lag_s: Option<f64>,
        /// Median distance of the lateness from its line.
        schedule_residual_p50_ms: Option<f64>,
        /// The greatest.
        schedule_residual_max_ms: Option<f64>,
        /// Share of arrivals off that line, by more than five medians and 1 ms.
        impulse_share: Option<f64>,
        /// The most of them in a row.
        impulse_longest: Option<u64>,
        /// The plant's ticks.
        ticks: Option<u64>,
        /// Mean interval of the plant's ticks.
        tick_interval_avg_ms: Option<f64>,
        /// Its standard deviation.
        tick_interval_sd_ms: Option<f64>,
        /// Share of ticks within 0.1 ms of their deadline.
        ticks_punctual: Option<f64>,
        /// Lateness of the ticks, 99th percentile.
        tick_late_p99_ms: Option<f64>,
        /// Ticks late by h or more.
        ticks_missed: Option<u64>,
        /// Rise from 10 to 90 %.
        rise_ms: Option<f64>,
        /// From the step until the output stays in its band; empty if it did not settle.
        settling_ms: Option<f64>,
        /// Overshoot, of the step.
        overshoot_pct: Option<f64>,
        /// The greatest error once the output has come within its band, in its units.
        excursion: Option<f64>,
        /// Half the width of the band, in units of the output; empty if nothing gives its scale.
        band: Option<f64>,
        /// Peak of the output.
        peak: Option<f64>,
        /// Mean of the output in the last fifth of the run.
        final_value: Option<f64>,
        /// Integral of the absolute error.
        iae_s: Option<f64>,
        /// Integral of the squared error.
        ///
        /// It is the quadratic cost.
        ise_s: Option<f64>,
        /// Files whose last line was torn.
        torn_lines: Option<u64>,
        /// The fault that the run met.
        ///
        /// Empty without one.
        fault: Option<String>,
        /// The greatest error from the fault's beginning until the loop was back.
        fault_worst: Option<f64>,
        /// From the last command to the plant's safe state.
        fault_safe_ms: Option<f64>,
        /// From the fault's end until the error stays within 2 % of the reference's range.
        ///
        /// Empty if it did not come back.
        fault_back_ms: Option<f64>,
    } beside {
        /// Its system. No column names it: `setup` does, if it is not the paper's.
        #[serde(skip)]
        system: String,
        /// How long its controller sends, ns. `messages_due` and `h_ns` say the same in the CSV.
        #[serde(skip)]
        duration_ns: u64,
    }
);

impl Summary {
    /// Builds the row from a cell, its run's manifest, the facts of its link, and its metrics.
    #[must_use]
    pub fn new(
        cell: &Cell,
        manifest: Option<&Manifest>,
        asked: LinkFacts,
        metrics: Option<&Metrics>,
    ) -> Self {
        let known = Self {
            cell: cell.id.clone(),
            topology: cell.topology.clone(),
            system: cell.system.clone(),
            duration_ns: cell.duration_ns,
            client: cell.client,
            setup: cell.setup(),
            transport: cell.settings.transport,
            timer_floor_ms: cell.page.map(|page| ms(page.floor_ns)),
            mode: cell.settings.mode,
            rate: cell.rate(),
            h_ns: cell.settings.h.ns(),
            repeat: cell.repeat,
            backend: manifest.map(|manifest| manifest.backend.clone()),
            verdict: manifest.map(|manifest| manifest.verdict),
            disturbed: manifest.and_then(disturbed),
            rtt_asked_ms: asked.rtt_avg_ms,
            rtt_asked_p50_ms: asked.typical.map(|typical| typical.p50_ms),
            rtt_asked_p90_ms: asked.typical.map(|typical| typical.p90_ms),
            stalled_asked: asked.stalled,
            stalled_due: asked.stalled_in_run,
            messages_due: cell.due(),
            ..Self::default()
        };
        metrics.map_or(known.clone(), |metrics| known.measured(metrics))
    }

    /// What run it is, whatever its link and its repeat.
    #[must_use]
    pub fn condition(&self) -> Condition<'_> {
        Condition {
            client: self.client,
            setup: &self.setup,
            mode: self.mode,
            h: Duration::from_nanos(self.h_ns),
        }
    }

    fn measured(self, metrics: &Metrics) -> Self {
        let Metrics {
            probes,
            messages,
            arrivals,
            ticks,
            response,
            torn_lines,
        } = metrics;
        Self {
            loop_verdict: response.map(|r| r.verdict),
            loop_reason: response
                .and_then(|r| r.reason)
                .map(|reason| reason.to_string()),
            rtt_due_ms: probes.and_then(|p| p.due_rtt).map(|rtt| rtt.avg_ms),
            rtt_due_p50_ms: probes.and_then(|p| p.due_quantiles.p50_ms),
            rtt_due_p90_ms: probes.and_then(|p| p.due_quantiles.p90_ms),
            rtt_measured_ms: probes.and_then(|p| p.rtt).map(|rtt| rtt.avg_ms),
            rtt_measured_p50_ms: probes.and_then(|p| p.rtt_quantiles.p50_ms),
            rtt_measured_p90_ms: probes.and_then(|p| p.rtt_quantiles.p90_ms),
            probes: probes.map(|p| p.count),
            probes_lost: probes.map(|p| p.lost),
            messages_sent: Some(messages.sent),
            sent_share: share(messages.sent, self.messages_due),
            messages_answered: Some(messages.answered),
            messages_timeout: Some(messages.timeout),
            messages_failed: Some(messages.failed),
            messages_missed: Some(self.messages_due.saturating_sub(messages.sent)),
            message_rtt_p50_ms: messages.rtt.p50_ms,
            message_rtt_p90_ms: messages.rtt.p90_ms,
            message_rtt_p99_ms: messages.rtt.p99_ms,
            message_rtt_max_ms: messages.rtt.max_ms,
            control_interval_avg_ms: arrivals.interval_avg_ms,
            control_interval_sd_ms: arrivals.interval_sd_ms,
            control_interval_at_h: arrivals.interval_at_h,
            zero_exact: arrivals.zero_exact,
            zero_1ms: arrivals.zero_1ms,
            zero_10ms: arrivals.zero_10ms,
            zero_tick: arrivals.zero_tick,
            out_of_order: Some(arrivals.out_of_order),
            schedule_slope: arrivals.drift.slope,
            schedule_lag_s: arrivals.drift.lag_s,
            schedule_residual_p50_ms: arrivals.drift.residual_p50_ms,
            schedule_residual_max_ms: arrivals.drift.residual_max_ms,
            impulse_share: arrivals.drift.impulse_share,
            impulse_longest: arrivals.drift.impulse_longest,
            ticks: Some(ticks.count),
            tick_interval_avg_ms: ticks.interval_avg_ms,
            tick_interval_sd_ms: ticks.interval_sd_ms,
            ticks_punctual: ticks.punctual,
            tick_late_p99_ms: ticks.late_p99_ms,
            ticks_missed: Some(ticks.missed),
            rise_ms: response.and_then(|r| r.rise_ms),
            settling_ms: response.and_then(|r| r.settling_ms),
            overshoot_pct: response.and_then(|r| r.overshoot_pct),
            excursion: response.and_then(|r| r.excursion),
            band: response.and_then(|r| r.band),
            peak: response.and_then(|r| r.peak),
            final_value: response.and_then(|r| r.final_value),
            iae_s: response.and_then(|r| r.iae),
            ise_s: response.and_then(|r| r.ise),
            torn_lines: Some(*torn_lines),
            ..self
        }
    }

    /// The row with how the run came through the cell's fault.
    pub(crate) fn after_fault(self, cell: &Cell, recovery: Option<&Recovery>) -> Self {
        Self {
            fault: cell.fault.clone(),
            fault_worst: recovery
                .map(|of| of.worst)
                .filter(|worst| worst.is_finite()),
            fault_safe_ms: recovery.and_then(|of| of.safe_ms),
            fault_back_ms: recovery.and_then(|of| of.back_ms),
            ..self
        }
    }

    /// Messages that are known to have had no answer: later than the time-out, or broken.
    #[must_use]
    pub fn unanswered(&self) -> u64 {
        self.messages_timeout.unwrap_or(0) + self.messages_failed.unwrap_or(0)
    }

    /// A quantile of the messages' round trips, ms: `quantile_ms` is its field, and it is infinite if it falls among
    /// those without an answer.
    #[must_use]
    pub fn or_never(&self, q: f64, quantile_ms: Option<f64>) -> Option<f64> {
        let answered = self.messages_answered.unwrap_or(0);
        let falls_among_them = Quantiles::falls_among_missing(q, answered, self.unanswered());
        quantile_ms.or(falls_among_them.then_some(f64::INFINITY))
    }

    /// Whether another run of the same cell shows the same in every figure.
    pub(crate) fn shows_what(&self, other: &Summary) -> bool {
        let alike = Summary {
            cell: other.cell.clone(),
            repeat: other.repeat,
            ..self.clone()
        };
        alike == *other
    }

    /// Whether it was run in virtual time.
    #[must_use]
    pub fn is_simulated(&self) -> bool {
        self.backend.as_deref() == Some(VIRTUAL)
    }

    /// A figure of the step, for a table. A lost loop has none, and a silent one neither: the number would only
    /// say when the run ended.
    pub(crate) fn of_step(&self, figure: Option<f64>) -> Option<f64> {
        figure.filter(|_| self.loop_verdict <= Some(LoopVerdict::Unsettled))
    }

    /// `summary.csv` as text: the header, and one row per cell.
    #[must_use]
    pub fn to_csv(rows: &[Summary]) -> String {
        layout::csv(rows)
    }
}

/// The disturbances of a run, in the few words that a table has room for.
fn disturbed(manifest: &Manifest) -> Option<String> {
    let of_length = |one: &&Disturbance| one.longest_ms as u64;
    let worst = manifest.disturbances.iter().max_by_key(of_length)?;
    Some(match manifest.disturbances.len() {
        1 => worst.to_string(),
        all => format!("{worst}, {} more", all - 1),
    })
}
