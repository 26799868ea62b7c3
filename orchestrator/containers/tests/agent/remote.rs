//! The orchestrator's side: a run from its beginning to its end, and errors that help.

use std::fs;
use std::io::Write;
use std::net::TcpListener;
use std::thread;
use std::time::{Duration, Instant};

use containers::{AgentName, Error, ProblemKind, Remote, RoleState, Token};
use serde_json::json;

use crate::served::{OTHER, SOON, Served, TOKEN};

fn settings(how: &str) -> serde_json::Value {
    json!({ "h": how })
}

#[test]
fn a_run_from_its_beginning_to_its_end() {
    let mut served = Served::unclaimed(|_| {});
    let remote = served.remote();
    let id = "couva native-333hz-r01-ä";
    let run = remote.begin(id).unwrap();
    fs::write(
        served.scratch().join(id).join("my rows.csv"),
        "n,x\n1,2.5\n",
    )
    .unwrap();
    assert!(
        run.start("plant", "plant", settings("ready"))
            .unwrap()
            .ends_with("as plant")
    );
    assert_eq!(run.state("plant").unwrap(), RoleState::Running);
    let ended = RoleState::Ended {
        code: 0,
        words: String::new(),
    };
    assert_eq!(run.stop("plant").unwrap(), ended);
    // A plant says itself when it was held up; a client in another language is looked at.
    assert_eq!(run.seen("plant").unwrap().looks, 0);
    run.start("python", "python", settings("ready")).unwrap();
    let deadline = Instant::now() + SOON;
    while run.seen("python").unwrap().looks == 0 && Instant::now() < deadline {
        thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(run.stop("python").unwrap(), ended);
    let seen = run.seen("python").unwrap();
    assert!(seen.looks > 0 && seen.stops_ns.is_empty(), "{seen:?}");
    assert!(run.seen("controller").is_err());
    assert_eq!(run.files().unwrap()["my rows.csv"], 10);
    assert_eq!(run.file("my rows.csv").unwrap().unwrap(), b"n,x\n1,2.5\n");
    assert_eq!(run.file("absent").unwrap(), None);
    run.finish().unwrap();
    remote.end().unwrap();
    served.ended(SOON);
}

#[test]
fn what_an_agent_refuses_comes_with_its_reason_and_kind() {
    let served = Served::unclaimed(|_| {});
    let run = served.remote().begin("r1").unwrap();
    for (how, expected) in [
        ("ends-3", ProblemKind::Unsupported),
        ("ends-2", ProblemKind::Usage),
        ("ends-1", ProblemKind::Failed),
    ] {
        match run.start(how, "plant", settings(how)) {
            Err(Error::Refused {
                agent,
                problem,
                kind,
            }) => {
                assert_eq!((agent.as_str(), kind), ("plant", expected));
                assert!(
                    problem.contains("what it lacks is a quiet machine"),
                    "{problem}"
                );
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(matches!(
        run.start("../x", "plant", json!({})),
        Err(Error::Name(_))
    ));
    let other = Remote::open(
        AgentName::Plant,
        &served.address.to_string(),
        OTHER.parse().unwrap(),
    );
    let error = other.unwrap().claim().unwrap_err().to_string();
    assert!(
        error.starts_with("plant: this agent belongs to another orchestrator"),
        "{error}"
    );
}

#[test]
fn nobody_there_is_said_with_the_place_and_the_remedy() {
    let token: Token = TOKEN.parse().unwrap();
    let free = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap()
        .to_string();
    let remote = Remote::open(AgentName::ControllerLink, &free, token.clone()).unwrap();
    let error = remote
        .wait_healthy(Duration::from_millis(300))
        .unwrap_err()
        .to_string();
    assert!(
        error.starts_with(&format!("controller-link: does not answer at {free}: ")),
        "{error}"
    );
    assert!(
        error.contains("refused") && error.contains("check that it runs"),
        "{error}"
    );

    let nowhere =
        Remote::open(AgentName::Plant, "no-such-host.invalid:7070", token.clone()).unwrap();
    let error = nowhere
        .wait_healthy(Duration::from_millis(300))
        .unwrap_err()
        .to_string();
    assert!(error.contains("at no-such-host.invalid:7070"), "{error}");

    assert!(matches!(
        Remote::open(AgentName::Plant, "plant", token),
        Err(Error::Authority { .. })
    ));
}

#[test]
fn an_agent_that_comes_late_is_waited_for() {
    let address = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let remote = Remote::open(
        AgentName::Plant,
        &address.to_string(),
        TOKEN.parse().unwrap(),
    )
    .unwrap();
    let waiting = thread::spawn(move || remote.wait_healthy(SOON));
    thread::sleep(Duration::from_millis(400));
    let _served = Served::unclaimed(|config| config.listen = address);
    assert!(!waiting.join().unwrap().unwrap().claimed);
}

#[test]
fn someone_else_at_the_address_is_not_taken_for_the_agent() {
    let served = Served::unclaimed(|_| {});
    let remote = Remote::open(
        AgentName::Controller,
        &served.address.to_string(),
        TOKEN.parse().unwrap(),
    );
    let error = remote.unwrap().wait_healthy(SOON).unwrap_err();
    assert!(matches!(error, Error::Stranger { .. }), "{error}");

    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || {
        for stream in listener.incoming() {
            let _ = stream
                .unwrap()
                .write_all(b"HTTP/1.1 200 OK\r\nContent-Length: 6\r\n\r\n<html>");
        }
    });
    let remote = Remote::open(AgentName::Plant, &address, TOKEN.parse().unwrap()).unwrap();
    let error = remote.wait_healthy(SOON).unwrap_err().to_string();
    assert!(
        error.contains("`<html>` is not an answer of an agent"),
        "{error}"
    );
    assert!(containers::health(&address).is_err());
    assert_eq!(
        containers::health(&served.address.to_string())
            .unwrap()
            .agent,
        AgentName::Plant
    );
}
