//! Vectors that laws in other languages are checked against: the numbers of each, as clients are
//! told them, and what it answers, to the last bit.
//!
//! They lie with the ends' own, in `endpoint/tests/vectors`. A change of them is a change of the
//! law: look at the difference, then write them anew with
//! `WEBLOOP_WRITE_VECTORS=1 cargo test -p webloop-plan --test all vectors`.
#![allow(
    clippy::disallowed_methods,
    reason = "this test, not the crate, reads and writes files"
)]

use std::path::Path;

use control::{AnswerFacts, Law, LawInput, Moment, Signals};
use endpoint::SampleTime;
use plan::system::System;
use serde_json::{Value, json};

/// The outputs that a law sees: a response that overshoots and comes to rest, with a few that are
/// no number.
fn seen() -> Vec<f64> {
    let seen = |k: u32| 1.0 - (-0.2 * f64::from(k)).exp() * (0.5 * f64::from(k)).cos();
    let mut outputs: Vec<f64> = (0..28).map(seen).collect();
    outputs[7] = f64::NAN;
    outputs[8] = f64::INFINITY;
    // So far off that limits are met on both sides.
    outputs[12] = -40.0;
    outputs[13] = 60.0;
    outputs[14] = 1e300;
    outputs
}

/// Answers of a loop whose messages come at any time: when a command is sent, and the answer that is the newest then.
/// Some were seen before, one is older, one comes after a long silence, and one is to a message out of order.
fn times(k: u64, h_ns: u64, u: Signals) -> Moment {
    let send_ns = 9_000_000_000 + k * 4 * h_ns + (k * k * 7919) % h_ns;
    let send_ns = send_ns + if k > 22 { 2_000 * h_ns } else { 0 };
    let asked = match k {
        0 | 1 => None,
        9 => Some(4),
        16 => Some(14),
        _ => Some(k - 2 + k % 2),
    };
    let told = asked.map(|asked| {
        let since_ns = asked * 4 * h_ns + (asked * asked * 7919) % h_ns;
        let since_ns = since_ns + if asked > 22 { 2_000 * h_ns } else { 0 };
        AnswerFacts {
            tick: 100 + since_ns / h_ns,
            u: u.map(|u| if k == 11 { f64::NAN } else { u }),
            send_ns: 9_000_000_000 + since_ns - if k == 18 { 3 * h_ns } else { 0 },
        }
    });
    Moment { send_ns, told }
}

/// What a number is in the vectors: JSON has none for some.
fn shown(x: f64) -> Value {
    if x.is_finite() {
        json!(x)
    } else {
        json!(x.to_string())
    }
}

fn shown_both(signals: Signals) -> Value {
    match signals.second {
        None => shown(signals.first),
        Some(second) => json!([shown(signals.first), shown(second)]),
    }
}

fn case(name: &str, text: &str, h: &str) -> Value {
    let system = System::read(text).unwrap_or_else(|fault| panic!("{name}: {fault}"));
    let h: SampleTime = h.parse().expect("a sample time");
    let own = system.at(h).expect(name);
    let h_s = own.plant.h_s();
    let mut law = own.law;
    let mut last = Signals::zeros(law.signals().1);
    let (outputs, _) = law.signals();
    let steps: Vec<Value> = seen()
        .into_iter()
        .enumerate()
        .map(|(k, y)| {
            let r = if k < 20 { 1.0 } else { -0.5 };
            // One update comes late, and one at no time at all.
            let dt_s = match k {
                5 => 4.0 * h_s,
                10 => 0.0,
                _ => h_s,
            };
            // A second output lags behind the first.
            let y = Signals {
                first: y,
                second: (outputs > 1).then_some(0.5 * y - 0.1),
            };
            let times = match &law {
                Law::Aged(_) => Some(times(k as u64, h.ns(), last)),
                _ => None,
            };
            let u = law.update(r, LawInput { y, times }, dt_s);
            last = u;
            let mut step = json!({"r": r, "y": shown_both(y), "dt_s": dt_s, "u": u});
            if let Some(Moment { send_ns, told }) = times {
                let told = told.map(|AnswerFacts { tick, u, send_ns }| json!({"tick": tick, "u": shown_both(u), "send_ns": send_ns}));
                step["times"] = json!({"send_ns": send_ns, "told": told});
            }
            step
        })
        .collect();
    json!({"case": name, "law": own.design, "steps": steps})
}

