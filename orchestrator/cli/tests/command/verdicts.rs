//! Five hundred and more loops, links and faults whose verdict is known by how they were made: held, badly held, not
//! settled, lost early and late, silent by the link, the controller or the plant; tracking and regulation, with noise
//! and with limits.
//!
//! Each is a cell of its own in virtual time; with `WEBLOOP_TEST_SOCKETS=1` two of each kind run over real sockets.
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::fs;

use analysis::LoopVerdict::{Holds, HoldsBadly, Lost, Silent, Unsettled};
use analysis::{LoopVerdict, Summary};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use crate::gate::webloop;

/// Loops of each kind.
const EACH: usize = 20;

/// A loop, and what is true of it.
struct Case {
    system: String,
    topology: &'static str,
    /// The lines of the event that it meets; empty for none.
    event: String,
    duration: &'static str,
    verdict: LoopVerdict,
    /// What the reason says, among other words.
    reason: &'static str,
}

/// Draws numbers evenly.
struct Draw(ChaCha8Rng);

impl Draw {
    fn between(&mut self, least: f64, most: f64) -> f64 {
        let part = self.0.next_u32() as f64 / f64::from(u32::MAX);
        least + (most - least) * part
    }

    fn sign(&mut self) -> f64 {
        if self.0.next_u32().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        }
    }
}

/// The paper's motor under its PI, with these lines in its `[plant]`.
fn motor(r: f64, plant: &str) -> String {
    let pid = "law = \"pid\"\nkp = 0.1701\nki = 0.378\n";
    let (head, rest) = plan::system::System::built_in("motor")
        .unwrap()
        .split_once("[plant]")
        .unwrap();
    let (model, _) = rest.split_once("[controller]").unwrap();
    assert!(head.contains("motor"));
    format!("r = {r}\n[plant]{model}{plant}\n[controller]\n{pid}")
}

/// A pendulum of 1 m under state feedback with a Kalman filter.
fn pendulum(r: f64, plant: &str) -> String {
    format!(
        "r = {r}\n[plant]\na = [[0.0, 1.0], [9.81, 0.0]]\nb = [0.0, 1.0]\nc = [1.0, 0.0]\n{plant}\n[controller]\n\
         law = \"state-feedback\"\nweights = {{ output = 100.0, input = 1.0 }}\n\
         noise = {{ disturbance = 1.0, measurement = 0.001 }}\nround_trip = \"10ms\"\n"
    )
}

/// A first-order lag under a proportional and an integral gain.
fn lag(tau_s: f64, kp: f64, ki: f64, more: &str) -> String {
    format!(
        "{more}[plant]\nnum = [1.0]\nden = [{tau_s}, 1.0]\n[controller]\nlaw = \"pid\"\nkp = {kp}\nki = {ki}\n"
    )
}

fn case(system: String, verdict: LoopVerdict, reason: &'static str) -> Case {
    Case {
        system,
        topology: "./near.toml",
        event: String::new(),
        duration: "8s",
        verdict,
        reason,
    }
}

