//! What runs are required to show: clauses such as `stable` or `settling <= 400ms in 90%`, and by which groups
//! of runs each is met.
//!
//! A group is the repeats of one cell. A clause asks each run, and how many of a group's runs must meet it: all,
//! if it does not say. Only complete runs are asked, since the others show nothing; a group without one meets no
//! clause. Where the experiment has no such loop (settling of an open one) the clause does not apply.

use std::fmt;
use std::str::FromStr;

use endpoint::{Mode, span::span_ns};
use plan::Verdict;

use crate::layout::{digits, grouped};
use crate::response::LoopVerdict;
use crate::summary::Summary;

/// A requirement on every run of a group, or on a share of them.
#[derive(Debug, Clone)]
pub struct Clause {
    text: String,
    test: Test,
    /// The share of a group's runs that must meet it, from 0 to 1.
    share: f64,
}

#[derive(Debug, Clone, Copy)]
enum Test {
    Stable,
    Bound {
        figure: &'static Figure,
        is_at_most: bool,
        limit: f64,
    },
}

/// A figure that a clause can bound.
#[derive(Debug)]
struct Figure {
    name: &'static str,
    unit: Unit,
    /// Whether it is of a closed loop alone.
    is_closed: bool,
    of: fn(&Summary) -> Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    Ms,
    Percent,
    Plain,
}

static FIGURES: [Figure; 9] = [
    Figure::new("settling", Unit::Ms, true, |row| row.settling_ms),
    Figure::new("rise", Unit::Ms, true, |row| row.rise_ms),
    Figure::new("overshoot", Unit::Percent, true, |row| row.overshoot_pct),
    Figure::new("iae", Unit::Plain, true, |row| row.iae_s),
    Figure::new("sent", Unit::Percent, false, |row| {
        row.sent_share.map(|share| share * 100.0)
    }),
    Figure::new("rtt.p50", Unit::Ms, false, |row| row.message_rtt_p50_ms),
    Figure::new("rtt.p90", Unit::Ms, false, |row| row.message_rtt_p90_ms),
    Figure::new("rtt.p99", Unit::Ms, false, |row| row.message_rtt_p99_ms),
    Figure::new("rtt.max", Unit::Ms, false, |row| row.message_rtt_max_ms),
];

impl Figure {
    const fn new(
        name: &'static str,
        unit: Unit,
        is_closed: bool,
        of: fn(&Summary) -> Option<f64>,
    ) -> Self {
        Self {
            name,
            unit,
            is_closed,
            of,
        }
    }
}

/// A text that is no clause.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct InvalidClause(String);

impl FromStr for Clause {
    type Err = InvalidClause;

    fn from_str(text: &str) -> Result<Self, InvalidClause> {
        let invalid = |problem: &str| InvalidClause(format!("`{text}`: {problem}"));
        let (asked, share) = match text.split_once(" in ") {
            None => (text, 1.0),
            Some((asked, share)) => {
                let share = percent(share).filter(|share| (0.0..=100.0).contains(share));
                let share = share
                    .ok_or_else(|| invalid("behind `in` stands the share of runs, such as 90%"))?;
                (asked, share / 100.0)
            }
        };
        let test = match asked.trim() {
            "stable" => Test::Stable,
            asked => bound(asked).map_err(|problem| invalid(&problem))?,
        };
        Ok(Self {
            text: text.trim().to_owned(),
            test,
            share,
        })
    }
}

/// A figure, `<=` or `>=`, and a limit in the figure's unit.
fn bound(asked: &str) -> Result<Test, String> {
    let names = || {
        FIGURES
            .iter()
            .map(|figure| figure.name)
            .collect::<Vec<_>>()
            .join(", ")
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
            "give `stable`, or a figure with <= or >= and a limit, such as \"settling <= 400ms\"; the figures \
             are {}",
            names()
        ));
    };
    let (name, limit) = (name.trim(), limit.trim());
    let Some(figure) = FIGURES.iter().find(|figure| figure.name == name) else {
        return Err(format!("there is no figure `{name}`; choose {}", names()));
    };
    let (read, example) = match figure.unit {
        Unit::Ms => (
            span_ns(limit).map(|ns| ns as f64 * 1e-6),
            "a time such as 400ms",
        ),
        Unit::Percent => (percent(limit), "a share such as 20%"),
        Unit::Plain => (finite(limit), "a number such as 0.3"),
    };
    let limit = read.ok_or_else(|| format!("`{limit}` is no limit of {name}; give {example}"))?;
    Ok(Test::Bound {
        figure,
        is_at_most,
        limit,
    })
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

