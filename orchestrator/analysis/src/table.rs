//! The table that ends `webloop run`: a line per cell, aligned, in about a hundred columns.

use plan::Verdict;

use crate::layout::{Column, align, digits, number, text, whole};
use crate::summary::Summary;

const LEGEND: &str = "\
RTT: the profile's mean, the link's at the instants of the echoes, and what they measured.
zero: arrivals in the same ms as the one before. rise: 10 to 90 %. settling: into 2 %.";

const COLUMNS: [Column; 15] = [
    text("topology"),
    text("client"),
    text("mode"),
    number("", "rate"),
    number("", "#"),
    text("verdict"),
    number("RTT/ms", "asked"),
    number("", "due"),
    number("", "probed"),
    number("messages", "sent"),
    number("", "missed"),
    number("zero", "%"),
    number("rise", "ms"),
    number("settling", "ms"),
    number("overshoot", "%"),
];

/// The table, with a line of legend; numbers have three significant digits, and `-` does not apply.
#[must_use]
pub fn render(rows: &[Summary]) -> String {
    let cells: Vec<Vec<String>> = rows.iter().map(line).collect();
    // A column that says the same of every cell tells nothing.
    let repeated = rows.iter().any(|row| row.repeat > 1);
    let clients = rows.iter().any(|row| row.client != rows[0].client);
    let shown = |name: &str| match name {
        "#" => repeated,
        "client" => clients,
        _ => true,
    };
    align(&COLUMNS, &cells, shown) + "\n" + LEGEND + "\n"
}

fn line(row: &Summary) -> Vec<String> {
    let percent = |share: Option<f64>| digits(share.map(|share| 100.0 * share));
    vec![
        row.topology.clone(),
        row.client.clone(),
        row.mode.clone(),
        row.rate.clone(),
        row.repeat.to_string(),
        verdict(row),
        digits(row.rtt_asked_ms),
        digits(row.rtt_due_ms),
        digits(row.rtt_measured_ms),
        whole(row.messages_sent),
        whole(row.messages_missed),
        percent(row.zero_1ms),
        digits(row.rise_ms),
        digits(row.settling_ms),
        digits(row.overshoot_pct),
    ]
}

/// The loop's verdict where the run has one to give, else the run's own.
fn verdict(row: &Summary) -> String {
    match (row.verdict, row.loop_verdict) {
        (Some(Verdict::Complete), Some(of_loop)) => of_loop.to_string(),
        (Some(of_run), _) => of_run.to_string(),
        (None, _) => "not run".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::LoopVerdict;

    fn cell(topology: &str, mode: &str, rate: &str) -> Summary {
        Summary {
            topology: topology.to_owned(),
            client: "native".to_owned(),
            mode: mode.to_owned(),
            rate: rate.to_owned(),
            repeat: 1,
            verdict: Some(Verdict::Complete),
            ..Summary::default()
        }
    }

    fn measured(topology: &str, rtt: [f64; 3], figures: Option<[f64; 3]>) -> Summary {
        let mode = if figures.is_some() { "closed" } else { "open" };
        Summary {
            rtt_asked_ms: (rtt[0] > 0.0).then_some(rtt[0]),
            rtt_due_ms: (rtt[1] > 0.0).then_some(rtt[1]),
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
                ..cell("diego-lan", "closed", "1 kHz")
            },
            Summary {
                verdict: None,
                ..cell("diego-lan", "open", "3.3 Hz")
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
    fn repeats_have_a_column_where_there_are_any() {
        assert!(!render(&[cell("arima", "open", "100 Hz")]).contains('#'));
        assert!(
            render(&[Summary {
                repeat: 2,
                ..cell("arima", "open", "100 Hz")
            }])
            .contains('#')
        );
    }
}
