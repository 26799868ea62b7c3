//! Vectors that other implementations of the two ends are checked against.
//!
//! Each file under `vectors/` is a script of what happens to an end, with what
//! the end does and the bytes it sends. A change of them is a change of the
//! protocol: look at the difference, then write them anew with
//! `WEBLOOP_WRITE_VECTORS=1 cargo test -p webloop-endpoint --test all vectors`.
#![allow(
    clippy::disallowed_methods,
    reason = "this test, not the crate, reads and writes files"
)]

use std::path::Path;

use control::preset;
use endpoint::{
    Answer, Command, ControllerEnd, ControllerSettings, Integrate, Late, Loss, Mode, Outstanding,
    PlantEnd, PlantSettings, Preset, Reference, SampleTime, Schedule, Step,
};
use serde_json::{Value, json};

const MS: u64 = 1_000_000;

fn h() -> SampleTime {
    SampleTime::try_new(3 * MS).expect("3 ms")
}

fn check(name: &str, vectors: &Value) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/vectors")
        .join(name);
    let text = format!("{vectors:#}\n");
    if std::env::var("WEBLOOP_WRITE_VECTORS").is_ok() {
        std::fs::write(&path, &text).expect("the folder is in the repository");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        text == committed,
        "{name} differs from what the ends do now:\n{text}"
    );
}

/// What happens to the plant, in order.
enum Happens {
    Tick,
    Request(u64, &'static str, &'static str),
}

fn plant_case(name: &str, late: Late, script: &[Happens]) -> Value {
    let plant = preset::paper_plant().sampled(h().ns()).expect("regular");
    let settings = PlantSettings {
        late,
        ..PlantSettings::new(h())
    };
    let start_ns = 100 * MS;
    let mut plant = PlantEnd::new(&settings, plant.stepper(), start_ns);
    let steps: Vec<Value> = script
        .iter()
        .map(|happens| match happens {
            Happens::Tick => {
                let row = plant.tick(plant.next_due_ns());
                json!({"tick": row.k, "at_ns": row.t_tick_ns, "u": row.u, "y": row.y, "seq": row.seq})
            }
            Happens::Request(at_ns, path, query) => {
                let mode = if *path == "/open" { Mode::Open } else { Mode::Closed };
                let request = format!("{path}?{query}");
                match query.parse::<Command>() {
                    Ok(command) => {
                        let (row, answer) = plant.command(mode, &command, *at_ns);
                        json!({"request": request, "at_ns": at_ns, "outcome": row.outcome, "answer": answer.to_string()})
                    }
                    Err(error) => json!({"request": request, "at_ns": at_ns, "refused": error.to_string()}),
                }
            }
        })
        .collect();
    json!({"case": name, "settings": settings, "start_ns": start_ns, "steps": steps})
}

#[test]
fn the_plant_does_what_its_vectors_say() {
    use Happens::{Request, Tick};
    let at = |t_us: u64| 100 * MS + t_us * 1000;
    let orders = || {
        [
            Tick,
            Request(at(100), "/closed", "seq=0&t_send_ns=100000000&u=0.171234"),
            Tick,
            Tick,
            Request(at(6100), "/closed", "seq=2&t_send_ns=106000000&u=0.1689"),
            Request(at(6100), "/closed", "seq=1&t_send_ns=103000000&u=0.1701"),
            Tick,
            Request(at(9500), "/open", "seq=3&t_send_ns=109000000&u=1"),
            Request(at(9600), "/closed", "seq=4&t_send_ns=109000000&u=NaN"),
            Request(at(9600), "/closed", "seq=4&t_send_ns=109000000"),
            Request(at(9600), "/closed", "seq=4&seq=5&t_send_ns=109000000&u=0"),
            Request(at(9600), "/closed", "seq=-4&t_send_ns=109000000&u=0"),
            Request(
                at(9600),
                "/closed",
                "seq=4&t_send_ns=109000000&u=0&mode=open",
            ),
            Tick,
            Request(at(12001), "/closed", "u=-1e-7&t_send_ns=112000000&seq=5"),
            Tick,
        ]
    };
    let cases = json!({
        "model": {"num": [preset::MOTOR_B0], "den": [1.0, preset::MOTOR_C0 + preset::MOTOR_C1, preset::MOTOR_C0 * preset::MOTOR_C1], "method": "backward-euler"},
        "cases": [
            plant_case("commands are applied in order of arrival", Late::Apply, &orders()),
            plant_case("commands that were overtaken are dropped", Late::Drop, &orders()),
        ],
    });
    check("plant.json", &cases);
}

