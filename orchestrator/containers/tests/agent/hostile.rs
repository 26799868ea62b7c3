//! What is not for the agent, or not whole: by name, by page, by token, by size and by time.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::served::{OTHER, SOON, Served, TOKEN};

/// Header lines, and the status that they get on a route that needs the token.
fn foreign() -> Vec<(String, u16)> {
    let own = format!("Authorization: Bearer {TOKEN}\r\n");
    let host = "Host: agent\r\n";
    let mut table = Vec::new();
    for name in [
        "example.org",
        "example.org:7070",
        "agent.example.org",
        "localhost.example.org",
        "127.0.0.1.example.org",
        "aagent",
        "agent.",
        "localhost.",
        "0x7f000001",
        "2130706433",
        "127.1",
    ] {
        table.push((format!("Host: {name}\r\n{own}"), 421));
    }
    for name in [
        "",
        ":",
        ":7070",
        "agent::",
        "agent:x",
        "agent:70700",
        "[::1",
        "::1",
        "a b",
        "a/b",
        "me@agent",
        "agent,agent",
    ] {
        table.push((format!("Host: {name}\r\n{own}"), 400));
    }
    table.push((own.clone(), 400));
    table.push((format!("{host}{host}{own}"), 400));
    table.push((format!("{host}Host: example.org\r\n{own}"), 400));
    for line in [
        "Origin: http://example.org",
        "Origin: http://agent",
        "Origin: null",
        "Origin: ",
        "Referer: http://example.org/",
        "Referer: http://agent/",
        "Sec-Fetch-Site: cross-site",
        "Sec-Fetch-Site: same-site",
        "Sec-Fetch-Site: same-origin",
        "Sec-Fetch-Site: none",
    ] {
        table.push((format!("{host}{line}\r\n{own}"), 403));
    }
    for (lines, status) in [
        (String::new(), 401),
        (format!("Authorization: Bearer {OTHER}\r\n"), 401),
        (format!("Authorization: bearer{TOKEN}\r\n"), 401),
        (format!("Authorization: Basic {TOKEN}\r\n"), 401),
        (format!("Authorization: {TOKEN}\r\n"), 401),
        (format!("Authorization: Bearer {TOKEN}0\r\n"), 401),
        (
            format!("Authorization: Bearer {TOKEN}, Bearer {TOKEN}\r\n"),
            401,
        ),
        (
            format!("Authorization: Bearer {}\r\n", TOKEN.to_uppercase()),
            401,
        ),
        (format!("Proxy-Authorization: Bearer {TOKEN}\r\n"), 401),
        (format!("Cookie: token={TOKEN}\r\n"), 401),
        (format!("{own}{own}"), 400),
        (format!("{own}Authorization: Bearer {OTHER}\r\n"), 400),
        (format!("Authorization: Bearer {OTHER}\r\n{own}"), 400),
    ] {
        table.push((format!("{host}{lines}"), status));
    }
    table
}

#[test]
fn nothing_foreign_changes_the_agent_and_no_answer_has_a_token() {
    let served = Served::claimed();
    let table = foreign();
    let count = table.len();
    assert!(count >= 45, "{count}");
    for (lines, status) in table {
        for request in [
            "POST /end",
            "DELETE /run/r1",
            "PUT /run/r2",
            "POST /run/r1/role/a",
            "OPTIONS /run/r1",
        ] {
            let answer = served.raw(
                format!(
                    "{request} HTTP/1.1\r\nConnection: close\r\n{lines}Content-Length: 0\r\n\r\n"
                )
                .as_bytes(),
            );
            let text = answer.text();
            assert_eq!(answer.status, status, "{request} {lines}: {text}");
            let all = format!("{} {text}", answer.head);
            assert!(!all.contains(TOKEN) && !all.contains(OTHER), "{all}");
            assert!(
                !answer.head.to_lowercase().contains("access-control"),
                "{all}"
            );
        }
    }
    let answer = served.ask("GET", "http://example.org/run/r1/files", b"");
    assert_eq!(answer.status, 400, "{}", answer.text());
    assert_eq!(served.ask("GET", "/run/r1/files", b"").json(), json!({}));
    assert_eq!(served.ask("GET", "/run/r1/role/a", b"").status, 404);
    println!(
        "row 20: agent, {count} lines in 5 requests: all refused, no change of state, no token in answers"
    );
}

