//! Compares two campaigns that should be alike, such as one in virtual time and one over real
//! sockets: which figures agree, and which differ?
//!
//! [`compare`](crate::compare) asks whether a change is more than chance. This module asks whether
//! two medians are close enough to stand for each other: a difference that is certain but small is
//! agreement. Runs are paired as in `compare`, so both runs of a pair met the same link.
//!
//! If a link's law has few draws in a run, such as a stall every ten seconds, runs differ widely. If
//! a few of them are slow, the median of all lies anywhere between the slow ones and the others. On
//! such a link, a figure whose medians differ still agrees if most pairs do, since the two runs of a
//! pair have equal draws: the medians then differ by the law's spread alone.

mod part;

use analysis::layout::{align, digits, number, text};
use analysis::statistics::median;
use analysis::{Campaign, Run, Summary};
use serde::Serialize;

pub use part::Parts;

use crate::compare::{GroupKey, Lone, Measure, pair};

/// A figure that is compared between two campaigns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Figure {
    /// Settling of a closed loop into 2 %, ms.
    Settling,
    /// Overshoot of a closed loop, % of the reference.
    Overshoot,
    /// Median round trip of a run's messages, ms.
    Rtt50,
    /// Their 90th percentile, ms.
    Rtt90,
    /// Their 99th percentile, ms.
    Rtt99,
    /// Mean time between arrivals, ms.
    Interval,
    /// Its standard deviation, ms.
    IntervalSd,
}

/// How far two figures may be apart: by a share of the second, or by a fixed amount if that is more.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tolerance {
    /// A share of the second figure.
    pub share: f64,
    /// An amount, in the figure's unit.
    pub least: f64,
}

impl Figure {
    /// All figures, in the order in which they are shown.
    pub const ALL: [Figure; 7] = [
        Figure::Settling,
        Figure::Overshoot,
        Figure::Rtt50,
        Figure::Rtt90,
        Figure::Rtt99,
        Figure::Interval,
        Figure::IntervalSd,
    ];

    /// Its name, with its unit.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Figure::Settling => "settling, ms",
            Figure::Overshoot => "overshoot, %",
            Figure::Rtt50 => "RTT 50 %, ms",
            Figure::Rtt90 => "RTT 90 %, ms",
            Figure::Rtt99 => "RTT 99 %, ms",
            Figure::Interval => "interval, ms",
            Figure::IntervalSd => "interval sd, ms",
        }
    }

    /// The quantile of round trips that it is; `None` if it is not one.
    fn quantile(self) -> Option<f64> {
        match self {
            Figure::Rtt50 => Some(0.5),
            Figure::Rtt90 => Some(0.9),
            Figure::Rtt99 => Some(0.99),
            _ => None,
        }
    }

    /// How far A's figure may be from B's to agree.
    #[must_use]
    pub fn tolerance(self) -> Tolerance {
        let (share, least) = match self {
            // One tick of the plant more or less is not a difference at 333 Hz.
            Figure::Settling => (0.10, 3.0),
            Figure::Overshoot => (0.10, 1.0),
            Figure::Rtt50 | Figure::Rtt90 | Figure::Rtt99 => (0.05, 0.2),
            Figure::Interval => (0.01, 0.01),
            Figure::IntervalSd => (0.25, 0.1),
        };
        Tolerance { share, least }
    }

    /// Its value in a run; `None` if it does not apply. Settling is infinite for a loop that never
    /// settled, and a round trip if it falls among messages without an answer.
    fn of(self, run: &Summary) -> Option<f64> {
        match self {
            Figure::Settling => Measure::Settling.of(run),
            Figure::Overshoot => Measure::Overshoot.of(run),
            Figure::Rtt50 => Measure::Rtt.of(run),
            Figure::Rtt90 => run.or_never(0.9, run.message_rtt_p90_ms),
            Figure::Rtt99 => run.or_never(0.99, run.message_rtt_p99_ms),
            Figure::Interval => run.control_interval_avg_ms,
            Figure::IntervalSd => run.control_interval_sd_ms,
        }
    }
}

impl Tolerance {
    /// Whether `a` can stand for `b`.
    #[must_use]
    pub fn allows(self, a: f64, b: f64) -> bool {
        // Two infinite values agree; an infinite and a finite one never do.
        a == b || b.is_finite() && (a - b).abs() <= (self.share * b.abs()).max(self.least)
    }
}

