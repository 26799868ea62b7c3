//! Who gets what: tokens, bodies, names, files. Roles are in `roles`.

use std::fs;

use serde_json::json;

use crate::served::{Answer, OTHER, SOON, Served, TOKEN};

/// Every route that needs the token.
const ROUTES: [(&str, &str); 9] = [
    ("PUT", "/run/r1"),
    ("DELETE", "/run/r1"),
    ("GET", "/run/r1/file/a"),
    ("GET", "/run/r1/files"),
    ("POST", "/run/r1/role/plant"),
    ("GET", "/run/r1/role/plant"),
    ("DELETE", "/run/r1/role/plant"),
    ("POST", "/end"),
    ("GET", "/nowhere"),
];

/// A refusal says why, and of what kind it is.
fn refused(answer: &Answer, status: u16, kind: &str) {
    assert_eq!(answer.status, status, "{}", answer.text());
    let problem = answer.json();
    assert_eq!(problem["kind"], kind, "{problem}");
    assert!(problem["problem"].as_str().unwrap().len() > 10, "{problem}");
}

#[test]
fn anyone_may_ask_who_it_is() {
    let served = Served::unclaimed(|_| {});
    let health = served.ask_as(None, "GET", "/health", b"");
    assert_eq!(health.status, 200);
    let expected =
        json!({"agent": "plant", "webloop": env!("CARGO_PKG_VERSION"), "claimed": false});
    assert_eq!(health.json(), expected);
    assert_eq!(served.ask("POST", "/claim", b"").json()["claimed"], true);
}

#[test]
fn without_the_token_there_is_nothing() {
    let served = Served::unclaimed(|_| {});
    for (method, path) in ROUTES {
        refused(&served.ask_as(None, method, path, b""), 401, "usage");
        // A token is worth nothing before it has claimed the agent.
        refused(&served.ask(method, path, b""), 401, "usage");
    }
    served.ask("POST", "/claim", b"");
    let last = &TOKEN[..TOKEN.len() - 1];
    for (method, path) in ROUTES {
        for token in [None, Some(OTHER), Some(last), Some("short"), Some("")] {
            let answer = served.ask_as(token, method, path, b"");
            refused(&answer, 401, "usage");
            assert!(
                answer
                    .head
                    .to_lowercase()
                    .contains("www-authenticate: bearer")
            );
        }
    }
    let basic = served.raw(
        format!("GET /run/r1/files HTTP/1.1\r\nHost: a\r\nConnection: close\r\nAuthorization: Basic {TOKEN}\r\n\r\n").as_bytes(),
    );
    refused(&basic, 401, "usage");
}

#[test]
fn an_agent_has_one_master() {
    let served = Served::unclaimed(|_| {});
    refused(&served.ask_as(None, "POST", "/claim", b""), 401, "usage");
    assert_eq!(served.ask("POST", "/claim", b"").status, 200);
    refused(
        &served.ask_as(Some(OTHER), "POST", "/claim", b""),
        409,
        "usage",
    );
    assert_eq!(served.ask("POST", "/claim", b"").status, 200);
}

#[test]
fn a_token_given_at_the_start_is_the_only_one() {
    let served = Served::unclaimed(|config| config.token = Some(TOKEN.parse().unwrap()));
    refused(
        &served.ask_as(Some(OTHER), "POST", "/claim", b""),
        401,
        "usage",
    );
    assert_eq!(
        served.ask_as(None, "GET", "/health", b"").json()["claimed"],
        false
    );
    assert_eq!(served.ask("PUT", "/run/r1", b"").status, 201);
    assert_eq!(
        served.ask_as(None, "GET", "/health", b"").json()["claimed"],
        true
    );
}

#[test]
fn a_body_that_is_no_role_starts_none() {
    let served = Served::claimed();
    for body in [
        "",
        "{",
        "[]",
        "null",
        r#"{"settings": {}}"#,
        r#"{"role": 3}"#,
        r#"{"role": "plant", "out": "/etc"}"#,
        r#"{"role": "plant"}"#,
        r#"{"role": "agent", "settings": {}}"#,
        r#"{"role": "run", "settings": {}}"#,
        r#"{"role": "../plant", "settings": {}}"#,
        "\u{0}\u{1}",
    ] {
        let answer = served.ask("POST", "/run/r1/role/a", body.as_bytes());
        refused(&answer, 400, "usage");
    }
    refused(
        &served.ask("POST", "/run/r1/role/a", b"\xff\xfe"),
        400,
        "usage",
    );
    refused(&served.ask("GET", "/run/r1/role/a", b""), 404, "usage");
}

#[test]
fn a_body_that_is_too_long_is_not_kept() {
    let served = Served::claimed();
    let long = vec![b' '; (16 << 20) + 1];
    refused(&served.ask("POST", "/run/r1/role/a", &long), 413, "usage");
    // By its own word too long: refused before a byte of it has come.
    let head = format!(
        "POST /run/r1/role/a HTTP/1.1\r\nHost: a\r\nAuthorization: Bearer {TOKEN}\r\nContent-Length: {}\r\n\r\n",
        (16 << 20) + 1
    );
    refused(&served.raw(head.as_bytes()), 413, "usage");
    // Without a word about it, in chunks.
    let head = format!(
        "POST /run/r1/role/a HTTP/1.1\r\nHost: a\r\nAuthorization: Bearer {TOKEN}\r\nTransfer-Encoding: chunked\r\n\r\n"
    );
    let chunk = [b"8000\r\n".as_slice(), &vec![b' '; 0x8000], b"\r\n"].concat();
    let chunks = chunk.repeat((16 << 20) / 0x8000);
    let bytes = [head.as_bytes(), &chunks, b"1\r\n \r\n0\r\n\r\n"].concat();
    refused(&served.raw(&bytes), 413, "usage");
    assert_eq!(served.ask("GET", "/run/r1/files", b"").json(), json!({}));
}

