//! A plant that is a program in lock-step with its law: each step of one waits for the other, with a constant delay of
//! whole samples between them, as `control::step_response` has it for a linear model.
//!
//! No clock is asked but for programs that take too long, so a run is the same on any machine.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use analysis::asked::Asked;
use analysis::response::ResponseTrace;
use analysis::{Aim, LoopVerdict, Reason};
use anyhow::anyhow;
use backend::start_simulated;
use control::{Analysis, Law, Signals};
use endpoint::{Model, Reference, SampleTime, SecondRow, Surrounded, TickRow};
use plan::system::{Program, System};

use crate::exit::Failure;

/// The seed of sensors and of the program: each run has the same.
const SEED: u64 = 1;
/// The longest that one run may take. There are dozens of them.
const RUN_WITHIN: Duration = Duration::from_secs(60);

/// A system at a sample time, to be run with other gains and further delay.
pub(super) struct Lockstep<'a> {
    system: &'a System,
    /// Its file, as it was named.
    file: &'a str,
    program: Program,
    law: Law,
    h: SampleTime,
    duration_ns: u64,
    r: f64,
    reference: Option<Reference>,
    /// What was run: the gain factor's step and the further delay, and what became of it.
    seen: BTreeMap<(isize, usize), Seen>,
}

/// What became of a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// The verdict of the rule that every run is judged by, and its reason.
    pub(super) verdict: LoopVerdict,
    pub(super) reason: Option<Reason>,
    /// Whether what moves y dies out; unknown where r does not rest.
    pub(super) dies_out: Option<bool>,
}

impl<'a> Lockstep<'a> {
    pub(super) fn new(
        system: &'a System,
        file: &'a str,
        program: Program,
        h: SampleTime,
        duration_ns: u64,
    ) -> Result<Self, Failure> {
        let (law, _) = system.law_at(h).map_err(Failure::usage)?;
        let (r, reference) = system
            .reference_over(h, duration_ns)
            .map_err(Failure::usage)?;
        Ok(Self {
            system,
            file,
            program,
            law,
            h,
            duration_ns,
            r,
            reference,
            seen: BTreeMap::new(),
        })
    }

    pub(super) fn h(&self) -> SampleTime {
        self.h
    }

    /// Samples in a run.
    pub(super) fn ticks(&self) -> usize {
        usize::try_from(self.duration_ns / self.h.ns()).unwrap_or(usize::MAX)
    }

    /// How many runs there were.
    pub(super) fn runs(&self) -> usize {
        self.seen.len()
    }

    /// The factor of the law's gains after so many steps of 1 %.
    pub(super) fn factor(steps: isize) -> f64 {
        1.01_f64.powi(steps as i32)
    }

    /// Runs it from a fresh start with the gains times a factor of so many steps, and a further delay of so many
    /// samples, unless it was run so before.
    pub(super) fn run(&mut self, steps: isize, further: usize) -> Result<Seen, Failure> {
        if let Some(seen) = self.seen.get(&(steps, further)) {
            return Ok(*seen);
        }
        let seen = self.fresh(Self::factor(steps), further)?;
        self.seen.insert((steps, further), seen);
        Ok(seen)
    }

