//! `webloop run --live`: the report on a folder that fills, over HTTP, on a thread of its own.
//!
//! It is the page that `webloop report` makes, made when it is asked for, and once for each number of cells that
//! have ended; the browser asks every few seconds whether there is a newer one. The thread gives way to any other
//! that wants the processor, since cells may be measured beside it. When the run has ended, the last page stays.

use std::fs;
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::thread;

use analysis::Campaign;
use anyhow::{Context, anyhow};
use axum::Router;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::get;
use endpoint::host;
use plan::file_name;
use record::Manifest;
use tokio::net::TcpListener;

use crate::command::report;
use crate::exit::Failure;

/// How willingly the thread gives way: as much as it can.
const NICE: i32 = 19;

/// Asks whether there is a newer page, every two seconds; what is not there any more leaves the page as it is.
const SCRIPT: &str = "<script>setInterval(async () => { try { const now = await (await fetch('/ended')).text(); \
                      if (now !== document.documentElement.dataset.ended) location.reload(); } catch {} }, 2000);\
                      </script>";

/// The page that was made last, and of how many cells.
type Made = Arc<Mutex<Option<(usize, String)>>>;

/// Serves the report on a folder until this process ends; returns the address.
///
/// # Errors
/// If the address is not one of this machine alone, or cannot be had.
pub(crate) fn serve(address: SocketAddr, folder: &Path) -> Result<SocketAddr, Failure> {
    if !address.ip().is_loopback() {
        return Err(Failure::usage(anyhow!(
            "--live {address} would show the results to others; give an address of this machine alone, such as \
             127.0.0.1:8000"
        )));
    }
    let listener = std::net::TcpListener::bind(address)
        .with_context(|| format!("cannot serve the report at {address}"))
        .map_err(Failure::usage)?;
    listener.set_nonblocking(true)?;
    let bound = listener.local_addr()?;
    let folder = folder.to_owned();
    thread::Builder::new()
        .name("live".to_owned())
        .spawn(move || {
            // Refused, it is as willing as any other thread.
            let _ = rustix::process::nice(NICE);
            if let Err(error) = answer(listener, folder) {
                say!("webloop: the live report ended: {error}");
            }
        })?;
    Ok(bound)
}

/// Answers requests, one at a time.
fn answer(listener: std::net::TcpListener, folder: PathBuf) -> std::io::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_io()
        .build()?;
    runtime.block_on(async {
        let state = (folder, Made::default());
        let routes = Router::new()
            .route("/", get(page))
            .route(
                "/ended",
                get(|State((folder, _)): State<(PathBuf, Made)>| async move {
                    ended(&folder).to_string()
                }),
            )
            .layer(from_fn(refuse_foreign))
            .with_state(state);
        axum::serve(TcpListener::from_std(listener)?, routes).await
    })
}

/// Answers only to this machine's own names, and to no page but its own.
async fn refuse_foreign(request: Request, next: Next) -> Response {
    let head = request.headers();
    if !is_local(head) || request.uri().authority().is_some() {
        let words = "this page is for 127.0.0.1 and localhost alone\n";
        return (StatusCode::MISDIRECTED_REQUEST, words).into_response();
    }
    if !is_own(head) {
        return (StatusCode::FORBIDDEN, "this is for its own page alone\n").into_response();
    }
    next.run(request).await
}

async fn page(State((folder, made)): State<(PathBuf, Made)>) -> Html<String> {
    let now = ended(&folder);
    let mut made = match made.lock() {
        Ok(made) => made,
        // The text is whole or not there, whatever became of the thread that made it.
        Err(poisoned) => poisoned.into_inner(),
    };
    if let Some((of, text)) = made.as_ref()
        && *of == now
    {
        return Html(text.clone());
    }
    let text = match Campaign::read(&folder).map_err(|error| anyhow!(error)) {
        Ok(campaign) => report::of(&campaign, None)
            .map(|report| live(&::report::page::render(&report, &report.draw()), now)),
        Err(error) => Err(error),
    };
    match text {
        Ok(text) => {
            *made = Some((now, text.clone()));
            Html(text)
        }
        // A cell may have ended while its rows were read.
        Err(error) => Html(format!(
            "<!doctype html><title>webloop</title><p>{}</p>{SCRIPT}",
            escaped(&error.to_string())
        )),
    }
}

