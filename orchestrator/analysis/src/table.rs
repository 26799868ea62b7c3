//! The table that ends `webloop run`: a line per cell, aligned, in about a hundred columns.

use plan::Verdict;

use crate::summary::Summary;

const LEGEND: &str = "RTT: the profile's mean, the link's at the echoes, theirs as measured; \
zero: in the same ms; rise 10-90 %, settling 2 %";

/// One column: its two lines of heading, and whether numbers stand in it.
struct Column {
    group: &'static str,
    name: &'static str,
    number: bool,
}

const fn text(name: &'static str) -> Column {
    Column {
        group: "",
        name,
        number: false,
    }
}

const fn number(group: &'static str, name: &'static str) -> Column {
    Column {
        group,
        name,
        number: true,
    }
}

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
    let cells: Vec<[String; COLUMNS.len()]> = rows.iter().map(line).collect();
    let shown = |i: usize| COLUMNS[i].name != "#" || rows.iter().any(|row| row.repeat > 1);
    let width = |i: usize| {
        let heading = COLUMNS[i].name.len().max(COLUMNS[i].group.len());
        cells
            .iter()
            .map(|cell| cell[i].chars().count())
            .fold(heading, usize::max)
    };
    let layout: Vec<(usize, usize)> = (0..COLUMNS.len())
        .filter(|i| shown(*i))
        .map(|i| (i, width(i)))
        .collect();
    let print = |entry: &dyn Fn(usize) -> String| {
        let entries = layout.iter().map(|(i, width)| match COLUMNS[*i].number {
            true => format!("{:>width$}", entry(*i)),
            false => format!("{:<width$}", entry(*i)),
        });
        entries.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    let mut out = print(&|i| COLUMNS[i].group.to_owned());
    out += &print(&|i| COLUMNS[i].name.to_owned());
    for cell in &cells {
        out += &print(&|i| cell[i].clone());
    }
    out + "\n" + LEGEND + "\n"
}

fn line(row: &Summary) -> [String; COLUMNS.len()] {
    let percent = |share: Option<f64>| digits(share.map(|share| 100.0 * share));
    [
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

fn whole(n: Option<u64>) -> String {
    n.map_or("-".to_owned(), |n| n.to_string())
}

/// Three significant digits, but no more than three after the point and none before it cut off.
/// Beyond a million the power of ten says enough.
fn digits(x: Option<f64>) -> String {
    const MOST_DECIMALS: i32 = 3;
    let Some(x) = x.filter(|x| x.is_finite()) else {
        return "-".to_owned();
    };
    if x.abs() >= 1e6 {
        return format!("{x:.1e}");
    }
    if x.abs() < 0.5 * 10f64.powi(-MOST_DECIMALS) {
        return "0".to_owned();
    }
    // The exponent is that of the rounded number: 9.996 is 10.0, not 10.00.
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    let decimals = (2 - rounded.abs().log10().floor() as i32).clamp(0, MOST_DECIMALS);
    format!("{x:.*}", decimals as usize)
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

    #[test]
    fn numbers_have_three_significant_digits_and_no_noise() {
        let cases = [
            (0.0, "0"),
            (0.0004, "0"),
            (0.0312, "0.031"),
            (0.9996, "1.00"),
            (1.0, "1.00"),
            (9.996, "10.0"),
            (53.14, "53.1"),
            (99.96, "100"),
            (318.4, "318"),
            (3033.37, "3033"),
            (-4.567, "-4.57"),
            (2.5e8, "2.5e8"),
        ];
        for (x, words) in cases {
            assert_eq!(digits(Some(x)), words);
        }
        assert_eq!(
            (digits(None), digits(Some(f64::NAN))),
            ("-".to_owned(), "-".to_owned())
        );
    }
}