/// A run has few draws of a link's law if it meets the law's rarest event less often than this in one
/// direction. The number of events then varies by a fifth or more, as counts do.
const FEW_DRAWS: f64 = 30.0;

/// A figure of a group in both campaigns: medians over the pairs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Held {
    /// The figure.
    pub figure: Figure,
    /// A's median; NaN if only B has the figure.
    pub a: f64,
    /// B's median; NaN if only A has the figure.
    pub b: f64,
    /// Whether A's median can stand for B's.
    pub agrees: bool,
    /// Whether the medians differ only by the spread of their link's law: a run has few draws of it,
    /// and most pairs agree. This is not a difference.
    pub spread: bool,
    /// The median over pairs of A's value divided by B's. If runs differ much from each other, as
    /// over a link that stalls in one run and not in the next, it says more than the two medians.
    pub ratio: f64,
    /// For a round trip that differs: in which part of their way the messages differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<Parts>,
}

/// Pairs of runs that differ only in their repeat.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairedFigures {
    /// What they have in common.
    #[serde(flatten)]
    pub kind: GroupKey,
    /// Number of pairs.
    pub pairs: usize,
    /// How often the link's rarest event occurs in a run, in one direction; `None` unless that is
    /// seldom.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub draws: Option<f64>,
    /// Each figure that either campaign has.
    pub figures: Vec<Held>,
}

/// Where two campaigns agree, and where they differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Agreement {
    /// The groups that have pairs, in the order of A's plan.
    pub groups: Vec<PairedFigures>,
    /// The groups without a pair, and why.
    pub lone: Vec<Lone>,
}

const LEGEND: &str = "\
In pairs: the median ratio of A to B, run by run over the same link.
The law's spread: the link stalls or changes so rarely in a run that medians depend on which runs it
met; run by run, over equal draws, most agree. This is neither a difference nor a failure.
After a round trip that is off: how much longer A's messages take than B's in each part of it, at the
same quantile. late: from the deadline to sending; up: to the plant; down: back to the controller.
";

impl Agreement {
    /// Compares `a` with `b`.
    #[must_use]
    pub fn of(a: &Campaign, b: &Campaign) -> Agreement {
        let (paired, lone) = pair(a, b);
        let groups = paired
            .iter()
            .map(|paired| {
                let draws = few_draws(a, &paired.runs);
                PairedFigures {
                    kind: paired.kind.clone(),
                    pairs: paired.runs.len(),
                    draws,
                    figures: Figure::ALL
                        .into_iter()
                        .filter_map(|figure| Held::of(figure, &paired.runs, draws))
                        .collect(),
                }
            })
            .collect();
        Agreement { groups, lone }
    }

    /// Every figure that differs, with its group; not those that differ only by their law's spread.
    pub fn partings(&self) -> impl Iterator<Item = (&PairedFigures, &Held)> {
        self.groups.iter().flat_map(|group| {
            let parts = group.figures.iter().filter(|held| held.parts());
            parts.map(move |held| (group, held))
        })
    }

    /// The agreement as JSON.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Plain data of strings and numbers: serialising it cannot fail.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// The agreement as text for people.
    #[must_use]
    pub fn to_text(&self) -> String {
        let columns = [
            &GroupKey::COLUMNS[..],
            &[
                number("", "pairs"),
                text("figure"),
                number("median", "A"),
                number("median", "B"),
                text("A is"),
            ],
        ]
        .concat();
        let mut rows = Vec::new();
        for group in &self.groups {
            for held in &group.figures {
                let mut row = group.kind.entries().to_vec();
                row.extend([
                    group.pairs.to_string(),
                    held.figure.name().to_owned(),
                    value(held.a),
                    value(held.b),
                    held.words(),
                ]);
                rows.push(row);
            }
        }
        let mut out = align(&columns, &rows);
        if !self.lone.is_empty() {
            out += "\nNot compared:\n";
        }
        for one in &self.lone {
            out += &format!("  {}: {}\n", one.kind, one.reason);
        }
        let all: usize = self.groups.iter().map(|group| group.figures.len()).sum();
        let parts = self.partings().count();
        let figures = self.groups.iter().flat_map(|group| &group.figures);
        let spread = figures.filter(|held| held.spread).count();
        let apart = match spread {
            0 => String::new(),
            _ => format!(" ({spread} of them only in pairs, by their law's spread)"),
        };
        out += &format!(
            "\nOf {all} figures {} agree{apart} and {parts} differ.\n",
            all - parts
        );
        if spread + parts > 0 {
            out += LEGEND;
        }
        out
    }
}

