//! Pages in control: who may command, what becomes of their rows, and that none
//! of it disturbs the loop.

use std::{
    fs,
    io::{Read, Write},
    net::{SocketAddr, TcpStream},
    sync::atomic::{AtomicBool, Ordering},
    thread,
    time::Duration,
};

use endpoint::{ArrivalOutcome, ArrivalRow, MessageOutcome, MessageRow};
use plant::Ready;

use crate::socket::{closing, open};
use crate::support::{
    PATIENCE, begin, claim, end, exchange, get, observe, post_rows, rows, send, status, until,
    with_plant,
};

const ROW: &str = "0,5,,,,1,,,,,missed,";

fn command(address: SocketAddr, token: &str, query: &str) -> u16 {
    let headers = [("Webloop-Session", token)];
    send(address, &format!("GET /closed?{query}"), &headers, "").status
}

#[test]
fn a_page_has_the_plant_to_itself_and_its_rows_and_report_are_kept() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name| folder.path().join(name);
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        assert_eq!(status(address)["state"], "free");
        let granted = claim(address, "a browser");
        assert_eq!(granted.status, 200, "{granted:?}");
        let grant: serde_json::Value = serde_json::from_str(&granted.body).expect("JSON");
        assert_eq!(
            (&grant["h_ns"], &grant["late"]),
            (&3_000_000.into(), &"apply".into())
        );
        let token = grant["session"].as_str().expect("a token");

        // The page commands, and nobody else does.
        assert_eq!(command(address, token, "seq=0&t_send_ns=5&u=0.5"), 200);
        for refused in [
            send(address, "GET /closed?seq=1&t_send_ns=5&u=9", &[], ""),
            send(address, "GET /open?seq=1&t_send_ns=5&u=9", &[], ""),
            claim(address, "another"),
        ] {
            assert_eq!(refused.status, 409, "{refused:?}");
            assert!(
                refused.body.contains("`a browser` is in control"),
                "{refused:?}"
            );
        }
        let stranger = "0123456789abcdef0123456789abcdef";
        for other in [stranger, "x", ""] {
            assert_eq!(command(address, other, "seq=1&t_send_ns=5&u=9"), 409);
        }
        assert_eq!(observe(address).u, 0.5);

        // Rows: each chunk once and in order.
        for (chunk, expected) in [(0, 204), (0, 204), (2, 409), (1, 204), (0, 204)] {
            let taken = post_rows(address, token, chunk, &format!("{ROW}\n{ROW}\n"));
            assert_eq!(taken.status, expected, "{taken:?}");
        }
        assert_eq!(post_rows(address, stranger, 2, ROW).status, 409);
        let seen = status(address);
        assert_eq!(seen["state"], "held");
        assert_eq!(seen["client"], "a browser");
        assert_eq!((&seen["commands"], &seen["rows"]), (&1.into(), &4.into()));
        // On disk while the session goes on.
        until("the rows are written", || {
            fs::read_to_string(path("messages.csv")).is_ok_and(|text| text.lines().count() == 5)
        });

        let wrong = end(address, token, "{outcome");
        assert_eq!(wrong.status, 400, "{wrong:?}");
        assert!(wrong.body.contains("not JSON"), "{wrong:?}");
        for _ in 0..2 {
            assert_eq!(
                end(address, token, "{\"outcome\": \"complete\"}").status,
                204
            );
        }
        assert_eq!(post_rows(address, token, 2, ROW).status, 409);
        let seen = status(address);
        assert_eq!(
            (&seen["state"], &seen["rows"]),
            (&"ended".into(), &4.into())
        );
        assert_eq!(command(address, token, "seq=1&t_send_ns=5&u=9"), 409);

        // The second has files of its own; it is still held when the plant stops.
        let second = begin(address, "another");
        assert_eq!(command(address, token, "seq=1&t_send_ns=5&u=9"), 409);
        assert_eq!(post_rows(address, &second, 0, ROW).status, 204);
        assert_eq!(end(address, token, "{}").status, 409);
    })
    .expect("a run without errors");

    assert_eq!((report.sessions, report.page_rows.rows), (2, 5));
    assert_eq!((report.arrivals, report.page_rows.overflow), (1, 0));
    let messages: Vec<MessageRow> = rows(&path("messages.csv"));
    assert_eq!(messages.len(), 4);
    assert_eq!(messages[3].outcome, MessageOutcome::Missed);
    assert_eq!(rows::<MessageRow>(&path("messages-2.csv")).len(), 1);
    let page = fs::read_to_string(path("page.json")).expect("the report");
    assert_eq!(page, "{\"outcome\": \"complete\"}");
    assert!(!path("page-2.json").exists());
}