#[test]
fn no_name_leads_out_of_the_runs_folder() {
    let served = Served::claimed();
    let outside = served.folder.path().join("outside");
    fs::write(&outside, "secret").unwrap();
    let paths = [
        "/run/r1/file/..%2F..%2F..%2Foutside",
        "/run/r1/file/%2e%2e%2foutside",
        "/run/r1/file/..",
        "/run/r1/file/.hidden",
        "/run/r1/file/a%00b",
        "/run/r1/file/a%5Cb",
        "/run/r1/file/%FF",
        "/run/r1/file/",
        "/run/r1/file/a/b",
        "/run/r1/file/../../../outside",
        "/run/../file/outside",
        "/run/%2e%2e/file/outside",
        "/run//file/outside",
        "//run/r1/file/outside",
        "/run/r1/role/..%2Fx",
    ];
    for path in paths {
        for method in ["GET", "PUT", "DELETE", "POST"] {
            let answer = served.ask(method, path, b"changed");
            assert!(
                (400..=405).contains(&answer.status),
                "{method} {path}: {}",
                answer.text()
            );
            assert!(!answer.text().contains("secret"), "{method} {path}");
        }
    }
    for id in ["..", ".", "%2e%2e", "a%2Fb", ".x"] {
        let answer = served.ask("PUT", &format!("/run/{id}"), b"");
        assert_eq!(answer.status, 400, "{id}: {}", answer.text());
    }
    assert_eq!(fs::read_to_string(&outside).unwrap(), "secret");
    assert_eq!(served.ask("GET", "/run/r1/files", b"").json(), json!({}));
}

#[test]
fn a_wrong_method_is_told_the_right_ones() {
    let served = Served::claimed();
    for (method, path, allowed) in [
        ("POST", "/health", "GET"),
        ("GET", "/claim", "POST"),
        ("GET", "/end", "POST"),
        ("GET", "/run/r1", "PUT, DELETE"),
        ("POST", "/run/r1/files", "GET"),
        ("PUT", "/run/r1/file/a", "GET"),
        ("PUT", "/run/r1/role/a", "GET, POST, DELETE"),
    ] {
        let answer = served.ask(method, path, b"");
        refused(&answer, 405, "usage");
        assert!(
            answer.head.contains(&format!("allow: {allowed}\r\n")),
            "{}",
            answer.head
        );
    }
    refused(
        &served.ask("GET", "/run/r1/files?from=1", b""),
        400,
        "usage",
    );
    refused(&served.ask("GET", "/elsewhere", b""), 404, "usage");
}

#[test]
fn a_file_comes_as_it_is_from_any_byte_on() {
    let served = Served::claimed();
    fs::write(served.scratch().join("r1/my trace.csv"), "0123456789").unwrap();
    let expected = json!({"my trace.csv": 10});
    assert_eq!(served.ask("GET", "/run/r1/files", b"").json(), expected);
    for (from, text) in [("", "0123456789"), ("?from=4", "456789"), ("?from=10", "")] {
        let part = served.ask("GET", &format!("/run/r1/file/my%20trace.csv{from}"), b"");
        assert_eq!((part.status, part.text().as_str()), (200, text));
        assert!(part.head.contains("x-size: 10\r\n"), "{}", part.head);
    }
    refused(
        &served.ask("GET", "/run/r1/file/my%20trace.csv?from=11", b""),
        416,
        "usage",
    );
    for query in [
        "?from=",
        "?from=-1",
        "?from=1&from=2",
        "?to=3",
        "?from=99999999999999999999",
    ] {
        let answer = served.ask("GET", &format!("/run/r1/file/my%20trace.csv{query}"), b"");
        refused(&answer, 400, "usage");
    }
    refused(&served.ask("GET", "/run/r1/file/absent", b""), 404, "usage");
}

#[test]
fn a_run_begins_empty_and_leaves_nothing() {
    let mut served = Served::claimed();
    let bystander = served.folder.path().join("scratch/r1");
    fs::write(&bystander, "not the agent's").unwrap();
    fs::write(served.scratch().join("r1/a"), "x").unwrap();
    refused(&served.ask("GET", "/run/r2/files", b""), 404, "usage");
    assert_eq!(served.ask("PUT", "/run/r2", b"").status, 201);
    refused(&served.ask("GET", "/run/r1/files", b""), 404, "usage");
    assert_eq!(served.ask("GET", "/run/r2/files", b"").json(), json!({}));
    fs::write(served.scratch().join("r2/a"), "x").unwrap();
    assert_eq!(served.ask("PUT", "/run/r2", b"").status, 201);
    assert_eq!(served.ask("GET", "/run/r2/files", b"").json(), json!({}));
    assert_eq!(served.ask("DELETE", "/run/r2", b"").status, 204);
    refused(&served.ask("DELETE", "/run/r2", b""), 404, "usage");
    assert_eq!(fs::read_dir(served.scratch()).unwrap().count(), 0);
    served.ask("POST", "/end", b"");
    served.ended(SOON);
    assert!(!served.scratch().exists());
    assert_eq!(fs::read_to_string(bystander).unwrap(), "not the agent's");
}