impl Clause {
    /// Whether a run is asked at all.
    fn applies(&self, row: &Summary) -> bool {
        match self.test {
            Test::Stable => row.mode == Mode::Closed,
            Test::Bound { figure, .. } => row.mode == Mode::Closed || !figure.is_closed,
        }
    }

    /// Whether a complete run meets it. A run without the figure, as one that never settled, does not.
    fn is_met_by(&self, row: &Summary) -> bool {
        match self.test {
            Test::Stable => row.loop_verdict == Some(LoopVerdict::Stable),
            Test::Bound {
                figure,
                is_at_most,
                limit,
            } => (figure.of)(row).is_some_and(|value| {
                if is_at_most {
                    value <= limit
                } else {
                    value >= limit
                }
            }),
        }
    }

    /// What a run shows instead, in words.
    fn shown(&self, row: &Summary) -> String {
        match self.test {
            Test::Stable => match row.loop_verdict {
                Some(verdict) => verdict.to_string(),
                None => "no verdict on the loop".to_owned(),
            },
            Test::Bound { figure, .. } => match (figure.of)(row) {
                Some(value) => format!("{}{}", digits(Some(value)), figure.unit.suffix()),
                None if figure.name.starts_with("rtt") => {
                    format!("too few answers for {}", figure.name)
                }
                None => format!("no {}", figure.name),
            },
        }
    }

    /// How far a run is from meeting it, to find the worst.
    fn distance(&self, row: &Summary) -> f64 {
        match self.test {
            Test::Stable => row
                .loop_verdict
                .map_or(f64::INFINITY, |verdict| verdict as u8 as f64),
            Test::Bound {
                figure, is_at_most, ..
            } => match (figure.of)(row) {
                None => f64::INFINITY,
                Some(value) if is_at_most => value,
                Some(value) => -value,
            },
        }
    }
}

impl Unit {
    fn suffix(self) -> &'static str {
        match self {
            Unit::Ms => " ms",
            Unit::Percent => " %",
            Unit::Plain => "",
        }
    }
}

/// A clause and a group of runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The clause, as it was asked.
    pub clause: String,
    /// Topology, client, setup, mode and rate of the group.
    pub group: String,
    /// Complete runs that meet the clause.
    pub met: usize,
    /// Complete runs.
    pub runs: usize,
    /// Whether the clause holds for the group.
    pub holds: bool,
    /// What the worst run shows, and its repeat; `None` without a complete run.
    pub worst: Option<(String, u32)>,
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.holds { "met" } else { "NOT MET" };
        write!(f, "{word}: {}: {}", self.group, self.clause)?;
        match &self.worst {
            None => f.write_str(" (no complete run)"),
            Some((shown, repeat)) => {
                write!(f, " (by {} of {} runs", self.met, self.runs)?;
                // Of several runs that are all stable none is the worst.
                if *shown == self.clause {
                    f.write_str(")")
                } else {
                    write!(f, "; the worst, run {repeat}: {shown})")
                }
            }
        }
    }
}

/// Asks each group of rows each clause that applies to it, in the order of the rows. Runs that this machine does
/// not support are left out.
#[must_use]
pub fn answers(clauses: &[Clause], rows: &[Summary]) -> Vec<Answer> {
    let asked = rows
        .iter()
        .filter(|row| row.verdict != Some(Verdict::Unsupported));
    let groups = grouped(asked, |row| {
        (&row.topology, row.client, &row.setup, row.mode, row.h_ns)
    });
    let of_group = |rows: &Vec<&Summary>| {
        let first = rows[0];
        let group = format!(
            "{} {} {} {} {}",
            first.topology, first.client, first.setup, first.mode, first.rate
        );
        let applying = clauses.iter().filter(|clause| clause.applies(first));
        let answers = applying.map(|clause| answer(clause, &group, rows));
        answers.collect::<Vec<_>>()
    };
    groups.iter().flat_map(|(_, rows)| of_group(rows)).collect()
}