/// One loop of each kind.
fn kinds(draw: &mut Draw) -> Vec<(&'static str, Case)> {
    let r = draw.sign() * draw.between(0.2, 5.0);
    let near = |system, verdict, reason| case(system, verdict, reason);
    let x0 = draw.sign() * draw.between(0.02, 0.08);
    let noise = draw.between(0.0003, 0.0015);
    let (from, rest) = (draw.between(1.0, 5.0), 100.0);
    let at = |from: f64, length: f64, what: &str| {
        format!(
            "at = \"{:.0}us\", for = \"{:.0}us\", {what}",
            from * 1e6,
            length * 1e6
        )
    };
    let with = |event: String, case: Case| Case { event, ..case };
    let tau_s = draw.between(0.1, 0.4);
    let limits = |least: f64, greatest: f64| format!("limits = [{least:?}, {greatest:?}]\n");
    let start = format!("x0 = [{x0}, 0.0]\n");
    let load = |size: f64, from: f64| {
        format!(
            "disturbance = {{ size = {size}, from = \"{:.0}ms\" }}\n",
            from * 1e3
        )
    };
    let sine = |period_s: f64| {
        let ms = period_s * 1e3;
        format!("[reference]\nshape = \"sine\"\nlow = -1.0\nhigh = 1.0\nperiod = \"{ms:.0}ms\"\n")
    };
    let cut = draw.between(1.0, 6.0);
    vec![
        ("tracks", near(motor(r, ""), Holds, "")),
        (
            "tracks, a lag",
            near(lag(tau_s, 1.0, 1.0 / tau_s, ""), Holds, ""),
        ),
        (
            "tracks, unstable",
            near(pendulum(0.1 * r.signum(), ""), Holds, ""),
        ),
        ("catches", near(pendulum(0.0, &start), Holds, "")),
        (
            "catches with noise, in a band",
            near(
                pendulum(
                    0.0,
                    &format!("{start}band = 0.05\nsensor = {{ noise = {noise} }}\n"),
                ),
                Holds,
                "",
            ),
        ),
        ("rests", near(motor(0.0, ""), Holds, "")),
        (
            "follows",
            near(lag(tau_s, 4.0, 4.0 / tau_s, &sine(6.0)), Holds, ""),
        ),
        (
            "a pause that nothing comes of",
            with(
                at(
                    draw.between(1.0, 5.0),
                    draw.between(0.3, 1.5),
                    "down = true",
                ),
                near(motor(r, ""), Holds, ""),
            ),
        ),
        ("two outputs", near(cart(""), Holds, "")),
        (
            "overshoots",
            near(motor(r, "overshoot = \"2%\"\n"), HoldsBadly, "overshoot"),
        ),
        (
            "pushes",
            near(
                motor(r, &format!("effort = {}\n", 0.06 * r.abs())),
                HoldsBadly,
                "an input of",
            ),
        ),
        (
            "is pushed",
            near(
                motor(r, &load(0.1 * r, draw.between(2.0, 5.0))),
                HoldsBadly,
                "left its band",
            ),
        ),
        (
            "cannot follow",
            near(lag(0.4, 0.2, 0.1, &sine(0.3)), Unsettled, "off by"),
        ),
        (
            "rests beside r",
            near(
                lag(tau_s, draw.between(1.0, 4.0), 0.0, ""),
                Unsettled,
                "off by",
            ),
        ),
        (
            "is too weak",
            near(
                motor(
                    r.abs(),
                    &format!("actuator = {{ max = {} }}\n", 0.015 * r.abs()),
                ),
                Unsettled,
                "off by",
            ),
        ),
        (
            "has no time",
            Case {
                duration: "200ms",
                ..near(motor(r, ""), Unsettled, "off by")
            },
        ),
        (
            "lost late",
            with(
                at(cut, rest, "down = true"),
                near(pendulum(0.1, &load(1.0, cut)), Lost, ""),
            ),
        ),
        (
            "lost early",
            near(
                motor(r.abs(), &limits(-1.0, 1.01 * r.abs())),
                Lost,
                "left its limits",
            ),
        ),
        (
            "too far away",
            Case {
                topology: "./far.toml",
                ..near(motor(r, ""), Lost, "grows")
            },
        ),
        (
            "not held at all",
            near(
                format!(
                    "r = 0.0\n[plant]\na = [[0.0, 1.0], [9.81, 0.0]]\nb = [0.0, 1.0]\nc = [1.0, 0.0]\n{start}\
                     [controller]\nlaw = \"pid\"\nkp = 0.1\n"
                ),
                Lost,
                "",
            ),
        ),
        (
            "fallen beyond its limits",
            with(
                at(0.01, rest, "down = true"),
                near(
                    pendulum(0.0, &(start.clone() + &limits(-0.3, 0.3))),
                    Lost,
                    "left its limits",
                ),
            ),
        ),
        (
            "two outputs, one beyond its limits",
            near(
                cart("limits = [[-inf, inf], [-0.0001, 0.0001]]\n"),
                Lost,
                "left its limits",
            ),
        ),
        (
            "silent by the link",
            with(
                at(from, rest, "down = true"),
                near(motor(r, ""), Silent, "the link let nothing"),
            ),
        ),
        (
            "silent by the controller",
            with(
                at(from, 7.9999 - from, "freeze = \"controller\""),
                near(motor(r, ""), Silent, "the controller sent nothing"),
            ),
        ),
        (
            "silent by the plant",
            with(
                at(from, 7.9999 - from, "freeze = \"plant\""),
                near(motor(r, ""), Silent, "the plant took no command"),
            ),
        ),
        (
            "a controller that stands still and goes on",
            with(
                at(from, 1.0, "freeze = \"controller\""),
                near(motor(r, ""), Holds, ""),
            ),
        ),
        (
            "a plant that stands still and goes on",
            with(
                at(from, 1.0, "freeze = \"plant\""),
                near(motor(r, ""), Holds, ""),
            ),
        ),
    ]
}

