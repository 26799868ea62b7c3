//! The claims board over folders made by hand: what is in the rows decides, and nothing else.

use crate::lab::{Lab, Rows};
use report::Report;
use report::claim::{self, Finding, Part, Verdict};
use report::group::Estimate;

/// The claims that reports have had from the start, by their places: programs know their ids.
const BOARD: &[(&str, &[&str])] = &[
    (
        "Table 2",
        &[
            "table-2-arima",
            "table-2-buccoo",
            "table-2-couva",
            "table-2-diego-lan",
            "table-2-diego-vpn",
        ],
    ),
    ("Section 3.1", &["text-couva-ping"]),
    (
        "Table 3",
        &["table-3-100-hz", "table-3-10-hz", "table-3-3-hz"],
    ),
    ("Section 4", &["text-out-of-order"]),
    ("Fig 2", &["fig-2-600th", "fig-2-in-6-s"]),
    ("Section 4.1", &["text-sent", "text-lag"]),
    (
        "Fig 3",
        &[
            "fig-3-python-flat",
            "fig-3-javascript-drifts",
            "fig-3-impulses",
        ],
    ),
    (
        "Fig 4",
        &["fig-4-javascript-diverges", "fig-4-python-not-flat"],
    ),
    (
        "Fig 5",
        &["fig-5-stable", "fig-5-final-value", "fig-5-settling"],
    ),
    ("Fig 6a", &["fig-6a-settling-javascript"]),
    ("Fig 6b", &["fig-6b-settling-vpn"]),
    ("Fig 6c", &["fig-6c-settling-lan"]),
    ("Fig 6", &["fig-6-stable"]),
    (
        "Fig 7",
        &["fig-7-mean", "fig-7-spread", "fig-7-nonpositive"],
    ),
    ("Fig 8a", &["fig-8-arima-peaks"]),
    ("Fig 8b, 8c", &["fig-8-flatter", "fig-8-zeros"]),
    ("Fig 9a", &["fig-9a-no-peak"]),
    ("Fig 9b", &["fig-9b-delay", "fig-9b-zeros"]),
    ("Section 4.3", &["guess-browsers", "future-kalman"]),
    ("Section 5", &["future-unstable-plants"]),
];

/// Python's step on arima and over the VPN, and JavaScript's open loop at 100 Hz.
const EXPERIMENT: &str = r#"
name = "made"

[[cells]]
topology = ["arima", "diego-vpn"]
client = ["python"]
preset = "paper-python"
mode = "closed"
h = ["3ms"]
duration = "3s"
repeats = 9

[[cells]]
topology = ["arima"]
client = ["firefox"]
preset = "paper-2011"
mode = "open"
h = ["10ms"]
duration = "60s"

[[cells]]
topology = ["buccoo"]
client = ["native"]
preset = "paper-python"
mode = "open"
h = ["100ms"]
duration = "100s"
"#;

fn board(lab: &Lab) -> Vec<Finding> {
    paper::claim::all(&lab.campaign()).expect("rows that can be read")
}

fn find(board: &[Finding], id: &str) -> Finding {
    let found = board.iter().find(|finding| finding.id == id);
    found.unwrap_or_else(|| panic!("no finding {id}")).clone()
}

fn verdict(lab: &Lab, id: &str) -> Verdict {
    find(&board(lab), id).verdict
}

/// Python settles in 318 ms on arima and in four times as long over the VPN.
fn steps() -> Lab {
    let lab = Lab::new(EXPERIMENT);
    for cell in lab.cells("arima-python") {
        lab.run(cell, &Rows::step(cell, 318.0));
    }
    for cell in lab.cells("diego-vpn-python") {
        lab.run(cell, &Rows::step(cell, 1272.0));
    }
    lab
}

#[test]
fn every_claim_of_the_paper_has_its_findings_and_there_are_no_others() {
    let board = board(&Lab::new(EXPERIMENT));
    for (place, ids) in BOARD {
        let found = board.iter().filter(|finding| finding.place == *place);
        let found: Vec<&str> = found.map(|finding| finding.id).collect();
        // A claim that was added since is none of these; none of these may go or be renamed.
        let known: Vec<&str> = found.into_iter().filter(|id| ids.contains(id)).collect();
        assert_eq!(known, *ids, "{place}");
    }
    let table: toml::Table = include_str!("../../claims.toml").parse().expect("TOML");
    let entries = table["claim"].as_array().expect("claims").iter();
    let claims = entries.filter(|entry| entry.get("reading_of").is_none());
    let ids: Vec<&str> = claims.filter_map(|entry| entry["id"].as_str()).collect();
    let found: Vec<&str> = board.iter().map(|finding| finding.id).collect();
    assert_eq!(found, ids);
}

