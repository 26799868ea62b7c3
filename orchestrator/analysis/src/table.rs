//! The table that `webloop run` prints at the end: a line per cell, aligned, and the links below.
//!
//! What all cells share is said once above it, and columns that say nothing about these cells are left out.
//! The table of the links is in `links`.

use endpoint::Mode;
use plan::Verdict;

use crate::condition;
use crate::layout::{Column, digits, number, sheet, text, whole, wrapped};
use crate::links;
use crate::summary::Summary;

/// The columns after those of the cell's condition.
const COLUMNS: [Column; 16] = [
    number("", "length").once(" each"),
    number("", "#").unless_all("1").means("#: repeat."),
    text("verdict"),
    number("messages", "sent").once(" messages sent"),
    number("messages", "missed")
        .unless_all("0")
        .means("missed: due but not sent."),
    number("zero", "%")
        .unless_all("0")
        .means("zero: arrivals in the same ms as the one before."),
    number("rise", "ms")
        .unless_all("")
        .means("rise: 10 to 90 %."),
    number("settling", "ms")
        .unless_all("")
        .means("settling: into its band, 2 % of the step."),
    number("overshoot", "%").unless_all(""),
    number("worst", "e")
        .unless_all("")
        .means("worst: the greatest error from the fault on."),
    number("safe", "ms")
        .unless_all("")
        .means("safe: from the last command to the plant's safe state."),
    number("back", "ms")
        .unless_all("")
        .means("back: from the fault's end until the error stays within 2 %."),
    number("slope", "ms/s")
        .unless_all("")
        .means("slope: lateness gained for each second of schedule."),
    number("lag", "s")
        .unless_all("")
        .means("lag: lateness of the last message."),
    text("disturbed").unless_all(""),
    text("because").unless_all(""),
];

/// Most cells that have a line each. Nobody reads more, and their lines take more memory than their figures.
const MOST_LINES: usize = 5_000;

/// The table, with a legend; of more cells than anybody reads, only how many there are. `seed` is that of the campaign.
/// Numbers have three significant digits; `-` means that a column does not apply.
#[must_use]
pub fn render(rows: &[Summary], seed: u64) -> String {
    if rows.len() > MOST_LINES {
        return format!(
            "{} cells, seed {seed}: too many for a table, `summary.csv` has a row for each.\n\n{}",
            rows.len(),
            links::render(rows)
        );
    }
    // Open loops alone have no step: the table shows their drift.
    let is_open = rows.iter().all(|row| row.mode == Mode::Open);
    let unlike = links::unlike(rows);
    let cells: Vec<Vec<String>> = (rows.iter())
        .map(|row| line(row, is_open, &unlike))
        .collect();
    let columns = [&condition::COLUMNS[..], &COLUMNS].concat();
    let sheet = sheet(&columns, &cells);
    let mut parts = Vec::new();
    if rows.iter().any(Summary::is_simulated) {
        parts.push("All runs are simulated, in virtual time.\n".to_owned());
    }
    if !rows.is_empty() {
        parts.push(format!("{}, seed {seed}\n", sheet.said.join(", ")));
    }
    parts.extend([sheet.text, wrapped(&sheet.legend), links::render(rows)]);
    parts.retain(|part| !part.is_empty());
    parts.join("\n")
}

fn line(row: &Summary, is_open: bool, unlike: &[&str]) -> Vec<String> {
    let percent = |share: Option<f64>| digits(share.map(|share| 100.0 * share));
    let drift = |figure: Option<f64>| digits(figure.filter(|_| is_open));
    let settling = digits(row.of_step(row.settling_ms));
    let rest = [
        length(row),
        row.repeat.to_string(),
        verdict(row),
        whole(row.messages_sent),
        whole(row.messages_missed),
        percent(row.zero_1ms),
        digits(row.of_step(row.rise_ms)),
        links::marked(settling, &row.topology, unlike),
        digits(row.of_step(row.overshoot_pct)),
        digits(row.fault_worst),
        digits(row.fault_safe_ms),
        digits(row.fault_back_ms),
        drift(row.schedule_slope.map(|slope| 1e3 * slope)),
        drift(row.schedule_lag_s),
        row.disturbed.clone().unwrap_or_default(),
        because(row),
    ];
    condition::entries(row).into_iter().chain(rest).collect()
}

/// How long the controller sends; empty if it is not known.
fn length(row: &Summary) -> String {
    match row.duration_ns {
        0 => String::new(),
        ns => format!("{} s", ns as f64 / 1e9),
    }
}

/// The loop's verdict if the run is complete and has one, else the run's own.
fn verdict(row: &Summary) -> String {
    match (row.verdict, row.loop_verdict) {
        (Some(Verdict::Complete), Some(of_loop)) => of_loop.to_string(),
        (Some(of_run), _) => of_run.to_string(),
        (None, _) => "not run".to_owned(),
    }
}

