//! Tests a program that is a plant: does it print one y for each u, always the same ones, and end with its
//! input?
//!
//! Each trial is a function of programs that it starts anew. They run one after another, since one of them
//! asks how long a step takes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use endpoint::{Model, SampleTime, Signals};
use process::plant::PlantProgram;

use crate::error::Error;
use crate::outcome::{TrialResult, Verdict};
use crate::plant_fault::PlantFault;

/// What starts the program, anew at each call, for steps of this h.
pub type StartPlant<'a> = dyn Fn(SampleTime) -> Result<PlantProgram, PlantFault> + 'a;

/// One test of a plant.
#[derive(Debug, Clone, Copy)]
pub struct PlantTrial {
    /// Its name.
    pub name: &'static str,
    /// What it asks, in a sentence.
    pub asks: &'static str,
    /// Returns the numbers of a plant that passes.
    try_out: fn(&Bench<'_>) -> Result<String, PlantFault>,
}

/// Every trial of a plant, in order.
pub const PLANT_TRIALS: [PlantTrial; 8] = [
    PlantTrial {
        name: "start",
        asks: "It prints the y that it starts with before it gets any u.",
        try_out: start,
    },
    PlantTrial {
        name: "steps",
        asks: "It prints one finite y for each u.",
        try_out: steps,
    },
    PlantTrial {
        name: "rate",
        asks: "A u comes each h: a step takes less, and y does not depend on when it is asked.",
        try_out: rate,
    },
    PlantTrial {
        name: "repeat",
        asks: "Started again, it gives the same y for the same u: nothing random without WEBLOOP_SEED, nothing kept.",
        try_out: repeat,
    },
    PlantTrial {
        name: "two",
        asks: "Two at once give the same y as one.",
        try_out: two,
    },
    PlantTrial {
        name: "sample-time",
        asks: "With twice the h a step advances by more.",
        try_out: sample_time,
    },
    PlantTrial {
        name: "extremes",
        asks: "A very great and a very small u do it no harm.",
        try_out: extremes,
    },
    PlantTrial {
        name: "end",
        asks: "No u comes for 1.5 s: it waits. Its input ends: it ends within 1 s, with exit code 0.",
        try_out: end,
    },
];

/// Runs all trials of a plant at the sample time `h`; only the first, if that fails. Ends early when `stop`
/// is set.
///
/// # Errors
/// [`Error::Interrupted`]; whatever the plant does wrong is in its outcome.
pub fn run_plant(
    start: &StartPlant<'_>,
    h: SampleTime,
    stop: &AtomicBool,
) -> Result<Vec<TrialResult>, Error> {
    let bench = Bench { start, h };
    let mut outcomes = Vec::new();
    for trial in PLANT_TRIALS {
        if stop.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        let began = Instant::now();
        let (verdict, words) = match (trial.try_out)(&bench) {
            Ok(words) => (Verdict::Passed, words),
            Err(fault) => (Verdict::Failed, fault.to_string()),
        };
        outcomes.push(TrialResult {
            trial: trial.name,
            asks: trial.asks,
            verdict,
            words: vec![words],
            wall: began.elapsed(),
        });
        if outcomes.len() == 1 && verdict == Verdict::Failed {
            break;
        }
    }
    Ok(outcomes)
}

/// What starts the programs of the trials.
struct Bench<'a> {
    start: &'a StartPlant<'a>,
    h: SampleTime,
}

impl Bench<'_> {
    fn start(&self) -> Result<PlantProgram, PlantFault> {
        (self.start)(self.h)
    }

    /// As many inputs as fit into 2 s, of both signs.
    fn inputs(&self) -> Vec<f64> {
        const SPAN_NS: u64 = 2_000_000_000;
        let count = (SPAN_NS / self.h.ns()).clamp(20, 400) as usize;
        let sign = |k| if k < count / 2 { 1.0 } else { -0.5 };
        (0..count).map(sign).collect()
    }

    /// The outputs of a new program for the inputs, as fast as it goes.
    fn outputs(&self) -> Result<Vec<f64>, PlantFault> {
        let mut plant = self.start()?;
        outputs(&mut plant, &self.inputs())
    }
}

/// The outputs of a program for these inputs.
fn outputs(plant: &mut PlantProgram, inputs: &[f64]) -> Result<Vec<f64>, PlantFault> {
    let mut outputs = Vec::with_capacity(inputs.len());
    for &u in inputs {
        outputs.push(output(plant, u, outputs.len() + 1)?);
    }
    Ok(outputs)
}

/// The first output of step number `steps`, from 1; each input is `u`.
fn output(plant: &mut PlantProgram, u: f64, steps: usize) -> Result<f64, PlantFault> {
    let y = plant.step(Signals::zeros(plant.inputs()).map(|_| u), 0);
    match plant.problem() {
        Some(problem) => Err(PlantFault::Broken(problem)),
        None if !y.is_finite() => Err(PlantFault::NotFinite { steps, u, y }),
        None => Ok(y.first),
    }
}

fn start(bench: &Bench<'_>) -> Result<String, PlantFault> {
    let began = Instant::now();
    let plant = bench.start()?;
    let ready_s = began.elapsed().as_secs_f64();
    let (steps, u, y) = (0, 0.0, plant.at_rest());
    if !y.is_finite() {
        return Err(PlantFault::NotFinite { steps, u, y });
    }
    Ok(format!(
        "y is {y} before the first step; ready after {ready_s:.2} s"
    ))
}

