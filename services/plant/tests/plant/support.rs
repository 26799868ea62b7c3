//! What the tests share: a plant while a client talks to it, and a client that
//! sends what it likes.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::{SocketAddr, TcpStream},
    path::Path,
    sync::mpsc,
    thread,
    time::{Duration, Instant},
};

use control::{Stepper, preset};
use endpoint::{Model, Observation, PlantSettings, Policy, SampleTime, report};
use plant::{Config, Ready, ServeError, serve_until};
use tokio::sync::oneshot;

pub(crate) fn config(out: &Path) -> Config {
    Config {
        listen: "127.0.0.1:0".parse().expect("an address"),
        hosts: ["plant", "a", "b"].map(str::to_owned).into(),
        settings: PlantSettings {
            scheduling: Policy::Other,
            ..PlantSettings::new(SampleTime::try_new(3_000_000).expect("3 ms"))
        },
        law: None,
        reference: None,
        out: out.to_owned(),
        again: false,
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
    with_config(config(out), client)
}

/// Runs a plant of this configuration while `client` does; its report.
pub(crate) fn with_config(
    config: Config,
    client: impl FnOnce(Ready),
) -> Result<report::Plant, ServeError> {
    let model = motor(&config);
    with_model(config, model, client)
}

/// Runs a plant with this model while `client` does; its report.
pub(crate) fn with_model(
    config: Config,
    model: impl Model + Send + 'static,
    client: impl FnOnce(Ready),
) -> Result<report::Plant, ServeError> {
    let (ready, is_ready) = mpsc::channel();
    let (stop, stopped) = oneshot::channel();
    let plant = thread::spawn(move || {
        serve_until(&config, model, dropped(stopped), |facts| {
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

/// Connects from 127.0.0.`host`.
pub(crate) fn connect_from(host: u8, address: SocketAddr) -> TcpStream {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .expect("a runtime");
    let stream = runtime.block_on(async {
        let socket = tokio::net::TcpSocket::new_v4()?;
        socket.bind(SocketAddr::from(([127, 0, 0, host], 0)))?;
        socket.connect(address).await?.into_std()
    });
    let stream = stream.expect("the plant listens");
    stream.set_nonblocking(false).expect("a socket");
    stream
}

/// One connection for many requests.
pub(crate) struct Line {
    stream: BufReader<TcpStream>,
    address: SocketAddr,
}

impl Line {
    pub(crate) fn open(address: SocketAddr) -> Self {
        Self::over(
            address,
            TcpStream::connect(address).expect("the plant listens"),
        )
    }

    /// From 127.0.0.`host`, which is another address of this machine.
    pub(crate) fn open_from(host: u8, address: SocketAddr) -> Self {
        Self::over(address, connect_from(host, address))
    }

    fn over(address: SocketAddr, stream: TcpStream) -> Self {
        stream.set_nodelay(true).expect("a socket");
        let timeout = stream.set_read_timeout(Some(PATIENCE));
        timeout.expect("a valid timeout");
        Self {
            stream: BufReader::new(stream),
            address,
        }
    }

    /// Looks at the plant until `is`, without a pause.
    pub(crate) fn wait_for(&mut self, what: &str, is: impl Fn(&Observation) -> bool) {
        let start = Instant::now();
        while !is(&self.get("/state", "").1.parse().expect("a state")) {
            assert!(start.elapsed() < PATIENCE, "{what}");
            thread::sleep(Duration::from_micros(200));
        }
    }

    /// Gets `target`, with a token unless it is empty; the status and the body.
    pub(crate) fn get(&mut self, target: &str, token: &str) -> (u16, String) {
        self.request(&format!("GET {target}"), token)
    }

    /// The same with another method, and no body.
    pub(crate) fn request(&mut self, request: &str, token: &str) -> (u16, String) {
        let session = match token {
            "" => String::new(),
            token => format!("Webloop-Session: {token}\r\n"),
        };
        let request = format!(
            "{request} HTTP/1.1\r\nHost: {}\r\n{session}\r\n",
            self.address
        );
        let stream = self.stream.get_mut();
        let sent = stream.write_all(request.as_bytes());
        sent.expect("the plant reads");
        let (mut status, mut length) = (None, 0);
        loop {
            let mut line = String::new();
            self.stream.read_line(&mut line).expect("an answer");
            let line = line.trim_end().to_ascii_lowercase();
            match status {
                None => status = Some(line[9..12].parse().expect("a status")),
                Some(_) if line.is_empty() => break,
                Some(_) => {}
            }
            if let Some(count) = line.strip_prefix("content-length: ") {
                length = count.parse().expect("a length");
            }
        }
        let mut body = vec![0; length];
        self.stream.read_exact(&mut body).expect("the whole body");
        let body = String::from_utf8(body).expect("answers are text");
        (status.expect("a status line"), body)
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
