//! The table that `webloop run` prints at the end: a line per cell, aligned, and the links below.
//!
//! Columns that say nothing about these cells are left out. The table of the links is in `links`.

use endpoint::Mode;
use plan::Verdict;

use crate::layout::{Column, Shown, align, digits, number, text, whole};
use crate::links;
use crate::summary::Summary;

const ZERO_LEGEND: &str = "zero: arrivals in the same ms as the one before.";
const STEP_LEGEND: &str = "rise: 10 to 90 %. settling: into 2 %.";
const DRIFT_LEGEND: &str = "\
missed: due but not sent. slope: lateness gained for each second of schedule.
lag: lateness of the last message.";

const COLUMNS: [Column; 16] = [
    text("topology"),
    text("client").shown(Shown::IfDiffers),
    text("setup").shown(Shown::IfDiffers),
    text("mode").shown(Shown::IfFilled),
    number("", "rate"),
    number("", "#").shown(Shown::IfFilled),
    text("verdict"),
    number("messages", "sent"),
    number("messages", "missed"),
    number("zero", "%"),
    number("rise", "ms").shown(Shown::IfFilled),
    number("settling", "ms").shown(Shown::IfFilled),
    number("overshoot", "%").shown(Shown::IfFilled),
    number("slope", "ms/s").shown(Shown::IfFilled),
    number("lag", "s").shown(Shown::IfFilled),
    text("disturbed"),
];

/// What the cells of a table have in common; this decides which columns are left out.
struct Kind {
    repeated: bool,
    /// All loops are open: they have no step, and the table shows their drift.
    open: bool,
    /// Clients or setups are compared.
    clients: bool,
    /// The two modes are compared.
    modes: bool,
}

impl Kind {
    fn of(rows: &[Summary]) -> Self {
        let differ = |is_other: fn(&Summary, &Summary) -> bool| {
            rows.iter().any(|row| is_other(row, &rows[0]))
        };
        Self {
            repeated: rows.iter().any(|row| row.repeat > 1),
            open: !rows.is_empty() && rows.iter().all(|row| row.mode == Mode::Open),
            clients: differ(|one, other| one.client != other.client || one.setup != other.setup),
            modes: differ(|one, other| one.mode != other.mode),
        }
    }

    fn legend(&self) -> String {
        let rest = if self.open { DRIFT_LEGEND } else { STEP_LEGEND };
        if self.open {
            format!("{ZERO_LEGEND}\n{rest}\n")
        } else {
            format!("{ZERO_LEGEND} {rest}\n")
        }
    }
}

/// The table, with a legend. Numbers have three significant digits; `-` means that a column does not
/// apply.
#[must_use]
pub fn render(rows: &[Summary]) -> String {
    let kind = Kind::of(rows);
    let cells: Vec<Vec<String>> = rows.iter().map(|row| line(row, &kind)).collect();
    let table = format!(
        "{}{}\n{}",
        head(rows),
        align(&COLUMNS, &cells),
        kind.legend()
    );
    match links::render(rows) {
        links if links.is_empty() => table,
        links => table + "\n" + &links,
    }
}

/// The line over a table that contains simulated runs.
pub(crate) fn head(rows: &[Summary]) -> &'static str {
    if rows.iter().any(Summary::is_simulated) {
        "All runs are simulated, in virtual time.\n\n"
    } else {
        ""
    }
}

fn line(row: &Summary, kind: &Kind) -> Vec<String> {
    let percent = |share: Option<f64>| digits(share.map(|share| 100.0 * share));
    let when = |shown: bool, entry: String| if shown { entry } else { String::new() };
    let step = |figure: Option<f64>| when(!kind.open, digits(figure));
    let drift = |figure: Option<f64>| when(kind.open, digits(figure));
    vec![
        row.topology.clone(),
        row.client.to_string(),
        row.setup.clone(),
        when(kind.modes || !kind.clients, row.mode.to_string()),
        row.rate.clone(),
        when(kind.repeated, row.repeat.to_string()),
        verdict(row),
        whole(row.messages_sent),
        whole(row.messages_missed),
        percent(row.zero_1ms),
        step(row.rise_ms),
        step(row.settling_ms),
        step(row.overshoot_pct),
        drift(row.schedule_slope.map(|slope| 1e3 * slope)),
        drift(row.schedule_lag_s),
        row.disturbed.clone().unwrap_or_default(),
    ]
}

/// The loop's verdict if the run is complete and has one, else the run's own.
fn verdict(row: &Summary) -> String {
    match (row.verdict, row.loop_verdict) {
        (Some(Verdict::Complete), Some(of_loop)) => of_loop.to_string(),
        (Some(of_run), _) => of_run.to_string(),
        (None, _) => "not run".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use plan::Client;

    use super::*;
    use crate::response::LoopVerdict;

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
            loop_verdict: figures.map(|_| LoopVerdict::Stable),
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
            loop_verdict: Some(LoopVerdict::NotSettled),
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
            setup: setup.to_owned(),
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
            setup: setup.to_owned(),
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
        assert!(!table.contains("closed"), "{table}");
        insta::assert_snapshot!(table);
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
        assert_eq!(render(&[]).lines().count(), 4);
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
