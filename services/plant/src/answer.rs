//! The responses of the API: made from a text or a message.

use std::fmt;

use hyper::{
    Response,
    body::Bytes,
    header::{self, HeaderMap, HeaderValue},
};
use serde::Serialize;

const FORM: &str = "application/x-www-form-urlencoded";
/// The kind of a JSON answer.
pub const JSON: &str = "application/json";
/// The kind of an answer in words.
pub const TEXT: &str = "text/plain; charset=utf-8";

/// A message in the form that the client accepts: a query, unless it asks for JSON.
pub fn message<M: fmt::Display + Serialize>(message: &M, headers: &HeaderMap) -> Response<Bytes> {
    let json = headers
        .get_all(header::ACCEPT)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .any(|range| {
            range
                .split(';')
                .next()
                .is_some_and(|kind| kind.trim() == JSON)
        });
    if json {
        as_json(message)
    } else {
        respond(FORM, message.to_string())
    }
}

/// A value as JSON.
pub(crate) fn as_json<V: Serialize>(value: &V) -> Response<Bytes> {
    let text = serde_json::to_string(value).expect("numbers and texts under fixed names");
    respond(JSON, text)
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
