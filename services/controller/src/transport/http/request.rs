//! A request to the plant, and how it is written.

use std::fmt::Write;

/// The header that carries a session's token.
const SESSION: &str = "webloop-session";

/// Any form of an answer will do.
pub(crate) const ANY: &str = "*/*";

/// A request to the plant.
#[derive(Debug)]
pub(crate) struct Request<'a> {
    /// Its path, and its query if it has one.
    pub(crate) target: String,
    /// The session to which it belongs.
    pub(crate) token: Option<&'a str>,
    /// JSON to post; without it, the request is a GET.
    pub(crate) body: Option<&'a str>,
    /// In which forms it may be answered.
    pub(crate) accept: &'static str,
}

impl Request<'_> {
    /// As it is sent to this host.
    pub(super) fn text(&self, host: &str) -> String {
        let mut text = String::with_capacity(256);
        let method = if self.body.is_some() { "POST" } else { "GET" };
        for part in [method, " ", &self.target, " HTTP/1.1\r\n"] {
            text.push_str(part);
        }
        if let Some(token) = self.token {
            for part in [SESSION, ": ", token, "\r\n"] {
                text.push_str(part);
            }
        }
        for part in ["accept: ", self.accept, "\r\nhost: ", host, "\r\n"] {
            text.push_str(part);
        }
        let body = self.body.unwrap_or_default();
        if !body.is_empty() {
            let _ = write!(
                text,
                "content-type: application/json\r\ncontent-length: {}\r\n",
                body.len()
            );
        }
        text.push_str("\r\n");
        text.push_str(body);
        text
    }
}
