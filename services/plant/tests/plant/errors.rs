//! The eight errors of communication that IEC 61784-3 names, a thousand of each, towards a plant with the safe
//! settings: not one bad message is applied, and the plant counts as many as there were.
//!
//! Each error has a plant of its own, so that its counters are of that error alone. Between two bad messages comes
//! a good one, which must be applied.

use std::{collections::BTreeMap, net::SocketAddr, path::Path};

use clock::now::now_ns;
use endpoint::{ArrivalOutcome, ArrivalRow, Lease, PlantSettings, SampleTime, checksum, report};
use plant::Config;

use crate::support::{Line, begin, config, observe, rows, with_config};

/// A thousand, where it is measured; fewer in a build for tests.
const EACH: u64 = if cfg!(debug_assertions) { 200 } else { 1000 };

/// Far above what a busy machine adds to the way of a message over loopback.
const MAX_AGE_NS: u64 = 5_000_000_000;

fn safe(out: &Path) -> Config {
    let h = SampleTime::try_new(1_000_000).expect("1 ms");
    Config {
        settings: PlantSettings {
            max_age_ns: Some(MAX_AGE_NS),
            lease: Lease::Token,
            check: true,
            ..PlantSettings::safe(h)
        },
        ..config(out)
    }
}

/// Sends messages to a plant, good ones and others.
struct Controller {
    line: Line,
    token: String,
    seq: u64,
    good: Vec<(u64, f64)>,
}

/// A message that no good controller sends says this.
const BAD: f64 = 9.0;

impl Controller {
    fn new(address: SocketAddr) -> Self {
        Self {
            line: Line::open(address),
            token: begin(address, "a test"),
            seq: 0,
            good: Vec::new(),
        }
    }

    /// The next good message, and its input.
    fn next(&mut self) -> (String, f64) {
        self.seq += 1;
        let u = (self.seq % 1000) as f64 / 1000.0;
        (message(self.seq, now_ns(), u), u)
    }

    /// Sends the next good message, which is taken; its text.
    fn send(&mut self) -> String {
        let (text, u) = self.next();
        let (status, body) = self.line.get(&format!("/closed?{text}"), &self.token);
        assert_eq!(status, 200, "{body}");
        self.good.push((self.seq, u));
        text
    }

    /// Sends a bad message, with this token; its status.
    fn send_bad(&mut self, text: &str, token: &str) -> u16 {
        self.line.get(&format!("/closed?{text}"), token).0
    }
}

/// A message with its checksum.
fn message(seq: u64, t_send_ns: u64, u: f64) -> String {
    checksum::signed(&format!("seq={seq}&t_send_ns={t_send_ns}&u={u}"))
}

/// Injects an error a thousand times into a plant; checks that only good messages were applied and that nothing
/// but `kind` was counted, as often. Returns the report.
fn inject(class: &str, kind: &str, mut bad: impl FnMut(&mut Controller, u64)) -> report::Plant {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut good = Vec::new();
    let report = with_config(safe(folder.path()), |ready| {
        let mut controller = Controller::new(ready.address);
        for n in 0..EACH {
            controller.send();
            bad(&mut controller, n);
        }
        controller.send();
        good = controller.good;
    })
    .expect("a run without errors");
    let arrivals: Vec<ArrivalRow> = rows(&folder.path().join("arrivals.csv"));
    let applied = arrivals
        .iter()
        .filter(|row| row.outcome == ArrivalOutcome::Applied);
    let applied: Vec<(u64, f64)> = applied.map(|row| (row.seq, row.u)).collect();
    assert_eq!(
        applied, good,
        "{class}: only what was sent, once and in order"
    );
    let counted = BTreeMap::from([(kind.to_owned(), EACH)]);
    assert_eq!(report.refusals, counted, "{class}");
    assert_eq!(report.refused, EACH, "{class}");
    let of = applied.len() - good.len();
    println!("| {class} | to the plant | {EACH} | {of} | {EACH} `{kind}` |");
    println!("row 17: {class} to the plant, {EACH}: {of} applied, {EACH} counted `{kind}`");
    report
}

