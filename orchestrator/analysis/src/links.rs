//! The links under a table of cells: a line per link, with what was asked of it and what was measured.
//!
//! Round trips are given as median and 90th percentile. A mean over ten seconds says little about a
//! link that stalls: it depends on whether a stall falls into these seconds. Where it does more or less than
//! usual, the settling times of that topology are marked in the tables above, and a sentence says why.

use crate::layout::{Column, digits, grouped, number, sheet, text, wrapped};
use crate::statistics::{mean, median};
use crate::summary::Summary;

const COLUMNS: [Column; 9] = [
    text("link"),
    number("50 %/ms", "asked")
        .unless_all("")
        .means("asked: of the profile over a long time;"),
    number("50 %/ms", "due")
        .unless_all("")
        .means("due: of the link at the instants of the echoes;"),
    number("50 %/ms", "probed").means("probed: of the echoes."),
    number("90 %/ms", "asked").unless_all(""),
    number("90 %/ms", "due").unless_all(""),
    number("90 %/ms", "probed").unless_all(""),
    number("stalled/%", "asked")
        .unless_all("")
        .means("stalled: share of time, over a long time and here."),
    number("stalled/%", "here").unless_all(""),
];

/// If the share of time stalled differs from the long-term share by more than this factor, a sentence
/// says so.
const LIKE: f64 = 2.0;

/// Stands behind the figures of a run whose link stalled more or less than it usually does, and before the sentence
/// about it.
const MARK: &str = "*";

/// The table of the links, in the order of the cells, with a legend; empty if no cell has echoes.
pub(crate) fn render(rows: &[Summary]) -> String {
    let links: Vec<Link> = links(rows);
    if links.is_empty() {
        return String::new();
    }
    let lines: Vec<Vec<String>> = links.iter().map(Link::line).collect();
    let sheet = sheet(&COLUMNS, &lines);
    let legend = [
        &["50 %, 90 %: quantiles of the round trip."],
        &sheet.legend[..],
    ]
    .concat();
    let mut out = format!("{}\n{}", sheet.text, wrapped(&legend));
    for link in &links {
        let mut own = rows.iter().filter(|row| row.topology == link.name);
        let mark = match own.any(|row| row.settling_ms.is_some()) {
            true => MARK,
            false => "",
        };
        out += &link
            .unlike()
            .map_or_else(String::new, |sentence| format!("{mark}{sentence}\n"));
    }
    out
}

/// The topologies whose links were stalled much more or much less than they are over a long time.
pub(crate) fn unlike(rows: &[Summary]) -> Vec<&str> {
    let links = links(rows).into_iter();
    let unlike = links.filter(|link| link.unlike().is_some());
    unlike.map(|link| link.name).collect()
}

/// A figure of a run on a topology, marked if that is among those whose links were unlike themselves. Room
/// for the mark keeps the numbers of a column aligned.
pub(crate) fn marked(figure: String, topology: &str, unlike: &[&str]) -> String {
    if unlike.is_empty() {
        figure
    } else if unlike.contains(&topology) && figure != "-" {
        figure + MARK
    } else {
        figure + " "
    }
}

/// The link of one topology: medians over its cells, all of which ran at the same link time.
struct Link<'a> {
    name: &'a str,
    p50: [Option<f64>; 3],
    p90: [Option<f64>; 3],
    /// Shares of time stalled: over a long time, and the mean over these runs.
    stalled: Option<(f64, f64)>,
}

fn links(rows: &[Summary]) -> Vec<Link<'_>> {
    let measured = rows.iter().filter(|row| row.rtt_measured_ms.is_some());
    let of = |(name, rows): (_, Vec<&Summary>)| {
        let figures = |figure: fn(&Summary) -> Option<f64>| {
            let figures = rows.iter().filter_map(|row| figure(row));
            figures.collect::<Vec<f64>>()
        };
        let middle = |figure| median(&figures(figure));
        let here = mean(&figures(|row| row.stalled_due));
        Link {
            name,
            p50: [
                middle(|row| row.rtt_asked_p50_ms),
                middle(|row| row.rtt_due_p50_ms),
                middle(|row| row.rtt_measured_p50_ms),
            ],
            p90: [
                middle(|row| row.rtt_asked_p90_ms),
                middle(|row| row.rtt_due_p90_ms),
                middle(|row| row.rtt_measured_p90_ms),
            ],
            stalled: middle(|row| row.stalled_asked).map(|asked| (asked, here)),
        }
    };
    let links = grouped(measured, |row| row.topology.as_str());
    links.into_iter().map(of).collect()
}

impl Link<'_> {
    fn line(&self) -> Vec<String> {
        let percent = |share: Option<f64>| digits(share.map(|share| 100.0 * share));
        let mut line = vec![self.name.to_owned()];
        line.extend(self.p50.into_iter().chain(self.p90).map(digits));
        line.push(percent(self.stalled.map(|(asked, _)| asked)));
        line.push(percent(self.stalled.map(|(_, here)| here)));
        line
    }

    /// A sentence, if its runs were stalled much more or much less than the link is over a long time.
    fn unlike(&self) -> Option<String> {
        let (asked, here) = self.stalled?;
        let like = asked / LIKE..=asked * LIKE;
        (!like.contains(&here)).then(|| {
            format!(
                "{}: stalled {} % of these seconds, {} % over a long time.",
                self.name,
                digits(Some(100.0 * here)),
                digits(Some(100.0 * asked))
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(
        topology: &str,
        p50_ms: [f64; 3],
        p90_ms: [f64; 3],
        stalled: Option<(f64, f64)>,
    ) -> Summary {
        let real = |ms: f64| (ms > 0.0).then_some(ms);
        Summary {
            topology: topology.to_owned(),
            rtt_measured_ms: Some(1.0),
            rtt_asked_p50_ms: real(p50_ms[0]),
            rtt_due_p50_ms: real(p50_ms[1]),
            rtt_measured_p50_ms: real(p50_ms[2]),
            rtt_asked_p90_ms: real(p90_ms[0]),
            rtt_due_p90_ms: real(p90_ms[1]),
            rtt_measured_p90_ms: real(p90_ms[2]),
            stalled_asked: stalled.map(|(asked, _)| asked),
            stalled_due: stalled.map(|(_, here)| here),
            ..Summary::default()
        }
    }

    #[test]
    fn a_link_that_was_unlike_itself_is_told_and_one_that_stalls_never_has_no_share() {
        let quiet = |here| {
            cell(
                "couva",
                [9.6, 9.4, 9.5],
                [243.1, 16.2, 16.3],
                Some((0.142, here)),
            )
        };
        let rows = [
            cell("arima", [0.0, 0.0, 0.021], [0.0, 0.0, 0.030], None),
            cell("buccoo", [3.38, 3.37, 3.41], [4.01, 3.99, 4.03], None),
            quiet(0.004),
            quiet(0.0),
        ];
        insta::assert_snapshot!(render(&rows));
        // Within a factor of two there is no sentence.
        assert!(!render(&[quiet(0.08)]).contains("over a long time."));
        assert!(render(&[quiet(0.3)]).contains("stalled 30.0 % of these seconds, 14.2 %"));
    }

    #[test]
    fn cells_without_echoes_have_no_links() {
        assert_eq!(render(&[Summary::default()]), "");
        assert_eq!(render(&[]), "");
    }
}
