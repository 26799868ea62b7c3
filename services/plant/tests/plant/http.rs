//! A plant over real sockets: what each request gets, and that a refused one
//! leaves the input as it was.

use std::{thread, time::Duration};

use endpoint::{Acknowledgement, ArrivalOutcome, ArrivalRow, State, TickRow};
use plant::{Config, Ready, serve_until};

use crate::support::{config, exchange, get, motor, observe, rows, with_plant};

#[test]
fn a_command_moves_the_plant_and_both_forms_of_answer_say_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        let (head, body) = get(address, "/closed?seq=7&t_send_ns=5&u=0.5", "*/*");
        assert!(head.starts_with("http/1.1 200"), "{head}");
        assert!(
            head.contains("content-type: application/x-www-form-urlencoded"),
            "{head}"
        );
        assert!(head.contains("cache-control: no-store"), "{head}");
        let state: State = body.parse().expect("a state");
        assert_eq!((state.seq, state.u.first), (7, 0.5));

        let (head, body) = get(
            address,
            "/open?seq=8&t_send_ns=6&u=9",
            "text/html, application/json;q=0.9",
        );
        assert!(head.contains("content-type: application/json"), "{head}");
        let acknowledgement: Acknowledgement = serde_json::from_str(&body).expect("JSON");
        assert_eq!(acknowledgement.seq, 8);

        // Within a few ticks the motor has begun to turn, driven by 0.5 still.
        thread::sleep(Duration::from_millis(50));
        let seen = observe(address);
        assert_eq!(seen.u, 0.5);
        assert!(seen.y.first > 0.0 && seen.tick > state.tick, "{seen:?}");

        assert_eq!(get(address, "/health", "*/*").1, "ok\n");
        let described: serde_json::Value =
            serde_json::from_str(&get(address, "/openapi.json", "*/*").1).expect("JSON");
        assert_eq!(described["openapi"], "3.1.0");
        let u = &described["components"]["schemas"]["State"]["properties"]["u"];
        assert_eq!(u["type"], "number", "this plant has one input");
        for path in described["paths"].as_object().expect("an object").keys() {
            let (head, _) = get(address, path, "*/*");
            assert!(!head.contains(" 404 "), "{path} is described and not there");
        }
    })
    .expect("a run without errors");

    assert_eq!((report.arrivals, report.arrival_rows.rows), (2, 2));
    assert_eq!(report.ticks, report.tick_rows.rows);
    let arrivals: Vec<ArrivalRow> = rows(&folder.path().join("arrivals.csv"));
    let outcomes: Vec<_> = arrivals
        .iter()
        .map(|row| (row.n, row.seq, row.outcome))
        .collect();
    assert_eq!(
        outcomes,
        [
            (0, 7, ArrivalOutcome::Applied),
            (1, 8, ArrivalOutcome::Acknowledged)
        ]
    );
    let ticks: Vec<TickRow> = rows(&folder.path().join("ticks.csv"));
    for (k, row) in (0..).zip(&ticks) {
        assert_eq!((row.k, row.t_due_ns), (k, report.start_ns + k * 3_000_000));
        assert!(row.t_tick_ns >= row.t_due_ns, "a tick is never early");
        assert_eq!(
            (row.u, row.seq),
            if row.seq.is_some() {
                (0.5, Some(7))
            } else {
                (0.0, None)
            }
        );
    }
}

