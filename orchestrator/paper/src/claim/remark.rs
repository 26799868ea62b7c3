//! What is said of a claim's result beyond its numbers: each remark by its name in `claims.toml`.

use serde::Deserialize;

use super::evidence::Evidence;
use super::row::Judged;
use super::{drift, interval, pace, plant, settling};

/// A remark on the rows of a claim after they are judged.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Remark {
    /// Stalls tilt a line.
    Tilts,
    /// Today's client is flat. Rows come in pairs: the messages in a row off the line, and the slope.
    StillFlat,
    /// The medians are over few runs.
    FewRuns,
    /// A client that is slower than h closes a slower loop; and few runs.
    PaceOfTheLoop,
    /// Runs that had not settled when they ended.
    Unsettled,
    /// How much wider the paper's numbers scatter.
    Spread,
    /// Commands and ticks have one period. The first two rows are arima's.
    Phase,
    /// The link keeps the order of packets. The first row is the VPN's.
    KeptOrder,
    /// The paper's numbers have two paces, and ours has one of them.
    PaceOfTheStart,
    /// What a message takes.
    PaceOfTheWhole,
    /// The plant changes another figure too. The third row is arima's share at h.
    Peaks,
}

impl Remark {
    pub(super) fn on(self, evidence: &mut Evidence, judged: &[Judged<'_>]) {
        let remark = match self {
            Remark::Tilts => drift::note_tilts,
            Remark::StillFlat => drift::explain_flat,
            Remark::FewRuns => settling::few,
            Remark::PaceOfTheLoop => settling::explain_pace,
            Remark::Unsettled => settling::note_unsettled,
            Remark::Spread => plant::note_spread,
            Remark::Phase => interval::note_phase,
            Remark::KeptOrder => interval::explain_order,
            Remark::PaceOfTheStart => pace::explain_start,
            Remark::PaceOfTheWhole => pace::explain_whole,
            Remark::Peaks => interval::note_peaks,
        };
        remark(evidence, judged);
    }
}
