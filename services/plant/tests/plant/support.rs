//! What the tests share: a plant while a client talks to it, and a client that
//! sends what it likes.

use std::{
    io::{Read, Write},
    net::{SocketAddr, TcpStream},
    path::Path,
    sync::mpsc,
    thread,
    time::{Duration, Instant},
};

use control::{Stepper, preset};
use endpoint::{Hold, Late, Observation, PlantSettings, SampleTime, report};
use plant::{Config, Ready, ServeError, serve_until};
use tokio::sync::oneshot;

pub(crate) fn config(out: &Path) -> Config {
    Config {
        listen: "127.0.0.1:0".parse().expect("an address"),
        settings: PlantSettings {
            h: SampleTime::try_new(3_000_000).expect("3 ms"),
            late: Late::Apply,
            hold: Hold::Last,
            tick_noise: None,
        },
        law: None,
        reference: None,
        out: out.to_owned(),
        fifo: false,
    }
}

/// The paper's motor at the h of a plant's settings.
pub(crate) fn motor(config: &Config) -> Stepper {
    let sampled = preset::paper_plant().sampled(config.settings.h.ns());
    sampled.expect("it can be sampled").stepper()
}

/// Done when its other half is dropped, also by a test that fails.
async fn dropped(stop: oneshot::Receiver<()>) -> std::io::Result<()> {
    let _ = stop.await;
    Ok(())
}

/// Runs a plant while `client` does; its report.
pub(crate) fn with_plant(
    out: &Path,
    client: impl FnOnce(Ready),
) -> Result<report::Plant, ServeError> {
    let config = config(out);
    let (ready, is_ready) = mpsc::channel();
    let (stop, stopped) = oneshot::channel();
    let plant = thread::spawn(move || {
        serve_until(&config, motor(&config), dropped(stopped), |facts| {
            ready.send(facts).expect("the test waits");
        })
    });
    client(
        is_ready
            .recv_timeout(Duration::from_secs(10))
            .expect("the plant starts"),
    );
    drop(stop);
    plant.join().expect("no panic")
}

/// How long a request may take on the busiest machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(30);

/// Sends bytes and gives all that comes back until the plant closes or is
/// silent for a while.
pub(crate) fn exchange(address: SocketAddr, request: &str) -> String {
    exchange_within(address, request, Duration::from_millis(300))
}

fn exchange_within(address: SocketAddr, request: &str, silence: Duration) -> String {
    let mut stream = TcpStream::connect(address).expect("the plant listens");
    stream
        .set_read_timeout(Some(silence))
        .expect("a valid timeout");
    stream
        .write_all(request.as_bytes())
        .expect("the plant reads");
    let mut bytes = Vec::new();
    let mut buffer = [0; 4096];
    while let Ok(read @ 1..) = stream.read(&mut buffer) {
        bytes.extend_from_slice(&buffer[..read]);
    }
    String::from_utf8(bytes).expect("answers are text")
}

pub(crate) fn get(address: SocketAddr, target: &str, accept: &str) -> (String, String) {
    let request = format!(
        "GET {target} HTTP/1.1\r\nHost: plant\r\nAccept: {accept}\r\nConnection: close\r\n\r\n"
    );
    let response = exchange_within(address, &request, PATIENCE);
    let (head, body) = response.split_once("\r\n\r\n").expect("a whole response");
    (head.to_ascii_lowercase(), body.to_owned())
}

pub(crate) fn observe(address: SocketAddr) -> Observation {
    get(address, "/state", "*/*")
        .1
        .parse()
        .expect("an observation")
}

pub(crate) fn rows<R: serde::de::DeserializeOwned>(path: &Path) -> Vec<R> {
    let mut reader = csv::Reader::from_path(path).expect("the file");
    reader
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("rows")
}

/// A response, taken apart.
#[derive(Debug)]
pub(crate) struct Response {
    pub(crate) status: u16,
    pub(crate) head: String,
    pub(crate) body: String,
}

/// Sends one request with these header lines and this body.
pub(crate) fn send(
    address: SocketAddr,
    request: &str,
    headers: &[(&str, &str)],
    body: &str,
) -> Response {
    let mut text = format!("{request} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n");
    for (name, value) in headers {
        text += &format!("{name}: {value}\r\n");
    }
    if request.starts_with("POST") {
        text += &format!("Content-Length: {}\r\n", body.len());
    }
    let response = exchange_within(address, &format!("{text}\r\n{body}"), PATIENCE);
    let (head, body) = response.split_once("\r\n\r\n").expect("a whole response");
    Response {
        status: head[9..12].parse().expect("a status"),
        head: head.to_ascii_lowercase(),
        body: body.to_owned(),
    }
}

/// Claims the plant; what it says.
pub(crate) fn claim(address: SocketAddr, client: &str) -> Response {
    let body = serde_json::json!({ "client": client }).to_string();
    send(
        address,
        "POST /session",
        &[("Content-Type", "application/json")],
        &body,
    )
}

/// The token of a session that begins now.
pub(crate) fn begin(address: SocketAddr, client: &str) -> String {
    let response = claim(address, client);
    assert_eq!(response.status, 200, "{response:?}");
    let grant: serde_json::Value = serde_json::from_str(&response.body).expect("JSON");
    grant["session"].as_str().expect("a token").to_owned()
}

/// Sends a chunk of rows.
pub(crate) fn post_rows(address: SocketAddr, token: &str, chunk: u64, text: &str) -> Response {
    let headers = [("Webloop-Session", token), ("Content-Type", "text/csv")];
    send(
        address,
        &format!("POST /session/rows?chunk={chunk}"),
        &headers,
        text,
    )
}

/// Sends the report, which ends the session.
pub(crate) fn end(address: SocketAddr, token: &str, report: &str) -> Response {
    let headers = [
        ("Webloop-Session", token),
        ("Content-Type", "application/json"),
    ];
    send(address, "POST /session/end", &headers, report)
}

/// What `GET /session` says.
pub(crate) fn status(address: SocketAddr) -> serde_json::Value {
    serde_json::from_str(&get(address, "/session", "*/*").1).expect("JSON")
}

/// Asks until it is so, for as long as a busy machine may need.
pub(crate) fn until(what: &str, mut is: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is() {
        assert!(start.elapsed() < PATIENCE, "{what}");
        thread::sleep(Duration::from_millis(20));
    }
}
