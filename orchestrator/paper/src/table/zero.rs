//! Table 3: the share of arrivals at the same time as the one before, at three resolutions of the
//! clock.

use analysis::Campaign;
use analysis::arrival::Arrivals;
use analysis::layout::number as column;
use endpoint::Mode;

use crate::printed;
use crate::subject::{CHROMIUM_2011, FIREFOX_2011, NATIVE, PYTHON, Subject};
use report::group::Group;
use report::origin::Origin;
use report::table::{Entry, Table};

const TOPOLOGIES: [&str; 3] = ["arima", "buccoo", "couva"];

/// In the paper's order.
const RATES: [(&str, u64); 3] = [
    ("100 Hz", printed::H_100_HZ_NS),
    ("10 Hz", printed::H_10_HZ_NS),
    ("3.3 Hz", printed::H_3_HZ_NS),
];

/// The paper's client comes first; its rows have the paper's numbers too.
const SUBJECTS: [Subject; 4] = [FIREFOX_2011, CHROMIUM_2011, PYTHON, NATIVE];

pub(super) fn table(campaign: &Campaign) -> Table {
    let mut columns = vec![column("", "topology"), column("", "client")];
    for (rate, _) in RATES {
        let names = ["the paper", "exact", "1 ms", "10 ms", "arrivals"];
        columns.extend(names.map(|name| column(rate, name)));
    }
    let mut origin = Origin::beside(printed::OPEN_LOOP_S);
    let mut rows = Vec::new();
    for topology in TOPOLOGIES {
        for subject in SUBJECTS {
            let mut row = vec![Entry::text(topology), Entry::text(subject.name())];
            for (_, h_ns) in RATES {
                let group = subject.runs(campaign, topology, Mode::Open, h_ns);
                origin.all(&group);
                row.push(if subject == FIREFOX_2011 {
                    theirs(topology, h_ns)
                } else {
                    Entry::None
                });
                row.extend(ours(&group));
            }
            rows.push(row);
        }
    }
    Table {
        name: "table-3".to_owned(),
        title: "Table 3: share of arrivals at the same time as the one before".to_owned(),
        notes: vec![
            "Shares are from 0 to 1; the paper's column says percentage, but only shares are counts \
             of whole messages."
                .to_owned(),
            "exact, 1 ms, 10 ms: the same time on a clock of that resolution; the paper's is not \
             known."
                .to_owned(),
            format!("{}.", origin.line(campaign)),
        ],
        columns,
        rows,
    }
}

fn theirs(topology: &str, h_ns: u64) -> Entry {
    printed::TABLE_3
        .iter()
        .find(|one| one.topology == topology && one.h_ns == h_ns)
        .map_or(Entry::None, |one| Entry::printed(one.share))
}

/// Shares at the three resolutions, and the number of arrivals, over all runs of a group.
fn ours(group: &Group<'_>) -> [Entry; 4] {
    let runs: Vec<Arrivals> = group
        .runs
        .iter()
        .filter_map(|run| run.metrics.map(|metrics| metrics.arrivals))
        .collect();
    let arrivals: u64 = runs.iter().map(|run| run.count).sum();
    let share = |of: fn(&Arrivals) -> Option<f64>| Entry::measured(pooled(&runs, of), 3);
    [
        share(|run| run.zero_exact),
        share(|run| run.zero_1ms),
        share(|run| run.zero_10ms),
        if runs.is_empty() {
            Entry::None
        } else {
            Entry::count(arrivals)
        },
    ]
}

/// The share over several runs, each weighted by its number of pairs of consecutive arrivals.
fn pooled(runs: &[Arrivals], share: fn(&Arrivals) -> Option<f64>) -> Option<f64> {
    let pairs = |run: &Arrivals| run.count.saturating_sub(1) as f64;
    let (mut same, mut all) = (0.0, 0.0);
    for run in runs {
        same += share(run)? * pairs(run);
        all += pairs(run);
    }
    (all > 0.0).then(|| same / all)
}
