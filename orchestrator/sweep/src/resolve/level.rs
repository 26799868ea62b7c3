//! From the values that a file gives for an axis to its levels: words, numbers, and steps between two.

use std::collections::BTreeSet;

use endpoint::InvalidSampleTime;
use text::{DAY_NS, Diagnostic, InvalidQuantity, duration_ns};
use toml::Spanned;

use super::Reader;
use crate::axis::Axis;
use crate::given::{Given, Word};
use crate::grid::{Level, Levels};
use crate::made::Unplayable;
use crate::number::brief;

/// Why a value of an axis is no level of it.
#[derive(Debug, thiserror::Error)]
pub(super) enum InvalidLevel {
    #[error("`{0}` is not a number; give one, such as 0.5")]
    NotANumber(String),
    #[error("the gain {0} is not finite; give a finite number")]
    Infinite(f64),
    #[error("{0} has no unit; write it as a text, like \"3ms\", \"1%\" or \"1mbit\"")]
    NoUnit(f64),
    #[error("{}; {}", .0, .0.remedy)]
    Quantity(#[from] InvalidQuantity),
    #[error(transparent)]
    SampleTime(#[from] InvalidSampleTime),
    /// A word of another type than the axis's, in that type's words.
    #[error("{0}")]
    Word(String),
    /// No text is found under this name or path, in the library's words.
    #[error("{0}")]
    Text(String),
    #[error(
        "the profile `{name}` cannot be played: {problem}; `webloop link lint {name}` shows where"
    )]
    Profile { name: String, problem: Unplayable },
    #[error("`{name}` is not a valid system: {}", .problem.inside())]
    System {
        name: String,
        problem: Box<Diagnostic>,
    },
    #[error(
        "`{0}` has a program, a second input or output, an actuator, a disturbance, a sensor, an x0 or a reference that \
         moves, which a sweep leaves out; run it as an experiment with --backend sim"
    )]
    LeftOut(String),
}

