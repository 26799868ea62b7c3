//! Table 2: round trips of the echoes, beside the paper's pings and beside what the link had at the
//! same instants.

use analysis::layout::number as column;
use analysis::statistics::Spread;
use analysis::{Campaign, Run};
use endpoint::Mode;

use crate::printed::{self, Ping};
use report::group::Group;
use report::origin::Origin;
use report::table::{Entry, Table};

pub(super) fn table(campaign: &Campaign) -> Table {
    let mut columns = vec![column("", "topology")];
    for (group, counted) in [("the paper", false), ("here", true), ("the link", false)] {
        let names = ["min/ms", "avg/ms", "max/ms", "sd/ms", "loss/%"];
        columns.extend(names.map(|name| column(group, name)));
        columns.extend(counted.then(|| column(group, "echoes")));
    }
    let mut origin = Origin::beside(printed::OPEN_LOOP_S);
    let rows = printed::TABLE_2
        .iter()
        .map(|theirs| {
            let group = open_loops(campaign, theirs.topology);
            let runs = one_a_seed(&group);
            origin.take(&runs);
            row(theirs, &Pool::of(&runs))
        })
        .collect();
    Table {
        name: "table-2".to_owned(),
        title: "Table 2: round trips".to_owned(),
        notes: vec![
            "here: echoes through the link beside the open loops, of one run for each realisation \
             of a link, the longest."
                .to_owned(),
            "the link: what the model had at the instants of these echoes; arima has no link."
                .to_owned(),
            format!("{}.", origin.line(campaign)),
        ],
        columns,
        rows,
    }
}

/// Every open loop on one topology, from any client at any rate.
fn open_loops<'a>(campaign: &'a Campaign, topology: &str) -> Group<'a> {
    let is_asked =
        |run: &&Run| run.cell.topology == topology && run.cell.settings.mode == Mode::Open;
    Group::complete(campaign.runs.iter().filter(is_asked))
}

/// The longest run of each link seed. Other runs of that seed met the same link at the same time, and
/// would count its states twice.
fn one_a_seed<'a>(group: &Group<'a>) -> Vec<&'a Run> {
    let mut longest: Vec<&Run> = Vec::new();
    for run in &group.runs {
        let same = longest
            .iter_mut()
            .find(|one| one.cell.link_seed == run.cell.link_seed);
        match same {
            None => longest.push(run),
            Some(one) if one.cell.duration_ns < run.cell.duration_ns => *one = run,
            Some(_) => {}
        }
    }
    longest
}

fn row(theirs: &Ping, pool: &Pool) -> Vec<Entry> {
    let mut row = vec![Entry::text(theirs.topology)];
    row.extend(
        [
            theirs.min_ms,
            theirs.avg_ms,
            theirs.max_ms,
            theirs.sd_ms,
            // Rounded to a tenth, as in the paper: 0.009 times 100 is not quite 0.9.
            (1000.0 * theirs.loss).round() / 10.0,
        ]
        .map(Entry::printed),
    );
    row.extend(measured(&pool.here));
    row.push(match pool.here.sent {
        0 => Entry::None,
        sent => Entry::count(sent),
    });
    row.extend(measured(&pool.link));
    row
}

fn measured(echoes: &Echoes) -> [Entry; 5] {
    let spread = echoes.spread;
    let ms = |of: fn(&Spread) -> f64| Entry::measured(spread.as_ref().map(of), 4);
    [
        ms(|spread| spread.min_ms),
        ms(|spread| spread.avg_ms),
        ms(|spread| spread.max_ms),
        ms(|spread| spread.sd_ms),
        // Without a delay, as on loopback, there is no link, and so no loss to show.
        Entry::measured(spread.and_then(|_| echoes.loss_percent()), 2),
    ]
}

/// The echoes of several runs, as measured and as the link had them.
#[derive(Debug, Default)]
struct Pool {
    here: Echoes,
    link: Echoes,
}

impl Pool {
    fn of(runs: &[&Run]) -> Pool {
        let mut pool = Pool::default();
        for probes in runs.iter().filter_map(|run| run.metrics?.probes) {
            pool.here.add(probes.count, probes.lost, probes.rtt);
            pool.link.add(probes.count, probes.due_lost, probes.due_rtt);
        }
        pool
    }
}

/// Echoes, and the spread of those that came back.
#[derive(Debug, Default)]
struct Echoes {
    sent: u64,
    lost: u64,
    spread: Option<Spread>,
}

impl Echoes {
    /// Adds the echoes of one more run. Means and squares are weighted by the number of echoes that
    /// came back.
    fn add(&mut self, sent: u64, lost: u64, spread: Option<Spread>) {
        let before = (self.sent - self.lost) as f64;
        self.sent += sent;
        self.lost += lost;
        let new = (sent - lost.min(sent)) as f64;
        self.spread = match (self.spread, spread) {
            (Some(a), Some(b)) => {
                let mean = |a: f64, b: f64| (a * before + b * new) / (before + new);
                let avg_ms = mean(a.avg_ms, b.avg_ms);
                let square = |s: &Spread| s.sd_ms.powi(2) + (s.avg_ms - avg_ms).powi(2);
                Some(Spread {
                    min_ms: a.min_ms.min(b.min_ms),
                    avg_ms,
                    max_ms: a.max_ms.max(b.max_ms),
                    sd_ms: mean(square(&a), square(&b)).sqrt(),
                })
            }
            (a, b) => a.or(b),
        };
    }

    fn loss_percent(&self) -> Option<f64> {
        (self.sent > 0).then(|| 100.0 * self.lost as f64 / self.sent as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use analysis::statistics::Moments;
    use proptest::prelude::*;

    fn moments(values: &[f64]) -> Moments {
        let mut moments = Moments::default();
        values.iter().for_each(|x| moments.push(*x));
        moments
    }

    proptest! {
        #[test]
        fn two_runs_pooled_are_all_of_their_echoes(
            a in prop::collection::vec(0.0f64..100.0, 1..50), b in prop::collection::vec(0.0f64..100.0, 1..50),
        ) {
            let mut pooled = Echoes::default();
            for values in [&a, &b] {
                let n = values.len() as u64;
                // One more echo of each run was lost.
                pooled.add(n + 1, 1, moments(values).spread());
            }
            let all = moments(&[a, b].concat()).spread().expect("not empty");
            let found = pooled.spread.expect("not empty");
            prop_assert!((found.avg_ms - all.avg_ms).abs() < 1e-9);
            prop_assert!((found.sd_ms - all.sd_ms).abs() < 1e-6);
            prop_assert_eq!((found.min_ms, found.max_ms), (all.min_ms, all.max_ms));
            prop_assert_eq!(pooled.lost, 2);
        }
    }
}
