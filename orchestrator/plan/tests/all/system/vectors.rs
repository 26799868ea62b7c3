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

use control::Signals;
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

fn case(name: &str, text: &str, h: &str) -> Value {
    let system = System::read(text).unwrap_or_else(|fault| panic!("{name}: {fault}"));
    let own = system.at(h.parse().expect("a sample time")).expect(name);
    let h_s = own.plant.h_s();
    let mut law = own.law;
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
            let u = law.update(r, y, dt_s);
            let shown = |y: f64| {
                if y.is_finite() {
                    json!(y)
                } else {
                    json!(y.to_string())
                }
            };
            let y = match y.second {
                None => shown(y.first),
                Some(second) => json!([shown(y.first), shown(second)]),
            };
            json!({"r": r, "y": y, "dt_s": dt_s, "u": u})
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