/// What happens to the controller, in order.
enum Event {
    Wake(u64),
    Answer(u64, &'static str),
    Timeout(u64, u64),
    Failure(u64, u64),
}

fn wake(end: &mut ControllerEnd, now_ns: u64) -> Value {
    let mut steps = Vec::new();
    loop {
        let (step, last) = match end.poll(now_ns) {
            Step::Send(command) => (json!({"send": command.to_string()}), false),
            Step::Missed(row) => (json!({"missed": row.seq, "t_due_ns": row.t_due_ns}), false),
            Step::Sleep { until_ns } => (json!({"sleep_until_ns": until_ns}), true),
            Step::AwaitAnswer => (json!("await-answer"), true),
            Step::Finished => (json!("finished"), true),
        };
        steps.push(step);
        if last {
            return json!({"wake": true, "at_ns": now_ns, "then": steps});
        }
    }
}

fn controller_case(name: &str, settings: ControllerSettings, script: &[Event]) -> Value {
    moving_case(name, settings, None, script)
}

fn moving_case(
    name: &str,
    settings: ControllerSettings,
    reference: Option<&Reference>,
    script: &[Event],
) -> Value {
    let (start_ns, stop_ns) = (200 * MS, 230 * MS);
    let mut end = ControllerEnd::try_new(settings, preset::paper_pi(), 0.0, start_ns, stop_ns)
        .expect("valid")
        .following(reference.cloned());
    let steps: Vec<Value> = script
        .iter()
        .map(|event| match event {
            Event::Wake(at_ns) => wake(&mut end, *at_ns),
            Event::Answer(at_ns, text) => {
                let answer = match settings.mode {
                    Mode::Closed => Answer::State(text.parse().expect("a valid state")),
                    Mode::Open => Answer::Acknowledgement(text.parse().expect("a valid answer")),
                };
                json!({"answer": text, "at_ns": at_ns, "row": end.answered(&answer, *at_ns)})
            }
            Event::Timeout(at_ns, seq) => {
                json!({"timeout": seq, "at_ns": at_ns, "row": end.lost(*seq, Loss::Timeout, *at_ns)})
            }
            Event::Failure(at_ns, seq) => {
                json!({"failure": seq, "at_ns": at_ns, "row": end.lost(*seq, Loss::Failed, *at_ns)})
            }
        })
        .collect();
    json!({"case": name, "settings": settings, "reference": reference, "start_ns": start_ns, "stop_ns": stop_ns, "steps": steps, "counts": end.counts()})
}

#[test]
fn the_controller_does_what_its_vectors_say() {
    use Event::{Answer, Failure, Timeout, Wake};
    let at = |t_us: u64| 200 * MS + t_us * 1000;
    let paper = Preset::PaperPython.settings(Mode::Closed, h());
    let blocking = Preset::Blocking.settings(Mode::Closed, h());
    let reordered = || {
        [
            Wake(at(0)),
            Wake(at(3000)),
            Wake(at(6020)),
            Answer(at(7000), "seq=1&tick=40&t_arrive_ns=900&y=0.25&u=0.1"),
            Answer(at(7000), "seq=0&tick=39&t_arrive_ns=800&y=0.125&u=0.1"),
            Wake(at(9001)),
            Failure(at(9500), 2),
            Timeout(at(9600), 3),
            // Two deadlines late: those before the present one are missed.
            Wake(at(18500)),
            Answer(at(18600), "seq=6&tick=45&t_arrive_ns=901&y=1.5&u=0.1"),
            Wake(at(21000)),
            Wake(at(30000)),
        ]
    };
    let cases = json!({
        "law": {"kp": preset::PAPER_A0, "ki": preset::PAPER_A1, "method": "backward-euler"},
        "cases": [
            controller_case("paper-python: a message every h, answers in order of arrival", paper, &reordered()),
            controller_case(
                "the same, and answers of older ticks are left out",
                ControllerSettings { late: Late::Drop, ..paper },
                &reordered(),
            ),
            controller_case(
                "blocking: deadlines without a free request are missed",
                blocking,
                &[
                    Wake(at(0)),
                    Wake(at(3000)),
                    Wake(at(6000)),
                    Answer(at(7000), "seq=0&tick=39&t_arrive_ns=800&y=0.125&u=0.1"),
                    Wake(at(7000)),
                    Wake(at(9000)),
                    Timeout(at(10000), 3),
                    Wake(at(12000)),
                ],
            ),
            moving_case(
                "a reference that moves: r is that of the deadline, also where it is missed",
                blocking,
                Some(&Reference::try_from(vec![(0, 0.5), (3 * MS, -1.0), (5 * MS, 2.0), (20 * MS, 0.1)]).expect("times rise")),
                &[
                    Wake(at(0)),
                    Wake(at(3000)),
                    Answer(at(4000), "seq=0&tick=39&t_arrive_ns=800&y=0.125&u=0.1"),
                    Wake(at(6000)),
                    Answer(at(7000), "seq=2&tick=41&t_arrive_ns=900&y=0.25&u=0.1"),
                    Wake(at(21500)),
                ],
            ),
            controller_case(
                "relative and elapsed: h after the answer, integrating the time that passed",
                ControllerSettings {
                    schedule: Schedule::Relative,
                    integrate: Integrate::Elapsed,
                    ..blocking
                },
                &[
                    Wake(at(0)),
                    Answer(at(4000), "seq=0&tick=39&t_arrive_ns=800&y=0.125&u=0.1"),
                    Wake(at(4000)),
                    Wake(at(7500)),
                    Failure(at(28000), 1),
                    Wake(at(28000)),
                ],
            ),
            controller_case(
                "since-send: h after the sending, or with the answer if that is later",
                ControllerSettings {
                    schedule: Schedule::SinceSend,
                    ..blocking
                },
                &[
                    Wake(at(0)),
                    Answer(at(1000), "seq=0&tick=39&t_arrive_ns=800&y=0.125&u=0.1"),
                    Wake(at(3500)),
                    Wake(at(6500)),
                    Answer(at(8000), "seq=1&tick=40&t_arrive_ns=900&y=0.25&u=0.1"),
                    Wake(at(8000)),
                    Timeout(at(28000), 2),
                    Wake(at(28000)),
                ],
            ),
            controller_case(
                "open loop with two outstanding",
                ControllerSettings {
                    mode: Mode::Open,
                    outstanding: "2".parse::<Outstanding>().expect("a valid word"),
                    ..paper
                },
                &[
                    Wake(at(0)),
                    Wake(at(3000)),
                    Wake(at(6000)),
                    Answer(at(6500), "seq=1&t_arrive_ns=800"),
                    Wake(at(9000)),
                ],
            ),
        ],
    });
    check("controller.json", &cases);
}
