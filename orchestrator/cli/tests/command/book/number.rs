//! The numbers in sentences of README and book: made again from results/ and the profiles, and looked for
//! in the words around them.

use analysis::{LoopVerdict, Summary};
use plan::{Plan, Verdict};

use crate::book::page::ROOT;

/// The rows of a folder of results/.
pub(crate) fn rows(folder: &str) -> Vec<Summary> {
    let path = format!("{ROOT}/results/{folder}/summary.csv");
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().collect::<Result<_, _>>().unwrap()
}

/// The table of a folder of results/, as webloop prints it of these rows today.
pub(crate) fn table(folder: &str) -> String {
    let plan = std::fs::read_to_string(format!("{ROOT}/results/{folder}/plan.json")).unwrap();
    let plan = Plan::from_json(&plan).unwrap();
    let mut rows = rows(folder);
    // What the CSV has no column for.
    for row in &mut rows {
        let cell = plan.cells.iter().find(|cell| cell.id == row.cell).unwrap();
        (row.system, row.duration_ns) = (cell.system.clone(), cell.duration_ns);
    }
    let medians = analysis::repeats::render(&rows, analysis::repeats::Over::Complete);
    analysis::table::render(&rows, plan.seed)
        + &medians.map_or_else(String::new, |of| format!("\n{of}"))
}

/// The complete closed loops at 333 Hz over a topology.
fn steps<'a>(rows: &'a [Summary], topology: &'a str) -> impl Iterator<Item = &'a Summary> {
    rows.iter().filter(move |row| {
        row.topology == topology
            && row.rate == "333 Hz"
            && row.verdict == Some(Verdict::Complete)
            && row.loop_verdict.is_some()
    })
}

/// The median; what is `None` is later than any number.
fn median(values: impl Iterator<Item = Option<f64>>) -> f64 {
    let mut values: Vec<f64> = values.map(|value| value.unwrap_or(f64::INFINITY)).collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() % 2 {
        0 => (values[middle - 1] + values[middle]) / 2.0,
        _ => values[middle],
    }
}

/// Each page with a sentence that it has to have.
pub(crate) fn sentences() -> Vec<(&'static str, String)> {
    let rows = rows("settling");
    let settling = |topology| median(steps(&rows, topology).map(|row| row.settling_ms));
    let overshoot = median(steps(&rows, "diego-vpn").map(|row| row.overshoot_pct));
    let late = steps(&rows, "couva").filter(|row| row.settling_ms.is_none_or(|ms| ms > 1_000.0));
    let share = late.count() as f64 / steps(&rows, "couva").count() as f64;
    assert!(
        (0.2..0.35).contains(&share),
        "a quarter of the runs: {share}"
    );
    let mut sentences = vec![(
        "README.md",
        format!(
            "the VPN makes the step settle {:.1} times later with {overshoot:.0} % of overshoot",
            settling("diego-vpn") / settling("arima")
        ),
    )];
    for name in ["buccoo", "couva", "diego-lan", "diego-vpn"] {
        let (profile, _) =
            link::Profile::read(link::Profile::builtin(name).unwrap(), name, &|_: &str| {
                Err(String::new())
            });
        let rtt_ms = profile.unwrap().asked().unwrap().rtt_avg_ms;
        let digits = usize::from(rtt_ms < 10.0);
        sentences.push(("README.md", format!("RTT {rtt_ms:>4.digits$} ms")));
    }
    sentences.extend(
        by_client()
            .lines()
            .map(|line| ("README.md", line.to_owned())),
    );
    let faults = [
        by_fault(
            "faults",
            &["outage", "loss-burst", "reset", "delay-step", "flapping"],
        ),
        by_fault(
            "end-faults",
            &[
                "frozen-controller",
                "frozen-plant",
                "starved-controller",
                "starved-plant",
                "killed-controller",
                "killed-plant",
            ],
        ),
    ];
    sentences.extend(
        faults
            .iter()
            .flat_map(|table| table.lines())
            .map(|line| ("docs/faults.md", line.to_owned())),
    );
    sentences
}

/// Median time to be back after each of these faults, by client, over the links of a folder of results/; all of its
/// runs are complete.
fn by_fault(folder: &str, faults: &[&str]) -> String {
    const CLIENTS: [&str; 4] = ["native", "python", "chromium", "firefox"];
    let rows = rows(folder);
    assert!(
        rows.iter()
            .all(|row| row.verdict == Some(Verdict::Complete))
    );
    let width = faults.iter().map(|fault| fault.len()).max().unwrap_or(0);
    let mut table = format!("{:width$}", "back/ms");
    for client in CLIENTS {
        table += &format!("  {client:>8}");
    }
    for fault in faults {
        table += &format!("\n{fault:width$}");
        for client in CLIENTS {
            let of_it = rows.iter().filter(|row| {
                row.fault.as_deref() == Some(*fault) && row.client.to_string() == client
            });
            let back: Vec<Option<f64>> = of_it.map(|row| row.fault_back_ms).collect();
            table += &match back.as_slice() {
                [] => format!("  {:>8}", "-"),
                back => format!("  {:8.0}", median(back.iter().copied())),
            };
        }
    }
    table
}

/// The clients of the table on the first screen: label, client, setup.
const CLIENTS: [(&str, &str, &str); 6] = [
    ("native", "native", "paper-python"),
    ("python", "python", "paper-python"),
    ("chromium, one WebSocket", "chromium", "socket"),
    ("firefox, one WebSocket", "firefox", "socket"),
    ("chromium, a request at a time", "chromium", "worker"),
    ("firefox, a request at a time", "firefox", "worker"),
];

/// Median settling at 333 Hz by client and link, from results/paper.
fn by_client() -> String {
    const TOPOLOGIES: [&str; 5] = ["arima", "buccoo", "couva", "diego-lan", "diego-vpn"];
    let rows = rows("paper");
    let mut table = format!("{:29}", "settling/ms, h = 3 ms");
    for topology in TOPOLOGIES {
        table += &format!("  {topology:>9}");
    }
    for (label, client, setup) in CLIENTS {
        table += &format!("\n{label:29}");
        for topology in TOPOLOGIES {
            let of_it =
                |row: &&Summary| row.client.to_string() == client && row.setup.to_string() == setup;
            let settled = |row: &Summary| match row.loop_verdict {
                Some(LoopVerdict::Holds) => row.settling_ms,
                _ => None,
            };
            let median = median(steps(&rows, topology).filter(of_it).map(settled));
            table += &match median.is_finite() {
                true => format!("  {median:9.0}"),
                false => format!("  {:>9}", "lost"),
            };
        }
    }
    table
}