#[test]
fn a_controller_without_a_session_keeps_pages_out_until_it_is_silent() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_plant(folder.path(), |Ready { address, .. }| {
        let plain = "GET /closed?seq=0&t_send_ns=5&u=0.5";
        // On a machine that stands still for 2 s it is silent indeed.
        until("the claim is refused", || {
            assert_eq!(send(address, plain, &[], "").status, 200);
            let refused = claim(address, "a browser");
            if refused.status == 200 {
                let grant: serde_json::Value = serde_json::from_str(&refused.body).expect("JSON");
                end(address, grant["session"].as_str().expect("a token"), "{}");
                return false;
            }
            assert!(
                refused.body.contains("without a session is in control"),
                "{refused:?}"
            );
            refused.status == 409
        });
        until("the claim is granted", || {
            claim(address, "a browser").status == 200
        });
    })
    .expect("a run without errors");
}

#[test]
fn what_is_wrong_with_a_body_is_named_and_nothing_of_it_is_taken() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        let json = ("Content-Type", "application/json");
        let claims = [
            ("{\"client\":", "does not say who"),
            ("{}", "missing field `client`"),
            ("{\"client\":\"a\",\"h\":1}", "unknown field `h`"),
            ("{\"client\":\"a\\nb\"}", "control character"),
            ("[\"a\",true]", "no JSON object"),
            (
                &format!("{{\"client\":\"{}\"}}", "a".repeat(81)),
                "81 characters",
            ),
        ];
        for (body, says) in claims {
            let refused = send(address, "POST /session", &[json], body);
            assert_eq!(refused.status, 400, "{body}: {refused:?}");
            assert!(refused.body.contains(says), "{body}: {refused:?}");
        }
        assert_eq!(send(address, "POST /session", &[], "{}").status, 415);
        assert_eq!(
            send(address, "POST /session?x=1", &[json], "{}").status,
            400
        );
        let put = send(address, "PUT /session", &[], "");
        assert_eq!(put.status, 405, "{put:?}");
        assert!(put.head.contains("allow: get, post"), "{put:?}");
        let got = send(address, "GET /session/rows", &[], "");
        assert_eq!(got.status, 405, "{got:?}");
        assert!(got.body.contains("use POST"), "{got:?}");

        let none = [("Content-Type", "text/csv")];
        let refused = send(address, "POST /session/rows?chunk=0", &none, ROW);
        assert_eq!(refused.status, 409, "{refused:?}");
        assert!(
            refused.body.contains("begin one with POST /session"),
            "{refused:?}"
        );

        let token = begin(address, "a browser");
        let session = ("Webloop-Session", token.as_str());
        let refused = post_rows(
            address,
            &token,
            0,
            &format!("{ROW}\n1,5,6,,,1,,,,,missed,\n"),
        );
        assert_eq!(refused.status, 400, "{refused:?}");
        assert!(
            refused.body.contains("line 2: field `t_send_ns`"),
            "{refused:?}"
        );
        for query in ["", "?chunk=", "?chunk=-1", "?chunk=0&chunk=0", "?n=0"] {
            let request = format!("POST /session/rows{query}");
            let refused = send(address, &request, &[session, none[0]], ROW);
            assert_eq!(refused.status, 400, "{query}: {refused:?}");
        }
        let refused = send(address, "POST /session/rows?chunk=0", &[session, json], ROW);
        assert_eq!(refused.status, 415, "{refused:?}");
        assert!(refused.body.contains("text/csv"), "{refused:?}");

        // Too long by its own word, and by its length alone.
        let head = format!(
            "POST /session/rows?chunk=0 HTTP/1.1\r\nHost: plant\r\n\
             Webloop-Session: {token}\r\nContent-Type: text/csv\r\n"
        );
        let declared = exchange(address, &format!("{head}Content-Length: 65537\r\n\r\n"));
        assert!(declared.starts_with("HTTP/1.1 413 "), "{declared}");
        let long = "0".repeat(65_537);
        let sent = format!("{head}Transfer-Encoding: chunked\r\n\r\n10001\r\n{long}\r\n");
        let streamed = exchange(address, &sent);
        assert!(streamed.starts_with("HTTP/1.1 413 "), "{streamed}");
        assert!(streamed.contains("65536 bytes"), "{streamed}");

        // As long as may be, in one piece.
        let whole = format!("{ROW}\n").repeat(65_536 / (ROW.len() + 1));
        let taken = post_rows(address, &token, 0, &whole);
        assert_eq!(taken.status, 204, "{taken:?}");
    })
    .expect("a run without errors");
    assert_eq!(report.page_rows.rows, 65_536 / (ROW.len() as u64 + 1));
    assert_eq!(report.refused, 20);
}