/// Whether the browser asked for this machine by a name of its own: a name of somebody else's that leads here
/// could read the results.
fn is_local(head: &HeaderMap) -> bool {
    let mut hosts = head.get_all(header::HOST).iter();
    let host = hosts.next().and_then(|host| host.to_str().ok());
    hosts.next().is_none()
        && host.is_some_and(|host| {
            host::name_of(host.as_bytes()).is_ok_and(|name| {
                name.eq_ignore_ascii_case("localhost")
                    || name.parse::<IpAddr>().is_ok_and(|of| of.is_loopback())
            })
        })
}

/// Whether no page of another origin sent the request.
fn is_own(head: &HeaderMap) -> bool {
    let site = |value: &HeaderValue| value == "same-origin" || value == "none";
    head.get_all("sec-fetch-site").iter().all(site) && !head.contains_key(header::ORIGIN)
}

/// A page that looks for a newer one.
fn live(page: &str, ended: usize) -> String {
    page.replacen("<html ", &format!("<html data-ended=\"{ended}\" "), 1)
        .replacen(
            "default-src 'none';",
            "default-src 'none'; connect-src 'self';",
            1,
        )
        .replacen("</body>", &format!("{SCRIPT}</body>"), 1)
}

/// How many cells of a folder have ended.
fn ended(folder: &Path) -> usize {
    let cells = fs::read_dir(folder.join(file_name::CELLS))
        .into_iter()
        .flatten();
    let cells = cells.filter_map(Result::ok);
    cells
        .filter(|cell| cell.path().join(Manifest::FILE).exists())
        .count()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_of_somebody_else_s_gets_no_page() {
        let asked = |host: &'static str| {
            let mut head = HeaderMap::new();
            head.insert(header::HOST, HeaderValue::from_static(host));
            is_local(&head)
        };
        for host in [
            "",
            ":8000",
            "localhost:x",
            "localhost:80:80",
            "localhost.",
            "127.0.0.1.example.org:8000",
            "localhost@example.org:8000",
            "example.org/localhost:8000",
            "0.0.0.0:8000",
            "127.1:8000",
            "[::]:8000",
            "192.168.1.1:8000",
            "[fe80::1]:8000",
        ] {
            assert!(!asked(host), "{host}");
        }
        let mut two = HeaderMap::new();
        two.append(header::HOST, HeaderValue::from_static("localhost:8000"));
        two.append(header::HOST, HeaderValue::from_static("example.org"));
        assert!(!is_local(&two));
        for host in ["127.0.0.1", "localhost", "LOCALHOST", "[::1]"] {
            // A port may be left out, or empty (RFC 3986, 3.2.3).
            for port in ["", ":", ":8000"] {
                let own = HeaderValue::from_str(&format!("{host}{port}")).expect("plain text");
                let head = HeaderMap::from_iter([(header::HOST, own)]);
                assert!(is_local(&head), "{host}{port}");
            }
        }
        assert!(
            !asked("example.org:8000")
                && !asked("10.0.0.1:8000")
                && !asked("localhost.example.org")
        );
        assert!(!is_local(&HeaderMap::new()));
    }

    #[test]
    fn a_page_of_another_origin_gets_nothing() {
        let sent = |name: &'static str, value: &'static str| {
            let mut head = HeaderMap::new();
            head.insert(name, HeaderValue::from_static(value));
            is_own(&head)
        };
        assert!(sent("sec-fetch-site", "same-origin") && sent("sec-fetch-site", "none"));
        for (name, value) in [
            ("sec-fetch-site", "cross-site"),
            ("sec-fetch-site", "same-site"),
            ("sec-fetch-site", ""),
            ("origin", "http://example.org"),
            ("origin", "null"),
            ("origin", "http://localhost:3000"),
        ] {
            assert!(!sent(name, value), "{name}: {value}");
        }
    }

    #[test]
    fn a_live_page_is_the_report_that_looks_for_a_newer_one() {
        let page = "<!DOCTYPE html><html lang=\"en\"><head>default-src 'none'; a</head><body><p></p></body></html>";
        let live = live(page, 7);
        assert!(live.contains("<html data-ended=\"7\" lang"), "{live}");
        assert!(
            live.contains("connect-src 'self';") && live.contains("/ended"),
            "{live}"
        );
    }
}
