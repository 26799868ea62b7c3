//! The loop by every transport, against the real plant, and what each cannot do.

use controller::{Config, DriveError};
use endpoint::{
    Connection, ControllerSettings, MessageRow, Mode, PlantSettings, Preset, TickRow, Transport,
};

use crate::{MS, check, config, drive, h, rows, with_plant, with_settings};

fn by(transport: Transport, mode: Mode) -> ControllerSettings {
    ControllerSettings {
        transport,
        ..Preset::PaperPython.settings(mode, h(10))
    }
}

pub(crate) fn the_loop_settles_at_its_reference_by_every_transport() {
    for transport in Transport::ALL {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let settings = PlantSettings {
            udp: *transport == Transport::Udp,
            ..PlantSettings::new(h(10))
        };
        let (report, plant) = with_settings(folder.path(), settings, |address| {
            let settings = by(*transport, Mode::Closed);
            drive(&config(folder.path(), address, settings, 3000)).expect("a run without errors")
        });
        let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
        check(&report, &messages, 300);
        assert_eq!(report.first_failure, None, "{transport}");
        assert_eq!(plant.arrivals, report.counts.sent, "{transport}");
        assert_eq!(plant.refused, 0, "{transport}");
        let ticks: Vec<TickRow> = rows(&folder.path().join("ticks.csv"));
        let tail: Vec<f64> = ticks
            .iter()
            .filter(|row| (report.stop_ns - 1000 * MS..report.stop_ns).contains(&row.t_due_ns))
            .map(|row| row.y)
            .collect();
        let mean = tail.iter().sum::<f64>() / tail.len() as f64;
        assert!(
            (mean - 1.0).abs() < 0.02,
            "{transport}: mean of the last second {mean}"
        );
    }
}

pub(crate) fn an_open_loop_is_acknowledged_by_every_transport() {
    for transport in Transport::ALL {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let settings = PlantSettings {
            udp: *transport == Transport::Udp,
            ..PlantSettings::new(h(10))
        };
        let (report, _) = with_settings(folder.path(), settings, |address| {
            let settings = by(*transport, Mode::Open);
            drive(&config(folder.path(), address, settings, 300)).expect("a run without errors")
        });
        assert_eq!(report.counts.answered, report.counts.sent, "{transport}");
        assert_eq!(report.first_failure, None, "{transport}");
    }
}

pub(crate) fn what_a_transport_cannot_do_is_said_before_the_run() {
    let new = |transport| ControllerSettings {
        connection: Connection::New,
        ..by(transport, Mode::Closed)
    };
    let [tcp, udp, json] = [Transport::Tcp, Transport::Udp, Transport::Json];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let address = "127.0.0.1:1".parse().expect("an address");
    let with = |settings| config(folder.path(), address, settings, 1);
    let claims = Config {
        claim: true,
        ..with(by(udp, Mode::Closed))
    };
    let checks = Config {
        check: true,
        ..with(by(json, Mode::Closed))
    };
    for (config, says) in [
        (with(new(tcp)), "`tcp` is one connection"),
        (with(new(udp)), "`udp` has no connections"),
        (claims, "no session"),
        (checks, "no checksum"),
    ] {
        let error = drive(&config).expect_err(says);
        assert!(matches!(error, DriveError::Conflict(_)), "{error}");
        assert!(error.to_string().contains(says), "{error}");
        assert!(!folder.path().join("messages.csv").exists());
    }
}

pub(crate) fn a_plant_that_takes_no_datagrams_is_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (report, plant) = with_plant(folder.path(), h(10), |address| {
        let settings = by(Transport::Udp, Mode::Closed);
        drive(&config(folder.path(), address, settings, 200)).expect("a run to its end")
    });
    let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
    check(&report, &messages, 20);
    assert_eq!(report.counts.failed, report.counts.sent);
    let why = report.first_failure.expect("failures");
    assert!(why.contains("start it with --udp"), "{why}");
    assert_eq!(plant.arrivals, 0);
}