/// The built-in pendulum on a cart, with these lines in its `[plant]`.
fn cart(plant: &str) -> String {
    let text = plan::system::System::built_in("cart").unwrap();
    let (_, rest) = text.split_once("r = 0.5").unwrap();
    let (model, law) = rest.split_once("[controller]").unwrap();
    format!("r = 0.5{model}{plant}\n[controller]{law}")
}

#[test]
fn each_loop_has_the_verdict_that_it_was_made_for() {
    let place = tempfile::tempdir().unwrap();
    let sockets = std::env::var_os("WEBLOOP_TEST_SOCKETS").is_some();
    let each = if sockets { 2 } else { EACH };
    let link = |name: &str, base: &str| {
        format!("name = \"{name}\"\nabout = \"A\"\n[both.delay]\nbase = \"{base}\"\n")
    };
    fs::write(place.path().join("near.toml"), link("near", "1ms")).unwrap();
    fs::write(place.path().join("far.toml"), link("far", "120ms")).unwrap();
    let mut draw = Draw(ChaCha8Rng::seed_from_u64(36));
    let mut cases: Vec<(String, &str, Case)> = Vec::new();
    for nth in 0..each {
        for (at, (kind, case)) in kinds(&mut draw).into_iter().enumerate() {
            cases.push((format!("s-{at}-{nth}"), kind, case));
        }
    }
    let mut text = "name = \"verdicts\"\n".to_owned();
    for (name, _, case) in &cases {
        if !case.event.is_empty() {
            let Case { event, .. } = case;
            writeln!(
                text,
                "[[fault]]\nname = \"{name}\"\nabout = \"A\"\nevent = [{{ {event} }}]"
            )
            .unwrap();
        }
    }
    for (name, _, case) in &cases {
        let Case {
            topology,
            duration,
            system,
            event,
            ..
        } = case;
        let fault = if event.is_empty() {
            String::new()
        } else {
            format!("fault = \"{name}\"\n")
        };
        fs::write(
            place.path().join(format!("{name}.toml")),
            format!("name = \"{name}\"\n{system}"),
        )
        .unwrap();
        writeln!(
            text,
            "[[cells]]\ntopology = \"{topology}\"\nsystem = \"./{name}.toml\"\nclient = \"native\"\n\
             mode = \"closed\"\nh = \"10ms\"\nduration = \"{duration}\"\n{fault}"
        )
        .unwrap();
    }
    fs::write(place.path().join("verdicts.toml"), text).unwrap();
    let backend = if sockets { "netns" } else { "sim" };
    let words = format!("run verdicts.toml --backend {backend} --out out --progress quiet");
    let (code, said) = webloop(place.path(), &words);
    assert!(matches!(code, Some(0 | 1)), "{said}");
    let rows = fs::read_to_string(place.path().join("out/summary.csv")).unwrap();
    let rows: Vec<Summary> = csv::Reader::from_reader(rows.as_bytes())
        .deserialize()
        .map(Result::unwrap)
        .collect();
    assert_eq!(rows.len(), cases.len());
    let mut wrong = Vec::new();
    let mut judged = 0;
    for (name, kind, case) in &cases {
        let row = rows
            .iter()
            .find(|row| row.cell.contains(&format!("-{name}-")))
            .unwrap();
        // The machine may hold up a real run: then it says so, and proves nothing here.
        if sockets && row.verdict != Some(plan::Verdict::Complete) {
            println!("{kind}: {:?} {:?}", row.verdict, row.disturbed);
            continue;
        }
        judged += 1;
        let reason = row.loop_reason.clone().unwrap_or_default();
        if row.loop_verdict != Some(case.verdict) || !reason.contains(case.reason) {
            wrong.push(format!("{kind} ({name}): {:?}, {reason}", row.loop_verdict));
        }
    }
    println!("verdicts: {} of {judged} right", judged - wrong.len());
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
