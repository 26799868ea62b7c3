//! The claims of `claims.toml` as written, read into types that cannot be wrong. The file's head says what each
//! word means.

#[cfg(test)]
mod tests;

use std::sync::LazyLock;

use endpoint::{Mode, SampleTime};
use serde::Deserialize;

use super::metric::Metric;
use super::odd::Odd;
use super::remark::Remark;
use super::row::{Accepted, Row, Than, Weight};
use crate::subject::{AskedRuns, Changed, Except, Subject, Topology};
use report::claim::rule::ANY;
use report::claim::{Finding, Verdict};

/// What the paper says, and what it is compared with.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Claim {
    pub(super) id: String,
    pub(super) place: String,
    pub(super) claim: String,
    /// What counts as agreement, in words.
    #[serde(default)]
    pub(super) check: String,
    check_as: Option<String>,
    /// The claim of which this is a reading.
    pub(super) reading_of: Option<String>,
    pub(super) remark: Option<Remark>,
    /// What judges it in the place of rows.
    pub(super) odd: Option<Odd>,
    #[serde(default)]
    runs: Vec<Runs>,
}

impl Claim {
    /// Its numbers, in order.
    pub(super) fn rows(&self) -> impl Iterator<Item = &Row> {
        self.runs.iter().flat_map(|runs| &runs.0)
    }

    /// The finding before anything is judged.
    pub(super) fn finding(&'static self) -> Finding {
        Finding {
            id: &self.id,
            place: &self.place,
            claim: &self.claim,
            check: self.check.clone(),
            reading_of: self.reading_of.as_deref(),
            verdict: Verdict::NotRun,
            reason: String::new(),
            parts: Vec::new(),
            runs: Vec::new(),
        }
    }
}

const BUILT_IN: &str = include_str!("../../claims.toml");

/// The claims that the crate carries, in the paper's order.
///
/// # Panics
/// Never, as a test shows.
pub(super) fn built_in() -> &'static [Claim] {
    static CLAIMS: LazyLock<Vec<Claim>> = LazyLock::new(|| read(BUILT_IN).expect("built in"));
    &CLAIMS
}

/// Why a text does not hold claims.
#[derive(Debug, thiserror::Error)]
enum InvalidClaims {
    /// A word is wrong; it says in which line.
    #[error("claims.toml: {0}")]
    Text(#[from] toml::de::Error),
    #[error("claims.toml: claim `{claim}`: `{field}` is `{id}`, and no claim has that id")]
    Id {
        claim: String,
        field: &'static str,
        id: String,
    },
    #[error("claims.toml: claim `{0}` is there twice; give each an id of its own")]
    Twice(String),
    #[error("claims.toml: claim `{0}` needs the words of a `check`, or `check_as`, and not both")]
    Check(String),
    #[error(
        "claims.toml: claim `{0}` needs either figures of [[claim.runs]], for some `h` and `where`, or `odd`"
    )]
    Judge(String),
}

/// Reads claims from a TOML text.
fn read(text: &str) -> Result<Vec<Claim>, InvalidClaims> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct ClaimsFile {
        claim: Vec<Claim>,
    }
    let mut claims = toml::from_str::<ClaimsFile>(text)?.claim;
    for at in 0..claims.len() {
        let Claim { id, odd, .. } = &claims[at];
        let find = |field, id: &Option<String>| {
            let Some(id) = id else { return Ok(None) };
            match claims.iter().find(|other| other.id == *id) {
                Some(other) => Ok(Some(other.check.clone())),
                None => Err(InvalidClaims::Id {
                    claim: claims[at].id.clone(),
                    field,
                    id: id.clone(),
                }),
            }
        };
        if claims[..at].iter().any(|other| other.id == *id) {
            return Err(InvalidClaims::Twice(id.clone()));
        }
        if odd.is_some() == claims[at].rows().next().is_some() {
            return Err(InvalidClaims::Judge(id.clone()));
        }
        find("reading_of", &claims[at].reading_of)?;
        let check = find("check_as", &claims[at].check_as)?;
        if check.is_some() != claims[at].check.is_empty() {
            return Err(InvalidClaims::Check(id.clone()));
        }
        if let Some(check) = check {
            claims[at].check = check;
        }
    }
    Ok(claims)
}