/// Characters that a query may have, so that what arrives is a request at all.
const LETTERS: &[u8] = b"0123456789abcdefghijklmnopqrstuvwxyz=&._-+";

#[test]
fn a_corrupted_message_is_refused() {
    let mut random = 1_u64;
    let mut draw = move |below: usize| {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (random >> 33) as usize % below
    };
    inject("corruption", "checksum", |controller, _| {
        let (text, _) = controller.next();
        let mut bytes = text.clone().into_bytes();
        while bytes == text.as_bytes() {
            for _ in 0..=draw(4) {
                let place = draw(bytes.len());
                bytes[place] = LETTERS[draw(LETTERS.len())];
            }
        }
        let text = String::from_utf8(bytes).expect("ASCII");
        let token = controller.token.clone();
        assert_eq!(controller.send_bad(&text, &token), 400, "{text}");
    });
}

#[test]
fn a_repeated_message_is_dropped() {
    inject("repetition", "stale", |controller, _| {
        let text = controller.send();
        let token = controller.token.clone();
        assert_eq!(controller.send_bad(&text, &token), 200);
    });
}

#[test]
fn a_message_out_of_sequence_is_dropped() {
    inject("wrong sequence", "stale", |controller, _| {
        controller.seq += 1;
        let overtaken = message(controller.seq, now_ns(), BAD);
        controller.send();
        let token = controller.token.clone();
        assert_eq!(controller.send_bad(&overtaken, &token), 200);
    });
}

#[test]
fn a_message_that_was_too_long_under_way_is_dropped() {
    inject("delay", "aged", |controller, _| {
        controller.seq += 1;
        let sent_ns = now_ns() - MAX_AGE_NS - 1_000_000_000;
        let late = message(controller.seq, sent_ns, BAD);
        let token = controller.token.clone();
        assert_eq!(controller.send_bad(&late, &token), 200);
    });
}

#[test]
fn a_message_of_a_stranger_is_refused() {
    inject("insertion", "lease", |controller, _| {
        let text = message(controller.seq + 1, now_ns(), BAD);
        assert_eq!(controller.send_bad(&text, ""), 409);
    });
}

#[test]
fn a_message_with_a_guessed_token_is_refused() {
    inject("masquerade", "session", |controller, n| {
        let text = message(controller.seq + 1, now_ns(), BAD);
        assert_eq!(controller.send_bad(&text, &format!("{n:032x}")), 409);
    });
}

#[test]
fn a_message_for_another_plant_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let other = with_config(safe(folder.path()), |ready| {
        let token = begin(ready.address, "of the other plant");
        inject("addressing", "session", |controller, _| {
            let text = message(controller.seq + 1, now_ns(), BAD);
            assert_eq!(controller.send_bad(&text, &token), 409);
        });
    });
    assert_eq!(other.expect("a run without errors").arrivals, 0);
}

/// A message that is lost is nothing that a plant could refuse. It tells by its watchdog, once for each.
#[test]
fn a_lost_message_trips_the_watchdog() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let config = safe(folder.path());
    let config = Config {
        settings: PlantSettings {
            hold: "2ms then zero".parse().expect("a hold"),
            ..config.settings
        },
        ..config
    };
    let report = with_config(config, |ready| {
        let mut controller = Controller::new(ready.address);
        for n in 1..=EACH {
            controller.send();
            // This one is lost.
            let _ = controller.next();
            controller.line.wait_for("the silence is noticed", |state| {
                state.safe && state.trips == n && state.u_applied == 0.0
            });
        }
        assert_eq!(observe(ready.address).trips, EACH);
    })
    .expect("a run without errors");
    assert_eq!((report.trips, report.refused), (EACH, 0));
    println!("| loss | to the plant | {EACH} | 0 | {EACH} trips |");
    println!("row 17: loss to the plant, {EACH}: {EACH} trips of the watchdog");
}
