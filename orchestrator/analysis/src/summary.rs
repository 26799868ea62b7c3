//! A cell as one row: of `summary.csv`, and of the table.

use endpoint::{Mode, Transport};
use link::{Profile, Typical};
use manifest::Manifest;
use plan::{Cell, Client, Disturbance, START_AT, Verdict};
use serde::{Deserialize, Serialize};

use crate::layout;
use crate::metrics::Metrics;
use crate::recovery::Recovery;
use crate::response::LoopVerdict;
use crate::statistics::{ms, share};
use crate::whole::VIRTUAL;

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

/// One cell of a campaign. Names end in the unit, shares are from 0 to 1, and an empty field does not
/// apply or was not measured.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Summary {
    /// The cell's id, the name of its folder.
    pub cell: String,
    /// Its topology.
    pub topology: String,
    /// Its system. No column names it: `setup` does, if it is not the paper's.
    #[serde(skip)]
    pub system: String,
    /// How long its controller sends, ns. `messages_due` and `h_ns` say the same in the CSV.
    #[serde(skip)]
    pub duration_ns: u64,
    /// Its client.
    pub client: Client,
    /// The client's preset, and the settings that the experiment changed.
    pub setup: String,
    /// `http` or `websocket`.
    pub transport: Transport,
    /// The least delay that the page gave its timers; empty if the client is not a page.
    pub timer_floor_ms: Option<f64>,
    /// `open` or `closed`.
    pub mode: Mode,
    /// Its rate for people, such as `333 Hz`.
    pub rate: String,
    /// The sample time, ns.
    pub h_ns: u64,
    /// Number of the repeat, from 1.
    pub repeat: u32,
    /// The back-end; `sim` is virtual time. Empty if the cell has not been run.
    pub backend: Option<String>,
    /// How the run ended; empty if the cell has not been run.
    pub verdict: Option<Verdict>,
    /// The worst disturbance of the run, and the number of others; empty if there was none.
    pub disturbed: Option<String>,
    /// The verdict on the loop, in closed loop.
    pub loop_verdict: Option<LoopVerdict>,
    /// The mean round trip over a long time that the profile states.
    pub rtt_asked_ms: Option<f64>,
    /// The profile's median round trip over a long time.
    pub rtt_asked_p50_ms: Option<f64>,
    /// Its 90th percentile over a long time.
    pub rtt_asked_p90_ms: Option<f64>,
    /// Mean round trip that the link had at the instants of the echoes.
    pub rtt_due_ms: Option<f64>,
    /// Median round trip that the link had at the instants of the echoes.
    pub rtt_due_p50_ms: Option<f64>,
    /// Its 90th percentile.
    pub rtt_due_p90_ms: Option<f64>,
    /// Mean round trip that the echoes measured at those instants.
    pub rtt_measured_ms: Option<f64>,
    /// Median round trip that the echoes measured.
    pub rtt_measured_p50_ms: Option<f64>,
    /// Its 90th percentile.
    pub rtt_measured_p90_ms: Option<f64>,
    /// Share of time, over a long time, in which the link is stalled; empty if it never is.
    pub stalled_asked: Option<f64>,
    /// Share of the run in which the link was stalled, from the first due message on.
    pub stalled_due: Option<f64>,
    /// Echoes sent.
    pub probes: Option<u64>,
    /// Echoes lost.
    pub probes_lost: Option<u64>,
    /// Messages that the schedule asked for, one per h of the run's length. A client that drifts
    /// sends fewer.
    pub messages_due: u64,
    /// Messages that were sent.
    pub messages_sent: Option<u64>,
    /// Messages sent divided by messages due.
    pub sent_share: Option<f64>,
    /// Messages that were answered.
    pub messages_answered: Option<u64>,
    /// Messages without an answer in time.
    pub messages_timeout: Option<u64>,
    /// Messages whose connection or answer was broken.
    pub messages_failed: Option<u64>,
    /// Messages due but not sent: deadlines without a message, and those that a drifting client never
    /// reached.
    pub messages_missed: Option<u64>,
    /// Median round trip of a message.
    pub message_rtt_p50_ms: Option<f64>,
    /// Its 90th percentile, ms.
    pub message_rtt_p90_ms: Option<f64>,
    /// Its 99th percentile.
    pub message_rtt_p99_ms: Option<f64>,
    /// The longest round trip of a message.
    pub message_rtt_max_ms: Option<f64>,
    /// Mean interval between arrivals.
    pub control_interval_avg_ms: Option<f64>,
    /// Standard deviation of these intervals.
    pub control_interval_sd_ms: Option<f64>,
    /// Share of these intervals within 10 % of h.
    pub control_interval_at_h: Option<f64>,
    /// Share of arrivals at the same time in ns as the one before.
    pub zero_exact: Option<f64>,
    /// Share in the same millisecond as the one before.
    pub zero_1ms: Option<f64>,
    /// Share in the same ten milliseconds as the one before.
    pub zero_10ms: Option<f64>,
    /// Share in the same tick of the plant as the one before.
    pub zero_tick: Option<f64>,
    /// Messages that arrived after one with a higher `seq`.
    pub out_of_order: Option<u64>,
    /// Slope of the lateness over the schedule, s/s.
    pub schedule_slope: Option<f64>,
    /// Lateness of the last arrival.
    pub schedule_lag_s: Option<f64>,
    /// Median distance of the lateness from its line.
    pub schedule_residual_p50_ms: Option<f64>,
    /// Greatest distance of the lateness from its line.
    pub schedule_residual_max_ms: Option<f64>,
    /// Share of arrivals off the line: by more than five median distances and by more than 1 ms.
    pub impulse_share: Option<f64>,
    /// The longest sequence of such arrivals.
    pub impulse_longest: Option<u64>,
    /// The plant's ticks.
    pub ticks: Option<u64>,
    /// Mean interval of the plant's ticks.
    pub tick_interval_avg_ms: Option<f64>,
    /// Standard deviation of these intervals.
    pub tick_interval_sd_ms: Option<f64>,
    /// Share of ticks within 0.1 ms of their deadline.
    pub ticks_punctual: Option<f64>,
    /// Lateness of the ticks, 99th percentile.
    pub tick_late_p99_ms: Option<f64>,
    /// Ticks late by h or more.
    pub ticks_missed: Option<u64>,
    /// Rise time from 10 to 90 %.
    pub rise_ms: Option<f64>,
    /// Settling time into 2 %.
    pub settling_ms: Option<f64>,
    /// Overshoot in percent.
    pub overshoot_pct: Option<f64>,
    /// Peak of the output.
    pub peak: Option<f64>,
    /// Mean of the output in the last fifth of the run.
    pub final_value: Option<f64>,
    /// Integral of the absolute error.
    pub iae_s: Option<f64>,
    /// Integral of the squared error: the quadratic cost.
    pub ise_s: Option<f64>,
    /// Number of files with a torn last line.
    pub torn_lines: Option<u64>,
    /// The fault that it met; empty without one.
    pub fault: Option<String>,
    /// The greatest error from the fault's beginning until the loop was back.
    pub fault_worst: Option<f64>,
    /// From the last command before the fault to the plant's safe state.
    pub fault_safe_ms: Option<f64>,
    /// From the fault's end until the loop was back; empty if it did not come back.
    pub fault_back_ms: Option<f64>,
}

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

    /// Whether it was run in virtual time.
    #[must_use]
    pub fn is_simulated(&self) -> bool {
        self.backend.as_deref() == Some(VIRTUAL)
    }

    /// A figure of the step, for a table. An unstable loop has none: the number would only say when the run
    /// ended.
    pub(crate) fn of_step(&self, figure: Option<f64>) -> Option<f64> {
        figure.filter(|_| self.loop_verdict != Some(LoopVerdict::Unstable))
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
