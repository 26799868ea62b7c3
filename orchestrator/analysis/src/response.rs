//! The step response of a closed loop, from the plant's ticks, and the verdict on it.
//!
//! Time is the plant's own: tick number times h, from the tick that took the first command. The
//! response ends with the last command: afterwards the loop is open, and the plant only holds its
//! input.
//!
//! Where the reference moves, the figures are of the response to its last step: from r before it to r after
//! it, and times from that step. A reference that moves in the last fifth has no last step: then the verdict
//! is on how the output follows, and of the figures there are only the peak, the mean and the integral.

use std::borrow::Cow;

use control::step_info::greatest;
use control::{StepSettings, sampled_step_info};
use endpoint::{Reference, SecondRow, TickRow};
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
    /// Rise time from 10 to 90 % of the step, ms.
    pub rise_ms: Option<f64>,
    /// Time until y stays within 2 % of the step about the reference, ms.
    pub settling_ms: Option<f64>,
    /// Overshoot, % of the step.
    pub overshoot_pct: Option<f64>,
    /// Largest magnitude of y.
    pub peak: Option<f64>,
    /// When the peak was reached, ms.
    pub peak_ms: Option<f64>,
    /// Mean of y over the last fifth.
    pub final_value: Option<f64>,
    /// Integral of the absolute error, in units of y times s.
    pub iae: Option<f64>,
    /// Integral of the squared error, in units of y squared times s: the quadratic cost.
    pub ise: Option<f64>,
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
    let Some(worst) = worst_errors(y, r) else {
        return if are_finite(y) {
            LoopVerdict::NotSettled
        } else {
            LoopVerdict::Unstable
        };
    };
    let last = worst[PARTS - 1];
    if grows(&worst) && last > r.abs() {
        return LoopVerdict::Unstable;
    }
    let steady = (mean(part(y, PARTS - 1)) - r).abs() <= BAND * r.abs();
    if last <= BAND * r.abs() || steady && last <= EXCURSION * r.abs() {
        return LoopVerdict::Stable;
    }
    LoopVerdict::NotSettled
}

/// The verdict on a response `y` to a reference `r` that moves without rest, sample by sample.
///
/// - *Unstable*: as by [`judge`], with the range of r in place of the step.
/// - *Stable*: the output follows. No error of the last part exceeds half the range of r, which an output
///   that rests in the middle would have, nor by more than a tenth the largest error before.
/// - *Not settled*: anything else.
///
/// # Panics
/// If there is not one r for each sample.
#[must_use]
pub fn judge_following(y: &[f64], r: &[f64]) -> LoopVerdict {
    assert_eq!(y.len(), r.len(), "one r for each sample");
    let span = r.iter().copied().fold(f64::NEG_INFINITY, f64::max)
        - r.iter().copied().fold(f64::INFINITY, f64::min);
    let e: Vec<f64> = y.iter().zip(r).map(|(y, r)| y - r).collect();
    match worst_errors(&e, 0.0) {
        None if e.iter().all(|e| e.is_finite()) => LoopVerdict::NotSettled,
        None => LoopVerdict::Unstable,
        Some(worst) if grows(&worst) && worst[PARTS - 1] > span => LoopVerdict::Unstable,
        Some(worst) => {
            let earlier = worst[..PARTS - 1].iter().copied().fold(0.0, f64::max);
            let last = worst[PARTS - 1];
            if last <= span / 2.0 && last <= GROWTH * earlier {
                LoopVerdict::Stable
            } else {
                LoopVerdict::NotSettled
            }
        }
    }
}

/// The verdict on a second output `y`, which comes to rest wherever it may: its reference, if it has one, is in
/// the law.
///
/// - *Unstable*: a value is not finite; or its distance from where it ends is largest in the last part, after
///   growing over three.
/// - *Stable*: in the last part it is within a tenth of its farthest from there.
/// - *Not settled*: anything else.
#[must_use]
pub fn judge_second(y: &[f64]) -> LoopVerdict {
    if !y.iter().all(|y| y.is_finite()) {
        return LoopVerdict::Unstable;
    }
    if y.len() < PARTS {
        return LoopVerdict::NotSettled;
    }
    let Some(worst) = worst_errors(y, mean(part(y, PARTS - 1))) else {
        return LoopVerdict::NotSettled;
    };
    let (last, farthest) = (worst[PARTS - 1], worst.iter().copied().fold(0.0, f64::max));
    if grows(&worst) && last >= farthest && last > 0.0 {
        LoopVerdict::Unstable
    } else if last <= EXCURSION * farthest {
        LoopVerdict::Stable
    } else {
        LoopVerdict::NotSettled
    }
}

/// The largest error about `r` in each part; `None` with fewer samples than parts, or one that is not
/// finite.
fn worst_errors(y: &[f64], r: f64) -> Option<[f64; PARTS]> {
    if y.len() < PARTS || !are_finite(y) {
        return None;
    }
    let largest = |part: &[f64]| greatest(part, |y| (y - r).abs()).max(0.0);
    Some(std::array::from_fn(|i| largest(part(y, i))))
}

/// Whether all are finite: without a way out of the loop, which is several times as fast.
fn are_finite(y: &[f64]) -> bool {
    y.iter().fold(true, |all, y| all & y.is_finite())
}

/// Whether each of the last three parts is worse than the one before it by a tenth.
fn grows(worst: &[f64; PARTS]) -> bool {
    (PARTS - 3..PARTS).all(|i| worst[i] > GROWTH * worst[i - 1])
}

