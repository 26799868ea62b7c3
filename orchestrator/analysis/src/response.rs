//! The step response of a closed loop, from the plant's ticks, and the verdict on it.
//!
//! Time is the plant's own: tick number times h, from the tick that took the first command. The
//! response ends with the last command: afterwards the loop is open, and the plant only holds its
//! input.

use control::{StepSettings, sampled_step_info};
use endpoint::TickRow;
use serde::{Deserialize, Serialize};

/// The verdict on a closed loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoopVerdict {
    /// The output reached the reference and stayed there; see [`judge`].
    Stable,
    /// The output did not settle in the time available, and its error does not grow either.
    NotSettled,
    /// The error grows, or the output is not finite.
    Unstable,
}

impl std::fmt::Display for LoopVerdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            LoopVerdict::Stable => "stable",
            LoopVerdict::NotSettled => "not settled",
            LoopVerdict::Unstable => "unstable",
        })
    }
}

/// The figures of a step response, by the definitions of [`control::step_info()`] with the reference
/// as final value. A figure that does not exist is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// The verdict on the loop.
    pub verdict: LoopVerdict,
    /// Length of the response, s.
    pub length_s: f64,
    /// Rise time from 10 to 90 % of the reference, ms.
    pub rise_ms: Option<f64>,
    /// Time until y stays within 2 % of the reference, ms.
    pub settling_ms: Option<f64>,
    /// Overshoot, % of the reference.
    pub overshoot_pct: Option<f64>,
    /// Largest magnitude of y.
    pub peak: Option<f64>,
    /// When the peak was reached, ms.
    pub peak_ms: Option<f64>,
    /// Mean of y over the last fifth.
    pub final_value: Option<f64>,
    /// Integral of the absolute error, in units of y times s.
    pub iae: Option<f64>,
}

/// Number of parts of a response that [`judge`] compares.
const PARTS: usize = 5;
/// Settled means within this fraction of the reference.
const BAND: f64 = 0.02;
/// A short excursion in the last part, such as a stall causes, may be up to this fraction of the
/// reference.
const EXCURSION: f64 = 0.1;
/// The error of an unstable loop grows by more than this factor from one part to the next.
const GROWTH: f64 = 1.1;

/// The verdict on a response `y` to a step to `r`.
///
/// The response is cut into five parts of equal length, and their largest errors are compared.
///
/// - *Unstable*: a value is not finite; or the largest error of the last part is more than the step
///   itself, and each of the last three parts exceeds the one before it by a tenth. A stall of the
///   link makes one part bad, not three in rising order.
/// - *Stable*: the last part lies within 2 % of the reference; or its mean does, and nothing in it
///   is farther than 10 %. So one stall near the end does not undo a loop that had settled.
/// - *Not settled*: anything else, a lasting oscillation included, and fewer than five samples.
#[must_use]
pub fn judge(y: &[f64], r: f64) -> LoopVerdict {
    if !y.iter().all(|y| y.is_finite()) {
        return LoopVerdict::Unstable;
    }
    if y.len() < PARTS {
        return LoopVerdict::NotSettled;
    }
    let part = |i: usize| &y[y.len() * i / PARTS..y.len() * (i + 1) / PARTS];
    let worst = |i: usize| {
        part(i)
            .iter()
            .fold(0.0, |worst: f64, y| worst.max((y - r).abs()))
    };
    let last = worst(PARTS - 1);
    let grows = (PARTS - 3..PARTS).all(|i| worst(i) > GROWTH * worst(i - 1));
    if grows && last > r.abs() {
        return LoopVerdict::Unstable;
    }
    let steady = (mean(part(PARTS - 1)) - r).abs() <= BAND * r.abs();
    if last <= BAND * r.abs() || steady && last <= EXCURSION * r.abs() {
        return LoopVerdict::Stable;
    }
    LoopVerdict::NotSettled
}

fn mean(y: &[f64]) -> f64 {
    y.iter().sum::<f64>() / y.len() as f64
}

/// Accumulates a [`Response`] tick by tick.
#[derive(Debug)]
pub struct ResponseTrace {
    h_ms: f64,
    r: f64,
    y: Vec<f64>,
    command: Option<u64>,
    /// Number of samples up to the tick that took the newest command.
    length: usize,
}

impl ResponseTrace {
    /// For a plant with this sample time and the reference `r`.
    #[must_use]
    pub fn new(h_ns: u64, r: f64) -> Self {
        Self {
            h_ms: h_ns as f64 / 1e6,
            r,
            y: Vec::new(),
            command: None,
            length: 0,
        }
    }

    /// Adds the next tick.
    pub fn push(&mut self, row: &TickRow) {
        if row.seq.is_none() {
            return;
        }
        self.y.push(row.y);
        if row.seq != self.command {
            self.command = row.seq;
            self.length = self.y.len();
        }
    }

    /// Returns the response; `None` if no command ever arrived.
    #[must_use]
    pub fn finish(self) -> Option<Response> {
        let y = &self.y[..self.length];
        let h_s = self.h_ms / 1e3;
        if y.is_empty() {
            return None;
        }
        let to_r = StepSettings {
            settling_threshold: BAND,
            final_value: Some(self.r),
            ..StepSettings::default()
        };
        let info = sampled_step_info(self.h_ms, y, &to_r).ok();
        let figure = |x: Option<f64>| x.filter(|x| x.is_finite());
        let last = &y[y.len() * (PARTS - 1) / PARTS..];
        Some(Response {
            verdict: judge(y, self.r),
            length_s: y.len() as f64 * h_s,
            rise_ms: figure(info.map(|info| info.rise_time)),
            settling_ms: figure(info.map(|info| info.settling_time)),
            overshoot_pct: figure(info.map(|info| info.overshoot)),
            peak: figure(info.map(|info| info.peak)),
            peak_ms: figure(info.map(|info| info.peak_time)),
            final_value: figure(Some(mean(last))),
            iae: figure(Some(y.iter().map(|y| (self.r - y).abs() * h_s).sum())),
        })
    }
}

#[cfg(test)]
mod tests;
