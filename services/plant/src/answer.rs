//! The responses of the API: made from a text or a message, and written.

use std::{cell::RefCell, fmt, rc::Rc, time::SystemTime};

use endpoint::http::{
    framing::{Afterwards, Protocol},
    lines::{Lines, text},
};
use hyper::{
    Response, StatusCode,
    body::Bytes,
    header::{self, HeaderValue},
};
use serde::Serialize;

const FORM: &str = "application/x-www-form-urlencoded";
/// The kind of a JSON answer.
pub const JSON: &str = "application/json";
/// The kind of an answer in words.
pub const TEXT: &str = "text/plain; charset=utf-8";

/// A message in the form that the client accepts: a query, unless it asks for JSON.
pub fn message<M: fmt::Display + Serialize>(message: &M, lines: Lines<'_>) -> Response<Bytes> {
    let Short { kind, body } = Short::new(message, message.to_string(), lines);
    respond(kind, body)
}

/// Whether the headers `Accept` ask for JSON: they name it, and want nothing else that a message can be more (RFC 9110,
/// 12.5.1).
fn is_json<'a>(accepted: impl Iterator<Item = &'a [u8]>) -> bool {
    let (mut json, mut form) = (None, None);
    let ranges = accepted.filter_map(text);
    for range in ranges.flat_map(|value| value.split(',')) {
        let (kind, parameters) = range.split_once(';').unwrap_or((range, ""));
        let kind = kind.trim();
        // What is more specific counts.
        let (wanted, rank) = if kind.eq_ignore_ascii_case(JSON) {
            (&mut json, 2)
        } else if kind.eq_ignore_ascii_case(FORM) {
            (&mut form, 2)
        } else if kind.eq_ignore_ascii_case("application/*") {
            (&mut form, 1)
        } else if kind == "*/*" {
            (&mut form, 0)
        } else {
            continue;
        };
        let Some(weight) = weight(parameters) else {
            continue;
        };
        *wanted = (*wanted).max(Some((rank, weight)));
    }
    let weight = |wanted: Option<(u8, u16)>| wanted.map_or(0, |(_, weight)| weight);
    weight(json) > 0 && weight(json) >= weight(form)
}

/// The weight among a range's parameters, in thousandths; `None` if it is none.
fn weight(parameters: &str) -> Option<u16> {
    for parameter in parameters.split(';') {
        let (name, value) = parameter.split_once('=').unwrap_or((parameter, ""));
        if !name.trim().eq_ignore_ascii_case("q") {
            continue;
        }
        let value = value.trim();
        let (whole, part) = value.split_once('.').unwrap_or((value, ""));
        let is_digits = part.bytes().all(|byte| byte.is_ascii_digit());
        if !matches!(whole, "0" | "1") || part.len() > 3 || !is_digits {
            return None;
        }
        let digits = part.bytes().chain(*b"000").take(3);
        let part = digits.fold(0, |sum, digit| 10 * sum + u16::from(digit - b'0'));
        return Some(u16::from(whole == "1") * 1000 + part).filter(|all| *all <= 1000);
    }
    Some(1000)
}

/// A message as a plant answers most requests: it is written without a [`Response`].
#[derive(Debug)]
pub(crate) struct Short {
    kind: &'static str,
    body: String,
}

/// The form in which a client wants a message.
#[derive(Clone, Copy, Debug)]
pub(crate) enum AnswerForm {
    Query,
    Json,
}

impl AnswerForm {
    /// That of a request with these lines.
    pub(crate) fn of(lines: Lines<'_>) -> Self {
        if is_json(lines.all("accept")) {
            Self::Json
        } else {
            Self::Query
        }
    }
}

impl Short {
    /// The message for a request with these lines; `text` is the message as a query.
    pub(crate) fn new(message: &impl Serialize, text: String, lines: Lines<'_>) -> Self {
        Self::in_form(message, text, AnswerForm::of(lines))
    }