/// One of the equal parts of a response.
fn part(y: &[f64], i: usize) -> &[f64] {
    &y[y.len() * i / PARTS..y.len() * (i + 1) / PARTS]
}

fn mean(y: &[f64]) -> f64 {
    y.iter().sum::<f64>() / y.len() as f64
}

/// Accumulates the second output over the ticks of a response.
#[derive(Debug)]
pub(crate) struct SecondTrace {
    first_k: u64,
    end_k: u64,
    y: Vec<f64>,
}

impl SecondTrace {
    pub(crate) fn push(&mut self, row: &SecondRow) {
        if (self.first_k..self.end_k).contains(&row.k) {
            self.y.extend(row.y2);
        }
    }

    /// The verdict; `None` if there is no second output.
    pub(crate) fn finish(self) -> Option<LoopVerdict> {
        (!self.y.is_empty()).then(|| judge_second(&self.y))
    }
}

/// Accumulates a [`Response`] tick by tick.
#[derive(Debug)]
pub struct ResponseTrace {
    h_ns: u64,
    r: f64,
    reference: Option<Reference>,
    y0: f64,
    y: Vec<f64>,
    command: Option<u64>,
    /// The tick of the first sample.
    first_k: Option<u64>,
    /// Number of samples up to the tick that took the newest command.
    length: usize,
}

impl ResponseTrace {
    /// For a plant with this sample time and the reference `r`, or one that moves.
    #[must_use]
    pub fn new(h_ns: u64, r: f64, reference: Option<Reference>) -> Self {
        Self {
            h_ns,
            r,
            reference,
            y0: 0.0,
            y: Vec::new(),
            command: None,
            first_k: None,
            length: 0,
        }
    }

    /// Takes the second output over the same ticks; `None` if no command ever arrived.
    pub(crate) fn second(&self) -> Option<SecondTrace> {
        let first_k = self.first_k?;
        Some(SecondTrace {
            first_k,
            end_k: first_k + self.length as u64,
            y: Vec::new(),
        })
    }

    /// For a plant that has this output at the start, instead of one at rest.
    #[must_use]
    pub fn from_output(self, y0: f64) -> Self {
        Self { y0, ..self }
    }

    /// Adds the next tick.
    #[inline]
    pub fn push(&mut self, row: &TickRow) {
        if row.seq.is_none() {
            return;
        }
        self.first_k.get_or_insert(row.k);
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
        if y.is_empty() {
            return None;
        }
        let h_s = self.h_ns as f64 / 1e9;
        let (first, before) = self.last_step(y.len());
        let has_step = first <= y.len() * (PARTS - 1) / PARTS;
        let from_step = &y[first..];
        // Most start at 0, and a copy of them all would take most of the time.
        let of_step: Cow<'_, [f64]> = if before == 0.0 {
            from_step.into()
        } else {
            from_step.iter().map(|y| y - before).collect()
        };
        let step = self.r_at(y.len() - 1) - before;
        let to_step = StepSettings {
            settling_threshold: BAND,
            final_value: Some(step),
            ..StepSettings::default()
        };
        let h_ms = self.h_ns as f64 / 1e6;
        let info = sampled_step_info(h_ms, &of_step, &to_step).ok();
        let info_of_step = info.filter(|_| has_step);
        let figure = |x: Option<f64>| x.filter(|x| x.is_finite());
        // By magnitude of y itself, which the response to a step from another value is not.
        let seen = if has_step { from_step } else { y };
        let peak = greatest(seen, f64::abs).max(0.0);
        let is_peak = |y: &f64| peak > 0.0 && y.abs() == peak;
        let peak_place = seen.iter().position(is_peak).unwrap_or_default();
        let (mut iae, mut ise) = (-0.0, -0.0);
        for (k, y) in y.iter().enumerate() {
            let e = self.r_at(k) - y;
            iae += e.abs() * h_s;
            ise += e.powi(2) * h_s;
        }
        let last = &y[y.len() * (PARTS - 1) / PARTS..];
        Some(Response {
            verdict: if has_step {
                judge(&of_step, step)
            } else {
                let r: Vec<f64> = (0..y.len()).map(|k| self.r_at(k)).collect();
                judge_following(y, &r)
            },
            length_s: y.len() as f64 * h_s,
            rise_ms: figure(info_of_step.map(|info| info.rise_time)),
            settling_ms: figure(info_of_step.map(|info| info.settling_time)),
            overshoot_pct: figure(info_of_step.map(|info| info.overshoot)),
            peak: figure(info.map(|_| peak)),
            peak_ms: figure(info.map(|_| peak_place as f64 * h_ms)),
            final_value: figure(Some(mean(last))),
            iae: figure(Some(iae)),
            ise: figure(Some(ise)),
        })
    }

    /// The reference at a sample.
    fn r_at(&self, k: usize) -> f64 {
        let moving = self.reference.as_ref();
        moving.map_or(self.r, |moving| moving.at(self.t_ns(k)))
    }

    /// The first sample of the last step, and r before it. Without a change of r it is the start, from the
    /// plant's first output.
    fn last_step(&self, length: usize) -> (usize, f64) {
        let moving = self.reference.as_ref();
        let change = moving.and_then(|moving| moving.last_change(self.t_ns(length - 1)));
        change.map_or((0, self.y0), |(t_ns, before)| {
            (t_ns.div_ceil(self.h_ns) as usize, before)
        })
    }

    fn t_ns(&self, k: usize) -> u64 {
        (k as u64).saturating_mul(self.h_ns)
    }
}

#[cfg(test)]
mod tests;
