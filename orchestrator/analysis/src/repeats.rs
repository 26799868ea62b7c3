//! Medians over repeats: runs that differ only in their link's realisation.
//!
//! A median over twenty runs is hardly affected by one whose step met a stall; the quartiles show how
//! far runs of the same kind lie apart. A run that did not settle counts as settling later than all
//! others.

use endpoint::Mode;
use plan::{Client, Verdict};

use crate::condition;
use crate::layout::{Column, digits, grouped, number, sheet};
use crate::links;
use crate::statistics;
use crate::summary::Summary;
use crate::verdict::LoopVerdict;

/// The columns after those of the group's condition.
const COLUMNS: [Column; 6] = [
    number("", "runs").once(" runs complete"),
    number("", "holds").once(" hold"),
    number("settling/ms", "median"),
    number("settling/ms", "quarter"),
    number("settling/ms", "3/4"),
    number("times", "first").unless_all(""),
];
/// The columns after those of the yardsticks.
const LAST_COLUMNS: [Column; 2] = [
    number("rise", "ms").unless_all(""),
    number("overshoot", "%").unless_all(""),
];

const LEGEND: &str = "Medians over complete runs of closed loops, with the quartiles of settling.";
const FIRST_LEGEND: &str = "times first: settling over that on the first topology at the same rate";
const CLIENT_LEGEND: &str = "settling over that client's with the same system, topology and rate.";

/// The runs that medians are over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// The complete ones.
    Complete,
    /// Those, and the disturbed ones.
    DisturbedToo,
}

/// The runs that differ only in their repeat.
struct Repeats<'a> {
    first: &'a Summary,
    complete: Vec<&'a Summary>,
    runs: usize,
}

impl Repeats<'_> {
    /// Whether `row` has the same client, setup and rate, on any topology.
    fn is_set_up_like(&self, row: &Summary) -> bool {
        self.first.condition() == row.condition()
    }

    /// Whether `row` has the same topology, system and rate, with any client and setup.
    fn is_beside(&self, row: &Summary) -> bool {
        let place = |row: &Summary| (row.topology.clone(), row.system.clone(), row.h_ns);
        place(self.first) == place(row)
    }

    fn settling_ms(&self, q: f64) -> Option<f64> {
        self.quantile(q, |row| row.settling_ms)
    }

    /// A quantile of a figure over the complete runs. A run without the figure counts as infinite;
    /// `None` if the quantile falls on one.
    fn quantile(&self, q: f64, figure: fn(&Summary) -> Option<f64>) -> Option<f64> {
        let value = |row: &&Summary| figure(row).unwrap_or(f64::INFINITY);
        let values: Vec<f64> = self.complete.iter().map(value).collect();
        statistics::quantile(&values, q).filter(|value| value.is_finite())
    }
}

/// The table of medians of every group; `None` if no cell was repeated. The medians are over the
/// runs that are asked for.
#[must_use]
pub fn render(rows: &[Summary], over: Over) -> Option<String> {
    let closed = rows.iter().filter(|row| row.mode == Mode::Closed);
    let is_asked = |row: &&Summary| match row.verdict {
        Some(Verdict::Disturbed) => over == Over::DisturbedToo,
        verdict => verdict == Some(Verdict::Complete),
    };
    let kinds = grouped(closed, |row| (&row.topology, row.condition()));
    let groups: Vec<Repeats> = (kinds.into_iter())
        .filter(|(_, rows)| rows.len() > 1)
        .map(|(_, rows)| Repeats {
            first: rows[0],
            runs: rows.len(),
            complete: rows.into_iter().filter(is_asked).collect(),
        })
        .collect();
    if groups.is_empty() {
        return None;
    }
    let differ = |is_other: fn(&Summary, &Summary) -> bool| {
        groups
            .iter()
            .any(|group| is_other(group.first, groups[0].first))
    };
    let clients = differ(|one, other| one.client != other.client);
    let has = |client: &Client| clients && groups.iter().any(|group| group.first.client == *client);
    let against = Against {
        first: differ(|one, other| one.topology != other.topology),
        clients: Client::YARDSTICKS.into_iter().filter(has).collect(),
    };
    let unlike = links::unlike(rows);
    let lines: Vec<Vec<String>> = groups
        .iter()
        .map(|group| line(group, &groups, &against, &unlike))
        .collect();
    let mut legend = format!("{LEGEND}\n");
    if against.first {
        let setup = if clients || differ(|one, other| one.setup != other.setup) {
            ", with the same client and setup."
        } else {
            "."
        };
        legend += &format!("{FIRST_LEGEND}{setup}\n");
    }
    let names = against.clients.iter().map(|client| client.spec().name);
    let names: Vec<&str> = names.collect();
    if !names.is_empty() {
        legend += &format!("times {}: {CLIENT_LEGEND}\n", names.join(", "));
    }
    let yardsticks: Vec<Column> = names.iter().map(|name| number("times", name)).collect();
    let columns = [
        &condition::COLUMNS[..],
        &COLUMNS,
        &yardsticks,
        &LAST_COLUMNS,
    ]
    .concat();
    let sheet = sheet(&columns, &lines);
    let said = sheet.said.join(", ");
    Some(format!("Medians: {said}\n\n{}\n{legend}", sheet.text))
}

