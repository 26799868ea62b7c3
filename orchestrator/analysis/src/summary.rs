//! A cell in one row: `summary.csv`, and what the table shows.

use plan::{Cell, Verdict};
use serde::{Deserialize, Serialize};

use crate::metrics::Metrics;
use crate::response::LoopVerdict;
use crate::statistics::{ms, share};

/// One cell of a campaign. Units end the names, shares are from 0 to 1, and an empty field does not
/// apply or was not measured.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Summary {
    /// The cell's id, the name of its folder.
    pub cell: String,
    /// Its topology.
    pub topology: String,
    /// Its client.
    pub client: String,
    /// The client's preset, and what the experiment laid over it.
    pub setup: String,
    /// `http` or `websocket`.
    pub transport: String,
    /// The least delay that the page gave its timers; empty where the client is no page.
    pub timer_floor_ms: Option<f64>,
    /// `open` or `closed`.
    pub mode: String,
    /// Its rate in people's words, such as `333 Hz`.
    pub rate: String,
    /// The sample time, ns.
    pub h_ns: u64,
    /// Which repeat it is, from 1.
    pub repeat: u32,
    /// How the run ended; empty if it has not been run.
    pub verdict: Option<Verdict>,
    /// What became of the loop, in closed loop.
    pub loop_verdict: Option<LoopVerdict>,
    /// The profile's mean round trip over a long time.
    pub rtt_asked_ms: Option<f64>,
    /// The mean that the link had at the instants of the echoes.
    pub rtt_due_ms: Option<f64>,
    /// The mean that the echoes measured at those instants.
    pub rtt_measured_ms: Option<f64>,
    /// Echoes sent.
    pub probes: Option<u64>,
    /// Echoes lost.
    pub probes_lost: Option<u64>,
    /// Messages that the schedule asked for, one each h of the run's length: a client that drifts
    /// gets round to fewer.
    pub messages_due: u64,
    /// Messages that were sent.
    pub messages_sent: Option<u64>,
    /// Sent of due.
    pub sent_share: Option<f64>,
    /// Messages that were answered.
    pub messages_answered: Option<u64>,
    /// Messages without an answer in time.
    pub messages_timeout: Option<u64>,
    /// Messages whose connection or answer was broken.
    pub messages_failed: Option<u64>,
    /// Due and not sent: deadlines without a message, and those that a client that drifts never had.
    pub messages_missed: Option<u64>,
    /// Median round trip of a message.
    pub message_rtt_p50_ms: Option<f64>,
    /// Its 90th percentile.
    pub message_rtt_p90_ms: Option<f64>,
    /// Its 99th percentile.
    pub message_rtt_p99_ms: Option<f64>,
    /// The longest.
    pub message_rtt_max_ms: Option<f64>,
    /// Mean interval between arrivals.
    pub control_interval_avg_ms: Option<f64>,
    /// Their standard deviation.
    pub control_interval_sd_ms: Option<f64>,
    /// Share of them within a tenth of h.
    pub control_interval_at_h: Option<f64>,
    /// Share of arrivals at the same time as the one before, in ns.
    pub zero_exact: Option<f64>,
    /// The same in ms.
    pub zero_1ms: Option<f64>,
    /// The same in tens of ms.
    pub zero_10ms: Option<f64>,
    /// The same in ticks of the plant.
    pub zero_tick: Option<f64>,
    /// Messages that a later one had overtaken.
    pub out_of_order: Option<u64>,
    /// Slope of the lateness over the schedule, s/s.
    pub schedule_slope: Option<f64>,
    /// Lateness of the last arrival.
    pub schedule_lag_s: Option<f64>,
    /// Median distance of the lateness from its line.
    pub schedule_residual_p50_ms: Option<f64>,
    /// The greatest.
    pub schedule_residual_max_ms: Option<f64>,
    /// Share of arrivals off the line: by more than five medians, and more than 1 ms.
    pub impulse_share: Option<f64>,
    /// The most of them in a row.
    pub impulse_longest: Option<u64>,
    /// The plant's ticks.
    pub ticks: Option<u64>,
    /// Mean interval of the plant's ticks.
    pub tick_interval_avg_ms: Option<f64>,
    /// Its standard deviation.
    pub tick_interval_sd_ms: Option<f64>,
    /// Share of ticks within 0.1 ms of their deadline.
    pub ticks_punctual: Option<f64>,
    /// Lateness of the ticks, 99th percentile.
    pub tick_late_p99_ms: Option<f64>,
    /// Ticks late by h or more.
    pub ticks_missed: Option<u64>,
    /// Rise from 10 to 90 %.
    pub rise_ms: Option<f64>,
    /// Settling into 2 %.
    pub settling_ms: Option<f64>,
    /// Overshoot in percent.
    pub overshoot_pct: Option<f64>,
    /// Peak of the output.
    pub peak: Option<f64>,
    /// Mean of the output in the last fifth of the run.
    pub final_value: Option<f64>,
    /// Integral of the absolute error.
    pub iae_s: Option<f64>,
    /// Files with a torn last line.
    pub torn_lines: Option<u64>,
}

impl Summary {
    /// Of a cell, how its run ended, the profile's mean round trip (`None` on loopback), and what
    /// was measured.
    #[must_use]
    pub fn new(
        cell: &Cell,
        verdict: Option<Verdict>,
        rtt_asked_ms: Option<f64>,
        metrics: Option<&Metrics>,
    ) -> Self {
        let known = Self {
            cell: cell.id.clone(),
            topology: cell.topology.clone(),
            client: cell.client.to_string(),
            setup: cell.setup(),
            transport: cell.settings.transport.to_string(),
            timer_floor_ms: cell.page.map(|page| ms(page.floor_ns)),
            mode: cell.settings.mode.to_string(),
            rate: cell.rate(),
            h_ns: cell.settings.h.ns(),
            repeat: cell.repeat,
            verdict,
            rtt_asked_ms,
            messages_due: cell.due(),
            ..Self::default()
        };
        metrics.map_or(known.clone(), |metrics| known.measured(metrics))
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
            rtt_due_ms: probes.and_then(|p| p.due_rtt).map(|rtt| rtt.avg_ms),
            rtt_measured_ms: probes.and_then(|p| p.rtt).map(|rtt| rtt.avg_ms),
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
            peak: response.and_then(|r| r.peak),
            final_value: response.and_then(|r| r.final_value),
            iae_s: response.and_then(|r| r.iae),
            torn_lines: Some(*torn_lines),
            ..self
        }
    }

    /// `summary.csv` as text: the header, and one row per cell.
    #[must_use]
    pub fn to_csv(rows: &[Summary]) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in rows {
            // A flat struct of words and numbers, into memory: neither can fail.
            let _ = writer.serialize(row);
        }
        writer
            .into_inner()
            .ok()
            .and_then(|bytes| String::from_utf8(bytes).ok())
            .unwrap_or_default()
    }
}