#[test]
fn without_runs_no_claim_agrees_or_differs() {
    for experiment in [EXPERIMENT, include_str!("../../../experiments/paper.toml")] {
        for finding in board(&Lab::new(experiment)) {
            let id = finding.id;
            let due = match id {
                // It is asked of the paper's own transfer function.
                "text-time-constant" => Verdict::Differs,
                _ => Verdict::NotRun,
            };
            assert_eq!(finding.verdict, due, "{id}");
            assert!(
                finding.runs.is_empty() && !finding.reason.is_empty(),
                "{id}"
            );
            assert!(
                finding
                    .parts
                    .iter()
                    .all(|part| part.verdict != Verdict::Agrees),
                "{id}"
            );
        }
    }
}

#[test]
fn a_claim_that_was_not_run_says_what_is_missing() {
    let board = board(&Lab::new(EXPERIMENT));
    insta::assert_snapshot!(
        find(&board, "fig-6b-settling-vpn").reason,
        @"Not run: python, diego-vpn, 333 Hz (none of 9 planned complete); python, arima, 333 Hz (none of 9 planned complete)."
    );
    insta::assert_snapshot!(
        find(&board, "fig-9a-no-peak").reason,
        @"Not run: firefox paper-2011, arima, 333 Hz (not in the plan)."
    );
}

#[test]
fn four_times_the_settling_agrees_and_the_reason_says_how_few_runs_there_are() {
    let found = find(&board(&steps()), "fig-6b-settling-vpn");
    assert_eq!(found.verdict, Verdict::Agrees);
    insta::assert_snapshot!(found.reason);
}

#[test]
fn one_late_run_of_nine_is_not_the_median_half_of_them_cannot_tell_and_eight_do() {
    let lab = steps();
    let vpn = lab.cells("diego-vpn-python");
    let late = |count: usize| {
        for cell in &vpn[..count] {
            lab.run(cell, &Rows::step(cell, 2800.0));
        }
        find(&board(&lab), "fig-6b-settling-vpn")
    };
    assert_eq!(late(1).verdict, Verdict::Agrees);
    // On either side of the middle: what decides is the interval, from the second to the eighth.
    assert_eq!(late(4).verdict, Verdict::CannotBeTold);
    let half = late(5);
    assert_eq!(half.verdict, Verdict::CannotBeTold);
    insta::assert_snapshot!("half_of_them", half.reason);
    let most = late(8);
    assert_eq!(most.verdict, Verdict::Differs);
    insta::assert_snapshot!("most_of_them", most.reason);
}

#[test]
fn five_runs_cannot_tell_what_six_can_and_exact_counts_need_one() {
    let lab = Lab::new(EXPERIMENT);
    let (arima, vpn) = (lab.cells("arima-python"), lab.cells("diego-vpn-python"));
    let run = |cells: &[&plan::Cell], settling_ms| {
        for cell in cells {
            lab.run(cell, &Rows::step(cell, settling_ms));
        }
    };
    run(&arima, 318.0);
    run(&vpn[..5], 1272.0);
    let few = find(&board(&lab), "fig-6b-settling-vpn");
    assert_eq!(few.verdict, Verdict::CannotBeTold);
    insta::assert_snapshot!("five_of_them", few.reason);
    let grown = |lab: &Lab| {
        let parts = find(&board(lab), "fig-6-stable").parts;
        let part = parts
            .into_iter()
            .find(|part| part.of == "runs that grow, python, diego-vpn, 333 Hz");
        part.expect("a count").verdict
    };
    assert_eq!(grown(&lab), Verdict::Agrees);
    run(&vpn[5..6], 1272.0);
    assert_eq!(verdict(&lab, "fig-6b-settling-vpn"), Verdict::Agrees);
}

