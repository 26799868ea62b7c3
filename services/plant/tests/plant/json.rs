//! Commands in the body of a POST.

use endpoint::{Lease, PlantSettings};
use plant::{Config, Ready};

use crate::support::{begin, config, observe, send, with_config, with_plant};

const JSON: (&str, &str) = ("Content-Type", "application/json");

#[test]
fn both_modes_take_an_object_and_answer_in_the_form_that_is_asked_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        let wants = ("Accept", "application/json");
        let body = r#"{"seq":7,"t_send_ns":5,"u":0.5}"#;
        let told = send(address, "POST /closed", &[JSON, wants], body);
        assert_eq!(told.status, 200, "{told:?}");
        let state: serde_json::Value = serde_json::from_str(&told.body).expect("JSON");
        assert_eq!((&state["seq"], &state["u"]), (&7.into(), &0.5.into()));
        let told = send(address, "POST /open", &[JSON], r#"{"u":9}"#);
        assert!(told.body.starts_with("seq="), "{told:?}");
        assert_eq!(observe(address).u, 0.5);
    })
    .expect("a run without errors");
    assert_eq!(report.arrivals, 2);
}

#[test]
fn a_session_commands_by_objects_too() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_plant(folder.path(), |Ready { address, .. }| {
        let token = begin(address, "a browser");
        let refused = send(address, "POST /closed", &[JSON], r#"{"u":1}"#);
        assert_eq!(refused.status, 409, "{refused:?}");
        let session = ("Webloop-Session", token.as_str());
        let taken = send(address, "POST /closed", &[JSON, session], r#"{"u":1}"#);
        assert_eq!(taken.status, 200, "{taken:?}");
        assert_eq!(observe(address).u, 1.0);
    })
    .expect("a run without errors");
}

#[test]
fn a_body_that_is_no_command_is_refused_and_changes_nothing() {
    let long = format!("{{\"u\":1{}}}", " ".repeat(1024));
    let table = [
        (
            "POST /closed",
            vec![],
            r#"{"u":1}"#,
            415,
            "application/json",
        ),
        (
            "POST /closed?u=1",
            vec![JSON],
            "{}",
            400,
            "in a body of JSON",
        ),
        ("POST /closed", vec![JSON], "", 400, "no object"),
        ("POST /closed", vec![JSON], "[1,2,3]", 400, "no object"),
        ("POST /closed", vec![JSON], r#"{"seq":1}"#, 400, "`u`"),
        (
            "POST /closed",
            vec![JSON],
            r#"{"u":1,"u":2}"#,
            400,
            "duplicate",
        ),
        (
            "POST /closed",
            vec![JSON],
            r#"{"u":1e999}"#,
            400,
            "out of range",
        ),
        (
            "POST /closed",
            vec![JSON],
            r#"{"u":[1,2]}"#,
            400,
            "one input",
        ),
        ("POST /closed", vec![JSON], &long, 413, "1024"),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let count = table.len() as u64;
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        for (request, headers, body, status, says) in table {
            let refused = send(address, request, &headers, body);
            assert_eq!(refused.status, status, "{body}: {refused:?}");
            assert!(refused.body.contains(says), "{body}: {refused:?}");
            assert_eq!(observe(address).u, 0.0, "{body} changed the input");
        }
    })
    .expect("a run without errors");
    assert_eq!((report.arrivals, report.refused), (0, count));
}

#[test]
fn an_object_has_no_checksum_so_a_plant_that_needs_one_refuses_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let usual = config(folder.path());
    let config = Config {
        settings: PlantSettings {
            check: true,
            lease: Lease::None,
            ..usual.settings
        },
        ..usual
    };
    let report = with_config(config, |Ready { address, .. }| {
        let refused = send(address, "POST /closed", &[JSON], r#"{"u":1}"#);
        assert_eq!(refused.status, 400, "{refused:?}");
        assert!(refused.body.contains("`crc` is missing"), "{refused:?}");
    });
    let report = report.expect("a run without errors");
    assert_eq!(report.refusals.get("checksum"), Some(&1));
}
