//! The failures of expectations that are known: `[[known]]` as written, and as a plan has it.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use text::Diagnostic;

use crate::cell::Cell;
use crate::clause::{Figure, OLD_HOLDS};
use crate::invalid::{Reader, Word};
use crate::selection::matches;

/// A failure that is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// The cells: a part of an id, or a whole id in which `*` stands for any text.
    pub cells: String,
    /// The figure whose clauses fail; all, if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expect: Option<Figure>,
    /// Why.
    pub reason: String,
    /// The last day on which the failure is accepted; for ever, if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<Day>,
}

impl Known {
    /// Whether it is about this figure of the cell with this id.
    #[must_use]
    pub fn is_about(&self, figure: Figure, id: &str) -> bool {
        self.expect.is_none_or(|own| own == figure) && matches(&self.cells, id)
    }

    /// Whether the failure is still accepted on this day.
    #[must_use]
    pub fn is_accepted(&self, today: Day) -> bool {
        self.until.is_none_or(|until| today <= until)
    }
}

/// A day of the calendar: `2027-06-30`.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String")]
pub struct Day(jiff::civil::Date);

impl From<jiff::civil::Date> for Day {
    fn from(date: jiff::civil::Date) -> Day {
        Day(date)
    }
}

/// A text that is no day.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a day; write it like 2027-06-30")]
pub struct NotADay(String);

impl FromStr for Day {
    type Err = NotADay;

    fn from_str(text: &str) -> Result<Day, NotADay> {
        let day = jiff::civil::Date::strptime("%Y-%m-%d", text);
        day.map(Day).map_err(|_| NotADay(text.to_owned()))
    }
}

impl TryFrom<String> for Day {
    type Error = NotADay;

    fn try_from(text: String) -> Result<Day, NotADay> {
        text.parse()
    }
}

impl From<Day> for String {
    fn from(day: Day) -> String {
        day.to_string()
    }
}

impl fmt::Display for Day {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A block `[[known]]` as written: a failure that is known, so that it does not fail a run of the experiment.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct KnownFailure {
    /// The cells: a part of an id, or a whole id in which * stands for any text, as `--only` takes it.
    #[schemars(with = "String")]
    cells: Word,
    /// The clause that fails, by its figure; all, if not given.
    #[schemars(with = "Option<String>")]
    expect: Option<Word>,
    /// Why it fails.
    reason: String,
    /// The last day on which the failure is accepted, like 2027-06-30; for ever, if not given.
    #[schemars(with = "Option<String>")]
    until: Option<Word>,
}

impl Reader<'_> {
    /// Reads the failures that are known. Each is of a cell of the plan, unless other topologies or clients took
    /// the place of the experiment's.
    pub(crate) fn known(
        &self,
        written: &[KnownFailure],
        cells: &[Cell],
        is_replaced: bool,
    ) -> Result<Vec<Known>, Diagnostic> {
        let read = |known: &KnownFailure| {
            let pattern = known.cells.get_ref();
            if !is_replaced && !cells.iter().any(|cell| matches(pattern, &cell.id)) {
                return Err(self.invalid(
                    &known.cells,
                    format!("no cell matches `{pattern}`"),
                    "`webloop run FILE --dry-run` lists the cells",
                ));
            }
            let expect = known.expect.as_ref();
            let until = known.until.as_ref();
            Ok(Known {
                cells: pattern.clone(),
                expect: expect
                    .map(|word| match word.get_ref().as_str() {
                        OLD_HOLDS => Ok(Figure::Holds),
                        _ => self.word(word),
                    })
                    .transpose()?,
                reason: known.reason.clone(),
                until: until.map(|word| self.word(word)).transpose()?,
            })
        };
        written.iter().map(read).collect()
    }
}
