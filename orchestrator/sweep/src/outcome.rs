//! What a run came to.

/// The figures of one run. What does not exist is `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Whether the error dies out, see [`crate::is_stable`].
    pub stable: bool,
    /// The largest error of the last quarter over that of the second, see [`crate::growth()`].
    pub growth: Option<f64>,
    /// Into 2 % of the reference for good.
    pub settling_ms: Option<f64>,
    /// From 10 to 90 % of the reference.
    pub rise_ms: Option<f64>,
    /// How far beyond the reference, % of it.
    pub overshoot_pct: Option<f64>,
    /// Integral of the absolute error, in units of y times s.
    pub iae_s: Option<f64>,
    /// Integral of e² + rho u².
    pub cost_s: Option<f64>,
    /// Of the controller's deadlines, those at which it sent something, %.
    pub sent_pct: Option<f64>,
    /// From a message's sending to its answer: the median of those that were answered.
    pub rtt_median_ms: Option<f64>,
    /// The same, 95 % of them.
    pub rtt_p95_ms: Option<f64>,
    /// The same, the longest.
    pub rtt_max_ms: Option<f64>,
}

impl Outcome {
    /// Its columns.
    pub(crate) const COLUMNS: [&'static str; 11] = [
        "stable",
        "growth",
        "settling_ms",
        "rise_ms",
        "overshoot_pct",
        "iae_s",
        "cost_s",
        "sent_pct",
        "rtt_median_ms",
        "rtt_p95_ms",
        "rtt_max_ms",
    ];

    /// All but whether it is stable, in the order of the columns.
    pub(crate) fn figures(&self) -> [Option<f64>; 10] {
        [
            self.growth,
            self.settling_ms,
            self.rise_ms,
            self.overshoot_pct,
            self.iae_s,
            self.cost_s,
            self.sent_pct,
            self.rtt_median_ms,
            self.rtt_p95_ms,
            self.rtt_max_ms,
        ]
    }

    /// From the same.
    pub(crate) fn of(stable: bool, figures: [Option<f64>; 10]) -> Outcome {
        let [
            growth,
            settling_ms,
            rise_ms,
            overshoot_pct,
            iae_s,
            cost_s,
            sent_pct,
            rtt_median_ms,
            rtt_p95_ms,
            rtt_max_ms,
        ] = figures;
        Outcome {
            stable,
            growth,
            settling_ms,
            rise_ms,
            overshoot_pct,
            iae_s,
            cost_s,
            sent_pct,
            rtt_median_ms,
            rtt_p95_ms,
            rtt_max_ms,
        }
    }
}
