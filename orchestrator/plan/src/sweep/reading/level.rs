//! From the words that are given for an axis to its levels: names, numbers, and steps between two numbers.

use std::collections::BTreeSet;

use endpoint::InvalidSampleTime;
use text::{DAY_NS, Diagnostic, InvalidQuantity, duration_ns};
use toml::Spanned;

use super::Reading;
use crate::sweep::axis::Axis;
use crate::sweep::grid::{Level, Levels};
use crate::sweep::number::brief;

/// Fewest and most levels that are steps between two numbers: more than the points of a figure.
const STEPS: std::ops::RangeInclusive<u32> = 2..=10_000;

/// Why a word is no level of its axis.
#[derive(Debug, thiserror::Error)]
pub(super) enum InvalidLevel {
    #[error("`{0}` is not a number; give one, such as 0.5")]
    NotANumber(String),
    #[error("the gain {0} is not finite; give a finite number")]
    Infinite(f64),
    #[error("{}; {}", .0, .0.remedy)]
    Quantity(#[from] InvalidQuantity),
    #[error(transparent)]
    SampleTime(#[from] InvalidSampleTime),
    /// A word of another type than the axis's, in that type's words.
    #[error("{0}")]
    Word(String),
    #[error(
        "`{0}` has a program, a second input or output, an actuator, a disturbance, a sensor, an x0 or a reference that \
         moves, which a sweep leaves out; run it in [[cells]] with --backend sim"
    )]
    LeftOut(String),
    #[error(
        "`{0}` are no steps; write {first} to {last} of them, like \"21 from 0ms to 40ms\" or \"10 log from 1ms to 1s\"",
        first = STEPS.start(), last = STEPS.end()
    )]
    Steps(String),
    #[error("steps need two finite numbers; give numbers, or a list")]
    Endless,
    #[error("logarithmic steps need numbers above zero; begin above zero")]
    Logarithm,
}

impl Reading<'_> {
    /// The levels of a gain; if none is given, `otherwise`, or each system's own gain.
    pub(super) fn gains(
        &self,
        axis: Axis,
        otherwise: Option<f64>,
    ) -> Result<Levels<Option<f64>>, Diagnostic> {
        if !self.axes.contains_key(&axis) && otherwise.is_none() {
            return Ok(Levels::new((None, said("own")), []));
        }
        let read = |word: &str| {
            word.parse()
                .map_err(|_| InvalidLevel::NotANumber(word.to_owned()))
        };
        let otherwise = otherwise.unwrap_or_default().to_string();
        self.numbers(axis, &otherwise, read, |gain: f64| {
            if gain.is_finite() {
                Ok((Some(gain), number(gain)))
            } else {
                Err(InvalidLevel::Infinite(gain))
            }
        })
    }

    /// The levels of an axis of words; if none is given, `otherwise` is the only one.
    pub(super) fn words<T: Clone>(
        &self,
        axis: Axis,
        otherwise: &str,
        mut read: impl FnMut(&str) -> Result<(T, Level), InvalidLevel>,
    ) -> Result<Levels<T>, Diagnostic> {
        self.levels(axis, otherwise, |word| Ok(vec![read(word)?]))
    }

    /// The levels of an axis of numbers: `read` reads a number from a word, `make` makes a level of it.
    pub(super) fn numbers<T: Clone>(
        &self,
        axis: Axis,
        otherwise: &str,
        read: impl Fn(&str) -> Result<f64, InvalidLevel>,
        make: impl Fn(f64) -> Result<(T, Level), InvalidLevel>,
    ) -> Result<Levels<T>, Diagnostic> {
        self.levels(axis, otherwise, |word| {
            let numbers = match Steps::of(word)? {
                Some(steps) => steps.numbers(read(steps.from)?, read(steps.to)?)?,
                None => vec![read(word)?],
            };
            numbers.into_iter().map(&make).collect()
        })
    }

    /// The levels of an axis, of which `read` makes some from each word: at least one, and none twice.
    fn levels<T: Clone>(
        &self,
        axis: Axis,
        otherwise: &str,
        mut read: impl FnMut(&str) -> Result<Vec<(T, Level)>, InvalidLevel>,
    ) -> Result<Levels<T>, Diagnostic> {
        let only = || Spanned::new(0..0, vec![Spanned::new(0..0, otherwise.to_owned())]);
        let given = self.axes.get(&axis).cloned().unwrap_or_else(only);
        let (mut seen, mut levels) = (BTreeSet::new(), Vec::new());
        for word in given.get_ref() {
            let invalid = |problem: InvalidLevel| self.invalid(word, problem.to_string());
            for level in read(word.get_ref()).map_err(invalid)? {
                if !seen.insert(level.1.text.clone()) {
                    let problem = format!("`{axis}` has {} twice; leave one out", level.1.text);
                    return Err(self.invalid(word, problem));
                }
                levels.push(level);
            }
        }
        let mut levels = levels.into_iter();
        match levels.next() {
            Some(first) => Ok(Levels::new(first, levels)),
            None => {
                let problem = format!("`{axis}` has no value; give one, or leave the key out");
                Err(self.invalid(&given, problem))
            }
        }
    }

    fn invalid<T>(&self, at: &Spanned<T>, problem: String) -> Diagnostic {
        self.text.invalid(at, problem, "")
    }
}