#[test]
fn runs_that_never_settle_differ_however_many_did_not() {
    let lab = steps();
    for cell in lab.cells("diego-vpn-python") {
        let mut rows = Rows::step(cell, 1272.0);
        for tick in &mut rows.ticks {
            tick.y = 0.5;
        }
        lab.run(cell, &rows);
    }
    let found = find(&board(&lab), "fig-6b-settling-vpn");
    assert_eq!(found.verdict, Verdict::Differs);
    assert!(found.reason.contains("infinite"), "{}", found.reason);
    // Infinity is null in JSON and the word in CSV, and both can be read.
    let json = claim::to_json(std::slice::from_ref(&found));
    let read: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert!(read[0]["parts"][0]["ours"]["value"].is_null());
    assert!(claim::to_csv(&[found]).contains(",inf,"));
}

#[test]
fn a_loop_that_grows_is_not_stable() {
    let lab = steps();
    let stable = |lab: &Lab| {
        let parts = find(&board(lab), "fig-6-stable").parts;
        let vpn = parts
            .into_iter()
            .filter(|part| part.of.contains("diego-vpn"));
        vpn.map(|part| part.verdict).max()
    };
    assert_eq!(stable(&lab), Some(Verdict::Agrees));
    let cell = lab.cells("diego-vpn-python")[0];
    let mut rows = Rows::step(cell, 1272.0);
    for tick in &mut rows.ticks {
        tick.y = 1.0 + (tick.k as f64 / 100.0).exp() * (tick.k as f64).sin();
    }
    lab.run(cell, &rows);
    assert_eq!(stable(&lab), Some(Verdict::Differs));
}

#[test]
fn the_paper_s_pace_agrees_with_its_text_and_differs_from_its_figure() {
    // 10.9 ms a message: 55 of 60 thousand, but the 600th after 6.5 s.
    let lab = Lab::new(EXPERIMENT);
    let cell = lab.cells("arima-firefox")[0];
    let rows = Rows::paced(cell, 10_909_091);
    lab.run(cell, &rows);
    assert_eq!(verdict(&lab, "text-sent"), Verdict::Agrees);
    assert_eq!(verdict(&lab, "text-lag"), Verdict::Agrees);
    let found = find(&board(&lab), "fig-2-600th");
    assert_eq!(found.verdict, Verdict::Differs);
    insta::assert_snapshot!(found.reason);

    // The 600th arrival alone moves Figure 2, and no message is less for it.
    let mut late = rows.clone();
    for arrival in &mut late.arrivals[599..] {
        arrival.t_arrive_ns += 1_465_000_000;
    }
    lab.run(cell, &late);
    assert_eq!(verdict(&lab, "fig-2-600th"), Verdict::Agrees);
    assert_eq!(verdict(&lab, "text-sent"), Verdict::Agrees);

    // A tenth of the messages gone is beyond 5 %.
    let mut fewer = rows;
    fewer.messages.truncate(fewer.messages.len() * 9 / 10);
    lab.run(cell, &fewer);
    assert_eq!(verdict(&lab, "text-sent"), Verdict::Differs);
}

#[test]
fn a_run_that_was_refused_is_not_run() {
    let lab = Lab::new(EXPERIMENT);
    let cell = lab.cells("arima-firefox")[0];
    lab.end(cell, &Rows::paced(cell, 10_909_091), plan::Verdict::Invalid);
    assert_eq!(verdict(&lab, "text-sent"), Verdict::NotRun);
}

#[test]
fn messages_in_one_stamp_are_table_3_s_and_one_more_interval_is_not() {
    let lab = Lab::new(EXPERIMENT);
    let cell = lab.cells("arima-firefox")[0];
    let share = |every_ns| {
        lab.run(cell, &Rows::paced(cell, every_ns));
        let found = find(&board(&lab), "table-3-100-hz");
        found.parts[0].clone()
    };
    // 7.5 ms a message puts a quarter of neighbours into one stamp of 10 ms, 10.9 ms none.
    assert_eq!(share(7_500_000).verdict, Verdict::Agrees);
    assert_eq!(share(10_909_091).verdict, Verdict::Differs);
}

#[test]
fn where_one_of_two_thousand_is_expected_of_four_hundred_none_says_nothing() {
    let lab = Lab::new(
        r#"
name = "made"

[[cells]]
topology = ["arima", "buccoo"]
client = ["firefox"]
preset = "paper-2011"
mode = "open"
h = ["300ms"]
duration = "120s"
"#,
    );
    let part = |topology: &str| {
        let cell = lab.cells(topology)[0];
        lab.run(cell, &Rows::paced(cell, 300_000_000));
        let parts = find(&board(&lab), "table-3-3-hz").parts;
        let own = format!(
            "share of neighbours in the same 10 ms, firefox paper-2011, {topology}, 3.3 Hz"
        );
        parts
            .into_iter()
            .find(|part| part.of == own)
            .expect("a part")
            .verdict
    };
    // The paper found none on arima, and so does this; on buccoo it found two.
    assert_eq!(part("arima"), Verdict::Agrees);
    assert_eq!(part("buccoo"), Verdict::CannotBeTold);
}