#[test]
fn the_laws_do_what_their_vectors_say() {
    const PLANT: &str = "name = \"mine\"\n[plant]\nnum = [1.0]\nden = [1.0, 0.7, 0.2]\n";
    const TANKS: &str = "name = \"tanks\"\nr = [1.0, -0.25]\n[plant]\na = [[-0.8, 0.3], [0.3, -0.5]]\n\
         b = [[1.0, 0.0], [0.0, 2.0]]\nc = [[1.0, 0.0], [0.0, 1.0]]\n[controller]\nlaw = \"state-feedback\"\n\
         weights = { output = [10.0, 5.0], input = [0.1, 0.2] }\n\
         noise = { disturbance = [0.5, 0.4], measurement = [0.01, 0.02] }\nround_trip = \"25ms\"\n";
    let with = |controller: &str| format!("{PLANT}[controller]\n{controller}");
    let built_in = |name| System::built_in(name).expect("built in").to_owned();
    let pid = "law = \"pid\"\nkp = 1.5\nki = 0.8\nkd = 0.3\n";
    let limited = "limits = { min = -2.0, max = 3.0";
    let cases = [
        ("the paper's PI", built_in("motor"), "3ms"),
        ("PID, unfiltered", with(pid), "10ms"),
        (
            "PID, filtered",
            with(&format!("{pid}filter = 20.0\n")),
            "10ms",
        ),
        (
            "PID, limited, winding up",
            with(&format!("{pid}{limited}, anti_windup = \"off\" }}")),
            "10ms",
        ),
        (
            "PID, limited, conditional",
            with(&format!("{pid}{limited} }}")),
            "10ms",
        ),
        (
            "PID, limited, back-calculation",
            with(&format!(
                "{pid}{limited}, anti_windup = \"back-calculation\", gain = 5.0 }}"
            )),
            "10ms",
        ),
        (
            "PI, limited on one side",
            with("law = \"pid\"\nkp = 1.5\nki = 0.8\nlimits = { max = 1.0 }"),
            "10ms",
        ),
        (
            "a transfer function",
            with(&format!(
                "law = \"transfer\"\nnum = [2.0, 1.0, 0.5]\nden = [1.0, 3.0, 0.0]\n{limited} }}"
            )),
            "10ms",
        ),
        ("a Smith predictor", built_in("lag-smith"), "20ms"),
        ("state feedback", built_in("pendulum"), "10ms"),
        (
            "state feedback by gains, limited",
            with(&format!(
                "law = \"state-feedback\"\ngains = [1.2, 0.9]\nnoise = {{ disturbance = 0.5, measurement = 0.1 }}\nround_trip = \"25ms\"\n{limited} }}"
            )),
            "10ms",
        ),
        ("one input, two outputs", built_in("cart"), "10ms"),
        (
            "two inputs, two outputs, limited",
            format!("{TANKS}{limited} }}"),
            "20ms",
        ),
        (
            "outputs whose age is measured",
            built_in("motor-kalman"),
            "3ms",
        ),
        (
            "outputs whose age is measured, two of them, and two inputs, limited",
            format!("{TANKS}age = \"measured\"\n{limited} }}"),
            "20ms",
        ),
    ];
    let cases: Vec<Value> = cases
        .iter()
        .map(|(name, text, h)| case(name, text, h))
        .collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../services/endpoint/tests/vectors/laws.json");
    let text = format!("{:#}\n", json!({ "cases": cases }));
    if std::env::var("WEBLOOP_WRITE_VECTORS").is_ok() {
        std::fs::write(&path, &text).expect("the folder is in the repository");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        text == committed,
        "laws.json differs from what the laws do now:\n{text}"
    );
}
