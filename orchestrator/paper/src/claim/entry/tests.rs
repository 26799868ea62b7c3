//! The built-in claims hold what their types cannot; wrong ones are told with their line and field.

use super::super::{interval, ping, rare, together};
use super::*;
use analysis::lateness::{IMPULSE, IMPULSE_MS};
use report::claim::rule;
use report::number::spelled;

const PLAIN: &str = r#"
[[claim]]
id = "one"
place = "Fig 1"
claim = "It settles."
check = "settling is at most 400 ms"
[[claim.runs]]
who = "python"
where = ["arima"]
mode = "closed"
h = ["3ms"]
figures = [{ figure = "settling", from = 0, to = 400 }]
"#;

#[test]
fn the_claims_that_the_crate_carries_are_whole() {
    let claims = read(BUILT_IN).unwrap_or_else(|wrong| panic!("{wrong}"));
    assert_eq!(claims.len(), built_in().len());
}

/// The ways in which people write a limit, whether it is a number, a share, or a distance from what it counts in.
fn ways(limit: f64) -> Vec<String> {
    let off = (1.0 - limit).abs();
    let mut ways = vec![limit.abs().to_string(), spelled(limit)];
    for off in [limit, off] {
        ways.push(format!("{} %", (off * 1e6).round() / 1e4));
        let words: &[&str] = match (1.0 / off).round() as u64 {
            2 => &["half", "most"],
            5 => &["a fifth"],
            10 => &["a tenth"],
            _ => &[],
        };
        ways.extend(words.iter().map(|word| (*word).to_owned()));
    }
    ways
}

/// Every limit that is written under a key, wherever it stands.
fn limits(value: &toml::Value) -> Vec<f64> {
    match value {
        toml::Value::Array(all) => all.iter().flat_map(limits).collect(),
        toml::Value::Table(table) => table
            .iter()
            .flat_map(|(key, value)| match (key.as_str(), value) {
                ("from" | "to" | "times" | "least", toml::Value::Float(limit)) => vec![*limit],
                ("from" | "to" | "times" | "least", toml::Value::Integer(limit)) => {
                    vec![*limit as f64]
                }
                _ => limits(value),
            })
            .collect(),
        _ => Vec::new(),
    }
}

#[test]
fn what_counts_as_agreement_is_said_with_its_limits() {
    let table: toml::Table = BUILT_IN.parse().expect("TOML");
    let entries = table["claim"].as_array().expect("claims");
    for (claim, entry) in built_in().iter().zip(entries) {
        // That a share is 1 at most, and that none or one is not some, needs no words.
        let is_said = |limit: &f64| {
            [0.0, 1.0].contains(limit) || ways(*limit).iter().any(|way| claim.check.contains(way))
        };
        let unsaid = limits(entry).into_iter().find(|limit| !is_said(limit));
        assert_eq!(unsaid, None, "{}: {}", claim.id, claim.check);
    }
}

#[test]
fn what_code_decides_is_said_with_its_limits_too() {
    let percent = |share: f64| format!("{} %", share * 1e2);
    for (id, said) in [
        ("table-2-arima", vec![ping::LOOPBACK_AVG_MS.to_string()]),
        ("table-2-buccoo", vec![spelled(ping::MAX_WITHIN)]),
        (
            "text-couva-ping",
            vec![format!("{} to {} ms", ping::TENS_MS.0, ping::TENS_MS.1)],
        ),
        ("table-3-100-hz", ways(together::WITHIN)[2..].to_vec()),
        ("table-3-10-hz", vec![percent(2.0 * rare::TAIL)]),
        (
            "table-3-3-hz",
            vec![format!("fewer than {}", spelled(rule::COUNT_MIN))],
        ),
        (
            "reading-table-3-arima",
            ways(together::WITHIN)[2..].to_vec(),
        ),
        (
            "fig-3-impulses",
            vec![format!(
                "{} medians and {} ms",
                spelled(IMPULSE),
                IMPULSE_MS
            )],
        ),
        ("fig-9b-zeros", vec![format!("h/{}", interval::NEAR)]),
    ] {
        let claim = built_in().iter().find(|claim| claim.id == id).expect(id);
        assert!(
            said.iter().any(|words| claim.check.contains(words)),
            "{id}: {said:?}"
        );
    }
}

#[test]
fn an_ordinary_claim_is_one_entry() {
    let claims = read(PLAIN).unwrap_or_else(|wrong| panic!("{wrong}"));
    let rows: Vec<&Row> = claims[0].rows().collect();
    let [row] = rows.as_slice() else {
        panic!("{rows:?}")
    };
    assert_eq!(
        (row.metric.of.as_ref(), row.metric.unit),
        ("settling", "ms")
    );
    assert!(matches!(row.accepted, Accepted::Within((0.0, 400.0))));
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let wrong = |from: &str, to: &str| {
        assert!(PLAIN.contains(from), "{from}");
        let wrong = read(&PLAIN.replacen(from, to, 1)).expect_err(to);
        wrong.to_string()
    };
    let told: Vec<String> = [
        (r#""settling""#, r#""setling""#),
        ("arima", "arma"),
        ("python", "pyton"),
        ("python", "firefox"),
        ("python", "firefox worke"),
        ("3ms", "3"),
        ("to = 400", "too = 400"),
        ("to = 400", r#"to = 4, in = "paper""#),
        ("from = 0, to = 400", ""),
        (
            "to = 400",
            "above = { where = \"buccoo\" }, below = { where = \"buccoo\" }",
        ),
        ("check =", "check_as ="),
        ("check", "reading_of = \"two\"\ncheck"),
        ("check =", "odd = \"out-of-order\"\ncheck ="),
        (r#"["3ms"]"#, "[]"),
    ]
    .into_iter()
    .map(|(from, to)| wrong(from, to))
    .collect();
    insta::assert_snapshot!(told.join("\n"));
    let twice = read(&PLAIN.repeat(2)).expect_err("the same id");
    insta::assert_snapshot!(twice, @"claims.toml: claim `one` is there twice; give each an id of its own");
}
