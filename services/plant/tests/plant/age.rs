//! Commands that were held or stamped by a wrong clock, over sockets, under each lease: `endpoint` has a thousand of
//! each kind, without them.

use std::{net::SocketAddr, path::Path, thread, time::Duration};

use clock::now::now_ns;
use endpoint::{ArrivalOutcome, ArrivalRow, Lease, PlantSettings, SampleTime};
use plant::Config;
use tokio_tungstenite::tungstenite::Message;

use crate::support::{Line, begin, config, rows, with_config};

/// Far above what a busy machine adds to the way over loopback.
const MAX_AGE_NS: u64 = 1_000_000_000;

const S: i64 = 1_000_000_000;

fn safe(out: &Path, lease: Lease) -> Config {
    let h = SampleTime::try_new(1_000_000).expect("1 ms");
    Config {
        settings: PlantSettings {
            max_age_ns: Some(MAX_AGE_NS),
            lease,
            ..PlantSettings::safe(h)
        },
        ..config(out)
    }
}

/// A controller that says of itself what it likes.
struct Controller {
    line: Line,
    token: String,
    seq: u64,
}

/// A command with a right stamp says this, any other that.
const GOOD: f64 = 0.5;
const BAD: f64 = 9.0;

impl Controller {
    fn new(address: SocketAddr, lease: Lease) -> Self {
        Self {
            line: Line::open(address),
            token: match lease {
                Lease::Token => begin(address, "a test"),
                Lease::None | Lease::Address => String::new(),
            },
            seq: 0,
        }
    }

    /// Sends a command whose stamp is `wrong_ns` from now; the input that the plant holds then.
    fn send(&mut self, wrong_ns: i64, u: f64) -> f64 {
        self.seq += 1;
        let sent_ns = now_ns().saturating_add_signed(wrong_ns);
        let target = format!("/closed?seq={}&t_send_ns={sent_ns}&u={u}", self.seq);
        let (status, text) = self.line.get(&target, &self.token);
        assert_eq!(status, 200, "{text}");
        let state: endpoint::State = text.parse().expect("a state");
        state.u.first
    }
}

#[test]
fn held_commands_are_dropped_under_each_lease_and_wrong_stamps_harm_nobody() {
    thread::scope(|scope| {
        for lease in [Lease::None, Lease::Address, Lease::Token] {
            scope.spawn(move || held_and_wrong(lease));
        }
    });
}

fn held_and_wrong(lease: Lease) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut bad = 0;
    let report = with_config(safe(folder.path(), lease), |ready| {
        let mut controller = Controller::new(ready.address, lease);
        // Even the first may be old: the plant was perhaps started anew.
        assert_eq!(controller.send(-5 * S, BAD), 0.0);
        assert_eq!(controller.send(10 * S, BAD), 0.0);
        bad += 2;
        for silent_ms in [0, 2_100] {
            for _ in 0..20 {
                assert_eq!(controller.send(0, GOOD), GOOD);
            }
            thread::sleep(Duration::from_millis(silent_ms));
            for held_ns in [11 * S / 10, 19 * S / 10, 22 * S / 10, 5 * S] {
                for _ in 0..50 {
                    assert_eq!(
                        controller.send(-held_ns, BAD),
                        GOOD,
                        "held for {held_ns} ns"
                    );
                    bad += 1;
                }
            }
            for wrong_ns in [10 * S, -10 * S, S, 3600 * S] {
                controller.send(wrong_ns, BAD);
                bad += 1;
                assert_eq!(controller.send(0, GOOD), GOOD, "behind {wrong_ns} ns");
            }
        }
    })
    .expect("a run without errors");
    let arrivals: Vec<ArrivalRow> = rows(&folder.path().join(ArrivalRow::FILE));
    let applied = arrivals
        .iter()
        .filter(|row| row.outcome == ArrivalOutcome::Applied);
    assert!(applied.clone().all(|row| row.u == GOOD), "{lease}");
    assert_eq!(applied.count() as u64 + bad, arrivals.len() as u64);
    assert_eq!(report.refusals.get("aged"), Some(&bad), "{lease}");
}

#[test]
fn over_a_websocket_it_is_the_same() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = safe(folder.path(), Lease::Address);
    let report = with_config(config, |ready| {
        let mut socket = crate::socket::open(ready.address, "mode=closed").expect("a socket");
        let mut seq = 0;
        let mut send = |wrong_ns: i64, u: f64| {
            seq += 1;
            let sent_ns = now_ns().saturating_add_signed(wrong_ns);
            let text = format!("seq={seq}&t_send_ns={sent_ns}&u={u}");
            socket.send(Message::text(text)).expect("it reads");
            let answer = socket.read().expect("an answer");
            let text = answer.to_text().expect("a text");
            let state: endpoint::State = text.parse().expect("a state");
            state.u.first
        };
        for _ in 0..20 {
            assert_eq!(send(0, GOOD), GOOD);
            assert_eq!(send(-5 * S, BAD), GOOD);
            assert_eq!(send(10 * S, BAD), GOOD);
        }
    })
    .expect("a run without errors");
    assert_eq!(report.refusals.get("aged"), Some(&40));
}
