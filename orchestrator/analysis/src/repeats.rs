//! What repeats agree on: medians over the runs that differ only in their link's realisation.
//!
//! A median of twenty forgives the run whose step met a stall; its quartiles show how far runs of
//! the same kind lie apart. A run that did not settle counts as one that settles later than any.

use plan::Verdict;

use crate::layout::{Column, align, digits, number, text};
use crate::response::LoopVerdict;
use crate::summary::Summary;

const COLUMNS: [Column; 12] = [
    text("topology"),
    text("client"),
    text("mode"),
    number("", "rate"),
    number("", "runs"),
    number("", "stable"),
    number("settling/ms", "median"),
    number("", "quarter"),
    number("", "3/4"),
    number("times", "first"),
    number("rise", "ms"),
    number("overshoot", "%"),
];

const LEGEND: &str = "\
Medians over complete runs, with the quartiles of settling.
times first: against the first topology at the same rate.";

/// The runs that differ only in their repeat.
struct Group<'a> {
    first: &'a Summary,
    complete: Vec<&'a Summary>,
    runs: usize,
}

impl Group<'_> {
    fn is_like(&self, row: &Summary) -> bool {
        self.first.topology == row.topology && self.is_comparable(row)
    }

    fn is_comparable(&self, row: &Summary) -> bool {
        let kind = |row: &Summary| (row.client.clone(), row.mode.clone(), row.h_ns);
        kind(self.first) == kind(row)
    }

    /// A quantile of a figure over the complete runs; `None` where it is beyond them.
    fn quantile(&self, q: f64, figure: fn(&Summary) -> Option<f64>) -> Option<f64> {
        let mut values: Vec<f64> = self
            .complete
            .iter()
            .map(|row| figure(row).unwrap_or(f64::INFINITY))
            .collect();
        values.sort_by(f64::total_cmp);
        let middle = q * values.len().checked_sub(1)? as f64;
        // Between two runs, their mean: as medians are taken.
        let (low, high) = (
            values[middle.floor() as usize],
            values[middle.ceil() as usize],
        );
        Some(f64::midpoint(low, high)).filter(|value| value.is_finite())
    }
}

/// The medians of every group, or nothing where no cell was repeated.
#[must_use]
pub fn render(rows: &[Summary]) -> Option<String> {
    let mut groups: Vec<Group> = Vec::new();
    for row in rows.iter().filter(|row| row.mode == "closed") {
        let at = groups
            .iter()
            .position(|group| group.is_like(row))
            .unwrap_or_else(|| {
                groups.push(Group {
                    first: row,
                    complete: Vec::new(),
                    runs: 0,
                });
                groups.len() - 1
            });
        groups[at].runs += 1;
        if row.verdict == Some(Verdict::Complete) {
            groups[at].complete.push(row);
        }
    }
    groups.retain(|group| group.runs > 1);
    let lines: Vec<Vec<String>> = groups.iter().map(|group| line(group, &groups)).collect();
    (!lines.is_empty()).then(|| align(&COLUMNS, &lines, |_| true) + "\n" + LEGEND + "\n")
}

fn line(group: &Group, groups: &[Group]) -> Vec<String> {
    let settling = |group: &Group, q| group.quantile(q, |row| row.settling_ms);
    let reference = groups
        .iter()
        .find(|other| other.is_comparable(group.first))
        .and_then(|other| settling(other, 0.5));
    let times = settling(group, 0.5)
        .zip(reference)
        .map(|(own, first)| own / first);
    let stable = group
        .complete
        .iter()
        .filter(|row| row.loop_verdict == Some(LoopVerdict::Stable))
        .count();
    vec![
        group.first.topology.clone(),
        group.first.client.clone(),
        group.first.mode.clone(),
        group.first.rate.clone(),
        format!("{}/{}", group.complete.len(), group.runs),
        stable.to_string(),
        digits(settling(group, 0.5)),
        digits(settling(group, 0.25)),
        digits(settling(group, 0.75)),
        digits(times),
        digits(group.quantile(0.5, |row| row.rise_ms)),
        digits(group.quantile(0.5, |row| row.overshoot_pct)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(topology: &str, repeat: u32, settling_ms: Option<f64>) -> Summary {
        Summary {
            topology: topology.to_owned(),
            client: "native".to_owned(),
            mode: "closed".to_owned(),
            rate: "333 Hz".to_owned(),
            repeat,
            verdict: Some(Verdict::Complete),
            loop_verdict: Some(match settling_ms {
                Some(_) => LoopVerdict::Stable,
                None => LoopVerdict::NotSettled,
            }),
            settling_ms,
            rise_ms: Some(100.0),
            overshoot_pct: Some(5.0),
            ..Summary::default()
        }
    }

    #[test]
    fn medians_stand_against_the_first_topology_and_forgive_one_run_that_never_settled() {
        let rows = [
            run("arima", 1, Some(300.0)),
            run("arima", 2, Some(320.0)),
            run("arima", 3, Some(310.0)),
            run("couva", 1, Some(330.0)),
            run("couva", 2, None),
            run("couva", 3, Some(310.0)),
            Summary {
                verdict: Some(Verdict::Invalid),
                ..run("couva", 4, Some(1.0))
            },
        ];
        // arima: the middle of 300, 310, 320. couva: of 310, 330 and never; the invalid run does
        // not count. 330 / 310 = 1.06.
        insta::assert_snapshot!(render(&rows).expect("there are repeats"));
    }

    #[test]
    fn without_repeats_there_are_no_medians() {
        assert_eq!(
            render(&[run("arima", 1, Some(300.0)), run("couva", 1, Some(330.0))]),
            None
        );
    }
}
