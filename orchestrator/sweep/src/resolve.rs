//! From a sweep's TOML to a [`Sweep`]: checks every value, and gives the position of every error.
//!
//! The caller reads files and passes in the texts and a way to look up profiles. `level` turns the
//! values of an axis into its levels.

mod level;

use std::sync::Arc;

use control::preset;
use endpoint::{Outstanding, SampleTime};
use plan::Library;
use system::System;
use text::{Diagnostic, TomlText, rate_bps, share};
use toml::Spanned;

use crate::axis::Axis;
use crate::file::{RUNS_MAX, SweepFile};
use crate::given::{Given, Word};
use crate::grid::{Grid, Level, Levels, Links};
use crate::machine::Machine;
use crate::made::{Made, Unplayable};
use crate::point::Point;
use crate::sweep::{Instead, Sweep};

use level::{InvalidLevel, duration_ns_of, number, parsed, said, text};

/// Fewest and most samples of a response: enough to compare its quarters, and few enough to fit into
/// memory once per core.
const SAMPLES: std::ops::RangeInclusive<u64> = 40..=20_000_000;
/// How long a made link's jitter keeps its value by default: within the range that suits diego-vpn.
const HOLD_NS: u64 = 50_000_000;

/// Looks up texts by name or path, or says why it cannot.
type Texts<'a> = &'a mut dyn Library;

impl Sweep {
    /// Resolves a sweep's TOML.
    ///
    /// `origin` names the text in errors, `instead` replaces parts of it.
    ///
    /// # Errors
    /// [`Diagnostic`], with line and column, if the text is not a sweep that can run.
    pub fn resolve(
        source: &str,
        origin: &str,
        instead: &Instead,
        mut library: impl Library,
    ) -> Result<Sweep, Diagnostic> {
        let text = plan::Reader(TomlText {
            text: source,
            origin,
        });
        let mut file: SweepFile =
            text.parse("the book's page Virtual time and sweeps has an example")?;
        for (axis, word) in &instead.fixed {
            let axes = file.axes.get_mut();
            let span = axes.get(*axis).map_or(0..0, Spanned::span);
            let given = Given::One(Word::Text(word.clone()));
            axes.set(*axis, Spanned::new(span, given));
        }
        let reader = Reader { text, file: &file };
        let sweep = Sweep {
            name: text.name(&file.name)?,
            about: file.about.clone(),
            duration_ns: text.duration(&file.duration)?,
            repeats: file.repeats.get(),
            seed: instead.seed.unwrap_or(file.seed),
            rho: reader.rho()?,
            grid: reader.grid(&mut library)?,
        };
        reader.size(&sweep)?;
        Ok(sweep)
    }
}

/// The text being read, for the positions of errors.
struct Reader<'a> {
    text: plan::Reader<'a>,
    file: &'a SweepFile,
}