fn answer(clause: &Clause, group: &str, rows: &[&Summary]) -> Answer {
    let is_complete = |row: &&&Summary| row.verdict == Some(Verdict::Complete);
    let complete: Vec<&&Summary> = rows.iter().filter(is_complete).collect();
    let met = complete.iter().filter(|row| clause.is_met_by(row)).count();
    let worst = complete
        .iter()
        .max_by(|one, other| clause.distance(one).total_cmp(&clause.distance(other)));
    Answer {
        clause: clause.to_string(),
        group: group.to_owned(),
        met,
        runs: complete.len(),
        // In whole runs, so that 90 % of ten are nine.
        holds: !complete.is_empty() && met as f64 >= clause.share * complete.len() as f64 - 1e-9,
        worst: worst.map(|row| (clause.shown(row), row.repeat)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(repeat: u32, settling_ms: Option<f64>) -> Summary {
        Summary {
            topology: "couva".into(),
            setup: "paper-python".into(),
            rate: "100 Hz".into(),
            mode: Mode::Closed,
            repeat,
            verdict: Some(Verdict::Complete),
            loop_verdict: Some(if settling_ms.is_some() {
                LoopVerdict::Stable
            } else {
                LoopVerdict::NotSettled
            }),
            settling_ms,
            sent_share: Some(0.995),
            ..Summary::default()
        }
    }

    fn said(clause: &str, rows: &[Summary]) -> Vec<(bool, String)> {
        let clause = clause.parse().expect("a clause");
        let answers = answers(&[clause], rows);
        answers
            .iter()
            .map(|answer| (answer.holds, answer.to_string()))
            .collect()
    }

    #[test]
    fn each_group_is_asked_and_its_worst_run_named() {
        let rows = [
            row(1, Some(300.0)),
            row(2, Some(420.0)),
            row(3, Some(310.0)),
        ];
        let late = said("settling <= 400ms", &rows);
        let words = "NOT MET: couva native paper-python closed 100 Hz: settling <= 400ms (by 2 of 3 runs; the \
                     worst, run 2: 420 ms)";
        assert_eq!(late, [(false, words.to_owned())]);
        assert!(said("settling<=0.42s", &rows)[0].0);
        assert!(said("settling <= 400ms in 66%", &rows)[0].0);
        assert!(!said("settling <= 400ms in 67%", &rows)[0].0);
        assert!(said("sent >= 99.5%", &rows)[0].0 && !said("sent >= 99.6%", &rows)[0].0);
    }

    #[test]
    fn a_loop_that_never_settles_meets_no_limit_and_is_not_stable() {
        let rows = [row(1, Some(300.0)), row(2, None)];
        assert!(
            said("stable", &rows)[0]
                .1
                .ends_with("by 1 of 2 runs; the worst, run 2: not settled)")
        );
        assert!(
            said("settling <= 60s", &rows)[0]
                .1
                .ends_with("the worst, run 2: no settling)")
        );
        // Nor does one whose figure is not there meet the opposite.
        assert!(!said("settling >= 1ms", &rows)[0].0);
    }

    #[test]
    fn only_complete_runs_count_and_without_one_nothing_is_met() {
        let mut disturbed = row(2, Some(900.0));
        disturbed.verdict = Some(Verdict::Disturbed);
        assert!(
            said(
                "settling <= 400ms",
                &[row(1, Some(300.0)), disturbed.clone()]
            )[0]
            .0
        );
        let alone = said("stable", &[disturbed.clone()]);
        assert!(
            !alone[0].0 && alone[0].1.ends_with("(no complete run)"),
            "{alone:?}"
        );
        disturbed.verdict = Some(Verdict::Unsupported);
        assert_eq!(said("stable", &[disturbed]), []);
    }

    #[test]
    fn an_open_loop_is_asked_what_it_has() {
        let mut open = row(1, None);
        (open.mode, open.loop_verdict) = (Mode::Open, None);
        assert_eq!(said("stable", &[open.clone()]), []);
        assert_eq!(said("settling <= 1s", &[open.clone()]), []);
        assert!(said("sent >= 99%", &[open])[0].0);
    }

    #[test]
    fn what_is_no_clause_is_said() {
        for (text, says) in [
            ("settled", "give `stable`, or a figure with <="),
            ("speed <= 3ms", "no figure `speed`; choose settling"),
            (
                "settling <= 400",
                "`400` is no limit of settling; give a time",
            ),
            ("overshoot <= 0.2", "give a share such as 20%"),
            ("stable in half", "behind `in` stands the share"),
            ("stable in 120%", "behind `in` stands the share"),
            ("iae <= inf", "give a number"),
        ] {
            let error = text.parse::<Clause>().expect_err(text).to_string();
            assert!(error.starts_with(&format!("`{text}`: ")), "{error}");
            assert!(error.contains(says), "{error}");
        }
    }
}
