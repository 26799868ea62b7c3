//! The responses of the API: made from a text or a message.

use std::{cell::RefCell, fmt, rc::Rc, time::SystemTime};

use hyper::{
    Response,
    body::Bytes,
    header::{self, HeaderMap, HeaderValue},
};
use serde::Serialize;

use crate::head::{self, Lines};

const FORM: &str = "application/x-www-form-urlencoded";
/// The kind of a JSON answer.
pub const JSON: &str = "application/json";
/// The kind of an answer in words.
pub const TEXT: &str = "text/plain; charset=utf-8";

/// A message in the form that the client accepts: a query, unless it asks for JSON.
pub fn message<M: fmt::Display + Serialize>(message: &M, headers: &HeaderMap) -> Response<Bytes> {
    let accepted = headers.get_all(header::ACCEPT).iter();
    if is_json(accepted.map(HeaderValue::as_bytes)) {
        as_json(message)
    } else {
        respond(FORM, message.to_string())
    }
}

/// Whether one of the headers `Accept` asks for JSON.
fn is_json<'a>(mut accepted: impl Iterator<Item = &'a [u8]>) -> bool {
    let is_json = |range: &str| {
        range
            .split(';')
            .next()
            .is_some_and(|kind| kind.trim() == JSON)
    };
    accepted.any(|value| head::text(value).is_some_and(|value| value.split(',').any(is_json)))
}

/// A message as a plant answers most requests: it is written without a [`Response`].
#[derive(Debug)]
pub(crate) struct Short {
    kind: &'static str,
    body: String,
}

impl Short {
    /// [`message`], for the lines of a head; `text` is the message as a query.
    pub(crate) fn new(message: &impl Serialize, text: String, lines: Lines<'_>) -> Self {
        if is_json(lines.all("accept")) {
            let kind = JSON;
            let body = json(message);
            return Self { kind, body };
        }
        Self {
            kind: FORM,
            body: text,
        }
    }

    /// As it is sent.
    pub(crate) fn written(&self, is_new: bool, keeps: bool) -> Vec<u8> {
        let mut text = Vec::with_capacity(256 + self.body.len());
        let mut digits = [0; 20];
        text.extend_from_slice(if is_new {
            b"HTTP/1.1 200 OK\r\ncontent-type: "
        } else {
            b"HTTP/1.0 200 OK\r\ncontent-type: "
        });
        for part in [
            self.kind.as_bytes(),
            b"\r\ncache-control: no-store\r\ncontent-length: ",
            decimal(self.body.len(), &mut digits),
            match (keeps, is_new) {
                (false, true) => b"\r\nconnection: close\r\ndate: ",
                (true, false) => b"\r\nconnection: keep-alive\r\ndate: ",
                _ => b"\r\ndate: ",
            },
            date().as_bytes(),
            b"\r\n\r\n",
            self.body.as_bytes(),
        ] {
            text.extend_from_slice(part);
        }
        text
    }
}

/// A number in decimal digits.
fn decimal(mut number: usize, digits: &mut [u8; 20]) -> &[u8] {
    let mut at = digits.len();
    loop {
        at -= 1;
        digits[at] = b'0' + (number % 10) as u8;
        number /= 10;
        if number == 0 {
            return &digits[at..];
        }
    }
}

/// The time of day, written once a second.
pub(crate) fn date() -> Rc<str> {
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
