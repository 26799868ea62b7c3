//! Manifests that real runs left are read whole and written again as they were; what they do not
//! have is refused by its name.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

use std::fs;
use std::path::PathBuf;

use link::Epoch;
use record::Manifest;
use serde_json::{Value, json};

const RESULTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../results");

/// Those that are kept of each client and of each link.
fn kept() -> impl Iterator<Item = PathBuf> {
    ["clients", "smoke"].into_iter().flat_map(|campaign| {
        let folder = fs::read_dir(format!("{RESULTS}/{campaign}/manifests")).unwrap();
        folder.map(|entry| entry.unwrap().path())
    })
}

fn read(path: &PathBuf) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// Whether `new` has all that `old` has, in the same words; it may have fields besides, which are
/// newer than the run.
fn has_all_of(old: &Value, new: &Value) -> bool {
    match (old, new) {
        (Value::Object(old), Value::Object(new)) => old
            .iter()
            .all(|(name, old)| new.get(name).is_some_and(|new| has_all_of(old, new))),
        (old, new) => old == new,
    }
}

#[test]
fn what_a_run_left_is_written_again_as_it_was() {
    let mut clients = std::collections::BTreeSet::new();
    for path in kept() {
        let text = fs::read_to_string(&path).unwrap();
        let manifest = Manifest::from_json(&text).unwrap_or_else(|e| panic!("{path:?}: {e}"));
        let again = serde_json::from_str(&manifest.to_json()).unwrap();
        assert!(has_all_of(&read(&path), &again), "{path:?}\n{again:#}");
        clients.insert(manifest.cell.client);
    }
    assert_eq!(clients.len(), 4, "{clients:?}");
}

#[test]
fn the_schema_beside_the_crate_is_the_type() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/manifest.schema.json");
    if std::env::var_os("WEBLOOP_TEST_WRITE").is_some() {
        fs::write(path, Manifest::schema()).unwrap();
    }
    let remedy = "WEBLOOP_TEST_WRITE=1 writes it anew";
    assert!(
        fs::read_to_string(path).unwrap() == Manifest::schema(),
        "{remedy}"
    );
}

#[test]
fn a_field_that_no_report_has_is_refused_by_its_name_wherever_it_is() {
    const PLACES: [&str; 14] = [
        "",
        "/machine",
        "/certificate",
        "/certificate/baseline",
        "/plant",
        "/plant/granted/ticker",
        "/plant/tick_rows",
        "/controller",
        "/controller/rows",
        "/controller/browser",
        "/page",
        "/page/clock",
        "/link",
        "/link/up/lateness",
    ];
    let mut found = [false; PLACES.len()];
    for path in kept() {
        for (place, found) in PLACES.iter().zip(&mut found) {
            let mut manifest = read(&path);
            let Some(Value::Object(fields)) = manifest.pointer_mut(place) else {
                continue;
            };
            fields.insert("surprise".to_owned(), json!(1));
            let problem = Manifest::from_json(&manifest.to_string())
                .unwrap_err()
                .to_string();
            assert!(
                problem.contains("unknown field `surprise`"),
                "{place}: {problem}"
            );
            *found = true;
        }
    }
    assert_eq!(found, [true; PLACES.len()]);
}

/// Two players beside an end each, of which no run is kept: webloop's, tc's, and one of each.
#[test]
fn a_field_that_no_player_beside_an_end_has_is_refused_too() {
    use link::certificate::{Beside, LinkReport, OneWay, Scheduling, TcReport};
    let lateness = link::certificate::Lateness::default();
    let traffic = link::certificate::WayReport {
        packets: 9,
        bytes: 900,
        delivered: 7,
        lost: 1,
        overflow: 0,
        unplayed: 1,
        foreign: 0,
        dropped: 0,
        lateness,
        ..link::certificate::WayReport::default()
    };
    let tc = |way| {
        OneWay::Tc(Beside {
            own: None,
            peer: Some([10, 77, 0, 2].into()),
            report: TcReport {
                tc: "tc utility".to_owned(),
                kernel: "6.1".to_owned(),
                scheduling: Scheduling::Other,
                epoch: Epoch::at_ns(u64::MAX),
                started_ns: 1,
                ended_ns: 2,
                device: "plant0".to_owned(),
                way,
                step_ns: 1,
                changes: 3,
                skipped: 0,
                answer: lateness,
                found: json!([{ "kind": "noqueue" }]),
                first: json!([{ "kind": "netem", "options": { "delay": 0.25 } }]),
                last: Value::Null,
                traffic,
            },
        })
    };
    let user = |way| {
        OneWay::User(Beside {
            own: None,
            peer: None,
            report: link::certificate::WayPlayed {
                way,
                scheduling: Scheduling::Fifo,
                epoch: Epoch::at_ns(7),
                started_ns: 8,
                ended_ns: 9,
                pauses: vec![link::certificate::Pause { t_ns: 8, ns: 1 }],
                shaped: traffic,
                carried: traffic.into(),
            },
        })
    };
    use link::Way::{Down, Up};
    for report in [
        LinkReport::of_each(tc(Up), tc(Down)),
        LinkReport::of_each(user(Up), user(Down)),
        LinkReport::of_each(user(Up), tc(Down)),
        LinkReport::model(),
    ] {
        let json = serde_json::to_value(&report).unwrap();
        let again: LinkReport = serde_json::from_value(json.clone()).unwrap();
        assert_eq!(again, report);
        for place in ["", "/up", "/down", "/up/shaped", "/down/answer"] {
            let mut json = json.clone();
            let Some(Value::Object(fields)) = json.pointer_mut(place) else {
                continue;
            };
            fields.insert("surprise".to_owned(), json!(1));
            let problem = serde_json::from_value::<LinkReport>(json)
                .unwrap_err()
                .to_string();
            assert!(
                problem.contains("unknown field `surprise`"),
                "{place}: {problem}"
            );
        }
    }
}
