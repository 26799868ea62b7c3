//! The step response of a closed loop, from the plant's ticks, and the verdict on it.
//!
//! Time is the plant's own: ticks from the first one that is due at the first deadline or after it, until the
//! planned end of the run. What arrives does not move either: a loop whose first command comes late, or whose
//! last one comes early, is judged by what its output does meanwhile.
//!
//! Where the reference moves, the figures are of the response to its last step: from r before it to r after
//! it, and times from that step. A reference that moves in the last fifth has no last step: then the verdict
//! is on how the output follows, and of the figures there are only the peak, the mean and the integral.
//! [`verdict`](crate::verdict) has the rule.

mod aim;
mod second;

use control::step_info::greatest;
use control::{StepSettings, sampled_step_info};
use endpoint::TickRow;
use serde::{Deserialize, Serialize};

use crate::asked::STEP_BAND;
use crate::reason::Reason;
use crate::silence::{Silence, SilenceTrace, Ticking, least_ns};
use crate::statistics::mean;
use crate::verdict::{Course, Finding, LoopVerdict, PARTS, judge, judge_following, part};

pub use aim::Aim;
pub use second::SecondTrace;

/// The figures of a step response, by the definitions of [`control::step_info()`] with the reference
/// as final value. A figure that does not exist is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// The verdict on the loop.
    pub verdict: LoopVerdict,
    /// Why it does not just hold.
    pub reason: Option<Reason>,
    /// When the loop was lost, s from the first deadline; `None` if it was not, or no sample says when.
    #[serde(default)]
    pub lost_s: Option<f64>,
    /// Length of the response, s.
    pub length_s: f64,
    /// Rise time from 10 to 90 % of the step, ms.
    pub rise_ms: Option<f64>,
    /// Time from the step until y stays within its band about the reference, ms.
    pub settling_ms: Option<f64>,
    /// Overshoot, % of the step.
    pub overshoot_pct: Option<f64>,
    /// The greatest error once y has come within its band, in units of y; over all time where it never does.
    pub excursion: Option<f64>,
    /// Half the width of the band, in units of y; `None` if nothing gives its scale.
    pub band: Option<f64>,
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

/// Accumulates a [`Response`] tick by tick.
#[derive(Debug)]
pub struct ResponseTrace {
    aim: Aim,
    end_ns: u64,
    y: Vec<f64>,
    command: Option<u64>,
    /// The tick of the first sample, and when the newest was due.
    first: Option<(u64, u64)>,
    last_due_ns: u64,
    /// Number of samples up to the tick that took the newest command.
    length: usize,
    effort: f64,
}

impl ResponseTrace {
    /// For a run with this aim.
    #[must_use]
    pub fn new(aim: Aim) -> Self {
        let end_ns = aim
            .start_ns
            .zip(aim.duration_ns)
            .map_or(u64::MAX, |(start_ns, duration_ns)| {
                start_ns.saturating_add(duration_ns)
            });
        Self {
            aim,
            end_ns,
            y: Vec::new(),
            command: None,
            first: None,
            last_due_ns: 0,
            length: 0,
            effort: 0.0,
        }
    }

    /// Adds the next tick.
    #[inline]
    pub fn push(&mut self, row: &TickRow) {
        let is_before = match self.aim.start_ns {
            Some(start_ns) => row.t_due_ns < start_ns,
            None => row.seq.is_none() && self.first.is_none(),
        };
        if is_before {
            // What was commanded before the first deadline is no command of the run.
            self.command = row.seq;
            return;
        }
        if row.t_due_ns >= self.end_ns {
            return;
        }
        self.first.get_or_insert((row.k, row.t_due_ns));
        self.last_due_ns = row.t_due_ns;
        self.y.push(row.y);
        let u = row.u_applied.unwrap_or(row.u).abs();
        if u > self.effort {
            self.effort = u;
        }
        // A plant that stood still makes up for its ticks, the last of them with commands that came too late.
        if row.seq != self.command && row.t_tick_ns < self.end_ns {
            self.command = row.seq;
            self.length = self.y.len();
        }
    }

    /// Takes the second output over the same ticks; `None` if there are none.
    #[must_use]
    pub fn second(&self) -> Option<SecondTrace> {
        let (first_k, _) = self.first?;
        let k = first_k..first_k + self.y.len() as u64;
        Some(SecondTrace::new(&self.aim, k))
    }

    /// Who was silent at the end, still to be told by the other rows; `None` if the run did not end in silence.
    pub(crate) fn silence(&self) -> Option<SilenceTrace> {
        let (start_ns, duration_ns) = (self.aim.start_ns?, self.aim.duration_ns?);
        let h_ns = self.aim.h_ns;
        let (_, first_ns) = self.first?;
        // The tick that took the newest command was due then.
        let newest = self.length.checked_sub(1);
        let from_ns = newest.map_or(start_ns, |k| first_ns.saturating_add(k as u64 * h_ns));
        let least_ns = least_ns(duration_ns, h_ns);
        let is_long = self.end_ns.saturating_sub(from_ns) >= least_ns;
        let ticking = if self.end_ns.saturating_sub(self.last_due_ns) >= least_ns {
            Ticking::Stopped
        } else {
            Ticking::On
        };
        is_long.then(|| SilenceTrace::new(start_ns, from_ns, self.end_ns, ticking))
    }