/// Why the loop of a complete run does not just hold; empty if it does.
fn because(row: &Summary) -> String {
    let reason = row.loop_reason.clone();
    reason
        .filter(|_| row.verdict == Some(Verdict::Complete))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use plan::Client;

    use super::*;
    use crate::verdict::LoopVerdict;

    fn render(rows: &[Summary]) -> String {
        super::render(rows, 1)
    }

    fn cell(topology: &str, mode: Mode, rate: &str) -> Summary {
        Summary {
            topology: topology.to_owned(),
            mode,
            rate: rate.to_owned(),
            repeat: 1,
            verdict: Some(Verdict::Complete),
            ..Summary::default()
        }
    }

    fn measured(topology: &str, rtt: [f64; 3], figures: Option<[f64; 3]>) -> Summary {
        let mode = match figures {
            Some(_) => Mode::Closed,
            None => Mode::Open,
        };
        Summary {
            rtt_asked_p50_ms: (rtt[0] > 0.0).then_some(rtt[0]),
            rtt_due_p50_ms: (rtt[1] > 0.0).then_some(rtt[1]),
            rtt_measured_p50_ms: Some(rtt[2]),
            rtt_measured_ms: Some(rtt[2]),
            messages_sent: Some(2666),
            messages_missed: Some(0),
            zero_1ms: Some(0.0123),
            loop_verdict: figures.map(|_| LoopVerdict::Holds),
            rise_ms: figures.map(|f| f[0]),
            settling_ms: figures.map(|f| f[1]),
            overshoot_pct: figures.map(|f| f[2]),
            ..cell(
                topology,
                mode,
                if figures.is_some() {
                    "333 Hz"
                } else {
                    "100 Hz"
                },
            )
        }
    }

    #[test]
    fn the_table_of_a_campaign_reads_like_this() {
        let vpn = Summary {
            loop_verdict: Some(LoopVerdict::Unsettled),
            settling_ms: None,
            messages_missed: Some(17),
            ..measured(
                "diego-vpn",
                [53.14, 51.987, 52.113],
                Some([86.0, 0.0, 21.9]),
            )
        };
        let rows = [
            measured("arima", [0.0, 0.0, 0.0312], None),
            measured(
                "buccoo",
                [3.376, 3.3704, 3.4112],
                Some([114.0, 318.0, 5.568]),
            ),
            vpn,
            Summary {
                verdict: Some(Verdict::Invalid),
                ..measured("couva", [104.188, 98.7, 99.1], Some([90.0, 3033.0, 9.996]))
            },
            Summary {
                verdict: Some(Verdict::Unsupported),
                ..cell("diego-lan", Mode::Closed, "1 kHz")
            },
            Summary {
                verdict: None,
                ..cell("diego-lan", Mode::Open, "3.3 Hz")
            },
        ];
        let table = render(&rows);
        assert!(
            table.lines().all(|line| line.len() <= 120),
            "wider than a terminal:\n{table}"
        );
        insta::assert_snapshot!(table);
    }

    #[test]
    fn where_only_open_loops_are_compared_by_client_the_table_is_of_their_drift() {
        let cell = |client: Client, setup: &str, sent: u64, slope: f64| Summary {
            client,
            setup: setup.to_owned().into(),
            messages_due: 6000,
            messages_sent: Some(sent),
            messages_missed: Some(6000 - sent),
            zero_1ms: Some(0.0),
            schedule_slope: Some(slope),
            schedule_lag_s: Some(60.0 * slope),
            rtt_measured_ms: Some(0.0312),
            ..cell("arima", Mode::Open, "100 Hz")
        };
        insta::assert_snapshot!(render(&[
            cell(Client::Python, "paper-python", 6000, 0.000_000_12),
            cell(Client::Firefox, "paper-2011", 5497, 0.0911),
            cell(Client::Firefox, "worker", 5998, -0.000_002),
        ]));
    }

    #[test]
    fn where_only_closed_loops_are_compared_by_client_the_table_stays_on_a_terminal() {
        let cell = |client: Client, setup: &str| Summary {
            client,
            setup: setup.to_owned().into(),
            repeat: 20,
            ..measured(
                "diego-vpn",
                [53.14, 51.987, 52.113],
                Some([86.0, 1182.0, 21.9]),
            )
        };
        let table = render(&[
            cell(Client::Native, "paper-python"),
            cell(Client::Chromium, "paper-2011"),
        ]);
        assert!(
            table.lines().all(|line| line.len() <= 120),
            "wider than a terminal:\n{table}"
        );
        assert!(!table.contains("mode"), "{table}");
        insta::assert_snapshot!(table);
    }

    #[test]
    fn a_settling_time_that_hangs_on_an_unusual_link_is_marked_and_an_unstable_loop_has_no_figures()
    {
        let of = |topology: &str, stalled: (f64, f64), system: &str| Summary {
            system: system.to_owned(),
            duration_ns: 8_000_000_000,
            setup: match system {
                "motor" => "paper-python".to_owned().into(),
                system => format!("paper-python, system {system}").into(),
            },
            stalled_asked: Some(stalled.0),
            stalled_due: Some(stalled.1),
            ..measured(topology, [11.2, 11.0, 11.1], Some([100.0, 470.0, 15.1]))
        };
        let rows = [
            of("couva", (0.142, 0.0645), "motor"),
            of("couva", (0.142, 0.0645), "lag"),
            of("diego-lan", (0.006, 0.008), "motor"),
            Summary {
                loop_verdict: Some(LoopVerdict::Lost),
                settling_ms: None,
                overshoot_pct: Some(9.5e12),
                ..of("diego-lan", (0.006, 0.008), "lag")
            },
        ];
        insta::assert_snapshot!(render(&rows));
    }

    #[test]
    fn what_is_simulated_says_so_over_its_table_and_what_was_run_does_not() {
        let of = |backend: &str| Summary {
            backend: Some(backend.to_owned()),
            ..measured("buccoo", [3.4, 3.4, 3.4], Some([114.0, 318.0, 5.6]))
        };
        assert!(render(&[of("sim")]).starts_with("All runs are simulated"));
        assert!(!render(&[of("netns")]).contains("simulated"));
    }

    #[test]
    fn nothing_has_been_run_and_the_table_is_empty() {
        assert_eq!(render(&[]).lines().count(), 2);
    }

    #[test]
    fn repeats_have_a_column_where_there_are_any() {
        assert!(!render(&[cell("arima", Mode::Open, "100 Hz")]).contains('#'));
        assert!(
            render(&[Summary {
                repeat: 2,
                ..cell("arima", Mode::Open, "100 Hz")
            }])
            .contains('#')
        );
    }
}