/// Rows about runs that have something in common.
#[derive(Debug, Deserialize)]
#[serde(try_from = "RunsEntry")]
struct Runs(Vec<Row>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RunsEntry {
    who: Subject,
    #[serde(rename = "where")]
    topologies: Vec<Topology>,
    mode: Mode,
    h: Vec<SampleTime>,
    #[serde(default)]
    with: Changed,
    figures: Vec<FigureEntry>,
}

impl TryFrom<RunsEntry> for Runs {
    type Error = InvalidFigure;

    fn try_from(runs: RunsEntry) -> Result<Runs, InvalidFigure> {
        let mut rows = Vec::new();
        for h in &runs.h {
            for topology in &runs.topologies {
                let asked = AskedRuns {
                    subject: runs.who,
                    topology: topology.name(),
                    mode: runs.mode,
                    h_ns: h.ns(),
                    with: runs.with,
                };
                for figure in &runs.figures {
                    rows.push(figure.row(asked)?);
                }
            }
        }
        Ok(Runs(rows))
    }
}

/// A figure of a claim, as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FigureEntry {
    figure: Metric,
    who: Option<Subject>,
    #[serde(rename = "where")]
    topology: Option<Topology>,
    with: Option<Changed>,
    over: Option<Except>,
    paper: Option<PrintedNumber>,
    from: Option<f64>,
    to: Option<f64>,
    #[serde(rename = "in")]
    scale: Option<CountedIn>,
    above: Option<ThanEntry>,
    below: Option<ThanEntry>,
    or: Option<OrEntry>,
    #[serde(default, rename = "use")]
    weight: Weight,
}

/// A number as the paper prints it, or as two of its numbers give it.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "a number, or two of which it is the ratio")]
enum PrintedNumber {
    Whole(f64),
    Ratio(f64, f64),
}

/// What limits are counted in.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum CountedIn {
    /// The sample time, in ms.
    H,
    /// The paper's number.
    Paper,
}

/// Another number, as a limit: of the row's own runs and figure, but for what is said here.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ThanEntry {
    who: Option<Subject>,
    #[serde(rename = "where")]
    topology: Option<Topology>,
    mode: Option<Mode>,
    h: Option<SampleTime>,
    with: Option<Changed>,
    figure: Option<Metric>,
    over: Option<Except>,
    times: Option<f64>,
    #[serde(default)]
    least: f64,
}

/// Another figure of the same runs, and the limits that it may be beyond.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OrEntry {
    figure: Metric,
    from: f64,
    to: f64,
}

/// Words that are right by themselves, and make no row together.
#[derive(Debug, thiserror::Error)]
enum InvalidFigure {
    #[error("`{0}` has limits in the paper's number and no `paper`; give it, or leave out `in`")]
    Paper(String),
    #[error("`{0}` has several of `above`, `below` and `or`; choose one")]
    Several(String),
    #[error(
        "`{0}` decides, and accepts anything; give `from`, `to`, `above` or `below`, or use = \"shown\""
    )]
    Anything(String),
}

impl FigureEntry {
    fn row(&self, runs: AskedRuns<'static>) -> Result<Row, InvalidFigure> {
        let asked = runs.but(Except {
            who: self.who,
            topology: self.topology,
            with: self.with,
            ..Except::default()
        });
        let words = || self.figure.of.clone().into_owned();
        let paper = self.paper.map(PrintedNumber::value);
        let one = match self.scale {
            None => 1.0,
            Some(CountedIn::H) => asked.h_ns as f64 / 1e9 * 1e3,
            Some(CountedIn::Paper) => paper.ok_or_else(|| InvalidFigure::Paper(words()))?,
        };
        let limits = (
            self.from.map_or(ANY.0, |from| from * one),
            self.to.map_or(ANY.1, |to| to * one),
        );
        let accepted = match (&self.above, &self.below, &self.or) {
            (None, None, None) => Accepted::Within(limits),
            (Some(than), None, None) => Accepted::Above(than.of(asked, limits)),
            (None, Some(than), None) => Accepted::Below(than.of(asked, limits)),
            (None, None, Some(or)) => {
                Accepted::WithinOrBeyond(limits, or.figure.clone(), (or.from, or.to))
            }
            _ => return Err(InvalidFigure::Several(words())),
        };
        if self.weight == Weight::Decides && matches!(accepted, Accepted::Within(ANY)) {
            return Err(InvalidFigure::Anything(words()));
        }
        Ok(Row {
            asked,
            metric: self.figure.clone(),
            over: self.over,
            paper,
            accepted,
            weight: self.weight,
        })
    }
}

impl PrintedNumber {
    fn value(self) -> f64 {
        match self {
            PrintedNumber::Whole(value) => value,
            PrintedNumber::Ratio(part, whole) => part / whole,
        }
    }
}

impl ThanEntry {
    fn of(&self, own: AskedRuns<'static>, unknown: (f64, f64)) -> Than {
        Than {
            asked: own.but(Except {
                who: self.who,
                topology: self.topology,
                mode: self.mode,
                h: self.h,
                with: self.with,
            }),
            metric: self.figure.clone(),
            over: self.over,
            // With `least` alone, the limit is the number's size.
            times: self.times.or((self.least > 0.0).then_some(1.0)),
            least: self.least,
            unknown,
        }
    }
}