    /// Returns the response without knowing who was silent, if anybody was: by its ticks alone it is the
    /// controller. `None` if there are no ticks, or no command ever came and none was due.
    #[must_use]
    pub fn finish(self) -> Option<Response> {
        let silence = self.silence().map(SilenceTrace::finish);
        self.judged(silence, None)
    }

    /// Returns the response, with the silence that the run ended in and the finding on its second output.
    #[must_use]
    pub fn judged(self, silence: Option<Silence>, second: Option<Finding>) -> Option<Response> {
        let y = self.y.as_slice();
        if y.is_empty() {
            return None;
        }
        let h_s = self.aim.h_ns as f64 / 1e9;
        let h_ms = self.aim.h_ns as f64 / 1e6;
        let (first, before) = self.aim.last_step(y);
        let has_step = first <= y.len() * (PARTS - 1) / PARTS;
        let seen = if has_step { &y[first..] } else { y };
        let error = self.errors(seen, if has_step { first } else { 0 });
        let step = self.aim.r_at(y.len() - 1) - before;
        let task = self.aim.task(step);
        let band = self.aim.first.band_for(step, task).filter(|_| has_step);
        let info = has_step
            .then(|| self.figures(seen, before, step, band))
            .flatten();
        let course = Course {
            error: &error,
            y: seen,
            h_s,
            step,
            task,
            open: y.len() - self.length,
            // Where y begins in its band there is no step to go beyond.
            overshoot_pct: info
                .map(|info| info.overshoot)
                .filter(|_| step.abs() > band.unwrap_or_default()),
            effort: self.effort,
            silence,
        };
        let found = if has_step {
            judge(&course, &self.aim.first)
        } else {
            let r: Vec<f64> = (0..y.len()).map(|k| self.aim.r_at(k)).collect();
            judge_following(&course, &r, &self.aim.first)
        };
        let begun_s = if has_step { first as f64 * h_s } else { 0.0 };
        let lost_s = found.lost_s.map(|lost_s| begun_s + lost_s);
        // The second output is judged from the first tick on.
        let both_s = [lost_s, second.and_then(|second| second.lost_s)];
        let found = second.map_or(found, |second| found.worse(second));
        let figure = |x: Option<f64>| x.filter(|x| x.is_finite());
        // By magnitude of y itself, which the response to a step from another value is not.
        let peak = greatest(seen, f64::abs).max(0.0);
        let is_peak = |y: &f64| peak > 0.0 && y.abs() == peak;
        let peak_place = seen.iter().position(is_peak).unwrap_or_default();
        let (iae, ise) = self.integrals(h_s);
        Some(Response {
            verdict: found.verdict,
            reason: found.reason,
            lost_s: both_s.into_iter().flatten().reduce(f64::min),
            length_s: y.len() as f64 * h_s,
            rise_ms: figure(info.map(|info| info.rise_time)).filter(|_| step != 0.0),
            // Of a loop that was lost, or on its own, it would say when that had not happened yet.
            settling_ms: figure(info.map(|info| info.settling_time))
                .filter(|_| found.verdict <= LoopVerdict::Unsettled),
            overshoot_pct: figure(course.overshoot_pct),
            excursion: figure(Some(excursion(&error, band))),
            band: figure(band),
            peak: figure(Some(peak)),
            peak_ms: figure(Some(peak_place as f64 * h_ms)),
            final_value: figure(Some(mean(part(y, PARTS - 1)))),
            iae: figure(Some(iae)),
            ise: figure(Some(ise)),
        })
    }

    /// The figures of the step, timed into the band.
    fn figures(
        &self,
        seen: &[f64],
        before: f64,
        step: f64,
        band: Option<f64>,
    ) -> Option<control::StepInfo> {
        // Most start at 0, and a copy of them all would take most of the time.
        let moved: Vec<f64>;
        let of_step = if before == 0.0 {
            seen
        } else {
            moved = seen.iter().map(|y| y - before).collect();
            &moved
        };
        let to_step = StepSettings {
            settling_threshold: band.map_or(STEP_BAND, |band| band / step.abs()),
            final_value: Some(step),
            ..StepSettings::default()
        };
        sampled_step_info(self.aim.h_ns as f64 / 1e6, of_step, &to_step).ok()
    }

    /// The integrals of the absolute and of the squared error.
    fn integrals(&self, h_s: f64) -> (f64, f64) {
        let (mut iae, mut ise) = (-0.0, -0.0);
        for (k, y) in self.y.iter().enumerate() {
            let e = self.aim.r_at(k) - y;
            iae += e.abs() * h_s;
            ise += e.powi(2) * h_s;
        }
        (iae, ise)
    }

    /// The errors of the samples from `first` on.
    fn errors(&self, seen: &[f64], first: usize) -> Vec<f64> {
        match self.aim.reference {
            None => seen.iter().map(|y| y - self.aim.r).collect(),
            Some(_) => {
                let r = (first..).map(|k| self.aim.r_at(k));
                seen.iter().zip(r).map(|(y, r)| y - r).collect()
            }
        }
    }
}

/// The greatest error from the first one within the band on; of all, where none is or there is no band.
fn excursion(error: &[f64], band: Option<f64>) -> f64 {
    let within = |band: f64| error.iter().position(|e| e.abs() <= band);
    let from = band.and_then(within).unwrap_or_default();
    greatest(&error[from..], f64::abs)
}

#[cfg(test)]
mod tests;
