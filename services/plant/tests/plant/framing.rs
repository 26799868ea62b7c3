//! The framing of requests, as strictly as RFC 9110 and 9112 ask: each case is bytes on a socket of its own and
//! what must come of them. The cases are those of the public list of h1spec, and more of their kind.

use std::{
    io::{Read, Write},
    net::{SocketAddr, TcpStream},
    thread,
};

use plant::Ready;

use crate::support::{PATIENCE, config, observe, with_config};

/// What must come of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Want {
    /// An answer with this status, and the connection stays.
    Kept(u16),
    /// An answer with this status, and the connection is closed.
    Closed(u16),
}
use Want::{Closed, Kept};

const GET: &str = "GET /state HTTP/1.1\r\nHost: plant\r\n\r\n";

/// A GET with these lines after its `Host`.
fn with(lines: &str) -> Vec<u8> {
    format!("GET /state HTTP/1.1\r\nHost: plant\r\n{lines}\r\n").into_bytes()
}

/// A claim with these lines and this body.
fn claim(lines: &str, body: &str) -> Vec<u8> {
    format!(
        "POST /session HTTP/1.1\r\nHost: plant\r\nContent-Type: application/json\r\n{lines}\r\n{body}"
    )
    .into_bytes()
}

/// A claim whose body is not JSON: 400 in words of its own, so that a test sees that the body was read.
const ODD: &str = "odd";

