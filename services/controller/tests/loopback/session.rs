//! A plant whose lease is `token`, with every message checked.

use controller::Config;
use endpoint::{
    ArrivalOutcome, ArrivalRow, ControllerSettings, Lease, MessageRow, Mode, PlantSettings, Preset,
    Transport,
};

use crate::{check, config, drive, h, rows, with_settings};

fn safe() -> PlantSettings {
    PlantSettings {
        lease: Lease::Token,
        check: true,
        max_age_ns: Some(2_000_000_000),
        ..PlantSettings::safe(h(5))
    }
}

pub(crate) fn a_controller_claims_the_plant_and_gives_it_back() {
    for transport in [
        Transport::Http,
        Transport::Json,
        Transport::Tcp,
        Transport::WebSocket,
    ] {
        // An object has no checksum.
        let check_sums = transport != Transport::Json;
        let folder = tempfile::tempdir().expect("a temporary folder");
        let settings = ControllerSettings {
            transport,
            ..Preset::PaperPython.settings(Mode::Closed, h(5))
        };
        let out = folder.path();
        let (reports, plant) = with_settings(
            out,
            PlantSettings {
                check: check_sums,
                ..safe()
            },
            |address| {
                // One after the other, the second at once: the first has given the plant back.
                ["first", "second"].map(|name| {
                    let config = Config {
                        claim: true,
                        check: check_sums,
                        ..config(&out.join(name), address, settings, 500)
                    };
                    drive(&config).expect("a run without errors")
                })
            },
        );
        for (report, name) in reports.iter().zip(["first", "second"]) {
            let messages: Vec<MessageRow> = rows(&out.join(name).join("messages.csv"));
            check(report, &messages, 100);
            assert_eq!(report.first_failure, None, "{transport}");
            assert_eq!(report.counts.answered, report.counts.sent, "{transport}");
        }
        // A machine that stands still lets a message by a newer connection come first, and the older is stale.
        let stale = plant.refusals.get("stale").copied().unwrap_or_default();
        assert_eq!((plant.sessions, plant.refused), (2, stale), "{transport}");
        let has_many = matches!(transport, Transport::Http | Transport::Json);
        assert!(
            stale == 0 || has_many,
            "{transport}: one connection keeps the order"
        );
        let arrivals: Vec<ArrivalRow> = rows(&out.join("arrivals.csv"));
        let is_read = |row: &ArrivalRow| {
            matches!(row.outcome, ArrivalOutcome::Applied | ArrivalOutcome::Stale)
        };
        assert!(arrivals.iter().all(is_read), "{transport}");
        assert!(!out.join("messages.csv").exists(), "its rows stay with it");
    }
}

pub(crate) fn a_controller_that_is_not_told_to_claim_is_refused_every_message() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = Preset::PaperPython.settings(Mode::Closed, h(5));
    let out = folder.path();
    let (report, plant) = with_settings(out, safe(), |address| {
        let config = Config {
            check: true,
            ..config(&out.join("own"), address, settings, 200)
        };
        drive(&config).expect("a run without errors")
    });
    assert_eq!(report.counts.failed, report.counts.sent);
    let why = report.first_failure.expect("all failed");
    assert!(why.contains("begin one with POST /session"), "{why}");
    assert_eq!(plant.refusals.get("session"), Some(&report.counts.sent));
    assert_eq!(plant.arrivals, 0);
}