#[test]
fn bad_requests_are_refused_by_name_and_leave_the_input_alone() {
    let good = "seq=2&t_send_ns=5&u=1";
    let plain = |target: &str| format!("GET {target} HTTP/1.1\r\nHost: plant\r\n\r\n");
    let closed = |query: &str| plain(&format!("/closed?{query}"));
    let method = |method: &str| format!("{method} /closed?{good} HTTP/1.1\r\nHost: plant\r\n\r\n");
    let headers = |headers: &str| format!("GET /closed?{good} HTTP/1.1\r\n{headers}\r\n");
    // What is sent, the status, and what the text says.
    let table = [
        (closed("seq=2&t_send_ns=5&u=NaN"), 400, "`u`: `NaN`"),
        (closed("seq=2&t_send_ns=5&u=-inf"), 400, "`u`: `-inf`"),
        (closed("seq=2&t_send_ns=5&u=1e999"), 400, "`u`"),
        (closed("seq=2&t_send_ns=5&u=fast"), 400, "`u`: `fast`"),
        (closed("seq=-2&t_send_ns=5&u=1"), 400, "`seq`: `-2`"),
        (closed("seq=2&t_send_ns=now&u=1"), 400, "`t_send_ns`: `now`"),
        (
            closed("seq=2&t_send_ns=5s&u=1"),
            400,
            "whole nanoseconds, without a unit",
        ),
        (closed("seq=2&t_send_ns=5&u=1e+3"), 400, "write %2B"),
        (closed("seq=2&t_send_ns=5&u=+1"), 400, "write %2B"),
        (closed("seq=+2&t_send_ns=5&u=1"), 400, "write %2B"),
        (plain("/state?full=1"), 400, "the query is not empty"),
        (plain("/health?v"), 400, "the query is not empty"),
        (plain("/openapi.json?v=3"), 400, "the query is not empty"),
        (plain("/session?s=1"), 400, "the query is not empty"),
        (closed("seq=2&t_send_ns=5"), 400, "`u` is missing"),
        (plain("/closed"), 400, "`u` is missing"),
        (
            closed("seq=2&t_send_ns=5&u=1&u=1"),
            400,
            "`u` appears twice",
        ),
        (closed("seq=2&t_send_ns=5&u=1&v=1"), 400, "`v` is unknown"),
        (closed(&format!("{good}{}", "0".repeat(1100))), 414, "1024"),
        (plain(&format!("/{}", "a".repeat(2000))), 414, "1024"),
        (plain(&format!("/{}", "a".repeat(70_000))), 431, ""),
        (plain("/motor"), 404, "/closed, /open, /state"),
        (method("POST"), 400, "in a body of JSON"),
        (method("PUT"), 405, "use GET, POST"),
        (method("HEAD"), 405, ""),
        (method("BREW"), 405, "BREW"),
        // Also with a body, which another method could have.
        (
            "GET /session/end HTTP/1.1\r\nHost: plant\r\nContent-Length: 2\r\n\r\n{}".to_owned(),
            405,
            "use POST",
        ),
        (headers(""), 400, "0 Host"),
        (headers("Host: a\r\nHost: b\r\n"), 400, "2 Host"),
        (
            headers("Host: a\r\nContent-Length: 3\r\n") + "u=1",
            413,
            "body",
        ),
        (
            headers("Host: a\r\nTransfer-Encoding: chunked\r\n") + "3\r\nu=1\r\n0\r\n\r\n",
            413,
            "body",
        ),
        (
            headers(&format!("Host: a\r\nX: {}\r\n", "x".repeat(20_000))),
            431,
            "",
        ),
        (
            headers(&format!("Host: a\r\n{}", "X: x\r\n".repeat(200))),
            431,
            "",
        ),
        (
            format!("GET http://other/closed?{good} HTTP/1.1\r\nHost: other\r\n\r\n"),
            400,
            "proxy",
        ),
        (
            "CONNECT other:80 HTTP/1.1\r\nHost: other\r\n\r\n".to_owned(),
            400,
            "proxy",
        ),
        ("seq=2&t_send_ns=5&u=1\r\n\r\n".to_owned(), 400, ""),
        (
            format!("GET /closed?{good} HTTP/1.1\r\nHost: plant\r\nbroken\r\n\r\n"),
            400,
            "",
        ),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let count = table.len();
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        get(address, "/closed?seq=1&t_send_ns=5&u=0.25", "*/*");
        for (request, status, says) in table {
            let response = exchange(address, &request);
            let start = request.get(..90).unwrap_or(&request);
            assert!(
                response.starts_with(&format!("HTTP/1.1 {status} ")),
                "{start}: {response}"
            );
            assert!(response.contains(says), "{start}: {response}");
            assert_eq!(observe(address).u, 0.25, "{start} changed the input");
        }
        let allow = exchange(address, &method("PUT")).to_ascii_lowercase();
        assert!(allow.contains("allow: get"), "{allow}");
    })
    .expect("a run without errors");
    assert_eq!(report.arrivals, 1);
    // Those that are not HTTP at all are refused before they are counted.
    assert!(
        report.refused > 20 && report.refused <= count as u64 + 1,
        "{}",
        report.refused
    );
}