fn cases() -> Vec<(&'static str, Vec<u8>, Want)> {
    let text = |text: &str| text.as_bytes().to_vec();
    vec![
        // What is valid.
        ("a GET", text(GET), Kept(200)),
        (
            "names in any case, and space around values",
            text("GET /state HTTP/1.1\r\nhOsT:\t plant \t\r\nX:\r\n\r\n"),
            Kept(200),
        ),
        (
            "an empty line before",
            text(&format!("\r\n{GET}")),
            Kept(200),
        ),
        ("a value beyond ASCII", with("X: \u{e4}\r\n"), Kept(200)),
        ("a length of zero", with("Content-Length: 0\r\n"), Kept(200)),
        (
            "the last request",
            with("Connection: close\r\n"),
            Closed(200),
        ),
        (
            "the last of several words",
            with("Connection: x, Close\r\n"),
            Closed(200),
        ),
        (
            "HTTP/1.0 without a host",
            text("GET /state HTTP/1.0\r\n\r\n"),
            Closed(200),
        ),
        (
            "HTTP/1.0 that stays",
            text("GET /state HTTP/1.0\r\nConnection: keep-alive\r\n\r\n"),
            Kept(200),
        ),
        (
            "an address as host",
            text("GET /state HTTP/1.1\r\nHost: 127.0.0.1:80\r\n\r\n"),
            Kept(200),
        ),
        (
            "an address of version 6",
            text("GET /state HTTP/1.1\r\nHost: [::1]:80\r\n\r\n"),
            Kept(200),
        ),
        (
            "a body of some length",
            claim("Content-Length: 3\r\n", ODD),
            Kept(400),
        ),
        (
            "a body in chunks",
            claim(
                "Transfer-Encoding: chunked\r\n",
                "1\r\no\r\n2\r\ndd\r\n0\r\n\r\n",
            ),
            Kept(400),
        ),
        (
            "a coding in any case",
            claim("Transfer-Encoding: CHUNKED\r\n", "3\r\nodd\r\n0\r\n\r\n"),
            Kept(400),
        ),
        (
            "extensions and a trailer",
            claim(
                "Transfer-Encoding: chunked\r\n",
                "3;a=b\r\nodd\r\n0\r\nX: y\r\n\r\n",
            ),
            Kept(400),
        ),
        (
            "a word before the body",
            claim("Content-Length: 3\r\nExpect: 100-continue\r\n", ODD),
            Kept(400),
        ),
        // The host.
        ("no host", text("GET /state HTTP/1.1\r\n\r\n"), Closed(400)),
        (
            "two hosts",
            text("GET /state HTTP/1.1\r\nHost: plant\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "two hosts that differ",
            text("GET /state HTTP/1.1\r\nHost: plant\r\nHost: a\r\n\r\n"),
            Closed(400),
        ),
        (
            "an empty host",
            text("GET /state HTTP/1.1\r\nHost:\r\n\r\n"),
            Closed(400),
        ),
        (
            "a host with a path",
            text("GET /state HTTP/1.1\r\nHost: plant/x\r\n\r\n"),
            Closed(400),
        ),
        (
            "a host with a user",
            text("GET /state HTTP/1.1\r\nHost: me@plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "a host with two ports",
            text("GET /state HTTP/1.1\r\nHost: plant:1:2\r\n\r\n"),
            Closed(400),
        ),
        (
            "a host with a port that is none",
            text("GET /state HTTP/1.1\r\nHost: plant:x\r\n\r\n"),
            Closed(400),
        ),
        (
            "a list of hosts",
            text("GET /state HTTP/1.1\r\nHost: plant, a\r\n\r\n"),
            Closed(400),
        ),
        (
            "a foreign host",
            text("GET /state HTTP/1.1\r\nHost: example.org\r\n\r\n"),
            Closed(421),
        ),
        // The host's port may be empty (RFC 3986, 3.2.3).
        (
            "an empty port",
            text("GET /state HTTP/1.1\r\nHost: 127.0.0.1:\r\n\r\n"),
            Kept(200),
        ),
        (
            "an empty port of version 6",
            text("GET /state HTTP/1.1\r\nHost: [::1]:\r\n\r\n"),
            Kept(200),
        ),
        (
            "a name in other letters, with an empty port",
            text("GET /state HTTP/1.1\r\nHost: PLANT:\r\n\r\n"),
            Kept(200),
        ),
        // An absolute target is a request to the host that it names (RFC 9112, 3.2.2).
        (
            "an absolute target",
            text("GET http://plant/state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Kept(200),
        ),
        (
            "an absolute target with a port, in other letters",
            text("GET HTTP://Plant:80/state HTTP/1.1\r\nHost: plant:80\r\n\r\n"),
            Kept(200),
        ),
        (
            "an absolute target of version 6",
            text("GET http://[::1]:8080/state HTTP/1.1\r\nHost: [::1]:8080\r\n\r\n"),
            Kept(200),
        ),
        (
            "an absolute target without a path, which is the page",
            text("GET http://plant HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Kept(200),
        ),
        (
            "an absolute target beside another host, which does not count",
            text("GET http://plant/state HTTP/1.1\r\nHost: example.org\r\n\r\n"),
            Kept(200),
        ),
        (
            "an absolute target with a query",
            text("GET http://plant/closed?u=x HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Kept(400),
        ),
        (
            "an absolute target without a host (RFC 9112, 3.2)",
            text("GET http://plant/state HTTP/1.1\r\n\r\n"),
            Closed(400),
        ),
        (
            "an absolute target with two hosts",
            text("GET http://plant/state HTTP/1.1\r\nHost: plant\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "an absolute target beside what is no host",
            text("GET http://plant/state HTTP/1.1\r\nHost: pl/ant\r\n\r\n"),
            Closed(400),
        ),
        (
            "an absolute target over TLS",
            text("GET https://plant/state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "an absolute target with a user",
            text("GET http://me@plant/state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "an absolute target without a host in it",
            text("GET http:///state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        // No chunks are no body (RFC 9112, 7.1).
        (
            "a GET with no chunks",
            text(
                "GET /state HTTP/1.1\r\nHost: plant\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
            ),
            Kept(200),
        ),
        (
            "a GET with no chunks, an extension and a trailer",
            text(
                "GET /state HTTP/1.1\r\nHost: plant\r\nTransfer-Encoding: chunked\r\n\r\n00;a=b\r\nX: y\r\n\r\n",
            ),
            Kept(200),
        ),
        (
            "a GET with a chunk",
            text(
                "GET /state HTTP/1.1\r\nHost: plant\r\nTransfer-Encoding: chunked\r\n\r\n1\r\nu\r\n0\r\n\r\n",
            ),
            Closed(413),
        ),
        (
            "a GET with chunks that are none",
            text(
                "GET /state HTTP/1.1\r\nHost: plant\r\nTransfer-Encoding: chunked\r\n\r\nx\r\n\r\n",
            ),
            Closed(413),
        ),
        (
            "a GET with no chunks in HTTP/1.0 (RFC 9112, 6.1)",
            text("GET /state HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
            Closed(400),
        ),
        // What is not there is 404 for every method (RFC 9110, 15.5.5), and what is has an Allow (15.5.6).
        (
            "a POST to nowhere",
            text("POST /nowhere HTTP/1.1\r\nHost: plant\r\nContent-Length: 0\r\n\r\n"),
            Kept(404),
        ),
        (
            "a POST to nowhere with a body",
            text("POST /nowhere HTTP/1.1\r\nHost: plant\r\nContent-Length: 3\r\n\r\nodd"),
            Closed(404),
        ),
        (
            "a POST to nowhere with a body that waits",
            text(
                "POST /nowhere HTTP/1.1\r\nHost: plant\r\nContent-Length: 3\r\nExpect: 100-continue\r\n\r\n",
            ),
            Closed(404),
        ),
        (
            "a path with a slash too many",
            text("GET /state/ HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Kept(404),
        ),
        (
            "a POST to the page",
            text("POST / HTTP/1.1\r\nHost: plant\r\nContent-Length: 0\r\n\r\n"),
            Kept(405),
        ),
        (
            "a PUT to what is read",
            text("PUT /health HTTP/1.1\r\nHost: plant\r\nContent-Length: 2\r\n\r\n{}"),
            Closed(405),
        ),
        // HTTP/1.0 without a host may look and not command, since nobody can tell for whom it is.
        (
            "a command of HTTP/1.0 without a host",
            text("GET /closed?u=1 HTTP/1.0\r\n\r\n"),
            Closed(400),
        ),
        (
            "the same that stays",
            text("GET /closed?u=1 HTTP/1.0\r\nConnection: keep-alive\r\n\r\n"),
            Closed(400),
        ),
        (
            "a reset of HTTP/1.0 without a host",
            text("POST /reset HTTP/1.0\r\nContent-Length: 0\r\n\r\n"),
            Closed(400),
        ),
        (
            "HTTP/1.0 that stays, in other letters",
            text("GET /state HTTP/1.0\r\nHost: plant\r\nConnection: Keep-Alive\r\n\r\n"),
            Kept(200),
        ),
        (
            "HTTP/1.0 that does not know what it wants (RFC 9112, 9.3)",
            text("GET /state HTTP/1.0\r\nHost: plant\r\nConnection: keep-alive, close\r\n\r\n"),
            Closed(200),
        ),
        (
            "a WebSocket of HTTP/1.0 (RFC 9110, 7.8)",
            text(
                "GET /socket?mode=open HTTP/1.0\r\nHost: plant\r\nConnection: upgrade, keep-alive\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
            ),
            Kept(426),
        ),
        (
            "no WebSocket at all (RFC 9110, 15.5.22)",
            text("GET /socket?mode=open HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Kept(426),
        ),
        (
            "a GET that waits for a word and has no body (RFC 9110, 10.1.1)",
            text("GET /state HTTP/1.1\r\nHost: plant\r\nExpect: 100-continue\r\n\r\n"),
            Kept(200),
        ),
        (
            "a query where none is read",
            text("GET /state?u=1 HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Kept(400),
        ),
        (
            "an empty query",
            text("GET /state? HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Kept(200),
        ),
        // The first line.
        (
            "no version",
            text("GET /state\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "version 9.9",
            text("GET /state HTTP/9.9\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "version 2.0",
            text("GET /state HTTP/2.0\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "the preface of HTTP/2",
            text("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"),
            Closed(400),
        ),
        (
            "a version in small letters",
            text("GET /state http/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "a line before",
            text("Extra\r\nGET /state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "two empty lines before",
            text(&format!("\r\n\r\n{GET}")),
            Closed(400),
        ),
        ("a space before", text(&format!(" {GET}")), Closed(400)),
        (
            "two spaces",
            text("GET  /state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "two spaces after the path",
            text("GET /state  HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "a space after the version",
            text("GET /state HTTP/1.1 \r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "tabs in place of spaces",
            text("GET\t/state\tHTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "no path",
            text("GET HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "a path without a slash",
            text("GET state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "a path with a fragment",
            text("GET /state#a HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "a path beyond ASCII",
            text("GET /st\u{e4}te HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "a path with NUL",
            text("GET /state\0 HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "a foreign address as path",
            text("GET http://example.org/state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "a foreign address as both",
            text("GET http://example.org/state HTTP/1.1\r\nHost: example.org\r\n\r\n"),
            Closed(400),
        ),
        (
            "a tunnel",
            text("CONNECT plant:80 HTTP/1.1\r\nHost: plant:80\r\n\r\n"),
            Closed(400),
        ),
        (
            "a star",
            text("OPTIONS * HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Kept(404),
        ),
        (
            "a method with brackets",
            text("G[T /state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        (
            "a method in small letters",
            text("get /state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Kept(405),
        ),
        (
            "a method of nobody's",
            text("BREW /state HTTP/1.1\r\nHost: plant\r\n\r\n"),
            Kept(405),
        ),
        // Lines.
        (
            "LF alone",
            text("GET /state HTTP/1.1\nHost: plant\n\n"),
            Closed(400),
        ),
        (
            "LF alone at the end",
            text("GET /state HTTP/1.1\r\nHost: plant\r\n\n"),
            Closed(400),
        ),
        (
            "LF alone after a header",
            text("GET /state HTTP/1.1\r\nHost: plant\nX: y\r\n\r\n"),
            Closed(400),
        ),
        (
            "CR alone",
            text("GET /state HTTP/1.1\rHost: plant\r\r"),
            Closed(400),
        ),
        (
            "two CR",
            text("GET /state HTTP/1.1\r\r\nHost: plant\r\n\r\n"),
            Closed(400),
        ),
        ("CR in a value", with("X: a\rb\r\n"), Closed(400)),
        ("NUL in a value", with("X: a\0b\r\n"), Closed(400)),
        ("a bell in a value", with("X: a\x07b\r\n"), Closed(400)),
        (
            "an escape in a value",
            with("X: a\x1b[31mb\r\n"),
            Closed(400),
        ),
        ("DEL in a value", with("X: a\x7fb\r\n"), Closed(400)),
        ("a folded value", with("X: a\r\n b\r\n"), Closed(400)),
        (
            "a folded value with a tab",
            with("X: a\r\n\tb\r\n"),
            Closed(400),
        ),
        (
            "a folded first line",
            text("GET /state HTTP/1.1\r\n Host: plant\r\n\r\n"),
            Closed(400),
        ),
        ("no colon", with("X\r\n"), Closed(400)),
        ("no name", with(": x\r\n"), Closed(400)),
        ("a space before the colon", with("X : y\r\n"), Closed(400)),
        ("a space in a name", with("X Y: z\r\n"), Closed(400)),
        ("brackets in a name", with("X[]: y\r\n"), Closed(400)),
        ("NUL in a name", with("X\0Y: z\r\n"), Closed(400)),
        ("a name beyond ASCII", with("\u{dc}: y\r\n"), Closed(400)),
        (
            "a space before the colon of a length",
            claim("Content-Length : 3\r\n", ODD),
            Closed(400),
        ),
        // Lengths and codings.
        (
            "a length below zero",
            claim("Content-Length: -1\r\n", ""),
            Closed(400),
        ),
        (
            "a length far below zero",
            claim("Content-Length: -123456789123456789123456789\r\n", ""),
            Closed(400),
        ),
        (
            "a length with a plus",
            claim("Content-Length: +3\r\n", ODD),
            Closed(400),
        ),
        (
            "a length that is a word",
            claim("Content-Length: abc\r\n", ""),
            Closed(400),
        ),
        (
            "a length in hex",
            claim("Content-Length: 0x3\r\n", ODD),
            Closed(400),
        ),
        (
            "a length with a fraction",
            claim("Content-Length: 3.0\r\n", ODD),
            Closed(400),
        ),
        (
            "an empty length",
            claim("Content-Length:\r\n", ""),
            Closed(400),
        ),
        (
            "a length beyond 64 bits",
            claim("Content-Length: 18446744073709551616\r\n", ""),
            Closed(400),
        ),
        (
            "a length of 2^64 - 1",
            claim("Content-Length: 18446744073709551615\r\n", ""),
            Closed(413),
        ),
        (
            "two lengths",
            claim("Content-Length: 3\r\nContent-Length: 4\r\n", ODD),
            Closed(400),
        ),
        (
            "two lengths that agree",
            claim("Content-Length: 3\r\nContent-Length: 3\r\n", ODD),
            Closed(400),
        ),
        (
            "a list of lengths",
            claim("Content-Length: 3, 3\r\n", ODD),
            Closed(400),
        ),
        (
            "a coding and a length",
            claim(
                "Transfer-Encoding: chunked\r\nContent-Length: 3\r\n",
                "0\r\n\r\n",
            ),
            Closed(400),
        ),
        (
            "a length and a coding",
            claim(
                "Content-Length: 3\r\nTransfer-Encoding: chunked\r\n",
                "0\r\n\r\n",
            ),
            Closed(400),
        ),
        (
            "a doubled coding",
            claim("Transfer-Encoding: chunked, chunked\r\n", "0\r\n\r\n"),
            Closed(400),
        ),
        (
            "two codings",
            claim(
                "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
                "0\r\n\r\n",
            ),
            Closed(400),
        ),
        (
            "an unknown coding",
            claim("Transfer-Encoding: gzip\r\n", ""),
            Closed(400),
        ),
        (
            "an unknown coding before",
            claim("Transfer-Encoding: gzip, chunked\r\n", "0\r\n\r\n"),
            Closed(400),
        ),
        (
            "identity",
            claim("Transfer-Encoding: identity\r\n", ""),
            Closed(400),
        ),
        (
            "a coding with a tab",
            claim("Transfer-Encoding: \x0bchunked\r\n", "0\r\n\r\n"),
            Closed(400),
        ),
        (
            "a coding in HTTP/1.0",
            text("POST /session HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
            Closed(400),
        ),
        (
            "a chunk with a size that is none",
            claim("Transfer-Encoding: chunked\r\n", "x\r\nodd\r\n0\r\n\r\n"),
            Closed(400),
        ),
        (
            "a chunk below zero",
            claim("Transfer-Encoding: chunked\r\n", "-3\r\nodd\r\n0\r\n\r\n"),
            Closed(400),
        ),
        (
            "a chunk in 0x",
            claim("Transfer-Encoding: chunked\r\n", "0x3\r\nodd\r\n0\r\n\r\n"),
            Closed(400),
        ),
        (
            "a chunk with space",
            claim("Transfer-Encoding: chunked\r\n", "3 \r\nodd\r\n0\r\n\r\n"),
            Closed(400),
        ),
        (
            "a chunk beyond 64 bits",
            claim(
                "Transfer-Encoding: chunked\r\n",
                "10000000000000003\r\nodd\r\n0\r\n\r\n",
            ),
            Closed(400),
        ),
        (
            "a chunk that is longer than it says",
            claim("Transfer-Encoding: chunked\r\n", "2\r\nodd\r\n0\r\n\r\n"),
            Closed(400),
        ),
        (
            "a chunk with LF alone",
            claim("Transfer-Encoding: chunked\r\n", "3\nodd\r\n0\r\n\r\n"),
            Closed(400),
        ),
        (
            "LF alone after a chunk",
            claim("Transfer-Encoding: chunked\r\n", "3\r\nodd\n0\r\n\r\n"),
            Closed(400),
        ),
        (
            "a long extension",
            claim(
                "Transfer-Encoding: chunked\r\n",
                &format!("3;{}\r\nodd\r\n0\r\n\r\n", "x".repeat(300)),
            ),
            Closed(400),
        ),
        (
            "a chunk beyond the limit",
            claim("Transfer-Encoding: chunked\r\n", "401\r\n"),
            Closed(413),
        ),
        // Bodies where there is none.
        (
            "a GET with a body",
            with("Content-Length: 3\r\n"),
            Closed(413),
        ),
        (
            "a GET with chunks",
            with("Transfer-Encoding: chunked\r\n"),
            Closed(413),
        ),
        // Sizes.
        (
            "a long path",
            text(&format!(
                "GET /{} HTTP/1.1\r\nHost: plant\r\n\r\n",
                "a".repeat(2_000)
            )),
            Kept(414),
        ),
        (
            "a path without an end",
            text(&format!("GET /{}", "a".repeat(20_000))),
            Closed(431),
        ),
        (
            "a long value",
            with(&format!("X: {}\r\n", "x".repeat(20_000))),
            Closed(431),
        ),
        (
            "a long name",
            with(&format!("{}: x\r\n", "x".repeat(20_000))),
            Closed(431),
        ),
        ("many lines", with(&"X: y\r\n".repeat(101)), Closed(431)),
        (
            "a long claim",
            claim("Content-Length: 1025\r\n", ""),
            Closed(413),
        ),
        // No HTTP at all.
        (
            "a greeting of TLS",
            b"\x16\x03\x01\x00\xa5\x01\x00\x00\xa1\x03\x03".to_vec(),
            Closed(400),
        ),
        (
            "random bytes",
            b"\x00\xff\xfe\x80\x0d\x0a\x0d\x0a".to_vec(),
            Closed(400),
        ),
    ]
}

/// Sends bytes in pieces, and reads what comes of them: the status, and whether the connection stays.
fn meet(address: SocketAddr, bytes: &[u8], piece: usize) -> Option<Want> {
    let mut stream = TcpStream::connect(address).expect("the plant listens");
    stream.set_nodelay(true).expect("a socket");
    stream
        .set_read_timeout(Some(PATIENCE))
        .expect("a valid timeout");
    for piece in bytes.chunks(piece) {
        // It may have answered and closed already.
        if stream.write_all(piece).is_err() {
            break;
        }
    }
    let mut answer = Vec::new();
    let mut buffer = [0; 4096];
    let is_whole = |answer: &[u8]| {
        let text = String::from_utf8_lossy(answer);
        let text = text.trim_start_matches("HTTP/1.1 100 Continue\r\n\r\n");
        text.split_once("\r\n\r\n").is_some_and(|(head, body)| {
            let length = head
                .lines()
                .find_map(|line| line.strip_prefix("content-length: "));
            length.is_some_and(|length| length.parse() == Ok(body.len()))
        })
    };
    while !is_whole(&answer) {
        match stream.read(&mut buffer) {
            Ok(read @ 1..) => answer.extend_from_slice(&buffer[..read]),
            _ => break,
        }
    }
    let text = String::from_utf8_lossy(&answer);
    let text = text.trim_start_matches("HTTP/1.1 100 Continue\r\n\r\n");
    let status = text.get(9..12)?.parse().ok()?;
    // A connection that stays answers the next request.
    let stays = stream.write_all(GET.as_bytes()).is_ok()
        && matches!(stream.read(&mut buffer), Ok(read @ 1..) if buffer[..read].starts_with(b"HTTP/1.1 200"));
    Some(if stays { Kept(status) } else { Closed(status) })
}

#[test]
fn every_request_is_framed_as_the_standard_says_and_none_that_is_not_moves_the_plant() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let cases = cases();
    assert!(cases.len() >= 100, "{}", cases.len());
    with_config(config(folder.path()), |Ready { address, .. }| {
        let wrong: Vec<_> = cases
            .iter()
            .filter_map(|(name, bytes, want)| {
                let got = meet(address, bytes, usize::MAX);
                (got != Some(*want)).then(|| format!("{name}: {got:?} in place of {want:?}"))
            })
            .collect();
        assert!(wrong.is_empty(), "{wrong:#?}");
        assert_eq!(observe(address).u, 0.0);
    })
    .expect("a run without errors");
    let count = cases.len();
    println!("row 11: {count} of {count} cases, those of h1spec among them");
}

/// In pieces of one byte, and of some, for what is not long.
#[test]
fn it_does_not_matter_in_which_pieces_a_request_arrives() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    with_config(config(folder.path()), |Ready { address, .. }| {
        let short = cases()
            .into_iter()
            .filter(|(_, bytes, _)| bytes.len() < 500);
        thread::scope(|scope| {
            for (name, bytes, want) in short {
                scope.spawn(move || {
                    for piece in [1, 7] {
                        let got = meet(address, &bytes, piece);
                        assert_eq!(got, Some(want), "{name} in pieces of {piece}");
                    }
                });
            }
        });
        assert_eq!(observe(address).u, 0.0);
    })
    .expect("a run without errors");
}
