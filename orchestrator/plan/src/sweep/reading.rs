//! From the words of a sweep to its grid: checks every value, and gives the position of every error.
//!
//! `level` turns the words of an axis into its levels. Texts of profiles and systems were looked up before.

mod level;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use crate::system::System;
use control::preset;
use endpoint::{Outstanding, SampleTime};
use text::{Diagnostic, rate_bps, share};
use toml::Spanned;

use crate::invalid::{Reader, Word};
use crate::profile_text::ProfileText;
use crate::sweep::Sweep;
use crate::sweep::axis::Axis;
use crate::sweep::grid::{Grid, Level, Levels, Links};
use crate::sweep::machine::Machine;
use crate::sweep::made::Unplayable;
use crate::sweep::point::Point;
use crate::sweep::table::RUNS_MAX;
use crate::sweep::text::SweepText;

use level::{InvalidLevel, duration_ns_of, number, parsed, said};

/// Fewest and most samples of a response: enough to compare its quarters, and few enough to fit into
/// memory once per core.
const SAMPLES: std::ops::RangeInclusive<u64> = 40..=20_000_000;

/// Where parts of a sweep are in a text; nowhere, by default.
#[derive(Default)]
pub(crate) struct Places {
    pub(crate) whole: Range<usize>,
    pub(crate) duration: Range<usize>,
    pub(crate) rho: Range<usize>,
}

/// A sweep that is being read: from an experiment, where each word has its place, or from a plan, where none has.
pub(crate) struct Reading<'a> {
    /// The text, for the positions of errors.
    pub(crate) text: Reader<'a>,
    /// Where parts of the sweep are in it.
    pub(crate) places: Places,
    /// The words of each axis that has any.
    pub(crate) axes: BTreeMap<Axis, Spanned<Vec<Word>>>,
    /// What all runs have in common.
    pub(crate) common: &'a SweepText,
    /// The profiles and the systems beside the paper's, by their names.
    pub(crate) profiles: &'a BTreeMap<String, ProfileText>,
    pub(crate) systems: &'a BTreeMap<String, String>,
}

