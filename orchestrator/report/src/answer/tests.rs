use analysis::LoopVerdict;
use plan::Client;

use super::headline::LINE;
use super::*;
use crate::sample::{Outcome, campaign};

/// Two clients on the paper's topologies, and a browser without a network.
const CLOSED: &str = "
[[cells]]
topology = [\"arima\", \"buccoo\", \"couva\", \"diego-lan\", \"diego-vpn\"]
client = [\"native\", \"python\"]
mode = \"closed\"
h = [\"3ms\", \"1ms\"]
duration = \"4s\"
repeats = 2

[[cells]]
topology = [\"arima\"]
client = [\"firefox\"]
preset = \"paper-2011\"
mode = \"closed\"
h = [\"3ms\"]
duration = \"4s\"
";

const OPEN: &str = "
[[cells]]
topology = [\"arima\"]
client = [\"native\"]
mode = \"open\"
h = [\"10ms\"]
duration = \"4s\"
";

/// A browser is slow, and so is the VPN.
fn stable(cell: &plan::Cell) -> Outcome {
    Outcome::Stable(match (cell.client, cell.topology.as_str()) {
        (Client::Firefox, _) => 3200.0,
        (_, "diego-vpn") => 1300.0,
        _ => 320.0,
    })
}

#[test]
fn the_answer_s_words_fit_what_the_runs_say() {
    let busy = "the machine was busy";
    let kinds = [
        ("all stable", campaign(CLOSED, stable)),
        (
            "some lost",
            campaign(CLOSED, |cell| {
                let is_lost = cell.topology == "couva" && cell.settings.h.ns() == 1_000_000;
                match (is_lost, cell.client, cell.repeat) {
                    (true, Client::Python, _) => Outcome::Lost(LoopVerdict::Lost),
                    (true, _, 2) => Outcome::Lost(LoopVerdict::Unsettled),
                    _ => stable(cell),
                }
            }),
        ),
        (
            "one client lost",
            campaign(CLOSED, |cell| match cell.client {
                Client::Firefox => Outcome::Lost(LoopVerdict::Unsettled),
                _ => stable(cell),
            }),
        ),
        (
            "none stable",
            campaign(CLOSED, |_| Outcome::Lost(LoopVerdict::Lost)),
        ),
        (
            "some run",
            campaign(CLOSED, |cell| match (cell.topology.as_str(), cell.repeat) {
                ("arima", 1) => stable(cell),
                ("arima" | "buccoo", _) => Outcome::Failed(busy),
                _ => Outcome::Absent,
            }),
        ),
        ("none complete", campaign(CLOSED, |_| Outcome::Failed(busy))),
        ("no closed loop", campaign(OPEN, stable)),
    ];
    let words: Vec<String> = kinds
        .iter()
        .map(|(kind, campaign)| {
            let words = Answer::of(campaign).words();
            format!("{kind}\n  {}", words.join("\n  "))
        })
        .collect();
    insta::assert_snapshot!(words.join("\n"));
}

#[test]
fn settling_is_held_against_both_references_without_a_network() {
    let answer = Answer::of(&campaign(CLOSED, |cell| {
        match (cell.client, cell.topology.as_str()) {
            (Client::Python, "arima") => Outcome::Stable(200.0),
            (_, "arima") => Outcome::Stable(100.0),
            _ => Outcome::Stable(400.0),
        }
    }));
    assert_eq!(answer.reference.as_deref(), Some("arima"));
    let times = |client: Client, topology: &str| -> Vec<(Client, f64)> {
        answer
            .loops()
            .filter(|(row, place, _)| row.client == client && *place == topology)
            .take(1)
            .flat_map(|(_, _, standing)| &standing.times)
            .map(|times| (times.of, times.factor))
            .collect()
    };
    assert_eq!(
        times(Client::Python, "couva"),
        [(Client::Native, 4.0), (Client::Python, 2.0)]
    );
    // A loop is not compared with itself.
    assert_eq!(times(Client::Native, "arima"), [(Client::Python, 0.5)]);
    assert_eq!(
        times(Client::Firefox, "arima"),
        [(Client::Native, 1.0), (Client::Python, 0.5)]
    );
}

#[test]
fn a_step_that_never_settled_counts_as_later_than_any() {
    let answer = Answer::of(&campaign(CLOSED, |cell| match cell.repeat {
        1 => Outcome::Lost(LoopVerdict::Unsettled),
        _ => Outcome::Stable(320.0),
    }));
    let (_, _, standing) = answer.loops().next().expect("a loop");
    assert_eq!((standing.complete, standing.holds), (2, 1));
    assert_eq!(standing.survival(), Survival::Sometimes);
    assert_eq!(standing.settling_ms, None, "half of them never settled");
}

#[test]
fn the_headline_stays_one_line_whatever_failed_or_is_missing() {
    let kinds = [
        LoopVerdict::HoldsBadly,
        LoopVerdict::Unsettled,
        LoopVerdict::Silent,
        LoopVerdict::Lost,
    ];
    let long = CLOSED.replace("repeats = 2", "repeats = 200");
    for (cells, every, missing) in (1..7).flat_map(|every| {
        [
            (CLOSED, every, 0),
            (CLOSED, every, 3),
            (long.as_str(), every, 2),
        ]
    }) {
        let campaign = campaign(cells, |cell| match cell.index {
            index if missing > 0 && index % missing == 1 => Outcome::Absent,
            index if index % every == 0 => Outcome::Lost(kinds[index / every % kinds.len()]),
            _ => stable(cell),
        });
        let words = Answer::of(&campaign).words();
        let length = words[0].chars().count();
        assert!(length <= LINE, "{length}: {}", words[0]);
    }
}