#[test]
fn one_connection_carries_many_commands_in_a_row_and_at_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        let pipelined: String = (0..50)
            .map(|seq| {
                format!("GET /closed?seq={seq}&t_send_ns=0&u=0.1 HTTP/1.1\r\nHost: plant\r\n\r\n")
            })
            .collect();
        assert_eq!(
            exchange(address, &pipelined)
                .matches("HTTP/1.1 200")
                .count(),
            50
        );
    })
    .expect("a run without errors");
    assert_eq!((report.arrivals, report.connections), (50, 1));
}

/// RFC 9112, 9.6 and 11.2: what follows a request that ends its connection, or one for somebody else, is not for this
/// plant.
#[test]
fn nothing_is_done_behind_a_last_request_or_one_for_another_host() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let command = "GET /closed?u=1 HTTP/1.1\r\nHost: plant\r\n\r\n";
    with_plant(folder.path(), |Ready { address, .. }| {
        for (before, status) in [
            (
                "GET /state HTTP/1.1\r\nHost: plant\r\nConnection: close\r\n\r\n",
                200,
            ),
            ("GET /state HTTP/1.1\r\nHost: example.org\r\n\r\n", 421),
            ("GET /state HTTP/1.1\r\nHost: a b\r\n\r\n", 400),
            (
                "GET /state HTTP/1.1\r\nHost: plant\r\nHost: plant\r\n\r\n",
                400,
            ),
            (
                "GET /closed?u=1 HTTP/1.0\r\nConnection: keep-alive\r\n\r\n",
                400,
            ),
            (
                "GET http://example.org/ HTTP/1.1\r\nHost: plant\r\n\r\n",
                400,
            ),
        ] {
            let answer = exchange(address, &format!("{before}{command}"));
            let is_one = answer.matches("HTTP/1.").count() == 1;
            assert!(
                is_one && answer.contains(&format!(" {status} ")),
                "{before}: {answer}"
            );
            assert!(
                answer.contains("connection: close") || status == 200,
                "{answer}"
            );
            assert_eq!(observe(address).u, 0.0, "{before}");
        }
        // And a plus that is written as one is one.
        assert!(exchange(address, &command.replace("u=1", "u=%2B5e%2B1")).contains(" 200 "));
        assert_eq!(observe(address).u, 50.0);
        let upgrade = get(address, "/socket?mode=open", "*/*").0;
        assert!(upgrade.contains("upgrade: websocket"), "{upgrade}");
    })
    .expect("a run without errors");
}

#[test]
fn what_cannot_be_had_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let never = || std::future::pending::<std::io::Result<()>>();
    let refuse = |config: &Config| {
        let error = serve_until(config, motor(config), never(), |_| {
            panic!("it cannot be ready")
        });
        error.expect_err("it cannot run").to_string()
    };

    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = taken.local_addr().expect("bound");
    let error = refuse(&Config {
        listen: address,
        ..config(folder.path())
    });
    assert!(error.contains(&address.to_string()), "{error}");
    assert!(
        !folder.path().join("ticks.csv").exists(),
        "nothing is left of it"
    );

    std::fs::write(folder.path().join("file"), "").expect("a writable folder");
    let error = refuse(&config(&folder.path().join("file")));
    assert!(error.contains("ticks.csv"), "{error}");

    std::fs::write(folder.path().join("arrivals.csv"), "old").expect("a writable folder");
    let error = refuse(&config(folder.path()));
    assert!(error.contains("arrivals.csv"), "{error}");
}

/// The stop may come first; the plant still ends in good order.
#[test]
fn a_plant_that_is_stopped_at_once_leaves_files_with_headers() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at_once = std::future::ready(Ok(()));
    let config = config(folder.path());
    let report = serve_until(&config, motor(&config), at_once, |_| {}).expect("no errors");
    assert_eq!(report.arrivals, 0);
    let text = std::fs::read_to_string(folder.path().join("arrivals.csv")).expect("the file");
    assert_eq!(text, "n,seq,t_send_ns,t_arrive_ns,tick,u,outcome\n");
}