impl Reading<'_> {
    /// The sweep, without its name, its question and its seed.
    ///
    /// # Errors
    /// [`Diagnostic`] at the first word that is wrong.
    pub(crate) fn sweep(&self) -> Result<Sweep, Diagnostic> {
        let SweepText {
            duration_ns,
            repeats,
            rho,
            ..
        } = *self.common;
        if !(rho.is_finite() && rho >= 0.0) {
            return Err(self.wrong(
                &self.places.rho,
                format!("`rho` is {rho}, which is not a cost"),
                "give 0 or more: the cost of a squared command relative to a squared error",
            ));
        }
        let sweep = Sweep {
            name: String::new(),
            about: String::new(),
            duration_ns,
            repeats,
            seed: 0,
            rho,
            grid: self.grid()?,
        };
        let runs = sweep.runs();
        if (1..=RUNS_MAX as usize).contains(&runs) {
            return Ok(sweep);
        }
        let problem = format!("the sweep has {runs} runs, and 1 to {RUNS_MAX} are possible");
        Err(self.wrong(
            &self.places.whole,
            problem,
            "take fewer steps or repeats, or --fix an axis",
        ))
    }

    /// An error about what depends on several values.
    fn wrong(&self, at: &Range<usize>, problem: impl Into<String>, remedy: &str) -> Diagnostic {
        let place = Spanned::new(at.clone(), ());
        self.text.invalid(&place, problem, remedy)
    }

    fn grid(&self) -> Result<Grid, Diagnostic> {
        let links = self.links()?;
        // Over a named link the question is what `run` would see; over a made link, what the delay does.
        let client = match &links {
            Links::Named(_) => "native",
            Links::Made { .. } => "ideal",
        };
        let system = self.system_levels()?;
        // With the paper's system alone, its own gains can be given as numbers.
        let is_paper = matches!(system.values(), [only] if only.is_paper());
        let grid = Grid {
            client: self.words(Axis::Client, client, |word| {
                let machine: Machine = parsed(word)?;
                Ok((machine, said(machine)))
            })?,
            h: self.numbers(Axis::H, "3ms", duration_ns_of, |ns| {
                let h = SampleTime::try_new(ns as u64)?;
                Ok((h, number(h.ns() as f64 / 1e6)))
            })?,
            outstanding: self.words(Axis::Outstanding, "unlimited", |word| {
                let outstanding: Outstanding = parsed(word)?;
                let level = Level {
                    number: word.parse().ok(),
                    ..said(outstanding)
                };
                Ok((outstanding, level))
            })?,
            kp: self.gains(Axis::Kp, is_paper.then_some(preset::PAPER_A0))?,
            ki: self.gains(Axis::Ki, is_paper.then_some(preset::PAPER_A1))?,
            system,
            links,
        };
        self.check(&grid)?;
        Ok(grid)
    }

    /// The links: whole ones, or ones made of numbers, but not both.
    fn links(&self) -> Result<Links, Diagnostic> {
        let mut given = self.axes.iter();
        let made = given.find(|(axis, _)| axis.makes_a_link());
        match (self.axes.contains_key(&Axis::Topology), made) {
            (true, Some((axis, given))) => Err(self.text.invalid(
                given,
                format!("the link is described twice: `topology` names it, and `{axis}` makes one"),
                "leave out `topology`, or all of rtt, jitter, loss and rate",
            )),
            (true, None) => self.topologies().map(Links::Named),
            (false, None) => Err(self.wrong(
                &self.places.whole,
                "the sweep has no link",
                "add `rtt`, such as rtt = \"50ms\", or `topology`, such as topology = [\"couva\"]",
            )),
            (false, Some(_)) => self.made(),
        }
    }

    fn topologies(&self) -> Result<Levels<Arc<link::Profile>>, Diagnostic> {
        self.words(Axis::Topology, "", |name| {
            let text = self.profiles.get(name);
            let text = text
                .ok_or_else(|| InvalidLevel::Word(format!("`{name}` is none of the profiles")))?;
            let profile = text
                .profile(name)
                .map_err(|findings| InvalidLevel::Word(Unplayable(findings).to_string()))?;
            Ok((Arc::new(profile), said(name)))
        })
    }

    fn system_levels(&self) -> Result<Levels<Arc<System>>, Diagnostic> {
        self.words(Axis::System, System::PAPER, |name| {
            let system = match self.systems.get(name) {
                Some(text) => {
                    System::read(text).map_err(|problem| InvalidLevel::Word(problem.to_string()))?
                }
                None if name == System::PAPER => System::paper(),
                None => {
                    let problem = format!("`{name}` is none of the systems");
                    return Err(InvalidLevel::Word(problem));
                }
            };
            let is_plain = system.surroundings().is_none() && system.reference().is_none();
            if !system.is_single() || !is_plain {
                return Err(InvalidLevel::LeftOut(name.to_owned()));
            }
            Ok((Arc::new(system), said(name)))
        })
    }

    fn made(&self) -> Result<Links, Diagnostic> {
        let time = |ns: f64| Ok((ns.round() as u64, number(ns.round() / 1e6)));
        Ok(Links::Made {
            rtt_ns: self.numbers(Axis::Rtt, "0ms", duration_ns_of, time)?,
            jitter_ns: self.numbers(Axis::Jitter, "0ms", duration_ns_of, time)?,
            loss: self.numbers(
                Axis::Loss,
                "0%",
                |word| Ok(share(word)?),
                |loss| Ok((loss, number(loss * 100.0))),
            )?,
            rate_bps: self.numbers(
                Axis::Rate,
                "none",
                |word| match word {
                    "none" => Ok(f64::INFINITY),
                    rate => Ok(rate_bps(rate)? as f64),
                },
                |bps| {
                    if bps.is_infinite() {
                        Ok((None, said("none")))
                    } else {
                        Ok((Some(bps as u64), number(bps.round())))
                    }
                },
            )?,
            hold_ns: self.common.hold_ns,
        })
    }

    /// Checks what depends on several values: made links that cannot be played, loops that do not
    /// exist, responses with too few or too many samples.
    fn check(&self, grid: &Grid) -> Result<(), Diagnostic> {
        for h in grid.h.values() {
            let samples = self.common.duration_ns / h.ns();
            if !SAMPLES.contains(&samples) {
                return Err(self.wrong(
                    &self.places.duration,
                    format!("a run would have {samples} samples at h = {h}"),
                    &format!(
                        "give a duration and an h that make {} to {}",
                        SAMPLES.start(),
                        SAMPLES.end()
                    ),
                ));
            }
        }
        if let Some(worst) = grid.links.worst() {
            worst.profile().map_err(|problem| {
                self.wrong(
                    &self.places.whole,
                    format!("the worst of its links cannot be played: {problem}"),
                    "the longest round trip, the most jitter and loss, and the slowest rate make it",
                )
            })?;
        }
        for (h, system) in grid.h.values().iter().flat_map(|h| {
            let systems = grid.system.values().iter();
            systems.map(move |system| (h, system))
        }) {
            let point = Point {
                h: *h,
                system: Arc::clone(system),
                ..grid.point(0)
            };
            point.design().map_err(|problem| {
                self.wrong(
                    &self.places.whole,
                    problem.to_string(),
                    "use another h, or other systems or gains",
                )
            })?;
        }
        Ok(())
    }
}
