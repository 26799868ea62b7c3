//! What runs are expected to show: clauses such as `holds`, `survives in 90%` or `settling <= 400ms in 90% at 95%`.
//!
//! A clause asks each run, and how many of a group's runs must meet it: all, if it does not say. With `at 95%`
//! the share of all runs that could be made is asked, with this confidence, and not just that of the runs made.
//! `analysis` judges the runs.

use std::fmt;
use std::str::FromStr;

use endpoint::Mode;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use text::duration_ns;

text::choice!(
    /// What a clause is about: the loop's verdict, or a figure of the run.
    Figure, "figure", {
        /// The loop holds, and holds well: `stable` is an older word for it.
        #[serde(alias = "stable")]
        Holds = "holds",
        /// The loop holds, well or badly.
        Survives = "survives",
        /// Settling time into the band.
        Settling = "settling",
        /// Rise time from 10 to 90 %.
        Rise = "rise",
        /// Overshoot, of the step.
        Overshoot = "overshoot",
        /// Integral of the absolute error, s.
        Iae = "iae",
        /// Messages sent, of those due.
        Sent = "sent",
        /// Median round trip of a message.
        RttP50 = "rtt.p50",
        /// Its 90th percentile.
        RttP90 = "rtt.p90",
        /// Its 99th percentile.
        RttP99 = "rtt.p99",
        /// The longest round trip.
        RttMax = "rtt.max",
    }
);

/// The unit of a figure's limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// A time; limits and figures are in ms.
    Ms,
    /// A share; limits and figures are in percent.
    Percent,
    /// A number.
    Plain,
}

impl Unit {
    /// What follows a number in this unit.
    #[must_use]
    pub fn suffix(self) -> &'static str {
        match self {
            Unit::Ms => " ms",
            Unit::Percent => " %",
            Unit::Plain => "",
        }
    }
}

impl Figure {
    /// The unit of its limits.
    #[must_use]
    pub fn unit(self) -> Unit {
        match self {
            Figure::Overshoot | Figure::Sent => Unit::Percent,
            Figure::Iae | Figure::Holds | Figure::Survives => Unit::Plain,
            _ => Unit::Ms,
        }
    }

    /// Whether it is the verdict on a loop, which has no limit.
    #[must_use]
    pub fn is_verdict(self) -> bool {
        matches!(self, Figure::Holds | Figure::Survives)
    }

    /// Whether runs of this mode have it: a step response is of a closed loop alone.
    #[must_use]
    pub fn is_of(self, mode: Mode) -> bool {
        use Figure::{Iae, Overshoot, Rise, Settling};
        let is_of_step = matches!(self, Settling | Rise | Overshoot | Iae);
        mode == Mode::Closed || !(self.is_verdict() || is_of_step)
    }
}

/// A limit of a figure, in the figure's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Whether it is the most, `<=`, or the least, `>=`.
    pub is_at_most: bool,
    /// The number.
    pub value: f64,
}

impl Limit {
    /// Whether a figure of this value is within it.
    #[must_use]
    pub fn is_kept_by(self, value: f64) -> bool {
        if self.is_at_most {
            value <= self.value
        } else {
            value >= self.value
        }
    }
}

/// A requirement on every run of a group, or on a share of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String")]
pub struct Clause {
    text: String,
    figure: Figure,
    limit: Option<Limit>,
    share: f64,
    confidence: Option<f64>,
}

impl Clause {
    /// What it is about.
    #[must_use]
    pub fn figure(&self) -> Figure {
        self.figure
    }

    /// The figure's limit; `None` of `holds` and `survives`.
    #[must_use]
    pub fn limit(&self) -> Option<Limit> {
        self.limit
    }

    /// The share of a group's runs that must meet it, from 0 to 1.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.share
    }

    /// The confidence that the share of all runs is large enough, from 0.5 to 1; `None` asks for the share of
    /// the runs that were made.
    #[must_use]
    pub fn confidence(&self) -> Option<f64> {
        self.confidence
    }

    /// The clause with this confidence, such as `95%`, if it asks for a share and has none. `all` runs is asked
    /// of the runs that were made: no number of them shows it of all.
    ///
    /// # Errors
    /// If the text is no confidence.
    pub(crate) fn at(&self, confidence: &str) -> Result<Clause, InvalidClause> {
        read_confidence(confidence)
            .map_err(|problem| InvalidClause(format!("`{confidence}`: {problem}")))?;
        if self.confidence.is_some() || self.share >= 1.0 {
            return Ok(self.clone());
        }
        format!("{} at {confidence}", self.text).parse()
    }
}

/// A text that is no clause.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct InvalidClause(String);

impl FromStr for Clause {
    type Err = InvalidClause;

    fn from_str(text: &str) -> Result<Self, InvalidClause> {
        let text = text.trim();
        // What plans and commands were written with before.
        let renamed = text
            .strip_prefix(OLD_HOLDS)
            .filter(|rest| rest.is_empty() || rest.starts_with(' '));
        let renamed = renamed.map(|rest| format!("{HOLDS}{rest}"));
        let text = renamed.as_deref().unwrap_or(text);
        read(text).map_err(|problem| InvalidClause(format!("`{text}`: {problem}")))
    }
}

/// What asks whether loops hold well.
const HOLDS: &str = "holds";
/// What asks whether they hold, well or badly.
const SURVIVES: &str = "survives";
/// What `holds` was called before.
pub(crate) const OLD_HOLDS: &str = "stable";