/// Each in a connection that only sends a part of a head.
#[test]
fn a_claim_is_answered_at_once_beside_more_half_heads_than_there_are_places() {
    serial::timed(
        "a_claim_is_answered_at_once_beside_more_half_heads_than_there_are_places",
        || {
            let served = Served::claimed();
            let held: Vec<TcpStream> = (0..200)
                .map(|n| {
                    let mut stream = TcpStream::connect(served.address).unwrap();
                    let text = if n % 2 == 0 {
                        "GET /health HTTP/1.1\r\nHost: "
                    } else {
                        ""
                    };
                    stream.write_all(text.as_bytes()).unwrap();
                    stream
                })
                .collect();
            for _ in 0..20 {
                let begun = Instant::now();
                assert_eq!(served.ask("GET", "/run/r1/files", b"").status, 200);
                let took = begun.elapsed();
                // A half head is let go after five.
                assert!(took < Duration::from_secs(2), "{took:?}");
            }
            drop(held);
        },
    );
}

#[test]
fn a_refused_host_ends_its_connection_and_an_own_one_may_be_in_the_target() {
    let served = Served::claimed();
    let own = format!("Authorization: Bearer {TOKEN}\r\n");
    for (start, lines, status) in [
        ("GET /run/r1/files HTTP/1.1", "Host: example.org\r\n", 421),
        ("GET /run/r1/files HTTP/1.1", "Host: a b\r\n", 400),
        ("GET /run/r1/files HTTP/1.1", "", 400),
        (
            "GET /run/r1/files HTTP/1.0",
            "Connection: keep-alive\r\n",
            400,
        ),
        ("DELETE /run/r1 HTTP/1.0", "", 400),
        (
            "GET http://example.org/run/r1/files HTTP/1.1",
            "Host: agent\r\n",
            400,
        ),
        (
            "GET https://agent/run/r1/files HTTP/1.1",
            "Host: agent\r\n",
            400,
        ),
        (
            "GET http://agent/run/r1/files HTTP/1.1",
            "Host: a/b\r\n",
            400,
        ),
    ] {
        let answer = served.raw(format!("{start}\r\n{lines}{own}\r\n").as_bytes());
        assert_eq!(answer.status, status, "{start} {lines}");
        let head = answer.head.to_lowercase();
        assert!(
            head.contains("connection: close") || start.ends_with("1.0"),
            "{head}"
        );
    }
    for (start, lines) in [
        ("GET http://agent/run/r1/files HTTP/1.1", "Host: agent\r\n"),
        (
            "GET http://AGENT:7070/run/r1/files HTTP/1.1",
            "Host: example.org\r\n",
        ),
        ("GET /run/r1/files HTTP/1.1", "Host: 127.0.0.1:\r\n"),
        ("GET /health HTTP/1.0", ""),
    ] {
        let text = format!("{start}\r\nConnection: close\r\n{lines}{own}\r\n");
        let answer = served.raw(text.as_bytes());
        assert_eq!(answer.status, 200, "{start}: {}", answer.text());
    }
}

#[test]
fn a_run_has_a_limit_of_roles() {
    let served = Served::claimed();
    for instance in 0..64 {
        let started = served.start(&format!("r{instance}"), "quick");
        assert!([201, 422].contains(&started.status), "{}", started.text());
        served.ask("DELETE", &format!("/run/r1/role/r{instance}"), b"");
    }
    let refused = served.start("more", "quick");
    assert_eq!(refused.status, 409, "{}", refused.text());
    assert!(
        refused.text().contains("at most 64 roles"),
        "{}",
        refused.text()
    );
}

/// By the clock, for it is about what does not come.
#[test]
fn a_client_that_stands_still_is_let_go_within_five_seconds() {
    serial::timed(
        "a_client_that_stands_still_is_let_go_within_five_seconds",
        || {
            let served = Served::claimed();
            let body = format!(
                "POST /run/r1/role/a HTTP/1.1\r\nHost: agent\r\nAuthorization: Bearer {TOKEN}\r\nContent-Length: 20\r\n\r\n{{"
            );
            let table = [
                (
                    "half a head",
                    "GET /health HTTP/1.1\r\nHost: agent\r\n".to_owned(),
                ),
                (
                    "no second request",
                    "GET /health HTTP/1.1\r\nHost: agent\r\n\r\n".to_owned(),
                ),
                ("half a body", body),
            ];
            thread::scope(|scope| {
                for (name, text) in table {
                    let address = served.address;
                    scope.spawn(move || {
                        let mut stream = TcpStream::connect(address).unwrap();
                        stream.set_read_timeout(Some(2 * SOON)).unwrap();
                        stream.write_all(text.as_bytes()).unwrap();
                        let begun = Instant::now();
                        let _ = stream.read_to_end(&mut Vec::new());
                        let took = begun.elapsed();
                        assert!(took < Duration::from_millis(6_500), "{name}: {took:?}");
                    });
                }
            });
        },
    );
}