/// So many numbers between two, both included.
struct Steps<'a> {
    count: u32,
    scale: Scale,
    from: &'a str,
    to: &'a str,
}

/// How they are spaced.
enum Scale {
    Linear,
    Log,
}

impl<'a> Steps<'a> {
    /// The steps that a word describes; `None` if it is a number by itself.
    fn of(word: &'a str) -> Result<Option<Self>, InvalidLevel> {
        let Some((count, ends)) = word.split_once(" from ") else {
            return Ok(None);
        };
        let (count, scale) = match count.split_once(' ') {
            None => (count, Some(Scale::Linear)),
            Some((count, "log")) => (count, Some(Scale::Log)),
            Some((count, _)) => (count, None),
        };
        let count = count.parse().ok().filter(|count| STEPS.contains(count));
        let steps =
            count
                .zip(scale)
                .zip(ends.split_once(" to "))
                .map(|((count, scale), (from, to))| Steps {
                    count,
                    scale,
                    from,
                    to,
                });
        match steps {
            None => Err(InvalidLevel::Steps(word.to_owned())),
            found => Ok(found),
        }
    }

    /// The numbers, of which the ends are these.
    fn numbers(&self, from: f64, to: f64) -> Result<Vec<f64>, InvalidLevel> {
        if !(from.is_finite() && to.is_finite()) {
            return Err(InvalidLevel::Endless);
        }
        if matches!(self.scale, Scale::Log) && !(from > 0.0 && to > 0.0) {
            return Err(InvalidLevel::Logarithm);
        }
        let numbers = (0..self.count).map(|step| {
            let part = f64::from(step) / f64::from(self.count - 1);
            tidy(match self.scale {
                Scale::Linear => from + (to - from) * part,
                Scale::Log => from * (to / from).powf(part),
            })
        });
        Ok(numbers.collect())
    }
}

pub(super) fn duration_ns_of(word: &str) -> Result<f64, InvalidLevel> {
    Ok(duration_ns(word, 0..=DAY_NS)? as f64)
}

pub(super) fn parsed<T: std::str::FromStr<Err: std::fmt::Display>>(
    word: &str,
) -> Result<T, InvalidLevel> {
    word.parse()
        .map_err(|why: T::Err| InvalidLevel::Word(why.to_string()))
}

pub(super) fn said(word: impl std::fmt::Display) -> Level {
    Level {
        text: word.to_string(),
        number: None,
    }
}

pub(super) fn number(number: f64) -> Level {
    let text = brief(number);
    Level {
        number: text.parse().ok(),
        text,
    }
}

/// A step without rounding noise: 0.15 and not 0.15000000000000002.
fn tidy(number: f64) -> f64 {
    brief(number).parse().unwrap_or(number)
}
