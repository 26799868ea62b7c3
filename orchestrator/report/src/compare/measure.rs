//! What is compared in a pair of runs, how its change is expressed, and which direction is worse.

use analysis::Summary;
use endpoint::Mode;
use serde::Serialize;

/// A figure of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Settling of a closed loop into 2 %, ms; infinite if it never settled.
    Settling,
    /// Overshoot of a closed loop, % of the reference.
    Overshoot,
    /// Integral of the absolute error of a closed loop, s.
    Iae,
    /// Slope of an open loop's lateness over its schedule, ms/s.
    Slope,
    /// Messages that an open loop sent, as a share of those due, %.
    Sent,
    /// Median round trip of the messages, ms; infinite if half of them had no answer.
    Rtt,
}

impl Measure {
    /// All measures, in the order in which they are shown.
    pub const ALL: [Measure; 6] = [
        Measure::Settling,
        Measure::Overshoot,
        Measure::Iae,
        Measure::Slope,
        Measure::Sent,
        Measure::Rtt,
    ];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Measure::Settling => "settling",
            Measure::Overshoot => "overshoot",
            Measure::Iae => "IAE",
            Measure::Slope => "slope",
            Measure::Sent => "sent",
            Measure::Rtt => "RTT",
        }
    }

    /// Its unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Measure::Settling | Measure::Rtt => "ms",
            Measure::Overshoot | Measure::Sent => "%",
            Measure::Iae => "s",
            Measure::Slope => "ms/s",
        }
    }

    /// Its value in a complete run, in its unit; `None` if it does not apply or was not measured.
    #[must_use]
    pub fn of(self, run: &Summary) -> Option<f64> {
        let closed = |value: Option<f64>| value.filter(|_| run.mode == Mode::Closed);
        let open = |value: Option<f64>| value.filter(|_| run.mode == Mode::Open);
        match self {
            Measure::Settling => closed(run.settling_ms.or(Some(f64::INFINITY))),
            Measure::Overshoot => closed(run.overshoot_pct),
            Measure::Iae => closed(run.iae_s),
            Measure::Slope => open(run.schedule_slope).map(|slope| slope * 1e3),
            Measure::Sent => open(run.sent_share).map(|share| share * 1e2),
            Measure::Rtt => run.or_never(0.5, run.message_rtt_p50_ms),
        }
    }

    /// The difference of `b` from `a`: the logarithm of their ratio if a change of the measure is a
    /// ratio, else their difference as a share of the reference or of the schedule. `None` if there
    /// is no ratio.
    pub(super) fn difference(self, a: f64, b: f64) -> Option<f64> {
        match self {
            // Neither settled: no difference.
            _ if a == b => Some(0.0),
            Measure::Settling | Measure::Iae | Measure::Rtt => {
                (a > 0.0 && b > 0.0).then(|| b.ln() - a.ln())
            }
            Measure::Overshoot | Measure::Sent => Some((b - a) / 1e2),
            Measure::Slope => Some((b - a) / 1e3),
        }
    }

    /// Converts a difference to a change as a share: 0.1 is a tenth more. For settling, IAE and RTT
    /// it is a share of A's value, for overshoot of the reference, for slope and sent of the
    /// schedule.
    #[must_use]
    pub fn change(self, difference: f64) -> f64 {
        match self {
            Measure::Settling | Measure::Iae | Measure::Rtt => difference.exp_m1(),
            Measure::Overshoot | Measure::Sent | Measure::Slope => difference,
        }
    }

    /// A difference of the medians below this, in the measure's unit, never matters. A message over
    /// loopback takes 0.2 ms, and 0.25 ms on a busier machine.
    pub(super) fn least(self) -> f64 {
        match self {
            Measure::Rtt => 0.1,
            _ => 0.0,
        }
    }

    /// Whether a change of this sign is for the worse.
    #[must_use]
    pub fn is_worse(self, change: f64) -> bool {
        self.badness(change) > 0.0
    }

    /// A change or a difference, positive if it is for the worse.
    pub(super) fn badness(self, change: f64) -> f64 {
        match self {
            Measure::Sent => -change,
            _ => change,
        }
    }
}
