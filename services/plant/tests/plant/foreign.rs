//! Requests in the name of another host, from another page, or with another token: whatever they ask, they get a
//! refusal, the plant and its session stay as they were, and no token is told.

use std::fs;

use plant::Ready;

use crate::support::{begin, config, exchange, observe, status, with_config};

/// Header lines with the plant's own host and origin, `TOKEN` for the session's, and the status that they get.
const LINES: [(&str, u16); 62] = [
    // Other names that may lead here.
    ("Host: example.org", 421),
    ("Host: example.org:80", 421),
    ("Host: EXAMPLE.ORG", 421),
    ("Host: plant.example.org", 421),
    ("Host: localhost.example.org", 421),
    ("Host: 127.0.0.1.example.org", 421),
    ("Host: aplant", 421),
    ("Host: plant.", 421),
    ("Host: localhost.", 421),
    ("Host: 127.1", 421),
    ("Host: 2130706433", 421),
    ("Host: 0x7f.0.0.1", 421),
    ("Host: xn--plnt-5qa", 421),
    ("Host: example.org\r\nOrigin: http://example.org", 421),
    ("Host: example.org\r\nOrigin: http://plant", 421),
    ("Host: example.org\r\nX-Forwarded-Host: plant", 421),
    ("Host: example.org\r\nForwarded: host=plant", 421),
    ("Host: example.org\r\nX-Host: plant", 421),
    // What is no name.
    ("Host:", 400),
    ("Host: :80", 400),
    ("Host: plant::", 400),
    ("Host: plant:x", 400),
    ("Host: plant:65536", 400),
    ("Host: plant example.org", 400),
    ("Host: plant,example.org", 400),
    ("Host: plant@example.org", 400),
    ("Host: plant/example.org", 400),
    ("Host: plant#example.org", 400),
    ("Host: plant?example.org", 400),
    ("Host: plant\\example.org", 400),
    ("Host: http://plant", 400),
    ("Host: [::1", 400),
    ("Host: ::1", 400),
    ("Host: plant\r\nHost: example.org", 400),
    ("Host: example.org\r\nHost: plant", 400),
    ("X: y", 400),
    // Other pages.
    ("Host: plant\r\nOrigin: http://example.org", 403),
    ("Host: plant\r\nOrigin: https://plant", 403),
    ("Host: plant\r\nOrigin: http://plant:81", 403),
    ("Host: plant\r\nOrigin: http://plant.example.org", 403),
    ("Host: plant\r\nOrigin: http://plant@example.org", 403),
    ("Host: plant\r\nOrigin: null", 403),
    ("Host: plant\r\nOrigin:", 403),
    ("Host: plant\r\nOrigin: *", 403),
    ("Host: plant\r\nOrigin: file://", 403),
    (
        "Host: plant\r\nOrigin: http://plant\r\nOrigin: http://example.org",
        403,
    ),
    ("Host: plant\r\nOrigin: http://localhost", 403),
    ("Host: plant\r\nReferer: http://example.org/", 403),
    ("Host: plant\r\nReferer: http://plant.example.org/", 403),
    ("Host: plant\r\nReferer: http://plant@example.org/", 403),
    ("Host: plant\r\nReferer: about:blank", 403),
    ("Host: plant\r\nSec-Fetch-Site: cross-site", 403),
    ("Host: plant\r\nSec-Fetch-Site: same-site", 403),
    (
        "Host: plant\r\nSec-Fetch-Site: same-origin\r\nOrigin: http://example.org",
        403,
    ),
    (
        "Host: plant\r\nSec-Fetch-Site: same-origin, cross-site",
        403,
    ),
    // Other tokens.
    (
        "Host: plant\r\nWebloop-Session: 0123456789abcdef0123456789abcdef",
        409,
    ),
    ("Host: plant\r\nWebloop-Session:", 409),
    ("Host: plant\r\nWebloop-Session: TOKEN0", 409),
    (
        "Host: plant\r\nWebloop-Session: TOKEN\r\nWebloop-Session: TOKEN",
        409,
    ),
    ("Host: plant\r\nWebloop-Session: TOKEN, TOKEN", 409),
    ("Host: plant\r\nAuthorization: Bearer TOKEN", 409),
    ("Host: plant\r\nCookie: session=TOKEN", 409),
];

/// What each of them asks: all that changes something.
const REQUESTS: [(&str, &str); 5] = [
    ("GET /closed?u=9", ""),
    ("GET /open?u=9", ""),
    ("POST /session/rows?chunk=0", "text/csv"),
    ("POST /session/end", "application/json"),
    ("OPTIONS /closed", ""),
];

#[test]
fn nothing_foreign_moves_the_plant_or_ends_its_session_and_no_token_is_told() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut secret = String::new();
    let report = with_config(config(folder.path()), |Ready { address, .. }| {
        let token = begin(address, "a browser");
        let before = status(address);
        for (lines, status) in LINES {
            for (request, kind) in REQUESTS {
                // A page asks first whether it may; without a session there is nothing to refuse it by.
                let is_asking = request.starts_with("OPTIONS");
                let expected = if is_asking && status == 409 { 405 } else { status };
                let mut text = format!(
                    "{request} HTTP/1.1\r\n{}\r\nConnection: close\r\n",
                    lines.replace("TOKEN", &token)
                );
                if is_asking {
                    text += "Access-Control-Request-Method: GET\r\nAccess-Control-Request-Headers: webloop-session\r\n";
                }
                if !kind.is_empty() {
                    text += &format!("Content-Type: {kind}\r\nContent-Length: 2\r\n");
                }
                text += "\r\n";
                if !kind.is_empty() {
                    text += "{}";
                }
                let answer = exchange(address, &text);
                assert!(
                    answer.starts_with(&format!("HTTP/1.1 {expected} ")),
                    "{text}: {answer}"
                );
                let lower = answer.to_ascii_lowercase();
                assert!(!lower.contains("access-control"), "{text}: {answer}");
                assert!(!answer.contains(&token), "{text}: {answer}");
            }
        }
        let mut after = status(address);
        after["idle_ms"] = before["idle_ms"].clone();
        assert_eq!(after, before);
        assert_eq!(observe(address).u, 0.0);
        secret = token;
    })
    .expect("a run without errors");
    assert_eq!((report.arrivals, report.sessions), (0, 1));
    assert_eq!(report.refused, (LINES.len() * REQUESTS.len()) as u64);
    for file in fs::read_dir(folder.path()).expect("the folder") {
        let path = file.expect("a file").path();
        let text = fs::read_to_string(&path).expect("text");
        assert!(!text.contains(&secret), "{}", path.display());
    }
    assert!(!format!("{report:?}").contains(&secret));
    println!(
        "row 20: plant, {} lines in {} requests: all refused, no change of state, no token in answers, files or report",
        LINES.len(),
        REQUESTS.len()
    );
}