impl Held {
    /// `draws` are those of the link in a run, if they are few.
    fn of(figure: Figure, runs: &[(&Run, &Run)], draws: Option<f64>) -> Option<Held> {
        let figures = |run: &Run| figure.of(&run.summary);
        let both: Vec<(f64, f64)> = runs
            .iter()
            .filter_map(|(a, b)| Some((figures(a)?, figures(b)?)))
            .collect();
        let (a, b) = if both.is_empty() {
            let of_a: Vec<f64> = runs.iter().filter_map(|(a, _)| figures(a)).collect();
            let of_b: Vec<f64> = runs.iter().filter_map(|(_, b)| figures(b)).collect();
            return Held::lone(figure, median(&of_a), median(&of_b));
        } else {
            (
                median(&both.iter().map(|(a, _)| *a).collect::<Vec<_>>())?,
                median(&both.iter().map(|(_, b)| *b).collect::<Vec<_>>())?,
            )
        };
        let ratios: Vec<f64> = both
            .iter()
            .map(|(a, b)| if a == b { 1.0 } else { a / b })
            .collect();
        let ratio = median(&ratios)?;
        let tolerance = figure.tolerance();
        let agrees = tolerance.allows(a, b);
        let alike = both
            .iter()
            .filter(|(a, b)| tolerance.allows(*a, *b))
            .count();
        let spread = !agrees && draws.is_some() && 2 * alike > both.len();
        Some(Held {
            figure,
            a,
            b,
            agrees,
            spread,
            ratio,
            parts: match (agrees || spread, figure.quantile()) {
                (false, Some(quantile)) => Parts::of(runs, quantile),
                _ => None,
            },
        })
    }

    /// A figure that only one campaign has; `None` if neither has it.
    fn lone(figure: Figure, a: Option<f64>, b: Option<f64>) -> Option<Held> {
        a.or(b)?;
        Some(Held {
            figure,
            a: a.unwrap_or(f64::NAN),
            b: b.unwrap_or(f64::NAN),
            agrees: false,
            spread: false,
            ratio: f64::NAN,
            parts: None,
        })
    }

    /// Whether the figure differs: A's median cannot stand for B's.
    #[must_use]
    pub fn parts(&self) -> bool {
        !self.agrees && !self.spread
    }

    fn words(&self) -> String {
        if self.agrees {
            return "alike".to_owned();
        }
        let share = |ratio: f64| match (ratio - 1.0) * 100.0 {
            off if off.is_finite() => format!("{off:+.0} % "),
            _ => String::new(),
        };
        if self.spread {
            let (off, in_pairs) = (share(self.a / self.b), share(self.ratio));
            return format!("{off}by the law's spread, alike in pairs {in_pairs}")
                .trim_end()
                .to_owned();
        }
        match (self.a.is_nan(), self.b.is_nan()) {
            (true, _) => return "OFF: only B has it".to_owned(),
            (_, true) => return "OFF: only A has it".to_owned(),
            (false, false) => {}
        }
        let mut off = share(self.a / self.b) + "OFF";
        if self.ratio.is_finite() {
            off += &format!(", in pairs {}", share(self.ratio).trim_end());
        }
        match self.parts {
            Some(parts) => format!("{off}: {}", parts.words()),
            None => off,
        }
    }
}

/// How often the rarest event of the runs' link occurs in one of them; `None` unless that is seldom.
fn few_draws(campaign: &Campaign, runs: &[(&Run, &Run)]) -> Option<f64> {
    let cell = &runs.first()?.0.cell;
    let text = campaign.plan.profiles.get(&cell.topology)?;
    let rarest_ns = text.profile(&cell.topology).ok()?.rarest_event_ns()?;
    let draws = cell.duration_ns as f64 / rarest_ns as f64;
    (draws < FEW_DRAWS).then_some(draws)
}

fn value(x: f64) -> String {
    if x.is_infinite() {
        "never".to_owned()
    } else {
        digits(Some(x).filter(|x| !x.is_nan()))
    }
}

#[cfg(test)]
mod tests;