#[test]
fn a_reading_stands_beside_the_claim_and_is_not_counted_as_one() {
    let lab = Lab::new(EXPERIMENT);
    let cell = lab.cells("arima-firefox")[0];
    // 11.5 ms a message: none shares 10 ms with the one before, and a quarter shares 1/64 s.
    lab.run(cell, &Rows::paced(cell, 11_500_000));
    let board = board(&lab);
    let reading = find(&board, "reading-table-3-arima");
    assert_eq!(reading.verdict, Verdict::Agrees, "{}", reading.reason);
    assert_eq!(reading.reading_of, Some("table-3-100-hz"));
    assert_eq!(
        find(&board, "table-3-100-hz").parts[0].verdict,
        Verdict::Differs
    );
    let campaign = lab.campaign();
    let report = Report::of(&campaign, paper::exhibits(&campaign).expect("rows"))
        .expect("rows that can be read");
    assert_eq!(report.strict().count() + 1, report.claims.len());
}

#[test]
fn a_plant_as_noisy_as_figure_7_s_is_a_reading_of_figure_9_and_without_its_runs_there_is_none() {
    let readings = include_str!("../../../experiments/readings.toml");
    let ids = |lab: &Lab| -> Vec<&'static str> {
        let board = board(lab);
        let readings = board.iter().filter(|finding| finding.reading_of.is_some());
        readings.map(|finding| finding.id).collect()
    };
    assert!(ids(&Lab::new(EXPERIMENT)).is_empty());
    let lab = Lab::new(readings);
    let known = ["reading-fig-9b-zeros", "reading-fig-6b-settling-vpn"];
    assert_eq!(ids(&lab), known);
    assert_eq!(verdict(&lab, known[0]), Verdict::NotRun);
    for (start, settling_ms) in [("arima", 318.0), ("diego-vpn-free", 1272.0)] {
        for cell in &lab.cells(start)[..6] {
            lab.run(cell, &Rows::step(cell, settling_ms));
        }
    }
    assert_eq!(verdict(&lab, known[1]), Verdict::Agrees);
    // These ticks are punctual, whatever the plan says, and commands come every h.
    let shape = find(&board(&lab), known[0]);
    assert_eq!(shape.verdict, Verdict::Differs);
    assert_eq!(shape.parts[0].ours.map(|ours| ours.value), Some(1.0));
}

#[test]
fn one_overtaken_message_of_a_client_that_waits_is_one_too_many() {
    let lab = steps();
    let cell = lab.cells("arima-firefox")[0];
    let mut rows = Rows::paced(cell, 10_909_091);
    lab.run(cell, &rows);
    let part =
        |lab: &Lab, which: usize| find(&board(lab), "text-out-of-order").parts[which].clone();
    assert_eq!(part(&lab, 0).verdict, Verdict::Differs);
    assert_eq!(part(&lab, 1).verdict, Verdict::Agrees);
    let python = lab.cells("arima-python")[0];
    let mut overtaken = Rows::step(python, 318.0);
    overtaken.arrivals[10].seq = 11;
    overtaken.arrivals[11].seq = 10;
    lab.run(python, &overtaken);
    assert_eq!(verdict(&lab, "text-out-of-order"), Verdict::Agrees);
    rows.arrivals[10].seq = 11;
    rows.arrivals[11].seq = 10;
    lab.run(cell, &rows);
    assert_eq!(part(&lab, 1).verdict, Verdict::Differs);
}