/// What settling is compared with.
struct Against {
    /// Whether there are several topologies, so that settling is compared with that on the first.
    first: bool,
    /// The yardsticks among the clients; empty if there is only one client.
    clients: Vec<Client>,
}

fn line(group: &Repeats, groups: &[Repeats], against: &Against, unlike: &[&str]) -> Vec<String> {
    let times = |is_reference: &dyn Fn(&&Repeats) -> bool| {
        let reference = groups.iter().find(is_reference);
        let reference_ms = reference.and_then(|other| other.settling_ms(0.5));
        let own_ms = group.settling_ms(0.5);
        digits(own_ms.zip(reference_ms).map(|(own, of)| own / of))
    };
    let of_yardsticks = against.clients.iter().map(|client| {
        times(&|other| other.first.client == *client && other.is_beside(group.first))
    });
    let stable = group
        .complete
        .iter()
        .filter(|row| row.loop_verdict == Some(LoopVerdict::Holds))
        .count();
    let settling = |q| links::marked(digits(group.settling_ms(q)), &group.first.topology, unlike);
    let figures = [
        format!("{}/{}", group.complete.len(), group.runs),
        stable.to_string(),
        settling(0.5),
        settling(0.25),
        settling(0.75),
        if against.first {
            times(&|other| other.is_set_up_like(group.first))
        } else {
            String::new()
        },
    ];
    let last = [
        digits(group.quantile(0.5, |row| row.of_step(row.rise_ms))),
        digits(group.quantile(0.5, |row| row.of_step(row.overshoot_pct))),
    ];
    let condition = condition::entries(group.first).into_iter();
    let figures = condition.chain(figures).chain(of_yardsticks);
    figures.chain(last).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(topology: &str, repeat: u32, settling_ms: Option<f64>) -> Summary {
        Summary {
            topology: topology.to_owned(),
            client: Client::Native,
            mode: Mode::Closed,
            rate: "333 Hz".to_owned(),
            repeat,
            verdict: Some(Verdict::Complete),
            loop_verdict: Some(match settling_ms {
                Some(_) => LoopVerdict::Holds,
                None => LoopVerdict::Unsettled,
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
        // arima: the median of 300, 310, 320. couva: that of 310, 330 and never; the invalid run does
        // not count. 330 / 310 = 1.06.
        insta::assert_snapshot!(render(&rows, Over::Complete).expect("there are repeats"));
    }

    #[test]
    fn clients_stand_against_native_and_python_on_their_own_topology() {
        let twice = |client: Client, setup: &str, topology: &str, settling_ms: f64| {
            [1, 2].map(|repeat| Summary {
                client,
                setup: setup.to_owned().into(),
                ..run(topology, repeat, Some(settling_ms))
            })
        };
        let rows = [
            twice(Client::Native, "paper-python", "arima", 300.0),
            twice(Client::Native, "blocking", "arima", 301.0),
            twice(Client::Native, "paper-python", "diego-vpn", 1200.0),
            twice(Client::Python, "paper-python", "arima", 320.0),
            twice(Client::Python, "paper-python", "diego-vpn", 1280.0),
            twice(Client::Firefox, "paper-2011", "arima", 3200.0),
            twice(
                Client::Firefox,
                "worker, fetch, channel, outstanding 6",
                "arima",
                330.0,
            ),
            // Native did not run on this topology: there is nothing to compare with.
            twice(Client::Firefox, "worker", "couva", 640.0),
        ]
        .concat();
        insta::assert_snapshot!(render(&rows, Over::Complete).expect("there are repeats"));
    }

    #[test]
    fn a_system_s_settling_is_held_against_its_own_alone() {
        let twice = |client: Client, system: &str, settling_ms: f64| {
            [1, 2].map(|repeat| Summary {
                client,
                system: system.to_owned(),
                setup: format!("paper-python, system {system}").into(),
                ..run("arima", repeat, Some(settling_ms))
            })
        };
        let rows = [
            twice(Client::Native, "motor", 100.0),
            twice(Client::Native, "lag", 400.0),
            twice(Client::Firefox, "lag", 800.0),
        ]
        .concat();
        let table = render(&rows, Over::Complete).expect("there are repeats");
        let lag = table.lines().find(|line| line.contains("firefox"));
        assert!(lag.is_some_and(|line| line.contains(" 2.00 ")), "{table}");
    }

    #[test]
    fn a_disturbed_run_is_in_the_medians_where_that_is_asked_for() {
        let rows = [
            run("arima", 1, Some(300.0)),
            run("arima", 2, Some(320.0)),
            Summary {
                verdict: Some(Verdict::Disturbed),
                ..run("arima", 3, Some(900.0))
            },
        ];
        let table = |over| render(&rows, over).expect("there are repeats");
        assert!(table(Over::Complete).contains("2/3") && !table(Over::Complete).contains("320  "));
        assert!(
            table(Over::DisturbedToo).contains("3/3")
                && table(Over::DisturbedToo).contains(" 320 ")
        );
    }

    #[test]
    fn without_repeats_there_are_no_medians() {
        assert_eq!(
            render(
                &[run("arima", 1, Some(300.0)), run("couva", 1, Some(330.0))],
                Over::Complete
            ),
            None
        );
    }
}
