//! What is written for other people's programs: names, order, escaping, and the columns of the rows.
#![allow(clippy::print_stdout, reason = "it says what is skipped")]

mod campaign;
mod columns;
mod frictionless;

use std::fs;

use analysis::Run;
use analysis::expect::judge;
use plan::{Figure, Known};
use proptest::prelude::*;
use record::FileFact;
use report::deposit::{package, provenance};
use report::{Report, claim, digest, junit};

use campaign::{files, finding, folder, plan, read, report};

/// Everything that is exported, one text.
fn exported(report: &Report<'_>) -> [String; 4] {
    [
        junit::xml(report),
        digest::markdown(report),
        package::json(report, &files()),
        provenance::json(report, &files()),
    ]
}

#[test]
fn junit_reads_like_this() {
    let folder = folder();
    let campaign = read(folder.path());
    insta::assert_snapshot!(junit::xml(&report(&campaign)));
}

#[test]
fn the_summary_reads_like_this() {
    let folder = folder();
    let campaign = read(folder.path());
    insta::assert_snapshot!(digest::markdown(&report(&campaign)));
}

/// What is expected is a suite of its own and a table; without it neither is there, as above.
#[test]
fn what_is_expected_reads_like_this() {
    let folder = folder();
    let mut campaign = read(folder.path());
    let reason = "it pauses | now and then".to_owned();
    campaign.plan.known = vec![Known {
        cells: "arima-native".to_owned(),
        expect: Some(Figure::Sent),
        reason,
        until: None,
    }];
    let runs: Vec<&Run> = campaign.runs.iter().collect();
    let clauses = ["sent >= 99%", "rtt.max <= 1ms", "stable"];
    let clauses = clauses.map(|text| text.parse().expect("a clause"));
    let today = "2026-11-25".parse().expect("a day");
    let judgement = judge(&campaign.plan, &runs, &clauses, today);
    let report = report(&campaign).with_expectations(judgement);
    let (xml, page) = (junit::xml(&report), digest::markdown(&report));
    let (_, suite) = xml
        .split_once("<testsuite name=\"expect\"")
        .expect("a suite");
    let (_, table) = page.split_once("## What is expected").expect("a table");
    let table = table.split("\n## ").next();
    insta::assert_snapshot!(format!("{suite}\n{}", table.unwrap_or_default()));
}

#[test]
fn the_package_reads_like_this() {
    let folder = folder();
    let campaign = read(folder.path());
    let text = package::json(&report(&campaign), &files());
    // The columns are long, and the tests below hold them against the rows.
    let text = without_fields(&text);
    insta::assert_snapshot!(text);
}

#[test]
fn the_provenance_reads_like_this() {
    let folder = folder();
    let campaign = read(folder.path());
    // A plan's length follows its profiles' words.
    let text = provenance::json(&report(&campaign), &files());
    let plan = campaign.plan.to_json();
    let fact = FileFact::of(plan.as_bytes()).expect("memory");
    let text = text.replace(&fact.sha256, "(plan's)");
    let text = text.replace(&format!("\"{}\"", fact.bytes), "\"(plan's)\"");
    insta::assert_snapshot!(text);
}

/// A package's text with only the last column of each resource.
fn without_fields(text: &str) -> String {
    let mut package: serde_json::Value = serde_json::from_str(text).expect("JSON");
    let resources = package["resources"].as_array_mut().expect("a list");
    for resource in resources {
        let fields = resource["schema"]["fields"].as_array_mut().expect("a list");
        *fields = fields.split_off(fields.len().saturating_sub(1));
    }
    serde_json::to_string_pretty(&package).expect("JSON")
}

#[test]
fn the_same_folder_gives_the_same_bytes_wherever_it_lies() {
    let (here, there) = (folder(), folder());
    let (one, other) = (read(here.path()), read(there.path()));
    let texts = exported(&report(&one));
    assert_eq!(texts, exported(&report(&other)));
    let place = here.path().display().to_string();
    assert!(texts.iter().all(|text| !text.contains(&place)));
}

#[test]
fn what_is_wrong_with_a_file_is_said_without_the_folder_s_own_place() {
    let folder = folder();
    let cell = folder.path().join(plan().cells[0].folder());
    fs::write(cell.join("ticks.csv"), "k,t_due_ns\n0,1\n").expect("a writable folder");
    let campaign = read(folder.path());
    let place = folder.path().display().to_string();
    let texts = exported(&report(&campaign));
    assert!(texts.iter().all(|text| !text.contains(&place)));
    assert!(texts[0].contains("type=\"damaged\""), "{}", texts[0]);
    // Neither are rows that cannot be read offered as a table.
    assert!(!texts[2].contains("arrivals.csv") || !texts[2].contains(&plan().cells[0].id));
}

proptest! {
    // Whatever a topology is called, its name comes back out of the XML and breaks no table.
    #[test]
    fn odd_names_stay_names(name in "[a-z<>&\"'|`\n\\]*é–]{1,12}") {
        let folder = folder();
        let mut campaign = read(folder.path());
        for run in &mut campaign.runs {
            run.cell.topology.clone_from(&name);
        }
        let report = report(&campaign);
        let xml = junit::xml(&report);
        let suites = quick_junit::Report::deserialize_from_str(&xml).expect("XML");
        // Readers of XML take a line's end in an attribute for a space.
        let found = suites.test_suites[0].name.as_str().replace('\n', " ");
        prop_assert_eq!(found, name.replace('\n', " "));
        let markdown = digest::markdown(&report);
        let rows: Vec<&str> = markdown.lines().filter(|line| line.starts_with('|')).collect();
        let bars = |line: &str| line.replace("\\|", "").matches('|').count();
        for row in rows {
            prop_assert!([3, 4, 5, 14].contains(&bars(row)), "{}", row);
        }
        prop_assert!(!markdown.contains('<'), "{}", markdown);
    }
}

#[test]
fn however_many_claims_differ_the_summary_stays_short() {
    let folder = folder();
    let campaign = read(folder.path());
    let mut report = report(&campaign);
    let mut long = finding("long", claim::Verdict::Differs, 7.0);
    long.reason = "it is later. ".repeat(1000);
    report.claims = vec![long; 1000];
    let text = digest::markdown(&report);
    assert!(text.len() < 20_000, "{} bytes", text.len());
    assert!(text.contains("975 more"), "{text}");
}