#[test]
fn echoes_of_the_profile_s_own_link_agree_and_two_ms_more_do_not() {
    let lab = Lab::new(EXPERIMENT);
    let cell = lab.cells("buccoo-native")[0];
    let text = lab.plan.profiles.get("buccoo").expect("planned");
    let profile = text
        .profile("buccoo")
        .expect("a profile that can be played");
    let mut rows = Rows::paced(cell, 100_000_000).with_echoes(cell, &profile, 100_000_000);
    lab.run(cell, &rows);
    assert_eq!(verdict(&lab, "table-2-buccoo"), Verdict::Agrees);
    for probe in rows
        .probes
        .iter_mut()
        .filter(|probe| probe.phase == plan::Phase::During)
    {
        // The link itself is another one, so the machine is exact and the law is not the profile's.
        probe.due_up_ns += 2_000_000;
        probe.t_back_ns = probe.t_back_ns.map(|ns| ns + 2_000_000);
    }
    lab.run(cell, &rows);
    let found = find(&board(&lab), "table-2-buccoo");
    assert_eq!(found.verdict, Verdict::Differs);
    assert!(found.reason.contains("avg"), "{}", found.reason);
}

#[test]
fn equal_folders_give_equal_bytes_and_every_part_is_a_row() {
    let lab = steps();
    let campaign = lab.campaign();
    let files = |campaign| {
        let report = Report::of(campaign, paper::exhibits(campaign).expect("rows"))
            .expect("rows that can be read");
        let claims = report
            .files(&report.draw())
            .into_iter()
            .filter(|(name, _)| name.starts_with("claims.json") || name.starts_with("claims.csv"));
        claims.collect::<Vec<_>>()
    };
    assert_eq!(files(&campaign).len(), 2);
    assert_eq!(files(&campaign), files(&lab.campaign()));

    let board = board(&lab);
    let csv = claim::to_csv(&board);
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let columns = reader
        .headers()
        .expect("a header")
        .iter()
        .collect::<Vec<_>>()
        .join(",");
    insta::assert_snapshot!(columns, @"id,place,claim,check,verdict,of,unit,paper,ours,low,high,n,accepted_low,accepted_high,part_verdict,reason");
    let rows = reader
        .records()
        .collect::<Result<Vec<_>, _>>()
        .expect("rows");
    let parts: usize = board.iter().map(|finding| finding.parts.len().max(1)).sum();
    assert_eq!(rows.len(), parts);
}

#[test]
fn a_client_that_keeps_its_schedule_is_flat_until_a_part_of_each_period_is_added() {
    let lab = Lab::new(
        r#"
name = "made"

[[cells]]
topology = ["arima"]
client = ["python"]
preset = "paper-python"
mode = "open"
h = ["100ms"]
duration = "60s"
"#,
    );
    let cell = lab.cells("arima-python")[0];
    let slope = |every_ns| {
        lab.run(cell, &Rows::paced(cell, every_ns));
        let parts = find(&board(&lab), "fig-3-python-flat").parts;
        let part = parts.into_iter().find(|part| part.ours.is_some());
        part.expect("one cell was run")
    };
    assert_eq!(slope(100_000_000).verdict, Verdict::Agrees);
    let drifts = slope(101_000_000);
    assert_eq!(drifts.verdict, Verdict::Differs);
    assert!(
        (drifts.ours.expect("run").value - 0.01).abs() < 1e-9,
        "{drifts:?}"
    );
}

#[test]
fn a_plant_as_noisy_as_a_desktop_s_has_the_spread_that_ours_must_not_have() {
    let lab = steps();
    let spread = |lab: &Lab| find(&board(lab), "fig-7-real-time").parts[0].clone();
    assert_eq!(spread(&lab).verdict, Verdict::Agrees);
    for cell in lab.cells("arima-python") {
        let mut rows = Rows::step(cell, 318.0);
        for tick in rows.ticks.iter_mut().step_by(2) {
            tick.t_tick_ns += 2_000_000;
        }
        lab.run(cell, &rows);
    }
    let noisy = spread(&lab);
    assert_eq!(noisy.verdict, Verdict::Differs);
    // Intervals of 1 and of 5 ms in turn.
    assert!(
        (noisy.ours.expect("run").value - 2.0).abs() < 0.01,
        "{noisy:?}"
    );
}

proptest::proptest! {
    #[test]
    fn a_part_agrees_where_its_number_is_accepted_and_nowhere_else(
        value in -10.0f64..10.0, low in -10.0f64..10.0, width in 0.0f64..5.0,
    ) {
        let ours = Estimate { value, low: value, high: value, n: 1 };
        let part = Part::judged("x", "", None, Some(ours), (low, low + width));
        let inside = low <= value && value <= low + width;
        proptest::prop_assert_eq!(part.verdict == Verdict::Agrees, inside);
        let none = Part::judged("x", "", None, None, (low, low + width));
        proptest::prop_assert_eq!(none.verdict, Verdict::NotRun);
    }
}