impl Reader<'_> {
    /// The levels of a gain; if the file gives none, `otherwise`, or each system's own gain.
    pub(super) fn gains(
        &self,
        axis: Axis,
        otherwise: Option<f64>,
    ) -> Result<Levels<Option<f64>>, Diagnostic> {
        if self.file.axes.get_ref().get(axis).is_none() && otherwise.is_none() {
            return Ok(Levels::new((None, said("own")), []));
        }
        self.numbers(
            axis,
            Some(&otherwise.unwrap_or_default().to_string()),
            |word| match word {
                Word::Number(number) => Ok(*number),
                Word::Text(text) => text
                    .parse()
                    .map_err(|_| InvalidLevel::NotANumber(text.clone())),
            },
            |gain: f64| {
                if gain.is_finite() {
                    Ok((Some(gain), number(gain)))
                } else {
                    Err(InvalidLevel::Infinite(gain))
                }
            },
        )
    }

    /// The levels of an axis of words; if the file gives none, `otherwise` is the only one.
    pub(super) fn words<T: Clone>(
        &self,
        axis: Axis,
        otherwise: Option<&str>,
        mut read: impl FnMut(&str) -> Result<(T, Level), InvalidLevel>,
    ) -> Result<Levels<T>, Diagnostic> {
        let given = self.given(axis, otherwise);
        if let Given::Range(range) = given.get_ref() {
            return Err(self.invalid(
                &range.from,
                format!("`{axis}` takes names, so there are no steps between two of them"),
                "write a list",
            ));
        }
        let mut levels = Vec::new();
        for word in listed(&given) {
            // A number counts as a word here: outstanding = 1.
            let text = match word.get_ref() {
                Word::Text(text) => text.clone(),
                Word::Number(number) => brief(*number),
            };
            let level =
                read(&text).map_err(|problem| self.invalid(&word, problem.to_string(), ""))?;
            levels.push((word, level));
        }
        self.levels(axis, &given, levels)
    }

    /// The levels of an axis of numbers: `read` reads a number from a word, `make` makes a level of it.
    pub(super) fn numbers<T: Clone>(
        &self,
        axis: Axis,
        otherwise: Option<&str>,
        read: impl Fn(&Word) -> Result<f64, InvalidLevel>,
        make: impl Fn(f64) -> Result<(T, Level), InvalidLevel>,
    ) -> Result<Levels<T>, Diagnostic> {
        let given = self.given(axis, otherwise);
        let number = |word: &Spanned<Word>| {
            read(word.get_ref()).map_err(|problem| self.invalid(word, problem.to_string(), ""))
        };
        let mut found = Vec::new();
        match given.get_ref() {
            Given::Range(range) => {
                let (from, to) = (number(&range.from)?, number(&range.to)?);
                if !(from.is_finite() && to.is_finite()) {
                    let problem = "steps need two finite numbers";
                    return Err(self.invalid(&range.from, problem, "give numbers, or a list"));
                }
                let steps = range.steps.get();
                let is_log = match &range.scale {
                    None => false,
                    Some(scale) => match scale.get_ref().as_str() {
                        "linear" => false,
                        "log" => true,
                        other => {
                            let problem = format!("`{other}` is not a scale");
                            return Err(self.invalid(scale, problem, "choose linear or log"));
                        }
                    },
                };
                if is_log && !(from > 0.0 && to > 0.0) {
                    let problem = "a logarithmic scale needs values above zero";
                    return Err(self.invalid(&range.from, problem, "begin above zero"));
                }
                for step in 0..steps {
                    let part = f64::from(step) / f64::from(steps - 1);
                    let value = if is_log {
                        from * (to / from).powf(part)
                    } else {
                        from + (to - from) * part
                    };
                    found.push((range.from.clone(), tidy(value)));
                }
            }
            Given::One(_) | Given::Many(_) => {
                for word in listed(&given) {
                    let value = number(&word)?;
                    found.push((word, value));
                }
            }
        }
        let mut levels = Vec::new();
        for (word, value) in found {
            let level =
                make(value).map_err(|problem| self.invalid(&word, problem.to_string(), ""))?;
            levels.push((word, level));
        }
        self.levels(axis, &given, levels)
    }

    /// The values that the file gives for an axis.
    fn given(&self, axis: Axis, otherwise: Option<&str>) -> Spanned<Given> {
        let given = self.file.axes.get_ref().get(axis).cloned();
        given.unwrap_or_else(|| {
            let word = Word::Text(otherwise.unwrap_or_default().to_owned());
            Spanned::new(0..0, Given::One(word))
        })
    }

    /// Checks that there is at least one level, and none twice.
    fn levels<T: Clone>(
        &self,
        axis: Axis,
        given: &Spanned<Given>,
        levels: Vec<(Spanned<Word>, (T, Level))>,
    ) -> Result<Levels<T>, Diagnostic> {
        let mut seen = BTreeSet::new();
        for (word, (_, level)) in &levels {
            if !seen.insert(level.text.clone()) {
                let problem = format!("`{axis}` has {} twice", level.text);
                return Err(self.invalid(word, problem, "leave one out"));
            }
        }
        let mut levels = levels.into_iter().map(|(_, level)| level);
        match levels.next() {
            Some(first) => Ok(Levels::new(first, levels)),
            None => Err(self.invalid(
                given,
                format!("`{axis}` has no value"),
                "give one, or leave the key out",
            )),
        }
    }
}

/// The values of an axis that is given as one or as a list.
fn listed(given: &Spanned<Given>) -> Vec<Spanned<Word>> {
    match given.get_ref() {
        Given::One(word) => vec![Spanned::new(given.span(), word.clone())],
        Given::Many(words) => words.clone(),
        Given::Range(_) => Vec::new(),
    }
}

pub(super) fn text(word: &Word) -> Result<&str, InvalidLevel> {
    match word {
        Word::Text(text) => Ok(text),
        Word::Number(number) => Err(InvalidLevel::NoUnit(*number)),
    }
}

pub(super) fn duration_ns_of(word: &Word) -> Result<f64, InvalidLevel> {
    Ok(duration_ns(text(word)?, 0..=DAY_NS)? as f64)
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