fn read(text: &str) -> Result<Clause, String> {
    let (asked, confidence) = match text.split_once(" at ") {
        None => (text, None),
        Some((asked, confidence)) => (asked, Some(read_confidence(confidence)?)),
    };
    let (asked, share) = match asked.split_once(" in ") {
        None => (asked, 1.0),
        Some((asked, share)) => {
            let share = percent(share).filter(|share| (0.0..=100.0).contains(share));
            let share = share.ok_or("behind `in` stands the share of runs, such as 90%")?;
            (asked, share / 100.0)
        }
    };
    if confidence.is_some() && share >= 1.0 {
        let words = "no number of runs shows that all meet it; ask for a share such as `in 99%`, or leave out `at`";
        return Err(words.to_owned());
    }
    let (figure, limit) = match asked.trim() {
        HOLDS => (Figure::Holds, None),
        SURVIVES => (Figure::Survives, None),
        asked => bound(asked).map(|(figure, limit)| (figure, Some(limit)))?,
    };
    Ok(Clause {
        text: text.to_owned(),
        figure,
        limit,
        share,
        confidence,
    })
}

/// A confidence in percent. Below a half, the lower bound of a share is above the upper one.
fn read_confidence(text: &str) -> Result<f64, String> {
    let confidence = percent(text).filter(|percent| (50.0..100.0).contains(percent));
    let words = "a confidence is at least 50% and less than 100%, such as 95%";
    Ok(confidence.ok_or(words)? / 100.0)
}

/// A figure, `<=` or `>=`, and a limit in the figure's unit.
fn bound(asked: &str) -> Result<(Figure, Limit), String> {
    let names = || {
        let bounded = Figure::ALL.iter().filter(|name| !name.is_verdict());
        let names: Vec<String> = bounded.map(Figure::to_string).collect();
        names.join(", ")
    };
    let parts = asked
        .split_once("<=")
        .map(|(name, limit)| (name, true, limit))
        .or_else(|| {
            asked
                .split_once(">=")
                .map(|(name, limit)| (name, false, limit))
        });
    let Some((name, is_at_most, limit)) = parts else {
        return Err(format!(
            "give `holds`, `survives`, or a figure with <= or >= and a limit, such as \"settling <= 400ms\"; the figures \
             are {}",
            names()
        ));
    };
    let (name, limit) = (name.trim(), limit.trim());
    let figure = name.parse().ok().filter(|of: &Figure| !of.is_verdict());
    let figure =
        figure.ok_or_else(|| format!("there is no figure `{name}`; choose {}", names()))?;
    let (read, example) = match figure.unit() {
        Unit::Ms => (
            duration_ns(limit, 0..=u64::MAX)
                .ok()
                .map(|ns| ns as f64 * 1e-6),
            "a time such as 400ms",
        ),
        Unit::Percent => (percent(limit), "a share such as 20%"),
        Unit::Plain => (finite(limit), "a number such as 0.3"),
    };
    let value = read.ok_or_else(|| format!("`{limit}` is no limit of {name}; give {example}"))?;
    Ok((figure, Limit { is_at_most, value }))
}

fn percent(text: &str) -> Option<f64> {
    finite(text.trim().strip_suffix('%')?)
}

fn finite(text: &str) -> Option<f64> {
    let number = text.trim().parse().ok();
    number.filter(|number: &f64| number.is_finite())
}

impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl TryFrom<String> for Clause {
    type Error = InvalidClause;

    fn try_from(text: String) -> Result<Self, InvalidClause> {
        text.parse()
    }
}

impl From<Clause> for String {
    fn from(clause: Clause) -> String {
        clause.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clause_says_figure_limit_share_and_confidence() {
        let clause: Clause = " settling <= 0.4s in 90% at 95% "
            .parse()
            .expect("a clause");
        let limit = Limit {
            is_at_most: true,
            value: 400.0,
        };
        assert_eq!(
            (clause.figure(), clause.limit()),
            (Figure::Settling, Some(limit))
        );
        assert_eq!((clause.share(), clause.confidence()), (0.9, Some(0.95)));
        assert_eq!(clause.to_string(), "settling <= 0.4s in 90% at 95%");
        let holds: Clause = "holds".parse().expect("a clause");
        assert_eq!((holds.share(), holds.limit()), (1.0, None));
        let survives: Clause = "survives in 90%".parse().expect("a clause");
        assert_eq!(
            (survives.figure(), survives.share(), survives.limit()),
            (Figure::Survives, 0.9, None)
        );
        // The older word is the same clause.
        assert_eq!("stable".parse(), Ok(holds));
        let old: Clause = "stable in 90% at 95%".parse().expect("a clause");
        assert_eq!(old.to_string(), "holds in 90% at 95%");
    }

    #[test]
    fn what_is_no_clause_is_said() {
        for (text, says) in [
            ("settled", "give `holds`, `survives`, or a figure with <="),
            ("survives <= 3ms", "no figure `survives`; choose settling"),
            ("speed <= 3ms", "no figure `speed`; choose settling"),
            ("holds <= 3ms", "no figure `holds`; choose settling"),
            (
                "settling <= 400",
                "`400` is no limit of settling; give a time",
            ),
            ("overshoot <= 0.2", "give a share such as 20%"),
            ("holds in half", "behind `in` stands the share"),
            ("holds in 120%", "behind `in` stands the share"),
            ("iae <= inf", "give a number"),
            ("holds in 90% at 100%", "less than 100%"),
            ("holds in 90% at 40%", "at least 50%"),
            ("holds at 95%", "ask for a share such as `in 99%`"),
        ] {
            let error = text.parse::<Clause>().expect_err(text).to_string();
            assert!(error.starts_with(&format!("`{text}`: ")), "{error}");
            assert!(error.contains(says), "{error}");
        }
    }
}