    /// The message in a form; `text` is the message as a query.
    pub(crate) fn in_form(message: &impl Serialize, text: String, form: AnswerForm) -> Self {
        match form {
            AnswerForm::Json => Self {
                kind: JSON,
                body: json(message),
            },
            AnswerForm::Query => Self {
                kind: FORM,
                body: text,
            },
        }
    }

    /// As it is sent.
    pub(crate) fn written(&self, protocol: Protocol, then: Afterwards) -> Vec<u8> {
        let lines = [
            "content-type: ",
            self.kind,
            "\r\ncache-control: no-store\r\n",
        ];
        let (lines, body) = (lines.map(str::as_bytes), self.body.as_bytes());
        endpoint::http::written::written(
            StatusCode::OK,
            protocol,
            Some(then),
            &lines,
            &date(),
            body,
        )
    }
}

/// A response as it is sent.
pub fn written(response: &Response<Bytes>, protocol: Protocol, then: Afterwards) -> Vec<u8> {
    let headers = response.headers();
    let lines = headers
        .iter()
        .flat_map(|(name, value)| [name.as_str().as_bytes(), b": ", value.as_bytes(), b"\r\n"]);
    let lines: Vec<&[u8]> = lines.collect();
    let says = then == Afterwards::Close && headers.contains_key(header::CONNECTION);
    let (status, then) = (response.status(), (!says).then_some(then));
    endpoint::http::written::written(status, protocol, then, &lines, &date(), response.body())
}

/// The time of day, written once a second.
fn date() -> Rc<str> {
    thread_local! {
        static DATE: RefCell<(u64, Rc<str>)> = RefCell::new((u64::MAX, "".into()));
    }
    let now = SystemTime::now();
    let s = now
        .duration_since(SystemTime::UNIX_EPOCH)
        .map_or(0, |since| since.as_secs());
    DATE.with_borrow_mut(|(of_s, text)| {
        if *of_s != s {
            (*of_s, *text) = (s, httpdate::fmt_http_date(now).into());
        }
        Rc::clone(text)
    })
}

/// A value as JSON.
pub(crate) fn as_json<V: Serialize>(value: &V) -> Response<Bytes> {
    respond(JSON, json(value))
}

fn json<V: Serialize>(value: &V) -> String {
    serde_json::to_string(value).expect("numbers and texts under fixed names")
}

/// A response with this body.
pub fn respond(kind: &'static str, body: impl Into<Bytes>) -> Response<Bytes> {
    let mut response = Response::new(body.into());
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    // A GET that moves a plant must reach it, and each answer holds only for its moment.
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 9110, 12.4.2 and 12.5.1.
    #[test]
    fn json_is_for_who_names_it_and_wants_nothing_more() {
        for (accept, expected) in [
            ("application/json", true),
            ("Application/JSON", true),
            ("application/json;q=0.5", true),
            ("APPLICATION/JSON; Q=0.5", true),
            ("application/json ; charset=utf-8 ; q=1.000", true),
            ("application/json, text/plain, */*", true),
            ("text/html, application/json;q=0.9", true),
            ("application/json;q=0.9, */*;q=0.1", true),
            ("application/json;q=0.001", true),
            ("", false),
            ("*/*", false),
            ("application/*", false),
            ("text/html", false),
            ("application/jsonp", false),
            ("application/json;q=0", false),
            ("application/json;q=0.000, */*", false),
            ("application/json;q=0.5, */*", false),
            (
                "application/json;q=0.5, application/x-www-form-urlencoded",
                false,
            ),
            (
                "application/x-www-form-urlencoded;q=0.8, application/json;q=0.2",
                false,
            ),
            ("application/json;q=2", false),
            ("application/json;q=1.001", false),
            ("application/json;q=0.0001", false),
            ("application/json;q=x", false),
            ("application/json;q=-1", false),
            ("application/json;q=", false),
        ] {
            assert_eq!(
                is_json([accept.as_bytes()].into_iter()),
                expected,
                "{accept}"
            );
        }
        let both = [b"*/*;q=0.1".as_slice(), b"application/json"];
        assert!(is_json(both.into_iter()), "two lines are one list");
    }
}
