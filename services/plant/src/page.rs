//! The page's files as responses.
//!
//! The headers isolate the page from all others, which browsers require for their finest clock and for shared
//! memory, and restrict it to its own files and its own plant. The crate `browser` has the files.

use browser::page::FILES;
use hyper::{
    Response,
    body::Bytes,
    header::{self, HeaderName, HeaderValue},
};

use endpoint::http::lines::{Lines, text};

use crate::answer::respond;

/// Headers of every file.
const HEADERS: [(HeaderName, &str); 5] = [
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "same-origin"),
    (
        HeaderName::from_static("cross-origin-opener-policy"),
        "same-origin",
    ),
    (
        HeaderName::from_static("cross-origin-embedder-policy"),
        "require-corp",
    ),
    (
        HeaderName::from_static("cross-origin-resource-policy"),
        "same-origin",
    ),
];

/// The file at `path`, if there is one.
pub(crate) fn file(path: &str, lines: Lines<'_>) -> Option<Response<Bytes>> {
    let file = FILES.iter().find(|file| file.path == path)?;
    let mut response = respond(file.kind, file.bytes);
    for (name, value) in HEADERS {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    }
    response
        .headers_mut()
        .insert(header::CONTENT_SECURITY_POLICY, policy(lines));
    Some(response)
}

/// What the page may load and connect to. Not every browser applies `'self'` to `ws:` too, so the
/// plant is named.
fn policy(lines: Lines<'_>) -> HeaderValue {
    let host = lines.first("host").and_then(text).filter(|host| {
        host.bytes()
            .all(|b| b.is_ascii_alphanumeric() || b".:-[]".contains(&b))
    });
    let socket = host.map(|host| format!(" ws://{host}")).unwrap_or_default();
    let policy = format!(
        "default-src 'none'; script-src 'self'; worker-src 'self'; style-src 'self'; \
         img-src 'self' data: blob:; connect-src 'self'{socket}; base-uri 'none'; \
         form-action 'none'; frame-ancestors 'none'"
    );
    HeaderValue::try_from(policy).expect("letters and signs of ASCII")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::openapi::PATHS;

    #[test]
    fn every_file_has_a_path_of_its_own() {
        let mut paths = BTreeSet::from(PATHS);
        for file in FILES {
            assert!(file.path.starts_with('/'), "{}", file.path);
            assert!(paths.insert(file.path), "{} is there twice", file.path);
        }
        assert!(paths.contains("/"), "the page itself");
    }

    #[test]
    fn the_policy_names_the_plant_and_repeats_no_nonsense() {
        let policy = |host: &'static str| {
            let line = httparse::Header {
                name: "Host",
                value: host.as_bytes(),
            };
            let policy = policy(Lines(&[line]));
            policy.to_str().expect("ASCII").to_owned()
        };
        assert!(policy("10.77.0.2:8000").contains("connect-src 'self' ws://10.77.0.2:8000;"));
        assert!(policy("a; script-src *").contains("connect-src 'self';"));
    }
}