/// Commands one after the other on one connection, until told to stop; how many.
fn drive(address: SocketAddr, token: &str, done: &AtomicBool) -> u64 {
    let mut stream = TcpStream::connect(address).expect("the plant listens");
    stream
        .set_read_timeout(Some(PATIENCE))
        .expect("a valid timeout");
    let mut buffer = [0; 4096];
    let mut seq = 0;
    while !done.load(Ordering::Relaxed) {
        let request = format!(
            "GET /closed?seq={seq}&t_send_ns=0&u=0.1 HTTP/1.1\r\nHost: plant\r\nWebloop-Session: {token}\r\n\r\n"
        );
        stream
            .write_all(request.as_bytes())
            .expect("the plant reads");
        let read = stream.read(&mut buffer).expect("an answer");
        let answer = String::from_utf8_lossy(&buffer[..read]);
        assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
        assert!(answer.contains(&format!("\r\n\r\nseq={seq}&")), "{answer}");
        seq += 1;
        thread::sleep(Duration::from_millis(2));
    }
    seq
}

#[test]
fn a_running_loop_is_not_disturbed_by_rows_refusals_or_foreigners() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut sent = 0;
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        let token = begin(address, "a browser");
        let done = AtomicBool::new(false);
        thread::scope(|scope| {
            let driver = scope.spawn(|| drive(address, &token, &done));
            let whole = format!("{ROW}\n").repeat(3000);
            for chunk in 0..10 {
                assert_eq!(post_rows(address, &token, chunk, &whole).status, 204);
                assert_eq!(post_rows(address, &token, chunk + 1, "x").status, 400);
                assert_eq!(post_rows(address, &token, chunk + 9, &whole).status, 409);
                assert_eq!(claim(address, "another").status, 409);
                assert_eq!(command(address, "x", "seq=0&t_send_ns=0&u=9"), 409);
                let foreign = [("Origin", "http://example.org")];
                assert_eq!(
                    send(address, "POST /session/end", &foreign, "{}").status,
                    403
                );
                get(address, "/closed?seq=0&t_send_ns=0&u=9", "*/*");
            }
            done.store(true, Ordering::Relaxed);
            sent = driver.join().expect("the loop goes on");
        });
    })
    .expect("a run without errors");
    let arrivals: Vec<ArrivalRow> = rows(&folder.path().join("arrivals.csv"));
    assert_eq!(arrivals.len() as u64, sent);
    for (row, seq) in arrivals.iter().zip(0..) {
        assert_eq!(
            (row.seq, row.u, row.outcome),
            (seq, 0.1, ArrivalOutcome::Applied)
        );
    }
    assert_eq!(
        (report.page_rows.rows, report.page_rows.overflow),
        (30_000, 0)
    );
}

/// By the clock, for it is about what nobody asks for.
#[test]
fn a_silent_page_loses_the_plant_by_itself() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let report = with_plant(folder.path(), |Ready { address, .. }| {
        let token = begin(address, "a browser");
        assert_eq!(post_rows(address, &token, 0, ROW).status, 204);
        let mut socket = open(address, &format!("mode=closed&session={token}")).expect("a socket");
        let (code, reason) = closing(&mut socket);
        assert_eq!((code, reason.as_str()), (1008, "the session is over"));
        assert_eq!(status(address)["state"], "free");
        assert_eq!(post_rows(address, &token, 1, ROW).status, 409);
        begin(address, "another");
    })
    .expect("a run without errors");
    assert_eq!((report.sessions, report.page_rows.rows), (2, 1));
}
