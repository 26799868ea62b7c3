//! Margins of a plant that is a program: nothing is known of it but what it answers, so its border is by simulation.

use analysis::LoopVerdict;
use analysis::layout::{Column, align, digits, number, text};
use anyhow::anyhow;
use control::Analysis;
use endpoint::SampleTime;
use plan::system::{Program, System};

use super::border::{Border, border};
use super::lockstep::{Lockstep, Seen};
use crate::exit::Failure;

/// Steps of 1 % up to a factor of a thousand.
const MOST_STEPS: usize = 694;
/// The part of a run that a delay may take up and still be judged.
const MOST_DELAY: usize = 4;

/// By which rule a run is on the near side of a border.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rule {
    /// It holds, well or badly.
    Holds,
    /// What moves y dies out.
    DiesOut,
}

impl Rule {
    const ALL: [Rule; 2] = [Rule::Holds, Rule::DiesOut];

    fn word(self) -> &'static str {
        match self {
            Rule::Holds => "holds",
            Rule::DiesOut => "dies out",
        }
    }

    fn is_met(self, seen: Seen) -> bool {
        match self {
            Rule::Holds => seen.verdict.is_held(),
            Rule::DiesOut => seen.dies_out == Some(true),
        }
    }
}

/// What was found of the loop at a sample time.
pub(super) struct Own {
    pub(super) h: SampleTime,
    runs: usize,
    /// The loop as it is.
    as_it_is: Seen,
    borders: Vec<(Rule, Borders)>,
}

/// The borders by one rule.
struct Borders {
    louder: Border,
    quieter: Border,
    later: Border,
}

impl Own {
    /// Finds the borders of a system in this file, whose plant is `program`, at a sample time.
    pub(super) fn look(
        system: &System,
        file: &str,
        program: &Program,
        h: SampleTime,
        duration_ns: u64,
    ) -> Result<Own, Failure> {
        let mut of = Lockstep::new(system, file, program.clone(), h, duration_ns)?;
        // A verdict needs parts, and each needs samples.
        const LEAST_TICKS: usize = 20;
        if of.ticks() < LEAST_TICKS {
            return Err(Failure::usage(anyhow!(
                "a run of {} samples at h = {h} is too short to judge; give a --duration of {LEAST_TICKS} sample times or more, or a \
                 shorter --h",
                of.ticks()
            )));
        }
        let as_it_is = of.run(0, 0)?;
        let mut borders = Vec::new();
        for rule in Rule::ALL {
            if rule == Rule::DiesOut && as_it_is.dies_out.is_none() {
                continue;
            }
            let most = of.ticks() / MOST_DELAY;
            borders.push((
                rule,
                Borders {
                    louder: border(MOST_STEPS, |k| {
                        of.run(k.cast_signed(), 0).map(|seen| rule.is_met(seen))
                    })?,
                    quieter: border(MOST_STEPS, |k| {
                        of.run(-k.cast_signed(), 0).map(|seen| rule.is_met(seen))
                    })?,
                    later: border(most, |k| of.run(0, k).map(|seen| rule.is_met(seen)))?,
                },
            ));
        }
        Ok(Own {
            h: of.h(),
            runs: of.runs(),
            as_it_is,
            borders,
        })
    }

    /// The longest constant round trip at which it holds, as at every shorter one that was tried, in seconds.
    pub(super) fn longest_s(&self) -> Option<f64> {
        let (_, of) = self.borders.iter().find(|(rule, _)| *rule == Rule::Holds)?;
        match of.later {
            Border::Nowhere => None,
            Border::After(ticks) | Border::Beyond(ticks) => {
                Some((ticks + Analysis::SHORTEST_TICKS - 1) as f64 * self.h.seconds())
            }
        }
    }
}

/// The borders of loops as a table, and what is to be said of them.
pub(super) fn of_programs(loops: &[Own], duration_ns: u64) -> String {
    const COLUMNS: [Column; 8] = [
        number("", "h"),
        text("still"),
        number("gain up", "at"),
        number("gain up", "not at"),
        number("gain down", "at"),
        number("gain down", "not at"),
        number("further delay/ms", "at"),
        number("further delay/ms", "not at"),
    ];
    let mut rows = Vec::new();
    let mut notes = String::new();
    for of in loops {
        for (rule, found) in &of.borders {
            let mut row = vec![of.h.to_string(), rule.word().to_owned()];
            let gain = |sign: isize| move |k: usize| Lockstep::factor(sign * k.cast_signed());
            row.extend(bracket(found.louder, gain(1)));
            row.extend(bracket(found.quieter, gain(-1)));
            row.extend(bracket(found.later, |k| k as f64 * of.h.seconds() * 1e3));
            rows.push(row);
        }
        notes += &told(of);
    }
    let runs: usize = loops.iter().map(|of| of.runs).sum();
    format!(
        "By simulation: {runs} runs of {} s, each from a fresh start of the program.\n\n{}{notes}",
        duration_ns as f64 / 1e9,
        align(&COLUMNS, &rows)
    )
}

/// The last that is met, and the first that is not.
fn bracket(found: Border, size: impl Fn(usize) -> f64) -> [String; 2] {
    let [some, none] = ["any", "-"].map(str::to_owned);
    match found {
        Border::Nowhere => [none.clone(), none],
        Border::After(k) => [k, k + 1].map(|k| digits(Some(size(k)))),
        Border::Beyond(_) => [some, none],
    }
}

/// Why there is no border, where the loop as it is does not hold.
fn told(of: &Own) -> String {
    let Seen {
        verdict, reason, ..
    } = of.as_it_is;
    if verdict.is_held() {
        return String::new();
    }
    let why = reason.map_or_else(String::new, |reason| format!(": {reason}"));
    let remedy = match verdict {
        LoopVerdict::Unsettled => ". Give a longer --duration, or the plant a wider `band`",
        _ => "",
    };
    let is_found = match verdict {
        LoopVerdict::Unsettled => "does not settle",
        _ => "is lost",
    };
    format!(
        "\nAt h = {} the loop with its own gains {is_found}{why}{remedy}.\n",
        of.h
    )
}