fn steps(bench: &Bench<'_>) -> Result<String, PlantFault> {
    let mut plant = bench.start()?;
    let outputs = outputs(&mut plant, &bench.inputs())?;
    // What it prints beside comes a moment later, and is seen at the next step.
    thread::sleep(Duration::from_millis(50));
    output(&mut plant, 0.0, outputs.len() + 1)?;
    let least = outputs.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = outputs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Ok(format!(
        "{} steps, y from {least:.4} to {greatest:.4}",
        outputs.len()
    ))
}

fn rate(bench: &Bench<'_>) -> Result<String, PlantFault> {
    /// More than one step in so many must not take longer than h.
    const SLOW_OF: u64 = 20;
    let inputs = bench.inputs();
    let mut plant = bench.start()?;
    let began = Instant::now();
    let mut paced = Vec::new();
    for (k, &u) in (1..).zip(&inputs) {
        paced.push(output(&mut plant, u, k as usize)?);
        let due = Duration::from_nanos(bench.h.ns().saturating_mul(k));
        thread::sleep(due.saturating_sub(began.elapsed()));
    }
    let remedy = "advance by h at each step, whatever the clock says";
    same(
        "one u each h and all at once",
        &paced,
        &bench.outputs()?,
        remedy,
    )?;
    let report = plant.report();
    let slowest_ms = report.slowest_ns as f64 * 1e-6;
    if report.slow > report.steps / SLOW_OF {
        return Err(PlantFault::Slow {
            slow: report.slow,
            steps: report.steps,
            h: bench.h,
            slowest_ms,
        });
    }
    Ok(format!(
        "{} steps of {}, the slowest took {slowest_ms:.2} ms",
        report.steps, bench.h
    ))
}

fn repeat(bench: &Bench<'_>) -> Result<String, PlantFault> {
    let remedy = "begin anew at each start, and draw what is random from WEBLOOP_SEED";
    let (one, other) = (bench.outputs()?, bench.outputs()?);
    same("two starts", &one, &other, remedy)?;
    Ok(format!(
        "{} steps twice, the same to the last bit",
        one.len()
    ))
}

fn two(bench: &Bench<'_>) -> Result<String, PlantFault> {
    let (mut one, mut other) = (bench.start()?, bench.start()?);
    let (mut ones, mut others) = (Vec::new(), Vec::new());
    for (k, u) in (1..).zip(bench.inputs()) {
        ones.push(output(&mut one, u, k)?);
        others.push(output(&mut other, u, k)?);
    }
    let remedy = "keep nothing where another one finds it";
    same("two at once", &ones, &others, remedy)?;
    same(
        "two at once and one alone",
        &ones,
        &bench.outputs()?,
        remedy,
    )?;
    Ok(format!(
        "{} steps each, the same to the last bit",
        ones.len()
    ))
}

fn sample_time(bench: &Bench<'_>) -> Result<String, PlantFault> {
    let Ok(twice) = SampleTime::try_new(bench.h.ns().saturating_mul(2)) else {
        return Ok(format!("h = {} has no double", bench.h));
    };
    let inputs = vec![1.0; bench.inputs().len()];
    let mut plant = bench.start()?;
    let own = outputs(&mut plant, &inputs)?;
    let mut plant = (bench.start)(twice)?;
    let other = outputs(&mut plant, &inputs)?;
    if own != other {
        return Ok(format!("y differs between h = {} and {twice}", bench.h));
    }
    // A plant without memory has one y for one u, whatever h is.
    if own.windows(2).skip(1).all(|pair| pair[0] == pair[1]) {
        return Ok("y follows u at once: it has no state".to_owned());
    }
    Err(PlantFault::IgnoresH {
        h: bench.h,
        other: twice,
    })
}

fn extremes(bench: &Bench<'_>) -> Result<String, PlantFault> {
    const INPUTS: [f64; 8] = [1e6, -1e6, 1e9, -1e9, 1e-300, -0.0, 12_345_678.9, 0.0];
    let mut plant = bench.start()?;
    let last = outputs(&mut plant, &INPUTS)?.pop().unwrap_or_default();
    Ok(format!("u from -1e9 to 1e9; y is {last:.4} at the end"))
}

fn end(bench: &Bench<'_>) -> Result<String, PlantFault> {
    const IDLE: Duration = Duration::from_millis(1_500);
    let mut plant = bench.start()?;
    output(&mut plant, 1.0, 1)?;
    thread::sleep(IDLE);
    output(&mut plant, 1.0, 2)?;
    let began = Instant::now();
    match plant.end() {
        Some(0) => Ok(format!(
            "ended {:.2} s after its input",
            began.elapsed().as_secs_f64()
        )),
        Some(code) => Err(PlantFault::Code { code }),
        None => Err(PlantFault::RanOn),
    }
}

/// Compares the outputs of two programs bit by bit.
fn same(
    pair: &'static str,
    ones: &[f64],
    others: &[f64],
    remedy: &'static str,
) -> Result<(), PlantFault> {
    let differs = |(one, other): &(&f64, &f64)| one.to_bits() != other.to_bits();
    match ones.iter().zip(others).position(|pair| differs(&pair)) {
        None => Ok(()),
        Some(at) => Err(PlantFault::Differs {
            pair,
            steps: at + 1,
            one: ones[at],
            other: others[at],
            remedy,
        }),
    }
}

#[cfg(test)]
mod tests;
