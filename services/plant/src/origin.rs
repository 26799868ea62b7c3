//! Foreign pages: the browser's information on the origin of a request.
//!
//! Any page that a person has open can make the browser send requests to any address, also to this
//! plant, where a GET moves it. Browsers say which page sent a request. A request without this
//! information does not come from a browser and is permitted.

use endpoint::http::lines::Lines;

/// Why a request is foreign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{header}` says that the request comes from another page; only this plant's own page may ask from a browser, so open that"
)]
pub(crate) struct Foreign {
    /// The header that shows it.
    header: &'static str,
}

/// Rejects requests from a page of another origin than `host`.
pub(crate) fn check(lines: Lines<'_>, host: Option<&[u8]>) -> Result<(), Foreign> {
    let all = |name: &'static str, own: &dyn Fn(&[u8]) -> bool| {
        if lines.all(name).all(own) {
            Ok(())
        } else {
            Err(Foreign { header: name })
        }
    };
    all("origin", &|value| rest(value, host) == Some(b""))?;
    all("sec-fetch-site", &|value| {
        value == b"same-origin" || value == b"none"
    })?;
    all("referer", &|value| match rest(value, host) {
        Some([]) | Some([b'/' | b'?' | b'#', ..]) => true,
        Some(_) | None => false,
    })
}

/// The part of `address` after `http://<host>`, if it begins like that.
fn rest<'a>(address: &'a [u8], host: Option<&[u8]>) -> Option<&'a [u8]> {
    let (start, rest) = address.split_at_checked(b"http://".len())?;
    let (named, rest) = rest.split_at_checked(host?.len())?;
    let own = start.eq_ignore_ascii_case(b"http://") && named.eq_ignore_ascii_case(host?);
    own.then_some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judge(lines: &[(&'static str, &'static str)]) -> Option<&'static str> {
        let lines: Vec<_> = lines
            .iter()
            .map(|(name, value)| httparse::Header {
                name,
                value: value.as_bytes(),
            })
            .collect();
        let lines = Lines(&lines);
        check(lines, lines.first("host"))
            .err()
            .map(|foreign| foreign.header)
    }

    #[test]
    fn only_the_plants_own_page_and_what_is_no_page_may_ask() {
        let host = ("host", "10.77.0.2:8000");
        // One header besides Host, and whether the request passes.
        let table = [
            ("accept", "*/*", true),
            ("origin", "http://10.77.0.2:8000", true),
            ("origin", "HTTP://10.77.0.2:8000", true),
            ("origin", "https://10.77.0.2:8000", false),
            ("origin", "http://10.77.0.2", false),
            ("origin", "http://10.77.0.2:80", false),
            ("origin", "http://10.77.0.2:80000", false),
            ("origin", "http://10.77.0.2:8000/", false),
            ("origin", "http://10.77.0.2:8000.example.org", false),
            ("origin", "http://example.org", false),
            ("origin", "null", false),
            ("origin", "", false),
            ("sec-fetch-site", "same-origin", true),
            ("sec-fetch-site", "none", true),
            ("sec-fetch-site", "same-site", false),
            ("sec-fetch-site", "cross-site", false),
            ("sec-fetch-site", "", false),
            ("referer", "http://10.77.0.2:8000/", true),
            ("referer", "http://10.77.0.2:8000", true),
            ("referer", "http://10.77.0.2:8000/?run=1", true),
            ("referer", "http://10.77.0.2:8000?run=1", true),
            ("referer", "http://10.77.0.2:80001/", false),
            ("referer", "http://10.77.0.2:8000@example.org/", false),
            ("referer", "http://10.77.0.2:8000.example.org/", false),
            (
                "referer",
                "http://example.org/http://10.77.0.2:8000/",
                false,
            ),
            ("referer", "about:blank", false),
        ];
        for (name, value, passes) in table {
            let expected = (!passes).then_some(name);
            assert_eq!(judge(&[host, (name, value)]), expected, "{name}: {value}");
        }
    }

    #[test]
    fn one_foreign_word_outweighs_all_others() {
        let own = ("origin", "http://plant");
        let host = ("host", "PLANT");
        assert_eq!(judge(&[host, own]), None);
        assert_eq!(
            judge(&[own]),
            Some("origin"),
            "without a host nothing is its own"
        );
        assert_eq!(judge(&[host, own, ("origin", "http://a")]), Some("origin"));
        let foreign = ("sec-fetch-site", "cross-site");
        assert_eq!(judge(&[host, own, foreign]), Some("sec-fetch-site"));
    }
}
