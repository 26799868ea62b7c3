//! Roles at an agent: started, looked at, ended, in all the ways that they can go wrong.

use std::fs;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::served::{SOON, Served, gone, process};

#[test]
fn a_role_gets_its_settings_gets_ready_and_ends_when_told_to() {
    let served = Served::claimed();
    let body = br#"{"role": "link", "settings": {"seed": "-1 --out=/etc"}}"#;
    let started = served.ask("POST", "/run/r1/role/link-up", body);
    assert_eq!(started.status, 201, "{}", started.text());
    let ready = started.json()["ready"].as_str().unwrap().to_owned();
    assert!(ready.ends_with(" as link"), "{ready}");
    assert_eq!(
        served.ask("GET", "/run/r1/role/link-up", b"").json(),
        json!({"state": "running"})
    );

    let folder = served.scratch().join("r1");
    let expected = format!(
        "--settings\n-\n--out\n{}\n{{\"seed\":\"-1 --out=/etc\"}}\n",
        folder.display()
    );
    let deadline = Instant::now() + SOON;
    let given = || fs::read_to_string(folder.join("arguments.txt")).unwrap_or_default();
    while given() != expected {
        assert!(Instant::now() < deadline, "{}", given());
        thread::sleep(Duration::from_millis(10));
    }

    let ended = json!({"state": "ended", "code": 0, "words": ""});
    assert_eq!(
        served.ask("DELETE", "/run/r1/role/link-up", b"").json(),
        ended
    );
    assert!(gone(process(&started)));
    assert_eq!(served.ask("GET", "/run/r1/role/link-up", b"").json(), ended);
    assert_eq!(
        served.ask("DELETE", "/run/r1/role/link-up", b"").json(),
        ended
    );
}

#[test]
fn a_role_that_ends_before_it_is_ready_is_refused_with_its_last_words() {
    let served = Served::claimed();
    for (code, kind) in [
        (1, "failed"),
        (2, "usage"),
        (3, "unsupported"),
        (0, "failed"),
        (77, "failed"),
    ] {
        let instance = format!("plant-{code}");
        let answer = served.start(&instance, &format!("ends-{code}"));
        assert_eq!(answer.status, 422, "{}", answer.text());
        let problem = answer.json();
        assert_eq!(problem["kind"], kind, "{problem}");
        let words = problem["problem"].as_str().unwrap().to_owned();
        assert!(
            words.starts_with(&format!("the {instance} ended before it was ready")),
            "{words}"
        );
        assert!(
            code == 0 || words.contains("what it lacks is a quiet machine"),
            "{words}"
        );
        let state = served
            .ask("GET", &format!("/run/r1/role/{instance}"), b"")
            .json();
        assert_eq!(
            (&state["state"], &state["code"]),
            (&json!("ended"), &json!(code))
        );
    }
}

#[test]
fn a_program_that_is_not_there_is_said() {
    let served = Served::unclaimed(|config| config.program = "/nowhere/webloop".into());
    served.ask("POST", "/claim", b"");
    served.ask("PUT", "/run/r1", b"");
    let answer = served.start("plant", "ready");
    assert_eq!(answer.status, 422);
    assert!(
        answer.text().contains("the plant cannot be started"),
        "{}",
        answer.text()
    );
}

#[test]
fn a_name_is_used_once_a_run() {
    let served = Served::claimed();
    assert_eq!(served.start("plant", "ready").status, 201);
    assert_eq!(served.start("plant", "ready").status, 409);
    served.ask("DELETE", "/run/r1/role/plant", b"");
    assert_eq!(served.start("plant", "ready").status, 409);
    served.ask("PUT", "/run/r1", b"");
    assert_eq!(served.start("plant", "ready").status, 201);
}

#[test]
fn a_role_that_breaks_later_shows_its_code_and_words() {
    let served = Served::claimed();
    assert_eq!(served.start("plant", "breaks").status, 201);
    let deadline = Instant::now() + SOON;
    let state = loop {
        let state = served.ask("GET", "/run/r1/role/plant", b"").json();
        if state["state"] == "ended" {
            break state;
        }
        assert!(Instant::now() < deadline);
        thread::sleep(Duration::from_millis(20));
    };
    assert_eq!(
        state,
        json!({"state": "ended", "code": 1, "words": "it broke"})
    );
}

#[test]
fn while_one_role_starts_and_another_will_not_end_the_agent_answers() {
    serial::timed(
        "while_one_role_starts_and_another_will_not_end_the_agent_answers",
        || {
            let served = Served::claimed();
            assert_eq!(served.start("stubborn", "stubborn").status, 201);
            thread::scope(|scope| {
                let slow = scope.spawn(|| served.start("slow", "slow"));
                let stop = scope.spawn(|| {
                    (
                        served.ask("DELETE", "/run/r1/role/stubborn", b""),
                        Instant::now(),
                    )
                });
                let begun = Instant::now();
                let mut asked = 0;
                while !slow.is_finished() {
                    assert_eq!(served.ask("GET", "/run/r1/files", b"").status, 200);
                    asked += 1;
                }
                // Each takes about a millisecond; were they to wait, there would be one or two.
                assert!(asked > 10, "{asked} answers within {:?}", begun.elapsed());
                let slow = slow.join().unwrap();
                assert_eq!(
                    (slow.status, slow.json()),
                    (201, json!({"ready": "at last"}))
                );
                let (stopped, at) = stop.join().unwrap();
                let state = stopped.json();
                assert_eq!(
                    (&state["state"], &state["code"]),
                    (&json!("ended"), &json!(137))
                );
                assert!(
                    state["words"].as_str().unwrap().contains("5s of SIGTERM"),
                    "{state}"
                );
                assert!(at.duration_since(begun) > Duration::from_millis(4_500));
            });
        },
    );
}

#[test]
fn a_run_that_is_ended_ends_the_role_that_somebody_waits_for() {
    serial::timed(
        "a_run_that_is_ended_ends_the_role_that_somebody_waits_for",
        || {
            let served = Served::claimed();
            thread::scope(|scope| {
                let waiting = scope.spawn(|| served.start("mute", "mute"));
                let deadline = Instant::now() + SOON;
                while served.ask("GET", "/run/r1/role/mute", b"").status != 200 {
                    assert!(Instant::now() < deadline && !waiting.is_finished());
                    thread::sleep(Duration::from_millis(5));
                }
                let begun = Instant::now();
                assert_eq!(served.ask("DELETE", "/run/r1", b"").status, 204);
                assert_eq!(waiting.join().unwrap().status, 422);
                // It would have waited for 10 s.
                assert!(
                    begun.elapsed() < Duration::from_secs(5),
                    "{:?}",
                    begun.elapsed()
                );
            });
        },
    );
}
