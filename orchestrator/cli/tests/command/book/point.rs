//! The page about the paper has a row for each point of its text: which claims ask it, and what the kept run of
//! results/paper says of each. The last column is made from that run's claims.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use report::claim::Verdict;
use report::number::number;
use report::outcome::answered;
use serde::Deserialize;
use serde_json::Value;

use crate::book::page::ROOT;

const PAGE: &str = "docs/paper.md";
const SECTION: &str = "## Every point of the text";

fn text(path: &str) -> String {
    fs::read_to_string(format!("{ROOT}/{path}")).expect("in the repository")
}

/// The ids in a line, in backticks.
fn ids(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

#[test]
fn each_claim_of_the_paper_is_a_point_of_its_page() {
    let table: toml::Table = text("orchestrator/paper/claims.toml")
        .parse()
        .expect("TOML");
    let claims = table["claim"].as_array().expect("claims").iter();
    let claims: BTreeSet<String> = claims
        .filter_map(|claim| Some(claim["id"].as_str()?.to_owned()))
        .collect();
    let page = text(PAGE);
    let (_, points) = page.split_once(SECTION).expect("its section");
    let named: BTreeSet<String> = ids(points).map(str::to_owned).collect();
    assert_eq!(named, claims);
    let numbers = points.lines().filter_map(|line| {
        let (number, _) = line.strip_prefix("| ")?.split_once(" |")?;
        number.parse::<usize>().ok()
    });
    assert!(numbers.eq(1..=39), "39 points, in the paper's order");
}

#[test]
fn each_point_says_what_the_kept_run_says_of_its_claims() {
    let board: Vec<Value> =
        serde_json::from_str(&text("results/paper/report/claims.json")).expect("JSON");
    let board: BTreeMap<&str, &Value> = board
        .iter()
        .filter_map(|finding| Some((finding["id"].as_str()?, finding)))
        .collect();
    let page = text(PAGE);
    let (before, points) = page.split_once(SECTION).expect("its section");
    let lines = points.lines().map(|line| match ids(line).next() {
        Some(_) => with_verdicts(line, &board),
        None => line.to_owned(),
    });
    let told = format!(
        "{before}{SECTION}{}\n",
        lines.collect::<Vec<_>>().join("\n")
    );
    if std::env::var_os("WEBLOOP_TEST_WRITE").is_some() {
        fs::write(format!("{ROOT}/{PAGE}"), &told).unwrap();
    }
    assert!(
        text(PAGE) == told,
        "{PAGE}: WEBLOOP_TEST_WRITE=1 writes it anew"
    );
}

/// What the tunnel adds, in the medians of six loops' median round trips, is what the page says.
#[test]
fn what_a_tunnel_costs_is_what_the_kept_loops_took() {
    let mut rows =
        csv::Reader::from_path(format!("{ROOT}/results/wireguard/round-trips.csv")).expect("kept");
    let mut by_way: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for row in rows.records() {
        let row = row.expect("a row");
        by_way
            .entry(row[0].to_owned())
            .or_default()
            .push(row[3].parse().expect("ms"));
    }
    let median = |way: &str| analysis::statistics::median(&by_way[way]).expect("six");
    let more_ms = median("wireguard") - median("bare");
    let told = format!("a WireGuard tunnel adds {more_ms:.2} ms");
    assert!(text(PAGE).contains(&told), "{told}");
}

/// A row with its last cell made from the board.
fn with_verdicts(line: &str, board: &BTreeMap<&str, &Value>) -> String {
    let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
    let [number, point, asked, _] = cells[..] else {
        panic!("four cells: {line}");
    };
    let known = |id: &str| board.get(id).copied();
    let found: Vec<Option<&Value>> = ids(line).map(known).collect();
    let words = match found.as_slice() {
        few if few.len() <= 2 => few
            .iter()
            .map(|of| verdict(*of))
            .collect::<Vec<_>>()
            .join("; "),
        many => counted(many),
    };
    format!("| {number} | {point} | {asked} | {words} |")
}

/// The verdict as the report words it.
fn word(finding: Option<&Value>) -> &'static str {
    let verdict = finding.and_then(|finding| Verdict::deserialize(&finding["verdict"]).ok());
    answered(verdict.unwrap_or(Verdict::NotRun))
}

/// A verdict with the first number that has it, beside the paper's: `differs, 0.0036 (paper: 0.25)`.
fn verdict(finding: Option<&Value>) -> String {
    let word = word(finding);
    let parts = finding.and_then(|finding| finding["parts"].as_array());
    let has_it = |part: &&Value| {
        let limits = part["accepted"].as_array();
        let decides = limits.is_some_and(|limits| limits.iter().any(|limit| !limit.is_null()));
        decides && finding.is_some_and(|finding| part["verdict"] == finding["verdict"])
    };
    let Some(part) = parts.and_then(|parts| parts.iter().find(has_it)) else {
        return word.to_owned();
    };
    let Some(ours) = part["ours"]["value"].as_f64() else {
        return word.to_owned();
    };
    let unit = part["unit"].as_str().unwrap_or_default();
    let with_unit = |value: f64| format!("{} {unit}", number(value)).trim_end().to_owned();
    match part["paper"].as_f64() {
        Some(paper) => format!("{word}, {} (paper: {})", with_unit(ours), number(paper)),
        None => format!("{word}, {}", with_unit(ours)),
    }
}

/// How many of many have each verdict: `4 agree, 1 differs`.
fn counted(found: &[Option<&Value>]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for finding in found {
        *counts.entry(word(*finding)).or_default() += 1;
    }
    let words = counts.iter().map(|(word, n)| match (*word, n) {
        ("agrees", 2..) => format!("{n} agree"),
        ("differs", 2..) => format!("{n} differ"),
        (word, n) => format!("{n} {word}"),
    });
    words.collect::<Vec<_>>().join(", ")
}
