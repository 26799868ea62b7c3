//! From the values that a file gives for an axis to its levels: words, numbers, and steps between two.

use std::collections::BTreeSet;

use link::duration_ns;
use plan::InvalidFile;
use toml::Spanned;

use super::Reader;
use crate::axis::Axis;
use crate::given::{Given, Word};
use crate::grid::{Level, Levels};
use crate::number::brief;

/// Most levels of one axis: more than the points of a figure.
const LEVELS_MAX: u32 = 10_000;

impl Reader<'_> {
    /// The levels of a gain; if the file gives none, `otherwise`, or each system's own gain.
    pub(super) fn gains(
        &self,
        axis: Axis,
        otherwise: Option<f64>,
    ) -> Result<Levels<Option<f64>>, InvalidFile> {
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
                    .map_err(|_| format!("`{text}` is not a number")),
            },
            |gain: f64| {
                if gain.is_finite() {
                    Ok((Some(gain), number(gain)))
                } else {
                    Err(format!("the gain {gain} is not finite"))
                }
            },
        )
    }

    /// The levels of an axis of words; if the file gives none, `otherwise` is the only one.
    pub(super) fn words<T: Clone>(
        &self,
        axis: Axis,
        otherwise: Option<&str>,
        mut read: impl FnMut(&str) -> Result<(T, Level), String>,
    ) -> Result<Levels<T>, InvalidFile> {
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
            let level = read(&text).map_err(|problem| self.invalid(&word, problem, ""))?;
            levels.push((word, level));
        }
        self.levels(axis, &given, levels)
    }

    /// The levels of an axis of numbers: `read` reads a number from a word, `make` makes a level of it.
    pub(super) fn numbers<T: Clone>(
        &self,
        axis: Axis,
        otherwise: Option<&str>,
        read: impl Fn(&Word) -> Result<f64, String>,
        make: impl Fn(f64) -> Result<(T, Level), String>,
    ) -> Result<Levels<T>, InvalidFile> {
        let given = self.given(axis, otherwise);
        let number = |word: &Spanned<Word>| {
            read(word.get_ref()).map_err(|problem| self.invalid(word, problem, ""))
        };
        let mut found = Vec::new();
        match given.get_ref() {
            Given::Range(range) => {
                let (from, to) = (number(&range.from)?, number(&range.to)?);
                if !(from.is_finite() && to.is_finite()) {
                    let problem = "steps need two finite numbers";
                    return Err(self.invalid(&range.from, problem, "give numbers, or a list"));
                }
                let steps = *range.steps.get_ref();
                if !(2..=LEVELS_MAX).contains(&steps) {
                    return Err(self.invalid(
                        &range.steps,
                        format!("`steps` is {steps}, but from and to alone are two"),
                        &format!("give 2 to {LEVELS_MAX}"),
                    ));
                }
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
            let level = make(value).map_err(|problem| self.invalid(&word, problem, ""))?;
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
    ) -> Result<Levels<T>, InvalidFile> {
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

pub(super) fn text(word: &Word) -> Result<&str, String> {
    match word {
        Word::Text(text) => Ok(text),
        Word::Number(number) => Err(format!(
            "{number} has no unit; write it as a text, like \"3ms\", \"1%\" or \"1mbit\""
        )),
    }
}

pub(super) fn duration_ns_of(word: &Word) -> Result<f64, String> {
    duration_ns(text(word)?).map_err(|why| why.to_string())
}

pub(super) fn parsed<T: std::str::FromStr<Err: std::fmt::Display>>(
    word: &str,
) -> Result<T, String> {
    word.parse().map_err(|why: T::Err| why.to_string())
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
