//! The page's files, and pages of others.

use plant::Ready;

use crate::support::{observe, send, with_plant};

#[test]
fn foreign_pages_are_turned_away_from_everything() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_plant(folder.path(), |Ready { address, .. }| {
        let (own, query) = (format!("http://{address}"), "?seq=0&t_send_ns=5&u=9");
        for foreign in [
            ("Origin", "http://example.org"),
            ("Origin", "null"),
            ("Referer", "http://example.org/page"),
            ("Sec-Fetch-Site", "cross-site"),
            ("Sec-Fetch-Site", "same-site"),
        ] {
            for request in [
                "GET /".to_owned(),
                format!("GET /closed{query}"),
                format!("GET /open{query}"),
                "GET /state".to_owned(),
                "GET /socket?mode=closed".to_owned(),
                "POST /session".to_owned(),
                "POST /session/rows?chunk=0".to_owned(),
                "POST /session/end".to_owned(),
                "GET /nothing".to_owned(),
            ] {
                let refused = send(address, &request, &[foreign], "");
                assert_eq!(refused.status, 403, "{request} {foreign:?}: {refused:?}");
                let header = foreign.0.to_ascii_lowercase();
                assert!(refused.body.contains(&header), "{request}: {refused:?}");
            }
        }
        assert_eq!(observe(address).u, 0.0);
        let headers = [
            ("Origin", own.as_str()),
            ("Referer", &format!("{own}/?run=1")),
            ("Sec-Fetch-Site", "same-origin"),
            ("Content-Type", "application/json; charset=utf-8"),
        ];
        let granted = send(address, "POST /session", &headers, "{\"client\":\"a\"}");
        assert_eq!(granted.status, 200, "{granted:?}");
    })
    .expect("a run without errors");
}

#[test]
fn the_page_is_served_isolated_from_all_others() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_plant(folder.path(), |Ready { address, .. }| {
        for file in browser::page::FILES {
            let response = send(address, &format!("GET {}", file.path), &[], "");
            assert_eq!(response.status, 200, "{}", file.path);
            assert_eq!(response.body.as_bytes(), file.bytes, "{}", file.path);
            for line in [
                &format!("content-type: {}", file.kind),
                "cross-origin-opener-policy: same-origin",
                "cross-origin-embedder-policy: require-corp",
                "cross-origin-resource-policy: same-origin",
                "x-content-type-options: nosniff",
                "cache-control: no-store",
                "content-security-policy: default-src 'none';",
            ] {
                assert!(response.head.contains(line), "{}: no {line}", file.path);
            }
            let post = send(address, &format!("POST {}", file.path), &[], "");
            assert_eq!(post.status, 405, "{}", file.path);
        }
    })
    .expect("a run without errors");
}