    fn fresh(&self, factor: f64, further: usize) -> Result<Seen, Failure> {
        let Some(mut law) = self.law.times(factor) else {
            return Err(Failure::usage(anyhow!(
                "the law of {} in {} has no gains that can be multiplied by {factor:.3}; give its [controller] finite \
                 gains, not all zero",
                self.system.name(),
                self.file
            )));
        };
        let own = start_simulated(&self.program, self.system.inputs(), self.h, SEED)
            .map_err(|problem| self.broken(&problem.to_string()))?;
        let around = self.system.surroundings().unwrap_or_default();
        let mut plant = Surrounded::new(own.clone(), around, SEED, Some(0));
        let mut trace = ResponseTrace::new(self.aim());
        let mut second = None;
        // The outputs that the controller has not yet got, the oldest first.
        let delay = Analysis::SHORTEST_TICKS + further;
        let mut under_way = VecDeque::from(vec![plant.at_rest(); delay]);
        let (begun, mut y) = (Instant::now(), Vec::new());
        for k in 0..self.ticks() as u64 {
            let t_ns = k * self.h.ns();
            let r = self.reference.as_ref().map_or(self.r, |r| r.at(t_ns));
            let got = under_way.pop_front().unwrap_or_default();
            let u = law.update(r, got, self.h.seconds());
            let output = plant.step(u, t_ns);
            if let Some(problem) = own.problem() {
                return Err(self.broken(&problem));
            }
            under_way.push_back(plant.measured(output));
            trace.push(&tick(k, t_ns, u, output, plant.applied()));
            if let Some(y2) = output.second {
                second
                    .get_or_insert_with(|| trace.second())
                    .iter_mut()
                    .for_each(|second| second.push(&of_second(k, y2)));
            }
            y.push(output.first);
            // What has overflown is lost, whatever comes after it.
            if !output.is_finite() {
                break;
            }
            if begun.elapsed() > RUN_WITHIN {
                return Err(self.too_slow(k));
            }
        }
        let found = second
            .flatten()
            .and_then(analysis::response::SecondTrace::finish);
        let response = trace
            .judged(None, found)
            .ok_or_else(|| anyhow!("a run of {} h has no samples", self.ticks()))?;
        Ok(Seen {
            verdict: response.verdict,
            reason: response.reason,
            dies_out: self.reference.is_none().then(|| dies_out(&y)),
        })
    }

    fn aim(&self) -> Aim {
        let around = self.system.surroundings().unwrap_or_default();
        let asked = |output| {
            Asked::of(
                self.system.holding(),
                output,
                around.noise,
                around.resolution,
            )
        };
        Aim {
            h_ns: self.h.ns(),
            start_ns: Some(0),
            duration_ns: Some(self.duration_ns),
            r: self.r,
            reference: self.reference.clone(),
            y0: None,
            first: asked(0),
            second: asked(1),
            second_r: self.system.other_r().first().copied(),
        }
    }

    /// The failure of the system's program, with the place that names it.
    fn broken(&self, problem: &str) -> Failure {
        anyhow!("{problem}. It is `run` in [plant] of {}", self.file).into()
    }

    fn too_slow(&self, k: u64) -> Failure {
        anyhow!(
            "the plant's program `{}` took over {} s for {k} of {} steps at h = {}, and the border needs dozens of such \
             runs; give a shorter --duration or a longer --h",
            self.program.run.join(" "),
            RUN_WITHIN.as_secs(),
            self.ticks(),
            self.h
        )
        .into()
    }
}

/// Whether what moves y dies out, about where it ends: a loop that is slow, or off by a constant, does not hold and is
/// stable all the same.
fn dies_out(y: &[f64]) -> bool {
    let last = &y[y.len() * 3 / 4..];
    let end = last.iter().sum::<f64>() / last.len().max(1) as f64;
    end.is_finite() && analysis::sweep::is_stable(y, end)
}

fn tick(k: u64, t_ns: u64, u: Signals, y: Signals, applied: Option<Signals>) -> TickRow {
    TickRow {
        k,
        t_due_ns: t_ns,
        t_tick_ns: t_ns,
        u: u.first,
        y: y.first,
        seq: Some(k),
        u_applied: applied.map(|u| u.first),
    }
}

fn of_second(k: u64, y2: f64) -> SecondRow {
    SecondRow {
        k,
        u2: None,
        y2: Some(y2),
        u2_applied: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_off_by_a_constant_dies_out_and_what_rings_on_does_not() {
        let ringing = |rate: f64| -> Vec<f64> {
            let y = |t: f64| 0.7 + (rate * t).exp() * (3.0 * t).cos();
            (0..2000).map(|k| y(f64::from(k) * 0.01)).collect()
        };
        assert!(dies_out(&ringing(-0.02)));
        assert!(!dies_out(&ringing(0.0)));
        assert!(!dies_out(&ringing(0.02)));
        assert!(!dies_out(&[0.0, 1.0, f64::INFINITY, f64::NAN]));
        assert!(!dies_out(&[]));
    }
}