impl Reader<'_> {
    fn invalid<T>(&self, at: &Spanned<T>, problem: impl Into<String>, remedy: &str) -> Diagnostic {
        self.text.invalid(at, problem, remedy)
    }

    fn rho(&self) -> Result<f64, Diagnostic> {
        let rho = *self.file.rho.get_ref();
        if rho.is_finite() && rho >= 0.0 {
            Ok(rho)
        } else {
            Err(self.invalid(
                &self.file.rho,
                format!("`rho` is {rho}, which is not a cost"),
                "give 0 or more: the cost of a squared command relative to a squared error",
            ))
        }
    }

    fn grid(&self, library: Texts<'_>) -> Result<Grid, Diagnostic> {
        let links = self.links(library)?;
        // Over a named link the question is what `run` would see; over a made link, what the delay does.
        let client = match &links {
            Links::Named(_) => "native",
            Links::Made { .. } => "ideal",
        };
        let system = self.systems(library)?;
        // With the paper's system alone, its own gains can be given as numbers.
        let is_paper = matches!(system.values(), [only] if only.is_paper());
        let grid = Grid {
            client: self.words(Axis::Client, Some(client), |word| {
                let machine: Machine = parsed(word)?;
                Ok((machine, said(machine)))
            })?,
            h: self.numbers(Axis::H, Some("3ms"), duration_ns_of, |ns| {
                let h = SampleTime::try_new(ns as u64)?;
                Ok((h, number(h.ns() as f64 / 1e6)))
            })?,
            outstanding: self.words(Axis::Outstanding, Some("unlimited"), |word| {
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
    fn links(&self, library: Texts<'_>) -> Result<Links, Diagnostic> {
        let axes = self.file.axes.get_ref();
        let made = Axis::ALL
            .into_iter()
            .filter(|axis| axis.makes_a_link())
            .find_map(|axis| axes.get(axis).map(|given| (axis, given)));
        match (axes.get(Axis::Topology), made) {
            (Some(_), Some((axis, given))) => Err(self.invalid(
                given,
                format!("the link is described twice: `topology` names it, and `{axis}` makes one"),
                "leave out `topology`, or all of rtt, jitter, loss and rate",
            )),
            (Some(_), None) => self.topologies(library).map(Links::Named),
            (None, None) => Err(self.invalid(
                &self.file.axes,
                "the sweep has no link",
                "add `rtt`, such as rtt = \"50ms\", or `topology`, such as topology = [\"couva\"]",
            )),
            (None, Some(_)) => self.made(),
        }
    }

    fn topologies(&self, library: Texts<'_>) -> Result<Levels<Arc<link::Profile>>, Diagnostic> {
        self.words(Axis::Topology, None, |asked| {
            let text = library.profile(asked).map_err(|problem| {
                let names = link::Profile::BUILTIN.join(", ");
                let remedy = format!("use one of {names}, or the path of a profile file");
                InvalidLevel::Text(format!("{problem}; {remedy}"))
            })?;
            let parsed = text
                .profile(asked)
                .map_err(|findings| InvalidLevel::Profile {
                    name: asked.to_owned(),
                    problem: Unplayable(findings),
                })?;
            let level = said(parsed.name());
            Ok((Arc::new(parsed), level))
        })
    }

    fn systems(&self, library: Texts<'_>) -> Result<Levels<Arc<System>>, Diagnostic> {
        self.words(Axis::System, Some(System::PAPER), |asked| {
            let text = library.system(asked).map_err(|problem| {
                let names: Vec<&str> = System::built_in_names().collect();
                let names = names.join(", ");
                let remedy = format!("use one of {names}, or the path of a system file");
                InvalidLevel::Text(format!("{problem}; {remedy}"))
            })?;
            let system = System::read(&text).map_err(|problem| InvalidLevel::System {
                name: asked.to_owned(),
                problem: Box::new(problem),
            })?;
            let is_plain = system.surroundings().is_none() && system.reference().is_none();
            if !system.is_single() || !is_plain {
                return Err(InvalidLevel::LeftOut(asked.to_owned()));
            }
            let level = said(system.name());
            Ok((Arc::new(system), level))
        })
    }

    fn made(&self) -> Result<Links, Diagnostic> {
        let time = |ns: f64| Ok((ns.round() as u64, number(ns.round() / 1e6)));
        let hold_ns = match &self.file.hold {
            Some(hold) => self.text.duration(hold)?,
            None => HOLD_NS,
        };
        Ok(Links::Made {
            rtt_ns: self.numbers(Axis::Rtt, Some("0ms"), duration_ns_of, time)?,
            jitter_ns: self.numbers(Axis::Jitter, Some("0ms"), duration_ns_of, time)?,
            loss: self.numbers(
                Axis::Loss,
                Some("0%"),
                |word| Ok(share(text(word)?)?),
                |loss| Ok((loss, number(loss * 100.0))),
            )?,
            rate_bps: self.numbers(
                Axis::Rate,
                Some("none"),
                |word| match text(word)? {
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
            hold_ns,
        })
    }

    /// Checks what depends on several values: made links that cannot be played, loops that do not
    /// exist, responses with too few or too many samples.
    fn check(&self, grid: &Grid) -> Result<(), Diagnostic> {
        let duration_ns = self.text.duration(&self.file.duration)?;
        for h in grid.h.values() {
            let samples = duration_ns / h.ns();
            if !SAMPLES.contains(&samples) {
                return Err(self.invalid(
                    &self.file.duration,
                    format!("a run would have {samples} samples at h = {h}"),
                    &format!(
                        "give a duration and an h that make {} to {}",
                        SAMPLES.start(),
                        SAMPLES.end()
                    ),
                ));
            }
        }
        if let Links::Made {
            rtt_ns,
            jitter_ns,
            loss,
            rate_bps,
            hold_ns,
        } = &grid.links
        {
            let most = |values: &[u64]| values.iter().copied().max().unwrap_or(0);
            let worst = Made {
                rtt_ns: most(rtt_ns.values()),
                jitter_ns: most(jitter_ns.values()),
                loss: loss.values().iter().copied().fold(0.0, f64::max),
                // The slowest rate.
                rate_bps: rate_bps.values().iter().copied().flatten().min(),
                hold_ns: *hold_ns,
            };
            worst.profile().map_err(|problem| {
                self.invalid(
                    &self.file.axes,
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
            point
                .design()
                .map_err(|problem| self.invalid(&self.file.axes, problem.to_string(), ""))?;
        }
        Ok(())
    }

    fn size(&self, sweep: &Sweep) -> Result<(), Diagnostic> {
        let runs = sweep.grid.points().saturating_mul(sweep.repeats as usize);
        if runs <= RUNS_MAX as usize {
            Ok(())
        } else {
            Err(self.invalid(
                &self.file.axes,
                format!("the sweep has {runs} runs, more than {RUNS_MAX}"),
                "take fewer steps or repeats, or --fix an axis",
            ))
        }
    }
}
